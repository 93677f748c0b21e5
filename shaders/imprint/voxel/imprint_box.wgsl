// import imprint_link
// import imprint_step
// The voxels of a grid that a collider's box leaves, along the axes of the overlap.

// Of every imprint the box of the collider's points in snapped units: the largest coordinates, and the largest of their
// negatives, as words of the same order that are not zero.
@group(0) @binding(2) var<storage, read> boxes: array<u32>;

struct Solid {
    low: vec3<i32>,
    // The ones after the last.
    high: vec3<i32>,
}

// Where voxels of imprint `link`, which is worked on, may be solid; everywhere before there is a box. What is solid behind
// an open mesh is also beyond its box.
fn solid_part(link: u32) -> Solid {
    let dims = vec3<i32>(work.dims);
    if boxes[6u * link] == 0u {
        return Solid(vec3(0), dims);
    }
    var part: Solid;
    for (var axis = 0u; axis < 3u; axis++) {
        let high = i32(boxes[6u * link + axis] ^ 0x80000000u);
        let low = -i32(boxes[6u * link + 3u + axis] ^ 0x80000000u);
        let open = axis == 2u && (work.flags & OPEN) != 0u;
        part.low[axis] = select(clamp(step_of(low), 0, dims[axis]), 0, open);
        part.high[axis] = select(clamp(step_of(high), 0, dims[axis]), dims[axis], open);
    }
    return part;
}
