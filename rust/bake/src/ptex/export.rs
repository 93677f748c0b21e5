//! From a channel to a Ptex file.

use half::f16;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Mesh, Progress, Result};
use relievo_ptex::{Borders, DataType, EdgeFilter, Format, MeshType, MetaValue, Resolution, Writer};
use relievo_tiles::texel::Vector;
use relievo_tiles::{Field, Rgba8, Rgba16, Texel};

use super::{COLOR, COLOR_SPACE, DEFAULT, DISPLACEMENT, KIND, UNITS, VECTOR, adjacency};
use crate::prefilter;

/// A texel that Ptex files hold.
pub trait PtexTexel: Texel {
    /// The type of its numbers.
    const DATA_TYPE: DataType;
    /// Its numbers.
    const CHANNELS: u16;
    /// The one that is coverage.
    const ALPHA: Option<u16>;
    /// What it is, its units and its colour space, in meta data.
    const MEANING: [&str; 3];

    /// How filters take its values across edges.
    const EDGES: EdgeFilter = EdgeFilter::None;

    /// The texels of a file for a block of `size`² texels and their ring.
    fn encode(block: &[Self], size: usize) -> Vec<u8>;
}

impl PtexTexel for f16 {
    const DATA_TYPE: DataType = DataType::F16;
    const CHANNELS: u16 = 1;
    const ALPHA: Option<u16> = None;
    const MEANING: [&str; 3] = [DISPLACEMENT, "object units", "none"];

    fn encode(block: &[Self], size: usize) -> Vec<u8> {
        DataType::F16.encode(&prefilter::values(block, size))
    }
}

impl PtexTexel for Vector {
    const DATA_TYPE: DataType = DataType::F16;
    const CHANNELS: u16 = 3;
    const ALPHA: Option<u16> = None;
    const MEANING: [&str; 3] = [VECTOR, "object units", "none"];
    const EDGES: EdgeFilter = EdgeFilter::TangentVector;

    fn encode(block: &[Self], size: usize) -> Vec<u8> {
        DataType::F16.encode(&prefilter::values(block, size))
    }
}

impl PtexTexel for Rgba8 {
    const DATA_TYPE: DataType = DataType::U8;
    const CHANNELS: u16 = 4;
    const ALPHA: Option<u16> = Some(3);
    const MEANING: [&str; 3] = [COLOR, "none", "sRGB"];

    fn encode(block: &[Self], size: usize) -> Vec<u8> {
        inside(block, size)
    }
}

impl PtexTexel for Rgba16 {
    const DATA_TYPE: DataType = DataType::F16;
    const CHANNELS: u16 = 4;
    const ALPHA: Option<u16> = Some(3);
    const MEANING: [&str; 3] = [COLOR, "none", "linear Rec.709"];

    fn encode(block: &[Self], size: usize) -> Vec<u8> {
        inside(block, size)
    }
}

/// The bytes of a block without its ring.
fn inside<T: Texel>(block: &[T], size: usize) -> Vec<u8> {
    let rows = block.chunks_exact(size + 2).skip(1).take(size);
    rows.flat_map(|row| bytemuck::cast_slice::<T, u8>(&row[1..=size])).copied().collect()
}

/// The channel as a Ptex file, with the `mesh` that it lies on.
///
/// # Errors
/// Fails with `Invalid` if the mesh has other faces than the channel, or a face is none that the format can hold.
pub fn to_ptex<T: PtexTexel>(context: &Context, mesh: &Mesh, field: &Field<T>) -> Result<Writer> {
    to_ptex_watched(context, mesh, field, &mut Silent)
}

/// As [`to_ptex`], telling `progress`.
///
/// # Errors
/// Fails as [`to_ptex`] does, and with `Cancelled` if `progress` asks to stop.
pub fn to_ptex_watched<T: PtexTexel>(
    context: &Context,
    mesh: &Mesh,
    field: &Field<T>,
    progress: &mut dyn Progress,
) -> Result<Writer> {
    let topology = field.topology();
    if mesh.face_count() != topology.face_count() {
        let (faces, expected) = (mesh.face_count(), topology.face_count());
        return Err(Error::invalid(format!("the mesh has {faces} faces and the channel {expected}")));
    }
    let format = Format { mesh: MeshType::Quad, data_type: T::DATA_TYPE, channels: T::CHANNELS, alpha: T::ALPHA };
    let borders = Borders { edge_filter: T::EDGES, ..Borders::default() };
    let mut writer = Writer::new(format, borders, field.tile_count() as u32)?;
    let blank = bytemuck::bytes_of(&field.blank()).to_vec();
    writer.set_all_watched(context, progress, |tile| {
        let size = field.size(tile) as usize;
        let face = adjacency::face(topology, tile, power(size));
        Ok(match field.block(tile) {
            Some(block) => (face, T::encode(block, size)),
            None => (face, blank.repeat(size * size)),
        })
    })?;
    for (key, text) in [KIND, UNITS, COLOR_SPACE].into_iter().zip(T::MEANING) {
        writer.set_meta(key, MetaValue::Text(text.into()));
    }
    writer.set_meta(DEFAULT, MetaValue::F32(T::DATA_TYPE.decode(&blank)));
    set_mesh(&mut writer, mesh);
    Ok(writer)
}

/// The resolution of `size` × `size` texels.
fn power(size: usize) -> Resolution {
    let power = size.ilog2() as u8;
    Resolution::new(power, power)
}

/// Stores the mesh by the keys of the format's list.
fn set_mesh(writer: &mut Writer, mesh: &Mesh) {
    let whole = |values: &[u32]| MetaValue::I32(values.iter().map(|value| *value as i32).collect());
    writer.set_meta("PtexFaceVertCounts", whole(&mesh.face_sizes));
    writer.set_meta("PtexFaceVertIndices", whole(&mesh.corners));
    writer.set_meta("PtexVertPositions", MetaValue::F32(mesh.points.as_flattened().to_vec()));
}
