// import triangles
// import brush_bend_modes
// import brush_smear
// A brush at every value of the triangles to modify (Schäfer et al. 2015, *Local Painting and Deformation of Meshes on the
// GPU*, Section 6.2). A triangle's block has the values of its sides and corners too: a value that changes is in the box, so
// that all triangles which share it are modified and come to the same bits.

/// 1 where places go by vectors.
override VECTORS: u32 = 0u;

// First words of what normals differ by from the smooth ones, where the mesh is displaced, and that, three numbers each.
@group(0) @binding(7) var<storage, read> turn_entries: array<u32>;
@group(0) @binding(8) var<storage, read> turn_values: array<f32>;
// First words of the triangles' blocks from when the stroke began, of displacement, and of those before the event.
@group(2) @binding(0) var<storage, read> begun_entries: array<u32>;
@group(2) @binding(1) var<storage, read> begun_values: array<u32>;
// As the former, of the vectors in object space, three numbers each.
@group(2) @binding(2) var<storage, read> bent_entries: array<u32>;
@group(2) @binding(3) var<storage, read> bent_values: array<f32>;
@group(3) @binding(0) var<storage, read> entries: array<u32>;
@group(3) @binding(1) var<storage, read> values: array<u32>;

// The number of a block's state that has the bits of its changed parts, see `part_of`.
const STATE_PARTS: u32 = BLOCK_CORNERS;

/// The part of a block that a value is in: its sides, its corners, its inside.
fn part_of(node: Node) -> u32 {
    return select(select(node.side, 3u + node.side, node.step == 0u), 6u, node.ring > 0u);
}

/// Notes that a value of a block changed; returns whether no other block is the first to have it.
fn note_value(face: u32, block: u32, node: Node) -> u32 {
    atomicOr(&states[BLOCK_WORDS * block + STATE_PARTS], 1u << part_of(node));
    return select(0u, 1u, is_first(face, node));
}

/// Whether no other block is the first to have a value.
fn is_first(face: u32, node: Node) -> bool {
    let others = sharing(face, node);
    return others.count == 0u || mesh_words[others.first] == 3u * face + node.side;
}

/// The displacement from when the stroke began.
fn begun_at(face: u32, node: Node) -> f32 {
    let first = begun_entries[face];
    if first == TRIANGLE_NONE {
        return 0.0;
    }
    let index = value_of(face, work.segments, node);
    let pair = unpack2x16float(begun_values[first + index / 2u]);
    return select(pair.x, pair.y, (index & 1u) == 1u);
}

/// The vector from when the stroke began, in object space.
fn offset_at(face: u32, node: Node) -> vec3<f32> {
    let first = bent_entries[face];
    if first == TRIANGLE_NONE {
        return vec3(0.0);
    }
    let at = first + 3u * value_of(face, work.segments, node);
    return vec3(bent_values[at], bent_values[at + 1u], bent_values[at + 2u]);
}

// What values are: coefficients of displacement, colours, or vectors in object space.
const HEIGHTS: u32 = 0u;
const COLORS: u32 = 1u;
const OFFSETS: u32 = 2u;

/// The words of colour `index` of a block before the event.
fn color_before(first: u32, index: u32) -> vec2<u32> {
    if edit_is(WIDE) {
        return vec2(values[first + 2u * index], values[first + 2u * index + 1u]);
    }
    return vec2(values[first + index], 0u);
}

/// What a vertex had before the dab, seen from a face that is modified.
fn value_before(face: u32, node: Node, kind: u32) -> vec4<f32> {
    let first = entries[face];
    let index = value_of(face, work.segments, node);
    let block = pointers[face];
    if block != BLOCK_NONE && !is_new(block) {
        return value_kept(block, index, kind);
    }
    if first == TRIANGLE_NONE {
        return select(vec4(0.0), work.blank, kind == COLORS);
    }
    if kind == COLORS {
        return decoded(color_before(first, index));
    }
    if kind == OFFSETS {
        let at = first + 3u * index;
        return vec4(bitcast<vec3<f32>>(vec3(values[at], values[at + 1u], values[at + 2u])), 0.0);
    }
    let pair = unpack2x16float(values[first + index / 2u]);
    return vec4(select(pair.x, pair.y, (index & 1u) == 1u), 0.0, 0.0, 0.0);
}

