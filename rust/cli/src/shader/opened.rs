//! A shader with its inputs and examples, opened on a graphics device: of a project file, or of options.

use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, Result};
use relievo_render::Picture;
use relievo_shaderlab::{
    Augmented, Class, Classes, Classified, Example, Faults, Input, Inputs, Program, Project, Runner, Shader, Source,
    Texture, Volume,
};

use crate::args::device::{Adapter, Device};
use crate::args::limits::Limits;

#[derive(clap::Args)]
pub struct Options {
    /// A project (.toml), or a shader: .wgsl, .frag, .vert, .comp or .glsl.
    pub file: PathBuf,
    /// The vertex shader of a fragment shader: .vert or .wgsl. Its bind groups follow those of the fragment shader.
    #[arg(long, value_name = "FILE")]
    vertex: Option<PathBuf>,
    /// Vertices to draw, three for each triangle; left out, as many as the inputs of the vertex shader have, or 3.
    #[arg(long, value_name = "COUNT")]
    vertices: Option<u32>,
    /// How often the vertices are drawn, with another instance_index.
    #[arg(long, value_name = "COUNT")]
    instances: Option<u32>,
    /// A texture of the shader: an image (.png, .exr) or a volume (.nii, .nii.gz, .vdb). May be repeated.
    #[arg(long = "input", value_name = "NAME=FILE")]
    inputs: Vec<String>,
    /// Numbers of a uniform, or of an input of the vertex shader, vertex after vertex, with commas between them. May be
    /// repeated.
    #[arg(long = "set", value_name = "NAME=NUMBERS", allow_hyphen_values = true)]
    numbers: Vec<String>,
    /// Pixels of the picture: WIDTHxHEIGHT; left out, those of the project, or of the first image.
    #[arg(long, value_name = "PIXELS", value_parser = crate::args::numbers::pixels)]
    size: Option<[u32; 2]>,
    /// The entry point, where the shader has several.
    #[arg(long, value_name = "NAME")]
    entry: Option<String>,
    /// A pixel that shows what is sought, from the upper left corner. May be repeated.
    #[arg(long = "positive", value_name = "X,Y", value_parser = super::source::pixel)]
    positive: Vec<[u32; 2]>,
    /// A pixel that shows something else. May be repeated.
    #[arg(long = "negative", value_name = "X,Y", value_parser = super::source::pixel)]
    negative: Vec<[u32; 2]>,
    /// Examples of a file, before those of the project and of these options.
    #[arg(long, value_name = "FILE")]
    classes: Option<PathBuf>,
    /// The exponent of the membership: the larger, the harder the border between the classes.
    #[arg(long, value_name = "NUMBER")]
    exponent: Option<f32>,
    /// Divide each feature by the range that it has over the examples.
    #[arg(long)]
    scaled: bool,
    #[command(flatten)]
    adapter: Adapter,
    #[command(flatten)]
    limits: Limits,
}

/// What [`Options`] open.
pub struct Opened {
    /// The augmented shader, if it takes vectors.
    pub augmented: Option<Augmented>,
    pub runner: Runner,
    /// The examples.
    pub classes: Option<Classes>,
}

/// What a shader runs with.
pub struct Begun {
    pub project: Project,
    pub inputs: Inputs,
    /// Columns and rows of the picture.
    pub size: [u32; 2],
    pub device: relievo_gpu::Device,
}

impl Options {
    /// Returns whether the file is a project.
    pub fn is_project(&self) -> bool {
        self.file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
    }

    /// Returns the pixels that options classify.
    pub fn classified(&self) -> Vec<Classified> {
        let of = |class| move |pixel: &[u32; 2]| Classified { pixel: *pixel, class };
        let positive = self.positive.iter().map(of(Class::Positive));
        positive.chain(self.negative.iter().map(of(Class::Negative))).collect()
    }

    fn project(&self) -> Result<Project> {
        let mut project = match self.is_project() {
            true => Project::read(&self.file)?,
            false => Project {
                version: 1,
                shader: self.file.clone(),
                vertex: None,
                vertices: None,
                instances: None,
                entry: None,
                size: [0; 2],
                exponent: relievo_shaderlab::EXPONENT,
                scaled: false,
                set: Default::default(),
                inputs: Vec::new(),
                examples: Vec::new(),
            },
        };
        for text in &self.inputs {
            let (name, file) = split(text, "--input")?;
            project.inputs.retain(|input| input.name != name);
            project.inputs.push(Input { name: name.to_owned(), file: file.into() });
        }
        for text in &self.numbers {
            let (name, numbers) = split(text, "--set")?;
            let numbers: std::result::Result<Vec<f64>, _> =
                numbers.split(',').map(|part| part.trim().parse()).collect();
            let numbers =
                numbers.map_err(|_| Error::invalid(format!("{text:?} has no numbers behind =")).at("--set"))?;
            project.set.insert(name.to_owned(), numbers);
        }
        project.examples.extend(self.classified());
        project.entry = self.entry.clone().or(project.entry);
        project.vertex = self.vertex.clone().or(project.vertex);
        project.vertices = self.vertices.or(project.vertices);
        project.instances = self.instances.or(project.instances);
        project.exponent = self.exponent.unwrap_or(project.exponent);
        project.scaled |= self.scaled;
        Ok(project)
    }

