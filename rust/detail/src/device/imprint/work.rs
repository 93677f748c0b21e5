//! Sizes of the blocks in which imprints of a submission meet.

/// The parameters of an object whose tiles are worked on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Work {
    /// Words of a block, workgroups for one and for its ring.
    pub words: u32,
    pub parts: u32,
    pub ring_parts: u32,
    /// Where rings and their entries begin in the topology.
    pub rings: u32,
    pub entries: u32,
}
