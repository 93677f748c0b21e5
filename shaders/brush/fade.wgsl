// import colors
// What is left of edits that fade (Schäfer et al. 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 7.2).
// The same as `decay` of rust/tiles.

struct Fade {
    // The time in seconds, in two parts, when edits begin to fade and how long they take.
    time: f32,
    rest: f32,
    delay: f32,
    duration: f32,
    // What is left in the end: a colour, or a coefficient of displacement.
    blank: vec4<f32>,
    // What texels are: 0 half floats, 1 colours of 8 bits, 2 those of half floats.
    format: u32,
}

// Of every tile the first word of its texels, which its stamps follow, how many texels it has, and where what is left of
// them goes.
@group(0) @binding(0) var<storage, read> jobs: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read> stamped: array<u32>;
@group(0) @binding(2) var<storage, read_write> faded: array<u32>;
var<immediate> work: Fade;

/// How much is left of an edit, by its stamp.
fn left_of(stamp: u32) -> f32 {
    let age = (work.time - bitcast<f32>(stamp)) + (work.rest - work.delay);
    return 1.0 - clamp(age / work.duration, 0.0, 1.0);
}

// One word of halves, or one colour.
@compute @workgroup_size(GROUP)
fn fade(id: Invocation) {
    let job = jobs[id.group.y];
    let at = id.group.x * GROUP + id.local;
    if work.format == 0u {
        if 2u * at < job.y {
            // The last word of texels may be half empty.
            let stamps = job.x + (job.y + 1u) / 2u + 2u * at;
            let edited = unpack2x16float(stamped[job.x + at]);
            let shares = vec2(left_of(stamped[stamps]), left_of(stamped[stamps + 1u]));
            let value = fma(edited - work.blank.xx, shares, work.blank.xx);
            faded[job.z + at] = half_bits(value.x) | (half_bits(value.y) << 16u);
        }
        return;
    }
    if at >= job.y {
        return;
    }
    let wide = work.format == 2u;
    let words = select(1u, 2u, wide);
    let first = job.x + words * at;
    let share = left_of(stamped[job.x + words * job.y + at]);
    var texel = vec2(stamped[first], 0u);
    if wide {
        texel.y = stamped[first + 1u];
    }
    let color = words_of(fma(color_of(texel, wide) - work.blank, vec4(share), work.blank), wide);
    faded[job.z + words * at] = color.x;
    if wide {
        faded[job.z + words * at + 1u] = color.y;
    }
}
