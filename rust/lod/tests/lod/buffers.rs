//! Meshes in their user's buffers: what is written there, and what is not.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use relievo_core::marks::GAP;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Falloff};
use relievo_lod::Progressive;
use relievo_lod::progressive::{
    ActiveMesh, Buffers, BuildOptions, Cut, Edit, Extents, Extract, Front, Handle, HandleKey, KeyedEdit, KeyedHandle,
    Region, Update, View,
};

use crate::attributes::furnished_cube;
use crate::shapes::{Triangles, torus, two_tori};
use crate::wedges::{self, painted_torus};

/// Buffers that know where they were written.
#[derive(Default)]
struct Kept {
    mesh: Extract,
    vertices: BTreeSet<u32>,
    triangles: BTreeSet<u32>,
    wedges: BTreeSet<u32>,
    writes: usize,
}

/// Returns the ranges of places: places with at most a gap between them are in one range.
fn ranges(places: &BTreeSet<u32>) -> Vec<Range<u32>> {
    let places: Vec<u32> = places.iter().copied().collect();
    places.chunk_by(|a, b| b - a <= GAP + 1).map(|run| run[0]..run[run.len() - 1] + 1).collect()
}

/// How many elements ranges have.
fn length(ranges: &[Range<u32>]) -> usize {
    ranges.iter().map(ExactSizeIterator::len).sum()
}

impl Buffers for Kept {
    fn set_vertex(&mut self, place: usize, point: [f32; 3], normal: [f32; 3]) {
        self.mesh.set_vertex(place, point, normal);
        self.vertices.insert(place as u32);
        self.writes += 1;
    }

    fn set_triangle(&mut self, place: usize, vertices: [u32; 3]) {
        self.mesh.set_triangle(place, vertices);
        self.triangles.insert(place as u32);
        self.writes += 1;
    }

    fn set_wedge(&mut self, place: usize, values: &[f32]) {
        self.mesh.set_wedge(place, values);
        self.wedges.insert(place as u32);
        self.writes += 1;
    }

    fn set_corners(&mut self, place: usize, wedges: [u32; 3], values: &[u32]) {
        self.mesh.set_corners(place, wedges, values);
    }
}

/// The triangles of a mesh as points, normals and what wedges and triangles have, in an order of their own.
fn sorted(mesh: &Extract, triangles: usize, [width, face_width]: [usize; 2]) -> Vec<Vec<u32>> {
    let triangle = |face: usize| {
        let mut numbers = Vec::new();
        for (side, vertex) in mesh.triangles[face].map(|vertex| vertex as usize).into_iter().enumerate() {
            let places = [mesh.points[vertex], mesh.normals[vertex]];
            numbers.extend(places.as_flattened().iter().map(|value| value.to_bits()));
            let wedge = mesh.wedges.get(face).map_or(0, |wedges| wedges[side] as usize);
            numbers.extend(mesh.values[wedge * width..(wedge + 1) * width].iter().map(|value| value.to_bits()));
        }
        numbers.extend(&mesh.face_values[face * face_width..(face + 1) * face_width]);
        numbers
    };
    let mut list: Vec<_> = (0..triangles).map(triangle).collect();
    list.sort_unstable();
    list
}

/// Updates buffers and compares them with the whole mesh. Returns how often something was written.
fn compare(active: &mut ActiveMesh, kept: &mut Kept) -> usize {
    *kept = Kept { mesh: std::mem::take(&mut kept.mesh), ..Kept::default() };
    let update = active.update(kept, false);
    let expected = Update {
        vertices: active.vertex_count(),
        triangles: active.triangle_count(),
        changed_vertices: ranges(&kept.vertices),
        changed_triangles: ranges(&kept.triangles),
        wedges: update.wedges,
        changed_wedges: ranges(&kept.wedges),
    };
    assert_eq!(update, expected);
    let wedges = kept.mesh.wedges[..update.triangles.min(kept.mesh.wedges.len())].as_flattened();
    assert!(wedges.iter().all(|wedge| (*wedge as usize) < update.wedges));
    assert!(kept.mesh.triangles[..update.triangles].iter().flatten().all(|it| (*it as usize) < update.vertices));
    let whole = active.extract();
    let wedges = whole.wedges.as_flattened().iter().max().map_or(1, |last| *last as usize + 1);
    let widths = [whole.values.len() / wedges, whole.face_values.len() / whole.triangles.len()];
    assert!(sorted(&kept.mesh, update.triangles, widths) == sorted(&whole, whole.triangles.len(), widths));
    kept.writes
}

fn build((points, triangles): &Triangles) -> Arc<Progressive> {
    let options = BuildOptions { faces: 40, ..BuildOptions::default() };
    Arc::new(Progressive::build(&Context::serial(), points, triangles, &options, &mut Silent).unwrap())
}

fn pull(center: [f32; 3], radius: f32) -> Edit {
    let region = Region { center, radius, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.1, 0.0, 0.2], axis: [0.0, 0.0, 1.0], angle: 0.4 };
    Edit { handles: vec![handle], ..Edit::default() }
}

