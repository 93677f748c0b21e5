// import shade
// import colors
// import grid
// import tints
// import vectors
// Displaced surfaces drawn from virtual vertices: a draw is one part of the grid for every tile of a rate, and the vertex
// stage evaluates its patch, Bézier or Gregory, with its displacement. Colours and traces are looked up at every pixel.

/// What texels of colours are: 0 for no colours, 1 for four bytes, 2 for four half floats.
override COLORS: u32 = 0u;
/// 1 where there are traces.
override TRACES: u32 = 0u;

struct TilesCall {
    /// Colour of tiles without a block of colours.
    blank: vec3<f32>,
    /// The first of its tiles.
    first: u32,
    tint: TintBlock,
}

/// Where the places on the edges of a tile are evaluated, 16 a tile: by halves of edges, 2 an edge, then corners and
/// middles of edges in turn. A tile, and in its parameters, in quarters, where the edge starts and how it goes on: four
/// bytes, each 128 more than it stands for.
@group(3) @binding(0) var<storage, read> joints: array<vec2<u32>>;
/// What is drawn: the tile; then, in four bits each, the powers of two that its sides and the edge of a strip are divided
/// into and the part (0: the whole grid, 1: cells that touch no edge, 2 to 5: the strip beside an edge), and its tag.
@group(3) @binding(1) var<storage, read> drawn_tiles: array<vec2<u32>>;
@group(3) @binding(4) var<storage, read> color_entries: array<TileEntry>;
/// Blocks of (size + 2)² texels, row by row.
@group(3) @binding(5) var<storage, read> color_texels: array<u32>;
/// Of every tile where its list is that of `Field::seams`, SEAMS_NONE for none, and its texels a side; then the lists,
/// of half floats.
@group(3) @binding(6) var<storage, read> color_seams: array<vec2<u32>>;
@group(3) @binding(7) var<storage, read> trace_entries: array<TileEntry>;
/// Blocks of (size + 2)² texels, row by row: contact and depth in half floats, and a float.
@group(3) @binding(8) var<storage, read> trace_texels: array<u32>;
var<immediate> call: TilesCall;

/// The cosine of the angle from which the normals on both sides of an edge show a sharp edge, not rounding.
const SHARP: f32 = 0.94;

const SEAMS_NONE: u32 = 0xffffffffu;
/// Texels from an edge within which the colour of a coarser tile beyond it is seen.
const SEAM_REACH: f32 = 4.0;

/// Bits of the number of a vertex of a strip, above which is which corner of its triangles it is.
const VERTEX_BITS: u32 = 20u;

/// The place at `t` from the first corner of `edge` of a tile, `depth` inside.
fn beside_edge(edge: u32, t: f32, depth: f32) -> vec2<f32> {
    switch edge {
        case 0u: { return vec2(t, depth); }
        case 1u: { return vec2(1.0 - depth, t); }
        case 2u: { return vec2(1.0 - t, 1.0 - depth); }
        default: { return vec2(depth, 1.0 - t); }
    }
}

/// The number in the four bits of `bits` from `from` on.
fn nibble(bits: u32, start: u32) -> u32 {
    return (bits >> start) & 15u;
}

@vertex
fn vertex_tiles(@builtin(vertex_index) sample: u32, @builtin(instance_index) instance: u32) -> Shaded {
    let drawn = drawn_tiles[call.first + instance];
    let rate = 1u << nibble(drawn.y, 0u);
    let part = nibble(drawn.y, 8u);
    var segments = rate;
    var edge = GRID_INSIDE;
    var at = 0u;
    var uv: vec2<f32>;
    var grid: vec3<f32>;
    if part < 2u {
        let side = rate + 1u - 2u * part;
        // Rows, of whole numbers that floats hold: devices divide these faster.
        let row = u32((f32(sample) + 0.5) / f32(side));
        let i = part + sample - row * side;
        let j = part + row;
        let found = grid_edge(i, j, rate);
        edge = found.x;
        at = found.y;
        uv = vec2(f32(i), f32(j)) / f32(rate);
        // Diagonals go from the first corner of a cell to the third, but beside the first edge and the third the other way.
        let bent = select(0.0, 2.0, j == rate && i < rate) - select(0.0, 2.0, j == 0u && i > 0u);
        grid = vec3(f32(i), f32(j), f32(i) - f32(j) + select(0.0, bent, part == 0u));
    } else {
        segments = 1u << nibble(drawn.y, 4u);
        let number = sample & ((1u << VERTEX_BITS) - 1u);
        let corner = sample >> VERTEX_BITS;
        if number <= segments {
            edge = part - 2u;
            at = number;
        } else {
            uv = beside_edge(part - 2u, f32(number - segments) / f32(rate), 1.0 / f32(rate));
        }
        grid[corner] = 0.5;
    }
    var place = uv;
    var tile = drawn.x;
    if edge < GRID_INSIDE {
        // All sides of an edge divide it alike, and evaluate it in the same tile.
        let t = f32(at) / f32(segments);
        uv = beside_edge(edge, t, 0.0);
        place = uv;
        var number = 2u * edge + select(0u, 1u, 2u * at > segments);
        if at == 0u || at == segments {
            number = 8u + 2u * ((edge + select(0u, 1u, at == segments)) % 4u);
        } else if 2u * at == segments {
            number = 9u + 2u * edge;
        }
        let joint = joints[16u * drawn.x + number];
        let quarters = vec4<f32>((vec4(joint.y) >> vec4(0u, 8u, 16u, 24u)) & vec4(255u)) - vec4(128.0);
        tile = joint.x;
        place = 0.25 * (quarters.xy + quarters.zw * t);
    }
    let point = vectors_displaced(tile, place);
    var normal = point.normal;
    if tile != drawn.x || any(place != uv) {
        let own = vectors_displaced(drawn.x, uv).normal;
        if dot(own, normal) < SHARP {
            normal = own;
        }
    }
    return shaded(point.p, normal, grid, uv, drawn.x, drawn.y >> 20u);
}

