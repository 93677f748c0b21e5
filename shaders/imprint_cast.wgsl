// import common
// import halves
// import imprint_place
// import imprint_record
// import imprint_solid
// import tiles
// The displacement update of listed blocks: every coefficient's point that lies in the voxels goes along −N until it
// leaves them (Schäfer et al. 2014, Section 6). Blocks that change are kept, on their way back to the host and for the
// imprints of later dispatches. A workgroup takes a block of 256 coefficients through all imprints of a row that may meet
// it, since no ray looks at another block; an invocation takes two, which share a word.

// Further than any ray.
const NEVER: f32 = 1e30;

@group(0) @binding(1) var<storage, read> listed: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> arguments: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> slots: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> told: AllTold;
@group(0) @binding(7) var<storage, read_write> records: array<u32>;
// Blocks of tiles that are worked on.
@group(0) @binding(8) var<storage, read> worked: array<u32>;
// The tiles from when the depth limit began to count.
@group(3) @binding(0) var<storage, read> start_entries: array<TileEntry>;
@group(3) @binding(1) var<storage, read> start_texels: array<u32>;

var<workgroup> sum_changed: atomic<i32>;
var<workgroup> sum_clamped: atomic<i32>;
var<workgroup> least: atomic<i32>;
var<workgroup> shared_place: u32;

// The key of the largest half that is not above a float.
fn key_below(exact: f32) -> i32 {
    let bits = bitcast<u32>(exact);
    let size = bits & 0x7fffffffu;
    var half = 0x7c00u;
    var rest = 0u;
    if size < 0x38800000u {
        let shift = min(126u - (size >> 23u), 31u);
        let digits = (size & 0x7fffffu) | 0x800000u;
        half = digits >> shift;
        rest = select(size, digits & ((1u << shift) - 1u), shift < 25u);
    } else if size < 0x47800000u {
        half = (size - 0x38000000u) >> 13u;
        rest = size & 0x1fffu;
    }
    if bits >= 0x80000000u {
        return -1 - i32(min(half + u32(rest != 0u), 0x7c00u));
    }
    return i32(min(half, 0x7bffu));
}

// The lower end of the piece of a column that has the solid voxel z, or `stop` if it reaches that far.
fn lower_end(column: u32, z: i32, stop: i32) -> i32 {
    let span = spans[work.first_column + column];
    if span != PIECES {
        return i32(span & 0xffffu);
    }
    var base = u32(z) / 32u * 32u;
    var clear = ~word_of(column, base) & (0xffffffffu >> (31u - u32(z) % 32u));
    // All steps of a ray go the same way along z: together they read a column's words once.
    while clear == 0u && i32(base) > stop && base > 0u {
        base -= 32u;
        clear = ~word_of(column, base);
    }
    if clear == 0u {
        return max(stop, 0);
    }
    return i32(base + 32u - countLeadingZeros(clear));
}

// The upper end, the voxel after the last, or the one after `stop`.
fn upper_end(column: u32, z: i32, stop: i32) -> i32 {
    let span = spans[work.first_column + column];
    if span != PIECES {
        return i32(span >> 16u);
    }
    let nz = i32(work.dims.z);
    var base = u32(z) / 32u * 32u;
    var clear = ~word_of(column, base) & (0xffffffffu << (u32(z) % 32u));
    while clear == 0u && i32(base) + 32 <= stop && i32(base) + 32 < nz {
        base += 32u;
        clear = ~word_of(column, base);
    }
    if clear == 0u {
        return min(stop + 1, nz);
    }
    return min(i32(base + countTrailingZeros(clear)), nz);
}

// How far a ray that starts in the solid goes until it leaves it, at most to `limit`, 0 where it leaves in its first
// voxel; and whether it was held at the border of the grid.
fn follow(start: vec3<f32>, direction: vec3<f32>, limit: f32) -> vec2<f32> {
    let dims = vec3<i32>(work.dims);
    let voxel = vec3<i32>(start);
    let ahead = direction > vec3(0.0);
    let still = direction == vec3(0.0);
    let inverse = 1.0 / select(direction, vec3(1.0), still);
    let face = vec3<f32>(voxel + select(vec3(0), vec3(1), ahead));
    let faces = (face - start) * inverse;
    var next = select(vec3(rounded(faces.x), rounded(faces.y), rounded(faces.z)), vec3(NEVER), still);
    let nearest = min(min(next.x, next.y), next.z);
    let delta = select(abs(inverse), vec3(NEVER), still);
    let step = select(vec2(-1, -dims.x), vec2(1, dims.x), ahead.xy);
    // Columns that are left along x and y before the grid ends.
    var left = select(voxel.xy, dims.xy - 1 - voxel.xy, ahead.xy);
    var column = voxel.y * dims.x + voxel.x;
    var z = voxel.z;
    var far = limit;
    var held = false;
    for (var k = 0; k <= dims.x + dims.y; k++) {
        let by_y = next.y <= next.x;
        let side = select(next.x, next.y, by_y);
        // The voxel in which the ray leaves the column, or reaches the limit; −1 below it and `dims.z` above it.
        let height = clamp(start.z + rounded(min(side, limit) * direction.z), -1.0, f32(dims.z));
        let end = i32(round(height - 0.5));
        if direction.z < 0.0 {
            let before = z;
            z = min(end, z);
            let low = lower_end(u32(column), before, z);
            if low > z {
                far = (f32(low) - start.z) * inverse.z;
                held = low == 0;
                break;
            }
        } else if direction.z > 0.0 {
            let before = z;
            z = max(end, z);
            let high = upper_end(u32(column), before, z);
            if high <= z {
                far = (f32(high) - start.z) * inverse.z;
                held = high >= dims.z;
                break;
            }
        }
        if side >= limit || select(left.x, left.y, by_y) == 0 {
            far = side;
            held = true;
            break;
        }
        if by_y {
            left.y -= 1;
            next.y += delta.y;
            column += step.y;
        } else {
            left.x -= 1;
            next.x += delta.x;
            column += step.x;
        }
        if !is_solid(u32(column), z) {
            far = side;
            break;
        }
    }
    if far <= nearest {
        return vec2(0.0);
    }
    return vec2(min(far, limit), select(0.0, 1.0, held && far < limit));
}

