// import ring_links
// import ring_texels
// What tiles see of texels of their neighbours: what is wound the other way changes its sign, and vectors are turned from one
// frame to the other. The same as `frame` of rust/tiles, with its sums and products one by one. The processor turns in 53
// digits, which are two numbers here.

// Of every tile the angles between its tangents at 33 points of edge 1 and of edge 3, then of every corner three turns at its
// vertex, a cosine and a sine each: to the frame of the ring's first tile, back, and from the tile whose texel it copies.
@group(0) @binding(9) var<storage, read> turns: array<f32>;

const TURN_STEPS: u32 = 32u;
const TURN_CORNERS: u32 = 66u;
const TURN_NUMBERS: u32 = 90u;
const TO_FIRST: u32 = 0u;
const FROM_FIRST: u32 = 2u;
const FROM_OPPOSITE: u32 = 4u;

const PI: f32 = 3.1415927;
const FRAC_2_PI: f32 = 0.63661975;

struct Turn {
    flips: bool,
    cosine: f32,
    sine: f32,
}

// A sum: the nearest number, and what that lacks.
struct Sum {
    high: vec4<f32>,
    low: vec4<f32>,
}

// A number that is rounded before anything is added to it: compilers may fuse products, and leave out what they think is
// nothing. The word is zero.
fn rounded(value: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(value) ^ work.zero);
}

fn all_rounded(value: vec4<f32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(bitcast<vec4<u32>>(value) ^ vec4(work.zero));
}

/// The sum of two numbers (Knuth, *The Art of Computer Programming*, volume 2, Section 4.2.2, Theorem B).
fn sum_of(a: vec4<f32>, b: vec4<f32>) -> Sum {
    let sum = all_rounded(a + b);
    let part = all_rounded(sum - a);
    return Sum(sum, (a - all_rounded(sum - part)) + (b - part));
}

fn added(a: Sum, b: Sum) -> Sum {
    if FRAMED == 0u {
        return Sum(a.high + b.high, vec4(0.0));
    }
    let sum = sum_of(a.high, b.high);
    return Sum(sum.high, sum.low + (a.low + b.low));
}

/// The texel nearest to a sum over a power of two.
fn words_near_sum(sum: Sum, power: u32) -> vec2<u32> {
    if FRAMED == 0u {
        return words_near(sum.high / f32(power));
    }
    let held = sum_of(sum.high, sum.low);
    // Odd where it is not exact, so that rounding it again is as if it had all digits.
    let bits = bitcast<vec4<u32>>(held.high);
    let below = (bits ^ bitcast<vec4<u32>>(held.low)) >= vec4(0x80000000u);
    let exact = (held.low == vec4(0.0)) | ((bits & vec4(1u)) == vec4(1u));
    let odd = bitcast<vec4<f32>>(select(select(bits + vec4(1u), bits - vec4(1u), below), bits, exact));
    return words_near(vec4(over(odd.x, power), over(odd.y, power), over(odd.z, power), 0.0));
}

fn plain(flips: bool) -> Turn {
    return Turn(flips, 1.0, 0.0);
}

fn turn_of(flips: bool, angle: f32) -> Turn {
    let quarters = round(angle * FRAC_2_PI);
    var r = angle - rounded(quarters * 1.5703125);
    r -= rounded(quarters * 4.837513e-4);
    r -= rounded(quarters * 7.54979e-8);
    let square = rounded(r * r);
    var sine = 2.7557319e-6 + rounded(-2.5052108e-8 * square);
    sine = -1.984127e-4 + rounded(sine * square);
    sine = 8.333334e-3 + rounded(sine * square);
    sine = -1.6666667e-1 + rounded(sine * square);
    sine = r + rounded(rounded(r * square) * sine);
    var cosine = 2.4801587e-5 + rounded(-2.7557319e-7 * square);
    cosine = -1.3888889e-3 + rounded(cosine * square);
    cosine = 4.1666668e-2 + rounded(cosine * square);
    cosine = -0.5 + rounded(cosine * square);
    cosine = 1.0 + rounded(square * cosine);
    let quarter = u32(i32(quarters)) & 3u;
    let swapped = select(vec2(cosine, sine), vec2(-sine, cosine), (quarter & 1u) == 1u);
    let turned = select(swapped, -swapped, quarter >= 2u);
    return Turn(flips, turned.x, turned.y);
}

