//! Progressive meshes: splits and collapses that undo each other, and what every mesh between keeps.

use std::sync::Arc;

use proptest::prelude::*;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, Extract};
use relievo_testing::file;

use crate::shapes::{Triangles, edges, lifted, torus, two_tori};

fn build((points, triangles): &Triangles, faces: usize) -> Arc<Progressive> {
    let options = BuildOptions { faces, ..BuildOptions::default() };
    Arc::new(Progressive::build(&Context::serial(), points, triangles, &options, &mut Silent).unwrap())
}

fn at(mesh: &Arc<Progressive>, cut: Cut) -> Extract {
    let mut active = ActiveMesh::new(mesh);
    active.adapt(&Context::serial(), cut);
    active.extract()
}

fn bumps(n: u32) -> Triangles {
    lifted(n, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + 0.02 * (40.0 * x * y).sin())
}

#[test]
fn the_finest_mesh_is_the_input_bit_for_bit() {
    for shape in [torus(60, 30), bumps(40), lifted(30, |_, _| 0.0), two_tori()] {
        let mesh = build(&shape, 50);
        assert!(mesh.base_faces().len() < shape.1.len() / 4);
        let finest = at(&mesh, Cut::FINEST);
        assert!(finest.points == shape.0 && finest.triangles == shape.1);
        for normal in finest.normals {
            let length = glam::Vec3::from(normal).length();
            assert!((length - 1.0).abs() < 1e-5 || length == 0.0);
        }
    }
}

#[test]
fn normals_of_the_finest_mesh_are_those_of_the_surface() {
    let shape = torus(120, 60);
    let finest = at(&build(&shape, 100), Cut::FINEST);
    for (point, normal) in finest.points.iter().zip(finest.normals) {
        let [x, y, z] = *point;
        let ring = glam::Vec3::new(x, y, 0.0).normalize();
        let exact = (glam::Vec3::new(x, y, z) - ring).normalize();
        assert!(exact.dot(normal.into()) > 0.999, "{point:?}");
    }
}

#[test]
fn what_is_split_and_taken_back_is_as_it_was_at_every_level() {
    for shape in [torus(48, 24), bumps(30), two_tori()] {
        let mesh = build(&shape, 40);
        let context = Context::serial();
        let mut active = ActiveMesh::new(&mesh);
        let mut passed = Vec::new();
        for faces in [0, 60, 100, 333, 700, 1500, usize::MAX] {
            let cut = Cut::of_faces(&mesh, faces);
            let [splits, collapses] = active.adapt(&context, cut);
            assert_eq!(collapses, 0);
            assert!(splits > 0 || faces == 0);
            assert!(active.triangle_count() <= faces.max(mesh.base_faces().len()));
            passed.push((cut, active.extract()));
        }
        for (cut, before) in passed.into_iter().rev() {
            let [splits, _] = active.adapt(&context, cut);
            let now = active.extract();
            assert_eq!(splits, 0);
            assert_eq!((now.triangles.len(), now.points.len()), (active.triangle_count(), active.vertex_count()));
            assert_eq!(now, before);
        }
    }
}

#[test]
fn a_mesh_of_so_many_triangles_has_them_but_for_one() {
    let shape = torus(60, 30);
    let mesh = build(&shape, 40);
    for faces in [60, 61, 500, 1999, 3600] {
        let made = at(&mesh, Cut::of_faces(&mesh, faces)).triangles.len();
        assert!(made <= faces && made + 1 >= faces, "{faces}: {made}");
    }
    assert_eq!(at(&mesh, Cut::of_faces(&mesh, 0)), at(&mesh, Cut::BASE));
}

#[test]
fn meshes_between_stay_closed_and_deviate_by_no_more_than_is_asked() {
    let shape = torus(96, 48);
    let mesh = build(&shape, 100);
    let distance = |[x, y, z]: &[f32; 3]| (((x * x + y * y).sqrt() - 1.0).hypot(*z) - 0.4).abs();
    let mut last = 0;
    for error in [0.03, 0.01, 0.003, 0.001, 0.0] {
        let made = at(&mesh, Cut::of_error(error));
        let edges = edges(&made.triangles);
        assert!(edges.values().all(|count| *count == 2));
        assert_eq!(made.points.len() + made.triangles.len(), edges.len(), "Euler's number of a torus is 0");
        let worst = made.points.iter().map(distance).fold(0.0, f32::max);
        assert!(worst <= 2.0 * error + 1e-5 && made.triangles.len() > last, "{error}: {worst}");
        last = made.triangles.len();
    }
}

