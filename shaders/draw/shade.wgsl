// What all draws share: the camera, the lights, the object that is drawn, and the light of its pixels as of the ray
// caster: Lambert's diffuse part, a GGX lobe, shadow maps of suns, and the mean of the sky over the hemisphere.

struct SunBlock {
    /// Towards it, of unit length.
    direction: vec3<f32>,
    /// Width of a texel of its shadow map in the world's units; 0 if it throws no shadows.
    texel: f32,
    irradiance: vec3<f32>,
    /// From the space about the camera to its layer of the shadow maps.
    shadow: mat4x4<f32>,
}

struct ViewBlock {
    forward: vec3<f32>,
    /// How much of the reflectance of lines is theirs: 1 where a wireframe is drawn.
    lines: f32,
    up: vec3<f32>,
    line_width: f32,
    line_color: vec3<f32>,
    sun_count: u32,
    /// How much of a false colour covers the material, and how many of them there are.
    false_color: f32,
    palette_count: u32,
    palette: array<vec4<f32>, 16>,
    /// What an open surface gets of the sky, by the cosine of its inclination from −1 to 1.
    sky: array<vec4<f32>, 65>,
    suns: array<SunBlock, 4>,
}

struct ObjectBlock {
    /// From the object's space to the picture, or to a shadow map.
    clip: mat4x4<f32>,
    /// To the directions of the world, about the camera.
    world: mat4x4<f32>,
    /// Of normals.
    normal: mat4x4<f32>,
    base_color: vec3<f32>,
    specular: f32,
    roughness: f32,
    /// Its number in pictures, or that of its first part.
    number: u32,
    /// 1 if its parts have numbers of their own.
    parts: u32,
    /// 1 if it is a mirror image.
    mirrored: u32,
}

/// A storage buffer because lavapipe compiles shaders anew, and keeps them all, whenever a uniform that decides about a
/// branch may have changed.
@group(0) @binding(0) var<storage, read> view: ViewBlock;
@group(0) @binding(1) var<uniform> object: ObjectBlock;
@group(0) @binding(2) var shadow_maps: texture_depth_2d_array;
@group(0) @binding(3) var shadow_sampler: sampler_comparison;

struct Shaded {
    @builtin(position) @invariant position: vec4<f32>,
    /// The point in the world's directions, about the camera.
    @location(0) p: vec3<f32>,
    @location(1) normal: vec3<f32>,
    /// Lines go where one of these is a whole number.
    @location(2) grid: vec3<f32>,
    /// Parameters in the tile.
    @location(3) uv: vec2<f32>,
    /// Which patch or tile.
    @location(4) @interpolate(flat) part: u32,
    /// Which of the false colours.
    @location(5) @interpolate(flat) tag: u32,
}

struct Pixel {
    @location(0) color: vec4<f32>,
    /// The normal to the side that is seen, and the depth.
    @location(1) geometry: vec4<f32>,
    @location(2) number: u32,
    @location(3) albedo: vec4<f32>,
}

/// A vertex at a point with a normal of the object's space.
fn shaded(p: vec3<f32>, normal: vec3<f32>, grid: vec3<f32>, uv: vec2<f32>, part: u32, tag: u32) -> Shaded {
    var out: Shaded;
    out.position = object.clip * vec4(p, 1.0);
    out.p = (object.world * vec4(p, 1.0)).xyz;
    out.normal = (object.normal * vec4(normal, 0.0)).xyz;
    // Tangents may be long: only the direction counts.
    out.normal = select(vec3(0.0), normalize(out.normal), any(out.normal != vec3(0.0)));
    out.grid = grid;
    out.uv = uv;
    out.part = part;
    out.tag = tag;
    return out;
}

/// The GGX lobe with Schlick's Fresnel term and the height-correlated shadowing of Smith (Walter et al. 2007).
fn gloss(normal: vec3<f32>, toward: vec3<f32>, to_eye: vec3<f32>) -> f32 {
    let light = dot(normal, toward);
    let eye = dot(normal, to_eye);
    if light <= 0.0 || eye <= 0.0 {
        return 0.0;
    }
    let half_way = normalize(toward + to_eye);
    let alpha = max(object.roughness, 0.05) * max(object.roughness, 0.05);
    let alpha2 = alpha * alpha;
    let c = clamp(dot(normal, half_way), 0.0, 1.0);
    let spread = c * c * (alpha2 - 1.0) + 1.0;
    let density = alpha2 / (3.14159265 * spread * spread);
    let from_light = eye * sqrt(alpha2 + (1.0 - alpha2) * light * light);
    let from_eye = light * sqrt(alpha2 + (1.0 - alpha2) * eye * eye);
    let visible = 0.5 / max(from_light + from_eye, 1e-6);
    let fresnel = object.specular + (1.0 - object.specular) * pow(1.0 - clamp(dot(half_way, to_eye), 0.0, 1.0), 5.0);
    return select(0.0, density * visible * fresnel, object.specular > 0.0);
}