// A row of the map, with the processor's roundings.
fn turned(row: vec4<f32>, v: vec3<f32>, base: f32) -> f32 {
    return fma(row.x, v.x, fma(row.y, v.y, fma(row.z, v.z, base)));
}

// A place of the surface with its unit normal, zero where it is degenerate.
struct Foot {
    p: vec3<f32>,
    n: vec3<f32>,
}

fn foot_of(it: SurfaceSample) -> Foot {
    let du = it.du;
    let dv = it.dv;
    let across = vec3(
        rounded(du.y * dv.z) - rounded(du.z * dv.y),
        rounded(du.z * dv.x) - rounded(du.x * dv.z),
        rounded(du.x * dv.y) - rounded(du.y * dv.x),
    );
    let square = fma(across.x, across.x, fma(across.y, across.y, across.z * across.z));
    if !(square > 0.0) {
        return Foot(it.p, vec3(0.0));
    }
    return Foot(it.p, across * (1.0 / sqrt(square)));
}

// The new key of a coefficient, and whether its ray was held.
fn moved(at: Foot, half: u32, start_half: u32) -> vec2<i32> {
    let old = key(half);
    let unchanged = vec2(old, 0);
    let n = at.n;
    let height = value(half);
    let q = at.p - work.origin;
    let up = vec3(turned(work.x, n, 0.0), turned(work.y, n, 0.0), turned(work.z, n, 0.0));
    let foot = vec3(turned(work.x, q, work.x.w), turned(work.y, q, work.y.w), turned(work.z, q, work.z.w));
    let place = fma(vec3(height), up, foot);
    let inside = all(place >= vec3(0.0)) && all(place < vec3<f32>(work.dims));
    let room = min(height + work.max_displacement, work.depth - (value(start_half) - height));
    let limit = room * (1.0 / work.share);
    if !inside || !(limit > 0.0) || all(up == vec3(0.0)) {
        return unchanged;
    }
    let voxel = vec3<u32>(place);
    if !is_solid(voxel.y * work.dims.x + voxel.x, i32(voxel.z)) {
        return unchanged;
    }
    let far = follow(place, -up, limit);
    if far.x <= 0.0 {
        return unchanged;
    }
    let down = max(key_below(height - work.share * far.x), work.deepest);
    return vec2(min(down, old), i32(far.y));
}

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

// Takes a record for a block of `listed` that imprint `link` changed, and tells of it.
fn keep(item: vec4<u32>, link: u32) {
    let clamped = atomicLoad(&sum_clamped);
    if clamped > 0 {
        atomicAdd(&told.links[link].clamped, u32(clamped));
    }
    let changed = atomicLoad(&sum_changed);
    if changed == 0 {
        return;
    }
    let place = atomicAdd(&told.kept, 1u);
    shared_place = place;
    if place >= work.records {
        return;
    }
    let first = RECORD * place;
    let block = item.y & 0xffffu;
    let lowest = atomicLoad(&least);
    records[first] = item.x;
    records[first + 1u] = block | (link << 16u);
    records[first + 2u] = u32(changed);
    records[first + 3u] = u32(lowest);
    if (work.flags & CHAINED) != 0u {
        let slot = work.slots + item.x * work.stride;
        atomicStore(&slots[slot + 1u + block], place + 1u);
        atomicMax(&slots[slot], u32(-lowest));
    }
}

@compute @workgroup_size(PAIRS)
fn cast_rays(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_group(group, groups);
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
            let knot = 2u * local + k;
            // Without a normal nothing changes: beyond the coefficients of a small tile, and in holes.
            var it: SurfaceSample;
            if knot < edge * edge {
                let cell = corner + vec2(knot % edge, knot / edge);
                texels[k] = (cell.y + 1u) * (size + 2u) + cell.x + 1u;
                let uv = (vec2<f32>(cell) + vec2(0.5)) / f32(size);
                let found = surface_find(item.x, uv);
                if found != SURFACE_NONE {
                    it = sample_patch(found, uv);
                }
            }
            feet[k] = foot_of(it);
        }
        pair = coefficients(item.x, block, local, texels);
    }
    let begun = pair.y;
    for (var link = step.link; link != LINK_NONE; link = work.next) {
        work = links[link];
        if ((item[2u + link / 32u] >> (link % 32u)) & 1u) == 0u {
            continue;
        }
        if local == 0u {
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
            let ray = moved(feet[k], old, (start >> (16u * k)) & 0xffffu);
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
        if local == 0u {
            keep(item, link);
        }
        workgroupBarrier();
        let place = shared_place;
        if place < work.records {
            records[RECORD * place + HEADER + local] = changed;
        }
        workgroupBarrier();
    }
}
