// import common
// A progressive mesh on a device. A vertex has the number of the first of its leaves, and a split that of the vertex it
// adds, so that a bit a number says both which vertices there are and which splits are made.

/// In place of the key of a vertex of the base, which is always there.
const ALWAYS: u32 = 0xffffffffu;
/// In place of a split: a leaf.
const LEAF: u32 = 0x80000000u;
/// The numbers ahead of the vertices around a split in `Stars` of rust/lod: how many are beside its first vertex alone,
/// beside both, beside the second alone, and how many triangles are at the first and at the second.
const HEAD: u32 = 5u;
/// Of a vertex around, its node: twice the number of the split it comes from, and 1 if it is the second of that. Above it:
/// its edge to the first vertex is a border; shifted by 1, that to the second.
const NODE: u32 = 0x0fffffffu;
const BORDER: u32 = 0x40000000u;
/// Above a corner: the vertex after it in its triangle is one beside its own vertex; shifted by 1, the one before it.
const AFTER: u32 = 0x40000000u;

struct SplitBlock {
    /// The deviation, rounded up to 16 bits, above the depth; 0 where there is no split.
    key: u32,
    /// The vertex that is split.
    vertex: u32,
    /// Its node.
    parent: u32,
    /// What that vertex and the added one are then: a split, or a leaf. Of a vertex of the base, what that is.
    children: array<u32, 2>,
}

/// Where a vertex is that was edited, or one near.
struct Place {
    point: vec3<f32>,
    /// 1 if it is elsewhere than it was built.
    moved: u32,
    normal: vec3<f32>,
}

/// The bits of a word up to one.
fn bits_to(bit: u32) -> u32 {
    return (2u << bit) - 1u;
}
