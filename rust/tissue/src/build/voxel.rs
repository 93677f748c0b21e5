//! Voxels by rays (Section 4.1, Figures 3 to 5): shares of volumes, materials and muscles from samples on lines.
//!
//! A ray along z tests a line of samples against one volume: its crossings with the surface, each with its direction, bound
//! the stretches in which the winding number is positive. A ray that leaves a volume other than it came is cast again
//! beside it.

use glam::{DVec3, Vec3};
use relievo_core::{Context, Error, Progress, Result};
use relievo_embree::{Device, Ray, Scene, Tracer};

use crate::build::volume::{Depth, Description, Volume};

/// Rays that are traced together.
const PACKET: usize = 8;
/// How often a ray is cast anew beside itself.
const TRIES: usize = 8;

/// The grid of voxels around all volumes of level 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    pub low: Vec3,
    pub cell: Vec3,
    pub counts: [usize; 3],
}

/// What the samples of a voxel are in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Voxel {
    pub at: [u32; 3],
    /// Share of samples inside, 0 to 1.
    pub share: f32,
    /// Materials with their shares of the samples inside.
    pub materials: Vec<(u32, f32)>,
    /// Muscles by the number of the volume, with their shares and mean directions.
    pub muscles: Vec<(u32, f32, Vec3)>,
}

impl Grid {
    /// Fits a grid to the volumes of level 0. Fails if it would not fit the memory limit.
    pub fn new(description: &Description, limit: u64) -> Result<Self> {
        let top = description.volumes.iter().filter(|volume| volume.level == 0);
        let points = || top.clone().flat_map(|volume| &volume.shape.points).map(|point| Vec3::from(*point));
        let low = points().fold(Vec3::INFINITY, Vec3::min);
        let high = points().fold(Vec3::NEG_INFINITY, Vec3::max);
        let cell = Vec3::from(description.cell);
        // A border of rounding keeps faces that lie on the grid from adding a layer of voxels.
        let counts = ((high - low) / cell - 1e-4).ceil().max(Vec3::ONE);
        let all = counts.as_dvec3().element_product();
        // Numbers of nodes have 32 bits.
        if all * 64.0 > limit as f64 || all > f64::from(u32::MAX / 4) || counts.max_element() > 65_535.0 {
            return Err(Error::memory(format!(
                "a grid of {} × {} × {} voxels is too large",
                counts.x, counts.y, counts.z
            ))
            .at("voxel")
            .advise("take larger voxels, or raise the memory limit"));
        }
        let size = counts * cell;
        Ok(Self { low: 0.5 * (low + high) - 0.5 * size, cell, counts: counts.to_array().map(|count| count as usize) })
    }

    /// Returns the index of a voxel or node in a list of `counts` along the axes, x fastest.
    pub fn index(at: [usize; 3], counts: [usize; 3]) -> usize {
        (at[2] * counts[1] + at[1]) * counts[0] + at[0]
    }
}

/// What a sample in a combination of volumes belongs to.
struct Levels(Vec<u64>);

impl Levels {
    fn new(volumes: &[Volume]) -> Self {
        let deepest = volumes.iter().map(|volume| volume.level).max().unwrap_or(0).min(1000);
        let mask = |level: u32| {
            let bits = volumes.iter().enumerate().filter(|(_, volume)| volume.level == level);
            bits.fold(0u64, |mask, (bit, _)| mask | 1 << bit)
        };
        Self((0..=deepest).map(mask).collect())
    }

    /// Returns the volumes of the lowest level that the sample is in, with all levels above it; 0 outside.
    fn resolve(&self, mask: u64) -> u64 {
        let mut of = 0;
        for level in &self.0 {
            if mask & level == 0 {
                break;
            }
            of = mask & level;
        }
        of
    }
}

/// Samples the volumes of a description. Returns voxels with samples inside, column after column.
pub(crate) fn sample(
    context: &Context,
    description: &Description,
    grid: &Grid,
    depth: Option<&Depth>,
    progress: &mut dyn Progress,
) -> Result<Vec<Voxel>> {
    let mut scenes = Vec::with_capacity(description.volumes.len());
    let device = Device::new()?;
    for volume in &description.volumes {
        let named = |error: Error| error.at(format!("volume `{}`", volume.shape.name));
        let mut scene = Scene::new(&device)?;
        let object = scene.add_object()?;
        // Rays start at the grid, so that distances keep their precision.
        let points: Vec<[f32; 3]> =
            volume.shape.points.iter().map(|point| (Vec3::from(*point) - grid.low).to_array()).collect();
        scene.set_mesh(object, 0, &points, &volume.shape.triangles).map_err(named)?;
        scene.commit()?;
        scenes.push(scene);
    }
    let tracers = scenes.iter().map(Scene::tracer).collect::<Result<Vec<_>>>()?;
    let sampler = Sampler { description, grid, tracers, levels: Levels::new(&description.volumes), depth };
    let columns = grid.counts[0] * grid.counts[1];
    let voxels = context.map_watched(columns, progress, ("voxels", [0.0, 0.8]), |column| {
        sampler.column([column % grid.counts[0], column / grid.counts[0]])
    })?;
    let mut all = Vec::new();
    for column in voxels {
        all.extend(column?);
    }
    Ok(all)
}

