//! What all texels of a Ptex file have in common: the type of their numbers, their channels, the mesh they lie on.

use half::f16;
use relievo_core::{Error, Result};

/// What every face is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MeshType {
    /// Triangles, packed into squares: the texels that stand on their side are folded in from the far corner.
    Triangle,
    /// Quads. Other polygons are one face per corner.
    Quad,
}

/// The type of the numbers in a file. They are little-endian.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DataType {
    /// Unsigned bytes; 255 stands for 1.
    U8,
    /// Unsigned 16-bit numbers; 65535 stands for 1.
    U16,
    /// Half floats.
    F16,
    /// Floats.
    F32,
}

impl DataType {
    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::F16 => 2,
            Self::F32 => 4,
        }
    }

    /// Name of the type, as users know it.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::U16 => "uint16",
            Self::F16 => "float16",
            Self::F32 => "float32",
        }
    }

    /// The numbers that `bytes` hold; whole numbers are scaled to 0..1.
    pub fn decode(self, bytes: &[u8]) -> Vec<f32> {
        match self {
            Self::U8 => bytes.iter().map(|value| f32::from(*value) / 255.0).collect(),
            Self::U16 => pairs(bytes).map(|value| f32::from(value) / 65535.0).collect(),
            Self::F16 => pairs(bytes).map(|value| f16::from_bits(value).to_f32()).collect(),
            Self::F32 => bytes.as_chunks().0.iter().map(|value| f32::from_le_bytes(*value)).collect(),
        }
    }

    /// The bytes of numbers. Whole numbers are clamped to 0..1 and rounded to the nearest; what is not a number
    /// becomes 0 in them.
    pub fn encode(self, values: &[f32]) -> Vec<u8> {
        match self {
            Self::U8 => values.iter().map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8).collect(),
            Self::U16 => {
                let whole = |value: &f32| ((value.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes();
                values.iter().flat_map(whole).collect()
            }
            Self::F16 => values.iter().flat_map(|value| f16::from_f32(*value).to_le_bytes()).collect(),
            Self::F32 => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }
}

fn pairs(bytes: &[u8]) -> impl Iterator<Item = u16> + '_ {
    bytes.as_chunks().0.iter().map(|pair| u16::from_le_bytes(*pair))
}

/// What filters see beyond an edge without a neighbour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BorderMode {
    /// The texels at the edge.
    #[default]
    Clamp,
    /// Zeros.
    Black,
    /// The texels at the opposite edge.
    Periodic,
}

/// How filters take values across edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum EdgeFilter {
    /// As they are.
    #[default]
    None,
    /// As vectors in the tangent frame of the face they come from.
    TangentVector,
}

/// What readers should do at edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Borders {
    /// Beyond the edges u = 0 and u = 1.
    pub u: BorderMode,
    /// Beyond the edges v = 0 and v = 1.
    pub v: BorderMode,
    /// Across edges between faces.
    pub edge_filter: EdgeFilter,
}

/// What all texels of a file have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Format {
    /// The shape of faces.
    pub mesh: MeshType,
    /// The type of every channel.
    pub data_type: DataType,
    /// Numbers of a texel, at least 1.
    pub channels: u16,
    /// The channel that is the coverage, if one is. Texels are not multiplied by it.
    pub alpha: Option<u16>,
}

impl Format {
    /// Bytes of a texel.
    pub fn texel_size(&self) -> usize {
        usize::from(self.channels) * self.data_type.size()
    }

    /// Checks that there is a channel, and that the alpha channel is one.
    ///
    /// # Errors
    /// Fails with `Invalid` if there are no channels or the alpha channel is none of them.
    pub fn check(&self) -> Result<()> {
        if self.channels == 0 {
            return Err(Error::invalid("texels have no channels").advise("store at least one"));
        }
        match self.alpha {
            Some(alpha) if alpha >= self.channels => {
                Err(Error::invalid(format!("channel {alpha} is to be alpha, but there are {}", self.channels))
                    .advise("name a channel that exists, or none"))
            }
            _ => Ok(()),
        }
    }
}

