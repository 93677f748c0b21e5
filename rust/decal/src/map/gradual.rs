//! Lists that grow by an eighth: doubling sets twice the memory aside, and leaves holes of that size behind.

/// Items that are set aside at least.
const MIN: usize = 64;

/// Makes room for `count` items.
pub fn reserve<T>(list: &mut Vec<T>, count: usize) {
    if count > list.capacity() {
        list.reserve_exact((count + count / 8 + MIN).saturating_sub(list.len()));
    }
}

/// Adds an item.
pub fn push<T>(list: &mut Vec<T>, item: T) {
    reserve(list, list.len() + 1);
    list.push(item);
}