struct Sampler<'a> {
    description: &'a Description,
    grid: &'a Grid,
    tracers: Vec<Tracer<'a>>,
    levels: Levels,
    depth: Option<&'a Depth>,
}

/// What is summed up over the samples of a voxel.
#[derive(Clone)]
struct Sums {
    inside: u32,
    materials: Vec<f32>,
    /// Weights and sums of directions of the muscles.
    muscles: Vec<(f32, Vec3)>,
    /// The depth of the middle, and the triangle of the skin that is closest.
    depth: Option<(f32, u32)>,
}

impl Sampler<'_> {
    /// The voxels of a column that have samples inside.
    fn column(&self, [x, y]: [usize; 2]) -> Result<Vec<Voxel>> {
        let (grid, samples) = (self.grid, self.description.samples as usize);
        let spacing = grid.cell / samples as f32;
        let rays: Vec<[f32; 2]> = (0..samples * samples)
            .map(|ray| {
                let at = [x * samples + ray % samples, y * samples + ray / samples];
                [(at[0] as f32 + 0.5) * spacing.x, (at[1] as f32 + 0.5) * spacing.y]
            })
            .collect();
        let lines = grid.counts[2] * samples;
        let mut masks = vec![0u64; rays.len() * lines];
        for (bit, tracer) in self.tracers.iter().enumerate() {
            for (packet, places) in rays.chunks(PACKET).enumerate() {
                let spans = self.spans(tracer, places, spacing, bit)?;
                for (ray, spans) in spans.iter().take(places.len()).enumerate() {
                    let line = &mut masks[(packet * PACKET + ray) * lines..][..lines];
                    for [from, to] in spans {
                        // Samples are in the middle of their spacing.
                        let sample = |z: f32| ((z / spacing.z - 0.5).ceil().max(0.0) as usize).min(lines);
                        let (from, to) = (sample(*from), sample(*to));
                        line[from..to.max(from)].iter_mut().for_each(|mask| *mask |= 1 << bit);
                    }
                }
            }
        }
        if masks.iter().all(|mask| *mask == 0) {
            return Ok(Vec::new());
        }
        let none = Sums {
            inside: 0,
            materials: vec![0.0; self.description.materials.len()],
            muscles: vec![(0.0, Vec3::ZERO); self.description.volumes.len()],
            depth: None,
        };
        let mut voxels = Vec::new();
        let mut near: Vec<Option<DVec3>> = vec![None; self.description.volumes.len()];
        for z in 0..grid.counts[2] {
            let mut sums = none.clone();
            let middle = grid.low + (Vec3::new(x as f32, y as f32, z as f32) + 0.5) * grid.cell;
            for (ray, place) in rays.iter().enumerate() {
                for sample in z * samples..(z + 1) * samples {
                    let of = self.levels.resolve(masks[ray * lines + sample]);
                    if of != 0 {
                        let place = grid.low + Vec3::new(place[0], place[1], (sample as f32 + 0.5) * spacing.z);
                        self.add(&mut sums, of, place, middle, &mut near);
                    }
                }
            }
            if sums.inside > 0 {
                voxels.push(finish(sums, [x, y, z], samples));
            }
        }
        Ok(voxels)
    }

    /// Adds a sample that is in volumes `of` (Equations 1 and 2).
    fn add(&self, sums: &mut Sums, of: u64, place: Vec3, middle: Vec3, near: &mut [Option<DVec3>]) {
        sums.inside += 1;
        let weight = 1.0 / of.count_ones() as f32;
        let mut rest = of;
        while rest != 0 {
            let number = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let volume = &self.description.volumes[number];
            if let Some((_, field)) = &volume.muscle {
                sums.muscles[number].0 += weight;
                sums.muscles[number].1 += field.direction(place, &mut near[number]);
            }
            let mut layers = 0;
            if let Some(skin) = self.depth.filter(|_| volume.has_layers) {
                let (depth, triangle) = *sums.depth.get_or_insert_with(|| skin.at(middle, None));
                let reach = 0.5 * self.grid.cell.length();
                let depth = if skin.is_mixed(depth, reach) { skin.at(place, Some(triangle)).0 } else { depth };
                layers = skin.layers(depth, |_| {});
                let part = weight / layers.max(1) as f32;
                skin.layers(depth, |material| sums.materials[material as usize] += part);
            }
            if layers == 0 {
                sums.materials[volume.material as usize] += weight;
            }
        }
    }

    /// The stretches of rays along z in which they are inside of a volume.
    fn spans(
        &self,
        tracer: &Tracer<'_>,
        places: &[[f32; 2]],
        spacing: Vec3,
        bit: usize,
    ) -> Result<[Vec<[f32; 2]>; PACKET]> {
        let height = self.grid.cell.z * self.grid.counts[2] as f32;
        let mut spans: [Vec<[f32; 2]>; PACKET] = Default::default();
        let mut open = [false; PACKET];
        open[..places.len()].fill(true);
        for shift in 0..TRIES {
            let shift = spacing * 1e-3 * shift as f32;
            let crossings = crossings(tracer, places, open, [shift.x, 0.618 * shift.y], height);
            for ray in 0..places.len() {
                if !open[ray] {
                    continue;
                }
                open[ray] = crossings[ray].iter().map(|crossing| crossing.1).sum::<i32>() != 0;
                if !open[ray] {
                    spans[ray] = inside(&crossings[ray]);
                }
            }
            if !open.contains(&true) {
                return Ok(spans);
            }
        }
        let ray = open.iter().position(|open| *open).unwrap_or(0);
        let [x, y] = places[ray];
        Err(Error::invalid("a ray along z leaves the surface other than it enters it")
            .at(format!(
                "volume `{}`, x = {}, y = {}",
                self.description.volumes[bit].shape.name,
                self.grid.low.x + x,
                self.grid.low.y + y
            ))
            .advise("repair the surface: `relievo mesh check FILE` lists its defects"))
    }
}

