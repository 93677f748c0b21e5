//! Any points and indices as a mesh: it is refused, or repaired to an oriented manifold, the same on one thread and on two.
#![no_main]

use std::collections::HashMap;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use relievo_core::parameter::Switch;
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, ContextOptions, Domain, Mesh, Values};
use relievo_fuzz::MEMORY_LIMIT;
use relievo_repair::{RepairSettings, Repaired, check, repair};

/// Points that faces choose from, a few places on a lattice so that they coincide often.
const POINTS: usize = 48;

static CONTEXTS: LazyLock<[Context; 2]> = LazyLock::new(|| {
    [1, 2].map(|threads| {
        Context::new(&ContextOptions { threads, memory_limit: MEMORY_LIMIT }).expect("two threads can be started")
    })
});

fuzz_target!(|data: &[u8]| {
    let Some(([first, second], rest)) = data.split_first_chunk::<2>() else { return };
    let (places, faces) = rest.split_at(rest.len().min(POINTS));
    let mesh = mesh(places, faces);
    let switch = |bit: u8| if first >> bit & 1 == 0 { Switch::ON } else { Switch::OFF };
    let settings = RepairSettings {
        weld: switch(0),
        degenerate: switch(1),
        duplicates: switch(2),
        orient: switch(3),
        split: switch(4),
        fill: switch(5),
        refine: switch(6),
        unused: switch(7),
        tolerance: if second & 1 == 0 { 0.0 } else { 0.7 },
        hole_area: if second & 2 == 0 { 0.75 } else { 1e9 },
        hole_edges: if second & 4 == 0 { 0 } else { 4 },
        ..RepairSettings::default()
    };
    let [one, two] = &*CONTEXTS;
    let found = check(one, &mesh, &settings, &mut Silent).expect("sizes fit");
    let Ok(made) = repair(one, &mesh, &settings, &mut Silent) else { return };
    let again = repair(two, &mesh, &settings, &mut Silent).expect("it was repaired before");
    assert_eq!((&made.mesh, &made.report), (&again.mesh, &again.report));
    assert_eq!(found.before, made.report.before);
    examine(&made);
    if [settings.weld, settings.degenerate, settings.duplicates, settings.orient, settings.split].map(Switch::is_on)
        == [true; 5]
    {
        made.mesh.check().expect("a mesh that can be used");
        assert_manifold(&made.mesh);
    }
});

/// A mesh with values on everything: each byte of `places` is a point, each of `faces` a corner or the end of a face.
fn mesh(places: &[u8], faces: &[u8]) -> Mesh {
    let place = |byte: &u8| match byte {
        254 => [f32::NAN; 3],
        255 => [f32::INFINITY; 3],
        _ => [byte & 3, byte >> 2 & 3, byte >> 4].map(|step| f32::from(step) * 0.5),
    };
    let mut mesh = Mesh { points: places.iter().map(place).collect(), ..Mesh::default() };
    let mut size = 0;
    for byte in faces {
        if byte & 0x40 == 0 || size == 0 {
            mesh.corners.push(u32::from(byte & 0x3f));
            size += 1;
        }
        if size == 3 && byte & 0x80 == 0 || byte & 0x40 != 0 {
            mesh.face_sizes.push(size);
            size = 0;
        }
    }
    if size > 0 {
        mesh.face_sizes.push(size);
    }
    let (corner_count, face_count) = (mesh.corners.len(), mesh.face_count() as u32);
    let mut add = |name: &str, domain: Domain, width: u32, values: Values| {
        mesh.attributes.push(Attribute { name: name.into(), domain, width, values, indices: None });
    };
    add("uv", Domain::Point, 2, Values::F32((0..2 * places.len()).map(|it| it as f32).collect()));
    add("normal", Domain::Corner, 3, Values::F32(vec![0.5; 3 * corner_count]));
    add("material", Domain::Face, 1, Values::U32((0..face_count).collect()));
    mesh
}

/// Fails if an index is out of range or an attribute has not a value for each element.
fn examine(made: &Repaired) {
    let mesh = &made.mesh;
    assert_eq!(made.point_origins.len(), mesh.points.len());
    assert_eq!(made.face_origins.len(), mesh.face_count());
    assert!(mesh.corners.iter().all(|point| (*point as usize) < mesh.points.len()));
    for attribute in &mesh.attributes {
        let elements = match attribute.domain {
            Domain::Point => mesh.points.len(),
            Domain::Corner => mesh.corners.len(),
            Domain::Face => mesh.face_count(),
        };
        let values = attribute.values.len() / attribute.width as usize;
        match &attribute.indices {
            Some(indices) => assert!(indices.len() == elements && indices.iter().all(|it| (*it as usize) < values)),
            None => assert_eq!(values, elements),
        }
    }
}

/// Fails unless no directed edge occurs twice and the corners of each point are one chain or ring.
fn assert_manifold(mesh: &Mesh) {
    let mut edges = HashMap::new();
    let mut fans: HashMap<u32, HashMap<u32, u32>> = HashMap::new();
    for face in mesh.faces() {
        for (at, point) in face.iter().enumerate() {
            let (next, last) = (face[(at + 1) % face.len()], face[(at + face.len() - 1) % face.len()]);
            assert_eq!(edges.insert((*point, next), ()), None, "an edge occurs twice");
            fans.entry(*point).or_default().insert(next, last);
        }
    }
    for fan in fans.values() {
        let start = fan.keys().find(|next| !fan.values().any(|last| last == *next)).or(fan.keys().next());
        let (mut at, mut steps) = (*start.expect("a face"), 0);
        while let Some(last) = fan.get(&at) {
            (at, steps) = (*last, steps + 1);
            if Some(&at) == start {
                break;
            }
        }
        assert_eq!(steps, fan.len(), "a point has more than one fan");
    }
}
