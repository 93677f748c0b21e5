//! All ranks of MPI as the transport of a fluid.

use std::sync::{Arc, Mutex, PoisonError};

use relievo_core::Result;
use relievo_fluid::Transport;
use relievo_openmpi::World;

/// All ranks, shared by the fluid and the program, which call it in turn.
#[derive(Clone)]
pub struct Ranks(Arc<Mutex<World>>);

impl Ranks {
    /// Shares a world.
    pub fn new(world: World) -> Self {
        Self(Arc::new(Mutex::new(world)))
    }

    /// Ends all ranks with exit code 1.
    pub fn abort(&self) -> ! {
        self.with(|world| world.abort(1))
    }

    fn with<T>(&self, call: impl FnOnce(&mut World) -> T) -> T {
        // A panic between two calls of MPI leaves nothing half done.
        call(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Transport for Ranks {
    fn rank(&self) -> usize {
        self.with(|world| world.rank())
    }

    fn ranks(&self) -> usize {
        self.with(|world| world.ranks())
    }

    fn exchange(&mut self, sent: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        self.with(|world| world.exchange(&sent))
    }

    fn gather(&mut self, own: Vec<u8>) -> Result<Vec<Vec<u8>>> {
        self.with(|world| world.gather(&own))
    }
}
