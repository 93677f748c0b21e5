// import brush_paint_modes
// A brush that smears: what it carries, and the sums of what it picks up. The same as `smudge` of rust/detail.

// Of every picture first whether there is one, then its cells.
@group(0) @binding(8) var<storage, read> carried: array<vec4<f32>>;
// Of each cell two words of red, green, blue and alpha, and how many.
@group(0) @binding(9) var<storage, read_write> picked: array<atomic<u32>>;

const SMEAR_SIDE: u32 = 32u;
// Parts of one in which colours are added up.
const SMEAR_UNIT: f32 = 1048576.0;
const SMEAR_WORDS: u32 = 9u;

/// Where the picture that this dab leaves begins: that of its brush, or of a mirror image.
fn carried_first() -> u32 {
    return (work.flags >> SMEAR_SHIFT) * (1u + SMEAR_SIDE * SMEAR_SIDE);
}

fn carried_at(i: u32, j: u32) -> vec4<f32> {
    return carried[carried_first() + 1u + min(j, SMEAR_SIDE - 1u) * SMEAR_SIDE + min(i, SMEAR_SIDE - 1u)];
}

/// The picture that is carried, bilinear at a place of the brush.
fn smeared(place: vec2<f32>) -> vec4<f32> {
    let side = f32(SMEAR_SIDE);
    let at = clamp((vec2(0.5) + 0.5 * place) * side - vec2(0.5), vec2(0.0), vec2(side - 1.0));
    let cell = vec2<u32>(at);
    let part = at - vec2<f32>(cell);
    let low = mix(carried_at(cell.x, cell.y), carried_at(cell.x + 1u, cell.y), part.x);
    let high = mix(carried_at(cell.x, cell.y + 1u), carried_at(cell.x + 1u, cell.y + 1u), part.x);
    return mix(low, high, part.y);
}

/// Picks up a colour at a place of the brush. Sums are whole numbers of two words, so that their order does not matter.
fn pick(place: vec2<f32>, color: vec4<f32>) {
    let side = f32(SMEAR_SIDE);
    let cell = vec2<u32>(clamp((vec2(0.5) + 0.5 * place) * side, vec2(0.0), vec2(side - 1.0)));
    let first = SMEAR_WORDS * (cell.y * SMEAR_SIDE + cell.x);
    for (var channel = 0u; channel < 4u; channel++) {
        let value = clamp(color[channel], -COLOR_MOST, COLOR_MOST) * SMEAR_UNIT;
        let size = abs(value);
        var high = u32(size / 4294967296.0);
        var low = u32(size - f32(high) * 4294967296.0);
        if value < 0.0 {
            low = ~low + 1u;
            high = ~high + select(0u, 1u, low == 0u);
        }
        let before = atomicAdd(&picked[first + 2u * channel], low);
        atomicAdd(&picked[first + 2u * channel + 1u], high + select(0u, 1u, before + low < before));
    }
    atomicAdd(&picked[first + 8u], 1u);
}

/// The new colour of a place that has `now`, with a share of the edit; one that `counts` is picked up.
fn smeared_over(at: BrushPlace, share: f32, now: vec4<f32>, counts: bool) -> vec4<f32> {
    let left = share * carried[carried_first()].x;
    let color = select(now, painted(Tint(smeared(at.place.xy), left), now, now), left > 0.0);
    if counts && at.share > 0.0 {
        pick(at.place.xy, color);
    }
    return color;
}
