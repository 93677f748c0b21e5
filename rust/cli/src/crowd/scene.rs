//! A crowd with a camera, and `relievo crowd view`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use relievo_core::{Context, Error, Result, file};
use relievo_crowd::{Crowd, CrowdModel, CrowdView, Culled, Frame, Occlusion, PixelView, Walker, parse_walkers, square};
use relievo_render::Camera;
use serde_json::{Value, json};

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
    /// The agents, one a line: x y z, heading in degrees about y, scale, clip, phase in seconds, the number of the
    /// model (0 if left out) and the speed along the heading in units a second (0 if left out).
    #[arg(long, value_name = "FILE", required_unless_present = "square")]
    agents: Option<PathBuf>,
    /// In place of a file, so many agents of the first model on a square.
    #[arg(long, value_name = "N", conflicts_with = "agents")]
    square: Option<usize>,
    /// Distance between agents of the square, in diagonals of the model.
    #[arg(long, value_name = "DIAGONALS", default_value_t = 0.8)]
    spacing: f64,
    /// Seconds since the clips began and agents set out.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    time: f64,
    /// Frames, the first at --time.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub frames: u32,
    /// Seconds from one frame to the next.
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, allow_negative_numbers = true)]
    step: f64,
    /// Leave out agents that others hide at the middle of every pixel that they may cover.
    #[arg(long)]
    occlusion: bool,
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

/// A crowd before a camera.
pub struct Scene {
    pub context: Context,
    pub crowd: Crowd,
    pub camera: Camera,
    /// The height of the lowest agent.
    pub ground: f64,
    walkers: Vec<Walker>,
    view: CrowdView,
    size: [u32; 2],
    occlusion: Option<Occlusion>,
}

/// What a view draws of a crowd at a time.
pub struct Shown {
    /// Seconds.
    pub time: f64,
    pub frame: Frame,
    /// Triangles of the agents in view at full resolution.
    full: u64,
    /// Agents in view, hidden or not.
    in_view: usize,
    culled: Option<Culled>,
}

impl Scene {
    /// Moves the agents to where they are at a time, and finds what is drawn.
    fn show(&mut self, time: f64) -> Result<Shown> {
        for (index, walker) in self.walkers.iter().enumerate() {
            self.crowd.set(index as u32, walker.at(time))?;
        }
        let mut frame = Frame::default();
        self.crowd.cut(&self.context, &self.view, &mut frame)?;
        let input = |agent: u32| {
            let model = self.crowd.agents()[agent as usize].model as usize;
            u64::from(self.crowd.models()[model].input_triangles)
        };
        let (full, in_view) = (frame.drawn.iter().map(|drawn| input(drawn.0)).sum(), frame.drawn.len());
        let camera = &self.camera;
        let pixels = PixelView { eye: camera.eye, axes: camera.axes, fov: camera.fov, size: self.size };
        let cull = |occlusion: &mut Occlusion| occlusion.cull(&self.context, &self.crowd, (&pixels, time), &mut frame);
        let culled = self.occlusion.as_mut().map(cull).transpose()?;
        Ok(Shown { time, frame, full, in_view, culled })
    }
}

impl SceneArguments {
    /// Reads the models and agents.
    pub fn open(&self) -> Result<Scene> {
        if !(self.time.is_finite() && self.step.is_finite()) {
            return Err(Error::invalid("a time is not finite").at("--time or --step").advise("give seconds"));
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
        let walkers = parse_walkers(&text, &references).map_err(|error| error.at(place))?;
        let mut crowd = Crowd::new(models.into_iter().map(Arc::new).collect());
        for (index, walker) in walkers.iter().enumerate() {
            crowd.add(walker.agent).map_err(|error| error.at(format!("agent {index}")))?;
        }
        let (camera, ground) = self.camera(&crowd)?;
        let view = CrowdView::perspective(camera.eye, camera.axes, camera.fov, self.size, self.pixels)?;
        let occlusion = self.occlusion.then(Occlusion::default);
        Ok(Scene { context, crowd, camera, ground, walkers, view, size: self.size, occlusion })
    }

    /// Calls `work` with what is drawn in one frame after the other.
    pub fn for_each_frame(&self, scene: &mut Scene, mut work: impl FnMut(&Scene, Shown) -> Result<()>) -> Result<()> {
        (0..self.frames).try_for_each(|number| {
            let shown = scene.show(self.time + self.step * f64::from(number))?;
            work(scene, shown)
        })
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

impl Shown {
    /// Returns the counts for programs.
    fn machine_readable(&self, agents: usize) -> Value {
        let mut value = json!({
            "time": self.time,
            "agents": agents,
            "in_view": self.in_view,
            "clusters": self.frame.clusters,
            "triangles": self.frame.triangles,
            "full_triangles": self.full,
        });
        if let Some(culled) = self.culled {
            value["hidden"] = json!(culled.hidden);
            value["hidden_triangles"] = json!(culled.hidden_triangles);
            value["occluder_triangles"] = json!(culled.occluder_triangles);
        }
        value
    }

    /// Returns the counts, one a line.
    pub fn described(&self, agents: usize) -> String {
        let share = 100.0 * self.frame.triangles as f64 / self.full.max(1) as f64;
        let hidden = self.culled.map_or(String::new(), |culled| match culled.is_resting {
            true => "hidden                 not searched, since occluders had more triangles than they hid\n".into(),
            false => format!(
                "hidden                 {} agents, {} triangles, by {} triangles\n",
                culled.hidden, culled.hidden_triangles, culled.occluder_triangles
            ),
        });
        format!(
            "agents                 {agents}\nin view                {}\n{hidden}clusters               {}\n\
             triangles              {}\nat full resolution     {} triangles, of which {share:.2} % are drawn\n",
            self.in_view, self.frame.clusters, self.frame.triangles, self.full,
        )
    }
}

pub fn run(arguments: &ViewArguments) -> Outcome {
    let mut scene = arguments.scene.open()?;
    let (mut text, mut values) = (String::new(), Vec::new());
    arguments.scene.for_each_frame(&mut scene, |scene, shown| {
        let agents = scene.crowd.agents().len();
        if arguments.scene.frames > 1 {
            text += &format!("time                   {} s\n", shown.time);
        }
        text += &shown.described(agents);
        values.push(shown.machine_readable(agents));
        Ok(())
    })?;
    if arguments.json {
        // A single frame is an object, several are a list.
        let value = if values.len() == 1 { values.swap_remove(0) } else { Value::Array(values) };
        text = format!("{value:#}\n");
    }
    crate::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
