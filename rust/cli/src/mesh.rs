//! `relievo mesh`

pub mod advice;
mod check;
mod repair;
mod report;
pub mod simplify;
pub mod tessellate;

use clap::Subcommand;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Reports holes, non-manifold, misoriented, degenerate and doubled elements of a mesh.
    Check(check::Arguments),
    /// Welds, orients and closes a mesh, and writes it as an oriented manifold.
    Repair(repair::Arguments),
    /// Makes a mesh of fewer triangles for nearly the same surface.
    Simplify(simplify::Arguments),
    /// Makes a mesh of Bézier patches.
    Tessellate(tessellate::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Check(arguments) => check::run(arguments),
        Task::Repair(arguments) => repair::run(arguments),
        Task::Simplify(arguments) => simplify::run(arguments),
        Task::Tessellate(arguments) => tessellate::run(arguments),
    }
}
