// import brush_sculpt_modes
// What a brush makes of vectors, given its weights. The same as `vector` of rust/detail.

// Of every dab: the axes of the box in object space as columns of length 1, from coordinates in the brush to object space,
// and from there to the brush.
@group(0) @binding(8) var<storage, read> bends: array<mat3x3<f32>>;

/// With the image of the brush, where neighbours are `footprint` away: the vector along the axes of the box, and the share
/// of the edit.
fn bend_stamped(place: vec3<f32>, share: f32, footprint: f32) -> vec4<f32> {
    if work.mode == SCULPT_VECTOR {
        return stamp_vector(place.xy, footprint, work.height) * vec4(vec3(1.0), share);
    }
    return vec4(0.0, 0.0, work.height, sculpt_stamped(place, share, footprint).x);
}

/// What is added where the share is 1, in object space: `vector` along the axes of the box, or the way to the line of the
/// brush from a place that has `moved` since the stroke began. Dabs that overlap go on from where those before brought the
/// places, or these would cross the line.
fn bend_change(place: vec3<f32>, vector: vec3<f32>, moved: vec3<f32>) -> vec3<f32> {
    let own = 3u * (work.dab - 1u);
    if work.mode == SCULPT_PINCH {
        let here = (bends[own + 2u] * moved).xy + place.xy;
        return bends[own + 1u] * vec3(select(-here, here, work.height < 0.0), 0.0);
    }
    return bends[own] * vector;
}

/// The new vector of a place that has `now`; `mean` is that of the neighbours, for the mode that needs it.
fn bent(now: vec3<f32>, change: vec3<f32>, mean: vec3<f32>, share: f32) -> vec3<f32> {
    switch work.mode {
        case SCULPT_SMOOTH: {
            return fma(mean - now, vec3(share), now);
        }
        case SCULPT_ERASE: {
            return fma(-now, vec3(share), now);
        }
        default: {
            return clamp(fma(change, vec3(share), now), vec3(-MAX), vec3(MAX));
        }
    }
}
