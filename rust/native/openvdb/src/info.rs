//! Facts about a grid, whether it is in memory or in a file.

use relievo_core::{Error, Result};

use crate::abi;
use crate::transform::Transform;

/// Kinds of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// 32-bit floating point.
    Float,
    /// 64-bit floating point.
    Double,
    /// Truth values.
    Bool,
    /// Active or not; there are no values besides.
    Mask,
    /// 32-bit integers, also labels.
    Int32,
    /// 64-bit integers.
    Int64,
    /// Three 32-bit floating point numbers.
    Vec3s,
    /// Three 64-bit floating point numbers.
    Vec3d,
    /// Three 32-bit integers.
    Vec3i,
    /// Points with attributes. They are listed; the crate `relievo-particleio` reads them.
    Points,
}

/// Kinds, their names, the types of their trees, and the bytes of a value in memory.
const KINDS: [(Kind, &str, &str, u64); 10] = [
    (Kind::Float, "float", "Tree_float_5_4_3", 4),
    (Kind::Double, "double", "Tree_double_5_4_3", 8),
    (Kind::Bool, "bool", "Tree_bool_5_4_3", 1),
    (Kind::Mask, "mask", "Tree_mask_5_4_3", 1),
    (Kind::Int32, "int32", "Tree_int32_5_4_3", 4),
    (Kind::Int64, "int64", "Tree_int64_5_4_3", 8),
    (Kind::Vec3s, "vec3s", "Tree_vec3s_5_4_3", 12),
    (Kind::Vec3d, "vec3d", "Tree_vec3d_5_4_3", 24),
    (Kind::Vec3i, "vec3i", "Tree_vec3i_5_4_3", 12),
    (Kind::Points, "points", "Tree_ptdataidx32_5_4_3", 4),
];

impl Kind {
    fn row(self) -> (Self, &'static str, &'static str, u64) {
        KINDS[self as usize]
    }

    /// Returns all kinds that have a grid in memory, in the order of their numbers in the C ABI.
    pub fn all() -> impl Iterator<Item = Self> {
        KINDS.iter().map(|(kind, ..)| *kind).filter(|kind| *kind != Self::Points)
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// Finds a kind by its name.
    ///
    /// # Errors
    /// Fails with `Invalid`, and the names that exist, if there is no such kind.
    pub fn by_name(name: &str) -> Result<Self> {
        Self::all().find(|kind| kind.name() == name).ok_or_else(|| {
            let names: Vec<_> = Self::all().map(Self::name).collect();
            Error::invalid(format!("`{name}` is no kind of grids")).advise(format!("use {}", names.join(", ")))
        })
    }

    /// Finds the kind of a type of trees.
    pub(crate) fn of_tree(tree: &str) -> Option<Self> {
        KINDS.iter().find(|(.., name, _)| *name == tree).map(|(kind, ..)| *kind)
    }

    /// Returns the bytes of a value in memory and in files.
    pub fn value_bytes(self) -> u64 {
        self.row().3
    }

    /// Returns how many numbers a value has: 1 or 3.
    pub fn components(self) -> usize {
        match self {
            Self::Vec3s | Self::Vec3d | Self::Vec3i => 3,
            _ => 1,
        }
    }

    /// Whether values may be written with 16 bits a number.
    pub fn is_real(self) -> bool {
        matches!(self, Self::Float | Self::Double | Self::Vec3s | Self::Vec3d)
    }

    pub(crate) fn of_number(number: i32) -> Result<Self> {
        let known = usize::try_from(number).ok().and_then(|number| Self::all().nth(number));
        known.ok_or_else(|| Error::internal(format!("the module returned {number} as a kind of grids")))
    }
}

/// What the values of a grid mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Class {
    /// Not stated.
    #[default]
    Unknown,
    /// Signed distances to a surface in world units, negative inside, within a narrow band.
    LevelSet,
    /// Densities, 0 outside.
    Fog,
    /// Components of vectors that lie on the faces of voxels.
    Staggered,
}

impl Class {
    /// Classes, and their names in files.
    const ALL: [(Self, &str); 4] = [
        (Self::Unknown, "unknown"),
        (Self::LevelSet, "level set"),
        (Self::Fog, "fog volume"),
        (Self::Staggered, "staggered"),
    ];

    /// Returns its name, as files have it.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// Finds a class by its name; an unknown name is [`Class::Unknown`], as for OpenVDB.
    pub fn by_name(name: &str) -> Self {
        Self::ALL.iter().find(|(_, other)| *other == name).map_or(Self::Unknown, |(class, _)| *class)
    }

    pub(crate) fn of_number(number: i32) -> Self {
        usize::try_from(number).ok().and_then(|number| Self::ALL.get(number)).map_or(Self::Unknown, |(class, _)| *class)
    }
}

/// An entry of metadata; numbers and vectors are text here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Its type in OpenVDB: `string`, `float`, `vec3i`, ...
    pub kind: String,
    /// Its value as text.
    pub value: String,
}

/// Facts about a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GridInfo {
    /// Its name.
    pub name: String,
    /// The kind of its values; `None` of a type that is listed alone.
    pub kind: Option<Kind>,
    /// The type of its tree in OpenVDB.
    pub tree: String,
    /// What its values mean.
    pub class: Class,
    /// Whether values have 16 bits a number in files.
    pub is_half: bool,
    /// The grid whose tree it shares, if it has none of its own.
    pub instance_of: Option<String>,
    /// From voxels to world units.
    pub transform: Transform,
    /// Active voxels, also those in tiles.
    pub active_voxels: u64,
    /// Leaves, of 8³ voxels each.
    pub leaf_count: u64,
    /// The lowest and the highest active voxel; `None` if none is active.
    pub bounds: Option<[[i32; 3]; 2]>,
    /// Bytes in memory; of a grid in a file an upper bound of what it will occupy.
    pub memory_bytes: u64,
    /// Its metadata.
    pub metadata: Vec<Entry>,
}

impl GridInfo {
    pub(crate) fn of_abi(info: &abi::RlvdbInfo, metadata: Vec<Entry>) -> Result<Self> {
        let kind = Kind::of_number(info.kind)?;
        let name = metadata.iter().find(|entry| entry.name == "name").map(|entry| entry.value.clone());
        let transform = Transform::of_rows(info.matrix, info.voxel_size, info.is_linear != 0);
        let is_empty = info.low[0] > info.high[0];
        Ok(Self {
            name: name.unwrap_or_default(),
            kind: Some(kind),
            tree: kind.row().2.to_owned(),
            class: Class::of_number(info.grid_class),
            is_half: info.is_half != 0,
            instance_of: None,
            transform,
            active_voxels: info.active_voxels,
            leaf_count: info.leaf_count,
            bounds: (!is_empty).then_some([info.low, info.high]),
            memory_bytes: info.memory_bytes,
            metadata,
        })
    }
}
