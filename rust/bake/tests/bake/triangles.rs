//! Bakes of triangle meshes against closed forms.

use glam::{Vec2, Vec3, Vec4};
use half::f16;
use relievo_bake::triangles::{TriangleColors, TriangleQuantity, bake_triangles};
use relievo_bake::{Axes, BakeOptions, BakeReport, Handedness, Map, Meaning, Space};
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, ContextOptions, Domain, Mesh, Result, Values};
use relievo_surface::TriangleSurface;
use relievo_tiles::triangle::{TriangleChannel, TriangleDisplaced, TriangleNormals, TriangleOptions};
use relievo_tiles::{ColorTexel, Rgba8};

use crate::support::everywhere;

/// The unit square as two triangles, whose texture coordinates are `uv` of its points.
fn square(uv: impl Fn(Vec2) -> Vec2) -> Mesh {
    let points: Vec<[f32; 3]> = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut mesh = Mesh::from_triangles(points, &[[0, 1, 2], [0, 2, 3]]);
    let at = |corner: &u32| uv(Vec3::from(mesh.points[*corner as usize]).truncate()).to_array();
    let values = Values::F32(mesh.corners.iter().flat_map(at).collect());
    mesh.attributes.push(Attribute { name: "uv".into(), domain: Domain::Corner, width: 2, values, indices: None });
    mesh
}

const HEIGHT: fn(Vec3) -> f32 = |p| 0.25 * p.x + 0.125 * p.y;
const COLOR: fn(Vec3) -> Vec4 = |p| Vec4::new(p.x, p.y, 0.0, 1.0);

struct Scene {
    context: Context,
    mesh: Mesh,
    surface: TriangleSurface,
    heights: TriangleChannel<f16>,
    colors: TriangleChannel<Rgba8>,
}

impl Scene {
    fn new(threads: usize, mesh: Mesh) -> Self {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let surface = TriangleSurface::new(&context, &mesh).unwrap();
        let options = TriangleOptions { segments: 8, budget: 1 << 20 };
        let heights = TriangleChannel::displacement(surface.topology().clone(), &options).unwrap();
        let heights = everywhere(&context, &surface, heights, |p| f16::from_f32(HEIGHT(p)));
        let colors = TriangleChannel::of_color(surface.topology().clone(), Vec4::ONE, &options).unwrap();
        let colors = everywhere(&context, &surface, colors, |p| Rgba8::of_color(COLOR(p)));
        Self { context, mesh, surface, heights, colors }
    }

    fn try_bake(&self, meaning: Meaning, options: &BakeOptions) -> Result<(Vec<Map>, BakeReport)> {
        let displaced = TriangleDisplaced::new(&self.surface, self.heights.field()).unwrap();
        let normals = TriangleNormals::of(&self.context, &displaced).unwrap();
        let colors: Option<&dyn TriangleColors> = Some(self.colors.field());
        let quantity = TriangleQuantity { meaning, displaced, normals: &normals, colors, traces: None };
        let mut maps = Vec::new();
        let mesh = (&self.mesh, "uv");
        let report = bake_triangles(&self.context, mesh, &quantity, options, &mut Silent, |map| {
            maps.push(map);
            Ok(())
        })?;
        Ok((maps, report))
    }

    fn bake(&self, meaning: Meaning, options: &BakeOptions) -> (Vec<Map>, BakeReport) {
        self.try_bake(meaning, options).unwrap()
    }
}

fn options(size: [u32; 2]) -> BakeOptions {
    BakeOptions { size, udim: false, gutter: 0, samples: 1 }
}

/// Where the middle of a pixel of the only picture is in the plane, if texture coordinates are places.
fn middle(map: &Map, pixel: usize) -> Vec3 {
    let (x, y) = (pixel as u32 % map.width, pixel as u32 / map.width);
    Vec3::new((x as f32 + 0.5) / map.width as f32, 1.0 - (y as f32 + 0.5) / map.height as f32, 0.0)
}

