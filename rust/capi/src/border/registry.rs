//! The registry of handles. A handle is a 64-bit id: 8 bits say which noun it is, 24 bits count how often its slot was
//! used before, 32 bits are the slot. An id that was never given out, was released, or is another noun's is an error.

use std::any::{Any, TypeId};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use relievo_core::{Error, Result};

use crate::border::work::{self, Held};

/// A handle type and what it stands for.
pub trait Handle: Copy {
    /// Number of the noun in ids, from 1.
    const TAG: u8;
    /// The object behind the handle.
    type Object: Any + Send + Sync;
    /// The id in the handle.
    fn id(self) -> u64;
    /// The handle with an id.
    fn of(id: u64) -> Self;
}

/// Names of the nouns, by tag.
pub const NOUNS: [&str; 37] = [
    "nothing",
    "context",
    "mesh",
    "surface",
    "detail",
    "collider",
    "caster",
    "tessellation",
    "brush",
    "stroke",
    "document",
    "picture",
    "procedural",
    "job",
    "bezier",
    "buffer",
    "progressive mesh",
    "level",
    "color buffer",
    "arrival",
    "device level",
    "isosurface",
    "fluid",
    "particles",
    "grid",
    "decal",
    "foam",
    "shader",
    "tissue",
    "tissue simulation",
    "client",
    "diffuse",
    "crowd model",
    "crowd",
    "bytes",
    "subdivision",
    "device crowd",
];

/// Defines the handle type of a noun.
macro_rules! handle {
    ($name:ident, $tag:literal, $object:ty) => {
        const _: () = assert!($tag < $crate::border::registry::NOUNS.len(), "a noun needs a name");

        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default)]
        pub struct $name {
            pub id: u64,
        }

        impl $crate::border::registry::Handle for $name {
            const TAG: u8 = $tag;
            type Object = $object;
            fn id(self) -> u64 {
                self.id
            }
            fn of(id: u64) -> Self {
                Self { id }
            }
        }
    };
}
pub(crate) use handle;

/// Uses of a slot before it is retired, so that an id never comes back.
const GENERATIONS: u64 = 1 << 24;

struct Slot {
    /// The id given out for this slot last.
    id: u64,
    /// References that C holds; 0 if the slot is free.
    references: u32,
    /// Forks before the object was made.
    forks: u32,
    object: Option<Arc<dyn Any + Send + Sync>>,
    /// The type of the object: to ask the object itself takes a call and a wait for its result.
    kind: TypeId,
}

struct Registry {
    slots: Vec<Slot>,
    free: Vec<u32>,
}

static REGISTRY: RwLock<Registry> = RwLock::new(Registry { slots: Vec::new(), free: Vec::new() });

// No code that may panic runs while the lock is held, so a poisoned lock guards a sound table.
fn reading() -> RwLockReadGuard<'static, Registry> {
    REGISTRY.read().unwrap_or_else(PoisonError::into_inner)
}

fn writing() -> RwLockWriteGuard<'static, Registry> {
    REGISTRY.write().unwrap_or_else(PoisonError::into_inner)
}

/// Forks between the process that loaded the library and this one.
static FORKS: AtomicU32 = AtomicU32::new(0);

fn forks() -> u32 {
    FORKS.load(Ordering::Relaxed)
}

/// Marks every object made so far as one of a parent process.
pub fn forked() {
    FORKS.fetch_add(1, Ordering::Relaxed);
}

/// The registry, locked: no other thread reads or changes it.
pub struct Locked(#[expect(dead_code, reason = "held until it is dropped")] RwLockWriteGuard<'static, Registry>);

/// Locks the registry.
pub fn lock() -> Locked {
    Locked(writing())
}

fn noun(tag: u8) -> &'static str {
    NOUNS.get(usize::from(tag)).copied().unwrap_or("unknown thing")
}

fn refuse<H: Handle>(id: u64) -> Error {
    let expected = noun(H::TAG);
    let tag = (id >> 56) as u8;
    if id == 0 {
        Error::invalid("the handle is NULL").at(expected).advise(format!("pass a living {expected}"))
    } else if tag == H::TAG {
        Error::invalid(format!("the handle {id:#x} is not alive"))
            .at(expected)
            .advise("it was released or never made; keep a reference with the noun's retain function")
    } else {
        Error::invalid(format!("the handle {id:#x} is of a {}", noun(tag)))
            .at(expected)
            .advise(format!("pass a {expected}"))
    }
}

impl Registry {
    fn slot<H: Handle>(&self, handle: H) -> Result<usize> {
        let id = handle.id();
        let index = (id & 0xffff_ffff) as usize;
        match self.slots.get(index) {
            Some(slot) if slot.id == id && slot.references > 0 && (id >> 56) as u8 == H::TAG => Ok(index),
            _ => Err(refuse::<H>(id)),
        }
    }
}

