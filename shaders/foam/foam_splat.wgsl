// import foam
// Passes 3 and 4: sprites of particles drawn into the depth of the nearest one and into thickness, as depth.rs and
// thickness.rs (Akinci et al. 2013, Sections 2.1 and 2.2).
//
// A chunk of particles is drawn in four steps. The first one adds thickness and lowers depths. Of particles that lowered or
// reached a depth, the others find the lowest number, then the lowest place on the disc, and take that fragment, so that
// no order of particles matters. All steps are one kernel, in which a depth is computed by the same instructions.

/// Steps of a chunk; the last one takes fragments.
const ADD: u32 = 0u;
const NUMBER: u32 = 1u;
const PLACE: u32 = 2u;
/// Sizes that particles have.
const SIZES: u32 = 5u;
/// The radius in pixels of the smallest sprite that is drawn.
const MIN_RADIUS: f32 = 0.5;
/// Pixels from the corner of the picture beyond which no sprite is.
const FARTHEST: f32 = 1e6;
/// Pixels of the box of a sprite that one invocation draws; a workgroup draws 64 rows of a larger one.
const NARROW: u32 = 1024u;
const STRIP: u32 = 64u;
/// The largest number below 1: thickness of a fragment stays within a word.
const ALMOST: f32 = 0.99999994;
const NONE: u32 = 0xffffffffu;
/// Workgroups in x, as in rust/gpu.
const ROW: u32 = 32768u;

/// A particle in eye space, in m.
struct FoamRow {
    x: f32,
    y: f32,
    z: f32,
    life: f32,
    id: u32,
    kind: u32,
}

struct FoamChunk {
    count: u32,
    step: u32,
    /// What thickness is multiplied by.
    share: f32,
    /// Where the list of wide sprites begins.
    room: u32,
}

/// Falloffs of spray, foam and bubbles, and that of the attenuation.
@group(1) @binding(0) var<storage, read> tables: array<f32>;
@group(1) @binding(1) var<storage, read> rows: array<FoamRow>;
/// Particles that lowered a depth, and those with wide sprites.
@group(1) @binding(2) var<storage, read_write> lists: array<u32>;
/// How many there are of both.
@group(1) @binding(3) var<storage, read_write> counts: array<atomic<u32>, 2>;
/// Workgroups for the lists.
@group(2) @binding(0) var<storage, read_write> arguments: array<u32, 6>;
var<immediate> chunk: FoamChunk;

struct Sprite {
    middle: vec2<f32>,
    depth: f32,
    radius: f32,
    search: f32,
    drawn: f32,
    share: f32,
    kind: u32,
    id: u32,
    /// Columns and rows: the first ones and those after the last ones; none of what is not drawn.
    low: vec2<u32>,
    high: vec2<u32>,
}

fn share_of_life(life: f32) -> f32 {
    if life <= 0.0 {
        return 1.0;
    }
    if life > 1.0 {
        return 0.0;
    }
    return power(max(1.0 - power(life, look.lifetime_n), 0.0), look.lifetime_m);
}

fn sprite_of(row: FoamRow) -> Sprite {
    var sprite: Sprite;
    let place = vec3(row.x, row.y, row.z);
    sprite.middle = to_picture(place);
    let is_seen = place.z >= look.near_depth && place.z < FARTHEST_DEPTH
        && abs(sprite.middle.x) < FARTHEST && abs(sprite.middle.y) < FARTHEST;
    if !is_seen {
        return sprite;
    }
    sprite.depth = place.z;
    sprite.radius = look.radius / f32(row.id % SIZES + 1u) * select(1.0, 0.5, row.kind == 2u);
    sprite.search = sprite.radius * scale_at(place.z);
    let blur = 0.5 * look.aperture * abs(place.z - look.focus) / place.z * scale_at(look.focus);
    sprite.drawn = sprite.search;
    if blur > 0.0 {
        sprite.drawn = sqrt(sprite.search * sprite.search + blur * blur);
    }
    sprite.drawn = max(sprite.drawn, MIN_RADIUS);
    let thinner = sprite.search / sprite.drawn;
    sprite.share = share_of_life(row.life) * thinner * thinner * chunk.share;
    sprite.kind = min(row.kind, 2u);
    sprite.id = row.id;
    if sprite.share <= 0.0 {
        return sprite;
    }
    let size = vec2(f32(look.width), f32(look.height));
    let reach = vec2(sprite.drawn);
    sprite.low = vec2<u32>(clamp(ceil(sprite.middle - reach - 0.5), vec2(0.0), size));
    sprite.high = vec2<u32>(clamp(floor(sprite.middle + reach - 0.5) + 1.0, vec2(0.0), size));
    return sprite;
}

fn falloff_at(table: u32, x: f32) -> f32 {
    let place = x * f32(ENTRIES - 1u);
    let cell = min(u32(place), ENTRIES - 2u);
    let low = tables[table * ENTRIES + cell];
    return low + (place - f32(cell)) * (tables[table * ENTRIES + cell + 1u] - low);
}

