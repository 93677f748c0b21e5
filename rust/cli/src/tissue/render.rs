//! `relievo tissue render`

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use glam::{DAffine3, DVec3};
use relievo_core::{Context, Error, Result};
use relievo_render as render;
use relievo_render::{Camera, Image, Lights, Material, Scene, View};
use relievo_scene::description::Up;
use relievo_scene::picture::whole_view;
use relievo_scene::tissue::Motion;
use relievo_tissue::{Simulation, SimulationOptions};

use super::picture::{coloring, faces, surfaces};
use super::{Limits, is_named};
use crate::Outcome;

const EXAMPLE: &str = "Example: relievo tissue render examples/tissue/press.toml frames/0000.rtstate frames/0024.rtstate \
    -o press.png --show stress --cut y=0";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// A model, or the description (.toml) of its simulation, whose activations and colliders are shown too.
    model: PathBuf,
    /// Frames, `.rtstate`, of which pictures are put side by side; left out, the model at rest.
    #[arg(value_name = "FRAME")]
    frames: Vec<PathBuf>,
    /// The picture: a .png.
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
    /// What colours stand for.
    #[arg(long, value_enum, default_value_t = Show::Material)]
    show: Show,
    /// What the brightest colour stands for; left out, nearly the largest value of each frame.
    #[arg(long, value_name = "VALUE")]
    most: Option<f32>,
    /// Leaves out what is on the camera's side of a plane at rest, such as `y=0.01`.
    #[arg(long, value_name = "AXIS=METRES", value_parser = cut)]
    cut: Option<Cut>,
    /// Shows the bound surfaces in place of the elements.
    #[arg(long)]
    bound: bool,
    /// Pixels of each picture: WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = crate::args::numbers::pixels, default_value = "640x480")]
    size: [u32; 2],
    /// Rays from the camera per pixel.
    #[arg(long, default_value_t = 8)]
    samples: u32,
    /// Pictures in a row.
    #[arg(long, default_value_t = 2)]
    columns: u32,
    /// Where the camera is, z up; left out, where it has all in view.
    #[arg(long, value_name = "X,Y,Z", value_parser = crate::args::numbers::vector, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// Where it looks; left out, at the middle of the model.
    #[arg(long, value_name = "X,Y,Z", value_parser = crate::args::numbers::vector, allow_hyphen_values = true)]
    target: Option<DVec3>,
    /// Its vertical field of view.
    #[arg(long, value_name = "DEGREES", default_value_t = 30.0)]
    fov: f64,
    /// Direction to the sun.
    #[arg(long, value_name = "X,Y,Z", value_parser = crate::args::numbers::vector, allow_hyphen_values = true, default_value = "-0.55,-0.45,0.7")]
    sun: DVec3,
    #[command(flatten)]
    limits: Limits,
}

/// What colours stand for.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Show {
    /// The materials, mixed by their shares.
    Material,
    /// The muscles.
    Muscle,
    /// Von Mises stress.
    Stress,
    /// The largest principal Green–Lagrange strain, of either sign.
    Strain,
    /// Change of volume.
    Volume,
    /// The pressure with which colliders of the description, which are left out, press on the nodes.
    Pressure,
    /// Nothing: one colour.
    Surface,
}

/// A plane across an axis.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// The axis, x first.
    pub axis: usize,
    /// Metres along it.
    pub at: f32,
}

fn cut(text: &str) -> std::result::Result<Cut, String> {
    let wrong = || format!("{text:?} is no plane; use x=0.01, y=0 or z=-0.02");
    let (axis, at) = text.split_once('=').ok_or_else(wrong)?;
    let axis = ["x", "y", "z"].iter().position(|name| *name == axis.trim()).ok_or_else(wrong)?;
    let at: f32 = at.trim().parse().map_err(|_| wrong())?;
    if at.is_finite() { Ok(Cut { axis, at }) } else { Err(wrong()) }
}

/// The colour of colliders.
const STEEL: [f32; 3] = [0.35, 0.37, 0.4];

