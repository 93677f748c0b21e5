// Vertices of grids.

/// In place of an edge.
const GRID_INSIDE: u32 = 4u;

/// The edge that vertex (i, j) of a grid of n cells a side is on, and how many cells it is from where that begins; at a
/// corner an edge begins.
fn grid_edge(i: u32, j: u32, n: u32) -> vec2<u32> {
    if j == 0u && i < n {
        return vec2(0u, i);
    }
    if i == n && j < n {
        return vec2(1u, j);
    }
    if j == n && i > 0u {
        return vec2(2u, n - i);
    }
    if i == 0u {
        return vec2(3u, n - j);
    }
    return vec2(GRID_INSIDE, 0u);
}
