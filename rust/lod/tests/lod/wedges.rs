//! Attributes of progressive meshes: those of the input at the finest level, those of a simplification at the base, and what
//! every level between keeps.

use std::sync::Arc;

use proptest::prelude::*;
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, ContextOptions, Domain, Falloff, Mesh, Values};
use relievo_lod::progressive::{ActiveMesh, Arrival, BuildOptions, Cut, Edit, Extract, Handle, Region};
use relievo_lod::{AttributeOptions, Progressive, SimplifyOptions, Welded, simplify_mesh, weld};
use relievo_testing::Random;

use crate::attributes::furnished_cube;
use crate::shapes::{edges, lifted, torus};

fn build_by(context: &Context, mesh: &Mesh, faces: usize) -> Arc<Progressive> {
    let options = BuildOptions { faces, ..BuildOptions::default() };
    let attributes = AttributeOptions::default();
    Arc::new(Progressive::build_mesh(context, mesh, &options, &attributes, &mut Silent).unwrap().0)
}

pub fn build(mesh: &Mesh, faces: usize) -> Arc<Progressive> {
    build_by(&Context::serial(), mesh, faces)
}

fn level(mesh: &Arc<Progressive>, cut: Cut) -> ActiveMesh {
    let mut active = ActiveMesh::new(mesh);
    active.adapt(&Context::serial(), cut);
    active
}

fn written(mesh: &Progressive) -> Vec<u8> {
    let mut bytes = Vec::new();
    mesh.write(&Context::serial(), &mut bytes).unwrap();
    bytes
}

/// The bits of an attribute at every corner of triangles, whatever it is on.
fn at_corners(mesh: &Mesh, name: &str) -> Vec<Vec<u32>> {
    assert!(mesh.face_sizes.iter().all(|size| *size == 3));
    let Attribute { domain, width, values, indices, .. } = mesh.attribute(name).unwrap();
    let value = |corner: usize| match (domain, indices) {
        (Domain::Point, _) => mesh.corners[corner] as usize,
        (Domain::Corner, Some(indices)) => indices[corner] as usize,
        (Domain::Corner, None) => corner,
        (Domain::Face, _) => corner / 3,
    };
    let range = |corner: usize| value(corner) * *width as usize..(value(corner) + 1) * *width as usize;
    let bits = |corner: usize| match values {
        Values::F32(values) => values[range(corner)].iter().map(|value| (value + 0.0).to_bits()).collect(),
        Values::U32(values) => values[range(corner)].to_vec(),
    };
    (0..mesh.corners.len()).map(bits).collect()
}

/// A torus unrolled twice over its texture coordinates, with colours on points.
pub fn painted_torus(n: u32, m: u32) -> Mesh {
    let (points, triangles) = torus(n, m);
    let place = |vertex: u32| [vertex % n, vertex / n];
    let turn = |at: u32, from: u32, count: u32| (if at < from && from + 1 == count { count } else { at }) as f32;
    let uv = |triangle: &[u32; 3]| {
        let [x, y] = [0, 1].map(|axis| triangle.map(|vertex| place(vertex)[axis]).into_iter().max().unwrap_or(0));
        let at = |vertex: u32| {
            let [u, v] = place(vertex);
            [turn(u, x, n) / n as f32, 2.0 * turn(v, y, m) / m as f32]
        };
        triangle.map(at)
    };
    let uvs: Vec<f32> = triangles.iter().flat_map(uv).flatten().collect();
    // In the order of corners, as simplification numbers them.
    let corners: Vec<[f32; 3]> = triangles.as_flattened().iter().map(|vertex| points[*vertex as usize]).collect();
    let numbers: Vec<u32> = (0..corners.len() as u32).collect();
    let Welded { points, triangles, .. } = weld(&corners, numbers.as_chunks::<3>().0);
    let colors = points.iter().flat_map(|[x, y, z]| [x * y, 0.5 + 0.5 * (9.0 * z).sin(), *y]).collect();
    let mut mesh = Mesh::from_triangles(points, &triangles);
    let (name, values) = ("uv".into(), Values::F32(uvs));
    mesh.attributes.push(Attribute { name, domain: Domain::Corner, width: 2, values, indices: None });
    let (name, values) = ("color".into(), Values::F32(colors));
    mesh.attributes.push(Attribute { name, domain: Domain::Point, width: 3, values, indices: None });
    mesh
}

