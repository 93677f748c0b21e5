//! Displaced surfaces drawn from virtual tiles, against the ray caster on the same.

use glam::{DAffine3, DVec3, Vec3, Vec4};
use half::f16;
use relievo_core::{Context, Crease, Mesh};
use relievo_gpu::Device;
use relievo_render::virtual_vertex::{
    Coat, DeviceCoat, DeviceMesh, DrawnSurface, MAX_POWER, Placed, Rasterizer, Shape, Stage, TileRates, Tint,
    VirtualTiles,
};
use relievo_render::{FalseColor, Frame, Material, NO_OBJECT, Scene, Sun, View, compare_geometry, write_png};
use relievo_surface::bezier::Viewpoint;
use relievo_surface::{DeviceSurface, Place, Surface, SurfaceOptions};
use relievo_testing::{Random, device, grid};
use relievo_tiles::channel::ChannelOptions;
use relievo_tiles::{
    ByFormat, ColorTexel, DeviceTiles, Displaced, Displacement, DisplacementOptions, Paint, Points, Rgba8, Rgba16,
    Sets, Trace, Traces, Vector, VectorDisplacement, uniform_rates,
};

use crate::{picture, traces_of, view};

/// A closed prism with a hexagon at each end, whose sub-tiles lie beside quads; one rim is infinitely sharp, the other
/// less.
fn prism() -> Mesh {
    let mut mesh = Mesh::default();
    for (z, radius) in [(0.0, 1.0), (0.9, 1.3), (2.0, 0.8)] {
        for k in 0..6 {
            let angle = std::f32::consts::TAU * k as f32 / 6.0;
            mesh.points.push([radius * angle.cos(), radius * angle.sin(), z]);
        }
    }
    for row in 0..2u32 {
        for k in 0..6u32 {
            let (a, b) = (6 * row + k, 6 * row + (k + 1) % 6);
            mesh.face_sizes.push(4);
            mesh.corners.extend([a, b, b + 6, a + 6]);
        }
    }
    mesh.face_sizes.extend([6, 6]);
    mesh.corners.extend((0..6).rev());
    mesh.corners.extend(12..18);
    for k in 0..6 {
        mesh.creases.push(Crease { points: [12 + k, 12 + (k + 1) % 6], sharpness: 10.0 });
        mesh.creases.push(Crease { points: [k, (k + 1) % 6], sharpness: 1.5 });
    }
    mesh
}

/// A displaced and painted surface, and what a device has of it.
struct Model {
    cage: Mesh,
    surface: Surface,
    displacement: Displacement,
    paint: Paint<Rgba8>,
    on_device: DeviceSurface,
    tiles: DeviceTiles,
    coat: DeviceCoat,
}

fn paint<T: ColorTexel>(surface: &Surface) -> Paint<T> {
    let context = Context::serial();
    let options = ChannelOptions { size: 32, ..ChannelOptions::default() };
    let mut paint = Paint::<T>::of_color(surface.topology().clone(), Vec4::new(0.5, 0.4, 0.3, 1.0), &options).unwrap();
    let all: Vec<u32> = (0..surface.tile_count() as u32).collect();
    paint.apply(&Sets { allocate: all.clone(), ..Sets::default() }).unwrap();
    let changes = paint.edit(&context, &all, |_, texels| {
        let n = texels.size() as f32;
        for j in 0..texels.size() {
            for (i, texel) in texels.row_mut(j).iter_mut().enumerate() {
                // Nothing along edges, so that tiles of any kind agree there.
                let at = |k: usize| (std::f32::consts::PI * (k as f32 + 0.5) / n).sin().powi(2);
                let share = at(i) * at(j);
                *texel = T::of_color(Vec4::new(0.4 + 0.2 * share, 0.4, 0.4 - 0.2 * share, 1.0));
            }
        }
    });
    paint.settle(&context, &changes.unwrap()).unwrap();
    paint
}

impl Model {
    /// Two of three tiles of `cage` with waves `depth` times the extent high.
    fn new(device: &Device, cage: Mesh, depth: f32) -> Self {
        let context = Context::serial();
        let surface = Surface::new(&context, &cage, &SurfaceOptions::default()).unwrap();
        let options = DisplacementOptions { size: 32, face_sizes: vec![(0, 64), (3, 16)], ..Default::default() };
        let mut displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
        let some: Vec<u32> = (0..surface.tile_count() as u32).filter(|tile| tile % 3 != 2).collect();
        displacement.apply(&Sets { allocate: some.clone(), ..Sets::default() }).unwrap();
        let height = depth * surface.extent();
        let changes = displacement.edit(&context, &some, |tile, texels| {
            let mut random = Random(u64::from(tile));
            let (a, b) = (2.0 + 4.0 * random.unit(), 2.0 + 4.0 * random.unit());
            let n = texels.size() as f32;
            for j in 0..texels.size() {
                for (i, texel) in texels.row_mut(j).iter_mut().enumerate() {
                    *texel = f16::from_f32(height * ((a * i as f32 / n).sin() + (b * j as f32 / n).cos()));
                }
            }
        });
        displacement.settle(&context, &changes.unwrap()).unwrap();
        let paint = paint(&surface);
        let on_device = DeviceSurface::new(device, &surface).unwrap();
        let tiles = DeviceTiles::new(device, displacement.field()).unwrap();
        let coat = Coat { colors: Some(ByFormat::Rgba8(paint.field())), traces: None };
        let coat = DeviceCoat::new(&context, device, coat).unwrap();
        Self { cage, surface, displacement, paint, on_device, tiles, coat }
    }