#[test]
fn pixels_have_what_lies_on_them_for_any_number_of_threads_and_samples() {
    let [one, two] = [1, 2].map(|threads| Scene::new(threads, square(|p| p)));
    // Wider than a window, and higher than a band.
    for options in [options([300, 130]), BakeOptions { samples: 3, ..options([90, 70]) }] {
        let (maps, report) = one.bake(Meaning::Displacement, &options);
        let pixels = u64::from(options.size[0]) * u64::from(options.size[1]);
        assert_eq!((report.covered, report.overlapping, report.flat, report.outside), (pixels, 0, 0, 0));
        for (pixel, height) in maps[0].data.iter().enumerate() {
            let expected = HEIGHT(middle(&maps[0], pixel));
            assert!((height - expected).abs() < 3e-4, "pixel {pixel}: {height}, {expected}");
        }
        assert!(two.bake(Meaning::Displacement, &options) == (maps, report));
        let (maps, _) = one.bake(Meaning::Color, &options);
        for (pixel, color) in maps[0].data.chunks(4).enumerate() {
            let far = (Vec4::from_slice(color) - COLOR(middle(&maps[0], pixel))).abs().max_element();
            // Bytes are sRGB; between two of them colours are linear.
            assert!(far < 0.01, "pixel {pixel}: {far}");
        }
        let (maps, _) = one.bake(Meaning::Mask, &options);
        assert!(maps[0].data.iter().all(|alpha| (alpha - 1.0).abs() < 1e-6));
    }
}

#[test]
fn tangent_space_follows_the_texture_coordinates() {
    let slope = Vec3::new(-0.25, -0.125, 1.0).normalize();
    let near = |map: &Map, expected: Vec3| {
        for found in map.data.chunks(3) {
            assert!((Vec3::from_slice(found) - expected).abs().max_element() < 2e-3, "{found:?}, {expected}");
        }
    };
    let tangent = |handedness| Meaning::Normal(Space::Tangent, handedness);
    // As they are; mirrored; turned by a quarter, so that s runs along y and t against x.
    let plain = Scene::new(2, square(|p| p));
    let mirrored = Scene::new(2, square(|p| Vec2::new(1.0 - p.x, p.y)));
    let turned = Scene::new(2, square(|p| Vec2::new(p.y, 1.0 - p.x)));
    let small = options([8, 8]);
    for (scene, expected) in [
        (&plain, slope),
        (&mirrored, Vec3::new(-slope.x, slope.y, slope.z)),
        (&turned, Vec3::new(slope.y, -slope.x, slope.z)),
    ] {
        near(&scene.bake(tangent(Handedness::OpenGl), &small).0[0], expected);
        let other = Vec3::new(expected.x, -expected.y, expected.z);
        near(&scene.bake(tangent(Handedness::DirectX), &small).0[0], other);
        near(&scene.bake(Meaning::Normal(Space::Object, Handedness::OpenGl), &small).0[0], slope);
        let (maps, _) = scene.bake(Meaning::Vector(Space::Tangent, Axes::Tnb), &small);
        let (heights, _) = scene.bake(Meaning::Displacement, &small);
        for (vector, height) in maps[0].data.chunks(3).zip(&heights[0].data) {
            assert!(vector[0] == 0.0 && (vector[1] - height).abs() < 1e-6 && vector[2] == 0.0, "{vector:?}");
        }
    }
}

