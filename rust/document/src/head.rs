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

    /// Checks that layers of `kind` can be seen so.
    ///
    /// # Errors
    /// Fails with `Invalid` if the opacity is outside 0 to 1, or the mode does not suit the kind.
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

/// What the times of a layer of [`Kind::Stamps`] belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamps {
    /// The number of the layer that fades.
    pub layer: u32,
    /// What its texels are.
    pub texel: Kind,
    /// How long an edit stays as it is, seconds.
    pub delay: f32,
    /// How long it then takes to fade, seconds.
    pub duration: f32,
}

impl Stamps {
    fn check(&self) -> Result<()> {
        let Self { delay, duration, .. } = *self;
        if self.texel == Kind::Stamps {
            return Err(Error::invalid("times of edits do not fade"));
        }
        if !(delay >= 0.0 && duration > 0.0 && (delay + duration).is_finite()) {
            return Err(Error::invalid(format!("edits cannot fade for {duration} s after {delay} s")));
        }
        Ok(())
    }
}

/// The largest number of a layer, far enough from where numbers end to count on.
pub const MAX_ID: u32 = 1 << 30;

/// What the names of layers of stamps begin with; the number of the layer that fades follows.
pub const STAMPS_OF: &str = "stamps of layer ";

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
    /// Of every face the size it was given, where edits at other levels changed the size of some; else none.
    pub given_sizes: Vec<u32>,
    /// The texel that is seen behind all layers of the kind, if this is the lowest of them and it is known; else none.
    pub behind: Vec<u8>,
    /// What its times belong to, if it is of [`Kind::Stamps`].
    pub stamps: Option<Stamps>,
}

/// Bits that say what follows in a head.
const GIVEN: u8 = 1;
const BEHIND: u8 = 2;

impl Head {
    /// A layer that is seen as a whole, in the mode of its kind.
    pub fn new(id: u32, name: &str, kind: Kind, blank: &[u8], face_sizes: Vec<u32>) -> Self {
        Self {
            id,
            name: name.to_string(),
            kind,
            blank: blank.to_vec(),
            settings: Settings::of(kind),
            face_sizes,
            given_sizes: Vec::new(),
            behind: Vec::new(),
            stamps: None,
        }
    }

    /// The times of the edits of the layer `of`, which fades as `stamps` says.
    pub fn of_stamps(id: u32, of: &Self, stamps: Stamps) -> Self {
        // What is not there was never edited.
        let blank = [&vec![0; of.kind.texel()][..], &f32::MAX.to_le_bytes()].concat();
        let name = format!("{STAMPS_OF}{}", of.id);
        let given_sizes = of.given_sizes.clone();
        let stamps = Some(Stamps { layer: of.id, texel: of.kind, ..stamps });
        Self { given_sizes, stamps, ..Self::new(id, &name, Kind::Stamps, &blank, of.face_sizes.clone()) }
    }

    /// Bytes of a texel; of stamps, of the texel as it was left and its time.
    pub fn texel(&self) -> usize {
        self.kind.texel() + self.stamps.map_or(0, |stamps| stamps.texel.texel())
    }

    /// Whether all numbers of a block are finite.
    pub(crate) fn all_finite(&self, block: &[u8]) -> bool {
        let Some(stamps) = self.stamps else { return self.kind.all_finite(block) };
        let (texels, times) = block.split_at(block.len() / self.texel() * stamps.texel.texel());
        stamps.texel.all_finite(texels) && self.kind.all_finite(times)
    }

    /// Writes the form of version 3.
    pub(crate) fn encode(&self, out: &mut Encoder) {
        out.text(&self.name);
        out.0.push(self.kind as u8);
        if let Some(stamps) = &self.stamps {
            out.u32(stamps.layer);
            out.0.push(stamps.texel as u8);
            out.u32(stamps.delay.to_bits());
            out.u32(stamps.duration.to_bits());
        }
        out.0.extend_from_slice(&self.blank);
        out.u32(self.id);
        out.u32(self.settings.opacity.to_bits());
        out.0.push(self.settings.blend as u8);
        out.0.push(u8::from(self.settings.visible));
        let bits = |sizes: &[u32], out: &mut Encoder| out.0.extend(sizes.iter().map(|size| size.ilog2() as u8));
        bits(&self.face_sizes, out);
        out.0.push(
            if self.given_sizes.is_empty() { 0 } else { GIVEN } | if self.behind.is_empty() { 0 } else { BEHIND },
        );
        bits(&self.given_sizes, out);
        out.0.extend_from_slice(&self.behind);
    }

