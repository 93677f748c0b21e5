// import imprint_rim_measure
// import imprint_under
// import imprint_vectors
// Coefficients of tiles around a contact before the imprint.

// Blocks of tiles that are worked on.
@group(0) @binding(8) var<storage, read> worked: array<u32>;

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

// Coefficient k of a piece, of the undisplaced surface, and whether it may rise.
fn measured(it: Patchwork, k: u32) -> Measured {
    var made: Measured;
    made.is_there = k < it.edge * it.edge;
    if !made.is_there {
        return made;
    }
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
    made.point = vec4(sample.p, length / f32(it.size * it.size));
    made.half = coefficient(it, k, (cell.y + 1u) * (it.size + 2u) + cell.x + 1u);
    let up = across * (value(made.half) / max(length, 1.1754944e-38));
    let foot = sample.p + way_at(it.tile, uv, sample, foot_of(sample));
    let place = foot + vec3(rounded(up.x), rounded(up.y), rounded(up.z));
    made.is_free = length > 0.0 && !is_under(place);
    return made;
}

// The largest distance of neighbours on a piece, by the largest area that a coefficient stands for.
fn spacing_of(_it: Patchwork, area: f32) -> f32 {
    return 2.0 * sqrt(area);
}
