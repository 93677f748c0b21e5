// import common
// import halves
// import imprint_tile
// import tiles
// The least and the largest coefficient of tiles that changed, by which culling widens their hulls: extrema of whole numbers
// do not depend on the order that these are met in. A workgroup takes a tile.

struct Measuring {
    tiles: u32,
}

// Tiles, how many texels they have along an edge, and as the bits of a float how long vectors over them are.
@group(0) @binding(0) var<storage, read> changed: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> measured: array<CullTile>;
var<immediate> work: Measuring;

var<workgroup> least: atomic<i32>;
var<workgroup> most: atomic<i32>;

@compute @workgroup_size(GROUP)
fn measure(id: Invocation) {
    let index = linear_group(id);
    let there = index < work.tiles;
    if id.local == 0u {
        atomicStore(&least, 0x7fff);
        atomicStore(&most, -0x8000);
    }
    workgroupBarrier();
    var tile = vec4(0u);
    var first = TILES_NONE;
    if there {
        tile = changed[index];
        first = tiles_entries[tile.x].first;
    }
    if first != TILES_NONE {
        let words = (tile.y + 2u) * (tile.y + 2u) / 2u;
        var low = 0x7fff;
        var high = -0x8000;
        for (var word = id.local; word < words; word += GROUP) {
            let pair = tiles_texels[first + word];
            let keys = vec2(key(pair & 0xffffu), key(pair >> 16u));
            low = min(low, min(keys.x, keys.y));
            high = max(high, max(keys.x, keys.y));
        }
        atomicMin(&least, low);
        atomicMax(&most, high);
    }
    workgroupBarrier();
    if there && id.local == 0u {
        // A tile without a block is not displaced.
        var it = CullTile(0.0, 0.0, tile.y, bitcast<f32>(tile.z));
        if first != TILES_NONE {
            it.least = value(half_of(atomicLoad(&least)));
            it.most = value(half_of(atomicLoad(&most)));
        }
        measured[tile.x] = it;
    }
}