    /// What [`Self::encode`] wrote for a mesh of `faces` faces. Documents of version 1 have neither numbers nor
    /// settings; the layer then gets the number `id`. Those of version 2 have nothing after the sizes.
    pub(crate) fn decode(from: &mut Decoder, version: u32, id: u32, faces: usize, budget: &mut Budget) -> Result<Self> {
        let name = from.text()?;
        let fault = |what: &str| Error::invalid(format!("the document is damaged: layer `{name}` {what}"));
        let kind = |number: u8| Kind::of(number).ok_or_else(|| fault("is of an unknown kind"));
        let own = kind(from.u8()?)?;
        let stamps = if own == Kind::Stamps {
            let (layer, texel) = (from.u32()?, kind(from.u8()?)?);
            let (delay, duration) = (f32::from_bits(from.u32()?), f32::from_bits(from.u32()?));
            Some(Stamps { layer, texel, delay, duration })
        } else {
            None
        };
        let kind = own;
        let texel = kind.texel() + stamps.map_or(0, |stamps| stamps.texel.texel());
        let blank = from.bytes(texel)?.to_vec();
        let (mut id, mut settings) = (id, Settings::of(kind));
        if version > 1 {
            id = from.u32()?;
            let opacity = f32::from_bits(from.u32()?);
            let blend = Blend::NAMES.get(usize::from(from.u8()?)).ok_or_else(|| fault("has an unknown blend mode"))?.0;
            settings = Settings { opacity, blend, visible: from.u8()? != 0 };
        }
        let mut sizes = |from: &mut Decoder| -> Result<Vec<u32>> {
            let mut sizes = Vec::new();
            let bits = from.bytes(faces)?;
            budget.reserve(&mut sizes, faces)?;
            for bits in bits {
                if !SIZE_BITS.contains(&u32::from(*bits)) {
                    return Err(fault("has tiles of an impossible size"));
                }
                sizes.push(1 << bits);
            }
            Ok(sizes)
        };
        let face_sizes = sizes(from)?;
        let (mut given_sizes, mut behind) = (Vec::new(), Vec::new());
        if version > 2 {
            let more = from.u8()?;
            if more & !(GIVEN | BEHIND) != 0 {
                return Err(fault("has what this build does not know"));
            }
            if more & GIVEN != 0 {
                given_sizes = sizes(from)?;
            }
            if more & BEHIND != 0 {
                behind = from.bytes(texel)?.to_vec();
            }
        }
        Ok(Self { id, name, kind, blank, settings, face_sizes, given_sizes, behind, stamps })
    }

    /// What holds for the layer alone.
    pub(crate) fn check(&self, faces: usize) -> Result<()> {
        let check = || {
            if self.name.is_empty() || self.name.len() > usize::from(u8::MAX) || self.name.contains(char::is_control) {
                return Err(Error::invalid("the name of a layer is 1 to 255 bytes of text"));
            }
            if self.stamps.is_some() != (self.kind == Kind::Stamps) {
                return Err(Error::invalid("times of edits belong to a layer, and nothing else does"));
            }
            self.stamps.map_or(Ok(()), |stamps| stamps.check())?;
            let texel = self.texel();
            for (what, bytes) in [("default", self.blank.len()), ("background", self.behind.len())] {
                if bytes != texel && (bytes > 0 || what == "default") {
                    return Err(Error::invalid(format!("its {what} has {bytes} bytes"))
                        .advise(format!("give one texel of {texel}")));
                }
            }
            if self.id > MAX_ID {
                return Err(Error::invalid(format!("its number is above {MAX_ID}")));
            }
            self.settings.check(self.kind)?;
            if let Some(size) = self.face_sizes.iter().chain(&self.given_sizes).find(|size| !is_size(**size)) {
                return Err(Error::invalid(format!("a tile cannot have {size} texels a side"))
                    .advise("use 8, 16, 32, 64, 128 or 256"));
            }
            let given = if self.given_sizes.is_empty() { faces } else { self.given_sizes.len() };
            for count in [self.face_sizes.len(), given] {
                if count != faces {
                    let what = format!("it has sizes for {count} faces and the mesh has {faces}");
                    return Err(Error::invalid(what));
                }
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
        side * side * self.texel() as u64
    }

    /// The numbers of bytes that a block may have, the most first.
    pub fn block_sizes(&self, topology: &Topology, block: u32) -> Vec<u64> {
        if !topology.is_of_triangles() {
            return vec![self.block_bytes(topology, block)];
        }
        let segments = self.face_sizes.first().copied().unwrap_or(0);
        let values = topology.lattice().values(block, segments);
        values.into_iter().map(|values| values * self.texel() as u64).collect()
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
