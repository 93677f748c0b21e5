//! Reads TOML tables by their schema: every value is checked against its key's type and range, every key must be
//! known, and every fault points at the bytes it is about. Faults are gathered, so that one run shows them all.

use relievo_core::Parameter;
use relievo_core::error::nearest;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::format::diagnostic::{Diagnostic, Span};
use crate::format::schema::{Key, Kind, Section, shown_unit};

/// Faults found so far.
#[derive(Debug, Default)]
pub struct Reader {
    /// The faults.
    pub faults: Vec<Diagnostic>,
}

/// A table of the file with the section it must follow.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a> {
    section: &'static Section,
    entries: Option<&'a DeTable<'a>>,
    /// The bytes of the table, or where it would be.
    pub span: (usize, usize),
}

/// A name written in the file and where. Its debug text leaves the place out, which does not matter for results.
#[derive(Clone, PartialEq, Eq)]
pub struct Name {
    /// The name.
    pub text: String,
    /// Its bytes.
    pub span: Span,
}

impl std::fmt::Debug for Name {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.text.fmt(out)
    }
}

impl<'a> Table<'a> {
    /// A table; its keys are checked by [`Reader::table`].
    fn new(section: &'static Section, entries: Option<&'a DeTable<'a>>, span: Span) -> Self {
        Self { section, entries, span: (span.start, span.end) }
    }

    /// The bytes of the table.
    pub fn span(&self) -> Span {
        self.span.0..self.span.1
    }

    /// The bytes of the value of `key`, or of the table if the key is not written.
    pub fn span_of(&self, key: &str) -> Span {
        self.value(key).map_or(self.span(), |value| value.span())
    }

    /// Whether `key` is written.
    pub fn has(&self, key: &str) -> bool {
        self.value(key).is_some()
    }

    /// The first of `keys` that is written.
    pub fn first_of<'k>(&self, keys: &[&'k str]) -> Option<&'k str> {
        keys.iter().copied().find(|key| self.has(key))
    }

    /// Whether a table has a name that the section does not know.
    pub fn has_unknown_table(&self) -> bool {
        self.entries.into_iter().flatten().any(|(name, value)| {
            value.get_ref().as_table().is_some() && self.section.names().all(|known| known != name.get_ref().as_ref())
        })
    }

    fn value(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.entries?.iter().find(|(name, _)| name.get_ref() == key).map(|(_, value)| value)
    }

    fn key(&self, name: &str) -> Key {
        // A name without a key would be a slip in this crate, which the test over all scenes would show as a wrong
        // type.
        self.section.key(name).copied().unwrap_or(Key { name: "", kind: Kind::Text, default: "", unit: "", help: "" })
    }
}

impl Reader {
    /// Notes a fault.
    pub fn fault(&mut self, fault: Diagnostic) {
        self.faults.push(fault);
    }

