//! Orders of triangles: along a curve through space that keeps neighbours together (Morton 1966), and by numbers.

use glam::{Vec3, Vec4Swizzles};
use relievo_core::Context;

use crate::patch::Pieces;

/// Bits of a digit.
const DIGIT: u32 = 11;
/// Triangles of one task.
const PART: usize = 4096;

/// A number by which something is sorted, and where that is.
type Keyed = [u32; 2];

/// Sorts by numbers of so many bits; what has the same one keeps its order.
fn sort(mut keyed: Vec<Keyed>, bits: u32) -> Vec<Keyed> {
    let mut sorted = vec![Keyed::default(); keyed.len()];
    for shift in (0..bits).step_by(DIGIT as usize) {
        let digit = |key: u32| (key >> shift) as usize & ((1 << DIGIT) - 1);
        let mut starts = [0u32; 1 << DIGIT];
        keyed.iter().for_each(|[key, _]| starts[digit(*key)] += 1);
        let mut end = 0;
        for start in &mut starts {
            end += std::mem::replace(start, end);
        }
        for one in &keyed {
            let start = &mut starts[digit(one[0])];
            sorted[*start as usize] = *one;
            *start += 1;
        }
        std::mem::swap(&mut keyed, &mut sorted);
    }
    keyed
}

/// Triangles in the order of their numbers.
pub fn by_number(pieces: &Pieces, triangles: usize) -> Vec<[u32; 3]> {
    let keyed = (0..triangles).map(|at| [pieces.triangle(at)[3], at as u32]).collect();
    let vertices = |[_, at]: Keyed| {
        let [a, b, c, _] = pieces.triangle(at as usize);
        [a, b, c]
    };
    sort(keyed, u32::BITS).into_iter().map(vertices).collect()
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
    let mut keyed = vec![Keyed::default(); triangles];
    let mut parts: Vec<_> = keyed.chunks_mut(PART).collect();
    context.for_each_mut(&mut parts, |part, keyed| {
        (part * PART..).zip(keyed.iter_mut()).for_each(|(at, keyed)| *keyed = [code(at), at as u32]);
    });
    sort(keyed, 3 * bits).into_iter().map(|[_, at]| at).collect()
}

/// The bits of a number below 2¹⁰, each followed by two zeros.
fn spread(number: u32) -> u32 {
    let number = (number | number << 16) & 0x0300_00ff;
    let number = (number | number << 8) & 0x0300_f00f;
    let number = (number | number << 4) & 0x030c_30c3;
    (number | number << 2) & 0x0924_9249
}
