//! A stage: layers composed over one another. Prims are composed of the places ("sites") that say something about
//! them, strongest first: the layers of a stack, then what a prim inherits, its variants, references, payloads, and what
//! it specializes (OpenUSD, "LIVERPS" without relocates and clips).
//!
//! Arcs may multiply one another, so the number of sites is bounded along with everything else.

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::HashSet;
use std::path::{Path as FilePath, PathBuf};

use openusd::sdf::{LayerOffset, ListOp, Path, Payload, Reference, Value};
use relievo_core::{Error, Result, file};

use super::layer::Layer;
use super::value;
use crate::budget::Budget;
use crate::notes::Notes;
use crate::root::Root;

/// Most arcs that may lead on to one another.
const ARCS: usize = 32;
/// Most names on the path of a prim, however it came to be.
const DEPTH: usize = 256;
/// Most files of a stage.
const FILES: usize = 4096;
/// Most sites of a stage.
const SITES: usize = 1 << 21;
/// Bytes counted for a site besides its path.
const SITE: u64 = 256;

/// Where a layer is among others, and how its times follow from the stage's.
type Placed = (usize, LayerOffset);

/// A layer with its sublayers, strongest first.
struct Stack {
    /// The file of its root layer, `None` for that of the stage, which is given as bytes.
    file: Option<PathBuf>,
    layers: Vec<Placed>,
}

/// A place that says something about a prim.
#[derive(Clone, Debug)]
struct Site {
    stack: usize,
    path: Path,
    offset: LayerOffset,
}

/// A prim of the stage.
#[derive(Clone, Debug)]
pub(crate) struct Prim {
    /// Its path on the stage.
    pub path: String,
    sites: Vec<Site>,
    /// The variants that are selected, by the strongest that says so.
    selections: Vec<(String, String)>,
}

impl Prim {
    /// The last name of its path.
    pub fn name(&self) -> &str {
        self.path.rsplit('/').next().unwrap_or_default()
    }
}

/// What is known of a property: its value at all times, and its values over time in time codes of the stage.
pub(crate) struct Property<'a> {
    pub default: Option<Cow<'a, Value>>,
    pub samples: Vec<(f64, Cow<'a, Value>)>,
}

impl<'a> Property<'a> {
    /// The value at no time in particular, or else the first.
    pub fn rest(&self) -> Option<&Value> {
        self.default.as_deref().or_else(|| self.samples.first().map(|(_, value)| value.as_ref()))
    }
}

/// A stage and where its files are.
pub(crate) struct Stage<'a> {
    layers: Vec<(Layer, PathBuf)>,
    stacks: Vec<Stack>,
    root: &'a Root,
    sites: usize,
    /// Of everything that is read.
    pub budget: RefCell<Budget>,
    notes: RefCell<Notes>,
}

impl<'a> Stage<'a> {
    /// Opens the layer in `bytes`, which names other files from `folder`.
    pub fn open(bytes: Vec<u8>, mut budget: Budget, folder: &FilePath, root: &'a Root) -> Result<Self> {
        let layer = Layer::open(bytes, &mut budget)?;
        let mut stage = Self {
            layers: vec![(layer, folder.into())],
            stacks: Vec::new(),
            root,
            sites: 0,
            budget: RefCell::new(budget),
            notes: RefCell::default(),
        };
        let mut layers = Vec::new();
        stage.sublayers(0, LayerOffset::IDENTITY, 0, &mut layers)?;
        stage.stacks.push(Stack { file: None, layers });
        Ok(stage)
    }

    /// Bytes that may still be taken.
    fn left(&self) -> u64 {
        self.budget.borrow().left()
    }

    /// Counts bytes as taken.
    pub fn charge(&self, bytes: u64) -> Result<()> {
        self.budget.borrow_mut().charge(bytes)
    }

    /// See [`value::floats`].
    pub fn floats(&self, value: &Value) -> Result<Option<(Vec<f32>, u32)>> {
        value::floats(value, &mut self.budget.borrow_mut())
    }

    /// See [`value::integers`].
    pub fn integers(&self, value: &Value) -> Result<Option<Vec<u32>>> {
        value::integers(value, &mut self.budget.borrow_mut())
    }

    /// Tells the user of what was left out.
    pub fn note(&self, what: &str) {
        self.notes.borrow_mut().add(what, 0);
    }

    /// What was left out.
    pub fn into_notes(self) -> Vec<String> {
        self.notes.into_inner().into_list()
    }

