//! What was measured, as a table or as JSON lines.

use serde_json::json;

use crate::measure::Sample;

/// What a figure has to reach.
#[derive(Clone, Copy, Debug)]
pub enum Goal {
    /// No goal: the figure is for information.
    None,
    /// Ours at most this, in the figure's unit.
    AtMost(f64),
    /// Ours at least this, in the figure's unit.
    AtLeast(f64),
    /// Ours divided by the peer's at most this.
    RatioAtMost(f64),
    /// Ours divided by the peer's at least this.
    RatioAtLeast(f64),
}

impl Goal {
    fn text(self) -> String {
        match self {
            Self::None => String::new(),
            Self::AtMost(limit) => format!("<= {limit}"),
            Self::AtLeast(limit) => format!(">= {limit}"),
            Self::RatioAtMost(limit) => format!("ratio <= {limit}"),
            Self::RatioAtLeast(limit) => format!("ratio >= {limit}"),
        }
    }

    fn met(self, ours: f64, ratio: Option<f64>) -> Option<bool> {
        match self {
            Self::None => None,
            Self::AtMost(limit) => Some(ours <= limit),
            Self::AtLeast(limit) => Some(ours >= limit),
            Self::RatioAtMost(limit) => ratio.map(|ratio| ratio <= limit),
            Self::RatioAtLeast(limit) => ratio.map(|ratio| ratio >= limit),
        }
    }
}

/// The figures of one bench.
pub struct Report {
    bench: String,
    json: bool,
    rows: Vec<[String; 6]>,
}

impl Report {
    /// An empty report of `bench`. With `json`, figures are printed as they come, one object per line.
    pub fn new(bench: &str, json: bool) -> Self {
        Self { bench: bench.into(), json, rows: Vec::new() }
    }

    /// Adds a figure in `unit` with the peer's name and sample, if there is one.
    pub fn add(&mut self, case: &str, ours: &Sample, peer: Option<(&str, &Sample)>, unit: &str, goal: Goal) {
        let value = ours.median();
        let other = peer.map(|(_, sample)| sample.median());
        let ratio = other.map(|other| value / other);
        let met = goal.met(value, ratio);
        if self.json {
            let object = json!({
                "bench": self.bench, "case": case, "ours": value, "peer": other,
                "peer_name": peer.map(|(name, _)| name), "unit": unit, "ratio": ratio, "goal": goal.text(), "met": met,
            });
            println!("{object}");
            return;
        }
        let shown = |sample: &Sample| format!("{} ±{:.0}%", figure(sample.median()), 100.0 * sample.spread());
        self.rows.push([
            case.into(),
            format!("{} {unit}", shown(ours)),
            peer.map_or(String::new(), |(name, sample)| format!("{} {name}", shown(sample))),
            ratio.map_or(String::new(), figure),
            goal.text(),
            met.map_or("", |met| if met { "yes" } else { "NO" }).into(),
        ]);
    }

    /// Says why a case is not measured.
    pub fn skip(&self, case: &str, reason: &str) {
        eprintln!("skipped: {case}: {reason}");
    }

    /// Prints the figures so far as a table.
    pub fn finish(self) {
        if self.json {
            return;
        }
        let head = ["case", "ours", "peer", "ratio", "goal", "met"];
        let mut rows = vec![head.map(String::from).to_vec()];
        rows.extend(self.rows.iter().map(|row| row.to_vec()));
        print!("{}", table(&rows));
    }
}

/// Lines of a table whose first row is its head; columns are as wide as they need.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
    let widths: Vec<_> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let mut text = String::new();
    for (index, row) in rows.iter().enumerate() {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        text += cells.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
        if index == 0 {
            text += &"-".repeat(widths.iter().sum::<usize>() + 2 * columns.saturating_sub(1));
            text.push('\n');
        }
    }
    text
}

/// A number with three to four significant digits.
pub fn figure(value: f64) -> String {
    match value.abs() {
        size if size >= 1000.0 => format!("{value:.0}"),
        size if size >= 100.0 => format!("{value:.1}"),
        size if size >= 10.0 => format!("{value:.2}"),
        size if size >= 0.1 || size == 0.0 => format!("{value:.3}"),
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_held_against_the_value_or_the_ratio() {
        assert_eq!(Goal::AtMost(3.0).met(3.0, None), Some(true));
        assert_eq!(Goal::AtMost(3.0).met(3.1, None), Some(false));
        assert_eq!(Goal::RatioAtLeast(20.0).met(1.0, Some(21.0)), Some(true));
        assert_eq!(Goal::RatioAtMost(1.3).met(1.0, Some(1.4)), Some(false));
        assert_eq!(Goal::RatioAtMost(1.3).met(1.0, None), None);
        assert_eq!(Goal::None.met(1.0, Some(1.0)), None);
    }

    #[test]
    fn columns_line_up() {
        let row = |a: &str, b: &str| vec![a.to_string(), b.to_string()];
        assert_eq!(table(&[row("a", "b"), row("long", "1")]), "a     b\n-------\nlong  1\n");
    }

    #[test]
    fn figures_keep_their_digits() {
        assert_eq!(
            ["0.254", "46.05", "1292"],
            [figure(0.254), figure(46.054), figure(1292.4)].each_ref().map(|s| &**s)
        );
    }
}
