//! Levels of patches, chosen by an error on the picture, and rates of edges that close cracks between them.
//!
//! A map's triangles leave the surface by no more than second differences of the control points allow (Filip,
//! Magedson, Markot 1986, *Surface algorithms using bounds on derivatives*), which the camera turns into pixels. An edge
//! is divided as the finest patch at it is. Coarser ones keep their own samples, and have triangles between these and the
//! finer ones ([`super::stitches`]): so no patch makes another one finer.

use glam::DVec3;
use relievo_core::{Context, Error, Result};

use super::{BezierSurface, ParametricMap};

/// The level of every patch and of each of its edges.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Levels {
    patches: Vec<u8>,
    edges: Vec<[u8; 4]>,
}

/// From where a surface is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// Where the camera is, in the surface's space.
    pub eye: [f64; 3],
    /// The direction of view, of unit length.
    pub forward: [f64; 3],
    /// Pixels that a unit across the view covers at distance 1 along it.
    pub pixels: f64,
    /// How far from the direction of view the picture reaches, as the tangent of the angle to its corner.
    pub corner: f64,
}

impl Levels {
    /// The same level for all patches.
    ///
    /// # Errors
    /// There is no such level.
    pub fn uniform(surface: &BezierSurface, level: u32) -> Result<Self> {
        let level = ParametricMap::new(level)?.level() as u8;
        Ok(Self { patches: vec![level; surface.count()], edges: vec![[level; 4]; surface.count()] })
    }

    /// These levels of patches; edges get the highest of the patches they belong to.
    ///
    /// # Errors
    /// There is not one level for every patch, or there is no such level.
    pub fn new(surface: &BezierSurface, levels: Vec<u8>) -> Result<Self> {
        if levels.len() != surface.count() {
            return Err(Error::invalid(format!("{} levels are given for {} patches", levels.len(), surface.count())));
        }
        for (patch, level) in levels.iter().enumerate() {
            ParametricMap::new(u32::from(*level)).map_err(|error| error.at(format!("patch {patch}")))?;
        }
        let mut edges = vec![[0; 4]; levels.len()];
        for (patch, edges) in edges.iter_mut().enumerate() {
            for (edge, curve) in edges.iter_mut().zip(surface.edges().curves(patch)) {
                let sharing = surface.edges().sharing(curve as usize);
                *edge = sharing.map(|(patch, _)| levels[patch as usize]).max().unwrap_or(levels[patch]);
            }
        }
        Ok(Self { patches: levels, edges })
    }

    /// The lowest levels, up to `most`, whose triangles are nowhere farther than `tolerance` pixels from the surface
    /// as the picture shows it. Patches for which `most` is not enough get it.
    ///
    /// # Errors
    /// The tolerance is not above zero, the viewpoint is not finite, or there is no level `most`.
    pub fn select(
        context: &Context,
        surface: &BezierSurface,
        view: &Viewpoint,
        tolerance: f64,
        most: u32,
    ) -> Result<Self> {
        let most = ParametricMap::new(most)?.level() as u8;
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(Error::invalid(format!("the tolerance of {tolerance} pixels cannot be met"))
                .advise("use a number above zero"));
        }
        let numbers = view.eye.iter().chain(&view.forward).chain([&view.pixels, &view.corner]);
        if !numbers.copied().all(f64::is_finite) {
            return Err(Error::invalid("the viewpoint is not finite"));
        }
        let curvatures = context.map(surface.count(), |patch| Curvature::new(surface.controls(patch)));
        let reach: Vec<f64> = context.map(surface.count(), |patch| view.reach_of(surface, patch, tolerance));
        let enough = |patch: usize, level: u8| curvatures[patch].error(level) <= reach[patch];
        let lowest = |patch: usize| (1..most).find(|level| enough(patch, *level)).unwrap_or(most);
        Self::new(surface, context.map(surface.count(), lowest))
    }

    /// The level of `patch`.
    ///
    /// # Panics
    /// It does not exist.
    pub fn patch(&self, patch: usize) -> u32 {
        u32::from(self.patches[patch])
    }

    /// The levels of its edges, none below the patch's.
    ///
    /// # Panics
    /// It does not exist.
    pub fn edges(&self, patch: usize) -> [u32; 4] {
        self.edges[patch].map(u32::from)
    }

    /// How many patches there are.
    pub fn count(&self) -> usize {
        self.patches.len()
    }
}

impl Viewpoint {
    /// How far from what it stands for a triangle within the box from `low` to `high` may be, in units of the surface, to
    /// be within `tolerance` pixels of it: negative where the box reaches behind the camera, without end where it is out
    /// of sight.
    pub fn reach(&self, low: [f32; 3], high: [f32; 3], tolerance: f64) -> f64 {
        let [low, high] = [low, high].map(|corner| DVec3::from(corner.map(f64::from)));
        let (middle, half) = (0.5 * (low + high) - DVec3::from(self.eye), 0.5 * (high - low));
        let forward = DVec3::from(self.forward);
        let depth = middle.dot(forward);
        // The sphere around the box, beside the cone around the picture.
        let beside = (middle - forward * depth).length() - self.corner * depth;
        if beside > half.length() * (1.0 + self.corner * self.corner).sqrt() {
            return f64::INFINITY;
        }
        self.within(depth - half.dot(forward.abs()), tolerance)
    }

