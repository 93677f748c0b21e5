//! Objects whose edits fade (Schäfer et al. 2015, Section 7.2): displacement and colours that were edited before the
//! time that the object comes to. See [`relievo_tiles::decay`].

use half::f16;
use relievo_core::{Context, Result};
use relievo_tiles::{Decay, DecayOptions, Field, Rgba8};

use crate::object::DisplacedObject;

/// The stamps of an object.
#[derive(Debug)]
pub struct Fading {
    /// Those of its displacement.
    pub displacement: Decay<f16>,
    /// Those of its colours.
    pub paint: Decay<Rgba8>,
    /// What has been stamped.
    stamped: (Field, Option<Field<Rgba8>>),
}

impl DisplacedObject {
    /// Makes edits from now on fade; what was edited before stays. Stamps of displacement and of colours may occupy
    /// `budget` bytes each. Fails if the times are none.
    pub fn set_decay(&mut self, options: DecayOptions, budget: u64) -> Result<()> {
        let tiles = self.surface.tile_count();
        let (displacement, paint) = (Decay::new(tiles, options, budget)?, Decay::new(tiles, options, budget)?);
        self.fading = Some(Fading { displacement, paint, stamped: self.fields() });
        Ok(())
    }

    /// The stamps, if edits fade.
    pub fn fading(&self) -> Option<&Fading> {
        self.fading.as_ref()
    }

    /// The stamps, to be written: put back what was read with the channels.
    pub fn fading_mut(&mut self) -> Option<&mut Fading> {
        self.fading.as_mut()
    }

    /// Stamps what was edited since it was last done with the object's time. Returns the tiles, ascending, whose stamps
    /// their budget refused; what was edited there stays.
    pub fn stamp(&mut self, context: &Context) -> Vec<u32> {
        let now = self.fields();
        let Some(fading) = &mut self.fading else { return Vec::new() };
        let (displacement, paint) = std::mem::replace(&mut fading.stamped, now);
        let mut refused = fading.displacement.stamp(context, &displacement, &self.displacement, self.time);
        if let (Some(before), Some(paint)) = (paint, &self.paint) {
            refused.extend(fading.paint.stamp(context, &before, paint, self.time));
            refused.sort_unstable();
            refused.dedup();
        }
        refused
    }

    /// Comes to `time` in seconds: what was edited fades as it should, and edits are made then from now on.
    ///
    /// Fails, as [`Self::set_time`] does, if the time is not finite.
    pub fn advance(&mut self, context: &Context, time: f64) -> Result<()> {
        let _stage = self.fading.is_some().then(|| context.stats().begin("decay"));
        self.stamp(context);
        self.set_time(time)?;
        if let Some(fading) = &mut self.fading {
            fading.displacement.fade(context, &mut self.displacement, time)?;
            if let Some(paint) = &mut self.paint {
                fading.paint.fade(context, paint, time)?;
            }
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

    fn fields(&self) -> (Field, Option<Field<Rgba8>>) {
        (self.displacement.field().clone(), self.paint.as_ref().map(|paint| paint.field().clone()))
    }
}
