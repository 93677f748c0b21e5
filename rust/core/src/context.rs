//! The context: an executor with its own threads, the instruction level, the memory limit and the statistics.
//!
//! Work is split into items whose results do not depend on how they are spread over threads, so every result is
//! bit-identical for any number of threads.

use std::sync::{Arc, Mutex, PoisonError};

use crate::parallel::{Executor, Pool, Scheduler, Slots};
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
    executor: Executor,
    level: Level,
    memory_limit: u64,
    stats: Stats,
    scratch: Scratch,
}

/// Threads a context may have at most.
const MAX_THREADS: usize = 1024;

impl Context {
    /// Makes a context. Its threads start with the first loop; where the system starts none, loops stay on the calling
    /// thread, with the same results.
    ///
    /// # Errors
    /// Fails with `Invalid` for more than 1024 threads, and as [`Level::detect`] does.
    pub fn new(options: &ContextOptions) -> Result<Self> {
        let available = || std::thread::available_parallelism().map_or(1, usize::from);
        let threads = if options.threads == 0 { available() } else { options.threads };
        if threads > MAX_THREADS {
            return Err(Error::invalid(format!("{threads} threads are too many"))
                .advise(format!("ask for at most {MAX_THREADS}, or 0 for one per core")));
        }
        let executor = if threads == 1 { Executor::Serial } else { Executor::Pool(Arc::new(Pool::new(threads))) };
        Self::on(executor, options.memory_limit)
    }

    /// Makes a context that works on the threads of `other`, and has a memory limit of its own in bytes, 0 for none.
    ///
    /// # Errors
    /// Fails as [`Level::detect`] does if `RELIEVO_SIMD` names no level of this processor.
    pub fn sharing(other: &Self, memory_limit: u64) -> Result<Self> {
        Self::on(other.inner.executor.clone(), memory_limit)
    }

    /// Makes a context that works on the threads of the host, and starts none. `memory_limit` is in bytes, 0 for none.
    ///
    /// # Errors
    /// Fails as [`Level::detect`] does if `RELIEVO_SIMD` names no level of this processor.
    pub fn scheduled(scheduler: Arc<dyn Scheduler>, memory_limit: u64) -> Result<Self> {
        Self::on(Executor::Host(scheduler), memory_limit)
    }

    /// A context that stays on the calling thread. A `RELIEVO_SIMD` that names no level of this processor is ignored.
    pub fn serial() -> Self {
        let level = Level::detect().unwrap_or_else(|_| Level::best());
        Self::at_level(Executor::Serial, level, 0)
    }

    fn on(executor: Executor, memory_limit: u64) -> Result<Self> {
        Ok(Self::at_level(executor, Level::detect()?, memory_limit))
    }

    fn at_level(executor: Executor, level: Level, memory_limit: u64) -> Self {
        let inner = Inner { executor, level, memory_limit, stats: Stats::default(), scratch: Scratch::default() };
        Self { inner: Arc::new(inner) }
    }

    /// How many threads work.
    pub fn threads(&self) -> usize {
        self.executor().threads()
    }

    /// The instruction level of the SIMD kernels.
    pub fn level(&self) -> Level {
        self.inner.level
    }

    /// Returns how many bytes a reader or a table may occupy now, `u64::MAX` if unlimited: the context's limit, or what
    /// the limit of the process leaves ([`crate::memory`]), if that is less.
    pub fn memory_limit(&self) -> u64 {
        self.own_memory_limit().min(crate::memory::left())
    }

    /// Returns the memory limit that the context was made with, `u64::MAX` if it has none.
    pub fn own_memory_limit(&self) -> u64 {
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
        self.executor().within(&mut || result = work.take().map(|work| work()));
        result.expect("work runs once")
    }

    /// Calls `work` for every index below `count`, in any order.
    pub fn for_each(&self, count: usize, work: impl Fn(usize) + Sync) {
        self.executor().run(count, &|range| range.for_each(&work));
    }

    /// Calls `work` for every item and its index, in any order.
    pub fn for_each_mut<T: Send>(&self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
        self.executor().run_parts(items, 1, &|first, items| {
            items.iter_mut().enumerate().for_each(|(at, item)| work(first + at, item));
        });
    }

