//! Reading of Abaqus input files: nodes, hexahedra, sets, materials, sections and boundaries that hold nodes.

use std::collections::HashMap;
use std::path::Path;

use relievo_core::{Context, Error, Result, file};

use crate::material::Material;
use crate::model::{Held, Lists, Model, NodeSet, Portion};

/// A model from a file, and the keywords that were passed over.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InpModel {
    /// The model.
    pub model: Model,
    /// Keywords that have no counterpart, each once.
    pub notes: Vec<String>,
}

/// Density in kg/m³ of a material that states none.
const DENSITY: f32 = 1000.0;

impl Model {
    /// Reads an Abaqus input file.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is larger than the memory limit or no UTF-8, and as [`Self::of_inp`].
    pub fn read_inp(context: &Context, path: &Path) -> Result<InpModel> {
        let named = |error: Error| error.at(path.display().to_string());
        let bytes = file::load(path, context.memory_limit())?;
        let text = std::str::from_utf8(&bytes).map_err(|_| named(Error::invalid("it is not UTF-8 text")))?;
        Self::of_inp(text).map_err(named)
    }

    /// Makes a model of the text of an Abaqus input file.
    ///
    /// # Errors
    /// Fails, with the line where it can, if a number cannot be read, a name, node or set does not exist, elements are
    /// not hexahedra of eight nodes, an element has no material, or the model cannot be used ([`Self::check`]).
    pub fn of_inp(text: &str) -> Result<InpModel> {
        let mut reader = Reader::default();
        for (number, line) in (1..).zip(text.lines()) {
            reader.line(line.trim()).map_err(|error| error.at(format!("line {number}")))?;
        }
        reader.model()
    }
}

/// What the lines after a keyword are.
#[derive(Clone, Debug, Default, PartialEq)]
enum Block {
    #[default]
    Other,
    Nodes,
    Elements(String),
    NodeSet(String, bool),
    ElementSet(String, bool),
    Hyperelastic,
    Elastic,
    Density,
    Boundary,
}

#[derive(Debug, Default)]
struct Reader {
    block: Block,
    notes: Vec<String>,
    nodes: Vec<[f32; 3]>,
    node_ids: HashMap<u64, u32>,
    elements: Vec<[u32; 8]>,
    element_ids: HashMap<u64, u32>,
    /// The numbers of an element of which a line is still to come.
    pending: Vec<u64>,
    node_sets: Vec<NodeSet>,
    element_sets: HashMap<String, Vec<u32>>,
    materials: Vec<Material>,
    /// Element sets and the names of their materials.
    sections: Vec<(String, String)>,
    held: Vec<Held>,
}

impl Reader {
    fn line(&mut self, line: &str) -> Result<()> {
        if line.is_empty() || line.starts_with("**") {
            return Ok(());
        }
        if let Some(keyword) = line.strip_prefix('*') {
            if !self.pending.is_empty() {
                return Err(Error::invalid("an element has fewer than eight nodes"));
            }
            return self.keyword(&keyword.to_ascii_uppercase());
        }
        let words: Vec<&str> = line.split(',').map(str::trim).filter(|word| !word.is_empty()).collect();
        match self.block.clone() {
            Block::Other => Ok(()),
            Block::Nodes => {
                let id = id(words.first())?;
                let mut place = [0.0; 3];
                for (at, word) in place.iter_mut().zip(words.get(1..).unwrap_or_default()) {
                    *at = float(word)?;
                }
                if self.node_ids.insert(id, self.nodes.len() as u32).is_some() {
                    return Err(Error::invalid(format!("node {id} is there twice")));
                }
                self.nodes.push(place);
                Ok(())
            }
            Block::Elements(set) => self.element(&words, &set),
            Block::NodeSet(name, generate) => {
                let nodes = self.members(&words, generate, true)?;
                self.node_set(&name).nodes.extend(nodes);
                Ok(())
            }
            Block::ElementSet(name, generate) => {
                let elements = self.members(&words, generate, false)?;
                self.element_sets.entry(name).or_default().extend(elements);
                Ok(())
            }
            Block::Hyperelastic => {
                let (c, d) = (float(words.first().unwrap_or(&""))?, float(words.get(1).unwrap_or(&""))?);
                let material = self.material()?;
                (material.shear, material.bulk) = (2.0 * c, 2.0 / d);
                Ok(())
            }
            Block::Elastic => {
                let (young, poisson) = (float(words.first().unwrap_or(&""))?, float(words.get(1).unwrap_or(&""))?);
                let material = self.material()?;
                let made = Material::of_young(&material.name, young, poisson, material.density)?;
                (material.shear, material.bulk) = (made.shear, made.bulk);
                Ok(())
            }
            Block::Density => {
                let density = float(words.first().unwrap_or(&""))?;
                self.material()?.density = density;
                Ok(())
            }
            Block::Boundary => self.boundary(&words),
        }
    }

