// Records: the blocks of 16 × 16 coefficients that imprints changed.

// Texels along a block at most.
const EDGE: u32 = 16u;

// Invocations of a workgroup that takes a block: two coefficients each, which share a word.
const PAIRS: u32 = 128u;

const NONE: u32 = 0xffffffffu;

// Words of a record: tile, block with the number of the imprint in the upper half, coefficients that change, the least
// of all as `key`, and the coefficients.
const RECORD: u32 = 132u;
const HEADER: u32 = 4u;
