// import common
// Bits that a workgroup finds together.

var<workgroup> bit_words: array<atomic<u32>, 8>;

/// The word of 32 bits in which an invocation has one, from all that have theirs there.
fn gathered(local: u32, bit: bool) -> u32 {
    if local < 8u {
        atomicStore(&bit_words[local], 0u);
    }
    workgroupBarrier();
    if bit {
        atomicOr(&bit_words[local / 32u], 1u << (local % 32u));
    }
    workgroupBarrier();
    return atomicLoad(&bit_words[local / 32u]);
}
