//! `relievo mesh check`

use std::process::ExitCode;

use super::report::{self, Common};
use crate::Outcome;
use crate::bar::Bar;

const EXAMPLE: &str = "Example: relievo mesh check scan.ply\n\n\
    Ends with 0 if the mesh is a closed, oriented manifold without degenerate or doubled faces, with 3 if it is not, \
    and with 1 if it cannot be read. Points that would be welded or dropped, and faces without area, are reported and \
    count as no defect.";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Let holes count as no defect.
    #[arg(long)]
    open: bool,
}

/// The exit code for a mesh with defects.
const DEFECTS: u8 = 3;

pub fn run(arguments: &Arguments) -> Outcome {
    let common = &arguments.common;
    let (context, mesh) = common.read()?;
    let report = relievo_repair::check(&context, &mesh, &common.settings(), &mut Bar::new())
        .map_err(|error| error.at(common.place()))?;
    let text = match common.json {
        true => format!("{:#}\n", report::machine_readable(&common.file, &report)),
        false => format!("{}\n{}\n{}", common.place(), report::described(&report.before), report::defects(&report)),
    };
    crate::print(&text)?;
    let mut judged = report;
    if arguments.open {
        judged.holes.count = 0;
    }
    Ok(if judged.is_solid() { ExitCode::SUCCESS } else { ExitCode::from(DEFECTS) })
}
