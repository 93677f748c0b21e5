//! What a surface of a scene looks like at a place: the colours painted on it, and over them the tint of its traces.

use glam::Vec3;
use relievo_render as render;
use relievo_surface::Place;
use relievo_tiles::{AnyField, Field, Mark, Trace};

use crate::format::description::{ObjectEntry, TintEntry};

/// The colours of a surface at a time.
#[derive(Clone, Copy, Debug)]
pub struct Coat<'a> {
    base: Vec3,
    paint: Option<AnyField<'a>>,
    traces: Option<(&'a Field<Trace>, &'a TintEntry)>,
    time: f32,
}

impl<'a> Coat<'a> {
    /// The colours of the object that `entry` describes, at `time` in seconds; `None` if it is of one colour.
    pub fn new(
        entry: &'a ObjectEntry,
        paint: Option<AnyField<'a>>,
        traces: Option<&'a Field<Trace>>,
        time: f64,
    ) -> Option<Self> {
        let traces = traces.zip(entry.traces.as_ref());
        let coat = Self { base: entry.colour.into(), paint, traces, time: time as f32 };
        (paint.is_some() || traces.is_some()).then_some(coat)
    }

    /// What a graphics device draws of a coat, or of none.
    pub fn drawn(coat: Option<&Self>) -> render::virtual_vertex::Coat<'a> {
        let traces = |coat: &Self| coat.traces.map(|(traces, tint)| (traces, tint.drawn(coat.time)));
        render::virtual_vertex::Coat { colors: coat.and_then(|coat| coat.paint), traces: coat.and_then(traces) }
    }

    /// Texels along a side of `tile`, the most of what is allocated there; `None` if nothing is.
    pub fn size(&self, tile: u32) -> Option<u32> {
        let paint = self.paint.filter(|paint| paint.is_allocated(tile)).map(|paint| paint.size(tile));
        let traces = self.traces.filter(|(traces, _)| traces.is_allocated(tile)).map(|(traces, _)| traces.size(tile));
        paint.max(traces)
    }

    /// The tiles that look different although nothing was written to them, because their traces fade.
    pub fn fading(&self) -> impl Iterator<Item = u32> + use<'a> {
        self.traces.into_iter().filter(|(_, tint)| tint.fade > 0.0).flat_map(|(traces, _)| traces.allocated())
    }

    /// The colour at `place`, linear Rec.709. Places on edges of a tile have one colour whichever tile is asked.
    pub fn color(&self, place: Place) -> [f32; 3] {
        let base = self.paint.map_or(self.base, |paint| paint.color(paint.canonical(place)).truncate());
        let Some((traces, tint)) = self.traces else { return base.to_array() };
        tint.over(base, &traces.mark(traces.canonical(place)), self.time)
    }
}

impl TintEntry {
    /// The colour of a place of colour `base` with a mark at `time`.
    pub(crate) fn over(&self, base: Vec3, mark: &Mark, time: f32) -> [f32; 3] {
        base.lerp(self.colour.into(), self.share(mark, time)).to_array()
    }

    /// The same for a graphics device.
    pub(crate) fn drawn(&self, time: f32) -> render::virtual_vertex::Tint {
        render::virtual_vertex::Tint { color: self.colour, depth: self.depth, fade: self.fade, time }
    }

    /// How much of the tint a mark gets at `time`.
    fn share(&self, mark: &Mark, time: f32) -> f32 {
        let Some(touched) = mark.time else { return 0.0 };
        let deep = if self.depth > 0.0 { (mark.depth / self.depth).min(1.0) } else { 1.0 };
        let fresh = if self.fade > 0.0 { (1.0 - (time - touched) / self.fade).clamp(0.0, 1.0) } else { 1.0 };
        mark.contact * deep * fresh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tints_grow_with_depth_and_fade_with_age() {
        let tint = TintEntry { colour: [0.0; 3], depth: 0.2, fade: 4.0 };
        let mark = Mark { contact: 1.0, depth: 0.1, time: Some(2.0) };
        assert_eq!(tint.share(&mark, 2.0), 0.5);
        assert_eq!(tint.share(&mark, 4.0), 0.25);
        assert_eq!(tint.share(&mark, 9.0), 0.0);
        assert_eq!(tint.share(&Mark { depth: 9.0, ..mark }, 2.0), 1.0);
        assert_eq!(tint.share(&Mark { time: None, ..mark }, 2.0), 0.0);
        assert_eq!(TintEntry { depth: 0.0, fade: 0.0, ..tint }.share(&mark, 1e6), 1.0);
    }
}
