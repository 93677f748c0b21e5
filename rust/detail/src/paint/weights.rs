//! What a brush says of places of a surface: their share of the edit, and where they are in its box.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 5.2: the
//! position of each texel is mapped to brush space and the brush function is evaluated there. It does not depend on
//! tiles: up to 256 places of any surface are given by points, unit normals and the displacement along them. Units:
//! object units; places in the brush are −1 to 1 along each axis of its box.

use bytemuck::{Pod, Zeroable};
use glam::DAffine3;
use relievo_core::dispatch_simd;
use relievo_core::simd::{Arithmetic, Level};

use crate::channels::knots::{BLOCK_KNOTS, KnotBlock, PerKnot};
use crate::paint::brush::Brush;
use relievo_core::Falloff;

/// What the evaluating kernel knows of a brush. As stored in buffers.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BrushParameters {
    /// From object space, less the origin, to the brush's coordinates: rows with their shift.
    pub rows: [[f32; 4]; 3],
    /// The place in object space that is subtracted first; the fourth number is nothing.
    pub origin: [f32; 4],
    /// The [`Falloff`].
    pub falloff: u32,
    /// The strength.
    pub strength: f32,
    /// Nothing.
    pub padding: [u32; 2],
}

impl BrushParameters {
    /// Those of `brush` with `strength`, 0 to 1, on an object with the given transform to the world.
    pub fn new(brush: &Brush, strength: f32, transform: &DAffine3) -> Self {
        let map = brush.map() * *transform;
        let origin = transform.inverse().transform_point3(brush.obb().center).as_vec3();
        let shift = map.transform_point3(origin.as_dvec3());
        let row = |axis: usize| map.matrix3.row(axis).as_vec3().extend(shift[axis] as f32).to_array();
        Self {
            rows: [0, 1, 2].map(row),
            origin: origin.extend(0.0).to_array(),
            falloff: brush.falloff() as u32,
            strength,
            padding: [0; 2],
        }
    }

    /// The formula of the share.
    pub fn falloff(&self) -> Falloff {
        Falloff::NAMES.get(self.falloff as usize).map_or(Falloff::Constant, |(falloff, _)| *falloff)
    }

    /// By how much the third coordinate in the brush grows over one object unit along the brush's third axis.
    pub fn unit(&self) -> f32 {
        let [x, y, z, _] = self.rows[2];
        (x * x + y * y + z * z).sqrt()
    }
}

/// What a brush says of up to 256 places.
#[derive(Clone, Debug)]
pub struct Weights {
    /// Share of the edit, 0 to 1; 0 outside the box.
    pub share: PerKnot,
    /// First and second coordinate in the brush.
    pub across: [PerKnot; 2],
    /// Third coordinate in the brush.
    pub level: PerKnot,
    /// By how much the third coordinate grows over one object unit along the normal.
    pub rise: PerKnot,
    /// [`BrushParameters::unit`].
    pub unit: f32,
}

impl Default for Weights {
    fn default() -> Self {
        let zero = [0.0; BLOCK_KNOTS];
        Self { share: zero, across: [zero; 2], level: zero, rise: zero, unit: 0.0 }
    }
}

impl Weights {
    /// Evaluates the brush at the points of `places`, moved along their normals by `heights`.
    pub fn evaluate(&mut self, level: Level, brush: &BrushParameters, places: &KnotBlock, heights: &PerKnot) {
        self.unit = brush.unit();
        weigh(level, brush, places, Some(heights), self);
    }

    /// As [`Self::evaluate`], of places that are not moved. Normals are not looked at, and the rise is not known.
    pub(crate) fn evaluate_points(&mut self, level: Level, brush: &BrushParameters, places: &KnotBlock) {
        self.unit = brush.unit();
        weigh(level, brush, places, None, self);
    }

    /// Whether a place has a share of the edit.
    pub fn any(&self) -> bool {
        self.share.iter().any(|share| *share > 0.0)
    }
}

dispatch_simd! {
    /// The brush at the displaced points of a block.
    fn weigh = weigh_body(
        brush: &BrushParameters, places: &KnotBlock, heights: Option<&PerKnot>, weights: &mut Weights
    )
}