    /// Returns the results of `work` for every index below `count`, in order.
    pub fn map<R: Send>(&self, count: usize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
        let size = self.executor().piece(count);
        let pieces = Slots::new((0..count.div_ceil(size)).map(|_| Vec::new()));
        self.executor().run(pieces.len(), &|range| {
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

    /// As [`Self::map`], in place of what `out` holds, whose memory is used again: warm calls ask for none, but on a
    /// scheduler of the host for the pieces.
    pub fn map_into<R: Send>(&self, count: usize, out: &mut Vec<R>, work: impl Fn(usize) -> R + Sync) {
        match self.executor() {
            Executor::Host(_) if count > 1 => {
                out.clear();
                out.append(&mut self.map(count, work));
            }
            executor => executor.fill(count, out, &work),
        }
    }

    /// Calls `work` with `size` items of `parts` each time, the last time maybe with fewer, and the index of the first
    /// of them, in any order.
    ///
    /// # Errors
    /// Returns the error of `work` at the lowest index.
    pub fn for_each_part<P: Parts>(
        &self,
        parts: P,
        size: usize,
        work: impl Fn(usize, P) -> Result<()> + Sync,
    ) -> Result<()> {
        let size = size.max(1);
        let failed = Mutex::new(None);
        self.executor().run_parts(parts, size, &|first, parts| {
            if let Err((at, error)) = each_part(parts, first, size, &work) {
                let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                if failed.as_ref().is_none_or(|(lowest, _)| at < *lowest) {
                    *failed = Some((at, error));
                }
            }
        });
        match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some((_, error)) => Err(error),
            None => Ok(()),
        }
    }

    /// As [`Self::map`], in pieces between which `progress` hears of `stage`, from the first to the second fraction of
    /// `span`.
    ///
    /// # Errors
    /// Fails with `Cancelled` if `progress` asks to stop.
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
        self.executor().join(&mut || first = a.take().map(|a| a()), &mut || second = b.take().map(|b| b()));
        (first.expect("work runs once"), second.expect("work runs once"))
    }

    fn executor(&self) -> &Executor {
        &self.inner.executor
    }
}

/// Calls `work` with `size` items of `parts` each time, whose first item has the index `first`. Returns the first error and
/// the index it came at; parts behind it are worked on all the same.
fn each_part<P: Parts>(
    parts: P,
    first: usize,
    size: usize,
    work: &(dyn Fn(usize, P) -> Result<()> + Sync),
) -> std::result::Result<(), (usize, Error)> {
    let (mut first, mut rest, mut done) = (first, parts, Ok(()));
    while !rest.is_empty() {
        let (part, others) = rest.split_at(size);
        let result = work(first, part).map_err(|error| (first, error));
        done = done.and(result);
        (first, rest) = (first + size, others);
    }
    done
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Threads of a host, which begin with the last index and count their calls.
    struct Backwards(usize, AtomicUsize);

    impl Scheduler for Backwards {
        fn threads(&self) -> usize {
            self.0
        }

        fn run(&self, count: usize, body: &(dyn Fn(usize) + Sync)) {
            self.1.fetch_add(count, Ordering::Relaxed);
            let next = AtomicUsize::new(count);
            std::thread::scope(|scope| {
                for _ in 0..self.0 {
                    scope.spawn(|| {
                        while let Ok(left) =
                            next.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1))
                        {
                            body(left - 1);
                        }
                    });
                }
            });
        }
    }

    #[test]
    fn one_and_many_threads_give_the_same_results_in_order() {
        let serial = Context::serial().map(1000, |index| index * index);
        let own = |threads| Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let host = Arc::new(Backwards(3, AtomicUsize::new(0)));
        let hosted = Context::scheduled(host.clone(), 0).unwrap();
        let shared = Context::sharing(&own(5), 0).unwrap();
        for (context, threads) in [(own(1), 1), (own(2), 2), (own(5), 5), (shared, 5), (hosted.clone(), 3)] {
            assert_eq!(context.threads(), threads);
            assert_eq!(context.join(|| 3, || "four"), (3, "four"));
            assert_eq!(context.within(|| context.map(9, |index| index)), (0..9).collect::<Vec<_>>());
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
        // Every loop above ran on it: two pieces of a join, nine of a map, and many of the others.
        assert!(host.1.load(Ordering::Relaxed) > 2 + 9 + 4 * 100);
    }

    #[test]
    fn threads_start_with_the_first_loop() {
        let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
        let Executor::Pool(pool) = context.executor() else { panic!("three threads are a pool") };
        assert_eq!((context.threads(), context.map(1, |index| index)), (3, vec![0]));
        context.for_each_mut(&mut [7], |_, item| *item += 1);
        assert!(!pool.has_started());
        assert_eq!(context.map(2, |index| index), [0, 1]);
        assert!(pool.has_started());
    }

    #[test]
    fn too_many_threads_are_refused() {
        assert!(Context::new(&ContextOptions { threads: 1 << 20, memory_limit: 0 }).is_err());
    }
}
