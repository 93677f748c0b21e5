// import foam
// Passes 5 and 6: intensity, ambient occlusion and irradiance, as intensity.rs, occlusion.rs and irradiance.rs (Akinci et al.
// 2013, Sections 2.3 and 2.4).

const PI: f32 = 3.14159265;
const TAU: f32 = 6.28318531;

/// Samples in the unit ball with their weights, and how many of the first ones of the cube are within it.
@group(1) @binding(0) var<storage, read> ball: array<vec4<f32>>;
@group(1) @binding(1) var<storage, read> counts: array<u32>;
/// Light by direction: irradiance, or radiance where that is summed for every pixel. Twice as wide as high.
@group(1) @binding(2) var<storage, read> map: array<vec4<f32>>;
/// Irradiance and occlusion of every pixel.
@group(1) @binding(3) var<storage, read_write> lights: array<vec4<f32>>;

/// How many samples a search radius in pixels has.
fn samples_of(radius: f32) -> u32 {
    let count = 0.75 * PI * radius * radius * radius * look.ao_s_dens;
    let cube = max(min(u32(min(count, 4e9)), look.ao_max_samp), look.ao_min_samp);
    return counts[min(cube, arrayLength(&counts) - 1u)];
}

@compute @workgroup_size(16, 16)
fn intensify(@builtin(global_invocation_id) item: vec3<u32>) {
    if item.x >= look.width || item.y >= look.height {
        return;
    }
    let at = item.y * look.width + item.x;
    let thickness = f32(atomicLoad(&pixels[at].high)) + f32(atomicLoad(&pixels[at].low)) / 4294967296.0;
    var intensity = 0.0;
    if thickness > 0.0 {
        intensity = 1.0 / (1.0 + look.rho_mod * min(pow(thickness, -look.rho_exp), FARTHEST_DEPTH / look.rho_mod));
        // What is too thin for a number is none.
        intensity = select(0.0, intensity, intensity > 1e-37);
    }
    let before = fronts[at];
    fronts[at] = vec4(falling(atomicLoad(&pixels[at].depth)), intensity, before.zw);
}

fn share_of(depth: f32, front: f32, opacity: f32) -> f32 {
    if depth <= front {
        return 0.0;
    }
    let near = max(1.0 - (depth - front) / look.ao_max_occl_dist, 0.0);
    return near * near * opacity;
}

@compute @workgroup_size(16, 16)
fn occlude(@builtin(global_invocation_id) item: vec3<u32>) {
    if item.x >= look.width || item.y >= look.height {
        return;
    }
    let at = item.y * look.width + item.x;
    let own = fronts[at];
    if own.y == 0.0 {
        lights[at] = vec4(0.0);
        return;
    }
    let search = pixels[at].search;
    let outward = normal_of(pixels[at].u, pixels[at].v) * vec3(1.0, 1.0, -1.0);
    let metres = 1.0 / scale_at(own.x);
    let place = vec3(
        (f32(item.x) + 0.5 - 0.5 * f32(look.width)) * metres,
        (0.5 * f32(look.height) - f32(item.y) - 0.5) * metres,
        own.x,
    );
    var sum = 0.0;
    var weights = 0.0;
    for (var turn = 0u; turn < look.ao_passes; turn++) {
        let radius = search * (look.ao_init_sr_fac + look.ao_sr_inc_fac * f32(turn));
        let count = samples_of(radius);
        for (var k = 0u; k < count; k++) {
            let sample = ball[k];
            var offset = sample.xyz;
            if look.ao_hemisphere == 1u && dot(offset, outward) < 0.0 {
                offset = -offset;
            }
            let there = place + radius * metres * offset;
            if there.z <= 0.0 {
                continue;
            }
            let seen = to_picture(there);
            if seen.x < 0.0 || seen.y < 0.0 || seen.x >= f32(look.width) || seen.y >= f32(look.height) {
                continue;
            }
            let front = fronts[u32(seen.y) * look.width + u32(seen.x)];
            let foam = share_of(there.z, front.x, front.y);
            let fluid = share_of(there.z, front.z, look.ao_fluid_opacity);
            let solid = share_of(there.z, front.w, look.ao_solid_opacity);
            weights += sample.w;
            sum += sample.w * min(foam + fluid + solid, 1.0);
        }
    }
    lights[at] = vec4(0.0, 0.0, 0.0, select(0.0, sum / weights, weights > 0.0));
}

fn texel(x: i32, y: i32) -> vec3<f32> {
    let columns = 2 * i32(look.rows);
    let column = (x + columns) % columns;
    return map[clamp(y, 0, i32(look.rows) - 1) * columns + column].xyz;
}

/// The light of a direction of unit length in the world.
fn light_of(direction: vec3<f32>) -> vec3<f32> {
    let up = clamp(dot(look.zenith, direction), -1.0, 1.0);
    // This is as precise near the zenith as elsewhere.
    let polar = atan2(sqrt(max((1.0 - up) * (1.0 + up), 0.0)), up);
    let around = vec2(dot(look.first, direction), dot(look.second, direction));
    var longitude = 0.0;
    if any(around != vec2(0.0)) {
        longitude = atan2(around.y, around.x);
    }
    let place = vec2(
        (0.5 - longitude / TAU) * f32(2u * look.rows) - 0.5,
        polar / PI * f32(look.rows) - 0.5,
    );
    let low = floor(place);
    let share = place - low;
    let corner = vec2<i32>(low);
    let upper = mix(texel(corner.x, corner.y), texel(corner.x + 1, corner.y), share.x);
    let lower = mix(texel(corner.x, corner.y + 1), texel(corner.x + 1, corner.y + 1), share.x);
    return mix(upper, lower, share.y);
}

@compute @workgroup_size(16, 16)
fn irradiate(@builtin(global_invocation_id) item: vec3<u32>) {
    if item.x >= look.width || item.y >= look.height {
        return;
    }
    let at = item.y * look.width + item.x;
    if fronts[at].y == 0.0 {
        return;
    }
    let own = normal_of(pixels[at].u, pixels[at].v);
    let normal = normalize(look.right * own.x + look.up * own.y + look.back * own.z);
    var light = vec3(0.0);
    if look.irradiance_map == 1u {
        light = light_of(normal);
    } else {
        var weights = 0.0;
        let count = samples_of(pixels[at].search * look.ao_init_sr_fac);
        for (var k = 0u; k < count; k++) {
            let far = length(ball[k].xyz);
            if far == 0.0 {
                continue;
            }
            let direction = ball[k].xyz / far;
            let cosine = dot(direction, normal);
            light += abs(cosine) * light_of(select(direction, -direction, cosine < 0.0));
            weights += abs(cosine);
        }
        light = select(vec3(0.0), light / weights, weights > 0.0);
    }
    lights[at] = vec4(light, lights[at].w);
}
