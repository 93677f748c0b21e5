//! Where the texels of a block are: in memory, or on a page from which they return when somebody looks at them.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 4, where
//! a heap that is full refuses; here the oldest blocks make room, see [`crate::store::paging`]. Any number of readers may look
//! at a page at once: one of them reads it, the others wait for it, and it stays for the life of the fields that have
//! it. Texels that cannot be read back are blank to readers, and an error to whoever asks or edits.

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use relievo_core::{Error, Result};
use relievo_document::{Page, PageStore};

use crate::texel::Texel;

/// The texels of a block, or its mips.
#[derive(Clone, Debug)]
pub(crate) enum Slot<T> {
    Here(Arc<[T]>),
    Paged(Arc<Paged<T>>),
}

/// Texels that are on a page.
pub(crate) struct Paged<T> {
    page: Arc<dyn Page>,
    /// What errors name.
    tile: u32,
    count: usize,
    blank: T,
    /// Of the displacement, see [`Texel::bound`].
    bound: [f32; 2],
    pager: Arc<Pager>,
    loaded: OnceLock<Loaded<T>>,
}

struct Loaded<T> {
    texels: Arc<[T]>,
    failed: Option<Error>,
}

impl<T> fmt::Debug for Paged<T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Paged(tile {}, {:?})", self.tile, self.page)
    }
}

/// What the blocks of one channel page to. Two fields that have the same one are of one channel, so that tiles of the
/// same version hold the same texels.
#[derive(Debug)]
pub(crate) struct Pager {
    pub store: Arc<dyn PageStore>,
    /// What errors call a block.
    noun: &'static str,
    notes: Mutex<Notes>,
}

#[derive(Debug, Default)]
struct Notes {
    /// Tiles that readers brought back, in no order.
    back: Vec<u32>,
    /// The lowest tile that could not be read back, and why.
    fault: Option<(u32, Error)>,
}

impl Pager {
    pub fn new(store: Arc<dyn PageStore>) -> Arc<Self> {
        Self::of(store, "tile")
    }

    /// As [`Self::new`], where errors call a block a `noun`.
    pub fn of(store: Arc<dyn PageStore>, noun: &'static str) -> Arc<Self> {
        Arc::new(Self { store, noun, notes: Mutex::default() })
    }

    /// Another for the same store.
    pub fn fork(&self) -> Arc<Self> {
        Self::of(self.store.clone(), self.noun)
    }

    fn place(&self, block: u32) -> String {
        format!("{} {block}", self.noun)
    }

    fn notes(&self) -> MutexGuard<'_, Notes> {
        self.notes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The tiles that readers brought back since this was called last.
    pub fn take_back(&self) -> Vec<u32> {
        std::mem::take(&mut self.notes().back)
    }

    /// What could not be read or written since this was called last.
    pub fn take_fault(&self) -> Option<Error> {
        self.notes().fault.take().map(|(_, error)| error)
    }

    /// Keeps an error about `tile` for the next call that can return it.
    pub fn note(&self, tile: u32, error: Error) {
        let mut notes = self.notes();
        if notes.fault.as_ref().is_none_or(|(other, _)| *other > tile) {
            notes.fault = Some((tile, error));
        }
    }
}

impl<T: Texel> Deref for Slot<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match self {
            Self::Here(texels) => texels,
            Self::Paged(paged) => &paged.texels().texels,
        }
    }
}

impl<T: Texel> Slot<T> {
    /// Stores the texels of `tile` on a page, unless they are on `clean` already.
    pub fn page_out(&self, tile: u32, blank: T, pager: &Arc<Pager>, clean: Option<Arc<dyn Page>>) -> Result<Self> {
        let Self::Here(texels) = self else { return Ok(self.clone()) };
        if texels.is_empty() {
            return Ok(self.clone());
        }
        let page = match clean {
            Some(page) => page,
            None => pager.store.store(bytemuck::cast_slice(texels)).map_err(|error| error.at(pager.place(tile)))?,
        };
        let (count, bound) = (texels.len(), T::bound(texels));
        let (pager, loaded) = (pager.clone(), OnceLock::new());
        Ok(Self::Paged(Arc::new(Paged { page, tile, count, blank, bound, pager, loaded })))
    }

