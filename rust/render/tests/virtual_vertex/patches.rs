//! Bézier patches against the same on the processor, and pictures of them.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::Context;
use relievo_gpu::Device;
use relievo_meshio::Patches;
use relievo_render::virtual_vertex::{Placed, Rasterizer, Shape, Storage, VirtualVertices};
use relievo_render::{Frame, Material, Mesh, NO_OBJECT, Scene, compare_geometry};
use relievo_surface::bezier::{BezierSurface, EdgeSense, Levels, ParametricMap};
use relievo_testing::{Random, device, tea_set};

use crate::{picture, view};

/// Makes surfaces of the tea set, as it is and with weights. None where the data is not there.
fn models(context: &Context) -> Vec<(String, BezierSurface)> {
    let surface = |it: &Patches| BezierSurface::new(context, &it.points, Some(&it.indices), it.weights.as_deref());
    tea_set(context).into_iter().map(|(name, patches)| (name, surface(&patches).unwrap())).collect()
}

fn mixed(surface: &BezierSurface, seed: u64, most: usize) -> Levels {
    let mut random = Random(seed);
    Levels::new(surface, (0..surface.count()).map(|_| 1 + random.below(most) as u8).collect()).unwrap()
}

/// Point and normal of every sample of every patch, as grids.
fn samples(device: &Device, surface: &BezierSurface, levels: &Levels) -> Vec<Vec<[[f32; 4]; 2]>> {
    let patches = VirtualVertices::new(device, surface, levels, Storage::Buffer, 7).unwrap();
    let mut grids = vec![Vec::new(); surface.count()];
    for draw in patches.draws() {
        let map = ParametricMap::new(draw.level).unwrap();
        let all = patches.samples(device, draw).unwrap();
        let (strips, stitches) = all.split_at(draw.vertices().unwrap() as usize);
        assert_eq!(stitches.len(), draw.stitches[1] as usize);
        for (copy, strip) in strips.chunks_exact(map.strip_vertices() as usize).enumerate() {
            let grid = &mut grids[patches.order()[draw.first as usize + copy] as usize];
            grid.resize(map.samples() as usize, [[f32::NAN; 4]; 2]);
            for (sample, [i, j]) in strip.iter().zip(map.strip()) {
                let at = &mut grid[(j * map.side() + i) as usize];
                // A strip visits samples more than once; they are the same each time.
                assert!(at[0][0].is_nan() || at == sample);
                *at = *sample;
            }
        }
    }
    grids
}