/// Value `index` of a block as `keep` left it.
fn value_kept(block: u32, index: u32, kind: u32) -> vec4<f32> {
    let first = arrayLength(&blocks) / 2u + block * work.room;
    if kind == OFFSETS {
        let at = first + 3u * index;
        return vec4(bitcast<vec3<f32>>(vec3(blocks[at], blocks[at + 1u], blocks[at + 2u])), 0.0);
    }
    if kind == COLORS {
        let wide = work.flags & WIDE;
        let at = first + index * (1u + wide);
        return decoded(vec2(blocks[at], select(0u, blocks[at + wide], wide == 1u)));
    }
    let pair = unpack2x16float(blocks[first + index / 2u]);
    return vec4(select(pair.x, pair.y, (index & 1u) == 1u), 0.0, 0.0, 0.0);
}

/// The mean of the neighbours of a vertex in all faces that have it.
fn mean_around(face: u32, node: Node, kind: u32) -> vec4<f32> {
    let others = sharing(face, node);
    var sum = vec4(0.0);
    var count = 0.0;
    for (var k = 0u; k < max(others.count, 1u); k++) {
        var seen = node;
        var from_face = face;
        if others.count > 0u {
            let item = mesh_words[others.first + k];
            seen = node_from(face, work.segments, node, item);
            from_face = item / 3u;
        }
        for (var i = 0u; i < ring_count(work.segments, seen); i++) {
            sum += value_before(from_face, ring_node(work.segments, seen, i), kind);
            count += 1.0;
        }
    }
    return sum / count;
}

/// How far neighbours are away across the brush: of all values of a face, an edge or a vertex alike, by the first face that
/// has it.
fn footprint_of(face: u32, node: Node) -> f32 {
    let others = sharing(face, node);
    var first = face;
    if others.count > 0u {
        first = mesh_words[others.first] / 3u;
    }
    let a = mesh_foot(mesh_corner(first, 0u)).p;
    let b = mesh_foot(mesh_corner(first, 1u)).p;
    let c = mesh_foot(mesh_corner(first, 2u)).p;
    let spacing = (distance(a, b) + distance(b, c) + distance(c, a)) / (3.0 * f32(work.segments));
    return spacing * max(length(work.row_x.xyz), length(work.row_y.xyz));
}

fn brush_at(face: u32, node: Node) -> BrushPlace {
    let foot = foot_of(face, work.segments, node);
    var p = foot.p;
    if VECTORS == 1u {
        p += offset_at(face, node);
    }
    return brush_over(p, foot.normal, begun_at(face, node));
}

/// The cosine between the normals of the mesh and of the displaced one.
fn facing_at(face: u32, node: Node, smooth_normal: vec3<f32>) -> f32 {
    let first = turn_entries[face];
    if first == TRIANGLE_NONE {
        return dot(smooth_normal, smooth_normal);
    }
    let at = first + 3u * value_of(face, work.segments, node);
    let turned = smooth_normal + vec3(turn_values[at], turn_values[at + 1u], turn_values[at + 2u]);
    let square = dot(turned, turned);
    return dot(smooth_normal, select(smooth_normal, turned / sqrt(square), square > 0.0));
}

/// The new coefficient of a vertex that has `now`.
fn sculpted_at(face: u32, node: Node, now: f32) -> f32 {
    let at = brush_at(face, node);
    var amount = vec2(at.share, work.height);
    if edit_is(STAMPED) && amount.x > 0.0 {
        amount = sculpt_stamped(at.place, amount.x, footprint_of(face, node));
    }
    if !(amount.x > 0.0) {
        return now;
    }
    var it = Sculpted(now, now - begun_at(face, node), now, 1.0);
    if work.mode == SCULPT_SMOOTH {
        it.mean = mean_around(face, node, HEIGHTS).x;
    }
    if work.mode == SCULPT_INFLATE {
        it.facing = facing_at(face, node, at.normal);
    }
    return sculpted(at, amount.x, amount.y, it);
}

