//! A page store for tests.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use relievo_core::{Error, Result};
use relievo_document::{Page, PageStore};

/// A store that counts, and can be told to fail.
#[derive(Debug, Default)]
pub struct Faulty {
    pub broken: Arc<AtomicBool>,
    pub full: AtomicBool,
    pub loads: Arc<AtomicU64>,
}

#[derive(Debug)]
struct FaultyPage {
    bytes: Mutex<Vec<u8>>,
    broken: Arc<AtomicBool>,
    loads: Arc<AtomicU64>,
}

impl Page for FaultyPage {
    fn load(&self) -> Result<Vec<u8>> {
        self.loads.fetch_add(1, Ordering::SeqCst);
        if self.broken.load(Ordering::SeqCst) {
            return Err(Error::invalid("a page is not what was stored"));
        }
        Ok(self.bytes.lock().unwrap().clone())
    }
}

impl PageStore for Faulty {
    fn store(&self, bytes: &[u8]) -> Result<Arc<dyn Page>> {
        if self.full.load(Ordering::SeqCst) {
            return Err(Error::memory("no room"));
        }
        let (broken, loads) = (self.broken.clone(), self.loads.clone());
        Ok(Arc::new(FaultyPage { bytes: Mutex::new(bytes.to_vec()), broken, loads }))
    }
}
