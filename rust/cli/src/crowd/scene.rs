//! A crowd with a camera, and `relievo crowd view`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::ValueEnum;
use glam::{DVec3, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_crowd::{
    Blend, Crowd, CrowdModel, CrowdView, Culled, DeviceCrowd, DeviceOcclusion, DevicePoser, Frame, Look, Occlusion,
    PixelView, Stream, Streamed, Walker, parse_walkers, read_walkers, square,
};
use relievo_gpu::Device;
use relievo_render::Camera;
use serde_json::{Value, json};

use crate::Outcome;
use crate::args::device::{Adapter, Device as Kind};
use crate::args::limits::Limits;
use crate::args::numbers::vector;

const EXAMPLE: &str = "Example: relievo crowd view robot.rcrowd --square 1000 --time 1.5";

/// Draws that a device has room for at first.
const ROOM: u32 = 1 << 16;

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct ViewArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// What cuts the crowd, culls by occlusion and makes the draws. A graphics device makes the cuts of the processor. By
    /// occlusion it leaves out fewer agents, because it compares wider boxes with coarser depths.
    #[arg(long, value_enum, default_value = "cpu")]
    device: Kind,
    #[command(flatten)]
    adapter: Adapter,
    /// Print JSON for programs.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum BlendName {
    /// Weighted sums of matrices.
    Linear,
    /// Weighted sums of dual quaternions.
    Dual,
}

/// The models, the agents and the camera.
#[derive(clap::Args)]
pub struct SceneArguments {
    /// Crowd models; agents refer to them by number from 0.
    #[arg(required = true, value_name = "FILE.rcrowd")]
    models: Vec<PathBuf>,
    /// The agents, one a line: x y z, heading in degrees about y, scale, clip, phase in seconds, the number of the
    /// model (0 if left out) and the speed along the heading in units a second (0 if left out). Or a USD stage (.usda,
    /// .usdc) whose point instancers place them: a model for each prototype in order, clips and phases by the primvars
    /// `clip` and `phase`, walks by velocities.
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
    /// Leave out agents that others hide at the middle of every pixel that they may cover. Pictures with shadows show all, since
    /// hidden agents throw shadows too.
    #[arg(long)]
    occlusion: bool,
    /// Move vertices from cut to cut as the camera moves, so that nothing jumps; of use where --pixels is above 1.
    #[arg(long)]
    geomorph: bool,
    /// Draw agents of a few pixels as single quads with pictures of them, where these hold the error.
    #[arg(long)]
    impostors: bool,
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
    #[arg(long, value_name = "PIXELS", value_parser = crate::args::numbers::pixels, default_value = "1280x720")]
    pub size: [u32; 2],
    /// How bones are blended, by which errors differ.
    #[arg(long, value_enum, default_value = "linear")]
    blend: BlendName,
    /// Read clusters from the files while they are drawn, and keep the triangles of all models within so many mebibytes;
    /// left out, whole files are read. What has not been read is drawn coarser.
    #[arg(long, value_name = "MIB", conflicts_with = "impostors")]
    budget: Option<f64>,
    /// Clusters that are read in a frame at most.
    #[arg(long, value_name = "N", default_value_t = 1024, requires = "budget")]
    read: u32,
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
    pub view: CrowdView,
    size: [u32; 2],
    occlusion: Option<Occlusion>,
    on_device: Option<OnDevice>,
}

/// A crowd on a device, with what culls it by occlusion if that was asked for.
struct OnDevice {
    crowd: DeviceCrowd,
    occlusion: Option<(DeviceOcclusion, DevicePoser)>,
}

impl OnDevice {
    fn new(device: &Device, crowd: &Crowd, has_occlusion: bool) -> Result<Self> {
        let look = Look { tag: None, lines: false };
        let occlusion = match has_occlusion {
            true => Some((DeviceOcclusion::new(device)?, DevicePoser::new(device, crowd, look)?)),
            false => None,
        };
        Ok(Self { crowd: DeviceCrowd::new(device, crowd, ROOM)?, occlusion })
    }

