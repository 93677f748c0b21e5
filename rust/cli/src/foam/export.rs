//! `relievo foam export`: foam for renderers that draw particles or media themselves.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use glam::DVec3;
use relievo_core::{Budget, Context, Error, Result, file};
use relievo_particleio::{Channel, Particles, write};
use relievo_render::foam::{Extinction, FoamKind, FoamParticle, FoamSettings, radius};
use relievo_scene::df3::write_df3;
use relievo_scene::foam::for_each_part;

use super::picture::Settings;
use super::source::Source;
use crate::Outcome;
use crate::args::limits::Limits;

#[derive(clap::Args)]
pub struct Arguments {
    /// The frame of foam.
    foam: PathBuf,
    /// The file: .df3 for media of POV-Ray, with a file .inc beside it that declares the medium; or .ply, .vtk, .bgeo or .vdb
    /// for particles with the channel `radius`, which renderers draw as spheres.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Kinds of particles; left out, all kinds. May be repeated.
    #[arg(long = "kind", value_enum)]
    kinds: Vec<Kind>,
    /// The edge of a cell of .df3; left out, the spacing of the fluid.
    #[arg(long, value_name = "METRES")]
    cell: Option<f64>,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    limits: Limits,
}

/// Kinds of particles.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    Spray,
    Foam,
    Bubbles,
}

impl Kind {
    fn of(kind: FoamKind) -> Self {
        match kind {
            FoamKind::Spray => Self::Spray,
            FoamKind::Foam => Self::Foam,
            FoamKind::Bubble => Self::Bubbles,
        }
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    let context = arguments.limits.context()?;
    let mut foam = Source::open(&context, &arguments.foam)?;
    let settings = arguments.settings.of(&foam)?;
    let is_df3 = arguments.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("df3"));
    let line = match is_df3 {
        true => arguments.medium(&context, &mut foam, settings)?,
        false => arguments.particles(&context, &mut foam, settings)?,
    };
    crate::print(&line)?;
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    /// Returns whether particles of a kind are exported.
    fn is_wanted(&self, particle: &FoamParticle) -> bool {
        self.kinds.is_empty() || self.kinds.contains(&Kind::of(particle.kind))
    }

    /// Writes a density file and the declaration of its medium. Returns what was written, as a line.
    fn medium(&self, context: &Context, foam: &mut Source, settings: FoamSettings) -> Result<String> {
        let cell = self.cell.or(foam.spacing().map(f64::from)).ok_or_else(|| {
            Error::invalid("the file does not say how far particles of the fluid are apart").advise("give --cell")
        })?;
        let (low, high) = foam.bounds()?;
        let mut grid = Extinction::new(context, settings, [low, high], cell)?;
        foam.for_each(|particles| {
            for_each_part(particles, |part, _| {
                let wanted: Vec<_> = part.iter().filter(|particle| self.is_wanted(particle)).copied().collect();
                grid.add(&wanted);
                Ok(())
            })
        })?;
        let most = grid.coefficients().fold(0.0, f64::max);
        let value = |coefficient: f64| if most > 0.0 { (65_535.0 * coefficient / most).round() as u16 } else { 0 };
        let values: Vec<u16> = grid.coefficients().map(value).collect();
        write_df3(&self.output, grid.size(), &values)?;
        let declared = self.output.with_extension("inc");
        file::store(&declared, |out| std::io::Write::write_all(out, medium(&self.output, &grid, most).as_bytes()))?;
        let [x, y, z] = grid.size();
        Ok(format!("{x} × {y} × {z} values, at most {most:.3} per metre, and {}\n", declared.display()))
    }

    /// Writes particles with their radii. Returns what was written, as a line.
    fn particles(&self, context: &Context, foam: &mut Source, settings: FoamSettings) -> Result<String> {
        // A place, a number and three channels.
        Budget::new(context.memory_limit()).charge(28 * foam.count() as u64)?;
        let mut made = Particles { spacing: foam.spacing(), ..Particles::default() };
        let (mut numbers, mut kinds, mut lives, mut radii) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        foam.for_each(|particles| {
            made.time = particles.time;
            for_each_part(particles, |part, _| {
                for particle in part.iter().filter(|particle| self.is_wanted(particle)) {
                    made.points.push(particle.position);
                    numbers.push(particle.id);
                    kinds.push(f32::from(particle.kind as u8));
                    lives.push(particle.life);
                    radii.push(radius(&settings, particle));
                }
                Ok(())
            })
        })?;
        let channel = |name: &str, values: Vec<f32>| Channel { name: name.into(), width: 1, values };
        made.numbers = Some(numbers);
        made.channels = vec![channel("type", kinds), channel("life", lives), channel("radius", radii)];
        write(context, &self.output, &made)?;
        Ok(format!("{} particles of foam in {}\n", made.points.len(), self.output.display()))
    }
}

/// Returns the declaration of a medium for POV-Ray: a box that scatters as the particles in it do, in metres.
fn medium(path: &Path, grid: &Extinction, most: f64) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().replace('"', "_");
    let DVec3 { x, y, z } = grid.low();
    let [width, depth, height] = grid.size().map(|along| along as f64 * grid.cell());
    format!(
        "// Foam as a medium: `object {{ Relievo_Foam }}`. Lengths are metres.\n\
         #declare Relievo_Foam = box {{ <0, 0, 0>, <1, 1, 1>\n  hollow\n  texture {{ pigment {{ rgbt 1 }} }}\n  \
         interior {{ media {{ scattering {{ 1, rgb {most} extinction 1 }} density {{ density_file df3 \"{name}\" \
         interpolate 1 }} }} }}\n  scale <{width}, {depth}, {height}>\n  translate <{x}, {y}, {z}>\n}}\n"
    )
}
