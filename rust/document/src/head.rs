//! What a layer is apart from its blocks: number, name, kind of texel, how it is blended, sizes of its tiles.

use relievo_core::budget::Budget;
use relievo_core::{Error, Result};

use crate::code::{Decoder, Encoder};
use crate::layer::{Kind, SIZE_BITS};
use crate::topology::Topology;

/// How a layer is put on what is below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// Over what is below, by its alpha.
    Normal,
    /// Added to what is below.
    Add,
    /// Taken away from what is below.
    Subtract,
    /// The product of both.
    Multiply,
    /// The product of what both leave out.
    Screen,
    /// Multiplied where it is dark below, screened where it is light.
    Overlay,
    /// The larger of both: higher, or lighter.
    Max,
    /// The smaller of both: lower, or darker.
    Min,
}

impl Blend {
    /// All modes and what they are called, in the order of their numbers in files.
    pub const NAMES: [(Blend, &'static str); 8] = [
        (Blend::Normal, "normal"),
        (Blend::Add, "add"),
        (Blend::Subtract, "subtract"),
        (Blend::Multiply, "multiply"),
        (Blend::Screen, "screen"),
        (Blend::Overlay, "overlay"),
        (Blend::Max, "max"),
        (Blend::Min, "min"),
    ];

    /// What it is called.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize].1
    }

    /// The mode in which layers of `kind` begin: displacements add up, colours cover.
    pub fn of(kind: Kind) -> Self {
        if kind.is_color() { Blend::Normal } else { Blend::Add }
    }

    /// Whether it means anything for layers of `kind`.
    pub fn suits(self, kind: Kind) -> bool {
        match self {
            Blend::Add | Blend::Max | Blend::Min => true,
            Blend::Subtract => !kind.is_color(),
            _ => kind.is_color(),
        }
    }
}

/// How a layer takes part in what is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How much of it is seen, 0 to 1.
    pub opacity: f32,
    /// How it is put on what is below it.
    pub blend: Blend,
    /// Whether it is seen at all.
    pub visible: bool,
}

impl Settings {
    /// Seen as a whole, in the mode of its kind.
    pub fn of(kind: Kind) -> Self {
        Self { opacity: 1.0, blend: Blend::of(kind), visible: true }
    }

    /// Fails unless layers of `kind` can be seen so.
    pub fn check(&self, kind: Kind) -> Result<()> {
        if !(0.0..=1.0).contains(&self.opacity) {
            return Err(Error::invalid(format!("its opacity is {}", self.opacity)).advise("use 0 to 1"));
        }
        if !self.blend.suits(kind) {
            let suitable: Vec<&str> =
                Blend::NAMES.into_iter().filter(|(blend, _)| blend.suits(kind)).map(|(_, name)| name).collect();
            return Err(Error::invalid(format!("`{}` means nothing for {}", self.blend.name(), kind.name()))
                .advise(format!("use {}", suitable.join(", "))));
        }
        Ok(())
    }
}

/// The largest number of a layer, far enough from where numbers end to count on.
pub const MAX_ID: u32 = 1 << 30;

/// A layer apart from its blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Its number, which no other layer of the document has and which it keeps under any name.
    pub id: u32,
    /// Its name, which no other layer of the document has.
    pub name: String,
    /// What its texels are.
    pub kind: Kind,
    /// The texel that tiles without a block read as.
    pub blank: Vec<u8>,
    /// How it takes part in what is seen.
    pub settings: Settings,
    /// Of every face, texels along an edge of it. Sub-tiles have half of it, but at least 8.
    pub face_sizes: Vec<u32>,
}

impl Head {
    pub(crate) fn encode(&self, out: &mut Encoder) {
        out.text(&self.name);
        out.0.push(self.kind as u8);
        out.0.extend_from_slice(&self.blank);
        out.u32(self.id);
        out.u32(self.settings.opacity.to_bits());
        out.0.push(self.settings.blend as u8);
        out.0.push(u8::from(self.settings.visible));
        out.0.extend(self.face_sizes.iter().map(|size| size.ilog2() as u8));
    }

