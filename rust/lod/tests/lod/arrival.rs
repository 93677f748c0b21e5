//! Progressive meshes whose files arrive piece by piece.

use std::sync::Arc;

use relievo_core::{Context, Falloff, Mesh};
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, Arrival, Cut, Edit, Extents, Extract, Handle, Region, View};
use relievo_testing::Random;

use crate::attributes::furnished_cube;
use crate::shapes::{lifted, torus};
use crate::wedges;

fn written(mesh: &Progressive) -> Vec<u8> {
    let mut bytes = Vec::new();
    mesh.write(&Context::serial(), &mut bytes).unwrap();
    bytes
}

fn plain() -> Arc<Progressive> {
    let (points, triangles) = torus(300, 200);
    wedges::build(&Mesh::from_triangles(points, &triangles), 100)
}

fn at(mesh: &Arc<Progressive>, cut: Cut) -> ActiveMesh {
    let mut active = ActiveMesh::new(mesh);
    active.adapt(&Context::serial(), cut);
    active
}

fn edit() -> Edit {
    let region = Region { center: [1.4, 0.0, 0.0], radius: 0.6, falloff: Falloff::Smooth };
    let handle = Handle { region, translation: [0.3, 0.0, 0.1], axis: [0.0, 0.0, 1.0], angle: 0.5 };
    Edit { handles: vec![handle], anchors: Vec::new() }
}

#[test]
fn every_beginning_is_a_level_and_meshes_in_use_become_finer() {
    let context = Context::serial();
    let mut random = Random(7);
    for built in [plain(), wedges::build(&furnished_cube(80), 100)] {
        let bytes = written(&built);
        let (mut arrival, mut rest, mut triangles, mut levels) = (Arrival::new(&context), bytes.as_slice(), 0, 0);
        let mut in_use: Option<ActiveMesh> = None;
        while !rest.is_empty() {
            let length = 1 + (random.unit() * [9.0, 900.0, 90_000.0][levels % 3]) as usize;
            let (piece, later) = rest.split_at(length.min(rest.len()));
            rest = later;
            let now = arrival.push(&context, piece).unwrap();
            assert!(now >= triangles);
            assert_eq!(arrival.mesh().is_some(), now > 0);
            if now == triangles {
                continue;
            }
            triangles = now;
            levels += 1;
            let mesh = arrival.mesh().unwrap();
            assert_eq!((mesh.vertex_count(), mesh.triangle_count()), (built.vertex_count(), built.triangle_count()));
            let expected = at(&built, Cut::of_faces(&built, triangles)).extract();
            assert_eq!(expected.triangles.len(), triangles);
            let active = in_use.get_or_insert_with(|| ActiveMesh::new(mesh));
            let before = active.extract();
            active.take_up(mesh).unwrap();
            assert!(active.extract() == before);
            active.adapt(&context, Cut::FINEST);
            assert!(active.extract() == expected && at(mesh, Cut::FINEST).extract() == expected);
            for faces in [200, 1000].into_iter().filter(|faces| *faces <= triangles) {
                assert!(
                    at(mesh, Cut::of_faces(mesh, faces)).extract()
                        == at(&built, Cut::of_faces(&built, faces)).extract()
                );
            }
        }
        assert!(arrival.is_complete() && levels > 2);
        assert!(written(arrival.mesh().unwrap()) == bytes);
        assert_eq!(arrival.push(&context, &[1, 2, 3]).unwrap(), triangles);
    }
}

#[test]
fn edits_and_views_go_on_as_more_arrives() {
    let context = Context::serial();
    for built in [plain(), wedges::build(&furnished_cube(80), 100)] {
        let bytes = written(&built);
        let mut arrival = Arrival::new(&context);
        let mut pieces = bytes.chunks(10_000);
        while arrival.push(&context, pieces.next().unwrap()).unwrap() < 2000 {}
        let mesh = arrival.mesh().unwrap().clone();
        let (mut active, mut viewed) = (at(&mesh, Cut::FINEST), ActiveMesh::new(&mesh));
        let half = active.triangle_count();
        assert!(half > 1000 && half < built.triangle_count());
        assert!(mesh.save(&context, std::path::Path::new("never")).unwrap_err().to_string().contains("not all"));
        let mut edit = edit();
        if built.wedge_count() > 0 {
            edit.handles[0].region.center = [0.5, 0.5, 1.0];
        }
        active.edit(&context, &edit).unwrap();
        let extents = Extents::new(&mesh);
        let view = View { eye: [2.0, 0.0, 0.5], pixels: 400.0, tolerance: 0.5, outline: 1.0, planes: Vec::new() };
        viewed.adapt_to(&context, &view, &extents).unwrap();
        pieces.for_each(|piece| _ = arrival.push(&context, piece).unwrap());
        let whole = arrival.mesh().unwrap();
        for mesh in [&mut active, &mut viewed] {
            let before = mesh.extract();
            mesh.take_up(whole).unwrap();
            assert!(mesh.extract() == before);
        }
        // Less of it, or another one, is refused.
        assert!(active.take_up(&mesh).is_err());
        let other = lifted(40, |_, _| 0.0);
        assert!(active.take_up(&wedges::build(&Mesh::from_triangles(other.0, &other.1), 10)).is_err());
        // Where it was edited, what is finer follows as if all had been there.
        let mut expected = at(&built, Cut::of_faces(&built, half));
        expected.edit(&context, &edit).unwrap();
        for mesh in [&mut active, &mut expected] {
            mesh.adapt(&context, Cut::FINEST);
        }
        let apart = |one: &Extract, other: &Extract| {
            assert_eq!(one.triangles, other.triangles);
            let pairs = one.points.iter().zip(&other.points);
            pairs.map(|(a, b)| glam::Vec3::from(*a).distance((*b).into())).fold(0.0, f32::max)
        };
        assert!(apart(&active.extract(), &expected.extract()) < 1e-6);
        assert!(active.undo(&context));
        assert!(active.extract() == at(&built, Cut::FINEST).extract());
        let extents = Extents::new(&built);
        let mut fresh = ActiveMesh::new(&built);
        for mesh in [&mut viewed, &mut fresh] {
            mesh.adapt_to(&context, &view, &extents).unwrap();
        }
        assert!(viewed.extract() == fresh.extract());
    }
}

#[test]
fn damaged_beginnings_are_refused_and_what_is_in_use_stays() {
    let context = Context::serial();
    let built = plain();
    let bytes = written(&built);
    let mut random = Random(11);
    for round in 0..60 {
        let mut file = bytes.clone();
        let place = match round % 3 {
            0 => round,
            _ => (random.unit() * file.len() as f32) as usize % file.len(),
        };
        file[place] ^= 1 << (round % 8);
        let (mut arrival, mut in_use) = (Arrival::new(&context), None);
        let mut refused = false;
        for piece in file.chunks(40_000) {
            if arrival.push(&context, piece).is_err() {
                refused = true;
                break;
            }
            in_use = arrival.mesh().cloned().or(in_use);
        }
        assert!(refused, "{place}");
        assert!(arrival.mesh().is_none() && !arrival.is_complete());
        assert!(arrival.push(&context, &bytes).is_err());
        if let Some(mesh) = in_use {
            let active = at(&mesh, Cut::FINEST);
            assert!(active.extract() == at(&built, Cut::of_faces(&built, active.triangle_count())).extract());
        }
    }
}
