// import fluid_surface_cells
// Bricks that particles reach: bricks with particles, and the bricks beside them. What several have beside them is listed by each
// first, and once in the end.

@group(1) @binding(0) var<storage, read_write> report: array<atomic<u32>, 8>;
/// How many bricks each lists, then how many those before it list.
@group(1) @binding(1) var<storage, read_write> counts: array<u32>;
@group(2) @binding(0) var<storage, read_write> listed: array<u32>;
/// Whether a brick is listed for the first time, then how many before it are.
@group(2) @binding(1) var<storage, read_write> firsts: array<u32>;
@group(2) @binding(2) var<storage, read_write> bricks: array<u32>;

/// Whether one of the 27 bricks around a brick has to be listed by it: itself, and those without particles.
fn is_lister(number: u32, count: u32) -> bool {
    let cell = first_cell(number, count);
    return cell == count || cells[cell] != number;
}

fn around(number: u32, k: u32) -> u32 {
    return number + dot(vec3(k % 3u, k / 3u % 3u, k / 9u), strides()) - dot(vec3(1u), strides());
}

@compute @workgroup_size(GROUP)
fn surround(id: Invocation) {
    let cell = linear_item(id);
    if cell >= surface.particles {
        return;
    }
    let count = atomicLoad(&report[6]);
    var all = 0u;
    if cell < count {
        all = 1u;
        for (var k = 0u; k < 27u; k++) {
            all += u32(is_lister(around(cells[cell], k), count));
        }
        atomicMax(&report[7], starts[cell + 1u] - starts[cell]);
    }
    counts[cell] = all;
}

@compute @workgroup_size(GROUP)
fn list_bricks(id: Invocation) {
    let cell = linear_item(id);
    if cell >= surface.cells {
        return;
    }
    var at = counts[cell];
    listed[at] = cells[cell];
    for (var k = 0u; k < 27u; k++) {
        let number = around(cells[cell], k);
        if is_lister(number, surface.cells) {
            at++;
            listed[at] = number;
        }
    }
}

fn is_first(at: u32) -> bool {
    return at == 0u || listed[at - 1u] != listed[at];
}

@compute @workgroup_size(GROUP)
fn mark_bricks(id: Invocation) {
    let at = linear_item(id);
    if at < surface.listed {
        firsts[at] = u32(is_first(at));
    }
}

@compute @workgroup_size(GROUP)
fn keep_bricks(id: Invocation) {
    let at = linear_item(id);
    if at < surface.listed && is_first(at) {
        bricks[firsts[at]] = listed[at];
    }
}
