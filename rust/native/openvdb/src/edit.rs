//! Grids made of grids: set operations, offsets, filters, resampling, other kinds of values, labels.

use relievo_core::{Context, Error, Progress, Result};

use crate::grid::Grid;
use crate::info::{Class, Kind};
use crate::module::Module;
use crate::transform::Transform;

/// Set operations of two grids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Inside of either; of fog the denser value.
    Union,
    /// Inside of both; of fog the thinner value.
    Intersection,
    /// Inside of the first and not of the second; of fog the first minus the second, not below 0.
    Difference,
}

/// Filters that smooth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The mean of a cube of voxels.
    Mean,
    /// Four passes of means, which come near to a Gaussian.
    Gaussian,
    /// The median of a cube of voxels.
    Median,
    /// Laplacian flow; of level sets alone.
    Laplacian,
    /// Mean curvature flow; of level sets alone.
    MeanCurvature,
}

/// How values between voxels are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// That of the nearest voxel. Bools, masks and integers are always resampled so.
    Nearest,
    /// Trilinear between voxels.
    Linear,
    /// Triquadratic; of vectors trilinear.
    Quadratic,
}

/// The radius of a filter in voxels, and how often it is applied, at most.
const WIDEST: u32 = 100;
const MAX: u32 = 1000;
/// Voxels that a surface is moved at most.
const FARTHEST: f64 = 10_000.0;

impl Grid {
    /// Combines it with another grid of its kind and class. The other one is resampled to its transform if they differ.
    ///
    /// # Errors
    /// Fails with `Invalid` if the kinds or classes differ, or are vectors, with `Memory` if resampling would exceed
    /// the memory limit, with `Cancelled` if `progress` asks to stop, and as [`Module::open`] does.
    pub fn combined(
        &self,
        context: &Context,
        other: &Self,
        operation: Operation,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        let (own, second) = (self.info()?, other.info()?);
        if (own.kind, own.class) != (second.kind, second.class) {
            let error = Error::invalid("the grids are not of one kind and class").at("grids");
            return Err(error.advise("convert one of them first"));
        }
        if own.transform != second.transform {
            check_resampled(&second, &own.transform, context)?;
        }
        let module = Module::open()?;
        Self::long(context, "combine grids", progress, |out, how, error| {
            let (a, b, operation) = (self.pointer(), other.pointer(), operation as i32);
            // SAFETY: both grids are alive, and the outputs live through the call.
            unsafe { module.table().rlvdb_combine(a, b, operation, how, out, error) }
        })
    }

    /// Moves the surface of a level set outwards by a distance in world units, inwards if it is negative.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is no level set of cubic voxels, or the distance is not finite or over 10,000 voxels,
    /// with `Cancelled` if `progress` asks to stop, and as [`Module::open`] does.
    pub fn offset(&self, context: &Context, distance: f64, progress: &mut dyn Progress) -> Result<Self> {
        let voxel = self.info()?.transform.voxel_size[0];
        if !distance.is_finite() || (distance / voxel).abs() > FARTHEST {
            let error = Error::invalid(format!("an offset of {distance} is not finite or over 10,000 voxels"));
            return Err(error.at("distance").advise("resample to larger voxels first"));
        }
        let module = Module::open()?;
        Self::long(context, "offset", progress, |out, how, error| {
            // SAFETY: the grid is alive, and the outputs live through the call.
            unsafe { module.table().rlvdb_offset(self.pointer(), distance, how, out, error) }
        })
    }

    /// Smooths a grid of floats or doubles: `radius` in voxels is half the width of the filter (that of means, Gaussians and
    /// medians), `iterations` is how often it is applied.
    ///
    /// # Errors
    /// Fails with `Invalid` if the filter does not fit the kind and class, the radius is not 1 to 100 or the iterations
    /// are not 1 to 1000, with `Cancelled` if `progress` asks to stop, and as [`Module::open`] does.
    pub fn filtered(
        &self,
        context: &Context,
        filter: Filter,
        radius: u32,
        iterations: u32,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        if !(1..=WIDEST).contains(&radius) || !(1..=MAX).contains(&iterations) {
            let error = Error::invalid(format!("a filter of radius {radius}, applied {iterations} times, cannot be"));
            return Err(error.at("radius").advise("use a radius of 1 to 100, and 1 to 1000 iterations"));
        }
        let module = Module::open()?;
        Self::long(context, "smooth", progress, |out, how, error| {
            let (grid, filter) = (self.pointer(), filter as i32);
            // SAFETY: the grid is alive, and the outputs live through the call.
            unsafe { module.table().rlvdb_filter(grid, filter, radius, iterations, how, out, error) }
        })
    }

    /// Resamples it to another transform. A level set keeps its distances in world units and the width of its band in voxels.
    ///
    /// # Errors
    /// Fails with `Invalid` if the transform has no inverse, with `Unsupported` if it is a frustum, with `Memory` if
    /// the estimate of the memory exceeds the limit, with `Cancelled` if `progress` asks to stop, and as
    /// [`Module::open`] does.
    pub fn resampled(
        &self,
        context: &Context,
        transform: &Transform,
        order: Order,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        transform.check()?;
        if !transform.is_linear {
            return Err(Error::unsupported("a grid is not resampled to a frustum").at("transform"));
        }
        check_resampled(&self.info()?, transform, context)?;
        let (module, matrix) = (Module::open()?, transform.numbers());
        Self::long(context, "resample", progress, |out, how, error| {
            let (grid, matrix, order) = (self.pointer(), matrix.as_ptr(), order as u32);
            // SAFETY: the grid is alive, sixteen numbers of the matrix are read, and the outputs live through the call.
            unsafe { module.table().rlvdb_resample(grid, matrix, order, how, out, error) }
        })
    }

