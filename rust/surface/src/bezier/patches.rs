//! Surfaces of bicubic Bézier patches, as they are or rational: 16 control points each, and a weight each.
//!
//! Control points go row by row: along a row runs u, from row to row runs v. Units: those of the object.

use relievo_core::budget::Budget;
use relievo_core::{Context, Error, Result};

use super::EdgeTable;

/// Control points of a patch.
pub const CONTROLS: usize = 16;

/// The largest coordinate of a control point.
pub const MAX_COORDINATE: f32 = 1e12;

/// The smallest and the largest weight of a control point.
pub const WEIGHTS: [f32; 2] = [1e-6, 1e6];

/// The most patches a surface may have.
pub const MAX_SURFACES: usize = 1 << 26;

/// A surface of bicubic Bézier patches, which are called its surfaces in the publications on virtual vertices.
#[derive(Clone, Debug)]
pub struct BezierSurface {
    /// x, y, z (not multiplied by the weight) and weight.
    controls: Vec<[[f32; 4]; CONTROLS]>,
    rational: bool,
    edges: EdgeTable,
}

impl BezierSurface {
    /// A surface of the patches whose control points are `points`, 16 after 16, or the points that `indices` name, 16
    /// after 16. `weights` has one weight for every point; without it all are 1.
    ///
    /// # Errors
    /// Counts that do not fit, an index that refers to nothing, coordinates that are not finite or above
    /// [`MAX_COORDINATE`], weights outside [`WEIGHTS`], or more than the context's memory limit.
    pub fn new(
        context: &Context,
        points: &[[f32; 3]],
        indices: Option<&[u32]>,
        weights: Option<&[f32]>,
    ) -> Result<Self> {
        let used = indices.map_or(points.len(), <[u32]>::len);
        if used == 0 || !used.is_multiple_of(CONTROLS) {
            return Err(Error::invalid(format!("{used} control points do not make patches"))
                .advise("give 16 for every patch, row by row"));
        }
        let count = used / CONTROLS;
        if count > MAX_SURFACES {
            return Err(
                Error::invalid(format!("{count} patches are too many")).advise(format!("use at most {MAX_SURFACES}"))
            );
        }
        if let Some(weights) = weights.filter(|weights| weights.len() != points.len()) {
            return Err(Error::invalid(format!("{} weights are given for {} points", weights.len(), points.len()))
                .advise("give one for every point"));
        }
        let control = |place: usize| -> Result<[f32; 4]> {
            let index = indices.map_or(place, |indices| indices[place] as usize);
            let at = |error: Error| error.at(format!("patch {}, control point {}", place / CONTROLS, place % CONTROLS));
            let point = points.get(index).ok_or_else(|| {
                at(Error::invalid(format!("point {index} does not exist"))
                    .advise(format!("use 0 to {}", points.len().saturating_sub(1))))
            })?;
            if !point.iter().all(|value| value.abs() <= MAX_COORDINATE) {
                return Err(at(Error::invalid("a coordinate is not finite, or too large")
                    .advise(format!("use coordinates up to {MAX_COORDINATE:e}"))));
            }
            let weight = weights.map_or(1.0, |weights| weights[index]);
            if !(WEIGHTS[0]..=WEIGHTS[1]).contains(&weight) {
                return Err(at(Error::invalid(format!("its weight is {weight}"))
                    .advise(format!("use weights from {:e} to {:e}", WEIGHTS[0], WEIGHTS[1]))));
            }
            // A zero has one sign, so that equal control points have equal bits.
            Ok([point[0] + 0.0, point[1] + 0.0, point[2] + 0.0, weight])
        };
        let mut budget = Budget::new(context.memory_limit());
        let mut controls = Vec::new();
        budget.reserve(&mut controls, count)?;
        for patch in 0..count {
            let mut sixteen = [[0.0; 4]; CONTROLS];
            for (number, into) in sixteen.iter_mut().enumerate() {
                *into = control(patch * CONTROLS + number)?;
            }
            controls.push(sixteen);
        }
        let rational = controls.as_flattened().iter().any(|control| control[3] != controls[0][0][3]);
        let edges = EdgeTable::new(&controls, &mut budget)?;
        Ok(Self { controls, rational, edges })
    }

