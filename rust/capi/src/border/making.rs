//! What a function makes, read from its arguments and not made yet: at once on the calling thread, or as a job.

use std::sync::Arc;

use relievo_core::progress::Silent;
use relievo_core::{Progress, Result};

use crate::runtime::context::ContextObject;

type Make<T> = Box<dyn FnOnce(&mut dyn Progress) -> Result<T> + Send>;

/// Work whose arguments were read and refused where they can be.
pub struct Making<T> {
    context: Arc<ContextObject>,
    make: Make<T>,
}

impl<T> Making<T> {
    /// Returns work of `context`. What `make` refuses before it reports progress is refused where a job is started.
    pub fn new(
        context: Arc<ContextObject>,
        make: impl FnOnce(&mut dyn Progress) -> Result<T> + Send + 'static,
    ) -> Self {
        Self { context, make: Box::new(make) }
    }

    /// Returns the context that the work belongs to.
    pub fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    /// Does the work on the calling thread.
    ///
    /// # Errors
    /// Returns the error of the work.
    pub fn now(self) -> Result<T> {
        (self.make)(&mut Silent)
    }

    /// Does the work and reports progress.
    ///
    /// # Errors
    /// Returns the error of the work, which is `Cancelled` if `progress` asks to stop.
    pub fn watched(self, progress: &mut dyn Progress) -> Result<T> {
        (self.make)(progress)
    }
}
