//! Any mesh a host may hand over: the check refuses it or everything that reads it afterwards is safe.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use relievo_core::mesh::{Attribute, Crease, Domain, Mesh, Values};

/// Indices are mostly small, so that a good part of the meshes pass the check.
fn mesh(bytes: &mut Unstructured) -> Result<Mesh> {
    let mut mesh = Mesh::default();
    for _ in 0..bytes.int_in_range(0..=24)? {
        mesh.points.push([bytes.arbitrary()?, bytes.arbitrary()?, bytes.arbitrary()?]);
    }
    for _ in 0..bytes.int_in_range(0..=16)? {
        let size = bytes.int_in_range(0..=6)?;
        mesh.face_sizes.push(size);
        for _ in 0..size {
            mesh.corners.push(bytes.int_in_range(0..=25)?);
        }
    }
    if bytes.ratio(1, 16)? {
        mesh.face_sizes.push(bytes.arbitrary()?);
    }
    for _ in 0..bytes.int_in_range(0..=4)? {
        let points = [bytes.int_in_range(0..=25)?, bytes.int_in_range(0..=25)?];
        mesh.creases.push(Crease { points, sharpness: bytes.arbitrary()? });
    }
    for _ in 0..bytes.int_in_range(0..=2)? {
        mesh.sharp_points.push((bytes.int_in_range(0..=25)?, bytes.arbitrary()?));
        mesh.holes.push(bytes.int_in_range(0..=17)?);
    }
    if bytes.arbitrary()? {
        let domain = *bytes.choose(&[Domain::Point, Domain::Corner, Domain::Face])?;
        let width = bytes.int_in_range(0..=5)?;
        let values = Values::U32(vec![0; bytes.int_in_range(0..=100)?]);
        let indices = if bytes.arbitrary()? { Some(vec![bytes.arbitrary()?; mesh.corners.len()]) } else { None };
        mesh.attributes.push(Attribute { name: "uv".into(), domain, width, values, indices });
    }
    Ok(mesh)
}

fuzz_target!(|data: &[u8]| {
    let Ok(mesh) = mesh(&mut Unstructured::new(data)) else { return };
    if mesh.check().is_ok() {
        assert!(mesh.triangles().iter().flatten().all(|point| (*point as usize) < mesh.points.len()));
        assert!(mesh.bounds().is_some());
    }
});
