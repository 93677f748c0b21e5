//! Sorting of numbers by keys, digit by digit; what has the same key keeps its order.

/// A key and a number.
pub type Keyed = (u64, u32);

/// Bits of a digit.
const DIGIT: u32 = 11;

/// Sorts by keys of so many bits. `room` is used and holds nothing of use after it.
pub fn sort(keyed: &mut Vec<Keyed>, room: &mut Vec<Keyed>, bits: u32) {
    room.resize(keyed.len(), (0, 0));
    for shift in (0..bits).step_by(DIGIT as usize) {
        let digit = |key: u64| (key >> shift) as usize & ((1 << DIGIT) - 1);
        let mut starts = [0u32; 1 << DIGIT];
        keyed.iter().for_each(|(key, _)| starts[digit(*key)] += 1);
        let mut end = 0;
        for start in &mut starts {
            end += std::mem::replace(start, end);
        }
        for one in &*keyed {
            let start = &mut starts[digit(one.0)];
            room[*start as usize] = *one;
            *start += 1;
        }
        std::mem::swap(keyed, room);
    }
}
