// import progressive_edited
// Where nodes would have been built near what was edited, in as many bindings as places are.

/// Of every node, if `moved` is 1.
@group(1) @binding(2) var<storage, read_write> notes: array<Place>;
@group(1) @binding(3) var<storage, read_write> more_notes: array<Place>;

fn note_of(node: u32) -> Place {
    if node < PLACES {
        return notes[node];
    }
    return more_notes[node - PLACES];
}

fn set_note(node: u32, place: Place) {
    if node < PLACES {
        notes[node] = place;
    } else {
        more_notes[node - PLACES] = place;
    }
}
