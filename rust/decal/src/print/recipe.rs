//! Recipes: what a decal was made of, as bytes that a document keeps, so that it can be taken up again.
//!
//! Little-endian: `RLVDECAL`, version (u32), bytes of what follows the head (u32), their CRC-32; columns and rows of the
//! image (u32 each), its hash (u64); number of corners of the outline (u32) and their coordinates (f64); number of pins
//! (u32), and of each its point of the image (f64, pixels), its face (u32), three weights and its depth (f64); whether depths count
//! (u8); whether a pose follows (u8), width and upward direction (f64); steps (u32), decrease (f64), most triangles (u32),
//! overlap (u8); cells (u32); layer (u32); ink (u8: 0 colour, 1 relief), blend mode (u8), opacity and height (f32).
//!
//! Faces of pins are those of the tessellation of a cage, or of a triangle mesh itself, whose recipes have 1 cell. Corners of
//! the outline are in widths of the image, counter-clockwise. Readers believe nothing.

use relievo_core::{Error, Mesh, Progress, Result};
use relievo_document::code::{Decoder, Encoder};
use relievo_document::{Blend, Kind, Settings};
use relievo_render::Image;

use crate::artwork::outline::{MAX, Outline};
use crate::decal::{DecalSettings, Pose, Sticker, check};
use crate::map::energy::Vec2;
use crate::pins::{Pin, Place, name};
use crate::placement::Placement;
use crate::print::check_height;
use crate::print::printable::Printable;

const MAGIC: [u8; 8] = *b"RLVDECAL";
/// The version that is written, and the newest that is read.
const VERSION: u32 = 1;
/// Bytes of the header, which the checksum does not cover.
const HEAD: usize = 20;
/// The most pins.
const PINS: usize = 1024;
/// The most cells along an edge of the tessellation.
const CELLS: u32 = 1 << 12;

/// What a decal puts on the layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ink {
    /// Its colours.
    Color,
    /// A relief of this height where the image is white, object units.
    Relief(f32),
}

impl Ink {
    /// Returns the kind of layer that it goes to.
    pub fn kind(self) -> Kind {
        match self {
            Self::Color => Kind::Rgba8,
            Self::Relief(_) => Kind::Scalar,
        }
    }
}

/// What a decal on the displaced surface of an object was made of, on Catmull-Clark surfaces and triangle meshes.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// The sticker.
    pub sticker: Sticker,
    /// The hash of the image, see [`hash`].
    pub image: u64,
    /// The pins, on the faces of the tessellation, or of the triangle mesh: see [`Printable::kept`].
    pub pins: Vec<Pin>,
    /// Depths of the pins, or none.
    pub depths: Vec<f64>,
    /// Size and direction of a decal with one pin.
    pub pose: Option<Pose>,
    /// How it is laid.
    pub settings: DecalSettings,
    /// Cells along an edge of the cage that the surface is tessellated into, a power of two; 1 on triangle meshes.
    pub cells: u32,
    /// The number of the layer that it lies in.
    pub layer: u32,
    /// What it puts on the layer.
    pub ink: Ink,
    /// Blend mode and opacity of the layer.
    pub seen: Settings,
}

/// Returns a hash of an image, of its size, its channels and its pixels (FNV-1a over numbers of 32 bits).
pub fn hash(image: &Image) -> u64 {
    let head = [image.width(), image.height(), image.channels()];
    let numbers = head.into_iter().chain(image.data().iter().map(|value| value.to_bits()));
    numbers.fold(0xcbf2_9ce4_8422_2325, |hash, number| (hash ^ u64::from(number)).wrapping_mul(0x0100_0000_01b3))
}

fn damaged(what: &str) -> Error {
    Error::invalid(format!("the recipe is damaged: {what}"))
        .at("decal")
        .advise("lay the sticker anew, or take an older copy of the document")
}

impl Recipe {
    /// Returns whether bytes begin as a recipe of a decal does.
    pub fn is_one(bytes: &[u8]) -> bool {
        bytes.starts_with(&MAGIC)
    }

