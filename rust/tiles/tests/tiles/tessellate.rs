//! Tessellations: closed where the surface is, oriented, with their attributes.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::{Vec3, Vec4};
use half::f16;
use proptest::prelude::*;
use relievo_core::marks::GAP;
use relievo_core::{Attribute, Context, ContextOptions, Crease, Domain, Marks, Mesh, Values};
use relievo_surface::{Place, Surface, SurfaceOptions};
use relievo_testing::{Random, cage, grid};
use relievo_tiles::{
    ColorTexel, Displaced, Displacement, DisplacementOptions, Paint, Rgba8, Sets, Tessellation, Tessellator, Trace,
    Traces, uniform_rates,
};

fn surface(mesh: &Mesh) -> Surface {
    Surface::new(&Context::serial(), mesh, &SurfaceOptions::default()).unwrap()
}

fn random_rates(surface: &Surface, seed: u64) -> Vec<u32> {
    let mut random = Random(seed);
    (0..surface.tile_count()).map(|_| 1 << random.below(5)).collect()
}

/// Holds ranges against the arrays of points before and after: they begin and end at points that differ, all that differ
/// are in them, and gaps are small.
fn check_ranges(before: &Tessellation, after: &Tessellation, ranges: &[Range<u32>]) {
    let numbers = |made: &Tessellation, point: usize| {
        let mut numbers = made.mesh.points[point].map(f32::to_bits).to_vec();
        for attribute in made.mesh.attributes.iter().filter(|attribute| attribute.domain == Domain::Point) {
            let Values::F32(values) = &attribute.values else { continue };
            let width = attribute.width as usize;
            numbers.extend(values[width * point..][..width].iter().map(|value| value.to_bits()));
        }
        numbers
    };
    let differing = (0..before.mesh.points.len()).filter(|point| numbers(before, *point) != numbers(after, *point));
    let differing: Vec<u32> = differing.map(|point| point as u32).collect();
    let expected: Vec<Range<u32>> =
        differing.chunk_by(|a, b| b - a <= GAP + 1).map(|run| run[0]..run[run.len() - 1] + 1).collect();
    assert!(!expected.is_empty() && differing.len() < before.mesh.points.len());
    assert_eq!(ranges, expected);
}

/// How often each directed edge occurs.
fn edges(mesh: &Mesh) -> BTreeMap<(u32, u32), u32> {
    let mut edges = BTreeMap::new();
    for face in mesh.faces() {
        for k in 0..3 {
            *edges.entry((face[k], face[(k + 1) % 3])).or_insert(0) += 1;
        }
    }
    edges
}

/// Checks that every edge is used once in each direction, but for `border` edges, and that all vertices are used.
fn check_closed(mesh: &Mesh, border: usize) {
    mesh.check().unwrap();
    let edges = edges(mesh);
    let open = edges.keys().filter(|(a, b)| !edges.contains_key(&(*b, *a))).count();
    assert!(edges.values().all(|count| *count == 1));
    assert_eq!(open, border);
    let mut used = vec![false; mesh.points.len()];
    mesh.corners.iter().for_each(|corner| used[*corner as usize] = true);
    assert!(used.iter().all(|used| *used));
}

fn plain(surface: &Surface, cage: &Mesh, rates: &[u32], context: &Context) -> Tessellation {
    let displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
    Displaced::new(surface, displacement.field()).unwrap().tessellate(context, cage, rates).unwrap()
}

