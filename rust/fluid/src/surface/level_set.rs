//! Level sets: distances to the mesh of a surface in a narrow band of voxels around it, with the sign of the surface's
//! function.

use glam::Vec3;
use relievo_core::{Context, Error, Mesh, Progress, Result};

use crate::Surface;
use crate::source::solid::nearest;

/// Voxels along an edge of a block.
pub const BLOCK: usize = 8;
/// A block of voxels: its lowest voxel, of multiples of 8, and its values, z fastest and x slowest.
pub type Block = ([i32; 3], Box<[f32; BLOCK * BLOCK * BLOCK]>);

/// The band on either side, in voxels: what others take level sets to have.
const BAND: f32 = 3.0;
/// Bits of a coordinate of a block, and what makes it positive.
const BITS: u32 = 20;
const OFFSET: i64 = 1 << (BITS - 1);

/// Distances to a surface in metres, negative inside, on a lattice of voxels: voxel (i, j, k) is at (i, j, k) times its size.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelSet {
    /// Edge of a voxel in metres.
    pub voxel: f32,
    /// Distances are known up to so many metres; beyond, values are this number or minus it.
    pub band: f32,
    /// Blocks that the band touches, sorted, each once.
    pub blocks: Vec<Block>,
}

/// The level set of a surface in voxels of a size in metres, from its mesh, as [`crate::mesh`] makes it and not smoothed.
///
/// # Errors
/// Fails if the size is not positive, if a voxel is more than 2²² voxels from 0, if the memory limit is not enough, or
/// where `progress` asks to stop.
pub fn level_set(
    context: &Context,
    surface: &Surface,
    mesh: &Mesh,
    voxel: f32,
    progress: &mut dyn Progress,
) -> Result<LevelSet> {
    if !(voxel.is_finite() && voxel > 0.0) {
        return Err(Error::invalid(format!("voxels of {voxel} m cannot be")));
    }
    let _stage = context.stats().begin("isosurface.level_set");
    let triangles = mesh.triangles();
    let corners = |triangle: usize| triangles[triangle].map(|point| Vec3::from(mesh.points[point as usize]));
    let pairs = pairs(context, triangles.len(), &corners, voxel)?;
    let mut starts: Vec<usize> = (0..pairs.len()).filter(|at| *at == 0 || pairs[*at - 1].0 != pairs[*at].0).collect();
    let bytes = starts.len() as u64 * (size_of::<Block>() + 4 * BLOCK.pow(3)) as u64;
    if bytes.saturating_add(pairs.len() as u64 * 16) > context.memory_limit() {
        return Err(Error::memory(format!("voxels of {voxel} m need {bytes} bytes"))
            .advise("use larger ones, or raise the memory limit"));
    }
    starts.push(pairs.len());
    let band = BAND * voxel;
    let blocks = context.map_watched(starts.len() - 1, progress, ("distances", [0.0, 1.0]), |at| {
        let pairs = &pairs[starts[at]..starts[at + 1]];
        let origin = origin(pairs[0].0);
        let mut squares = Box::new([band * band; BLOCK * BLOCK * BLOCK]);
        for (_, triangle) in pairs {
            measure(&mut squares, origin, corners(*triangle as usize), voxel, band);
        }
        if squares.iter().all(|square| *square >= band * band) {
            return None;
        }
        let mut probe = surface.probe(context);
        for (at, value) in squares.iter_mut().enumerate() {
            let inside = probe.sample(place(origin, at, voxel).to_array()).value > 0.0;
            let distance = value.sqrt();
            *value = if inside { -distance } else { distance };
        }
        Some((origin, squares))
    })?;
    Ok(LevelSet { voxel, band, blocks: blocks.into_iter().flatten().collect() })
}

