//! Pass 6, first part: ambient occlusion in screen space, in passes of growing search radii (Akinci et al. 2013,
//! Section 2.4.1, after Mittring 2007).

use std::f32::consts::PI;

use glam::Vec3;
use relievo_core::lanes::Lanes;
use relievo_core::{Context, Progress, Result, dispatch_simd};

use super::depth::normal;
use super::halton::Ball;
use super::layers::Shading;
use super::settings::FoamSettings;

/// Lanes of the widest vectors.
const WIDEST: usize = 16;

/// Finds the occlusion of pixels.
struct Search<'a> {
    of: &'a Shading<'a>,
    ball: Ball,
    /// Coordinates and weights of the samples, whose lanes fill whole vectors.
    samples: [Vec<f32>; 4],
    /// Their numbers.
    numbers: Vec<u32>,
    fronts: Fronts,
}

/// What may occlude in every pixel: depth and intensity of the foam, depth of the fluid and of solids. All that a sample looks
/// up is in one place of memory.
struct Fronts {
    /// Entries of a row: an odd number of cache lines, so that the rows about a pixel do not share few sets of the cache.
    stride: usize,
    entries: Vec<[f32; 4]>,
    /// Whether there are a fluid or solids.
    has_scenery: bool,
}

impl Fronts {
    fn new(context: &Context, of: &Shading<'_>) -> Self {
        let (width, height) = (of.view.width as usize, of.view.height as usize);
        let stride = width.next_multiple_of(16) + 4;
        let mut entries = vec![[0.0; 4]; stride * height];
        context.for_each_mut(&mut entries.chunks_mut(stride).collect::<Vec<_>>(), |y, row| {
            for (at, entry) in (y * width..(y + 1) * width).zip(row.iter_mut()) {
                *entry = [of.surfaces.depth[at], of.intensity[at], of.depths.fluid[at], of.depths.solids[at]];
            }
        });
        let has_scenery = [&of.depths.fluid, &of.depths.solids].iter().any(|list| list.iter().any(|it| it.is_finite()));
        Self { stride, entries, has_scenery }
    }
}

/// Returns the occlusion ω of every pixel, 0 where there is no foam. Fails if `progress` asks to stop.
pub fn occlusion(context: &Context, of: &Shading<'_>, progress: &mut dyn Progress) -> Result<Vec<f32>> {
    let ball = Ball::new(of.settings.ao_max_samp.max(of.settings.ao_min_samp));
    let samples = ball.columns(WIDEST);
    let numbers = (0..samples[0].len() as u32).collect();
    let search = Search { of, ball, samples, numbers, fronts: Fronts::new(context, of) };
    let width = of.view.width as usize;
    let rows = context.map_watched(of.view.height as usize, progress, ("occlusion of foam", [0.0, 1.0]), |y| {
        let mut row = vec![0.0; width];
        of_row(context.level(), &search, y, &mut row);
        row
    })?;
    Ok(rows.concat())
}

