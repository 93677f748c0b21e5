//! `relievo devices`

use std::process::ExitCode;

use relievo_core::Context;
use relievo_gpu::{AdapterKind, adapters};
use serde_json::json;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
}

fn kind(kind: AdapterKind) -> &'static str {
    match kind {
        AdapterKind::Discrete => "graphics card",
        AdapterKind::Integrated => "integrated",
        AdapterKind::Virtual => "virtual",
        AdapterKind::Software => "the processor",
    }
}

/// Lists what `--device` and `--adapter` of other commands can name, best first.
pub fn run(arguments: &Arguments) -> Outcome {
    let context = Context::new(&Default::default())?;
    let (threads, level) = (context.threads(), context.level().name());
    let graphics = adapters();
    let text = if arguments.json {
        let graphics = graphics.iter().map(|adapter| {
            json!({
                "name": adapter.name,
                "kind": kind(adapter.kind),
                "backend": adapter.backend,
                "driver": adapter.driver,
            })
        });
        format!(
            "{:#}\n",
            json!({ "cpu": { "threads": threads, "instructions": level }, "gpu": graphics.collect::<Vec<_>>() })
        )
    } else {
        let mut text = format!("cpu  {threads} threads, {level}\n");
        for adapter in &graphics {
            text += &format!("gpu  {adapter}: {}\n", kind(adapter.kind));
        }
        if graphics.is_empty() {
            text += "gpu  none: install a Vulkan driver, on Debian `mesa-vulkan-drivers`\n";
        }
        text
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