    /// Converts it to another kind of values: scalars to scalars, vectors to vectors; a bool or a mask has the active voxels,
    /// and becomes 1 and 0 as a number.
    ///
    /// # Errors
    /// Fails with `Invalid` between scalars and vectors, with `Unsupported` for points, with `Cancelled` if `progress`
    /// asks to stop, and as [`Module::open`] does.
    pub fn converted(&self, context: &Context, kind: Kind, progress: &mut dyn Progress) -> Result<Self> {
        if kind == Kind::Points {
            return Err(Error::unsupported("voxels are not converted to points").at("kind"));
        }
        let module = Module::open()?;
        Self::long(context, "convert", progress, |out, how, error| {
            // SAFETY: the grid is alive, and the outputs live through the call.
            unsafe { module.table().rlvdb_convert(self.pointer(), kind as i32, how, out, error) }
        })
    }

    /// Makes a fog volume of a level set: 1 inside, falling to 0 over the inner band.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is no level set, with `Cancelled` if `progress` asks to stop, and as [`Module::open`]
    /// does.
    pub fn fog(&self, context: &Context, progress: &mut dyn Progress) -> Result<Self> {
        let module = Module::open()?;
        Self::long(context, "level set to fog", progress, |out, how, error| {
            // SAFETY: the grid is alive, and the outputs live through the call.
            unsafe { module.table().rlvdb_to_fog(self.pointer(), how, out, error) }
        })
    }

    /// Makes a level set of the surface at which a scalar grid has a value, or of the active voxels of a bool or a mask.
    /// `band` is half its width in voxels.
    ///
    /// # Errors
    /// Fails with `Invalid` if the grid has integers or vectors, the value is not finite or the band is not 1 to 100,
    /// with `Cancelled` if `progress` asks to stop, and as [`Module::open`] does.
    pub fn level_set(&self, context: &Context, value: f64, band: f32, progress: &mut dyn Progress) -> Result<Self> {
        if !value.is_finite() || !(1.0..=100.0).contains(&band) {
            let error = Error::invalid(format!("a level set at {value} with a band of {band} voxels cannot be"));
            return Err(error.at("band").advise("use a finite value, and a band of 1 to 100"));
        }
        let module = Module::open()?;
        let mut made = Self::long(context, "level set", progress, |out, how, error| {
            // SAFETY: the grid is alive, and the outputs live through the call.
            unsafe { module.table().rlvdb_to_level_set(self.pointer(), value, band, how, out, error) }
        })?;
        // A level set that is rebuilt has no metadata.
        if let Some(name) = self.metadata()?.iter().find(|entry| entry.name == "name") {
            made.set_name(&name.value)?;
        }
        Ok(made)
    }

    /// Makes a mask of the voxels that have a label.
    ///
    /// # Errors
    /// Fails with `Invalid` if the grid has no integers, with `Cancelled` if `progress` asks to stop, and as
    /// [`Module::open`] does.
    pub fn label_mask(&self, context: &Context, label: i64, progress: &mut dyn Progress) -> Result<Self> {
        let module = Module::open()?;
        Self::long(context, "mask of a label", progress, |out, how, error| {
            // SAFETY: the grid is alive, and the outputs live through the call.
            unsafe { module.table().rlvdb_label_mask(self.pointer(), label, how, out, error) }
        })
    }
}

/// Makes a grid of 32-bit labels: voxels inside a level set have its label, later ones win, and 0 is outside of all.
///
/// # Errors
/// Fails with `Invalid` if there is no label, there are not as many labels as level sets, one is no level set of
/// floats, or their transforms differ, with `Cancelled` if `progress` asks to stop, and as [`Module::open`] does.
pub fn labels(context: &Context, level_sets: &[&Grid], labels: &[i32], progress: &mut dyn Progress) -> Result<Grid> {
    if level_sets.len() != labels.len() || labels.is_empty() {
        let what = format!("there are {} labels for {} level sets", labels.len(), level_sets.len());
        return Err(Error::invalid(what).at("labels").advise("give one for each, and at least one"));
    }
    let module = Module::open()?;
    let pointers: Vec<_> = level_sets.iter().map(|grid| grid.pointer()).collect();
    Grid::long(context, "labels", progress, |out, how, error| {
        let (grids, numbers, count) = (pointers.as_ptr(), labels.as_ptr(), pointers.len());
        // SAFETY: both arrays have `count` elements, the grids are alive, and all live through the call.
        unsafe { module.table().rlvdb_labels(grids, numbers, count, how, out, error) }
    })
}

/// Fails if a grid would outgrow the memory limit when it is resampled.
fn check_resampled(info: &crate::GridInfo, transform: &Transform, context: &Context) -> Result<()> {
    let finer = info.transform.voxel_volume() / transform.voxel_volume();
    // The band of a level set grows as its surface does.
    let growth = if info.class == Class::LevelSet { finer.powf(2.0 / 3.0) } else { finer };
    let bytes = info.memory_bytes as f64 * growth.max(1.0) * 2.0;
    if bytes <= context.memory_limit() as f64 && finer < 1e12 && finer > 1e-12 {
        return Ok(());
    }
    let what = format!("resampling would need about {bytes:.3e} bytes, more than the memory limit");
    Err(Error::memory(what).at("transform").advise("take larger voxels, or raise the memory limit"))
}
