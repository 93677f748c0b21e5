//! Running of shaders on a graphics device: pictures, and the feature vectors of single pixels.
//!
//! A fragment shader is drawn over the whole picture, with its own vertex shader where the module has one without vertex
//! buffers, or with a triangle that covers the picture. A compute shader is dispatched with an invocation for each pixel and
//! writes the picture to its 2-D storage texture. To classify, a fragment shader runs for one pixel alone.

mod bind;
mod draw;
mod program;

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Device};
use relievo_render::Image;

use crate::accumulation::Accumulation;
use crate::classes::{Classes, MOST_EXAMPLES, Mode};
use crate::instrument::{EXAMPLES_HEAD, LOG_HEAD};
use crate::log::Log;

pub use bind::{Inputs, Texture};
pub use program::Program;

use bind::Bound;
use draw::Pipeline;

/// Vectors of one pixel that the log keeps one by one. Later ones are still accumulated.
pub const MOST_VECTORS: usize = 4096;

/// The buffers of an augmented shader.
struct Instruments {
    examples: Buffer<u32>,
    log: Buffer<u32>,
    features: usize,
    accumulation: Accumulation,
}

/// A shader with its inputs on a graphics device.
pub struct Runner {
    device: Device,
    pipeline: Pipeline,
    bound: Bound,
    instruments: Option<Instruments>,
    size: [u32; 2],
}

impl std::fmt::Debug for Runner {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Runner").field("size", &self.size).finish_non_exhaustive()
    }
}

fn place(pixel: [u32; 2]) -> String {
    format!("pixel {}, {}", pixel[0], pixel[1])
}

impl Runner {
    /// Prepares a shader for pictures of `size` pixels.
    ///
    /// `entry` names the fragment or compute entry point; it may be left out where there is one. Fails if there is none or more
    /// than one, if an input is missing or of the wrong kind, if a name of a number is unknown, or if the device cannot run the
    /// shader.
    pub fn new(
        device: &Device,
        program: &Program,
        entry: Option<&str>,
        size: [u32; 2],
        inputs: &Inputs,
    ) -> Result<Self> {
        let most = device.limits().max_texture_dimension_2d;
        if size.iter().any(|edge| !(1..=most).contains(edge)) {
            return Err(Error::invalid(format!("a picture of {} × {} pixels cannot be drawn", size[0], size[1]))
                .advise(format!("use 1 to {most} pixels along each edge")));
        }
        let entry = program.entry(entry)?;
        let instruments = match &program.instrument {
            None => None,
            Some(instrument) => {
                let width = instrument.features + 1;
                let examples = EXAMPLES_HEAD + instrument.features + MOST_EXAMPLES * width;
                let pixels = size[0] as usize * size[1] as usize;
                let log = LOG_HEAD + (instrument.features + MOST_VECTORS * width).max(pixels);
                Some(Instruments {
                    examples: Buffer::new(device, "examples", examples)?,
                    log: Buffer::new(device, "log", log)?,
                    features: instrument.features,
                    accumulation: instrument.accumulation,
                })
            }
        };
        let buffers = instruments.as_ref().map(|it| [it.examples.wgpu(), it.log.wgpu()]);
        let bound = Bound::new(device, program, size, inputs, buffers)?;
        let pipeline = Pipeline::new(device, program, &entry, &bound, size)?;
        Ok(Self { device: device.clone(), pipeline, bound, instruments, size })
    }

    /// Returns the size of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    fn instruments(&self) -> Result<&Instruments> {
        self.instruments.as_ref().ok_or_else(|| {
            Error::invalid("the shader is not augmented").advise("augment it before pixels are classified")
        })
    }

    /// Sends classes and a mode to the shader.
    fn send(&self, classes: &Classes, mode: Mode) -> Result<()> {
        let instruments = self.instruments()?;
        classes.check()?;
        if classes.features.len() != instruments.features {
            let what =
                format!("the classes have {} features, the shader {}", classes.features.len(), instruments.features);
            return Err(Error::invalid(what).advise("classify the pixels again with this shader"));
        }
        instruments.examples.write(&self.device, 0, &classes.words(mode))
    }

    /// Runs the shader without reading anything back and waits until it is done.
    pub fn run(&self, classes: Option<&Classes>) -> Result<()> {
        self.start(classes)?;
        let mut frame = self.device.frame()?;
        self.pipeline.record(&mut frame, &self.bound, self.size, None)?;
        frame.submit()?.wait()?;
        Ok(())
    }

    fn start(&self, classes: Option<&Classes>) -> Result<()> {
        match (classes, &self.instruments) {
            (Some(classes), _) => self.send(classes, Mode::Render),
            (None, Some(instruments)) => {
                self.send(&Classes::new(vec![String::new(); instruments.features]), Mode::Render)
            }
            (None, None) => Ok(()),
        }
    }

    /// Returns the picture of the shader, with the membership that `classes` give; an augmented shader without classes has
    /// the membership 0.5 everywhere. Channels are those that the shader writes, without any conversion of colours.
    pub fn picture(&self, classes: Option<&Classes>) -> Result<Image> {
        self.start(classes)?;
        let mut frame = self.device.frame()?;
        self.pipeline.record(&mut frame, &self.bound, self.size, None)?;
        let read = self.pipeline.read(&self.device, &mut frame, &self.bound, self.size)?;
        let _submitted = frame.submit()?;
        self.pipeline.image(&read.get(&self.device)?, self.size)
    }

    /// Returns the membership of each pixel's vector, in one channel; 0.5 where the shader takes no vector.
    pub fn mask(&self, classes: &Classes) -> Result<Image> {
        self.send(classes, Mode::Mask(self.size))?;
        let log = &self.instruments()?.log;
        let pixels = self.size[0] as usize * self.size[1] as usize;
        log.write(&self.device, LOG_HEAD, &vec![0.5_f32.to_bits(); pixels])?;
        let mut frame = self.device.frame()?;
        self.pipeline.record(&mut frame, &self.bound, self.size, None)?;
        let read = frame.read(log, LOG_HEAD..LOG_HEAD + pixels)?;
        let _submitted = frame.submit()?;
        let values = read.get(&self.device)?.into_iter().map(f32::from_bits).collect();
        Image::from_data(self.size[0], self.size[1], 1, values)
    }

    /// Returns the vectors of a pixel, whose column and row count from the upper left corner.
    ///
    /// Fails if the pixel lies outside of the picture, or if the shader takes no vector of a weight other than 0 there.
    pub fn classify(&self, classes: &Classes, pixel: [u32; 2]) -> Result<Log> {
        self.check(pixel)?;
        self.send(classes, Mode::Classify(pixel))?;
        let instruments = self.instruments()?;
        let count = instruments.features;
        let mut frame = self.device.frame()?;
        frame.clear(&instruments.log);
        self.pipeline.record(&mut frame, &self.bound, self.size, Some(pixel))?;
        let read = frame.read(&instruments.log, 0..LOG_HEAD + count + MOST_VECTORS * (count + 1))?;
        let _submitted = frame.submit()?;
        Log::of(&read.get(&self.device)?, count, instruments.accumulation).map_err(|error| error.at(place(pixel)))
    }

    /// Fails if a pixel lies outside of the picture.
    pub(crate) fn check(&self, pixel: [u32; 2]) -> Result<()> {
        if (0..2).all(|axis| pixel[axis] < self.size[axis]) {
            return Ok(());
        }
        Err(Error::invalid(format!("the picture has {} × {} pixels", self.size[0], self.size[1])).at(place(pixel)))
    }
}
