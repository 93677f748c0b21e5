// import progressive
// import progressive_bits
// Which vertices of a progressive mesh are there: those of the base, and those of the splits above a key.

struct CutCall {
    key: u32,
    /// Of the splits at the key those of a greater number are made.
    split: u32,
    vertices: u32,
}

@group(0) @binding(0) var<storage, read> splits: array<SplitBlock>;
@group(1) @binding(0) var<storage, read_write> there: array<u32>;
@group(1) @binding(1) var<storage, read_write> ranks: array<u32>;
var<immediate> cut: CutCall;

@compute @workgroup_size(GROUP)
fn mark(id: Invocation) {
    let vertex = linear_item(id);
    var is_there = false;
    if vertex < cut.vertices {
        let key = splits[vertex].key;
        is_there = key == ALWAYS || key > cut.key || (key == cut.key && vertex > cut.split);
    }
    let word = gathered(id.local, is_there);
    if vertex < cut.vertices && id.local % 32u == 0u {
        there[vertex / 32u] = word;
    }
}

/// How many vertices each word has.
@compute @workgroup_size(GROUP)
fn count(id: Invocation) {
    let word = linear_item(id);
    if word < (cut.vertices + 31u) / 32u {
        ranks[word] = countOneBits(there[word]);
    }
}
