//! Checks a file before OpenVDB reads it, and lists its grids without the values of their leaves.
//!
//! OpenVDB allocates what a file states: lengths of texts, packed sizes, numbers of nodes. Here each of them is checked
//! against what is left of the file, and the nodes of trees are counted against the memory limit. The form is that of file
//! versions 222 to 224, which OpenVDB has written since version 2.

use std::path::Path;

use relievo_core::{Budget, Error, Result};

use crate::cursor::{Cursor, damaged};
use crate::info::{Class, Entry, GridInfo, Kind};
use crate::topology::{Storage, Topology};
use crate::transform::Transform;

const SIGNATURE: u64 = 0x5644_4220;
/// File versions that are read.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=224;
/// Grids of a file and entries of metadata at most.
const MAX: u32 = 1 << 16;
/// What follows the type of a grid whose numbers have 16 bits.
const HALVES: &str = "_HalfFloat";
/// The metadata that OpenVDB writes for delayed loading: it states how much to allocate.
const DELAYED: &str = "__delayedload";
/// Separates the number of a grid from its name, where a name occurs more than once.
const SEPARATOR: char = '\u{1e}';

/// What is in a file.
#[derive(Clone, Debug)]
pub struct Survey {
    /// The version of its form.
    pub version: u32,
    /// Major and minor version of the OpenVDB that wrote it.
    pub library: [u32; 2],
    /// Whether it states no places of grids, as `openvdb::io::Stream` writes it; it can only be read whole.
    pub is_stream: bool,
    /// The metadata of the file.
    pub metadata: Vec<Entry>,
    /// Its grids in the order of the file.
    pub grids: Vec<GridInfo>,
    places: Vec<Place>,
}

/// Where a grid is.
#[derive(Clone, Debug)]
struct Place {
    /// Its name with the number that makes it unique.
    unique: String,
    /// That of the grid whose tree it shares; empty if it has its own.
    parent: String,
    /// Where it begins and ends.
    begin: u64,
    end: u64,
}

/// How much of a grid is looked at.
#[derive(Clone, Copy, PartialEq)]
enum Depth {
    Topology,
    Values,
}

impl Survey {
    /// Lists the grids of a file. Values of leaves are left out, except in a stream, where they are between grids.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file does not exist or cannot be read, with `Invalid` if it is damaged,
    /// with `Unsupported` if it is of another version, and with `Memory` if its list would need more than
    /// `memory_limit` bytes.
    pub fn of_file(path: &Path, memory_limit: u64) -> Result<Self> {
        let mut file = Cursor::open(path)?;
        Self::list(&mut file, memory_limit).map_err(|error| error.at(path.display().to_string()))
    }

    fn list(file: &mut Cursor, memory_limit: u64) -> Result<Self> {
        let mut budget = Budget::new(memory_limit);
        if u64::from_le_bytes(file.array()?) != SIGNATURE {
            return Err(
                Error::invalid("the file does not begin as OpenVDB's do").advise("check that it is a .vdb file")
            );
        }
        let [version, major, minor] = [file.u32()?, file.u32()?, file.u32()?];
        if !VERSIONS.contains(&version) {
            let (first, last) = (VERSIONS.start(), VERSIONS.end());
            let what = format!("its form has version {version}, and versions {first} to {last} are read");
            return Err(Error::unsupported(what).advise("save it with an OpenVDB between 2 and 12"));
        }
        let is_stream = match file.array()? {
            [0] => true,
            [1] => false,
            _ => return Err(damaged("it neither states places of grids nor leaves them out")),
        };
        file.skip(36)?;
        let metadata = metadata(file, &mut budget)?;
        let count = file.u32()?;
        if count > MAX {
            return Err(damaged("there are too many grids"));
        }
        let mut survey =
            Self { version, library: [major, minor], is_stream, metadata, grids: Vec::new(), places: Vec::new() };
        for _ in 0..count {
            let (unique, tree, parent) = (file.text()?, file.text()?, file.text()?);
            budget.charge((unique.len() + tree.len() + parent.len()) as u64 + 512)?;
            let [begin, _, end] = [file.i64()?, file.i64()?, file.i64()?];
            let begin = if is_stream { file.place() } else { u64::try_from(begin).unwrap_or(u64::MAX) };
            if begin < file.place() {
                return Err(damaged("a grid begins before its name"));
            }
            let mut place = Place { unique, parent, begin, end: file.place() };
            // The memory of a grid counts when it is read, not when it is listed; in a stream all are read.
            let (mut own, depth) = match is_stream {
                true => (Budget::new(budget.left()), Depth::Values),
                false => (Budget::new(u64::MAX), Depth::Topology),
            };
            let info = place.walk(file, tree, depth, [&mut budget, &mut own])?;
            if is_stream {
                budget.charge(info.memory_bytes)?;
            }
            place.end = if is_stream { file.place() } else { u64::try_from(end).unwrap_or(u64::MAX) };
            if !is_stream && place.end < file.place() {
                return Err(damaged("a grid ends before its tree"));
            }
            file.go(place.end)?;
            survey.grids.push(info);
            survey.places.push(place);
        }
        Ok(survey)
    }

