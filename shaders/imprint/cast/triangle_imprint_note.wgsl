// import triangle_imprint_foot
// import triangle_imprint_slot
// What is noted of the values of triangles that an imprint changes.

// What a change of value `index` of a block is noted as.
fn note_of(index: u32) -> u32 {
    let along = index - inner_count(SEGMENTS);
    if index < inner_count(SEGMENTS) || along >= 3u * (SEGMENTS - 1u) {
        return INNER;
    }
    return SIDES;
}
