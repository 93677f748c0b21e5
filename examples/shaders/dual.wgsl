// Direct volume rendering of two scans of one body, as of a head by MRI and CT. The membership of a sample by both values and
// both gradients is a factor of its opacity.

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
    mri_size: vec3<f32>,
    mri_proportions: vec3<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var mri: texture_3d<f32>;
@group(0) @binding(2) var ct: texture_3d<f32>;
@group(0) @binding(3) var linear: sampler;

// The values of both scans.
fn values_at(place: vec3<f32>) -> vec2<f32> {
    return vec2<f32>(textureSampleLevel(mri, linear, place, 0.0).r, textureSampleLevel(ct, linear, place, 0.0).r);
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

    let extent = 0.5 * view.mri_proportions;
    let inverse = 1.0 / (ray + select(vec3<f32>(0.0), vec3<f32>(1e-6), abs(ray) < vec3<f32>(1e-6)));
    let front = vec3<f32>(0.0, 2.0 * extent.y * view.clip, 0.0);
    let one = (front - extent - eye) * inverse;
    let two = (extent - eye) * inverse;
    let near = min(one, two);
    let far = max(one, two);
    let enter = max(max(near.x, near.y), near.z);
    let leave = min(min(far.x, far.y), far.z);

    let voxel = 1.0 / view.mri_size;
    var color = vec3<f32>(0.0);
    var alpha = 0.0;
    if enter < leave {
        let stride = 1.8 / view.steps;
        for (var distance = enter; distance < leave; distance += stride) {
            let place = (eye + ray * distance) / view.mri_proportions + 0.5;
            let values = values_at(place);
            let dx = 0.5 * (values_at(place + vec3<f32>(voxel.x, 0.0, 0.0)) - values_at(place - vec3<f32>(voxel.x, 0.0, 0.0)));
            let dy = 0.5 * (values_at(place + vec3<f32>(0.0, voxel.y, 0.0)) - values_at(place - vec3<f32>(0.0, voxel.y, 0.0)));
            let dz = 0.5 * (values_at(place + vec3<f32>(0.0, 0.0, voxel.z)) - values_at(place - vec3<f32>(0.0, 0.0, voxel.z)));
            //. name MRI
            let vox_mri = values.x;
            //. name CT
            let vox_ct = values.y;
            //. name Gradient magnitude of MRI
            let gm_mri = length(vec3<f32>(dx.x, dy.x, dz.x));
            //. name Gradient magnitude of CT
            let gm_ct = length(vec3<f32>(dx.y, dy.y, dz.y));
            let opacity = smoothstep(view.low, view.high, max(vox_mri, vox_ct)) * view.opacity;
            //. vector vox_mri; vox_ct; gm_mri; gm_ct; opacity * (1.0 - alpha)
            let shown = opacity /*. * smoothstep(0.3, 0.7, confidence) */;
            let normal = vec3<f32>(dx.x, dy.x, dz.x) / max(gm_mri, 1e-4);
            let light = 0.5 + 0.5 * abs(dot(normal, ray));
            let paint = mix(vec3<f32>(0.75, 0.25, 0.18), vec3<f32>(1.0, 0.95, 0.85), vox_mri);
            color += (1.0 - alpha) * shown * light * paint;
            alpha += (1.0 - alpha) * shown;
            if alpha > 0.99 {
                break;
            }
        }
    }
    return vec4<f32>(color + (1.0 - alpha) * vec3<f32>(0.02, 0.03, 0.05), 1.0);
}
