// import shade
// import vectors
// Displaced surfaces drawn from virtual vertices: a draw is one part of the grid for every tile of a rate, and the vertex
// stage evaluates its patch, Bézier or Gregory, with its displacement. Colours are looked up at every pixel.

/// What texels of colours are: 0 where there are none, 1 for four bytes, 2 for four half floats.
override COLORS: u32 = 0u;

struct TilesCall {
    /// Colour of tiles without a block of colours.
    blank: vec3<f32>,
    /// The first of its tiles.
    first: u32,
}

/// Where the places on the edges of a tile are evaluated, 16 a tile: by halves of edges, 2 an edge, then corners and
/// middles of edges in turn. A tile, and in its parameters, in quarters, where the edge starts and how it goes on: four
/// bytes, each 128 more than it stands for.
@group(3) @binding(0) var<storage, read> joints: array<vec2<u32>>;
/// What is drawn: the tile; then, in four bits each, the powers of two that its sides and the edge of a strip are divided
/// into and the part (0: the whole grid, 1: cells that touch no edge, 2 to 5: the strip beside an edge), and its tag.
@group(3) @binding(1) var<storage, read> drawn_tiles: array<vec2<u32>>;
@group(3) @binding(2) var<storage, read> color_entries: array<TileEntry>;
/// Blocks of (size + 2)² texels, row by row.
@group(3) @binding(3) var<storage, read> color_texels: array<u32>;
var<immediate> call: TilesCall;

/// The cosine of the angle from which the normals on both sides of an edge show a sharp edge, not rounding.
const SHARP: f32 = 0.94;

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
    var edge = 4u;
    var at = 0u;
    var uv: vec2<f32>;
    var grid: vec3<f32>;
    if part < 2u {
        let side = rate + 1u - 2u * part;
        let i = part + sample % side;
        let j = part + sample / side;
        if j == 0u && i < rate {
            edge = 0u;
            at = i;
        } else if i == rate && j < rate {
            edge = 1u;
            at = j;
        } else if j == rate && i > 0u {
            edge = 2u;
            at = rate - i;
        } else if i == 0u {
            edge = 3u;
            at = rate - j;
        }
        uv = vec2(f32(i), f32(j)) / f32(rate);
        // Diagonals go from the first corner of a cell to the third.
        grid = vec3(f32(i), f32(j), f32(i) - f32(j));
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
    if edge < 4u {
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

fn linear_of(encoded: f32) -> f32 {
    return select(pow((encoded + 0.055) / 1.055, 2.4), encoded / 12.92, encoded <= 0.04045);
}

fn color_texel(first: u32, index: u32) -> vec3<f32> {
    if COLORS == 1u {
        let bytes = unpack4x8unorm(color_texels[first + index]);
        return vec3(linear_of(bytes.x), linear_of(bytes.y), linear_of(bytes.z));
    }
    let halves = unpack2x16float(color_texels[first + 2u * index]);
    return vec3(halves, unpack2x16float(color_texels[first + 2u * index + 1u]).x);
}

/// The colour between the four texels around a place.
fn color_at(tile: u32, uv: vec2<f32>) -> vec3<f32> {
    let entry = color_entries[tile];
    if entry.first == TILES_NONE {
        return call.blank;
    }
    let x = clamp(uv, vec2(0.0), vec2(1.0)) * f32(entry.size) + vec2(0.5);
    let cell = min(vec2<u32>(x), vec2(entry.size));
    let f = x - vec2<f32>(cell);
    let stride = entry.size + 2u;
    let at = cell.y * stride + cell.x;
    let low = mix(color_texel(entry.first, at), color_texel(entry.first, at + 1u), f.x);
    let high = mix(color_texel(entry.first, at + stride), color_texel(entry.first, at + stride + 1u), f.x);
    return mix(low, high, f.y);
}

@fragment
fn fragment(in: Shaded, @builtin(front_facing) front: bool) -> Pixel {
    var albedo = object.base_color;
    if COLORS > 0u {
        albedo = color_at(in.part, in.uv);
    }
    return pixel(in, front, albedo);
}
