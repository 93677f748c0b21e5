//! Triangle meshes whose edits fade, as [`crate::fading`] has it for tiles. See [`relievo_tiles::triangle::decay`].

use relievo_core::{Context, Error, Result};
use relievo_tiles::triangle::{TriangleDecay, TriangleField};
use relievo_tiles::{ByFormat, DecayOptions, Rgba8, Rgba16};

use super::object::TriangleObject;
use crate::layers::Stack;

/// The colours of a triangle mesh at one moment.
type Colors = ByFormat<TriangleField<Rgba8>, TriangleField<Rgba16>>;

/// The stamps of a triangle mesh.
#[derive(Debug)]
pub struct TriangleFading {
    /// Those of its displacement.
    pub displacement: TriangleDecay<half::f16>,
    /// Those of its colours, if it has colours.
    pub paint: Option<ByFormat<TriangleDecay<Rgba8>, TriangleDecay<Rgba16>>>,
    /// What has been stamped.
    stamped: (TriangleField, Option<Colors>),
}

impl TriangleObject {
    /// Makes edits from now on fade; what was edited before stays, and so do colours that the object is given later.
    /// Stamps of displacement and of colours may occupy `budget` bytes each, and the edited values as many.
    ///
    /// Fails if the times are none, the budget does not hold the vertices, or there are layers.
    pub fn set_decay(&mut self, options: DecayOptions, budget: u64) -> Result<()> {
        let (colors, halves) = (self.layers.colors.as_ref(), self.layers.half_colors.as_ref());
        let plain = colors.is_none_or(Stack::is_plain) && halves.is_none_or(Stack::is_plain);
        if !(plain && self.layers.displacement.is_plain()) {
            return Err(
                Error::unsupported("edits that fade are on one layer").advise("leave out the layers or the decay")
            );
        }
        let displacement = TriangleDecay::new(&self.displacement, options, budget)?;
        let paint = match (&self.paint, &self.half_paint) {
            (Some(paint), _) => Some(ByFormat::Rgba8(TriangleDecay::new(paint, options, budget)?)),
            (_, Some(paint)) => Some(ByFormat::Rgba16(TriangleDecay::new(paint, options, budget)?)),
            _ => None,
        };
        self.fading = Some(TriangleFading { displacement, paint, stamped: self.fields() });
        Ok(())
    }

    /// The stamps, if edits fade.
    pub fn fading(&self) -> Option<&TriangleFading> {
        self.fading.as_ref()
    }

    /// The stamps, to be written: put back what was read with the channels.
    pub fn fading_mut(&mut self) -> Option<&mut TriangleFading> {
        self.fading.as_mut()
    }

    /// Stamps what was edited since it was last done with the object's time. Returns the faces, ascending, whose stamps
    /// their budget refused; what was edited there stays.
    pub fn stamp(&mut self, context: &Context) -> Result<Vec<u32>> {
        let now = self.fields();
        let Some(fading) = &mut self.fading else { return Ok(Vec::new()) };
        let (displacement, paint) = std::mem::replace(&mut fading.stamped, now);
        let mut refused = fading.displacement.stamp(context, &displacement, &self.displacement, self.time)?;
        refused.extend(match (&paint, &mut fading.paint, &self.paint, &self.half_paint) {
            (Some(ByFormat::Rgba8(before)), Some(ByFormat::Rgba8(stamps)), Some(paint), _) => {
                stamps.stamp(context, before, paint, self.time)?
            }
            (Some(ByFormat::Rgba16(before)), Some(ByFormat::Rgba16(stamps)), _, Some(paint)) => {
                stamps.stamp(context, before, paint, self.time)?
            }
            _ => Vec::new(),
        });
        refused.sort_unstable();
        refused.dedup();
        Ok(refused)
    }

    /// Comes to `time` in seconds: what was edited fades as it should, and edits are made then from now on.
    ///
    /// Fails, as [`Self::set_time`] does, if the time is not finite.
    pub fn advance(&mut self, context: &Context, time: f64) -> Result<()> {
        let _stage = self.fading.is_some().then(|| context.stats().begin("decay"));
        self.stamp(context)?;
        self.set_time(time)?;
        if let Some(mut fading) = self.fading.take() {
            let faded = fading.displacement.fade(context, &mut self.displacement, time);
            let painted = match (&mut fading.paint, &mut self.paint, &mut self.half_paint) {
                (Some(ByFormat::Rgba8(stamps)), Some(paint), _) => stamps.fade(context, paint, time).map(drop),
                (Some(ByFormat::Rgba16(stamps)), _, Some(paint)) => stamps.fade(context, paint, time).map(drop),
                _ => Ok(()),
            };
            self.fading = Some(fading);
            self.touch(&faded?.changed);
            painted?;
        }
        self.take_as_stamped();
        Ok(())
    }

    /// Notes that nothing of what there is now waits for a stamp, as after channels and stamps were put back.
    pub fn take_as_stamped(&mut self) {
        let now = self.fields();
        if let Some(fading) = &mut self.fading {
            fading.stamped = now;
        }
    }

    fn fields(&self) -> (TriangleField, Option<Colors>) {
        let colors = self.colors().map(|colors| match colors {
            ByFormat::Rgba8(field) => ByFormat::Rgba8(field.clone()),
            ByFormat::Rgba16(field) => ByFormat::Rgba16(field.clone()),
        });
        (self.displacement.field().clone(), colors)
    }
}
