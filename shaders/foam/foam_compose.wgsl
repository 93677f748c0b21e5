// import foam
// Pass 7: shadows and irradiance are filtered, and foam is laid over a picture, as composition.rs (Akinci et al. 2013, Section
// 2.5).

/// The radius of the filter in pixels at most.
const WIDEST: f32 = 16.0;

/// Irradiance and occlusion of every pixel.
@group(1) @binding(0) var<storage, read> lights: array<vec4<f32>>;
/// A picture of three channels or more, the first of which are red, green and blue.
@group(1) @binding(1) var<storage, read_write> picture: array<f32>;
/// How many channels it has.
var<immediate> channels: u32;

/// The shadow of an occlusion, 0 to 1.
fn shadow_of(occlusion: f32) -> f32 {
    let scaled = power(occlusion * look.ao_sh_scale, look.ao_sh_exp);
    return clamp(scaled + look.ao_sh_offset, 0.0, 1.0);
}

@compute @workgroup_size(16, 16)
fn compose(@builtin(global_invocation_id) item: vec3<u32>) {
    if item.x >= look.width || item.y >= look.height {
        return;
    }
    let at = item.y * look.width + item.x;
    let intensity = fronts[at].y;
    if intensity == 0.0 {
        return;
    }
    let radius = min(look.filter_radius * pixels[at].search, WIDEST);
    let reach = i32(radius);
    let middle = vec2<i32>(item.xy);
    let last = vec2(i32(look.width), i32(look.height)) - 1;
    let low = max(middle - reach, vec2(0));
    let high = min(middle + reach, last);
    // The filter ends at two standard deviations.
    let falloff = -2.0 / max(radius * radius, 1e-6);
    var shadow = 0.0;
    var irradiance = vec3(0.0);
    var weights = 0.0;
    for (var y = low.y; y <= high.y; y++) {
        for (var x = low.x; x <= high.x; x++) {
            let apart = vec2<f32>(vec2(x, y) - middle);
            let square = dot(apart, apart);
            if square > radius * radius && square > 0.0 {
                continue;
            }
            let other = u32(y) * look.width + u32(x);
            if fronts[other].y == 0.0 {
                continue;
            }
            let weight = exp(falloff * square);
            shadow += weight * shadow_of(lights[other].w);
            irradiance += weight * lights[other].xyz;
            weights += weight;
        }
    }
    let dark = clamp(shadow / weights * (vec3(1.0) - look.shadow_color), vec3(0.0), vec3(1.0));
    let light = clamp(look.irr_scale * irradiance / weights, vec3(0.0), vec3(1.0));
    // Where shadows are darker than the light, black remains.
    let color = max(light - dark, vec3(0.0));
    for (var channel = 0u; channel < 3u; channel++) {
        let place = at * channels + channel;
        picture[place] = (1.0 - intensity) * picture[place] + intensity * color[channel];
    }
}
