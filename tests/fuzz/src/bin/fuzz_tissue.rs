//! Any bytes as a model of soft tissue, a state, an Abaqus file and a scan: refused, or a model that can be written, read and
//! simulated. Sums of models and states are made right, so that what is behind them is read.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use relievo_core::{Context, ContextOptions};
use relievo_fuzz::MEMORY_LIMIT;
use relievo_tissue::{Labels, Material, Model, Range, SavedState, Scan, Simulation, SimulationOptions};

/// Bytes before those that the sum is of.
const HEAD: usize = 24;
/// Elements and nodes of models that are simulated.
const MAX: usize = 2000;

fn gel() -> Material {
    Material { name: "gel".into(), density: 1000.0, shear: 1000.0, bulk: 1e4 }
}

static SOUND: LazyLock<Vec<u8>> =
    LazyLock::new(|| Model::block([0.0; 3], [0.1; 3], [2, 2, 1], gel()).expect("a block").encode()[HEAD..].to_vec());

fuzz_target!(|data: &[u8]| {
    let [kind, data @ ..] = data else { return };
    match kind % 5 {
        0 => model(&sealed(b"RTISSUE\0", data)),
        1 => model(&sealed(b"RTISSUE\0", &changed(data))),
        2 => drop(SavedState::decode(&sealed(b"RTSTATE\0", data))),
        3 => {
            let Ok(text) = std::str::from_utf8(data) else { return };
            if let Ok(read) = Model::of_inp(text) {
                sound(read.model);
            }
        }
        _ => scan(data),
    }
});

/// A file with a right sum.
fn sealed(name: &[u8; 8], bytes: &[u8]) -> Vec<u8> {
    let mut file = name.to_vec();
    file.extend(1u32.to_le_bytes());
    file.extend((bytes.len() as u64).to_le_bytes());
    file.extend(crc32fast::hash(bytes).to_le_bytes());
    file.extend(bytes);
    file
}

/// A sound model with some bytes changed: two that give the place, one what it becomes.
fn changed(changes: &[u8]) -> Vec<u8> {
    let mut bytes = SOUND.clone();
    for change in changes.as_chunks::<3>().0 {
        let place = usize::from(u16::from_le_bytes([change[0], change[1]])) % bytes.len();
        bytes[place] = change[2];
    }
    bytes
}

fn model(bytes: &[u8]) {
    if let Ok(model) = Model::decode(bytes) {
        sound(model);
    }
}

fn sound(model: Model) {
    model.check().expect("readers check models");
    let again = Model::decode(&model.encode()).expect("what was written is read");
    assert_eq!(again.encode(), model.encode());
    let _ = model.to_inp();
    if model.nodes.len() > MAX || model.elements.len() > MAX {
        return;
    }
    let context = Context::new(&ContextOptions { threads: 1, memory_limit: MEMORY_LIMIT }).expect("one thread");
    let options = SimulationOptions { self_friction: Some(0.5), halvings: 1, ..SimulationOptions::default() };
    if let Ok(mut simulation) = Simulation::new(model, &options) {
        let _ = simulation.advance(&context, 2, &mut relievo_core::progress::Silent);
        let _ = simulation.element_states(&context);
    }
}

fn scan(data: &[u8]) {
    let Ok(scan) = Scan::decode(data, MEMORY_LIMIT) else { return };
    assert_eq!(scan.values.len(), scan.counts.iter().product::<usize>());
    let labels = Labels {
        block: 2,
        share: 0.1,
        materials: vec![gel()],
        ranges: vec![Range { material: 0, low: 1.0, high: f32::MAX }],
    };
    if scan.values.len() < 1 << 16
        && let Ok((model, _)) = labels.build(&Context::serial(), &scan)
    {
        sound(model);
    }
}
