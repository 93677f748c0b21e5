//! Light through bodies, and surfaces that find their hits themselves, against closed forms: no light is lost or made,
//! what absorption leaves, Snell's law, shadows, blur.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use relievo_core::Context;
use relievo_render::{
    Camera, Dielectric, Frame, Implicit, ImplicitHit, ImplicitRay, ImplicitTracer, Lights, Material, Mesh, ObjectId,
    Scene, Sky, Sun, View,
};

const MATTE: Material = Material { base_color: [0.5, 0.25, 1.0], specular: 0.0, roughness: 1.0 };
const SMOOTH: Material = Material { base_color: [1.0; 3], specular: 0.0, roughness: 0.1 };
const GLASS: Dielectric = Dielectric { index: 1.5, absorption: [0.0, 0.5, 2.0] };

/// A ball of radius 1 that moves with a velocity along x.
struct Ball(f32);

impl Implicit for Ball {
    fn tracer(&self) -> Box<dyn ImplicitTracer + '_> {
        Box::new(Self(self.0))
    }
}

impl ImplicitTracer for Ball {
    fn intersect(&mut self, ray: &ImplicitRay) -> Option<ImplicitHit> {
        let (origin, direction) = (Vec3::from(ray.origin) - Vec3::X * self.0 * ray.time, Vec3::from(ray.direction));
        let middle = -origin.dot(direction);
        let half = 1.0 - (origin + middle * direction).length_squared();
        let half = (half > 0.0).then(|| half.sqrt())?;
        let enters = middle - half > 0.0;
        let distance = if enters { middle - half } else { middle + half };
        let normal = (origin + distance * direction).to_array();
        (distance > 0.0 && distance < ray.far).then_some(ImplicitHit { distance, normal, enters, margin: 1e-4 })
    }
}

