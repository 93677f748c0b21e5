//! What a contributor types: `cargo xtask setup`, `demo`, `test`, `bench`, and what makes packages and pages.

mod bench;
mod bindings;
mod blender;
mod comparison;
mod demo;
mod dist;
mod files;
mod fuzz;
mod licences;
mod module;
mod mutants;
mod packages;
mod paths;
mod peers;
mod platforms;
mod release;
mod sbom;
mod stage;
mod suite;
mod usd;
mod wheel;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::platforms::Platform;

#[derive(Parser)]
#[command(name = "cargo xtask", about = "Builds, tests, shows and measures Relievo", disable_help_subcommand = true)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Installs the Debian packages that building and testing need
    Setup {
        /// Installs without asking
        #[arg(long)]
        yes: bool,
    },
    /// Sets up, builds, and runs the shipped scene: pictures, mesh, tiles and a table of costs
    Demo {
        /// Installs missing packages without asking
        #[arg(long)]
        yes: bool,
        /// What makes imprints and pictures, as of `relievo scene run`: `cpu`, `gpu` or `auto`
        #[arg(long, default_value = "cpu")]
        device: String,
    },
    /// Sets up, builds, and runs every test: Rust, C and C++ hosts, Valgrind, fuzz targets
    Test {
        /// Installs missing packages without asking
        #[arg(long)]
        yes: bool,
    },
    /// Runs fuzz targets with a fresh seed, all of them or those named
    Fuzz {
        /// Targets, as the files of `tests/fuzz/src/bin` are called
        names: Vec<String>,
        /// Seconds each target runs
        #[arg(long, default_value_t = 60)]
        seconds: u32,
    },
    /// Builds the module over OpenVDB, which programs and tests open on demand
    Module,
    /// Builds the Python package as wheels that carry the library and all that it needs
    Wheel,
    /// Makes the Blender extension and the add-on for Blender 3.4, with the library
    Blender {
        /// Runs the tests of both and of the Python package too
        #[arg(long)]
        test: bool,
        /// Does the five first tasks of `docs/tasks.md` in a window and renews their pictures
        #[arg(long, conflicts_with = "test")]
        tasks: bool,
    },
    /// Does the five first tasks of `docs/tasks.md` in `relievo view` and renews their pictures
    Window,
    /// Renders scenes in our ray caster, in Cycles and in POV-Ray, and compares what is seen
    Comparison {
        /// Writes the contact sheet to this PNG file
        #[arg(long, value_name = "FILE")]
        sheet: Option<PathBuf>,
    },
    /// Tests USD against OpenUSD and Blender
    Usd,
    /// Writes the declarations that are made from C headers
    Bindings {
        /// Compares them with the headers and writes none
        #[arg(long)]
        check: bool,
    },
    /// Writes a page for each header of the C ABI, and fails where something is undocumented
    Docs,
    /// Makes the archives and the Debian packages, and the zip files for Blender
    Dist {
        /// Uses each of them too, where nothing else of ours is
        #[arg(long)]
        test: bool,
    },
    /// Makes and checks all files of a release: packages, wheel, zip files for Blender, notices, list of what is linked, sums
    Release {
        /// Publishes nothing, which is all that there is
        #[arg(long, required = true)]
        dry_run: bool,
    },
    /// Changes code at drawn places and counts the changes that tests notice; goes on where it was stopped
    Mutants {
        /// Crates to draw from: `tiles`, `detail`, `lod`, `fluid`, `document`, which are the usual ones, or `ptex`
        names: Vec<String>,
        /// How many mutants are drawn
        #[arg(long, default_value_t = 200)]
        count: usize,
        /// What they are drawn by
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Builds for Linux on AArch64, Windows and macOS, and runs tests in qemu and Wine
    Platforms {
        /// Which of them; all where none is named
        names: Vec<Platform>,
        /// Installs missing packages without asking
        #[arg(long)]
        yes: bool,
    },
    /// Writes the licences of the crates that are linked
    Notices {
        /// The file
        file: PathBuf,
    },
    /// Measures, beside a peer in the same run, and holds the figures against their goals
    Bench {
        /// Which bench: `surface`, `imprint`, `paint`, `gpu`, `lod`, `fluid`, `pictures` (a part of that), `native` or
        /// `hosts`
        name: String,
        /// One JSON object per line instead of a table
        #[arg(long)]
        json: bool,
    },
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().task {
        Task::Setup { yes } => packages::install(packages::ALL, yes),
        Task::Demo { yes, device } => demo::run(yes, &device),
        Task::Test { yes } => suite::run(yes),
        Task::Fuzz { names, seconds } => fuzz::build().and_then(|()| fuzz::run(&names, seconds, None)),
        Task::Module => module::run(),
        Task::Wheel => wheel::run(),
        Task::Comparison { sheet } => comparison::run(sheet.as_deref()),
        Task::Usd => usd::run(),
        Task::Bindings { check } => bindings::run(check),
        Task::Docs => bindings::pages(),
        Task::Dist { test } => dist::run(test),
        Task::Release { .. } => release::run(),
        Task::Platforms { names, yes } => platforms::run(&names, yes),
        Task::Notices { file } => licences::write(&file),
        Task::Mutants { names, count, seed } => mutants::run(&names, count, seed),
        Task::Window => suite::window(),
        Task::Blender { tasks: true, .. } => blender::tasks(),
        Task::Blender { test, .. } => blender::run(test),
        Task::Bench { name, json } => bench::run(&name, json),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
