//! Foam as simulations of the server: fluids with a table `foam` in their descriptions. The particles of a frame are those of
//! the foam, its surface is that of the fluid.

use std::path::Path;

use relievo_client::{Particles as Wanted, SurfaceForm};
use relievo_core::{Context, Error, Result};
use relievo_particleio::{EXTENSION, Particles, read_frame};
use relievo_simulation::{Foam, FoamDescription, Making};

use crate::fluid::{bound, memory, merged, same_rate};
use crate::kind::{Kind, Opening, Simulation};
use crate::surface;

/// The kind `foam`. The processor simulates it.
pub struct FoamKind;

/// Bytes that a diffuse particle occupies, about.
const BYTES: u64 = 64;

impl Kind for FoamKind {
    fn name(&self) -> &'static str {
        "foam"
    }

    fn open(&self, context: &Context, opening: &Opening<'_>) -> Result<Box<dyn Simulation>> {
        let mut description = FoamDescription::parse(opening.description)?;
        let fluid = bound(&description.fluid, opening.elements)?;
        let room = u32::try_from(opening.elements - fluid).unwrap_or(u32::MAX);
        description.options.settings.most = description.options.settings.most.min(room);
        let making = Making { format: EXTENSION.into(), parts: 1, device: None };
        Ok(Box::new(Foam::begin(context, description, &opening.files, making)?))
    }

    fn change(&self, description: &str, changes: &str) -> Result<String> {
        let merged = merged(description, changes)?;
        let [old, new] = [description, &merged].map(|text| FoamDescription::parse(text).map(|it| it.fluid.fps));
        same_rate(old?, new?)?;
        Ok(merged)
    }

    fn particles(&self, context: &Context, frame: &[u8]) -> Result<Particles> {
        Ok(read_frame(context, frame)?.particles)
    }

    fn select(&self, _: &Context, particles: &Particles, wanted: Wanted) -> Result<Particles> {
        match wanted {
            Wanted::All => Ok(particles.clone()),
            _ => Err(Error::unsupported("particles of foam are not at the surface or blind")
                .at("particles")
                .advise("ask for all")),
        }
    }

    fn surface(&self, context: &Context, frame: &[u8], wish: (SurfaceForm, &str), to: &Path) -> Result<()> {
        let water = Foam::water(context, frame)?;
        surface::write(context, &read_frame(context, &water)?.particles, wish, to)
    }
}

impl Simulation for Foam {
    fn identity(&self) -> &str {
        self.identity()
    }

    fn last(&self) -> u64 {
        self.fluid().last()
    }

    fn frame(&self) -> u64 {
        self.fluid().step()
    }

    fn elements(&self) -> u64 {
        (self.fluid().fluid().len() + self.len()) as u64
    }

    fn memory(&self) -> u64 {
        memory(self.fluid()) + BYTES * self.len() as u64
    }

    fn restore(&mut self, context: &Context, frame: &[u8]) -> Result<()> {
        self.restore(context, frame)
    }

    fn accelerate(&mut self, _: &[[f32; 3]]) -> Result<()> {
        Err(Error::unsupported("foam takes no accelerations by the host").advise("submit the scene without `forced`"))
    }

    fn advance(&mut self, context: &Context, watch: &mut dyn FnMut(f32) -> Result<()>) -> Result<()> {
        let mut stopped = Ok(());
        let mut progress = |fraction: f32, _: &str| {
            stopped = watch(fraction);
            stopped.is_ok()
        };
        let advanced = self.advance(context, &mut progress);
        stopped.and(advanced)
    }

    fn encode(&self, context: &Context) -> Result<Vec<u8>> {
        self.encode(context)
    }
}