#[test]
fn no_edge_gets_more_triangles_than_two_where_the_input_had_no_more() {
    let shape = two_tori();
    let before = edges(&shape.1).into_values().filter(|count| *count > 2).count();
    let mesh = build(&shape, 100);
    for faces in [0, 150, 400, 900, 1500] {
        let made = at(&mesh, Cut::of_faces(&mesh, faces));
        let crowded = edges(&made.triangles).into_values().filter(|count| *count > 2).count();
        assert!(crowded <= before, "{faces}: {crowded}");
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let shape = bumps(90);
    let one = build(&shape, 60);
    for threads in [2, 5] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let options = BuildOptions { faces: 60, ..BuildOptions::default() };
        let mesh = Arc::new(Progressive::build(&context, &shape.0, &shape.1, &options, &mut Silent).unwrap());
        let mut active = ActiveMesh::new(&mesh);
        for faces in [5000, 300, 16000, 9000, 60] {
            let cut = Cut::of_faces(&mesh, faces);
            active.adapt(&context, cut);
            assert_eq!(active.extract(), at(&one, cut));
        }
    }
}

#[test]
fn forty_bytes_a_triangle_are_enough() {
    for shape in [torus(200, 100), bumps(100)] {
        let mesh = build(&shape, 100);
        let bytes = mesh.bytes() as f64 / shape.1.len() as f64;
        // Points, normals and splits of the vertices, and what triangles say, are all counted.
        assert!((30.0..=40.0).contains(&bytes), "{bytes}");
        // Sums of triangles are made when levels are first asked for by their number.
        let before = mesh.bytes();
        let _ = Cut::of_faces(&mesh, 300);
        assert!(mesh.bytes() > before);
    }
}

#[test]
fn locked_points_stay_at_all_levels() {
    let shape = torus(60, 30);
    let locked: Vec<u32> = (0..shape.0.len() as u32).step_by(97).collect();
    let options = BuildOptions { faces: 100, locked: locked.clone() };
    let mesh = Arc::new(Progressive::build(&Context::serial(), &shape.0, &shape.1, &options, &mut Silent).unwrap());
    for faces in [0, 500, 2000] {
        let made = at(&mesh, Cut::of_faces(&mesh, faces));
        for vertex in &locked {
            assert!(made.points.contains(&shape.0[*vertex as usize]), "{vertex} at {faces}");
        }
    }
}

#[test]
fn extreme_sizes_are_no_matter() {
    for scale in [1e-30f32, 1e30] {
        let (points, triangles) = torus(40, 20);
        let points = points.into_iter().map(|point| point.map(|value| value * scale)).collect();
        let shape = (points, triangles);
        let mesh = build(&shape, 100);
        let (coarse, finest) = (at(&mesh, Cut::of_error(0.02 * scale)), at(&mesh, Cut::FINEST));
        assert!(finest.points == shape.0 && finest.triangles == shape.1);
        assert!(coarse.triangles.len() < 800 && coarse.points.iter().flatten().all(|value| value.is_finite()));
    }
}

#[test]
fn bad_input_is_refused() {
    let good = torus(8, 6);
    let fails = |points: &[[f32; 3]], triangles: &[[u32; 3]], options: &BuildOptions| {
        Progressive::build(&Context::serial(), points, triangles, options, &mut Silent).map(drop).unwrap_err()
    };
    let options = BuildOptions::default();
    assert!(fails(&good.0, &[], &options).to_string().contains("without triangles"));
    assert!(fails(&good.0, &[[0, 1, 48]], &options).to_string().contains("triangle 0"));
    let locked = BuildOptions { locked: vec![48], ..options };
    assert!(fails(&good.0, &good.1, &locked).to_string().contains("locked"));
    let mut stop = |_: f32, _: &str| false;
    let options = BuildOptions { faces: 10, ..BuildOptions::default() };
    let stopped = Progressive::build(&Context::serial(), &good.0, &good.1, &options, &mut stop).map(drop);
    assert_eq!(stopped.unwrap_err().kind, ErrorKind::Cancelled);
}

