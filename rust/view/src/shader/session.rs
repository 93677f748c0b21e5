//! What a window explores: a shader with its inputs, its examples and their feature vectors.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use relievo_core::{Error, Result};
use relievo_gpu::Device;
use relievo_render::Image;
use relievo_shaderlab::{
    Augmented, Class, Classes, Classified, Diagnosis, Example, Explanation, Faults, Inputs, Log, Program, Project,
    Runner, Setting, Shader, Source, Textures, Value,
};

/// What a session begins with.
#[derive(Debug)]
pub struct Opening {
    /// The graphics device.
    pub device: Device,
    /// The project; its paths are relative to the folder of the process.
    pub project: Project,
    /// The file of the project, where there is one.
    pub file: Option<PathBuf>,
    /// Textures and numbers of the shader.
    pub inputs: Inputs,
    /// Columns and rows of the picture.
    pub size: [u32; 2],
}

/// A fault of the text: its line, counted from 1, and what it says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Note {
    pub line: usize,
    pub what: String,
}

/// A shader that was accepted and runs.
struct Compiled {
    shader: Shader,
    /// The vertex shader of another text.
    vertex: Option<Shader>,
    /// The shader that takes vectors.
    augmented: Option<Augmented>,
    runner: Runner,
}

/// A pixel that was asked about.
pub(crate) struct Asked {
    pub pixel: [u32; 2],
    pub log: Log,
    pub explanation: Explanation,
}

/// The values of the float variables at a pixel, in the order of the variables.
pub(crate) struct Values {
    pub pixel: [u32; 2],
    pub list: Vec<Result<Value>>,
}

/// An exploration of a shader.
pub struct Session {
    opening: Opening,
    /// The textures on the device, which do not change with the text.
    textures: Textures,
    /// The text of the shader as it is edited.
    pub(crate) text: String,
    /// The text that was saved last.
    saved: String,
    compiled: Option<Compiled>,
    /// Faults of the text that was compiled last. The picture is then that of the last text without any.
    pub(crate) notes: Vec<Note>,
    /// What went wrong last, apart from the text.
    pub(crate) message: Option<String>,
    classes: Option<Classes>,
    /// The vectors that the pixel of each example took.
    pub(crate) logs: Vec<Log>,
    pub(crate) asked: Option<Asked>,
    pub(crate) values: Option<Values>,
    /// What [`Diagnosis::of`] says of the classes.
    pub(crate) diagnosis: Option<Diagnosis>,
    picture: Option<Image>,
    is_changed: bool,
}

impl std::fmt::Debug for Session {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Session").field("shader", &self.opening.project.shader).finish_non_exhaustive()
    }
}

impl Session {
    /// Opens a session. A shader that is refused is no failure: its faults are shown beside its text.
    ///
    /// # Errors
    /// Fails if the file of the shader cannot be read or its language is unknown.
    pub fn open(opening: Opening) -> Result<Self> {
        let text = Source::read(&opening.project.shader)?.text.to_string();
        let saved = text.clone();
        let mut session = Self {
            opening,
            textures: Textures::default(),
            text,
            saved,
            compiled: None,
            notes: Vec::new(),
            message: None,
            classes: None,
            logs: Vec::new(),
            asked: None,
            values: None,
            diagnosis: None,
            picture: None,
            is_changed: false,
        };
        session.compile();
        Ok(session)
    }

