//! Channels go into Ptex files and come back.

use glam::Vec4;
use half::f16;
use relievo_bake::ptex::{Imported, PtexImport, PtexKind, from_ptex, to_ptex};
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_ptex::{Borders, DataType, EdgeFilter, Face, Format, MeshType, MetaValue, Neighbor, Reader, Writer};
use relievo_surface::Surface;
use relievo_testing::Random;
use relievo_tiles::{ColorTexel, Displacement, Paint, Rgba8, Rgba16, Vector, VectorDisplacement};

use crate::support::{cages, options, same_tiles, scribble, surface};

const OPTIONS: PtexImport = PtexImport { kind: None, budget: 1 << 30, eight_bits: false };

fn reader(writer: &Writer) -> Reader<Vec<u8>> {
    Reader::new(writer.bytes().unwrap(), u64::MAX).unwrap()
}

fn texels(reader: &Reader<Vec<u8>>, tile: u32) -> Vec<f32> {
    reader.format().data_type.decode(&reader.texels(tile).unwrap())
}

#[test]
fn displacement_keeps_its_values_to_the_rounding_of_half_floats() {
    let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
    for (index, mesh) in cages().iter().enumerate() {
        for mixed in [false, true] {
            let surface = surface(mesh);
            let topology = surface.topology().clone();
            let mut made = Displacement::new(topology.clone(), &options(mesh, mixed)).unwrap();
            let mut random = Random(index as u64);
            scribble(&context, &mut made, &mut random, |random| f16::from_f32(0.2 * random.unit() - 0.05));
            let file = reader(&to_ptex(&context, mesh, made.field()).unwrap());
            assert_eq!(file.meta()["RelievoKind"], MetaValue::Text("displacement".into()));
            let (back, report) = from_ptex(&context, &surface, &file, &OPTIONS).unwrap();
            let Imported::Displacement(back) = back else { panic!("{back:?}") };
            same_tiles(made.field(), back.field());
            assert!(report.deviation < 2.0 / 2048.0, "{mixed}: {}", report.deviation);
            let again = reader(&to_ptex(&context, mesh, back.field()).unwrap());
            for tile in 0..file.face_count() {
                for (a, b) in texels(&file, tile).into_iter().zip(texels(&again, tile)) {
                    // A unit in the last place of the largest coefficients.
                    assert!((a - b).abs() <= 0.15 / 1024.0, "{mixed} tile {tile}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn vectors_keep_their_values_and_say_how_to_filter_them() {
    let context = Context::serial();
    for (index, mesh) in cages().iter().enumerate() {
        let surface = surface(mesh);
        let mut made = VectorDisplacement::on(&surface, &options(mesh, true)).unwrap();
        let number = |random: &mut Random| f16::from_f32(0.2 * random.unit() - 0.1);
        let mut random = Random(index as u64);
        scribble(&context, &mut made, &mut random, |random| Vector([0; 3].map(|_: u8| number(random))));
        let file = reader(&to_ptex(&context, mesh, made.field()).unwrap());
        assert_eq!((file.format().channels, file.borders().edge_filter), (3, EdgeFilter::TangentVector));
        let (back, report) = from_ptex(&context, &surface, &file, &OPTIONS).unwrap();
        let Imported::Vector(back) = back else { panic!("{back:?}") };
        same_tiles(made.field(), back.field());
        assert!(report.deviation < 2.0 / 2048.0, "{}", report.deviation);
    }
}

#[test]
fn colours_come_back_to_the_bit() {
    let context = Context::serial();
    for (index, mesh) in cages().iter().enumerate() {
        let surface = surface(mesh);
        let topology = surface.topology().clone();
        let mut random = Random(index as u64);
        let blank = Vec4::new(0.5, 0.25, 1.0, 1.0);
        let mut bytes = Paint::<Rgba8>::of_color(topology.clone(), blank, &options(mesh, true)).unwrap();
        scribble(&context, &mut bytes, &mut random, |random| Rgba8([0; 4].map(|_: u8| random.below(256) as u8)));
        let file = reader(&to_ptex(&context, mesh, bytes.field()).unwrap());
        assert_eq!((file.format().data_type, file.format().alpha), (DataType::U8, Some(3)));
        let (back, _) = from_ptex(&context, &surface, &file, &OPTIONS).unwrap();
        let Imported::Rgba8(back) = back else { panic!("{back:?}") };
        same_tiles(bytes.field(), back.field());
        assert_eq!(back.field().blank(), bytes.field().blank());
        (0..file.face_count()).for_each(|tile| assert_eq!(bytes.field().block(tile), back.field().block(tile)));

        let mut halves = Paint::<Rgba16>::of_color(topology.clone(), blank, &options(mesh, true)).unwrap();
        let number = |random: &mut Random| f16::from_f32(4.0 * random.unit() - 1.0);
        scribble(&context, &mut halves, &mut random, |random| Rgba16([0; 4].map(|_: u8| number(random))));
        let file = reader(&to_ptex(&context, mesh, halves.field()).unwrap());
        let (back, _) = from_ptex(&context, &surface, &file, &OPTIONS).unwrap();
        let Imported::Rgba16(back) = back else { panic!("{back:?}") };
        same_tiles(halves.field(), back.field());
        (0..file.face_count()).for_each(|tile| assert_eq!(halves.field().block(tile), back.field().block(tile)));
    }
}

/// Every neighbour's neighbour across the shared edge is the face again, or of a whole face the first of two.
#[test]
fn faces_know_their_neighbours() {
    let context = Context::serial();
    let mesh = &cages()[0];
    let surface = surface(mesh);
    let topology = surface.topology().clone();
    let made = Displacement::new(topology, &options(mesh, false)).unwrap();
    let file = reader(&to_ptex(&context, mesh, made.field()).unwrap());
    let mut halves = 0;
    for tile in 0..file.face_count() {
        let face = file.face(tile).unwrap();
        for (edge, neighbor) in face.neighbors.iter().enumerate() {
            let Neighbor { face: other, edge: there } = neighbor.expect("a torus has no border");
            let back = file.face(other).unwrap().neighbors[usize::from(there)].unwrap();
            let second = file.face(back.face).unwrap().subface && face.subface && back.face != tile;
            halves += usize::from(second);
            assert!(second || (back.face, usize::from(back.edge)) == (tile, edge), "{tile} {edge}");
        }
    }
    assert!(halves > 0);
}

fn format(data_type: DataType, channels: u16) -> Format {
    Format { mesh: MeshType::Quad, data_type, channels, alpha: None }
}

/// A file for two quads side by side.
fn pair(format: Format, sizes: [(u8, u8); 2], value: impl Fn(usize, f32, f32, u16) -> f32) -> Reader<Vec<u8>> {
    let mut writer = Writer::new(format, Borders::default(), 2).unwrap();
    for (index, (u, v)) in sizes.into_iter().enumerate() {
        let face = Face::new(u, v);
        let (width, height) = (1 << u, 1 << v);
        let mut values = Vec::new();
        for j in 0..height {
            for i in 0..width {
                let (u, v) = ((i as f32 + 0.5) / width as f32, (j as f32 + 0.5) / height as f32);
                values.extend((0..format.channels).map(|channel| value(index, u, v, channel)));
            }
        }
        writer.set(index as u32, &face, &format.data_type.encode(&values)).unwrap();
    }
    reader(&writer)
}

fn two_quads() -> Mesh {
    let points = (0..6).map(|i| [(i % 3) as f32, (i / 3) as f32, 0.0]).collect();
    Mesh::new(points, vec![4; 2], vec![0, 1, 4, 3, 1, 2, 5, 4])
}

#[test]
fn faces_of_any_shape_and_type_are_taken_and_counted() {
    let context = Context::serial();
    let surface = surface(&two_quads());
    // A line along u, which resampling keeps away from the ends.
    for data_type in [DataType::U16, DataType::F16, DataType::F32] {
        let file = pair(format(data_type, 2), [(5, 3), (9, 9)], |_, u, _, channel| u + f32::from(channel));
        let kind = PtexImport { kind: Some(PtexKind::Displacement), ..OPTIONS };
        let (back, report) = from_ptex(&context, &surface, &file, &kind).unwrap();
        assert_eq!((report.squared, report.reduced, report.enlarged, report.ignored), (1, 1, 0, 1));
        let Imported::Displacement(back) = back else { panic!("{back:?}") };
        assert_eq!([0, 1].map(|tile| back.field().size(tile)), [32, 256]);
        for (u, v) in [(0.3, 0.5), (0.5, 0.2), (0.71, 0.5)] {
            for tile in [0, 1] {
                let d = back.field().point(context.level(), relievo_surface::Place::new(tile, u, v)).d;
                assert!((d - u).abs() < 2e-3, "{tile} {u} {d}");
            }
        }
    }
    let file = pair(format(DataType::U8, 1), [(2, 2), (0, 0)], |_, u, _, _| u);
    let (back, report) = from_ptex(&context, &surface, &file, &OPTIONS).unwrap();
    assert_eq!((report.constant, report.enlarged), (1, 1));
    let Imported::Rgba8(back) = back else { panic!("{back:?}") };
    assert_eq!(back.field().blank(), Rgba8([128, 128, 128, 255]));
    assert_eq!(back.allocated_count(), 1 + usize::from(back.field().is_allocated(1)));
}

#[test]
fn corner_texels_that_become_a_mean_are_counted() {
    let context = Context::serial();
    let surface = surface(&two_quads());
    let color = |size: [(u8, u8); 2]| {
        let file =
            pair(format(DataType::F32, 3), size, |face, u, v, _| if face == 0 { 0.25 * u } else { 1.0 - 0.25 * v });
        let (back, report) = from_ptex(&context, &surface, &file, &OPTIONS).unwrap();
        let Imported::Rgba16(back) = back else { panic!("{back:?}") };
        (back, report)
    };
    // Faces of one size are continuous there without it.
    assert_eq!(color([(3, 3), (3, 3)]).1.averaged, 0);
    // Both ends of the edge between the faces: two texels each.
    let (back, report) = color([(3, 3), (4, 4)]);
    assert_eq!(report.averaged, 4);
    let corner = |tile: u32, at: usize| back.field().block(tile).unwrap()[at].color().x;
    let before = [0.25 * 7.5 / 8.0, 1.0 - 0.25 * 0.5 / 16.0];
    let mean = 0.5 * (before[0] + before[1]);
    assert!((corner(0, 10 + 8) - mean).abs() < 1e-3 && (corner(1, 18 + 1) - mean).abs() < 1e-3);
    assert!(report.largest_average > mean - before[0] - 2e-3, "{report}");
    assert!(report.to_string().contains("4 texels in corners of faces"), "{report}");
}

#[test]
fn files_that_do_not_fit_are_errors_that_explain() {
    let context = Context::serial();
    let surface = surface(&two_quads());
    let refuse = |surface: &Surface, file: &Reader<Vec<u8>>, options: &PtexImport, words: &[&str]| {
        let error = from_ptex(&context, surface, file, options).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let file = pair(format(DataType::F32, 1), [(3, 3), (3, 3)], |_, u, _, _| u);
    let three = crate::support::surface(&cages()[1]);
    refuse(&three, &file, &OPTIONS, &["2 faces", "corners of other polygons", "same order"]);
    refuse(&surface, &file, &PtexImport { budget: 100, ..OPTIONS }, &["allow at least 400 bytes"]);
    let bad = pair(format(DataType::F32, 1), [(3, 3), (3, 3)], |_, u, _, _| if u > 0.9 { f32::NAN } else { u });
    refuse(&surface, &bad, &OPTIONS, &["face 0", "not a finite number"]);
    let far = pair(format(DataType::F32, 1), [(3, 3), (3, 3)], |index, u, _, _| u + 1e6 * index as f32);
    refuse(&surface, &far, &OPTIONS, &["face 1", "larger than tiles can hold"]);
    let mut writer = Writer::new(format(DataType::F32, 1), Borders::default(), 2).unwrap();
    let mut face = Face::new(3, 3);
    face.neighbors[0] = Some(Neighbor { face: 1, edge: 2 });
    writer.set_constant(0, &face, &[0; 4]).unwrap();
    writer.set_constant(1, &Face { subface: true, ..Face::new(3, 3) }, &[0; 4]).unwrap();
    refuse(&surface, &reader(&writer), &OPTIONS, &["face 1", "corner of a polygon"]);
    writer.set_constant(1, &Face::new(3, 3), &[0; 4]).unwrap();
    refuse(&surface, &reader(&writer), &OPTIONS, &["face 0, edge 0", "1 edges have another neighbour"]);
    let triangles = Format { mesh: MeshType::Triangle, ..format(DataType::F32, 1) };
    let mut writer = Writer::new(triangles, Borders::default(), 2).unwrap();
    (0..2).for_each(|face| writer.set_constant(face, &Face::new(3, 3), &[0; 4]).unwrap());
    refuse(&surface, &reader(&writer), &OPTIONS, &["triangles"]);
}