/// The cell of texels around a place of a tile of `size` texels, and where the place is between them.
struct Around {
    at: u32,
    stride: u32,
    f: vec2<f32>,
}

fn around(size: u32, uv: vec2<f32>) -> Around {
    let x = clamp(uv, vec2(0.0), vec2(1.0)) * f32(size) + vec2(0.5);
    let cell = min(vec2<u32>(x), vec2(size));
    return Around(cell.y * (size + 2u) + cell.x, size + 2u, x - vec2<f32>(cell));
}

fn color_texel(first: u32, index: u32) -> vec3<f32> {
    if COLORS == 1u {
        return color_of(vec2(color_texels[first + index], 0u), false).xyz;
    }
    let at = first + 2u * index;
    return color_of(vec2(color_texels[at], color_texels[at + 1u]), true).xyz;
}

/// What a list of seams has at a whole number.
fn seam_item(at: u32) -> vec3<f32> {
    let words = color_seams[at];
    return vec3(unpack2x16float(words.x), unpack2x16float(words.y).x);
}

/// What coarser tiles around it add to the colour of a tile.
fn seam_at(tile: u32, uv: vec2<f32>) -> vec3<f32> {
    let list = color_seams[tile];
    if list.x == SEAMS_NONE {
        return vec3(0.0);
    }
    let size = f32(list.y);
    let weights = max(vec4(0.0), vec4(1.0) - vec4(uv.y, 1.0 - uv.x, 1.0 - uv.y, uv.x) * (size / SEAM_REACH));
    let along = vec4(uv.x, uv.y, 1.0 - uv.x, 1.0 - uv.y) * (2.0 * size);
    var sum = vec3(0.0);
    for (var edge = 0u; edge < 4u; edge++) {
        if weights[edge] > 0.0 {
            let k = min(u32(along[edge]), 2u * list.y - 1u);
            let at = list.x + 4u + edge * (2u * list.y + 1u) + k;
            sum += weights[edge] * mix(seam_item(at), seam_item(at + 1u), along[edge] - f32(k));
        }
        let both = weights[edge] * weights[(edge + 3u) & 3u];
        if both > 0.0 {
            sum -= both * seam_item(list.x + edge);
        }
    }
    return sum;
}

/// The colour between the four texels around a place, as `Field::color` has it.
fn color_at(tile: u32, place: vec2<f32>) -> vec3<f32> {
    let uv = clamp(place, vec2(0.0), vec2(1.0));
    let entry = color_entries[tile];
    var color = call.blank;
    if entry.first != TILES_NONE {
        let it = around(entry.size, uv);
        let low = mix(color_texel(entry.first, it.at), color_texel(entry.first, it.at + 1u), it.f.x);
        let next = it.at + it.stride;
        let high = mix(color_texel(entry.first, next), color_texel(entry.first, next + 1u), it.f.x);
        color = mix(low, high, it.f.y);
    }
    return color + seam_at(tile, uv);
}

fn trace_texel(first: u32, index: u32) -> vec3<f32> {
    let at = first + 2u * index;
    return vec3(unpack2x16float(trace_texels[at]), bitcast<f32>(trace_texels[at + 1u]));
}

/// The trace between the four texels around a place, as `Field::mark` has it: contact, depth, moment.
fn trace_at(tile: u32, uv: vec2<f32>) -> vec3<f32> {
    let entry = trace_entries[tile];
    if entry.first == TILES_NONE {
        return vec3(0.0);
    }
    let it = around(entry.size, uv);
    let low = mix(trace_texel(entry.first, it.at), trace_texel(entry.first, it.at + 1u), it.f.x);
    let next = it.at + it.stride;
    let high = mix(trace_texel(entry.first, next), trace_texel(entry.first, next + 1u), it.f.x);
    return mix(low, high, it.f.y);
}

@fragment
fn fragment(in: Shaded, @builtin(front_facing) front: bool) -> Pixel {
    var albedo = object.base_color;
    if COLORS > 0u {
        albedo = color_at(in.part, in.uv);
    }
    if TRACES > 0u {
        albedo = tint_over(albedo, trace_at(in.part, in.uv), call.tint);
    }
    return pixel(in, front, albedo);
}
