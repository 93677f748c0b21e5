//! What the surface of particles is, and which of them it needs.

use std::cell::OnceCell;
use std::time::Instant;

use clap::ValueEnum;
use relievo_core::progress::Silent;
use relievo_core::{Context, Mesh, Result, Values};
use relievo_fluid::{Surface, SurfaceFunction, Visibility, classify, classify_on};
use relievo_gpu::Device as GraphicsDevice;
use relievo_particleio::{Channel, Particles, frame_bytes};

use crate::args::device::{Adapter, Device};

/// The channel that tells blind particles, 1, from those at the surface, 0.
const BLIND: &str = "blind";

#[derive(Clone, Copy, ValueEnum)]
pub enum Function {
    /// Blobs (Blinn 1982).
    Blobs,
    /// The distance from a mean of places (Zhu, Bridson 2005).
    ZhuBridson,
    /// The density of particles.
    Density,
    /// Kernels that are flat where particles are (Yu, Turk 2013).
    Anisotropic,
}

impl Function {
    /// The function of particles that lie this far apart at rest, in metres.
    fn of(self, spacing: f32) -> SurfaceFunction {
        let radius = 0.5 * spacing;
        match self {
            Self::Blobs => SurfaceFunction::blobs(radius),
            Self::ZhuBridson => SurfaceFunction::zhu_bridson(radius),
            Self::Density => SurfaceFunction::density(radius),
            Self::Anisotropic => SurfaceFunction::anisotropic(radius),
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kept {
    /// All.
    All,
    /// Those at the surface and blind ones, whose own surface is left out.
    Blind,
    /// Those at the surface, with what shows behind them where the others are left out.
    Surface,
}

#[derive(clap::Args)]
pub struct Options {
    /// Distance between particles at rest, in metres; without it, what the file says, or else the median distance between
    /// nearest neighbours in the first file, which is printed.
    #[arg(long, value_name = "METRES")]
    spacing: Option<f32>,
    /// What the surface is of.
    #[arg(long, value_enum, default_value_t = Function::ZhuBridson)]
    function: Function,
    /// Which of the particles are taken. Where a file has the channel `blind`, it says which are.
    #[arg(long, value_enum, default_value_t = Kept::All)]
    particles: Kept,
    /// How near the surface a particle is blind; left out, as far as it has influence.
    #[arg(long, value_name = "METRES")]
    threshold: Option<f32>,
    /// What finds the particles that are taken, and draws foam. A graphics device finds particles for all functions but
    /// anisotropic kernels.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Device,
    #[command(flatten)]
    adapter: Adapter,
    /// The spacing that was estimated for a file without one.
    #[arg(skip)]
    estimated: OnceCell<f32>,
    /// The graphics device, opened when it is first needed.
    #[arg(skip)]
    opened: OnceCell<Option<GraphicsDevice>>,
}

/// The particles that are taken.
pub struct Selection {
    /// They have no channel `blind`.
    pub particles: Particles,
    /// Which of them are blind; empty if none is.
    pub blind: Vec<bool>,
    /// What to say of how many there are: nothing, or parts of a line that end with a comma.
    pub share: String,
}

impl Options {
    /// Returns the spacing that was asked for, in metres.
    pub fn given_spacing(&self) -> Option<f32> {
        self.spacing
    }

    /// Returns how far particles are apart at rest, in metres. An estimate is printed once, and holds for all files.
    ///
    /// # Errors
    /// Neither the command nor the file says it, and it cannot be estimated.
    pub fn spacing(&self, particles: &Particles) -> Result<f32> {
        if let Some(spacing) = self.spacing.or(particles.spacing).or(self.estimated.get().copied()) {
            return Ok(spacing);
        }
        let estimate = super::spacing::estimate(&particles.points)?;
        eprintln!(
            "note: the file does not say how far particles are apart; {estimate} m is the median distance between nearest \
             neighbours, --spacing sets another"
        );
        Ok(*self.estimated.get_or_init(|| estimate))
    }

    /// The surface of particles.
    pub fn surface(&self, context: &Context, particles: &Particles) -> Result<Surface> {
        Surface::new(context, &particles.points, self.function.of(self.spacing(particles)?))
    }

    /// Whether particles may be left out.
    pub fn is_selective(&self) -> bool {
        self.particles != Kept::All
    }

    /// Whether all of these particles are there, and some of them are left out.
    pub fn is_classifying(&self, particles: &Particles) -> bool {
        self.is_selective() && flags(particles).is_none()
    }

    /// The graphics device that was asked for; none for the processor.
    pub fn device(&self, context: &Context) -> Result<Option<&GraphicsDevice>> {
        if self.opened.get().is_none() {
            let opened = self.adapter.open(self.device, context.memory_limit())?;
            return Ok(self.opened.get_or_init(|| opened).as_ref());
        }
        Ok(self.opened.get().and_then(Option::as_ref))
    }

    /// Those of the particles that are taken.
    pub fn select(&self, context: &Context, mut particles: Particles) -> Result<Selection> {
        let start = Instant::now();
        let told = flags(&particles).map(|at| particles.channels.remove(at).values);
        let told = told.map(|values| values.iter().map(|value| *value > 0.5).collect());
        if !self.is_selective() {
            return Ok(Selection { particles, blind: told.unwrap_or_default(), share: String::new() });
        }
        let blind = |blind: bool| if blind { Visibility::Blind } else { Visibility::Surface };
        let classes = match told {
            Some(told) => Vec::into_iter(told).map(blind).collect(),
            None => match self.device(context)? {
                None => {
                    let surface = self.surface(context, &particles)?;
                    classify(context, &particles.points, &surface, self.threshold, &mut Silent)?.of
                }
                Some(device) => {
                    let function = self.function.of(self.spacing(&particles)?);
                    classify_on(device, &particles.points, function, self.threshold)?.of
                }
            },
        };
        let seconds = start.elapsed().as_secs_f64();
        let is_kept = |at: &usize| match self.particles {
            Kept::All => true,
            Kept::Blind => classes[*at] != Visibility::Hidden,
            Kept::Surface => classes[*at] == Visibility::Surface,
        };
        let indices: Vec<usize> = (0..classes.len()).filter(is_kept).collect();
        let mut blind: Vec<bool> = indices.iter().map(|at| classes[*at] == Visibility::Blind).collect();
        if !blind.contains(&true) {
            blind.clear();
        }
        let kept = particles.subset(&indices);
        let part = |count: usize, all: usize| 100.0 * count as f64 / all.max(1) as f64;
        let count = |wanted| part(classes.iter().filter(|class| **class == wanted).count(), classes.len());
        let [all, left] = [frame_bytes(context, &particles)?, frame_bytes(context, &kept)?];
        let share = format!(
            "{:.1} % kept ({:.1} % at the surface and {:.1} % blind), found in {seconds:.2} s, {:.1} % of {:.2} MB a frame \
             saved, ",
            part(indices.len(), classes.len()),
            count(Visibility::Surface),
            count(Visibility::Blind),
            100.0 - part(left, all),
            all as f64 / 1e6,
        );
        Ok(Selection { particles: kept, blind, share })
    }
}

/// The place of the channel `blind` among those of particles, if they have it.
fn flags(particles: &Particles) -> Option<usize> {
    particles.channels.iter().position(|channel| channel.name == BLIND && channel.width == 1)
}

impl Selection {
    /// Its particles, with the channel `blind` where some are.
    pub fn marked(self) -> Particles {
        let Self { mut particles, blind, .. } = self;
        if !blind.is_empty() {
            let values = blind.iter().map(|blind| f32::from(u8::from(*blind))).collect();
            particles.channels.push(Channel { name: BLIND.into(), width: 1, values });
        }
        particles
    }

    /// A mesh of their surface with what they carry, but no normals of theirs, without that of blind particles: faces where
    /// these hold most of the weight.
    pub fn mesh(&self, context: &Context, surface: &Surface, cell: f32) -> Result<Mesh> {
        let weights: Vec<f32> = self.blind.iter().map(|blind| f32::from(u8::from(*blind))).collect();
        // Normals are those of the surface.
        let channels = self.particles.channels.iter().filter(|channel| channel.name != "normal");
        let channels = channels.map(|it| (it.name.as_str(), it.width as usize, it.values.as_slice()));
        let blind = (!weights.is_empty()).then_some((BLIND, 1, weights.as_slice()));
        let channels: Vec<_> =
            channels.chain(blind).map(|(name, width, values)| relievo_fluid::Channel { name, width, values }).collect();
        let mut mesh = relievo_fluid::mesh(context, surface, cell, &channels, &mut Silent)?;
        let blind = mesh.attributes.iter().position(|attribute| blind.is_some() && attribute.name == BLIND);
        if let Some(Values::F32(share)) = blind.map(|at| mesh.attributes.remove(at).values) {
            let seen = |face: &[u32; 3]| face.iter().map(|point| share[*point as usize]).sum::<f32>() <= 1.5;
            keep(&mut mesh, seen);
        }
        Ok(mesh)
    }
}

/// Leaves the triangles of which `seen` says so, with their points.
fn keep(mesh: &mut Mesh, seen: impl Fn(&[u32; 3]) -> bool) {
    mesh.corners = mesh.corners.as_chunks().0.iter().filter(|face| seen(face)).flatten().copied().collect();
    mesh.face_sizes.truncate(mesh.corners.len() / 3);
    let mut new = vec![u32::MAX; mesh.points.len()];
    mesh.corners.iter().for_each(|point| new[*point as usize] = 0);
    let kept: Vec<usize> = (0..new.len()).filter(|point| new[*point] == 0).collect();
    kept.iter().zip(0..).for_each(|(point, at)| new[*point] = at);
    mesh.corners.iter_mut().for_each(|point| *point = new[*point as usize]);
    mesh.points = kept.iter().map(|point| mesh.points[*point]).collect();
    for attribute in &mut mesh.attributes {
        let width = attribute.width as usize;
        if let Values::F32(values) = &mut attribute.values {
            *values = kept.iter().flat_map(|point| &values[point * width..][..width]).copied().collect();
        }
    }
}
