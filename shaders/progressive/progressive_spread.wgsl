// import progressive
// import progressive_stars
// What splits stand on is made too: splits that the vertices around theirs come from. Splits of one depth do not stand on
// each other, so that depth by depth, from the least, each is looked at once.

/// Depths, which are numbered from the greatest.
struct Depths {
    /// The first to look at, and how many before it.
    last: u32,
    count: u32,
}

@group(0) @binding(0) var<storage, read> splits: array<SplitBlock>;
/// Splits by depth, the greatest first, and where those of a depth begin.
@group(2) @binding(0) var<storage, read> order: array<u32>;
@group(2) @binding(1) var<storage, read> depths: array<u32>;
@group(1) @binding(0) var<storage, read_write> there: array<atomic<u32>>;
var<immediate> work: Depths;

fn spread_from(place: u32) {
    let split = order[place];
    if (atomicLoad(&there[split / 32u]) >> (split % 32u) & 1u) == 0u {
        return;
    }
    let start = starts[split];
    let count = star(start) + star(start + 1u) + star(start + 2u);
    // The vertex that is split comes first.
    var node = splits[split].parent;
    for (var k = 0u; k <= count; k++) {
        let below = node / 2u;
        let bit = 1u << (below % 32u);
        if (atomicLoad(&there[below / 32u]) & bit) == 0u {
            atomicOr(&there[below / 32u], bit);
        }
        if k < count {
            node = star(start + HEAD + k) & NODE;
        }
    }
}

/// One depth of many splits.
@compute @workgroup_size(GROUP)
fn spread(id: Invocation) {
    let place = depths[work.last] + linear_item(id);
    if place < depths[work.last + 1u] {
        spread_from(place);
    }
}

/// Depths of few splits, by one workgroup.
@compute @workgroup_size(GROUP)
fn spread_all(@builtin(local_invocation_index) local: u32) {
    for (var k = 0u; k < work.count; k++) {
        let depth = work.last - k;
        for (var place = depths[depth] + local; place < depths[depth + 1u]; place += GROUP) {
            spread_from(place);
        }
        storageBarrier();
    }
}