fn triangle(mesh: &Mesh, index: usize) -> [Vec3; 3] {
    [0, 1, 2].map(|k| Vec3::from(mesh.points[mesh.corners[3 * index + k] as usize]))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..Default::default() })]

    #[test]
    fn any_rates_over_a_torus_make_a_closed_mesh(
        size in 3u32..6, choices in prop::collection::vec(any::<u8>(), 1..30), seed: u64,
    ) {
        let mesh = grid(size, true, &choices, false);
        let surface = surface(&mesh);
        let rates = random_rates(&surface, seed);
        let made = plain(&surface, &mesh, &rates, &Context::serial());
        check_closed(&made.mesh, 0);
        let (v, f) = (made.mesh.points.len(), made.mesh.face_count());
        prop_assert_eq!(2 * v, f, "Euler's number of a torus is 0");
        // Every corner's own tile and parameters lead to its point.
        for (corner, [u, v]) in made.parameters.iter().enumerate() {
            let at = surface.sample(relievo_core::simd::Level::best(), Place::new(made.tiles[corner / 3], *u, *v)).unwrap().p;
            let point = made.mesh.points[made.mesh.corners[corner] as usize];
            prop_assert!((0..3).all(|axis| (at[axis] - point[axis]).abs() < 1e-5), "{:?} {:?}", at, point);
        }
        let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
        prop_assert_eq!(plain(&surface, &mesh, &rates, &context), made);
    }

    #[test]
    fn any_sharp_edges_and_fins_leave_no_cracks(
        size in 3u32..6, choices in prop::collection::vec(any::<u8>(), 1..30), seed: u64, fin: bool,
    ) {
        let mut mesh = grid(size, true, &choices, true);
        let mut random = Random(seed);
        let offsets = mesh.face_offsets();
        for _ in 0..random.below(20) {
            let at = offsets[random.below(mesh.face_count())] as usize;
            mesh.creases.push(Crease { points: [mesh.corners[at], mesh.corners[at + 1]], sharpness: 10.0 });
        }
        if fin {
            let (a, b, new) = (mesh.corners[0], mesh.corners[1], mesh.points.len() as u32);
            mesh.points.extend([[9.0, 0.0, 1.0], [9.0, 0.0, 2.0]]);
            mesh.face_sizes.push(4);
            mesh.corners.extend([a, b, new, new + 1]);
        }
        let surface = surface(&mesh);
        let rates = random_rates(&surface, seed);
        let made = plain(&surface, &mesh, &rates, &Context::serial()).mesh;
        made.check().unwrap();
        // Every edge of the mesh has a partner at the same positions, in either direction where faces are wound
        // against each other.
        let made = welded(&made);
        let mut sides = BTreeMap::new();
        for face in made.faces() {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                *sides.entry((a.min(b), a.max(b))).or_insert(0) += 1;
            }
        }
        let open = sides.values().filter(|count| **count == 1).count();
        prop_assert_eq!(open == 0, !fin);
        prop_assert!(sides.values().all(|count| *count <= 3));
    }

    #[test]
    fn a_plane_keeps_its_area_its_side_and_its_coordinates(
        choices in prop::collection::vec(any::<u8>(), 1..30), seed: u64,
    ) {
        let mut mesh = grid(4, false, &choices, false);
        mesh.points.iter_mut().for_each(|p| p[2] = 0.0);
        let uv: Vec<f32> = mesh.corners.iter().flat_map(|corner| [0, 1].map(|axis| mesh.points[*corner as usize][axis])).collect();
        let attribute = |name: &str, domain, width, values| Attribute { name: name.into(), domain, width, values, indices: None };
        mesh.attributes = vec![
            attribute("uv", Domain::Corner, 2, Values::F32(uv)),
            attribute("height", Domain::Point, 1, Values::F32(mesh.points.iter().map(|p| 3.0 * p[0]).collect())),
            attribute("joints", Domain::Point, 1, Values::U32((0..mesh.points.len() as u32).collect())),
            attribute("material", Domain::Face, 1, Values::U32((0..mesh.face_count() as u32).collect())),
        ];
        let surface = surface(&mesh);
        let made = plain(&surface, &mesh, &random_rates(&surface, seed), &Context::serial()).mesh;
        made.check().unwrap();
        let area: f32 = (0..made.face_count()).map(|index| {
            let [a, b, c] = triangle(&made, index);
            let facing = (b - a).cross(c - a);
            assert!(facing.z > 0.0, "{a} {b} {c}");
            0.5 * facing.z
        }).sum();
        // Corners that belong to two triangles are rounded.
        prop_assert!(area > 14.0 && area < 16.001, "{}", area);
        let names: Vec<&str> = made.attributes.iter().map(|attribute| attribute.name.as_str()).collect();
        prop_assert_eq!(names, ["normal", "uv", "height", "joints", "material"]);
        // Corners of the same vertex have the same coordinates, although they belong to different tiles.
        let uv = made.attribute("uv").unwrap();
        let (Values::F32(values), Some(indices)) = (&uv.values, &uv.indices) else { panic!() };
        let mut seen = BTreeMap::new();
        for (corner, index) in made.corners.iter().zip(indices) {
            let uv = [values[2 * *index as usize], values[2 * *index as usize + 1]];
            let old = *seen.entry(*corner).or_insert(uv);
            prop_assert!((old[0] - uv[0]).abs() + (old[1] - uv[1]).abs() < 1e-5);
            let Values::F32(heights) = &made.attribute("height").unwrap().values else { panic!() };
            prop_assert!((heights[*corner as usize] - 3.0 * uv[0]).abs() < 1e-4);
        }
    }
}