    /// Returns what is drawn, the agents that others hide, and what culling did.
    fn cut(
        &mut self,
        (context, crowd): (&Context, &Crowd),
        seen: (&CrowdView, f64),
        pixels: &PixelView,
    ) -> Result<(Frame, Vec<u32>, Option<Culled>)> {
        let Some((occlusion, poser)) = &mut self.occlusion else {
            return Ok((self.crowd.cut(context, crowd, seen.0, seen.1)?.frame(), Vec::new(), None));
        };
        let (counted, culled) = occlusion.update(context, (crowd, &mut self.crowd, poser), seen, pixels)?;
        Ok((self.crowd.read(counted)?.frame(), self.crowd.hidden()?, Some(culled)))
    }
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
    streamed: Option<Streamed>,
}

impl Scene {
    /// Moves the agents to where they are at a time.
    pub fn walk(&mut self, time: f64) -> Result<()> {
        let mut walkers = (0..).zip(&self.walkers);
        walkers.try_for_each(|(index, walker)| self.crowd.set(index, walker.at(time)))
    }

    /// Returns the camera with the pixels of its picture.
    pub fn pixels(&self) -> PixelView {
        let camera = &self.camera;
        PixelView { eye: camera.eye, axes: camera.axes, fov: camera.fov, size: self.size }
    }

    /// Whether agents that others hide are left out.
    pub fn has_occlusion(&self) -> bool {
        self.occlusion.is_some()
    }

    /// Shows agents that others hide from now on. Returns whether they were left out.
    pub fn show_hidden(&mut self) -> bool {
        self.occlusion.take().is_some()
    }

    /// Moves the agents to where they are at a time, and finds what is drawn.
    fn show(&mut self, time: f64) -> Result<Shown> {
        self.walk(time)?;
        let pixels = self.pixels();
        let (mut frame, mut hidden, mut culled) = (Frame::default(), Vec::new(), None);
        match &mut self.on_device {
            Some(device) => {
                (frame, hidden, culled) = device.cut((&self.context, &self.crowd), (&self.view, time), &pixels)?;
            }
            None => self.crowd.cut(&self.context, &self.view, &mut frame)?,
        }
        let input = |agent: &u32| {
            let model = self.crowd.agents()[*agent as usize].model as usize;
            u64::from(self.crowd.models()[model].input_triangles)
        };
        let in_view = || frame.drawn.iter().map(|(agent, _)| agent).chain(&hidden);
        let (full, in_view) = (in_view().map(input).sum(), in_view().count());
        if let (Some(occlusion), None) = (&mut self.occlusion, &self.on_device) {
            culled = Some(occlusion.cull(&self.context, &self.crowd, (&pixels, time), &mut frame)?);
        }
        Ok(Shown { time, frame, full, in_view, culled, streamed: self.crowd.stream().map(Stream::counts) })
    }
}

impl SceneArguments {
    /// Reads the models and agents.
    pub fn open(&self) -> Result<Scene> {
        let context = self.limits.context()?;
        let blend = match self.blend {
            BlendName::Linear => Blend::Linear,
            BlendName::Dual => Blend::DualQuaternion,
        };
        let Some(budget) = self.budget else {
            let load = |path: &PathBuf| CrowdModel::load(&context, path)?.with_blend(&context, blend).map(Arc::new);
            let models = self.models.iter().map(load).collect::<Result<Vec<_>>>()?;
            return self.place(context, Crowd::new(models));
        };
        if !(budget > 0.0 && budget <= 1e9) {
            return Err(Error::invalid(format!("{budget} mebibytes")).at("--budget").advise("give more than 0"));
        }
        if blend != Blend::Linear {
            return Err(Error::unsupported("errors of dual quaternions are measured on whole models")
                .at("--blend")
                .advise("leave out --budget"));
        }
        let stream = Stream::open(&context, &self.models, (budget * f64::from(1 << 20)) as u64, self.read);
        self.place(context, Crowd::streamed(stream.map_err(|error| error.at("--budget"))?))
    }