    fn displaced(&self) -> Displaced<'_> {
        Displaced::new(&self.surface, self.displacement.field()).unwrap()
    }

    fn drawn(&self, device: &Device, cells: u32) -> VirtualTiles {
        VirtualTiles::new(&Context::serial(), device, &self.displaced(), cells).unwrap()
    }

    fn placed<'a>(&'a self, drawn: &'a VirtualTiles) -> Placed<'a> {
        let coat = Some(&self.coat);
        Placed::new(Shape::Tiles { surface: &self.on_device, tiles: &self.tiles, vectors: None, coat, drawn }, MATERIAL)
    }

    /// The same as triangles, with the colours of its points.
    fn mesh(&self, cells: u32) -> relievo_render::Mesh {
        let rates = uniform_rates(self.surface.topology(), cells);
        let mut made = self.displaced().tessellate(&Context::serial(), &self.cage, &rates).unwrap();
        made.paint(self.paint.field());
        relievo_render::Mesh::of_tessellation(made.mesh)
    }

    /// A view of all of it from a direction.
    fn view(&self, from: DVec3, size: [u32; 2]) -> View {
        let (low, high) = self.surface.bounds();
        let [low, high] = [low, high].map(|corner| DVec3::from(corner.map(f64::from)));
        let middle = 0.5 * (low + high);
        let up = if from.normalize().z.abs() > 0.9 { DVec3::Y } else { DVec3::Z };
        let mut view = view(middle, middle + from.normalize() * 2.4 * (high - low).length(), up, size);
        view.settings.shadows = relievo_core::parameter::Switch::OFF;
        view.settings.sky_rays = 0;
        view.settings.sky_filter = 0;
        view.lights.suns[0].angular_radius = 0.0;
        view
    }
}

const MATERIAL: Material = Material { base_color: [0.6, 0.3, 0.2], specular: 0.04, roughness: 0.4 };

fn cast(mesh: relievo_render::Mesh, view: &View) -> Frame {
    let mut scene = Scene::new().unwrap();
    let object = scene.add_object(DAffine3::IDENTITY, MATERIAL).unwrap();
    scene.set_mesh(object, 0, mesh).unwrap();
    scene.render(&Context::serial(), view).unwrap()
}

/// From where the rates are chosen.
fn viewpoint(view: &View) -> Viewpoint {
    view.viewpoint(&DAffine3::IDENTITY)
}

/// The values of two images in ascending order of how much they differ where both pictures and their neighbours show
/// something.
fn differences(a: &Frame, b: &Frame, of: impl Fn(&Frame, u32, u32) -> Vec3) -> Vec<f32> {
    let (width, height) = (a.color.width(), a.color.height());
    let covered = |frame: &Frame, x: u32, y: u32| frame.object[(y * width + x) as usize] != NO_OBJECT;
    let mut found = Vec::new();
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let around = (0..9).all(|k| {
                let (x, y) = (x + k % 3 - 1, y + k / 3 - 1);
                covered(a, x, y) && covered(b, x, y)
            });
            if around {
                found.push((of(a, x, y) - of(b, x, y)).abs().max_element());
            }
        }
    }
    found.sort_by(f32::total_cmp);
    found
}

fn color_of(image: &relievo_render::Image, x: u32, y: u32) -> Vec3 {
    Vec3::from(image.color(x, y))
}

#[test]
fn displaced_surfaces_are_those_of_the_ray_caster() {
    let Some(device) = device() else { return };
    let model = Model::new(&device, prism(), 0.01);
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let drawn = model.drawn(&device, 32);
    let view = model.view(DVec3::new(1.0, -1.4, 1.1), [240, 180]);
    let frame = rasterizer.render(&[model.placed(&drawn)], &view).unwrap();
    let expected = cast(model.mesh(32), &view);
    let difference = compare_geometry(&picture(&expected), &picture(&frame), None).unwrap().unwrap();
    assert!(difference.covered > 6000, "{difference:?}");
    assert!(difference.silhouette() < 0.002, "{difference:?}");
    assert!(difference.depth.unwrap().p999 < 1e-5, "{difference:?}");
    assert!(difference.normal.unwrap().median < 1e-4, "{difference:?}");
    let albedo = differences(&expected, &frame, |frame, x, y| color_of(&frame.albedo, x, y));
    let color = differences(&expected, &frame, |frame, x, y| color_of(&frame.color, x, y));
    let at = |list: &[f32], share: f64| list[((list.len() - 1) as f64 * share) as usize];
    println!(
        "{difference:?}; albedo {} {}; colour {} {}",
        at(&albedo, 0.5),
        at(&albedo, 0.99),
        at(&color, 0.5),
        at(&color, 0.99)
    );
    assert!(at(&albedo, 0.99) < 1.0 / 255.0, "{}", at(&albedo, 0.99));
    assert!(at(&color, 0.95) < 2.0 / 255.0, "{}", at(&color, 0.95));
    // Half floats hold the same colours.
    let halves = paint::<Rgba16>(&model.surface);
    let coat = Coat { colors: Some(ByFormat::Rgba16(halves.field())), traces: None };
    let coat = &DeviceCoat::new(&Context::serial(), &device, coat).unwrap();
    let (surface, tiles, coat, drawn) = (&model.on_device, &model.tiles, Some(coat), &drawn);
    let shape = Shape::Tiles { surface, tiles, vectors: None, coat, drawn };
    let halved = rasterizer.render(&[Placed::new(shape, MATERIAL)], &view).unwrap();
    assert_eq!(halved.depth, frame.depth);
    let albedo = differences(&halved, &frame, |frame, x, y| color_of(&frame.albedo, x, y));
    assert!(at(&albedo, 1.0) < 2.5 / 255.0, "{}", at(&albedo, 1.0));
}