#[test]
fn displaced_cages_of_the_shared_data_have_no_cracks() {
    let borders =
        [("rabbit.obj", true), ("spot_control_mesh.obj", true), ("monsterfrog.obj", true), ("suzanne.obj", false)];
    for (name, closed) in borders {
        let Some(mesh) = cage(name) else { return };
        let surface = surface(&mesh);
        let context = Context::serial();
        let mut displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
        displacement.apply(&Sets { allocate: (0..40).collect(), ..Sets::default() }).unwrap();
        let depth = surface.extent() / 50.0;
        let changes = displacement.edit(&context, &(0..40).collect::<Vec<_>>(), |tile, texels| {
            let mut random = Random(u64::from(tile));
            (0..texels.size()).for_each(|row| texels.row_mut(row).fill_with(|| f16::from_f32(-depth * random.unit())));
        });
        displacement.settle(&context, &changes.unwrap()).unwrap();
        let displaced = Displaced::new(&surface, displacement.field()).unwrap();
        let made = displaced.tessellate(&context, &mesh, &random_rates(&surface, 3)).unwrap();
        if closed {
            check_closed(&made.mesh, 0);
        } else {
            made.mesh.check().unwrap();
        }
        assert!(made.tiles.is_sorted() && made.tiles.len() == made.mesh.face_count());
        let Values::F32(normals) = &made.mesh.attribute("normal").unwrap().values else { panic!() };
        for normal in normals.chunks_exact(3) {
            assert!((Vec3::from_slice(normal).length() - 1.0).abs() < 1e-4, "{name} {normal:?}");
        }
        // Two triangles per cell where all rates agree.
        let rates = uniform_rates(surface.topology(), 8);
        let cells: u32 = rates.iter().map(|rate| rate * rate).sum();
        let made = displaced.tessellate(&context, &mesh, &rates).unwrap();
        assert_eq!(made.mesh.face_count() as u32, 2 * cells);
    }
}

/// The mesh with vertices at one position made one.
fn welded(mesh: &Mesh) -> Mesh {
    let mut seen = BTreeMap::new();
    let mut points = Vec::new();
    let weld = |corner: &u32| {
        let p = mesh.points[*corner as usize];
        *seen.entry(p.map(f32::to_bits)).or_insert_with(|| {
            points.push(p);
            points.len() as u32 - 1
        })
    };
    let corners = mesh.corners.iter().map(weld).collect();
    Mesh::new(points, mesh.face_sizes.clone(), corners)
}

/// Fails unless the normals at the corners of every triangle are the triangle's own.
fn check_flat(made: &Tessellation) {
    let Values::F32(normals) = &made.mesh.attribute("normal").unwrap().values else { panic!() };
    for index in 0..made.mesh.face_count() {
        let [a, b, c] = triangle(&made.mesh, index);
        let facing = (b - a).cross(c - a).normalize();
        for corner in &made.mesh.corners[3 * index..3 * index + 3] {
            let normal = Vec3::from_slice(&normals[3 * *corner as usize..]);
            assert!((normal - facing).length() < 1e-3, "{normal} {facing} at {:?}", made.mesh.points[*corner as usize]);
        }
    }
}

#[test]
fn sharp_edges_between_triangles_have_a_normal_for_each_side() {
    let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut mesh = Mesh::from_triangles(points, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    for points in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
        mesh.creases.push(Crease { points, sharpness: 10.0 });
    }
    let surface = surface(&mesh);
    let tessellator = Tessellator::new(surface.topology(), &mesh, uniform_rates(surface.topology(), 4)).unwrap();
    let mut displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
    let plain = displacement.commit();
    let view = Displaced::new(&surface, plain.field()).unwrap();
    let made = tessellator.tessellate(&Context::serial(), &view, &mesh).unwrap();
    check_closed(&welded(&made.mesh), 0);
    check_flat(&made);
}

