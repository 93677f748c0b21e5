// import common
// import imprint_link
// The pieces around a contact on a triangle mesh: all parts, 256 values each, of the blocks of listed triangles.

/// Parts of a triangle's block.
override PARTS: u32 = 13u;

@group(0) @binding(1) var<storage, read> faces: array<u32>;
@group(0) @binding(2) var<storage, read> faces_arguments: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> listed: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(5) var<storage, read_write> counters: AllCounters;

// Pieces are as blocks of 16 × 16 coefficients.
const EDGE: u32 = 16u;

@compute @workgroup_size(GROUP)
fn list_pieces(id: Invocation) {
    let index = linear_group(id) * GROUP + id.local;
    work = links[step.link];
    let found = faces_arguments[2u * step.link + 1u].x;
    if index == 0u {
        let count = min(found * PARTS, work.room);
        let at = 8u * step.link + 4u;
        arguments[at] = count;
        arguments[at + 1u] = min(count, ROW);
        arguments[at + 2u] = (count + ROW - 1u) / ROW;
        arguments[at + 3u] = 1u;
        atomicStore(&counters.links[step.link].found, found * PARTS);
    }
    if index >= found {
        return;
    }
    for (var part = 0u; part < PARTS; part++) {
        if index * PARTS + part < work.room {
            listed[index * PARTS + part] = vec4(faces[index], part | (EDGE << 16u), 0u, 0u);
        }
    }
}
