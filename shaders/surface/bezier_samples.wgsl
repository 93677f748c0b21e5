// import bezier
// Samples of Bézier patches into a buffer: what the vertex stage computes, where it can be read.

struct Samples {
    /// How many there are, and the first of them.
    count: u32,
    start: u32,
    /// The patch of the first copy of the map.
    first: u32,
}

@group(0) @binding(0) var<storage, read> records: array<vec4<f32>>;
/// u, v, patch, sample.
@group(0) @binding(1) var<storage, read> vertices: array<vec4<u32>>;
/// Point and normal of every vertex.
@group(0) @binding(2) var<storage, read_write> samples: array<vec4<f32>>;
var<immediate> wanted: Samples;

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= wanted.count {
        return;
    }
    let vertex = vertices[wanted.start + id.x];
    let base = RECORD * (wanted.first + vertex.z);
    let edges = u32(records[base + 16u].x);
    let uv = bitcast<vec2<f32>>(vertex.xy);
    let place = place_of(vertex.w, uv, edges);
    var c: array<vec4<f32>, 16>;
    for (var k = 0; k < 16; k++) {
        c[k] = records[base + control_number(place.frame, k % 4, k / 4)];
    }
    let sample = sample_of(c, place);
    samples[2u * id.x] = vec4<f32>(sample.p, 1.0);
    samples[2u * id.x + 1u] = vec4<f32>(sample.normal, 0.0);
}
