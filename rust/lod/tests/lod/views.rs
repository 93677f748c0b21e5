//! Meshes for a view: what they have, what they leave out, and that they come back.

use std::sync::Arc;

use glam::Vec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Falloff};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, Edit, Extents, Extract, Handle, Region, View};

use crate::shapes::{edges, torus};

fn build() -> Arc<Progressive> {
    let (points, triangles) = torus(120, 60);
    let options = BuildOptions { faces: 60, ..BuildOptions::default() };
    Arc::new(Progressive::build(&Context::serial(), &points, &triangles, &options, &mut Silent).unwrap())
}

fn view(eye: [f32; 3], tolerance: f32) -> View {
    View { eye, pixels: 500.0, tolerance, outline: 1.0, planes: Vec::new() }
}

/// Triangles whose first corner has x above or below 0.
fn halves(mesh: &Extract) -> [usize; 2] {
    let right = mesh.triangles.iter().filter(|triangle| mesh.points[triangle[0] as usize][0] > 0.0).count();
    [mesh.triangles.len() - right, right]
}

fn assert_closed(mesh: &Extract) {
    let edges = edges(&mesh.triangles);
    assert!(edges.values().all(|count| *count == 2));
    assert_eq!(mesh.points.len() + mesh.triangles.len(), edges.len(), "Euler's number of a torus is 0");
}

#[test]
fn what_is_near_is_finer() {
    let mesh = build();
    let (context, extents) = (Context::serial(), Extents::new(&mesh));
    let mut active = ActiveMesh::new(&mesh);
    active.adapt_to(&context, &view([1.8, 0.0, 0.3], 3.0), &extents).unwrap();
    let made = active.extract();
    assert_closed(&made);
    let [far, near] = halves(&made);
    assert!(near > 2 * far && made.triangles.len() < 10_000, "{far} {near}");
    assert_eq!((active.triangle_count(), active.vertex_count()), (made.triangles.len(), made.points.len()));
}

#[test]
fn what_is_not_seen_stays_coarse() {
    let mesh = build();
    let (context, extents) = (Context::serial(), Extents::new(&mesh));
    let mut active = ActiveMesh::new(&mesh);
    let everything = view([0.0, 0.0, 5.0], 0.3);
    active.adapt_to(&context, &everything, &extents).unwrap();
    let [left, right] = halves(&active.extract());
    assert!(left.abs_diff(right) < left / 4);
    let right_half = View { planes: vec![[1.0, 0.0, 0.0, 0.0]], ..everything };
    active.adapt_to(&context, &right_half, &extents).unwrap();
    let made = active.extract();
    assert_closed(&made);
    let [left, still] = halves(&made);
    assert!(still > right * 9 / 10 && left < still * 2 / 3, "{left} {still}");
}

#[test]
fn outlines_are_finer_where_that_is_asked() {
    let mesh = build();
    let (context, extents) = (Context::serial(), Extents::new(&mesh));
    let count = |outline: f32| {
        let mut active = ActiveMesh::new(&mesh);
        let view = View { outline, ..view([0.0, 0.0, 6.0], 2.0) };
        active.adapt_to(&context, &view, &extents).unwrap();
        let made = active.extract();
        let outside = |triangle: &&[u32; 3]| Vec3::from(made.points[triangle[0] as usize]).z.abs() < 0.1;
        let outer = made.triangles.iter().filter(outside).count();
        [outer, made.triangles.len() - outer]
    };
    let ([outer, inner], [finer, same]) = (count(1.0), count(8.0));
    assert!(finer > 2 * outer && finer * inner > outer * same, "{outer} {inner} {finer} {same}");
}

#[test]
fn a_mesh_for_a_view_is_the_same_whatever_was_before_and_leaves_nothing_behind() {
    let mesh = build();
    let extents = Extents::new(&mesh);
    let wanted = view([1.8, 0.0, 0.3], 3.0);
    let mut fresh = ActiveMesh::new(&mesh);
    fresh.adapt_to(&Context::serial(), &wanted, &extents).unwrap();
    for threads in [1, 3] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut active = ActiveMesh::new(&mesh);
        active.adapt(&context, Cut::FINEST);
        active.adapt_to(&context, &view([-1.8, 0.2, 0.3], 2.0), &extents).unwrap();
        let moved = active.adapt_to(&context, &wanted, &extents).unwrap();
        assert!(moved[0] > 100 && moved[1] > 100, "{moved:?}");
        assert!(active.extract() == fresh.extract());
        assert_eq!(active.adapt_to(&context, &wanted, &extents).unwrap(), [0, 0]);
        for cut in [Cut::of_faces(&mesh, 3000), Cut::BASE, Cut::FINEST] {
            let mut plain = ActiveMesh::new(&mesh);
            plain.adapt(&context, cut);
            active.adapt(&context, cut);
            assert!(active.extract() == plain.extract());
            active.adapt_to(&context, &wanted, &extents).unwrap();
        }
    }
}

