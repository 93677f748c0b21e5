//! Fluids as simulations of the server, from the descriptions that `relievo fluid sim` reads. Their frames are the files
//! that a local run writes, to the bit.

use std::path::Path;

use relievo_client::{Particles as Wanted, SurfaceForm};
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result};
use relievo_fluid::{Surface, SurfaceFunction, Visibility, classify};
use relievo_gpu::Device;
use relievo_particleio::{Channel, EXTENSION, Particles, read_frame};
use relievo_simulation::{Description, Making, Simulation as Fluid};

use crate::kind::{Kind, Opening, Simulation};
use crate::surface;

/// The kind `fluid`.
#[derive(Default)]
pub struct FluidKind {
    /// The graphics device that makes the steps; `None` for the processor.
    pub device: Option<Device>,
}

/// Bytes that a particle occupies in a solver with its neighbours, about.
const BYTES: u64 = 600;
/// The channel that is 1 for blind particles and 0 for those at the surface.
const BLIND: &str = "blind";

impl Kind for FluidKind {
    fn name(&self) -> &'static str {
        "fluid"
    }

    fn open(&self, context: &Context, opening: &Opening<'_>) -> Result<Box<dyn Simulation>> {
        let description = Description::parse(opening.description)?;
        bound(&description, opening.elements)?;
        let making = Making { format: EXTENSION.into(), parts: 1, device: self.device.clone() };
        Ok(Box::new(Fluid::begin(context, description, &opening.files, making)?))
    }

    fn change(&self, description: &str, changes: &str) -> Result<String> {
        let merged = merged(description, changes)?;
        same_rate(Description::parse(description)?.fps, Description::parse(&merged)?.fps)?;
        Ok(merged)
    }

    fn particles(&self, context: &Context, frame: &[u8]) -> Result<Particles> {
        Ok(read_frame(context, frame)?.particles)
    }

    fn select(&self, context: &Context, particles: &Particles, wanted: Wanted) -> Result<Particles> {
        if wanted == Wanted::All {
            return Ok(particles.clone());
        }
        let spacing = particles.spacing.ok_or_else(|| Error::invalid("the frame does not say its spacing"))?;
        let surface = Surface::new(context, &particles.points, SurfaceFunction::zhu_bridson(0.5 * spacing))?;
        let classes = classify(context, &particles.points, &surface, None, &mut Silent)?.of;
        let is_wanted = |class: Visibility| match wanted {
            Wanted::Surface => class == Visibility::Surface,
            _ => class != Visibility::Hidden,
        };
        let places: Vec<usize> = (0..classes.len()).filter(|at| is_wanted(classes[*at])).collect();
        let mut selected = particles.subset(&places);
        if wanted == Wanted::Blind {
            let values = places.iter().map(|at| f32::from(u8::from(classes[*at] == Visibility::Blind))).collect();
            selected.channels.push(Channel { name: BLIND.into(), width: 1, values });
        }
        Ok(selected)
    }

    fn surface(&self, context: &Context, frame: &[u8], wish: (SurfaceForm, &str), to: &Path) -> Result<()> {
        surface::write(context, &self.particles(context, frame)?, wish, to)
    }
}

/// Returns how many particles a fluid begins with, about. Fails if they are more than `elements`.
pub fn bound(description: &Description, elements: u64) -> Result<u64> {
    let estimate = description.estimate();
    if !(estimate <= elements as f64) {
        let what = format!("the fluid would begin with about {estimate:.0} particles, and {elements} are allowed");
        return Err(Error::memory(what).at("fluid.spacing").advise("use a larger spacing or less fluid"));
    }
    Ok(estimate as u64)
}

/// Returns the bytes that a fluid occupies in memory, about.
pub fn memory(fluid: &Fluid) -> u64 {
    BYTES * fluid.fluid().len() as u64
}

/// Fails if the frames of a second change.
pub fn same_rate(old: f64, new: f64) -> Result<()> {
    match old == new {
        true => Ok(()),
        false => Err(Error::invalid("the frames of a second cannot change on the way")
            .at("fps")
            .advise("submit another scene")),
    }
}

/// Returns a description with changed keys, both in TOML. Fails where one of them is not TOML.
pub fn merged(description: &str, changes: &str) -> Result<String> {
    let table = |text: &str| {
        toml::from_str::<toml::Table>(text)
            .map_err(|error| Error::invalid(error.to_string()).at("changes").advise("send keys and values in TOML"))
    };
    let mut all = table(description)?;
    merge(&mut all, table(changes)?);
    toml::to_string(&all).map_err(|error| Error::internal(error.to_string()))
}

/// Puts the keys of `changes` into `table`: tables into tables, all else in place of what is there.
fn merge(table: &mut toml::Table, changes: toml::Table) {
    for (key, change) in changes {
        match (table.get_mut(&key), change) {
            (Some(toml::Value::Table(old)), toml::Value::Table(new)) => merge(old, new),
            (_, change) => drop(table.insert(key, change)),
        }
    }
}

impl Simulation for Fluid {
    fn identity(&self) -> &str {
        self.identity()
    }

    fn last(&self) -> u64 {
        self.last()
    }

    fn frame(&self) -> u64 {
        self.step()
    }

    fn elements(&self) -> u64 {
        self.fluid().len() as u64
    }

    fn memory(&self) -> u64 {
        memory(self)
    }

    fn restore(&mut self, context: &Context, frame: &[u8]) -> Result<()> {
        self.restore(Self::decode(context, frame)?)
    }

    fn accelerate(&mut self, accelerations: &[[f32; 3]]) -> Result<()> {
        self.accelerate(accelerations)
    }

    fn advance(&mut self, context: &Context, watch: &mut dyn FnMut(f32) -> Result<()>) -> Result<()> {
        let (mut done, all) = (0.0, self.seconds());
        self.advance(context, |step| {
            done += step.seconds;
            watch((done / all).min(1.0))
        })
    }

    fn encode(&self, context: &Context) -> Result<Vec<u8>> {
        self.encode(context)
    }
}
