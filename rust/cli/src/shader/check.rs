//! `relievo shader check`

use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use relievo_shaderlab::{Augmented, Declared, ResourceKind, Shader, Variable};
use serde_json::{Value, json};

use super::source::sound;
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo shader check volume.wgsl";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The shader: .wgsl, .frag, .vert, .comp or .glsl.
    file: PathBuf,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let shader = sound!(super::source::read(&arguments.file)?);
    let is_marked = shader.is_marked();
    let augmented = if is_marked { Some(sound!(shader.augment())) } else { None };
    let refused = shader.wgsl().err().and_then(|faults| faults.list.into_iter().next()).map(|fault| fault.what);
    let text = match arguments.json {
        true => format!("{:#}\n", machine_readable(&shader, augmented.as_ref(), refused.as_deref())),
        false => described(&shader, augmented.as_ref(), refused.as_deref()),
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn kind(kind: &ResourceKind) -> String {
    match kind {
        ResourceKind::Uniforms { fields, .. } => {
            let names: Vec<_> =
                fields.iter().map(|field| format!("{} ({})", field.name, field.offsets.len())).collect();
            format!("uniforms {}", names.join(", "))
        }
        ResourceKind::Storage { is_written: true } => "storage buffer, written".into(),
        ResourceKind::Storage { is_written: false } => "storage buffer".into(),
        ResourceKind::Texture { dimensions } => format!("{dimensions}-D texture"),
        ResourceKind::Target { .. } => "texture, written".into(),
        ResourceKind::Sampler => "sampler".into(),
        ResourceKind::Other(what) => (*what).into(),
    }
}

fn type_name(variable: &Variable) -> String {
    if variable.components == 1 { "float".into() } else { format!("vector of {}", variable.components) }
}

fn declared(variable: &Variable) -> String {
    match (variable.declared, &variable.function) {
        (Declared::Parameter, Some(function)) => format!("parameter of {function}"),
        (Declared::Local, Some(function)) => format!("in {function}"),
        _ => "global".into(),
    }
}

fn described(shader: &Shader, augmented: Option<&Augmented>, refused: Option<&str>) -> String {
    let mut out = String::new();
    if let Some(reason) = refused {
        let _ = writeln!(out, "warning        {reason}");
    }
    for entry in shader.entries() {
        let _ = writeln!(out, "entry point    {} ({})", entry.name, entry.stage.name());
    }
    for resource in shader.resources() {
        let _ = writeln!(
            out,
            "binding {}.{:<4} {}: {}",
            resource.group,
            resource.binding,
            resource.name,
            kind(&resource.kind)
        );
    }
    for variable in shader.variables() {
        let name = variable.label.clone().unwrap_or_else(|| variable.name.clone());
        let line = shader.line(&variable);
        let note = if variable.is_initialized { "" } else { ", without a first value" };
        let _ =
            write!(out, "variable       {name}: {}, line {line}, {}{note}", type_name(&variable), declared(&variable));
        let _ = writeln!(out, "{}", variable.description.map(|it| format!(" - {it}")).unwrap_or_default());
    }
    match augmented {
        None => out.push_str("vectors        none\n"),
        Some(augmented) => {
            let places = match augmented.sites.len() {
                1 => "one place".to_owned(),
                count => format!("{count} places"),
            };
            let names: Vec<_> = augmented.features.iter().map(|feature| feature.name.as_str()).collect();
            let _ = writeln!(
                out,
                "vectors        {} in {}, accumulation {}",
                names.join("; "),
                places,
                augmented.accumulation.name()
            );
        }
    }
    out
}

fn machine_readable(shader: &Shader, augmented: Option<&Augmented>, refused: Option<&str>) -> Value {
    let entries: Vec<_> =
        shader.entries().into_iter().map(|it| json!({ "name": it.name, "stage": it.stage.name() })).collect();
    let resources: Vec<_> = shader
        .resources()
        .iter()
        .map(|it| json!({ "name": it.name, "group": it.group, "binding": it.binding, "kind": kind(&it.kind) }))
        .collect();
    let variables: Vec<_> = shader
        .variables()
        .iter()
        .map(|it| {
            json!({
                "name": it.name,
                "label": it.label,
                "description": it.description,
                "components": it.components,
                "declared": declared(it),
                "line": shader.line(it),
                "bytes": [it.place.start, it.place.end],
                "scope": [it.scope.start, it.scope.end],
                "initialized": it.is_initialized,
            })
        })
        .collect();
    json!({
        "file": shader.source().name,
        "entries": entries,
        "resources": resources,
        "refused": refused,
        "variables": variables,
        "vectors": augmented.map(super::augment::layout),
    })
}
