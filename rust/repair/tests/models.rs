//! Models that users import, repaired and held against a check that shares no code with the repair.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_repair::{RepairSettings, Repaired, check, repair};

/// Fails unless the mesh is an oriented manifold: no directed edge occurs twice, and around each point the faces form
/// one fan. Returns the number of boundary edges.
fn assert_manifold(mesh: &Mesh, name: &str) -> usize {
    mesh.check().unwrap_or_else(|error| panic!("{name}: {error}"));
    let mut after: HashMap<(u32, u32), u32> = HashMap::new();
    let mut spokes: HashMap<u32, Vec<(u32, u32)>> = HashMap::new();
    for face in mesh.faces() {
        for (at, point) in face.iter().enumerate() {
            let next = face[(at + 1) % face.len()];
            let before = face[(at + face.len() - 1) % face.len()];
            assert_eq!(after.insert((*point, next), before), None, "{name}: edge {point}-{next} occurs twice");
            spokes.entry(*point).or_default().push((next, before));
        }
    }
    for (point, pairs) in spokes {
        // Each face leads from its next point to its last one; together they are one chain or one ring.
        let leads: HashMap<u32, u32> = pairs.iter().copied().collect();
        let ends: Vec<u32> = pairs.iter().map(|(_, last)| *last).collect();
        let start = pairs.iter().map(|(next, _)| *next).find(|next| !ends.contains(next)).unwrap_or(pairs[0].0);
        let (mut at, mut steps) = (start, 0);
        while let Some(next) = leads.get(&at) {
            (at, steps) = (*next, steps + 1);
            if at == start || steps > pairs.len() {
                break;
            }
        }
        assert_eq!(steps, pairs.len(), "{name}: point {point} has more than one fan");
    }
    after.keys().filter(|(from, to)| !after.contains_key(&(*to, *from))).count()
}

fn volume(mesh: &Mesh) -> f64 {
    let place = |point: u32| mesh.points[point as usize].map(f64::from);
    let six: f64 = mesh
        .triangles()
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(place);
            a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        })
        .sum();
    six / 6.0
}

fn repaired(mesh: &Mesh, settings: &RepairSettings, name: &str) -> Repaired {
    let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).expect("two threads");
    let made = repair(&context, mesh, settings, &mut Silent).unwrap_or_else(|error| panic!("{name}: {error}"));
    let alone = repair(&Context::serial(), mesh, settings, &mut Silent).expect("repaired before");
    assert_eq!((&made.mesh, &made.report), (&alone.mesh, &alone.report), "{name} depends on the number of threads");
    made
}

/// Repairs the model of a file, if it is one and has at most 40,000 faces.
fn assert_repaired(path: &Path) {
    let name = path.display().to_string();
    let Ok(mesh) = relievo_meshio::read(&Context::serial(), path) else { return };
    if mesh.face_count() == 0 || mesh.face_count() > 40_000 {
        return;
    }
    let made = repaired(&mesh, &RepairSettings::default(), &name);
    let boundary = assert_manifold(&made.mesh, &name);
    assert_eq!(made.report.after.boundary_edges, boundary, "{name}");
    let before = &made.report.before;
    let is_sound = before.boundary_edges + before.non_manifold_edges + made.report.turned_faces == 0;
    if is_sound && before.volume != 0.0 {
        assert!((volume(&made.mesh) / before.volume - 1.0).abs() < 1e-4, "{name}: volume of {before:?}");
    }
    let again = check(&Context::serial(), &made.mesh, &RepairSettings::default(), &mut Silent).expect("checked");
    assert_eq!(again.invalid_faces.count + again.degenerate_faces.count, 0, "{name}");
}

#[test]
fn models_of_all_kinds_become_oriented_manifolds() {
    for folder in ["ugly", "formats", "meshes", "cages"] {
        let Some(folder) = relievo_testing::file(folder) else { return };
        let files = std::fs::read_dir(folder).expect("the folder").map(|file| file.expect("a file").path());
        let files: Vec<PathBuf> = files.collect();
        // Most of a repair runs on one thread.
        std::thread::scope(|scope| {
            for part in 0..2 {
                let files = files.iter().skip(part).step_by(2);
                scope.spawn(move || files.for_each(|path| assert_repaired(path)));
            }
        });
    }
}
