//! `relievo-bench NAME [--json]`: measures Relievo and a peer in the same run and holds the figures against goals.
//! `cargo xtask bench` builds and runs it.

mod contact;
mod imprint;
mod measure;
mod report;
mod shapes;
mod surface;
mod table1;
mod voxels;

use std::process::ExitCode;

use clap::Parser;
use relievo_core::{Error, Result};
use report::Report;

#[derive(Parser)]
#[command(about = "Measures Relievo beside its peers")]
struct Arguments {
    /// Which bench: `surface` or `imprint`
    name: String,
    /// One JSON object per line instead of a table
    #[arg(long)]
    json: bool,
}

fn run(arguments: &Arguments) -> Result<()> {
    let mut report = Report::new(&arguments.name, arguments.json);
    match arguments.name.as_str() {
        "surface" => surface::run(&mut report)?,
        "imprint" => imprint::run(&mut report)?,
        name => return Err(Error::invalid(format!("there is no bench `{name}`")).advise("use `surface` or `imprint`")),
    }
    report.finish();
    Ok(())
}

#[allow(dead_code)]
fn hot() {
    let context = relievo_core::Context::new(&relievo_core::ContextOptions::default()).unwrap();
    let mut near = contact::Contact::new(&context, shapes::terrain(imprint::SIDE), imprint::RADIUS).unwrap();
    let mut object = near.object(&context, 128).unwrap();
    let mut st: std::collections::BTreeMap<String, Vec<f64>> = Default::default();
    for round in 0..std::env::var("ROUNDS").map_or(5, |v| v.parse().unwrap()) {
        if round > 0 { object = near.object(&context, 128).unwrap(); }
        for tile in imprint::terrain_tiles(imprint::SIDE) {
            for again in [false, true] {
                let p = near.press(&context, &mut object, relievo_surface::Place::new(tile, 0.5, 0.5), again).unwrap();
                for (k, v) in &p.stages { st.entry(format!("{again} {k}")).or_default().push(v * 1e3); }
                st.entry(format!("{again} sum")).or_default().push(p.sum * 1e3);
            }
        }
    }
    for (k, mut v) in st { v.sort_by(f64::total_cmp); println!("{k:30} {:.3}  min {:.3}", v[v.len()/2], v[0]); }
    println!("{:?}", near.dims());
}

fn main() -> ExitCode {
    if std::env::var_os("HOT").is_some() { hot(); return ExitCode::SUCCESS; }
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
