// import fluid_surface
// The bricks that have particles, and what they have.

/// Their numbers, rising, and the first particle of each, with how many there are at the end.
@group(0) @binding(0) var<storage, read> cells: array<u32>;
@group(0) @binding(1) var<storage, read> starts: array<u32>;

/// The first of so many bricks whose number is not below another.
fn first_cell(number: u32, count: u32) -> u32 {
    var low = 0u;
    var high = count;
    while low < high {
        let middle = (low + high) / 2u;
        if cells[middle] < number {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

/// The particles of three bricks in a row, of the nine rows around a brick.
fn particles_of(number: u32, row: u32) -> vec2<u32> {
    let stride = strides();
    let begin = number + row % 3u * stride.y + row / 3u * stride.z - stride.y - stride.z - 1u;
    let first = first_cell(begin, surface.cells);
    var last = first;
    while last < surface.cells && cells[last] <= begin + 2u {
        last++;
    }
    return vec2(starts[first], starts[last]);
}
