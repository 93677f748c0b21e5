//! Project files: a shader with its inputs and classified pixels, as TOML that people can read, edit and compare.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use relievo_core::{Error, Result};
use serde::{Deserialize, Serialize};

use crate::classes::{Class, EXPONENT};

/// Bytes that a project file may have.
const MAX_BYTES: u64 = 16 << 20;

/// A texture that a shader is given.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// The name of the texture in the shader.
    pub name: String,
    /// The file: an image (PNG, EXR) or a volume (NIfTI, OpenVDB), relative to the project.
    pub file: PathBuf,
}

/// A pixel with its class.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Classified {
    /// Column and row, from the upper left corner.
    pub pixel: [u32; 2],
    /// Its class.
    pub class: Class,
}

/// A project.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Project {
    /// The version of the format, 1.
    pub version: u32,
    /// The file of the shader, relative to the project.
    pub shader: PathBuf,
    /// The file of the vertex shader that belongs to a fragment shader, relative to the project.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertex: Option<PathBuf>,
    /// The vertices to draw; left out, as many as the inputs of the vertex shader have, or 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertices: Option<u32>,
    /// How often they are drawn, with another `instance_index`; left out, once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instances: Option<u32>,
    /// The entry point; left out, the only one that draws or computes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entry: Option<String>,
    /// Pixels in a row, and rows.
    pub size: [u32; 2],
    /// The exponent of the membership.
    #[serde(default = "exponent")]
    pub exponent: f32,
    /// Whether features are scaled by their ranges.
    #[serde(default)]
    pub scaled: bool,
    /// Numbers of uniforms and of the inputs of vertex shaders by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, Vec<f64>>,
    /// Textures.
    #[serde(default, rename = "input", skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<Input>,
    /// Classified pixels.
    #[serde(default, rename = "example", skip_serializing_if = "Vec::is_empty")]
    pub examples: Vec<Classified>,
}

fn exponent() -> f32 {
    EXPONENT
}

impl Project {
    /// Reads a project of its text.
    ///
    /// # Errors
    /// Fails if the text is no TOML of a project, with the line where it is faulty, if the version is another one, or
    /// if the picture has no pixels.
    pub fn parse(text: &str) -> Result<Self> {
        let project: Self = toml::from_str(text).map_err(|error| {
            let line = error.span().map(|span| text[..span.start.min(text.len())].matches('\n').count() + 1);
            let refused = Error::invalid(error.message().to_owned());
            match line {
                Some(line) => refused.at(format!("line {line}")),
                None => refused,
            }
        })?;
        if project.version != 1 {
            return Err(Error::unsupported(format!("the project has version {}", project.version))
                .advise("open it with a newer Relievo"));
        }
        if project.size.contains(&0) {
            return Err(Error::invalid("the picture has no pixels").at("size").advise("use at least 1 by 1"));
        }
        Ok(project)
    }

    /// Reads a project; paths in it become relative to the folder of the process.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is larger than 16 MiB or no UTF-8, or as [`Self::parse`] does.
    pub fn read(path: &Path) -> Result<Self> {
        let place = path.display().to_string();
        let bytes = relievo_core::file::load(path, MAX_BYTES)?;
        let text = String::from_utf8(bytes).map_err(|_| Error::invalid("the file is no UTF-8").at(&*place))?;
        let mut project = Self::parse(&text).map_err(|error| error.at(place))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        project.shader = folder.join(&project.shader);
        project.vertex = project.vertex.map(|vertex| folder.join(vertex));
        for input in &mut project.inputs {
            input.file = folder.join(&input.file);
        }
        Ok(project)
    }

    /// Writes a project whose paths are relative to the folder of the process. Comments before the first line of a file
    /// that is there already stay.
    ///
    /// # Errors
    /// Fails if the file that is there cannot be read or the new one cannot be written; it appears whole or not at all.
    pub fn write(&self, path: &Path) -> Result<()> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let relative = |path: &Path| path.strip_prefix(folder).map_or_else(|_| path.to_owned(), Path::to_owned);
        let mut project = self.clone();
        project.shader = relative(&project.shader);
        project.vertex = project.vertex.as_deref().map(relative);
        for input in &mut project.inputs {
            input.file = relative(&input.file);
        }
        let mut text = String::new();
        if path.exists() {
            let bytes = relievo_core::file::load(path, MAX_BYTES)?;
            let before = String::from_utf8_lossy(&bytes).into_owned();
            for line in before.lines().take_while(|line| line.starts_with('#')) {
                let _ = writeln!(text, "{line}");
            }
        }
        text += &toml::to_string(&project).map_err(|error| Error::internal(error.to_string()))?;
        relievo_core::file::store(path, |file| file.write_all(text.as_bytes()))
    }

    /// Appends classified pixels to a project file and leaves the rest of its text alone.
    ///
    /// # Errors
    /// Fails, and does not change the file, if it cannot be read, is larger than 16 MiB, no UTF-8 or no project, or
    /// cannot be written.
    pub fn append(path: &Path, examples: &[Classified]) -> Result<()> {
        let place = path.display().to_string();
        let bytes = relievo_core::file::load(path, MAX_BYTES)?;
        let mut text = String::from_utf8(bytes).map_err(|_| Error::invalid("the file is no UTF-8").at(&*place))?;
        if !text.is_empty() && !text.ends_with('\n') {
            text.push('\n');
        }
        for Classified { pixel: [x, y], class } in examples {
            let class = match class {
                Class::Positive => "positive",
                Class::Negative => "negative",
            };
            let _ = write!(text, "\n[[example]]\npixel = [{x}, {y}]\nclass = \"{class}\"\n");
        }
        Self::parse(&text).map_err(|error| error.at(place))?;
        relievo_core::file::store(path, |file| file.write_all(text.as_bytes()))
    }
}