#[test]
fn no_background_is_seen_between_tiles_of_any_rates() {
    let Some(device) = device() else { return };
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    // A sheet with faces of all kinds, larger than the picture.
    let model = Model::new(&device, grid(6, false, &[2, 3, 0, 2, 1], false), 0.01);
    let mut drawn = model.drawn(&device, 8);
    let middle = DVec3::new(3.0, 3.0, 0.0);
    let mut sheet = view(middle, middle + DVec3::new(0.5, -1.0, 5.0), DVec3::Y, [400, 300]);
    sheet.settings.shadows = relievo_core::parameter::Switch::OFF;
    let topology = model.surface.topology().clone();
    for seed in 0..3 {
        let mut random = Random(seed);
        let powers = (0..topology.tile_count()).map(|_| 1 + random.below(5) as u8).collect();
        drawn.divide(&device, TileRates::new(&topology, powers).unwrap()).unwrap();
        let frame = rasterizer.render(&[model.placed(&drawn)], &sheet).unwrap();
        let holes = frame.object.iter().filter(|object| **object == NO_OBJECT).count();
        assert_eq!(holes, 0, "rates {seed}");
        // The processor computes the same vertices.
        let passed = drawn.passed(&Context::serial(), &device, &model.displaced(), &MATERIAL).unwrap();
        let passed = rasterizer.render(&[Placed::new(Shape::Mesh(&passed), MATERIAL)], &sheet).unwrap();
        let difference = compare_geometry(&picture(&passed), &picture(&frame), None).unwrap().unwrap();
        assert_eq!(difference.alone, 0);
        assert!(difference.depth.unwrap().p999 < 1e-5, "{difference:?}");
    }
    // Cracks of a closed surface show its other side, far behind.
    let model = Model::new(&device, prism(), 0.01);
    let (mut fine, mut adapted) = (model.drawn(&device, 64), model.drawn(&device, 2));
    let extent = f64::from(model.surface.extent());
    for from in [DVec3::new(1.0, -1.4, 1.1), DVec3::new(-1.0, 0.2, -0.6), DVec3::new(0.1, 0.0, 1.0)] {
        let view = model.view(from, [240, 180]);
        adapted.adapt(&device, &viewpoint(&view), 0.5).unwrap();
        let powers: Vec<u8> = adapted.order().iter().map(|tile| adapted.rates().tile(*tile)).collect();
        assert!(powers.iter().min() < powers.iter().max() && powers.iter().all(|power| *power < MAX_POWER));
        let expected = rasterizer.render(&[model.placed(&fine)], &view).unwrap();
        let frame = rasterizer.render(&[model.placed(&adapted)], &view).unwrap();
        let difference = compare_geometry(&picture(&expected), &picture(&frame), None).unwrap().unwrap();
        assert!(difference.silhouette() < 0.004, "{difference:?}");
        let depths = differences(&expected, &frame, |frame, x, y| {
            Vec3::splat(frame.depth.data()[(y * frame.depth.width() + x) as usize])
        });
        // At bends of the outline a pixel may see another part of the surface.
        let far = depths.iter().filter(|difference| f64::from(**difference) > 0.05 * extent).count();
        assert!(far * 2000 < depths.len(), "{far} of {}", depths.len());
    }
    let rates = TileRates::uniform(model.surface.topology(), 16).unwrap();
    fine.divide(&device, rates).unwrap();
}

#[test]
fn counts_follow_from_rates_which_agree_on_both_sides_of_edges() {
    let Some(device) = device() else { return };
    let model = Model::new(&device, prism(), 0.0);
    let drawn = model.drawn(&device, 16);
    // Twelve quads of 16 × 16 cells and twelve sub-tiles of 8 × 8.
    let triangles: u64 = drawn.draws().iter().map(|draw| draw.triangles()).sum();
    let vertices: u64 = drawn.draws().iter().map(|draw| draw.vertices()).sum();
    assert_eq!(triangles, 12 * 2 * 256 + 12 * 2 * 64);
    assert_eq!(vertices, 12 * 17 * 17 + 12 * 81);
    assert_eq!(drawn.draws().len(), 2);
    let topology = model.surface.topology();
    let mut random = Random(4);
    let powers: Vec<u8> = (0..topology.tile_count()).map(|_| 1 + random.below(8) as u8).collect();
    let rates = TileRates::new(topology, powers).unwrap();
    for tile in 0..topology.tile_count() as u32 {
        for (edge, power) in (0..).zip(rates.edges(tile)) {
            let own = rates.tile(tile).min(MAX_POWER - u8::from(topology.is_sub(tile)));
            assert!((own..=MAX_POWER).contains(&power));
            match topology.link(tile, edge) {
                relievo_surface::Link::Whole { side, .. } => {
                    assert_eq!(power, rates.edges(side.tile)[usize::from(side.edge)]);
                }
                relievo_surface::Link::Halves { first, second, .. } => {
                    for side in [first, second] {
                        assert_eq!(power, rates.edges(side.tile)[usize::from(side.edge)] + 1);
                    }
                }
                _ => {}
            }
        }
    }
    assert!(TileRates::uniform(topology, 3).is_err() && TileRates::uniform(topology, 512).is_err());
    assert!(TileRates::new(topology, vec![0; topology.tile_count()]).is_err());
    assert!(TileRates::new(topology, vec![3; 2]).is_err());
}

