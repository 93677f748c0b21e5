// import shade
// import tints
// import triangles
// Displaced triangle meshes drawn from virtual vertices: a draw is a part of the pattern of every triangle that is divided
// alike. Values of edges are kept by edge, so that all faces along one come to the same bits.

/// 1 where values have colours.
override COLORS: u32 = 0u;
/// 1 where values have vectors.
override VECTORS: u32 = 0u;
/// 1 where values have traces.
override TRACES: u32 = 0u;

struct TrianglesCall {
    tint: TintBlock,
    /// The first of its parts.
    first: u32,
}

/// Of all faces, then of all edges, the first value inside and the power of two of the pattern.
@group(2) @binding(0) var<storage, read> held: array<vec2<u32>>;
/// A displacement, a normal, a colour in half floats; then a vector of object space and a trace, if there are some.
/// Those of the vertices of the mesh are the first.
@group(2) @binding(1) var<storage, read> held_values: array<u32>;
/// What is drawn: the face; then in four bits each the power of the pattern, that of a side and the part (0: the inside, 1
/// to 3: the strip beside a side, 4 to 6: the fan from the other corner over a side), and its tag.
@group(2) @binding(2) var<storage, read> drawn_parts: array<vec2<u32>>;
var<immediate> call: TrianglesCall;

/// Bits of the number of a vertex, above which is which corner of its triangles it is.
const VERTEX_BITS: u32 = 20u;

struct Painted {
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) p: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) grid: vec3<f32>,
    @location(3) color: vec3<f32>,
    @location(4) @interpolate(flat) part: u32,
    @location(5) @interpolate(flat) tag: u32,
}

fn nibble(bits: u32, start: u32) -> u32 {
    return (bits >> start) & 15u;
}

/// Where the value is of a vertex of the pattern of 2^power segments.
fn held_at(face: u32, node: Node, power: u32) -> u32 {
    if node.ring == 0u && node.step == 0u {
        return mesh_corner(face, node.side);
    }
    if node.ring == 0u {
        let side = mesh_side(face, node.side);
        let own = held[mesh_words[0] + (side >> 1u)];
        return own.x + (select(node.step, (1u << power) - node.step, (side & 1u) == 1u) << (own.y - power)) - 1u;
    }
    // The same vertex in the pattern that is kept.
    let own = held[face];
    let finer = own.y - power;
    return own.x + value_of(face, 1u << own.y, Node(node.ring << finer, node.side, node.step << finer));
}

/// The unit vector on an octahedron that was unfolded to a square; zero at its corner, which no other vector has.
fn unfolded(bits: u32) -> vec3<f32> {
    let e = unpack2x16snorm(bits);
    var v = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    let below = max(-v.z, 0.0);
    v.x += select(below, -below, v.x >= 0.0);
    v.y += select(below, -below, v.y >= 0.0);
    return select(normalize(v), vec3(0.0), all(e == vec2(1.0)));
}

@vertex
fn vertex_triangles(@builtin(vertex_index) sample: u32, @builtin(instance_index) instance: u32) -> Painted {
    let drawn = drawn_parts[call.first + instance];
    let face = drawn.x;
    let power = nibble(drawn.y, 0u);
    let along = nibble(drawn.y, 4u);
    let part = nibble(drawn.y, 8u);
    let number = sample & ((1u << VERTEX_BITS) - 1u);
    let side = (part + 2u) % 3u;
    var node: Node;
    var level = power;
    if part == 0u {
        node = node_of(face, 1u << power, number);
    } else if number <= (1u << along) {
        level = along;
        node = node_at(1u << along, 0u, side, number);
    } else if part < 4u {
        node = node_at(1u << power, 1u, side, number - (1u << along) - 1u);
    } else {
        node = Node(0u, (side + 2u) % 3u, 0u);
    }
    let foot = foot_of(face, 1u << level, node);
    let value = (4u + 3u * VECTORS + 2u * TRACES) * held_at(face, node, level);
    var p = foot.p + foot.normal * bitcast<f32>(held_values[value]);
    if VECTORS > 0u {
        p += bitcast<vec3<f32>>(vec3(held_values[value + 4u], held_values[value + 5u], held_values[value + 6u]));
    }
    var grid: vec3<f32>;
    grid[sample >> VERTEX_BITS] = 0.5;
    let out = shaded(p, unfolded(held_values[value + 1u]), grid, vec2(0.0), face, drawn.y >> 20u);
    var color = object.base_color;
    if COLORS > 0u {
        color = vec3(unpack2x16float(held_values[value + 2u]), unpack2x16float(held_values[value + 3u]).x);
    }
    if TRACES > 0u {
        let at = value + 4u + 3u * VECTORS;
        let trace = vec3(unpack2x16float(held_values[at]), bitcast<f32>(held_values[at + 1u]));
        color = tint_over(color, trace, call.tint);
    }
    return Painted(out.position, out.p, out.normal, out.grid, color, out.part, out.tag);
}

@fragment
fn fragment(in: Painted, @builtin(front_facing) front: bool) -> Pixel {
    let shape = Shaded(in.position, in.p, in.normal, in.grid, vec2(0.0), in.part, in.tag);
    return pixel(shape, front, in.color);
}
