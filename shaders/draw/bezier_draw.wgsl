// import bezier
// import shade
// Bézier patches drawn from virtual vertices: three ways to hold their control points (Concheiro et al. 2013, Sections
// 4.1 and 4.2, and storage buffers).

struct Draw {
    /// The first patch.
    first: u32,
}

/// Marks vertices of triangles that close gaps beside finer edges.
const STITCH: u32 = 0x10000000u;

/// Patches of a row of the texture.
const TEXTURE_ROW: u32 = 120u;

/// The control points of the patches of a draw, sixteen patches at most.
@group(1) @binding(0) var<uniform> chunk: array<vec4<f32>, 272>;
@group(1) @binding(1) var records: texture_2d<f32>;
@group(1) @binding(2) var<storage, read> stored: array<vec4<f32>>;
var<immediate> call: Draw;

struct Vertex {
    @location(0) uv: vec2<f32>,
    @location(1) patch_index: u32,
    @location(2) sample_index: u32,
}

fn drawn(sample: Sample, sample_index: u32, number: f32) -> Shaded {
    let place = vec2<f32>(sample_place(sample_index));
    let stitch = (sample_index & STITCH) != 0u;
    let grid = select(vec3(place, place.x + place.y), vec3(0.5), stitch);
    // Patches have no tiles: what their parameters are says whether a triangle is one beside a finer edge.
    return shaded(sample.p, sample.normal, grid, vec2(select(0.0, 1.0, stitch)), u32(number), 0xffffffffu);
}

fn located(vertex: Vertex, edges: f32) -> Place {
    return place_of(vertex.sample_index, vertex.uv, u32(edges));
}

@vertex
fn vertex_uniform(vertex: Vertex) -> Shaded {
    let base = RECORD * vertex.patch_index;
    let last = chunk[base + 16u];
    let place = located(vertex, last.x);
    var c: array<vec4<f32>, 16>;
    for (var k = 0; k < 16; k++) {
        c[k] = chunk[base + control_number(place.frame, k % 4, k / 4)];
    }
    return drawn(sample_of(c, place), vertex.sample_index, last.y);
}

@vertex
fn vertex_texture(vertex: Vertex) -> Shaded {
    let index = call.first + vertex.patch_index;
    let base = vec2<u32>(RECORD * (index % TEXTURE_ROW), index / TEXTURE_ROW);
    let last = textureLoad(records, base + vec2<u32>(16u, 0u), 0);
    let place = located(vertex, last.x);
    var c: array<vec4<f32>, 16>;
    for (var k = 0; k < 16; k++) {
        c[k] = textureLoad(records, base + vec2<u32>(control_number(place.frame, k % 4, k / 4), 0u), 0);
    }
    return drawn(sample_of(c, place), vertex.sample_index, last.y);
}

@vertex
fn vertex_buffer(vertex: Vertex) -> Shaded {
    let base = RECORD * (call.first + vertex.patch_index);
    let last = stored[base + 16u];
    let place = located(vertex, last.x);
    var c: array<vec4<f32>, 16>;
    for (var k = 0; k < 16; k++) {
        c[k] = stored[base + control_number(place.frame, k % 4, k / 4)];
    }
    return drawn(sample_of(c, place), vertex.sample_index, last.y);
}

/// Points and normals that were computed before: what drawing the same strips costs by itself.
@vertex
fn vertex_passed(@location(0) p: vec3<f32>, @location(1) sample_index: u32, @location(2) normal: vec3<f32>) -> Shaded {
    return drawn(Sample(p, normal), sample_index, 0.0);
}

@fragment
fn fragment(in: Shaded, @builtin(front_facing) front: bool) -> Pixel {
    var facing = facing_of(in);
    var side = front;
    if in.uv.x > 0.5 && any(in.normal != vec3(0.0)) {
        // A triangle beside a finer edge is as thin as the tolerance and lies in any direction: the surface's counts.
        side = (dot(in.normal, in.p) < 0.0) != (object.mirrored == 1u);
        facing = normalize(select(-in.normal, in.normal, dot(in.normal, in.p) < 0.0));
    }
    return pixel_of(in, facing, side, object.base_color);
}
