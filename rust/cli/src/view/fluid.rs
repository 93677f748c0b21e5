//! A simulation of a fluid in the window: it and its foam are baked there, or were by `relievo fluid sim`.

use std::path::{Path, PathBuf};

use glam::DVec3;
use relievo_core::progress::Silent;
use relievo_core::{Context, Progress, Result};
use relievo_fluid::{DiffuseOptions, DiffuseSettings, Surface, SurfaceFunction};
use relievo_particleio::Format;
use relievo_simulation::{Description, Making, Simulation};
use relievo_view::show::{Bake, Ball, Eye, Frames, Picture, Range, Setting, Subject};

use super::baker::Baker;
use super::particles::{ParticleFrames, WATER};
use super::scene::placed;
use crate::fluid::{FluidRun, beside};
use crate::foam::FoamRun;

/// The folder of the frames of foam, in that of the fluid's.
const FOAM: &str = "foam";

/// The share of a bake that the fluid takes; foam takes the rest.
const SHARE: f32 = 0.8;

/// Cells of the surface, in distances of particles at rest.
const CELL: f32 = 0.75;

/// Linear Rec.709, of foam.
const WHITE: [f32; 3] = [0.85, 0.88, 0.9];

/// Colours of spray, foam and bubbles, where each kind has its own.
const KINDS: [([f32; 3], &str); 3] = [([0.95, 0.55, 0.12], "spray"), (WHITE, "foam"), ([0.1, 0.75, 0.35], "bubbles")];

/// The share of the longest life of foam that the shortest has.
const LEAST_LIFE: f64 = 0.4;

/// The first of the settings that foam is baked with.
const FIRST: usize = 4;

/// A fluid over time.
pub struct FluidFrames {
    context: Context,
    name: String,
    file: PathBuf,
    out: PathBuf,
    rate: f64,
    /// With the first one, which is what the fluid begins as.
    count: usize,
    /// Metres between particles at rest.
    spacing: f32,
    basin: Option<[DVec3; 2]>,
    /// Of foam, but for the settings.
    options: DiffuseOptions,
    /// Settings of foam, and whether the foam that is there lacks frames or was made with others.
    known: Option<(DiffuseSettings, bool)>,
    /// What the fluid begins as, once a frame was asked for that is not baked.
    start: Option<Vec<Ball>>,
    /// The frames that were baked when they were listed last.
    water: Option<ParticleFrames>,
    baker: Option<Baker>,
}

impl FluidFrames {
    /// Opens a description whose frames are in the folder `out`, or will be.
    pub fn open(context: Context, path: &Path, out: &Path) -> Result<Self> {
        let description = Description::read(path)?;
        let (count, rate, spacing) = (description.frames as usize + 1, description.fps, description.spacing());
        let options = options(&description);
        let basin = description.basin().map(|corners| corners.map(|corner| corner.as_dvec3()));
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let (file, out) = (path.to_owned(), out.to_owned());
        Ok(Self {
            context,
            name,
            file,
            out,
            rate,
            count,
            spacing,
            basin,
            options,
            known: None,
            start: None,
            water: None,
            baker: None,
        })
    }

    /// Returns what the fluid begins as.
    fn start(&mut self) -> Result<&[Ball]> {
        if self.start.is_none() {
            let named = |error: relievo_core::Error| error.at(self.file.display().to_string());
            let making = Making { format: Format::Cache.extension().to_owned(), parts: 1, device: None };
            let description = Description::read(&self.file)?;
            let simulation =
                Simulation::begin(&self.context, description, &beside(&self.file), making).map_err(named)?;
            let points = simulation.checkpoint().state.particles(self.spacing).points;
            let ball = |center| Ball { center, radius: 0.5 * self.spacing, color: WATER };
            self.start = Some(points.into_iter().map(ball).collect());
        }
        Ok(self.start.as_deref().unwrap_or_default())
    }

    /// Makes the mesh of the surface of balls.
    fn surface(&self, balls: &[Ball]) -> Result<relievo_render::Mesh> {
        let points: Vec<[f32; 3]> = balls.iter().map(|ball| ball.center).collect();
        let surface = Surface::new(&self.context, &points, SurfaceFunction::zhu_bridson(0.5 * self.spacing))?;
        let mesh = relievo_fluid::mesh(&self.context, &surface, CELL * self.spacing, &[], &mut Silent)?;
        Ok(placed(mesh, &glam::DAffine3::IDENTITY, WATER))
    }

