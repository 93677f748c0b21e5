//! Bakes to texture coordinates against closed forms.

use glam::{Vec3, Vec4};
use half::f16;
use relievo_bake::{Axes, BakeOptions, BakeReport, Handedness, Map, Quantity, Space, bake};
use relievo_core::{Attribute, Context, ContextOptions, Domain, Mesh, Values};
use relievo_surface::{Place, Surface, SurfaceOptions};
use relievo_tiles::{
    Change, Channel, ChannelOptions, Displaced, Displacement, Paint, Rgba16, Sets, Texel, Vector, VectorDisplacement,
};

/// Quads side by side in the plane z = 0, each of side 1, whose corners have these texture coordinates.
fn quads(islands: &[[[f32; 2]; 4]]) -> Mesh {
    let count = islands.len() as u32;
    let points = (0..2 * (count + 1)).map(|i| [(i % (count + 1)) as f32, (i / (count + 1)) as f32, 0.0]).collect();
    let corners = (0..count).flat_map(|i| [i, i + 1, i + count + 2, i + count + 1]).collect();
    let mut mesh = Mesh::new(points, vec![4; islands.len()], corners);
    let values = Values::F32(islands.as_flattened().as_flattened().to_vec());
    mesh.attributes.push(Attribute { name: "uv".into(), domain: Domain::Corner, width: 2, values, indices: None });
    mesh
}

const IDENTITY: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

fn moved(island: [[f32; 2]; 4], scale: f32, by: [f32; 2]) -> [[f32; 2]; 4] {
    island.map(|[s, t]| [scale * s + by[0], scale * t + by[1]])
}

struct Scene {
    context: Context,
    surface: Surface,
    limit: Surface,
}

impl Scene {
    fn new(mesh: &Mesh) -> Self {
        let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
        let options = SurfaceOptions::default();
        let surface = Surface::new(&context, mesh, &options).unwrap();
        let limit = Surface::face_varying(&context, mesh, "uv", &options).unwrap();
        Self { context, surface, limit }
    }

    fn bake(&self, quantity: &Quantity<'_>, options: &BakeOptions) -> (Vec<Map>, BakeReport) {
        let mut maps = Vec::new();
        let report = bake(&self.context, &self.limit, quantity, options, |map| {
            maps.push(map);
            Ok(())
        });
        (maps, report.unwrap())
    }

    fn displacement(&self, value: impl Fn(u32, f32, f32) -> f32 + Sync) -> Displacement {
        let mut made = Displacement::new(self.surface.topology().clone(), &ChannelOptions::default()).unwrap();
        fill(&self.context, &mut made, |tile, u, v| f16::from_f32(value(tile, u, v)));
        made
    }
}

/// Gives every texel the value at its centre.
fn fill<T: Texel>(context: &Context, channel: &mut Channel<T>, value: impl Fn(u32, f32, f32) -> T + Sync) {
    let tiles: Vec<u32> = (0..channel.field().tile_count() as u32).collect();
    channel.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let edit = channel.edit(context, &tiles, |tile, texels| {
        let size = texels.size();
        let centre = |k: usize| (k as f32 + 0.5) / size as f32;
        for j in 0..size {
            texels.row_mut(j).iter_mut().enumerate().for_each(|(i, t)| *t = value(tile, centre(i), centre(j)));
        }
    });
    edit.unwrap();
    let changes: Vec<Change> = tiles.into_iter().map(Change::all).collect();
    channel.settle(context, &changes).unwrap();
}

fn small(size: u32) -> BakeOptions {
    BakeOptions { size: [size; 2], gutter: 0, ..BakeOptions::default() }
}

/// s and t at the centre of a pixel.
fn centre(map: &Map, x: u32, y: u32) -> [f32; 2] {
    [(x as f32 + 0.5) / map.width as f32, 1.0 - (y as f32 + 0.5) / map.height as f32]
}

#[test]
fn a_plane_with_its_own_texture_coordinates_bakes_to_the_channel() {
    let scene = Scene::new(&quads(&[IDENTITY]));
    let made = scene.displacement(|_, u, v| 0.1 * (9.0 * u).sin() + 0.2 * (5.0 * v).cos());
    let options = BakeOptions { size: [96, 64], gutter: 0, ..BakeOptions::default() };
    let (maps, report) = scene.bake(&Quantity::Displacement(made.field()), &options);
    let map = &maps[0];
    assert_eq!((report.pictures, report.covered, report.overlapping), (vec![1001], 96 * 64, 0));
    for y in 0..64 {
        for x in 0..96 {
            let [u, v] = centre(map, x, y);
            let expected = made.field().point(scene.context.level(), Place::new(0, u, v)).d;
            assert!((map.pixel(x, y)[0] - expected).abs() < 1e-5, "({x}, {y})");
        }
    }
}

