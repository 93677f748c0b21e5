//! Counters of the server, and their text for Prometheus.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};

/// A number that is counted by several threads.
#[derive(Default)]
pub struct Counter(AtomicU64);

impl Counter {
    /// Adds to the number.
    pub fn add(&self, more: u64) {
        self.0.fetch_add(more, Ordering::Relaxed);
    }

    /// Subtracts from the number.
    pub fn subtract(&self, less: u64) {
        self.0.fetch_sub(less, Ordering::Relaxed);
    }

    /// Returns the number.
    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// What the server counts.
#[derive(Default)]
pub struct Metrics {
    /// Connections that were accepted.
    pub accepted: Counter,
    /// Connections that are open.
    pub connections: Counter,
    /// Connections that were closed for what they sent or did not send.
    pub dropped: Counter,
    /// Tokens that were refused.
    pub refused: Counter,
    /// Calls.
    pub requests: Counter,
    /// Calls that failed.
    pub failures: Counter,
    /// Bytes of messages in and out.
    pub bytes: [Counter; 2],
    /// Frames that were computed.
    pub frames: Counter,
    /// Microseconds that they took.
    pub microseconds: Counter,
}

impl Metrics {
    /// Returns the counters by their Prometheus names.
    pub fn values(&self) -> BTreeMap<&'static str, f64> {
        let count = |counter: &Counter| counter.get() as f64;
        BTreeMap::from([
            ("relievo_connections_accepted_total", count(&self.accepted)),
            ("relievo_connections", count(&self.connections)),
            ("relievo_connections_dropped_total", count(&self.dropped)),
            ("relievo_tokens_refused_total", count(&self.refused)),
            ("relievo_requests_total", count(&self.requests)),
            ("relievo_requests_failed_total", count(&self.failures)),
            ("relievo_received_bytes_total", count(&self.bytes[0])),
            ("relievo_sent_bytes_total", count(&self.bytes[1])),
            ("relievo_frames_computed_total", count(&self.frames)),
            ("relievo_frame_seconds_total", count(&self.microseconds) / 1e6),
        ])
    }
}

/// Returns values as Prometheus reads them.
pub fn text(values: &BTreeMap<String, f64>) -> String {
    let mut out = String::new();
    for (name, value) in values {
        let kind = if name.ends_with("_total") { "counter" } else { "gauge" };
        // Writing into a text does not fail.
        let _ = writeln!(out, "# TYPE {name} {kind}\n{name} {value}");
    }
    out
}