#[test]
fn buffers_have_the_mesh_after_all_that_can_happen_to_it() {
    let painted = wedges::build(&painted_torus(80, 40), 40);
    for mesh in [build(&torus(80, 40)), build(&two_tori()), painted, wedges::build(&furnished_cube(24), 40)] {
        let context = Context::serial();
        let (mut active, mut kept) = (ActiveMesh::new(&mesh), Kept::default());
        compare(&mut active, &mut kept);
        for faces in [500, 3000, 900, usize::MAX, 100, 700] {
            active.adapt(&context, Cut::of_faces(&mesh, faces));
            compare(&mut active, &mut kept);
        }
        active.edit(&context, &pull([1.0, 0.0, 0.4], 0.6)).unwrap();
        compare(&mut active, &mut kept);
        // Finer and coarser before anything is written.
        active.adapt(&context, Cut::of_faces(&mesh, 2500));
        active.adapt(&context, Cut::of_faces(&mesh, 600));
        active.adapt(&context, Cut::of_faces(&mesh, 1500));
        compare(&mut active, &mut kept);
        active.undo(&context);
        compare(&mut active, &mut kept);
        active.redo(&context);
        active.adapt(&context, Cut::BASE);
        compare(&mut active, &mut kept);
        let extents = Extents::new(&mesh);
        for x in [2.0, 2.2, 0.5, -2.0] {
            let view = View { eye: [x, 0.3, 0.5], pixels: 400.0, tolerance: 2.0, outline: 2.0, planes: Vec::new() };
            active.adapt_to(&context, &view, &extents).unwrap();
            compare(&mut active, &mut kept);
        }
        active.settled(&context);
        compare(&mut active, &mut kept);
        assert_eq!(compare(&mut active, &mut kept), 0, "nothing has changed");
    }
}

#[test]
fn little_is_written_of_little_that_changes() {
    let mesh = build(&torus(200, 100));
    let context = Context::serial();
    let (mut active, mut kept) = (ActiveMesh::new(&mesh), Kept::default());
    active.adapt(&context, Cut::of_faces(&mesh, 20_000));
    let whole = compare(&mut active, &mut kept);
    assert_eq!(whole, active.vertex_count() + active.triangle_count());
    let [splits, _] = active.adapt(&context, Cut::of_faces(&mesh, 20_200));
    // A split changes its two vertices and the triangles around them.
    assert!(compare(&mut active, &mut kept) < 16 * splits);
    let reached = active.edit(&context, &pull([1.4, 0.0, 0.0], 0.1)).unwrap();
    assert_eq!(compare(&mut active, &mut kept), reached);
    // Ranges are as fine as what differs in the buffers.
    active.edit(&context, &pull([-1.4, 0.0, 0.0], 0.2)).unwrap();
    let before = kept.mesh.clone();
    let update = active.update(&mut kept, false);
    let differs = |place: &u32| {
        let place = *place as usize;
        (before.points[place], before.normals[place]) != (kept.mesh.points[place], kept.mesh.normals[place])
    };
    let differing: BTreeSet<u32> = (0..update.vertices as u32).filter(differs).collect();
    assert!(differing.len() > 50 && update.changed_triangles.is_empty());
    assert!(differing.iter().all(|place| update.changed_vertices.iter().any(|range| range.contains(place))));
    assert!(length(&update.changed_vertices) <= 4 * differing.len(), "{:?}", update.changed_vertices);
    let all = active.update(&mut kept, true);
    assert_eq!([length(&all.changed_vertices), length(&all.changed_triangles)], [all.vertices, all.triangles]);
}

#[test]
fn what_moves_over_time_beneath_a_finer_mesh_is_all_that_is_written() {
    let (mesh, context) = (build(&torus(200, 100)), Context::serial());
    let (mut active, mut kept) = (ActiveMesh::new(&mesh), Kept::default());
    active.adapt(&context, Cut::FINEST);
    let (whole, rest) = (compare(&mut active, &mut kept), active.extract());
    let Edit { handles, anchors } = pull([1.4, 0.0, 0.0], 0.3);
    let key = |time: f64, share: f32| {
        let Handle { translation, axis, angle, .. } = handles[0];
        HandleKey { time, translation: translation.map(|along| share * along), axis, angle: share * angle }
    };
    let handle = KeyedHandle { region: handles[0].region, keys: vec![key(0.0, 0.0), key(1.0, 1.0)] };
    let motion = [(Front::Cut(Cut::of_faces(&mesh, 2000)), KeyedEdit { handles: vec![handle], anchors })];
    for time in [1.0, 0.5, 0.0, 0.7] {
        let reached = active.pose(&context, &motion, time).unwrap();
        assert_eq!((reached > 10, active.extract() != rest), (time > 0.0, time > 0.0));
        let writes = compare(&mut active, &mut kept);
        assert!((1..whole / 20).contains(&writes), "{writes} of {whole}");
    }
    // Other levels have the pose too, and are at rest after it.
    active.adapt(&context, Cut::of_faces(&mesh, 5000));
    active.adapt(&context, Cut::FINEST);
    compare(&mut active, &mut kept);
    active.rest(&context);
    compare(&mut active, &mut kept);
    assert!(active.extract() == rest);
}

#[test]
fn places_do_not_depend_on_threads() {
    let mesh = build(&torus(150, 80));
    let made = [1, 4].map(|threads| {
        let context = Context::new(&ContextOptions { threads, ..ContextOptions::default() }).unwrap();
        let (mut active, mut kept) = (ActiveMesh::new(&mesh), Extract::default());
        for faces in [400, 9_000, 2_000, 5_000] {
            active.adapt(&context, Cut::of_faces(&mesh, faces));
            active.update(&mut kept, false);
        }
        kept
    });
    assert!(made[0] == made[1]);
}
