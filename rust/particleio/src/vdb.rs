//! Writes level sets as OpenVDB's files (Museth 2013), version 224: a tree of floats with nodes of 32³, 16³ and 8³, packed
//! by zlib. The form is what OpenVDB 10 reads; its library is asked in tests alone.
//!
//! Little-endian: the signature, versions, whether places of grids are in the file, an identifier, the metadata of the
//! file and the number of grids; and of the grid its name, type and places, how it is packed, its metadata, its transform,
//! the topology of its tree (of each node its masks and the values of tiles) and then the values of its leaves.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use relievo_core::{Context, Error, Result, file};

/// Voxels along an edge of a block.
pub const BLOCK: usize = 8;
/// A block of voxels: its lowest voxel, of multiples of 8, and its values, z fastest and x slowest.
pub type Block = ([i32; 3], Box<[f32; BLOCK * BLOCK * BLOCK]>);

/// Distances to a surface on a lattice of voxels, negative inside. Voxel (i, j, k) is at (i, j, k) times its size.
#[derive(Clone, Debug, Default)]
pub struct LevelSet {
    /// Edge of a voxel in metres.
    pub voxel: f32,
    /// Distances are known up to so many metres; beyond, values are this number or minus it.
    pub band: f32,
    /// Blocks that the band touches, sorted, each once.
    pub blocks: Vec<Block>,
}

const SIGNATURE: u64 = 0x5644_4220;
/// The version of the file, and that of the library that is said to have written it.
const VERSIONS: [u32; 3] = [224, 10, 0];
/// What is packed: all values, by zlib.
const ZIP: u32 = 1;
/// Before values: all of them follow.
const ALL: u8 = 6;
/// Binary logarithms of the nodes' children along an edge, and of their voxels along an edge.
const LOWER: Node = Node { children: 4, edge: 7 };
const UPPER: Node = Node { children: 5, edge: 12 };
/// Voxels from 0 at most, so that places fit their numbers.
const FARTHEST: i32 = 1 << 30;

/// A level of nodes.
#[derive(Clone, Copy)]
struct Node {
    children: u32,
    edge: u32,
}

impl Node {
    fn len(self) -> usize {
        1 << (3 * self.children)
    }

    /// Binary logarithm of a child's voxels along an edge.
    fn child_edge(self) -> u32 {
        self.edge - self.children
    }

    /// The lowest voxel of the node around a voxel.
    fn around(self, voxel: [i32; 3]) -> [i32; 3] {
        voxel.map(|at| at >> self.edge << self.edge)
    }

    /// The number of the child around a voxel.
    fn child(self, voxel: [i32; 3]) -> usize {
        let [x, y, z] = voxel.map(|at| (at >> self.child_edge()) as usize & ((1 << self.children) - 1));
        (x << self.children | y) << self.children | z
    }

    /// The middle of a child of the node whose lowest voxel is `origin`, in voxels.
    fn middle(self, origin: [i32; 3], child: usize) -> [f64; 3] {
        let mask = (1 << self.children) - 1;
        let at = [child >> (2 * self.children), child >> self.children & mask, child & mask];
        let edge = f64::from(1 << self.child_edge());
        [0, 1, 2].map(|axis| f64::from(origin[axis]) + (at[axis] as f64 + 0.5) * edge - 0.5)
    }
}

/// Nodes of a level by their lowest voxels, each with the voxels of its children.
type Nodes = BTreeMap<[i32; 3], Vec<[i32; 3]>>;

/// Writes a level set. `is_inside` tells of a place in voxels, in parts where no block is, whether it is inside.
///
/// Fails, and leaves no file, if a number is not finite, blocks are not sorted or farther than 2³⁰ voxels from 0, or the
/// system refuses.
pub fn write_vdb(
    context: &Context,
    path: &Path,
    level_set: &LevelSet,
    is_inside: &(dyn Fn([f64; 3]) -> bool + Sync),
) -> Result<()> {
    level_set.check().map_err(|error| error.at(path.display().to_string()))?;
    let bytes = encode(context, level_set, is_inside);
    file::store(path, |out| out.write_all(&bytes))
}

impl LevelSet {
    fn check(&self) -> Result<()> {
        let is_positive = |value: f32| value.is_finite() && value > 0.0;
        if !is_positive(self.voxel) || !is_positive(self.band) {
            return Err(Error::invalid(format!("voxels of {} m and a band of {} m cannot be", self.voxel, self.band)));
        }
        let is_near = |(origin, _): &Block| origin.iter().all(|at| at % BLOCK as i32 == 0 && at.abs() < FARTHEST);
        if !self.blocks.iter().all(is_near) || !self.blocks.windows(2).all(|pair| pair[0].0 < pair[1].0) {
            return Err(Error::invalid("blocks of a level set are not sorted, or more than 2³⁰ voxels from 0"));
        }
        match self.blocks.iter().find(|(_, values)| values.iter().any(|value| !value.is_finite())) {
            Some((origin, _)) => Err(Error::invalid("a distance is not finite").at(format!("block {origin:?}"))),
            None => Ok(()),
        }
    }
}