    /// Returns its bytes.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Encoder::default();
        out.0.extend_from_slice(&MAGIC);
        out.u32(VERSION);
        out.u64(0);
        let number = |out: &mut Encoder, value: f64| out.u64(value.to_bits());
        self.sticker.size.iter().for_each(|side| out.u32(*side as u32));
        out.u64(self.image);
        let corners = self.sticker.outline.corners();
        out.u32(corners.len() as u32);
        corners.as_flattened().iter().for_each(|value| number(&mut out, *value));
        out.u32(self.pins.len() as u32);
        for (index, pin) in self.pins.iter().enumerate() {
            pin.image.iter().for_each(|value| number(&mut out, *value));
            out.u32(pin.place.face);
            pin.place.barycentric.iter().for_each(|value| number(&mut out, *value));
            number(&mut out, self.depths.get(index).copied().unwrap_or(0.0));
        }
        out.0.push(u8::from(!self.depths.is_empty()));
        out.0.push(u8::from(self.pose.is_some()));
        if let Some(Pose { width, up }) = self.pose {
            number(&mut out, width);
            up.iter().for_each(|value| number(&mut out, *value));
        }
        let DecalSettings { steps, decrease, triangles, overlap } = self.settings;
        out.u32(steps);
        number(&mut out, decrease);
        out.u32(triangles);
        out.0.push(u8::from(overlap));
        out.u32(self.cells);
        out.u32(self.layer);
        let (ink, height) = match self.ink {
            Ink::Color => (0, 0.0),
            Ink::Relief(height) => (1, height),
        };
        out.0.extend([ink, self.seen.blend as u8]);
        out.u32(self.seen.opacity.to_bits());
        out.u32(f32::to_bits(height));
        let crc = crc32fast::hash(&out.0[HEAD..]);
        let length = (out.0.len() - HEAD) as u32;
        out.0[12..16].copy_from_slice(&length.to_le_bytes());
        out.0[16..HEAD].copy_from_slice(&crc.to_le_bytes());
        out.0
    }

    /// Reads what [`Self::encode`] wrote.
    ///
    /// # Errors
    /// It is of a newer version, cut or changed, or a number is out of range.
    pub fn decode(bytes: &[u8]) -> Result<Self> {
        let ends = |_: Error| damaged("it is shorter than it says");
        let mut from = Decoder(bytes);
        if from.bytes(MAGIC.len()).ok() != Some(&MAGIC[..]) {
            return Err(damaged("it does not begin as the recipe of a decal does"));
        }
        let version = from.u32().map_err(ends)?;
        if version > VERSION {
            return Err(Error::unsupported(format!("the recipe has version {version}"))
                .at("decal")
                .advise(format!("this build reads versions up to {VERSION}: take a newer relievo")));
        }
        let (length, crc) = (from.u32().map_err(ends)?, from.u32().map_err(ends)?);
        if version == 0 || from.0.len() as u64 != u64::from(length) || crc32fast::hash(from.0) != crc {
            return Err(damaged("its checksum is wrong"));
        }
        let recipe = Self::body(&mut from)?;
        if !from.0.is_empty() {
            return Err(damaged("it is longer than it says"));
        }
        Ok(recipe)
    }

    fn body(from: &mut Decoder) -> Result<Self> {
        let unfit = |error: Error| damaged(&error.what);
        let number = |from: &mut Decoder| from.u64().map(f64::from_bits).map_err(unfit);
        let flag = |from: &mut Decoder| match from.u8().map_err(unfit)? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(damaged("a flag is neither 0 nor 1")),
        };
        let whole = |from: &mut Decoder| from.u32().map_err(unfit);
        let size = [whole(from)?, whole(from)?];
        Sticker::whole(size).map_err(unfit)?;
        let image = from.u64().map_err(unfit)?;
        let count = whole(from)? as usize;
        if count > MAX {
            return Err(damaged("its outline has too many corners"));
        }
        from.expect(16 * count as u64).map_err(unfit)?;
        let mut corners: Vec<Vec2> = Vec::with_capacity(count);
        for _ in 0..count {
            corners.push([number(from)?, number(from)?]);
        }
        let outline = Outline::new(corners.clone()).map_err(unfit)?;
        if outline.corners() != corners {
            return Err(damaged("the corners of its outline do not run counter-clockwise"));
        }
        let sticker = Sticker { size: size.map(f64::from), outline };
        let count = whole(from)? as usize;
        if count > PINS {
            return Err(damaged("it has too many pins"));
        }
        let (mut pins, mut depths) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for _ in 0..count {
            let point = [number(from)?, number(from)?];
            let face = whole(from)?;
            let barycentric = [number(from)?, number(from)?, number(from)?];
            let depth = number(from)?;
            let sum: f64 = barycentric.iter().sum();
            let is_usable = barycentric.iter().all(|weight| *weight >= -1e-6) && sum > 1e-6 && sum.is_finite();
            if !is_usable || !depth.is_finite() || sticker.check(&point).is_err() {
                return Err(damaged(&format!("pin {} has no place or depth", pins.len())));
            }
            pins.push(Pin { image: point, place: Place { face, barycentric } });
            depths.push(depth);
        }
        if !flag(from)? {
            if depths.iter().any(|depth| depth.to_bits() != 0) {
                return Err(damaged("its pins have depths that do not count"));
            }
            depths.clear();
        }
        let pose = match flag(from)? {
            true => Some(Pose { width: number(from)?, up: [number(from)?, number(from)?, number(from)?] }),
            false => None,
        };
        if pose
            .is_some_and(|pose| !(pose.width > 0.0 && pose.width.is_finite() && pose.up.iter().all(|x| x.is_finite())))
        {
            return Err(damaged("its pose is none"));
        }
        let settings = DecalSettings {
            steps: whole(from)?,
            decrease: number(from)?,
            triangles: whole(from)?,
            overlap: flag(from)?,
        };
        check(&pins, &settings).map_err(unfit)?;
        let (cells, layer) = (whole(from)?, whole(from)?);
        if !cells.is_power_of_two() || cells > CELLS {
            return Err(damaged(&format!("it has {cells} cells")));
        }
        let (ink, blend) = (from.u8().map_err(unfit)?, from.u8().map_err(unfit)?);
        let (opacity, height) = (f32::from_bits(whole(from)?), f32::from_bits(whole(from)?));
        check_height(height).map_err(unfit)?;
        let ink = match (ink, height.to_bits()) {
            (0, 0) => Ink::Color,
            (1, _) => Ink::Relief(height),
            _ => return Err(damaged("its ink is unknown")),
        };
        let blend = Blend::NAMES.get(usize::from(blend)).ok_or_else(|| damaged("its blend mode is unknown"))?.0;
        let seen = Settings { opacity, blend, visible: true };
        seen.check(ink.kind()).map_err(unfit)?;
        Ok(Self { sticker, image, pins, depths, pose, settings, cells, layer, ink, seen })
    }

    /// Checks that `image` is the one that the decal was made with.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is another.
    pub fn check_image(&self, image: &Image) -> Result<()> {
        if hash(image) == self.image {
            return Ok(());
        }
        Err(Error::invalid("it is not the image that the decal was made with")
            .at("image")
            .advise("give that image, or replace the image of the decal"))
    }

    /// Lays the sticker on a mesh: the tessellation that the pins belong to, or a pose of it.
    ///
    /// # Errors
    /// As [`lay`](crate::lay).
    pub fn lay(&self, mesh: &Mesh, progress: &mut dyn Progress) -> Result<Placement> {
        Placement::new(mesh, &self.sticker, &self.pins, self.pose, &self.settings, progress)
    }

    /// Lays the sticker on the triangles of an object, where the pins are as [`Printable::kept`] gave them.
    ///
    /// # Errors
    /// As [`Self::lay`], or the surface has no such faces.
    pub fn lay_on<O: Printable>(&self, triangles: &O::Triangles, progress: &mut dyn Progress) -> Result<Placement> {
        let found = |(index, pin): (usize, &Pin)| {
            let place = O::found(triangles, pin.place).map_err(|error| error.at(name(index)))?;
            Ok(Pin { place, ..*pin })
        };
        let pins = self.pins.iter().enumerate().map(found).collect::<Result<Vec<_>>>()?;
        Placement::new(O::mesh(triangles), &self.sticker, &pins, self.pose, &self.settings, progress)
    }
}

impl PartialEq for Recipe {
    fn eq(&self, other: &Self) -> bool {
        self.encode() == other.encode()
    }
}
