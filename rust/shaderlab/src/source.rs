//! Shaders as their authors wrote them: text, language and stage.

use std::path::Path;
use std::sync::Arc;

use relievo_core::{Error, Result};

use crate::fault::{Span, clip};

/// Bytes that the text of a shader may have.
pub const MAX_BYTES: usize = 1 << 20;

/// A shading language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Language {
    /// The OpenGL shading language, any version; versions before 4.40 are rewritten.
    Glsl,
    /// The WebGPU shading language.
    Wgsl,
}

/// A stage of the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Vertices.
    Vertex,
    /// Pixels.
    Fragment,
    /// Invocations of a grid.
    Compute,
}

impl Stage {
    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Fragment => "fragment",
            Self::Compute => "compute",
        }
    }

    /// Returns the stage of naga.
    pub(crate) fn naga(self) -> naga::ShaderStage {
        match self {
            Self::Vertex => naga::ShaderStage::Vertex,
            Self::Fragment => naga::ShaderStage::Fragment,
            Self::Compute => naga::ShaderStage::Compute,
        }
    }
}

/// The text of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The name that messages show: usually the path of the file.
    pub name: String,
    /// The text.
    pub text: Arc<str>,
    /// Its language.
    pub language: Language,
    /// The stage of a GLSL shader. A WGSL shader names the stages of its entry points itself.
    pub stage: Stage,
}

impl Source {
    /// Makes a source of a text.
    pub fn new(name: impl Into<String>, text: impl Into<Arc<str>>, language: Language, stage: Stage) -> Self {
        Self { name: name.into(), text: text.into(), language, stage }
    }

    /// Reads a shader. Its language and stage follow from the ending of the name: `.wgsl`; `.frag`, `.vert` or `.comp` for
    /// GLSL; `.glsl` for a fragment shader unless `.vert` or `.comp` stands before it.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is larger than [`MAX_BYTES`], is no UTF-8, or has another ending.
    pub fn read(path: &Path) -> Result<Self> {
        let place = path.display().to_string();
        let bytes = relievo_core::file::load(path, MAX_BYTES as u64)?;
        let text = String::from_utf8(bytes).map_err(|error| {
            Error::invalid(format!("byte {} is no UTF-8", error.utf8_error().valid_up_to()))
                .at(&*place)
                .advise("save the shader as UTF-8")
        })?;
        let (language, stage) = Self::kind_of(path).ok_or_else(|| {
            Error::unsupported("the language of the shader is unknown")
                .at(&*place)
                .advise("name it .wgsl, .frag, .vert, .comp or .glsl")
        })?;
        Ok(Self::new(place, text, language, stage))
    }

    /// Returns line and column of the start of a span, counted from 1 in characters.
    pub fn place(&self, span: &Span) -> (usize, usize) {
        let before = &self.text[..clip(&self.text, span).start];
        let line = before.rfind('\n').map_or(0, |at| at + 1);
        (before.matches('\n').count() + 1, before[line..].chars().count() + 1)
    }

    /// Returns the language and the stage that the ending of a file name stands for.
    pub fn kind_of(path: &Path) -> Option<(Language, Stage)> {
        let ending = |path: &Path| path.extension().and_then(|it| it.to_str()).map(str::to_ascii_lowercase);
        let stage = |ending: &str| match ending {
            "vert" | "vs" => Some(Stage::Vertex),
            "frag" | "fs" => Some(Stage::Fragment),
            "comp" | "cs" => Some(Stage::Compute),
            _ => None,
        };
        match ending(path)?.as_str() {
            "wgsl" => Some((Language::Wgsl, Stage::Fragment)),
            "glsl" => {
                let before = path.file_stem().map(Path::new).and_then(ending);
                Some((Language::Glsl, before.and_then(|it| stage(&it)).unwrap_or(Stage::Fragment)))
            }
            other => Some((Language::Glsl, stage(other)?)),
        }
    }
}
