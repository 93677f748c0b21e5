//! The two headers in front of a Ptex file, field by field (file format 1.3 and 1.4).

use relievo_core::{Error, Result};

use crate::fields::{Fields, damaged, section};
use crate::format::{BorderMode, Borders, DataType, EdgeFilter, Format, MeshType};

const MAGIC: &[u8; 4] = b"Ptex";
const MAJOR: u32 = 1;
/// The minor version that is written: with an edge filter.
const MINOR: u32 = 4;
const NO_ALPHA: u32 = u32::MAX;

/// The first header: what is in the file, and the sizes of its blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    pub format: Format,
    pub levels: u16,
    pub faces: u32,
    pub extended: u32,
    pub face_info: u32,
    pub constants: u32,
    pub level_info: u32,
    pub level_data: u64,
    pub meta_zipped: u32,
    pub meta: u32,
}

impl Header {
    pub const SIZE: usize = 64;

    pub fn read(bytes: &[u8]) -> Result<Self> {
        if !bytes.starts_with(MAGIC) {
            return Err(Error::invalid("the file does not begin with `Ptex`").advise("name a Ptex file"));
        }
        let mut fields = Fields::new(section(bytes, 0, Self::SIZE as u64, "the header")?, 0);
        fields.take(MAGIC.len())?;
        let version = fields.u32()?;
        if version != MAJOR {
            return Err(Error::unsupported(format!("the file is of version {version}"))
                .at("byte 4")
                .advise("save it in version 1"));
        }
        let mesh = match fields.u32()? {
            0 => MeshType::Triangle,
            1 => MeshType::Quad,
            other => return Err(damaged(format!("there is no mesh type {other}"), 8)),
        };
        let data_type = match fields.u32()? {
            0 => DataType::U8,
            1 => DataType::U16,
            2 => DataType::F16,
            3 => DataType::F32,
            other => return Err(damaged(format!("there is no data type {other}"), 12)),
        };
        let alpha = match fields.u32()? {
            NO_ALPHA => None,
            channel => Some(
                u16::try_from(channel).map_err(|_| damaged(format!("there is no channel {channel} for alpha"), 16))?,
            ),
        };
        let format = Format { mesh, data_type, channels: fields.u16()?, alpha };
        format.check().map_err(|error| error.at("byte 16"))?;
        let levels = fields.u16()?;
        let [faces, extended, face_info, constants, level_info] =
            [fields.u32()?, fields.u32()?, fields.u32()?, fields.u32()?, fields.u32()?];
        // The minor version says nothing that the extended header does not.
        fields.u32()?;
        let level_data = fields.u64()?;
        let (meta_zipped, meta) = (fields.u32()?, fields.u32()?);
        Ok(Self { format, levels, faces, extended, face_info, constants, level_info, level_data, meta_zipped, meta })
    }

    pub fn write(&self, out: &mut Vec<u8>) {
        out.extend(MAGIC);
        let mesh = match self.format.mesh {
            MeshType::Triangle => 0u32,
            MeshType::Quad => 1,
        };
        let data_type = match self.format.data_type {
            DataType::U8 => 0u32,
            DataType::U16 => 1,
            DataType::F16 => 2,
            DataType::F32 => 3,
        };
        let alpha = self.format.alpha.map_or(NO_ALPHA, u32::from);
        out.extend([MAJOR, mesh, data_type, alpha].iter().flat_map(|field| field.to_le_bytes()));
        out.extend([self.format.channels, self.levels].iter().flat_map(|field| field.to_le_bytes()));
        let sizes = [self.faces, self.extended, self.face_info, self.constants, self.level_info, MINOR];
        out.extend(sizes.iter().flat_map(|field| field.to_le_bytes()));
        out.extend(self.level_data.to_le_bytes());
        out.extend([self.meta_zipped, self.meta].iter().flat_map(|field| field.to_le_bytes()));
    }
}

/// The second header, which older files have a part of or lack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ExtendedHeader {
    pub borders: Borders,
    pub large_zipped: u32,
    pub large: u32,
    pub large_data: u64,
    pub edits: u64,
    /// 0 in files before 1.3.
    pub edits_at: u64,
}

impl ExtendedHeader {
    pub const SIZE: usize = 40;

    /// Reads it from the `length` bytes that the file gives it; what it lacks is zero.
    pub fn read(bytes: &[u8], length: u32) -> Result<Self> {
        let stored = section(bytes, Header::SIZE as u64, u64::from(length), "the extended header")?;
        let mut padded = [0; Self::SIZE];
        padded.iter_mut().zip(stored).for_each(|(to, from)| *to = *from);
        let mut fields = Fields::new(&padded, Header::SIZE as u64);
        let u = border(&mut fields)?;
        // The documented field has four bytes, of which two are used.
        fields.u16()?;
        let v = border(&mut fields)?;
        let edge_filter = match fields.u16()? {
            0 => EdgeFilter::None,
            1 => EdgeFilter::TangentVector,
            other => return Err(damaged(format!("there is no edge filter mode {other}"), 70)),
        };
        Ok(Self {
            borders: Borders { u, v, edge_filter },
            large_zipped: fields.u32()?,
            large: fields.u32()?,
            large_data: fields.u64()?,
            edits: fields.u64()?,
            edits_at: fields.u64()?,
        })
    }

    pub fn write(&self, out: &mut Vec<u8>) {
        let mode = |mode| match mode {
            BorderMode::Clamp => 0u16,
            BorderMode::Black => 1,
            BorderMode::Periodic => 2,
        };
        let edge_filter = match self.borders.edge_filter {
            EdgeFilter::None => 0u16,
            EdgeFilter::TangentVector => 1,
        };
        let modes = [mode(self.borders.u), 0, mode(self.borders.v), edge_filter];
        out.extend(modes.iter().flat_map(|field| field.to_le_bytes()));
        out.extend([self.large_zipped, self.large].iter().flat_map(|field| field.to_le_bytes()));
        out.extend([self.large_data, self.edits, self.edits_at].iter().flat_map(|field| field.to_le_bytes()));
    }
}

fn border(fields: &mut Fields) -> Result<BorderMode> {
    let offset = fields.offset();
    match fields.u16()? {
        0 => Ok(BorderMode::Clamp),
        1 => Ok(BorderMode::Black),
        2 => Ok(BorderMode::Periodic),
        other => Err(damaged(format!("there is no border mode {other}"), offset)),
    }
}
