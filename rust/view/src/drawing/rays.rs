//! The picture of the ray caster, which takes the place of the device's once the hand rests: with shadows and the light of a
//! sky, on a thread of its own, in passes of more and more rays a pixel.
//!
//! What is asked for has a number; another number, as after an edit or a turn, drops the picture and what is being made.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};

use egui::{ColorImage, Rect, TextureHandle, TextureOptions, Ui};
use glam::{DAffine3, Vec3};
use relievo_core::{Context, ContextOptions, Error, Result};
use relievo_render::color::srgb_byte;
use relievo_render::{Image, Lights, Material, Mesh, Scene, Sky, Sun, View};

use super::camera::Camera;

/// Seconds without a change after which the caster begins.
const REST: f64 = 0.4;

/// Rays a pixel of the passes.
const PASSES: [u32; 2] = [1, 6];

/// Pixels of a picture at most, along its longer side.
const MAX: f32 = 1600.0;

/// Triangles at most, so that a copy of them is affordable.
pub(crate) const MAX_TRIANGLES: usize = 8_000_000;

/// The sky and what is seen beside the model, linear.
const BEHIND: [f32; 3] = [0.022, 0.025, 0.03];

/// What a picture shows: it is another one where one of these differs.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Asked {
    camera: Camera,
    size: [u32; 2],
    /// Of the triangles and their colours.
    serial: u64,
}

/// A picture that is made.
struct Job {
    stops: Arc<AtomicBool>,
    pictures: Receiver<Result<Image>>,
    /// Passes that are there.
    done: usize,
}

/// The caster of a view.
#[derive(Default)]
pub(crate) struct Rays {
    /// Whether it is switched on.
    pub(crate) is_on: bool,
    /// Whether it begins without a delay, as scripts want it.
    pub(crate) is_prompt: bool,
    asked: Option<Asked>,
    since: f64,
    job: Option<Job>,
    picture: Option<TextureHandle>,
}

impl Drop for Job {
    fn drop(&mut self) {
        self.stops.store(true, Ordering::Relaxed);
    }
}

impl Rays {
    /// Whether there is nothing more to come.
    pub(crate) fn is_done(&self) -> bool {
        !self.is_on || self.job.as_ref().is_some_and(|job| job.done == PASSES.len())
    }

    /// Shows the latest picture of a mesh in an area of the window. `serial` numbers the mesh that `mesh` returns, with a new
    /// number for each mesh; `is_busy` says that the hand does not rest.
    ///
    /// # Errors
    /// The caster cannot make a picture: there is no Embree, or no memory.
    pub(crate) fn show(
        &mut self,
        ui: &Ui,
        area: Rect,
        camera: &Camera,
        (serial, is_busy): (u64, bool),
        mesh: impl FnOnce() -> Result<Mesh>,
    ) -> Result<()> {
        if !self.is_on || is_busy {
            (self.asked, self.job, self.picture) = (None, None, None);
            return Ok(());
        }
        let shrink = (MAX / area.width().max(area.height()).max(1.0)).min(ui.ctx().pixels_per_point());
        let size = [area.width(), area.height()].map(|side| (side * shrink).round().max(1.0) as u32);
        let (asked, now) = (Asked { camera: *camera, size, serial }, ui.input(|input| input.time));
        if self.asked != Some(asked) {
            (self.asked, self.since, self.job, self.picture) = (Some(asked), now, None, None);
        }
        if self.job.is_none() {
            if now - self.since < REST && !self.is_prompt {
                ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(REST));
                return Ok(());
            }
            self.job = Some(begin(mesh()?, view(camera, size)?, ui.ctx().clone())?);
        }
        let Some(job) = &mut self.job else { return Ok(()) };
        while let Ok(made) = job.pictures.try_recv() {
            job.done += 1;
            let image = made.inspect_err(|_| job.done = PASSES.len())?;
            let pixels = image.data().chunks_exact(image.channels() as usize);
            let bytes: Vec<u8> = pixels.flat_map(|pixel| [0, 1, 2].map(|channel| srgb_byte(pixel[channel]))).collect();
            let image = ColorImage::from_rgb([image.width() as usize, image.height() as usize], &bytes);
            self.picture = Some(ui.ctx().load_texture("rays", image, TextureOptions::LINEAR));
        }
        if let Some(picture) = &self.picture {
            let whole = Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(1.0, 1.0));
            ui.painter_at(area).image(picture.id(), area, whole, egui::Color32::WHITE);
        }
        Ok(())
    }
}

/// The view of a camera of the window, with suns that stand beside it.
fn view(camera: &Camera, [width, height]: [u32; 2]) -> Result<View> {
    let axes = camera.axes();
    let (eye, fov) = camera.perspective();
    let mut view = View::new(relievo_render::Camera::look_at(eye, eye - axes.z_axis, axes.y_axis, fov)?);
    let sun = |place: [f64; 3], irradiance: f32| Sun {
        direction: (axes * glam::DVec3::from(place)).as_vec3().to_array(),
        irradiance: [irradiance; 3],
        angular_radius: 0.03,
    };
    let up = axes.y_axis.as_vec3().to_array();
    view.lights = Lights {
        suns: vec![sun([-0.45, 0.6, 0.66], 2.2), sun([0.8, 0.1, 0.6], 0.5)],
        sky: Sky { up, zenith: [0.42; 3], horizon: [0.3; 3], ground: [0.12; 3] },
    };
    [view.settings.width, view.settings.height] = [width, height];
    Ok(view)
}

fn begin(mesh: Mesh, mut view: View, egui: egui::Context) -> Result<Job> {
    let (sender, pictures) = channel();
    let stops = Arc::new(AtomicBool::new(false));
    let stop = Arc::clone(&stops);
    let work = move || {
        let make = || -> Result<(Context, Scene)> {
            let mut scene = Scene::new()?;
            let object = scene.add_object(DAffine3::IDENTITY, Material::default())?;
            scene.set_mesh(object, 0, mesh)?;
            Ok((Context::new(&ContextOptions::default())?, scene))
        };
        let (context, mut scene) = match make() {
            Ok(made) => made,
            Err(error) => {
                // Nobody waits for it where the window was closed.
                let _ = sender.send(Err(error));
                return egui.request_repaint();
            }
        };
        for samples in PASSES {
            if stop.load(Ordering::Relaxed) {
                return;
            }
            view.settings.samples = samples;
            let made = scene.render(&context, &view).map(|frame| {
                let (mut color, depth) = (frame.color, frame.depth);
                let [width, height] = [color.width(), color.height()];
                for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                    if depth.pixel(x, y).first().is_none_or(|depth| !depth.is_finite()) {
                        color.set_color(x, y, BEHIND);
                    }
                }
                color
            });
            let is_faulty = made.is_err();
            if sender.send(made).is_err() || is_faulty {
                break;
            }
            egui.request_repaint();
        }
    };
    std::thread::Builder::new()
        .name("rays".into())
        .spawn(work)
        .map_err(|error| Error::invalid(format!("the caster has no thread: {error}")))?;
    Ok(Job { stops, pictures, done: 0 })
}

/// Makes normals of points by the areas of their triangles, and triangles of corners.
pub(crate) fn smooth_normals(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![Vec3::ZERO; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|point| Vec3::from(points[point as usize]));
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|point| sums[*point as usize] += normal);
    }
    sums.into_iter().map(|normal| normal.normalize_or(Vec3::Z).to_array()).collect()
}