    fn keyword(&mut self, line: &str) -> Result<()> {
        let mut parts = line.split(',').map(str::trim);
        let name = parts.next().unwrap_or_default();
        let options: Vec<(&str, &str)> = parts
            .map(|part| part.split_once('=').map_or((part, ""), |(key, value)| (key.trim(), value.trim())))
            .collect();
        let option = |key: &str| options.iter().find(|(name, _)| *name == key).map(|(_, value)| (*value).to_owned());
        let needed = |key: &str| {
            option(key)
                .ok_or_else(|| Error::invalid(format!("*{name} has no {key}")).advise("name it after the keyword"))
        };
        let generate = option("GENERATE").is_some();
        self.block = match name {
            "NODE" => Block::Nodes,
            "ELEMENT" => {
                let kind = needed("TYPE")?;
                if !["C3D8", "C3D8R", "C3D8I", "C3D8H", "C3D8RH"].contains(&kind.as_str()) {
                    return Err(Error::unsupported(format!("elements of type {kind} are not read")).advise("use C3D8R"));
                }
                Block::Elements(option("ELSET").unwrap_or_default())
            }
            "NSET" => Block::NodeSet(needed("NSET")?, generate),
            "ELSET" => Block::ElementSet(needed("ELSET")?, generate),
            "MATERIAL" => {
                let name = needed("NAME")?;
                self.materials.push(Material { name, density: DENSITY, shear: 0.0, bulk: 0.0 });
                Block::Other
            }
            "HYPERELASTIC" if option("NEO HOOKE").is_some() => Block::Hyperelastic,
            "ELASTIC" => Block::Elastic,
            "DENSITY" => Block::Density,
            "SOLID SECTION" => {
                self.sections.push((needed("ELSET")?, needed("MATERIAL")?));
                Block::Other
            }
            "BOUNDARY" => Block::Boundary,
            _ => {
                let note = format!("*{name} is passed over");
                if !self.notes.contains(&note) {
                    self.notes.push(note);
                }
                Block::Other
            }
        };
        Ok(())
    }

    fn element(&mut self, words: &[&str], set: &str) -> Result<()> {
        for word in words {
            self.pending.push(id(Some(word))?);
        }
        if self.pending.len() < 9 {
            return Ok(());
        }
        if self.pending.len() > 9 {
            return Err(Error::invalid("an element has more than eight nodes"));
        }
        let mut corners = [0; 8];
        for (corner, id) in corners.iter_mut().zip(&self.pending[1..]) {
            let missing = || Error::invalid(format!("node {id} does not exist")).advise("list nodes before elements");
            *corner = *self.node_ids.get(id).ok_or_else(missing)?;
        }
        let (id, number) = (self.pending[0], self.elements.len() as u32);
        self.pending.clear();
        if self.element_ids.insert(id, number).is_some() {
            return Err(Error::invalid(format!("element {id} is there twice")));
        }
        self.elements.push(corners);
        if !set.is_empty() {
            self.element_sets.entry(set.to_owned()).or_default().push(number);
        }
        Ok(())
    }