    /// Returns whether foam of a fluid that is baked lacks frames, or was made with other settings.
    fn lacks_foam(&mut self, settings: DiffuseSettings) -> bool {
        if let Some((known, lacks)) = &self.known
            && *known == settings
        {
            return *lacks;
        }
        let foam = self.out.join(FOAM);
        let last = self.water.as_ref().map_or_else(String::new, |water| water.file_name(self.count - 1));
        let is_whole = foam.join(last).is_file();
        let fits = relievo_particleio::frames(&self.out).and_then(|fluid| {
            let (format, fps) = (Format::Cache, self.rate);
            let run = FoamRun { fluid: &fluid, folder: &self.out, output: &foam, format, restarts: false, fps };
            run.fits(&self.context, &DiffuseOptions { settings, ..self.options })
        });
        // What cannot be read is made anew, or says why it cannot.
        let lacks = !is_whole || !matches!(fits, Ok(Some(true)));
        self.known = Some((settings, lacks));
        lacks
    }

    /// Lists the frames again if the next one is there, and returns how many there are.
    fn list(&mut self) -> Result<usize> {
        let known = self.water.as_ref().map_or(0, ParticleFrames::len);
        let next = self.out.join(format!("{known:04}.{}", Format::Cache.extension()));
        if known < self.count && next.exists() {
            self.water = Some(ParticleFrames::open(self.context.clone(), &self.out, self.rate)?);
        }
        Ok(self.water.as_ref().map_or(0, ParticleFrames::len).min(self.count))
    }
}

/// What foam of a fluid is made with at first.
fn options(description: &Description) -> DiffuseOptions {
    DiffuseOptions {
        spacing: description.spacing(),
        gravity: description.gravity(),
        bounds: description.basin(),
        settings: DiffuseSettings::default(),
    }
}

/// The settings of foam that the window shows.
fn foam_of(values: &[f64]) -> DiffuseSettings {
    let value = |at: usize, other: f64| values.get(FIRST + at).copied().unwrap_or(other);
    let plain = DiffuseSettings::default();
    let rate = value(0, f64::from(plain.air_rate)) as f32;
    let life = value(1, f64::from(plain.lifetime_max));
    let [spray, bubbles] = [(2, plain.spray_below), (3, plain.bubbles_above)]
        .map(|(at, other)| value(at, f64::from(other)).round() as u32);
    DiffuseSettings {
        air_rate: rate,
        crest_rate: rate,
        lifetime_min: (LEAST_LIFE * life) as f32,
        lifetime_max: life as f32,
        spray_below: spray,
        bubbles_above: bubbles.max(spray),
        ..plain
    }
}

/// Bakes the frames of a fluid that are missing, and then those of its foam: all of them if they were made with other settings.
fn bake(
    context: &Context,
    (file, out): (&Path, &Path),
    settings: DiffuseSettings,
    progress: &mut dyn Progress,
) -> Result<String> {
    let run = FluidRun { file, output: out, format: Format::Cache, parts: 1, restarts: false, device: None };
    let description = Description::read(file)?;
    let options = DiffuseOptions { settings, ..options(&description) };
    let fps = description.fps;
    let done = run.go(context, description, &mut |share: f32, stage: &str| progress.report(SHARE * share, stage))?;
    let (fluid, foam) = (relievo_particleio::frames(out)?, out.join(FOAM));
    let run = FoamRun { fluid: &fluid, folder: out, output: &foam, format: Format::Cache, restarts: false, fps };
    if run.fits(context, &options)? == Some(false) {
        run.clear()?;
    }
    let mut later = |share: f32, stage: &str| progress.report(SHARE + (1.0 - SHARE) * share, &format!("foam: {stage}"));
    let white = run.go(context, &|_| Ok(options), &mut later)?;
    Ok(format!("{} particles and {} of foam, in {}", done.count, white.count, out.display()))
}

impl Subject for FluidFrames {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn frames(&self) -> Frames {
        Frames { count: self.count, rate: self.rate }
    }

