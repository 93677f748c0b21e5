// import common
// import imprint_box
// Columns from what their winding number changes by at every step: a voxel is solid where it is not zero. The changes, and
// what was noted of crossings, are left zero for the next use. Nothing changes beyond the box of the collider. Workgroups of a
// layer take an imprint.

// As in `imprint_cross.wgsl`.
@group(0) @binding(1) var<storage, read_write> turns: array<i32>;
// The lowest solid voxel of a column, and the one after the highest in the upper half; after those of all columns of an
// imprint the heights of both ends of each, the upper one negated, from the centre of the lowest voxel.
@group(0) @binding(4) var<storage, read_write> spans: array<u32>;
// Bit z % 32 of the word at z / 32 times the columns plus c is voxel z of column c.
@group(0) @binding(3) var<storage, read_write> words: array<u32>;

// Units by which the rounding of a height may take it beyond its step.
const ROUNDED: i32 = 4096;

// 1 where a word holds two steps.
var<private> halves: u32;

// The words of a column that hold steps from a multiple of four on; nothing is beyond the last.
fn turns_at(column: u32, layer: u32) -> i32 {
    if layer > work.dims.z >> halves {
        return 0;
    }
    return turns[work.first_turn + layer * work.dims.x * work.dims.y + column];
}

// What the winding number changes by at four steps. They are taken by four because a loop over all steps twice would come
// near the number of iterations at which some devices stop.
fn four_turns(column: u32, z: u32) -> vec4<i32> {
    let layer = z >> halves;
    let first = vec2(turns_at(column, layer), turns_at(column, layer + 1u));
    if halves == 0u {
        return vec4(first, turns_at(column, layer + 2u), turns_at(column, layer + 3u));
    }
    let low = extractBits(first, 0u, 16u);
    let high = (first - low) >> vec2(16u);
    return vec4(low.x, high.x, low.y, high.y);
}

// The winding number after each of four steps, from the one before them.
fn windings(turns: vec4<i32>, before: i32) -> vec4<i32> {
    let pairs = vec4(turns.x, turns.x + turns.y, turns.z, turns.z + turns.w);
    return vec4(before) + vec4(pairs.x, pairs.y, pairs.y + pairs.z, pairs.y + pairs.w);
}

fn clear(column: u32, z: u32) {
    let end = min((z + 4u) >> halves, (work.dims.z >> halves) + 1u);
    for (var layer = z >> halves; layer < end; layer++) {
        turns[work.first_turn + layer * work.dims.x * work.dims.y + column] = 0;
    }
}

// The height of a crossing, which `at` tells of, negated for the highest one. It is none where it is not rounded up to `end`,
// the end of the column on that side.
fn take_height(at: u32, end: i32, sign: i32) -> i32 {
    let height = NO_HEIGHT - turns[at];
    turns[at] = 0;
    // What could wrap is no height.
    let rest = HEIGHT_UNITS * end - sign * height;
    let near = height != NO_HEIGHT && rest >= -ROUNDED && rest <= HEIGHT_UNITS + ROUNDED;
    return select(NO_HEIGHT, height, near);
}

@compute @workgroup_size(GROUP)
fn resolve(id: Invocation) {
    let column = linear_group(id) * GROUP + id.local;
    work = links[step.link + id.group.z];
    let columns = work.dims.x * work.dims.y;
    if column >= columns {
        return;
    }
    halves = select(0u, 1u, (work.flags & NARROW) != 0u);
    let part = solid_part(step.link + id.group.z);
    let place = vec2(i32(column % work.dims.x), i32(column / work.dims.x));
    let there = all(place >= part.low.xy) && all(place < part.high.xy);
    // Whole words of bits, of which the last may have a change at its end.
    let start = select(work.dims.z, u32(part.low.z) / 32u * 32u, there);
    let stop = select(0u, u32(part.high.z), there);
    for (var z = 0u; z < work.dims.z; z += 32u) {
        if z < start || z > stop {
            words[work.first_word + z / 32u * columns + column] = 0u;
        }
    }
    var winding = 0;
    if (work.flags & (BACKWARD | OPEN)) != 0u {
        // From the far side all crossings come first. An open mesh has no outside to come from: the least winding
        // number along the column is outside.
        var sum = 0;
        var least = 0;
        for (var z = start; z <= stop; z += 4u) {
            let four = windings(four_turns(column, z), sum);
            sum = four.w;
            least = min(least, min(min(four.x, four.y), min(four.z, four.w)));
        }
        winding = -select(sum, least, (work.flags & OPEN) != 0u);
    }
    var first = 0xffffffffu;
    var end = 0u;
    var pieces = 0u;
    var carry = 0u;
    var word = 0u;
    for (var z = start; z <= stop; z += 4u) {
        let changes = four_turns(column, z);
        let four = windings(changes, winding);
        winding = four.w;
        if any(changes != vec4(0)) {
            clear(column, z);
        }
        let solid = select(vec4(0u), vec4(1u, 2u, 4u, 8u), four != vec4(0));
        let inside = (1u << min(work.dims.z - z, 4u)) - 1u;
        word |= ((solid.x | solid.y | solid.z | solid.w) & inside) << (z % 32u);
        if z % 32u == 28u || z + 4u > stop {
            let base = z / 32u * 32u;
            if base < work.dims.z {
                words[work.first_word + z / 32u * columns + column] = word;
            }
            if word != 0u {
                first = min(first, base + countTrailingZeros(word));
                end = base + 32u - countLeadingZeros(word);
            }
            pieces += countOneBits(word & ~((word << 1u) | carry));
            carry = word >> 31u;
            word = 0u;
        }
    }
    spans[work.first_column + column] = select(select(first | (end << 16u), 0u, pieces == 0u), PIECES, pieces > 1u);
    let top = work.first_turn + ((work.dims.z >> halves) + 1u) * columns + column;
    let low = take_height(top, select(-4, i32(first), pieces > 0u), 1);
    let high = take_height(top + columns, select(-4, i32(end), pieces > 0u), -1);
    let ends = work.first_column + columns + 2u * column;
    spans[ends] = u32(low);
    spans[ends + 1u] = u32(high);
}
