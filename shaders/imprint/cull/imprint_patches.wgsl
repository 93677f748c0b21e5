// import imprint_hull
// Which tiles may have points in the voxel grids of the imprints of a row (Schäfer et al. 2014, Section 5, Culling Geometry
// within Overlap). An invocation takes a patch; tiles are listed once, in any order.

const THREADS: u32 = 64u;

// Of every imprint the number of listed tiles, and the workgroups in x, y and z that take one each.
@group(0) @binding(3) var<storage, read_write> arguments: array<atomic<u32>>;
@group(2) @binding(3) var<storage, read_write> listed: array<u32>;
// The tile of every patch.
@group(2) @binding(4) var<storage, read> owners: array<u32>;

fn list(tile: u32) {
    let at = 4u * step.link;
    let place = atomicAdd(&arguments[at], 1u);
    listed[place] = tile;
    atomicMax(&arguments[at + 1u], min(place + 1u, ROW));
    atomicMax(&arguments[at + 2u], place / ROW + 1u);
    atomicMax(&arguments[at + 3u], 1u);
}

@compute @workgroup_size(THREADS)
fn cull_patches(id: Invocation) {
    let index = linear_group(id) * THREADS + id.local;
    if index >= arrayLength(&owners) {
        return;
    }
    let owner = owners[index];
    var tile = tile_before(owner);
    var met = vec2(0u);
    for (var link = step.link; link != LINK_NONE; link = work.next) {
        take(link);
        if meets(whole(tile, index)) {
            met[link / 32u] |= 1u << (link % 32u);
        }
        tile.least = lowest(tile.least);
    }
    if all(met == vec2(0u)) {
        return;
    }
    let at = MASK_WORDS * owner;
    atomicOr(&masks[at], met.x);
    atomicOr(&masks[at + 1u], met.y);
    if atomicExchange(&masks[at + 2u], 1u) == 0u {
        list(owner);
    }
}
