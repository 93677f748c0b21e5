//! Displaced triangle meshes drawn in the pattern of their values, against the ray caster on the same triangles.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3, Vec3, Vec4};
use half::f16;
use relievo_core::{Context, Mesh};
use relievo_gpu::Device;
use relievo_render::virtual_vertex::{
    Placed, Rasterizer, Shape, Stage, Tint, TriangleCoat, TriangleRates, VirtualTriangles,
};
use relievo_render::{Frame, Material, NO_OBJECT, Scene, View, compare_geometry, write_png};
use relievo_surface::TriangleSurface;
use relievo_testing::{Random, device};
use relievo_tiles::triangle::{
    FaceRates, Pattern, TriangleChannel, TriangleDisplaced, TriangleNormals, TriangleOptions, TriangleSets,
    TriangleTessellation, TriangleValues,
};
use relievo_tiles::{ByFormat, ColorTexel, Rgba8, Texel, Trace, Vector};

use crate::{picture, traces_of, view};

const MATERIAL: Material = Material { base_color: [0.6, 0.3, 0.2], specular: 0.04, roughness: 0.4 };

/// An octahedron whose faces are split into four, twice, on the unit sphere.
fn ball() -> Mesh {
    let mut points: Vec<Vec3> = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]).collect();
    let mut triangles: Vec<[u32; 3]> = (0..8u32)
        .map(|k| {
            let [x, y, z] = [k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2 & 1)];
            if k.count_ones() % 2 == 0 { [x, y, z] } else { [x, z, y] }
        })
        .collect();
    for _ in 0..2 {
        let mut middles = BTreeMap::new();
        let mut split = Vec::new();
        for corners in &triangles {
            let [ab, bc, ca] = [0, 1, 2].map(|k| {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push((points[a as usize] + points[b as usize]).normalize());
                    points.len() as u32 - 1
                })
            });
            let [a, b, c] = *corners;
            split.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = split;
    }
    Mesh::from_triangles(points.into_iter().map(|point| point.to_array()).collect(), &triangles)
}

/// A square sheet of pairs of triangles.
fn sheet(n: u32) -> Mesh {
    let at = |k: u32| [(k % (n + 1)) as f32, (k / (n + 1)) as f32, 0.0];
    let corner = |i: u32, j: u32| j * (n + 1) + i;
    let pairs = (0..n * n).map(|k| (k % n, k / n)).flat_map(|(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    Mesh::from_triangles((0..(n + 1) * (n + 1)).map(at).collect(), &pairs.collect::<Vec<_>>())
}

struct Model {
    mesh: Mesh,
    surface: TriangleSurface,
    displacement: TriangleChannel,
    paint: TriangleChannel<Rgba8>,
}

/// Gives what has a block values by its place: `of` gets the number of the element and how far it is along.
fn fill<T: Texel>(channel: &mut TriangleChannel<T>, of: impl Fn(f32) -> T) {
    let field = channel.field().clone();
    let mut random = Random(7);
    let mut block = |count: usize| (0..count).map(|_| of(random.unit())).collect::<Vec<T>>();
    let faces = field.allocated().map(|face| (face, block(field.face(face).map_or(0, <[T]>::len)))).collect();
    let edges = field.allocated_edges().map(|edge| (edge, block(field.edge(edge).map_or(0, <[T]>::len)))).collect();
    let mut vertices: Vec<u32> = field.allocated().flat_map(|face| field.topology().face(face)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let vertices = vertices.into_iter().zip(block(field.topology().vertex_count())).collect();
    channel.write(TriangleValues { faces, edges, vertices }).unwrap();
}

impl Model {
    /// Faces of three levels, and those without values between them; paint is on others.
    fn new(mesh: Mesh, height: f32) -> Self {
        let context = Context::serial();
        let surface = TriangleSurface::new(&context, &mesh).unwrap();
        let options = TriangleOptions { segments: 16, budget: 1 << 26 };
        let topology = surface.topology().clone();
        let mut displacement = TriangleChannel::displacement(topology.clone(), &options).unwrap();
        let faces = topology.face_count() as u32;
        for (segments, rest) in [(4, 0), (8, 1), (16, 2)] {
            let allocate = (0..faces).filter(|face| face / 3 % 5 == rest).collect();
            let sets = TriangleSets { allocate, ..TriangleSets::default() };
            displacement.apply(&context, Pattern::new(segments).unwrap(), &sets).unwrap();
        }
        fill(&mut displacement, |value| f16::from_f32(height * value));
        let mut paint = TriangleChannel::<Rgba8>::of_color(topology, Vec4::new(0.5, 0.4, 0.3, 1.0), &options).unwrap();
        let sets = TriangleSets { allocate: (0..faces).filter(|face| face % 3 == 0).collect(), ..Default::default() };
        paint.apply(&context, Pattern::new(16).unwrap(), &sets).unwrap();
        fill(&mut paint, |value| Rgba8::of_color(Vec4::new(0.4 + 0.2 * value, 0.4, 0.4 - 0.2 * value, 1.0)));
        Self { mesh, surface, displacement, paint }
    }

    fn displaced(&self) -> TriangleDisplaced<'_> {
        TriangleDisplaced::new(&self.surface, self.displacement.field()).unwrap()
    }

    fn normals(&self) -> TriangleNormals {
        TriangleNormals::of(&Context::serial(), &self.displaced()).unwrap()
    }

    fn drawn(&self, device: &Device) -> VirtualTriangles {
        VirtualTriangles::new(&Context::serial(), device, &self.displaced(), &self.normals(), self.coat()).unwrap()
    }

    fn coat(&self) -> TriangleCoat<'_> {
        TriangleCoat { colors: Some(ByFormat::Rgba8(self.paint.field())), traces: None }
    }

    /// The same as triangles of the processor, with the colours of their corners.
    fn mesh(&self) -> relievo_render::Mesh {
        let displaced = self.displaced();
        let rates = |face: u32| FaceRates::of(displaced.field(), face).with(FaceRates::of(self.paint.field(), face));
        let context = Context::serial();
        let mut made = TriangleTessellation::new(&context, &displaced, &self.normals(), &self.mesh, rates).unwrap();
        made.paint(self.paint.field()).unwrap();
        relievo_render::Mesh::of_tessellation(made.mesh)
    }
}

fn plain(mut view: View) -> View {
    view.settings.shadows = relievo_core::parameter::Switch::OFF;
    view.settings.sky_rays = 0;
    view.settings.sky_filter = 0;
    view.lights.suns[0].angular_radius = 0.0;
    view
}

fn cast(mesh: relievo_render::Mesh, view: &View) -> Frame {
    let mut scene = Scene::new().unwrap();
    let object = scene.add_object(DAffine3::IDENTITY, MATERIAL).unwrap();
    scene.set_mesh(object, 0, mesh).unwrap();
    scene.render(&Context::serial(), view).unwrap()
}

fn shown<'a>(drawn: &'a VirtualTriangles) -> [Placed<'a>; 1] {
    [Placed::new(Shape::Triangles(drawn), MATERIAL)]
}

