//! A layer: what its texels are, the sizes of its tiles, and the compressed blocks of texels that differ from the
//! default. Sizes are texels along a side; a block is the tile with a ring of one texel, row by row.

use relievo_core::{Context, Error, Result};

use crate::head::{Head, Settings};
use crate::packing;
use crate::topology::Topology;

/// What the texels of a layer are, in little-endian numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Scalar displacement: B-spline coefficients in half floats, object units.
    Scalar = 0,
    /// Colour in four bytes: red, green and blue encoded as sRGB, and alpha.
    Rgba8 = 1,
    /// Colour in four half floats: linear red, green and blue, and alpha.
    Rgba16 = 2,
    /// Vector displacement: B-spline coefficients in three half floats, along the tangent by u, across it and along the
    /// normal; object units.
    Vector = 3,
    /// Traces of contact: contact and depth in half floats, and the moment of contact in a float.
    Trace = 4,
    /// When the texels of another layer, which fades, were edited last: of every block all texels as they were left
    /// then, and after them as many floats, seconds. The largest float is the time of what does not fade.
    Stamps = 5,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 6] = [Kind::Scalar, Kind::Rgba8, Kind::Rgba16, Kind::Vector, Kind::Trace, Kind::Stamps];

    /// The kind that has `number` in files.
    pub(crate) fn of(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == number)
    }

    /// Bytes of a texel; of stamps, of the time alone.
    pub fn texel(self) -> usize {
        match self {
            Kind::Scalar => 2,
            Kind::Rgba8 | Kind::Stamps => 4,
            Kind::Vector => 6,
            Kind::Rgba16 | Kind::Trace => 8,
        }
    }

    /// Whether texels are colours.
    pub fn is_color(self) -> bool {
        matches!(self, Kind::Rgba8 | Kind::Rgba16)
    }

    /// What it is called in print.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Scalar => "scalar displacement, f16",
            Kind::Rgba8 => "colour, RGBA8",
            Kind::Rgba16 => "colour, RGBA16F",
            Kind::Vector => "vector displacement, f16",
            Kind::Trace => "traces of contact",
            Kind::Stamps => "times of edits that fade",
        }
    }

    /// Whether all numbers of a block are finite. Numbers that are cut off do not count.
    pub(crate) fn all_finite(self, block: &[u8]) -> bool {
        let half = |half: &[u8]| u16::from_le_bytes([half[0], half[1]]) & 0x7c00 != 0x7c00;
        // The exponent of a float is in its upper half.
        let float = |float: &[u8]| u16::from_le_bytes([float[2], float[3]]) & 0x7f80 != 0x7f80;
        match self {
            Kind::Rgba8 => true,
            Kind::Scalar | Kind::Rgba16 | Kind::Vector => block.chunks_exact(2).all(half),
            Kind::Trace => {
                block.chunks_exact(8).all(|texel| half(&texel[..2]) && half(&texel[2..4]) && float(&texel[4..]))
            }
            Kind::Stamps => block.chunks_exact(4).all(float),
        }
    }
}

/// The compressed block of one tile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    pub(crate) tile: u32,
    pub(crate) crc: u32,
    pub(crate) packed: Vec<u8>,
    pub(crate) place: Place,
}

/// Where a block is in the file that it was read from, if it is there; no two blocks differ by it.
#[derive(Clone, Copy, Debug, Default, Eq)]
pub(crate) struct Place(pub Option<u64>);

impl PartialEq for Place {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Block {
    /// The block of `tile` with these bytes.
    pub(crate) fn pack(tile: u32, bytes: &[u8]) -> Result<Self> {
        let packed = packing::pack_block(bytes, COMPRESSION)
            .map_err(|error| Error::internal(format!("a block cannot be compressed: {error}")))?;
        Ok(Self { tile, crc: crc32fast::hash(&packed), packed, place: Place::default() })
    }

    /// The tile.
    pub fn tile(&self) -> u32 {
        self.tile
    }

    /// Bytes it takes in the file.
    pub fn packed_bytes(&self) -> usize {
        self.packed.len()
    }
}

/// A named layer of a document.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    pub(crate) head: Head,
    /// By tile, ascending.
    pub(crate) blocks: Vec<Block>,
}

/// Level of zstd: documents are written seldom and read often.
const COMPRESSION: i32 = 3;
/// No packed block is larger: 258² texels of 8 bytes and times of 4, and what incompressible data adds.
pub(crate) const MAX_PACKED: u32 = 1 << 20;
/// Sizes of faces, as powers of two.
pub(crate) const SIZE_BITS: std::ops::RangeInclusive<u32> = 3..=8;

