// import common
// import tiles
// The displaced surface at many places.

@group(0) @binding(0) var<storage, read> places: array<Place>;
// Position and normal of every place, three numbers each.
@group(0) @binding(1) var<storage, read_write> points: array<f32>;
var<immediate> count: u32;

@compute @workgroup_size(GROUP)
fn evaluate(id: Invocation) {
    let index = linear_group(id) * GROUP + id.local;
    if index >= count {
        return;
    }
    let place = places[index];
    var displaced: Displaced;
    if place.tile < arrayLength(&tiles_entries) {
        displaced = tiles_displaced(place.tile, vec2(place.u, place.v));
    }
    for (var axis = 0u; axis < 3u; axis++) {
        points[6u * index + axis] = displaced.p[axis];
        points[6u * index + 3u + axis] = displaced.normal[axis];
    }
}