/// The new colour of a vertex that has `now`.
fn painted_at(face: u32, node: Node, now: vec4<f32>) -> vec4<f32> {
    let at = brush_at(face, node);
    var tint = Tint(work.color, at.share);
    if edit_is(STAMPED) && tint.share > 0.0 {
        tint = paint_stamped(at.place, tint.share, footprint_of(face, node));
    }
    if work.mode == PAINT_SMEAR {
        return smeared_over(at, tint.share, now, is_first(face, node));
    }
    if !(tint.share > 0.0) {
        return now;
    }
    var mean = now;
    if work.mode == PAINT_BLUR {
        mean = mean_around(face, node, COLORS);
    }
    return painted(tint, now, mean);
}

// One word, two coefficients, of the block of one triangle.
@compute @workgroup_size(GROUP)
fn sculpt(id: Invocation) {
    let found = begin_edit(id.group.x + id.groups.x * id.group.z, id.local);
    if found.y != BLOCK_NONE {
        sculpt_word(found.x, found.y, id.group.y * GROUP + id.local);
    }
    finish_edit(found.y, value_count(work.segments), id.group.y == 0u, id.local);
}

fn sculpt_word(face: u32, block: u32, word: u32) {
    let all = value_count(work.segments);
    if 2u * word >= all {
        return;
    }
    let at = block * work.room + word;
    let taken = is_new(block);
    var old = 0u;
    if !taken {
        old = blocks[at];
    } else if entries[face] != TRIANGLE_NONE {
        old = values[entries[face] + word];
    }
    let pair = unpack2x16float(old);
    var new_word = 0u;
    for (var k = 0u; k < 2u; k++) {
        let half = (old >> (16u * k)) & 0xffffu;
        var bits = half;
        if 2u * word + k < all {
            let node = node_of(face, work.segments, 2u * word + k);
            let value = sculpted_at(face, node, pair[k]);
            if value != pair[k] {
                bits = half_bits(value);
            }
            if bits != half {
                note_texels(1u, note_value(face, block, node));
            }
        }
        new_word |= bits << (16u * k);
    }
    if taken || new_word != old {
        blocks[at] = new_word;
    }
}

// One colour of the block of one triangle.
@compute @workgroup_size(GROUP)
fn paint(id: Invocation) {
    let found = begin_edit(id.group.x + id.groups.x * id.group.z, id.local);
    if found.y != BLOCK_NONE {
        paint_value(found.x, found.y, id.group.y * GROUP + id.local);
    }
    finish_edit(found.y, value_count(work.segments), id.group.y == 0u, id.local);
}

fn paint_value(face: u32, block: u32, index: u32) {
    if index >= value_count(work.segments) {
        return;
    }
    let at = block * work.room + index * (1u + (work.flags & WIDE));
    let taken = is_new(block);
    var old = coded(work.blank);
    if !taken {
        old = vec2(blocks[at], 0u);
        if edit_is(WIDE) {
            old.y = blocks[at + 1u];
        }
    } else if entries[face] != TRIANGLE_NONE {
        old = color_before(entries[face], index);
    }
    let node = node_of(face, work.segments, index);
    let now = decoded(old);
    let color = painted_at(face, node, now);
    var new_words = old;
    if any(color != now) {
        new_words = coded(color);
    }
    let differs = any(new_words != old);
    if differs {
        note_texels(1u, note_value(face, block, node));
    }
    if taken || differs {
        blocks[at] = new_words.x;
        if edit_is(WIDE) {
            blocks[at + 1u] = new_words.y;
        }
    }
}

// One word of the block of one triangle, kept apart in the second half for modes that look at neighbours.
@compute @workgroup_size(GROUP)
fn keep(id: Invocation) {
    let index = id.group.x + id.groups.x * id.group.z;
    let word = id.group.y * GROUP + id.local;
    if index >= counts[0] || word >= work.room || pointers[lists[index]] == BLOCK_NONE {
        return;
    }
    let at = pointers[lists[index]] * work.room + word;
    blocks[arrayLength(&blocks) / 2u + at] = blocks[at];
}

/// The new vector of a vertex that has `now`.
fn bent_at(face: u32, node: Node, now: vec3<f32>) -> vec3<f32> {
    let at = brush_at(face, node);
    var amount = vec4(0.0, 0.0, work.height, at.share);
    if edit_is(STAMPED) && amount.w > 0.0 {
        amount = bend_stamped(at.place, amount.w, footprint_of(face, node));
    }
    if !(amount.w > 0.0) {
        return now;
    }
    var mean = now;
    if work.mode == SCULPT_SMOOTH {
        mean = mean_around(face, node, OFFSETS).xyz;
    }
    return bent(now, bend_change(at.place, amount.xyz, now - offset_at(face, node)), mean, amount.w);
}

