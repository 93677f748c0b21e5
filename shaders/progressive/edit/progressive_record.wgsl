// import progressive_notes
// What an edit replaces, listed without gaps, so that it can be taken back and made again.

/// Of every node whether its place is replaced, and then of every node whether its note is, a bit each.
@group(0) @binding(0) var<storage, read> touched: array<u32>;
/// How many there are before those of a word.
@group(0) @binding(1) var<storage, read> ranks: array<u32>;
/// The numbers of bits, and what was there.
@group(1) @binding(0) var<storage, read_write> numbers: array<u32>;
@group(1) @binding(1) var<storage, read_write> values: array<Place>;
/// How many words of places there are, or how many places were replaced.
struct RecordCall {
    words: u32,
    count: u32,
}
var<immediate> work: RecordCall;

/// The place or note of a number.
fn value_of(number: u32) -> Place {
    if number < 32u * work.words {
        return place_of(number);
    }
    return note_of(number - 32u * work.words);
}

/// Lists what is marked.
@compute @workgroup_size(GROUP)
fn keep(id: Invocation) {
    let word = linear_item(id);
    if word >= 2u * work.words {
        return;
    }
    var at = ranks[word];
    for (var left = touched[word]; left != 0u; left &= left - 1u) {
        let number = 32u * word + firstTrailingBit(left);
        numbers[at] = number;
        values[at] = value_of(number);
        at += 1u;
    }
}

/// Puts what was there back in place of what is.
@compute @workgroup_size(GROUP)
fn swap(id: Invocation) {
    let item = linear_item(id);
    if item >= work.count {
        return;
    }
    let number = numbers[item];
    let is = value_of(number);
    if number < 32u * work.words {
        set_place(number, values[item]);
    } else {
        set_note(number - 32u * work.words, values[item]);
    }
    values[item] = is;
}
