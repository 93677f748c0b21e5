// The imprints of a submission: what kernels get of each, and what they report.

// Bits of the flags: how the columns are solid, and what rays start from.
const BACKWARD: u32 = 1u;
const OPEN: u32 = 2u;
const MIRRORED: u32 = 4u;
const STARTED: u32 = 8u;
const CHAINED: u32 = 16u;
const WORKED: u32 = 32u;
// Winding numbers change by so little that a word holds two steps.
const NARROW: u32 = 64u;

// Faults in voxelising.
const TOO_FAR: u32 = 1u;
const TOO_MUCH: u32 = 2u;

// No imprint.
const LINK_NONE: u32 = 0xffffffffu;

// Triangles whose work a workgroup finds, four an invocation.
const COUNTED: u32 = 1024u;

// Workgroups of a row of a dispatch.
const ROW: u32 = 32768u;

// What stands for the ends of a column that is solid in more than one piece.
const PIECES: u32 = 0xffffu;

// Units of the heights of columns' ends in a voxel, and the height of none.
const HEIGHT_UNITS: i32 = 32768;
const NO_HEIGHT: i32 = 1073741824;

struct Link {
    // The map of the collider's coordinates, as integers, to the lattice: rows, times 2 to the power of `shift`.
    lattice_x: vec3<i32>,
    points: u32,
    lattice_y: vec3<i32>,
    shift: u32,
    lattice_z: vec3<i32>,
    // Coordinates times this are integers; a power of two.
    scale: f32,
    // Subtracted from coordinates as integers.
    lattice_origin: vec3<i32>,
    first_point: u32,
    // Where the origin is, with half a unit for rounding: low words and high words.
    lattice_low: vec3<u32>,
    first_index: u32,
    lattice_high: vec3<u32>,
    triangles: u32,
    // Voxels along x, y and z, which the columns run along.
    dims: vec3<u32>,
    flags: u32,
    // From the object's space to voxels: three numbers of the linear part, and where the origin is.
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    // What is subtracted from points first.
    origin: vec3<f32>,
    // Tiles of the object.
    tiles: u32,
    // Share of the distance that is applied, limits in object units, and the least coefficient as `key`.
    share: f32,
    max_displacement: f32,
    depth: f32,
    deepest: i32,
    // Where its points on the lattice begin, and the work of its triangles, at a multiple of `COUNTED`.
    first_corner: u32,
    first_work: u32,
    // Where the object's slots begin, and how many a tile has: the least coefficient that imprints before this one left,
    // as `key` and negated, of every block its last record, from 1, and last the highest coefficient that rose, as a half;
    // of tiles that are worked on others, see below.
    slots: u32,
    stride: u32,
    // Blocks that there is room for, and records.
    room: u32,
    records: u32,
    // 0, see `rounded`.
    zero: u32,
    // Where the winding numbers of its voxels, its columns and their bits begin.
    first_turn: u32,
    first_column: u32,
    first_word: u32,
    // The next imprint of the same object whose blocks are found and whose rays are cast together with this one's.
    next: u32,
    // The first of the imprints whose winding numbers are there at once with this one's.
    wave: u32,
    // How strongly what changed is smoothed, 0 to 1.
    strength: f32,
    // Of tiles that are worked on: words of a block, how many blocks there are, workgroups that take one and its ring, and
    // where rings and their entries begin in the topology.
    block_words: u32,
    blocks: u32,
    parts: u32,
    ring_parts: u32,
    rings: u32,
    entries: u32,
    // Voxels by which a surface may rise from column to column to be taken for one.
    steep: f32,
}

// Slots of a tile of an object whose tiles are worked on: its block, from 1, or one that there is no room for; the keys of
// its least and its largest coefficient; the imprints, from 1, that changed it last, that were the last to list it, and for
// which its block was taken.
const SLOT_BLOCK: u32 = 0u;
const SLOT_LEAST: u32 = 1u;
const SLOT_MOST: u32 = 2u;
const SLOT_TOUCHED: u32 = 3u;
const SLOT_LISTED: u32 = 4u;
const SLOT_TAKEN: u32 = 5u;
const NO_ROOM: u32 = 0xffffffffu;

// Whether what such a slot says of a block is one.
fn is_block(slot: u32) -> bool {
    return slot != 0u && slot != NO_ROOM;
}

struct JobCounters {
    // Blocks that were found, whether or not there was room for them.
    found: atomic<u32>,
    // Rays that were held at the border of the grid.
    clamped: atomic<u32>,
    tiles: atomic<u32>,
    faults: atomic<u32>,
    // Coefficients that were looked at.
    tested: atomic<u32>,
    // The work of all triangles in units of 1,024, rounded up: sums of words may wrap round, this does not.
    work: atomic<u32>,
    // Blocks that it changed, where these are smoothed.
    @size(8) changed: atomic<u32>,
}

struct AllCounters {
    // Blocks that are kept, and those of tiles that were worked on, whether or not there was room for them.
    kept: atomic<u32>,
    @size(12) taken: atomic<u32>,
    links: array<JobCounters>,
}

// Which imprint this is, or the first of several that are taken together, and how many these are or, of those of one
// object, `Link.next`.
struct Step {
    link: u32,
    count: u32,
}

@group(0) @binding(0) var<storage, read> links: array<Link>;
var<immediate> step: Step;

// The imprint that an invocation works on.
var<private> work: Link;

// A product that is rounded before anything is added to it: compilers may fuse the two. The word is zero.
fn rounded(product: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(product) ^ work.zero);
}
