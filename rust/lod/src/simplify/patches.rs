//! Simplification of a mesh in patches, each by one task and in memory that is near.
//!
//! All patches collapse what costs less than a limit, which rises step by step, so that edges of the whole mesh go in about
//! the order of their costs. When the mesh has become much smaller it is cut into patches elsewhere, and what was
//! between them has its turn. How it is cut, and what each patch may collapse, does not depend on threads.

use std::sync::atomic::AtomicU64;

use glam::{Vec3, Vec4, Vec4Swizzles};
use relievo_core::{Context, Progress, Result};

use crate::numbers::Claims;
use crate::order::{along_curve, by_number};
use crate::simplify::error_bound::Limits;
use crate::simplify::patch::{Care, Patch, Pieces};
use crate::simplify::queue::MAGNITUDES;

/// Triangles of a patch at most, and where there are fewer than a few such patches.
const PATCH: [usize; 2] = [8192, 4096];
/// So many patches are a few.
const FEW_PATCHES: usize = 4;
/// The share of the triangles at which a mesh is cut anew.
const AGAIN: f32 = 0.4;
/// The share of the edges that wait whose turn comes in a step.
const STEP: f32 = 0.6;
/// Cuts in a row without a collapse after which there is nothing left to collapse.
const IDLE: usize = 2;

/// A mesh whose edges were collapsed.
pub struct Reduced {
    /// Triangles that are left, in the order of the input.
    pub triangles: Vec<[u32; 3]>,
    /// Place and deviation of every vertex of the input.
    pub points: Vec<Vec4>,
    /// The vertex that each was collapsed into, or itself.
    pub joined: Vec<u32>,
    /// Vertices that had to stay, those of edges that are not of two triangles in opposite directions among them.
    pub is_locked: Vec<bool>,
}

/// Collapses edges until there are `faces` triangles, or none is left that deviates by at most `error`.
pub fn reduce(
    context: &Context,
    mut pieces: Pieces<'_>,
    faces: usize,
    error: f32,
    progress: &mut dyn Progress,
) -> Result<Reduced> {
    let before = pieces.input.len();
    let serial = Context::serial();
    let bounds = bounds(&pieces.points);
    let claims = context.map(pieces.points.len(), |_| AtomicU64::new(0));
    // No patch has the number 0.
    let mut patches_before = 1;
    let mut idle = 0;
    let mut left = before;
    for cut in 0.. {
        if left <= faces || idle == IDLE {
            break;
        }
        // Powers of the root of x⁴ = x + 1 fill a cube evenly (Roberts 2018).
        let shift = Vec3::new(0.819_172_5, 0.671_043_6, 0.549_700_5) * cut as f32;
        let mut valences = std::mem::take(&mut pieces.valences);
        let (order, ()) = context
            .join(|| along_curve(context, &pieces, left, bounds, shift.fract()), || pieces.count(left, &mut valences));
        pieces.valences = valences;
        let [many, few] = PATCH.map(|most| left.div_ceil(most));
        let many = if many == 1 { 1 } else { many.next_multiple_of(2) };
        let size = left.div_ceil(many.max(few.min(FEW_PATCHES)));
        let start = left;
        let until = if size >= left { 0 } else { (left as f32 * AGAIN) as usize };
        // What later cuts do most of does not have to be in order.
        let care = if cut == 0 && faces < until / 2 { Care::Little } else { Care::Much };
        let mut made: Vec<_> = order.chunks(size).map(|list| (list, None)).collect();
        let claims = Claims { of: &claims, first: patches_before };
        patches_before += made.len() as u32;
        context.for_each_part(made.as_mut_slice(), 1, |number, made| {
            made.iter_mut().zip(number as u32..).try_for_each(|((list, patch), number)| {
                *patch = Some(Patch::new(&serial, (&pieces, &claims), (list, number), error, care)?);
                Ok(())
            })
        })?;
        let mut patches: Vec<Patch> = made.into_iter().filter_map(|(_, patch)| patch).collect();
        drop(order);
        pieces.left = None;
        let (goal, enough) = if until > faces { (until, until + until / 100 + 1) } else { (faces, faces) };
        while left > enough {
            progress.step((before - left) as f32 / (before - faces) as f32, "simplify")?;
            let Some((limit, quotas)) = plan(&patches, left - goal) else { break };
            let is_last = left - faces == 1;
            let mut work: Vec<_> = patches.iter_mut().zip(quotas).map(|(patch, quota)| (patch, quota, 0)).collect();
            context.for_each_part(work.as_mut_slice(), 1, |_, work| {
                work.iter_mut().for_each(|(patch, quota, gone)| *gone = patch.run(&serial, limit, *quota, is_last));
                Ok(())
            })?;
            left -= work.iter().map(|(.., gone)| gone).sum::<usize>();
        }
        let (given, ()) = context.join(
            || context.map(patches.len(), |patch| patches[patch].left()).concat(),
            || patches.iter().for_each(|patch| patch.give_back(&mut pieces)),
        );
        pieces.left = Some(given);
        idle = match (left < start, patches.len()) {
            (true, _) => 0,
            (false, 1) => IDLE,
            _ => idle + 1,
        };
    }
    progress.step(1.0, "simplify")?;
    let triangles = by_number(context, &pieces, left);
    Ok(Reduced { triangles, points: pieces.points, joined: pieces.joined, is_locked: pieces.is_locked })
}

