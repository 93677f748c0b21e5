//! What a failure is about, in numbers: the element that it names, and a number of its sentence for translations.

/// Words that name elements, by `RlvElement`. 0 is for none.
const WORDS: [&[&str]; 13] = [
    &[],
    &["point", "vertex", "node"],
    &["corner"],
    &["edge"],
    &["face"],
    &["triangle"],
    &["tile"],
    &["patch"],
    &["element", "value", "place", "hit", "ray"],
    &["particle"],
    &["line"],
    &["pin"],
    &["crease"],
];

/// The kind and the number of the last element that a text names: "face 3, corner 2" is about a corner.
fn last_element(text: &str) -> Option<(u32, u64)> {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.windows(2).rev().find_map(|pair| {
        let kind = WORDS.iter().position(|names| names.contains(&pair[0]))?;
        let number = pair[1].trim_end_matches([',', ':', ';', '.']).parse().ok()?;
        Some((u32::try_from(kind).ok()?, number))
    })
}

/// The kind and the number of the element that a failure is about, from where it is, or else from what it is.
pub fn element(place: &str, what: &str) -> (u32, u64) {
    last_element(place).or_else(|| last_element(what)).unwrap_or((0, 0))
}

/// A number of a sentence, the same whatever numbers and quoted names it has: FNV-1a, 32 bits, of the sentence with `#`
/// for each number and a quote for each quoted name. 0 for an empty sentence.
pub fn code(what: &str) -> u32 {
    let mut hash = if what.is_empty() { 0 } else { 0x811c_9dc5_u32 };
    let mut add = |byte: u8| hash = (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
    let (mut quote, mut in_number) = (None, false);
    for letter in what.chars() {
        if let Some(end) = quote {
            if letter == end {
                quote = None;
                add(b'`');
            }
            continue;
        }
        let goes_on = in_number && matches!(letter, '.' | 'e' | '-' | '+' | 'x' | 'a'..='f');
        if letter.is_ascii_digit() || goes_on {
            if !in_number {
                add(b'#');
            }
            in_number = true;
            continue;
        }
        in_number = false;
        if matches!(letter, '`' | '"') {
            quote = Some(letter);
            continue;
        }
        let mut bytes = [0; 4];
        letter.encode_utf8(&mut bytes).bytes().for_each(&mut add);
    }
    hash
}
