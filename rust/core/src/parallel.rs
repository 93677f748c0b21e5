//! Parallel loops over index ranges, compiled once for the whole workspace.
//!
//! Rayon's iterators are generic in what they call, and each call site compiles a dozen functions of them. Here the
//! loop is a trait object over ranges or parts of lists: a call site compiles its own body, and pays one indirect call a
//! range. Loops over parts ask for no memory, but on a scheduler of the host.
//!
//! A host may bring its own threads as a [`Scheduler`]; then the same pieces are indices of its parallel loop.

use std::fmt;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::ThreadPool;
use rayon::iter::plumbing::{Folder, UnindexedConsumer, UnindexedProducer, bridge_unindexed};
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use crate::parts::Parts;

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
    Pool(Arc<Pool>),
    /// Threads of the host.
    Host(Arc<dyn Scheduler>),
}

/// Threads that start with the first loop, so that a context costs none before it works.
pub(crate) struct Pool {
    threads: usize,
    started: OnceLock<Option<ThreadPool>>,
}

impl Pool {
    /// Makes a pool of `threads` threads, none of which runs yet.
    pub(crate) fn new(threads: usize) -> Self {
        Self { threads, started: OnceLock::new() }
    }

    /// Returns the running threads, or nothing where the system starts no more: then loops stay on the calling thread.
    fn running(&self) -> Option<&ThreadPool> {
        let start = || {
            let name = |index| format!("relievo-{index}");
            rayon::ThreadPoolBuilder::new().num_threads(self.threads).thread_name(name).build().ok()
        };
        self.started.get_or_init(start).as_ref()
    }

    /// Returns whether the threads were started.
    #[cfg(test)]
    pub(crate) fn has_started(&self) -> bool {
        self.started.get().is_some()
    }
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
            Self::Pool(pool) => pool.threads,
            Self::Host(host) => host.threads().max(1),
        }
    }

    /// Returns the threads of ours.
    fn pool(&self) -> Option<&ThreadPool> {
        match self {
            Self::Pool(pool) => pool.running(),
            Self::Serial | Self::Host(_) => None,
        }
    }

    /// Calls `work` with ranges that cover `0..count` once.
    pub(crate) fn run(&self, count: usize, work: &(dyn Fn(Range<usize>) + Sync)) {
        if count <= 1 {
            if count == 1 {
                work(0..1);
            }
        } else if let Self::Host(host) = self {
            let size = self.piece(count);
            host.run(count.div_ceil(size), &|piece| work(piece * size..((piece + 1) * size).min(count)));
        } else if let Some(pool) = self.pool() {
            pool.install(|| Span(0..count).for_each(work));
        } else {
            work(0..count);
        }
    }

    /// Calls `work` with parts of `parts` that cover them once, and the index of the first item of each. All but the last
    /// have a multiple of `size` items, which is at least 1.
    pub(crate) fn run_parts<P: Parts>(&self, parts: P, size: usize, work: &(dyn Fn(usize, P) + Sync)) {
        if parts.len() <= size {
            if !parts.is_empty() {
                work(0, parts);
            }
        } else if let Self::Host(host) = self {
            let piece = size * self.piece(parts.len().div_ceil(size));
            let (mut pieces, mut rest) = (Vec::new(), parts);
            while rest.len() > piece {
                let (low, high) = rest.split_at(piece);
                pieces.push(Some(low));
                rest = high;
            }
            pieces.push(Some(rest));
            let pieces = Slots::new(pieces.into_iter());
            host.run(pieces.len(), &|index| {
                if let Some(parts) = pieces.with(index, Option::take) {
                    work(index * piece, parts);
                }
            });
        } else if let Some(pool) = self.pool() {
            let mut halves = Some(Halves { parts, first: 0, size });
            within(pool, &mut || {
                if let Some(halves) = halves.take() {
                    halves.for_each(|(first, parts)| work(first, parts));
                }
            });
        } else {
            work(0, parts);
        }
    }

    /// Puts the results of `work` for every index below `count` into `out`, in order, in place of what it holds.
    pub(crate) fn fill<R: Send>(&self, count: usize, out: &mut Vec<R>, work: &(dyn Fn(usize) -> R + Sync)) {
        match self.pool() {
            Some(pool) if count > 1 => within(pool, &mut || (0..count).into_par_iter().map(work).collect_into_vec(out)),
            _ => {
                out.clear();
                out.extend((0..count).map(work));
            }
        }
    }

    /// Runs `work` on a thread of the pool, or on the calling thread.
    pub(crate) fn within(&self, work: &mut (dyn FnMut() + Send)) {
        match self.pool() {
            Some(pool) => within(pool, work),
            None => work(),
        }
    }

    /// Runs `a` and `b`, at the same time if there is a thread for it.
    pub(crate) fn join<'a>(&self, a: &'a mut (dyn FnMut() + Send), b: &'a mut (dyn FnMut() + Send)) {
        if let Self::Host(host) = self {
            let both = Slots::new([a, b].into_iter());
            host.run(2, &|index| both.with(index, |work| work()));
        } else if let Some(pool) = self.pool() {
            pool.join(a, b);
        } else {
            a();
            b();
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

/// Runs `work` on a thread of `pool`.
fn within(pool: &ThreadPool, work: &mut (dyn FnMut() + Send)) {
    pool.install(work);
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

/// Parts that Rayon halves, at multiples of `size` items, where a thread is idle.
struct Halves<P> {
    parts: P,
    first: usize,
    size: usize,
}

impl<P: Parts> UnindexedProducer for Halves<P> {
    type Item = (usize, P);

    fn split(self) -> (Self, Option<Self>) {
        let Self { parts, first, size } = self;
        if parts.len() <= size {
            return (Self { parts, first, size }, None);
        }
        let half = parts.len().div_ceil(size) / 2 * size;
        let (low, high) = parts.split_at(half);
        (Self { parts: low, first, size }, Some(Self { parts: high, first: first + half, size }))
    }

    fn fold_with<F: Folder<Self::Item>>(self, folder: F) -> F {
        folder.consume((self.first, self.parts))
    }
}

impl<P: Parts> ParallelIterator for Halves<P> {
    type Item = (usize, P);

    fn drive_unindexed<C: UnindexedConsumer<Self::Item>>(self, consumer: C) -> C::Result {
        bridge_unindexed(self, consumer)
    }
}