/// The magnitude up to which edges have their turn in the next step, and how many triangles each patch may be rid of.
/// `None` if no edge waits.
fn plan(patches: &[Patch], surplus: usize) -> Option<(usize, Vec<usize>)> {
    let mut sums = [0; MAGNITUDES];
    for patch in patches {
        sums.iter_mut().zip(patch.waiting()).for_each(|(sum, count)| *sum += count);
    }
    let wanted = ((sums.iter().sum::<usize>() as f32 * STEP) as usize).max(1);
    let mut ready = 0;
    let limit = sums.iter().position(|count| {
        ready += count;
        ready >= wanted
    })?;
    let ready: Vec<usize> = patches.iter().map(|patch| patch.waiting().take(limit + 1).sum()).collect();
    let all: usize = ready.iter().sum();
    // Whole pairs of triangles, as most collapses are rid of; where there are too few, for those where most edges wait.
    let pairs = |ready: usize| ready.min((surplus as u64 / 2 * ready as u64 / all as u64) as usize);
    let mut quotas: Vec<usize> = ready.iter().map(|ready| 2 * pairs(*ready)).collect();
    if quotas.iter().all(|quota| *quota == 0) {
        let most = (0..ready.len()).rev().max_by_key(|patch| ready[*patch])?;
        quotas[most] = surplus.min(2);
    }
    Some((limit, quotas))
}

/// The corners of a box round points.
fn bounds(points: &[Vec4]) -> (Vec3, Vec3) {
    let (low, high) =
        points.iter().fold((Vec4::MAX, Vec4::MIN), |(low, high), point| (low.min(*point), high.max(*point)));
    (low.xyz(), high.xyz())
}

impl<'a> Pieces<'a> {
    /// Of a mesh whose indices are in range, with coordinates and limits multiplied by `scale`, the factors of its points
    /// or none, and its fixed vertices.
    pub fn new(
        (points, input): (&[[f32; 3]], &'a [[u32; 3]]),
        scale: f32,
        (factors, fixed): (&[f32], &[u32]),
        limits: &Limits,
    ) -> Self {
        let mut is_locked = vec![false; points.len()];
        fixed.iter().for_each(|vertex| is_locked[*vertex as usize] = true);
        let place =
            |(index, point): (usize, &[f32; 3])| (Vec3::from(*point) * scale).extend(limits.spent(index) * scale);
        Self {
            input,
            left: None,
            points: points.iter().enumerate().map(place).collect(),
            factors: factors.to_vec(),
            is_locked,
            valences: vec![0; points.len()],
            joined: (0..points.len() as u32).collect(),
        }
    }

    /// Counts the corners at every vertex.
    fn count(&self, triangles: usize, valences: &mut [u32]) {
        valences.fill(0);
        for at in 0..triangles {
            let [a, b, c, _] = self.triangle(at);
            [a, b, c].into_iter().for_each(|vertex| valences[vertex as usize] += 1);
        }
    }
}
