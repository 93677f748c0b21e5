//! Surfaces of particles as files, so that a client needs no kernels: meshes in PLY and level sets in OpenVDB's format.

use std::path::Path;

use relievo_client::SurfaceForm;
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, Result};
use relievo_fluid::{Channel, LevelSet, Smoothing, Surface, SurfaceFunction, level_set, mesh, smooth};
use relievo_particleio::Particles;
use serde::Deserialize;

/// The settings of a surface. Those of `relievo fluid mesh` have the same names and defaults.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Settings {
    /// Size of cells and voxels, in spacings.
    cell: f32,
    /// What the surface is of.
    function: Function,
    /// Steps by which a mesh is smoothed.
    smooth: u32,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Function {
    Blobs,
    ZhuBridson,
    Density,
    Anisotropic,
}

impl Default for Settings {
    fn default() -> Self {
        Self { cell: 0.5, function: Function::ZhuBridson, smooth: 0 }
    }
}

impl Settings {
    fn parse(text: &str) -> Result<Self> {
        let settings: Self = toml::from_str(text).map_err(|error| Error::invalid(error.to_string()).at("settings"))?;
        if !(0.1..=10.0).contains(&settings.cell) {
            return Err(Error::invalid(format!("cells cannot be {} spacings large", settings.cell))
                .at("settings.cell")
                .advise("use 0.1 to 10"));
        }
        if settings.smooth > 100 {
            return Err(Error::invalid("a mesh is smoothed in at most 100 steps").at("settings.smooth"));
        }
        Ok(settings)
    }

    fn function(&self, spacing: f32) -> SurfaceFunction {
        let radius = 0.5 * spacing;
        match self.function {
            Function::Blobs => SurfaceFunction::blobs(radius),
            Function::ZhuBridson => SurfaceFunction::zhu_bridson(radius),
            Function::Density => SurfaceFunction::density(radius),
            Function::Anisotropic => SurfaceFunction::anisotropic(radius),
        }
    }
}

/// Writes the surface of particles to the file `to`. A mesh carries the channels of the particles. Fails where a setting is
/// unknown or out of range, or the particles do not say how far they are apart.
pub fn write(context: &Context, particles: &Particles, (form, settings): (SurfaceForm, &str), to: &Path) -> Result<()> {
    let settings = Settings::parse(settings)?;
    if form == SurfaceForm::LevelSet && settings.smooth > 0 {
        return Err(Error::unsupported("a level set is not smoothed").at("settings.smooth").advise("ask for a mesh"));
    }
    let spacing = particles.spacing.ok_or_else(|| Error::invalid("the frame does not say its spacing"))?;
    let surface = Surface::new(context, &particles.points, settings.function(spacing))?;
    let cell = settings.cell * spacing;
    let channels: Vec<Channel> = particles
        .channels
        .iter()
        .filter(|channel| form == SurfaceForm::Mesh && channel.name != "normal")
        .map(|it| Channel { name: &it.name, width: it.width as usize, values: &it.values })
        .collect();
    let mut made = mesh(context, &surface, cell, &channels, &mut Silent)?;
    if form == SurfaceForm::LevelSet {
        let LevelSet { voxel, band, blocks } = level_set(context, &surface, &made, cell, &mut Silent)?;
        let is_inside = |place: [f64; 3]| {
            let place = place.map(|at| (at * f64::from(voxel)) as f32);
            surface.probe(context).sample(place).value > 0.0
        };
        let grid = relievo_particleio::LevelSet { voxel, band, blocks };
        return relievo_particleio::write_vdb(context, to, &grid, &is_inside);
    }
    if settings.smooth > 0 {
        let smoothing = Smoothing { iterations: settings.smooth, ..Smoothing::default() };
        smooth(context, &mut made, smoothing, &mut Silent)?;
    }
    match made.face_count() {
        0 => relievo_meshio::write_points_ply(to, Vec::new(), Vec::new()),
        _ => relievo_meshio::write_ply(to, &made),
    }
}