/// Blocks that the band around a triangle may touch, with the triangle, sorted.
fn pairs(
    context: &Context,
    count: usize,
    corners: &(impl Fn(usize) -> [Vec3; 3] + Sync),
    voxel: f32,
) -> Result<Vec<(u64, u32)>> {
    let edge = f64::from(voxel) * BLOCK as f64;
    let reach = f64::from(BAND * voxel);
    let ranges = |triangle: usize| {
        let [a, b, c] = corners(triangle);
        let (low, high) = (a.min(b).min(c).as_dvec3() - reach, a.max(b).max(c).as_dvec3() + reach);
        // Voxels lie at the lower corners of their cells.
        let [low, high] = [low, high].map(|at| (at / edge).floor().as_i64vec3());
        let is_near = low.min_element() >= -OFFSET && high.max_element() < OFFSET;
        is_near.then(|| [0, 1, 2].map(|axis| low[axis]..=high[axis]))
    };
    let counts = context.map(count, |triangle| {
        Some(ranges(triangle)?.iter().map(|range| (range.end() - range.start() + 1) as u64).product::<u64>())
    });
    let total = counts.into_iter().try_fold(0u64, |total, count| Some(total.saturating_add(count?)));
    let Some(total) = total else {
        return Err(Error::invalid(format!("the surface is more than 2²² voxels of {voxel} m from 0"))
            .advise("use larger voxels, or move the particles"));
    };
    // Lists, and all of them together.
    if total.saturating_mul(2 * size_of::<(u64, u32)>() as u64) > context.memory_limit() {
        return Err(Error::memory(format!("voxels of {voxel} m are near triangles {total} times"))
            .advise("use larger ones, or raise the memory limit"));
    }
    let lists = context.map(count, |triangle| {
        let Some([xs, ys, zs]) = ranges(triangle) else { return Vec::new() };
        let places = xs.flat_map(|x| ys.clone().map(move |y| (x, y)));
        let places = places.flat_map(|(x, y)| zs.clone().map(move |z| [x, y, z]));
        places.map(|block| (key(block), triangle as u32)).collect()
    });
    let mut pairs = lists.concat();
    pairs.sort_unstable();
    Ok(pairs)
}

/// A block as a number, in the order of places.
fn key(block: [i64; 3]) -> u64 {
    block.iter().fold(0, |key, at| key << BITS | (at + OFFSET) as u64)
}

/// The lowest voxel of a block.
fn origin(key: u64) -> [i32; 3] {
    let at = |shift: u32| ((key >> shift & ((1 << BITS) - 1)) as i64 - OFFSET) as i32 * BLOCK as i32;
    [at(2 * BITS), at(BITS), at(0)]
}

/// Where voxel `at` of a block is, in metres.
fn place(origin: [i32; 3], at: usize, voxel: f32) -> Vec3 {
    let steps = [at / (BLOCK * BLOCK), at / BLOCK % BLOCK, at % BLOCK];
    Vec3::from([0, 1, 2].map(|axis| (f64::from(origin[axis] + steps[axis] as i32) * f64::from(voxel)) as f32))
}

/// Lowers the squared distances of a block to those from a triangle.
fn measure(squares: &mut [f32; BLOCK * BLOCK * BLOCK], origin: [i32; 3], corners: [Vec3; 3], voxel: f32, band: f32) {
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c) - band, a.max(b).max(c) + band);
    let range = |axis: usize| {
        let within = |at: f32| (at / voxel - origin[axis] as f32).clamp(0.0, BLOCK as f32);
        within(low[axis]).floor() as usize..within(high[axis] + voxel).ceil() as usize
    };
    let [xs, ys, zs] = [range(0), range(1), range(2)];
    for x in xs {
        for y in ys.clone() {
            for z in zs.clone() {
                let at = (x * BLOCK + y) * BLOCK + z;
                let place = place(origin, at, voxel);
                // Of a triangle without an area it may be no number, which counts for nothing.
                squares[at] = squares[at].min(nearest(corners.map(|corner| corner - place)).length_squared());
            }
        }
    }
}
