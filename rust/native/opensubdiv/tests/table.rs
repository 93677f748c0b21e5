//! Tables of a cage with creases, boundaries, a hole and faces of three to five corners, held against OpenSubdiv's own
//! evaluators.

use relievo_core::{Crease, Mesh};
use relievo_opensubdiv::reference::{Bfr, evaluate, far_grid};
use relievo_opensubdiv::{BoundaryRule, Options, PatchKind, Table};

const OPTIONS: Options = Options {
    boundary: BoundaryRule::EdgesAndCorners,
    isolation: 6,
    single_crease: false,
    patch_limit: 1e6,
    memory_limit: u64::MAX,
};

/// Faces along each edge of the cage.
const SIZE: u32 = 6;

/// The face that is a hole.
const HOLE: u32 = 18;

/// The tile of that face, after those of 16 quads, two triangles, a triangle and a pentagon.
const HOLE_TILE: u32 = 28;

/// A sheet of quads over the square of 0 to [`SIZE`], of which one is two triangles and two are a pentagon and a
/// triangle.
fn sheet() -> Mesh {
    let place = |x: u32, y: u32| y * (SIZE + 1) + x;
    let height = |x: f32, y: f32| (1.3 * x).sin() + (0.7 * y).cos();
    let mut points = Vec::new();
    for y in 0..=SIZE {
        points.extend((0..=SIZE).map(|x| [x as f32, y as f32, height(x as f32, y as f32)]));
    }
    let middle = points.len() as u32;
    points.push([3.5, 1.25, height(3.5, 1.25)]);
    let (mut sizes, mut corners) = (Vec::new(), Vec::new());
    for y in 0..SIZE {
        for x in 0..SIZE {
            let [a, b, c, d] = [place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1)];
            let faces: &[&[u32]] = match (x, y) {
                (1, 1) => &[&[a, b, c], &[a, c, d]],
                (3, 1) => &[&[a, b, middle], &[a, middle, b, c, d]],
                _ => &[&[a, b, c, d]],
            };
            for face in faces {
                sizes.push(face.len() as u32);
                corners.extend_from_slice(face);
            }
        }
    }
    let mut mesh = Mesh::new(points, sizes, corners);
    mesh.creases = (1..5).map(|x| Crease { points: [place(x, 4), place(x + 1, 4)], sharpness: 1.5 }).collect();
    mesh.sharp_points = vec![(place(2, 2), 2.5)];
    mesh.holes = vec![HOLE];
    mesh.check().unwrap();
    mesh
}

/// Returns the cage's points and those of the stencils.
fn points(table: &Table, mesh: &Mesh) -> Vec<[f64; 3]> {
    let mut all: Vec<[f64; 3]> = mesh.points.iter().map(|point| point.map(f64::from)).collect();
    let (sources, weights) = table.stencil_weights();
    let mut terms = sources.iter().zip(weights);
    for size in table.stencil_sizes() {
        let mut sum = [0.0; 3];
        for (source, weight) in terms.by_ref().take(*size as usize) {
            for axis in 0..3 {
                sum[axis] += weight * f64::from(mesh.points[*source as usize][axis]);
            }
        }
        all.push(sum);
    }
    assert_eq!(terms.next(), None, "every weight belongs to a stencil");
    all
}

/// Returns the four uniform cubic B-splines at `t` and their derivatives.
fn splines(t: f64) -> [[f64; 4]; 2] {
    let s = 1.0 - t;
    let values = [s * s * s, 3.0 * t * t * t - 6.0 * t * t + 4.0, 3.0 * s * s * s - 6.0 * s * s + 4.0, t * t * t];
    let slopes = [-s * s, 3.0 * t * t - 4.0 * t, -3.0 * s * s + 4.0 * s, t * t];
    [values.map(|value| value / 6.0), slopes.map(|slope| slope / 2.0)]
}

