// Direct volume rendering of a scan. The membership of a sample by its value and its gradient is a factor of its opacity.

struct View {
    // Radians around the vertical axis, and up.
    turn: f32,
    tilt: f32,
    // Values between which the opacity of a voxel grows from 0 to 1.
    low: f32,
    high: f32,
    opacity: f32,
    // Share of the scan that is cut away in front.
    clip: f32,
    // Samples along a ray.
    steps: f32,
    resolution: vec2<f32>,
    scan_size: vec3<f32>,
    scan_proportions: vec3<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var scan: texture_3d<f32>;
@group(0) @binding(2) var linear: sampler;

fn value_at(place: vec3<f32>) -> f32 {
    return textureSampleLevel(scan, linear, place, 0.0).r;
}

fn gradient_at(place: vec3<f32>) -> vec3<f32> {
    let step = 1.0 / view.scan_size;
    let x = vec3<f32>(step.x, 0.0, 0.0);
    let y = vec3<f32>(0.0, step.y, 0.0);
    let z = vec3<f32>(0.0, 0.0, step.z);
    return vec3<f32>(
        value_at(place + x) - value_at(place - x),
        value_at(place + y) - value_at(place - y),
        value_at(place + z) - value_at(place - z),
    ) * 0.5;
}

@fragment
fn render(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let plane = (position.xy - 0.5 * view.resolution) / min(view.resolution.x, view.resolution.y);
    let ct = cos(view.turn);
    let st = sin(view.turn);
    let cp = cos(view.tilt);
    let sp = sin(view.tilt);
    let right = vec3<f32>(ct, st, 0.0);
    let forward = vec3<f32>(-st * cp, ct * cp, -sp);
    let up = cross(right, forward);
    let eye = forward * -2.5;
    let ray = normalize(forward * 2.0 + (right * plane.x - up * plane.y) * 0.8);

    let extent = 0.5 * view.scan_proportions;
    let inverse = 1.0 / (ray + select(vec3<f32>(0.0), vec3<f32>(1e-6), abs(ray) < vec3<f32>(1e-6)));
    let front = vec3<f32>(0.0, 2.0 * extent.y * view.clip, 0.0);
    let one = (front - extent - eye) * inverse;
    let two = (extent - eye) * inverse;
    let near = min(one, two);
    let far = max(one, two);
    let enter = max(max(near.x, near.y), near.z);
    let leave = min(min(far.x, far.y), far.z);

    var color = vec3<f32>(0.0);
    var alpha = 0.0;
    if enter < leave {
        let length = 1.8 / view.steps;
        for (var distance = enter; distance < leave; distance += length) {
            let place = (eye + ray * distance) / view.scan_proportions + 0.5;
            //. name Value
            //. desc Value of the scan, 0 to 1
            let value = value_at(place);
            let gradient = gradient_at(place);
            //. name Gradient magnitude
            //. desc Change of the value for each voxel
            let magnitude = min(sqrt(dot(gradient, gradient)), 1.0);
            let opacity = smoothstep(view.low, view.high, value) * view.opacity;
            //. vector value; magnitude; opacity * (1.0 - alpha)
            let shown = opacity /*. * smoothstep(0.3, 0.7, confidence) */;
            let normal = gradient / max(magnitude, 1e-4);
            let light = 0.35 + 0.65 * abs(dot(normal, ray));
            let paint = mix(vec3<f32>(0.75, 0.25, 0.18), vec3<f32>(1.0, 0.95, 0.85), smoothstep(0.2, 0.7, value));
            color += (1.0 - alpha) * shown * light * paint;
            alpha += (1.0 - alpha) * shown;
            if alpha > 0.99 {
                break;
            }
        }
    }
    return vec4<f32>(color + (1.0 - alpha) * vec3<f32>(0.02, 0.03, 0.05), 1.0);
}