fn all_cuts(mesh: &Progressive) -> Vec<Cut> {
    let few = |share: usize| Cut::of_faces(mesh, mesh.triangle_count() / share);
    vec![Cut::BASE, few(9), Cut::of_error(0.02), few(3), few(2), Cut::of_error(0.0), Cut::FINEST]
}

#[test]
fn the_finest_mesh_has_the_attributes_of_the_input_at_every_corner() {
    for mesh in [furnished_cube(16), painted_torus(60, 32)] {
        let built = build(&mesh, 60);
        assert!(built.base_faces().len() < mesh.face_count() / 4, "{}", built.base_faces().len());
        let (made, vertices) = level(&built, Cut::FINEST).to_mesh();
        made.check().unwrap();
        assert_eq!((&made.points, &made.corners), (&mesh.points, &mesh.corners));
        assert!(vertices.into_iter().eq(0..mesh.points.len() as u32));
        assert!(!made.attributes.is_empty());
        for attribute in &made.attributes {
            let given = mesh.attribute(&attribute.name).unwrap();
            assert_eq!((attribute.domain, attribute.width), (given.domain, given.width));
            assert!(at_corners(&made, &attribute.name) == at_corners(&mesh, &attribute.name), "{}", attribute.name);
        }
    }
}

#[test]
fn attributes_count_as_bytes_of_a_mesh() {
    let (points, triangles) = torus(60, 32);
    let plain = build(&Mesh::from_triangles(points, &triangles), 300);
    let painted = build(&painted_torus(60, 32), 300);
    // At least the numbers of two texture coordinates and three colours at each vertex.
    let numbers = 4 * 5 * plain.vertex_count();
    assert!(painted.bytes() > plain.bytes() + numbers, "{} {} {numbers}", painted.bytes(), plain.bytes());
}

#[test]
fn the_base_has_the_attributes_of_a_simplification() {
    // Curved: on flat faces all collapses cost nothing, and last bits decide which are made.
    let (mesh, faces) = (painted_torus(60, 32), 300);
    let built = build(&mesh, faces);
    let (made, _) = level(&built, Cut::BASE).to_mesh();
    let options = SimplifyOptions { target_triangles: faces, ..SimplifyOptions::default() };
    let attributes = AttributeOptions::default();
    let expected = simplify_mesh(&Context::serial(), &mesh, &options, &attributes, &mut Silent).unwrap().mesh;
    assert_eq!((made.face_count(), made.points.len()), (expected.face_count(), expected.points.len()));
    for attribute in &expected.attributes {
        let name = &attribute.name;
        assert!(at_corners(&made, name) == at_corners(&expected, name), "{name}");
    }
    // Places are on a lattice.
    for (found, expected) in made.corners.iter().zip(&expected.corners).map(|(found, other)| {
        let place = |mesh: &Mesh, point: u32| glam::Vec3::from(mesh.points[point as usize]);
        (place(&made, *found), place(&expected, *other))
    }) {
        assert!(found.distance(expected) < 1e-5);
    }
}

#[test]
fn wedges_are_the_same_on_every_way_to_a_level() {
    for mesh in [furnished_cube(24), painted_torus(90, 48)] {
        let built = build(&mesh, 60);
        let cuts = all_cuts(&built);
        let expected: Vec<Extract> = cuts.iter().map(|cut| level(&built, *cut).extract()).collect();
        for threads in [1, 3] {
            let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
            let mut active = ActiveMesh::new(&build_by(&context, &mesh, 60));
            // Near ones are reached split by split, far ones at once.
            let steps = (0..cuts.len()).chain((0..cuts.len()).rev()).chain([6, 0, 3, 6, 1, 4, 0, 5]);
            for step in steps {
                active.adapt(&context, cuts[step]);
                assert!(active.extract() == expected[step], "{step}");
            }
        }
    }
}

