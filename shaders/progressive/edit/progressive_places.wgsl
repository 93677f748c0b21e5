// import progressive_edited
// import octahedron
// Where the vertices of an edited progressive mesh are, at every level. A vertex is named by its node: twice the number of
// the split it comes from, and 1 if it is the second of that.

@group(0) @binding(0) var<storage, read> splits: array<SplitBlock>;
@group(0) @binding(1) var<storage, read> inner: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> leaves: array<vec4<u32>>;
@group(1) @binding(0) var<storage, read_write> there: array<u32>;

fn is_there(vertex: u32) -> bool {
    return (there[vertex / 32u] >> (vertex % 32u) & 1u) == 1u;
}

/// Where a node was built.
fn built(node: u32) -> Place {
    let split = node / 2u;
    let child = splits[split].children[node % 2u];
    var bits: vec4<u32>;
    if child < LEAF {
        bits = inner[child];
    } else {
        // The one leaf of a first vertex is before those of the second; a vertex of the base has no second.
        bits = leaves[split - select(1u - node % 2u, 0u, splits[split].key == ALWAYS)];
    }
    return Place(bitcast<vec3<f32>>(bits.xyz), 0u, octahedral_normal(bits.w));
}

/// Where it is.
fn now(node: u32) -> Place {
    let place = place_of(node);
    if place.moved == 1u {
        return place;
    }
    return built(node);
}

/// Whether a vertex of the mesh that is there has a node, of as many vertices as the finest has.
fn is_shown(node: u32, vertices: u32) -> bool {
    let split = node / 2u;
    if split >= vertices || !is_there(split) || (node % 2u == 1u && splits[split].key == ALWAYS) {
        return false;
    }
    let child = splits[split].children[node % 2u];
    return child >= LEAF || !is_there(child);
}
