//! `relievo farm`: simulations as jobs of a render farm.

mod flamenco;
mod opencue;
mod plan;
mod slurm;
mod submit;

use clap::Subcommand;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Writes and submits a job: a simulation, then meshes, foam and pictures of its frames in parallel.
    #[command(after_help = "Example: relievo farm submit examples/fluids/dam.toml -o /shared/dam --engine slurm")]
    Submit(submit::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Submit(arguments) => submit::run(arguments),
    }
}

/// A file that an engine reads.
struct File {
    name: String,
    text: String,
}

/// The file that submits a job.
const SUBMIT: &str = "submit.sh";

/// Returns a word that a shell takes as `text`.
fn quoted(text: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"_-./=:,+@%".contains(&byte);
    match !text.is_empty() && text.bytes().all(is_plain) {
        true => text.to_owned(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_shell_are_quoted_where_they_need_it() {
        assert_eq!(quoted("--frames=0..9"), "--frames=0..9");
        assert_eq!(quoted("it's $HOME"), r"'it'\''s $HOME'");
        assert_eq!(quoted(""), "''");
    }
}