    /// What [`Self::encode`] wrote for a mesh of `faces` faces. Documents of version 1 have neither numbers nor
    /// settings; the layer then gets the number `id`.
    pub(crate) fn decode(from: &mut Decoder, version: u32, id: u32, faces: usize, budget: &mut Budget) -> Result<Self> {
        let name = from.text()?;
        let fault = |what: &str| Error::invalid(format!("the document is damaged: layer `{name}` {what}"));
        let kind = Kind::of(from.u8()?).ok_or_else(|| fault("is of an unknown kind"))?;
        let blank = from.bytes(kind.texel())?.to_vec();
        let (mut id, mut settings) = (id, Settings::of(kind));
        if version > 1 {
            id = from.u32()?;
            let opacity = f32::from_bits(from.u32()?);
            let blend = Blend::NAMES.get(usize::from(from.u8()?)).ok_or_else(|| fault("has an unknown blend mode"))?.0;
            settings = Settings { opacity, blend, visible: from.u8()? != 0 };
        }
        let mut face_sizes = Vec::new();
        let bits = from.bytes(faces)?;
        budget.reserve(&mut face_sizes, faces)?;
        for bits in bits {
            if !SIZE_BITS.contains(&u32::from(*bits)) {
                return Err(fault("has tiles of an impossible size"));
            }
            face_sizes.push(1 << bits);
        }
        Ok(Self { id, name, kind, blank, settings, face_sizes })
    }

    /// What holds for the layer alone.
    pub(crate) fn check(&self, faces: usize) -> Result<()> {
        let check = || {
            if self.name.is_empty() || self.name.len() > usize::from(u8::MAX) || self.name.contains(char::is_control) {
                return Err(Error::invalid("the name of a layer is 1 to 255 bytes of text"));
            }
            if self.blank.len() != self.kind.texel() {
                return Err(Error::invalid(format!("its default has {} bytes", self.blank.len()))
                    .advise(format!("give one texel of {}", self.kind.texel())));
            }
            if self.id > MAX_ID {
                return Err(Error::invalid(format!("its number is above {MAX_ID}")));
            }
            self.settings.check(self.kind)?;
            if let Some(size) = self.face_sizes.iter().find(|size| !is_size(**size)) {
                return Err(Error::invalid(format!("a tile cannot have {size} texels a side"))
                    .advise("use 8, 16, 32, 64, 128 or 256"));
            }
            if self.face_sizes.len() != faces {
                return Err(Error::invalid(format!(
                    "it has sizes for {} faces and the mesh has {}",
                    self.face_sizes.len(),
                    faces
                )));
            }
            Ok(())
        };
        check().map_err(|error: Error| error.at(self.place()))
    }

    /// What errors call it.
    pub(crate) fn place(&self) -> String {
        format!("layer `{}`", self.name)
    }

    /// Bytes of the block of `tile`, 0 if there is no such tile; on a triangle mesh the most that a block can have.
    pub fn block_bytes(&self, topology: &Topology, tile: u32) -> u64 {
        if topology.is_of_triangles() {
            return self.block_sizes(topology, tile).first().copied().unwrap_or(0);
        }
        let Some((face, sub)) = topology.face_of(tile) else { return 0 };
        let size = self.face_sizes.get(face as usize).copied().unwrap_or(0);
        let side = u64::from(if sub { (size / 2).max(8) } else { size }) + 2;
        side * side * self.kind.texel() as u64
    }

    /// The numbers of bytes that a block may have, the most first.
    pub fn block_sizes(&self, topology: &Topology, block: u32) -> Vec<u64> {
        if !topology.is_of_triangles() {
            return vec![self.block_bytes(topology, block)];
        }
        let segments = self.face_sizes.first().copied().unwrap_or(0);
        let values = topology.lattice().values(block, segments);
        values.into_iter().map(|values| values * self.kind.texel() as u64).collect()
    }
}

/// Fails if `head` has the number or the name of one of `others`.
pub(crate) fn check_distinct<'a>(head: &Head, mut others: impl Iterator<Item = &'a Head>) -> Result<()> {
    if others.any(|other| other.name == head.name || other.id == head.id) {
        return Err(Error::invalid("the document has a layer of that name or number")
            .at(head.place())
            .advise("name it otherwise"));
    }
    Ok(())
}

fn is_size(size: u32) -> bool {
    size.is_power_of_two() && SIZE_BITS.contains(&size.ilog2())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_have_the_numbers_of_their_names_and_suit_their_kind() {
        for (number, (blend, _)) in Blend::NAMES.into_iter().enumerate() {
            assert_eq!(blend as usize, number);
            assert!(Kind::ALL.into_iter().any(|kind| blend.suits(kind)));
        }
        for kind in Kind::ALL {
            Settings::of(kind).check(kind).unwrap();
            for opacity in [f32::NAN, -0.1, 1.5] {
                assert!(Settings { opacity, ..Settings::of(kind) }.check(kind).is_err());
            }
        }
        let multiply = Settings { blend: Blend::Multiply, ..Settings::of(Kind::Scalar) };
        let error = multiply.check(Kind::Scalar).unwrap_err().to_string();
        assert!(error.ends_with("use add, subtract, max, min"), "{error}");
    }
}