    /// Checks that `entries` has only keys of `section`.
    pub fn table<'a>(&mut self, section: &'static Section, entries: &'a DeTable<'a>, span: Span) -> Table<'a> {
        for (name, _) in entries {
            if section.names().any(|known| known == name.get_ref().as_ref()) {
                continue;
            }
            let place = if section.name.is_empty() { String::new() } else { format!(" in [{}]", section.name) };
            let fault = Diagnostic::new(name.span(), format!("unknown key `{}`{place}", name.get_ref()));
            self.fault(match nearest(name.get_ref(), section.names()) {
                Some(near) => fault.advise(format!("did you mean `{near}`?")),
                None => fault.advise(format!("known keys are {}", section.names().collect::<Vec<_>>().join(", "))),
            });
        }
        Table::new(section, Some(entries), span)
    }

    /// The table at `key`, or an empty one.
    pub fn sub_table<'a>(&mut self, table: Table<'a>, key: &str) -> Table<'a> {
        let Kind::Table(section) = table.key(key).kind else { return table };
        match table.value(key) {
            None => Table::new(section, None, table.span()),
            Some(value) => match value.get_ref() {
                DeValue::Table(entries) => self.table(section, entries, value.span()),
                other => {
                    self.wrong_type(key, "a table", other, value.span());
                    Table::new(section, None, value.span())
                }
            },
        }
    }

    /// The named tables at `key`, in the order of the file.
    pub fn named<'a>(&mut self, table: Table<'a>, key: &str) -> Vec<(Name, Table<'a>)> {
        let Kind::Named(section) = table.key(key).kind else { return Vec::new() };
        let Some(value) = table.value(key) else { return Vec::new() };
        let DeValue::Table(entries) = value.get_ref() else {
            self.wrong_type(key, "tables by name", value.get_ref(), value.span());
            return Vec::new();
        };
        let mut list = Vec::new();
        for (name, value) in entries {
            let named = Name { text: name.get_ref().to_string(), span: name.span() };
            let plain = |letter: char| letter.is_alphanumeric() || "_-. ".contains(letter);
            if named.text.is_empty()
                || named.text.len() > 100
                || !named.text.chars().all(plain)
                || named.text.starts_with('.')
            {
                self.fault(
                    Diagnostic::new(name.span(), format!("{:?} cannot be a name", named.text))
                        .advise("use up to 100 letters, digits, spaces, `_`, `-` and `.`, and do not begin with a dot"),
                );
                continue;
            }
            match value.get_ref() {
                DeValue::Table(entries) => list.push((named, self.table(section, entries, name.span()))),
                other => self.wrong_type(&named.text, "a table", other, value.span()),
            }
        }
        // The parser sorts by name; results are reported in the order the user wrote.
        list.sort_by_key(|(name, _)| name.span.start);
        list
    }

    /// The list of tables at `key`.
    pub fn list<'a>(&mut self, table: Table<'a>, key: &str) -> Vec<Table<'a>> {
        let Kind::List(section) = table.key(key).kind else { return Vec::new() };
        let Some(value) = table.value(key) else { return Vec::new() };
        let DeValue::Array(items) = value.get_ref() else {
            self.wrong_type(key, "a list of tables", value.get_ref(), value.span());
            return Vec::new();
        };
        let mut list = Vec::new();
        for item in items.iter() {
            match item.get_ref() {
                DeValue::Table(entries) => list.push(self.table(section, entries, item.span())),
                other => self.wrong_type(key, "a table", other, item.span()),
            }
        }
        list
    }

    /// The text at `key`.
    pub fn text(&mut self, table: Table, key: &str) -> Option<Name> {
        let value = table.value(key)?;
        match value.get_ref() {
            DeValue::String(text) => Some(Name { text: text.to_string(), span: value.span() }),
            other => {
                self.wrong_type(key, "a text in quotes", other, value.span());
                None
            }
        }
    }

    /// The texts at `key`: one, or a list.
    pub fn texts(&mut self, table: Table, key: &str) -> Option<Vec<Name>> {
        let value = table.value(key)?;
        let DeValue::Array(items) = value.get_ref() else { return self.text(table, key).map(|text| vec![text]) };
        let mut list: Vec<Name> = Vec::new();
        for item in items.iter() {
            match item.get_ref() {
                DeValue::String(text) => {
                    if let Some(other) = list.iter().find(|other| other.text == text.as_ref()) {
                        self.faults.push(
                            Diagnostic::new(item.span(), format!("`{text}` is listed twice"))
                                .relate(other.span.clone(), "first here")
                                .advise("remove one of them"),
                        );
                        continue;
                    }
                    list.push(Name { text: text.to_string(), span: item.span() });
                }
                other => self.wrong_type(key, "a text in quotes", other, item.span()),
            }
        }
        Some(list)
    }

    /// The switch at `key`.
    pub fn flag(&mut self, table: Table, key: &str) -> bool {
        let default = table.key(key).default == "true";
        match table.value(key) {
            None => default,
            Some(value) => value.get_ref().as_bool().unwrap_or_else(|| {
                self.wrong_type(key, "true or false", value.get_ref(), value.span());
                default
            }),
        }
    }

    /// The number at `key`, its default, or `None` if it has neither.
    pub fn optional_number(&mut self, table: Table, key: &str) -> Option<f64> {
        let Key { kind, default, .. } = table.key(key);
        let Some(value) = table.value(key) else { return default.parse().ok() };
        let Some(number) = self.finite(key, value) else { return default.parse().ok().or(Some(1.0)) };
        let (low, high, words) = match kind {
            Kind::Number(low, high) => (low, high, "a number"),
            Kind::Whole(low, high) => (low as f64, high as f64, "a whole number"),
            Kind::Power(low, high) => (low as f64, high as f64, "a power of two"),
            _ => (f64::MIN, f64::MAX, "a number"),
        };
        let whole = matches!(kind, Kind::Whole(..) | Kind::Power(..));
        let power = matches!(kind, Kind::Power(..));
        if !(low..=high).contains(&number)
            || whole && number.fract() != 0.0
            || power && !(number as u64).is_power_of_two()
        {
            self.fault(
                Diagnostic::new(value.span(), format!("`{key}` is out of range"))
                    .label(format!("this is {number}"))
                    .advise(format!("use {words} from {low} to {high}")),
            );
            return default.parse().ok().or(Some(low.max(1.0)));
        }
        Some(number)
    }

    /// The number at `key` or its default.
    pub fn number(&mut self, table: Table, key: &str) -> f64 {
        self.optional_number(table, key).unwrap_or(0.0)
    }

    /// The whole number at `key` or its default.
    pub fn whole(&mut self, table: Table, key: &str) -> u64 {
        self.number(table, key) as u64
    }

    /// The list of three numbers at `key`, its default, or `None` if it has neither.
    pub fn optional_vector(&mut self, table: Table, key: &str) -> Option<[f64; 3]> {
        let default = || parse_vector(table.key(key).default);
        let Some(value) = table.value(key) else { return default() };
        let numbers = match value.get_ref() {
            DeValue::Array(items) => {
                if items.len() != 3 {
                    self.fault(
                        Diagnostic::new(value.span(), format!("`{key}` has {} numbers", items.len()))
                            .advise("give three, for x, y and z"),
                    );
                    return default().or(Some([0.0; 3]));
                }
                let found: Vec<f64> = items.iter().filter_map(|item| self.finite(key, item)).collect();
                <[f64; 3]>::try_from(found).ok()
            }
            other => {
                self.wrong_type(key, "a list of three numbers", other, value.span());
                None
            }
        };
        let Some(vector) = numbers else { return default().or(Some([0.0; 3])) };
        if vector.iter().any(|number| number.abs() > 1e9) {
            self.fault(Diagnostic::new(value.span(), format!("`{key}` is too large")).advise("stay below 1e9"));
        }
        Some(vector)
    }

    /// The list of pairs of numbers at `key`; empty if it is not written.
    pub fn pairs(&mut self, table: Table, key: &str) -> Vec<[f64; 2]> {
        let Some(value) = table.value(key) else { return Vec::new() };
        let mut list = Vec::new();
        let items = match value.get_ref() {
            DeValue::Array(items) => items,
            other => {
                self.wrong_type(key, "a list of pairs of numbers", other, value.span());
                return list;
            }
        };
        for item in items.iter() {
            match item.get_ref() {
                DeValue::Array(pair) if pair.len() == 2 => {
                    let found: Vec<f64> = pair.iter().filter_map(|number| self.finite(key, number)).collect();
                    list.extend(<[f64; 2]>::try_from(found));
                }
                other => self.wrong_type(key, "a pair of numbers", other, item.span()),
            }
        }
        list
    }

    /// Returns the pair of numbers at `key`, or `None` if it is not written.
    pub fn pair(&mut self, table: Table, key: &str) -> Option<[f64; 2]> {
        let value = table.value(key)?;
        match value.get_ref() {
            DeValue::Array(items) if items.len() == 2 => {
                let found: Vec<f64> = items.iter().filter_map(|item| self.finite(key, item)).collect();
                found.try_into().ok()
            }
            other => {
                self.wrong_type(key, "a pair of numbers", other, value.span());
                None
            }
        }
    }

    /// The list of three numbers at `key` or its default.
    pub fn vector(&mut self, table: Table, key: &str) -> [f64; 3] {
        self.optional_vector(table, key).unwrap_or([0.0; 3])
    }

    /// The scale at `key`, its default, or `None` if it has neither. Zero and mirrored scales are faults.
    pub fn scale(&mut self, table: Table, key: &str) -> Option<[f64; 3]> {
        let Some(value) = table.value(key) else {
            return table.key(key).default.parse::<f64>().ok().map(|number| [number; 3]);
        };
        let scale = match value.get_ref() {
            DeValue::Array(_) => self.optional_vector(table, key)?,
            _ => [self.finite(key, value)?; 3],
        };
        if scale.iter().any(|number| !(1e-6..=1e6).contains(number)) {
            self.fault(
                Diagnostic::new(value.span(), format!("`{key}` is out of range"))
                    .advise("use numbers from 1e-6 to 1e6; a mirrored object needs a mirrored mesh"),
            );
            return Some([1.0; 3]);
        }
        Some(scale)
    }

    /// The colour at `key` or its default, linear Rec.709.
    pub fn colour(&mut self, table: Table, key: &str) -> [f32; 3] {
        let default = parse_vector(table.key(key).default).unwrap_or([0.5; 3]).map(|number| number as f32);
        let Some(value) = table.value(key) else { return default };
        if let DeValue::String(text) = value.get_ref() {
            let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii());
            let Some(code) = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()) else {
                self.fault(
                    Diagnostic::new(value.span(), format!("{text:?} is not a colour"))
                        .advise("write it as \"#rrggbb\""),
                );
                return default;
            };
            return [16, 8, 0].map(|shift| {
                let encoded = ((code >> shift) & 255) as f32 / 255.0;
                if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
            });
        }
        let colour = self.vector(table, key);
        if colour.iter().any(|number| !(0.0..=1e4).contains(number)) {
            self.fault(
                Diagnostic::new(value.span(), format!("`{key}` is out of range")).advise("use numbers from 0 to 1"),
            );
            return default;
        }
        colour.map(|number| number as f32)
    }

    /// The word at `key`, its default, or `None` if it has neither.
    pub fn choice(&mut self, table: Table, key: &str) -> Option<&'static str> {
        let Key { kind: Kind::Choice(words), default, .. } = table.key(key) else { return None };
        let default = words.iter().copied().find(|word| default.trim_matches('"') == *word);
        let Some(text) = self.text(table, key) else { return default };
        self.word(key, &text, words).or(default).or(words.first().copied())
    }

    /// The words at `key` or its default.
    pub fn choices(&mut self, table: Table, key: &str) -> Vec<&'static str> {
        let Key { kind: Kind::Choices(words), default, .. } = table.key(key) else { return Vec::new() };
        let Some(texts) = self.texts(table, key) else {
            return words.iter().copied().filter(|word| default.contains(&format!("\"{word}\""))).collect();
        };
        texts.iter().filter_map(|text| self.word(key, text, words)).collect()
    }

    fn word(&mut self, key: &str, text: &Name, words: &[&'static str]) -> Option<&'static str> {
        let found = words.iter().copied().find(|word| *word == text.text);
        if found.is_none() {
            let fault = Diagnostic::new(text.span.clone(), format!("`{key}` cannot be {:?}", text.text));
            self.fault(match nearest(&text.text, words.iter().copied()) {
                Some(near) => fault.advise(format!("did you mean {near:?}? use one of {}", words.join(", "))),
                None => fault.advise(format!("use one of {}", words.join(", "))),
            });
        }
        found
    }

    /// Calls `set` with every parameter that is written, as the parameter's unit counts it. `set` says whether it took
    /// the value.
    pub fn parameters(&mut self, table: Table, mut set: impl FnMut(&Parameter, f64) -> bool) {
        for parameter in table.section.parameters {
            let Some(value) = table.value(parameter.name) else { continue };
            let (factor, unit) = shown_unit(parameter);
            let number = match value.get_ref() {
                DeValue::Boolean(flag) if parameter.kind == relievo_core::ParameterKind::Bool => Some(f64::from(*flag)),
                _ => self.finite(parameter.name, value).map(|number| number / factor),
            };
            let Some(number) = number else { continue };
            // A range given in radians and asked for in degrees may miss its own ends by rounding.
            let slack = (parameter.max - parameter.min).abs() * 1e-9;
            let number = if factor == 1.0 || number < parameter.min - slack || number > parameter.max + slack {
                number
            } else {
                number.clamp(parameter.min, parameter.max)
            };
            if set(parameter, number) {
                continue;
            }
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            self.fault(Diagnostic::new(value.span(), format!("`{}` is out of range", parameter.name)).advise(format!(
                "use a number from {} to {}{unit}",
                parameter.min * factor,
                parameter.max * factor
            )));
        }
    }

    fn finite(&mut self, key: &str, value: &Spanned<DeValue>) -> Option<f64> {
        let number = match value.get_ref() {
            DeValue::Integer(number) => {
                i64::from_str_radix(number.as_str(), number.radix()).ok().map(|number| number as f64)
            }
            DeValue::Float(number) => number.as_str().parse::<f64>().ok(),
            other => {
                self.wrong_type(key, "a number", other, value.span());
                return None;
            }
        };
        let number = number.filter(|number| number.is_finite());
        if number.is_none() {
            self.fault(
                Diagnostic::new(value.span(), format!("`{key}` is not a finite number"))
                    .advise("write an ordinary number, such as 0.5"),
            );
        }
        number
    }

    fn wrong_type(&mut self, key: &str, wanted: &str, found: &DeValue, span: Span) {
        let found = match found {
            DeValue::String(_) => "a text",
            DeValue::Integer(_) | DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        };
        self.fault(Diagnostic::new(span, format!("`{key}` must be {wanted}")).label(format!("this is {found}")));
    }
}

fn parse_vector(text: &str) -> Option<[f64; 3]> {
    let inner = text.strip_prefix('[')?.strip_suffix(']')?;
    let numbers: Vec<f64> = inner.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    numbers.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::schema::sections;

    #[test]
    fn every_default_is_a_value_of_its_own_key() {
        for section in sections() {
            for key in section.keys.iter().filter(|key| !key.default.is_empty()) {
                let text = format!("{} = {}", key.name, key.default);
                let parsed = DeTable::parse(&text).unwrap();
                let mut reader = Reader::default();
                let table = reader.table(section, parsed.get_ref(), 0..text.len());
                match key.kind {
                    Kind::Flag => drop(reader.flag(table, key.name)),
                    Kind::Whole(..) | Kind::Number(..) | Kind::Power(..) => {
                        let written = reader.number(table, key.name);
                        assert_eq!(Some(written), key.default.parse().ok(), "{}", key.name);
                    }
                    Kind::Numbers(_) => {
                        let written = reader.vector(table, key.name);
                        assert_eq!(Some(written), parse_vector(key.default), "{}", key.name);
                    }
                    Kind::Scale => drop(reader.scale(table, key.name).unwrap()),
                    Kind::Colour => drop(reader.colour(table, key.name)),
                    Kind::Choice(_) => drop(reader.choice(table, key.name).unwrap()),
                    Kind::Choices(_) => {
                        let written = reader.choices(table, key.name);
                        let empty = DeTable::new();
                        let left_out = reader.table(section, &empty, 0..0);
                        assert_eq!(written, reader.choices(left_out, key.name));
                    }
                    Kind::List(_) | Kind::Pairs => assert_eq!(key.default, "[]"),
                    _ => panic!("{} has a default of a kind that has none", key.name),
                }
                assert_eq!(reader.faults, [], "{}", key.name);
            }
        }
    }
}
