//! Traces of contact: where colliders have pushed a surface, how far in all, and when last, so that shaders can tint
//! tracks.
//!
//! A [`Channel`] with the texels of the displacement. Contact and the time that goes with it are averaged and
//! interpolated together: the time is kept multiplied by the contact, so that what was never touched, which has no
//! time, does not count. Units: object units for depths; seconds.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DVec4;
use half::f16;
use relievo_core::{Attribute, Domain, Error, Result, Values};
use relievo_surface::Place;

use crate::quads::channel::{Channel, ChannelOptions};
use crate::quads::color::cell;
use crate::quads::field::Field;
use crate::quads::tessellate::Tessellation;
use crate::store::heap::MAX_SIZE;
use crate::texel::Texel;

/// One texel of traces.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Trace {
    /// 1 where a collider pushed, 0 elsewhere; between them where texels are averaged.
    pub contact: f16,
    /// How far colliders have pushed in all, object units.
    pub depth: f16,
    /// When a collider pushed last, in seconds, times the contact.
    pub moment: f32,
}

/// Traces that may be written.
pub type Traces = Channel<Trace>;

/// What traces say of a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mark {
    /// 0 to 1.
    pub contact: f32,
    /// Object units.
    pub depth: f32,
    /// When it was touched last, in seconds; `None` if it never was.
    pub time: Option<f32>,
}

impl Mark {
    /// What a mean of traces says.
    pub(crate) fn of(mean: DVec4) -> Self {
        let time = (mean.x > 0.0).then(|| (mean.z / mean.x) as f32);
        Self { contact: mean.x as f32, depth: mean.y as f32, time }
    }

    /// Seconds from when it was touched last to `now`, at least 0; −1 where nothing ever touched.
    pub fn age(&self, now: f64) -> f32 {
        self.time.map_or(-1.0, |time| (now - f64::from(time)).max(0.0) as f32)
    }
}

impl Trace {
    /// The trace after a push by `depth` at `time`.
    pub fn pushed(self, depth: f32, time: f32) -> Self {
        let depth = f16::from_f32((self.depth.to_f32() + depth).min(65504.0));
        Self { contact: f16::ONE, depth, moment: time }
    }
}

impl Texel for Trace {
    type Value = DVec4;
    type Difference = Self;

    fn value(self) -> DVec4 {
        DVec4::new(self.contact.to_f64(), self.depth.to_f64(), f64::from(self.moment), 0.0)
    }

    fn nearest(value: DVec4) -> Self {
        Self { contact: f16::nearest(value.x), depth: f16::nearest(value.y), moment: value.z as f32 }
    }

    fn flipped(self) -> Self {
        self
    }

    fn all_finite(texels: &[Self]) -> bool {
        texels.iter().all(|trace| trace.contact.is_finite() && trace.depth.is_finite() && trace.moment.is_finite())
    }
}

impl Traces {
    /// No traces, for a surface with this displacement. They may occupy `budget` bytes.
    ///
    /// # Errors
    /// Fails if traces cannot have the size that the displacement has in a tile.
    pub fn of(displacement: &Field, budget: u64) -> Result<Self> {
        let topology = displacement.topology();
        let sizes = (0..topology.face_count() as u32).map(|face| {
            let tile = topology.tiles_of(face).start;
            let size = displacement.size(tile);
            (face, if topology.is_sub(tile) { (2 * size).min(MAX_SIZE) } else { size })
        });
        let options = ChannelOptions { face_sizes: sizes.collect(), budget, ..ChannelOptions::default() };
        let traces = Self::blank(Arc::clone(topology), Trace::default(), &options)?;
        let differs = |tile: &u32| traces.field().size(*tile) != displacement.size(*tile);
        match (0..topology.tile_count() as u32).find(differs) {
            Some(tile) => {
                Err(Error::invalid("traces cannot have the size of its displacement").at(format!("tile {tile}")))
            }
            None => Ok(traces),
        }
    }
}

impl Field<Trace> {
    /// The trace in `place`'s own tile, interpolated bilinearly. Give it a canonical place for traces that agree
    /// across seams.
    ///
    /// # Panics
    /// If there is no such tile. Parameters outside 0 to 1 are clamped.
    pub fn mark(&self, place: Place) -> Mark {
        let Some(block) = self.block(place.tile) else { return Mark::default() };
        let size = self.size(place.tile);
        let ((i, s), (j, t)) = (cell(place.u, size), cell(place.v, size));
        let stride = size as usize + 2;
        let at = |i: usize, j: usize| block[j * stride + i].value();
        let low = at(i, j).lerp(at(i + 1, j), f64::from(s));
        let high = at(i, j + 1).lerp(at(i + 1, j + 1), f64::from(s));
        Mark::of(low.lerp(high, f64::from(t)))
    }
}

impl Tessellation {
    /// Gives the mesh the point attributes `contact`, 0 to 1, `depth`, in object units, and `age`, in seconds before
    /// `now` and −1 where nothing ever touched, in place of those it may have.
    ///
    /// # Panics
    /// If the tessellation is that of another surface.
    pub fn trace(&mut self, traces: &Field<Trace>, now: f64) {
        let count = self.mesh.points.len();
        let mut lists = [vec![0.0; count], vec![0.0; count], vec![-1.0; count]];
        let mut done = vec![false; count];
        for (corner, point) in self.mesh.corners.iter().enumerate() {
            let point = *point as usize;
            if std::mem::replace(&mut done[point], true) {
                continue;
            }
            let [u, v] = self.parameters[corner];
            let mark = traces.mark(traces.canonical(Place::new(self.tiles[corner / 3], u, v)));
            lists[0][point] = mark.contact;
            lists[1][point] = mark.depth;
            lists[2][point] = mark.age(now);
        }
        for (name, values) in ["contact", "depth", "age"].into_iter().zip(lists) {
            self.mesh.attributes.retain(|attribute| attribute.name != name);
            self.mesh.attributes.push(Attribute {
                name: name.into(),
                domain: Domain::Point,
                width: 1,
                values: Values::F32(values),
                indices: None,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trace_is_eight_bytes_and_survives_its_value() {
        assert_eq!(size_of::<Trace>(), 8);
        let trace = Trace::default().pushed(0.25, 7.3).pushed(0.5, 1234.567);
        assert_eq!(trace, Trace { contact: f16::ONE, depth: f16::from_f32(0.75), moment: 1234.567 });
        assert_eq!(Trace::nearest(trace.value()), trace);
        assert!(!Trace::all_finite(&[Trace { moment: f32::NAN, ..trace }]));
        assert_eq!(trace.pushed(1e9, 0.0).depth, f16::MAX);
    }
}
