//! Running of shaders on a graphics device: pictures, and the feature vectors of single pixels.
//!
//! A fragment shader is drawn over the whole picture, with a triangle that covers the picture, or with its vertex shader. A
//! vertex shader alone draws its triangles. A compute shader is dispatched with an invocation for each pixel and writes the
//! picture to its 2-D storage texture. To classify, a fragment shader runs for one pixel alone. Of vertices, those of the
//! triangle that is seen at the pixel are classified, each by a run of its own; its share in the pixel multiplies the weights of its
//! vectors, so that a pixel has the interpolated vector, as a fragment shader has the interpolated outputs.

mod bind;
mod cover;
mod draw;
mod geometry;
mod program;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Device, wgpu};
use relievo_render::Image;

use crate::accumulation::Accumulation;
use crate::classes::{Classes, MAX_EXAMPLES, Mode};
use crate::instrument::{EXAMPLES_HEAD, LOG_HEAD, VERTEX_HEAD};
use crate::log::{Log, Part};

pub use bind::{Inputs, Texture, Textures};
pub use geometry::MAX_VERTICES;
pub use program::Program;

use bind::Bound;
use cover::{Cover, covers};
use draw::{Pipeline, Run};
use geometry::Geometry;

/// Vectors of one pixel that the log keeps one by one. Later ones are still accumulated.
pub const MAX_VECTORS: usize = 4096;

/// The buffers of an augmented shader.
struct Instruments {
    examples: Buffer<u32>,
    log: Buffer<u32>,
    features: usize,
    accumulation: Accumulation,
}

impl Instruments {
    /// Returns the words of the log of one invocation.
    fn logged(&self) -> usize {
        LOG_HEAD + self.features + MAX_VECTORS * (self.features + 1)
    }
}

/// The accumulated vectors of all vertices.
struct Vertices {
    /// The words that the vertex shader read: those of the classes where it uses `confidence`, otherwise none.
    key: Vec<u32>,
    /// The records of the vertices, one after the other (see [`crate::instrument`]).
    records: Vec<f32>,
    /// The numbers of a record.
    width: usize,
}

impl Vertices {
    /// Returns the position of a vertex in clip space.
    fn place(&self, vertex: usize) -> [f32; 4] {
        std::array::from_fn(|axis| self.records[vertex * self.width + axis])
    }

    /// Returns what a vertex logged, without single vectors.
    fn part(&self, vertex: usize) -> Part {
        let record = &self.records[vertex * self.width..][..self.width];
        Part { weighted: record[4] as u32, total: record[5], sums: record[VERTEX_HEAD..].to_vec(), ..Part::default() }
    }
}

/// A list of vertices.
#[derive(Default)]
enum List {
    /// There is none.
    #[default]
    Missing,
    /// The log on the device has it, and the host has not read it yet: its key.
    Logged(Vec<u32>),
    /// The host has it.
    Read(Arc<Vertices>),
}

/// A shader with its inputs on a graphics device.
pub struct Runner {
    device: Device,
    pipeline: Pipeline,
    bound: Bound,
    /// The buffers of the shader, and behind them those of a vertex shader of another text, if each is augmented.
    instruments: Vec<Instruments>,
    geometry: Option<Geometry>,
    /// Whether pixels, and whether vertices, take vectors.
    takes: [bool; 2],
    /// Whether the vertex shader uses `confidence`, so that its outputs depend on the classes.
    judges: bool,
    /// The list of vertices made last. Text, inputs and vertices of a runner never change, so only classes can outdate it.
    vertices: Mutex<List>,
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
    /// `entry` names the entry point; it may be left out where there is one that computes pixels, or else one of
    /// vertices.
    ///
    /// # Errors
    /// Fails if the size is 0 or more than the device draws, if there is no entry point of the name or, without a name,
    /// none or more than one, if an input is missing or of the wrong kind or length, if a name of an input is unknown,
    /// or if the device cannot run the shader, is lost or has no memory: vectors of vertices need a device whose vertex
    /// shaders can write.
    pub fn new(
        device: &Device,
        program: &Program,
        entry: Option<&str>,
        size: [u32; 2],
        inputs: &Inputs,
    ) -> Result<Self> {
        Self::sharing(device, program, entry, size, inputs, &mut Textures::default())
    }