/// The frame of the vector at a vertex, as `vectors` of rust/tiles has it: of a face along its first side, of an edge along
/// it, of a corner along the side of its first face that starts there. Columns are T, N × T and N.
fn frame_of(face: u32, node: Node) -> mat3x3<f32> {
    var ends = vec2(mesh_corner(face, 0u), mesh_corner(face, 1u));
    if node.ring == 0u && node.step == 0u {
        let first = mesh_words[mesh_around(mesh_corner(face, node.side)).first];
        ends = vec2(mesh_corner(face, node.side), mesh_corner(first / 3u, (first % 3u + 1u) % 3u));
    } else if node.ring == 0u {
        ends = vec2(mesh_corner(face, node.side), mesh_corner(face, (node.side + 1u) % 3u));
        ends = select(ends, ends.yx, (mesh_side(face, node.side) & 1u) == 1u);
    }
    let n = foot_of(face, work.segments, node).normal;
    var across = cross(n, mesh_foot(ends.y).p - mesh_foot(ends.x).p);
    let square = dot(across, across);
    if square > 0.0 {
        across /= sqrt(square);
    } else if any(n != vec3(0.0)) {
        // Any direction at right angles (Duff et al. 2017, *Building an Orthonormal Basis, Revisited*).
        let side = select(1.0, -1.0, n.z < 0.0);
        let a = -1.0 / (side + n.z);
        across = vec3(n.x * n.y * a, side + n.y * n.y * a, -n.y);
    }
    return mat3x3(cross(across, n), across, n);
}

/// The half floats that keep a vector of object space in a frame. Zeros are positive.
fn kept_halves(frame: mat3x3<f32>, vector: vec3<f32>) -> vec3<u32> {
    let own = clamp(vector * frame, vec3(-MAX), vec3(MAX));
    let halves = vec3(half_bits(own.x), half_bits(own.y), half_bits(own.z));
    return select(halves, vec3(0u), (halves & vec3(0x7fffu)) == vec3(0u));
}

// One vector of the block of one triangle.
@compute @workgroup_size(GROUP)
fn bend(id: Invocation) {
    let found = begin_edit(id.group.x + id.groups.x * id.group.z, id.local);
    if found.y != BLOCK_NONE {
        bend_value(found.x, found.y, id.group.y * GROUP + id.local);
    }
    finish_edit(found.y, value_count(work.segments), id.group.y == 0u, id.local);
}

fn bend_value(face: u32, block: u32, index: u32) {
    if index >= value_count(work.segments) {
        return;
    }
    let at = block * work.room + 3u * index;
    let taken = is_new(block);
    var old = vec3(0u);
    if !taken {
        old = vec3(blocks[at], blocks[at + 1u], blocks[at + 2u]);
    } else if entries[face] != TRIANGLE_NONE {
        let before = entries[face] + 3u * index;
        old = vec3(values[before], values[before + 1u], values[before + 2u]);
    }
    let node = node_of(face, work.segments, index);
    let now = bitcast<vec3<f32>>(old);
    let vector = bent_at(face, node, now);
    var made = old;
    var differs = false;
    if any(vector != now) && !edit_is(ROUNDED) {
        differs = true;
        made = bitcast<vec3<u32>>(vector);
    } else if any(vector != now) {
        // The next dab of the event finds it as it is kept.
        let frame = frame_of(face, node);
        let halves = kept_halves(frame, vector);
        differs = any(halves != kept_halves(frame, now));
        let held = vec3(unpack2x16float(halves.x).x, unpack2x16float(halves.y).x, unpack2x16float(halves.z).x);
        made = select(old, bitcast<vec3<u32>>(frame * held), differs);
    }
    if differs {
        note_texels(1u, note_value(face, block, node));
    }
    if taken || differs {
        blocks[at] = made.x;
        blocks[at + 1u] = made.y;
        blocks[at + 2u] = made.z;
    }
}
