//! What a run says of its ranks: particles, copies and messages.

use std::fmt::Write;

use relievo_core::{Error, Result};
use relievo_fluid::{Traffic, Transport};

/// Numbers that a rank reports.
const NUMBERS: usize = 7;

/// Returns a table of the ranks, from what each sent in so many steps, which took so many seconds with the frames.
pub fn report(ranks: &mut dyn Transport, own: Traffic, steps: u64, elapsed: f64) -> Result<String> {
    let own = [
        own.owned as f64,
        own.copies as f64,
        own.exchanges as f64,
        own.migrated as f64,
        own.refreshed as f64,
        own.reduced as f64,
        own.seconds,
    ];
    let message = own.iter().flat_map(|number| number.to_le_bytes()).collect();
    let mut text = "rank  particles  copies  exchanges a step  migrated B a step  refreshed B a step  reduced B a step  % in exchanges\n".to_owned();
    let each = steps.max(1) as f64;
    let (mut most, mut sum) = (0.0f64, 0.0);
    let all = ranks.gather(message)?;
    for (rank, message) in all.iter().enumerate() {
        let numbers: Vec<f64> = message.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let [owned, copies, exchanges, migrated, refreshed, reduced, seconds] =
            <[f64; NUMBERS]>::try_from(numbers).map_err(|_| Error::internal("a rank reports other numbers"))?;
        // Writing into a text does not fail.
        let _ = writeln!(
            text,
            "{rank:4}  {owned:9.0}  {copies:6.0}  {:16.1}  {:17.0}  {:18.0}  {:16.0}  {:14.1}",
            exchanges / each,
            migrated / each,
            refreshed / each,
            reduced / each,
            100.0 * seconds / elapsed.max(f64::MIN_POSITIVE)
        );
        most = most.max(owned);
        sum += owned;
    }
    let imbalance = most * all.len() as f64 / sum.max(1.0) - 1.0;
    let _ = writeln!(text, "imbalance: {:.1} %; {:.4} s a step", 100.0 * imbalance, elapsed / each);
    Ok(text)
}