    /// Finds the grid of a name, whatever its kind.
    ///
    /// # Errors
    /// Fails with `NotFound`, and the names that exist, if there is no such grid.
    pub fn find_any(&self, name: &str) -> Result<usize> {
        self.grids.iter().position(|grid| grid.name == name).ok_or_else(|| self.none())
    }

    fn none(&self) -> Error {
        let names: Vec<_> = self.grids.iter().map(|grid| format!("{} ({})", grid.name, grid.tree)).collect();
        let error = Error::new(relievo_core::ErrorKind::NotFound, "the file has no such grid");
        error.advise(format!("it has {}", names.join(", ")))
    }

    /// Finds a grid whose values can be read: the one of a name, or the first.
    ///
    /// # Errors
    /// Fails with `NotFound`, and the names that exist, if there is no such grid, and with `Unsupported` if it has
    /// points or a type that this module does not handle.
    pub fn find(&self, name: Option<&str>) -> Result<usize> {
        let readable = |info: &GridInfo| info.kind.is_some_and(|kind| kind != Kind::Points);
        let index = match name {
            Some(name) => self.find_any(name)?,
            None => self.grids.iter().position(readable).ok_or_else(|| self.none())?,
        };
        let info = &self.grids[index];
        match info.kind {
            Some(Kind::Points) => Err(Error::unsupported(format!("grid {} has points", info.name))
                .advise("read points with `relievo fluid`, or as particles")),
            None => Err(Error::unsupported(format!("grid {} has the type {}", info.name, info.tree))
                .advise("convert it to one of the kinds of this module")),
            Some(_) => Ok(index),
        }
    }

    /// Checks all that OpenVDB reads of a file to read grid `index`, and returns the name by which OpenVDB finds it.
    pub(crate) fn check(&self, path: &Path, index: usize, memory_limit: u64) -> Result<&str> {
        let mut budget = Budget::new(memory_limit);
        let (place, info) = (&self.places[index], &self.grids[index]);
        if self.places[..index].iter().any(|other| other.unique == place.unique) {
            return Err(Error::unsupported("two grids of the file have one name").advise("rename one of them"));
        }
        let mut file = Cursor::open(path)?;
        let mut walk = |place: &Place, tree: &str| -> Result<()> {
            file.go(place.begin)?;
            let mut own = Budget::new(budget.left());
            let info = place.walk(&mut file, tree.to_owned(), Depth::Values, [&mut budget, &mut own])?;
            budget.charge(info.memory_bytes)?;
            if file.place() > place.end {
                return Err(damaged("a grid is longer than its place"));
            }
            Ok(())
        };
        if self.is_stream {
            // The list was made of all its values.
            if self.grids.iter().any(|grid| grid.kind.is_none_or(|kind| kind == Kind::Points)) {
                let error = Error::unsupported("a stream has a grid that cannot be skipped");
                return Err(error.advise("save it as a file with places of grids"));
            }
            self.grids.iter().try_for_each(|grid| budget.charge(grid.memory_bytes))?;
            return Ok(&place.unique);
        }
        walk(place, &info.full_tree())?;
        if !place.parent.is_empty() {
            let parent = self.places.iter().position(|other| other.unique == place.parent);
            let parent = parent.filter(|parent| self.places[*parent].parent.is_empty());
            let parent = parent.ok_or_else(|| damaged("a grid shares the tree of a grid that has none"))?;
            if self.grids[parent].full_tree() != info.full_tree() {
                return Err(damaged("a grid shares a tree of another type"));
            }
            walk(&self.places[parent], &self.grids[parent].full_tree())?;
        }
        Ok(&place.unique)
    }
}

