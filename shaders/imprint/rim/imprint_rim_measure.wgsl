// import imprint_rim
// needs measured
// needs spacing_of
// The pieces around a contact before the imprint: places, areas, values, and which are under the collider.

// A value of a piece before the imprint: its point on the undisplaced surface with the area that it stands for, its half
// float, and whether it may rise.
struct Measured {
    point: vec4<f32>,
    half: u32,
    is_there: bool,
    is_free: bool,
}

var<workgroup> low: array<vec4<f32>, 256>;
var<workgroup> high: array<vec4<f32>, 256>;
var<workgroup> free: array<atomic<u32>, 8>;

@compute @workgroup_size(GROUP)
fn gather(id: Invocation) {
    let k = id.local;
    let piece = linear_group(id);
    let there = piece < arguments[2u * step.link + 1u].x;
    work = links[step.link];
    if k < 8u {
        atomicStore(&free[k], 0u);
    }
    low[k] = vec4(1e38, 1e38, 1e38, 0.0);
    high[k] = vec4(-1e38, -1e38, -1e38, 0.0);
    workgroupBarrier();
    var it: Patchwork;
    if there {
        it = patchwork(listed[piece]);
        let made = measured(it, k);
        if made.is_free {
            atomicOr(&free[k / 32u], 1u << (k % 32u));
        }
        if made.is_there {
            low[k] = made.point;
            high[k] = made.point;
        }
        points[256u * piece + k] = made.point;
        pieces[PIECE * piece + k] = made.half << 16u;
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
        pieces[first + SPACING] = bitcast<u32>(spacing_of(it, high[0].w));
        pieces[first + RECORD_OF] = 0u;
    }
}
