//! `relievo farm submit`

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use clap::ValueEnum;
use relievo_core::{Error, ErrorKind, Result, file};
use relievo_simulation::Description;

use super::plan::{Extra, Plan, Product};
use super::{File, SUBMIT, flamenco, opencue, slurm};
use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// What is simulated: a fluid, and what it meets, in TOML, as `relievo fluid sim` reads it.
    description: PathBuf,
    /// The folder for the results, under the same path on all machines: `frames`, `meshes`, `foam`, `pictures`, and `farm`
    /// for the files of the job.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// The farm.
    #[arg(long, value_enum)]
    engine: Engine,
    /// What is made of the frames, separated by commas.
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',', default_value = "mesh,foam,render")]
    make: Vec<Product>,
    /// Frames of a task at most, in stages over frames.
    #[arg(long, value_name = "NUMBER", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    chunk: u32,
    /// Threads of each task, which the farm reserves; 0 for all cores of a machine.
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    threads: u32,
    /// The name of the job; left out, that of the file.
    #[arg(long)]
    name: Option<String>,
    /// The command as the machines of the farm find it.
    #[arg(long, value_name = "PATH", default_value = "relievo")]
    program: String,
    /// More options of `relievo fluid sim`, separated by spaces.
    #[arg(long, value_name = "OPTIONS", allow_hyphen_values = true, default_value = "")]
    simulate_options: String,
    /// More options of `relievo fluid mesh`.
    #[arg(long, value_name = "OPTIONS", allow_hyphen_values = true, default_value = "")]
    mesh_options: String,
    /// More options of `relievo foam generate`.
    #[arg(long, value_name = "OPTIONS", allow_hyphen_values = true, default_value = "")]
    foam_options: String,
    /// More options of `relievo foam render`, or of `relievo fluid render` without foam.
    #[arg(long, value_name = "OPTIONS", allow_hyphen_values = true, default_value = "")]
    render_options: String,
    /// Writes the files of the job without submitting it.
    #[arg(long)]
    write_only: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Engine {
    /// Slurm, by `sbatch`.
    Slurm,
    /// Flamenco 3, by `curl`.
    Flamenco,
    /// OpenCue, by PyOutline.
    Opencue,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let plan = plan(arguments)?;
    let mut files = match arguments.engine {
        Engine::Slurm => slurm::files(&plan),
        Engine::Flamenco => flamenco::files(&plan)?,
        Engine::Opencue => opencue::files(&plan),
    };
    let failed = |error: serde_json::Error| Error::internal(error.to_string());
    files.push(File { name: "plan.json".into(), text: serde_json::to_string_pretty(&plan).map_err(failed)? + "\n" });
    let folder = arguments.output.join("farm");
    std::fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, &error))?;
    for File { name, text } in &files {
        file::store(&folder.join(name), |out| out.write_all(text.as_bytes()))?;
    }
    if arguments.write_only {
        crate::print(&format!(
            "{} files in {}; submit them by `sh {}`\n",
            files.len(),
            folder.display(),
            folder.join(SUBMIT).display()
        ))?;
        return Ok(ExitCode::SUCCESS);
    }
    submit(&folder.join(SUBMIT))?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the job. Fails where the description cannot be read or the name is not one.
fn plan(arguments: &Arguments) -> Result<Plan> {
    let path = absolute(&arguments.description)?;
    let description = Description::read(&arguments.description)?;
    let name = match &arguments.name {
        Some(name) => name.clone(),
        None => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            stem.chars().map(|letter| if is_of_name(letter) { letter } else { '_' }).collect()
        }
    };
    // The engines have this much in common.
    if name.is_empty() || !name.chars().all(is_of_name) {
        return Err(Error::invalid(format!("a job cannot be called {name:?}"))
            .at("--name")
            .advise("use letters of ASCII, digits, _ and -"));
    }
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let extra = Extra {
        simulate: words(&arguments.simulate_options),
        mesh: words(&arguments.mesh_options),
        foam: words(&arguments.foam_options),
        render: words(&arguments.render_options),
    };
    let output = absolute(&arguments.output)?;
    let stages = Plan::stages(&arguments.program, [&path, &output], &arguments.make, arguments.threads, &extra);
    let (chunk, threads) = (arguments.chunk, arguments.threads);
    Ok(Plan { name, first: 0, last: description.frames, chunk, threads, stages })
}

fn is_of_name(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || letter == '_' || letter == '-'
}

/// Returns a path from the root. Fails if it is not UTF-8, which the files of engines are.
fn absolute(path: &Path) -> Result<PathBuf> {
    let whole = std::path::absolute(path).map_err(|error| Error::io(path, &error))?;
    match whole.to_str() {
        Some(_) => Ok(whole),
        None => Err(Error::unsupported("the path is not UTF-8").at(path.display().to_string()).advise("rename it")),
    }
}

/// Runs the script that submits a job, and prints what it says.
fn submit(script: &Path) -> Result<()> {
    let named = |what: String| Error::new(ErrorKind::Io, what).at(script.display().to_string());
    let done = Command::new("sh").arg(script).stderr(Stdio::inherit()).output();
    let done = done.map_err(|error| named(error.to_string()))?;
    crate::print(&String::from_utf8_lossy(&done.stdout))?;
    match done.status.success() {
        true => Ok(()),
        false => Err(named(format!("the job was not submitted: {}", done.status))
            .advise("read what the engine says above; the files of the job stay, and the script may be run again")),
    }
}