impl GridInfo {
    /// Returns the type as files have it.
    fn full_tree(&self) -> String {
        format!("{}{}", self.tree, if self.is_half { HALVES } else { "" })
    }
}

impl Place {
    /// Walks through the grid. What OpenVDB allocates for metadata is charged to the first budget, and for the tree to the
    /// second.
    fn walk(
        &self,
        file: &mut Cursor,
        tree: String,
        depth: Depth,
        [heads, trees]: [&mut Budget; 2],
    ) -> Result<GridInfo> {
        file.go(self.begin)?;
        let is_half = tree.ends_with(HALVES);
        let tree = tree.trim_end_matches(HALVES).to_owned();
        let kind = Kind::of_tree(&tree);
        let packing = file.u32()?;
        let metadata = metadata(file, heads)?;
        let transform = transform(file, 0)?;
        let mut topology = Topology::default();
        if let Some(kind) = kind.filter(|_| self.parent.is_empty()) {
            let storage = Storage { kind, is_half, packing };
            topology = storage.topology(file, trees)?;
            if kind == Kind::Points && depth == Depth::Values {
                return Err(Error::unsupported("a stream of points cannot be read").advise("save it as a file"));
            }
            if depth == Depth::Values {
                storage.leaves(file, &topology, trees)?;
            }
        } else if depth == Depth::Values && self.parent.is_empty() {
            return Err(Error::unsupported(format!("a grid has the type {tree}")).advise("leave it out of the file"));
        }
        let class = metadata.iter().find(|entry| entry.name == "class");
        let mut names = self.unique.split(SEPARATOR);
        Ok(GridInfo {
            name: names.next().unwrap_or_default().to_owned(),
            kind,
            tree,
            class: class.map_or(Class::Unknown, |entry| Class::by_name(&entry.value)),
            is_half,
            instance_of: (!self.parent.is_empty())
                .then(|| self.parent.split(SEPARATOR).next().unwrap_or_default().to_owned()),
            transform,
            active_voxels: topology.active_voxels,
            leaf_count: topology.leaves.len() as u64,
            bounds: topology.bounds,
            memory_bytes: topology.memory_bytes,
            metadata,
        })
    }
}

/// Reads names, types and values.
fn metadata(file: &mut Cursor, budget: &mut Budget) -> Result<Vec<Entry>> {
    let count = file.u32()?;
    if count > MAX {
        return Err(damaged("there is too much metadata"));
    }
    let mut list = Vec::new();
    for _ in 0..count {
        let (name, kind, length) = (file.text()?, file.text()?, file.u32()?);
        budget.charge(name.len() as u64 + kind.len() as u64 + u64::from(length) + 96)?;
        if kind == DELAYED {
            let end = file.place() + u64::from(length);
            if length > 0 {
                delayed(file, budget)?;
            }
            if file.place() > end {
                return Err(damaged("sizes for delayed loading are too large"));
            }
            file.go(end)?;
            continue;
        }
        let bytes = file.bytes(length.into(), 1 << 24)?;
        let value = value_text(&kind, &bytes)?;
        list.push(Entry { name, kind, value });
    }
    Ok(list)
}

/// Walks through what OpenVDB keeps for delayed loading: of each leaf a byte and a size of eight bytes, both lists packed
/// or, where 0 is stated, plain; the second one may be left out.
fn delayed(file: &mut Cursor, budget: &mut Budget) -> Result<()> {
    let leaves = u64::from(file.u32()?);
    budget.charge(18 * leaves)?;
    for bytes in [1, 8] {
        match file.u32()? {
            0 => file.skip(leaves * bytes)?,
            u32::MAX if bytes == 8 => {}
            packed => {
                budget.charge(packed.into())?;
                file.skip(packed.into())?;
            }
        }
    }
    Ok(())
}

