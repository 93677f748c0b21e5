//! What pictures of foam have in common: settings, the environment, the pass over the particles and the files.

use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_render as render;
use relievo_render::Image;
use relievo_render::foam::{Environment, Foam, FoamLayers, FoamSettings, FoamView, Scenery};
use relievo_scene::foam::add_frame;

use super::source::Source;
use crate::bar::Bar;

#[derive(clap::Args)]
pub struct Options {
    /// The picture: .png, or .exr, which has the layers too. Of a folder of frames, the folder for the pictures.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// A file for the layers alone: intensity, thickness, depth, normals, occlusion and irradiance.
    #[arg(long, value_name = "FILE.exr")]
    layers: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// The light around as a picture by latitude and longitude, .exr or .png, z up; left out, the sky and the sun.
    #[arg(long, value_name = "FILE")]
    environment: Option<PathBuf>,
}

/// The settings of foam.
#[derive(clap::Args)]
pub struct Settings {
    /// Changes a setting; `relievo foam info --settings` lists all settings. May be repeated.
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = setting, allow_hyphen_values = true)]
    changes: Vec<(String, f64)>,
}

impl Settings {
    /// Returns the settings for a frame: particles have half of the fluid's spacing as their radius unless it is set.
    pub fn of(&self, source: &Source) -> Result<FoamSettings> {
        let mut settings = FoamSettings::default();
        if let Some(spacing) = source.spacing() {
            settings.set("radius", 0.5 * f64::from(spacing))?;
        }
        self.changes.iter().try_for_each(|(name, value)| settings.set(name, *value))?;
        Ok(settings)
    }
}

fn setting(text: &str) -> std::result::Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("a name, = and a number are needed")?;
    let value = value.trim().parse().map_err(|_| format!("{value:?} is not a number"))?;
    Ok((name.trim().to_owned(), value))
}

impl Options {
    /// Returns the layers of a frame, which a graphics device draws where there is one.
    pub fn layers(
        &self,
        (context, device): (&Context, Option<&Device>),
        source: &mut Source,
        view: FoamView,
        scenery: &Scenery,
        lights: &render::Lights,
    ) -> Result<FoamLayers> {
        let environment = match &self.environment {
            Some(path) => {
                let picture = render::Picture::read(path, context.memory_limit())?;
                Environment::of_image(&picture.color, [0.0, 0.0, 1.0])
                    .map_err(|error| error.at(path.display().to_string()))?
            }
            None => Environment::of_lights(lights)?,
        };
        let mut foam = Foam::on(context, device, self.settings.of(source)?, view, scenery)?;
        source.for_each(|particles| add_frame(context, &mut foam, particles))?;
        foam.finish(context, &environment, &mut Bar::new())
    }

    /// Checks that the names of the files have extensions that can be written.
    pub fn check(&self) -> Result<()> {
        let has = |path: &Path, known: &[&str]| {
            let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
            known.iter().any(|known| extension.as_deref() == Some(*known))
        };
        if !has(&self.output, &["png", "exr"]) {
            return Err(Error::unsupported("the format to write is not known")
                .at(self.output.display().to_string())
                .advise("use the extension .png or .exr"));
        }
        match &self.layers {
            Some(path) if !has(path, &["exr"]) => Err(Error::unsupported("layers cannot be written in that format")
                .at(path.display().to_string())
                .advise("use the extension .exr")),
            _ => Ok(()),
        }
    }

    /// Returns the file or the folder that is written.
    pub fn output(&self) -> &Path {
        &self.output
    }

    /// Makes the folder for pictures of several frames and returns it. Fails where a file of layers is asked for.
    pub fn folder(&self) -> Result<&Path> {
        if let Some(path) = &self.layers {
            return Err(Error::unsupported("layers of several frames do not fit into one file")
                .at(path.display().to_string())
                .advise("render single frames, or leave out --layers"));
        }
        std::fs::create_dir_all(&self.output).map_err(|error| Error::io(&self.output, &error))?;
        Ok(&self.output)
    }

    /// Writes a picture with the foam over it to `path`, and the layers where they are asked for.
    pub fn write(&self, context: &Context, path: &Path, background: &Image, layers: &FoamLayers) -> Result<()> {
        let picture = layers.composite(context, background)?;
        let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        match is_exr {
            true => {
                let mut layer = layers.exr_layer();
                layer.add(&["R", "G", "B"], &picture);
                render::write_exr(path, &[layer], render::Content::Color)?;
            }
            false => render::write_png(path, &picture)?,
        }
        match &self.layers {
            Some(path) => render::write_exr(path, &[layers.exr_layer()], render::Content::Data),
            None => Ok(()),
        }
    }
}

/// Returns one line on the particles and the pixels of foam.
pub fn summary(source: &Source, layers: &FoamLayers, seconds: f64) -> String {
    let covered = layers.intensity().iter().filter(|intensity| **intensity > 0.0).count();
    let [width, height] = layers.size();
    let share = 100.0 * covered as f64 / (f64::from(width) * f64::from(height));
    format!("{} particles of foam in {share:.1} % of {width} × {height} pixels, {seconds:.2} s\n", source.count())
}