/// The triangles of all patches with the bits of their points: of grids, then those beside finer edges.
fn triangles(
    device: &Device,
    surface: &BezierSurface,
    levels: &Levels,
    grids: &[Vec<[[f32; 4]; 2]>],
) -> Vec<[[u32; 3]; 3]> {
    let bits = |sample: &[[f32; 4]; 2]| [0, 1, 2].map(|axis| (sample[0][axis] + 0.0).to_bits());
    let mut found = Vec::new();
    for (patch, grid) in grids.iter().enumerate() {
        let side = ParametricMap::new(levels.patch(patch)).unwrap().side() as usize;
        let at = |i: usize, j: usize| bits(&grid[j * side + i]);
        for (i, j) in (0..side - 1).flat_map(|j| (0..side - 1).map(move |i| (i, j))) {
            found.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            found.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let patches = VirtualVertices::new(device, surface, levels, Storage::Buffer, 7).unwrap();
    for draw in patches.draws() {
        let all = patches.samples(device, draw).unwrap();
        let stitches = &all[draw.vertices().unwrap() as usize..];
        found.extend(stitches.as_chunks::<3>().0.iter().map(|corners| corners.each_ref().map(bits)));
    }
    found
}

#[test]
fn points_and_normals_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for (name, surface) in models(&context) {
        let levels = mixed(&surface, 5, 5);
        let expected = surface.tessellate(&context, &levels).unwrap();
        let (low, high) = surface.total_bounds();
        let extent = Vec3::from(low).distance(Vec3::from(high));
        let grids = samples(&device, &surface, &levels);
        let (mut turned, mut count) = (0, 0);
        for (patch, grid) in grids.iter().enumerate() {
            let range = expected.first[patch] as usize..expected.first[patch + 1] as usize;
            assert_eq!(grid.len(), range.len(), "{name}");
            for (at, [p, normal]) in range.zip(grid) {
                let error = Vec3::from(expected.points[at]).distance(Vec3::new(p[0], p[1], p[2]));
                assert!(error <= 1e-6 * extent, "{name}, patch {patch}: {p:?} and {:?}", expected.points[at]);
                let normal = Vec3::new(normal[0], normal[1], normal[2]);
                assert!((normal.length() - 1.0).abs() < 1e-4, "{name}, patch {patch}: {normal}");
                count += 1;
                turned += usize::from(normal.dot(Vec3::from(expected.normals[at])) < 0.99999);
            }
        }
        assert!(turned * 1000 <= count, "{name}: {turned} of {count} normals differ");
    }
}

#[test]
fn both_sides_of_every_edge_have_the_same_points_on_the_device() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for (name, surface) in models(&context) {
        for round in 0..3 {
            let levels = mixed(&surface, 40 + round, 5);
            let grids = samples(&device, &surface, &levels);
            // Every side of a triangle has another triangle beside it, but where the surface has a border.
            let mut sides: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
            for corners in triangles(&device, &surface, &levels, &grids) {
                let [a, b, c] = corners;
                if a == b || b == c || a == c {
                    continue;
                }
                for (a, b) in [(a, b), (b, c), (c, a)] {
                    *sides.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
                }
            }
            let edges = surface.edges();
            let border: u32 = (0..edges.curve_count())
                .filter(|curve| edges.sharing(*curve).count() == 1)
                .flat_map(|curve| edges.sharing(curve))
                .filter(|(patch, edge)| edges.senses(*patch as usize)[usize::from(*edge)] != EdgeSense::Collapsed)
                .map(|(patch, edge)| (2 << levels.edges(patch as usize)[usize::from(edge)]) - 1)
                .sum();
            let open = sides.values().filter(|count| **count != 0).count();
            assert_eq!(open, border as usize, "{name}, round {round}");
            // Corners are one point in all patches, and that of the control net.
            let mut corners: BTreeMap<[u32; 3], ()> = BTreeMap::new();
            for patch in 0..surface.count() {
                let side = ParametricMap::new(levels.patch(patch)).unwrap().side() as usize;
                for (corner, number) in [(0, 0), (side - 1, 3), (side * side - 1, 15), (side * (side - 1), 12)] {
                    let p = grids[patch][corner][0];
                    let control = surface.controls(patch)[number];
                    assert_eq!(p[..3], control[..3], "{name}, patch {patch}");
                    corners.insert([p[0], p[1], p[2]].map(f32::to_bits), ());
                }
            }
            assert!(corners.len() < 4 * surface.count());
        }
    }
}

#[test]
fn pictures_do_not_depend_on_the_storage_and_are_those_of_the_ray_caster() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let material = Material { base_color: [0.6, 0.3, 0.2], specular: 0.04, roughness: 0.4 };
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    for (name, surface) in models(&context) {
        let up = if name.contains("teapot") { DVec3::Z } else { DVec3::Y };
        let (low, high) = surface.total_bounds();
        let [low, high] = [low, high].map(|corner| DVec3::from(corner.map(f64::from)));
        let middle = 0.5 * (low + high);
        let eye = middle + (DVec3::new(0.5, -0.6, 0.4) + up * 0.3) * (high - low).length() * 2.0;
        let view = view(middle, eye, up, [160, 120]);
        let levels = mixed(&surface, 9, 4);
        let mut first: Option<Frame> = None;
        for storage in Storage::ALL {
            for per_draw in [1, 5, 16] {
                let patches = VirtualVertices::new(&device, &surface, &levels, storage, per_draw).unwrap();
                let frame = rasterizer.render(&[Placed::new(Shape::Patches(&patches), material)], &view).unwrap();
                let first = first.get_or_insert_with(|| frame.clone());
                assert_eq!(first.object, frame.object, "{name}, {storage:?}, {per_draw} a draw");
                assert_eq!(first.depth, frame.depth, "{name}, {storage:?}, {per_draw} a draw");
                assert_eq!(first.color, frame.color, "{name}, {storage:?}, {per_draw} a draw");
            }
        }
        let frame = first.unwrap();
        let covered = frame.object.iter().filter(|object| **object != NO_OBJECT).count();
        assert!(covered > 1000, "{name}: {covered} pixels");
        // The same triangles, by rays.
        let tessellation = surface.tessellate(&context, &levels).unwrap();
        let mut scene = Scene::new().unwrap();
        let object = scene.add_object(DAffine3::IDENTITY, material).unwrap();
        let mesh = Mesh {
            points: tessellation.points,
            triangles: tessellation.triangles,
            normals: tessellation.normals,
            ..Mesh::default()
        };
        scene.set_mesh(object, 0, mesh).unwrap();
        let cast = scene.render(&context, &view).unwrap();
        let difference = compare_geometry(&picture(&cast), &picture(&frame), None).unwrap().unwrap();
        assert!(difference.silhouette() < 0.002, "{name}: {difference:?}");
        assert!(difference.depth.unwrap().p999 < 1e-4, "{name}: {difference:?}");
        assert!(difference.normal.unwrap().median < 0.5f64.to_radians(), "{name}: {difference:?}");
    }
}

