//! Room that calls need on their way and leave behind for the next one, so that calls of every frame ask the system for
//! no memory once they are warm.
//!
//! [`Scratch`] keeps values by their type: lists with their capacity, mostly. [`Retired`] keeps what was handed out in an
//! [`Arc`] and may be written anew once nobody looks at it any more: snapshots, poses, views.

use std::any::{Any, TypeId};
use std::fmt;
use std::ops::{Deref, DerefMut};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Values of any types, kept for the next one who needs such a value.
#[derive(Default)]
pub struct Scratch {
    shelves: Mutex<Vec<Shelf>>,
}

/// The values of one type that nobody uses now.
type Shelf = (TypeId, Vec<Box<dyn Any + Send>>);

impl fmt::Debug for Scratch {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Scratch").field("types", &self.lock().len()).finish()
    }
}

impl Scratch {
    /// A value that nobody else uses meanwhile, as the last one left it, or a new one. It comes back when the loan ends.
    pub fn lend<T: Default + Send + 'static>(&self) -> Lent<'_, T> {
        let kept = {
            let mut shelves = self.lock();
            let shelf = shelves.iter_mut().find(|(kind, _)| *kind == TypeId::of::<T>());
            shelf.and_then(|(_, values)| values.pop())
        };
        let value = kept.and_then(|value| value.downcast().ok()).unwrap_or_default();
        Lent { scratch: self, value: Some(value) }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Shelf>> {
        self.shelves.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take_back(&self, kind: TypeId, value: Box<dyn Any + Send>) {
        let mut shelves = self.lock();
        match shelves.iter_mut().find(|(other, _)| *other == kind) {
            Some((_, values)) => values.push(value),
            None => shelves.push((kind, vec![value])),
        }
    }
}

/// A value on loan from a [`Scratch`].
pub struct Lent<'a, T: Send + 'static> {
    scratch: &'a Scratch,
    /// There until the loan ends.
    value: Option<Box<T>>,
}

impl<T: Send> Deref for Lent<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.value.as_deref().unwrap_or_else(|| unreachable!("a loan has its value until it ends"))
    }
}

impl<T: Send> DerefMut for Lent<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.value.as_deref_mut().unwrap_or_else(|| unreachable!("a loan has its value until it ends"))
    }
}

impl<T: Send + 'static> Drop for Lent<'_, T> {
    fn drop(&mut self) {
        if let Some(value) = self.value.take() {
            self.scratch.take_back(TypeId::of::<T>(), value);
        }
    }
}

impl<T: Send + fmt::Debug> fmt::Debug for Lent<'_, T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(out)
    }
}

/// References to the last few values that were handed out, so that one which nobody looks at any more is used again.
#[derive(Clone, Debug)]
pub struct Retired<T>(Vec<Arc<T>>);

/// How many are watched: those that are read, those that are being made, and some that are held for long.
const WATCHED: usize = 4;

impl<T> Default for Retired<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Retired<T> {
    /// One that nobody looks at, for writing, if there is one.
    pub fn take(&mut self) -> Option<Arc<T>> {
        let at = self.0.iter_mut().position(|value| Arc::get_mut(value).is_some())?;
        Some(self.0.remove(at))
    }

    /// Watches `value`, in place of the oldest if there are many.
    pub fn watch(&mut self, value: &Arc<T>) {
        if self.0.len() == WATCHED {
            self.0.remove(0);
        }
        self.0.push(value.clone());
    }

    /// Calls `work` with every value that nobody looks at.
    pub fn for_each_free(&mut self, work: impl FnMut(&mut T)) {
        self.0.iter_mut().filter_map(Arc::get_mut).for_each(work);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_back_is_lent_again_by_type_and_never_twice() {
        let scratch = Scratch::default();
        let mut first = scratch.lend::<Vec<u32>>();
        first.extend([1, 2, 3]);
        let place = first.as_ptr();
        assert!(scratch.lend::<Vec<u32>>().is_empty(), "the first is in use");
        drop(first);
        assert!(scratch.lend::<Vec<f32>>().is_empty());
        let again = [scratch.lend::<Vec<u32>>(), scratch.lend::<Vec<u32>>()];
        assert_eq!(again.iter().filter(|list| list.as_ptr() == place && ***list == [1, 2, 3]).count(), 1);
    }

    #[test]
    fn only_what_nobody_looks_at_is_used_again() {
        let mut retired = Retired::default();
        let [seen, unseen] = [Arc::new(1), Arc::new(2)];
        retired.watch(&seen);
        retired.watch(&unseen);
        assert!(retired.take().is_none());
        drop(unseen);
        retired.for_each_free(|value| *value += 10);
        assert_eq!((retired.take().as_deref(), *seen), (Some(&12), 1));
        assert!(retired.take().is_none());
        for _ in 0..10 {
            retired.watch(&seen);
        }
        assert_eq!(Arc::strong_count(&seen), 1 + WATCHED);
    }
}