/// Registers `object` with one reference.
///
/// # Errors
/// Fails with `Memory` if there are 2³² objects.
pub fn insert<H: Handle>(object: H::Object) -> Result<H> {
    let object: Arc<dyn Any + Send + Sync> = Arc::new(object);
    let mut registry = writing();
    let (index, generation) = match registry.free.pop() {
        Some(index) => (index, (registry.slots[index as usize].id >> 32 & (GENERATIONS - 1)) + 1),
        None => {
            let index = u32::try_from(registry.slots.len())
                .map_err(|_| Error::memory("too many objects are alive").advise("release some"))?;
            registry.slots.push(Slot { id: 0, references: 0, forks: 0, object: None, kind: TypeId::of::<()>() });
            (index, 1)
        }
    };
    let id = u64::from(H::TAG) << 56 | generation << 32 | u64::from(index);
    let kind = TypeId::of::<H::Object>();
    registry.slots[index as usize] = Slot { id, references: 1, forks: forks(), object: Some(object), kind };
    Ok(H::of(id))
}

/// What a handle with the id is of, and its object, whatever noun it is.
///
/// # Errors
/// Fails with `Invalid` if the id is 0 or of no living handle, and with `Unsupported` if the process was forked after
/// the object was made.
pub fn any(id: u64) -> Result<(&'static str, Arc<dyn Any + Send + Sync>)> {
    let registry = reading();
    let dead = || {
        let what = if id == 0 { "the handle is NULL".into() } else { format!("the handle {id:#x} is not alive") };
        Error::invalid(what).at("object").advise("pass the id of a living handle")
    };
    let slot = registry.slots.get((id & 0xffff_ffff) as usize);
    let slot = slot.filter(|slot| slot.id == id && slot.references > 0).ok_or_else(dead)?;
    if slot.forks != forks() {
        return Err(inherited((id >> 56) as u8));
    }
    Ok((noun((id >> 56) as u8), slot.object.clone().ok_or_else(dead)?))
}

fn inherited(tag: u8) -> Error {
    Error::unsupported("the process was forked after this object was made, and its threads stayed behind")
        .at(noun(tag))
        .advise("make a context and its objects in the child; in Python start processes by \"spawn\"")
}

/// The object of a handle, which stays alive while the returned reference does, even if C releases the handle.
///
/// # Errors
/// Fails with `Invalid` if the handle is NULL, dead or of another noun, and with `Unsupported` if the process was
/// forked after the object was made.
pub fn get<H: Handle>(handle: H) -> Result<Arc<H::Object>> {
    let registry = reading();
    let index = registry.slot(handle)?;
    let slot = &registry.slots[index];
    if slot.forks != forks() {
        return Err(inherited(H::TAG));
    }
    match &slot.object {
        Some(object) if slot.kind == TypeId::of::<H::Object>() => {
            let object = Arc::into_raw(Arc::clone(object)).cast::<H::Object>();
            // SAFETY: the pointer comes from `into_raw`, and `insert`, which alone fills slots, made the object of this type.
            Ok(unsafe { Arc::from_raw(object) })
        }
        _ => Err(refuse::<H>(handle.id())),
    }
}

/// Adds a reference.
///
/// # Errors
/// Fails with `Invalid` if the handle is NULL, dead or of another noun, or has 2³² references.
pub fn retain<H: Handle>(handle: H) -> Result<()> {
    let mut registry = writing();
    let index = registry.slot(handle)?;
    let references = &mut registry.slots[index].references;
    *references = references.checked_add(1).ok_or_else(|| {
        Error::invalid("too many references").at(noun(H::TAG)).advise("release as often as you retain")
    })?;
    Ok(())
}

/// Takes a reference away; the handle dies with the last one.
///
/// # Errors
/// Fails with `Invalid` if the handle is NULL, dead or of another noun.
pub fn release<H: Handle>(handle: H) -> Result<()> {
    let mut registry = writing();
    let index = registry.slot(handle)?;
    let slot = &mut registry.slots[index];
    slot.references -= 1;
    if slot.references == 0 {
        let object = slot.object.take();
        let inherited = slot.forks != forks();
        if (slot.id >> 32 & (GENERATIONS - 1)) + 1 < GENERATIONS {
            registry.free.push(index as u32);
        }
        // What the object owns may be large; it goes after the lock.
        drop(registry);
        if inherited {
            // To drop it would wait for threads that a forked child does not have.
            std::mem::forget(object);
        }
    }
    Ok(())
}

/// Reads `lock` without waiting.
///
/// # Errors
/// Fails with `Busy` while a mutating call is at work, and with `Internal` if an earlier panic left the object broken.
pub fn try_read<'a, T>(lock: &'a RwLock<T>, noun: &str) -> Result<Held<RwLockReadGuard<'a, T>>> {
    work::hold(lock, lock.try_read(), noun)
}

/// Takes `lock` exclusively without waiting.
///
/// # Errors
/// Fails with `Busy` while any other call is at work, and with `Internal` if an earlier panic left the object broken.
pub fn try_write<'a, T>(lock: &'a RwLock<T>, noun: &str) -> Result<Held<RwLockWriteGuard<'a, T>>> {
    work::hold(lock, lock.try_write(), noun)
}

/// Takes `lock` without waiting.
///
/// # Errors
/// Fails with `Busy` while another call is at work, and with `Internal` if an earlier panic left the object broken.
pub fn try_lock<'a, T>(lock: &'a Mutex<T>, noun: &str) -> Result<Held<MutexGuard<'a, T>>> {
    work::hold(lock, lock.try_lock(), noun)
}
