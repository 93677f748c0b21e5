// import common
// import halves
// import imprint_link
// import imprint_record
// Rims as rust/detail/src/imprint/rim.rs makes them: what its stages share. A workgroup takes a block of 256 coefficients of a tile,
// or values of a triangle, the piece, and an invocation one of them.

// Faults: cells too far from the contact or too many, and borders too many.
const RIM_FAR: u32 = 1u;
const RIM_MANY: u32 = 2u;

// What an imprint raises.
struct Rim {
    // Share of the volume that is pushed away, how far from the contact a rim ends, and how high it may be.
    share: f32,
    width: f32,
    highest: f32,
    // Room for pieces, for cells, of which there is a power of two, and for places at borders.
    pieces: u32,
    cells: u32,
    borders: u32,
    // Where the object's blocks begin in `places`, and how many a tile has.
    first_place: u32,
    blocks: u32,
}

// What an imprint tells of its rim.
struct RimCounters {
    // The distance of neighbours that are pushed, as the bits of a float.
    spacing: atomic<u32>,
    // Pieces with borders, places at borders, and cells, whether or not there was room.
    edges: atomic<u32>,
    borders: atomic<u32>,
    cells: atomic<u32>,
    faults: atomic<u32>,
}

@group(0) @binding(1) var<storage, read> listed: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> arguments: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> slots: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> counters: AllCounters;
@group(0) @binding(7) var<storage, read_write> records: array<u32>;
@group(3) @binding(0) var<storage, read> rims: array<Rim>;
@group(3) @binding(1) var<storage, read_write> rim_counters: array<RimCounters>;
@group(3) @binding(2) var<storage, read_write> pieces: array<u32>;
// The points of the undisplaced surface, and the area that each stands for.
@group(3) @binding(3) var<storage, read_write> points: array<vec4<f32>>;
// By block of the objects the piece that it is, with the imprint from 1 in the upper eight bits.
@group(3) @binding(4) var<storage, read_write> places: array<u32>;
// Cells: see below.
@group(3) @binding(5) var<storage, read_write> cells: array<atomic<u32>>;
// The points at borders of the contact, and their cells.
@group(3) @binding(6) var<storage, read_write> borders: array<vec4<f32>>;
// Pieces with borders: which piece, its first border and how many.
@group(3) @binding(7) var<storage, read_write> edges: array<vec4<u32>>;
// By record the volumes that were pushed away and that rose.
@group(3) @binding(8) var<storage, read_write> volumes: array<vec2<f32>>;

// A piece: of every coefficient the half that it is and, above, that it was; the cell of what is pushed, or the patch of
// what rises; the rim's profile. Then bits of what is pushed and of what may rise, the box of the points, and the largest
// distance of neighbours, and the record of what is pushed, from 1.
const CELLS_OF: u32 = 256u;
const PROFILE: u32 = 512u;
const PUSHED: u32 = 768u;
const FREE: u32 = 776u;
const BOX: u32 = 784u;
const SPACING: u32 = 790u;
const RECORD_OF: u32 = 791u;
const PIECE: u32 = 792u;

// A cell: its key, or EMPTY where there is none; the cell of the same patch that it follows; the volume that its patch
// pushed away, and the room for it, low words first. The sixth word of cell k is the k-th cell that there is.
const EMPTY: u32 = 0u;
const FOLLOWS: u32 = 1u;
const VOLUME: u32 = 2u;
const SPACE: u32 = 4u;
const LISTED: u32 = 6u;
const CELL: u32 = 8u;

// Where a piece lies on its tile.
struct Patchwork {
    tile: u32,
    block: u32,
    size: u32,
    edge: u32,
    // Blocks along the tile.
    across: u32,
}

fn patchwork(item: vec4<u32>) -> Patchwork {
    let size = item.y >> 16u;
    let edge = min(size, EDGE);
    return Patchwork(item.x, item.y & 0xffffu, size, edge, size / max(edge, 1u));
}

// The slot of a block, unless tiles are worked on.
fn block_slot(it: Patchwork) -> u32 {
    return work.slots + it.tile * work.stride + 1u + it.block;
}

fn place_of(tile: u32, block: u32) -> u32 {
    return rims[step.link].first_place + tile * rims[step.link].blocks + block;
}

// The piece that a block is, or NONE.
fn piece_of(tile: u32, block: u32) -> u32 {
    let found = places[place_of(tile, block)];
    return select(NONE, found & 0xffffffu, found >> 24u == step.link + 1u);
}

fn has_bit(piece: u32, mask: u32, k: u32) -> bool {
    return ((pieces[PIECE * piece + mask + k / 32u] >> (k % 32u)) & 1u) == 1u;
}

// The key of a cell, of up to 1,024 along each axis: not EMPTY, and in the order of x, then y, then z.
fn cell_key(at: vec3<i32>) -> u32 {
    return 0x80000000u | (u32(at.x) << 20u) | (u32(at.y) << 10u) | u32(at.z);
}

// Where a key is looked for first, and how many cells are looked at.
const PROBES: u32 = 256u;

fn cell_start(key: u32) -> u32 {
    return (key * 2654435761u) >> 7u;
}

fn number(piece: u32, word: u32) -> f32 {
    return bitcast<f32>(pieces[PIECE * piece + word]);
}

// The edge of the cells: the power of two that is not less than a number.
fn cell_edge() -> u32 {
    let size = max(rims[step.link].width, bitcast<f32>(atomicLoad(&rim_counters[step.link].spacing)));
    let bits = bitcast<u32>(clamp(size, 9.094947e-13, 1.0995116e12));
    return (bits + 0x7fffffu) & 0xff800000u;
}

// One by the power of two with these bits.
fn inverse_of(edge: u32) -> f32 {
    return bitcast<f32>((254u << 23u) - edge);
}

// A number in units of 2⁻³², downwards, 2¹² at most: low word and high word.
fn whole(number: f32) -> vec2<u32> {
    let held = clamp(number, 0.0, 4096.0);
    let high = floor(held);
    return vec2(u32((held - high) * 4294967296.0), u32(high));
}

// Adds to a sum of 64 bits.
fn add(at: u32, amount: vec2<u32>) {
    if all(amount == vec2(0u)) {
        return;
    }
    let before = atomicAdd(&cells[at], amount.x);
    let high = amount.y + u32(before + amount.x < before);
    if high != 0u {
        atomicAdd(&cells[at + 1u], high);
    }
}

// The leading 24 bits of a sum of 64 bits.
fn leading(low: u32, high: u32) -> f32 {
    let zeros = select(countLeadingZeros(high), 32u + countLeadingZeros(low), high == 0u);
    let shift = 40u - min(zeros, 40u);
    var word = high >> (shift & 31u);
    if shift == 0u {
        word = low;
    } else if shift < 32u {
        word = (low >> shift) | (high << (32u - shift));
    }
    return f32(word) * bitcast<f32>((127u + shift) << 23u);
}