    /// Prepares a shader as [`Runner::new`] does, with the textures that `textures` has of these inputs on this device already;
    /// missing ones are added.
    ///
    /// # Errors
    /// Fails as [`Runner::new`] does.
    pub fn sharing(
        device: &Device,
        program: &Program,
        entry: Option<&str>,
        size: [u32; 2],
        inputs: &Inputs,
        textures: &mut Textures,
    ) -> Result<Self> {
        let most = device.limits().max_texture_dimension_2d;
        if size.iter().any(|edge| !(1..=most).contains(edge)) {
            return Err(Error::invalid(format!("a picture of {} × {} pixels cannot be drawn", size[0], size[1]))
                .advise(format!("use 1 to {most} pixels along each edge")));
        }
        let chosen = program.choose(entry, inputs)?;
        let takes = [&chosen.pixels, &chosen.vertices].map(|point| point.as_ref().is_some_and(|it| it.is_marked));
        if takes[1] && !device.wgpu().features().contains(wgpu::Features::VERTEX_WRITABLE_STORAGE) {
            let what = format!("vertex shaders of {} cannot write their vectors", device.summary().name);
            return Err(
                Error::unsupported(what).advise("take the vectors in the fragment shader, or choose another device")
            );
        }
        let attributes = chosen.vertices.as_ref().map_or(&[][..], |point| point.inputs.as_slice());
        bind::check_names(program, inputs, attributes)?;
        let geometry = chosen.vertices.as_ref().map(|point| Geometry::new(device, point, inputs)).transpose()?;
        let listed = geometry.as_ref().filter(|_| takes[1]).map_or(0, Geometry::all);
        let mut instruments = Vec::new();
        for instrument in program.parts().filter_map(|part| part.instrument.as_ref()) {
            let width = instrument.features + 1;
            let examples = EXAMPLES_HEAD + instrument.features + MAX_EXAMPLES * width;
            let pixels = size[0] as usize * size[1] as usize;
            let vertices = listed * (VERTEX_HEAD + instrument.features);
            let log = LOG_HEAD + (instrument.features + MAX_VECTORS * width).max(pixels).max(vertices);
            instruments.push(Instruments {
                examples: Buffer::new(device, "examples", examples)?,
                log: Buffer::new(device, "log", log)?,
                features: instrument.features,
                accumulation: instrument.accumulation,
            });
        }
        let buffers: Vec<_> = instruments.iter().map(|it| [it.examples.wgpu(), it.log.wgpu()]).collect();
        let bound = Bound::new(device, program, size, inputs, textures, &buffers, takes[1])?;
        let pipeline = Pipeline::new(device, program, &chosen, geometry.as_ref(), &bound, size)?;
        let judges = program.vertex.as_deref().unwrap_or(program).judges;
        let vertices = Mutex::default();
        Ok(Self { device: device.clone(), pipeline, bound, instruments, geometry, takes, judges, vertices, size })
    }

    /// Returns the size of the picture.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the buffers of the shader that computes pixels, or else of the one that is augmented.
    fn instruments(&self) -> Result<&Instruments> {
        self.instruments.first().ok_or_else(|| {
            Error::invalid("the shader is not augmented").advise("augment it before pixels are classified")
        })
    }

    /// Returns the buffers that vertices write to.
    fn vertex_instruments(&self) -> Result<&Instruments> {
        self.instruments.last().ok_or_else(|| Error::internal("the vertex shader is not augmented"))
    }

    /// Returns the words that the shader reads of classes in a mode. Fails if the classes do not fit the shader.
    fn words(&self, classes: &Classes, mode: Mode) -> Result<Vec<u32>> {
        let features = self.instruments()?.features;
        classes.check()?;
        if classes.features.len() != features {
            let what = format!("the classes have {} features, the shader {features}", classes.features.len());
            return Err(Error::invalid(what).advise("classify the pixels again with this shader"));
        }
        Ok(classes.words(mode))
    }

