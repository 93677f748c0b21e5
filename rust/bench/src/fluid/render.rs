//! Bench `pictures`, a part of `fluid`: pictures of fluids in the form of Table 2 and of Figures 8 and 9 of Morgenroth,
//! Weiskopf and Eberhardt 2013, whose times, of a 2.0 GHz i7 with four cores, stand beside ours: a dam of 20,000 and of
//! 200,000 particles with a support radius of 4 cm, 1280 × 720 pixels. Ours have one ray a pixel, the paper's several.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, ContextOptions, Result};
use relievo_fluid::{
    Fluid, FluidOptions, March, Motion, RayCaster, Surface, SurfaceFunction, Visibility, basin, block, classify,
};
use relievo_render as render;
use relievo_render::{Camera, Dielectric, Material, Scene, View};
use relievo_scene::isosurface::Isosurface;

use crate::measure::{Sample, seconds};
use crate::report::{Goal, Report};

const PAPER: &str = "Morgenroth 2013, i7";
const SPACING: f32 = 0.02;
const RADIUS: f32 = 0.5 * SPACING;
/// Cells of meshes, in spacings.
const CELL: f32 = 0.5;

/// A dam: its name, the size of what falls, and the paper's seconds of its opaque and transparent pictures by a mesh,
/// directly, and with blind particles.
struct Dam {
    name: &'static str,
    size: [f32; 3],
    paper: [[f64; 2]; 3],
}

const DAMS: [Dam; 2] = [
    Dam { name: "20 k", size: [0.4, 0.5, 0.8], paper: [[36.0, 39.0], [18.0, 55.0], [18.0, 55.0]] },
    Dam { name: "200 k", size: [0.8, 1.0, 2.0], paper: [[166.0, 147.0], [121.0, 378.0], [117.0, 283.0]] },
];

/// Seconds from the beginning at which pictures of Table 2 are made: the water has reached the far wall and stands up.
const MOMENT: f32 = 0.8;
/// Seconds between the pictures of Figures 8 and 9.
const BETWEEN: f32 = 0.2;

/// How a picture is made.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Mesh,
    Direct,
    Blind,
}

/// Measures every case into `report`.
pub fn run(report: &mut Report) -> Result<()> {
    let context = &Context::new(&ContextOptions::default())?;
    for dam in &DAMS {
        let mut fluid = dam.begin(context)?;
        let is_large = dam.name == "200 k";
        let mut now = 0.0;
        while now < MOMENT - 1e-3 {
            if is_large {
                figures(report, context, dam, now, &points(&fluid))?;
            }
            fluid.advance(context, BETWEEN, |_, _| Ok(()))?;
            now += BETWEEN;
        }
        let points = points(&fluid);
        if is_large {
            figures(report, context, dam, now, &points)?;
            first_pixels(report, context, dam, &points)?;
        }
        table(report, context, dam, &points)?;
    }
    Ok(())
}

impl Dam {
    /// The fluid as it begins, in a basin four times as long.
    fn begin(&self, context: &Context) -> Result<Fluid> {
        let options = FluidOptions { spacing: SPACING, ..FluidOptions::default() };
        let mut fluid = Fluid::new(options)?;
        let size = Vec3::from(self.size);
        fluid.add(&block(Vec3::ZERO, size, SPACING)?, Vec3::ZERO)?;
        let high = Vec3::new(4.0 * size.x, size.y, 1.5 * size.z);
        fluid.set_walls(context, &basin(Vec3::ZERO, high, SPACING)?)?;
        Ok(fluid)
    }

    /// From the front and above, with the whole basin in view.
    fn view(&self) -> Result<View> {
        let size = Vec3::from(self.size).as_dvec3();
        let target = DVec3::new(2.0 * size.x, 0.5 * size.y, 0.35 * size.z);
        let eye = target + DVec3::new(0.9, -3.9, 1.9) * size.x * 1.2;
        let mut view = View::new(Camera::look_at(eye, target, DVec3::Z, 0.6)?);
        (view.settings.width, view.settings.height, view.settings.samples) = (1280, 720, 1);
        Ok(view)
    }
}

fn points(fluid: &Fluid) -> Vec<[f32; 3]> {
    fluid.places().iter().map(|place| place.truncate().into()).collect()
}

/// Seconds that a picture takes with what has to be made for it.
fn picture(context: &Context, points: &[[f32; 3]], blind: &[bool], way: Way, clear: bool, view: &View) -> Result<f64> {
    let mut done = Ok(());
    let time = seconds(|| done = draw(context, points, blind, way, clear, view));
    done.map(|()| time)
}

