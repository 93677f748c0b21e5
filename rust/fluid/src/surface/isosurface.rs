//! Meshes of surface functions by marching cubes (Lorensen, Cline 1987), in blocks of cells: only blocks that particles
//! reach are looked at, so memory grows with the particles and not with the box.
//!
//! Corners of cells are at multiples of the cell size, so that the mesh of what is at rest does not flicker. Meshes are
//! welded, watertight and manifold, their front is outside, and they do not depend on the number of threads.

use std::ops::Range;

use relievo_core::{Attribute, Context, Domain, Error, Mesh, Progress, Result, Values};

use crate::surface::Surface;
use crate::surface::block::{Block, CELLS, FOREIGN, Part};

/// Blocks that are made before their meshes are put together.
const BATCH: usize = 128;
/// Cells of a search row of one task.
const CHUNK_LEN: usize = 1024;
/// Blocks at most, with blocks that are met more than once.
const MAX_BLOCKS: u64 = 1 << 28;
/// Cells from 0 at most: coordinates are then exact to a sixteenth of a cell.
const FARTHEST: f64 = 1_048_576.0;
/// Cells of a support radius at most.
const FINEST: f32 = 128.0;

/// Values of particles that vertices get the weighted mean of, such as their velocities.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'a> {
    /// The name of the attribute.
    pub name: &'a str,
    /// Numbers per particle, 1 to 4.
    pub width: usize,
    /// The numbers, particle after particle.
    pub values: &'a [f32],
}