#[test]
fn levels_with_seams_stay_closed_and_keep_islands_apart() {
    let mesh = furnished_cube(24);
    let built = build(&mesh, 60);
    for cut in all_cuts(&built) {
        let (made, _) = level(&built, cut).to_mesh();
        made.check().unwrap();
        let closed = weld(&made.points, &made.triangles());
        assert!(edges(&closed.triangles).values().all(|count| *count == 2));
        for (uv, normal) in at_corners(&made, "uv").chunks(3).zip(at_corners(&made, "normal").chunks(3)) {
            let sides: Vec<f32> = uv.iter().map(|uv| 6.0 * f32::from_bits(uv[0])).collect();
            let [low, high] = [f32::min, f32::max].map(|pick| sides.iter().copied().reduce(pick).unwrap());
            assert!(high - low <= 1.001, "{low} {high}");
            assert!(normal.iter().all(|it| *it == normal[0]), "sides are flat");
        }
    }
}

#[test]
fn a_file_has_the_attributes_and_so_has_its_beginning() {
    for mesh in [furnished_cube(40), painted_torus(200, 120)] {
        let built = build(&mesh, 60);
        let bytes = written(&built);
        assert_eq!(bytes[8], 2);
        let read =
            |faces: usize| Arc::new(Progressive::read(&Context::serial(), &mut bytes.as_slice(), faces).unwrap());
        let (whole, part) = (read(usize::MAX), read(2000));
        assert_eq!(whole.attributes(), built.attributes());
        for cut in all_cuts(&built) {
            assert!(level(&whole, cut).extract() == level(&built, cut).extract());
        }
        let cut = Cut::of_faces(&built, 2000);
        assert!(level(&part, cut).extract() == level(&built, cut).extract());
        assert_eq!(written(&whole), bytes);
        for end in (0..bytes.len()).step_by(997) {
            assert!(Progressive::read(&Context::serial(), &mut &bytes[..end], usize::MAX).is_err(), "{end}");
        }
    }
}

#[test]
fn a_mesh_without_attributes_is_what_it_was() {
    let (points, triangles) = lifted(30, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos());
    let mut mesh = Mesh::from_triangles(points.clone(), &triangles);
    let options = BuildOptions { faces: 60, ..BuildOptions::default() };
    let plain = Progressive::build(&Context::serial(), &points, &triangles, &options, &mut Silent).unwrap();
    assert!(written(&build(&mesh, 60)) == written(&plain));
    assert_eq!(written(&plain)[8], 1);
    let values = Values::U32(vec![1; points.len()]);
    mesh.attributes.push(Attribute { name: "group".into(), domain: Domain::Point, width: 1, values, indices: None });
    let attributes = AttributeOptions::default();
    let (made, left_out) =
        Progressive::build_mesh(&Context::serial(), &mesh, &options, &attributes, &mut Silent).unwrap();
    assert_eq!(left_out, ["group"]);
    assert!(written(&made) == written(&plain) && made.attributes().is_empty());
}

