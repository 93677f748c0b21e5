//! OpenVDB's files (Museth 2013), version 224: level sets and particles out, grids of floats and particles in. The form is
//! what OpenVDB 10 reads and writes; its library is asked in tests alone.
//!
//! Little-endian: the signature, versions, whether places of grids are in the file, an identifier, the metadata of the
//! file and the number of grids; and of each grid its name, type and places, how it is packed, its metadata, its transform,
//! the topology of its tree (of each node its masks and the values of tiles) and then the values of its leaves. Trees have
//! nodes of 32³ and 16³ children and leaves of 8³ voxels.

mod blosc;
mod grid;
mod level_set;
mod points;
mod points_reader;
mod reader;
mod tree;

use std::collections::BTreeMap;
use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use relievo_core::Context;

pub use self::grid::{Grid, read_grid};
pub use self::level_set::{BLOCK, Block, LevelSet, write_vdb};
pub use self::points::write_vdb_points;
pub use self::points_reader::read_vdb_points;

pub(crate) const SIGNATURE: u64 = 0x5644_4220;
/// The version of the file, and that of the library that is said to have written it.
const VERSIONS: [u32; 3] = [224, 10, 0];
/// What is packed: all values, by zlib.
const ZIP: u32 = 1;
/// Before values: all of them follow.
const ALL: u8 = 6;
/// The types of trees of floats and of points.
const FLOATS: &str = "Tree_float_5_4_3";
const POINTS: &str = "Tree_ptdataidx32_5_4_3";
/// Binary logarithms of the nodes' children along an edge, and of their voxels along an edge.
const LEAF: Node = Node { children: 3, edge: 3 };
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
    const fn len(self) -> usize {
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

    /// The lowest voxel of a child of the node whose lowest voxel is `origin`.
    fn origin(self, origin: [i32; 3], child: usize) -> [i32; 3] {
        let mask = (1 << self.children) - 1;
        let at = [child >> (2 * self.children), child >> self.children & mask, child & mask];
        [0, 1, 2].map(|axis| origin[axis] + ((at[axis] as i32) << self.child_edge()))
    }

    /// The middle of a child of the node whose lowest voxel is `origin`, in voxels.
    fn middle(self, origin: [i32; 3], child: usize) -> [f64; 3] {
        let half = 0.5 * f64::from((1 << self.child_edge()) - 1);
        self.origin(origin, child).map(|at| f64::from(at) + half)
    }
}

/// Nodes of a level by their lowest voxels, each with the voxels of its children.
type Nodes = BTreeMap<[i32; 3], Vec<[i32; 3]>>;

/// Writes the topology of a tree whose leaves have these lowest voxels, sorted, and these masks of active voxels; tiles are
/// the background, or minus it where `is_inside` says so of a place in voxels. Returns it with the order of the leaves in
/// the file.
fn topology(
    context: &Context,
    leaves: &[([i32; 3], [u8; 64])],
    background: f32,
    is_inside: &(dyn Fn([f64; 3]) -> bool + Sync),
) -> (Vec<u8>, Vec<usize>) {
    let (mut lower, mut upper) = (Nodes::new(), Nodes::new());
    for (origin, _) in leaves {
        lower.entry(LOWER.around(*origin)).or_default().push(*origin);
    }
    lower.keys().for_each(|origin| upper.entry(UPPER.around(*origin)).or_default().push(*origin));
    let number = |origin: &[i32; 3]| leaves.partition_point(|(other, _)| other < origin);
    let mut out = 1u32.to_le_bytes().to_vec();
    out.extend(background.to_le_bytes());
    out.extend([0, upper.len() as u32].iter().flat_map(|count| count.to_le_bytes()));
    let mut order = Vec::with_capacity(leaves.len());
    for (origin, children) in &upper {
        out.extend(origin.iter().flat_map(|at| at.to_le_bytes()));
        out.extend(node(context, UPPER, *origin, children, background, is_inside));
        // Children follow in the order of their numbers, which is that of their places.
        for origin in children {
            out.extend(node(context, LOWER, *origin, &lower[origin], background, is_inside));
            for leaf in lower[origin].iter().map(number) {
                out.extend_from_slice(&leaves[leaf].1);
                order.push(leaf);
            }
        }
    }
    (out, order)
}

/// What a grid is called and is.
struct Head<'a> {
    name: &'a str,
    kind: &'a str,
    /// Names, types and values.
    metadata: &'a [(&'a str, &'a str, Vec<u8>)],
    /// Edge of a voxel in metres.
    voxel: f64,
}

/// A file of one grid.
fn encode(head: &Head, topology: &[u8], buffers: &[u8]) -> Vec<u8> {
    let mut out = SIGNATURE.to_le_bytes().to_vec();
    out.extend(VERSIONS.iter().flat_map(|number| number.to_le_bytes()));
    out.push(1);
    // What others tell grids apart by: made of what is in the file, so that the same has the same.
    let sums = [crc32fast::hash(topology), crc32fast::hash(buffers)];
    let identifier = format!("{:08x}-0000-4000-8000-{:08x}0000", sums[0], sums[1]);
    out.extend(identifier.as_bytes());
    out.extend([0, 1u32].iter().flat_map(|count| count.to_le_bytes()));
    text(&mut out, head.name);
    text(&mut out, head.kind);
    text(&mut out, "");
    let bytes = head.encode();
    let grid = out.len() + 3 * size_of::<u64>();
    let values = grid + bytes.len() + topology.len();
    out.extend([grid, values, values + buffers.len()].iter().flat_map(|place| (*place as u64).to_le_bytes()));
    [&bytes, topology, buffers].iter().for_each(|part| out.extend_from_slice(part));
    out
}

impl Head<'_> {
    /// How a grid is packed, its metadata, and its transform: a uniform scale with its voxel, inverse, and what follows.
    fn encode(&self) -> Vec<u8> {
        let mut out = ZIP.to_le_bytes().to_vec();
        out.extend((self.metadata.len() as u32).to_le_bytes());
        for (name, kind, value) in self.metadata {
            text(&mut out, name);
            text(&mut out, kind);
            out.extend((value.len() as u32).to_le_bytes());
            out.extend(value);
        }
        text(&mut out, "UniformScaleMap");
        let voxel = self.voxel;
        for value in [voxel, voxel, 1.0 / voxel, 1.0 / (voxel * voxel), 0.5 / voxel] {
            out.extend([value; 3].iter().flat_map(|value| value.to_le_bytes()));
        }
        out
    }
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
