//! Any mesh a host may hand over as a cage: it is refused, or it is a surface that can be evaluated everywhere.
#![no_main]

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use libfuzzer_sys::fuzz_target;
use relievo_core::Context;
use relievo_core::mesh::{Attribute, Crease, Domain, Mesh, Values};
use relievo_surface::{BoundaryRule, Grid, Order, Placement, Samples, Surface, SurfaceOptions};

/// A sheet of quads, a fan of quads around a point, or loose faces, then spoilt: most meshes can still be refined.
fn mesh(bytes: &mut Unstructured) -> Result<Mesh> {
    let mut faces: Vec<Vec<u32>> = Vec::new();
    match bytes.int_in_range(0..=2)? {
        0 => {
            let (columns, rows) = (bytes.int_in_range(1..=4)?, bytes.int_in_range(1..=4)?);
            for at in (0..rows).flat_map(|row| (0..columns).map(move |column| row * (columns + 1) + column)) {
                faces.push(vec![at, at + 1, at + columns + 2, at + columns + 1]);
            }
        }
        1 => {
            let valence = bytes.int_in_range(2..=20)?;
            let rim = |index: u32| 1 + index % (2 * valence);
            faces.extend((0..valence).map(|face| vec![0, rim(2 * face), rim(2 * face + 1), rim(2 * face + 2)]));
        }
        _ => {}
    }
    for _ in 0..bytes.int_in_range(0..=4)? {
        let size = bytes.int_in_range(0..=6)?;
        faces.push((0..size).map(|_| bytes.int_in_range(0..=25)).collect::<Result<_>>()?);
    }
    if bytes.arbitrary()? && !faces.is_empty() {
        let last = faces.len() - 1;
        faces.remove(bytes.int_in_range(0..=last)?);
    }
    let count = 1 + faces.iter().flatten().copied().max().unwrap_or(0) - u32::from(bytes.ratio(1, 16)?);
    let mut mesh = Mesh::default();
    for _ in 0..count {
        mesh.points.push([coordinate(bytes)?, coordinate(bytes)?, coordinate(bytes)?]);
    }
    mesh.face_sizes = faces.iter().map(|face| face.len() as u32).collect();
    if bytes.ratio(1, 32)? {
        mesh.face_sizes.push(bytes.arbitrary()?);
    }
    for _ in 0..bytes.int_in_range(0..=4)? {
        let points = match faces.first() {
            Some(_) if bytes.ratio(7, 8)? => {
                let face = bytes.choose(&faces)?;
                let corner = bytes.int_in_range(0..=face.len())?;
                [corner, corner + 1].map(|corner| face.get(corner % face.len().max(1)).copied().unwrap_or(0))
            }
            _ => [bytes.int_in_range(0..=25)?, bytes.int_in_range(0..=25)?],
        };
        mesh.creases.push(Crease { points, sharpness: sharpness(bytes)? });
    }
    for _ in 0..bytes.int_in_range(0..=2)? {
        mesh.sharp_points.push((bytes.int_in_range(0..=10)?, sharpness(bytes)?));
        mesh.holes.push(bytes.int_in_range(0..=8)?);
    }
    mesh.corners = faces.concat();
    if bytes.ratio(1, 8)? {
        let domain = *bytes.choose(&[Domain::Point, Domain::Corner, Domain::Face])?;
        let width = bytes.int_in_range(0..=5)?;
        let values = Values::U32(vec![0; bytes.int_in_range(0..=100)?]);
        let indices = if bytes.arbitrary()? { Some(vec![bytes.arbitrary()?; mesh.corners.len()]) } else { None };
        mesh.attributes.push(Attribute { name: "uv".into(), domain, width, values, indices });
    }
    Ok(mesh)
}

fn coordinate(bytes: &mut Unstructured) -> Result<f32> {
    if bytes.ratio(1, 255)? { bytes.arbitrary() } else { Ok(f32::from(bytes.arbitrary::<i8>()?) / 8.0) }
}

fn sharpness(bytes: &mut Unstructured) -> Result<f32> {
    if bytes.ratio(1, 16)? { bytes.arbitrary() } else { Ok(f32::from(bytes.int_in_range(0..=44_u8)?) / 4.0) }
}

fn options(bytes: &mut Unstructured) -> Result<SurfaceOptions> {
    let boundary = *bytes.choose(&[BoundaryRule::Edges, BoundaryRule::EdgesAndCorners])?;
    Ok(SurfaceOptions { boundary, isolation: bytes.int_in_range(0..=7)?, patch_limit: 20_000 })
}

fuzz_target!(|data: &[u8]| {
    let mut bytes = Unstructured::new(data);
    let (Ok(options), Ok(mesh)) = (options(&mut bytes), mesh(&mut bytes)) else { return };
    let context = Context::serial();
    let Ok(surface) = Surface::new(&context, &mesh, &options) else { return };
    let mut samples = Samples::default();
    for tile in 0..surface.tile_count() as u32 {
        surface.grid(context.level(), tile, &Grid::whole(5, Placement::Lattice), Order::Second, &mut samples);
        let (low, high) = surface.tile_bounds(tile);
        assert!((0..3).all(|axis| low[axis] <= high[axis] || !low[axis].is_finite() || !high[axis].is_finite()));
    }
});
