//! `relievo shader view`

use std::path::PathBuf;
use std::process::ExitCode;

use relievo_view::Script;
use relievo_view::shader::{Opening, Session};

use super::opened::{Begun, Options};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo shader view volume.toml

A click with the left button makes a pixel a positive example, with the right button a negative one; the middle button asks
why a pixel has its membership; Shift and a click remove an example. S saves. The text is compiled while it is edited.

Acts of a script, one a line: click X Y, right_click X Y, ask X Y, press NAME (a button, a tab, or a variable as NAME@LINE),
drag A B X0 Y0 X1 Y1 (a brush over the plot of two features, in shares of it), key NAME, type TEXT, text FILE,
wait_frames N, screenshot FILE, quit";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    options: Options,
    /// Play the acts of a file, as a mouse and a keyboard would do them, and close the window.
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let options = &arguments.options;
    let script = arguments.script.as_deref().map(Script::read).transpose()?;
    let Begun { project, inputs, size, device } = options.begin()?;
    let file = options.is_project().then(|| options.file.clone());
    relievo_view::shader::run(Session::open(Opening { device, project, file, inputs, size })?, script)?;
    Ok(ExitCode::SUCCESS)
}
