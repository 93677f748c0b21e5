//! Meshes and level sets that the server makes.

use relievo_client::{Client, SurfaceForm};
use relievo_core::progress::Silent;
use relievo_core::{Context, ErrorKind, Result};
use relievo_fluid::{Surface, SurfaceFunction};

use super::{DAM, connect, fetched, options, scene, start};

fn surface(client: &mut Client, form: SurfaceForm, settings: &str) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let write = |part: &[u8]| {
        bytes.extend_from_slice(part);
        Ok(())
    };
    client.surface(("dam", 6), (form, settings), &mut Silent, write)?;
    Ok(bytes)
}

#[test]
fn a_mesh_of_the_server_is_that_of_the_frame_s_particles() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    client.submit(&scene("dam", DAM)).unwrap();
    assert_eq!(client.wait("dam", 6, &mut Silent).unwrap().ready, 7);
    let bytes = surface(&mut client, SurfaceForm::Mesh, "").unwrap();
    let mesh = relievo_meshio::read_ply(&bytes, 1 << 30).unwrap().into_merged_mesh(&Context::serial()).unwrap();
    let context = Context::serial();
    let particles = relievo_particleio::read_frame(&context, &fetched(&mut client, "dam", 6)).unwrap().particles;
    let of = Surface::new(&context, &particles.points, SurfaceFunction::zhu_bridson(0.025)).unwrap();
    let local = relievo_fluid::mesh(&context, &of, 0.025, &[], &mut Silent).unwrap();
    assert_eq!((&mesh.points, &mesh.corners), (&local.points, &local.corners));
    assert!(mesh.face_count() > 200 && mesh.attributes.iter().any(|it| it.name == "velocity" && it.width == 3));

    // Coarser cells make fewer triangles, and a server started anew has the file already.
    let coarse = surface(&mut client, SurfaceForm::Mesh, "cell = 1.0").unwrap();
    assert!(coarse.len() < bytes.len() / 2);
    let count = |folder: &std::path::Path| relievo_server::Store::look(folder).unwrap().size().1;
    assert_eq!(count(folder.path()), 7 + 2);
    drop((client, server));
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    assert!(surface(&mut client, SurfaceForm::Mesh, "").unwrap() == bytes);
    assert_eq!(count(folder.path()), 7 + 2);

    let level_set = surface(&mut client, SurfaceForm::LevelSet, "function = \"density\"").unwrap();
    assert!(level_set.starts_with(b" BDV"), "OpenVDB's magic number");
    let wrong = ["cell = 0.001", "cells = 1", "cell", "function = \"none\"", "smooth = 1000", &"#".repeat(5000)];
    for settings in wrong {
        assert_eq!(surface(&mut client, SurfaceForm::Mesh, settings).unwrap_err().kind, ErrorKind::Invalid);
    }
    let smoothed = surface(&mut client, SurfaceForm::LevelSet, "smooth = 1");
    assert_eq!(smoothed.unwrap_err().kind, ErrorKind::Unsupported);
    assert_eq!(std::fs::read_dir(folder.path().join("unfinished")).unwrap().count(), 0);
}

#[test]
fn a_damaged_mesh_is_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(options(folder.path()));
    let mut client = connect(&server);
    client.submit(&scene("dam", DAM)).unwrap();
    client.wait("dam", 6, &mut Silent).unwrap();
    let files = |folder: &std::path::Path| -> std::collections::BTreeSet<std::path::PathBuf> {
        let list = |folder: &std::path::Path| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        list(&folder.join("frames")).flat_map(|folder| list(&folder).collect::<Vec<_>>()).collect()
    };
    let frames = files(folder.path());
    let whole = surface(&mut client, SurfaceForm::Mesh, "").unwrap();
    let all = files(folder.path());
    let mesh = all.difference(&frames).next().unwrap();
    let mut bytes = std::fs::read(mesh).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(mesh, bytes).unwrap();
    assert!(surface(&mut client, SurfaceForm::Mesh, "").unwrap() == whole);
    assert!(relievo_server::Store::look(folder.path()).unwrap().verify(false).unwrap().is_empty());
}