impl Layer {
    /// See [`Document::pack`](crate::Document::pack).
    pub(crate) fn pack(
        context: &Context,
        topology: &Topology,
        head: Head,
        tiles: &[u32],
        read: impl Fn(u32) -> Result<Vec<u8>> + Sync,
    ) -> Result<Self> {
        let place = head.place();
        let bare = |tile: &u32| Block { tile: *tile, crc: 0, packed: Vec::new(), place: Place::default() };
        let blocks = tiles.iter().map(bare).collect();
        let mut layer = Self { head, blocks };
        layer.check(topology)?;
        let packed = context.map(tiles.len(), |at| {
            let (tile, bytes) = (tiles[at], read(tiles[at])?);
            let expected = layer.head.block_sizes(topology, tile);
            if !expected.contains(&(bytes.len() as u64)) {
                let expected: Vec<String> = expected.iter().map(u64::to_string).collect();
                let what = format!("its block has {} bytes and not {}", bytes.len(), expected.join(" or "));
                return Err(Error::invalid(what).at(topology.block_name(tile)));
            }
            Block::pack(tile, &bytes)
        });
        layer.blocks = packed.into_iter().collect::<Result<_>>().map_err(|error: Error| error.at(place))?;
        Ok(layer)
    }

    /// What it is apart from its blocks.
    pub fn head(&self) -> &Head {
        &self.head
    }

    /// Its number.
    pub fn id(&self) -> u32 {
        self.head.id
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.head.name
    }

    /// What its texels are.
    pub fn kind(&self) -> Kind {
        self.head.kind
    }

    /// How it takes part in what is seen.
    pub fn settings(&self) -> Settings {
        self.head.settings
    }

    /// The texel that tiles without a block read as.
    pub fn blank(&self) -> &[u8] {
        &self.head.blank
    }

    /// Of every face, texels along an edge of it. Sub-tiles have half of it, but at least 8.
    pub fn face_sizes(&self) -> &[u32] {
        &self.head.face_sizes
    }

    /// Its blocks, by tile.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Bytes of the block at `index` of [`Self::blocks`] when unpacked, 0 if there is none.
    pub fn block_bytes(&self, topology: &Topology, index: usize) -> u64 {
        let Some(block) = self.blocks.get(index) else { return 0 };
        let sizes = self.head.block_sizes(topology, block.tile);
        // Where it can have several, the packed bytes say which.
        let said = zstd::zstd_safe::get_frame_content_size(&block.packed).ok().flatten();
        said.filter(|said| sizes.contains(said)).or(sizes.first().copied()).unwrap_or(0)
    }

    /// Bytes of all its blocks when unpacked.
    pub fn bytes(&self, topology: &Topology) -> u64 {
        (0..self.blocks.len()).map(|index| self.block_bytes(topology, index)).sum()
    }

    /// The block at `index` of [`Self::blocks`].
    ///
    /// # Errors
    /// Fails with `Invalid` if there is none or its bytes are damaged.
    pub fn unpack(&self, topology: &Topology, index: usize) -> Result<Vec<u8>> {
        let block = self.blocks.get(index).ok_or_else(|| Error::invalid(format!("there is no block {index}")))?;
        let place = || format!("{}: {}", self.head.place(), topology.block_name(block.tile));
        let damaged = |what: &str| {
            Error::invalid(format!("the document is damaged: {what}"))
                .at(place())
                .advise("see `relievo doc check`, and take an older copy")
        };
        if crc32fast::hash(&block.packed) != block.crc {
            return Err(damaged("the checksum of the block is wrong"));
        }
        let bytes = self.block_bytes(topology, index);
        let length = usize::try_from(bytes).map_err(|_| damaged("the block claims an impossible size"))?;
        match packing::unpack(&block.packed, length) {
            Ok(unpacked) if unpacked.len() == length => Ok(unpacked),
            _ => Err(damaged(&format!("the block does not unpack to {bytes} bytes"))),
        }
    }

    /// Whether it can be one of a document about `topology`.
    pub(crate) fn check(&self, topology: &Topology) -> Result<()> {
        self.head.check(topology.face_count())?;
        let check = || {
            topology.lattice().check(self.face_sizes())?;
            if let Some(pair) = self.blocks.windows(2).find(|pair| pair[0].tile >= pair[1].tile) {
                return Err(Error::invalid(format!("tile {} comes after tile {}", pair[1].tile, pair[0].tile)));
            }
            match self.blocks.last() {
                Some(block) if block.tile >= topology.block_count() => Err(Error::invalid(format!(
                    "tile {} does not exist; the mesh has {}",
                    block.tile,
                    topology.block_count()
                ))),
                _ => Ok(()),
            }
        };
        check().map_err(|error: Error| error.at(self.head.place()))
    }
}