    /// How far from what it stands for a triangle may be that is `nearest` along the view or farther.
    ///
    /// A point at depth z that moves by e moves by at most e · pixels · √(1 + r²) / (z − e) on the picture, where r is
    /// the tangent of the angle between the view and it.
    fn within(&self, nearest: f64, tolerance: f64) -> f64 {
        let slope = self.pixels * (1.0 + self.corner * self.corner).sqrt();
        nearest * tolerance / (slope + tolerance)
    }

    /// As [`Self::reach`], of a patch.
    fn reach_of(&self, surface: &BezierSurface, patch: usize, tolerance: f64) -> f64 {
        let (eye, forward) = (DVec3::from(self.eye), DVec3::from(self.forward));
        let depth = |control: &[f32; 4]| {
            (DVec3::new(f64::from(control[0]), f64::from(control[1]), f64::from(control[2])) - eye).dot(forward)
        };
        // The patch is within its control points.
        let nearest = surface.controls(patch).iter().map(depth).fold(f64::INFINITY, f64::min);
        self.within(nearest, tolerance)
    }
}

/// Bounds of the second derivatives of a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Curvature {
    uu: f64,
    uv: f64,
    vv: f64,
}

impl Curvature {
    fn new(controls: &[[f32; 4]; 16]) -> Self {
        let weight = |number: usize| f64::from(controls[number][3]);
        // About the middle of the control points, so that how far they are from the origin does not count.
        let place = |number: usize| {
            let [x, y, z, _] = controls[number].map(f64::from);
            DVec3::new(x, y, z)
        };
        let middle = (0..16).map(place).sum::<DVec3>() / 16.0;
        let form = |number: usize| ((place(number) - middle) * weight(number), weight(number));
        let largest = |differences: &mut dyn Iterator<Item = [(usize, f64); 4]>| {
            differences.fold((0.0f64, 0.0f64), |(vector, scalar), terms| {
                let sum = terms.iter().fold((DVec3::ZERO, 0.0), |(p, w), (number, factor)| {
                    let (point, weight) = form(*number);
                    (p + *factor * point, w + factor * weight)
                });
                (vector.max(sum.0.length()), scalar.max(sum.1.abs()))
            })
        };
        let row = |step: usize, other: usize| {
            move |factor: [f64; 3]| {
                (0..4usize).flat_map(move |line| {
                    let count = if factor[2] == 0.0 { 3 } else { 2 };
                    (0..count).map(move |at| {
                        let first = line * other + at * step;
                        let last = if factor[2] == 0.0 { first } else { first + 2 * step };
                        [(first, factor[0]), (first + step, factor[1]), (last, factor[2]), (first, 0.0)]
                    })
                })
            }
        };
        let (u, v) = (row(1, 4), row(4, 1));
        let (first, second) = ([-1.0, 1.0, 0.0], [1.0, -2.0, 1.0]);
        let (pu, wu) = largest(&mut u(first));
        let (pv, wv) = largest(&mut v(first));
        let (puu, wuu) = largest(&mut u(second));
        let (pvv, wvv) = largest(&mut v(second));
        let mixed = (0..9).map(|at| {
            let first = at % 3 + 4 * (at / 3);
            [(first, 1.0), (first + 1, -1.0), (first + 4, -1.0), (first + 5, 1.0)]
        });
        let (puv, wuv) = largest(&mut mixed.into_iter());
        // Derivatives of cubics are three times their differences, second ones six; mixed ones nine.
        let [pu, wu, pv, wv] = [pu, wu, pv, wv].map(|value| 3.0 * value);
        let [puu, wuu, pvv, wvv] = [puu, wuu, pvv, wvv].map(|value| 6.0 * value);
        let [puv, wuv] = [puv, wuv].map(|value| 9.0 * value);
        let least = (0..16).map(weight).fold(f64::INFINITY, f64::min);
        let radius = (0..16).map(|number| place(number).distance(middle)).fold(0.0, f64::max);
        // S = P / w: S_u = (P_u − S·w_u) / w, S_uv = (P_uv − S_u·w_v − S_v·w_u − S·w_uv) / w.
        let (su, sv) = ((pu + radius * wu) / least, (pv + radius * wv) / least);
        Self {
            uu: (puu + 2.0 * su * wu + radius * wuu) / least,
            uv: (puv + su * wv + sv * wu + radius * wuv) / least,
            vv: (pvv + 2.0 * sv * wv + radius * wvv) / least,
        }
    }