/// The largest distance on the picture, in pixels, of places of `drawn`'s triangles from the surface, to first order: from
/// its tangent plane at the same parameters.
fn error(displaced: &Displaced<'_>, drawn: &VirtualTiles, view: &View) -> f64 {
    let context = Context::serial();
    let (mut places, triangles) = drawn.triangles(&context);
    let count = places.len();
    let shares =
        [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.33, 0.33, 0.34], [0.7, 0.2, 0.1], [0.1, 0.2, 0.7]];
    for corners in &triangles {
        let corners = corners.map(|corner| places[corner as usize]);
        places.extend(shares.map(|shares| {
            let mean = |of: fn(&Place) -> f32| (0..3).map(|k| shares[k] * of(&corners[k])).sum::<f32>().clamp(0.0, 1.0);
            Place::new(corners[0].tile, mean(|place| place.u), mean(|place| place.v))
        }));
    }
    let mut points = Points::default();
    displaced.evaluate(&context, &places, &mut points).unwrap();
    let viewpoint = viewpoint(view);
    let [eye, forward] = [viewpoint.eye, viewpoint.forward].map(DVec3::from);
    let per_unit = |p: DVec3| viewpoint.pixels / (p - eye).dot(forward) * (p - eye).length() / (p - eye).dot(forward);
    let (vertices, places) = points.p.split_at(count);
    let mut largest = 0.0f64;
    let places = places.iter().zip(&points.normal[count..]).collect::<Vec<_>>();
    for (corners, places) in triangles.iter().zip(places.chunks_exact(shares.len())) {
        let corners = corners.map(|corner| Vec3::from(vertices[corner as usize]));
        for (shares, (place, normal)) in shares.iter().zip(places) {
            let flat: Vec3 = (0..3).map(|k| shares[k] * corners[k]).sum();
            let away = (flat - Vec3::from(**place)).dot(Vec3::from(**normal)).abs();
            largest = largest.max(f64::from(away) * per_unit(flat.as_dvec3()));
        }
    }
    largest
}

fn triangles_of(drawn: &VirtualTiles) -> u64 {
    drawn.draws().iter().map(|draw| draw.triangles()).sum()
}

#[test]
fn adapted_tiles_are_within_the_tolerance_and_have_few_triangles() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let from = DVec3::new(1.0, -1.4, 1.1);
    for (depth, pictures) in
        [(0.0, [([240, 180], 0.5), ([960, 720], 0.1)]), (0.01, [([240, 180], 1.0), ([240, 180], 0.3)])]
    {
        let mut cage = prism();
        if depth > 0.0 {
            // Displaced along two normals the surface itself has a gap at a sharp edge, which triangles close.
            cage.creases.retain(|crease| crease.sharpness < 2.0);
        }
        let model = Model::new(&device, cage, depth);
        let mut drawn = model.drawn(&device, 2);
        for (size, tolerance) in pictures {
            let view = model.view(from, size);
            drawn.adapt(&device, &viewpoint(&view), tolerance).unwrap();
            let found = error(&model.displaced(), &drawn, &view);
            println!("depth {depth} {size:?} {tolerance}: {} triangles, {found} pixels", triangles_of(&drawn));
            assert!(found < tolerance, "{depth} {size:?}: {found} instead of {tolerance} pixels");
        }
    }
    // A tile of fine waves among tiles of none: what is fine ends beside it.
    let surface = Surface::new(&context, &grid(6, false, &[3], false), &SurfaceOptions::default()).unwrap();
    let mut displacement = Displacement::new(surface.topology().clone(), &Default::default()).unwrap();
    displacement.apply(&Sets { allocate: vec![14], ..Sets::default() }).unwrap();
    let changes = displacement.edit(&context, &[14], |_, texels| {
        let inner = 2..texels.size() - 2;
        for j in inner.clone() {
            let row = texels.row_mut(j);
            inner.clone().for_each(|i| row[i] = f16::from_f32(if (i + j) % 2 == 0 { 0.005 } else { -0.005 }));
        }
    });
    displacement.settle(&context, &changes.unwrap()).unwrap();
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let mut drawn = VirtualTiles::new(&context, &device, &displaced, 2).unwrap();
    let middle = DVec3::new(3.0, 3.0, 0.0);
    let sheet = view(middle, middle + DVec3::new(0.5, -1.0, 14.0), DVec3::Y, [960, 720]);
    drawn.adapt(&device, &viewpoint(&sheet), 0.5).unwrap();
    let rates = drawn.rates();
    let others: Vec<u32> = (0..36).filter(|tile| *tile != 14).collect();
    assert!(others.iter().all(|tile| rates.tile(*tile) + 2 < rates.tile(14)), "{rates:?}");
    let beside = others.iter().filter(|tile| rates.edges(**tile).iter().any(|edge| edge + 2 >= rates.tile(14))).count();
    assert!(beside <= 4, "{rates:?}");
    let found = error(&displaced, &drawn, &sheet);
    println!("a fine tile among 36: {} triangles, {found} pixels", triangles_of(&drawn));
    assert!(found < 0.5, "{found}");
    let Some(path) = relievo_testing::file("cages/spot_quadrangulated.obj") else { return };
    let cage = relievo_meshio::read(&context, &path).unwrap();
    let surface = Surface::new(&context, &cage, &SurfaceOptions::default()).unwrap();
    let displacement = Displacement::new(surface.topology().clone(), &Default::default()).unwrap();
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let mut drawn = VirtualTiles::new(&context, &device, &displaced, 2).unwrap();
    let (low, high) = surface.bounds();
    let [low, high] = [low, high].map(|corner| DVec3::from(corner.map(f64::from)));
    let middle = 0.5 * (low + high);
    let view = view(middle, middle + DVec3::new(0.6, 0.3, -1.0) * 1.8 * (high - low).length(), DVec3::Y, [480, 400]);
    drawn.adapt(&device, &viewpoint(&view), 0.5).unwrap();
    let found = error(&displaced, &drawn, &view);
    println!("spot: {} triangles, {found} pixels", triangles_of(&drawn));
    assert!(found < 0.5 && triangles_of(&drawn) < 50_000, "{found} {}", triangles_of(&drawn));
}

