// import common
// import halves
// import imprint_keep
// import imprint_ray
// import imprint_vectors
// The displacement update of listed blocks: every coefficient's point that lies in the voxels goes along −N until it
// leaves them (Schäfer et al. 2014, Section 6). Blocks that change are kept, on their way back to the host and for the
// imprints of later dispatches. A workgroup takes a block of 256 coefficients through all imprints of a row that may meet
// it, since no ray looks at another block; an invocation takes two, which share a word.

@group(0) @binding(1) var<storage, read> listed: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> arguments: array<vec4<u32>>;
// Blocks of tiles that are worked on.
@group(0) @binding(8) var<storage, read> worked: array<u32>;
// The tiles from when the depth limit began to count.
@group(3) @binding(0) var<storage, read> start_entries: array<TileEntry>;
@group(3) @binding(1) var<storage, read> start_texels: array<u32>;

// Of two coefficients of a block, which share a word, what they are, and what they were at the start if the imprint that is
// worked on tells of one. There is no texel for what is beyond a small tile.
fn coefficients(tile: u32, block: u32, local: u32, texels: vec2<u32>) -> vec2<u32> {
    var pair = vec2(0u);
    let first = tiles_entries[tile].first;
    var block_first = TILES_NONE;
    if (work.flags & WORKED) != 0u {
        let slot = atomicLoad(&slots[work.slots + tile * work.stride + SLOT_BLOCK]);
        block_first = select(TILES_NONE, (slot - 1u) * work.block_words, is_block(slot));
    }
    var start_first = TILES_NONE;
    if (work.flags & STARTED) != 0u {
        start_first = start_entries[tile].first;
    }
    for (var k = 0u; k < 2u; k++) {
        let texel = texels[k];
        let lane = 16u * (texel & 1u);
        if texel != NONE && block_first != TILES_NONE {
            pair.x |= ((worked[block_first + texel / 2u] >> lane) & 0xffffu) << (16u * k);
        } else if texel != NONE && first != TILES_NONE {
            pair.x |= ((tiles_texels[first + texel / 2u] >> lane) & 0xffffu) << (16u * k);
        }
        if texel != NONE && start_first != TILES_NONE {
            pair.y |= ((start_texels[start_first + texel / 2u] >> lane) & 0xffffu) << (16u * k);
        }
    }
    if (work.flags & CHAINED) != 0u {
        let slot = atomicLoad(&slots[work.slots + tile * work.stride + 1u + block]);
        if slot != 0u {
            pair.x = records[RECORD * (slot - 1u) + HEADER + local];
        }
    }
    return pair;
}

@compute @workgroup_size(PAIRS)
fn cast_rays(id: Invocation) {
    let index = linear_group(id);
    let there = index < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    var item = vec4(0u);
    var feet: array<Foot, 2>;
    var pair = vec2(0u);
    if there {
        item = listed[index];
        let size = item.y >> 16u;
        let edge = min(size, EDGE);
        let across = size / edge;
        let block = item.y & 0xffffu;
        let corner = vec2(block % across, block / across) * edge;
        var texels = vec2(NONE);
        for (var k = 0u; k < 2u; k++) {
            let knot = 2u * id.local + k;
            // Without a normal nothing changes: beyond the coefficients of a small tile, and in holes.
            var it: SurfaceSample;
            var uv = vec2(0.5);
            if knot < edge * edge {
                let cell = corner + vec2(knot % edge, knot / edge);
                texels[k] = (cell.y + 1u) * (size + 2u) + cell.x + 1u;
                uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
                let found = surface_find(item.x, uv);
                if found != SURFACE_NONE {
                    it = sample_patch(found, uv);
                }
            }
            feet[k] = foot_of(it);
            feet[k].p += way_at(item.x, uv, it, feet[k]);
        }
        pair = coefficients(item.x, block, id.local, texels);
    }
    let begun = pair.y;
    for (var link = step.link; link != LINK_NONE; link = work.next) {
        work = links[link];
        if ((item[2u + link / 32u] >> (link % 32u)) & 1u) == 0u {
            continue;
        }
        if id.local == 0u {
            atomicStore(&sum_changed, 0);
            atomicStore(&sum_clamped, 0);
            atomicStore(&least, 0);
            shared_place = NONE;
        }
        workgroupBarrier();
        let start = select(pair.x, begun, (work.flags & STARTED) != 0u);
        var changed = 0u;
        var differ = 0;
        var clamped = 0;
        for (var k = 0u; k < 2u; k++) {
            let old = (pair.x >> (16u * k)) & 0xffffu;
            let ray = moved(feet[k].p, feet[k].n, old, (start >> (16u * k)) & 0xffffu);
            changed |= half_of(ray.x) << (16u * k);
            differ += i32(ray.x != key(old));
            clamped += ray.y;
            atomicMin(&least, ray.x);
        }
        if differ > 0 {
            atomicAdd(&sum_changed, differ);
        }
        if clamped > 0 {
            atomicAdd(&sum_clamped, clamped);
        }
        pair.x = changed;
        workgroupBarrier();
        if id.local == 0u {
            keep(item, link);
        }
        workgroupBarrier();
        let place = shared_place;
        if place < work.records {
            records[RECORD * place + HEADER + id.local] = changed;
        }
        workgroupBarrier();
    }
}