fn inverse(turn: Turn) -> Turn {
    // A reflection undoes itself.
    return Turn(turn.flips, turn.cosine, select(-turn.sine, turn.sine, turn.flips));
}

/// One of the turns at a corner of a tile.
fn turn_at(tile: u32, corner: u32, which: u32, flips: bool) -> Turn {
    if FRAMED == 0u {
        return plain(flips);
    }
    let at = TURN_NUMBERS * tile + TURN_CORNERS + 6u * (corner & 3u) + which;
    return Turn(flips, turns[at], turns[at + 1u]);
}

/// The angle from the direction of an edge to the tangent, about the tile's normal.
fn angle_at(tile: u32, edge: u32, t: f32) -> f32 {
    let last = edge == 3u;
    let x = clamp(select(t, 1.0 - t, last), 0.0, 1.0) * f32(TURN_STEPS);
    let step = min(u32(x), TURN_STEPS - 1u);
    let at = TURN_NUMBERS * tile + select(0u, TURN_STEPS + 1u, last) + step;
    let between = turns[at] + rounded(rounded(turns[at + 1u] - turns[at]) * (x - f32(step)));
    if (edge & 1u) == 0u {
        return select(0.0, PI, edge == 2u);
    }
    return select(-between, PI - between, last);
}

/// From the neighbour's frame to that of a tile at texel `q` of `count` of their span.
fn turn_across(tile: u32, edge: u32, span: Span, q: u32, count: u32) -> Turn {
    if FRAMED == 0u {
        return plain(span.reversed);
    }
    let along = over(f32(q) + 0.5, count);
    let own = over(f32(span.start) + along * f32(span.count), size_of(tile));
    let there = f32(span.first) + select(1.0 - along, along, span.reversed) * f32(span.length);
    let a = angle_at(tile, edge, own);
    let b = angle_at(span.tile, span.edge, over(there, size_of(span.tile)));
    return turn_of(span.reversed, select(rounded(b + PI) - a, -b - a, span.reversed));
}

/// A texel that is no vector, as a neighbour sees it that is wound the other way if `flips`.
fn words_flipped(words: vec2<u32>, flips: bool) -> vec2<u32> {
    let changes = flips && work.format == 0u && (words.x & 0x7fffu) != 0u;
    return vec2(words.x ^ select(0u, 0x8000u, changes), words.y);
}

/// The value that a neighbour sees of a texel, all its digits.
fn seen(words: vec2<u32>, turn: Turn) -> Sum {
    if FRAMED == 0u {
        return Sum(value_of(words_flipped(words, turn.flips)), vec4(0.0));
    }
    // The upper halves of cosine and sine, and the lower ones: products with half floats are exact.
    let whole = vec2(turn.cosine, turn.sine);
    let upper = bitcast<vec2<f32>>(bitcast<vec2<u32>>(whole) & vec2(0xfffff000u));
    let lower = whole - upper;
    let value = value_of(words);
    let sign = select(1.0, -1.0, turn.flips);
    let x = value.x;
    let y = sign * value.y;
    let sum = sum_of(vec4(x * upper, sign * value.z, 0.0), vec4(-y * upper.y, y * upper.x, 0.0, 0.0));
    return Sum(sum.high, sum.low + vec4(x * lower.x - y * lower.y, x * lower.y + y * lower.x, 0.0, 0.0));
}

/// The nearest texel to what a neighbour sees of one.
fn words_seen(words: vec2<u32>, turn: Turn) -> vec2<u32> {
    if FRAMED == 0u {
        return words_flipped(words, turn.flips);
    }
    return words_near_sum(seen(words, turn), 1u);
}

/// A value as a neighbour sees it.
fn value_seen(value: vec4<f32>, turn: Turn) -> vec4<f32> {
    if FRAMED == 0u {
        return select(value, -value, turn.flips && work.format == 0u);
    }
    let sign = select(1.0, -1.0, turn.flips);
    let y = sign * value.y;
    return vec4(
        value.x * turn.cosine - y * turn.sine,
        value.x * turn.sine + y * turn.cosine,
        sign * value.z,
        0.0,
    );
}
