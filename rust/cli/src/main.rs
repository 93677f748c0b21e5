//! The `relievo` command: runs scenes, checks them, writes a first one, and looks into files.
//!
//! Results go to standard output, everything else to standard error. Exit codes: 0 done, 1 failed, 2 wrong usage,
//! 3 files that were compared differ by more than allowed, or a mesh that was checked has defects.

mod bar;
mod check;
mod compare;
mod crowd;
#[cfg(feature = "decal")]
mod decal;
mod devices;
mod displaced;
mod doc;
mod draw;
mod edits;
mod export;
mod farm;
mod fluid;
mod foam;
mod grid;
mod groups;
mod import;
mod info;
mod limits;
mod manual;
mod mesh;
mod new;
mod numbers;
mod plot;
mod povray;
mod progressive;
mod run;
mod schema;
#[cfg(feature = "server")]
mod server;
#[cfg(feature = "shader")]
mod shader;
mod simplify;
mod stroke;
mod tessellate;
mod tissue;
mod transfer;
mod triangles;
#[cfg(feature = "view")]
mod view;
mod viewpoint;

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
    /// Runs a scene: physics, imprints, pictures and meshes of its frames.
    Run(run::Arguments),
    /// Writes a commented scene for your own meshes.
    New(new::Arguments),
    /// Reads a scene and its meshes and says what is wrong, without running it.
    Check(check::Arguments),
    /// Prints the format of scene files.
    Schema(schema::Arguments),
    /// Says how much two pictures differ.
    Compare(compare::Arguments),
    /// Says what is in a mesh file, a file of Bézier patches, a Ptex file, a document or particles.
    Info(info::Arguments),
    /// Makes a mesh of Bézier patches.
    Tessellate(tessellate::Arguments),
    /// Makes a mesh of fewer triangles for nearly the same surface.
    Simplify(simplify::Arguments),
    /// Checks and repairs meshes: holes, doubled, twisted and non-manifold faces.
    Mesh(mesh::Arguments),
    /// Lays stickers on meshes, exactly on feature points.
    #[cfg(feature = "decal")]
    Decal(decal::Arguments),
    /// Builds, draws and reports crowds of articulated models at the detail that their pixels deserve.
    Crowd(crowd::Arguments),
    /// Builds progressive meshes, and takes meshes of any level from them.
    Progressive(progressive::Arguments),
    /// Simulates fluids of particles, and makes meshes of their surfaces.
    Fluid(fluid::Arguments),
    /// Makes spray, foam and bubbles of a fluid's frames, and renders them over pictures.
    Foam(foam::Arguments),
    /// Makes finite-element models of soft tissue from surfaces, and simulates them.
    Tissue(tissue::Arguments),
    /// Lists, converts, meshes and combines OpenVDB's sparse grids: level sets, fog, masks, labels.
    Grid(grid::Arguments),
    /// Simulates for other programs and machines, until it is asked to stop.
    #[cfg(feature = "server")]
    Serve(server::serve::Arguments),
    /// Sends a fluid to a server, which simulates it in the background.
    #[cfg(feature = "server")]
    Submit(server::submit::Arguments),
    /// Says what the scenes on a server are doing.
    #[cfg(feature = "server")]
    Status(server::status::Arguments),
    /// Shows the progress of a scene on a server until it is done.
    #[cfg(feature = "server")]
    Watch(server::watch::Arguments),
    /// Fetches frames from a server, also while later ones are computed.
    #[cfg(feature = "server")]
    Fetch(server::fetch::Arguments),
    /// Changes a scene on a server from a frame on.
    #[cfg(feature = "server")]
    Steer(server::steer::Arguments),
    /// Pauses, resumes, cancels or removes a scene on a server.
    #[cfg(feature = "server")]
    Control(server::control::Arguments),
    /// Lists, checks, shrinks and exports the cache of a server.
    #[cfg(feature = "server")]
    Cache(server::cache::Arguments),
    /// Writes and submits jobs of render farms: a simulation, then meshes, foam and pictures in parallel.
    Farm(farm::Arguments),
    /// Plots how a simulation of a fluid went, from its statistics.
    Plot(plot::Arguments),
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
    /// Replays a list of strokes on a mesh, or on a document of it.
    Stroke(stroke::Arguments),
    /// Looks after documents.
    Doc(doc::Arguments),
    /// Writes scenes for other programs.
    Export(povray::Arguments),
    /// Writes the manual pages of all commands.
    #[command(hide = true)]
    Manual(manual::Arguments),
}

/// What a command ends with.
type Outcome = std::result::Result<ExitCode, Failure>;

fn main() -> ExitCode {
    relievo_gpu::quiet_drivers();
    let matches = groups::grouped(Arguments::command()).get_matches();
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let outcome = match arguments.command {
        Command::Run(arguments) => run::run(&arguments),
        Command::New(arguments) => new::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Schema(arguments) => schema::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Info(arguments) => info::run(&arguments),
        Command::Tessellate(arguments) => tessellate::run(&arguments),
        Command::Simplify(arguments) => simplify::run(&arguments),
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
        Command::Serve(arguments) => server::serve::run(&arguments),
        #[cfg(feature = "server")]
        Command::Submit(arguments) => server::submit::run(&arguments),
        #[cfg(feature = "server")]
        Command::Status(arguments) => server::status::run(&arguments),
        #[cfg(feature = "server")]
        Command::Watch(arguments) => server::watch::run(&arguments),
        #[cfg(feature = "server")]
        Command::Fetch(arguments) => server::fetch::run(&arguments),
        #[cfg(feature = "server")]
        Command::Steer(arguments) => server::steer::run(&arguments),
        #[cfg(feature = "server")]
        Command::Control(arguments) => server::control::run(&arguments),
        #[cfg(feature = "server")]
        Command::Cache(arguments) => server::cache::run(&arguments),
        Command::Farm(arguments) => farm::run(&arguments),
        Command::Plot(arguments) => plot::run(&arguments),
        #[cfg(feature = "view")]
        Command::View(arguments) => view::run(&arguments),
        Command::Draw(arguments) => draw::run(&arguments),
        #[cfg(feature = "shader")]
        Command::Shader(arguments) => shader::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Stroke(arguments) => stroke::run(&arguments),
        Command::Doc(arguments) => doc::run(&arguments),
        Command::Export(arguments) => povray::run(&arguments),
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
