// What culling knows of a tile.

struct CullTile {
    // The least and the largest of its coefficients, ring included, object units.
    least: f32,
    most: f32,
    // Texels along an edge.
    size: u32,
    // No vector over it is longer.
    length: f32,
}