/// A box around 0 with its front outside.
fn block(half: [f32; 3]) -> Mesh {
    let corner = |at: u32| std::array::from_fn(|axis| if at >> axis & 1 == 1 { half[axis] } else { -half[axis] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Mesh { points: (0..8).map(corner).collect(), triangles, ..Mesh::default() }
}

fn square(half: f32) -> Mesh {
    Mesh {
        points: vec![[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

fn furnace() -> Lights {
    Lights { suns: Vec::new(), sky: Sky::uniform([1.0; 3]) }
}

fn view(eye: DVec3, target: DVec3, lights: Lights, samples: u32) -> View {
    let mut view = View { lights, ..View::new(Camera::look_at(eye, target, DVec3::Y, 0.8).unwrap()) };
    (view.settings.width, view.settings.height, view.settings.samples) = (33, 33, samples);
    view
}

fn add(scene: &mut Scene, transform: DAffine3, material: Material, mesh: Mesh) -> ObjectId {
    let object = scene.add_object(transform, material).unwrap();
    scene.set_mesh(object, 0, mesh).unwrap();
    object
}

fn add_ball(scene: &mut Scene, transform: DAffine3, speed: f32) -> ObjectId {
    let object = scene.add_object(transform, SMOOTH).unwrap();
    scene.set_implicit(object, Some(Box::new(Ball(speed)))).unwrap();
    object
}

fn render(scene: &mut Scene, view: &View) -> Frame {
    scene.render(&Context::serial(), view).unwrap()
}

/// Light of a slab of a thickness in uniform light of 1, seen straight on: reflected and let through, any number of
/// times.
fn slab(absorption: f32, thickness: f32) -> f32 {
    let (reflected, left) = (0.04f32, (-absorption * thickness).exp());
    let series = (1.0 - reflected).powi(2) / (1.0 - (reflected * left).powi(2));
    reflected + series * left * (1.0 + reflected * left)
}

#[test]
fn clear_bodies_in_even_light_cannot_be_seen() {
    let clear = Dielectric { absorption: [0.0; 3], ..GLASS };
    for (eye, in_body) in [(DVec3::new(1.0, 2.0, 5.0), false), (DVec3::new(0.1, 0.2, -0.3), true)] {
        let mut scene = Scene::new().unwrap();
        let turned = DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.4), DVec3::ZERO);
        let object = match in_body {
            true => add_ball(&mut scene, turned, 0.0),
            false => add(&mut scene, turned, SMOOTH, block([0.8, 1.0, 0.6])),
        };
        scene.set_dielectric(object, Some(clear)).unwrap();
        let frame = render(&mut scene, &view(eye, DVec3::new(0.0, 0.0, 0.1), furnace(), 4));
        assert!(frame.object.contains(&object.number()));
        for value in frame.color.data() {
            assert!((value - 1.0).abs() < 1e-4, "{in_body} {value}");
        }
    }
}

#[test]
fn what_is_absorbed_is_that_of_the_way_within() {
    let mut scene = Scene::new().unwrap();
    let object = add(&mut scene, DAffine3::IDENTITY, SMOOTH, block([50.0, 50.0, 0.35]));
    scene.set_dielectric(object, Some(GLASS)).unwrap();
    let outside = render(&mut scene, &view(DVec3::Z * 5.0, DVec3::ZERO, furnace(), 1));
    for (value, absorption) in outside.color.color(16, 16).iter().zip(GLASS.absorption) {
        // What less than a hundredth of the light is left of is not followed.
        assert!((value - slab(absorption, 0.7)).abs() < 2e-3, "{value} {}", slab(absorption, 0.7));
    }
    // A ray that starts within: it leaves 0.25 away, or comes back once more from there.
    let within = render(&mut scene, &view(DVec3::Z * 0.1, DVec3::Z * 0.3, furnace(), 1));
    for (value, absorption) in within.color.color(16, 16).iter().zip(GLASS.absorption) {
        let (first, whole) = ((-absorption * 0.25).exp(), (-absorption * 0.7).exp());
        let expected = first * 0.96 * (1.0 + 0.04 * whole / (1.0 - 0.04 * whole));
        assert!((value - expected).abs() < 2e-3, "{value} {expected}");
    }
}

#[test]
fn what_is_under_a_body_is_seen_where_snells_law_has_it() {
    // A floor that is red from a line on, 1 below the upper side of a block. The ray through the middle of the picture
    // meets the block at 0, at 45 degrees.
    let mut scene = Scene::new().unwrap();
    let bent = (0.5f64.sqrt() / 1.5).asin().tan();
    for (side, red) in [(1.0, 1.0), (-1.0, 0.0)] {
        let material = Material { base_color: [red, 1.0 - red, 0.0], ..MATTE };
        add(&mut scene, at(bent + side * 20.0, 0.0, -1.0), material, square(20.0));
    }
    let object = add(&mut scene, at(0.0, 0.0, -5.0), SMOOTH, block([30.0, 30.0, 5.0]));
    scene.set_dielectric(object, Some(Dielectric { absorption: [0.0; 3], ..GLASS })).unwrap();
    let mut look = view(DVec3::new(-4.0, 0.0, 4.0), DVec3::ZERO, furnace(), 1);
    (look.settings.width, look.settings.height, look.camera.fov) = (401, 401, 0.02);
    let frame = render(&mut scene, &look);
    // The border is a line across the picture, through its middle; x runs up in it or to the side.
    let red = |x: u32, y: u32| frame.color.color(x, y)[0] > frame.color.color(x, y)[1];
    let changes = (0..400).filter(|at| red(*at, 200) != red(at + 1, 200)).map(|at| (at, 200));
    let changes: Vec<_> =
        changes.chain((0..400).filter(|at| red(200, *at) != red(200, at + 1)).map(|at| (200, at))).collect();
    assert_eq!(changes.len(), 1, "{changes:?}");
    let (x, y) = changes[0];
    assert!((199..=200).contains(&x) && (199..=200).contains(&y), "{changes:?}");
}

#[test]
fn shadows_of_bodies_have_the_light_that_they_let_through() {
    for solid in [true, false] {
        let mut scene = Scene::new().unwrap();
        add(&mut scene, DAffine3::IDENTITY, MATTE, square(50.0));
        let object = match solid {
            true => add(&mut scene, at(0.0, 0.0, 3.0), SMOOTH, block([1.0, 1.0, 0.35])),
            false => add_ball(&mut scene, at(0.0, 0.0, 3.0), 0.0),
        };
        let up = Sun { direction: [0.0, 0.0, 1.0], irradiance: [3.0, 2.0, 1.0], angular_radius: 0.0 };
        let lights = Lights { suns: vec![up], sky: Sky::uniform([0.0; 3]) };
        let look = view(DVec3::new(-4.0, 0.0, 1.0), DVec3::ZERO, lights, 1);
        assert_eq!(render(&mut scene, &look).color.color(16, 16), [0.0; 3], "an opaque body");
        scene.set_dielectric(object, Some(GLASS)).unwrap();
        let color = render(&mut scene, &look).color.color(16, 16);
        let thickness = if solid { 0.7 } else { 2.0 };
        for axis in 0..3 {
            let left = 0.96f32.powi(2) * (-GLASS.absorption[axis] * thickness).exp();
            let expected = up.irradiance[axis] * MATTE.base_color[axis] * left / std::f32::consts::PI;
            assert!((color[axis] - expected).abs() < 1e-3 * expected, "{color:?} {expected}");
        }
    }
}

#[test]
fn implicit_surfaces_have_depths_and_normals_and_are_blurred_where_they_move() {
    let mut scene = Scene::new().unwrap();
    let stretched = DAffine3::from_scale_rotation_translation(
        DVec3::new(2.0, 1.0, 1.0),
        DQuat::IDENTITY,
        DVec3::new(1e6, 0.0, 0.0),
    );
    let object = add_ball(&mut scene, stretched, 1.0);
    let eye = DVec3::new(1e6, 0.0, 5.0);
    let mut look = view(eye, DVec3::new(1e6, 0.0, 0.0), furnace(), 1);
    let frame = render(&mut scene, &look);
    assert_eq!(frame.object[16 * 33 + 16], object.number());
    assert!((frame.depth.data()[16 * 33 + 16] - 4.0).abs() < 1e-5);
    assert!((Vec3::from(frame.normal.color(16, 16)) - Vec3::Z).length() < 1e-4);
    // An ellipse twice as wide as high.
    let covered = |frame: &Frame| (0..33 * 33).filter(|at| frame.object[*at] == object.number()).count();
    let expected = std::f64::consts::PI * 2.0 * (16.5 / (24f64.sqrt() * 0.4f64.tan())).powi(2);
    assert!((covered(&frame) as f64 / expected - 1.0).abs() < 0.06, "{} {expected}", covered(&frame));
    // In a second it goes two units to the right: what was near its left rim is seen for an eighth of it.
    (look.shutter, look.settings.samples, look.lights.sky) = ([0.0, 1.0], 256, Sky::uniform([0.0; 3]));
    look.lights.suns =
        vec![Sun { direction: [0.0, 0.0, 1.0], irradiance: [std::f32::consts::PI; 3], angular_radius: 0.0 }];
    let moved = render(&mut scene, &look);
    let share = |x: u32| moved.color.color(x, 16)[0];
    let still = render(&mut scene, &View { shutter: [0.0; 2], ..look.clone() });
    assert!((share(16) / still.color.color(16, 16)[0] - 0.9).abs() < 0.1, "{}", share(16));
    let before = |x: u32| still.color.color(x, 16)[0];
    assert!(share(2) < 0.2 * before(2) && share(32) > 3.0 * before(32), "{} {}", share(2), share(32));
    look.shutter = [1.0, 0.0];
    assert!(scene.render(&Context::serial(), &look).is_err());
}

#[test]
fn dielectrics_out_of_range_are_refused() {
    let mut scene = Scene::new().unwrap();
    let object = add_ball(&mut scene, DAffine3::IDENTITY, 0.0);
    for bad in [
        Dielectric { index: 0.5, ..GLASS },
        Dielectric { index: f32::NAN, ..GLASS },
        Dielectric { absorption: [-1.0, 0.0, 0.0], ..GLASS },
        Dielectric { absorption: [0.0, f32::INFINITY, 0.0], ..GLASS },
    ] {
        assert!(scene.set_dielectric(object, Some(bad)).is_err(), "{bad:?}");
    }
}
