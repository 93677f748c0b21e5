//! Which half-edges share an edge.

use std::sync::atomic::{AtomicU32, Ordering};

use relievo_core::Context;

use crate::corners::Corners;

/// Stands for the mate of a half-edge whose edge has no other face.
pub const BOUNDARY: u32 = u32::MAX;
/// Stands for the mate of a half-edge whose edge has more than two faces.
pub const BRANCHING: u32 = u32::MAX - 1;

/// Half-edges by their edges.
pub struct Edges {
    /// For every half-edge the other one of its edge, or [`BOUNDARY`] or [`BRANCHING`].
    pub mates: Vec<u32>,
    /// The half-edges of each edge of more than two faces, in order.
    pub branching: Vec<Vec<u32>>,
    /// The number of edges.
    pub count: usize,
}

/// Points that a thread takes at a time.
const POINTS: usize = 1 << 13;

impl Edges {
    /// Finds the edges of faces.
    pub fn of(context: &Context, corners: &Corners) -> Self {
        let ends = context.map(corners.points.len(), |half| {
            let (from, to) = (corners.from(half as u32), corners.to(half as u32));
            [from.min(to), from.max(to)]
        });
        // Half-edges by the lower of their points.
        let point_count = corners.places.len();
        let mut starts = vec![0u32; point_count + 2];
        ends.iter().for_each(|[low, _]| starts[*low as usize + 2] += 1);
        (2..starts.len()).for_each(|point| starts[point] += starts[point - 1]);
        let mut by_low = vec![[0u32; 2]; ends.len()];
        for (half, [low, high]) in (0..).zip(&ends) {
            let slot = &mut starts[*low as usize + 1];
            by_low[*slot as usize] = [*high, half];
            *slot += 1;
        }
        let mates: Vec<AtomicU32> = context.map(ends.len(), |_| AtomicU32::new(BOUNDARY));
        let found = context.map(point_count.div_ceil(POINTS), |part| {
            let (mut branching, mut count) = (Vec::new(), 0);
            let mut run: Vec<[u32; 2]> = Vec::new();
            for point in part * POINTS..point_count.min((part + 1) * POINTS) {
                run.clear();
                run.extend_from_slice(&by_low[starts[point] as usize..starts[point + 1] as usize]);
                run.sort_unstable();
                for edge in run.chunk_by(|a, b| a[0] == b[0]) {
                    count += 1;
                    match edge {
                        // From a point to itself, in faces that are degenerate.
                        [[high, _], ..] if *high == point as u32 => {}
                        [_] => {}
                        [[_, a], [_, b]] => {
                            mates[*a as usize].store(*b, Ordering::Relaxed);
                            mates[*b as usize].store(*a, Ordering::Relaxed);
                        }
                        _ => {
                            edge.iter().for_each(|[_, half]| mates[*half as usize].store(BRANCHING, Ordering::Relaxed));
                            branching.push(edge.iter().map(|[_, half]| *half).collect::<Vec<u32>>());
                        }
                    }
                }
            }
            (branching, count)
        });
        let count = found.iter().map(|(_, count)| count).sum();
        let branching = found.into_iter().flat_map(|(branching, _)| branching).collect();
        Self { mates: context.map(mates.len(), |half| mates[half].load(Ordering::Relaxed)), branching, count }
    }

    /// The other half-edge of an edge of two faces.
    pub fn mate(&self, half: u32) -> Option<u32> {
        let mate = self.mates[half as usize];
        (mate < BRANCHING).then_some(mate)
    }

    /// Cuts an edge of two faces.
    pub fn cut(&mut self, half: u32) {
        if let Some(mate) = self.mate(half) {
            self.mates[mate as usize] = BOUNDARY;
        }
        self.mates[half as usize] = BOUNDARY;
    }

    /// Joins two half-edges.
    pub fn join(&mut self, a: u32, b: u32) {
        self.mates[a as usize] = b;
        self.mates[b as usize] = a;
    }
}
