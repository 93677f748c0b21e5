// import imprint_rim
// import imprint_under
// import imprint_vectors
// The pieces around a contact before the imprint: places, areas, coefficients, and which are under the collider.

// Blocks of tiles that are worked on.
@group(0) @binding(8) var<storage, read> worked: array<u32>;

var<workgroup> low: array<vec4<f32>, 256>;
var<workgroup> high: array<vec4<f32>, 256>;
var<workgroup> free: array<atomic<u32>, 8>;

// The coefficient as imprints of earlier dispatches left it.
fn coefficient(it: Patchwork, k: u32, texel: u32) -> u32 {
    if (work.flags & WORKED) != 0u {
        let slot = atomicLoad(&slots[work.slots + it.tile * work.stride + SLOT_BLOCK]);
        if is_block(slot) {
            return (worked[(slot - 1u) * work.block_words + texel / 2u] >> (16u * (texel & 1u))) & 0xffffu;
        }
    } else {
        let slot = atomicLoad(&slots[block_slot(it)]);
        if slot != 0u {
            return (records[RECORD * (slot - 1u) + HEADER + k / 2u] >> (16u * (k & 1u))) & 0xffffu;
        }
    }
    let first = tiles_entries[it.tile].first;
    if first == TILES_NONE {
        return 0u;
    }
    return (tiles_texels[first + texel / 2u] >> (16u * (texel & 1u))) & 0xffffu;
}

@compute @workgroup_size(GROUP)
fn gather(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) k: u32,
) {
    let piece = linear_group(group, groups);
    let there = piece < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    if k < 8u {
        atomicStore(&free[k], 0u);
    }
    low[k] = vec4(1e38, 1e38, 1e38, 0.0);
    high[k] = vec4(-1e38, -1e38, -1e38, 0.0);
    workgroupBarrier();
    if there {
        let it = patchwork(listed[piece]);
        var point = vec4(0.0);
        var half = 0u;
        if k < it.edge * it.edge {
            let cell = vec2(it.block % it.across, it.block / it.across) * it.edge + vec2(k % it.edge, k / it.edge);
            let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(it.size);
            let found = surface_find(it.tile, uv);
            var sample: SurfaceSample;
            if found != SURFACE_NONE {
                sample = sample_patch(found, uv);
            }
            let du = sample.du;
            let dv = sample.dv;
            let across = vec3(
                rounded(du.y * dv.z) - rounded(dv.y * du.z),
                rounded(du.z * dv.x) - rounded(dv.z * du.x),
                rounded(du.x * dv.y) - rounded(dv.x * du.y),
            );
            let square = (rounded(across.x * across.x) + rounded(across.y * across.y)) + rounded(across.z * across.z);
            let length = sqrt(square);
            point = vec4(sample.p, length / f32(it.size * it.size));
            half = coefficient(it, k, (cell.y + 1u) * (it.size + 2u) + cell.x + 1u);
            let up = across * (value(half) / max(length, 1.1754944e-38));
            let foot = sample.p + way_at(it.tile, uv, sample, foot_of(sample));
            let place = foot + vec3(rounded(up.x), rounded(up.y), rounded(up.z));
            if length > 0.0 && !is_under(place) {
                atomicOr(&free[k / 32u], 1u << (k % 32u));
            }
            low[k] = point;
            high[k] = point;
        }
        points[256u * piece + k] = point;
        pieces[PIECE * piece + k] = half << 16u;
        if k == 0u {
            places[place_of(it.tile, it.block)] = piece | ((step.link + 1u) << 24u);
        }
    }
    // The box of the points, and the largest area.
    for (var reach = 128u; reach > 0u; reach /= 2u) {
        workgroupBarrier();
        if k < reach {
            low[k] = min(low[k], low[k + reach]);
            high[k] = max(high[k], high[k + reach]);
        }
    }
    workgroupBarrier();
    if !there {
        return;
    }
    let first = PIECE * piece;
    if k < 3u {
        pieces[first + BOX + k] = bitcast<u32>(low[0][k]);
        pieces[first + BOX + 3u + k] = bitcast<u32>(high[0][k]);
    }
    if k < 8u {
        pieces[first + FREE + k] = atomicLoad(&free[k]);
    }
    if k == 0u {
        pieces[first + SPACING] = bitcast<u32>(2.0 * sqrt(high[0].w));
        pieces[first + RECORD_OF] = 0u;
    }
}
