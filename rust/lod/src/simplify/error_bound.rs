//! Simplification whose surface is nowhere farther from the input's than a bound, nor the input's from it.
//!
//! What collapses are estimated to deviate by is a root mean square, and may be exceeded. So the mesh is simplified with
//! the bound as the limit of the estimates, its distance from the input is measured, and where it is exceeded the limit
//! is lowered for the vertices around, until it is exceeded nowhere. All other parts keep their triangles.

use relievo_core::{Context, Progress, Result};

use crate::distance::MeasuredMesh;

/// A mesh as points and triangles.
pub type Triangles<'a> = (&'a [[f32; 3]], &'a [[u32; 3]]);

/// The share of the limit that is left to a vertex after so many lowerings; none after the last.
const LEFT: [f32; 4] = [1.0, 0.5, 0.2, 0.05];
/// Simplifications at most. If the last one exceeds the bound, the input is the result.
const ROUNDS: i32 = 12;
/// Rounds after which the limit is also lowered one triangle farther around.
const WIDER: i32 = 3;
/// The share of the bound from which on a vertex under a triangle that exceeds it has its limit lowered. Large triangles
/// of flat parts exceed a bound at a corner, and most vertices under them have no part in that.
const CORNER_SHARE: f64 = 0.1;
/// Rounds after which all vertices under such a triangle do.
const ALL: i32 = 6;

/// Lowered limits of the estimated deviation.
pub struct Limits {
    /// The limit of all vertices.
    error: f32,
    /// How often that of each vertex was lowered.
    lowered: Vec<u8>,
}

impl Limits {
    /// No limit but one for all.
    pub fn of(error: f32) -> Self {
        Self { error, lowered: Vec::new() }
    }

    /// The limit of all vertices.
    pub fn error(&self) -> f32 {
        self.error
    }

    /// Returns what a vertex is taken to deviate by before anything is collapsed, so that what is left of the limit is
    /// its own. Above the limit for a vertex that must not move.
    pub fn spent(&self, vertex: usize) -> f32 {
        match self.lowered.get(vertex) {
            None | Some(0) => 0.0,
            Some(times) => LEFT.get(usize::from(*times)).map_or(f32::MAX, |left| self.error * (1.0 - left)),
        }
    }
}

/// Simplifies a mesh so that the largest distance between its surface and the input's is at most `bound`, and no estimate
/// is above `error`. `simplify` makes a mesh within limits, of which `shape` returns the surface. Returns the mesh and its distance, which is never less
/// than the true one.
///
/// Fails as `simplify` does, if memory does not suffice, or `progress` asks to stop.
pub fn within<T>(
    context: &Context,
    input: Triangles,
    [bound, error]: [f32; 2],
    progress: &mut dyn Progress,
    mut simplify: impl FnMut(&Limits, &mut dyn Progress) -> Result<T>,
    shape: impl Fn(&T) -> Triangles<'_>,
) -> Result<(T, f32)> {
    let original = MeasuredMesh::new(context, input)?;
    let most = f64::from(bound).max(original.rounding());
    let mut limits = Limits { error: (most as f32).min(error), lowered: vec![0; input.0.len()] };
    let mut round = 0;
    loop {
        // How many rounds there will be is not known: each takes half of what is left.
        let start = 1.0 - 0.5f32.powi(round);
        let width = 0.5 * (1.0 - start);
        let mut made = |fraction: f32, stage: &str| progress.report(start + 0.5 * width * fraction, stage);
        let made = simplify(&limits, &mut made)?;
        let surface = MeasuredMesh::new(context, shape(&made))?;
        let mut part = |fraction: f32, stage: &str| progress.report(start + width * fraction, stage);
        let there = surface.beyond(context, &original, most, (&mut part, [0.5, 0.75]))?;
        let back = original.beyond(context, &surface, most, (&mut part, [0.75, 1.0]))?;
        if round == ROUNDS || there.is_empty() && back.is_empty() {
            let end = start + width;
            let mut rest = |fraction: f32, stage: &str| progress.report(end + (1.0 - end) * fraction, stage);
            let distance = original.distance(context, &surface, &mut rest)?;
            return Ok((made, distance.at_most.min(most as f32)));
        }
        round += 1;
        if round == ROUNDS {
            limits.lowered.fill(u8::MAX);
        } else {
            let covered = surface.nearest_triangles(context, input.0);
            let failed = there.iter().map(|it| it.triangle).chain(back.iter().map(|it| it.nearest));
            let failed = grown(shape(&made), failed, round / WIDER);
            let own = there.iter().map(|it| it.nearest).chain(back.iter().map(|it| it.triangle));
            let least = if round > ALL { 0.0 } else { CORNER_SHARE * most };
            let is_part = |(triangle, distance): (u32, f64)| failed[triangle as usize] && distance >= least;
            let mut is_lowered: Vec<bool> = covered.into_iter().map(is_part).collect();
            own.flat_map(|triangle| input.1[triangle as usize]).for_each(|vertex| is_lowered[vertex as usize] = true);
            for (lowered, is_lowered) in limits.lowered.iter_mut().zip(is_lowered) {
                *lowered = lowered.saturating_add(u8::from(is_lowered));
            }
        }
    }
}

/// Returns which triangles are given, or reached from them over shared vertices in so many steps.
fn grown((points, triangles): Triangles, given: impl Iterator<Item = u32>, steps: i32) -> Vec<bool> {
    let mut is_in = vec![false; triangles.len()];
    given.for_each(|triangle| is_in[triangle as usize] = true);
    for _ in 0..steps {
        let mut is_met = vec![false; points.len()];
        for (triangle, _) in triangles.iter().zip(&is_in).filter(|(_, is_in)| **is_in) {
            triangle.iter().for_each(|vertex| is_met[*vertex as usize] = true);
        }
        for (triangle, is_in) in triangles.iter().zip(&mut is_in) {
            *is_in |= triangle.iter().any(|vertex| is_met[*vertex as usize]);
        }
    }
    is_in
}