    /// Adds the agents to a crowd without any.
    fn place(&self, context: Context, mut crowd: Crowd) -> Result<Scene> {
        if !(self.time.is_finite() && self.step.is_finite()) {
            return Err(Error::invalid("a time is not finite").at("--time or --step").advise("give seconds"));
        }
        let models = crowd.models().to_vec();
        let references: Vec<&CrowdModel> = models.iter().map(Arc::as_ref).collect();
        let walkers = match (&self.agents, self.square) {
            (Some(path), _) => read_walkers(&context, path, &references)?,
            (None, count) => {
                let count = count.unwrap_or(1);
                if count == 0 || count > relievo_crowd::MAX_AGENTS {
                    return Err(Error::invalid(format!("{count} agents")).at("--square").advise("give 1 to 16777216"));
                }
                let spacing = self.spacing * f64::from(models[0].size());
                let text = square(&models[0], count, spacing);
                parse_walkers(&text, &references).map_err(|error| error.at("--square"))?
            }
        };
        for (index, walker) in walkers.iter().enumerate() {
            crowd.add(walker.agent).map_err(|error| error.at(format!("agent {index}")))?;
        }
        let (camera, ground) = self.camera(&crowd)?;
        let mut view = CrowdView::perspective(camera.eye, camera.axes, camera.fov, self.size, self.pixels)?;
        (view.geomorph, view.impostors) = (self.geomorph, self.impostors);
        let occlusion = self.occlusion.then(Occlusion::default);
        Ok(Scene { context, crowd, camera, ground, walkers, view, size: self.size, occlusion, on_device: None })
    }

    /// Calls `work` with what is drawn in one frame after the other.
    pub fn for_each_frame(&self, scene: &mut Scene, mut work: impl FnMut(&Scene, Shown) -> Result<()>) -> Result<()> {
        self.times().try_for_each(|time| {
            let shown = scene.show(time)?;
            work(scene, shown)
        })
    }

    /// Returns the times of all frames, seconds.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        let (start, step) = (self.time, self.step);
        (0..self.frames).map(move |number| start + step * f64::from(number))
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
            value["hidden_clusters"] = json!(culled.hidden_clusters);
            value["hidden_triangles"] = json!(culled.hidden_triangles);
            value["occluder_triangles"] = json!(culled.occluder_triangles);
        }
        if let Some(streamed) = self.streamed {
            value["read_clusters"] = json!(streamed.read);
            value["missing_clusters"] = json!(streamed.missing);
            value["dropped_clusters"] = json!(streamed.dropped);
            value["resident_clusters"] = json!(streamed.resident);
            value["wanted_triangles"] = json!(streamed.wanted_triangles);
        }
        value
    }

    /// Returns the counts, one a line.
    pub fn described(&self, agents: usize) -> String {
        let share = 100.0 * self.frame.triangles as f64 / self.full.max(1) as f64;
        let hidden = self.culled.map_or(String::new(), |culled| match culled.is_resting {
            true => "hidden                 not searched, since occluders had more triangles than they hid\n".into(),
            false => format!(
                "hidden                 {} agents and {} clusters, {} triangles, by {} triangles\n",
                culled.hidden, culled.hidden_clusters, culled.hidden_triangles, culled.occluder_triangles
            ),
        });
        let streamed = self.streamed.map_or(String::new(), |streamed| {
            format!(
                "read                   {} clusters, {} are missing, {} are in memory\n\
                 with all of them       {} triangles\n",
                streamed.read, streamed.missing, streamed.resident, streamed.wanted_triangles
            )
        });
        format!(
            "agents                 {agents}\nin view                {}\n{hidden}clusters               {}\n\
             triangles              {}\nat full resolution     {} triangles, of which {share:.2} % are drawn\n{streamed}",
            self.in_view, self.frame.clusters, self.frame.triangles, self.full,
        )
    }
}

pub fn run(arguments: &ViewArguments) -> Outcome {
    let mut scene = arguments.scene.open()?;
    let memory = arguments.scene.limits.memory_limit;
    if let Some(device) = arguments.adapter.open(arguments.device, memory)? {
        scene.on_device = Some(OnDevice::new(&device, &scene.crowd, arguments.scene.occlusion)?);
    }
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