    /// Number of patches.
    pub fn count(&self) -> usize {
        self.controls.len()
    }

    /// The control points of `patch`: x, y, z and weight.
    ///
    /// # Panics
    /// `patch` is not below [`Self::count`].
    pub fn controls(&self, patch: usize) -> &[[f32; 4]; CONTROLS] {
        &self.controls[patch]
    }

    /// The control points of all patches.
    pub fn all_controls(&self) -> &[[[f32; 4]; CONTROLS]] {
        &self.controls
    }

    /// Whether weights differ. Where they are all equal they cancel.
    pub fn is_rational(&self) -> bool {
        self.rational
    }

    /// How its edges touch.
    pub fn edges(&self) -> &EdgeTable {
        &self.edges
    }

    /// Smallest and largest coordinates of the control points of `patch`, between which all of it lies.
    pub fn bounds(&self, patch: usize) -> ([f32; 3], [f32; 3]) {
        extent(&self.controls[patch])
    }

    /// Smallest and largest coordinates of all control points.
    pub fn total_bounds(&self) -> ([f32; 3], [f32; 3]) {
        extent(self.controls.as_flattened())
    }
}

fn extent(controls: &[[f32; 4]]) -> ([f32; 3], [f32; 3]) {
    controls.iter().fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), control| {
        (
            std::array::from_fn(|axis| low[axis].min(control[axis])),
            std::array::from_fn(|axis| high[axis].max(control[axis])),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(offset: f32) -> Vec<[f32; 3]> {
        (0..16).map(|i| [(i % 4) as f32 + offset, (i / 4) as f32, 0.0]).collect()
    }

    #[test]
    fn indices_name_points_and_weights_follow_them() {
        let context = Context::serial();
        let mut points = flat(0.0);
        points.push([9.0, 9.0, 9.0]);
        let mut weights = vec![1.0; 17];
        weights[16] = 2.0;
        let mut indices: Vec<u32> = (0..16).collect();
        indices[5] = 16;
        let surface = BezierSurface::new(&context, &points, Some(&indices), Some(&weights)).unwrap();
        assert_eq!((surface.count(), surface.is_rational()), (1, true));
        assert_eq!(surface.controls(0)[5], [9.0, 9.0, 9.0, 2.0]);
        assert_eq!(surface.bounds(0), ([0.0; 3], [9.0; 3]));
        let equal = BezierSurface::new(&context, &flat(0.0), None, Some(&[3.0; 16])).unwrap();
        assert!(!equal.is_rational(), "equal weights cancel");
    }

    #[test]
    fn what_cannot_be_a_surface_is_refused_with_its_place() {
        let context = Context::serial();
        let refused = |points: &[[f32; 3]], indices: Option<&[u32]>, weights: Option<&[f32]>| {
            BezierSurface::new(&context, points, indices, weights).unwrap_err().to_string()
        };
        assert!(refused(&[], None, None).starts_with("0 control points"));
        assert!(refused(&flat(0.0)[..15], None, None).starts_with("15 control points"));
        assert!(refused(&flat(0.0), None, Some(&[1.0; 3])).starts_with("3 weights"));
        let mut indices: Vec<u32> = (0..16).collect();
        indices[7] = 16;
        assert!(refused(&flat(0.0), Some(&indices), None).starts_with("patch 0, control point 7: point 16"));
        let mut points = flat(0.0);
        points[3][1] = f32::NAN;
        assert!(refused(&points, None, None).starts_with("patch 0, control point 3: a coordinate"));
        for weight in [0.0, -1.0, f32::NAN, 1e7] {
            let mut weights = [1.0; 16];
            weights[2] = weight;
            assert!(refused(&flat(0.0), None, Some(&weights)).contains("control point 2: its weight"));
        }
        let small = relievo_core::ContextOptions { threads: 1, memory_limit: 1000 };
        let small = Context::new(&small).unwrap();
        let points: Vec<_> = (0..8).flat_map(|i| flat(i as f32)).collect();
        let error = BezierSurface::new(&small, &points, None, None).unwrap_err();
        assert_eq!(error.kind, relievo_core::ErrorKind::Memory);
    }
}