#[test]
fn edits_leave_attributes_as_they_are() {
    let mesh = painted_torus(60, 32);
    let built = build(&mesh, 60);
    let context = Context::serial();
    let cut = Cut::of_faces(&built, 700);
    let mut active = level(&built, cut);
    let region = Region { center: [1.4, 0.0, 0.0], radius: 0.5, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.2, 0.0, 0.1], axis: [0.0, 0.0, 1.0], angle: 0.3 };
    active.edit(&context, &Edit { handles: vec![handle], anchors: Vec::new() }).unwrap();
    let settled = Arc::new(active.settled(&context));
    let mut edited = ActiveMesh::new(&settled);
    for cut in all_cuts(&built).into_iter().rev() {
        active.adapt(&context, cut);
        edited.adapt(&context, cut);
        let expected = level(&built, cut).extract();
        assert!(active.extract().points != expected.points);
        for made in [active.extract(), edited.extract()] {
            assert!(made.wedges == expected.wedges && made.values == expected.values);
        }
    }
    let read = Progressive::read(&context, &mut written(&settled).as_slice(), usize::MAX).unwrap();
    assert_eq!(written(&read), written(&settled));
    // Built anew the finest mesh has them too.
    let options = BuildOptions { faces: 60, ..BuildOptions::default() };
    let rebuilt = Arc::new(active.rebuilt(&context, &options, &mut Silent).unwrap());
    active.adapt(&context, Cut::FINEST);
    let ((expected, _), (made, _)) = (active.to_mesh(), level(&rebuilt, Cut::FINEST).to_mesh());
    assert_eq!((&made.points, &made.corners), (&expected.points, &expected.corners));
    for name in ["uv", "color"] {
        assert!(at_corners(&made, name) == at_corners(&expected, name), "{name}");
    }
}

#[test]
fn what_a_progressive_mesh_cannot_keep_is_refused() {
    let (points, triangles) = torus(8, 6);
    let fails = |attributes: Vec<Attribute>, options: &AttributeOptions| {
        let mut mesh = Mesh::from_triangles(points.clone(), &triangles);
        mesh.attributes = attributes;
        let made = Progressive::build_mesh(&Context::serial(), &mesh, &BuildOptions::default(), options, &mut Silent);
        made.map(drop).unwrap_err().to_string()
    };
    let attribute = |name: String, domain: Domain, values: Vec<f32>| {
        let width = values.len() as u32 / if domain == Domain::Face { 96 } else { 48 };
        Attribute { name, domain, width, values: Values::F32(values), indices: None }
    };
    let options = AttributeOptions::default();
    assert!(fails(vec![attribute("a".repeat(256), Domain::Point, vec![0.0; 48])], &options).contains("256"));
    let many = (0..17).map(|index| attribute(index.to_string(), Domain::Face, vec![0.0; 4 * 96])).collect();
    assert!(fails(many, &options).contains("68 numbers"));
    let mut values = vec![0.0; 48];
    values[7] = f32::NAN;
    assert!(fails(vec![attribute("a".into(), Domain::Point, values)], &options).contains("not finite"));
    let left_out = AttributeOptions { left_out: vec!["nothing".into()], ..options };
    assert!(fails(Vec::new(), &left_out).contains("`nothing`"));
}

proptest! {
    #[test]
    fn random_triangles_with_wedges_do_no_harm(
        points in prop::collection::vec((prop::array::uniform3(-2i8..2), 0u8..3), 3..40),
        picks in prop::collection::vec((prop::array::uniform3(any::<u16>()), 0u32..2), 1..160),
        faces in 0usize..40,
    ) {
        let count = points.len() as u32;
        let triangles: Vec<[u32; 3]> = picks.iter().map(|(pick, _)| pick.map(|it| u32::from(it) % count)).collect();
        let values = Values::F32(points.iter().map(|(_, value)| f32::from(*value)).collect());
        let points: Vec<[f32; 3]> = points.iter().map(|(point, _)| point.map(f32::from)).collect();
        let mut mesh = Mesh::from_triangles(points, &triangles);
        mesh.attributes.push(Attribute { name: "uv".into(), domain: Domain::Point, width: 1, values, indices: None });
        let values = Values::U32(picks.iter().map(|(_, material)| *material).collect());
        let material = Attribute { name: "material".into(), domain: Domain::Face, width: 1, values, indices: None };
        mesh.attributes.push(material);
        let built = build(&mesh, faces);
        let read = Progressive::read(&Context::serial(), &mut written(&built).as_slice(), usize::MAX).unwrap();
        let mut active = ActiveMesh::new(&Arc::new(read));
        let cuts = all_cuts(&built);
        for cut in cuts.iter().chain(cuts.iter().rev()) {
            active.adapt(&Context::serial(), *cut);
            let made = active.extract();
            prop_assert_eq!(made.wedges.len(), made.triangles.len());
            prop_assert!(made.wedges.as_flattened().iter().all(|wedge| (*wedge as usize) < made.values.len()));
            prop_assert!(made.values.iter().all(|value| (0.0..=2.0).contains(value)));
            // A wedge is of one vertex.
            let mut vertices = vec![None; made.values.len()];
            for (wedge, vertex) in made.wedges.as_flattened().iter().zip(made.triangles.as_flattened()) {
                prop_assert!(vertices[*wedge as usize].replace(*vertex).is_none_or(|other| other == *vertex));
            }
        }
        active.adapt(&Context::serial(), Cut::FINEST);
        let (finest, _) = active.to_mesh();
        prop_assert!(at_corners(&finest, "uv") == at_corners(&mesh, "uv"));
        prop_assert!(at_corners(&finest, "material") == at_corners(&mesh, "material"));
        let welded = weld(&mesh.points, &triangles);
        prop_assert!(active.extract().points == welded.points);
    }
}

