//! Files of models and states.

use std::path::Path;

use relievo_core::Context;
use relievo_core::progress::Silent;
use relievo_tissue::{
    Binding, Fibre, Held, Model, Muscle, NodeSet, SavedState, Shape, Simulation, SimulationOptions, Sliding,
};

use crate::bodies::{block, gel};

fn model() -> Model {
    let mut model = block([0.2, 0.1, 0.1], [2, 1, 1], gel());
    model.muscles.push(Muscle { name: "belly".into(), stiffness: 10.0, strength: 20.0 });
    model.fibres = Default::default();
    model.fibres.push([Fibre { muscle: 0, share: 0.5, direction: [0.0, 1.0, 0.0] }]);
    model.fibres.push([]);
    model.held.push(Held { node: 3, axes: 5 });
    model.surfaces.push(Shape {
        name: "bone".into(),
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
    });
    model.sliding.push(Sliding { node: 1, surface: 0, distance: 0.0 });
    model.sets.push(NodeSet { name: "end".into(), nodes: vec![0, 3] });
    let points = [[0.0, 0.05, 0.1], [0.1, 0.05, 0.1], [0.15, 0.0, 0.2]];
    model.bindings.push(Binding::new(&Context::serial(), &model, "skin", &points, &[[0, 1, 2]]).unwrap());
    model
}

#[test]
fn a_model_is_read_as_it_was_written_and_damage_is_refused() {
    let bytes = model().encode();
    assert_eq!(Model::decode(&bytes).unwrap(), model());
    for length in 0..bytes.len() {
        assert!(Model::decode(&bytes[..length]).is_err());
    }
    for at in 0..bytes.len() {
        let mut spoilt = bytes.clone();
        spoilt[at] ^= 1 << (at % 8);
        assert!(Model::decode(&spoilt).is_err(), "byte {at}");
    }
}

#[test]
fn counts_that_lie_are_refused_without_memory() {
    let mut bytes = model().encode();
    bytes[24..32].copy_from_slice(&u64::MAX.to_le_bytes());
    let checksum = crc32fast::hash(&bytes[24..]);
    bytes[20..24].copy_from_slice(&checksum.to_le_bytes());
    assert!(Model::decode(&bytes).unwrap_err().to_string().contains("damaged"));
    bytes[8] = 9;
    assert!(Model::decode(&bytes).unwrap_err().to_string().contains("version is 9"));
}

#[test]
fn damage_behind_right_sums_is_refused_or_can_be_simulated() {
    let context = Context::serial();
    let sound = model().encode();
    let text = model().to_inp();
    let alphabet = b"0123456789-.,*eE\n\0 ";
    let mut random = 7u64;
    let mut next = move |below: usize| {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (random >> 33) as usize % below
    };
    let mut simulated = 0;
    for _ in 0..4000 {
        let mut bytes = sound.clone();
        let mut letters = text.clone().into_bytes();
        for _ in 0..=next(3) {
            let at = 24 + next(bytes.len() - 24);
            bytes[at] = [0, 1, 0x7f, 0x80, 0xff, next(256) as u8][next(6)];
            let at = next(letters.len());
            letters[at] = alphabet[next(alphabet.len())];
        }
        let sum = crc32fast::hash(&bytes[24..]);
        bytes[20..24].copy_from_slice(&sum.to_le_bytes());
        let read = [
            Model::decode(&bytes).ok(),
            std::str::from_utf8(&letters).ok().and_then(|text| Model::of_inp(text).ok()).map(|read| read.model),
        ];
        for model in read.into_iter().flatten() {
            model.check().unwrap();
            let options = SimulationOptions { self_friction: Some(0.1), halvings: 1, ..SimulationOptions::default() };
            if let Ok(mut simulation) = Simulation::new(model, &options) {
                let _ = simulation.advance(&context, 2, &mut Silent);
                let _ = simulation.element_states(&context);
                simulated += 1;
            }
        }
    }
    assert!(simulated > 100, "{simulated}");
}

#[test]
fn a_state_file_resumes_to_the_bit() {
    let context = Context::serial();
    let folder = tempfile::tempdir().unwrap();
    let (model_path, path) = (folder.path().join("a.rtissue"), folder.path().join("a.rtstate"));
    model().write(&model_path).unwrap();
    let options = SimulationOptions { gravity: [0.0, 0.0, -0.5], ..SimulationOptions::default() };
    let begin = || Simulation::new(Model::read(&context, &model_path).unwrap(), &options).unwrap();
    let mut whole = begin();
    whole.advance(&context, 40, &mut Silent).unwrap();
    let saved =
        SavedState { identity: model().checksum(), level: context.level().name().into(), state: whole.state().clone() };
    saved.write(&path).unwrap();
    whole.advance(&context, 40, &mut Silent).unwrap();
    let read = SavedState::read(&context, &path).unwrap();
    assert_eq!(read, saved);
    let mut resumed = begin();
    resumed.set_state(read.state).unwrap();
    resumed.advance(&context, 40, &mut Silent).unwrap();
    assert_eq!(resumed.state(), whole.state());
    let bytes = saved.encode();
    assert!((0..bytes.len()).all(|length| SavedState::decode(&bytes[..length]).is_err()));
    let mut other = begin();
    assert!(other.set_state(Default::default()).is_err());
}