fn draw(context: &Context, points: &[[f32; 3]], blind: &[bool], way: Way, clear: bool, view: &View) -> Result<()> {
    let mut scene = Scene::new()?;
    let floor = scene.add_object(DAffine3::from_scale(DVec3::splat(20.0)), Material::default())?;
    let square = [[-1.0, -1.0, 5e-4], [1.0, -1.0, 5e-4], [1.0, 1.0, 5e-4], [-1.0, 1.0, 5e-4]];
    let triangles = vec![[0, 1, 2], [0, 2, 3]];
    scene.set_mesh(floor, 0, render::Mesh { points: square.to_vec(), triangles, ..render::Mesh::default() })?;
    let water = scene.add_object(DAffine3::IDENTITY, Material { roughness: 0.15, ..Material::default() })?;
    scene.set_dielectric(water, clear.then_some(Dielectric::WATER))?;
    let surface = Arc::new(Surface::new(context, points, SurfaceFunction::zhu_bridson(RADIUS))?);
    if way == Way::Mesh {
        let mesh = relievo_fluid::mesh(context, &surface, CELL * SPACING, &[], &mut Silent)?;
        scene.set_mesh(water, 0, render::Mesh::of_tessellation(mesh))?;
    } else {
        let caster = RayCaster::new(context, &surface, Motion::default(), blind, March::default())?;
        scene.set_implicit(water, Some(Box::new(Isosurface(caster))))?;
    }
    scene.render(context, view).map(|_| ())
}

/// The particles that are kept, and which of them are blind.
fn kept(context: &Context, points: &[[f32; 3]]) -> Result<(Vec<[f32; 3]>, Vec<bool>)> {
    let surface = Surface::new(context, points, SurfaceFunction::zhu_bridson(RADIUS))?;
    let classes = classify(context, points, &surface, None, &mut Silent)?;
    Ok(classes.indices().map(|at| (points[at], classes.of[at] == Visibility::Blind)).unzip())
}

/// Table 2: a mesh, directly, and with blind particles, opaque and transparent.
fn table(report: &mut Report, context: &Context, dam: &Dam, points: &[[f32; 3]]) -> Result<()> {
    let view = dam.view()?;
    let (few, blind) = kept(context, points)?;
    for (way, name, paper) in
        [(Way::Mesh, "mesh", 0), (Way::Direct, "direct", 1), (Way::Blind, "direct, blind particles", 2)]
    {
        let (points, blind) = if way == Way::Blind { (&few[..], &blind[..]) } else { (points, &[][..]) };
        for (clear, look) in [(false, "opaque"), (true, "transparent")] {
            let ours = picture(context, points, blind, way, clear, &view)?;
            let paper = Sample::new(vec![dam.paper[paper][usize::from(clear)]]);
            let name = format!("dam of {}, {look}: {name}", dam.name);
            report.add(&name, &Sample::new(vec![ours]), Some((PAPER, &paper)), "s", Goal::None);
        }
    }
    Ok(())
}

/// Figures 8 and 9: the particles that are kept of a frame, and the time of an opaque picture with them beside that
/// with all.
fn figures(report: &mut Report, context: &Context, dam: &Dam, now: f32, points: &[[f32; 3]]) -> Result<()> {
    let view = dam.view()?;
    let (few, blind) = kept(context, points)?;
    let share = 100.0 * few.len() as f64 / points.len() as f64;
    let name = format!("dam of {}, {now:.1} s", dam.name);
    report.add(&format!("{name}: particles kept"), &Sample::new(vec![share]), None, "%", Goal::None);
    let ours = Sample::new(vec![picture(context, &few, &blind, Way::Blind, true, &view)?]);
    let all = Sample::new(vec![picture(context, points, &[], Way::Direct, true, &view)?]);
    let name = format!("{name}: transparent, blind particles");
    report.add(&name, &ours, Some(("all particles", &all)), "s", Goal::None);
    Ok(())
}

/// How long it is from the particles of a frame to the first pixels of its picture, a block of them.
fn first_pixels(report: &mut Report, context: &Context, dam: &Dam, points: &[[f32; 3]]) -> Result<()> {
    let mut view = dam.view()?;
    (view.settings.width, view.settings.height) = (16, 16);
    for (name, function) in [
        ("blobs", SurfaceFunction::blobs(RADIUS)),
        ("Zhu and Bridson", SurfaceFunction::zhu_bridson(RADIUS)),
        ("anisotropic kernels", SurfaceFunction::anisotropic(RADIUS)),
    ] {
        let first = || -> Result<f64> {
            let mut done = Ok(());
            let time = seconds(|| {
                done = (|| {
                    let mut scene = Scene::new()?;
                    let water = scene.add_object(DAffine3::IDENTITY, Material::default())?;
                    let surface = Arc::new(Surface::new(context, points, function)?);
                    let caster = RayCaster::new(context, &surface, Motion::default(), &[], March::default())?;
                    scene.set_implicit(water, Some(Box::new(Isosurface(caster))))?;
                    scene.render(context, &view).map(|_| ())
                })();
            });
            done.map(|()| time)
        };
        let times = (0..3).map(|_| first()).collect::<Result<Vec<f64>>>()?;
        let name = format!("dam of {}, first pixels, {name}", dam.name);
        report.add(&name, &Sample::new(times), None, "s", Goal::AtMost(1.0));
    }
    Ok(())
}
