// import halves
// import imprint_exit
// A ray from the point of a coefficient along −N until it leaves the surface that was voxelised (Schäfer et al. 2014,
// Section 6), with the processor's roundings.

// Further than any ray.
const NEVER: f32 = 1e30;

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

// How far a ray that starts in a solid voxel goes until it leaves the surface, at most to `limit`; and whether it was held at
// the border of the grid.
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
    var exit = Exit(limit, APART, false, false);
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
                exit = end_exit(u32(column), low, (f32(low) - start.z) * inverse.z, false);
                break;
            }
        } else if direction.z > 0.0 {
            let before = z;
            z = max(end, z);
            let high = upper_end(u32(column), before, z);
            if high <= z {
                exit = end_exit(u32(column), high, (f32(high) - start.z) * inverse.z, true);
                break;
            }
        }
        if side >= limit || select(left.x, left.y, by_y) == 0 {
            exit = Exit(side, APART, false, true);
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
            exit = side_exit(u32(column), z, side, fma(side, direction.z, start.z));
            break;
        }
    }
    if exit.far >= limit || exit.held {
        // At the border of the grid, leaving in the first step changes nothing.
        let goes = exit.far > nearest;
        return vec2(select(0.0, min(exit.far, limit), goes), select(0.0, 1.0, goes && exit.far < limit));
    }
    return vec2(min(refined(start, direction, exit), limit), 0.0);
}

// A row of the map, with the processor's roundings.
fn turned(row: vec4<f32>, v: vec3<f32>, base: f32) -> f32 {
    return fma(row.x, v.x, fma(row.y, v.y, fma(row.z, v.z, base)));
}

// The new key of the coefficient of a point with its unit normal, zero where it is degenerate, and whether its ray was
// held.
fn moved(p: vec3<f32>, n: vec3<f32>, half: u32, start_half: u32) -> vec2<i32> {
    let old = key(half);
    let unchanged = vec2(old, 0);
    let height = value(half);
    let q = p - work.origin;
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
    let column = voxel.y * work.dims.x + voxel.x;
    var far: vec2<f32>;
    if is_solid(column, i32(voxel.z)) {
        far = follow(place, -up, limit);
    } else {
        // Next to an end the surface may be further out than voxels are solid.
        let span = spans[work.first_column + column];
        let upper = voxel.z == span >> 16u;
        if span >> 16u == 0u || !(upper || voxel.z + 1u == (span & 0xffffu)) {
            return unchanged;
        }
        far.x = min(refined(place, -up, Exit(0.0, 0.0, upper, false)), limit);
    }
    if far.x <= 0.0 {
        return unchanged;
    }
    let down = max(key_below(height - work.share * far.x), work.deepest);
    return vec2(min(down, old), i32(far.y));
}
