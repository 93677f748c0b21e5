//! Many small decals over a surface, by density and seed.
//!
//! Each lies around a point by the discrete exponential map. The points are spread evenly by area: places in the running
//! sum of the areas, drawn by SplitMix64 (Steele, Lea and Flood 2014). All points become vertices of one surface, which the
//! decals share. Lengths are in units of the mesh, angles in radians.

use relievo_core::{Context, Error, Mesh, Result};

use crate::decal::{Decal, Frame, Sticker};
use crate::exponential::around;
use crate::pins::{Place, insert};
use crate::surface::{Surface, Vec3};

/// The most decals of a scatter.
const MAX: f64 = 1_000_000.0;
/// The golden ratio as a fraction of 2⁶⁴, by which SplitMix64 counts.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// How stickers are scattered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Decals for each square unit of the mesh.
    pub density: f64,
    /// The width of the whole image on the surface, at least and at most.
    pub width: [f64; 2],
    /// The direction in space that the image's upward direction follows before it is turned.
    pub up: Vec3,
    /// The largest angle that a decal is turned by, to either side.
    pub turn: f64,
    /// The number that the random places, widths and angles come from.
    pub seed: u64,
}

/// Lays a sticker around many random points of a mesh. The result does not depend on the number of threads.
///
/// # Errors
/// The mesh is unusable or has no area, or a number is out of range.
pub fn scatter(context: &Context, mesh: &Mesh, sticker: &Sticker, settings: &Scatter) -> Result<Vec<Decal>> {
    let Scatter { density, width: [least, most], up, turn, seed } = *settings;
    let refuse = |what: &str, remedy: &str| Err(Error::invalid(what).at("scatter").advise(remedy));
    if !(density >= 0.0 && density.is_finite()) || !(least > 0.0 && most >= least && most.is_finite()) {
        return refuse("the density or a width is out of range", "give a density of 0 or more and positive widths");
    }
    let is_direction = up.iter().all(|value| value.is_finite()) && up != [0.0; 3];
    if !is_direction || !(0.0..=std::f64::consts::PI).contains(&turn) {
        return refuse(
            "the direction or the angle is out of range",
            "give a direction, and an angle of 0 to pi radians",
        );
    }
    let surface = Surface::new(mesh)?;
    let mut sums = Vec::with_capacity(surface.triangles.len());
    let mut area = 0.0;
    for triangle in 0..surface.triangles.len() as u32 {
        area += if surface.is_hole(triangle) { 0.0 } else { surface.area(triangle) };
        sums.push(area);
    }
    let count = (density * area).round();
    if area.is_nan() || area <= 0.0 || count > MAX {
        return refuse("the mesh has no area, or there would be more than a million decals", "lower the density");
    }
    let mut random = Random(seed);
    let draws: Vec<[f64; 5]> = (0..count as usize).map(|_| std::array::from_fn(|_| random.unit())).collect();
    let mut places: Vec<Place> = Vec::with_capacity(draws.len());
    for [along, s, t, ..] in &draws {
        let face = sums.partition_point(|sum| *sum <= along * area).min(sums.len() - 1) as u32;
        let root = s.sqrt();
        places.push(Place { face, barycentric: [1.0 - root, root * (1.0 - t), root * t] });
    }
    let (surface, vertices) = insert(surface, &places)?;
    let middle = sticker.middle();
    let lay = |index: usize| -> Option<Decal> {
        let [.., size, angle] = draws[index];
        let width = least + size * (most - least);
        let normal = Frame::normal(&surface, vertices[index]);
        let frame = Frame::turned(normal, up, (2.0 * angle - 1.0) * turn)?;
        Some(around(&surface, sticker, vertices[index], middle, frame, width))
    };
    Ok(context.map(draws.len(), lay).into_iter().flatten().collect())
}

/// SplitMix64.
struct Random(u64);

impl Random {
    /// Returns the next number from 0 to below 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(STEP);
        let mut bits = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