#[test]
fn edits_tags_and_placement_are_seen() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut model = Model::new(&device, prism(), 0.0);
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let mut drawn = model.drawn(&device, 16);
    let mut view = model.view(DVec3::new(1.0, -1.4, 1.1), [120, 90]);
    let before = rasterizer.render(&[model.placed(&drawn)], &view).unwrap();
    // What an edit raises is nearer.
    let tile = *before
        .object
        .iter()
        .filter(|tile| **tile != NO_OBJECT)
        .max_by_key(|tile| before.object.iter().filter(|other| other == tile).count())
        .unwrap();
    let height = 0.02 * model.surface.extent();
    model.displacement.apply(&Sets { allocate: vec![tile], ..Sets::default() }).unwrap();
    let changes = model.displacement.edit(&context, &[tile], |_, texels| {
        for j in 0..texels.size() {
            texels.row_mut(j).fill(f16::from_f32(height));
        }
    });
    model.displacement.settle(&context, &changes.unwrap()).unwrap();
    let changed = model.tiles.update(&device, model.displacement.field()).unwrap();
    assert!(changed.contains(&tile));
    let displaced = Displaced::new(&model.surface, model.displacement.field()).unwrap();
    drawn.update(&context, &device, &displaced, &changed).unwrap();
    drawn.tag(&device, |at| u32::from(at == tile)).unwrap();
    view.false_color = Some(FalseColor { palette: vec![[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]] });
    view.settings.false_color = 1.0;
    let after = rasterizer.render(&[model.placed(&drawn)], &view).unwrap();
    let expected = cast(model.mesh(16), &view);
    let difference = compare_geometry(&picture(&expected), &picture(&after), None).unwrap().unwrap();
    assert!(difference.depth.unwrap().p999 < 1e-4, "{difference:?}");
    let (mut raised, mut red) = (0, 0);
    for (at, object) in after.object.iter().enumerate().filter(|(_, object)| **object != NO_OBJECT) {
        let color = color_of(&after.color, at as u32 % 120, at as u32 / 120);
        assert_eq!(*object == tile, color.x > color.y, "pixel {at}: {color}");
        red += usize::from(*object == tile);
        raised += usize::from(after.depth.data()[at] < before.depth.data()[at] - 0.5 * height);
    }
    assert!(red > 200 && raised > 100, "{red} {raised}");
    // A mirror image elsewhere, with a number of its own, and its mesh beside it.
    let transform =
        DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)) * DAffine3::from_translation(DVec3::new(0.2, 0.1, 0.0));
    view.false_color = None;
    let mirrored = Placed { transform, number: Some(41), ..model.placed(&drawn) };
    let ours = rasterizer.render(&[mirrored], &view).unwrap();
    let mesh = DeviceMesh::new(&device, &model.mesh(16), &MATERIAL).unwrap();
    let placed = Placed { shape: Shape::Mesh(&mesh), ..mirrored };
    let theirs = rasterizer.render(&[placed], &view).unwrap();
    assert!(ours.object.iter().all(|object| [41, NO_OBJECT].contains(object)));
    let difference = compare_geometry(&picture(&theirs), &picture(&ours), None).unwrap().unwrap();
    assert!(difference.silhouette() < 0.002 && difference.depth.unwrap().p999 < 1e-4, "{difference:?}");
    assert!(difference.normal.unwrap().median < 0.5f64.to_radians(), "{difference:?}");
}