    /// How far triangles are from the patch at most, if its map has `level`: triangles that close gaps beside finer
    /// edges are no longer than a segment.
    fn error(&self, level: u8) -> f64 {
        let step = 1.0 / f64::from((2u32 << level) - 1);
        0.125 * step * step * (self.uu + 2.0 * self.uv + self.vv)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Place;
    use crate::bezier::MAX_LEVEL;

    fn random(seed: u64) -> impl FnMut() -> f32 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f32 / (1 << 24) as f32
        }
    }

    /// A row of patches that share edges, each with more relief than the one before.
    fn strip(count: usize, rational: bool, seed: u64) -> BezierSurface {
        let mut random = random(seed);
        let width = 3 * count + 1;
        let points: Vec<[f32; 3]> = (0..4 * width)
            .map(|at| {
                let (x, y) = ((at % width) as f32, (at / width) as f32);
                [x + 0.3 * random(), y + 0.3 * random(), (random() - 0.5) * x * x * 0.02]
            })
            .collect();
        let weights: Vec<f32> = points.iter().map(|_| 0.5 + 2.0 * random()).collect();
        let indices: Vec<u32> =
            (0..count).flat_map(|patch| (0..16).map(move |at| (at / 4 * width + 3 * patch + at % 4) as u32)).collect();
        let weights = rational.then_some(&weights[..]);
        BezierSurface::new(&Context::serial(), &points, Some(&indices), weights).unwrap()
    }

    #[test]
    fn errors_are_bounds_of_what_is_measured() {
        for (rational, seed) in [(false, 1), (true, 2), (true, 3)] {
            let surface = strip(3, rational, seed);
            for patch in 0..3 {
                for level in 1..=3u8 {
                    let bound = Curvature::new(surface.controls(patch)).error(level);
                    let map = ParametricMap::new(u32::from(level)).unwrap();
                    let at = |u: f32, v: f32| {
                        DVec3::from(surface.evaluate(Place::new(patch as u32, u, v)).unwrap().0.p.map(f64::from))
                    };
                    let mut largest = 0.0f64;
                    for j in 0..map.segments() {
                        for i in 0..map.segments() {
                            let [u0, u1] = [map.parameter(i), map.parameter(i + 1)];
                            let [v0, v1] = [map.parameter(j), map.parameter(j + 1)];
                            // The middle of the diagonal, where both triangles are farthest.
                            let flat = 0.5 * (at(u1, v0) + at(u0, v1));
                            largest = largest.max(flat.distance(at(0.5 * (u0 + u1), 0.5 * (v0 + v1))));
                        }
                    }
                    assert!(largest <= bound, "patch {patch}, level {level}: {largest} above {bound}");
                    assert!(rational || largest > 0.02 * bound, "{largest} far below {bound}");
                }
            }
        }
    }

    #[test]
    fn edges_have_one_level_on_both_sides() {
        let surface = strip(4, false, 5);
        let levels = Levels::new(&surface, vec![1, 4, 2, 8]).unwrap();
        assert_eq!((levels.edges(0), levels.edges(1)), ([1, 4, 1, 1], [4, 4, 4, 4]));
        assert_eq!((levels.edges(2), levels.edges(3)), ([2, 8, 2, 4], [8, 8, 8, 8]));
        assert!(Levels::new(&surface, vec![1; 3]).is_err());
        assert!(Levels::new(&surface, vec![1, 2, 0, 4]).is_err());
        assert!(Levels::uniform(&surface, 9).is_err());
    }

    #[test]
    fn levels_follow_relief_distance_and_tolerance() {
        let context = Context::serial();
        let surface = strip(6, false, 9);
        let seen = |distance: f64, tolerance: f64| {
            let view = Viewpoint { eye: [9.0, 1.5, distance], forward: [0.0, 0.0, -1.0], pixels: 800.0, corner: 0.6 };
            Levels::select(&context, &surface, &view, tolerance, MAX_LEVEL).unwrap()
        };
        let far = seen(400.0, 1.0);
        let near = seen(40.0, 1.0);
        let sharp = seen(40.0, 0.1);
        for patch in 0..6 {
            assert!(far.patch(patch) <= near.patch(patch) && near.patch(patch) <= sharp.patch(patch));
        }
        assert!(near.patch(0) < near.patch(5) && near != sharp);
        for (distance, tolerance, levels) in [(400.0, 1.0, far), (40.0, 1.0, near), (40.0, 0.1, sharp)] {
            for patch in 0..6 {
                let level = levels.patch(patch);
                assert!(levels.edges(patch).iter().all(|edge| *edge >= level));
                let nearest = distance - f64::from(surface.bounds(patch).1[2]);
                let pixels = |level: u32| {
                    let error = Curvature::new(surface.controls(patch)).error(level as u8);
                    error * 800.0 * 1.36f64.sqrt() / (nearest - error)
                };
                assert!(pixels(level) <= tolerance * 1.000001 || level == MAX_LEVEL, "{patch}: {}", pixels(level));
                // No neighbour made it finer than it has to be.
                assert!(level == 1 || pixels(level - 1) > tolerance, "{patch}: {}", pixels(level - 1));
            }
        }
        let behind = Viewpoint { eye: [9.0, 1.5, -100.0], forward: [0.0, 0.0, -1.0], pixels: 800.0, corner: 0.6 };
        assert_eq!(Levels::select(&context, &surface, &behind, 1.0, 3).unwrap(), Levels::uniform(&surface, 3).unwrap());
        assert!(Levels::select(&context, &surface, &behind, 0.0, 3).is_err());
    }
}
