// What a ring update is bound to, and the tiles that it sees: as they are, or each at one of its mips. The same as `View` in
// `ring` of rust/tiles.

struct Ring {
    // What tiles without a block read as: a colour, or a coefficient of displacement.
    blank: vec4<f32>,
    // Where rings and their entries begin in the topology.
    rings: u32,
    entries: u32,
    // The number of this update, by which a vertex is made once.
    run: u32,
    // What texels are: 0 half floats, 1 colours of 8 bits, 2 those of half floats, 3 vectors (see FRAMED).
    format: u32,
    // Words of a block that is worked on; 0 without such blocks.
    room: u32,
    // 1 where tiles without a block count as blank ones.
    loose: u32,
    // Of mips texels along an edge of the cage, at most: every tile is seen at the level that is nearest to it. 0 for the
    // tiles themselves.
    density: u32,
    // The mips that are made of what is below them.
    level: u32,
    // Zero, which compilers do not know.
    zero: u32,
}

/// 1 where texels are vectors of three half floats, which lie in the frames of their tiles.
override FRAMED: u32 = 0u;

// The tiles to bring up to date, and first how many.
@group(0) @binding(0) var<storage, read> listed: array<u32>;
@group(0) @binding(1) var<storage, read> counts: array<u32>;
// Of every tile the block that is worked on, if there are such blocks, and those; of mips the first word, and those.
@group(0) @binding(2) var<storage, read> pointers: array<u32>;
@group(0) @binding(3) var<storage, read_write> blocks: array<atomic<u32>>;
// Of every tile the first word of its block, and its texels a side; the latter again, of tiles without a block too if these
// count as blank ones.
@group(0) @binding(4) var<storage, read> entries: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> sizes: array<vec2<u32>>;
@group(0) @binding(6) var<storage, read_write> texels: array<atomic<u32>>;
// Of every tile four links and four rings, see `DeviceRing`, then what means of bytes go by: of every byte its linear value
// in 65,535ths, and the least sum of four of them, in sixteens, that is the byte. Then of every ring the first entry and
// the class, then of every entry the tile and where it is.
@group(0) @binding(7) var<storage, read> topology: array<u32>;
// Of every ring the update that made it, whether it gives all its texels one value, and that.
@group(0) @binding(8) var<storage, read_write> vertices: array<atomic<u32>>;
var<immediate> work: Ring;

const NONE: u32 = 0xffffffffu;
const TILE_WORDS: u32 = 20u;
const VERTEX_WORDS: u32 = 4u;

fn is_there(tile: u32) -> bool {
    return work.loose == 1u || entries[tile].x != NONE;
}

fn is_sub(tile: u32) -> u32 {
    return (topology[TILE_WORDS * tile] >> 9u) & 1u;
}

/// The level at which a tile is seen.
fn level_of(tile: u32) -> u32 {
    if work.density == 0u {
        return 0u;
    }
    let size = sizes[tile].y;
    return min(firstLeadingBit(max((size << is_sub(tile)) / work.density, 1u)), firstTrailingBit(size) - 1u);
}

fn size_of(tile: u32) -> u32 {
    return sizes[tile].y >> level_of(tile);
}

/// Whether what is brought up to date of a tile is of this density.
fn is_updated(tile: u32) -> bool {
    return work.density == 0u || (level_of(tile) > 0u && size_of(tile) << is_sub(tile) == work.density);
}

/// Texels along an edge of the cage.
fn density_of(tile: u32) -> u32 {
    return select(0u, size_of(tile) << is_sub(tile), is_there(tile));
}

fn block_of(tile: u32) -> u32 {
    if work.room == 0u {
        return NONE;
    }
    return pointers[tile];
}

fn is_wide() -> bool {
    return work.format == 2u;
}