dispatch_simd! { fn of_row = row_body(search: &Search<'_>, y: usize, out: &mut [f32]) }

#[inline(always)]
fn row_body<A: Lanes>(lanes: A, search: &Search<'_>, y: usize, out: &mut [f32]) {
    for (x, occlusion) in out.iter_mut().enumerate() {
        if search.of.intensity[y * search.of.view.width as usize + x] > 0.0 {
            *occlusion = search.of_pixel(lanes, x, y);
        }
    }
}

/// A place in eye space of which the surroundings are searched.
struct Place {
    at: Vec3,
    /// Outwards from the foam, or no direction where samples lie on both sides.
    outward: Vec3,
}

impl Search<'_> {
    #[inline(always)]
    fn of_pixel<A: Lanes>(&self, lanes: A, x: usize, y: usize) -> f32 {
        let at = y * self.of.view.width as usize + x;
        let (depth, search) = (self.of.surfaces.depth[at], self.of.surfaces.search[at]);
        let [u, v] = self.of.surfaces.disc[at];
        // In eye space depth grows away from the camera.
        let is_half = self.of.settings.ao_hemisphere.is_on();
        let outward = if is_half { normal(u, v) * Vec3::new(1.0, 1.0, -1.0) } else { Vec3::ZERO };
        let place = Place { at: self.of.projection.from_picture(x as f32 + 0.5, y as f32 + 0.5, depth), outward };
        let metres = self.of.projection.scale(depth).recip();
        let mut sums = [lanes.splat(0.0); 2];
        for pass in 0..self.of.settings.ao_passes {
            let radius = search * (self.of.settings.ao_init_sr_fac + self.of.settings.ao_sr_inc_fac * pass as f32);
            let count = self.ball.count(samples(self.of.settings, radius));
            sums = self.add(lanes, &place, radius * metres, count, sums);
        }
        let (sum, weights) = (lanes.sum(sums[0]), lanes.sum(sums[1]));
        if weights > 0.0 { sum / weights } else { 0.0 }
    }

    /// Adds the samples within a radius in metres to the sums of λ·δ·k·a and of λ. A vector has a sample in each lane.
    #[inline(always)]
    fn add<A: Lanes>(&self, lanes: A, place: &Place, radius: f32, count: usize, sums: [A::F; 2]) -> [A::F; 2] {
        let Shading { settings, view, projection, .. } = *self.of;
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        let [x, y, z] = [lanes.splat(place.at.x), lanes.splat(place.at.y), lanes.splat(place.at.z)];
        let outward = [lanes.splat(place.outward.x), lanes.splat(place.outward.y), lanes.splat(place.outward.z)];
        let (radius, mirrored) = (lanes.splat(radius), lanes.splat(-radius));
        let middle = [lanes.splat(projection.middle.x), lanes.splat(projection.middle.y)];
        let scale = lanes.splat(projection.scale);
        let size = [lanes.splat(view.width as f32), lanes.splat(view.height as f32)];
        let falling = lanes.splat(-settings.ao_max_occl_dist.recip());
        let fluid_opacity = lanes.splat(settings.ao_fluid_opacity);
        let solid_opacity = lanes.splat(settings.ao_solid_opacity);
        let (stride, end) = (lanes.isplat(self.fronts.stride as i32), lanes.isplat(count as i32));
        let [mut sum, mut weights] = sums;
        let mut indices = [0; WIDEST];
        for first in (0..count).step_by(A::WIDTH) {
            let across = lanes.load(&self.samples[0][first..]);
            let up = lanes.load(&self.samples[1][first..]);
            let along = lanes.load(&self.samples[2][first..]);
            let weight = lanes.load(&self.samples[3][first..]);
            let is_one = lanes.ilt(lanes.iload(&self.numbers[first..]), end);
            let cosine = lanes.fused(across, outward[0], lanes.fused(up, outward[1], lanes.mul(along, outward[2])));
            let factor = lanes.select(lanes.lt(cosine, zero), mirrored, radius);
            let depth = lanes.fused(factor, along, z);
            let pixels = if projection.is_parallel { scale } else { lanes.div(scale, depth) };
            let column = lanes.fused(pixels, lanes.fused(factor, across, x), middle[0]);
            let row = lanes.sub(middle[1], lanes.mul(pixels, lanes.fused(factor, up, y)));
            let is_before = lanes.both(lanes.both(lanes.le(zero, column), lanes.le(zero, row)), lanes.lt(zero, depth));
            let is_within = lanes.both(lanes.lt(column, size[0]), lanes.lt(row, size[1]));
            let is_shown = lanes.both(is_one, lanes.both(is_before, is_within));
            let index = lanes.iadd(lanes.imul(lanes.trunc(row), stride), lanes.trunc(column));
            lanes.istore(lanes.iselect(is_shown, index, lanes.isplat(0)), &mut indices);
            let [foam, intensity, fluid, solid] = lanes.gather_rows(&self.fronts.entries, &indices);
            let mut occluded = share(lanes, depth, foam, intensity, falling);
            if self.fronts.has_scenery {
                occluded = lanes.add(occluded, share(lanes, depth, fluid, fluid_opacity, falling));
                occluded = lanes.add(occluded, share(lanes, depth, solid, solid_opacity, falling));
            }
            let weight = lanes.select(is_shown, weight, zero);
            weights = lanes.add(weights, weight);
            sum = lanes.fused(weight, lanes.min(occluded, one), sum);
        }
        [sum, weights]
    }
}

/// Returns δ·k·a of samples at depths of what has another depth in their pixels. `falling` is −1 over the distance beyond which
/// nothing occludes.
#[inline(always)]
fn share<A: Lanes>(lanes: A, depth: A::F, front: A::F, opacity: A::F, falling: A::F) -> A::F {
    let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
    let near = lanes.max(lanes.fused(lanes.sub(depth, front), falling, one), zero);
    lanes.select(lanes.lt(front, depth), lanes.mul(lanes.mul(near, near), opacity), zero)
}

/// Returns the number ν of samples in the cube for a search radius in pixels.
pub fn samples(settings: &FoamSettings, radius: f32) -> u32 {
    let count = 0.75 * PI * radius.powi(3) * settings.ao_s_dens;
    // A limit below the other gives way.
    (count.min(4e9) as u32).min(settings.ao_max_samp).max(settings.ao_min_samp)
}

/// Returns the shadow ζ of an occlusion ω, 0 to 1.
pub fn shadow(settings: &FoamSettings, occlusion: f32) -> f32 {
    let scaled = (occlusion * settings.ao_sh_scale).powf(settings.ao_sh_exp);
    (scaled + settings.ao_sh_offset).clamp(0.0, 1.0)
}
