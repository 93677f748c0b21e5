// import common
// import surface
// Evaluation at many places.

@group(0) @binding(0) var<storage, read> places: array<Place>;
// P, du, dv, duu, duv, dvv of every place, as many as `QUANTITIES`, three numbers each.
@group(0) @binding(1) var<storage, read_write> samples: array<f32>;
var<immediate> count: u32;

override QUANTITIES: u32 = 6u;

@compute @workgroup_size(GROUP)
fn evaluate(id: Invocation) {
    let index = linear_group(id) * GROUP + id.local;
    if index >= count {
        return;
    }
    let place = places[index];
    let uv = vec2(place.u, place.v);
    let found = surface_find(place.tile, uv);
    var sample: SurfaceSample;
    if found != SURFACE_NONE {
        sample = surface_evaluate(found, uv);
    }
    let first = 3u * QUANTITIES * index;
    for (var axis = 0u; axis < 3u; axis++) {
        samples[first + axis] = sample.p[axis];
        if QUANTITIES > 1u {
            samples[first + 3u + axis] = sample.du[axis];
            samples[first + 6u + axis] = sample.dv[axis];
        }
        if QUANTITIES > 3u {
            samples[first + 9u + axis] = sample.duu[axis];
            samples[first + 12u + axis] = sample.duv[axis];
            samples[first + 15u + axis] = sample.dvv[axis];
        }
    }
}
