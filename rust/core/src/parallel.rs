//! Parallel loops over index ranges, compiled once for the whole workspace.
//!
//! Rayon's iterators are generic in what they call, and each call site compiles a dozen functions of them. Here the
//! loop is a trait object over ranges: a call site compiles its own body, and pays one indirect call a range. Loops that
//! must not ask for memory stay with Rayon's iterators (`Context::map_into`, `for_each_mut`, `for_each_part`).
//!
//! A host may bring its own threads as a [`Scheduler`]; then the same pieces are indices of its parallel loop.

use std::fmt;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::ThreadPool;
use rayon::iter::ParallelIterator;
use rayon::iter::plumbing::{Folder, UnindexedConsumer, UnindexedProducer, bridge_unindexed};

/// Pieces of a list that each thread gets on average, so that uneven pieces even out.
const PIECES_A_THREAD: usize = 64;

/// A parallel loop of the host, which takes the place of a context's own threads.
pub trait Scheduler: Send + Sync {
    /// Returns how many threads may work at once, at least 1. The same for the life of the scheduler.
    fn threads(&self) -> usize;

    /// Calls `body` once for every index below `count`, on any threads in any order, and returns when all calls have
    /// returned. `body` may call `run` again.
    fn run(&self, count: usize, body: &(dyn Fn(usize) + Sync));
}

/// What a context's loops run on.
#[derive(Clone)]
pub(crate) enum Executor {
    /// The calling thread.
    Serial,
    /// Threads of ours, which contexts may share.
    Pool(Arc<ThreadPool>),
    /// Threads of the host.
    Host(Arc<dyn Scheduler>),
}

impl fmt::Debug for Executor {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self {
            Self::Serial => "Serial",
            Self::Pool(_) => "Pool",
            Self::Host(_) => "Host",
        };
        write!(out, "{name}({})", self.threads())
    }
}

impl Executor {
    /// Returns how many threads work.
    pub(crate) fn threads(&self) -> usize {
        match self {
            Self::Serial => 1,
            Self::Pool(pool) => pool.current_num_threads(),
            Self::Host(host) => host.threads().max(1),
        }
    }

    /// Calls `work` with ranges that cover `0..count` once.
    pub(crate) fn run(&self, count: usize, work: &(dyn Fn(Range<usize>) + Sync)) {
        match self {
            Self::Pool(pool) if count > 1 => pool.install(|| Span(0..count).for_each(work)),
            Self::Host(host) if count > 1 => {
                let size = self.piece(count);
                host.run(count.div_ceil(size), &|piece| work(piece * size..((piece + 1) * size).min(count)));
            }
            _ if count > 0 => work(0..count),
            _ => {}
        }
    }

    /// Runs `work` on a thread of the pool, or on the calling thread.
    pub(crate) fn within(&self, work: &mut (dyn FnMut() + Send)) {
        match self {
            Self::Pool(pool) => pool.install(work),
            Self::Serial | Self::Host(_) => work(),
        }
    }

    /// Runs `a` and `b`, at the same time if there is a thread for it.
    pub(crate) fn join<'a>(&self, a: &'a mut (dyn FnMut() + Send), b: &'a mut (dyn FnMut() + Send)) {
        match self {
            Self::Serial => {
                a();
                b();
            }
            Self::Pool(pool) => {
                pool.join(a, b);
            }
            Self::Host(host) => {
                let both = Slots::new([a, b].into_iter());
                host.run(2, &|index| both.with(index, |work| work()));
            }
        }
    }

    /// Returns the items of each piece when `count` items are cut for the threads. At least 1.
    pub(crate) fn piece(&self, count: usize) -> usize {
        let pieces = match self {
            Self::Serial => 1,
            _ => PIECES_A_THREAD * self.threads(),
        };
        count.div_ceil(pieces).max(1)
    }
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
