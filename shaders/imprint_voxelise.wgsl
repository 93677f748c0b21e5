// What is voxelised: the shape of the grid, how its columns are solid, and how many triangles there are.

// Bits of the flags.
const BACKWARD: u32 = 1u;
const OPEN: u32 = 2u;
const MIRRORED: u32 = 4u;

struct Voxelise {
    // Voxels along x, y and z, which the columns run along.
    nx: u32,
    ny: u32,
    nz: u32,
    flags: u32,
    triangles: u32,
}