    /// Sends classes and a mode to the shader.
    fn send(&self, classes: &Classes, mode: Mode) -> Result<()> {
        let words = self.words(classes, mode)?;
        self.instruments.iter().try_for_each(|it| it.examples.write(&self.device, 0, &words))
    }

    fn record(&self, frame: &mut relievo_gpu::Frame, run: Run) -> Result<()> {
        self.pipeline.record(frame, &self.bound, self.geometry.as_ref(), self.size, run)
    }

    /// Runs the shader without reading anything back and waits until it is done.
    ///
    /// # Errors
    /// Fails if the classes do not fit the shader, or where the device is lost or has no memory.
    pub fn run(&self, classes: Option<&Classes>) -> Result<()> {
        let mut frame = self.device.frame()?;
        let list = self.start(&mut frame, classes)?;
        self.record(&mut frame, Run::All)?;
        let submitted = frame.submit()?;
        self.list(list);
        submitted.wait()?;
        Ok(())
    }

    /// Sends what the shader reads when it draws. A first picture lists the vertices as well, which run for it anyway, so that
    /// no pixel waits for them later: then returns the list of vertices, still empty, and the key of what is listed.
    fn start(
        &self,
        frame: &mut relievo_gpu::Frame,
        classes: Option<&Classes>,
    ) -> Result<Option<(MutexGuard<'_, List>, Vec<u32>)>> {
        let Some(instruments) = self.instruments.first() else { return Ok(None) };
        let none = || Classes::new(vec![String::new(); instruments.features]);
        let classes = classes.map_or_else(|| Cow::Owned(none()), Cow::Borrowed);
        if let (true, Some(geometry)) = (self.takes[1], &self.geometry) {
            let held = self.held();
            if matches!(*held, List::Missing) {
                // To fragment shaders, this mode is the one to render.
                let mode = Mode::Vertices(geometry.count);
                let key = self.key(&classes, mode)?;
                self.send(&classes, mode)?;
                frame.clear(&self.vertex_instruments()?.log);
                return Ok(Some((held, key)));
            }
        }
        self.send(&classes, Mode::Render)?;
        Ok(None)
    }

