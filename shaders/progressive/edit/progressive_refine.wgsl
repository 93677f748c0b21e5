// import progressive_follow
// Where the vertices of splits of one depth go that are made: near an edit, where the vertices around take them.

/// The vertices that there were.
@group(1) @binding(1) var<storage, read_write> before: array<u32>;

@compute @workgroup_size(GROUP)
fn refine(id: Invocation) {
    let item = linear_item(id);
    if item >= work.count {
        return;
    }
    let split = order[work.first + item];
    let was_there = (before[split / 32u] >> (split % 32u) & 1u) == 1u;
    if was_there || !is_there(split) {
        return;
    }
    let ring = ring_of(split);
    let one = splits[split].parent;
    let is_noted = note_of(2u * split).moved == 1u;
    var is_near = is_noted || place_of(one).moved == 1u;
    for (var k = ring.x; k < ring.w && !is_near; k++) {
        is_near = place_of(star(k) & NODE).moved == 1u;
    }
    let vertex = array(built(one), now(one));
    for (var side = 0u; side < 2u; side++) {
        let node = 2u * split + side;
        var place = Place(vec3(0.0), 0u, vec3(0.0));
        if is_near {
            let was = built(node);
            var origin = was;
            if is_noted {
                origin = note_of(node);
            }
            let followed = forward(surroundings(beside(ring, side), vertex), origin);
            let far = followed.point - was.point;
            let turn = followed.normal - was.normal;
            if dot(far, far) > work.least * work.least || dot(turn, turn) > MIN_TURN * MIN_TURN {
                place = followed;
            }
        }
        set_place(node, place);
    }
}