pub fn run(arguments: &Arguments) -> Outcome {
    if !is_named(&arguments.output, "png") {
        return Err(Error::unsupported("the format to write is not known")
            .at(arguments.output.display().to_string())
            .advise("use the extension .png")
            .into());
    }
    if arguments.show == Show::Pressure && !is_named(&arguments.model, "toml") {
        return Err(Error::unsupported("a model has no colliders that press on it")
            .at(arguments.model.display().to_string())
            .advise("give the description (.toml) of its simulation")
            .into());
    }
    let context = arguments.limits.context()?;
    let motion = is_named(&arguments.model, "toml").then(|| Motion::read(&arguments.model)).transpose()?;
    let mut simulation = match &motion {
        Some(motion) => {
            let model = super::model(&context, &motion.model())?;
            motion.begin(&context, model).map_err(|error| error.at(arguments.model.display().to_string()))?
        }
        None => Simulation::new(super::model(&context, &arguments.model)?, &SimulationOptions::default())?,
    };
    let view = arguments.view(&simulation)?;
    let [width, height] = arguments.size;
    let count = arguments.frames.len().max(1) as u32;
    let columns = arguments.columns.clamp(1, count);
    let mut sheet = Image::new(width.saturating_mul(columns), height.saturating_mul(count.div_ceil(columns)), 3)?;
    for at in 0..count {
        if let Some(path) = arguments.frames.get(at as usize) {
            super::show(&context, &mut simulation, path)?;
        }
        let picture = arguments.picture(&context, &simulation, motion.as_ref(), &view)?;
        let (left, top) = (at % columns * width, at / columns * height);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            sheet.set_color(left + x, top + y, picture.color(x, y));
        }
    }
    render::write_png(&arguments.output, &sheet)?;
    Ok(ExitCode::SUCCESS)
}

impl Arguments {
    fn view(&self, simulation: &Simulation) -> Result<View> {
        let [width, height] = self.size;
        let points = || simulation.model().nodes.iter().map(|node| glam::Vec3::from(*node).as_dvec3());
        let low = points().reduce(DVec3::min).unwrap_or_default();
        let high = points().reduce(DVec3::max).unwrap_or_default();
        let fov = self.fov.to_radians();
        let aspect = f64::from(width) / f64::from(height.max(1));
        let (eye, middle) = whole_view(Some((low, high)), fov, aspect, Up::Z);
        let target = self.target.unwrap_or(middle);
        let eye = self.eye.unwrap_or(target + (eye - middle));
        let mut view = View::new(Camera::look_at(eye, target, DVec3::Z, fov)?);
        view.lights = Lights::default();
        view.lights.suns[0].direction = self.sun.as_vec3().to_array();
        [view.settings.width, view.settings.height] = self.size;
        view.settings.samples = self.samples;
        Ok(view)
    }

    fn picture(
        &self,
        context: &Context,
        simulation: &Simulation,
        motion: Option<&Motion>,
        view: &View,
    ) -> Result<Image> {
        let coloring = coloring(context, simulation, self.show, self.most)?;
        let mut scene = Scene::new()?;
        let object = scene.add_object(DAffine3::IDENTITY, Material::default())?;
        if self.bound {
            for (number, mesh) in (0..).zip(surfaces(context, simulation, &coloring.paint)) {
                scene.set_mesh(object, number, mesh)?;
            }
        } else {
            scene.set_mesh(object, 0, faces(simulation, self.cut, view.camera.eye, &coloring.paint))?;
        }
        // Colliders would hide where they press.
        if let Some(motion) = motion.filter(|_| self.show != Show::Pressure) {
            let steel = Material { base_color: STEEL, specular: 0.3, roughness: 0.3 };
            for (points, triangles) in motion.solids(context, simulation.state().seconds)? {
                let solid = scene.add_object(DAffine3::IDENTITY, steel)?;
                scene.set_mesh(solid, 0, render::Mesh { points, triangles, ..render::Mesh::default() })?;
            }
        }
        let mut picture = scene.render(context, view)?.color;
        let entries: Vec<_> = coloring.legend.iter().map(|(color, label)| (*color, label.as_str())).collect();
        render::draw_legend(&mut picture, &entries);
        Ok(picture)
    }
}
