// import imprint_rim_list
// import triangles
// The cells of space that the values of triangles which an imprint pushed are in, and those at the border: beside which in
// any triangle others may not be pushed.

/// Segments of a side.
override SEGMENTS: u32 = 64u;

// Whether a value of a triangle's block is pushed; what is not around the contact is not.
fn is_pushed(face: u32, index: u32) -> bool {
    let piece = piece_of(face, index / 256u);
    return piece != NONE && has_bit(piece, PUSHED, index % 256u);
}

fn is_at_border(_piece: u32, it: Patchwork, k: u32) -> bool {
    let node = node_of(it.tile, SEGMENTS, 256u * it.block + k);
    let others = sharing(it.tile, node);
    var alone = false;
    for (var other = 0u; other < max(others.count, 1u); other++) {
        var seen = node;
        var face = it.tile;
        if others.count > 0u {
            let item = mesh_words[others.first + other];
            seen = node_from(it.tile, SEGMENTS, node, item);
            face = item / 3u;
        }
        for (var i = 0u; i < ring_count(SEGMENTS, seen); i++) {
            alone = alone || !is_pushed(face, value_of(face, SEGMENTS, ring_node(SEGMENTS, seen, i)));
        }
    }
    return alone;
}
