// import common
// What a brush that smears leaves with its next dab: the means of what it picked up, and in a cell that has none that of
// the least square of cells around it that has some. The same as `smudge` of rust/detail.

// As in `brush_smear`, and where the picture to make begins.
@group(0) @binding(0) var<storage, read_write> carried: array<vec4<f32>>;
// The same, and then the sums of squares of 2 × 2, 4 × 4, … cells.
@group(0) @binding(1) var<storage, read_write> picked: array<u32>;
var<immediate> first: u32;

const SMEAR_SIDE: u32 = 32u;
const SMEAR_UNIT: f32 = 1048576.0;
const SMEAR_WORDS: u32 = 9u;
// Of squares, up to the one of all cells.
const SMEAR_LEVELS: u32 = 6u;

/// The first word of a cell of a level.
fn cell_at(level: u32, i: u32, j: u32) -> u32 {
    var before = 0u;
    for (var k = 0u; k < level; k++) {
        before += (SMEAR_SIDE >> k) * (SMEAR_SIDE >> k);
    }
    return SMEAR_WORDS * (before + j * (SMEAR_SIDE >> level) + i);
}

/// Adds up four cells of the level below.
fn add_up(level: u32, i: u32, j: u32) {
    let at = cell_at(level, i, j);
    for (var channel = 0u; channel < 4u; channel++) {
        var low = 0u;
        var high = 0u;
        for (var k = 0u; k < 4u; k++) {
            let finer = cell_at(level - 1u, 2u * i + k % 2u, 2u * j + k / 2u) + 2u * channel;
            low += picked[finer];
            high += picked[finer + 1u] + select(0u, 1u, low < picked[finer]);
        }
        picked[at + 2u * channel] = low;
        picked[at + 2u * channel + 1u] = high;
    }
    var count = 0u;
    for (var k = 0u; k < 4u; k++) {
        count += picked[cell_at(level - 1u, 2u * i + k % 2u, 2u * j + k / 2u) + 8u];
    }
    picked[at + 8u] = count;
}

/// The mean of the colours of a cell that has some.
fn mean_of(at: u32) -> vec4<f32> {
    var mean: vec4<f32>;
    for (var channel = 0u; channel < 4u; channel++) {
        var low = picked[at + 2u * channel];
        var high = picked[at + 2u * channel + 1u];
        let negative = high >= 0x80000000u;
        if negative {
            low = ~low + 1u;
            high = ~high + select(0u, 1u, low == 0u);
        }
        let size = (f32(high) * 4294967296.0 + f32(low)) / SMEAR_UNIT;
        mean[channel] = select(size, -size, negative) / f32(picked[at + 8u]);
    }
    return mean;
}

@compute @workgroup_size(GROUP)
fn spread(@builtin(local_invocation_index) local: u32) {
    for (var level = 1u; level < SMEAR_LEVELS; level++) {
        let side = SMEAR_SIDE >> level;
        for (var cell = local; cell < side * side; cell += GROUP) {
            add_up(level, cell % side, cell / side);
        }
        storageBarrier();
    }
    // Where nothing was there it goes on carrying what it did.
    if picked[cell_at(SMEAR_LEVELS - 1u, 0u, 0u) + 8u] == 0u {
        return;
    }
    for (var cell = local; cell < SMEAR_SIDE * SMEAR_SIDE; cell += GROUP) {
        var level = 0u;
        var at = SMEAR_WORDS * cell;
        while picked[at + 8u] == 0u && level + 1u < SMEAR_LEVELS {
            level++;
            at = cell_at(level, (cell % SMEAR_SIDE) >> level, (cell / SMEAR_SIDE) >> level);
        }
        carried[first + 1u + cell] = mean_of(at);
    }
    if local == 0u {
        carried[first] = vec4(1.0);
    }
}