    /// Notes that a picture that was submitted lists the vertices, if it does.
    fn list(&self, listed: Option<(MutexGuard<'_, List>, Vec<u32>)>) {
        if let Some((mut held, key)) = listed {
            *held = List::Logged(key);
        }
    }

    /// Returns the picture of the shader, with the membership that `classes` give; an augmented shader without classes has
    /// the membership 0.5 everywhere. Channels are what the shader writes, without any conversion of colours.
    ///
    /// # Errors
    /// Fails if the classes do not fit the shader, a compute shader writes no picture, or the device is lost or has no
    /// memory.
    pub fn picture(&self, classes: Option<&Classes>) -> Result<Image> {
        let mut frame = self.device.frame()?;
        let list = self.start(&mut frame, classes)?;
        self.record(&mut frame, Run::All)?;
        let read = self.pipeline.read(&self.device, &mut frame, &self.bound, self.size)?;
        let _submitted = frame.submit()?;
        self.list(list);
        self.pipeline.image(&read.get(&self.device)?, self.size)
    }

    /// Returns the membership of each pixel's vector, in one channel; 0.5 where the shader takes no vector.
    ///
    /// # Errors
    /// Fails if vertices and fragments take vectors: those of fragments are judged on the device, before they could be
    /// joined with those of vertices. Fails too if the shader is not augmented, the classes do not fit it, or the
    /// device is lost or has no memory.
    pub fn mask(&self, classes: &Classes) -> Result<Image> {
        let [width, height] = self.size;
        match self.takes {
            [true, true] => {
                return Err(Error::unsupported("vertices and fragments take vectors, which no mask joins")
                    .advise("take the vectors in one of the two shaders"));
            }
            [false, true] => return self.mask_of_vertices(classes),
            [_, false] => {}
        }
        self.send(classes, Mode::Mask(self.size))?;
        let log = &self.instruments()?.log;
        let pixels = width as usize * height as usize;
        log.write(&self.device, LOG_HEAD, &vec![0.5_f32.to_bits(); pixels])?;
        let mut frame = self.device.frame()?;
        self.record(&mut frame, Run::All)?;
        let read = frame.read(log, LOG_HEAD..LOG_HEAD + pixels)?;
        let _submitted = frame.submit()?;
        let values = read.get(&self.device)?.into_iter().map(f32::from_bits).collect();
        Image::from_data(width, height, 1, values)
    }

    /// As [`Runner::mask`], of the vectors of vertices: a list of them is made on the device, and pixels are judged here.
    fn mask_of_vertices(&self, classes: &Classes) -> Result<Image> {
        let [width, height] = self.size;
        let Instruments { features, accumulation, .. } = *self.vertex_instruments()?;
        let vertices = self.vertices(classes)?;
        let value = |cover: &Option<Cover>| {
            let Some(Cover { corners, shares, .. }) = cover else { return 0.5 };
            let parts = corners.iter().zip(shares).map(|(corner, share)| (vertices.part(*corner), *share));
            let log = Log::join(parts.collect(), features, accumulation);
            log.map_or(0.5, |log| classes.membership(&log.vector))
        };
        let values = self.covers(&vertices, [0..width, 0..height]).iter().map(value).collect();
        Image::from_data(width, height, 1, values)
    }

    /// Returns what is seen of the vertices in an area of the picture.
    fn covers(&self, vertices: &Vertices, area: [Range<u32>; 2]) -> Vec<Option<Cover>> {
        let count = self.geometry.as_ref().map_or([0; 2], |geometry| geometry.count).map(|count| count as usize);
        covers(|vertex| vertices.place(vertex), count, self.size, area)
    }

    fn held(&self) -> MutexGuard<'_, List> {
        self.vertices.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the words that a list of vertices depends on: those of the classes where the vertex shader uses `confidence`.
    /// Fails if the classes do not fit the shader.
    fn key(&self, classes: &Classes, mode: Mode) -> Result<Vec<u32>> {
        let words = self.words(classes, mode)?;
        Ok(if self.judges { words } else { Vec::new() })
    }

    /// Returns the vectors of all vertices: the list made last while it holds, and a new one where there is none or where the
    /// vertex shader judges by other classes now.
    fn vertices(&self, classes: &Classes) -> Result<Arc<Vertices>> {
        let geometry = self.geometry.as_ref().ok_or_else(|| Error::internal("the shader has no vertices"))?;
        let Instruments { features, log, .. } = self.vertex_instruments()?;
        let [count, instances] = geometry.count;
        let mode = Mode::Vertices(geometry.count);
        let key = self.key(classes, mode)?;
        let mut held = self.held();
        let mut frame = self.device.frame()?;
        match std::mem::take(&mut *held) {
            List::Read(vertices) if vertices.key == key => {
                *held = List::Read(Arc::clone(&vertices));
                return Ok(vertices);
            }
            List::Logged(listed) if listed == key => {}
            _ => {
                self.send(classes, mode)?;
                frame.clear(log);
                self.record(&mut frame, Run::Vertices([0..count, 0..instances]))?;
            }
        }
        let width = VERTEX_HEAD + features;
        let read = frame.read(log, LOG_HEAD..LOG_HEAD + geometry.all() * width)?;
        let _submitted = frame.submit()?;
        let records = read.get(&self.device)?.into_iter().map(f32::from_bits).collect();
        let vertices = Arc::new(Vertices { key, records, width });
        *held = List::Read(Arc::clone(&vertices));
        Ok(vertices)
    }

    /// Returns the vectors of a pixel, whose column and row count from the upper left corner: those of the corners of the
    /// triangle that is seen there, their weights multiplied by the corners' shares, and then those of the pixel itself.
    ///
    /// # Errors
    /// Fails if the pixel lies outside of the picture, if the shader is not augmented or takes no vector of a weight
    /// other than 0 there, if the classes do not fit it, if the weights of an average sum to 0 or the vector is not
    /// finite, or where the device is lost or has no memory.
    pub fn classify(&self, classes: &Classes, pixel: [u32; 2]) -> Result<Log> {
        self.check(pixel)?;
        let Instruments { features, accumulation, .. } = *self.instruments()?;
        let mut parts = Vec::new();
        if self.takes[1] {
            let vertices = self.vertices(classes)?;
            let count = self.geometry.as_ref().map_or(1, |geometry| geometry.count[0] as usize);
            let area = pixel.map(|at| at..at + 1);
            if let Some(Some(Cover { corners, shares, .. })) = self.covers(&vertices, area).first() {
                for (corner, share) in corners.iter().zip(shares) {
                    let [vertex, instance] = [corner % count, corner / count].map(|index| index as u32);
                    let run = Run::Vertices([vertex..vertex + 1, instance..instance + 1]);
                    let mode = Mode::ClassifyVertex([vertex, instance]);
                    parts.push((self.log(classes, mode, run, self.vertex_instruments()?)?, *share));
                }
            }
        }
        if self.takes[0] || !self.takes[1] {
            parts.push((self.log(classes, Mode::Classify(pixel), Run::Pixel(pixel), self.instruments()?)?, 1.0));
        }
        Log::join(parts, features, accumulation).map_err(|error| error.at(place(pixel)))
    }

    /// Returns what the invocation that a mode names logs.
    fn log(&self, classes: &Classes, mode: Mode, run: Run, instruments: &Instruments) -> Result<Part> {
        let Instruments { features, log, .. } = instruments;
        self.send(classes, mode)?;
        let mut frame = self.device.frame()?;
        // What lists and masks wrote behind the log of one invocation is not read.
        frame.encoder().clear_buffer(log.wgpu(), 0, Some(4 * instruments.logged() as u64));
        self.record(&mut frame, run)?;
        let read = frame.read(log, 0..instruments.logged())?;
        let _submitted = frame.submit()?;
        Part::of(&read.get(&self.device)?, *features)
    }

    /// Fails if a pixel lies outside of the picture.
    pub(crate) fn check(&self, pixel: [u32; 2]) -> Result<()> {
        if (0..2).all(|axis| pixel[axis] < self.size[axis]) {
            return Ok(());
        }
        Err(Error::invalid(format!("the picture has {} × {} pixels", self.size[0], self.size[1])).at(place(pixel)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Class, Example, Language, Shader, Source, Stage};

    /// A triangle over the whole picture that `confidence`, a parameter and the numbers of its vertices move.
    const TEXT: &str = "@group(0) @binding(0) var<uniform> shift: vec4<f32>;\n\
        struct Out { @builtin(position) at: vec4<f32>, @location(0) shade: f32 }\n\
        @vertex fn vs(@location(0) place: vec2<f32>) -> Out {\n    var out: Out;\n    let v = place.x + 2.0 * place.y;\n    \
        //. vector v; shift.y; 1.0\n    var moved = 0.0;\n    CODE\n    \
        out.at = vec4<f32>(place.x + moved + shift.x, place.y, 0.5, 1.0);\n    out.shade = v;\n    return out;\n}\n\
        @fragment fn fs(in: Out) -> @location(0) vec4<f32> { return vec4<f32>(in.shade); }\n";

    fn made(device: &Device, text: &str, inputs: &Inputs) -> (Runner, Classes) {
        let shader = Shader::new(Source::new("test", text, Language::Wgsl, Stage::Fragment)).unwrap();
        let augmented = shader.augment().unwrap();
        let program = Program::augmented(&shader, &augmented).unwrap();
        (Runner::new(device, &program, None, [12, 8], inputs).unwrap(), Classes::of(&augmented))
    }

    #[test]
    fn the_list_of_vertices_is_retained_until_what_it_depends_on_changes() {
        let Some(device) = relievo_testing::device() else { return };
        let mut inputs = Inputs::default();
        inputs.numbers.insert("shift".into(), vec![0.0, 3.0, 0.0, 0.0]);
        inputs.numbers.insert("place".into(), vec![-1.0, -1.0, 3.0, -1.0, -1.0, 3.0, -1.0, -1.0, 9.0, -1.0, -1.0, 9.0]);
        inputs.vertices = Some(3);
        let judging = TEXT.replace("CODE", "/*. moved = 4.0 * confidence - 2.0; */");
        let plain = TEXT.replace("CODE", "");
        let sure = |classes: &Classes, class| {
            let example = |class, value| Example { pixel: [0, 0], class, vector: vec![value, 3.0] };
            let other = if class == Class::Positive { Class::Negative } else { Class::Positive };
            let mut classes = classes.clone();
            classes.examples = vec![example(class, -3.0), example(other, 5.0)];
            classes
        };
        // A shader without `confidence` has one list for all classes.
        let (runner, none) = made(&device, &plain, &inputs);
        let list = runner.vertices(&none).unwrap();
        assert!(Arc::ptr_eq(&list, &runner.vertices(&sure(&none, Class::Positive)).unwrap()));
        assert!(runner.vertices(&Classes::new(vec!["one".into()])).is_err());
        assert!(runner.classify(&none, [6, 4]).is_ok() && Arc::ptr_eq(&list, &runner.vertices(&none).unwrap()));
        // Classes, parameters, vertices and text in turn: each result is that of a new runner, and each differs.
        let (runner, none) = made(&device, &judging, &inputs);
        let mut seen = Vec::new();
        for classes in [none.clone(), sure(&none, Class::Positive), sure(&none, Class::Negative), none.clone()] {
            let list = runner.vertices(&classes).unwrap();
            assert!(Arc::ptr_eq(&list, &runner.vertices(&classes).unwrap()));
            let new = made(&device, &judging, &inputs).0;
            let log = |runner: &Runner| runner.classify(&classes, [6, 4]).ok();
            assert_eq!(log(&runner), log(&new));
            assert_eq!(runner.mask(&classes).unwrap().data(), new.mask(&classes).unwrap().data());
            seen.push((log(&runner), list.records.clone()));
        }
        assert_eq!(seen[0], seen[3]);
        assert!(seen[0].0.is_some() && seen[0] != seen[1] && seen[1] != seen[2] && seen[0] != seen[2], "{seen:?}");
        // A first picture lists the vertices as well, and is the same as a later one.
        for text in [&plain, &judging] {
            let classes = [none.clone(), sure(&none, Class::Positive)];
            for (drawn, asked) in [(0, 0), (0, 1), (1, 0), (1, 1)].map(|it| (&classes[it.0], &classes[it.1])) {
                let [(runner, _), (new, _)] = [made(&device, text, &inputs), made(&device, text, &inputs)];
                let first = runner.picture(Some(drawn)).unwrap();
                assert!(matches!(*runner.held(), List::Logged(_)));
                assert_eq!(runner.classify(asked, [6, 4]).ok(), new.classify(asked, [6, 4]).ok());
                assert_eq!(runner.vertices(asked).unwrap().records, new.vertices(asked).unwrap().records);
                assert!(matches!(*runner.held(), List::Read(_)));
                assert_eq!(first.data(), new.picture(Some(drawn)).unwrap().data());
                assert_eq!(first.data(), runner.picture(Some(drawn)).unwrap().data());
            }
            let (runner, _) = made(&device, text, &inputs);
            assert!(runner.picture(Some(&Classes::new(vec!["one".into()]))).is_err());
            runner.run(None).unwrap();
            assert!(matches!(*runner.held(), List::Logged(_)));
        }
        let [mut moved, mut other] = [inputs.clone(), inputs.clone()];
        moved.numbers.insert("shift".into(), vec![0.25, 3.0, 0.0, 0.0]);
        other.vertices = Some(6);
        for (text, inputs) in [(&judging, &moved), (&judging, &other), (&plain, &inputs)] {
            let (changed, _) = made(&device, text, inputs);
            let records = changed.vertices(&none).unwrap().records.clone();
            assert_eq!(records, made(&device, text, inputs).0.vertices(&none).unwrap().records);
            assert!(seen.iter().all(|(_, seen)| *seen != records) || text == &plain);
        }
    }
}
