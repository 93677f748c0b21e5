//! The `relievo` command: runs scenes, checks them, writes a first one, and looks into files.
//!
//! Results go to standard output, everything else to standard error. Exit codes: 0 done, 1 failed, 2 wrong usage,
//! 3 files that were compared differ by more than allowed, or a mesh that was checked has defects.

mod args;
mod bar;
mod compare;
mod crowd;
#[cfg(feature = "decal")]
mod decal;
mod devices;
mod doc;
mod draw;
mod farm;
mod fluid;
mod foam;
mod grid;
mod groups;
mod info;
mod manual;
mod mesh;
mod progressive;
mod scene;
#[cfg(feature = "server")]
mod server;
#[cfg(feature = "shader")]
mod shader;
mod spelling;
mod tissue;
#[cfg(feature = "view")]
mod view;

use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use relievo_core::{Context, ContextOptions, Result};
use relievo_scene::diagnostic::Failure;

/// Surfaces and effects: displacement, painting, imprints, levels of detail, repair, fluids and grids.
#[derive(Parser)]
#[command(name = "relievo", version, propagate_version = true, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Runs, writes, checks and exports scenes: physics, imprints, pictures and meshes of frames.
    Scene(scene::Arguments),
    /// Says how much two pictures differ.
    Compare(compare::Arguments),
    /// Says what is in a mesh file, a file of Bézier patches, a Ptex file, a document or particles.
    Info(info::Arguments),
    /// Checks, repairs and simplifies meshes, and makes them of Bézier patches.
    Mesh(mesh::Arguments),
    /// Lays stickers on meshes, exactly on feature points.
    #[cfg(feature = "decal")]
    Decal(decal::Arguments),
    /// Builds, draws and reports crowds of articulated models at the detail that their pixels deserve.
    Crowd(crowd::Arguments),
    /// Builds progressive meshes, and takes meshes of any level from them.
    Progressive(progressive::Arguments),
    /// Simulates fluids of particles, makes meshes of their surfaces, and plots how it went.
    Fluid(fluid::Arguments),
    /// Makes spray, foam and bubbles of a fluid's frames, and renders them over pictures.
    Foam(foam::Arguments),
    /// Makes finite-element models of soft tissue from surfaces, and simulates them.
    Tissue(tissue::Arguments),
    /// Lists, converts, meshes and combines OpenVDB's sparse grids: level sets, fog, masks, labels.
    Grid(grid::Arguments),
    /// Runs a simulation server, and submits, watches, steers and fetches what a server simulates.
    #[cfg(feature = "server")]
    Server(server::Arguments),
    /// Writes and submits jobs of render farms: a simulation, then meshes, foam and pictures in parallel.
    Farm(farm::Arguments),
    /// Opens a window in which a mesh or a document is looked at, painted and sculpted.
    #[cfg(feature = "view")]
    View(view::Arguments),
    /// Draws a picture of Bézier patches, a mesh or a document, on a graphics device or by rays.
    Draw(draw::Arguments),
    /// Explores shaders: which of their variables tell what is sought in a picture from what is not.
    #[cfg(feature = "shader")]
    Shader(shader::Arguments),
    /// Lists the processor and the graphics devices of this machine.
    Devices(devices::Arguments),
    /// Makes documents of strokes and textures, lists and undoes their edits, and exports their layers.
    Doc(doc::Arguments),
    /// Writes the manual pages of all commands.
    #[command(hide = true)]
    Manual(manual::Arguments),
}

/// What a command ends with.
type Outcome = std::result::Result<ExitCode, Failure>;

fn main() -> ExitCode {
    relievo_gpu::quiet_drivers();
    let matches = groups::grouped(Arguments::command()).get_matches_from(spelling::current(std::env::args_os()));
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let outcome = match arguments.command {
        Command::Scene(arguments) => scene::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Info(arguments) => info::run(&arguments),
        Command::Mesh(arguments) => mesh::run(&arguments),
        #[cfg(feature = "decal")]
        Command::Decal(arguments) => decal::run(&arguments),
        Command::Crowd(arguments) => crowd::run(&arguments),
        Command::Progressive(arguments) => progressive::run(&arguments),
        Command::Fluid(arguments) => fluid::run(&arguments),
        Command::Foam(arguments) => foam::run(&arguments),
        Command::Tissue(arguments) => tissue::run(&arguments),
        Command::Grid(arguments) => grid::run(&arguments),
        #[cfg(feature = "server")]
        Command::Server(arguments) => server::run(&arguments),
        Command::Farm(arguments) => farm::run(&arguments),
        #[cfg(feature = "view")]
        Command::View(arguments) => view::run(&arguments),
        Command::Draw(arguments) => draw::run(&arguments),
        #[cfg(feature = "shader")]
        Command::Shader(arguments) => shader::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Doc(arguments) => doc::run(&arguments),
        Command::Manual(arguments) => manual::run(&arguments),
    };
    outcome.unwrap_or_else(|failure| {
        let text = failure.to_string();
        // A pipe that nobody reads any more is no reason to panic.
        let _ = writeln!(std::io::stderr(), "{}", text.trim_end());
        ExitCode::FAILURE
    })
}

/// Prints a result.
fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(relievo_core::Error::new(relievo_core::ErrorKind::Io, error.to_string()).at("standard output"))
        }
        _ => Ok(()),
    }
}

/// A context for commands that only look.
fn context(memory_limit: u64) -> Result<Context> {
    Context::new(&ContextOptions { threads: 0, memory_limit })
}

/// Bytes, with an optional suffix K, M, G or T of powers of 1024.
fn bytes(text: &str) -> std::result::Result<u64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    let power = match text[digits.len()..].to_ascii_uppercase().as_str() {
        "" | "B" => 0,
        "K" | "KB" | "KIB" => 10,
        "M" | "MB" | "MIB" => 20,
        "G" | "GB" | "GIB" => 30,
        "T" | "TB" | "TIB" => 40,
        other => return Err(format!("{other} is no unit of memory; use K, M, G or T")),
    };
    let number: u64 = digits.trim().parse().map_err(|_| format!("{digits:?} is not a whole number"))?;
    number.checked_mul(1 << power).ok_or_else(|| "that is too much".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn bytes_take_suffixes() {
        assert_eq!(bytes("12"), Ok(12));
        assert_eq!(bytes("2G"), Ok(2 << 30));
        assert_eq!(bytes("3 MiB"), Ok(3 << 20));
        assert!(bytes("2X").is_err() && bytes("-1").is_err() && bytes("99999999999T").is_err());
    }
}
