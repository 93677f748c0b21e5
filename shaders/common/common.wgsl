// import invocation
// What all kernels share.

/// Items of a workgroup in one dimension.
const GROUP: u32 = 256u;

/// The number of a workgroup whose dispatch is spread over x and y.
fn linear_group(id: Invocation) -> u32 {
    return id.group.x + id.group.y * id.groups.x;
}

/// The number of an invocation among all.
fn linear_item(id: Invocation) -> u32 {
    return linear_group(id) * GROUP + id.local;
}

/// The nearest half float, ties to even, as bits; too large numbers become infinity. What devices have for it may round
/// either way.
fn half_bits(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    let sign = (bits >> 16u) & 0x8000u;
    let size = bits & 0x7fffffffu;
    if size >= 0x47800000u {
        return sign | select(0x7c00u, 0x7e00u, size > 0x7f800000u);
    }
    // The bits that stay, before rounding, and the bits that go.
    var kept = (size >> 13u) - 0x1c000u;
    var gone = size << 19u;
    if size < 0x38800000u {
        // Below 2^-14 steps are equal: 2^-24 each. All of what is below half a step is none.
        let shift = 126u - (size >> 23u);
        if shift > 24u {
            return sign;
        }
        let whole = (size & 0x7fffffu) | 0x800000u;
        kept = select(whole >> shift, 0u, shift == 24u);
        gone = whole << (32u - shift);
    }
    let up = gone > 0x80000000u || (gone == 0x80000000u && (kept & 1u) == 1u);
    return sign | (kept + select(0u, 1u, up));
}