    /// Reads the project and its inputs and opens the graphics device.
    pub fn begin(&self) -> Result<Begun> {
        let project = self.project()?;
        let context = self.limits.context()?;
        let (vertices, instances) = (project.vertices, project.instances);
        let mut inputs = Inputs { numbers: project.set.clone(), vertices, instances, ..Inputs::default() };
        let mut image_size = None;
        for input in &project.inputs {
            let texture = texture(&context, &input.file)?;
            if let Texture::Image(image) = &texture {
                image_size = image_size.or(Some([image.width(), image.height()]));
            }
            inputs.textures.insert(input.name.clone(), texture);
        }
        let stated = Some(project.size).filter(|size| !size.contains(&0));
        let size = self.size.or(stated).or(image_size).unwrap_or([640, 480]);
        let device = self
            .adapter
            .open(Device::Gpu, self.limits.memory_limit)?
            .ok_or_else(|| Error::internal("no graphics device was opened"))?;
        Ok(Begun { project, inputs, size, device })
    }

    /// Opens the shader on a graphics device and takes the vectors of its examples.
    pub fn open(&self) -> Result<std::result::Result<Opened, Faults>> {
        let Begun { project, inputs, size, device } = self.begin()?;
        let shader = match Shader::new(Source::read(&project.shader)?) {
            Ok(shader) => shader,
            Err(faults) => return Ok(Err(faults)),
        };
        let vertex = match project.vertex.as_deref().map(super::source::read).transpose()?.transpose() {
            Ok(vertex) => vertex,
            Err(faults) => return Ok(Err(faults)),
        };
        let needs_vectors = !project.examples.is_empty() || self.classes.is_some();
        // Vectors of the vertex shader alone are enough.
        let is_marked = shader.is_marked() || (needs_vectors && !vertex.as_ref().is_some_and(Shader::is_marked));
        let prepared = || -> std::result::Result<_, Faults> {
            let augmented = if is_marked { Some(shader.augment()?) } else { None };
            let program = match &augmented {
                Some(augmented) => Program::augmented(&shader, augmented)?,
                None => Program::plain(&shader)?,
            };
            let of_vertices = vertex.as_ref().filter(|vertex| vertex.is_marked()).map(Shader::augment).transpose()?;
            Ok((program, augmented, of_vertices))
        };
        let (program, augmented, of_vertices) = match prepared() {
            Ok(prepared) => prepared,
            Err(faults) => return Ok(Err(faults)),
        };
        let program = match &vertex {
            Some(vertex) => program.with_vertex(vertex, of_vertices.as_ref())?,
            None => program,
        };
        let augmented = augmented.or(of_vertices);
        let runner = Runner::new(&device, &program, project.entry.as_deref(), size, &inputs)
            .map_err(|error| error.at(project.shader.display().to_string()))?;
        let classes = match &augmented {
            Some(augmented) => Some(self.classes(&project, augmented, &runner)?),
            None => None,
        };
        Ok(Ok(Opened { augmented, runner, classes }))
    }

    fn classes(&self, project: &Project, augmented: &Augmented, runner: &Runner) -> Result<Classes> {
        let mut classes = Classes::of(augmented);
        if let Some(file) = &self.classes {
            let read = Classes::read(file)?;
            if read.features != classes.features {
                let what = format!("the classes have the features {}", read.features.join("; "));
                let advice = format!("use classes of a shader with the features {}", classes.features.join("; "));
                return Err(Error::invalid(what).at(file.display().to_string()).advise(advice));
            }
            classes = read;
        }
        if self.classes.is_none() || self.exponent.is_some() {
            classes.exponent = project.exponent;
        }
        classes.is_scaled |= project.scaled;
        // Vectors are taken of the picture without examples, so that their order does not matter.
        let plain = Classes::of(augmented);
        for Classified { pixel, class } in &project.examples {
            let vector = runner.classify(&plain, *pixel)?.vector;
            classes.examples.push(Example { pixel: *pixel, class: *class, vector });
        }
        classes.check()?;
        Ok(classes)
    }
}

fn split<'a>(text: &'a str, option: &str) -> Result<(&'a str, &'a str)> {
    let parts = text.split_once('=').filter(|(name, _)| !name.is_empty());
    parts.ok_or_else(|| Error::invalid(format!("{text:?} has no = between name and value")).at(option))
}

/// Reads an image or a volume.
fn texture(context: &Context, file: &Path) -> Result<Texture> {
    let name = file.to_string_lossy().to_lowercase();
    if [".nii", ".nii.gz", ".vdb"].iter().any(|ending| name.ends_with(ending)) {
        return Ok(Texture::Volume(Volume::read(context, file)?));
    }
    Ok(Texture::Image(Picture::read(file, context.memory_limit())?.color))
}
