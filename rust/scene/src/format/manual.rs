//! The format of scene files in print: for people as commented TOML, for programs as JSON.

use relievo_core::Parameter;
use serde_json::{Map, Value, json};

use crate::format::schema::{Kind, sections, shown_unit};

/// A value of a parameter as a scene file shows it.
fn shown_value(parameter: &Parameter, value: f64) -> String {
    match parameter.kind {
        relievo_core::ParameterKind::Bool => (value != 0.0).to_string(),
        _ => shown(value * shown_unit(parameter).0).to_string(),
    }
}

/// The type and range of a parameter in words.
fn parameter_words(parameter: &Parameter) -> String {
    match parameter.kind {
        relievo_core::ParameterKind::Bool => "true or false".into(),
        relievo_core::ParameterKind::U32 => format!("whole number {} to {}", parameter.min, parameter.max),
        relievo_core::ParameterKind::F32 => {
            format!("number {} to {}", shown_value(parameter, parameter.min), shown_value(parameter, parameter.max))
        }
    }
}

/// A number as a scene file shows it: to seven digits, which hides that radians are rounded to f32.
fn shown(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// The schema for people: one line of TOML comment per key.
pub fn text() -> String {
    let mut out = String::new();
    for section in sections() {
        match section.name {
            "" => out.push_str("# The whole file. Angles are in degrees, paths relative to this file.\n"),
            name => out.push_str(&format!("\n# {}\n[{name}]\n", section.help)),
        }
        for key in section.keys {
            let unit = if key.unit.is_empty() { String::new() } else { format!(", in {}", key.unit) };
            let default = if key.default.is_empty() { String::new() } else { format!(" = {}", key.default) };
            out.push_str(&format!("{}{default}  # {}; {}{unit}\n", key.name, key.help, key.kind.words()));
        }
        for parameter in section.parameters {
            let (_, unit) = shown_unit(parameter);
            let unit = if unit.is_empty() { String::new() } else { format!(", in {unit}") };
            let default = shown_value(parameter, parameter.default);
            let help = parameter.help.trim_end_matches('.');
            out.push_str(&format!("{} = {default}  # {help}; {}{unit}\n", parameter.name, parameter_words(parameter)));
        }
    }
    out
}

/// The schema for programs: an object with `version` and `sections`, each a list of keys.
pub fn json() -> Value {
    let mut list = Map::new();
    for section in sections() {
        let keys = section.keys.iter().map(|key| {
            let mut entry = json!({ "name": key.name, "type": kind_name(&key.kind), "help": key.help });
            if let Some(entry) = entry.as_object_mut() {
                if !key.default.is_empty() {
                    entry.insert("default".into(), key.default.into());
                }
                if !key.unit.is_empty() {
                    entry.insert("unit".into(), key.unit.into());
                }
                match key.kind {
                    Kind::Choice(words) | Kind::Choices(words) => {
                        entry.insert("words".into(), words.into());
                    }
                    Kind::Whole(low, high) | Kind::Power(low, high) => {
                        entry.insert("min".into(), low.into());
                        entry.insert("max".into(), high.into());
                    }
                    Kind::Number(low, high) => {
                        entry.insert("min".into(), low.into());
                        entry.insert("max".into(), high.into());
                    }
                    Kind::Table(section) | Kind::List(section) | Kind::Named(section) => {
                        entry.insert("section".into(), section.name.into());
                    }
                    Kind::Name(section) | Kind::Names(section) => {
                        entry.insert("section".into(), section.into());
                    }
                    _ => {}
                }
            }
            entry
        });
        let parameters = section.parameters.iter().map(|parameter| {
            let (factor, unit) = shown_unit(parameter);
            let kind = match parameter.kind {
                relievo_core::ParameterKind::Bool => "flag",
                relievo_core::ParameterKind::U32 => "whole",
                relievo_core::ParameterKind::F32 => "number",
            };
            json!({
                "name": parameter.name, "type": kind, "help": parameter.help, "unit": unit,
                "default": shown_value(parameter, parameter.default),
                "min": shown(parameter.min * factor), "max": shown(parameter.max * factor),
            })
        });
        let name = if section.name.is_empty() { "scene" } else { section.name };
        list.insert(name.into(), json!({ "help": section.help, "keys": keys.chain(parameters).collect::<Vec<_>>() }));
    }
    json!({ "version": 1, "sections": list })
}

fn kind_name(kind: &Kind) -> &'static str {
    match kind {
        Kind::Text => "text",
        Kind::Path => "path",
        Kind::Name(_) => "name",
        Kind::Names(_) => "names",
        Kind::Flag => "flag",
        Kind::Whole(..) => "whole",
        Kind::Power(..) => "power",
        Kind::Number(..) => "number",
        Kind::Numbers(_) => "numbers",
        Kind::Pairs => "pairs",
        Kind::Scale => "scale",
        Kind::Colour => "colour",
        Kind::Choice(_) => "choice",
        Kind::Choices(_) => "choices",
        Kind::Table(_) => "table",
        Kind::List(_) => "list",
        Kind::Named(_) => "tables",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_schema_names_every_key_in_both_forms() {
        let text = text();
        let json = json();
        for section in sections() {
            for name in section.names() {
                assert!(text.lines().any(|line| line.split([' ', '#']).next() == Some(name)), "{name} is not printed");
                let shown = if section.name.is_empty() { "scene" } else { section.name };
                let keys = json["sections"][shown]["keys"].as_array().unwrap();
                assert!(keys.iter().any(|key| key["name"] == name), "{shown}.{name} is not in the JSON");
            }
        }
    }
}
