//! The values of a shader's float variables at a pixel (Mindek et al. 2013, Section 4.2).

use relievo_core::{Error, Result};
use relievo_gpu::Device;

use crate::classes::Classes;
use crate::log::Log;
use crate::runner::{Inputs, Program, Runner, Textures};
use crate::shader::Shader;
use crate::source::Source;
use crate::variable::Variable;

/// The values that a variable has at a pixel, one component after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// How often the pixel passes the declaration.
    pub taken: u32,
    /// The mean over all passes.
    pub mean: Vec<f32>,
    /// The least over the passes that the log has room for.
    pub low: Vec<f32>,
    /// The largest over the same.
    pub high: Vec<f32>,
}

impl Value {
    fn of(log: &Log) -> Self {
        let width = log.vector.len().max(1);
        let bound = |with: fn(f32, f32) -> f32| {
            let mut bound = log.vectors.get(..width).unwrap_or(&log.vector).to_vec();
            for vector in log.vectors.chunks_exact(width) {
                bound.iter_mut().zip(vector).for_each(|(bound, value)| *bound = with(*bound, *value));
            }
            bound
        };
        Self { taken: log.taken, mean: log.vector.clone(), low: bound(f32::min), high: bound(f32::max) }
    }
}

/// What a shader runs with.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// The graphics device.
    pub device: &'a Device,
    /// The vertex shader of another text, for fragment shaders.
    pub vertex: Option<&'a Shader>,
    /// The entry point; left out, the only one.
    pub entry: Option<&'a str>,
    /// Columns and rows of the picture.
    pub size: [u32; 2],
    /// Textures and numbers.
    pub inputs: &'a Inputs,
}

impl Setting<'_> {
    fn runner(&self, program: Program, textures: &mut Textures) -> Result<Runner> {
        let program = match self.vertex {
            Some(vertex) => program.with_vertex(vertex, None)?,
            None => program,
        };
        Runner::sharing(self.device, &program, self.entry, self.size, self.inputs, textures)
    }
}

impl Shader {
    /// Returns the values of each of [`Shader::variables`] at a pixel, counted from the upper left corner of the picture, where
    /// the variable is declared. Each is taken by a vector of that variable alone, in place of the vectors of the shader. All
    /// runs share the textures of `textures`, which are those of the setting's inputs on its device.
    ///
    /// A variable of a vertex shader has its values at the vertices of the triangle that is seen at the pixel; their
    /// mean is the interpolated value. A variable has an error in its place if its declaration gives it no value, if
    /// the pixel does not pass it, if a value is not finite, or if no statement can stand behind it.
    ///
    /// # Errors
    /// Fails if the pixel lies outside of the picture, the shader without its annotations cannot be read, or the device
    /// cannot run it.
    pub fn values(
        &self,
        setting: &Setting<'_>,
        textures: &mut Textures,
        pixel: [u32; 2],
    ) -> Result<Vec<Result<Value>>> {
        let bare = Self::new(self.without_annotations())?;
        setting.runner(Program::plain(&bare)?, textures)?.check(pixel)?;
        let value = |(index, variable): (usize, &Variable)| {
            if !variable.is_initialized {
                let what = format!("the declaration of `{}` gives it no value", variable.name);
                return Err(Error::invalid(what).advise("mark a vector behind the assignment that is of interest"));
            }
            let text = bare.with_vector(&[index], "1.0")?.into();
            let marked = Self::new(Source { text, ..bare.source.clone() })?;
            let augmented = marked.augment()?;
            let runner = setting.runner(Program::augmented(&marked, &augmented)?, textures)?;
            Ok(Value::of(&runner.classify(&Classes::of(&augmented), pixel)?))
        };
        Ok(bare.variables().iter().enumerate().map(value).collect())
    }
}
