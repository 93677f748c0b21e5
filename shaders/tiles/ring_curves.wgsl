// import ring_vertices
// Edge curves between tiles of different density, of which the coarser one's rules. The same as `edge_curve` in `ring` of
// rust/tiles.

// A coefficient of the edge curve of the coarser neighbour along a span of a finer side.
struct CurvePlace {
    tile: u32,
    edge: u32,
    span: Span,
    q: u32,
}

/// The coefficient as the neighbour sees it: the mean of its border and of its ring.
fn edge_curve(at: CurvePlace) -> vec4<f32> {
    let span = at.span;
    if !is_there(span.tile) || !is_there(at.tile) {
        return work.blank;
    }
    let ratio = span.count / span.length;
    var sum: Sum;
    var other = vec4(0.0);
    for (var k = 0u; k <= ratio; k++) {
        let own = k < ratio;
        let tile = select(span.tile, at.tile, own);
        let edge = select(span.edge, at.edge, own);
        let texel = settled_at(tile, edge, select(across(span, at.q), span.start + at.q * ratio + k, own));
        if own {
            let turn = turn_across(at.tile, at.edge, span, at.q * ratio + k, span.count);
            sum = added(sum, seen(texel, inverse(turn)));
        } else {
            other = value_of(texel);
        }
    }
    return 0.5 * (other + value_of(words_near_sum(sum, ratio)));
}

/// What an edge curve goes on with beyond an end of a span, which is the middle of a quad's edge.
fn beyond(at: CurvePlace, end: u32) -> CurvePlace {
    var place = at;
    let link = link_of(at.tile, at.edge);
    place.q = select(0u, at.span.length - 1u, end == 1u);
    if link.kind == HALVES {
        place.span = span_of(at.tile, at.edge, end);
        place.q = select(place.span.length - 1u, 0u, end == 1u);
    } else if link.kind == HALF {
        let quad = link_of(link.tiles.x, link.edges.x);
        let which = select(1u, 0u, link.second);
        place.tile = quad.tiles[which];
        place.edge = quad.edges[which];
        place.span = span_of(place.tile, place.edge, 0u);
        let starts = ring_number(place.span.ends.x) == ring_number(at.span.ends[end]);
        place.q = select(place.span.length - 1u, 0u, starts);
    }
    return place;
}

/// As `edge_curve`, with one coefficient more at each end.
fn ended_curve(tile: u32, edge: u32, span: Span, q: i32) -> vec4<f32> {
    let last = i32(span.length) - 1;
    var place = CurvePlace(tile, edge, span, u32(clamp(q, 0, last)));
    var turn = plain(false);
    // The later end wins where there is one coefficient.
    for (var k = 2u; k > 0u; k--) {
        let end = k - 1u;
        let outside = select(q < 0, last < q, end == 1u);
        let at_end = select(q == 0, q == last, end == 1u);
        if outside || at_end {
            let corner = corner_across(span, end);
            let vertex = end_of(ring_across(span, end), span.tile, corner);
            if vertex.single {
                return value_of(vertex.words);
            }
            if outside {
                place = beyond(place, end);
                if place.span.tile != span.tile {
                    turn = turn_at(span.tile, corner, FROM_OPPOSITE, false);
                }
                break;
            }
        }
    }
    let value = edge_curve(place);
    return select(value, value_seen(value, turn), FRAMED == 1u);
}

/// The ring beside a span whose neighbour is coarser, at its texel `k`: twice the subdivided edge curve less the border.
fn finer_ring(tile: u32, edge: u32, span: Span, k: u32) -> vec2<u32> {
    let steps = firstTrailingBit(span.count / span.length);
    let q = i32(k >> steps);
    var curve: array<vec4<f32>, 3>;
    for (var i = 0; i < 3; i++) {
        curve[i] = ended_curve(tile, edge, span, q + i - 1);
    }
    var before = curve[0];
    var here = curve[1];
    var after = curve[2];
    for (var step = steps; step > 0u; step--) {
        let left = 0.25 * before + 0.75 * here;
        let right = 0.75 * here + 0.25 * after;
        if ((k >> (step - 1u)) & 1u) == 0u {
            before = 0.75 * before + 0.25 * here;
            here = left;
            after = right;
        } else {
            after = 0.25 * here + 0.75 * after;
            before = left;
            here = right;
        }
    }
    let own = value_of(settled_at(tile, edge, span.start + k));
    return words_near(2.0 * value_seen(here, turn_across(tile, edge, span, k, span.count)) - own);
}