fn encode(context: &Context, level_set: &LevelSet, is_inside: &(dyn Fn([f64; 3]) -> bool + Sync)) -> Vec<u8> {
    let (mut lower, mut upper) = (Nodes::new(), Nodes::new());
    for (origin, _) in &level_set.blocks {
        lower.entry(LOWER.around(*origin)).or_default().push(*origin);
    }
    lower.keys().for_each(|origin| upper.entry(UPPER.around(*origin)).or_default().push(*origin));
    let leaves = context.map(level_set.blocks.len(), |at| level_set.leaf(at));
    let number = |origin: &[i32; 3]| level_set.blocks.partition_point(|(other, _)| other < origin);

    let mut topology = 1u32.to_le_bytes().to_vec();
    topology.extend(level_set.band.to_le_bytes());
    topology.extend([0, upper.len() as u32].iter().flat_map(|count| count.to_le_bytes()));
    let mut buffers = Vec::new();
    for (origin, children) in &upper {
        topology.extend(origin.iter().flat_map(|at| at.to_le_bytes()));
        topology.extend(node(context, UPPER, *origin, children, level_set.band, is_inside));
        // Children follow in the order of their numbers, which is that of their places.
        for origin in children {
            topology.extend(node(context, LOWER, *origin, &lower[origin], level_set.band, is_inside));
            for leaf in lower[origin].iter().map(|origin| &leaves[number(origin)]) {
                topology.extend_from_slice(&leaf.mask);
                buffers.extend_from_slice(&leaf.mask);
                buffers.extend_from_slice(&leaf.packed);
            }
        }
    }

    let mut out = SIGNATURE.to_le_bytes().to_vec();
    out.extend(VERSIONS.iter().flat_map(|number| number.to_le_bytes()));
    out.push(1);
    // What others tell grids apart by: made of what is in the file, so that the same has the same.
    let sums = [crc32fast::hash(&topology), crc32fast::hash(&buffers)];
    let identifier = format!("{:08x}-0000-4000-8000-{:08x}0000", sums[0], sums[1]);
    out.extend(identifier.as_bytes());
    out.extend([0, 1u32].iter().flat_map(|count| count.to_le_bytes()));
    text(&mut out, "surface");
    text(&mut out, "Tree_float_5_4_3");
    text(&mut out, "");
    let head = grid_head(level_set.voxel);
    let grid = out.len() + 3 * size_of::<u64>();
    let values = grid + head.len() + topology.len();
    out.extend([grid, values, values + buffers.len()].iter().flat_map(|place| (*place as u64).to_le_bytes()));
    [head, topology, buffers].iter().for_each(|part| out.extend_from_slice(part));
    out
}

/// How a grid is packed, its metadata, and its transform: a uniform scale with its voxel, inverse, and what follows.
fn grid_head(voxel: f32) -> Vec<u8> {
    let mut out = ZIP.to_le_bytes().to_vec();
    let metadata = [("class", "level set"), ("creator", "Relievo"), ("name", "surface")];
    out.extend((metadata.len() as u32).to_le_bytes());
    for (name, value) in metadata {
        text(&mut out, name);
        text(&mut out, "string");
        text(&mut out, value);
    }
    text(&mut out, "UniformScaleMap");
    let voxel = f64::from(voxel);
    for value in [voxel, voxel, 1.0 / voxel, 1.0 / (voxel * voxel), 0.5 / voxel] {
        out.extend([value; 3].iter().flat_map(|value| value.to_le_bytes()));
    }
    out
}

fn text(out: &mut Vec<u8>, text: &str) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

/// Masks and values of a node: of children that are there, none of tiles that are active, and of all tiles on which side
/// of the surface they are.
fn node(
    context: &Context,
    node: Node,
    origin: [i32; 3],
    children: &[[i32; 3]],
    band: f32,
    is_inside: &(dyn Fn([f64; 3]) -> bool + Sync),
) -> Vec<u8> {
    let mut mask = vec![0u8; node.len() / 8];
    for child in children.iter().map(|child| node.child(*child)) {
        mask[child / 8] |= 1 << (child % 8);
    }
    let values = context.map(node.len(), |child| match mask[child / 8] >> (child % 8) & 1 {
        1 => 0.0,
        _ if is_inside(node.middle(origin, child)) => -band,
        _ => band,
    });
    let mut out = mask;
    out.resize(2 * out.len(), 0);
    out.extend(packed(&values));
    out
}

/// A leaf: which of its voxels are active, and its values packed.
struct Leaf {
    mask: [u8; 64],
    packed: Vec<u8>,
}

impl LevelSet {
    fn leaf(&self, at: usize) -> Leaf {
        let values = &self.blocks[at].1;
        let mut mask = [0u8; 64];
        for (voxel, _) in values.iter().enumerate().filter(|(_, value)| value.abs() < self.band) {
            mask[voxel / 8] |= 1 << (voxel % 8);
        }
        Leaf { mask, packed: packed(values.as_slice()) }
    }
}

/// All values, packed; not so where that would not be shorter.
fn packed(values: &[f32]) -> Vec<u8> {
    let plain: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    // Writing to memory does not fail; if it did, the values would be there unpacked.
    let zipped = encoder.write_all(&plain).and_then(|()| encoder.finish()).unwrap_or_default();
    let mut out = vec![ALL];
    if zipped.is_empty() || zipped.len() >= plain.len() {
        out.extend((-(plain.len() as i64)).to_le_bytes());
        out.extend(plain);
    } else {
        out.extend((zipped.len() as i64).to_le_bytes());
        out.extend(zipped);
    }
    out
}
