// import imprint_rim_list
// The cells of space that the coefficients of tiles which an imprint pushed are in, and those at the border.

// Whether a coefficient of a tile is pushed; beyond the tile nothing is known.
fn is_pushed(piece: u32, it: Patchwork, place: vec2<i32>) -> bool {
    if any(place < vec2(0)) || any(place >= vec2(i32(it.size))) {
        return false;
    }
    let at = vec2<u32>(place);
    let block = at.y / it.edge * it.across + at.x / it.edge;
    var other = piece;
    if block != it.block {
        other = piece_of(it.tile, block);
        if other == NONE {
            return false;
        }
    }
    return has_bit(other, PUSHED, at.y % it.edge * it.edge + at.x % it.edge);
}

fn is_at_border(piece: u32, it: Patchwork, k: u32) -> bool {
    let own = vec2<i32>(vec2(it.block % it.across, it.block / it.across) * it.edge + vec2(k % it.edge, k / it.edge));
    return !(is_pushed(piece, it, own - vec2(1, 0)) && is_pushed(piece, it, own + vec2(1, 0))
        && is_pushed(piece, it, own - vec2(0, 1)) && is_pushed(piece, it, own + vec2(0, 1)));
}