#[test]
fn patches_cover_every_tile_once_and_holes_not_at_all() {
    let mesh = sheet();
    for single_crease in [false, true] {
        let table = Table::new(&mesh, &Options { single_crease, ..OPTIONS }).unwrap();
        let mut areas = vec![0.0; table.tile_count()];
        for patch in table.patches() {
            areas[patch.tile as usize] += 0.25_f64.powi(i32::from(patch.depth));
            let indices = &table.indices()[patch.first as usize..][..patch.point_count()];
            assert!(indices.iter().all(|index| (*index as usize) < table.point_count()));
        }
        let mut tile = 0;
        for (face, size) in mesh.face_sizes.iter().enumerate() {
            let expected = if face == HOLE as usize { 0.0 } else { 1.0 };
            for _ in 0..if *size == 4 { 1 } else { *size } {
                assert_eq!(areas[tile], expected, "face {face}, tile {tile}");
                tile += 1;
            }
        }
        assert_eq!(tile, table.tile_count());
        let creased = table.patches().iter().any(|patch| matches!(patch.kind, PatchKind::SingleCrease { .. }));
        assert_eq!(creased, single_crease);
    }
}

#[test]
fn regular_patches_evaluate_as_far_does() {
    let mesh = sheet();
    let table = Table::new(&mesh, &OPTIONS).unwrap();
    let points = points(&table, &mesh);
    let inner = table.patches().iter().filter(|patch| patch.kind == PatchKind::Regular { boundary: 0 });
    let (mut places, mut expected) = (Vec::new(), Vec::new());
    for patch in inner {
        let size = 0.5_f64.powi(i32::from(patch.depth));
        for (s, t) in [(0.5, 0.5), (0.125, 0.75), (0.875, 0.25)] {
            places.push((patch.tile, (f64::from(patch.u) + s) * size, (f64::from(patch.v) + t) * size));
            let ([u, du], [v, dv]) = (splines(s), splines(t));
            let mut sums = [[0.0; 3]; 3];
            for k in 0..16 {
                let point = points[table.indices()[patch.first as usize + k] as usize];
                let weights = [u[k % 4] * v[k / 4], du[k % 4] * v[k / 4] / size, u[k % 4] * dv[k / 4] / size];
                for (sum, weight) in sums.iter_mut().zip(weights) {
                    for axis in 0..3 {
                        sum[axis] += weight * point[axis];
                    }
                }
            }
            expected.push(sums);
        }
    }
    assert!(places.len() > 300, "only {} places", places.len());
    let found = evaluate(&table, &points, &places).unwrap();
    for ((found, expected), place) in found.iter().zip(&expected).zip(&places) {
        for (found, expected) in found.iter().zip(expected) {
            let distance = (0..3).map(|axis| (found[axis] - expected[axis]).abs()).fold(0.0, f64::max);
            assert!(distance < 1e-11, "{place:?}: {distance:e}");
        }
    }
}

#[test]
fn far_in_float_and_bfr_agree_with_far_in_double() {
    let mesh = sheet();
    let table = Table::new(&mesh, &OPTIONS).unwrap();
    let points = points(&table, &mesh);
    let rounded: Vec<[f32; 3]> = points.iter().map(|point| point.map(|value| value as f32)).collect();
    const LATTICE: usize = 4;
    let mut places = Vec::new();
    for tile in 0..table.tile_count() as u32 {
        for sample in 0..LATTICE * LATTICE {
            let at = |index: usize| f64::from(index as f32 / (LATTICE - 1) as f32);
            places.push((tile, at(sample % LATTICE), at(sample / LATTICE)));
        }
    }
    let expected = evaluate(&table, &points, &places).unwrap();
    let mut far = vec![0.0; 9 * places.len()];
    let surface_samples = (places.len() - LATTICE * LATTICE) as u64;
    assert_eq!(far_grid(&table, &rounded, LATTICE, &mut far).unwrap(), surface_samples);
    let mut bfr = vec![0.0; 9 * places.len()];
    assert_eq!(Bfr::new(&table, 6).unwrap().grid(&mesh.points, LATTICE, &mut bfr).unwrap(), surface_samples);
    let distance = |found: &[f32], expected: &[f64; 3]| {
        (0..3).map(|axis| (f64::from(found[axis]) - expected[axis]).abs()).fold(0.0, f64::max)
    };
    // Bfr passes over holes.
    let of_surface =
        places.iter().zip(&expected).zip(far.chunks_exact(9)).filter(|((place, _), _)| place.0 != HOLE_TILE);
    for (((place, expected), far), bfr) in of_surface.zip(bfr.chunks_exact(9)) {
        assert!(distance(far, &expected[0]) < 1e-5, "Far at {place:?}: {far:?}, {expected:?}");
        assert!(distance(bfr, &expected[0]) < 1e-3, "Bfr at {place:?}: {bfr:?}, {expected:?}");
    }
}