/// Returns a value of metadata as text.
fn value_text(kind: &str, bytes: &[u8]) -> Result<String> {
    let texts = |size: usize, count: usize, text: &dyn Fn(&[u8]) -> String| -> Result<String> {
        // OpenVDB reads as much as the type has, whatever length is stated.
        if bytes.len() != size * count {
            return Err(damaged("metadata do not have the size of their type"));
        }
        let all: Vec<String> = bytes.chunks_exact(size).map(text).collect();
        Ok(if count == 1 { all.concat() } else { format!("[{}]", all.join(", ")) })
    };
    // Every slice has the length that is asked for.
    let int32 = |at: &[u8]| at.try_into().map(i32::from_le_bytes).unwrap_or_default().to_string();
    let int64 = |at: &[u8]| at.try_into().map(i64::from_le_bytes).unwrap_or_default().to_string();
    let float = |at: &[u8]| at.try_into().map(f32::from_le_bytes).unwrap_or_default().to_string();
    let double = |at: &[u8]| at.try_into().map(f64::from_le_bytes).unwrap_or_default().to_string();
    match kind {
        "string" => Ok(String::from_utf8_lossy(bytes).into_owned()),
        "bool" => texts(1, 1, &|at| (at[0] != 0).to_string()),
        "int32" => texts(4, 1, &int32),
        "int64" => texts(8, 1, &int64),
        "float" => texts(4, 1, &float),
        "double" => texts(8, 1, &double),
        "vec2i" => texts(4, 2, &int32),
        "vec2s" => texts(4, 2, &float),
        "vec2d" => texts(8, 2, &double),
        "vec3i" => texts(4, 3, &int32),
        "vec3s" => texts(4, 3, &float),
        "vec3d" => texts(8, 3, &double),
        "vec4i" => texts(4, 4, &int32),
        "vec4s" => texts(4, 4, &float),
        "vec4d" => texts(8, 4, &double),
        "mat4s" => texts(4, 16, &float),
        "mat4d" => texts(8, 16, &double),
        _ => Ok(format!("{} bytes", bytes.len())),
    }
}

/// Reads a map from voxels to the world; `depth` is how many frustums are around it.
fn transform(file: &mut Cursor, depth: u32) -> Result<Transform> {
    let kind = file.text()?;
    let mut vector = || -> Result<[f64; 3]> { Ok([file.f64()?, file.f64()?, file.f64()?]) };
    let scaled = |[x, y, z]: [f64; 3], origin| Transform::affine([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z], origin]);
    let found = match kind.as_str() {
        "UniformScaleMap" | "ScaleMap" => {
            let scale = vector()?;
            // The size of a voxel, and inverses that OpenVDB keeps.
            (0..4).try_for_each(|_| vector().map(drop))?;
            scaled(scale, [0.0; 3])
        }
        "TranslationMap" => scaled([1.0; 3], vector()?),
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let (origin, scale) = (vector()?, vector()?);
            (0..4).try_for_each(|_| vector().map(drop))?;
            scaled(scale, origin)
        }
        "AffineMap" | "UnitaryMap" => {
            let mut numbers = [0.0; 16];
            for number in &mut numbers {
                *number = file.f64()?;
            }
            let row = |at: usize| [0, 1, 2].map(|column| numbers[4 * at + column]);
            Transform::affine([row(0), row(1), row(2), row(3)])
        }
        "NonlinearFrustumMap" if depth == 0 => {
            // The box in voxels, the taper and the depth.
            let (low, high) = (vector()?, vector()?);
            let (taper, long) = (file.f64()?, file.f64()?);
            if !taper.is_finite() || !long.is_finite() || (0..3).any(|axis| !(high[axis] > low[axis])) {
                return Err(damaged("a frustum has no volume"));
            }
            Transform { is_linear: false, ..transform(file, 1)? }
        }
        _ => return Err(Error::unsupported(format!("a grid has a transform of type {kind:?}"))),
    };
    if !found.is_regular() {
        return Err(damaged("a transform is not finite or has no inverse"));
    }
    Ok(found)
}
