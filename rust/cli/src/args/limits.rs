//! Options that bound the threads and the memory of a command.

use relievo_core::{Context, ContextOptions, Result};

#[derive(clap::Args)]
pub struct Limits {
    /// Threads; 0 for one per core. Results do not depend on it.
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    pub memory_limit: u64,
}

/// The option that sets how finely irregular points of a cage are isolated.
#[derive(clap::Args)]
pub struct Isolation {
    /// Levels of isolation of irregular points, 1 to 10; left out, 6, or fewer where these exceed the memory limit.
    #[arg(long, value_name = "LEVELS", value_parser = clap::value_parser!(u32).range(1..=10))]
    pub isolation: Option<u32>,
}

impl Limits {
    /// Makes a context with these limits.
    pub fn context(&self) -> Result<Context> {
        Context::new(&ContextOptions { threads: self.threads, memory_limit: self.memory_limit })
    }
}
