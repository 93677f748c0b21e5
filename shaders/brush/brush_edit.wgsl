// import common
// import brush
// import falloff
// A brush at places of a surface, and what edits of blocks share (Schäfer et al. 2015, *Local Painting and Deformation of
// Meshes on the GPU*, Sections 3 and 5.2). The same as `weights` of rust/detail.

struct Edit {
    // From object space, less the origin, to the brush's coordinates: rows with their shift.
    row_x: vec4<f32>,
    row_y: vec4<f32>,
    row_z: vec4<f32>,
    origin: vec3<f32>,
    falloff: u32,
    strength: f32,
    // What is drawn where the share is 1.
    height: f32,
    // By how much the third coordinate grows over one object unit along the brush's third axis.
    unit: f32,
    mode: u32,
    // The dab, from 1, how many words a block's room has, and bits.
    dab: u32,
    room: u32,
    flags: u32,
    // Segments along the side of a triangle; 0 on tiles.
    segments: u32,
    // The colour of the brush, and of what is not painted.
    color: vec4<f32>,
    blank: vec4<f32>,
}

// The tiles, or triangles, to modify come first, and how many they are.
@group(0) @binding(0) var<storage, read> lists: array<u32>;
@group(0) @binding(1) var<storage, read> counts: array<u32>;
@group(0) @binding(2) var<storage, read> pointers: array<u32>;
@group(0) @binding(3) var<storage, read_write> states: array<atomic<u32>>;
// Texels of the blocks, rings as they were before the event.
@group(0) @binding(4) var<storage, read_write> blocks: array<u32>;
// Tiles, their texels, and texels that changed, of every dab.
@group(0) @binding(5) var<storage, read_write> tested: array<atomic<u32>>;
var<immediate> work: Edit;

// Texels that changed, and those of them that no other block has too.
var<workgroup> changed: atomic<u32>;
var<workgroup> counted: atomic<u32>;

// Bits of the edit: colours are of half floats; the brush has an image, seen from the other side of the first axis; vectors
// in object space are left as their frames keep them. From SMEAR_SHIFT on they are the number of a picture.
const WIDE: u32 = 1u;
const STAMPED: u32 = 2u;
const TURNED_OVER: u32 = 4u;
const ROUNDED: u32 = 8u;
const SMEAR_SHIFT: u32 = 16u;

// The largest half float.
const MAX: f32 = 65504.0;

struct BrushPlace {
    // Where it is in the box.
    place: vec3<f32>,
    // How coordinates there grow over one object unit along the normal.
    rises: vec3<f32>,
    normal: vec3<f32>,
    // The part of the edit that it gets.
    share: f32,
}

fn along(row: vec4<f32>, p: vec3<f32>) -> f32 {
    return fma(row.x, p.x, fma(row.y, p.y, fma(row.z, p.z, row.w)));
}

fn turned(row: vec4<f32>, n: vec3<f32>) -> f32 {
    return fma(row.x, n.x, fma(row.y, n.y, row.z * n.z));
}

/// The brush at a point displaced by `height` along the normal.
fn brush_over(point: vec3<f32>, normal: vec3<f32>, height: f32) -> BrushPlace {
    var found: BrushPlace;
    found.normal = normal;
    let p = point - work.origin;
    found.rises = vec3(turned(work.row_x, normal), turned(work.row_y, normal), turned(work.row_z, normal));
    let still = vec3(along(work.row_x, p), along(work.row_y, p), along(work.row_z, p));
    let place = fma(vec3(height), found.rises, still);
    found.place = place;
    if all(abs(place) <= vec3(1.0)) {
        found.share = work.strength * falloff_share(work.falloff, fma(place.z, place.z, fma(place.y, place.y, place.x * place.x)));
    }
    return found;
}

fn edit_is(bit: u32) -> bool {
    return (work.flags & bit) != 0u;
}

/// The tile and the block of a workgroup that edits one of those to modify; the block may be none. All of it calls this
/// first.
fn begin_edit(index: u32, local: u32) -> vec2<u32> {
    if local == 0u {
        atomicStore(&changed, 0u);
        atomicStore(&counted, 0u);
    }
    workgroupBarrier();
    if index >= counts[0] {
        return vec2(0u, BLOCK_NONE);
    }
    let tile = lists[index];
    return vec2(tile, pointers[tile]);
}

/// Whether a block was taken for this dab, and has nothing yet.
fn is_new(block: u32) -> bool {
    return atomicLoad(&states[BLOCK_WORDS * block + BLOCK_TAKEN]) == work.dab;
}

/// Notes in word `word` of what is known of a block that this dab changed something.
fn note_dab(block: u32, word: u32) {
    atomicOr(&states[BLOCK_WORDS * block + word], 1u << (work.dab - 1u));
}

/// Notes what an invocation changed.
fn note_texels(count: u32, of_them: u32) {
    if count > 0u {
        atomicAdd(&changed, count);
        atomicAdd(&counted, of_them);
    }
}

/// Ends the edit of a workgroup, which all of it calls last; `first` is set in one workgroup of the block of `values`.
fn finish_edit(block: u32, values: u32, first: bool, local: u32) {
    workgroupBarrier();
    if local != 0u || block == BLOCK_NONE {
        return;
    }
    let dab = 3u * (work.dab - 1u);
    let count = atomicLoad(&changed);
    if count > 0u {
        atomicAdd(&states[BLOCK_WORDS * block + BLOCK_CHANGES], count);
        note_dab(block, BLOCK_DABS);
        atomicAdd(&tested[dab + 2u], atomicLoad(&counted));
    }
    if first {
        atomicAdd(&tested[dab], 1u);
        atomicAdd(&tested[dab + 1u], values);
    }
}