#[test]
fn an_edit_shows_in_every_view_and_is_taken_back_there() {
    let mesh = build();
    let (context, extents) = (Context::serial(), Extents::new(&mesh));
    let mut active = ActiveMesh::new(&mesh);
    let region = Region { center: [0.0; 3], radius: 9.0, falloff: Falloff::Constant };
    let lift = Handle { region, translation: [0.0, 0.0, 1.0], axis: [0.0; 3], angle: 0.0 };
    let edit = Edit { handles: vec![lift], anchors: Vec::new() };
    active.edit(&context, &edit).unwrap();
    active.adapt_to(&context, &view([1.8, 0.0, 1.3], 3.0), &extents).unwrap();
    let low = active.extract().points.iter().map(|point| point[2]).fold(f32::MAX, f32::min);
    assert!(low > 0.5);
    let front = active.front();
    assert!(active.undo(&context) && active.front() == front);
    active.adapt(&context, Cut::BASE);
    assert!(active.extract() == ActiveMesh::new(&mesh).extract());
    assert!(active.adapt_to(&context, &view([f32::NAN; 3], 1.0), &extents).is_err());
    assert!(active.adapt_to(&context, &view([0.0; 3], 0.0), &extents).is_err());
}

fn apart(a: &Extract, b: &Extract) -> f32 {
    assert_eq!(a.triangles, b.triangles);
    a.points.iter().zip(&b.points).map(|(a, b)| Vec3::from(*a).distance((*b).into())).fold(0.0, f32::max)
}

fn pull(center: [f32; 3]) -> Edit {
    let region = Region { center, radius: 0.5, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.1, 0.2, 0.3], axis: [0.0, 0.6, 0.8], angle: 0.7 };
    Edit { handles: vec![handle], ..Edit::default() }
}

#[test]
fn what_is_grabbed_in_a_view_is_the_same_edit_whatever_way_the_view_was_reached() {
    let mesh = build();
    let (context, extents) = (Context::serial(), Extents::new(&mesh));
    // Finer on one side than on the other: the region has vertices of both.
    let wanted = View { planes: vec![[0.0, 1.0, 0.0, 0.0]], ..view([1.8, 0.0, 0.3], 3.0) };
    let levels = [Cut::of_faces(&mesh, 600), Cut::BASE, Cut::of_faces(&mesh, 3000), Cut::FINEST];
    let edited = |ways: &[Option<Cut>], after: &[Cut]| {
        let mut active = ActiveMesh::new(&mesh);
        for way in ways {
            match way {
                Some(cut) => _ = active.adapt(&context, *cut),
                None => _ = active.adapt_to(&context, &view([-1.8, 0.2, 0.3], 2.0), &extents).unwrap(),
            }
        }
        active.adapt_to(&context, &wanted, &extents).unwrap();
        let reached = active.edit(&context, &pull([1.4, 0.0, 0.0])).unwrap();
        let seen = active.extract();
        after.iter().for_each(|cut| _ = active.adapt(&context, *cut));
        let made = levels.map(|cut| {
            active.adapt(&context, cut);
            active.extract()
        });
        (reached, seen, made, active)
    };
    let (reached, seen, made, mut active) = edited(&[], &[]);
    let mut plain = ActiveMesh::new(&mesh);
    plain.adapt(&context, Cut::FINEST);
    assert!(reached > 20 && apart(&made[3], &plain.extract()) > 0.1, "{reached}");
    for (ways, after) in [
        (vec![Some(Cut::FINEST)], vec![Cut::FINEST]),
        (vec![None, Some(Cut::of_faces(&mesh, 500))], vec![Cut::of_faces(&mesh, 2000), Cut::BASE]),
    ] {
        let (other_reached, other_seen, other, _) = edited(&ways, &after);
        assert_eq!((other_reached, &other_seen), (reached, &seen));
        for (level, (a, b)) in made.iter().zip(&other).enumerate() {
            assert!(apart(a, b) < 1e-5, "{level}: {}", apart(a, b));
        }
    }
    // Between edits of levels it is taken back and made again, wherever the mesh is.
    active.adapt(&context, Cut::of_faces(&mesh, 300));
    active.edit(&context, &pull([1.2, 0.4, 0.0])).unwrap();
    active.adapt_to(&context, &view([1.8, 0.4, 0.3], 2.0), &extents).unwrap();
    active.edit(&context, &pull([1.3, 0.3, 0.1])).unwrap();
    active.adapt(&context, Cut::FINEST);
    let all = active.extract();
    active.adapt(&context, Cut::of_faces(&mesh, 900));
    assert!(active.undo(&context) && active.undo(&context));
    active.adapt(&context, Cut::FINEST);
    assert!(apart(&active.extract(), &made[3]) < 1e-5);
    assert!(active.undo(&context) && !active.undo(&context));
    assert!(active.extract() == plain.extract());
    active.adapt_to(&context, &wanted, &extents).unwrap();
    assert!(active.redo(&context) && active.redo(&context) && active.redo(&context));
    active.adapt(&context, Cut::FINEST);
    assert!(apart(&active.extract(), &all) < 2e-5);
}