/// The share of a sun's light that arrives at a point whose triangle has the normal `facing` to the lit side: the mean
/// of three by three look-ups, each between four texels.
fn sunlit(index: u32, p: vec3<f32>, facing: vec3<f32>) -> f32 {
    let sun = view.suns[index];
    if sun.texel <= 0.0 {
        return 1.0;
    }
    // Out of the reach of the look-ups on the plane of the triangle itself.
    let cosine = clamp(dot(facing, sun.direction), 0.0, 1.0);
    let off = sun.texel * (0.5 + 3.0 * sqrt(1.0 - cosine * cosine));
    let at = (sun.shadow * vec4(p + facing * off, 1.0)).xyz;
    let place = at.xy * vec2(0.5, -0.5) + vec2(0.5);
    let step = 1.0 / vec2<f32>(textureDimensions(shadow_maps));
    // What throws no shadows may be behind all that does, or beside it, where maps are empty: their depth is 1.
    let depth = min(at.z, 1.0);
    var sum = 0.0;
    for (var tap = 0; tap < 9; tap++) {
        let shifted = place + step * vec2<f32>(vec2(tap % 3 - 1, tap / 3 - 1));
        sum += textureSampleCompareLevel(shadow_maps, shadow_sampler, shifted, index, depth);
    }
    return sum / 9.0;
}

/// The normal of the triangle at a pixel, to the side that is seen.
fn facing_of(in: Shaded) -> vec3<f32> {
    let to_eye = -normalize(in.p);
    let across = cross(dpdx(in.p), dpdy(in.p));
    var facing = to_eye;
    if any(across != vec3(0.0)) {
        facing = normalize(across);
        facing = select(facing, -facing, dot(facing, to_eye) < 0.0);
    }
    return facing;
}

/// The pixel of a surface with the diffuse reflectance `albedo`.
fn pixel(in: Shaded, front: bool, albedo: vec3<f32>) -> Pixel {
    return pixel_of(in, facing_of(in), front, albedo);
}

/// The same where the triangle has the normal `facing`.
fn pixel_of(in: Shaded, facing: vec3<f32>, front: bool, albedo: vec3<f32>) -> Pixel {
    let to_eye = -normalize(in.p);
    let cells = fwidth(in.grid);
    var normal = facing;
    if dot(in.normal, in.normal) > 1e-12 {
        let seen = select(-1.0, 1.0, front != (object.mirrored == 1u));
        let smooth_normal = seen * normalize(in.normal);
        // A normal that looks away says little about such a triangle.
        normal = select(facing, smooth_normal, dot(smooth_normal, facing) > 0.0);
    }
    var tinted = albedo;
    if view.palette_count > 0u && in.tag != 0xffffffffu {
        tinted = mix(albedo, view.palette[in.tag % view.palette_count].xyz, view.false_color);
    }
    let inclination = 64.0 * clamp(0.5 + 0.5 * dot(normal, view.up), 0.0, 1.0);
    let low = min(u32(inclination), 63u);
    var color = tinted * mix(view.sky[low].xyz, view.sky[low + 1u].xyz, inclination - f32(low));
    for (var k = 0u; k < min(view.sun_count, 4u); k++) {
        let sun = view.suns[k];
        let light = dot(normal, sun.direction);
        if light > 0.0 {
            // Triangles that are turned away are lit by what their normals say, as the smooth surface is.
            let lit = select(sunlit(k, in.p, facing), 0.0, dot(facing, sun.direction) <= 0.0 && sun.texel > 0.0);
            color += sun.irradiance * (light * lit) * (tinted * 0.318309886 + vec3(gloss(normal, sun.direction, to_eye)));
        }
    }
    if view.lines > 0.0 {
        let away = abs(in.grid - round(in.grid)) / max(cells, vec3(1e-9));
        let nearest = min(min(away.x, away.y), away.z);
        color = mix(color, view.line_color, view.lines * clamp(0.5 * view.line_width + 0.5 - nearest, 0.0, 1.0));
    }
    let number = object.number + select(0u, in.part, object.parts == 1u);
    return Pixel(vec4(color, 1.0), vec4(normal, dot(in.p, view.forward)), number + 1u, vec4(albedo, 1.0));
}
