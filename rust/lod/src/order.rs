//! Orders of triangles: along a curve through space that keeps neighbours together (Morton 1966), and by numbers.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use glam::{Vec3, Vec4Swizzles};
use relievo_core::Context;

use crate::simplify::patch::Pieces;

/// Bits of a digit at most.
const DIGIT: u32 = 11;
/// Triangles of one task.
const CHUNK_LEN: usize = 4096;
/// What one task sorts at least, so that counting digits is little of it.
const SORTED: usize = 16_384;

/// A number by which something is sorted, and where that is, in the lower half.
type Keyed = AtomicU64;

fn keyed(key: u32, at: usize) -> Keyed {
    Keyed::new(u64::from(key) << u32::BITS | at as u64)
}

/// Where they are that are sorted by numbers of so many bits; what has the same one keeps its order.
fn sort(context: &Context, mut keyed: Vec<Keyed>, bits: u32) -> Vec<u32> {
    let size = SORTED.max(keyed.len().div_ceil(4 * context.threads()));
    let mut sorted = context.map(keyed.len(), |_| Keyed::default());
    let passes = bits.div_ceil(DIGIT).max(1);
    let width = bits.div_ceil(passes);
    for pass in 0..passes {
        let digit = |keyed: &Keyed| (keyed.load(Relaxed) >> (u32::BITS + pass * width)) as usize & ((1 << width) - 1);
        let mut starts = context.map(keyed.len().div_ceil(size), |part| {
            let mut counts = vec![0u32; 1 << width];
            keyed.chunks(size).nth(part).into_iter().flatten().for_each(|one| counts[digit(one)] += 1);
            counts
        });
        let mut end = 0;
        for digit in 0..1 << width {
            for starts in &mut starts {
                end += std::mem::replace(&mut starts[digit], end);
            }
        }
        context.for_each_mut(&mut starts, |part, starts| {
            for one in keyed.chunks(size).nth(part).into_iter().flatten() {
                let start = &mut starts[digit(one)];
                sorted[*start as usize].store(one.load(Relaxed), Relaxed);
                *start += 1;
            }
        });
        std::mem::swap(&mut keyed, &mut sorted);
    }
    keyed.into_iter().map(|one| one.into_inner() as u32).collect()
}

/// Triangles in the order of their numbers.
pub fn by_number(context: &Context, pieces: &Pieces, triangles: usize) -> Vec<[u32; 3]> {
    let numbered = (0..triangles).map(|at| keyed(pieces.triangle(at)[3], at)).collect();
    let vertices = |at: u32| {
        let [a, b, c, _] = pieces.triangle(at as usize);
        [a, b, c]
    };
    sort(context, numbered, u32::BITS).into_iter().map(vertices).collect()
}

/// The places of so many triangles along the curve, in a cube of twice the extent of `bounds`, whose lower corner is there
/// at a shift of 0. Cells are a few triangles wide.
pub fn along_curve(
    context: &Context,
    pieces: &Pieces,
    triangles: usize,
    (low, high): (Vec3, Vec3),
    shift: Vec3,
) -> Vec<u32> {
    let bits = (triangles.max(1).ilog2() / 2).saturating_sub(2).clamp(4, 10);
    let cells = (1 << bits) as f32;
    let scale = 0.5 * cells / (high - low).max_element().max(f32::MIN_POSITIVE);
    let code = |at: usize| {
        let [a, b, c, _] = pieces.triangle(at);
        let middle = [a, b, c].into_iter().map(|vertex| pieces.points[vertex as usize].xyz()).sum::<Vec3>() / 3.0;
        let cell = (middle - low) * scale + shift * (0.5 * cells);
        let [x, y, z] = cell.to_array().map(|cell| spread(cell.clamp(0.0, cells - 1.0) as u32));
        x | y << 1 | z << 2
    };
    let mut coded: Vec<Keyed> = context.map(triangles, |_| Keyed::default());
    let mut parts: Vec<_> = coded.chunks_mut(CHUNK_LEN).collect();
    context.for_each_mut(&mut parts, |part, coded| {
        (part * CHUNK_LEN..).zip(coded.iter_mut()).for_each(|(at, coded)| *coded = keyed(code(at), at));
    });
    sort(context, coded, 3 * bits)
}

/// The bits of a number below 2¹⁰, each followed by two zeros.
fn spread(number: u32) -> u32 {
    let number = (number | number << 16) & 0x0300_00ff;
    let number = (number | number << 8) & 0x0300_f00f;
    let number = (number | number << 4) & 0x030c_30c3;
    (number | number << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use relievo_core::ContextOptions;

    use super::*;

    #[test]
    fn triangles_of_one_cell_follow_each_other() {
        let context = Context::new(&ContextOptions::default()).unwrap();
        let size = 64;
        let points = (0..size * size).map(|at| Vec3::new((at % size) as f32, (at / size) as f32, 0.0));
        let corners = [0, 1, size].map(|step| move |at: u32| at + step);
        let inside = |at: &u32| at % size < size - 1 && at / size < size - 1;
        let input: Vec<[u32; 3]> = (0..size * size).filter(inside).map(|at| corners.map(|corner| corner(at))).collect();
        let points: Vec<Vec3> = points.collect();
        let pieces = Pieces {
            input: &input,
            left: None,
            points: points.iter().map(|point| point.extend(0.0)).collect(),
            factors: Vec::new(),
            is_locked: Vec::new(),
            valences: Vec::new(),
            joined: Vec::new(),
        };
        // Sixteen cells along twice the extent are eight wide, and hold 64 triangles or fewer.
        let bounds = (Vec3::ZERO, Vec3::splat(size as f32));
        let order = along_curve(&context, &pieces, input.len(), bounds, Vec3::ZERO);
        let cell = |at: &u32| points[input[*at as usize][0] as usize].to_array().map(|place| place as u32 / 8);
        let mut cells: Vec<_> = order.iter().map(cell).collect();
        cells.dedup();
        assert_eq!(cells.len(), 64);
        let steps =
            cells.windows(2).filter(|pair| pair[0][0].abs_diff(pair[1][0]) + pair[0][1].abs_diff(pair[1][1]) > 2);
        // The curve jumps where a block of cells ends, and is among neighbours otherwise.
        assert!(steps.count() <= 8);
        let mut all = order;
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..input.len() as u32));
    }
}