    /// A field of the stage's root layer itself.
    pub fn metadata(&self, name: &str) -> Result<Option<Cow<'_, Value>>> {
        self.layers[0].0.field(&Path::abs_root(), name, self.left())
    }

    /// The prim above all others.
    pub fn top(&self) -> Prim {
        let site = Site { stack: 0, path: Path::abs_root(), offset: LayerOffset::IDENTITY };
        Prim { path: String::new(), sites: vec![site], selections: Vec::new() }
    }

    /// The prims below one, in order: those of weaker sites first, as OpenUSD has it.
    pub fn children(&mut self, prim: &Prim) -> Result<Vec<Prim>> {
        let mut names: Vec<String> = Vec::new();
        let mut known = HashSet::new();
        for site in prim.sites.iter().rev() {
            for (layer, _) in self.stacks[site.stack].layers.iter().rev() {
                let Some(list) = self.layers[*layer].0.field(&site.path, "primChildren", self.left())? else {
                    continue;
                };
                for name in words(&list) {
                    if known.insert(name.to_owned()) {
                        names.push(name.to_owned());
                    }
                }
            }
        }
        if !names.is_empty() && prim.path.matches('/').count() >= DEPTH {
            return Err(Error::unsupported(format!("more than {DEPTH} prims are nested")).advise("flatten the stage"));
        }
        let mut children = Vec::new();
        for name in names {
            let path = format!("{}/{name}", prim.path);
            self.charge(SITE + path.len() as u64)?;
            let mut child = Prim { path, sites: Vec::new(), selections: Vec::new() };
            for site in &prim.sites {
                if let Ok(path) = site.path.append_path(name.as_str()) {
                    self.compose(site.stack, path, site.offset, 0, &mut child)
                        .map_err(|error| error.at(child.path.clone()))?;
                }
            }
            children.push(child);
        }
        Ok(children)
    }

    /// The strongest opinion about a field of a prim.
    pub fn field(&self, prim: &Prim, name: &str) -> Result<Option<Cow<'_, Value>>> {
        for site in &prim.sites {
            for (layer, _) in &self.stacks[site.stack].layers {
                if let Some(value) = self.layers[*layer].0.field(&site.path, name, self.left())? {
                    return Ok(Some(value));
                }
            }
        }
        Ok(None)
    }

    /// All opinions about a field of a prim that `is` the one looked for.
    pub fn any(&self, prim: &Prim, name: &str, is: impl Fn(&Value) -> bool) -> Result<bool> {
        for site in &prim.sites {
            for (layer, _) in &self.stacks[site.stack].layers {
                let value = self.layers[*layer].0.field(&site.path, name, self.left())?;
                if value.is_some_and(|value| is(&value)) {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// The names of the properties of a prim.
    pub fn properties(&self, prim: &Prim) -> Result<Vec<String>> {
        let mut names = Vec::new();
        let mut known = HashSet::new();
        for site in &prim.sites {
            for (layer, _) in &self.stacks[site.stack].layers {
                for key in ["propertyChildren", "properties"] {
                    let Some(list) = self.layers[*layer].0.field(&site.path, key, self.left())? else { continue };
                    for name in words(&list) {
                        if known.insert(name.to_owned()) {
                            names.push(name.to_owned());
                        }
                    }
                }
            }
        }
        Ok(names)
    }

    /// The strongest opinion about a field of a property: `interpolation`, `targetPaths` and the like.
    pub fn property_field(&self, prim: &Prim, property: &str, name: &str) -> Result<Option<Cow<'_, Value>>> {
        for site in &prim.sites {
            let Ok(path) = site.path.append_property(property) else { continue };
            for (layer, _) in &self.stacks[site.stack].layers {
                if let Some(value) = self.layers[*layer].0.field(&path, name, self.left())? {
                    return Ok(Some(value));
                }
            }
        }
        Ok(None)
    }

    /// The value of a property, by the strongest layer that gives one; samples over time win over its default.
    pub fn property(&self, prim: &Prim, name: &str) -> Result<Property<'_>> {
        for site in &prim.sites {
            let Ok(path) = site.path.append_property(name) else { continue };
            for (index, offset) in &self.stacks[site.stack].layers {
                let layer = &self.layers[*index].0;
                let default = layer.field(&path, "default", self.left())?;
                let samples = layer.field(&path, "timeSamples", self.left())?;
                if default.is_none() && samples.is_none() {
                    continue;
                }
                let default = default.filter(|value| !matches!(**value, Value::ValueBlock | Value::None));
                let offset = site.offset.concatenate(offset);
                let mut samples: Vec<(f64, Cow<Value>)> = match samples {
                    Some(Cow::Borrowed(Value::TimeSamples(list))) => {
                        list.iter().map(|(time, value)| (*time, Cow::Borrowed(value))).collect()
                    }
                    Some(Cow::Owned(Value::TimeSamples(list))) => {
                        list.into_iter().map(|(time, value)| (time, Cow::Owned(value))).collect()
                    }
                    _ => Vec::new(),
                };
                samples.iter_mut().for_each(|(time, _)| *time = offset.apply(*time));
                samples.retain(|(time, value)| time.is_finite() && !matches!(**value, Value::ValueBlock));
                samples.sort_by(|a, b| a.0.total_cmp(&b.0));
                samples.dedup_by_key(|sample| sample.0);
                return Ok(Property { default, samples });
            }
        }
        Ok(Property { default: None, samples: Vec::new() })
    }

    /// The layer of `file` and what it is made of, strongest first.
    fn sublayers(&mut self, layer: usize, offset: LayerOffset, depth: usize, out: &mut Vec<Placed>) -> Result<()> {
        if depth > ARCS {
            return Err(Error::invalid("sublayers lead to one another without end"));
        }
        self.charge(SITE)?;
        out.push((layer, offset));
        let field = |name: &str| self.layers[layer].0.field(&Path::abs_root(), name, self.left());
        let names: Vec<String> = match field("subLayers")? {
            Some(list) => words(&list).into_iter().map(str::to_owned).collect(),
            None => return Ok(()),
        };
        let offsets = match field("subLayerOffsets")?.as_deref() {
            Some(Value::LayerOffsetVec(list)) => list.clone(),
            _ => Vec::new(),
        };
        for (index, name) in names.iter().enumerate() {
            let own = offsets.get(index).copied().unwrap_or(LayerOffset::IDENTITY).sanitized();
            match self.load(layer, name) {
                Ok(below) => self.sublayers(below, offset.concatenate(&own), depth + 1, out)?,
                Err(error) => self.note(&format!("the sublayer is left out: {error}")),
            }
        }
        Ok(())
    }

    /// The number of the layer that `name` means in a layer.
    fn load(&mut self, from: usize, name: &str) -> Result<usize> {
        if self.layers.len() == FILES {
            return Err(Error::unsupported(format!("the stage is made of more than {FILES} files")));
        }
        let path = self.root.resolve(&self.layers[from].1, name)?;
        let bytes = file::load(&path, self.left())?;
        self.charge(bytes.len() as u64)?;
        let layer = Layer::open(bytes, self.budget.get_mut()).map_err(|error| error.at(path.display().to_string()))?;
        let folder = path.parent().unwrap_or(FilePath::new("")).to_path_buf();
        self.layers.push((layer, folder));
        Ok(self.layers.len() - 1)
    }

    /// The number of the stack whose root layer is the file that `name` means in a stack.
    fn stack(&mut self, from: usize, name: &str) -> Result<usize> {
        let layer = self.stacks[from].layers[0].0;
        let path = self.root.resolve(&self.layers[layer].1, name)?;
        if let Some(known) = self.stacks.iter().position(|stack| stack.file.as_ref() == Some(&path)) {
            return Ok(known);
        }
        let first = self.load(layer, name)?;
        let mut layers = Vec::new();
        self.sublayers(first, LayerOffset::IDENTITY, 0, &mut layers)?;
        self.stacks.push(Stack { file: Some(path), layers });
        Ok(self.stacks.len() - 1)
    }

    /// What all layers of a stack say together of a list.
    fn list<T: Default + Clone + PartialEq>(
        &self,
        stack: usize,
        path: &Path,
        name: &str,
        pick: impl Fn(&Value) -> Option<ListOp<T>>,
    ) -> Result<Vec<T>> {
        let mut all = ListOp::<T>::default();
        for (layer, _) in &self.stacks[stack].layers {
            if let Some(list) = self.layers[*layer].0.field(path, name, self.left())?.and_then(|value| pick(&value)) {
                all = all.combined_with(&list);
            }
        }
        Ok(all.flatten())
    }

    /// Adds a site and the sites that arcs lead to from it.
    fn compose(&mut self, stack: usize, path: Path, offset: LayerOffset, arcs: usize, prim: &mut Prim) -> Result<()> {
        if arcs > ARCS {
            return Err(Error::invalid(format!(
                "more than {ARCS} references, variants or classes lead on to one another"
            ))
            .advise("look for a circle among them"));
        }
        if !self.stacks[stack].layers.iter().any(|(layer, _)| self.layers[*layer].0.has(&path)) {
            return Ok(());
        }
        self.sites += 1;
        if self.sites > SITES {
            return Err(Error::unsupported("references, variants and classes multiply into too many prims")
                .advise("flatten the stage with usdcat"));
        }
        self.charge(SITE + 2 * path.as_str().len() as u64)?;
        prim.sites.push(Site { stack, path: path.clone(), offset });
        let paths = |value: &Value| match value {
            Value::PathListOp(list) => Some(list.clone()),
            _ => None,
        };
        for target in self.list(stack, &path, "inheritPaths", paths)? {
            self.compose(stack, path.make_absolute(&target), offset, arcs + 1, prim)?;
        }
        for layer in 0..self.stacks[stack].layers.len() {
            let layer = self.stacks[stack].layers[layer].0;
            let value = self.layers[layer].0.field(&path, "variantSelection", self.left())?;
            if let Some(Value::VariantSelectionMap(map)) = value.as_deref() {
                let mut list: Vec<(&String, &String)> = map.iter().collect();
                list.sort();
                for (set, variant) in list {
                    if prim.selections.iter().all(|(known, _)| known != set) {
                        prim.selections.push((set.clone(), variant.clone()));
                    }
                }
            }
        }
        let sets = self.list(stack, &path, "variantSetNames", |value| match value {
            Value::StringListOp(list) => Some(list.clone()),
            Value::TokenListOp(list) => {
                let names = |list: &[openusd::tf::Token]| list.iter().map(|name| name.as_str().to_owned()).collect();
                Some(ListOp {
                    explicit: list.explicit,
                    explicit_items: names(&list.explicit_items),
                    added_items: names(&list.added_items),
                    prepended_items: names(&list.prepended_items),
                    appended_items: names(&list.appended_items),
                    deleted_items: names(&list.deleted_items),
                    ordered_items: names(&list.ordered_items),
                })
            }
            _ => None,
        })?;
        for set in sets {
            if let Some((_, variant)) = prim.selections.iter().find(|(name, _)| *name == set) {
                let selected = path.append_variant_selection(&set, variant);
                self.compose(stack, selected, offset, arcs + 1, prim)?;
            }
        }
        let references = self.list(stack, &path, "references", |value| match value {
            Value::ReferenceListOp(list) => Some(list.clone()),
            _ => None,
        })?;
        for Reference { asset_path, prim_path, layer_offset, .. } in references {
            self.follow(
                stack,
                &path,
                (&asset_path, &prim_path),
                offset.concatenate(&layer_offset.sanitized()),
                arcs,
                prim,
            )?;
        }
        let payloads = self.list(stack, &path, "payload", |value| match value {
            Value::PayloadListOp(list) => Some(list.clone()),
            Value::Payload(one) => {
                Some(ListOp { explicit: true, explicit_items: vec![one.clone()], ..ListOp::default() })
            }
            _ => None,
        })?;
        for Payload { asset_path, prim_path, layer_offset } in payloads {
            let own = layer_offset.unwrap_or(LayerOffset::IDENTITY).sanitized();
            self.follow(stack, &path, (&asset_path, &prim_path), offset.concatenate(&own), arcs, prim)?;
        }
        for target in self.list(stack, &path, "specializes", paths)? {
            self.compose(stack, path.make_absolute(&target), offset, arcs + 1, prim)?;
        }
        Ok(())
    }

    /// Adds the prim that a reference or payload names: of another file, or of this one.
    fn follow(
        &mut self,
        stack: usize,
        from: &Path,
        (asset, target): (&str, &Path),
        offset: LayerOffset,
        arcs: usize,
        prim: &mut Prim,
    ) -> Result<()> {
        let other = if asset.is_empty() { Ok(stack) } else { self.stack(stack, asset) };
        let other = match other {
            Ok(other) => other,
            Err(error) => {
                self.note(&format!("what {} refers to is left out: {error}", from.as_str()));
                return Ok(());
            }
        };
        let path = if target.as_str().is_empty() {
            let root = self.stacks[other].layers[0].0;
            let value = self.layers[root].0.field(&Path::abs_root(), "defaultPrim", self.left())?;
            match value.as_deref().and_then(word).map(|name| format!("/{}", name.trim_start_matches('/'))) {
                Some(name) => Path::new(&name).ok(),
                None => None,
            }
        } else {
            Some(from.make_absolute(target))
        };
        match path {
            Some(path) => self.compose(other, path, offset, arcs + 1, prim),
            None => {
                self.note(&format!("what {} refers to has no default prim", from.as_str()));
                Ok(())
            }
        }
    }
}

/// The text of a token or string.
pub(crate) fn word(value: &Value) -> Option<&str> {
    match value {
        Value::Token(token) => Some(token.as_str()),
        Value::String(text) | Value::PathExpression(text) => Some(text),
        _ => None,
    }
}

/// The texts of a list of tokens, strings or assets.
pub(crate) fn words(value: &Value) -> Vec<&str> {
    match value {
        Value::TokenVec(list) => list.iter().map(|token| token.as_str()).collect(),
        Value::StringVec(list) => list.iter().map(String::as_str).collect(),
        Value::AssetPathVec(list) => list.iter().map(|asset| asset.as_str()).collect(),
        _ => Vec::new(),
    }
}