    /// Returns the members of a line of a set: numbers, names of other sets, or a range.
    fn members(&self, words: &[&str], generate: bool, nodes: bool) -> Result<Vec<u32>> {
        let ids = if nodes { &self.node_ids } else { &self.element_ids };
        if generate {
            let (first, last) = (id(words.first())?, id(words.get(1))?);
            let step = words.get(2).map_or(Ok(1), |word| id(Some(word)))?.max(1);
            // Only what exists is kept, so that a range that lies takes no memory.
            let mut found: Vec<(u64, u32)> = ids
                .iter()
                .filter(|(id, _)| (first..=last).contains(id) && (**id - first) % step == 0)
                .map(|(a, b)| (*a, *b))
                .collect();
            found.sort_unstable();
            return Ok(found.into_iter().map(|(_, number)| number).collect());
        }
        let mut all = Vec::new();
        for word in words {
            if let Ok(id) = word.parse::<u64>() {
                let missing = || Error::invalid(format!("number {id} of a set does not exist"));
                all.push(*ids.get(&id).ok_or_else(missing)?);
                continue;
            }
            let name = word.to_ascii_uppercase();
            let set = if nodes {
                self.node_sets.iter().find(|set| set.name == name).map(|set| &set.nodes)
            } else {
                self.element_sets.get(&name)
            };
            all.extend(set.ok_or_else(|| Error::invalid(format!("there is no set {name}")))?);
        }
        Ok(all)
    }

    fn node_set(&mut self, name: &str) -> &mut NodeSet {
        let at = self.node_sets.iter().position(|set| set.name == name).unwrap_or_else(|| {
            self.node_sets.push(NodeSet { name: name.to_owned(), nodes: Vec::new() });
            self.node_sets.len() - 1
        });
        &mut self.node_sets[at]
    }

    fn material(&mut self) -> Result<&mut Material> {
        self.materials.last_mut().ok_or_else(|| Error::invalid("there is no *MATERIAL before it"))
    }

    fn boundary(&mut self, words: &[&str]) -> Result<()> {
        let nodes = self.members(words.get(..1).unwrap_or_default(), false, true)?;
        let first = id(words.get(1))?;
        let last = words.get(2).map_or(Ok(first), |word| id(Some(word)))?;
        let value = words.get(3).map_or(Ok(0.0), |word| float(word))?;
        if value != 0.0 {
            let note = "*BOUNDARY other than 0 is passed over".to_owned();
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
            return Ok(());
        }
        let axes = (1..=3).filter(|axis| (first..=last).contains(axis)).fold(0, |axes, axis| axes | 1 << (axis - 1));
        self.held.extend(nodes.into_iter().map(|node| Held { node, axes }));
        Ok(())
    }

    fn model(self) -> Result<InpModel> {
        if !self.pending.is_empty() {
            return Err(Error::invalid("an element has fewer than eight nodes"));
        }
        let mut of = vec![u32::MAX; self.elements.len()];
        for (set, material) in &self.sections {
            let elements =
                self.element_sets.get(set).ok_or_else(|| Error::invalid(format!("there is no set {set}")))?;
            let named = self.materials.iter().position(|it| it.name == *material);
            let number = named.ok_or_else(|| Error::invalid(format!("there is no material {material}")))?;
            elements.iter().for_each(|element| of[*element as usize] = number as u32);
        }
        if let Some(element) = of.iter().position(|material| *material == u32::MAX) {
            return Err(Error::invalid(format!("element {element} from 0 has no material"))
                .advise("give its set a *SOLID SECTION"));
        }
        let (mut mixtures, mut fibres) = (Lists::default(), Lists::default());
        for material in of {
            mixtures.push([Portion { material, share: 1.0 }]);
            fibres.push([]);
        }
        let model = Model {
            nodes: self.nodes,
            elements: self.elements,
            materials: self.materials,
            mixtures,
            fibres,
            held: self.held,
            sets: self.node_sets,
            ..Model::default()
        };
        model.check()?;
        Ok(InpModel { model, notes: self.notes })
    }
}

fn id(word: Option<&&str>) -> Result<u64> {
    let word = word.copied().unwrap_or_default();
    word.parse().map_err(|_| Error::invalid(format!("{word:?} is not a number from 0")))
}

fn float(word: &str) -> Result<f32> {
    let number = word.parse::<f32>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| Error::invalid(format!("{word:?} is not a finite number")))
}
