//! `relievo scene new`

use std::path::{Component, Path, PathBuf};
use std::process::ExitCode;

use glam::DAffine3;
use relievo_core::{Error, Mesh};
use relievo_scene::description::Up;
use relievo_scene::starter::{Entry, starter};

use crate::Outcome;

/// Axes that may point up.
const AXES: [&str; 3] = ["x", "y", "z"];

#[derive(clap::Args)]
pub struct Arguments {
    /// Mesh files: the first takes dents, the others make them.
    #[arg(required = true)]
    meshes: Vec<PathBuf>,
    /// Where to write the scene; without it, it is printed.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// The axis that points up.
    #[arg(long, value_parser = AXES, default_value = "y")]
    up: String,
    /// Replace an existing scene.
    #[arg(long)]
    force: bool,
    /// Bytes that files and what is made of them may occupy, with K, M or G; 0 for no limit.
    #[arg(long, value_name = "BYTES", value_parser = crate::bytes, default_value = "8G")]
    memory_limit: u64,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = crate::context(arguments.memory_limit)?;
    let mut meshes: Vec<Mesh> = Vec::new();
    for path in &arguments.meshes {
        let place = |error: Error| error.at(path.display().to_string());
        let mut model = relievo_meshio::read_model(&context, path)?;
        if model.is_converted {
            let up = [Up::X, Up::Y, Up::Z].into_iter().zip(AXES).find(|(_, axis)| *axis == arguments.up);
            model.place(DAffine3::from_mat3(up.map_or(Up::Y, |(up, _)| up).from_y_up()));
        }
        let mesh = model.into_merged_mesh(&context).map_err(place)?;
        mesh.check().map_err(place)?;
        meshes.push(mesh);
    }
    let folder = arguments.output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let mut entries = Vec::new();
    let mut outside = Vec::new();
    for (path, mesh) in arguments.meshes.iter().zip(&meshes) {
        let written = relative(path, folder)?;
        if written.starts_with("..") || Path::new(&written).is_absolute() {
            outside.push(path);
        }
        entries.push(Entry { path: written, mesh });
    }
    let up = AXES.iter().position(|axis| *axis == arguments.up).unwrap_or(1);
    let text = starter(&context, &entries, up)?;
    let mut allowed: Vec<String> = Vec::new();
    for path in outside {
        let option = format!(" --allow-path {}", path.parent().unwrap_or(path).display());
        eprintln!("note: {} lies outside the scene's folder; run with{option}", path.display());
        if !allowed.contains(&option) {
            allowed.push(option);
        }
    }
    match &arguments.output {
        None => crate::print(&text)?,
        Some(path) if path.exists() && !arguments.force => {
            return Err(Error::invalid("the file exists")
                .at(path.display().to_string())
                .advise("choose another name, or replace it with --force")
                .into());
        }
        Some(path) => {
            relievo_core::file::store(path, |out| std::io::Write::write_all(out, text.as_bytes()))?;
            eprintln!(
                "wrote {}; run it with `relievo scene run {}{}`",
                path.display(),
                path.display(),
                allowed.concat()
            );
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// `path` as seen from `folder`, with `/` between its parts.
fn relative(path: &Path, folder: &Path) -> Result<String, Error> {
    let real = |path: &Path| {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        path.canonicalize().map_err(|error| Error::io(path, &error))
    };
    let (path, folder) = (real(path)?, real(folder)?);
    let shared = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    let parts: Vec<String> =
        up.chain(path.components().skip(shared)).map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
    Ok(parts.join("/"))
}
