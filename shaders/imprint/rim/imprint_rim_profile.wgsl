// import imprint_rim
// The rim's profile over a piece: the share of its height by the distance to the nearest border, and of which patch. The
// volumes that patches pushed away and the room for them are sums of whole numbers, whichever comes first.

// Pieces with borders near one at most: with 256 borders each, four an iteration, fewer than the iterations at which some
// devices stop.
const MAX_NEAR: u32 = 800u;

var<workgroup> near: array<u32, 256>;
var<workgroup> near_count: atomic<u32>;
var<workgroup> at: array<vec3<f32>, 256>;
// The patch of every border and its key.
var<workgroup> patches: array<vec2<u32>, 256>;

struct Nearest {
    square: f32,
    patch_key: u32,
    patch_cell: u32,
}

fn nearer(best: Nearest, p: vec3<f32>, k: u32) -> Nearest {
    let d = p - at[k];
    let square = fma(d.x, d.x, fma(d.y, d.y, d.z * d.z));
    let patch_of = patches[k];
    if square < best.square || (square == best.square && patch_of.y < best.patch_key) {
        return Nearest(square, patch_of.y, patch_of.x);
    }
    return best;
}

// Whether borders of another piece may be within the width.
fn is_near(piece: u32, other: u32, width: f32) -> bool {
    for (var axis = 0u; axis < 3u; axis++) {
        if number(other, BOX + axis) > number(piece, BOX + 3u + axis) + width
            || number(other, BOX + 3u + axis) < number(piece, BOX + axis) - width {
            return false;
        }
    }
    return true;
}

@compute @workgroup_size(GROUP)
fn profile(id: Invocation) {
    let k = id.local;
    let piece = linear_group(id);
    let there = piece < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    let width = rims[step.link].width;
    var count = 0u;
    if there {
        var any_free = 0u;
        for (var word = 0u; word < 8u; word++) {
            any_free |= pieces[PIECE * piece + FREE + word];
        }
        if any_free != 0u {
            count = atomicLoad(&rim_counters[step.link].edges);
        }
    }
    var point = vec4(0.0);
    if there {
        point = points[256u * piece + k];
    }
    var best = Nearest(width * width, 0u, NONE);
    var looked = 0u;
    for (var base = 0u; base < count; base += 256u) {
        workgroupBarrier();
        if k == 0u {
            atomicStore(&near_count, 0u);
        }
        workgroupBarrier();
        if base + k < count && is_near(piece, edges[base + k].x, width) {
            near[atomicAdd(&near_count, 1u)] = base + k;
        }
        workgroupBarrier();
        let found = atomicLoad(&near_count);
        looked += found;
        if looked > MAX_NEAR {
            atomicOr(&rim_counters[step.link].faults, RIM_MANY);
            break;
        }
        for (var turn = 0u; turn < found; turn++) {
            let edge = edges[near[turn]];
            // Beyond them is nothing near.
            at[k] = vec3(1e30);
            if k < edge.z {
                let border = borders[edge.y + k];
                let cell = bitcast<u32>(border.w);
                if cell != NONE {
                    at[k] = border.xyz;
                    let first = atomicLoad(&cells[CELL * cell + FOLLOWS]);
                    patches[k] = vec2(first, atomicLoad(&cells[CELL * first]));
                }
            }
            workgroupBarrier();
            for (var other = 0u; other < edge.z; other += 4u) {
                best = nearer(best, point.xyz, other);
                best = nearer(best, point.xyz, other + 1u);
                best = nearer(best, point.xyz, other + 2u);
                best = nearer(best, point.xyz, other + 3u);
            }
            workgroupBarrier();
        }
    }
    if !there {
        return;
    }
    let edge = cell_edge();
    let inverse = inverse_of(edge);
    var height = 0.0;
    let at_piece = PIECE * piece;
    if has_bit(piece, PUSHED, k) {
        let word = pieces[at_piece + k];
        let cell = pieces[at_piece + CELLS_OF + k];
        let depth = value(word >> 16u) - value(word & 0xffffu);
        if cell != NONE {
            let first = atomicLoad(&cells[CELL * cell + FOLLOWS]);
            add(CELL * first + VOLUME, whole(depth * point.w * inverse * inverse * inverse));
        }
    } else if has_bit(piece, FREE, k) && best.square < width * width && best.patch_cell != NONE {
        let s = sqrt(best.square) / width;
        height = (1.0 - s) * (1.0 - s) * (1.0 + 2.0 * s);
        pieces[at_piece + CELLS_OF + k] = best.patch_cell;
        if height > 0.0 {
            add(CELL * best.patch_cell + SPACE, whole(height * point.w * inverse * inverse));
        }
    }
    pieces[at_piece + PROFILE + k] = bitcast<u32>(height);
}
