//! `relievo shader mark`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_core::{Error, ErrorKind, error::nearest};

use super::source::sound;
use crate::Outcome;

const EXAMPLE: &str =
    "Example: relievo shader mark volume.wgsl -o marked.wgsl --variable value --variable magnitude --weight alpha";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The shader: .wgsl, .frag, .vert, .comp or .glsl.
    file: PathBuf,
    /// The marked shader to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// A variable of the vector by its name; `NAME@LINE` names the one declared on a line. May be repeated.
    #[arg(long = "variable", value_name = "NAME", required = true)]
    variables: Vec<String>,
    /// The weight of the vector: an expression of the shading language.
    #[arg(long, value_name = "EXPRESSION", default_value = "1.0")]
    weight: String,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let shader = sound!(super::source::read(&arguments.file)?);
    let variables = shader.variables();
    let mut chosen = Vec::with_capacity(arguments.variables.len());
    for wanted in &arguments.variables {
        let (name, at) = match wanted.split_once('@') {
            Some((name, line)) => (name, line.parse::<usize>().ok()),
            None => (wanted.as_str(), None),
        };
        let found = variables.iter().position(|it| it.name == name && at.is_none_or(|at| shader.line(it) == at));
        chosen.push(found.ok_or_else(|| {
            let error = Error::new(ErrorKind::NotFound, format!("the shader has no float variable `{wanted}`"));
            match nearest(name, variables.iter().map(|it| it.name.as_str())) {
                Some(near) => error.advise(format!("did you mean `{near}`?")),
                None => error.advise("list them with `relievo shader check`"),
            }
        })?);
    }
    let marked = sound!(shader.with_vector(&chosen, &arguments.weight));
    super::source::store(&arguments.output, &marked)?;
    let written = sound!(super::source::read(&arguments.output)?);
    sound!(written.augment());
    Ok(ExitCode::SUCCESS)
}