/// Powers of two of the numbers of texels along u and v.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Resolution {
    /// log2 of the texels along u.
    pub u: u8,
    /// log2 of the texels along v.
    pub v: u8,
}

impl Resolution {
    /// The largest power, along u and along v.
    pub const LARGEST: u8 = 16;

    /// 2^u by 2^v texels.
    pub fn new(u: u8, v: u8) -> Self {
        Self { u, v }
    }

    /// Texels along u.
    pub fn width(self) -> usize {
        1 << self.u.min(Self::LARGEST)
    }

    /// Texels along v.
    pub fn height(self) -> usize {
        1 << self.v.min(Self::LARGEST)
    }

    /// Texels.
    pub fn texels(self) -> u64 {
        self.width() as u64 * self.height() as u64
    }

    /// The smaller power.
    pub fn least(self) -> u8 {
        self.u.min(self.v)
    }

    /// The resolution with a half as many texels along u and v, `times` times, or `None` where that is below one.
    pub fn halved(self, times: u8) -> Option<Self> {
        Some(Self { u: self.u.checked_sub(times)?, v: self.v.checked_sub(times)? })
    }

    /// Checks that a face of `mesh` may have it.
    ///
    /// # Errors
    /// Fails with `Unsupported` above [`Resolution::LARGEST`], and with `Invalid` for triangles unless both powers are
    /// the same.
    pub fn check(self, mesh: MeshType) -> Result<()> {
        if self.u.max(self.v) > Self::LARGEST {
            return Err(Error::unsupported(format!("it has 2^{} by 2^{} texels", self.u, self.v))
                .advise(format!("use at most 2^{} along u and v", Self::LARGEST)));
        }
        if mesh == MeshType::Triangle && self.u != self.v {
            return Err(Error::invalid(format!("the triangle has 2^{} by 2^{} texels", self.u, self.v))
                .advise("use as many along u as along v"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_value_and_whole_numbers_are_clamped() {
        let values = [0.0, 1.0, -3.0, 0.5, 7.0, f32::NAN];
        assert_eq!(DataType::U8.encode(&values), [0, 255, 0, 128, 255, 0]);
        assert_eq!(DataType::U16.encode(&values[..4]), [0, 0, 255, 255, 0, 0, 0, 128]);
        for (data_type, step) in [(DataType::U8, 1.0 / 255.0), (DataType::U16, 1.0 / 65535.0)] {
            for value in [0.0, 0.2, 0.7, 1.0] {
                let back = data_type.decode(&data_type.encode(&[value]))[0];
                assert!((back - value).abs() <= 0.5001 * step, "{value} became {back}");
            }
        }
        for data_type in [DataType::F16, DataType::F32] {
            let values = [0.0, -1.5, 1024.0, f32::INFINITY];
            assert_eq!(data_type.decode(&data_type.encode(&values)), values);
        }
    }

    #[test]
    fn formats_and_resolutions_are_checked() {
        let format = Format { mesh: MeshType::Quad, data_type: DataType::U16, channels: 3, alpha: Some(2) };
        assert_eq!(format.texel_size(), 6);
        assert!(format.check().is_ok());
        assert!(Format { alpha: Some(3), ..format }.check().is_err());
        assert!(Format { channels: 0, alpha: None, ..format }.check().is_err());
        assert!(Resolution::new(16, 3).check(MeshType::Quad).is_ok());
        assert!(Resolution::new(17, 3).check(MeshType::Quad).is_err());
        assert!(Resolution::new(4, 3).check(MeshType::Triangle).is_err());
        assert_eq!(Resolution::new(4, 3).halved(3), Some(Resolution::new(1, 0)));
        assert_eq!(Resolution::new(4, 3).halved(4), None);
    }
}
