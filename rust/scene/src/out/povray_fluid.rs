//! Fluids in scenes for POV-Ray: as blobs of its own, or as a grid of values (`.df3`) of which it makes an isosurface.
//!
//! A blob of POV-Ray is (1 - d²/R²)², here with R of 2.5 radii of a particle, which is near the Gaussian of blobs of
//! sharpness 8; a particle alone is a sphere of its radius. A grid has values of 16 bits, half of the most at the surface.

use std::io::Write;

use relievo_core::{Context, Error, Result};
use relievo_fluid::{Surface, SurfaceFunction};

use crate::format::povray_form::PovrayForm;
use crate::out::df3::write_df3;
use crate::out::output::Folder;
use crate::state::isosurface::FluidEntry;

/// A fluid as it is written.
pub(crate) enum PovrayFluid {
    Blobs { points: Vec<[f32; 3]>, spacing: f32 },
    Grid(Grid),
}

/// Values on a grid and where it lies.
pub(crate) struct Grid {
    /// The name of its file.
    file: String,
    /// Columns, rows and layers.
    size: [usize; 3],
    low: [f64; 3],
    cell: f64,
    values: Vec<u16>,
}

/// Values of a grid at most along an axis, and in all.
const MAX_ALONG: f64 = 65_535.0;
const MAX: f64 = 67_108_864.0;
/// The reach of a blob in spacings, and its strength half a spacing away.
const REACH: f32 = 1.25;
const THRESHOLD: f32 = 0.7056;

impl PovrayFluid {
    /// Of particles at these places; `None` if a mesh is wanted. Fails if the surface cannot be made, or if its grid has more
    /// than 2²⁶ values.
    pub fn new(context: &Context, fluid: &FluidEntry, points: &[[f32; 3]]) -> Result<Option<Self>> {
        match fluid.povray {
            PovrayForm::Mesh => Ok(None),
            PovrayForm::Blobs => Ok(Some(Self::Blobs { points: points.to_vec(), spacing: fluid.spacing })),
            PovrayForm::Grid => Grid::new(context, fluid, points).map(|grid| Some(Self::Grid(grid))),
        }
    }

    /// Writes the file that the object of this name refers to in a frame, where it has one.
    pub fn store(&mut self, folder: &Folder, object: &str, frame: u32) -> Result<()> {
        let Self::Grid(grid) = self else { return Ok(()) };
        let path = folder.file(&format!("fluid-{}-{frame:06}.df3", object.replace('"', "_")));
        grid.file = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        write_df3(&path, grid.size, &grid.values)
    }

    /// Writes what the object refers to.
    pub fn declare(&self, out: &mut impl Write) -> std::io::Result<()> {
        let Self::Grid(grid) = self else { return Ok(()) };
        // A value lies where its number divided by how many there are says.
        let [x, y, z] = grid.size.map(|along| along as f64 * grid.cell);
        let [a, b, c] = grid.low;
        let place = format!("scale <{x}, {y}, {z}> translate <{a}, {b}, {c}>");
        let pattern = format!("density_file df3 \"{}\" interpolate 1 {place}", grid.file);
        writeln!(out, "#declare Fluid_Values = function {{ pattern {{ {pattern} }} }};")
    }

    /// Writes the geometry.
    pub fn write(&self, out: &mut impl Write) -> std::io::Result<()> {
        match self {
            Self::Blobs { points, spacing } => {
                writeln!(out, "blob {{ threshold {THRESHOLD}")?;
                for [x, y, z] in points {
                    writeln!(out, "  sphere {{ <{x}, {y}, {z}>, {}, 1 }}", REACH * spacing)?;
                }
                writeln!(out, "}}")
            }
            Self::Grid(grid) => {
                let [a, b, c] = grid.low;
                let end = |axis: usize| grid.low[axis] + (grid.size[axis] - 1) as f64 * grid.cell;
                let contained = format!("box {{ <{a}, {b}, {c}>, <{}, {}, {}> }}", end(0), end(1), end(2));
                let (steepest, accuracy) = (1.0 / grid.cell, 0.01 * grid.cell);
                writeln!(
                    out,
                    "isosurface {{\n  function {{ 0.5 - Fluid_Values(x, y, z) }}\n  contained_by {{ {contained} }}\n  \
                     max_gradient {steepest} accuracy {accuracy}\n}}"
                )
            }
        }
    }
}

impl Grid {
    /// Values in steps of the entry's cells, or of half a spacing.
    fn new(context: &Context, fluid: &FluidEntry, points: &[[f32; 3]]) -> Result<Self> {
        let surface = Surface::new(context, points, fluid.function)?;
        let cell = f64::from(fluid.cell.unwrap_or(0.5 * fluid.spacing));
        let reach = f64::from(surface.reach());
        let along = |axis: usize| points.iter().map(move |point| f64::from(point[axis]));
        let low: [f64; 3] = std::array::from_fn(|axis| along(axis).fold(f64::INFINITY, f64::min) - reach);
        let high: [f64; 3] = std::array::from_fn(|axis| along(axis).fold(f64::NEG_INFINITY, f64::max) + reach);
        let counts: [f64; 3] = std::array::from_fn(|axis| ((high[axis] - low[axis]) / cell).ceil() + 1.0);
        let fits = counts.iter().all(|count| *count <= MAX_ALONG) && counts.iter().product::<f64>() <= MAX;
        if points.is_empty() || !fits {
            return Err(Error::invalid(format!("a grid of {counts:?} values cannot be written"))
                .advise("use larger cells, or `povray = \"mesh\"`"));
        }
        let size = counts.map(|count| count as usize);
        // The value deep within a fluid of one particle.
        let most = match fluid.function {
            SurfaceFunction::ZhuBridson { radius, .. } => radius,
            _ => 1.0,
        };
        let layers = context.map(size[2], |layer| {
            let mut probe = surface.probe(context);
            let mut values = Vec::with_capacity(size[0] * size[1]);
            for (row, column) in (0..size[1]).flat_map(|row| (0..size[0]).map(move |column| (row, column))) {
                let place = [column, row, layer];
                let at = std::array::from_fn(|axis| (low[axis] + place[axis] as f64 * cell) as f32);
                let value = (probe.sample(at).value / most).clamp(-1.0, 1.0);
                values.push((32_768.0 + 32_767.0 * value) as u16);
            }
            values
        });
        Ok(Self { file: String::new(), size, low, cell, values: layers.concat() })
    }
}