/// The largest value of what the share `share` of the pixels that both pictures and their neighbours show differs by.
fn difference(a: &Frame, b: &Frame, share: f64, of: impl Fn(&Frame, u32, u32) -> Vec3) -> f32 {
    let (width, height) = (a.color.width(), a.color.height());
    let covered = |frame: &Frame, x: u32, y: u32| frame.object[(y * width + x) as usize] != NO_OBJECT;
    let mut found = Vec::new();
    for (x, y) in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
        let around = [(0, 0), (0, 2), (2, 0), (2, 2), (1, 1)].map(|(i, j)| (x + i - 1, y + j - 1));
        if around.iter().all(|(x, y)| covered(a, *x, *y) && covered(b, *x, *y)) {
            found.push((of(a, x, y) - of(b, x, y)).abs().max_element());
        }
    }
    found.sort_by(f32::total_cmp);
    found[((found.len() - 1) as f64 * share) as usize]
}

#[test]
fn displaced_triangles_are_those_of_the_ray_caster() {
    let Some(device) = device() else { return };
    let model = Model::new(ball(), 0.02);
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let drawn = model.drawn(&device);
    let mesh = model.mesh();
    assert_eq!(drawn.triangle_count(), mesh.triangles.len() as u64);
    let view = plain(view(DVec3::ZERO, DVec3::new(2.0, -3.0, 2.5), DVec3::Z, [240, 180]));
    let frame = rasterizer.render(&shown(&drawn), &view).unwrap();
    let expected = cast(mesh, &view);
    if let Ok(folder) = std::env::var("RELIEVO_PICTURES") {
        for (name, frame) in [("device", &frame), ("rays", &expected)] {
            write_png(&std::path::Path::new(&folder).join(format!("triangles_{name}.png")), &frame.color).unwrap();
        }
    }
    let found = compare_geometry(&picture(&expected), &picture(&frame), None).unwrap().unwrap();
    assert!(found.covered > 6000 && found.silhouette() < 0.002, "{found:?}");
    assert!(found.depth.unwrap().p999 < 1e-4 && found.normal.unwrap().median < 0.5f64.to_radians(), "{found:?}");
    let albedo = difference(&expected, &frame, 0.99, |frame, x, y| Vec3::from(frame.albedo.color(x, y)));
    let color = difference(&expected, &frame, 0.95, |frame, x, y| Vec3::from(frame.color.color(x, y)));
    println!("{found:?}; albedo {albedo}, colour {color}");
    assert!(albedo < 1.0 / 255.0 && color < 2.0 / 255.0, "{albedo} {color}");
}

