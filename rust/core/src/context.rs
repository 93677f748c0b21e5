//! The context: an executor with its own threads, the instruction level, the memory limit and the statistics.
//!
//! Work is split into items whose results do not depend on how they are spread over threads, so every result is
//! bit-identical for any number of threads.

use std::sync::Arc;

use rayon::prelude::*;

use crate::parallel::{self, Slots};
use crate::parts::Parts;
use crate::scratch::Scratch;
use crate::simd::Level;
use crate::stats::Stats;
use crate::{Error, Progress, Result};

/// How a context is made.
#[derive(Clone, Debug, Default)]
pub struct ContextOptions {
    /// Number of threads: 0 for all cores, 1 to stay on the calling thread and create none.
    pub threads: usize,
    /// Bytes that readers and tables made from input may occupy; 0 for no limit.
    pub memory_limit: u64,
}

/// An executor. Cloning it is cheap and shares it.
#[derive(Clone, Debug)]
pub struct Context {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    pool: Option<rayon::ThreadPool>,
    level: Level,
    memory_limit: u64,
    stats: Stats,
    scratch: Scratch,
}

/// Threads a context may have at most.
const MAX_THREADS: usize = 1024;

impl Context {
    /// Makes a context. Fails if the threads cannot be started or `RELIEVO_SIMD` names no level of this processor.
    pub fn new(options: &ContextOptions) -> Result<Self> {
        let available = || std::thread::available_parallelism().map_or(1, usize::from);
        let threads = if options.threads == 0 { available() } else { options.threads };
        if threads > MAX_THREADS {
            return Err(Error::invalid(format!("{threads} threads are too many"))
                .advise(format!("ask for at most {MAX_THREADS}, or 0 for one per core")));
        }
        let pool = if threads == 1 {
            None
        } else {
            let build = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(|index| format!("relievo-{index}"))
                .build();
            Some(build.map_err(|error| Error::internal(format!("cannot start {threads} threads: {error}")))?)
        };
        let level = Level::detect()?;
        let inner = Inner {
            pool,
            level,
            memory_limit: options.memory_limit,
            stats: Stats::default(),
            scratch: Scratch::default(),
        };
        Ok(Self { inner: Arc::new(inner) })
    }

    /// A context that stays on the calling thread. A `RELIEVO_SIMD` that names no level of this processor is ignored.
    pub fn serial() -> Self {
        let level = Level::detect().unwrap_or_else(|_| Level::best());
        let inner = Inner { pool: None, level, memory_limit: 0, stats: Stats::default(), scratch: Scratch::default() };
        Self { inner: Arc::new(inner) }
    }

    /// How many threads work.
    pub fn threads(&self) -> usize {
        self.pool().map_or(1, rayon::ThreadPool::current_num_threads)
    }

    /// The instruction level of the SIMD kernels.
    pub fn level(&self) -> Level {
        self.inner.level
    }

    /// Bytes that readers may occupy, `u64::MAX` if unlimited.
    pub fn memory_limit(&self) -> u64 {
        if self.inner.memory_limit == 0 { u64::MAX } else { self.inner.memory_limit }
    }

    /// Where stages report their time and counts.
    pub fn stats(&self) -> &Stats {
        &self.inner.stats
    }

    /// Room that calls keep for the next ones.
    pub fn scratch(&self) -> &Scratch {
        &self.inner.scratch
    }