/// The mesh of a surface, of cells of a size in metres: triangles with the attribute `normal` from the gradient, and
/// one for each channel, whose values are means by the particles' weights. Without particles it has no faces.
///
/// # Errors
/// Fails if the cell size is not between 1/128 of the support radius and all of it, if a coordinate is more than
/// 1,048,576 cells from 0, if a channel has no name of its own, not 1 to 4 numbers for each particle, or one that is
/// not finite, if the memory limit of the context or 2³¹ vertices would be exceeded, or where `progress` asks to stop.
pub fn mesh(
    context: &Context,
    surface: &Surface,
    cell: f32,
    channels: &[Channel<'_>],
    progress: &mut dyn Progress,
) -> Result<Mesh> {
    for channel in channels {
        check(channel, surface.len())?;
    }
    let mut stage = context.stats().begin("isosurface.mesh");
    let blocks = Blocks::new(context, surface, cell)?;
    let mut made = Made::new(&blocks, channels.len());
    for first in (0..blocks.keys.len()).step_by(BATCH) {
        progress.step(first as f32 / blocks.keys.len() as f32, "surface")?;
        let count = BATCH.min(blocks.keys.len() - first);
        let parts = context.map(count, |at| {
            let mut block = context.scratch().lend::<Block>();
            block.make(&mut surface.probe(context), blocks.low(first + at), cell, Some(channels))
        });
        for (at, part) in parts.into_iter().enumerate() {
            made.add(first + at, part, context.memory_limit())?;
        }
    }
    stage.count("blocks", blocks.keys.len() as u64);
    stage.count("triangles", made.corners.len() as u64 / 3);
    made.finish(context, channels)
}

/// Vertices of the mesh of a surface, in the same order and with the same errors.
pub(crate) fn vertices(
    context: &Context,
    surface: &Surface,
    cell: f32,
    progress: &mut dyn Progress,
) -> Result<Vec<[f32; 3]>> {
    let blocks = Blocks::new(context, surface, cell)?;
    let mut points = Vec::new();
    for first in (0..blocks.keys.len()).step_by(BATCH) {
        progress.step(first as f32 / blocks.keys.len() as f32, "surface")?;
        let parts = context.map(BATCH.min(blocks.keys.len() - first), |at| {
            let mut block = context.scratch().lend::<Block>();
            block.make(&mut surface.probe(context), blocks.low(first + at), cell, None).points
        });
        let bytes = 12 * (points.len() + parts.iter().map(Vec::len).sum::<usize>()) as u64;
        if bytes > context.memory_limit() {
            return Err(Error::memory(format!("the surface needs more than {bytes} bytes"))
                .advise("use larger cells, or raise the memory limit"));
        }
        points.extend(parts.into_iter().flatten());
    }
    Ok(points)
}

fn check(channel: &Channel<'_>, particles: usize) -> Result<()> {
    let place = || format!("channel `{}`", channel.name);
    if !(1..=4).contains(&channel.width) || channel.name == "normal" {
        return Err(Error::invalid("it has no name of its own, or not 1 to 4 numbers a particle").at(place()));
    }
    if channel.values.len() != particles * channel.width {
        let count = channel.values.len();
        return Err(Error::invalid(format!("it has {count} numbers for {particles} particles"))
            .at(place())
            .advise(format!("give {} numbers for each", channel.width)));
    }
    match channel.values.iter().position(|value| !value.is_finite()) {
        Some(at) => Err(Error::invalid("a number is not finite")
            .at(format!("{}, particle {}", place(), at / channel.width))
            .advise("repair the value, or leave the channel out")),
        None => Ok(()),
    }
}

/// The blocks that particles reach.
struct Blocks {
    /// Coordinates of blocks as one number, rising.
    keys: Vec<u64>,
}

/// Bits of a coordinate of a block, and what makes it positive.
const BITS: u32 = 20;
const OFFSET: i64 = 1 << (BITS - 1);

fn key([x, y, z]: [i64; 3]) -> u64 {
    let [x, y, z] = [x, y, z].map(|at| (at + OFFSET) as u64);
    (z << BITS | y) << BITS | x
}

impl Blocks {
    /// Fails as [`mesh`] does.
    fn new(context: &Context, surface: &Surface, cell: f32) -> Result<Self> {
        let support = surface.function().support();
        if !(cell * FINEST >= support && cell <= support) {
            return Err(Error::invalid(format!("the cell size is {cell} at a support radius of {support}"))
                .advise(format!("use {} to {support}", support / FINEST)));
        }
        let edge = f64::from(cell) * CELLS as f64;
        let reach = f64::from(surface.reach) * 1.001 + 0.25 * f64::from(cell);
        // Blocks that the particles of a cell of the search reach.
        let reached = |number: usize| -> [Range<i64>; 3] {
            std::array::from_fn(|axis| {
                let centres = &surface.centres[axis][surface.rows.particles(number)];
                let low = centres.iter().copied().fold(f32::INFINITY, f32::min);
                let high = centres.iter().copied().fold(f32::NEG_INFINITY, f32::max);
                let block = |at: f64| (at / edge).floor() as i64;
                block(f64::from(low) - reach)..block(f64::from(high) + reach).saturating_add(1)
            })
        };
        let tasks = surface.rows.len().div_ceil(CHUNK_LEN);
        let cells = |task: usize| task * CHUNK_LEN..((task + 1) * CHUNK_LEN).min(surface.rows.len());
        let farthest = FARTHEST as i64 / CELLS as i64;
        let counts = context.map(tasks, |task| {
            let count = cells(task).map(|number| {
                let blocks = reached(number);
                let near = blocks.iter().all(|range| range.start >= -farthest && range.end <= farthest);
                near.then(|| blocks.iter().map(|range| (range.end - range.start) as u64).product::<u64>())
            });
            count.sum::<Option<u64>>()
        });
        let total = counts.into_iter().try_fold(0u64, |total, count| Some(total.saturating_add(count?)));
        let Some(total) = total else {
            return Err(Error::invalid(format!("particles are more than {FARTHEST} cells of {cell} from 0"))
                .advise("move them nearer to 0, or use larger cells"));
        };
        if total > MAX_BLOCKS || total.saturating_mul(16) > context.memory_limit() {
            return Err(Error::memory(format!("cells of {cell} need {total} blocks of {CELLS}³ cells"))
                .advise("use larger cells, or raise the memory limit"));
        }
        let lists = context.map(tasks, |task| {
            let mut keys = Vec::new();
            for number in cells(task) {
                let [xs, ys, zs] = reached(number);
                for (z, y) in zs.flat_map(|z| ys.clone().map(move |y| (z, y))) {
                    keys.extend(xs.clone().map(|x| key([x, y, z])));
                }
            }
            keys.sort_unstable();
            keys.dedup();
            keys
        });
        let mut keys = lists.concat();
        keys.sort_unstable();
        keys.dedup();
        Ok(Self { keys })
    }

    fn coordinates(&self, number: usize) -> [i64; 3] {
        let key = self.keys[number];
        [key, key >> BITS, key >> (2 * BITS)].map(|at| (at & ((1 << BITS) - 1)) as i64 - OFFSET)
    }

    /// The cell at the lower corner of a block.
    fn low(&self, number: usize) -> [i64; 3] {
        self.coordinates(number).map(|at| at * CELLS as i64)
    }

    /// The block some steps from another. Blocks that share a vertex both have particles that reach it.
    fn beside(&self, number: usize, steps: [u8; 3]) -> Option<usize> {
        let [x, y, z] = self.coordinates(number);
        let beside = key([x + i64::from(steps[0]), y + i64::from(steps[1]), z + i64::from(steps[2])]);
        self.keys[number..].binary_search(&beside).ok().map(|at| number + at)
    }
}

/// What was put together so far.
struct Made<'a> {
    blocks: &'a Blocks,
    points: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    channels: Vec<Vec<f32>>,
    corners: Vec<u32>,
    /// Vertices that others use, as codes and numbers, block after block.
    shared: Vec<(u16, u32)>,
    /// The first of these of every block.
    starts: Vec<u32>,
    /// Vertices of other blocks, by block and code.
    foreign: Vec<(u32, u16)>,
}

