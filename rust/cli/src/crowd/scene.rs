//! A crowd with a camera, and `relievo crowd view`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use relievo_core::{Context, Error, Result, file};
use relievo_crowd::{Crowd, CrowdModel, CrowdView, Frame, parse_agents, square};
use relievo_render::Camera;
use serde_json::json;

use crate::Outcome;
use crate::limits::Limits;
use crate::numbers::vector;

const EXAMPLE: &str = "Example: relievo crowd view robot.rcrowd --square 1000 --time 1.5";

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct ViewArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
}

/// The models, the agents and the camera.
#[derive(clap::Args)]
pub struct SceneArguments {
    /// Crowd models; agents refer to them by number from 0.
    #[arg(required = true, value_name = "FILE.rcrowd")]
    models: Vec<PathBuf>,
    /// The agents, one a line: x y z, heading in degrees about y, scale, clip, phase in seconds, and the number of the
    /// model where there are several.
    #[arg(long, value_name = "FILE", required_unless_present = "square")]
    agents: Option<PathBuf>,
    /// In place of a file, so many agents of the first model on a square.
    #[arg(long, value_name = "N", conflicts_with = "agents")]
    square: Option<usize>,
    /// Distance between agents of the square, in diagonals of the model.
    #[arg(long, value_name = "DIAGONALS", default_value_t = 0.8)]
    spacing: f64,
    /// Seconds since the clips began.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub time: f64,
    /// Error that may be seen, in pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = 0.5)]
    pixels: f32,
    /// Where the camera is, y up; left out, above a side of the crowd.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// Where it looks; left out, at the middle of the crowd.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    target: Option<DVec3>,
    /// Vertical field of view in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = 40.0)]
    fov: f64,
    /// Pixels of the picture: WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = crate::export::size, default_value = "1280x720")]
    pub size: [u32; 2],
    #[command(flatten)]
    pub limits: Limits,
}

/// A crowd with what a view draws of it.
pub struct Scene {
    pub context: Context,
    pub crowd: Crowd,
    pub camera: Camera,
    pub frame: Frame,
    /// The height of the lowest agent.
    pub ground: f64,
}

impl SceneArguments {
    /// Reads the models and agents and finds what is drawn.
    pub fn open(&self) -> Result<Scene> {
        if !self.time.is_finite() {
            return Err(Error::invalid("the time is not finite").at("--time").advise("give seconds"));
        }
        let context = self.limits.context()?;
        let models = self.models.iter().map(|path| CrowdModel::load(&context, path)).collect::<Result<Vec<_>>>()?;
        let references: Vec<&CrowdModel> = models.iter().collect();
        let (text, place) = match (&self.agents, self.square) {
            (Some(path), _) => {
                let bytes = file::load(path, context.memory_limit())?;
                let place = path.display().to_string();
                let text = String::from_utf8(bytes).map_err(|_| Error::invalid("it is no text").at(place.clone()))?;
                (text, place)
            }
            (None, count) => {
                let count = count.unwrap_or(1);
                if count == 0 || count > relievo_crowd::MOST_AGENTS {
                    return Err(Error::invalid(format!("{count} agents")).at("--square").advise("give 1 to 16777216"));
                }
                let spacing = self.spacing * f64::from(models[0].size());
                (square(&models[0], count, spacing), "--square".into())
            }
        };
        let agents = parse_agents(&text, &references).map_err(|error| error.at(place))?;
        let mut crowd = Crowd::new(models.into_iter().map(Arc::new).collect());
        for (index, agent) in agents.into_iter().enumerate() {
            crowd.add(agent).map_err(|error| error.at(format!("agent {index}")))?;
        }
        let (camera, ground) = self.camera(&crowd)?;
        let view = CrowdView::perspective(camera.eye, camera.axes, camera.fov, self.size, self.pixels)?;
        let mut frame = Frame::default();
        crowd.cut(&context, &view, &mut frame)?;
        Ok(Scene { context, crowd, camera, frame, ground })
    }

    fn camera(&self, crowd: &Crowd) -> Result<(Camera, f64)> {
        if self.size.contains(&0) {
            return Err(Error::invalid("the picture has no pixels").at("--size").advise("give WIDTHxHEIGHT"));
        }
        let places: Vec<DVec3> = crowd.agents().iter().map(|agent| agent.transform.translation).collect();
        if places.is_empty() {
            return Err(Error::invalid("there are no agents").advise("give at least one"));
        }
        let model = &crowd.models()[0];
        let tall = f64::from(model.high[1] - model.low[1]);
        let low = places.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = places.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let middle = 0.5 * (low + high) + DVec3::Y * 0.5 * tall;
        let half = 0.5 * (high - low).x.max((high - low).z) + f64::from(model.size());
        let target = self.target.unwrap_or(middle);
        // Near the front row, so that agents of all sizes are seen.
        let eye = self.eye.unwrap_or(middle + DVec3::new(0.25 * half, 0.35 * half + tall, 1.25 * half));
        let camera = Camera::look_at(eye, target, DVec3::Y, self.fov.to_radians())?;
        Ok((camera, low.y + f64::from(Vec3::from(model.low).y.min(0.0))))
    }
}

pub fn run(arguments: &ViewArguments) -> Outcome {
    let scene = arguments.scene.open()?;
    let (crowd, frame) = (&scene.crowd, &scene.frame);
    let full: u64 = frame
        .drawn
        .iter()
        .map(|(agent, _)| {
            let model = crowd.agents()[*agent as usize].model as usize;
            u64::from(crowd.models()[model].input_triangles)
        })
        .sum();
    let share = 100.0 * frame.triangles as f64 / full.max(1) as f64;
    let text = if arguments.json {
        let value = json!({
            "agents": crowd.agents().len(),
            "in_view": frame.drawn.len(),
            "clusters": frame.clusters,
            "triangles": frame.triangles,
            "full_triangles": full,
        });
        format!("{value:#}\n")
    } else {
        format!(
            "agents                 {}\nin view                {}\nclusters               {}\ntriangles              {}\n\
             at full resolution     {full} triangles, of which {share:.2} % are drawn\n",
            crowd.agents().len(),
            frame.drawn.len(),
            frame.clusters,
            frame.triangles,
        )
    };
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
