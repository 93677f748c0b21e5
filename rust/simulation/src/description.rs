//! Descriptions of fluids: what `relievo fluid sim` and the server simulate.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::Vec3;
use relievo_core::error::nearest;
use relievo_core::{Context, Error, Result, file};
use relievo_fluid::{
    Batch, Bodies, Channel, Excess, Fluid, FluidOptions, KernelSet, PressureSolver, Solid, TimeStep, basin, block,
};
use serde::Deserialize;

use crate::entries::{Budget, Drain, Floating, Outlet, Push, sources};
use crate::files::Source;
use crate::fill::Fill;
use crate::mover::Collider;
use crate::play::Play;
use crate::shape::{Corners, MeshFile, checksum};

/// Bytes of a description at most.
const LONGEST: u64 = 1 << 20;

/// Layers of particles that walls have, about.
const WALL_LAYERS: f64 = 3.0;
/// Files of all sequences of a description at most.
const MAX_FILES: u64 = 1 << 20;

/// A fluid, what it begins as, and how many frames of it there are.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Frames after the first, which is what the fluid begins as.
    pub frames: u32,
    /// Frames a second.
    #[serde(default = "fps")]
    pub fps: f64,
    #[serde(default)]
    fluid: Options,
    basin: Option<Corners>,
    #[serde(default)]
    block: Vec<Block>,
    #[serde(default)]
    fill: Vec<Fill>,
    #[serde(default)]
    collider: Vec<Collider>,
    #[serde(default)]
    body: Vec<Floating>,
    #[serde(default)]
    emitter: Vec<Outlet>,
    #[serde(default)]
    sink: Vec<Drain>,
    #[serde(default)]
    force: Vec<Push>,
    budget: Option<Budget>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Options {
    spacing: f32,
    density: f32,
    viscosity: f32,
    friction: f32,
    cohesion: f32,
    tension: f32,
    gravity: [f32; 3],
    kernels: String,
    solver: String,
    excess: [f32; 2],
    corrections: [u32; 2],
    time_step: Option<f32>,
    courant: f32,
    longest_step: f32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Block {
    low: [f32; 3],
    high: [f32; 3],
    #[serde(default)]
    velocity: [f32; 3],
}

impl Default for Options {
    fn default() -> Self {
        let FluidOptions {
            spacing, density, viscosity, friction, cohesion, tension, gravity, excess, corrections, ..
        } = FluidOptions::default();
        let excess = [excess.most, excess.mean];
        let TimeStep::Courant { number, most } = FluidOptions::default().time_step else { unreachable!() };
        Self {
            spacing,
            density,
            viscosity,
            friction,
            cohesion,
            tension,
            gravity: gravity.into(),
            kernels: "wendland".into(),
            solver: "pcisph".into(),
            excess,
            corrections,
            time_step: None,
            courant: number,
            longest_step: most,
        }
    }
}

fn fps() -> f64 {
    24.0
}

/// What a description is refused for, with the name that may be meant where one is unknown.
fn unfit(error: &toml::de::Error) -> Error {
    let told = Error::invalid(error.to_string());
    let mut names = error.message().split('`').skip(1).step_by(2);
    let word = names.next().filter(|_| error.message().starts_with("unknown"));
    match word.and_then(|word| nearest(word, names)) {
        Some(name) => told.advise(format!("perhaps `{name}` is meant")),
        None => told,
    }
}

impl Description {
    /// Parses the text of a description.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is longer than 1 MiB, is no TOML, has unknown keys or values that do not fit, a rate
    /// of frames that cannot be, or too many files.
    pub fn parse(text: &str) -> Result<Self> {
        if text.len() as u64 > LONGEST {
            return Err(Error::invalid("the description is longer than 1 MiB").advise("put meshes into files"));
        }
        let read: Self = toml::from_str(text).map_err(|error| unfit(&error))?;
        if !(read.fps > 1e-3 && read.fps < 1e6) {
            let error = Error::invalid(format!("{} frames a second cannot be", read.fps)).at("fps");
            return Err(error.advise("use more than 0.001 and less than 1000000"));
        }
        let files = read.collider.iter().map(Collider::count).fold(0u64, u64::saturating_add);
        if files > MAX_FILES {
            return Err(
                Error::invalid(format!("its sequences have {files} files")).advise(format!("use at most {MAX_FILES}"))
            );
        }
        Ok(read)
    }

    /// Estimates the particles that the fluid begins with, from the volumes of blocks, boxes and spheres and the areas of the
    /// basin. Meshes and grids that are filled are not counted.
    pub fn estimate(&self) -> f64 {
        let spacing = f64::from(self.fluid.spacing);
        let sides =
            |low: [f32; 3], high: [f32; 3]| [0, 1, 2].map(|axis| f64::from(high[axis] - low[axis]).max(0.0) / spacing);
        let blocks = self.block.iter().map(|block| sides(block.low, block.high).iter().product::<f64>());
        let fills = self.fill.iter().map(|fill| fill.volume() / spacing.powi(3));
        let walls = self.basin.iter().map(|basin| {
            let [x, y, z] = sides(basin.low, basin.high);
            2.0 * WALL_LAYERS * (x * y + y * z + z * x)
        });
        blocks.chain(fills).chain(walls).sum()
    }

    /// Lists the files that the description names, each once, as it writes them.
    ///
    /// # Errors
    /// Fails with `Invalid` if a collider names files of a sequence without one, or how many they are is not said.
    pub fn files(&self) -> Result<BTreeSet<PathBuf>> {
        let mut names = BTreeSet::new();
        let meshes = self.fill.iter().filter_map(Fill::mesh).chain(self.body.iter().filter_map(Floating::mesh));
        let meshes = meshes.chain(self.emitter.iter().filter_map(Outlet::mesh));
        for mesh in meshes.chain(self.sink.iter().filter_map(Drain::mesh)) {
            names.extend(mesh.files());
        }
        for collider in &self.collider {
            names.extend(collider.meshes()?.iter().flat_map(MeshFile::files));
        }
        names.extend(self.fill.iter().filter_map(Fill::grid).map(Path::to_owned));
        Ok(names)
    }

    /// Reads a description.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file does not exist or cannot be read, with `Memory` if it is longer than 1
    /// MiB, and as [`Self::parse`] does.
    pub fn read(path: &Path) -> Result<Self> {
        let named = |error: Error| error.at(path.display().to_string());
        let bytes = file::load(path, LONGEST)?;
        let text = std::str::from_utf8(&bytes).map_err(|_| named(Error::invalid("it is not UTF-8 text")))?;
        Self::parse(text).map_err(named)
    }

    /// Opens what moves, comes and goes on the way.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if a file that it names cannot be read, with `Memory` if one exceeds the context's
    /// memory limit, and with `Invalid` if a collider, an emitter or a sink has no shape, more than one, or numbers out
    /// of range.
    pub fn play(&self, context: &Context, files: &Source) -> Result<Play> {
        let numbered = self.collider.iter().enumerate();
        let movers = numbered.map(|(number, collider)| {
            collider.mover(context, files, self.fps).map_err(|error| error.at(format!("collider {number}")))
        });
        let entries = (self.emitter.as_slice(), self.sink.as_slice(), self.budget.as_ref());
        Ok(Play {
            movers: movers.collect::<Result<_>>()?,
            sources: sources(context, files, self.spacing(), entries)?,
            bodies: Bodies::new(
                self.fluid.gravity.into(),
                self.basin.map(|basin| [basin.low, basin.high].map(Vec3::from)),
            ),
        })
    }

    /// All that decides what the frames are, but not how many there are: the description, and a line for each file that it
    /// names, with a checksum of what is in it.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if a file that it names cannot be read, with `Memory` if one exceeds the context's
    /// memory limit, and with `Invalid` if a mesh file is damaged or how many files a sequence has is not said.
    pub fn identity(&self, context: &Context, files: &Source) -> Result<String> {
        let text = format!("{self:?}").replacen(&format!("frames: {}, ", self.frames), "", 1);
        // Each once.
        let mut lines = BTreeSet::new();
        let meshes = self.fill.iter().filter_map(Fill::mesh).chain(self.body.iter().filter_map(Floating::mesh));
        let meshes = meshes.chain(self.emitter.iter().filter_map(Outlet::mesh));
        for mesh in meshes.chain(self.sink.iter().filter_map(Drain::mesh)) {
            lines.extend(mesh.checksums(context, files)?);
        }
        for mesh in self.collider.iter().map(Collider::meshes).collect::<Result<Vec<_>>>()?.iter().flatten() {
            lines.extend(mesh.checksums(context, files)?);
        }
        for grid in self.fill.iter().filter_map(Fill::grid) {
            lines.insert(checksum(context, files, grid)?);
        }
        Ok(lines.iter().fold(text, |text, line| text + "\n" + line))
    }

    /// The spacing of particles.
    pub fn spacing(&self) -> f32 {
        self.fluid.spacing
    }

    /// Returns the acceleration of gravity, in m/s².
    pub fn gravity(&self) -> Vec3 {
        self.fluid.gravity.into()
    }

    /// Returns the low and the high corner of the basin, in metres, if there is one.
    pub fn basin(&self) -> Option<[Vec3; 2]> {
        self.basin.as_ref().map(|basin| [basin.low.into(), basin.high.into()])
    }

    /// The fluid as it begins, with its bodies.
    ///
    /// # Errors
    /// Fails with `Invalid` if a number is out of range, there are no such kernels or solver, or a shape cannot be
    /// filled; with `NotFound` or `Io` if a file that it names cannot be read; and with `Memory` if there are too many
    /// particles or a file exceeds the context's memory limit.
    pub fn begin(&self, context: &Context, files: &Source, play: &mut Play) -> Result<Fluid> {
        let options = &self.fluid;
        let kernels = match options.kernels.as_str() {
            "wendland" => KernelSet::Wendland,
            "mueller" => KernelSet::Mueller,
            other => {
                let error = Error::invalid(format!("there are no kernels {other:?}")).at("fluid.kernels");
                return Err(error.advise("use wendland or mueller"));
            }
        };
        let solver = match options.solver.as_str() {
            "pcisph" => PressureSolver::Pcisph,
            "dfsph" => PressureSolver::Dfsph,
            other => {
                let error = Error::invalid(format!("there is no solver {other:?}")).at("fluid.solver");
                return Err(error.advise("use pcisph or dfsph"));
            }
        };
        let [most, mean] = options.excess;
        let courant = TimeStep::Courant { number: options.courant, most: options.longest_step };
        let mut fluid = Fluid::new(FluidOptions {
            spacing: options.spacing,
            density: options.density,
            viscosity: options.viscosity,
            friction: options.friction,
            cohesion: options.cohesion,
            tension: options.tension,
            gravity: options.gravity.into(),
            kernels,
            solver,
            excess: Excess { most, mean },
            corrections: options.corrections,
            time_step: options.time_step.map_or(courant, TimeStep::Fixed),
        })?;
        for (number, Block { low, high, velocity }) in self.block.iter().enumerate() {
            let named = |error: Error| error.at(format!("block {number}"));
            let places = block(Vec3::from(*low), Vec3::from(*high), options.spacing).map_err(named)?;
            fluid.add(&places, Vec3::from(*velocity)).map_err(named)?;
        }
        if let Some(Corners { low, high }) = &self.basin {
            let places = basin(Vec3::from(*low), Vec3::from(*high), options.spacing);
            fluid.set_walls(context, &places.map_err(|error| error.at("basin"))?)?;
        }
        for mover in &play.movers {
            fluid.add_collider(context, &mover.at(context, 0.0)?, &mover.triangles, mover.options)?;
        }
        // Bodies have them as obstacles, by the same numbers.
        for mover in play.movers.iter().filter(|_| !self.body.is_empty()) {
            let number = play.bodies.add_obstacle(&mover.points, &mover.triangles)?;
            play.bodies.move_obstacle(number, [mover.pose(0.0); 2])?;
        }
        let mut floating = Vec::new();
        for (number, body) in self.body.iter().enumerate() {
            let named = |error: Error| error.at(format!("body {number}"));
            let ((points, triangles), options) = body.body(context, files).map_err(named)?;
            play.bodies.add(context, &mut fluid, (&points, &triangles), &options)?;
            floating.push(Solid::new(&points, &triangles).map_err(named)?);
        }
        let forces: Vec<_> = self.force.iter().map(Push::force).collect();
        fluid.set_forces(&forces)?;
        self.fill(context, files, (play, floating), &mut fluid)?;
        Ok(fluid)
    }

    /// Fills shapes, but not where walls, colliders and bodies are.
    fn fill(
        &self,
        context: &Context,
        files: &Source,
        (play, bodies): (&Play, Vec<Solid>),
        fluid: &mut Fluid,
    ) -> Result<()> {
        let movers = play.movers.iter().filter(|mover| !mover.options.is_container);
        let mut obstacles = bodies;
        for mover in movers {
            obstacles.push(Solid::new(&mover.at(context, 0.0)?, &mover.triangles)?);
        }
        for (number, fill) in self.fill.iter().enumerate() {
            let named = |error: Error| error.at(format!("fill {number}"));
            let places = fill.places(context, files, self.spacing()).map_err(named)?;
            let mut places = fluid.beside_walls(context, &places).map_err(named)?;
            places.retain(|place| !obstacles.iter().any(|solid| solid.is_inside(*place)));
            let channels: Vec<Channel> =
                fill.color.iter().map(|color| Channel { name: "color", width: 3, values: color }).collect();
            let velocities = [Vec3::from(fill.velocity)];
            let batch =
                Batch { places: &places, velocities: &velocities, lifetime: f32::INFINITY, channels: &channels };
            fluid.add_batch(&batch).map_err(named)?;
        }
        Ok(())
    }
}
