// import shade
// import affine
// Agents of a few pixels as quads, with pictures of their models in their poses.

/// Texels along a side of a picture.
struct Call {
    side: u32,
}

/// A square in the space of a model, on which a picture lies.
struct QuadPicture {
    /// Its middle.
    center: vec3<f32>,
    /// Half a side.
    radius: f32,
    /// The direction to the right, of length 1.
    right: vec3<f32>,
    /// The direction upwards, of length 1.
    up: vec3<f32>,
}

struct Instance {
    number: u32,
    first_matrix: u32,
    first_weight: u32,
    model: u32,
    transform: array<vec4<f32>, 3>,
}

/// The picture and the instance of each quad.
@group(1) @binding(0) var<storage, read> quads: array<vec2<u32>>;
@group(1) @binding(1) var<storage, read> instances: array<Instance>;
@group(1) @binding(2) var<storage, read> pictures: array<QuadPicture>;
/// The normal, zero where a picture has nothing, and the bits of the false colour; row after row from the lowest.
@group(1) @binding(3) var<storage, read> texels: array<vec4<f32>>;
var<immediate> call: Call;

/// The false colour that is that of the number of the instance.
const INSTANCE_TAG: u32 = 0xfffffffeu;

fn map_of(instance: u32) -> Affine {
    let rows = instances[instance].transform;
    return Affine(rows[0], rows[1], rows[2]);
}

@vertex
fn vertex_quad(@builtin(vertex_index) vertex: u32, @builtin(instance_index) index: u32) -> Shaded {
    let quad = quads[index];
    let picture = pictures[quad.x];
    let map = map_of(quad.y);
    // Counter-clockwise for the viewer, also where a mirror turns triangles over.
    var corner = vertex % 3u;
    if affine_is_mirror(map) {
        corner = (3u - corner) % 3u;
    }
    let at = select(0u, corner + vertex / 3u, corner > 0u);
    let square = vec2(f32(at == 1u || at == 2u), f32(at >= 2u));
    let away = picture.radius * (2.0 * square - 1.0);
    let p = affine_point(map, picture.center + away.x * picture.right + away.y * picture.up);
    return shaded(p, vec3(0.0), vec3(0.5), f32(call.side) * square, instances[quad.y].number, index);
}

/// What the picture of a quad shows at a pixel.
fn texel_at(in: Shaded) -> vec4<f32> {
    let place = min(vec2<u32>(max(in.uv, vec2(0.0))), vec2(call.side - 1u));
    return texels[(quads[in.tag].x * call.side + place.y) * call.side + place.x];
}

@fragment
fn fragment(in: Shaded, @builtin(front_facing) front: bool) -> Pixel {
    let texel = texel_at(in);
    let normal = affine_normal(map_of(quads[in.tag].y), texel.xyz);
    let tag = bitcast<u32>(texel.w);
    var found = in;
    found.normal = (object.normal * vec4(normal, 0.0)).xyz;
    found.tag = select(tag, in.part, tag == INSTANCE_TAG);
    let made = pixel(found, front, object.base_color);
    if all(texel.xyz == vec3(0.0)) {
        discard;
    }
    return made;
}

/// Depths alone.
@fragment
fn fragment_depth(in: Shaded) {
    if all(texel_at(in).xyz == vec3(0.0)) {
        discard;
    }
}