#[test]
fn sharp_edges_have_a_normal_for_each_side_and_no_cracks() {
    // A cube of quads, but for one side of two triangles, with all its edges sharp.
    let points = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32]).collect();
    let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 1, 7, 5];
    let mut mesh = Mesh::new(points, vec![4, 4, 4, 4, 4, 3, 3], corners);
    for (a, b) in (0..8u32).flat_map(|a| [1, 2, 4].map(|bit| (a, a | bit))).filter(|(a, b)| a != b) {
        mesh.creases.push(Crease { points: [a, b], sharpness: 10.0 });
    }
    let surface = surface(&mesh);
    let context = Context::serial();
    let tessellator = Tessellator::new(surface.topology(), &mesh, uniform_rates(surface.topology(), 4)).unwrap();
    let mut displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
    let plain = displacement.commit();
    let view = Displaced::new(&surface, plain.field()).unwrap();
    let mut made = tessellator.tessellate(&context, &view, &mesh).unwrap();
    check_closed(&welded(&made.mesh), 0);
    check_flat(&made);
    // And with a dent over an edge.
    displacement.apply(&Sets { allocate: vec![0, 6], ..Sets::default() }).unwrap();
    let changes = displacement.edit(&context, &[0, 6], |_, texels| {
        (0..texels.size()).for_each(|row| texels.row_mut(row).fill(f16::from_f32(-0.1)));
    });
    displacement.settle(&context, &changes.unwrap()).unwrap();
    let dented = displacement.commit();
    let view = Displaced::new(&surface, dented.field()).unwrap();
    let count = made.mesh.points.len();
    tessellator.update(&context, &view, dented.changed(), &mut made, &Marks::new(count)).unwrap();
    assert_eq!(made, tessellator.tessellate(&context, &view, &mesh).unwrap());
    check_closed(&welded(&made.mesh), 0);
}

#[test]
fn an_update_of_the_changed_tiles_is_a_whole_tessellation() {
    let mesh = grid(5, true, &[2, 1, 0, 3, 2, 0, 1], false);
    let surface = surface(&mesh);
    let context = Context::serial();
    let mut displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
    let tessellator = Tessellator::new(surface.topology(), &mesh, random_rates(&surface, 8)).unwrap();
    let displaced = |snapshot: &relievo_tiles::Snapshot| {
        tessellator.tessellate(&context, &Displaced::new(&surface, snapshot.field()).unwrap(), &mesh).unwrap()
    };
    let mut made = displaced(&displacement.commit());
    for tile in [3, 17, 4, 3] {
        displacement.apply(&Sets { allocate: vec![tile], ..Sets::default() }).unwrap();
        let changes = displacement.edit(&context, &[tile], |tile, texels| {
            let mut random = Random(u64::from(tile));
            (0..texels.size()).for_each(|row| texels.row_mut(row).fill_with(|| f16::from_f32(-0.1 * random.unit())));
        });
        displacement.settle(&context, &changes.unwrap()).unwrap();
        let snapshot = displacement.commit();
        let view = Displaced::new(&surface, snapshot.field()).unwrap();
        assert!(snapshot.changed().len() < surface.tile_count());
        let before = made.clone();
        let (mut marks, mut moved) = (Marks::new(made.mesh.points.len()), Vec::new());
        tessellator.update(&context, &view, snapshot.changed(), &mut made, &marks).unwrap();
        marks.take(&mut moved);
        assert_eq!(made, displaced(&snapshot));
        check_ranges(&before, &made, &moved);
        for (triangle, tile) in made.tiles.iter().enumerate() {
            let (low, high) = view.tile_bounds(*tile);
            for p in self::triangle(&made.mesh, triangle) {
                assert!(p.cmpge(Vec3::from(low)).all() && p.cmple(Vec3::from(high)).all(), "{tile}");
            }
        }
        assert!(tessellator.update(&context, &view, &[9999], &mut made, &marks).is_err());
        assert!(tessellator.update(&context, &view, &[0], &mut Tessellation::default(), &marks).is_err());
    }
}