/// The crossings of rays with a surface in order: heights above the grid, and 1 where a ray enters or −1 where it leaves.
fn crossings(
    tracer: &Tracer<'_>,
    places: &[[f32; 2]],
    wanted: [bool; PACKET],
    shift: [f32; 2],
    height: f32,
) -> [Vec<(f32, i32)>; PACKET] {
    let mut found: [Vec<(f32, i32)>; PACKET] = Default::default();
    // Volumes of lower levels may begin below the grid.
    let below = 2.0 * height;
    let mut rays = [None; PACKET];
    for (ray, place) in places.iter().enumerate().filter(|(ray, _)| wanted[*ray]) {
        let origin = [place[0] + shift[0], place[1] + shift[1], -below];
        rays[ray] = Some(Ray::new(origin, [0.0, 0.0, 1.0]));
    }
    let apart = 1e-6 * (height + below);
    while rays.iter().any(Option::is_some) {
        let hits = tracer.intersect8(&rays);
        for (ray, hit) in hits.iter().enumerate() {
            let Some(hit) = hit else {
                rays[ray] = None;
                continue;
            };
            let sign = if hit.normal[2] < 0.0 { 1 } else { -1 };
            found[ray].push((hit.t - below, sign));
            if let Some(next) = &mut rays[ray] {
                // Two triangles that share an edge are crossed once.
                next.near = hit.t + apart.max(hit.t * 3e-7);
            }
        }
    }
    found
}

/// The stretches in which the winding number is positive.
fn inside(crossings: &[(f32, i32)]) -> Vec<[f32; 2]> {
    let (mut winding, mut from, mut spans) = (0, 0.0, Vec::new());
    for (z, sign) in crossings {
        let before = winding;
        winding += sign;
        if before <= 0 && winding > 0 {
            from = *z;
        } else if before > 0 && winding <= 0 {
            spans.push([from, *z]);
        }
    }
    spans
}

fn finish(sums: Sums, at: [usize; 3], samples: usize) -> Voxel {
    let inside = sums.inside as f32;
    let materials = (0u32..).zip(sums.materials).filter(|(_, weight)| *weight > 0.0);
    let muscles = (0u32..).zip(sums.muscles).filter(|(_, (weight, _))| *weight > 0.0);
    Voxel {
        at: at.map(|index| index as u32),
        share: inside / samples.pow(3) as f32,
        materials: materials.map(|(material, weight)| (material, weight / inside)).collect(),
        muscles: muscles.map(|(muscle, (weight, sum))| (muscle, weight / inside, sum.normalize_or(Vec3::X))).collect(),
    }
}