    fn settings(&self) -> Vec<Setting> {
        let plain = DiffuseSettings::default();
        vec![
            Setting {
                name: "Water".into(),
                hint: "Its particles, coloured plainly or by their speed, or its surface".into(),
                range: Range::Choice(["particles", "velocity", "surface"].map(str::to_owned).to_vec()),
                value: 0.0,
            },
            Setting {
                name: "Size".into(),
                hint: "Of a ball, in distances of particles at rest".into(),
                range: Range::Slider { least: 0.1, most: 3.0, is_logarithmic: true, is_whole: false },
                value: 1.0,
            },
            Setting {
                name: "Foam".into(),
                hint: "Its particles, white or with a colour for each kind".into(),
                range: Range::Choice(["white", "kinds", "hidden"].map(str::to_owned).to_vec()),
                value: 0.0,
            },
            Setting {
                name: "Radius of foam".into(),
                hint: "Of a ball of foam, in distances of particles at rest".into(),
                range: Range::Slider { least: 0.01, most: 1.0, is_logarithmic: true, is_whole: false },
                value: 0.15,
            },
            Setting {
                name: "Amount of foam".into(),
                hint:
                    "Particles that a particle of the water makes in a second where it is wildest. Bake makes foam anew"
                        .into(),
                range: Range::Slider { least: 10.0, most: 1e5, is_logarithmic: true, is_whole: true },
                value: f64::from(plain.air_rate),
            },
            Setting {
                name: "Life of foam".into(),
                hint: "Seconds that foam lives at most; at least it lives two fifths of them. Bake makes foam anew"
                    .into(),
                range: Range::Slider { least: 0.1, most: 60.0, is_logarithmic: true, is_whole: false },
                value: f64::from(plain.lifetime_max),
            },
            Setting {
                name: "Spray below".into(),
                hint: "Particles with fewer neighbours in the water fly as spray. Bake makes foam anew".into(),
                range: Range::Slider { least: 0.0, most: 40.0, is_logarithmic: false, is_whole: true },
                value: f64::from(plain.spray_below),
            },
            Setting {
                name: "Bubbles above".into(),
                hint: "Particles with more neighbours in the water rise as bubbles. Bake makes foam anew".into(),
                range: Range::Slider { least: 0.0, most: 80.0, is_logarithmic: false, is_whole: true },
                value: f64::from(plain.bubbles_above),
            },
        ]
    }

    fn bounds(&self) -> Option<[DVec3; 2]> {
        self.basin
    }

    fn bake(&mut self, values: &[f64]) -> Option<Bake> {
        // What cannot be read is an error of the picture.
        let frames = self.list().unwrap_or(0);
        let missing = Bake { stage: format!("{frames} of {} frames are baked", self.count), ..Bake::default() };
        let state = self.baker.as_ref().map_or(missing, Baker::state);
        if state.is_running {
            self.known = None;
        }
        let has_more = !state.is_running && frames == self.count && self.lacks_foam(foam_of(values));
        Some(Bake { frames, has_more, ..state })
    }

    fn begin_bake(&mut self, values: &[f64]) {
        let (context, file, out) = (self.context.clone(), self.file.clone(), self.out.clone());
        let settings = foam_of(values);
        self.known = None;
        self.baker = Some(Baker::start(move |progress| bake(&context, (&file, &out), settings, progress)));
    }

    fn stop_bake(&mut self) {
        self.baker.iter().for_each(Baker::stop);
    }

    fn picture(&mut self, frame: usize, values: &[f64], _: &Eye) -> Result<Picture> {
        let [shown, size, foam_shown, foam_size] = [0, 1, 2, 3].map(|at| values.get(at).copied().unwrap_or_default());
        let channel = (shown == 1.0).then_some(relievo_particleio::VELOCITY);
        self.list()?;
        let mut picture = match self.water.as_mut().filter(|water| frame < water.len()) {
            Some(water) => water.balls(frame, channel, size as f32)?,
            None => {
                let start = self.start()?;
                let balls = start.iter().map(|ball| Ball { radius: ball.radius * size as f32, ..*ball }).collect();
                let facts = vec![format!("frame {frame} is not baked yet"), format!("{} particles", start.len())];
                Picture { balls, facts, ..Picture::default() }
            }
        };
        if shown == 2.0 {
            picture.mesh = self.surface(&std::mem::take(&mut picture.balls))?;
        }
        let name = self.water.as_ref().map_or_else(String::new, |water| water.file_name(frame));
        let foam = self.out.join(FOAM).join(name);
        if foam.is_file() && foam_shown < 2.0 {
            let particles = relievo_particleio::read(&self.context, &foam)?.particles;
            let radius = foam_size as f32 * self.spacing;
            picture.facts.push(format!("{} particles of foam", particles.points.len()));
            let channel = particles.channels.iter().find(|channel| foam_shown == 1.0 && channel.name == "type");
            let kinds = channel.map_or(&[][..], |channel| &channel.values);
            let color =
                |at: usize| kinds.get(at).and_then(|kind| KINDS.get(*kind as usize)).map_or(WHITE, |(color, _)| *color);
            let balls = particles.points.iter().enumerate();
            picture.balls.extend(balls.map(|(at, center)| Ball { center: *center, radius, color: color(at) }));
            if foam_shown == 1.0 {
                picture.legend.extend(KINDS.map(|(color, name)| (color, name.to_owned())));
            }
            if self.known.is_some_and(|(_, lacks)| lacks) {
                picture.facts.push("foam was baked with other settings".into());
            }
        }
        Ok(picture)
    }
}
