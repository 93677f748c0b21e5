// import progressive
// import progressive_stars
// Which places an edit changes: of the vertices that it reaches, and at splits of one depth that have one of those near.
// Splits of one depth do not touch each other, so that depth by depth, from the least, each is looked at once.

/// Splits of a depth.
struct DepthCall {
    first: u32,
    count: u32,
}

@group(0) @binding(0) var<storage, read> splits: array<SplitBlock>;
/// Splits by depth.
@group(2) @binding(0) var<storage, read> order: array<u32>;
@group(1) @binding(0) var<storage, read_write> there: array<u32>;
/// As `progressive_record.wgsl` has them.
@group(1) @binding(1) var<storage, read_write> touched: array<atomic<u32>>;
var<immediate> work: DepthCall;

fn is_touched(node: u32) -> bool {
    return (atomicLoad(&touched[node / 32u]) >> (node % 32u) & 1u) == 1u;
}

@compute @workgroup_size(GROUP)
fn touch(id: Invocation) {
    let item = linear_item(id);
    if item >= work.count {
        return;
    }
    let split = order[work.first + item];
    if (there[split / 32u] >> (split % 32u) & 1u) == 0u {
        return;
    }
    let start = starts[split];
    let first = start + HEAD;
    let end = first + star(start) + star(start + 1u) + star(start + 2u);
    var is_near = is_touched(2u * split) || is_touched(2u * split + 1u);
    for (var k = first; k < end && !is_near; k++) {
        is_near = is_touched(star(k) & NODE);
    }
    if is_near {
        let parent = splits[split].parent;
        atomicOr(&touched[parent / 32u], 1u << (parent % 32u));
        atomicOr(&touched[arrayLength(&touched) / 2u + split / 16u], 3u << (2u * split % 32u));
    }
}
