// What the kernels of a dab share: what is known of tiles, and of the blocks of memory that an event works on (Schäfer et
// al. 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 4).

struct BrushTile {
    // How far it is displaced at most, object units.
    reach: f32,
    // Texels a side, allocated or not.
    size: u32,
}

// Words of what is known of a block.
const BLOCK_WORDS: u32 = 8u;
// The tile that has it, or had it last.
const BLOCK_TILE: u32 = 0u;
// The dab, from 1, that it was taken for.
const BLOCK_TAKEN: u32 = 1u;
// Texels that changed, dab by dab.
const BLOCK_CHANGES: u32 = 2u;
// Bits of the dabs that changed texels, and that changed the one at each corner. Of triangles the latter are other words,
// see `triangle_brush`.
const BLOCK_DABS: u32 = 3u;
const BLOCK_CORNERS: u32 = 4u;

// A brush that is tested against tiles or triangles.
struct Intersect {
    // From object space, less the origin, to the brush's coordinates: rows with their shift.
    row_x: vec4<f32>,
    row_y: vec4<f32>,
    row_z: vec4<f32>,
    origin: vec3<f32>,
    tiles: u32,
}

// What bounds are widened by against rounding: a part of the box, and of coordinates in object space.
const SLACK: f32 = 0.002;
const ROUNDING: f32 = 1e-6;

// What has no block.
const BLOCK_NONE: u32 = 0xffffffffu;

// The sets that tiles are compacted into.
const MODIFY: u32 = 1u;
const ALLOCATE: u32 = 2u;
const DEALLOCATE: u32 = 4u;

/// The sets of a tile that the brush may reach or not; it has no block, or an unchanged one that a dab before only grazed.
fn sets_of(meets: bool, block: bool, unchanged: bool) -> u32 {
    if meets {
        return select(MODIFY | ALLOCATE, MODIFY, block);
    }
    return select(0u, DEALLOCATE, block && unchanged);
}
