//! Room that calls need on their way and leave behind for the next one, so that calls of every frame ask the system for
//! no memory once they are warm.
//!
//! [`Scratch`] keeps values by their type: lists with their capacity, mostly. [`ArcPool`] keeps what was handed out in an
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

/// A type, and the list of its values that nobody uses now: a `Vec` of them.
type Shelf = (TypeId, Box<dyn Any + Send>);

/// Values of a type that are kept at most. Nobody gives back more than was lent, unless what was lent is lost.
const KEPT: usize = 4096;

impl fmt::Debug for Scratch {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Scratch").field("types", &self.lock().len()).finish()
    }
}

impl Scratch {
    /// A value that nobody else uses meanwhile, as the last one left it, or a new one. It comes back when the loan ends.
    pub fn lend<T: Default + Send + 'static>(&self) -> Lent<'_, T> {
        Lent { scratch: self, value: Some(self.take()) }
    }

    /// An empty list with the room of another. It comes back when the loan ends, and what is in it then is dropped.
    pub fn list<T: Send + 'static>(&self) -> List<'_, T> {
        List { scratch: self, values: self.take_list() }
    }

    /// As [`Self::list`], to be handed out: who has done with it may give it back by [`Self::keep_list`].
    pub fn take_list<T: Send + 'static>(&self) -> Vec<T> {
        let mut list: Vec<T> = self.take();
        list.clear();
        list
    }

    /// Drops what is in `list` and keeps its room for another.
    pub fn keep_list<T: Send + 'static>(&self, mut list: Vec<T>) {
        list.clear();
        if list.capacity() > 0 {
            self.keep(list);
        }
    }

    fn take<T: Default + Send + 'static>(&self) -> T {
        let mut shelves = self.lock();
        let shelf = shelves.iter_mut().find(|(kind, _)| *kind == TypeId::of::<T>());
        let kept = shelf.and_then(|(_, values)| values.downcast_mut::<Vec<T>>()?.pop());
        drop(shelves);
        kept.unwrap_or_default()
    }

    fn keep<T: Send + 'static>(&self, value: T) {
        let mut shelves = self.lock();
        let at = shelves.iter().position(|(kind, _)| *kind == TypeId::of::<T>());
        let at = at.unwrap_or_else(|| {
            shelves.push((TypeId::of::<T>(), Box::new(Vec::<T>::new())));
            shelves.len() - 1
        });
        if let Some(values) = shelves[at].1.downcast_mut::<Vec<T>>().filter(|values| values.len() < KEPT) {
            values.push(value);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Shelf>> {
        self.shelves.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A value on loan from a [`Scratch`].
pub struct Lent<'a, T: Send + 'static> {
    scratch: &'a Scratch,
    /// There until the loan ends.
    value: Option<T>,
}

impl<T: Send> Deref for Lent<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.value.as_ref().unwrap_or_else(|| unreachable!("a loan has its value until it ends"))
    }
}

impl<T: Send> DerefMut for Lent<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.value.as_mut().unwrap_or_else(|| unreachable!("a loan has its value until it ends"))
    }
}

impl<T: Send + 'static> Drop for Lent<'_, T> {
    fn drop(&mut self) {
        if let Some(value) = self.value.take() {
            self.scratch.keep(value);
        }
    }
}

impl<T: Send + fmt::Debug> fmt::Debug for Lent<'_, T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(out)
    }
}

/// A list on loan from a [`Scratch`], see [`Scratch::list`].
pub struct List<'a, T: Send + 'static> {
    scratch: &'a Scratch,
    values: Vec<T>,
}

impl<T: Send> List<'_, T> {
    /// The list, to be handed out, see [`Scratch::take_list`].
    pub fn detach(mut self) -> Vec<T> {
        std::mem::take(&mut self.values)
    }
}

impl<T: Send> Deref for List<'_, T> {
    type Target = Vec<T>;

    fn deref(&self) -> &Vec<T> {
        &self.values
    }
}

impl<T: Send> DerefMut for List<'_, T> {
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.values
    }
}

impl<T: Send + 'static> Drop for List<'_, T> {
    fn drop(&mut self) {
        self.scratch.keep_list(std::mem::take(&mut self.values));
    }
}

impl<T: Send + fmt::Debug> fmt::Debug for List<'_, T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.values.fmt(out)
    }
}

/// References to the last few values that were handed out, so that one which nobody looks at any more is used again.
#[derive(Clone, Debug)]
pub struct ArcPool<T>(Vec<Arc<T>>);

/// How many are watched: values that are read, values that are being made, and some that are held for long.
const WATCHED: usize = 4;

impl<T> Default for ArcPool<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> ArcPool<T> {
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
        drop(again);
        let taken = [scratch.list::<u32>(), scratch.list::<u32>()];
        assert!(taken.iter().all(|list| list.is_empty()) && scratch.list::<u32>().capacity() == 0);
        let taken = taken.map(List::detach);
        assert!(scratch.list::<u32>().capacity() == 0, "both were handed out");
        taken.into_iter().filter(|list| list.as_ptr() == place).for_each(|list| scratch.keep_list(list));
        assert_eq!(scratch.list::<u32>().as_ptr(), place);
    }

    #[test]
    fn only_what_nobody_looks_at_is_used_again() {
        let mut retired = ArcPool::default();
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