impl<'a> Made<'a> {
    fn new(blocks: &'a Blocks, channels: usize) -> Self {
        Self {
            blocks,
            points: Vec::new(),
            normals: Vec::new(),
            channels: vec![Vec::new(); channels],
            corners: Vec::new(),
            shared: Vec::new(),
            starts: vec![0],
            foreign: Vec::new(),
        }
    }

    fn add(&mut self, number: usize, part: Part, limit: u64) -> Result<()> {
        let first = self.points.len() as u32;
        let floats: usize = self.channels.iter().zip(&part.channels).map(|(all, part)| all.len() + part.len()).sum();
        let bytes = 24 * (self.points.len() + part.points.len()) + 4 * floats;
        // Corners, and the size of each face.
        let bytes = bytes as u64 + 16 * (self.corners.len() + part.corners.len()) as u64 / 3;
        let many = self.points.len() + part.points.len() + self.foreign.len() + part.foreign.len();
        if bytes > limit || many >= FOREIGN as usize || self.corners.len() + part.corners.len() > u32::MAX as usize {
            return Err(Error::memory(format!("the mesh needs more than {bytes} bytes or 2^31 vertices"))
                .advise("use larger cells, or raise the memory limit"));
        }
        let offset = self.foreign.len() as u32;
        // The flag of vertices of other blocks stays, since neither sum reaches it.
        let renumber = |at: u32| if at & FOREIGN == 0 { at + first } else { at + offset };
        self.corners.extend(part.corners.into_iter().map(renumber));
        self.points.extend(part.points);
        self.normals.extend(part.normals);
        for (all, part) in self.channels.iter_mut().zip(part.channels) {
            all.extend(part);
        }
        self.shared.extend(part.shared.into_iter().map(|(code, at)| (code, at + first)));
        self.starts.push(self.shared.len() as u32);
        for foreign in part.foreign {
            let Some(owner) = self.blocks.beside(number, foreign.steps) else {
                return Err(Error::internal("a block beside another is missing"));
            };
            self.foreign.push((owner as u32, foreign.code));
        }
        Ok(())
    }

    fn finish(self, context: &Context, channels: &[Channel<'_>]) -> Result<Mesh> {
        let Self { points, normals, channels: values, mut corners, shared, starts, foreign, .. } = self;
        let found = context.map(foreign.len(), |at| {
            let (owner, code) = foreign[at];
            let shared = &shared[starts[owner as usize] as usize..starts[owner as usize + 1] as usize];
            shared.binary_search_by_key(&code, |(code, _)| *code).map(|at| shared[at].1).ok()
        });
        context.for_each_part(corners.as_mut_slice(), 1 << 16, |_, corners| {
            for corner in corners.iter_mut().filter(|corner| **corner & FOREIGN != 0) {
                let Some(vertex) = found[(*corner & !FOREIGN) as usize] else {
                    return Err(Error::internal("two blocks do not agree on the edge between them"));
                };
                *corner = vertex;
            }
            Ok(())
        })?;
        let faces = corners.len() / 3;
        let mut mesh = Mesh::new(points, vec![3; faces], corners);
        let normal = ("normal", 3, normals.into_flattened());
        let named = channels.iter().zip(values).map(|(channel, values)| (channel.name, channel.width, values));
        for (name, width, values) in std::iter::once(normal).chain(named) {
            mesh.attributes.push(Attribute {
                name: name.to_owned(),
                domain: Domain::Point,
                width: width as u32,
                values: Values::F32(values),
                indices: None,
            });
        }
        Ok(mesh)
    }
}
