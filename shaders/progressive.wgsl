// import common
// A progressive mesh on a device. A vertex has the number of the first of its leaves, and a split that of the vertex it
// adds, so that a bit a number says both which vertices there are and which splits are made.

/// In place of the key of a vertex of the base, which is always there.
const ALWAYS: u32 = 0xffffffffu;
/// In place of a split: a leaf.
const LEAF: u32 = 0x80000000u;

struct Split {
    /// The deviation, rounded up to 16 bits, above the depth; 0 where there is no split.
    key: u32,
    /// The vertex that is split.
    vertex: u32,
    /// What that vertex and the added one are then: a split, or a leaf. Of a vertex of the base, what that is.
    children: array<u32, 2>,
}

/// The number of an invocation among all.
fn linear_item(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return linear_group(group, groups) * GROUP + local;
}

/// The bits of a word up to one.
fn bits_to(bit: u32) -> u32 {
    return (2u << bit) - 1u;
}
