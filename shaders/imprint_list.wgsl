// import common
// The blocks that culling left of the tiles to modify, in any order, and how many there are: the stages that follow
// take each by itself.

struct Listing {
    // Blocks that there is room for.
    room: u32,
    // Which of the imprints this is that are submitted together.
    link: u32,
}

const ROW: u32 = 32768u;

// Words that are told of an imprint.
const TOLD: u32 = 8u;

// Texels along a block at most.
const EDGE: u32 = 16u;

// The tiles to modify come first, see `compaction`.
@group(0) @binding(0) var<storage, read> tiles: array<u32>;
@group(0) @binding(1) var<storage, read> counts: array<u32>;
// Bits of the blocks, eight words a tile; the last number of a tile has its size, see `imprint_cull`.
@group(0) @binding(2) var<storage, read> blocks: array<u32>;
@group(0) @binding(3) var<storage, read> culled: array<vec4<u32>>;
// A tile, and a block of it with the tile's size in the upper half.
@group(1) @binding(0) var<storage, read_write> listed: array<vec2<u32>>;
// Four words, the first of which is the blocks that are kept, then eight of every imprint: blocks that were found, held
// rays, tiles, faults in voxelising, coefficients, and three unused.
@group(1) @binding(1) var<storage, read_write> told: array<atomic<u32>>;
// The number of blocks that are listed, and the workgroups in x, y and z that take one each.
@group(1) @binding(2) var<storage, read_write> arguments: array<u32>;
var<immediate> work: Listing;

@compute @workgroup_size(GROUP)
fn list(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_group(group, groups) * GROUP + local;
    if index >= counts[0] {
        return;
    }
    let tile = tiles[index];
    let size = culled[tile].w & 0xffffu;
    var count = 0u;
    for (var k = 0u; k < 8u; k++) {
        count += countOneBits(blocks[8u * tile + k]);
    }
    var at = atomicAdd(&told[4u + TOLD * work.link], count);
    let edge = min(size, EDGE);
    atomicAdd(&told[4u + TOLD * work.link + 4u], count * edge * edge);
    for (var k = 0u; k < 8u; k++) {
        for (var bits = blocks[8u * tile + k]; bits != 0u; bits &= bits - 1u) {
            if at < work.room {
                listed[at] = vec2(tile, (32u * k + countTrailingZeros(bits)) | (size << 16u));
            }
            at++;
        }
    }
}

@compute @workgroup_size(1)
fn arrange() {
    let count = min(atomicLoad(&told[4u + TOLD * work.link]), work.room);
    atomicStore(&told[4u + TOLD * work.link + 2u], counts[0]);
    arguments[0] = count;
    arguments[1] = min(count, ROW);
    arguments[2] = (count + ROW - 1u) / ROW;
    arguments[3] = 1u;
}
