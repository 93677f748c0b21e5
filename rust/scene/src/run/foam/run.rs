//! The foam of a fluid over the frames of a scene, in metres of the world.

use std::path::PathBuf;

use glam::{DAffine3, DVec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result};
use relievo_fluid::{Diffuse, DiffuseKind, DiffuseOptions, FluidFrame, positions_and_velocities};
use relievo_particleio::{Particles, read};
use relievo_render::foam::{Foam, FoamKind, FoamParticle, FoamSettings};

use super::FoamEntry;
use super::cache::{Cache, Found, Identity};
use crate::out::output::Folder;
use crate::state::world::World;

/// Particles that are converted at a time, so that a frame is not in memory twice.
const CHUNK: usize = 1 << 18;

/// The foam of a fluid after a frame.
#[derive(Debug)]
pub struct FoamRun {
    options: DiffuseOptions,
    look: FoamSettings,
    files: Vec<PathBuf>,
    /// From the object of the fluid to metres of the world.
    place: DAffine3,
    metres: f64,
    seconds: f64,
    diffuse: Diffuse,
    /// The frame that `diffuse` and `fluid` are at.
    frame: usize,
    fluid: Option<Particles>,
    cache: Cache,
    identity: Identity,
    /// What the foam is of, a frame each, as far as it was asked for.
    identities: Vec<String>,
    /// What the user should know.
    notes: Vec<String>,
}

impl FoamRun {
    /// Makes the foam of an object, before the first frame, with frames in the folder of the scene's cache; `None` if it has
    /// none. Fails if the object's mesh is not a sequence of files, a setting is out of range, or the folder cannot be made.
    pub fn new(context: &Context, world: &World, object: usize, cache: &Folder) -> Result<Option<Self>> {
        let scene = &world.scene;
        let entry = &scene.objects[object];
        let Some((fluid, foam)) = entry.fluid.and_then(|fluid| Some((fluid, fluid.foam?))) else { return Ok(None) };
        let FoamEntry { settings, look, has_radius } = foam;
        let files = world.sequence(object).ok_or_else(|| {
            Error::invalid("foam is made from the frames of a fluid, and the mesh is not a sequence")
                .at(format!("object `{}`", entry.name.text))
                .advise("give the mesh a `sequence` of files of particles")
        })?;
        let transform = entry.placement.transform();
        let scale = transform.matrix3.determinant().abs().cbrt();
        let look = match has_radius {
            true => look,
            false => FoamSettings { radius: (0.5 * scale * f64::from(fluid.spacing)) as f32, ..look },
        };
        let options = DiffuseOptions {
            spacing: (scale * scene.metres * f64::from(fluid.spacing)) as f32,
            gravity: (-9.81 * scene.up.direction()).as_vec3(),
            bounds: None,
            settings,
        };
        let place = DAffine3::from_scale(DVec3::splat(scene.metres)) * transform;
        let level = context.level();
        let decisive = format!("{options:?}, {place:?}, {} frames a second, level {level:?}", scene.fps);
        Ok(Some(Self {
            options,
            look,
            files: files.to_vec(),
            place,
            metres: scene.metres,
            seconds: scene.fps.recip(),
            diffuse: Diffuse::new(options)?,
            frame: 0,
            fluid: None,
            cache: Cache::new(cache, &entry.name.text)?,
            identity: Identity::new(decisive),
            identities: Vec::new(),
            notes: Vec::new(),
        }))
    }

    /// Returns how the foam is drawn.
    pub fn look(&self) -> &FoamSettings {
        &self.look
    }

    /// Returns what the user should know since the last call.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Goes to the end of a frame of the scene, from the last cached frame on the way; after the last file the foam stays as
    /// it is. Frames that are made are cached. The state of a frame does not depend on the frames that are asked for. Fails
    /// if a file cannot be read or written, or has neither velocities nor numbers.
    pub fn go_to(&mut self, context: &Context, frame: usize) -> Result<()> {
        let frame = frame.min(self.files.len().saturating_sub(1));
        if frame < self.frame {
            (self.diffuse, self.frame, self.fluid) = (Diffuse::new(self.options)?, 0, None);
        }
        self.open(context, frame)?;
        while self.frame < frame {
            let _stage = context.stats().begin("foam.generate");
            let before = match self.fluid.take() {
                Some(fluid) => fluid,
                None => read(context, &self.files[self.frame])?.particles,
            };
            let path = &self.files[self.frame + 1];
            let named = |error: Error| error.at(path.display().to_string());
            let after = read(context, path)?.particles;
            let (mut positions, mut velocities) =
                positions_and_velocities(&before, &after, self.seconds as f32).map_err(named)?;
            for (position, velocity) in positions.iter_mut().zip(&mut velocities) {
                *position = self.place.transform_point3(position.as_dvec3()).as_vec3();
                *velocity = self.place.transform_vector3(velocity.as_dvec3()).as_vec3();
            }
            let fluid = FluidFrame { positions: &positions, velocities: &velocities };
            self.diffuse.advance(context, fluid, self.seconds as f32, &mut Silent).map_err(named)?;
            self.frame += 1;
            self.fluid = Some(after);
            let at = (self.frame, self.frame as f64 * self.seconds);
            self.cache.store(context, at, &self.diffuse, &self.identities[self.frame])?;
        }
        Ok(())
    }

    /// Opens the last cached frame between this one and `frame`, if there is one.
    fn open(&mut self, context: &Context, frame: usize) -> Result<()> {
        if frame == self.frame {
            return Ok(());
        }
        for path in &self.files[self.identities.len().min(frame + 1)..=frame] {
            self.identities.push(self.identity.add(path)?);
        }
        let _stage = context.stats().begin("foam.open");
        for at in (self.frame + 1..=frame).rev() {
            match self.cache.open(context, self.options, at, &self.identities[at])? {
                Found::Absent | Found::Stale => {}
                Found::Damaged(error) => self.notes.push(format!("{error}; the foam of the frame is made again")),
                Found::Run(diffuse) => {
                    (self.diffuse, self.frame, self.fluid) = (*diffuse, at, None);
                    break;
                }
            }
        }
        Ok(())
    }

    /// Adds the particles to a picture in scene units.
    pub fn draw(&self, context: &Context, foam: &mut Foam) -> Result<()> {
        let found = self.diffuse.particles();
        let particle = |at: usize| FoamParticle {
            position: (found.positions[at] / self.metres as f32).into(),
            life: found.life(at),
            id: found.ids[at] as u32,
            kind: match found.kinds[at] {
                DiffuseKind::Spray => FoamKind::Spray,
                DiffuseKind::Foam => FoamKind::Foam,
                DiffuseKind::Bubble => FoamKind::Bubble,
            },
        };
        for first in (0..found.len()).step_by(CHUNK) {
            let chunk: Vec<_> = (first..found.len().min(first + CHUNK)).map(particle).collect();
            let velocities = found.velocities[first..first + chunk.len()].iter();
            let velocities: Vec<_> = velocities.map(|velocity| (*velocity / self.metres as f32).into()).collect();
            foam.add_moving(context, &chunk, &velocities)?;
        }
        Ok(())
    }
}