/// A torus of `rings` times `rings` quads, each of which is split into two triangles if `split`.
fn torus(rings: u32, split: bool) -> Mesh {
    let angle = |at: u32| at as f32 / rings as f32 * std::f32::consts::TAU;
    let points = (0..rings * rings).map(|at| {
        let (u, v) = (angle(at / rings), angle(at % rings));
        let radius = 2.0 + v.cos();
        [radius * u.cos(), radius * u.sin(), v.sin()]
    });
    let place = |u: u32, v: u32| u % rings * rings + v % rings;
    let (mut sizes, mut corners) = (Vec::new(), Vec::new());
    for at in 0..rings * rings {
        let (u, v) = (at / rings, at % rings);
        let [a, b, c, d] = [place(u, v), place(u + 1, v), place(u + 1, v + 1), place(u, v + 1)];
        if split {
            sizes.extend([3, 3]);
            corners.extend([a, b, c, a, c, d]);
        } else {
            sizes.push(4);
            corners.extend([a, b, c, d]);
        }
    }
    Mesh::new(points.collect(), sizes, corners)
}

/// How near estimates of memory are to what a process takes is a test of the surfaces that are made of tables.
#[test]
fn tables_hold_no_more_patches_than_estimated_and_take_memory_by_their_weights() {
    let mut creased = torus(24, false);
    creased.creases = (0..24 * 3).map(|at| Crease { points: [at, at + 24], sharpness: 3.5 }).collect();
    // Points of three and of five faces.
    let mut knobbed = torus(16, false);
    for face in (0..16 * 16).step_by(7) {
        let middle = knobbed.points.len() as u32;
        let corner: [u32; 4] = std::array::from_fn(|at| knobbed.corners[4 * face + at]);
        knobbed.points.push(knobbed.points[corner[0] as usize]);
        knobbed.corners.splice(4 * face..4 * face + 4, [corner[0], corner[1], middle, corner[3]]);
        knobbed.face_sizes.push(4);
        knobbed.corners.extend([corner[1], corner[2], corner[3], middle]);
    }
    for (name, mesh) in [("triangles", torus(24, true)), ("creased", creased), ("knobbed", knobbed)] {
        let mut last = 0.0;
        for isolation in [3, 6] {
            let options = Options { isolation, single_crease: true, ..OPTIONS };
            let expected = *Table::expected(&mesh, &options).unwrap().last().unwrap();
            let table = Table::new(&mesh, &options).unwrap();
            assert!(expected.patches >= table.patches().len() as f64, "{name}, {isolation}");
            let held = 12.0 * table.stencil_weights().0.len() as f64;
            assert!(expected.bytes > 3.0 * held && expected.bytes >= last, "{name}, {isolation}: {}", expected.bytes);
            last = expected.bytes;
        }
    }
}

/// The most bytes that this process has used, where the system has them.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024 * line.trim().strip_suffix(" kB")?.parse::<u64>().ok()?)
}

