//! Options of commands that set a camera.

use glam::DVec3;
use relievo_core::Result;
use relievo_render::{Camera, Lights, View};
use relievo_scene::description::Up;
use relievo_scene::picture::whole_view;

use super::numbers::{pixels, vector};

/// An axis.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum Axis {
    X,
    Y,
    Z,
}

impl From<Axis> for Up {
    fn from(axis: Axis) -> Self {
        match axis {
            Axis::X => Up::X,
            Axis::Y => Up::Y,
            Axis::Z => Up::Z,
        }
    }
}

#[derive(clap::Args)]
pub struct Viewpoint {
    /// Pixels of each picture: WIDTHxHEIGHT.
    #[arg(long, value_name = "PIXELS", value_parser = pixels, default_value = "1280x720")]
    pub size: [u32; 2],
    /// Where the camera is, z up; left out, where it has all in view.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub eye: Option<DVec3>,
    /// Where it looks; left out, at the middle of all particles.
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub target: Option<DVec3>,
    /// Its vertical field of view.
    #[arg(long, value_name = "DEGREES", default_value_t = 35.0)]
    pub fov: f64,
}

impl Viewpoint {
    /// Returns the camera, which has a box in view unless the options say otherwise.
    pub fn camera(&self, low: DVec3, high: DVec3) -> Result<Camera> {
        let [width, height] = self.size;
        let aspect = f64::from(width) / f64::from(height.max(1));
        let fov = self.fov.to_radians();
        let (eye, middle) = whole_view(Some((low, high)), fov, aspect, Up::Z);
        let target = self.target.unwrap_or(middle);
        let eye = self.eye.unwrap_or(target + (eye - middle));
        Camera::look_at(eye, target, DVec3::Z, fov)
    }

    /// Returns the view of the camera with rays for each pixel, lit by a sun in a direction and by the sky.
    pub fn view(&self, (low, high): (DVec3, DVec3), sun: DVec3, samples: u32) -> Result<View> {
        let mut view = View::new(self.camera(low, high)?);
        view.lights = Lights::default();
        view.lights.suns[0].direction = sun.as_vec3().to_array();
        // Beyond the floor the haze goes on.
        view.lights.sky.ground = view.lights.sky.horizon;
        [view.settings.width, view.settings.height] = self.size;
        view.settings.samples = samples;
        Ok(view)
    }
}