#[test]
fn stages_keep_what_changes() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut model = Model::new(&device, prism(), 0.01);
    let view = model.view(DVec3::new(1.0, -1.4, 1.1), [96, 72]);
    let rates = TileRates::uniform(model.surface.topology(), 8).unwrap();
    let mut stage = Stage::new(&device).unwrap();
    let nothing = stage.add_object(DAffine3::IDENTITY, MATERIAL);
    let object = stage.add_object(DAffine3::from_translation(DVec3::X), MATERIAL);
    stage.set_transform(object, DAffine3::IDENTITY).unwrap();
    assert!(stage.set_transform(object, DAffine3::ZERO).is_err());
    let show = |stage: &mut Stage, model: &Model, moved: bool| {
        let coat = Coat { colors: Some(ByFormat::Rgba8(model.paint.field())), traces: None };
        let shown = (&model.displaced(), coat);
        stage.set_surface(&context, object, shown, moved, rates.clone(), |_| 0).unwrap();
        stage.render(&view).unwrap()
    };
    let first = show(&mut stage, &model, false);
    let drawn = model.drawn(&device, 8);
    let expected = Rasterizer::new(&device).unwrap().render(&[model.placed(&drawn)], &view).unwrap();
    assert_eq!((&first.depth, &first.color), (&expected.depth, &expected.color));
    assert!(first.object.iter().all(|number| [object.number(), NO_OBJECT].contains(number)));
    // An edit of paint and displacement is seen, and its like elsewhere: in a stage that is made anew.
    let all: Vec<u32> = (0..model.surface.tile_count() as u32).collect();
    let changes = model.paint.edit(&context, &all[..9], |_, texels| {
        (0..texels.size()).for_each(|j| texels.row_mut(j).fill(Rgba8([255, 0, 0, 255])));
    });
    model.paint.settle(&context, &changes.unwrap()).unwrap();
    model.displacement.apply(&Sets { deallocate: vec![1, 4], allocate: vec![2], ..Sets::default() }).unwrap();
    let settled = model.displacement.edit(&context, &[2], |_, texels| {
        (0..texels.size()).for_each(|j| texels.row_mut(j).fill(f16::from_f32(0.03)));
    });
    model.displacement.settle(&context, &settled.unwrap()).unwrap();
    let after = show(&mut stage, &model, false);
    assert!(after.color != first.color && after.depth != first.depth);
    let again = show(&mut stage, &model, true);
    assert_eq!((&again.depth, &again.color, &again.object), (&after.depth, &after.color, &after.object));
    // A mesh in place of nothing hides what is behind it.
    let wall = relievo_render::Mesh {
        points: [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, z]| [x, -4.0, z]).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    };
    stage.set_mesh(nothing, 0, &wall).unwrap();
    let hidden = stage.render(&view).unwrap();
    assert!(hidden.object.iter().all(|number| *number == nothing.number()));
    stage.set_mesh(nothing, 0, &Default::default()).unwrap();
    assert_eq!(stage.render(&view).unwrap().object, again.object);
}

#[test]
fn vectors_are_those_of_the_ray_caster() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut cage = prism();
    cage.creases.retain(|crease| crease.sharpness < 2.0);
    let model = Model::new(&device, cage, 0.005);
    let options = ChannelOptions { size: 16, ..ChannelOptions::default() };
    let mut vectors = VectorDisplacement::on(&model.surface, &options).unwrap();
    let mut drawn = DrawnSurface::new(&context, &device, &model.displaced(), Coat::default()).unwrap();
    let some: Vec<u32> = (0..model.surface.tile_count() as u32).filter(|tile| tile % 4 != 1).collect();
    vectors.apply(&Sets { allocate: some.clone(), ..Sets::default() }).unwrap();
    let length = 0.02 * model.surface.extent();
    let changes = vectors.edit(&context, &some, |tile, texels| {
        let n = texels.size() as f32;
        for j in 0..texels.size() {
            for (i, texel) in texels.row_mut(j).iter_mut().enumerate() {
                // Nothing along edges, where frames of texels turn.
                let [u, v] = [i, j].map(|at| (at as f32 + 0.5) / n);
                let share = length * [u, v].map(|at| (std::f32::consts::PI * at).sin().powi(2)).iter().product::<f32>();
                let [a, b] = [4.0 * (u + tile as f32), 4.0 * v];
                *texel = Vector([a.sin(), (a + b).cos(), (a - b).sin()].map(|part| f16::from_f32(share * part)));
            }
        }
    });
    vectors.settle(&context, &changes.unwrap()).unwrap();
    let displaced = model.displaced().with_vectors(vectors.field()).unwrap();
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let view = model.view(DVec3::new(1.0, -1.4, 1.1), [240, 180]);
    let before = rasterizer.render(&[drawn.placed(DAffine3::IDENTITY, MATERIAL, None)], &view).unwrap();
    drawn.update(&context, &device, &displaced, Coat::default()).unwrap();
    drawn.tiles_mut().divide(&device, TileRates::uniform(model.surface.topology(), 32).unwrap()).unwrap();
    let frame = rasterizer.render(&[drawn.placed(DAffine3::IDENTITY, MATERIAL, None)], &view).unwrap();
    assert!(before.depth != frame.depth);
    let passed = drawn.tiles().passed(&context, &device, &displaced, &MATERIAL).unwrap();
    let passed = rasterizer.render(&[Placed::new(Shape::Mesh(&passed), MATERIAL)], &view).unwrap();
    let rates = uniform_rates(model.surface.topology(), 32);
    let made = displaced.tessellate(&context, &model.cage, &rates).unwrap();
    let mesh = relievo_render::Mesh::of_tessellation(made.mesh);
    // The processor's points in the same triangles, and its own tessellation.
    for expected in [&passed, &cast(mesh, &view)] {
        let found = compare_geometry(&picture(expected), &picture(&frame), None).unwrap().unwrap();
        println!("{found:?}");
        assert!(found.covered > 6000 && found.silhouette() < 0.002, "{found:?}");
        assert!(found.depth.unwrap().p999 < 1e-5 && found.normal.unwrap().median < 1e-4, "{found:?}");
    }
    drawn.adapt(&device, &view, &DAffine3::IDENTITY, 0.5).unwrap();
    let away = error(&displaced, drawn.tiles(), &view);
    println!("vectors: {} triangles, {away} pixels", triangles_of(drawn.tiles()));
    assert!(away < 0.5, "{away}");
    let adapted = rasterizer.render(&[drawn.placed(DAffine3::IDENTITY, MATERIAL, None)], &view).unwrap();
    let found = compare_geometry(&picture(&frame), &picture(&adapted), None).unwrap().unwrap();
    assert!(found.silhouette() < 0.004, "{found:?}");
    // Without them it is as before.
    drawn.update(&context, &device, &model.displaced(), Coat::default()).unwrap();
    drawn.tiles_mut().divide(&device, TileRates::uniform(model.surface.topology(), 2).unwrap()).unwrap();
    let after = rasterizer.render(&[drawn.placed(DAffine3::IDENTITY, MATERIAL, None)], &view).unwrap();
    assert_eq!(before.depth, after.depth);
}

