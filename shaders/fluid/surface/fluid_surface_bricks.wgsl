// import fluid_surface
// The bricks that particles reach.

/// Their numbers, rising.
@group(0) @binding(0) var<storage, read> bricks: array<u32>;

/// The first whose number is not below another.
fn first_brick(number: u32) -> u32 {
    var low = 0u;
    var high = surface.bricks;
    while low < high {
        let middle = (low + high) / 2u;
        if bricks[middle] < number {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}