#[test]
fn no_background_is_seen_between_patches_of_any_levels() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    // A sheet with relief of 6 × 6 patches, whose control points neighbours share, larger than the picture.
    let (side, mut random) = (6u32, Random(77));
    let width = 3 * side + 1;
    let points: Vec<[f32; 3]> =
        (0..width * width).map(|at| [(at % width) as f32, (at / width) as f32, 0.7 * random.unit()]).collect();
    let indices: Vec<u32> = (0..side * side)
        .flat_map(|patch| {
            let corner = 3 * (patch / side) * width + 3 * (patch % side);
            (0..16).map(move |number| corner + number / 4 * width + number % 4)
        })
        .collect();
    let weights: Vec<f32> = points.iter().map(|_| 0.5 + random.unit()).collect();
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let middle = DVec3::new(0.5, 0.5, 0.0) * f64::from(width - 1);
    let view = view(middle, middle + DVec3::new(3.0, -5.0, 18.0), DVec3::Y, [400, 300]);
    for weights in [None, Some(&weights[..])] {
        let surface = BezierSurface::new(&context, &points, Some(&indices), weights).unwrap();
        for seed in 0..3 {
            let levels = mixed(&surface, seed, 5);
            let patches = VirtualVertices::new(&device, &surface, &levels, Storage::Uniform, 8).unwrap();
            let frame =
                rasterizer.render(&[Placed::new(Shape::Patches(&patches), Material::default())], &view).unwrap();
            let holes = frame.object.iter().filter(|object| **object == NO_OBJECT).count();
            assert_eq!(holes, 0, "levels {seed}");
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let points: Vec<[f32; 3]> = (0..32).map(|at| [(at % 4) as f32, (at / 4) as f32, 0.0]).collect();
    let surface = BezierSurface::new(&context, &points, None, None).unwrap();
    let levels = Levels::uniform(&surface, 2).unwrap();
    for (storage, per_draw) in [(Storage::Uniform, 17), (Storage::Buffer, 0), (Storage::Texture, 1 << 20)] {
        assert!(VirtualVertices::new(&device, &surface, &levels, storage, per_draw).is_err());
    }
    let one = BezierSurface::new(&context, &points[..16], None, None).unwrap();
    assert!(VirtualVertices::new(&device, &one, &levels, Storage::Buffer, 1).is_err());
    let patches = VirtualVertices::new(&device, &surface, &levels, Storage::Buffer, 1).unwrap();
    assert_eq!(patches.draws().len(), 2);
    let mut view = view(DVec3::ZERO, DVec3::Z * 5.0, DVec3::Y, [16, 16]);
    view.settings.width = 16384;
    view.settings.samples = 9;
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    assert!(rasterizer.render(&[Placed::new(Shape::Patches(&patches), Material::default())], &view).is_err());
    device.abandon();
    let error = rasterizer.render(&[Placed::new(Shape::Patches(&patches), Material::default())], &view).unwrap_err();
    assert_eq!(error.kind, relievo_core::ErrorKind::Device, "{error}");
}
