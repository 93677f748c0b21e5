//! The settings of diffuse particles by the names that descriptions and commands use. Limits that belong together are one
//! entry of two numbers; every other setting is an entry of its own name.

use relievo_core::error::nearest;
use relievo_core::{Error, Parameter, Result};

use super::DiffuseSettings;

/// Entries of two numbers: the name, the lower and the upper field, and what they are.
const RANGES: [(&str, [&str; 2], &str); 4] = [
    ("trapped_air", ["air_min", "air_max"], "Limits of the potential of trapped air."),
    ("crests", ["crest_min", "crest_max"], "Limits of the potential of wave crests."),
    ("energy", ["energy_min", "energy_max"], "Limits of the kinetic energy of a kilogram."),
    (
        "lifetime",
        ["lifetime_min", "lifetime_max"],
        "Seconds that foam of the least and of the greatest potential lives.",
    ),
];

/// An entry of a description, or an option of a command.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseEntry {
    /// Its name.
    pub name: &'static str,
    /// The fields of [`DiffuseSettings`] that its numbers set: one, or the lower and the upper limit.
    pub fields: Vec<&'static Parameter>,
    /// What it is.
    pub help: &'static str,
}

impl DiffuseSettings {
    /// Returns the entries that set these settings, in the order of the fields. Every field belongs to one entry.
    pub fn entries() -> Vec<DiffuseEntry> {
        let field = |name: &str| Self::PARAMETERS.iter().find(|parameter| parameter.name == name);
        let entry = |parameter: &'static Parameter| match RANGES.iter().find(|range| range.1.contains(&parameter.name))
        {
            Some((_, [low, _], _)) if *low != parameter.name => None,
            Some((name, fields, help)) => {
                Some(DiffuseEntry { name, fields: fields.iter().filter_map(|name| field(name)).collect(), help })
            }
            None => Some(DiffuseEntry { name: parameter.name, fields: vec![parameter], help: parameter.help }),
        };
        Self::PARAMETERS.iter().filter_map(entry).collect()
    }

    /// Sets an entry by its name.
    ///
    /// # Errors
    /// Fails if there is no entry of the name, if it has another number of values, or if a value is out of range.
    pub fn set_entry(&mut self, name: &str, values: &[f64]) -> Result<()> {
        let entries = Self::entries();
        let Some(entry) = entries.iter().find(|entry| entry.name == name) else {
            let error = Error::invalid(format!("unknown setting `{name}`"));
            return Err(match nearest(name, entries.iter().map(|entry| entry.name)) {
                Some(near) => error.advise(format!("did you mean `{near}`?")),
                None => {
                    let names: Vec<_> = entries.iter().map(|entry| entry.name).collect();
                    error.advise(format!("use one of {}", names.join(", ")))
                }
            });
        };
        if values.len() != entry.fields.len() {
            return Err(Error::invalid(format!("`{name}` has {} numbers", values.len()))
                .advise(format!("give it {}", entry.fields.len())));
        }
        entry.fields.iter().zip(values).try_for_each(|(field, value)| self.set(field.name, *value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_is_set_by_one_entry_within_its_range() {
        let entries = DiffuseSettings::entries();
        let fields: Vec<_> = entries.iter().flat_map(|entry| entry.fields.iter().map(|field| field.name)).collect();
        let all: Vec<_> = DiffuseSettings::PARAMETERS.iter().map(|field| field.name).collect();
        assert_eq!(fields, all);
        let mut settings = DiffuseSettings::default();
        for entry in &entries {
            let values: Vec<f64> = entry.fields.iter().map(|field| field.min).collect();
            settings.set_entry(entry.name, &values).unwrap();
            let below: Vec<f64> = entry.fields.iter().map(|field| field.min - 1.0).collect();
            assert!(settings.set_entry(entry.name, &below).unwrap_err().what.contains(entry.fields[0].name));
            assert!(settings.set_entry(entry.name, &[values, vec![1.0]].concat()).is_err(), "{}", entry.name);
        }
        assert!(DiffuseSettings::PARAMETERS.iter().all(|field| settings.get(field.name).unwrap() == field.min));
        settings.set_entry("lifetime", &[1.5, 4.0]).unwrap();
        assert_eq!([settings.lifetime_min, settings.lifetime_max], [1.5, 4.0]);
        assert!(settings.set_entry("air_rat", &[1.0]).unwrap_err().remedy.contains("air_rate"));
        assert!(settings.set_entry("zebra", &[1.0]).unwrap_err().remedy.contains("trapped_air"));
    }
}