#[test]
fn an_abaqus_file_is_read_as_it_was_written() {
    let text = model().to_inp();
    let read = Model::of_inp(&text).unwrap();
    assert_eq!(read.notes, Vec::<String>::new());
    let (written, read) = (model(), read.model);
    assert_eq!((&read.nodes, &read.elements), (&written.nodes, &written.elements));
    assert_eq!(read.sets[0].nodes, written.sets[0].nodes);
    let axes: u32 = read.held.iter().filter(|held| held.node == 3).map(|held| held.axes).sum();
    assert_eq!(axes, 5);
    let [ours, theirs] = [&written.materials[0], &read.materials[0]];
    assert!((ours.shear - theirs.shear).abs() < 1e-3 && (ours.bulk - theirs.bulk).abs() < 0.1);
}

#[test]
fn files_of_other_programs_are_read_and_lies_refused() {
    let text = "*HEADING\nA cube\n*NODE\n10, 0, 0, 0\n20, 1, 0, 0\n30, 1, 1, 0\n40, 0, 1, 0\n50, 0, 0, 1\n60, 1, 0, 1\n\
        70, 1, 1, 1\n80, 0, 1, 1\n*Element, type=C3D8R, elset=EB\n7, 10, 20, 30, 40,\n50, 60, 70, 80\n*NSET, NSET=LOW, GENERATE\n\
        10, 40, 10\n*Boundary\nLOW, 1, 3\n*Material, name=RUBBER\n*Elastic\n1e5, .3\n*Density\n900.\n\
        *Solid Section, elset=EB, material=RUBBER\n*STEP\n*DYNAMIC\n1, 2\n*END STEP\n";
    let read = Model::of_inp(text).unwrap();
    assert_eq!(read.model.elements, [[0, 1, 2, 3, 4, 5, 6, 7]]);
    assert_eq!((read.model.held.len(), read.model.held[0].axes), (4, 7));
    assert!((read.model.materials[0].young() - 1e5).abs() < 1.0 && read.model.materials[0].density == 900.0);
    assert_eq!(read.notes.len(), 4);
    for (from, to, why) in [
        ("C3D8R", "C3D10", "C3D10"),
        ("50, 60, 70, 80", "50, 60, 70, 81", "node 81"),
        ("10, 40, 10", "10, x", "not a number"),
        ("1e5, .3", "nan, .3", "not a finite number"),
        ("20, 1, 0, 0", "10, 1, 0, 0", "twice"),
        ("material=RUBBER", "material=STEEL", "STEEL"),
        ("50, 60, 70, 80", "50, 60", "fewer than eight"),
    ] {
        let error = Model::of_inp(&text.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(why), "{error} should say {why}");
    }
    assert!((0..text.len()).all(|end| Model::of_inp(&text[..end]).is_err() || end > text.find("*STEP").unwrap() - 2));
    Model::of_inp(&text.replacen("10, 40, 10", "10, 18446744073709551615, 1", 1)).unwrap();
}

#[test]
fn a_grid_for_vtk_has_what_it_announces() {
    let context = Context::serial();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vtu");
    let simulation = Simulation::new(model(), &SimulationOptions::default()).unwrap();
    let mut states = simulation.element_states(&context).unwrap();
    // xx, yy, zz, yz, zx, xy.
    states[0].stress = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let pressures: Vec<f32> = (0..12).map(|node| node as f32).collect();
    simulation.write_vtu(&path, &states, &pressures).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("NumberOfPoints=\"12\" NumberOfCells=\"2\"") && text.ends_with("</VTKFile>\n"));
    let begin = bytes.windows(16).position(|it| it == b"encoding=\"raw\">\n").unwrap() + 17;
    let mut at = begin;
    let mut lengths = Vec::new();
    for _ in 0..15 {
        let length = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        let floats = |count: usize| -> Vec<f32> {
            bytes[at + 8..at + 8 + 4 * count].as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
        };
        if lengths.len() == 2 {
            assert_eq!(floats(12), pressures);
        }
        if lengths.len() == 3 {
            assert_eq!(floats(6), [1.0, 2.0, 3.0, 6.0, 4.0, 5.0], "VTK's order: xx, yy, zz, xy, yz, xz");
        }
        lengths.push(length);
        at += 8 + length as usize;
    }
    assert_eq!(lengths, [144, 144, 48, 48, 48, 8, 24, 24, 8, 8, 8, 144, 64, 8, 2]);
}

#[test]
fn models_of_earlier_versions_are_read() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/model-1.rtissue");
    if std::env::var_os("RELIEVO_WRITE_GOLDEN").is_some() {
        model().write(&path).unwrap();
    }
    let golden = Model::read(&Context::serial(), &path).unwrap();
    assert_eq!((&golden.elements, &golden.fibres, &golden.held), (&model().elements, &model().fibres, &model().held));
    assert_eq!((&golden.surfaces, &golden.sets, &golden.sliding), (&model().surfaces, &model().sets, &model().sliding));
    let moved =
        golden.nodes.iter().zip(&model().nodes).any(|(a, b)| (0..3).any(|axis| (a[axis] - b[axis]).abs() > 1e-6));
    assert!(!moved && golden.bindings[0].anchors.len() == 3);
}