    /// Runs `work` on a thread of this context. What is done in parallel within then starts without waking a thread
    /// first, which counts where stages take less than a millisecond.
    pub fn within<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let (mut work, mut result) = (Some(work), None);
        parallel::within(self.pool(), &mut || result = work.take().map(|work| work()));
        result.expect("work runs once")
    }

    /// Calls `work` for every index below `count`, in any order.
    pub fn for_each(&self, count: usize, work: impl Fn(usize) + Sync) {
        parallel::run(self.pool(), count, &|range| range.for_each(&work));
    }

    /// Calls `work` for every item and its index, in any order.
    pub fn for_each_mut<T: Send>(&self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
        match self.pool() {
            Some(pool) if items.len() > 1 => {
                pool.install(|| items.par_iter_mut().enumerate().for_each(|(index, item)| work(index, item)));
            }
            _ => items.iter_mut().enumerate().for_each(|(index, item)| work(index, item)),
        }
    }

    /// Returns the results of `work` for every index below `count`, in order.
    pub fn map<R: Send>(&self, count: usize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
        let size = parallel::piece(self.pool(), count);
        let pieces = Slots::new((0..count.div_ceil(size)).map(|_| Vec::new()));
        parallel::run(self.pool(), pieces.len(), &|range| {
            for piece in range {
                let indices = piece * size..((piece + 1) * size).min(count);
                pieces.with(piece, |list| list.extend(indices.map(&work)));
            }
        });
        let mut pieces = pieces.into_values();
        let mut results = pieces.next().unwrap_or_default();
        results.reserve_exact(count - results.len());
        pieces.for_each(|mut piece| results.append(&mut piece));
        results
    }

    /// As [`Self::map`], in place of what `out` holds, whose memory is used again: warm calls ask for none.
    pub fn map_into<R: Send>(&self, count: usize, out: &mut Vec<R>, work: impl Fn(usize) -> R + Sync) {
        match self.pool() {
            Some(pool) if count > 1 => pool.install(|| (0..count).into_par_iter().map(&work).collect_into_vec(out)),
            _ => {
                out.clear();
                out.extend((0..count).map(work));
            }
        }
    }

    /// Calls `work` with `size` items of `parts` each time, the last time maybe with fewer, and the index of the first of
    /// them, in any order. Returns the error of the lowest index, if there is one.
    pub fn for_each_part<P: Parts>(
        &self,
        parts: P,
        size: usize,
        work: impl Fn(usize, P) -> Result<()> + Sync,
    ) -> Result<()> {
        let size = size.max(1);
        match self.pool() {
            Some(pool) if parts.len() > size => pool.install(|| halve(parts, 0, size, &work, true)),
            _ => halve(parts, 0, size, &work, false),
        }
    }

    /// As [`Self::map`], in pieces between which `progress` hears of `stage`, from the first to the second fraction of
    /// `span`. Fails where it asks to stop.
    pub fn map_watched<R: Send>(
        &self,
        count: usize,
        progress: &mut dyn Progress,
        (stage, span): (&str, [f32; 2]),
        work: impl Fn(usize) -> R + Sync,
    ) -> Result<Vec<R>> {
        let piece = count.div_ceil(64).max(4 * self.threads());
        let mut results = Vec::with_capacity(count);
        while results.len() < count {
            let first = results.len();
            progress.step(span[0] + (span[1] - span[0]) * first as f32 / count as f32, stage)?;
            results.extend(self.map(piece.min(count - first), |index| work(first + index)));
        }
        Ok(results)
    }

    /// Runs `a` and `b`, at the same time if there are threads for it.
    pub fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        let (mut a, mut b) = (Some(a), Some(b));
        let (mut first, mut second) = (None, None);
        parallel::join(self.pool(), &mut || first = a.take().map(|a| a()), &mut || second = b.take().map(|b| b()));
        (first.expect("work runs once"), second.expect("work runs once"))
    }

    fn pool(&self) -> Option<&rayon::ThreadPool> {
        self.inner.pool.as_ref()
    }
}

/// Halves `parts`, whose first item has the index `first`, until at most `size` items are left, for `work`.
fn halve<P: Parts>(
    parts: P,
    first: usize,
    size: usize,
    work: &(impl Fn(usize, P) -> Result<()> + Sync),
    parallel: bool,
) -> Result<()> {
    if parts.len() <= size {
        return if parts.is_empty() { Ok(()) } else { work(first, parts) };
    }
    let half = parts.len().div_ceil(size) / 2 * size;
    let (low, high) = parts.split_at(half);
    let low = || halve(low, first, size, work, parallel);
    let high = || halve(high, first + half, size, work, parallel);
    let (low, high) = if parallel { rayon::join(low, high) } else { (low(), high()) };
    low.and(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_and_many_threads_give_the_same_results_in_order() {
        let serial = Context::serial().map(1000, |index| index * index);
        for threads in [1, 2, 5] {
            let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
            assert_eq!(context.threads(), threads);
            assert_eq!(context.map(1000, |index| index * index), serial);
            let mut items = vec![0; 1000];
            context.for_each_mut(&mut items, |index, item| *item = index * index);
            assert_eq!(items, serial);
            let mut list = vec![7];
            context.map_into(1000, &mut list, |index| index * index);
            assert_eq!(list, serial);
            let (mut squares, roots) = (vec![0; 1000], (0..1000).collect::<Vec<usize>>());
            let parts = (roots.as_slice(), squares.as_mut_slice());
            let done = context.for_each_part(parts, 64, |first, (roots, squares)| {
                assert_eq!((roots[0], roots.len()), (first, if first == 960 { 40 } else { 64 }));
                squares.iter_mut().zip(roots).for_each(|(square, root)| *square = root * root);
                if first < 128 { Ok(()) } else { Err(Error::invalid(format!("{first}"))) }
            });
            assert!(done.unwrap_err().to_string().contains("128"));
            assert_eq!(squares, serial);
        }
    }

    #[test]
    fn too_many_threads_are_refused() {
        assert!(Context::new(&ContextOptions { threads: 1 << 20, memory_limit: 0 }).is_err());
    }
}
