//! `relievo grid combine`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Error, Result};
use relievo_openvdb::{Grid, Operation, Order, labels, write};

use super::source::{self, Making};
use super::{Bar, Limits, Output};
use crate::Outcome;

/// Combines grids of OpenVDB files, meshes and particles, from left to right. All become as the first one: its voxels and
/// its kind of values.
#[derive(clap::Args)]
#[command(
    after_help = "Example: relievo grid combine block.obj hole.obj -o part.vdb --operation difference --voxel 0.01"
)]
pub struct Arguments {
    /// The OpenVDB files, meshes or particles; two at least.
    #[arg(value_name = "FILE", required = true, num_args = 2..)]
    from: Vec<PathBuf>,
    /// The OpenVDB file to write.
    #[arg(short, long, value_name = "FILE.vdb")]
    output: PathBuf,
    /// What to make of them.
    #[arg(long, value_enum, default_value_t = Combination::Union)]
    operation: Combination,
    /// The grid to take of files that have several; the first that can be read if it is left out.
    #[arg(long, value_name = "NAME")]
    grid: Option<String>,
    #[command(flatten)]
    making: Making,
    #[command(flatten)]
    written: Output,
    #[command(flatten)]
    limits: Limits,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum Combination {
    /// What is inside of any.
    Union,
    /// What is inside of all.
    Intersection,
    /// What is inside of the first and of none of the others.
    Difference,
    /// A grid of integers: 1 inside the first, 2 inside the second, and so on; later ones win.
    Labels,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let mut grids = Vec::new();
    let mut making = Making { voxel: arguments.making.voxel, ..arguments.making };
    for path in &arguments.from {
        let name = arguments.grid.as_deref().filter(|_| source::is_vdb(path));
        let mut found = source::grids(&context, path, name, None, &making)?;
        let grid = found.swap_remove(0);
        // What is made of later meshes has the voxels of the first grid.
        making.voxel.get_or_insert(grid.info()?.transform.voxel_size[0]);
        grids.push(grid);
    }
    let mut made = match arguments.operation {
        Combination::Labels => {
            let first = grids[0].info()?.transform;
            for grid in &mut grids[1..] {
                if grid.info()?.transform != first {
                    *grid = grid.resampled(&context, &first, Order::Linear, &mut Bar::new())?;
                }
            }
            let numbers: Vec<i32> = (1..=grids.len() as i32).collect();
            let list: Vec<&Grid> = grids.iter().collect();
            labels(&context, &list, &numbers, &mut Bar::new())?
        }
        other => {
            let operation = match other {
                Combination::Intersection => Operation::Intersection,
                Combination::Difference => Operation::Difference,
                _ => Operation::Union,
            };
            let rest = grids.split_off(1).into_iter().zip(&arguments.from[1..]);
            let mut all = grids.swap_remove(0);
            for (grid, path) in rest {
                let named = |error: Error| error.at(path.display().to_string());
                all = all.combined(&context, &grid, operation, &mut Bar::new()).map_err(named)?;
            }
            all
        }
    };
    made.set_half(arguments.written.half)?;
    write(&context, &arguments.output, &[&made], &arguments.written.writing(), &mut Bar::new())?;
    let line: Result<String> = super::line(&made);
    crate::print(&line?)?;
    Ok(ExitCode::SUCCESS)
}