#[test]
fn shadows_fall_where_the_ray_caster_has_them() {
    let Some(device) = device() else { return };
    let model = Model::new(&device, prism(), 0.01);
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let drawn = model.drawn(&device, 32);
    let mut view = model.view(DVec3::new(1.0, -1.4, 1.1), [160, 120]);
    view.settings.shadows = relievo_core::parameter::Switch::ON;
    let direction = [-0.8, -0.3, 0.6];
    view.lights.suns = vec![Sun { direction, irradiance: [3.0; 3], angular_radius: 0.0 }];
    let floor = relievo_render::Mesh {
        points: vec![[-4.0, -4.0, -0.2], [4.0, -4.0, -0.2], [4.0, 4.0, -0.2], [-4.0, 4.0, -0.2]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    };
    let on_device = DeviceMesh::new(&device, &floor, &MATERIAL).unwrap();
    let objects = [
        Placed { number: Some(0), ..model.placed(&drawn) },
        Placed { number: Some(1), ..Placed::new(Shape::Mesh(&on_device), MATERIAL) },
    ];
    let frame = rasterizer.render(&objects, &view).unwrap();
    let mut scene = Scene::new().unwrap();
    for mesh in [model.mesh(32), floor] {
        let object = scene.add_object(DAffine3::IDENTITY, MATERIAL).unwrap();
        scene.set_mesh(object, 0, mesh).unwrap();
    }
    let expected = scene.render(&Context::serial(), &view).unwrap();
    let (mut shadowed, mut wrong, mut count) = (0, 0, 0);
    for at in 0..frame.object.len() {
        if frame.object[at] != expected.object[at] || frame.object[at] == NO_OBJECT {
            continue;
        }
        let [a, b] = [&expected, &frame].map(|frame| color_of(&frame.color, at as u32 % 160, at as u32 / 160));
        count += 1;
        shadowed += usize::from(expected.object[at] == 1 && a.x < 0.3);
        wrong += usize::from((a - b).abs().max_element() > 0.15);
    }
    println!("{shadowed} shadowed, {wrong} of {count} differ");
    assert!(shadowed > 500 && wrong * 50 < count, "{shadowed} shadowed, {wrong} of {count} differ");
}

/// Writes a picture where `RELIEVO_PICTURES` says, to be looked at.
fn keep(name: &str, frame: &Frame) {
    if let Ok(folder) = std::env::var("RELIEVO_PICTURES") {
        write_png(&std::path::Path::new(&folder).join(format!("{name}.png")), &frame.color).unwrap();
    }
}

#[test]
fn colours_have_no_seam_between_tiles_of_different_density() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let cage = grid(4, false, &[2, 3, 1], false);
    let surface = Surface::new(&context, &cage, &SurfaceOptions::default()).unwrap();
    let displacement = Displacement::new(surface.topology().clone(), &Default::default()).unwrap();
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let faces = surface.topology().face_count() as u32;
    let face_sizes = (0..faces).map(|face| (face, [64, 8, 32, 16][face as usize * 5 % 4])).collect();
    let options = ChannelOptions { size: 32, face_sizes, ..ChannelOptions::default() };
    let blank = Vec4::new(0.5, 0.4, 0.3, 1.0);
    let mut paint = Paint::<Rgba16>::of_color(surface.topology().clone(), blank, &options).unwrap();
    let mut drawn: Option<DrawnSurface> = None;
    let middle = DVec3::new(2.0, 2.0, 0.0);
    let mut above = view(middle, middle + DVec3::new(0.0, -0.5, 9.0), DVec3::Y, [480, 400]);
    above.settings.shadows = relievo_core::parameter::Switch::OFF;
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    // First some tiles, then all: lists are made anew where something changed.
    let tiles = surface.tile_count() as u32;
    for round in 0..3u32 {
        let some: Vec<u32> = (0..tiles).filter(|tile| round == 1 || (tile + round) % 3 == 0).collect();
        paint.apply(&Sets { allocate: some.clone(), ..Sets::default() }).unwrap();
        let changes = paint.edit(&context, &some, |tile, texels| {
            let mut random = Random(u64::from(97 * round + tile));
            let size = texels.size();
            for j in 0..size {
                for texel in texels.row_mut(j) {
                    // Tiles differ in colour, and so do the texels of coarse ones.
                    let share = 0.3 * (tile % 3) as f32 + random.unit() * 2.0 / size as f32;
                    *texel = Rgba16::of_color(Vec4::new(0.2 + share, 0.5, 0.8 - share, 1.0));
                }
            }
        });
        paint.settle(&context, &changes.unwrap()).unwrap();
        let coat = Coat { colors: Some(ByFormat::Rgba16(paint.field())), traces: None };
        match &mut drawn {
            Some(drawn) => drawn.update(&context, &device, &displaced, coat).unwrap(),
            None => drawn = Some(DrawnSurface::new(&context, &device, &displaced, coat).unwrap()),
        }
        let Some(drawn) = &mut drawn else { return };
        drawn.tiles_mut().divide(&device, TileRates::uniform(surface.topology(), 128).unwrap()).unwrap();
        let frame = rasterizer.render(&[drawn.placed(DAffine3::IDENTITY, MATERIAL, None)], &above).unwrap();
        let rates = uniform_rates(surface.topology(), 256);
        let mut made = displaced.tessellate(&context, &cage, &rates).unwrap();
        made.paint(paint.field());
        let expected = cast(relievo_render::Mesh::of_tessellation(made.mesh), &above);
        keep(&format!("seams_{round}_device"), &frame);
        keep(&format!("seams_{round}_rays"), &expected);
        let albedo = differences(&expected, &frame, |frame, x, y| color_of(&frame.albedo, x, y));
        let [most, all] = [0.999, 1.0].map(|share| albedo[((albedo.len() - 1) as f64 * share) as usize]);
        println!("round {round}: {most} {all}");
        assert!(most < 1.0 / 255.0 && all < 4.0 / 255.0, "round {round}: {most} {all}");
    }
}