/// Every edge is a crease, so that all faces are refined at every level: five levels take half a gigabyte.
#[test]
fn estimates_are_bounded_by_the_limits_too() {
    let mut cage = torus(96, false);
    let edge = |a: &u32, b: &u32| Crease { points: [*a.min(b), *a.max(b)], sharpness: 6.0 };
    cage.creases = (cage.corners.chunks_exact(4))
        .flat_map(|face| (0..4).map(|side| edge(&face[side], &face[(side + 1) % 4])).collect::<Vec<_>>())
        .collect();
    cage.creases.sort_by_key(|crease| crease.points);
    cage.creases.dedup_by_key(|crease| crease.points);
    let options = Options { isolation: 8, memory_limit: 16 << 20, single_crease: true, ..OPTIONS };
    let before = peak();
    let expected = Table::expected(&cage, &options).unwrap();
    assert!(expected.windows(2).all(|pair| pair[1].bytes >= pair[0].bytes && pair[1].patches >= pair[0].patches));
    assert!(expected[3].bytes > 16e6);
    let error = Table::new(&cage, &options).err().unwrap();
    assert!(error.to_string().contains("memory limit"), "{error}");
    if let (Some(before), Some(after)) = (before, peak()) {
        assert!(after - before < 250 << 20, "{} MB", (after - before) >> 20);
    }
    // Counted level by level, where the limit is near but not reached, they are the same.
    let mesh = torus(24, true);
    let counted = |memory_limit| Table::expected(&mesh, &Options { isolation: 4, memory_limit, ..OPTIONS }).unwrap();
    assert_eq!(counted(400 << 20), counted(1 << 40));
}

#[test]
fn what_cannot_be_refined_or_evaluated_is_an_error() {
    let mesh = sheet();
    for isolation in [0, 11] {
        assert!(Table::new(&mesh, &Options { isolation, ..OPTIONS }).is_err());
    }
    let error = Table::new(&mesh, &Options { patch_limit: 10.0, ..OPTIONS }).err().unwrap();
    assert!(error.to_string().contains("more than the limit of 10"), "{error}");
    let error = Table::new(&mesh, &Options { memory_limit: 1000, ..OPTIONS }).err().unwrap();
    assert!(error.to_string().contains("memory limit"), "{error}");

    let table = Table::new(&mesh, &OPTIONS).unwrap();
    let points = points(&table, &mesh);
    for place in [(table.tile_count() as u32, 0.5, 0.5), (0, 1.5, 0.5), (0, 0.5, -0.1), (0, f64::NAN, 0.5)] {
        assert!(evaluate(&table, &points, &[place]).is_err(), "{place:?}");
    }
    assert!(evaluate(&table, &points[1..], &[(0, 0.5, 0.5)]).is_err());
    assert!(far_grid(&table, &[], 4, &mut [0.0; 144]).is_err());
    let mut bfr = Bfr::new(&table, 3).unwrap();
    for (size, floats) in [(4, 143), (1, 144), (5000, 144)] {
        assert!(bfr.grid(&mesh.points, size, &mut vec![0.0; floats]).is_err());
    }
}

/// A crease on a regular sheet has stencils and no Gregory patch.
#[test]
fn stencils_of_regular_creases_have_a_source_for_each_weight() {
    let place = |x: u32, y: u32| y * (SIZE + 1) + x;
    let points =
        (0..=SIZE).flat_map(|y| (0..=SIZE).map(move |x| [x as f32, y as f32, 0.25 * (x * y) as f32])).collect();
    let quad = |x, y| [place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1)];
    let corners = (0..SIZE).flat_map(|y| (0..SIZE).flat_map(move |x| quad(x, y))).collect();
    let mut mesh = Mesh::new(points, vec![4; (SIZE * SIZE) as usize], corners);
    mesh.creases = (0..SIZE).map(|x| Crease { points: [place(x, 3), place(x + 1, 3)], sharpness: 2.5 }).collect();
    for single_crease in [false, true] {
        let table = Table::new(&mesh, &Options { single_crease, ..OPTIONS }).unwrap();
        let (sources, weights) = table.stencil_weights();
        assert!(!weights.is_empty() && sources.len() == weights.len(), "{} and {}", sources.len(), weights.len());
        let mut first = 0;
        for size in table.stencil_sizes() {
            let sum: f64 = weights[first..first + *size as usize].iter().sum();
            first += *size as usize;
            assert!((sum - 1.0).abs() < 1e-12, "a stencil's weights sum up to {sum}");
        }
        assert_eq!(first, weights.len());
    }
}
