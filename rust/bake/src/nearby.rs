//! Samples of a surface in a k-d tree (Bentley 1975), and from the nearest of them Newton steps to the nearest place
//! itself. Units: object units.

use glam::Vec3;
use relievo_core::{Context, Result};
use relievo_surface::{Grid, Order, Place, Placement, Samples, Surface};

/// A sample.
#[derive(Clone, Copy, Debug)]
struct Sample {
    point: Vec3,
    normal: Vec3,
    place: Place,
}

/// A surface that is looked for near points.
#[derive(Debug)]
pub(crate) struct Nearby<'a> {
    surface: &'a Surface,
    /// The middle of every part of the list is the node that splits it.
    samples: Vec<Sample>,
    /// The axis along which the node at that index splits.
    axes: Vec<u8>,
}

/// A place that was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// The place, in the tile of the nearest sample.
    pub place: Place,
    /// How far it is.
    pub distance: f32,
}

/// All samples there may be, and how many along a side of a tile.
const SAMPLES: usize = 4 << 20;
const SIDES: std::ops::RangeInclusive<u32> = 2..=16;
/// Steps from the nearest sample toward the nearest place.
const STEPS: usize = 4;

impl<'a> Nearby<'a> {
    pub fn new(context: &Context, surface: &'a Surface) -> Self {
        let tiles: Vec<u32> =
            (0..surface.tile_count() as u32).filter(|tile| !surface.topology().is_hole(*tile)).collect();
        let fair = ((SAMPLES / tiles.len().max(1)) as f64).sqrt() as u32;
        let side = fair.clamp(*SIDES.start(), *SIDES.end());
        let lists = context.map(tiles.len(), |index| {
            let grid = Grid::whole(side, Placement::Centred);
            let mut samples = Samples::default();
            surface.grid(context.level(), tiles[index], &grid, Order::First, &mut samples);
            let sample = |at: usize| {
                let [u, v] = [at as u32 % side, at as u32 / side].map(|i| grid.parameter(i));
                let normal = vector(&samples.du, at).cross(vector(&samples.dv, at)).normalize_or_zero();
                Sample { point: vector(&samples.p, at), normal, place: Place::new(tiles[index], u, v) }
            };
            (0..grid.len()).map(sample).collect::<Vec<_>>()
        });
        let mut samples = lists.concat();
        let mut axes = vec![0; samples.len()];
        split(&mut samples, &mut axes);
        Self { surface, samples, axes }
    }

    /// For each of `points`, the place whose surface faces as its normal does that is nearest, if there is any.
    pub fn find(&self, context: &Context, points: &[(Vec3, Vec3)]) -> Result<Vec<Option<Found>>> {
        let starts: Vec<Option<usize>> = points
            .iter()
            .map(|(point, normal)| {
                let mut best = (f32::INFINITY, None);
                self.search(0, self.samples.len(), *point, *normal, &mut best);
                best.1
            })
            .collect();
        let mut found: Vec<Option<Found>> = starts
            .iter()
            .map(|start| Some(Found { place: self.samples[(*start)?].place, distance: f32::INFINITY }))
            .collect();
        let mut at: Vec<Place> = found.iter().flatten().map(|found| found.place).collect();
        let mut samples = Samples::default();
        for step in 0..=STEPS {
            self.surface.evaluate(context, &at, Order::First, &mut samples)?;
            let known = found.iter_mut().zip(points).filter_map(|(found, (point, _))| Some((found.as_mut()?, point)));
            for (index, (best, point)) in known.enumerate() {
                let (p, du, dv) = (vector(&samples.p, index), vector(&samples.du, index), vector(&samples.dv, index));
                let off = *point - p;
                if off.length() < best.distance {
                    *best = Found { place: at[index], distance: off.length() };
                }
                if step < STEPS {
                    let (a, b, c) = (du.length_squared(), du.dot(dv), dv.length_squared());
                    let determinant = a * c - b * b;
                    if determinant > 1e-12 * a * c {
                        let (s, t) = (du.dot(off), dv.dot(off));
                        let place = &mut at[index];
                        place.u = (place.u + (s * c - t * b) / determinant).clamp(0.0, 1.0);
                        place.v = (place.v + (t * a - s * b) / determinant).clamp(0.0, 1.0);
                    }
                }
            }
        }
        Ok(found)
    }

    fn search(&self, from: usize, to: usize, point: Vec3, normal: Vec3, best: &mut (f32, Option<usize>)) {
        if from >= to {
            return;
        }
        let middle = (from + to) / 2;
        let sample = &self.samples[middle];
        let distance = sample.point.distance_squared(point);
        if distance < best.0 && sample.normal.dot(normal) > 0.0 {
            *best = (distance, Some(middle));
        }
        let axis = usize::from(self.axes[middle]);
        let across = point[axis] - sample.point[axis];
        let (near, far) =
            if across < 0.0 { ((from, middle), (middle + 1, to)) } else { ((middle + 1, to), (from, middle)) };
        self.search(near.0, near.1, point, normal, best);
        if across * across < best.0 {
            self.search(far.0, far.1, point, normal, best);
        }
    }
}

/// Sorts samples so that the middle of every part splits it along the axis of its largest extent.
fn split(samples: &mut [Sample], axes: &mut [u8]) {
    if samples.len() < 2 {
        return;
    }
    let low = samples.iter().fold(Vec3::INFINITY, |low, sample| low.min(sample.point));
    let high = samples.iter().fold(Vec3::NEG_INFINITY, |high, sample| high.max(sample.point));
    let axis = (high - low).max_position();
    let middle = samples.len() / 2;
    samples.select_nth_unstable_by(middle, |a, b| a.point[axis].total_cmp(&b.point[axis]));
    axes[middle] = axis as u8;
    let (before, after) = samples.split_at_mut(middle);
    let (axes_before, axes_after) = axes.split_at_mut(middle);
    split(before, axes_before);
    split(&mut after[1..], &mut axes_after[1..]);
}

/// Three numbers out of three lists.
pub(crate) fn vector(lists: &[Vec<f32>; 3], at: usize) -> Vec3 {
    Vec3::new(lists[0][at], lists[1][at], lists[2][at])
}