    /// Returns columns and rows of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.opening.size
    }

    /// Returns the classes, if the shader takes vectors.
    pub fn classes(&self) -> Option<&Classes> {
        self.classes.as_ref()
    }

    /// Returns the examples of the project.
    pub fn examples(&self) -> &[Classified] {
        &self.opening.project.examples
    }

    /// Returns the names of the features.
    pub(crate) fn features(&self) -> Vec<String> {
        let augmented = self.compiled.as_ref().and_then(|compiled| compiled.augmented.as_ref());
        augmented.map_or(Vec::new(), |it| it.features.iter().map(|feature| feature.name.clone()).collect())
    }

    /// Returns the shader that runs.
    pub(crate) fn shader(&self) -> Option<&Shader> {
        self.compiled.as_ref().map(|compiled| &compiled.shader)
    }

    /// Returns whether something is not saved.
    pub fn is_changed(&self) -> bool {
        self.is_changed || self.text != self.saved
    }

    /// Compiles the text. Where it has faults, the last shader and its picture stay.
    pub fn compile(&mut self) {
        match self.compiled_text() {
            Ok(Ok(compiled)) => {
                self.notes.clear();
                self.message = None;
                self.compiled = Some(compiled);
                self.asked = None;
                self.values = None;
                self.take_vectors();
                self.explain();
                self.draw();
            }
            Ok(Err(faults)) => {
                let note = |fault: &relievo_shaderlab::Fault| {
                    let advice = if fault.remedy.is_empty() { String::new() } else { format!(": {}", fault.remedy) };
                    Note { line: faults.place(&fault.span).0, what: format!("{}{advice}", fault.what) }
                };
                self.notes = faults.list.iter().map(note).collect();
            }
            Err(error) => self.message = Some(error.to_string()),
        }
    }

    fn compiled_text(&mut self) -> Result<std::result::Result<Compiled, Faults>> {
        let Opening { device, project, inputs, size, .. } = &self.opening;
        let (language, stage) = Source::kind_of(&project.shader)
            .ok_or_else(|| Error::unsupported("the language of the shader is unknown"))?;
        let source = Source::new(project.shader.display().to_string(), self.text.as_str(), language, stage);
        // The text of the vertex shader is not shown here: its faults are a message.
        let vertex = project.vertex.as_deref().map(Source::read).transpose()?.map(Shader::new).transpose()?;
        let of_vertices = vertex.as_ref().filter(|vertex| vertex.is_marked()).map(Shader::augment).transpose()?;
        let prepared = || -> std::result::Result<_, Faults> {
            let shader = Shader::new(source)?;
            let augmented = if shader.is_marked() { Some(shader.augment()?) } else { None };
            let program = match &augmented {
                Some(augmented) => Program::augmented(&shader, augmented)?,
                None => Program::plain(&shader)?,
            };
            Ok((shader, augmented, program))
        };
        let (shader, augmented, program) = match prepared() {
            Ok(prepared) => prepared,
            Err(faults) => return Ok(Err(faults)),
        };
        let program = match &vertex {
            Some(vertex) => program.with_vertex(vertex, of_vertices.as_ref())?,
            None => program,
        };
        let entry = project.entry.as_deref();
        let runner = Runner::sharing(device, &program, entry, *size, inputs, &mut self.textures)?;
        let augmented = augmented.or(of_vertices);
        Ok(Ok(Compiled { shader, vertex, augmented, runner }))
    }

    /// Takes the vectors of all examples anew. Examples without a vector leave the classes, and a message says so.
    fn take_vectors(&mut self) {
        self.logs.clear();
        self.classes = None;
        let Some(Compiled { augmented: Some(augmented), runner, .. }) = &self.compiled else { return };
        let plain = Classes::of(augmented);
        let mut classes = plain.clone();
        classes.exponent = self.opening.project.exponent;
        classes.is_scaled = self.opening.project.scaled;
        for Classified { pixel, class } in &self.opening.project.examples {
            match runner.classify(&plain, *pixel) {
                Ok(log) => {
                    classes.examples.push(Example { pixel: *pixel, class: *class, vector: log.vector.clone() });
                    self.logs.push(log);
                }
                Err(error) => self.message = Some(error.to_string()),
            }
        }
        self.classes = Some(classes);
    }

    /// Draws the picture with the classes there are now. Nothing is compiled.
    fn draw(&mut self) {
        let Some(compiled) = &self.compiled else { return };
        match compiled.runner.picture(self.classes.as_ref()) {
            Ok(picture) => self.picture = Some(picture),
            Err(error) => self.message = Some(error.to_string()),
        }
    }

    /// Returns the picture drawn last.
    pub fn picture(&self) -> Option<&Image> {
        self.picture.as_ref()
    }

    /// Makes a pixel an example of a class, in place of an example that it was, and draws the picture anew.
    ///
    /// # Errors
    /// Fails if the shader takes no vector there, there are as many examples as there may be, or the device is lost or
    /// has no memory; then nothing changes.
    pub fn classify(&mut self, pixel: [u32; 2], class: Class) -> Result<()> {
        let log = self.log(pixel)?;
        let Some(classes) = &self.classes else { return Ok(()) };
        let mut classes = classes.clone();
        classes.examples.retain(|example| example.pixel != pixel);
        classes.examples.push(Example { pixel, class, vector: log.vector.clone() });
        classes.check()?;
        self.forget(pixel);
        self.classes = Some(classes);
        self.logs.push(log);
        self.opening.project.examples.push(Classified { pixel, class });
        self.is_changed = true;
        self.explain();
        self.draw();
        Ok(())
    }

    fn forget(&mut self, pixel: [u32; 2]) {
        if let Some(classes) = &mut self.classes
            && let Some(index) = classes.examples.iter().position(|example| example.pixel == pixel)
        {
            classes.examples.remove(index);
            self.logs.remove(index);
        }
        self.opening.project.examples.retain(|example| example.pixel != pixel);
    }

    /// Removes the example at a pixel and draws the picture anew.
    pub fn remove(&mut self, pixel: [u32; 2]) {
        self.forget(pixel);
        self.is_changed = true;
        self.explain();
        self.draw();
    }

    /// Sets the exponent of the membership and whether features are scaled, and draws the picture anew.
    pub fn weigh(&mut self, exponent: f32, is_scaled: bool) {
        self.opening.project.exponent = exponent;
        self.opening.project.scaled = is_scaled;
        if let Some(classes) = &mut self.classes {
            classes.exponent = exponent;
            classes.is_scaled = is_scaled;
        }
        self.is_changed = true;
        self.explain();
        self.draw();
    }

    fn log(&self, pixel: [u32; 2]) -> Result<Log> {
        let refused = || Error::invalid("the shader takes no vector").advise("choose variables and write a vector");
        let compiled = self.compiled.as_ref().ok_or_else(refused)?;
        let augmented = compiled.augmented.as_ref().ok_or_else(refused)?;
        // Vectors are taken of the picture without examples, so that their order does not matter.
        compiled.runner.classify(&Classes::of(augmented), pixel)
    }

    /// Asks why a pixel has its membership.
    ///
    /// # Errors
    /// Fails if the shader takes no vector there, or the device is lost or has no memory.
    pub fn ask(&mut self, pixel: [u32; 2]) -> Result<()> {
        let log = self.log(pixel)?;
        let Some(classes) = &self.classes else { return Ok(()) };
        let explanation = Explanation::of(classes, &log.vector);
        self.asked = Some(Asked { pixel, log, explanation });
        self.diagnosis = self.diagnose();
        Ok(())
    }

    /// Takes the values of all float variables at a pixel.
    ///
    /// # Errors
    /// Fails if the pixel lies outside of the picture, or the device cannot run the shader without its vectors.
    pub fn look(&mut self, pixel: [u32; 2]) -> Result<()> {
        let Some(Compiled { shader, vertex, .. }) = &self.compiled else { return Ok(()) };
        let Opening { device, project, inputs, size, .. } = &self.opening;
        let (vertex, entry) = (vertex.as_ref(), project.entry.as_deref());
        let setting = Setting { device, vertex, entry, size: *size, inputs };
        let list = shader.values(&setting, &mut self.textures, pixel)?;
        self.values = Some(Values { pixel, list });
        Ok(())
    }

    /// Explains the pixel asked about, and judges the features, by the classes there are now.
    fn explain(&mut self) {
        if let (Some(asked), Some(classes)) = (&mut self.asked, &self.classes) {
            asked.explanation = Explanation::of(classes, &asked.log.vector);
        }
        self.diagnosis = self.diagnose();
    }

    /// Returns the diagnosis of the classes, with the vectors of the pixel that was asked about.
    fn diagnose(&self) -> Option<Diagnosis> {
        let classes = self.classes.as_ref()?;
        let width = classes.features.len().max(1);
        let asked = self.asked.iter().flat_map(|asked| asked.log.vectors.chunks_exact(width));
        Some(Diagnosis::of(classes, &asked.map(<[f32]>::to_vec).collect::<Vec<_>>()))
    }

    /// Writes a vector of variables into the text and compiles it. `chosen` has indices into the variables of the shader.
    pub fn mark(&mut self, chosen: &[usize], weight: &str) {
        let Some(compiled) = &self.compiled else { return };
        match compiled.shader.with_vector(chosen, weight) {
            Ok(text) => {
                self.text = text;
                self.compile();
            }
            Err(faults) => self.message = Some(Error::from(faults).to_string()),
        }
    }

    /// Saves the shader and the project. Without a project file, one is written beside the shader.
    ///
    /// # Errors
    /// Fails if a file cannot be written, or the project that is there cannot be read; files appear whole or not at
    /// all.
    pub fn save(&mut self) -> Result<PathBuf> {
        let Opening { project, file, .. } = &self.opening;
        if self.text != self.saved {
            relievo_core::file::store(&project.shader, |out| out.write_all(self.text.as_bytes()))?;
            self.saved.clone_from(&self.text);
        }
        let path = file.clone().unwrap_or_else(|| project.shader.with_extension("toml"));
        let mut project = project.clone();
        project.size = self.opening.size;
        project.write(&path)?;
        self.opening.file = Some(path.clone());
        self.is_changed = false;
        Ok(path)
    }

    /// Writes what is not saved beside the files of the session, with the ending `.rescued`, and returns the file of
    /// the project; `None` where all is saved.
    ///
    /// # Errors
    /// Fails if a file cannot be written.
    pub fn rescue(&self) -> Result<Option<PathBuf>> {
        if !self.is_changed() {
            return Ok(None);
        }
        let rescued = |path: &Path| {
            let mut name = path.as_os_str().to_owned();
            name.push(".rescued");
            PathBuf::from(name)
        };
        let Opening { project, file, .. } = &self.opening;
        relievo_core::file::store(&rescued(&project.shader), |out| out.write_all(self.text.as_bytes()))?;
        let path = rescued(&file.clone().unwrap_or_else(|| project.shader.with_extension("toml")));
        project.write(&path)?;
        Ok(Some(path))
    }

    /// Writes the visible picture as PNG.
    ///
    /// # Errors
    /// Fails if there is no picture or the file cannot be written.
    pub fn save_picture(&self, path: &Path) -> Result<()> {
        let picture = self.picture.as_ref().ok_or_else(|| Error::invalid("there is no picture"))?;
        relievo_render::write_png(path, picture)
    }

    /// Writes the membership of each pixel as PNG.
    ///
    /// # Errors
    /// Fails if the shader takes no vector or both of its shaders do, the file cannot be written, or the device is lost
    /// or has no memory.
    pub fn save_mask(&self, path: &Path) -> Result<()> {
        let (Some(compiled), Some(classes)) = (&self.compiled, &self.classes) else {
            return Err(Error::invalid("the shader takes no vector").advise("choose variables and write a vector"));
        };
        let mut mask = compiled.runner.mask(classes)?;
        // The file holds the membership itself, not an encoded colour.
        mask.data_mut().iter_mut().for_each(|value| *value = relievo_render::color::decode_srgb(*value));
        relievo_render::write_png(path, &mask)
    }

    /// Returns the folder and the first part of the name for pictures that are saved.
    pub(crate) fn stem(&self) -> PathBuf {
        self.opening.file.clone().unwrap_or_else(|| self.opening.project.shader.clone()).with_extension("")
    }

    pub(crate) fn device(&self) -> &Device {
        &self.opening.device
    }
}
