//! `relievo decal info`

use std::process::ExitCode;

use super::common::Common;
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo decal info bottle.obj --size 400x300 --pin 10,10@-0.3,1,0.5 \
    --pin 390,10@0.3,1,0.5 --pin 200,290@0,0.2,0.6 --picture heat.png --show heat";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let common = &arguments.common;
    let laid = common.lay()?;
    common.draw(&laid, &[])?;
    let quality = &laid.decal.quality;
    let text = match common.json {
        true => format!("{:#}\n", super::common::machine_readable(common, &laid)),
        false => format!("{}\n{}", common.place(), super::common::described(quality)),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