/// Four islands: as it is, turned by a quarter, mirrored, and both. The corner of each pixel's island follows from
/// where it is.
#[test]
fn turned_and_mirrored_islands_have_their_own_places_and_frames() {
    let turned = [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
    let mirrored = [[1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let both = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let shapes = [IDENTITY, turned, mirrored, both];
    let corners = [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5], [0.5, 0.5]];
    let islands: Vec<_> =
        shapes.iter().zip(corners).map(|(shape, by)| moved(*shape, 0.4, [by[0] + 0.05, by[1] + 0.05])).collect();
    let scene = Scene::new(&quads(&islands));
    // One slope in x and one in y all over.
    let (a, b) = (0.25, -0.5);
    let made = scene.displacement(|tile, u, v| a * (tile as f32 + u) + b * v);
    let displaced = Displaced::new(&scene.surface, made.field()).unwrap();
    let bake = |quantity| scene.bake(&quantity, &small(80)).0.remove(0);
    let map = bake(Quantity::Displacement(made.field()));
    let [vector_tbn, vector_tnb] =
        [Axes::Tbn, Axes::Tnb].map(|axes| bake(Quantity::Vector(displaced, Space::Tangent, axes)));
    let vector = bake(Quantity::Vector(displaced, Space::Object, Axes::Tbn));
    let [open_gl, direct_x] =
        [Handedness::OpenGl, Handedness::DirectX].map(|hand| bake(Quantity::Normal(displaced, Space::Tangent, hand)));
    let normal = bake(Quantity::Normal(displaced, Space::Object, Handedness::DirectX));
    // Vectors that are the same all over the sheet, along x, y and z.
    let mut vectors = VectorDisplacement::on(&scene.surface, &ChannelOptions::default()).unwrap();
    let all = Vec3::new(0.125, 0.25, 0.0625);
    fill(&scene.context, &mut vectors, |_, _, _| Vector(all.to_array().map(f16::from_f32)));
    let pushed = displaced.with_vectors(vectors.field()).unwrap();
    let pushed = bake(Quantity::Vector(pushed, Space::Tangent, Axes::Tnb));
    let expected_normal = Vec3::new(-a, -b, 1.0).normalize();
    let mut seen = [0; 4];
    for y in 0..80 {
        for x in 0..80 {
            let [s, t] = centre(&map, x, y);
            let tile = usize::from(s > 0.5) + 2 * usize::from(t > 0.5);
            let [ls, lt] = [(s - corners[tile][0] - 0.05) / 0.4, (t - corners[tile][1] - 0.05) / 0.4];
            let inside = [ls, lt].iter().all(|l| (0.0..=1.0).contains(l));
            assert_eq!(map.covered[(y * 80 + x) as usize], inside, "({x}, {y})");
            if !inside {
                assert_eq!((map.pixel(x, y), open_gl.pixel(x, y)), (&[0.0][..], &[0.0, 0.0, 1.0][..]));
                continue;
            }
            seen[tile] += 1;
            // The place, and T and B in the plane.
            let (u, v, tangent, bitangent) = match tile {
                0 => (ls, lt, Vec3::X, Vec3::Y),
                1 => (lt, 1.0 - ls, -Vec3::Y, Vec3::X),
                2 => (1.0 - ls, lt, -Vec3::X, Vec3::Y),
                _ => (lt, ls, Vec3::Y, Vec3::X),
            };
            let jet = made.field().point(scene.context.level(), Place::new(tile as u32, u, v));
            assert!((map.pixel(x, y)[0] - jet.d).abs() < 1e-5, "({x}, {y})");
            let near = |map: &Map, expected: Vec3, much: f32| {
                let found = Vec3::from_slice(map.pixel(x, y));
                assert!((found - expected).length() < much, "({x}, {y}): {found} and not {expected}");
            };
            near(&vector, Vec3::new(0.0, 0.0, jet.d), 1e-5);
            near(&vector_tbn, Vec3::new(0.0, 0.0, jet.d), 1e-5);
            near(&vector_tnb, Vec3::new(0.0, jet.d, 0.0), 1e-5);
            let sum = all + Vec3::new(0.0, 0.0, jet.d);
            near(&pushed, Vec3::from([tangent, Vec3::Z, bitangent].map(|axis| sum.dot(axis))), 1e-5);
            // At the border of the sheet the slope is another.
            if !(0.03..0.97).contains(&v) || tile == 0 && u < 0.03 || tile == 3 && u > 0.97 {
                continue;
            }
            near(&normal, expected_normal, 0.03);
            let parts = [tangent, bitangent, Vec3::Z].map(|axis| expected_normal.dot(axis));
            near(&open_gl, Vec3::from(parts), 0.03);
            near(&direct_x, Vec3::new(parts[0], -parts[1], parts[2]), 0.03);
        }
    }
    assert!(seen.iter().all(|count| *count > 900), "{seen:?}");
}

#[test]
fn udim_tiles_get_pictures_of_their_own_and_others_are_counted() {
    let islands = [IDENTITY, moved(IDENTITY, 1.0, [1.0, 0.0]), moved(IDENTITY, 0.5, [0.25, 2.25])];
    let scene = Scene::new(&quads(&islands));
    let made = scene.displacement(|tile, _, _| tile as f32 + 1.0);
    let quantity = Quantity::Displacement(made.field());
    let (maps, report) = scene.bake(&quantity, &BakeOptions { udim: true, ..small(32) });
    assert_eq!((&report.pictures[..], report.outside), (&[1001, 1002, 1021][..], 0));
    for (tile, map) in maps.iter().enumerate() {
        assert_eq!(map.pixel(16, 16), [tile as f32 + 1.0]);
    }
    assert_eq!(report.covered, 2 * 32 * 32 + 16 * 16);
    let (maps, report) = scene.bake(&quantity, &small(32));
    assert_eq!((maps.len(), &report.pictures[..], report.outside), (1, &[1001][..], 2));
}

#[test]
fn overlaps_are_counted_and_the_lowest_tile_has_them() {
    let scene = Scene::new(&quads(&[IDENTITY, moved(IDENTITY, 0.5, [0.0, 0.0])]));
    let made = scene.displacement(|tile, _, _| tile as f32);
    let (maps, report) = scene.bake(&Quantity::Displacement(made.field()), &small(64));
    assert_eq!((report.covered, report.overlapping), (64 * 64, 32 * 32));
    assert!(maps[0].pixel(8, 56)[0] < 0.6);
    // Faces that only touch do not overlap.
    let beside = [moved(IDENTITY, 0.5, [0.0, 0.0]), moved(IDENTITY, 0.5, [0.5, 0.0])];
    let (_, report) = Scene::new(&quads(&beside)).bake(&Quantity::Displacement(made.field()), &small(64));
    assert_eq!((report.covered, report.overlapping), (64 * 32, 0));
}

#[test]
fn the_gutter_leaves_no_background_and_samples_are_averaged() {
    let scene = Scene::new(&quads(&[moved(IDENTITY, 0.5, [0.26, 0.27])]));
    let mut paint =
        Paint::<Rgba16>::of_color(scene.surface.topology().clone(), Vec4::ONE, &ChannelOptions::default()).unwrap();
    fill(&scene.context, &mut paint, |_, u, _| {
        let [one, half] = [1.0, 0.5].map(f16::from_f32);
        Rgba16([if u < 0.5 { one } else { f16::ZERO }, half, f16::ZERO, one])
    });
    let field: &relievo_tiles::Field<Rgba16> = paint.field();
    for samples in [1, 3] {
        let options = BakeOptions { gutter: 7, samples, ..small(101) };
        let (maps, report) = scene.bake(&Quantity::Color(field), &options);
        let map = &maps[0];
        assert!(report.gutter > 0);
        let covered: Vec<(u32, u32)> =
            (0..101 * 101).filter(|i| map.covered[*i as usize]).map(|i| (i % 101, i / 101)).collect();
        let mut background = 0;
        for y in 0..101u32 {
            for x in 0..101u32 {
                let near = covered.iter().any(|(i, j)| i.abs_diff(x).max(j.abs_diff(y)) <= 7);
                assert_eq!(map.pixel(x, y)[3] == 1.0, near, "({x}, {y})");
                background += usize::from(!near);
            }
        }
        assert!(background > 1000);
        let (masks, _) = scene.bake(&Quantity::Mask(field), &options);
        assert!(masks[0].data.iter().zip(map.data.chunks_exact(4)).all(|(mask, color)| *mask == color[3]));
        let reds = covered.iter().map(|(x, y)| map.pixel(*x, *y)[0]).sum::<f32>() / covered.len() as f32;
        assert!((reds - 0.5).abs() < 0.02, "{reds}");
    }
}

#[test]
fn results_do_not_depend_on_threads_and_bad_options_are_refused() {
    let mut scene = Scene::new(&quads(&[IDENTITY, moved(IDENTITY, 0.5, [0.3, 0.3])]));
    let made = scene.displacement(|_, u, v| u * v);
    let quantity = Quantity::Displacement(made.field());
    let options = BakeOptions { samples: 2, gutter: 3, ..small(150) };
    let two = scene.bake(&quantity, &options);
    scene.context = Context::serial();
    assert!(scene.bake(&quantity, &options) == two);
    let fails = |context: &Context, limit: &Surface, options: &BakeOptions, word: &str| {
        let error = bake(context, limit, &quantity, options, |_| Ok(())).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    };
    fails(&scene.context, &scene.limit, &BakeOptions { size: [0, 4], ..options }, "use 1 to 32768");
    fails(&scene.context, &scene.limit, &BakeOptions { samples: 9, ..options }, "use 1 to 8 samples");
    let poor = Context::new(&ContextOptions { threads: 1, memory_limit: 1000 }).unwrap();
    fails(&poor, &scene.limit, &options, "memory limit");
    let away = Scene::new(&quads(&[moved(IDENTITY, 1.0, [3.0, 0.0]), moved(IDENTITY, 1.0, [5.0, 0.0])]));
    fails(&away.context, &away.limit, &options, "ask for pictures of UDIM tiles");
    let none = Scene::new(&quads(&[moved(IDENTITY, 0.0, [0.5, 0.5]); 2]));
    fails(&none.context, &none.limit, &options, "unwrap the mesh");
    let far = Scene::new(&quads(&[moved(IDENTITY, 1.0, [1e8, 0.0]); 2]));
    fails(&far.context, &far.limit, &options, "within 1000");
    let other = Scene::new(&quads(&[IDENTITY]));
    fails(&other.context, &other.limit, &options, "another surface");
    let huge = Scene::new(&quads(&[moved(IDENTITY, 900.0, [0.0, 0.0]); 2]));
    fails(&huge.context, &huge.limit, &BakeOptions { udim: true, ..small(16) }, "pictures");
    // A thousand faces on one square: too often for a large picture, and not for a small one.
    let heap = Scene::new(&quads(&[IDENTITY; 1000]));
    let made = heap.displacement(|_, _, _| 0.0);
    let quantity = Quantity::Displacement(made.field());
    let large = BakeOptions { samples: 8, ..small(1024) };
    let error = bake(&heap.context, &heap.limit, &quantity, &large, |_| Ok(())).unwrap_err().to_string();
    assert!(error.contains("cover the square of texture coordinates 1000 times"), "{error}");
    assert_eq!(heap.bake(&quantity, &small(16)).1.overlapping, 16 * 16);
}

/// A model of quads, triangles and pentagons with seams: what a host looks up in the map at a place's texture
/// coordinates is what the channel has there.
#[test]
fn a_map_of_a_real_model_looks_up_as_the_channel() {
    let Some(mesh) = relievo_testing::cage("spot_control_mesh.obj") else { return };
    let scene = Scene::new(&mesh);
    // A function of where the surface is, so that it is smooth across seams.
    let surface = scene.surface.clone();
    let level = scene.context.level();
    let height = move |tile: u32, u: f32, v: f32| {
        let p = surface.sample(level, Place::new(tile, u, v)).unwrap().p;
        0.1 * (4.0 * p[0] + 3.0 * p[1]).sin() * (3.0 * p[2]).cos()
    };
    let made = scene.displacement(&height);
    let options = BakeOptions { gutter: 4, ..small(1024) };
    let (maps, report) = scene.bake(&Quantity::Displacement(made.field()), &options);
    println!("{report}");
    let map = &maps[0];
    let (mut count, mut far) = (0, 0);
    for tile in 0..scene.surface.tile_count() as u32 {
        for k in 0..49 {
            let (u, v) = ((k % 7) as f32 / 6.0, (k / 7) as f32 / 6.0);
            let [s, t, _] = scene.limit.sample(level, Place::new(tile, u, v)).unwrap().p;
            let (x, y) = (s * 1024.0 - 0.5, (1.0 - t) * 1024.0 - 0.5);
            if !(0.0..1022.0).contains(&x) || !(0.0..1022.0).contains(&y) {
                continue;
            }
            let (i, j) = (x as u32, y as u32);
            let at = |i: u32, j: u32| map.pixel(i, j)[0];
            let (a, b) = (x - i as f32, y - j as f32);
            let low = at(i, j) * (1.0 - a) + at(i + 1, j) * a;
            let high = at(i, j + 1) * (1.0 - a) + at(i + 1, j + 1) * a;
            let found = low * (1.0 - b) + high * b;
            let expected =
                made.field().point(level, scene.surface.topology().canonical(Place::new(tile, u, v), |_| 1)).d;
            count += 1;
            far += usize::from((found - expected).abs() > 0.004);
        }
    }
    // Where faces lie on one another in the layout, only one of them can be found.
    println!("{far} of {count} are far off");
    assert!(count > 5000 && far * 100 < count, "{far} of {count}");
}
