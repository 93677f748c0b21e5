//! The ray caster against closed forms: depths, Lambert's law, shadows, sky light, line widths, and independence of
//! threads and of the distance from the origin.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use relievo_core::parameter::Switch;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_render::{
    Camera, FalseColor, Frame, Lights, Material, Mesh, NO_OBJECT, ObjectId, Scene, Sky, Sun, View, color,
};

const MATTE: Material = Material { base_color: [0.5, 0.25, 1.0], specular: 0.0, roughness: 1.0 };

/// A square of two triangles in the plane z = 0.
fn square(half: f32) -> Mesh {
    Mesh {
        points: vec![[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A unit sphere of `rings` × 2 `rings` facets with its normals.
fn sphere(rings: u32) -> Mesh {
    let columns = 2 * rings;
    let mut mesh = Mesh::default();
    for row in 0..=rings {
        for column in 0..=columns {
            let polar = std::f32::consts::PI * row as f32 / rings as f32;
            let around = std::f32::consts::TAU * column as f32 / columns as f32;
            mesh.points.push([polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()]);
        }
    }
    for row in 0..rings {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            let b = a + columns + 1;
            mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh.normals = mesh.points.clone();
    mesh
}

fn dark() -> Lights {
    Lights { suns: Vec::new(), sky: Sky::uniform([0.0; 3]) }
}

fn sun(direction: [f32; 3], angular_radius: f32) -> Lights {
    Lights { suns: vec![Sun { direction, irradiance: [3.0, 2.0, 1.0], angular_radius }], ..dark() }
}

/// Straight down on the origin from a height of 5, x to the right.
fn above(lights: Lights, size: u32) -> View {
    let camera = Camera::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, DVec3::Y, 0.8).unwrap();
    let mut view = View { lights, ..View::new(camera) };
    (view.settings.width, view.settings.height, view.settings.samples) = (size, size, 1);
    view
}

fn render(scene: &mut Scene, view: &View) -> Frame {
    scene.render(&Context::serial(), view).unwrap()
}

fn scene_of(mesh: Mesh) -> (Scene, ObjectId) {
    let mut scene = Scene::new().unwrap();
    let object = scene.add_object(DAffine3::IDENTITY, MATTE).unwrap();
    scene.set_mesh(object, 0, mesh).unwrap();
    (scene, object)
}

fn close(a: [f32; 3], b: [f32; 3], tolerance: f32) -> bool {
    (0..3).all(|at| (a[at] - b[at]).abs() <= tolerance)
}

#[test]
fn a_sphere_has_the_depths_and_normals_of_its_equation() {
    let (mut scene, object) = scene_of(sphere(256));
    let view = above(dark(), 65);
    let frame = render(&mut scene, &view);
    let mut hits = 0;
    for y in 0..65u32 {
        for x in 0..65u32 {
            let at = (y * 65 + x) as usize;
            // The direction has length 1 along the view: (s, t, −1) from (0, 0, 5).
            let tangent = |value: u32| (0.4f64).tan() * (2.0 * (f64::from(value) + 0.5) / 65.0 - 1.0);
            let direction = DVec3::new(tangent(x), -tangent(y), -1.0);
            let (a, b, c) = (direction.length_squared(), -5.0, 24.0);
            let under = b * b - a * c;
            if under < 0.05 {
                continue;
            }
            let depth = (-b - under.sqrt()) / a;
            let point = DVec3::new(0.0, 0.0, 5.0) + direction * depth;
            assert!((f64::from(frame.depth.data()[at]) - depth).abs() < 1e-3, "({x}, {y})");
            assert!(close(frame.normal.color(x, y), point.as_vec3().to_array(), 1e-2), "({x}, {y})");
            assert_eq!(frame.object[at], object.number());
            hits += 1;
        }
    }
    assert!(hits > 500);
    assert_eq!((frame.object[0], frame.depth.data()[0]), (NO_OBJECT, f32::INFINITY));
}

#[test]
fn a_matte_plane_obeys_lamberts_law_and_lights_its_back_like_its_front() {
    let (mut scene, _) = scene_of(square(10.0));
    for degrees in [0.0f32, 30.0, 60.0, 85.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let frame = render(&mut scene, &above(sun([2.0 * sin, 0.0, 2.0 * cos], 0.0), 3));
        let expected = [0, 1, 2].map(|at| MATTE.base_color[at] * [3.0, 2.0, 1.0][at] * cos / std::f32::consts::PI);
        assert!(close(frame.color.color(1, 1), expected, 1e-5), "{degrees}");
        assert_eq!(frame.albedo.color(1, 1), MATTE.base_color);
    }
    let frame = render(&mut scene, &above(sun([0.0, 0.0, -1.0], 0.0), 3));
    assert_eq!(frame.color.color(1, 1), [0.0; 3]);
    let camera = Camera::look_at(DVec3::new(0.0, 0.0, -5.0), DVec3::ZERO, DVec3::Y, 0.8).unwrap();
    let frame = render(&mut scene, &View { camera, ..above(sun([0.0, 0.0, -1.0], 0.0), 3) });
    assert!(frame.color.color(1, 1)[0] > 0.4);
    assert_eq!(frame.normal.color(1, 1), [0.0, 0.0, -1.0]);
}

#[test]
fn an_open_plane_gives_back_a_uniform_sky_times_its_colour() {
    let (mut scene, _) = scene_of(square(10.0));
    let lights = Lights { suns: Vec::new(), sky: Sky::uniform([2.0, 4.0, 0.5]) };
    let frame = render(&mut scene, &above(lights, 3));
    assert!(close(frame.color.color(1, 1), [1.0, 1.0, 0.5], 1e-5));
}

#[test]
fn beside_a_high_wall_half_the_sky_is_seen() {
    let (mut scene, object) = scene_of(square(10.0));
    scene.set_material(object, Material { base_color: [0.001; 3], ..MATTE }).unwrap();
    let wall = Mesh {
        points: vec![[1e-3, -1e3, 0.0], [1e-3, 1e3, 0.0], [1e-3, 1e3, 1e3], [1e-3, -1e3, 1e3]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    scene.set_mesh(object, 1, wall).unwrap();
    let lights = Lights { suns: Vec::new(), sky: Sky::uniform([1000.0; 3]) };
    let mut view = above(lights, 1);
    view.camera = Camera::look_at(DVec3::new(-1.0, 0.0, 2.0), DVec3::ZERO, DVec3::Y, 0.01).unwrap();
    view.settings.sky_rays = 256;
    view.settings.samples = 4;
    let frame = render(&mut scene, &view);
    assert!((frame.color.color(0, 0)[0] - 0.5).abs() < 0.02, "{:?}", frame.color.color(0, 0));
    view.settings.sky_rays = 0;
    let frame = render(&mut scene, &view);
    assert!((frame.color.color(0, 0)[0] - 1.0).abs() < 1e-3, "without rays nothing is in the way");
}

#[test]
fn an_occluder_throws_a_shadow_whose_edge_is_half_lit() {
    let (mut scene, object) = scene_of(square(10.0));
    // Covers x > 0 at a height of 1, and the camera looks from below it.
    let roof = Mesh {
        points: vec![[0.0, -50.0, 1.0], [50.0, -50.0, 1.0], [50.0, 50.0, 1.0], [0.0, 50.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    scene.set_mesh(object, 1, roof).unwrap();
    let at = |scene: &mut Scene, x: f64, radius: f32, shadows: Switch| {
        let eye = DVec3::new(x, 0.0, 0.5);
        let mut view = above(sun([0.0, 0.0, 1.0], radius), 1);
        view.camera = Camera::look_at(eye, DVec3::new(x, 0.0, 0.0), DVec3::Y, 0.001).unwrap();
        (view.settings.samples, view.settings.shadows) = (512, shadows);
        render(scene, &view).color.color(0, 0)[2] * std::f32::consts::PI
    };
    assert_eq!(at(&mut scene, 0.1, 0.0, Switch::ON), 0.0);
    assert!((at(&mut scene, -0.1, 0.0, Switch::ON) - 1.0).abs() < 1e-4);
    assert!((at(&mut scene, 0.1, 0.0, Switch::OFF) - 1.0).abs() < 1e-4);
    assert!((at(&mut scene, 0.0, 0.2, Switch::ON) - 0.5).abs() < 0.03);
    let half_way = at(&mut scene, 0.1, 0.2, Switch::ON);
    assert!(half_way > 0.05 && half_way < 0.45, "{half_way} in the penumbra");
}

#[test]
fn wires_are_as_wide_as_asked_and_only_marked_edges_are_drawn() {
    let mut mesh = square(1.0);
    mesh.edges = vec![0b100, 0b001];
    let (mut scene, object) = scene_of(mesh);
    let lights = Lights { suns: Vec::new(), sky: Sky::uniform([1.0; 3]) };
    let mut view = above(lights, 401);
    view.line_color = [0.0; 3];
    view.settings.samples = 16;
    view.settings.wireframe = Switch::ON;
    for width in [1.0, 2.0, 5.0] {
        view.settings.line_width = width;
        let frame = render(&mut scene, &view);
        // Along a row the diagonal is crossed under 45 degrees.
        let covered: f32 = (150..250).map(|x| 1.0 - frame.color.color(x, 200)[2]).sum();
        assert!((covered - width * 2f32.sqrt()).abs() < 0.05, "{covered} for {width}");
    }
    scene.set_mesh(object, 0, Mesh { edges: vec![0, 0], ..square(1.0) }).unwrap();
    let frame = render(&mut scene, &view);
    assert!((0..401).all(|x| frame.color.color(x, 200)[2] > 0.99));
}

#[test]
fn tags_are_shown_in_the_colours_of_the_palette() {
    let (mut scene, _) = scene_of(Mesh { tags: vec![1, 7], ..square(1.0) });
    let lights = Lights { suns: Vec::new(), sky: Sky::uniform([1.0; 3]) };
    let mut view = above(lights, 9);
    view.settings.false_color = 1.0;
    let palette = color::categories()[..4].to_vec();
    view.false_color = Some(FalseColor { palette: palette.clone() });
    let frame = render(&mut scene, &view);
    assert!(close(frame.color.color(5, 6), palette[1], 1e-5));
    assert!(close(frame.color.color(3, 2), palette[3], 1e-5), "tag 7 starts again after 4 colours");
    view.false_color = Some(FalseColor { palette: Vec::new() });
    assert!(scene.render(&Context::serial(), &view).is_err());
}

#[test]
fn one_and_several_threads_make_the_same_picture() {
    let make = |threads| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let (mut scene, object) = scene_of(square(2.0));
        for number in 0..8 {
            let mut ball = sphere(24);
            for point in &mut ball.points {
                *point =
                    (Vec3::from(*point) * 0.3 + Vec3::new((number as f32).sin(), (number as f32).cos(), 0.2)).into();
            }
            scene.set_mesh(object, number + 1, ball).unwrap();
        }
        let mut view = above(Lights::default(), 70);
        view.settings.samples = 4;
        view.settings.wireframe = Switch::ON;
        let frame = scene.render(&context, &view).unwrap();
        (frame.color, frame.depth, frame.normal, frame.object)
    };
    let one = make(1);
    assert!(one == make(2) && one == make(3));
}

#[test]
fn a_scene_far_from_the_origin_looks_the_same() {
    let look = |offset: DVec3| {
        let mut scene = Scene::new().unwrap();
        let object = scene.add_object(DAffine3::from_translation(offset), MATTE).unwrap();
        scene.set_mesh(object, 0, sphere(32)).unwrap();
        let mut view = above(Lights::default(), 33);
        view.camera = Camera::look_at(offset + DVec3::new(3.0, 2.0, 1.0), offset, DVec3::Z, 0.8).unwrap();
        render(&mut scene, &view).color
    };
    let (near, far) = (look(DVec3::ZERO), look(DVec3::new(1e8, -3e7, 5e6)));
    for (a, b) in near.data().iter().zip(far.data()) {
        assert!((a - b).abs() < 2e-2, "{a} {b}");
    }
}

#[test]
fn transforms_carry_normals_also_when_they_mirror_or_stretch() {
    let rotate = DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.5), DVec3::ZERO);
    for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(3.0, 0.5, 2.0)] {
        let mut mesh = square(1.0);
        let flat = mesh.clone();
        mesh.normals = vec![[0.0, 0.0, 1.0]; 4];
        for mesh in [mesh, flat] {
            let (mut scene, object) = scene_of(mesh);
            scene.set_transform(object, rotate * DAffine3::from_scale(scale)).unwrap();
            let normal = render(&mut scene, &above(dark(), 3)).normal.color(1, 1);
            assert!(close(normal, [0.0, -(0.5f32).sin(), (0.5f32).cos()], 1e-6), "{normal:?} for {scale:?}");
        }
    }
}

#[test]
fn meshes_can_be_moved_replaced_and_removed() {
    let (mut scene, object) = scene_of(square(5.0));
    let view = above(dark(), 3);
    let depth = |scene: &mut Scene| render(scene, &view).depth.data()[4];
    assert!((depth(&mut scene) - 5.0).abs() < 1e-5);
    let raised = square(5.0).points.iter().map(|[x, y, _]| [*x, *y, 1.0]).collect();
    scene.move_points(object, 0, raised, Vec::new()).unwrap();
    assert!((depth(&mut scene) - 4.0).abs() < 1e-5);
    scene.set_transform(object, DAffine3::from_translation(DVec3::Z)).unwrap();
    assert!((depth(&mut scene) - 3.0).abs() < 1e-5);
    scene.set_mesh(object, 0, square(5.0)).unwrap();
    assert!((depth(&mut scene) - 4.0).abs() < 1e-5);
    assert_eq!(scene.triangle_count(), 2);
    scene.remove_mesh(object, 0).unwrap();
    assert_eq!(depth(&mut scene), f32::INFINITY);
    scene.remove_object(object).unwrap();
    assert!(scene.set_mesh(object, 0, square(1.0)).is_err());
}

#[test]
fn what_cannot_be_rendered_is_refused() {
    let (mut scene, object) = scene_of(square(1.0));
    let bad = Mesh { triangles: vec![[0, 1, 4]], ..square(1.0) };
    assert!(scene.set_mesh(object, 1, bad).unwrap_err().to_string().contains("triangle 0"));
    let bad = Mesh { normals: vec![[0.0; 3]], ..square(1.0) };
    assert!(scene.set_mesh(object, 1, bad).unwrap_err().to_string().contains("normals"));
    assert!(scene.set_transform(object, DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_err());
    assert!(scene.set_transform(object, DAffine3::from_translation(DVec3::NAN)).is_err());
    assert!(scene.set_material(object, Material { roughness: 2.0, ..MATTE }).is_err());
    let mut view = above(dark(), 3);
    view.settings.width = 0;
    assert!(scene.render(&Context::serial(), &view).unwrap_err().to_string().contains("width"));
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: 1000 }).unwrap();
    assert_eq!(scene.render(&context, &above(dark(), 64)).unwrap_err().kind, ErrorKind::Memory);
}
