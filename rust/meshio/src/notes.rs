//! What a reader left out or repaired, each kind once, with its first line and how often it occurred.

/// Collects notes.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    kinds: Vec<(String, u64, u64)>,
    others: u64,
}

/// Kinds kept apart; a file of garbage has as many as lines.
const KINDS: usize = 16;

impl Notes {
    /// Notes `what` at `line`, 0 for nowhere.
    pub fn add(&mut self, what: &str, line: u64) {
        if let Some(kind) = self.kinds.iter_mut().find(|kind| kind.0 == what) {
            kind.2 += 1;
        } else if self.kinds.len() < KINDS {
            self.kinds.push((what.into(), line, 1));
        } else {
            self.others += 1;
        }
    }

    /// Notes every one of `list`.
    pub fn extend(&mut self, list: Vec<String>) {
        list.iter().for_each(|what| self.add(what, 0));
    }

    /// The notes as sentences.
    pub fn into_list(self) -> Vec<String> {
        let mut list: Vec<String> = self
            .kinds
            .into_iter()
            .map(|(what, line, count)| match (line, count) {
                (0, 1) => what,
                (0, _) => format!("{what} ({count} times)"),
                (_, 1) => format!("line {line}: {what}"),
                _ => format!("line {line}: {what} ({count} times)"),
            })
            .collect();
        if self.others > 0 {
            list.push(format!("{} other statements are left out", self.others));
        }
        list
    }
}
