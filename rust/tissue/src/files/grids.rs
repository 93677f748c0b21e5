//! Grids of OpenVDB: level sets, fog and labels become scans, and models and their stresses become grids.

use std::path::Path;

use glam::Vec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result};
use relievo_openvdb::{Block, Class, Grid, Kind, Transform, Writing, read, write};

use crate::files::scan::Scan;
use crate::model::Model;
use crate::simulation::{ElementState, Simulation};

impl Scan {
    /// Reads a grid of an OpenVDB file: the one of a name, or the first.
    ///
    /// # Errors
    /// Fails as [`relievo_openvdb::read`] and [`Self::of_grid`].
    pub fn read_grid(context: &Context, path: &Path, name: Option<&str>) -> Result<Self> {
        let grid = read(context, path, name, None, &mut Silent)?;
        Self::of_grid(context, &grid).map_err(|error| error.at(path.display().to_string()))
    }

    /// Copies the box of active voxels of a grid of numbers, truth values or labels. Inside of a level set values are
    /// negative, and those of truth values are 0 and 1.
    ///
    /// # Errors
    /// Fails if no voxel is active, a value has more than one number, the box does not fit the memory limit, or the
    /// voxels are not boxes along the axes of the world.
    pub fn of_grid(context: &Context, grid: &Grid) -> Result<Self> {
        let info = grid.info()?;
        let named = |error: Error| error.at(format!("grid {}", info.name));
        let Some(kind) = info.kind.filter(|kind| kind.components() == 1 && *kind != Kind::Points) else {
            return Err(named(
                Error::unsupported("its values are not single numbers").advise("give a level set, fog, or labels"),
            ));
        };
        let Some([low, high]) = info.bounds else {
            return Err(named(Error::invalid("none of its voxels is active").advise("give a grid with active voxels")));
        };
        let rows = info.transform.rows;
        let is_box =
            (0..3).all(|at| (0..3).all(|axis| if at == axis { rows[at][axis] > 0.0 } else { rows[at][axis] == 0.0 }));
        let corner = info.transform.place(low.map(|at| f64::from(at) - 0.5)).filter(|_| is_box);
        let Some(corner) = corner else {
            return Err(named(
                Error::unsupported("its voxels are turned, sheared or in a frustum").advise("resample it first"),
            ));
        };
        let size: [u32; 3] = std::array::from_fn(|axis| (i64::from(high[axis]) - i64::from(low[axis]) + 1) as u32);
        let bytes = size.iter().map(|edge| f64::from(*edge)).product::<f64>() * (kind.value_bytes() + 4) as f64;
        if bytes > context.memory_limit() as f64 {
            return Err(named(
                Error::memory(format!("a box of {size:?} voxels does not fit the memory limit"))
                    .advise("raise the memory limit, or resample the grid"),
            ));
        }
        let block = grid.block(context, low, size)?;
        let counts = size.map(|edge| edge as usize);
        let width = kind.value_bytes() as usize;
        let planes = context.map(counts[2], |z| {
            let place = |x: usize, y: usize| ((x * counts[1] + y) * counts[2] + z) * width;
            let row = |y: usize| (0..counts[0]).map(move |x| place(x, y));
            (0..counts[1]).flat_map(row).map(|at| number(kind, &block.bytes[at..at + width])).collect::<Vec<f32>>()
        });
        let cell = [0, 1, 2].map(|axis| rows[axis][axis] as f32);
        Ok(Self { counts, cell, low: corner.map(|at| at as f32), values: planes.concat() })
    }
}

/// Returns a number in as many bytes as its kind has, in native order.
fn number(kind: Kind, bytes: &[u8]) -> f32 {
    match kind {
        Kind::Double => bytes.try_into().map_or(0.0, |bytes| f64::from_ne_bytes(bytes) as f32),
        Kind::Int32 => bytes.try_into().map_or(0.0, |bytes| i32::from_ne_bytes(bytes) as f32),
        Kind::Int64 => bytes.try_into().map_or(0.0, |bytes| i64::from_ne_bytes(bytes) as f32),
        Kind::Bool | Kind::Mask => bytes.first().map_or(0.0, |byte| f32::from(*byte)),
        _ => bytes.try_into().map_or(0.0, f32::from_ne_bytes),
    }
}

impl Model {
    /// Returns a grid of labels at rest: 1 and the index of the material with the largest share, 0 outside.
    ///
    /// # Errors
    /// Fails if the elements are not equal boxes, or the grid does not fit the memory limit.
    pub fn label_grid(&self, context: &Context) -> Result<Grid> {
        let labels = self.main_materials();
        self.grid(context, "material", Kind::Int32, |element| (labels[element] as i32 + 1).to_ne_bytes())
    }

    /// Returns a grid with a number of each element.
    fn grid(&self, context: &Context, name: &str, kind: Kind, value: impl Fn(usize) -> [u8; 4]) -> Result<Grid> {
        let Some(cell) = self.cell.map(Vec3::from) else {
            return Err(Error::unsupported("the elements are not equal boxes").advise("write it for VTK, `.vtu`"));
        };
        let low = self.nodes.iter().map(|node| Vec3::from(*node)).fold(Vec3::INFINITY, Vec3::min);
        let high = self.nodes.iter().map(|node| Vec3::from(*node)).fold(Vec3::NEG_INFINITY, Vec3::max);
        let counts = ((high - low) / cell).round().max(Vec3::ONE);
        if counts.as_dvec3().element_product() * 4.0 > context.memory_limit() as f64 {
            return Err(Error::memory(format!("a grid of {counts} voxels does not fit the memory limit"))
                .advise("raise the memory limit"));
        }
        let size = counts.to_array().map(|count| count as usize);
        let mut bytes = vec![0; size.iter().product::<usize>() * 4];
        for (element, corners) in self.elements.iter().enumerate() {
            let place = ((Vec3::from(self.nodes[corners[0] as usize]) - low) / cell).round().to_array();
            let [x, y, z] = std::array::from_fn(|axis| (place[axis] as usize).min(size[axis] - 1));
            let at = ((x * size[1] + y) * size[2] + z) * 4;
            bytes[at..at + 4].copy_from_slice(&value(element));
        }
        let mut grid = Grid::new(kind, [0.0; 3], f64::from(cell.x))?;
        let [a, b, c] = cell.as_dvec3().to_array();
        let middle = (low + 0.5 * cell).as_dvec3().to_array();
        grid.set_transform(&Transform::affine([[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c], middle]))?;
        grid.set_name(name)?;
        grid.set_class(Class::Unknown)?;
        let block = Block { low: [0; 3], size: size.map(|count| count as u32), kind, bytes };
        grid.set_block(context, &block, 0.0)?;
        Ok(grid)
    }
}

impl Simulation {
    /// Writes grids of the elements at rest to an OpenVDB file: `material` as labels, `von_mises` in Pa and `volume` as
    /// the share of that at rest.
    ///
    /// # Errors
    /// Fails as [`Model::label_grid`], or if the file cannot be written.
    pub fn write_vdb(&self, context: &Context, path: &Path, elements: &[ElementState]) -> Result<()> {
        let model = self.model();
        let of = |element: usize| elements.get(element).copied().unwrap_or_default();
        let floats = |name: &str, value: fn(ElementState) -> f32| {
            model.grid(context, name, Kind::Float, |element| value(of(element)).to_ne_bytes())
        };
        let grids = [
            model.label_grid(context)?,
            floats("von_mises", |state| state.von_mises)?,
            floats("volume", |state| state.volume)?,
        ];
        write(context, path, &grids.each_ref(), &Writing::default(), &mut Silent)
    }
}
