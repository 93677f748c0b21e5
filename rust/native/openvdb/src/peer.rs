//! Files that OpenVDB reads and writes as a peer of our own readers and writers; for tests alone.

use std::path::Path;

use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result};

use crate::call;
use crate::file::{self, Packing, path_text};
use crate::grid::{Grid, zero_ended};
use crate::info::Class;
use crate::module::Module;
use crate::transform::Transform;

/// A level set on the integer lattice.
#[derive(Debug)]
pub struct LevelSet(Grid);

/// How a level set is written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placing {
    /// Edge of a voxel.
    pub voxel: f64,
    /// Where voxel 0 is.
    pub origin: [f64; 3],
    /// How values are packed.
    pub packing: Packing,
    /// Values have 16 bits.
    pub is_half: bool,
    /// It is made a fog volume first.
    pub is_fog: bool,
}

impl LevelSet {
    /// Makes one of a mesh in voxel coordinates, with a band of `band` voxels on either side.
    pub fn of_mesh(points: &[[f32; 3]], triangles: &[[u32; 3]], band: f32) -> Result<Self> {
        let (context, lattice) = (Context::serial(), Transform::uniform(1.0));
        Grid::of_mesh(&context, points, triangles, &lattice, [band; 2], &mut Silent).map(Self)
    }

    /// Reads the first grid of a file.
    pub fn read(path: &Path) -> Result<Self> {
        file::read(&Context::serial(), path, None, None, &mut Silent).map(Self)
    }

    /// Writes it as the only grid of a file, called `cloud`; its values stay as they are.
    pub fn write(&self, path: &Path, placing: &Placing) -> Result<()> {
        let Placing { voxel, origin, packing, is_half, is_fog } = *placing;
        let context = Context::serial();
        let mut grid = if is_fog { self.0.fog(&context, &mut Silent)? } else { self.0.copy()? };
        let axes = [[voxel, 0.0, 0.0], [0.0, voxel, 0.0], [0.0, 0.0, voxel], origin];
        grid.set_transform(&Transform::affine(axes))?;
        grid.set_half(is_half)?;
        grid.set_name("cloud")?;
        let writing = file::Writing { packing, ..Default::default() };
        file::write(&context, path, &[&grid], &writing, &mut Silent)
    }

    /// Returns the edge of a voxel, the background, the number of active voxels, and whether it is a level set of cubic
    /// voxels.
    pub fn facts(&self) -> Result<(f64, f64, u64, bool)> {
        let info = self.0.info()?;
        let [x, y, z] = info.transform.voxel_size;
        let is_level_set = info.class == Class::LevelSet && x == y && y == z;
        Ok((x, self.0.background()?[0], info.active_voxels, is_level_set))
    }

    /// Returns the values of voxels; of meshes distances in voxels, negative inside, clamped to the band.
    pub fn values(&self, voxels: &[[i32; 3]]) -> Result<Vec<f32>> {
        Ok(self.0.voxels(voxels)?.iter().map(|value| *value as f32).collect())
    }
}

/// Points with velocities, of which OpenVDB makes a grid.
#[derive(Clone, Copy, Debug)]
pub struct Points<'a> {
    /// Positions.
    pub places: &'a [[f32; 3]],
    /// One for each.
    pub velocities: &'a [[f32; 3]],
    /// Edge of a voxel.
    pub voxel: f64,
    /// Positions have 16 bits.
    pub is_fixed: bool,
    /// How values are packed.
    pub packing: Packing,
}

/// Returns the numbers of an attribute of the points of a file, in the order of the file: positions, of `P`, in the world.
///
/// The file is not checked. Fails if it has not one grid of points, or OpenVDB throws.
pub fn read_points(path: &Path, attribute: &str) -> Result<Vec<f32>> {
    let module = Module::open()?;
    let (file, attribute) = (path_text(path)?, zero_ended("attribute", attribute)?);
    let mut values: Vec<f32> = Vec::new();
    loop {
        let (mut count, mut error) = (0, call::record());
        // SAFETY: the texts end with zeros and live through the call, and at most as many numbers are written as there is
        // room for.
        let result = unsafe {
            let (out, room) = (values.as_mut_ptr(), values.len());
            let table = module.table();
            table.rlvdb_test_points_read(file.as_ptr(), attribute.as_ptr(), out, room, &mut count, &mut error)
        };
        call::check(result, &error)?;
        if count == values.len() {
            return Ok(values);
        }
        values.resize(count, 0.0);
    }
}

/// Writes points as the only grid of a file: velocities `v` with 16 bits, and the radius `pscale` of 0.25.
///
/// Fails if there are not as many velocities as positions, or OpenVDB throws.
pub fn write_points(path: &Path, points: &Points) -> Result<()> {
    let Points { places, velocities, voxel, is_fixed, packing } = *points;
    if places.len() != velocities.len() {
        return Err(Error::invalid("there are not as many velocities as positions"));
    }
    let module = Module::open()?;
    let (file, mut error) = (path_text(path)?, call::record());
    // SAFETY: the path ends with a zero, both arrays have three numbers of each point, and all live through the call.
    let result = unsafe {
        let (at, moves, count) = (places.as_ptr().cast(), velocities.as_ptr().cast(), places.len());
        let (table, bits) = (module.table(), packing.bits());
        table.rlvdb_test_points_write(file.as_ptr(), at, moves, count, voxel, is_fixed.into(), bits, &mut error)
    };
    call::check(result, &error)
}

/// Writes two grids, `first` and `second`, that share the tree of `grid`; the second is 100 units further along x.
pub fn write_instances(path: &Path, grid: &Grid) -> Result<()> {
    let module = Module::open()?;
    let (file, mut error) = (path_text(path)?, call::record());
    // SAFETY: the path ends with a zero, the grid is alive, and the record lives through the call.
    let result = unsafe { module.table().rlvdb_test_instances_write(file.as_ptr(), grid.pointer(), &mut error) };
    call::check(result, &error)
}

/// Fails where there is no module, if it is `required`, as `cargo xtask test` demands.
const REQUIRED: &str = "RELIEVO_OPENVDB_TESTS";

/// Whether tests have the module; where it is not built they are skipped, with a line about it.
///
/// # Panics
/// If there is none and `RELIEVO_OPENVDB_TESTS` is `required`.
pub fn is_available() -> bool {
    let Err(error) = Module::open() else { return true };
    assert!(std::env::var_os(REQUIRED).is_none_or(|value| value != "required"), "{error}");
    println!("skipped: the OpenVDB module is not built (cargo xtask module)");
    false
}
