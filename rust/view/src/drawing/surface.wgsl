// Triangles with a colour for each point, lit from where the camera is, lines on them, and balls.

struct View {
    // From the world to clip space.
    projection: mat4x4<f32>,
    // Directions of the camera in the world: right, up, and against the direction of view.
    right: vec4<f32>,
    up: vec4<f32>,
    back: vec4<f32>,
    // The colour of lines, and by how much they are drawn nearer, as a share of the depth.
    line: vec4<f32>,
}

@group(0) @binding(0) var<uniform> view: View;

struct Point {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec4<f32>,
    // Encoded as sRGB.
    @location(2) color: vec4<f32>,
}

struct Fragment {
    @builtin(position) position: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) color: vec3<f32>,
}

fn decoded(color: vec3<f32>) -> vec3<f32> {
    return select(pow((color + 0.055) / 1.055, vec3(2.4)), color / 12.92, color <= vec3(0.04045));
}

fn encoded(color: vec3<f32>) -> vec3<f32> {
    let held = clamp(color, vec3(0.0), vec3(1.0));
    return select(1.055 * pow(held, vec3(1.0 / 2.4)) - 0.055, 12.92 * held, held <= vec3(0.0031308));
}

@vertex
fn surface_point(point: Point) -> Fragment {
    let normal = vec3(dot(point.normal.xyz, view.right.xyz), dot(point.normal.xyz, view.up.xyz), dot(point.normal.xyz, view.back.xyz));
    return Fragment(view.projection * vec4(point.position, 1.0), normal, decoded(point.color.rgb));
}

// The light on a colour, where the normal is in the space of the camera, z toward the eye.
fn lit(albedo: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let key = max(dot(normal, normalize(vec3(-0.45, 0.6, 0.66))), 0.0);
    let fill = max(dot(normal, normalize(vec3(0.8, 0.1, 0.6))), 0.0);
    let sky = 0.5 + 0.5 * normal.y;
    let shine = pow(max(dot(normal, normalize(vec3(-0.24, 0.32, 0.92))), 0.0), 40.0);
    return albedo * (0.95 * key + 0.22 * fill + 0.16 * sky + 0.04) + 0.06 * shine;
}

@fragment
fn surface_color(fragment: Fragment, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    var color = lit(fragment.color, normalize(select(-fragment.normal, fragment.normal, is_front)));
    // The inside of an open surface is darker.
    color *= select(0.45, 1.0, is_front);
    return vec4(encoded(color), 1.0);
}

@vertex
fn line_point(point: Point) -> @builtin(position) vec4<f32> {
    var place = view.projection * vec4(point.position, 1.0);
    place.z -= view.line.w * place.w;
    return place;
}

@fragment
fn line_color() -> @location(0) vec4<f32> {
    return vec4(view.line.rgb, 1.0);
}

struct Ball {
    @location(0) center: vec3<f32>,
    @location(1) radius: f32,
    // Encoded as sRGB.
    @location(2) color: vec4<f32>,
}

struct Disc {
    @builtin(position) position: vec4<f32>,
    @location(0) place: vec2<f32>,
    @location(1) color: vec3<f32>,
}

// A square toward the eye that the ball lies in.
@vertex
fn ball_corner(ball: Ball, @builtin(vertex_index) corner: u32) -> Disc {
    let place = vec2(f32(corner & 1u), f32(corner >> 1u)) * 2.0 - 1.0;
    let at = ball.center + ball.radius * (place.x * view.right.xyz + place.y * view.up.xyz);
    return Disc(view.projection * vec4(at, 1.0), place, decoded(ball.color.rgb));
}

@fragment
fn ball_color(disc: Disc) -> @location(0) vec4<f32> {
    let rest = 1.0 - dot(disc.place, disc.place);
    if rest < 0.0 {
        discard;
    }
    return vec4(encoded(lit(disc.color, vec3(disc.place, sqrt(rest)))), 1.0);
}
