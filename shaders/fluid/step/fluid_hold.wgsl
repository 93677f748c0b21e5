// import fluid
// Particles that would go through a moving triangle in a step are held before it, as `sweep.rs`. Lengths are relative to the
// support radius and places to the particle's, so that numbers of 32 bits do; how far rounding leads is far less than the gap
// that stays before a triangle.

/// As in `sweep.rs`.
const GAP: vec2<f32> = vec2(0.01, 1e-6);
const MEETINGS: u32 = 8u;
/// How far beyond a side of a triangle counts as within, as a share of it.
const BEYOND: f32 = 1e-5;
/// A time at which nothing is met.
const NEVER: f32 = 2.0;

@group(0) @binding(0) var<storage, read> places: array<vec4<f32>>;
/// Of every cell its first triangle in the list and the one after its last: triangles that a particle in it may meet.
@group(0) @binding(1) var<storage, read> cells: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> list: array<u32>;
/// Three points, and as bits the friction, or a negative number where particles stay where they meet it.
@group(0) @binding(3) var<storage, read> triangles: array<vec4<u32>>;
/// In m when the step begins, and m/s.
@group(0) @binding(4) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> paces: array<vec4<f32>>;
@group(1) @binding(0) var<storage, read_write> predicted: array<vec4<f32>>;
/// Velocities after what was met, with 1, or 0 where nothing was.
@group(1) @binding(1) var<storage, read_write> held: array<vec4<f32>>;
/// By how much they have changed, in m/s.
@group(1) @binding(2) var<storage, read_write> changes: array<vec4<f32>>;

struct Hit {
    /// In 0..1 of the step.
    time: f32,
    weights: vec3<f32>,
    /// Towards where the particle came from.
    normal: vec3<f32>,
    triangle: u32,
}

fn volume(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> f32 {
    return dot(a, cross(b, c));
}

fn value_at(terms: vec4<f32>, time: f32) -> f32 {
    return ((terms.w * time + terms.z) * time + terms.y) * time + terms.x;
}

/// A time between 0 and 1, or NEVER.
fn turn_at(over: f32, under: f32) -> f32 {
    if abs(over) < abs(under) && over * under > 0.0 {
        return over / under;
    }
    return NEVER;
}

/// Where a polynomial of the third degree turns, in order.
fn turns(terms: vec4<f32>) -> vec2<f32> {
    let a = 3.0 * terms.w;
    let b = 2.0 * terms.z;
    let root = sqrt(max(b * b - 4.0 * a * terms.y, 0.0));
    let q = -0.5 * (b + select(root, -root, b < 0.0));
    let turns = vec2(turn_at(q, a), turn_at(terms.y, q));
    return vec2(min(turns.x, turns.y), max(turns.x, turns.y));
}

/// Where a particle at 0 that stays there meets a triangle of these corners that moves so far.
fn meet(corners: array<vec3<f32>, 3>, motions: array<vec3<f32>, 3>) -> Hit {
    var hit = Hit(NEVER, vec3(0.0), vec3(0.0), 0u);
    let a = corners[0];
    let b = corners[1];
    let c = corners[2];
    let u = motions[0];
    let v = motions[1];
    let w = motions[2];
    let low = min(min(min(a, b), c), min(min(a + u, b + v), c + w));
    let high = max(max(max(a, b), c), max(max(a + u, b + v), c + w));
    if any(low > vec3(0.0)) || any(high < vec3(0.0)) {
        return hit;
    }
    let terms = vec4(
        volume(a, b, c),
        volume(u, b, c) + volume(a, v, c) + volume(a, b, w),
        volume(u, v, c) + volume(u, b, w) + volume(a, v, w),
        volume(u, v, w),
    );
    let stops = vec3(turns(terms), 1.0);
    var start = 0.0;
    for (var k = 0u; k < 3u && hit.time == NEVER; k++) {
        let stop = stops[k];
        if stop > 1.0 {
            continue;
        }
        let before = value_at(terms, start);
        if before != 0.0 && before * value_at(terms, stop) <= 0.0 {
            var least = start;
            var most = stop;
            for (var step = 0u; step < 24u; step++) {
                let middle = 0.5 * (least + most);
                if before * value_at(terms, middle) > 0.0 {
                    least = middle;
                } else {
                    most = middle;
                }
            }
            let p = a + most * u;
            let q = b + most * v;
            let r = c + most * w;
            let normal = cross(q - p, r - p);
            let square = dot(normal, normal);
            let weights = vec3(volume(normal, q, r), volume(normal, r, p), volume(normal, p, q)) / square;
            if square > 0.0 && all(weights >= vec3(-BEYOND)) {
                hit = Hit(most, weights, normal * (-sign(before) / sqrt(square)), 0u);
            }
        }
        start = stop;
    }
    return hit;
}

/// The first triangle that the particle of a place meets on a straight way.
fn first_hit(place: vec3<f32>, way: vec3<f32>, range: vec2<u32>) -> Hit {
    var first = Hit(NEVER, vec3(0.0), vec3(0.0), 0u);
    for (var k = range.x; k < range.y; k++) {
        let triangle = triangles[list[k]];
        var corners: array<vec3<f32>, 3>;
        var motions: array<vec3<f32>, 3>;
        for (var side = 0u; side < 3u; side++) {
            corners[side] = (points[triangle[side]].xyz - place) / fluid.support;
            motions[side] = (fluid.step * paces[triangle[side]].xyz - way) / fluid.support;
        }
        let hit = meet(corners, motions);
        if hit.time < first.time {
            first = hit;
            first.triangle = list[k];
        }
    }
    return first;
}

@compute @workgroup_size(GROUP)
fn hold(id: Invocation) {
    let particle = linear_item(id);
    if particle >= fluid.count {
        return;
    }
    let own = places[particle].xyz;
    let range = cells[number_of(cell_of(own))];
    held[particle] = vec4(0.0);
    if range.x == range.y {
        return;
    }
    var way = predicted[particle].xyz - own;
    let far = length(way);
    if far > fluid.spacing {
        way *= fluid.spacing / far;
    }
    let begun = way / fluid.step;
    var velocity = begun;
    var is_held = false;
    for (var meeting = 0u; meeting <= MEETINGS; meeting++) {
        let hit = first_hit(own, way, range);
        if hit.time == NEVER {
            break;
        }
        let triangle = triangles[hit.triangle];
        var surface = vec3(0.0);
        var touched = vec3(0.0);
        for (var side = 0u; side < 3u; side++) {
            surface += hit.weights[side] * paces[triangle[side]].xyz;
            touched += hit.weights[side] * (points[triangle[side]].xyz - own);
        }
        touched += fluid.step * surface;
        let relative = velocity - surface;
        let into = max(-dot(relative, hit.normal), 0.0);
        let along = relative + into * hit.normal;
        let friction = bitcast<f32>(triangle.w);
        var kept = vec3(0.0);
        // What meets one triangle after the other is in a wedge between them.
        if friction >= 0.0 && meeting < MEETINGS {
            kept = along * max(1.0 - friction * into / max(length(along), 1e-30), 0.0);
        }
        let size = abs(own + touched);
        let gap = GAP.x * fluid.spacing + GAP.y * max(max(size.x, size.y), size.z);
        way = touched + gap * hit.normal + (1.0 - hit.time) * fluid.step * kept;
        velocity = surface + kept;
        is_held = true;
    }
    if is_held {
        predicted[particle] = vec4(own + way, predicted[particle].w);
        held[particle] = vec4(velocity, 1.0);
        changes[particle] = vec4(velocity - begun, 0.0);
    }
}
