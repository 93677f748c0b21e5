// import progressive_edited
// import progressive_bits
// import octahedron
// Which vertices of a progressive mesh a view wants, and what those stand on.

struct ViewCall {
    eye: vec3<f32>,
    /// Pixels of what has the length of its distance.
    pixels: f32,
    /// Pixels that are allowed, and what they are divided by at outlines.
    tolerance: f32,
    outline: f32,
    plane_count: u32,
    vertices: u32,
    /// What is seen has n · p + d ≥ 0.
    planes: array<vec4<f32>, 6>,
}

@group(0) @binding(0) var<storage, read> splits: array<SplitBlock>;
@group(0) @binding(1) var<storage, read> inner: array<vec4<u32>>;
/// How far what a split makes is from its vertex.
@group(0) @binding(2) var<storage, read> extents: array<f32>;
@group(1) @binding(0) var<storage, read_write> there: array<u32>;
var<immediate> view: ViewCall;

/// The cosine between normal and view within which a vertex may be at an outline.
const OUTLINE: f32 = 0.25;

fn wants(split: u32, error: f32) -> bool {
    let bits = inner[split];
    var p = bitcast<vec3<f32>>(bits.xyz);
    var normal = octahedral_normal(bits.w);
    let node = splits[split].parent;
    if arrayLength(&places) > 1u {
        let place = place_of(node);
        if place.moved == 1u {
            p = place.point;
            normal = place.normal;
        }
    }
    let extent = extents[split];
    for (var k = 0u; k < view.plane_count; k++) {
        if dot(view.planes[k].xyz, p) + view.planes[k].w < -extent {
            return false;
        }
    }
    let along = p - view.eye;
    let distance = length(along);
    let near = distance - extent;
    if near <= 0.0 {
        return true;
    }
    let may_be_outline = abs(dot(normal, along)) < OUTLINE * distance + extent;
    return error * view.pixels * select(1.0, view.outline, may_be_outline) > view.tolerance * near;
}

@compute @workgroup_size(GROUP)
fn want(id: Invocation) {
    let vertex = linear_item(id);
    var is_wanted = false;
    if vertex < view.vertices {
        let key = splits[vertex].key;
        is_wanted = key == ALWAYS || (key > 0u && wants(vertex, bitcast<f32>(key & 0xffff0000u)));
    }
    let word = gathered(id.local, is_wanted);
    if vertex < view.vertices && id.local % 32u == 0u {
        there[vertex / 32u] = word;
    }
}