#[test]
fn no_background_is_seen_between_triangles_of_any_rates() {
    let Some(device) = device() else { return };
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let model = Model::new(sheet(6), 0.05);
    let middle = DVec3::new(3.0, 3.0, 0.0);
    let view = plain(view(middle, middle + DVec3::new(0.5, -1.0, 5.0), DVec3::Y, [400, 300]));
    let mut drawn = model.drawn(&device);
    let finest = drawn.finest();
    for seed in 0..4 {
        let mut random = Random(seed);
        let mut any = |list: &[u8]| list.iter().map(|most| random.below(usize::from(*most) + 1) as u8).collect();
        let rates = TriangleRates { faces: any(&finest.faces), edges: any(&finest.edges) };
        drawn.divide(&device, if seed == 0 { finest.clone() } else { rates }).unwrap();
        let frame = rasterizer.render(&shown(&drawn), &view).unwrap();
        let holes = frame.object.iter().filter(|object| **object == NO_OBJECT).count();
        assert_eq!(holes, 0, "rates {seed}");
    }
}

#[test]
fn adapted_triangles_look_like_all_of_them() {
    let Some(device) = device() else { return };
    let mut rasterizer = Rasterizer::new(&device).unwrap();
    let mut model = Model::new(ball(), 0.004);
    let context = Context::serial();
    let plainly =
        VirtualTriangles::new(&context, &device, &model.displaced(), &model.normals(), TriangleCoat::default());
    let mut drawn = plainly.unwrap();
    let all = drawn.triangle_count();
    let mut before = u64::MAX;
    for distance in [4.0, 8.0, 40.0] {
        let eye = DVec3::new(0.4, -0.7, 0.5).normalize() * distance;
        let view = plain(view(DVec3::ZERO, eye, DVec3::Z, [480, 360]));
        drawn.divide(&device, drawn.finest()).unwrap();
        let expected = rasterizer.render(&shown(&drawn), &view).unwrap();
        drawn.adapt(&device, &view.viewpoint(&DAffine3::IDENTITY), 0.5).unwrap();
        let frame = rasterizer.render(&shown(&drawn), &view).unwrap();
        let found = compare_geometry(&picture(&expected), &picture(&frame), None).unwrap().unwrap();
        println!("{distance}: {} of {all} triangles, {found:?}", drawn.triangle_count());
        // Half a pixel all around is as much.
        let rim = 4.0 / (found.covered as f64).sqrt();
        assert!(found.silhouette() < rim && drawn.triangle_count() <= before, "{found:?}");
        before = drawn.triangle_count();
    }
    assert!(before < all / 4, "{before} of {all}");
    // Colours need triangles of a pixel where they are as different as here.
    let mut drawn = model.drawn(&device);
    let far = view(DVec3::ZERO, DVec3::new(0.0, 900.0, 1.0), DVec3::Z, [64, 48]).viewpoint(&DAffine3::IDENTITY);
    drawn.adapt(&device, &far, 0.5).unwrap();
    assert_eq!(drawn.triangle_count(), model.mesh.triangles().len() as u64);
    assert!(drawn.adapt(&device, &far, 0.0).is_err());
    // An edit is seen as if all had been sent anew.
    let near = plain(view(DVec3::ZERO, DVec3::new(2.0, -3.0, 2.5), DVec3::Z, [120, 90]));
    let sets = TriangleSets { allocate: vec![9, 12, 40], deallocate: vec![0, 6], ..TriangleSets::default() };
    model.displacement.apply(&context, Pattern::new(16).unwrap(), &sets).unwrap();
    fill(&mut model.displacement, |value| f16::from_f32(-0.02 * value));
    let changed: Vec<u32> = (0..model.mesh.triangles().len() as u32).collect();
    drawn.update(&context, &device, &model.displaced(), &model.normals(), model.coat(), &changed).unwrap();
    drawn.divide(&device, drawn.finest()).unwrap();
    let after = rasterizer.render(&shown(&drawn), &near).unwrap();
    let anew = rasterizer.render(&shown(&model.drawn(&device)), &near).unwrap();
    assert_eq!((&after.depth, &after.color, &after.object), (&anew.depth, &anew.color, &anew.object));
    let bare = TriangleCoat::default();
    assert!(drawn.update(&context, &device, &model.displaced(), &model.normals(), bare, &[]).is_err());
}

