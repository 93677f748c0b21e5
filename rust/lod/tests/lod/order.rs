//! Splits whose order no longer fits what they have become, and meshes that are built anew.

use std::sync::Arc;

use glam::Vec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Falloff};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, BuildOptions, Cut, Edit, Handle, Misplaced, Region};

use crate::shapes::{Triangles, lifted, torus};

fn build((points, triangles): &Triangles) -> Arc<Progressive> {
    let options = BuildOptions { faces: 60, ..BuildOptions::default() };
    Arc::new(Progressive::build(&Context::serial(), points, triangles, &options, &mut Silent).unwrap())
}

/// A plate that is flat but for grooves that are hardly seen.
fn plate(n: u32) -> Triangles {
    lifted(n, |x, y| 1e-4 * (60.0 * x).sin() * (50.0 * y).cos())
}

/// A bump is pulled out of it, at the finest level.
fn pulled(context: &Context, mesh: &Arc<Progressive>) -> ActiveMesh {
    let mut active = ActiveMesh::new(mesh);
    active.adapt(context, Cut::FINEST);
    let region = Region { center: [0.3, 0.4, 0.0], radius: 0.2, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.0, 0.0, 0.3], axis: [0.0; 3], angle: 0.0 };
    active.edit(context, &Edit { handles: vec![handle], anchors: Vec::new() }).unwrap();
    active
}

/// The root of the mean square of how far a plate is above or below a level of it, at the places of its finest mesh that
/// are far from its border: by the height of the triangle there.
fn deviation(active: &mut ActiveMesh, cut: Cut) -> f64 {
    let context = Context::serial();
    active.adapt(&context, Cut::FINEST);
    let finest = active.extract();
    active.adapt(&context, cut);
    let level = active.extract();
    let at = |vertex: u32| Vec3::from(level.points[vertex as usize]);
    let (mut sum, mut count) = (0.0, 0);
    for point in finest.points.iter().map(|point| Vec3::from(*point)).step_by(7) {
        let side = |a: Vec3, b: Vec3| (b - a).truncate().perp_dot((point - a).truncate());
        let above = level.triangles.iter().find_map(|triangle| {
            let [a, b, c] = triangle.map(at);
            let shares = [side(b, c), side(c, a), side(a, b)];
            let whole = shares.iter().sum::<f32>();
            let is_in = whole > 0.0 && shares.iter().all(|share| *share >= 0.0);
            is_in.then(|| (a.z * shares[0] + b.z * shares[1] + c.z * shares[2]) / whole)
        });
        if let Some(z) = above {
            sum += f64::from(point.z - z).powi(2);
            count += 1;
        }
    }
    assert!(count > 100);
    (sum / f64::from(count)).sqrt()
}

#[test]
fn a_mesh_as_it_was_built_is_in_order_and_stays_so_where_it_moves_rigidly() {
    let context = Context::serial();
    let bumps = lifted(60, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos() + 0.02 * (40.0 * x * y).sin());
    for shape in [torus(120, 60), bumps, plate(60)] {
        let mesh = build(&shape);
        let mut active = ActiveMesh::new(&mesh);
        active.adapt(&context, Cut::of_faces(&mesh, 500));
        let before = active.extract();
        assert_eq!(active.misplaced(&context), []);
        assert!(active.extract() == before, "it has not changed");
        let region = Region { center: [0.3, 0.1, -0.2], radius: 100.0, falloff: Falloff::Constant };
        let handle = Handle { region, translation: [0.5, -0.3, 0.2], axis: [0.0, 0.6, 0.8], angle: 2.0 };
        active.edit(&context, &Edit { handles: vec![handle], anchors: Vec::new() }).unwrap();
        assert_eq!(active.misplaced(&context), []);
    }
}

#[test]
fn what_is_bent_where_it_was_flat_is_found_there_whatever_the_threads() {
    let mesh = build(&plate(100));
    let run = |threads: usize| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        pulled(&context, &mesh).misplaced(&context)
    };
    let found = run(1);
    assert!(found.len() > 100 && found[0].now > 0.01, "{}", found.len());
    assert!(found.iter().all(|split| split.now > 2.0 * split.told));
    // Coarse splits have the bump among their triangles from further away.
    let near = |split: &&Misplaced| Vec3::from(split.point).truncate().distance([0.3, 0.4].into()) < 0.25;
    assert!(found.iter().filter(near).count() > found.len() / 2);
    assert!(found.is_sorted_by(|a, b| a.now >= b.now));
    assert!(run(3) == found);
}

#[test]
fn a_mesh_that_is_built_anew_is_in_order_and_has_its_triangles_where_they_are_needed() {
    let context = Context::serial();
    let mesh = build(&plate(100));
    let mut active = pulled(&context, &mesh);
    active.adapt(&context, Cut::FINEST);
    let finest = active.extract();
    let options = BuildOptions { faces: 60, locked: vec![0] };
    let made = Arc::new(active.rebuilt(&context, &options, &mut Silent).unwrap());
    let mut again = ActiveMesh::new(&made);
    assert!(again.extract().points.contains(&finest.points[0]), "it is locked");
    assert_eq!(again.misplaced(&context), []);
    again.adapt(&context, Cut::FINEST);
    let rebuilt = again.extract();
    assert!(rebuilt.points == finest.points && rebuilt.triangles == finest.triangles);
    let faces = 300;
    let settled = Arc::new(active.settled(&context));
    let mut settled_mesh = ActiveMesh::new(&settled);
    assert!(settled_mesh.misplaced(&context).len() > 100, "what is saved tells it too");
    let [before, after] = [(&mut settled_mesh, &settled), (&mut again, &made)]
        .map(|(active, mesh)| deviation(active, Cut::of_faces(mesh, faces)));
    assert!(after < 0.5 * before, "{after}, not less than {before}");
    assert!(active.rebuilt(&context, &BuildOptions { locked: vec![u32::MAX], ..options }, &mut Silent).is_err());
}