#[test]
fn traces_tint_as_on_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let model = Model::new(&device, prism(), 0.01);
    let mut traces = Traces::of(model.displacement.field(), 1 << 26).unwrap();
    let some: Vec<u32> = (0..model.surface.tile_count() as u32).filter(|tile| tile % 4 != 3).collect();
    traces.apply(&Sets { allocate: some.clone(), ..Sets::default() }).unwrap();
    let changes = traces.edit(&context, &some, |_, texels| {
        let n = texels.size() as f32;
        for j in 0..texels.size() {
            for (i, texel) in texels.row_mut(j).iter_mut().enumerate() {
                // A disc that goes deeper towards its middle, touched from left to right.
                let [u, v] = [i, j].map(|k| (k as f32 + 0.5) / n);
                let away = (u - 0.5).hypot(v - 0.5);
                if away < 0.45 {
                    *texel = Trace::default().pushed(0.2 * (0.45 - away), 1.0 + u);
                }
            }
        }
    });
    traces.settle(&context, &changes.unwrap()).unwrap();
    let tint = Tint { color: [0.05, 0.1, 0.8], depth: 0.06, fade: 4.0, time: 3.0 };
    let colors = Some(ByFormat::Rgba8(model.paint.field()));
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let view = model.view(DVec3::new(1.0, -1.4, 1.1), [240, 180]);
    let coat = Coat { colors, traces: None };
    let mut drawn = DrawnSurface::new(&context, &device, &model.displaced(), coat).unwrap();
    drawn.tiles_mut().divide(&device, TileRates::uniform(model.surface.topology(), 64).unwrap()).unwrap();
    let plain = rasterizer.render(&[drawn.placed(DAffine3::IDENTITY, MATERIAL, None)], &view).unwrap();
    for (tint, colors) in [
        (tint, colors),
        (Tint { time: 4.5, ..tint }, colors),
        (Tint { depth: 0.0, fade: 0.0, ..tint }, None),
        (Tint { time: 99.0, ..tint }, colors),
    ] {
        let coat = Coat { colors, traces: Some((traces.field(), tint)) };
        drawn.update(&context, &device, &model.displaced(), coat).unwrap();
        let frame = rasterizer.render(&[drawn.placed(DAffine3::IDENTITY, MATERIAL, None)], &view).unwrap();
        let rates = uniform_rates(model.surface.topology(), 64);
        let mut made = model.displaced().tessellate(&context, &model.cage, &rates).unwrap();
        made.paint(model.paint.field());
        made.trace(traces.field(), f64::from(tint.time));
        let [contact, depth, age] = traces_of(&made.mesh);
        let mut mesh = relievo_render::Mesh::of_tessellation(made.mesh);
        for (at, color) in mesh.colors.iter_mut().enumerate() {
            let base = if colors.is_some() { *color } else { MATERIAL.base_color };
            let deep = if tint.depth > 0.0 { (depth[at] / tint.depth).min(1.0) } else { 1.0 };
            let fresh = if tint.fade > 0.0 { (1.0 - age[at] / tint.fade).max(0.0) } else { 1.0 };
            *color = Vec3::from(base).lerp(Vec3::from(tint.color), contact[at] * deep * fresh).to_array();
        }
        let expected = cast(mesh, &view);
        keep(&format!("tints_{}_device", tint.time), &frame);
        keep(&format!("tints_{}_rays", tint.time), &expected);
        let albedo = differences(&expected, &frame, |frame, x, y| color_of(&frame.albedo, x, y));
        let at = |share: f64| albedo[((albedo.len() - 1) as f64 * share) as usize];
        println!("{tint:?}: {} {} {}", at(0.5), at(0.95), at(0.99));
        // Rims of discs go over a texel, which triangles interpolate.
        assert!(at(0.5) < 1e-3 && at(0.95) < 2.0 / 255.0 && at(0.99) < 0.06, "{} {} {}", at(0.5), at(0.95), at(0.99));
        let gone = tint.time > 50.0;
        assert_eq!(gone, frame.albedo == plain.albedo);
    }
}