/// Adds the thickness of a fragment to a pixel, before which the surface of the fluid has a depth.
fn thicken(at: u32, sprite: Sprite, square: f32, behind: f32) {
    var value = sprite.share * falloff_at(sprite.kind, sqrt(square));
    if behind > 0.0 {
        value *= select(0.0, falloff_at(3u, min(behind / look.eta_max, 1.0)), behind < look.eta_max);
    }
    let fixed = u32(clamp(value, 0.0, ALMOST) * 4294967296.0);
    if fixed > 0u {
        let before = atomicAdd(&pixels[at].low, fixed);
        if before > NONE - fixed {
            atomicAdd(&pixels[at].high, 1u);
        }
    }
}

/// Draws a pixel of a sprite. Returns whether it lowered or reached the depth there.
fn draw(sprite: Sprite, x: u32, y: u32) -> bool {
    let inverse = 1.0 / sprite.drawn;
    let u = (f32(x) + 0.5 - sprite.middle.x) * inverse;
    let v = (sprite.middle.y - f32(y) - 0.5) * inverse;
    let square = u * u + v * v;
    if square > 1.0 {
        return false;
    }
    let depth = sprite.depth - sqrt(1.0 - square) * sprite.radius;
    let at = y * look.width + x;
    let front = fronts[at];
    if depth > front.w {
        return false;
    }
    let own = rising(depth);
    // Where depth and number are equal, so is v but for its sign.
    let key = (rising(u + 0.0) & 0xfffffffeu) | u32(v > 0.0);
    if chunk.step == ADD {
        thicken(at, sprite, square, depth - front.z);
        if own > atomicLoad(&pixels[at].depth) {
            return false;
        }
        let before = atomicMin(&pixels[at].depth, own);
        if own < before {
            atomicStore(&pixels[at].id, NONE);
            atomicStore(&pixels[at].key, NONE);
        }
        return own <= before;
    }
    if own != atomicLoad(&pixels[at].depth) {
        return false;
    }
    if chunk.step == NUMBER {
        let before = atomicMin(&pixels[at].id, sprite.id);
        if sprite.id < before {
            atomicStore(&pixels[at].key, NONE);
        }
        return false;
    }
    if sprite.id != atomicLoad(&pixels[at].id) {
        return false;
    }
    if chunk.step == PLACE {
        atomicMin(&pixels[at].key, key);
    } else if key == atomicLoad(&pixels[at].key) {
        pixels[at].search = sprite.search;
        pixels[at].u = u;
        pixels[at].v = v;
    }
    return false;
}

/// Makes all pixels empty.
@compute @workgroup_size(GROUP)
fn begin(id: Invocation) {
    let at = linear_item(id);
    if at >= look.width * look.height {
        return;
    }
    atomicStore(&pixels[at].depth, rising(FARTHEST_DEPTH));
    atomicStore(&pixels[at].id, NONE);
    atomicStore(&pixels[at].key, NONE);
    atomicStore(&pixels[at].low, 0u);
    atomicStore(&pixels[at].high, 0u);
    pixels[at].search = 0.0;
    pixels[at].u = 0.0;
    pixels[at].v = 0.0;
}

/// Draws small sprites: all of a chunk, and later those of the first list. Wide ones go into the second list.
@compute @workgroup_size(GROUP)
fn narrow(id: Invocation) {
    let item = linear_item(id);
    var particle = item;
    if chunk.step == ADD {
        if item >= chunk.count {
            return;
        }
    } else {
        if item >= atomicLoad(&counts[0]) {
            return;
        }
        particle = lists[item];
    }
    let sprite = sprite_of(rows[particle]);
    if any(sprite.low >= sprite.high) {
        return;
    }
    let size = sprite.high - sprite.low;
    if size.x * size.y > NARROW {
        let place = atomicAdd(&counts[1], 1u);
        lists[chunk.room + place] = particle;
        return;
    }
    var is_near = false;
    for (var y = sprite.low.y; y < sprite.high.y; y++) {
        for (var x = sprite.low.x; x < sprite.high.x; x++) {
            is_near = draw(sprite, x, y) || is_near;
        }
    }
    if is_near {
        let place = atomicAdd(&counts[0], 1u);
        lists[place] = particle;
    }
}

/// Makes the sizes of the dispatches over both lists.
@compute @workgroup_size(1)
fn arrange() {
    let near = (atomicLoad(&counts[0]) + GROUP - 1u) / GROUP;
    let wide = atomicLoad(&counts[1]);
    arguments[0] = min(near, ROW);
    arguments[1] = (near + ROW - 1u) / ROW;
    arguments[2] = 1u;
    arguments[3] = min(wide, ROW);
    arguments[4] = (wide + ROW - 1u) / ROW;
    arguments[5] = (look.height + STRIP - 1u) / STRIP;
}

/// Draws wide sprites: a workgroup has 64 rows of one.
@compute @workgroup_size(GROUP)
fn wide(id: Invocation) {
    let item = linear_group(id);
    if item >= atomicLoad(&counts[1]) {
        return;
    }
    let sprite = sprite_of(rows[lists[chunk.room + item]]);
    let top = max(sprite.low.y, id.group.z * STRIP);
    let bottom = min(sprite.high.y, (id.group.z + 1u) * STRIP);
    if top >= bottom {
        return;
    }
    let width = sprite.high.x - sprite.low.x;
    for (var at = id.local; at < width * (bottom - top); at += GROUP) {
        draw(sprite, sprite.low.x + at % width, top + at / width);
    }
}
