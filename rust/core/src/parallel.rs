//! Parallel loops over index ranges, compiled once for the whole workspace.
//!
//! Rayon's iterators are generic in what they call, and each call site compiles a dozen functions of them. Here the
//! loop is a trait object over ranges: a call site compiles its own body, and pays one indirect call a range. Loops that
//! must not ask for memory stay with Rayon's iterators (`Context::map_into`, `for_each_mut`, `for_each_part`).

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use rayon::ThreadPool;
use rayon::iter::ParallelIterator;
use rayon::iter::plumbing::{Folder, UnindexedConsumer, UnindexedProducer, bridge_unindexed};

/// Pieces of a list that each thread gets on average, so that uneven pieces even out.
const PIECES_A_THREAD: usize = 64;

/// Calls `work` with ranges that cover `0..count` once, on the threads of `pool` or on the calling thread alone.
pub(crate) fn run(pool: Option<&ThreadPool>, count: usize, work: &(dyn Fn(Range<usize>) + Sync)) {
    match pool {
        Some(pool) if count > 1 => pool.install(|| Span(0..count).for_each(work)),
        _ if count > 0 => work(0..count),
        _ => {}
    }
}

/// Runs `work` on a thread of `pool`, or on the calling thread.
pub(crate) fn within(pool: Option<&ThreadPool>, work: &mut (dyn FnMut() + Send)) {
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// Runs `a` and `b`, at the same time if `pool` has a thread for it.
pub(crate) fn join(pool: Option<&ThreadPool>, a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    match pool {
        Some(pool) => {
            pool.join(a, b);
        }
        None => {
            a();
            b();
        }
    }
}

/// Returns the items of each piece when `count` items are cut for the threads of `pool`. At least 1.
pub(crate) fn piece(pool: Option<&ThreadPool>, count: usize) -> usize {
    let pieces = pool.map_or(1, |pool| PIECES_A_THREAD * pool.current_num_threads());
    count.div_ceil(pieces).max(1)
}

/// One value a piece, which the thread that works on the piece takes or changes.
pub(crate) struct Slots<T>(Vec<Mutex<T>>);

impl<T> Slots<T> {
    /// Makes the slots of `values`.
    pub(crate) fn new(values: impl Iterator<Item = T>) -> Self {
        Self(values.map(Mutex::new).collect())
    }

    /// Returns the number of slots.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// Calls `change` with the value of slot `index`.
    pub(crate) fn with<R>(&self, index: usize, change: impl FnOnce(&mut T) -> R) -> R {
        change(&mut self.0[index].lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Returns the values in order.
    pub(crate) fn into_values(self) -> impl Iterator<Item = T> {
        self.0.into_iter().map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}

/// A range of indices that Rayon halves where a thread is idle.
struct Span(Range<usize>);

impl UnindexedProducer for Span {
    type Item = Range<usize>;

    fn split(self) -> (Self, Option<Self>) {
        let Range { start, end } = self.0;
        if end - start < 2 {
            return (self, None);
        }
        let middle = start + (end - start) / 2;
        (Self(start..middle), Some(Self(middle..end)))
    }

    fn fold_with<F: Folder<Self::Item>>(self, folder: F) -> F {
        folder.consume(self.0)
    }
}

impl ParallelIterator for Span {
    type Item = Range<usize>;

    fn drive_unindexed<C: UnindexedConsumer<Self::Item>>(self, consumer: C) -> C::Result {
        bridge_unindexed(self, consumer)
    }
}