#[test]
fn a_hole_is_left_out_and_bad_rates_are_refused() {
    let mut mesh = grid(4, true, &[2], false);
    mesh.holes = vec![5];
    let surface = surface(&mesh);
    let context = Context::serial();
    let made = plain(&surface, &mesh, &uniform_rates(surface.topology(), 4), &context);
    check_closed(&made.mesh, 16);
    assert_eq!(made.mesh.face_count(), 15 * 32);
    let displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    for rates in [vec![4; 15], vec![3; 16], vec![0; 16], vec![1024; 16]] {
        assert!(displaced.tessellate(&context, &mesh, &rates).is_err());
    }
    assert!(displaced.tessellate(&context, &grid(3, true, &[2], false), &[4; 16]).is_err());
}

#[test]
fn colours_and_traces_of_changed_tiles_are_those_of_all() {
    // Faces of all sizes beside each other, so that look-ups near edges see the neighbours.
    let mesh = grid(5, true, &[2, 1, 0, 3, 2, 0, 1], false);
    let surface = surface(&mesh);
    let topology = surface.topology();
    let context = Context::serial();
    let face_sizes = (0..topology.face_count() as u32).map(|face| (face, 8 << (face % 3))).collect();
    let options = DisplacementOptions { face_sizes, ..DisplacementOptions::default() };
    let displacement = Displacement::new(topology.clone(), &options).unwrap();
    let mut paint = Paint::<Rgba8>::of_color(topology.clone(), Vec4::new(0.2, 0.4, 0.6, 1.0), &options).unwrap();
    let mut traces = Traces::of(displacement.field(), 1 << 30).unwrap();
    let tessellator = Tessellator::new(topology, &mesh, random_rates(&surface, 9)).unwrap();
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let plain = tessellator.tessellate(&context, &displaced, &mesh).unwrap();
    let whole = |paint: &relievo_tiles::Field<Rgba8>, traces: &relievo_tiles::Field<Trace>| {
        let mut made = plain.clone();
        made.paint(paint);
        made.trace(traces, 3.0);
        made
    };
    let (mut colors, mut marks) = (paint.commit(), traces.commit());
    let mut made = whole(colors.field(), marks.field());
    assert!(tessellator.paint(colors.field(), &[0], &mut plain.clone(), &Marks::default()).is_err());
    for tile in [3, 17, 4, 3, 0, 11] {
        let sets = || Sets { allocate: vec![tile], ..Sets::default() };
        paint.apply(&sets()).unwrap();
        let changes = paint.edit(&context, &[tile], |tile, texels| {
            let mut random = Random(u64::from(tile));
            let mut color = || Rgba8::of_color(Vec4::new(random.unit(), random.unit(), random.unit(), 1.0));
            (0..texels.size()).for_each(|row| texels.row_mut(row).fill_with(&mut color));
        });
        paint.settle(&context, &changes.unwrap()).unwrap();
        traces.apply(&sets()).unwrap();
        let changes = traces.edit(&context, &[tile], |tile, texels| {
            let mut random = Random(u64::from(tile));
            let mut trace = || Trace::default().pushed(random.unit(), 1.0);
            (0..texels.size()).for_each(|row| texels.row_mut(row).fill_with(&mut trace));
        });
        traces.settle(&context, &changes.unwrap()).unwrap();
        let before = (colors.clone(), marks.clone());
        (colors, marks) = (paint.commit(), traces.commit());
        for (touched, changed) in [
            (colors.touched(&before.0).collect::<Vec<_>>(), colors.changed()),
            (marks.touched(&before.1).collect(), marks.changed()),
        ] {
            assert!(changed.iter().all(|tile| touched.contains(tile)));
        }
        let mut seen = Vec::new();
        colors.seen_from(&before.0, colors.changed(), &mut seen);
        assert!(seen.len() < surface.tile_count() && seen.windows(2).all(|pair| pair[0] < pair[1]));
        let (start, mut points, mut ranges) = (made.clone(), Marks::new(made.mesh.points.len()), Vec::new());
        tessellator.paint(colors.field(), &seen, &mut made, &points).unwrap();
        tessellator.trace(marks.field(), 3.0, marks.changed(), &mut made, &points).unwrap();
        assert_eq!(made, whole(colors.field(), marks.field()));
        points.take(&mut ranges);
        check_ranges(&start, &made, &ranges);
    }
}
