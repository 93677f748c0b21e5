// import progressive
// Where the vertices of an edited progressive mesh are, by their nodes, in as many bindings as they need.

/// Nodes of the first binding.
override PLACES: u32 = 0xffffffffu;

/// Of every node, where it is if it was edited; one alone where nothing was.
@group(2) @binding(0) var<storage, read_write> places: array<Place>;
@group(2) @binding(1) var<storage, read_write> more_places: array<Place>;

fn place_of(node: u32) -> Place {
    if node < PLACES {
        return places[node];
    }
    return more_places[node - PLACES];
}

fn set_place(node: u32, place: Place) {
    if node < PLACES {
        places[node] = place;
    } else {
        more_places[node - PLACES] = place;
    }
}
