//! The limit on the memory that the process's share of a library occupies.
//!
//! A library whose allocator counts its blocks installs a counter. Contexts then allow new tables only as much as the limit
//! leaves, in addition to their own limits.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

static COUNTER: OnceLock<fn() -> u64> = OnceLock::new();
static LIMIT: AtomicU64 = AtomicU64::new(u64::MAX);

/// Installs the function that returns how many bytes the blocks of the library occupy now. The first one stays.
pub fn count_with(counter: fn() -> u64) {
    COUNTER.get_or_init(|| counter);
}

/// Sets how many bytes the blocks of the library may occupy together; `u64::MAX` for no limit.
pub fn set_limit(bytes: u64) {
    LIMIT.store(bytes, Ordering::Relaxed);
}

/// Returns how many bytes the blocks of the library may occupy together, `u64::MAX` without a limit.
pub fn limit() -> u64 {
    LIMIT.load(Ordering::Relaxed)
}

/// Returns how many bytes the limit leaves; `u64::MAX` without a limit.
pub fn left() -> u64 {
    let limit = limit();
    if limit == u64::MAX { limit } else { limit.saturating_sub(COUNTER.get().map_or(0, |counter| counter())) }
}
