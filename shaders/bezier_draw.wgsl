// import bezier
// Bézier patches drawn from virtual vertices: three ways to hold their control points (Concheiro et al. 2013, Sections
// 4.1 and 4.2, and storage buffers), and shading as of the ray caster.

struct Sun {
    /// Towards it, of unit length.
    direction: vec3<f32>,
    irradiance: vec3<f32>,
}

struct View {
    /// From the space of the patches to the picture.
    projection: mat4x4<f32>,
    eye: vec3<f32>,
    /// How much of the reflectance of lines is theirs: 1 where a wireframe is drawn.
    lines: f32,
    forward: vec3<f32>,
    line_width: f32,
    base_color: vec3<f32>,
    specular: f32,
    line_color: vec3<f32>,
    roughness: f32,
    up: vec3<f32>,
    sun_count: u32,
    zenith: vec3<f32>,
    horizon: vec3<f32>,
    ground: vec3<f32>,
    suns: array<Sun, 4>,
}

struct Draw {
    /// The first patch.
    first: u32,
    /// The level of the map.
    level: u32,
}

/// Patches of a row of the texture.
const TEXTURE_ROW: u32 = 120u;

@group(0) @binding(0) var<uniform> view: View;
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

struct Shaded {
    @builtin(position) position: vec4<f32>,
    @location(0) p: vec3<f32>,
    @location(1) normal: vec3<f32>,
    /// Samples along u and v, for lines.
    @location(2) grid: vec2<f32>,
    @location(3) @interpolate(flat) number: u32,
}

struct Pixel {
    @location(0) color: vec4<f32>,
    /// The normal to the side that is seen, and the depth.
    @location(1) geometry: vec4<f32>,
    @location(2) number: u32,
}

fn shaded(sample: Sample, sample_index: u32, number: f32) -> Shaded {
    var out: Shaded;
    out.position = view.projection * vec4<f32>(sample.p, 1.0);
    out.p = sample.p;
    out.normal = sample.normal;
    out.grid = vec2<f32>(f32(sample_index & 0xffffu), f32(sample_index >> 16u));
    out.number = u32(number);
    return out;
}

fn located(vertex: Vertex, edges: f32) -> Place {
    return place_of(call.level, vertex.sample_index & 0xffffu, vertex.sample_index >> 16u, vertex.uv, u32(edges));
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
    return shaded(sample_of(c, place), vertex.sample_index, last.y);
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
    return shaded(sample_of(c, place), vertex.sample_index, last.y);
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
    return shaded(sample_of(c, place), vertex.sample_index, last.y);
}

/// Points and normals that were computed before: what drawing the same strips costs by itself.
@vertex
fn vertex_passed(@location(0) p: vec3<f32>, @location(1) sample_index: u32, @location(2) normal: vec3<f32>) -> Shaded {
    return shaded(Sample(p, normal), sample_index, 0.0);
}

/// The GGX lobe with Schlick's Fresnel term and the height-correlated shadowing of Smith (Walter et al. 2007).
fn gloss(normal: vec3<f32>, toward: vec3<f32>, to_eye: vec3<f32>) -> f32 {
    let light = dot(normal, toward);
    let eye = dot(normal, to_eye);
    if view.specular <= 0.0 || light <= 0.0 || eye <= 0.0 {
        return 0.0;
    }
    let half_way = normalize(toward + to_eye);
    let alpha = max(view.roughness, 0.05) * max(view.roughness, 0.05);
    let alpha2 = alpha * alpha;
    let c = clamp(dot(normal, half_way), 0.0, 1.0);
    let spread = c * c * (alpha2 - 1.0) + 1.0;
    let density = alpha2 / (3.14159265 * spread * spread);
    let from_light = eye * sqrt(alpha2 + (1.0 - alpha2) * light * light);
    let from_eye = light * sqrt(alpha2 + (1.0 - alpha2) * eye * eye);
    let visible = 0.5 / max(from_light + from_eye, 1e-6);
    let fresnel = view.specular + (1.0 - view.specular) * pow(1.0 - clamp(dot(half_way, to_eye), 0.0, 1.0), 5.0);
    return density * visible * fresnel;
}

@fragment
fn fragment(in: Shaded) -> Pixel {
    let away = in.p - view.eye;
    let to_eye = -normalize(away);
    var normal = in.normal;
    let flat_normal = cross(dpdx(in.p), dpdy(in.p));
    let cells = fwidth(in.grid);
    let diagonal = fwidth(in.grid.x + in.grid.y);
    if dot(normal, normal) < 1e-6 {
        normal = flat_normal;
    }
    normal = normalize(normal);
    if dot(normal, to_eye) < 0.0 {
        normal = -normal;
    }
    var color = vec3<f32>(0.0);
    for (var k = 0u; k < min(view.sun_count, 4u); k++) {
        let sun = view.suns[k];
        let light = max(dot(normal, sun.direction), 0.0);
        color += sun.irradiance * light * (view.base_color * 0.318309886 + vec3<f32>(gloss(normal, sun.direction, to_eye)));
    }
    // The mean of the sky over the hemisphere of a normal upwards, less towards the ground.
    let sky = mix(view.horizon, view.zenith, 0.8);
    color += view.base_color * mix(view.ground, sky, 0.5 + 0.5 * dot(normal, view.up));
    if view.lines > 0.0 {
        let sum = in.grid.x + in.grid.y;
        let to_cell = abs(in.grid - round(in.grid)) / max(cells, vec2<f32>(1e-9));
        let to_diagonal = abs(sum - round(sum)) / max(diagonal, 1e-9);
        let nearest = min(min(to_cell.x, to_cell.y), to_diagonal);
        color = mix(color, view.line_color, view.lines * clamp(0.5 * view.line_width + 0.5 - nearest, 0.0, 1.0));
    }
    return Pixel(vec4<f32>(color, 1.0), vec4<f32>(normal, dot(away, view.forward)), in.number + 1u);
}
