//! Far agents as impostors have the brightness and the contrast of their models at full resolution.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use relievo_core::parameter::Switch;
use relievo_core::{Context, ContextOptions, ErrorKind};
use relievo_crowd::{Agent, Cluster, Crowd, CrowdView, Drawn, Frame};
use relievo_render::{Camera, FalseColor, Frame as Pixels, Material, NO_OBJECT, Scene, View};
use relievo_scene::walking::StandIns;

use crate::crowd_devices::arm;

const SIZE: [u32; 2] = [128, 96];

/// Returns agents side by side and one behind the other.
fn crowd() -> Crowd {
    let mut crowd = Crowd::new(vec![Arc::new(arm::built(40, 20))]);
    for index in 0..144 {
        let place = DVec3::new(2.5 * f64::from(index % 12) - 14.0, 0.0, 2.5 * f64::from(index / 12) - 14.0);
        let transform = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.7 * f64::from(index)), place);
        crowd.add(Agent { model: 0, clip: 0, phase: 0.13 * f64::from(index), transform }).unwrap();
    }
    crowd
}

/// Returns the picture of a crowd that is cut at an error in pixels, and how many of its agents are impostors.
fn picture(tolerance: f32, impostors: bool) -> (Pixels, usize) {
    let (context, mut crowd) = (Context::serial(), crowd());
    let camera = Camera::look_at(DVec3::new(0.0, 150.0, 320.0), DVec3::Y, DVec3::Y, 0.2).unwrap();
    let mut view = View::new(camera);
    [view.settings.width, view.settings.height] = SIZE;
    view.settings.samples = 16;
    (view.settings.sky_rays, view.settings.shadows) = (0, Switch::OFF);
    view.lights.sky.up = [0.0, 1.0, 0.0];
    view.lights.suns[0].direction = [-0.5, 0.8, 0.6];
    view.settings.false_color = 1.0;
    view.false_color = Some(FalseColor { palette: vec![[0.02; 3], [0.8, 0.7, 0.2], [0.1, 0.2, 0.5]] });
    let seen = CrowdView::perspective(camera.eye, camera.axes, camera.fov, SIZE, tolerance).unwrap();
    let mut frame = Frame::default();
    crowd.cut(&context, &CrowdView { impostors, ..seen }, &mut frame).unwrap();
    let mut scene = Scene::new().unwrap();
    let tag = |agent: u32, _: &Cluster, _: u32, _: u32| agent;
    let shown = (&crowd, &frame, 0.3, camera.eye);
    StandIns::default().show(&context, &mut scene, shown, Material::default(), &tag).unwrap();
    let quads = frame.drawn.iter().filter(|drawn| drawn.1 == Drawn::Impostor).count();
    (scene.render(&context, &view).unwrap(), quads)
}

/// Returns the mean luminance of some pixels, and the mean of its deviation within five by five pixels around each.
fn look(pixels: &Pixels, chosen: &[usize]) -> [f32; 2] {
    let [width, height] = SIZE.map(|side| side as usize);
    let luminance = |at: usize| {
        let color = pixels.color.color((at % width) as u32, (at / width) as u32);
        Vec3::from(color).dot(Vec3::new(0.2126, 0.7152, 0.0722))
    };
    let around = |at: usize| {
        let range = |at: usize, most: usize| at.saturating_sub(2)..(at + 3).min(most);
        let rows = range(at / width, height).flat_map(|y| range(at % width, width).map(move |x| y * width + x));
        let values: Vec<f32> = rows.map(luminance).collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        (values.iter().map(|value| (value - mean).powi(2)).sum::<f32>() / values.len() as f32).sqrt()
    };
    let count = chosen.len() as f32;
    [
        chosen.iter().map(|at| luminance(*at)).sum::<f32>() / count,
        chosen.iter().map(|at| around(*at)).sum::<f32>() / count,
    ]
}

#[test]
fn far_agents_have_the_brightness_and_the_contrast_of_their_models() {
    let ((full, none), (quads, all)) = (picture(0.02, false), picture(0.5, true));
    assert_eq!((none, all), (0, 144));
    let is_covered = |at: &usize| full.object[*at] != NO_OBJECT;
    let chosen: Vec<usize> = (0..full.object.len()).filter(is_covered).collect();
    assert!(chosen.len() > 250, "{} pixels", chosen.len());
    let ([brightness, contrast], [of_quads, contrast_of_quads]) = (look(&full, &chosen), look(&quads, &chosen));
    let ratios = [of_quads / brightness, contrast_of_quads / contrast];
    println!("brightness {brightness} and {of_quads}, contrast {contrast} and {contrast_of_quads}: {ratios:?}");
    assert!((ratios[0] - 1.0).abs() < 0.03, "{ratios:?}");
    assert!((ratios[1] - 1.0).abs() < 0.08, "{ratios:?}");
}

#[test]
fn agents_beyond_the_memory_limit_are_refused_before_they_are_made() {
    let mut crowd = crowd();
    let mut frame = Frame::default();
    crowd.cut(&Context::serial(), &CrowdView { tolerance: 0.01, ..CrowdView::default() }, &mut frame).unwrap();
    let mut scene = Scene::new().unwrap();
    let mut show = |memory_limit: u64| {
        let context = Context::new(&ContextOptions { threads: 1, memory_limit }).unwrap();
        let shown = (&crowd, &frame, 0.3, DVec3::ZERO);
        StandIns::default().show(&context, &mut scene, shown, Material::default(), &|_, _, _, _| 0)
    };
    let error = show(1 << 20).unwrap_err();
    assert_eq!(error.kind, ErrorKind::Memory);
    assert!(error.to_string().contains("144 agents"), "{error}");
    show(1 << 30).unwrap();
}