#[inline(always)]
fn weigh_body<A: Arithmetic>(
    _: A,
    brush: &BrushParameters,
    places: &KnotBlock,
    heights: Option<&PerKnot>,
    weights: &mut Weights,
) {
    let BrushParameters { rows, origin, strength, .. } = *brush;
    let Weights { share, across: [first, second], level, rise, .. } = weights;
    let (mut squares, mut inside) = ([0.0; BLOCK_KNOTS], [true; BLOCK_KNOTS]);
    // Axis by axis in plain loops: what is not inlined here would not have the instructions of the level.
    for (row, out) in rows.iter().zip([first, second, level]) {
        for k in 0..BLOCK_KNOTS {
            let (x, y, z) = (places.p[0][k] - origin[0], places.p[1][k] - origin[1], places.p[2][k] - origin[2]);
            out[k] = A::fma(row[0], x, A::fma(row[1], y, A::fma(row[2], z, row[3])));
        }
        if let Some(heights) = heights {
            for k in 0..BLOCK_KNOTS {
                // The third axis comes last.
                rise[k] = A::fma(row[0], places.n[0][k], A::fma(row[1], places.n[1][k], row[2] * places.n[2][k]));
                out[k] = A::fma(heights[k], rise[k], out[k]);
            }
        }
        for k in 0..BLOCK_KNOTS {
            inside[k] &= out[k].abs() <= 1.0;
            squares[k] = A::fma(out[k], out[k], squares[k]);
        }
    }
    // The square of the distance from the middle, or −1 outside.
    for k in 0..BLOCK_KNOTS {
        share[k] = if inside[k] { squares[k] } else { -1.0 };
    }
    // A loop for each formula, so that none asks which it is.
    match brush.falloff() {
        Falloff::Constant => fade(share, strength, |square| Falloff::Constant.of_square(square)),
        Falloff::Linear => fade(share, strength, |square| Falloff::Linear.of_square(square)),
        Falloff::Smooth => fade(share, strength, |square| Falloff::Smooth.of_square(square)),
        Falloff::Sphere => fade(share, strength, |square| Falloff::Sphere.of_square(square)),
        Falloff::Gaussian => fade(share, strength, |square| Falloff::Gaussian.of_square(square)),
    }
}

/// Squares of distances, −1 outside, to shares of the edit.
#[inline(always)]
fn fade(share: &mut PerKnot, strength: f32, formula: impl Fn(f32) -> f32) {
    for value in share {
        *value = if *value >= 0.0 { strength * formula(*value) } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    #[test]
    fn weights_are_the_formula_at_the_displaced_place_in_the_box() {
        let transform =
            DAffine3::from_translation(DVec3::new(3.0, 1.0, -2.0)) * DAffine3::from_scale(DVec3::splat(2.0));
        let axes = DMat3::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 0.2);
        let brush = Brush::new(DVec3::new(3.5, 0.5, -1.5), axes, DVec3::new(1.0, 0.6, 0.8), Falloff::Linear).unwrap();
        let parameters = BrushParameters::new(&brush, 0.7, &transform);
        assert!((parameters.unit() - 2.0 / 0.8).abs() < 1e-6);
        let (mut places, mut heights) = (KnotBlock::ZERO, [0.0; BLOCK_KNOTS]);
        for k in 0..BLOCK_KNOTS {
            let t = k as f32;
            let normal = DVec3::new(f64::from(t.sin()), f64::from(t.cos()), 0.5).normalize();
            heights[k] = 0.1 * (0.7 * t).sin();
            for axis in 0..3 {
                places.p[axis][k] = 0.4 * (t * (axis as f32 + 1.3)).sin();
                places.n[axis][k] = normal[axis] as f32;
            }
        }
        let mut weights = Weights::default();
        for (level, name) in Level::NAMES {
            weights.evaluate(level, &parameters, &places, &heights);
            for k in 0..BLOCK_KNOTS {
                let [p, n] =
                    [&places.p, &places.n].map(|xyz| DVec3::from_array([0, 1, 2].map(|i| f64::from(xyz[i][k]))));
                let place = brush.map().transform_point3(transform.transform_point3(p + n * f64::from(heights[k])));
                let expected = 0.7 * Falloff::Linear.share(place.as_vec3().to_array());
                assert!((weights.share[k] - expected).abs() < 1e-5, "{name} {k}");
                let found = DVec3::new(f64::from(weights.across[0][k]), f64::from(weights.across[1][k]), 0.0)
                    + DVec3::Z * f64::from(weights.level[k]);
                assert!((found - place).length() < 1e-5, "{name} {k}: {found} {place}");
            }
            weights.evaluate(level, &parameters, &places, &[0.0; BLOCK_KNOTS]);
            let mut still = Weights::default();
            still.evaluate_points(level, &parameters, &places);
            assert!(still.share == weights.share && still.across == weights.across && still.level == weights.level);
        }
        assert!(weights.any());
    }
}
