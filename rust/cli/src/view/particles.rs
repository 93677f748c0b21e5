//! Frames of particles in the window: a file, or a folder of frames that is played.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_particleio::Particles;
use relievo_view::show::{Ball, Eye, Frames, Picture, Range, Setting, Subject};

use crate::tissue::picture::{scale, viridis};

/// Frames that are kept in memory.
const KEPT: usize = 48;

/// Linear Rec.709.
pub const WATER: [f32; 3] = [0.07, 0.23, 0.5];

/// Channels that colours may stand for.
const MAX_CHANNELS: usize = 12;

/// Particles over time.
pub struct ParticleFrames {
    context: Context,
    name: String,
    files: Vec<PathBuf>,
    rate: f64,
    /// Half the distance of particles at rest.
    radius: f32,
    /// Channels of the first frame with one or three numbers.
    channels: Vec<String>,
    kept: VecDeque<(usize, Arc<Particles>)>,
}

impl ParticleFrames {
    /// Opens a file, or the frames in a folder, which are shown `rate` a second.
    pub fn open(context: Context, path: &Path, rate: f64) -> Result<Self> {
        let files = match path.is_dir() {
            true => relievo_particleio::frames(path)?.into_iter().map(|(_, path)| path).collect(),
            false => vec![path.to_owned()],
        };
        let Some(first) = files.first() else {
            return Err(Error::invalid("there are no frames of particles in the folder")
                .at(path.display().to_string())
                .advise("name a folder that `relievo fluid sim` wrote, or one with files like 0001.bgeo"));
        };
        let particles = relievo_particleio::read(&context, first)?.particles;
        let radius = 0.5 * particles.spacing.unwrap_or_else(|| spacing(&particles.points));
        let shown = particles.channels.iter().filter(|channel| matches!(channel.width, 1 | 3));
        let channels = shown.map(|channel| channel.name.clone()).take(MAX_CHANNELS).collect();
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self { context, name, files, rate, radius, channels, kept: VecDeque::new() })
    }

    /// Makes the picture of a frame, with colours of a channel and balls of `size` distances of particles at rest.
    pub fn balls(&mut self, frame: usize, channel: Option<&str>, size: f32) -> Result<Picture> {
        let particles = self.read(frame)?;
        let channel = channel.and_then(|name| particles.channel(name));
        let lengths = channel.map(|channel| {
            let length = |part: &[f32]| part.iter().map(|value| value * value).sum::<f32>().sqrt();
            channel.values.chunks_exact(channel.width as usize).map(length).collect::<Vec<f32>>()
        });
        let mut picture = Picture::default();
        let most = lengths.as_ref().map(|lengths| {
            let unit =
                if channel.is_some_and(|channel| channel.name == relievo_particleio::VELOCITY) { "m/s" } else { "" };
            let (most, legend) = scale(lengths.clone(), None, unit);
            picture.legend = legend;
            most
        });
        let color =
            |at: usize| lengths.as_ref().and_then(|lengths| Some(viridis(lengths.get(at)? / most?))).unwrap_or(WATER);
        let balls = particles.points.iter().enumerate();
        let radius = self.radius * size;
        picture.balls = balls.map(|(at, center)| Ball { center: *center, radius, color: color(at) }).collect();
        picture.facts = vec![self.file_name(frame), format!("{} particles", particles.points.len())];
        picture.facts.extend(particles.time.map(|time| format!("{time:.4} s")));
        Ok(picture)
    }

    /// Returns how many frames there are.
    pub fn len(&self) -> usize {
        self.files.len()
    }

    /// Returns the name of the file of a frame, empty where there is none.
    pub fn file_name(&self, frame: usize) -> String {
        let name = self.files.get(frame).and_then(|file| file.file_name());
        name.unwrap_or_default().to_string_lossy().into_owned()
    }

    fn read(&mut self, frame: usize) -> Result<Arc<Particles>> {
        if let Some((_, found)) = self.kept.iter().find(|(kept, _)| *kept == frame) {
            return Ok(Arc::clone(found));
        }
        let file = self.files.get(frame).ok_or_else(|| Error::invalid(format!("there is no frame {frame}")))?;
        let read = Arc::new(relievo_particleio::read(&self.context, file)?.particles);
        if self.kept.len() == KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back((frame, Arc::clone(&read)));
        Ok(read)
    }
}

/// A distance of particles, where they fill their box evenly.
pub fn spacing(points: &[[f32; 3]]) -> f32 {
    let places = || points.iter().map(|point| glam::Vec3::from(*point));
    let (low, high) = (places().reduce(glam::Vec3::min), places().reduce(glam::Vec3::max));
    let size = high.unwrap_or_default() - low.unwrap_or_default();
    let volume = size.max(glam::Vec3::splat(0.05 * size.max_element())).element_product();
    (volume / points.len().max(1) as f32).cbrt().max(f32::MIN_POSITIVE)
}

impl Subject for ParticleFrames {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn frames(&self) -> Frames {
        Frames { count: self.files.len(), rate: self.rate }
    }

    fn settings(&self) -> Vec<Setting> {
        let plain = std::iter::once("plain".to_owned());
        vec![
            Setting {
                name: "Colours show".into(),
                hint: "A channel: a number, or the length of three".into(),
                range: Range::Choice(plain.chain(self.channels.iter().cloned()).collect()),
                value: 0.0,
            },
            Setting {
                name: "Size".into(),
                hint: "Of a ball, in distances of particles at rest".into(),
                range: Range::Slider { least: 0.1, most: 3.0, is_logarithmic: true, is_whole: false },
                value: 1.0,
            },
        ]
    }

    fn picture(&mut self, frame: usize, values: &[f64], _: &Eye) -> Result<Picture> {
        let [shown, size] = [0, 1].map(|at| values.get(at).copied().unwrap_or_default());
        let channel = (shown as usize).checked_sub(1).and_then(|at| self.channels.get(at)).cloned();
        self.balls(frame, channel.as_deref(), size as f32)
    }
}