#[test]
fn vectors_and_traces_of_triangles_are_those_of_the_ray_caster() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let model = Model::new(ball(), 0.01);
    let topology = model.surface.topology().clone();
    let faces = topology.face_count() as u32;
    let options = TriangleOptions { segments: 16, budget: 1 << 26 };
    let mut vectors = TriangleChannel::<Vector>::vectors(topology, &options).unwrap();
    let sets = TriangleSets { allocate: (0..faces).filter(|face| face % 4 == 1).collect(), ..Default::default() };
    vectors.apply(&context, Pattern::new(8).unwrap(), &sets).unwrap();
    fill(&mut vectors, |value| Vector([0.03 * value, 0.03 - 0.04 * value, -0.02 * value].map(f16::from_f32)));
    let mut traces = TriangleChannel::<Trace>::of(model.displacement.field(), 1 << 26).unwrap();
    let sets = TriangleSets { allocate: (0..faces).filter(|face| face % 5 < 2).collect(), ..Default::default() };
    traces.apply(&context, Pattern::new(16).unwrap(), &sets).unwrap();
    fill(&mut traces, |value| Trace::default().pushed(0.2 * value, 1.0 + value));
    let offsets = vectors.field().in_object_space(&context, &model.surface);
    let displaced = model.displaced().with_vectors(&offsets).unwrap();
    let normals = TriangleNormals::of(&context, &displaced).unwrap();
    let view = plain(view(DVec3::ZERO, DVec3::new(2.0, -3.0, 2.5), DVec3::Z, [240, 180]));
    let tint = Tint { color: [0.05, 0.1, 0.8], depth: 0.1, fade: 4.0, time: 2.5 };
    let mut stage = Stage::new(&device).unwrap();
    let object = stage.add_object(DAffine3::IDENTITY, MATERIAL);
    let mut before: Option<Frame> = None;
    for (tint, colors) in [(tint, None), (Tint { time: 4.5, ..tint }, None), (tint, model.coat().colors)] {
        let coat = TriangleCoat { colors, traces: Some((traces.field(), tint)) };
        // Only the time is another the second time; colours are new the third.
        let changed = before.as_ref().map(|_| &[][..]);
        stage.set_triangles(&context, object, (&displaced, &normals, coat), changed, |_| 0).unwrap();
        let frame = stage.render(&view).unwrap();
        let rates = |face: u32| {
            let rates = displaced.rates(face).with(FaceRates::of(traces.field(), face));
            if colors.is_some() { rates.with(FaceRates::of(model.paint.field(), face)) } else { rates }
        };
        let mut made = TriangleTessellation::new(&context, &displaced, &normals, &model.mesh, rates).unwrap();
        made.trace(traces.field(), f64::from(tint.time));
        made.paint(model.paint.field()).unwrap();
        let [contact, depth, age] = traces_of(&made.mesh);
        let mut mesh = relievo_render::Mesh::of_tessellation(made.mesh);
        for (at, color) in mesh.colors.iter_mut().enumerate() {
            let base = if colors.is_some() { *color } else { MATERIAL.base_color };
            let share = contact[at] * (depth[at] / tint.depth).min(1.0) * (1.0 - age[at] / tint.fade).max(0.0);
            *color = Vec3::from(base).lerp(Vec3::from(tint.color), share).to_array();
        }
        let expected = cast(mesh, &view);
        if let Ok(folder) = std::env::var("RELIEVO_PICTURES") {
            for (name, frame) in [("device", &frame), ("rays", &expected)] {
                let file = format!("triangle_vectors_{}_{name}.png", tint.time);
                write_png(&std::path::Path::new(&folder).join(file), &frame.color).unwrap();
            }
        }
        let found = compare_geometry(&picture(&expected), &picture(&frame), None).unwrap().unwrap();
        assert!(found.covered > 6000 && found.silhouette() < 0.002, "{found:?}");
        assert!(found.depth.unwrap().p999 < 1e-4 && found.normal.unwrap().median < 0.5f64.to_radians(), "{found:?}");
        let albedo = difference(&expected, &frame, 0.99, |frame, x, y| Vec3::from(frame.albedo.color(x, y)));
        println!("{tint:?}: {found:?}; albedo {albedo}");
        assert!(albedo < 1.0 / 255.0, "{albedo}");
        assert!(before.replace(frame.clone()).is_none_or(|before| before.albedo != frame.albedo));
    }
}
