//! Times of passes as callers see them.

use std::time::Duration;

/// How long a pass took on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassTime {
    /// The pass's name.
    pub name: &'static str,
    /// From the beginning of its first command to the end of its last.
    pub length: Duration,
}