/// Where the head ends, with its sum.
const HEAD: usize = 60;

/// The bytes of the chunks of a file.
fn chunks_of(bytes: &[u8]) -> Vec<Vec<u8>> {
    let (mut rest, mut chunks) = (&bytes[HEAD..], Vec::new());
    while !rest.is_empty() {
        let word = |at: usize| u32::from_le_bytes(rest[at..at + 4].try_into().unwrap()) as usize;
        let (packed, after) = rest[12..].split_at(word(4));
        chunks.push(zstd::bulk::decompress(packed, word(0)).unwrap());
        rest = after;
    }
    chunks
}

#[test]
fn files_that_lie_with_the_right_sums_are_refused_or_harmless() {
    let bytes = written(&build(&furnished_cube(5), 40));
    let (chunks, mut random, mut refused) = (chunks_of(&bytes), Random(3), 0);
    for round in 0..3000 {
        let mut chunks = chunks.clone();
        // The chunk of attributes is short, and the last one has the most columns.
        for _ in 0..1 + round % 3 {
            let chunk = &mut chunks[round % 3];
            let place = (random.unit() * chunk.len() as f32) as usize % chunk.len();
            chunk[place] = (random.unit() * 256.0) as u8;
        }
        let mut file = bytes[..HEAD].to_vec();
        for chunk in &chunks {
            let packed = zstd::bulk::compress(chunk, 1).unwrap();
            let head = [chunk.len() as u32, packed.len() as u32, crc32fast::hash(&packed)];
            file.extend(head.into_iter().flat_map(u32::to_le_bytes).chain(packed));
        }
        let context = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 26 }).unwrap();
        let read = Progressive::read(&context, &mut file.as_slice(), usize::MAX).map(Arc::new);
        // Piece by piece as at once.
        let mut arrival = Arrival::new(&context);
        let is_taken = file.chunks(999).all(|piece| arrival.push(&context, piece).is_ok());
        assert_eq!(is_taken && arrival.is_complete(), read.is_ok());
        let Ok(mesh) = read else {
            refused += 1;
            continue;
        };
        let (mut active, mut kept) = (ActiveMesh::new(&mesh), Extract::default());
        let base = active.extract();
        let half = Cut::of_faces(&mesh, (mesh.triangle_count() + mesh.base_faces().len()) / 2);
        for cut in [half, Cut::FINEST, half, Cut::BASE] {
            active.adapt(&context, cut);
            let update = active.update(&mut kept, false);
            assert!(kept.wedges[..update.triangles].iter().flatten().all(|wedge| (*wedge as usize) < update.wedges));
            let (made, vertices) = active.to_mesh();
            assert_eq!((made.face_count(), made.points.len()), (update.triangles, vertices.len()));
        }
        assert!(active.extract() == base);
    }
    assert!(refused > 500, "{refused}");
}