#[test]
fn a_mesh_that_cannot_become_coarser_is_its_own_base() {
    let triangle = (vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let mesh = build(&triangle, 0);
    assert_eq!(at(&mesh, Cut::BASE).triangles, triangle.1);
    assert_eq!(at(&mesh, Cut::BASE), at(&mesh, Cut::FINEST));
    let read = Arc::new(Progressive::read(&Context::serial(), &mut written(&mesh).as_slice(), usize::MAX).unwrap());
    assert_eq!(at(&read, Cut::FINEST), at(&mesh, Cut::FINEST));
}

#[test]
fn models_come_back_as_they_were() {
    for name in ["ugly/soup.stl", "ugly/multibody.stl", "ugly/cow.obj", "ugly/joined_tetrahedra.obj", "ugly/beetle.obj"]
    {
        let Some(path) = file(name) else { continue };
        let context = Context::serial();
        let model = relievo_meshio::read(&context, &path).unwrap();
        let triangles = model.triangles();
        let mesh = build(&(model.points.clone(), triangles.clone()), 100);
        let finest = at(&mesh, Cut::FINEST);
        assert!(finest.points == model.points && finest.triangles == triangles, "{name}");
        let mut active = ActiveMesh::new(&mesh);
        active.adapt(&context, Cut::FINEST);
        active.adapt(&context, Cut::BASE);
        assert_eq!(active.extract(), at(&mesh, Cut::BASE), "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn whatever_way_a_mesh_was_reached_it_is_the_same(faces in prop::collection::vec(0usize..2600, 1..6), threads in 1usize..4) {
        let shape = bumps(36);
        let mesh = build(&shape, 30);
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut active = ActiveMesh::new(&mesh);
        for faces in faces {
            let cut = Cut::of_faces(&mesh, faces);
            active.adapt(&context, cut);
            prop_assert_eq!(active.extract(), at(&mesh, cut));
        }
    }
}

/// The bytes of a file of a mesh.
fn written(mesh: &Progressive) -> Vec<u8> {
    let mut bytes = Vec::new();
    mesh.write(&Context::serial(), &mut bytes).unwrap();
    bytes
}

#[test]
fn what_was_written_is_read() {
    for shape in [torus(150, 130), bumps(30), two_tori()] {
        let mesh = build(&shape, 60);
        let bytes = written(&mesh);
        assert!(bytes.len() < 30 * shape.1.len(), "{} bytes for {} triangles", bytes.len(), shape.1.len());
        let read = Arc::new(Progressive::read(&Context::serial(), &mut bytes.as_slice(), usize::MAX).unwrap());
        assert_eq!(read.bytes(), mesh.bytes());
        for faces in [0, 100, 777, usize::MAX] {
            assert_eq!(at(&read, Cut::of_faces(&read, faces)), at(&mesh, Cut::of_faces(&mesh, faces)));
        }
        assert_eq!(written(&read), bytes);
    }
}

#[test]
fn the_beginning_of_a_file_is_a_coarser_mesh() {
    let shape = torus(200, 130);
    let mesh = build(&shape, 60);
    let bytes = written(&mesh);
    let mut source = bytes.as_slice();
    let coarse = Arc::new(Progressive::read(&Context::serial(), &mut source, 10_000).unwrap());
    assert!(source.len() > bytes.len() / 4, "{} of {} bytes are left", source.len(), bytes.len());
    for faces in [0, 1000, 10_000] {
        assert_eq!(at(&coarse, Cut::of_faces(&coarse, faces)), at(&mesh, Cut::of_faces(&mesh, faces)));
    }
}

#[test]
fn damaged_files_are_refused_or_harmless() {
    let shape = bumps(16);
    let bytes = written(&build(&shape, 60));
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: 1 << 24 }).unwrap();
    let read = |bytes: &[u8]| Progressive::read(&context, &mut &*bytes, usize::MAX).map(drop);
    read(&bytes).unwrap();
    for length in 0..bytes.len() {
        assert!(read(&bytes[..length]).is_err(), "{length} bytes");
    }
    for place in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x41;
        assert!(read(&damaged).is_err(), "byte {place}");
    }
    // The origin of the lattice, with the sum of the head made right again.
    let mut endless = bytes.clone();
    endless[32..36].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let sum = crc32fast::hash(&endless[..56]);
    endless[56..60].copy_from_slice(&sum.to_le_bytes());
    assert!(read(&endless).unwrap_err().to_string().contains("not finite"));
    let mut newer = bytes.clone();
    newer[8] = 3;
    assert_eq!(read(&newer).unwrap_err().kind, ErrorKind::Unsupported);
    assert!(read(b"OFF\n3 1 0\n").unwrap_err().to_string().contains("no progressive mesh"));
    let small = Context::new(&ContextOptions { threads: 1, memory_limit: 1000 }).unwrap();
    let error = Progressive::read(&small, &mut bytes.as_slice(), usize::MAX).map(drop).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Memory);
}

#[test]
fn a_base_vertex_outside_of_the_mesh_is_refused_though_sums_are_right() {
    let bytes = written(&build(&bumps(16), 60));
    let (head, rest) = bytes.split_at(60);
    let base_vertices = u32::from_le_bytes(head[20..24].try_into().unwrap()) as usize;
    let word = |at: usize| u32::from_le_bytes(rest[at..at + 4].try_into().unwrap()) as usize;
    let (packed, later) = rest[12..].split_at(word(4));
    let base = zstd::bulk::decompress(packed, word(0)).unwrap();
    // Columns of four planes of bytes: leaves, tags, children. The next leaf ends the range that the child must be in.
    let highest = |column: usize, vertex: usize| (4 * column + 3) * base_vertices + vertex;
    for vertex in 0..base_vertices - 1 {
        let mut damaged = base.clone();
        damaged[highest(0, vertex + 1)] |= 0x40;
        damaged[highest(2, vertex)] |= 0x20;
        let packed = zstd::bulk::compress(&damaged, 1).unwrap();
        let told = [damaged.len() as u32, packed.len() as u32, crc32fast::hash(&packed)].map(u32::to_le_bytes);
        let file = [head, told.as_flattened(), &packed, later].concat();
        let error = Progressive::read(&Context::serial(), &mut file.as_slice(), usize::MAX).map(drop).unwrap_err();
        assert!(error.to_string().contains("out of order") || error.to_string().contains("out of place"), "{error}");
    }
}
