//! Abaqus input files, `.inp`, which CalculiX reads too: written with C3D8R elements, sets, materials and boundaries.
//!
//! Elements of equal moduli share a material. Fibres, sliding nodes and bound surfaces have no counterpart and are left out.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use relievo_core::{Result, file};

use crate::model::Model;

/// Numbers in a line of a set.
const IN_LINE: usize = 12;

impl Model {
    /// Returns the text of an Abaqus input file: nodes and elements from 1, in metres, kilograms and seconds.
    pub fn to_inp(&self) -> String {
        let mut text = String::from("** Written by Relievo; metres, kilograms, seconds.\n*NODE, NSET=ALL\n");
        for (number, [x, y, z]) in (1..).zip(&self.nodes) {
            let _ = writeln!(text, "{number}, {x}, {y}, {z}");
        }
        // By their bits, so that the order is the same everywhere.
        let mut groups: BTreeMap<[u32; 3], Vec<usize>> = BTreeMap::new();
        for element in 0..self.elements.len() {
            groups.entry(self.moduli(element).map(f32::to_bits)).or_default().push(element);
        }
        for (group, elements) in (1..).zip(groups.values()) {
            let _ = writeln!(text, "*ELEMENT, TYPE=C3D8R, ELSET=MIXTURE-{group}");
            for element in elements {
                let corners = self.elements[*element].map(|node| (node + 1).to_string()).join(", ");
                let _ = writeln!(text, "{}, {corners}", element + 1);
            }
        }
        for set in &self.sets {
            let _ = writeln!(text, "*NSET, NSET={}", keyword(&set.name));
            for line in set.nodes.chunks(IN_LINE) {
                let line: Vec<String> = line.iter().map(|node| (node + 1).to_string()).collect();
                let _ = writeln!(text, "{}", line.join(", "));
            }
        }
        for (group, bits) in (1..).zip(groups.keys()) {
            let [shear, bulk, density] = bits.map(f32::from_bits);
            let _ = writeln!(text, "*MATERIAL, NAME=MIXTURE-{group}");
            let _ = writeln!(text, "*HYPERELASTIC, NEO HOOKE\n{}, {}", 0.5 * shear, 2.0 / bulk);
            let _ = writeln!(text, "*DENSITY\n{density}");
            let _ = writeln!(text, "*SOLID SECTION, ELSET=MIXTURE-{group}, MATERIAL=MIXTURE-{group}");
        }
        if !self.held.is_empty() {
            text += "*BOUNDARY\n";
            for held in &self.held {
                for axis in (0..3).filter(|axis| held.axes >> axis & 1 != 0) {
                    let _ = writeln!(text, "{}, {}, {}, 0", held.node + 1, axis + 1, axis + 1);
                }
            }
        }
        text
    }

    /// Writes an Abaqus input file.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn write_inp(&self, path: &Path) -> Result<()> {
        let text = self.to_inp();
        file::store(path, |out| out.write_all(text.as_bytes()))
    }
}

/// Returns a name that the format allows.
fn keyword(name: &str) -> String {
    let letter = |letter: char| match letter {
        '+' => 'P',
        letter if letter.is_ascii_alphanumeric() || letter == '-' || letter == '_' => letter.to_ascii_uppercase(),
        _ => '_',
    };
    let name: String = name.chars().map(letter).collect();
    if name.starts_with(|first: char| first.is_ascii_alphabetic()) { name } else { format!("SET_{name}") }
}