    /// The texels, if they are in memory for good.
    pub fn here_mut(&mut self) -> Option<&mut Arc<[T]>> {
        match self {
            Self::Here(texels) => Some(texels),
            Self::Paged(_) => None,
        }
    }

    pub fn is_paged(&self) -> bool {
        matches!(self, Self::Paged(_))
    }

    /// The texels, shared. Fails if they are on a page that cannot be read.
    pub fn shared(&self) -> Result<Arc<[T]>> {
        match self {
            Self::Here(texels) => Ok(texels.clone()),
            Self::Paged(paged) => {
                let loaded = paged.texels();
                loaded.failed.clone().map_or_else(|| Ok(loaded.texels.clone()), Err)
            }
        }
    }

    /// Fails if the texels are on a page that cannot be read.
    pub fn check(&self) -> Result<()> {
        match self {
            Self::Here(_) => Ok(()),
            Self::Paged(paged) => paged.texels().failed.clone().map_or(Ok(()), Err),
        }
    }

    /// Whether the texels were looked at and could not be read.
    pub fn has_failed(&self) -> bool {
        matches!(self, Self::Paged(paged) if paged.loaded.get().is_some_and(|loaded| loaded.failed.is_some()))
    }

    /// Bytes that readers brought back.
    pub fn back_bytes(&self) -> u64 {
        match self {
            Self::Paged(paged) if paged.loaded.get().is_some() => (paged.count * size_of::<T>()) as u64,
            _ => 0,
        }
    }

    /// On the same page, with nothing of it in memory: other fields keep what readers brought back for them.
    pub fn release(&mut self, pager: &Arc<Pager>) {
        if let Self::Paged(paged) = self {
            let Paged { page, tile, count, blank, bound, .. } = &**paged;
            let (page, pager, loaded) = (page.clone(), pager.clone(), OnceLock::new());
            *paged = Arc::new(Paged { page, tile: *tile, count: *count, blank: *blank, bound: *bound, pager, loaded });
        }
    }

    /// The bound of texels that are on a page, see [`Texel::bound`].
    pub fn bound(&self) -> Option<[f32; 2]> {
        match self {
            Self::Here(_) => None,
            Self::Paged(paged) => Some(paged.bound),
        }
    }

    /// Whether both are the same memory or page, and so the same texels.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Here(a), Self::Here(b)) => Arc::ptr_eq(a, b),
            (Self::Paged(a), Self::Paged(b)) => Arc::ptr_eq(&a.page, &b.page),
            _ => false,
        }
    }
}

impl<T: Texel> Paged<T> {
    /// The texels, brought back if they are not in memory.
    #[inline]
    fn texels(&self) -> &Loaded<T> {
        match self.loaded.get() {
            Some(loaded) => loaded,
            None => self.bring_back(),
        }
    }

    #[cold]
    #[inline(never)]
    fn bring_back(&self) -> &Loaded<T> {
        self.loaded.get_or_init(|| {
            let loaded = match self.read() {
                Ok(texels) => Loaded { texels, failed: None },
                Err(error) => {
                    let error = error.at(self.pager.place(self.tile));
                    self.pager.note(self.tile, error.clone());
                    Loaded { texels: vec![self.blank; self.count].into(), failed: Some(error) }
                }
            };
            self.pager.notes().back.push(self.tile);
            loaded
        })
    }

    fn read(&self) -> Result<Arc<[T]>> {
        let bytes = self.page.load()?;
        if bytes.len() != self.count * size_of::<T>() {
            return Err(Error::invalid(format!("a page of {} bytes is none of its", bytes.len())));
        }
        Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }
}