#[test]
fn squares_without_a_picture_overlaps_and_flat_triangles_are_counted() {
    // Over three columns and two rows of squares, from the middle of the first.
    let wide = Scene::new(2, square(|p| Vec2::new(0.5 + 2.0 * p.x, 0.5 + p.y)));
    let (maps, report) = wide.bake(Meaning::Displacement, &options([16, 16]));
    assert_eq!((maps.len(), report.outside, report.covered), (1, 5, 64));
    let (maps, report) = wide.bake(Meaning::Displacement, &BakeOptions { udim: true, ..options([16, 16]) });
    assert_eq!(report.pictures, [1001, 1002, 1003, 1011, 1012, 1013]);
    assert_eq!((report.outside, report.covered), (0, 2 * 16 * 16));
    // The middle of the second picture is at x = 0.5 in the plane, its upper half up to y = 0.5.
    let height = HEIGHT(Vec3::new(0.5 + 0.5 / 32.0, 0.5 / 16.0, 0.0));
    assert!((maps[1].data[7 * 16 + 8] - height).abs() < 1e-3);

    let folded = Scene::new(2, square(|p| Vec2::new(p.x.max(p.y), p.x.min(p.y))));
    let (_, report) = folded.bake(Meaning::Displacement, &options([16, 16]));
    assert!(report.overlapping >= 120 && report.overlapping <= 136, "{report}");
    let flat = Scene::new(2, square(|p| Vec2::new(p.x.max(p.y), p.y)));
    assert_eq!(flat.bake(Meaning::Displacement, &options([16, 16])).1.flat, 1);
}

#[test]
fn squares_covered_hundreds_of_times_are_refused_where_that_takes_long() {
    let one = square(|p| p);
    let (mut points, mut triangles, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let Values::F32(uv) = &one.attributes[0].values else { panic!("floats") };
    for level in 0..600u32 {
        points.extend(one.points.iter().map(|p| [p[0], p[1], level as f32]));
        triangles.extend([[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|corner: u32| corner + 4 * level)));
        values.extend_from_slice(uv);
    }
    let mut heap = Mesh::from_triangles(points, &triangles);
    heap.attributes.push(Attribute { values: Values::F32(values), ..one.attributes[0].clone() });
    let heap = Scene::new(2, heap);
    let large = BakeOptions { samples: 8, ..options([1024; 2]) };
    let error = heap.try_bake(Meaning::Displacement, &large).unwrap_err().to_string();
    assert!(error.contains("cover the square of texture coordinates 600 times"), "{error}");
    // All pixels but those on the common side of two triangles.
    assert_eq!(heap.bake(Meaning::Displacement, &options([16; 2])).1.overlapping, 16 * 15);
}

#[test]
fn what_cannot_be_baked_is_an_error() {
    let fails = |mesh: Mesh, udim: bool, words: &str| {
        let scene = Scene::new(1, mesh);
        let error = scene.try_bake(Meaning::Displacement, &BakeOptions { udim, ..options([4, 4]) }).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    };
    // As far apart as coordinates go, where counting squares one by one for every triangle would take long.
    fails(square(|p| 1900.0 * (p - 0.5)), true, "pictures");
    fails(square(|p| 2100.0 * (p - 0.5)), true, "within 1000");
    fails(square(|p| p + 3.0), false, "no texture coordinates");
    fails(square(|_| Vec2::ZERO), true, "no texture coordinates");
    let mut bare = square(|p| p);
    bare.attributes.clear();
    fails(bare, false, "no such attribute");
    let mut points = square(|p| p);
    points.attributes[0] = Attribute {
        name: "uv".into(),
        domain: Domain::Point,
        width: 2,
        values: Values::F32(vec![0.0; 8]),
        indices: None,
    };
    fails(points, false, "on corners");
    let scene = Scene::new(1, square(|p| p));
    for meaning in [Meaning::Contact, Meaning::Depth, Meaning::Time] {
        assert!(scene.try_bake(meaning, &options([4, 4])).unwrap_err().to_string().contains("no traces"));
    }
    let huge = BakeOptions { samples: 9, ..options([4, 4]) };
    assert!(scene.try_bake(Meaning::Displacement, &huge).is_err());
    assert!(scene.try_bake(Meaning::Displacement, &options([0, 4])).is_err());
}
