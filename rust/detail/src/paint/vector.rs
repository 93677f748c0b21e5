//! New vectors of old ones: what a brush, with its image and its mode, makes of the vector displacement of up to 256
//! places of any kind of surface.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 3, names
//! displacement in any direction beside that along the normal. A scalar displacement cannot move a place sideways, so
//! whatever does writes here. Units: object units.

use glam::{DAffine3, DVec3, Mat3, Vec3};
use half::f16;
use half::slice::HalfFloatSliceExt;
use relievo_core::simd::Level;
use relievo_tiles::triangle::Offset;
use relievo_tiles::{Texel, Vector};

use crate::channels::frame::{STILL, Vectors};
use crate::channels::knots::{BLOCK_KNOTS, PerKnot};
use crate::paint::brush::Brush;
use crate::paint::mode::{SculptMode, VectorInput};
use crate::paint::spot::Spot;
use crate::paint::stamp::Stamp;

/// A texel that holds a vector.
pub(crate) trait VectorTexel: Texel<Value = DVec3> {
    /// Writes the components of `texels` from place `start` on.
    fn read(texels: &[Self], out: &mut Vectors, start: usize);
}

impl VectorTexel for Vector {
    fn read(texels: &[Self], out: &mut Vectors, start: usize) {
        let mut numbers = [0.0; 3 * BLOCK_KNOTS];
        let halves: &[f16] = bytemuck::cast_slice(texels);
        halves.convert_to_f32_slice(&mut numbers[..halves.len()]);
        for (k, vector) in numbers[..halves.len()].chunks_exact(3).enumerate() {
            (0..3).for_each(|axis| out[axis][start + k] = vector[axis]);
        }
    }
}

impl VectorTexel for Offset {
    fn read(texels: &[Self], out: &mut Vectors, start: usize) {
        for (k, texel) in texels.iter().enumerate() {
            (0..3).for_each(|axis| out[axis][start + k] = texel.0[axis]);
        }
    }
}

/// Places whose vectors are in frames of their own.
pub(crate) trait Framed {
    /// The vectors that the weights were evaluated with, in the frames.
    fn vectors(&self) -> &Vectors;

    /// From the frames to object space.
    fn to_object(&self, level: Level, vectors: &mut Vectors);

    /// From object space to the frames.
    fn from_object(&self, level: Level, vectors: &mut Vectors);
}

/// How vectors are changed.
pub(crate) struct Bending<'a> {
    pub level: Level,
    pub mode: SculptMode,
    pub height: f32,
    pub stamp: Option<&'a Stamp>,
    maps: BrushMaps,
}

/// How directions go between a brush and object space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrushMaps {
    /// Directions of the brush's axes in object space, as columns of length 1.
    axes: Mat3,
    /// From coordinates in the brush to object space.
    spread: Mat3,
    /// From object space to coordinates in the brush.
    inner: Mat3,
}

impl BrushMaps {
    /// Those of `brush` on an object with the given transform to the world.
    pub fn new(brush: &Brush, transform: &DAffine3) -> Self {
        let obb = brush.obb();
        let inverse = transform.matrix3.inverse();
        let map = inverse * obb.axes * glam::DMat3::from_diagonal(obb.half);
        let axes = [map.x_axis, map.y_axis, map.z_axis].map(|axis| axis.normalize_or_zero().as_vec3());
        let inner = (brush.map().matrix3 * transform.matrix3).as_mat3();
        Self { axes: Mat3::from_cols(axes[0], axes[1], axes[2]), spread: map.as_mat3(), inner }
    }

    /// As `brush_bend.wgsl` has them: columns of the three matrices.
    pub fn packed(&self) -> [[[f32; 4]; 3]; 3] {
        let columns = |of: &Mat3| [of.x_axis, of.y_axis, of.z_axis].map(|column| column.extend(0.0).to_array());
        [columns(&self.axes), columns(&self.spread), columns(&self.inner)]
    }
}

impl<'a> Bending<'a> {
    /// What `brush` does on an object with the given transform to the world.
    pub fn new(level: Level, mode: SculptMode, height: f32, brush: &'a Brush, transform: &DAffine3) -> Self {
        Self { level, mode, height, stamp: brush.stamp(), maps: BrushMaps::new(brush, transform) }
    }

    /// Makes the new texels of `spot`.
    pub fn edit<T: VectorTexel>(&self, spot: &mut (impl Spot<T> + Framed), texels: &mut [T]) {
        let mut now = STILL;
        T::read(texels, &mut now, 0);
        let mut mean = STILL;
        let with_mean = self.mode.needs_mean()
            && spot.means(
                |texel| texel.value().as_vec3().to_array(),
                |k, vector| (0..3).for_each(|axis| mean[axis][k] = vector[axis]),
            );
        let mut change = STILL;
        match self.mode {
            SculptMode::Vector => {
                change[2] = [self.height; BLOCK_KNOTS];
                if let Some(stamp) = self.stamp {
                    stamp.bend(&spot.footprints(), spot.weights_mut(), &mut change);
                }
                each(&mut change, |_, vector| self.maps.axes * vector);
                spot.from_object(self.level, &mut change);
            }
            SculptMode::Pinch => {
                self.mask(spot);
                // Dabs that overlap go on from where those before brought the places, or these would cross the line.
                for (axis, change) in change.iter_mut().enumerate() {
                    (0..BLOCK_KNOTS).for_each(|k| change[k] = now[axis][k] - spot.vectors()[axis][k]);
                }
                spot.to_object(self.level, &mut change);
                let across = spot.weights().across;
                let sign = if self.height < 0.0 { 1.0 } else { -1.0 };
                each(&mut change, |k, moved| {
                    let here = (self.maps.inner * moved).truncate() + glam::Vec2::new(across[0][k], across[1][k]);
                    self.maps.spread * (sign * here).extend(0.0)
                });
                spot.from_object(self.level, &mut change);
            }
            _ => self.mask(spot),
        }
        let share = &spot.weights().share;
        let input = VectorInput { share, change: &change, mean: with_mean.then_some(&mean) };
        self.mode.apply_vectors(self.level, &input, &mut now);
        for (k, texel) in texels.iter_mut().enumerate().filter(|(k, _)| share[*k] > 0.0) {
            *texel = T::nearest(DVec3::from([0, 1, 2].map(|axis| f64::from(now[axis][k]))));
        }
    }

    /// An image is how much of the edit a place gets where the mode has no vectors of its own.
    fn mask<T: Texel>(&self, spot: &mut impl Spot<T>) {
        if let Some(stamp) = self.stamp {
            let mut height: PerKnot = [1.0; BLOCK_KNOTS];
            stamp.sculpt(&spot.footprints(), spot.weights_mut(), &mut height, true);
        }
    }
}

fn each(vectors: &mut Vectors, formula: impl Fn(usize, Vec3) -> Vec3) {
    for k in 0..BLOCK_KNOTS {
        let made = formula(k, Vec3::new(vectors[0][k], vectors[1][k], vectors[2][k]));
        (0..3).for_each(|axis| vectors[axis][k] = made[axis]);
    }
}
