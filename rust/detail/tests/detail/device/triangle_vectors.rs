//! Dabs and strokes of a graphics device on triangle meshes with vector displacement, which are those of the processor.

use glam::{DMat3, DVec3, Vec4};
use relievo_core::Context;
use relievo_detail::{
    Action, Brush, Dab, Falloff, PaintMode, SculptMode, Stamp, StampChannel, StampImage, StampSettings, StrokeSettings,
    TriangleObject,
};
use relievo_testing::{Random, device};
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};

use super::triangles::{color_difference, object, pairs, stroke};
use super::vectors::Apart;

fn sculpt(mode: SculptMode, height: f32) -> Action {
    Action::Sculpt { mode, height }
}

/// A mesh with vectors and colours, raised and bent a bit.
pub(crate) fn bent(context: &Context) -> TriangleObject {
    let mut object = object(context, 16);
    let topology = object.surface().topology().clone();
    let options = TriangleOptions { segments: 16, ..Default::default() };
    object.set_paint(TriangleChannel::of_color(topology.clone(), Vec4::splat(0.5), &options).unwrap()).unwrap();
    object.set_vectors(TriangleChannel::vectors(topology, &options).unwrap()).unwrap();
    for (mode, height, size) in [(SculptMode::Draw, 0.1, 1.0), (SculptMode::Vector, 0.12, 1.6)] {
        let axes = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.2, 0.1);
        let place = object.transform().transform_point3(DVec3::new(2.2, 2.3, 0.1));
        let brush = Brush::new(place, axes, DVec3::splat(size), Falloff::Gaussian).unwrap();
        object.dab(context, &Dab { brush, action: sculpt(mode, height), strength: 0.8 }).unwrap();
    }
    object
}

/// Adds how far coefficients and vectors are apart.
fn add(apart: &mut Apart, a: &TriangleObject, b: &TriangleObject) {
    for (a, b) in pairs(a.displacement().field(), b.displacement().field()) {
        apart.add(a, b, |value| [value.to_f32()]);
    }
    let [a, b] = [a, b].map(|object| object.vectors().unwrap().field());
    for (a, b) in pairs(a, b) {
        apart.add(a, b, |vector| vector.0.map(|value| value.to_f32()));
    }
}

#[test]
fn strokes_of_a_device_on_vectors_of_triangles_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut random = Random(7);
    let data: Vec<f32> = (0..9 * 7 * 4).map(|_| random.unit()).collect();
    let often = StampSettings { repeat: 1.5, mid: 0.4, angle: 0.4, ..StampSettings::default() };
    let image = Stamp::new(StampImage::new(9, 7, 4, &data).unwrap(), often, StampChannel::Red).unwrap();
    let paint = |mode| Action::Paint { mode, color: [0.9, 0.1, 0.05, 1.0] };
    for (action, level, stamped) in [
        (sculpt(SculptMode::Vector, 0.1), 0, false),
        (sculpt(SculptMode::Vector, -0.2), 0, true),
        (sculpt(SculptMode::Pinch, 0.1), 0, false),
        (sculpt(SculptMode::Pinch, -0.1), 0, true),
        (sculpt(SculptMode::Smooth, 0.0), 0, false),
        (sculpt(SculptMode::Erase, 0.0), 0, false),
        (sculpt(SculptMode::Vector, 0.1), 1, false),
        (sculpt(SculptMode::Draw, 0.1), 0, false),
        (sculpt(SculptMode::Inflate, 0.02), 0, false),
        (paint(PaintMode::Mix), 0, false),
        (paint(PaintMode::Blur), 0, false),
    ] {
        let [mut here, mut there] = [bent(&context), bent(&context)];
        there.use_device(Some(&device)).unwrap();
        let settings = StrokeSettings { radius: 0.9, spacing: 0.5, level, ..StrokeSettings::default() };
        let mut stroke = stroke(&here, &[[1.6, 2.0, 0.0], [2.6, 2.4, 0.0]], action, settings);
        stroke.stamp = stamped.then(|| image.clone());
        let expected = stroke.apply(&context, &mut here).unwrap();
        context.stats().take();
        let found = stroke.apply(&context, &mut there).unwrap();
        let events = context.stats().take().iter().filter(|event| event.stage == "dab.device").count();
        // Modes that change heights and vectors, and coarser levels, are made dab by dab.
        let at_once =
            level == 0 && !matches!(action, Action::Sculpt { mode: SculptMode::Smooth | SculptMode::Erase, .. });
        assert!(events > 0 && (!at_once || events < found.dabs as usize), "{action:?}: {events} submissions");
        assert_eq!((found.dabs, &found.report.changed), (expected.dabs, &expected.report.changed), "{action:?}");
        if !matches!(action, Action::Paint { mode: PaintMode::Blur, .. }) {
            assert!(expected.report.changed_texels > 100, "{action:?}: {expected:?}");
        }
        let mut apart = Apart::default();
        add(&mut apart, &here, &there);
        apart.check(&format!("{action:?} at level {level}, with an image: {stamped}"));
        assert!(color_difference(&here, &there) <= 1.0, "{action:?}");
        assert!(there.take_device_fault().is_none());
    }
}
