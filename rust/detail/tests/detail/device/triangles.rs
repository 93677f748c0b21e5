//! Dabs and strokes on triangle meshes of a graphics device, which are those of the processor.

use glam::{DMat3, DVec3, Vec4};
use half::f16;
use relievo_core::{Context, ErrorKind, Mesh};
use relievo_detail::{
    Action, Brush, Dab, DabReport, Falloff, PaintMode, SculptMode, Stamp, StampChannel, StampImage, StampSettings,
    Stroke, StrokePoint, StrokeReport, StrokeSettings, TriangleObject,
};
use relievo_surface::TriangleSurface;
use relievo_testing::{Random, device};
use relievo_tiles::triangle::{TriangleChannel, TriangleField, TriangleOptions};
use relievo_tiles::{Rgba8, Rgba16, Texel};

use super::{PAINTING, SCULPTING, assert_stamped_alike, turned};

/// A bent square of 5 × 5 pairs of triangles, some of them wound the other way, with a third triangle along an edge in its
/// middle.
fn mesh() -> Mesh {
    let at = |k: u32| [(k % 6) as f32, (k / 6) as f32];
    let height = |[x, y]: [f32; 2]| 0.06 * x * x - 0.04 * x * y;
    let mut points: Vec<[f32; 3]> = (0..36).map(|k| [at(k)[0], at(k)[1], height(at(k))]).collect();
    let mut triangles = Vec::new();
    for corner in (0..25).map(|k| k / 5 * 6 + k % 5) {
        triangles.push([corner, corner + 1, corner + 7]);
        triangles.push([corner + 6, corner, corner + 7]);
    }
    triangles[6].swap(0, 1);
    points.push([2.5, 2.5, 2.0]);
    triangles.push([14, 15, 36]);
    Mesh::from_triangles(points, &triangles)
}

pub(crate) fn object(context: &Context, segments: u32) -> TriangleObject {
    let surface = TriangleSurface::new(context, &mesh()).unwrap();
    let options = TriangleOptions { segments, ..Default::default() };
    let displacement = TriangleChannel::displacement(surface.topology().clone(), &options).unwrap();
    TriangleObject::new(context, surface, displacement, turned()).unwrap()
}

/// The texels of two fields, block by block, which have the same ones.
pub(crate) fn pairs<'a, T: Texel>(a: &'a TriangleField<T>, b: &'a TriangleField<T>) -> Vec<(&'a [T], &'a [T])> {
    let faces = |field: &TriangleField<T>| field.allocated().collect::<Vec<_>>();
    let edges = |field: &TriangleField<T>| field.allocated_edges().collect::<Vec<_>>();
    assert_eq!((faces(a), edges(a)), (faces(b), edges(b)), "the blocks that are allocated");
    let inside = faces(a).into_iter().map(|face| (a.face(face).unwrap(), b.face(face).unwrap()));
    let along = edges(a).into_iter().map(|edge| (a.edge(edge).unwrap(), b.edge(edge).unwrap()));
    inside.chain(along).chain(a.vertices().zip(b.vertices())).collect()
}

/// Coefficients of two objects: how many differ, and the largest difference in steps of half floats, those below 2⁻⁷ in
/// steps at that: where an edit takes away what was there, what is left is as exact as that was.
fn difference(a: &TriangleObject, b: &TriangleObject) -> (usize, i32) {
    let apart = |a: f16, b: f16| {
        let [a, b] = [a, b].map(f32::from);
        let step = f32::powi(2.0, a.abs().max(b.abs()).max(1.0 / 128.0).log2().floor() as i32 - 10);
        ((a - b).abs() / step).ceil() as i32
    };
    let pairs = pairs(a.displacement().field(), b.displacement().field());
    let all = pairs.into_iter().flat_map(|(a, b)| a.iter().zip(b));
    all.fold((0, 0), |(count, most), (a, b)| (count + usize::from(a != b), most.max(apart(*a, *b))))
}

/// The largest difference of the colours of two objects: in bytes, or in 255ths.
pub(super) fn color_difference(a: &TriangleObject, b: &TriangleObject) -> f32 {
    fn most<T: Texel>(a: &TriangleField<T>, b: &TriangleField<T>, numbers: impl Fn(&T) -> [f32; 4]) -> f32 {
        let all = pairs(a, b).into_iter().flat_map(|(a, b)| a.iter().zip(b));
        let apart = |(a, b): (&T, &T)| (0..4).map(|k| (numbers(a)[k] - numbers(b)[k]).abs()).fold(0.0, f32::max);
        all.map(apart).fold(0.0, f32::max)
    }
    let bytes = a.paint().zip(b.paint()).map(|(a, b)| most(a.field(), b.field(), |it: &Rgba8| it.0.map(f32::from)));
    let scaled = |it: &Rgba16| it.0.map(|number| 255.0 * number.to_f32());
    let halves = a.half_paint().zip(b.half_paint()).map(|(a, b)| most(a.field(), b.field(), scaled));
    bytes.or(halves).unwrap_or_default()
}

/// What reports of the processor and of a device have in common.
fn told(report: &DabReport) -> (&[u32], u64, u64, u64, u64) {
    (&report.changed, report.changed_texels, report.allocated, report.freed, report.bytes)
}

pub(crate) fn stroke(object: &TriangleObject, points: &[[f64; 3]], action: Action, settings: StrokeSettings) -> Stroke {
    let point = |p: &[f64; 3]| StrokePoint::new(object.transform().transform_point3(DVec3::from(*p)), 1.0);
    Stroke::new(points.iter().map(point).collect(), settings, Falloff::Smooth, action)
}

fn apply(context: &Context, stroke: &Stroke, objects: [&mut TriangleObject; 2]) -> [StrokeReport; 2] {
    objects.map(|object| stroke.apply(context, object).unwrap())
}

#[test]
fn dabs_of_a_device_on_triangles_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let (mut differing, mut changed) = (0, 0);
    for (falloff, _) in Falloff::NAMES {
        for (mode, height) in SCULPTING {
            let (mut here, mut there) = (object(&context, 16), object(&context, 16));
            let axes = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.2, 0.1);
            let dab = |at: [f64; 3], mode, height, size: f64, falloff| {
                let place = here.transform().transform_point3(DVec3::from(at));
                let brush = Brush::new(place, axes, DVec3::splat(size), falloff).unwrap();
                Dab { brush, action: Action::Sculpt { mode, height }, strength: 0.8 }
            };
            let base = dab([2.3, 2.4, 0.1], SculptMode::Draw, 0.15, 1.2, Falloff::Gaussian);
            let dabs = [(1.0, [2.4, 2.6, 0.1]), (1.7, [2.8, 2.5, 0.1])];
            let dabs = dabs.map(|(size, at)| dab(at, mode, height, size, falloff));
            for object in [&mut here, &mut there] {
                object.dab(&context, &base).unwrap();
            }
            there.use_device(Some(&device)).unwrap();
            for dab in &dabs {
                let expected = here.dab(&context, dab).unwrap();
                let found = there.dab(&context, dab).unwrap();
                assert_eq!(found.changed, expected.changed, "{mode:?} {falloff:?}");
                assert_eq!(
                    (found.allocated, found.bytes),
                    (expected.allocated, expected.bytes),
                    "{mode:?} {falloff:?}"
                );
                let (differ, apart) = difference(&here, &there);
                // A sphere has no slope at its rim.
                assert!(apart <= 1 || falloff == Falloff::Sphere && apart <= 8, "{mode:?} {falloff:?}: {apart} steps");
                differing += differ;
                changed += expected.changed_texels as usize;
            }
            assert!(there.take_device_fault().is_none());
        }
    }
    println!("{differing} of {changed} coefficients on triangles differ");
    assert!(differing * 100 < changed, "{differing} of {changed} coefficients differ");
}

#[test]
fn strokes_of_a_device_on_triangles_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for (segments, mode, height) in
        [(8, SculptMode::Draw, 0.1), (32, SculptMode::Layer, 0.1), (64, SculptMode::Clay, 0.05)]
    {
        let [mut here, mut there] = [object(&context, segments), object(&context, segments)];
        there.use_device(Some(&device)).unwrap();
        let posed: Vec<_> = mesh().points.iter().map(|p| [p[0], p[1] + 0.1 * p[0], 1.2 * p[2]]).collect();
        for object in [&mut here, &mut there] {
            object.pose(&context, &posed).unwrap();
        }
        let settings = StrokeSettings { radius: 0.9, spacing: 0.5, ..StrokeSettings::default() };
        let action = Action::Sculpt { mode, height };
        let stroke = stroke(&here, &[[1.1, 1.2, 0.0], [3.1, 2.7, 0.0], [3.1, 3.9, 0.0]], action, settings);
        for _ in 0..2 {
            let [expected, found] = apply(&context, &stroke, [&mut here, &mut there]);
            assert_eq!((found.dabs, found.missed), (expected.dabs, expected.missed));
            assert!(expected.dabs > 5 && expected.report.changed_texels > 500, "{expected:?}");
            assert_eq!(found.report.changed, expected.report.changed);
            assert_eq!(
                (found.report.allocated, found.report.bytes),
                (expected.report.allocated, expected.report.bytes)
            );
        }
        let (differ, apart) = difference(&here, &there);
        println!("{segments} {mode:?}: {differ} coefficients of strokes differ, by {apart} steps at most");
        assert!(apart <= 4, "{mode:?}: {apart} steps");
        assert!(there.take_device_fault().is_none());
    }
}

#[test]
fn sets_of_a_device_on_triangles_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [object(&context, 64), object(&context, 64)];
    there.use_device(Some(&device)).unwrap();
    let middle = here.transform().transform_point3(DVec3::new(2.6, 2.4, 0.2));
    let draw = |far: f64, half: f64, mode| {
        let place = middle + DVec3::Y * far;
        let brush = Brush::new(place, DMat3::IDENTITY, DVec3::splat(half), Falloff::Constant).unwrap();
        Dab { brush, action: Action::Sculpt { mode, height: 0.1 }, strength: 1.0 }
    };
    let dabs = [
        // Nothing, the inside of a triangle or two, more, what is allocated already, everything, and nothing again.
        (draw(30.0, 0.5, SculptMode::Draw), 0),
        (draw(0.0, 0.1, SculptMode::Draw), 1),
        (draw(0.9, 1.1, SculptMode::Draw), 6),
        (draw(0.9, 1.1, SculptMode::Draw), 6),
        (draw(0.0, 20.0, SculptMode::Draw), 51),
        (draw(0.0, 20.0, SculptMode::Erase), 51),
    ];
    for (index, (dab, least)) in dabs.iter().enumerate() {
        let expected = here.dab(&context, dab).unwrap();
        let found = there.dab(&context, dab).unwrap();
        assert!(expected.changed.len() >= *least, "dab {index}: {expected:?}");
        assert_eq!(told(&found), told(&expected), "dab {index}");
        assert!(found.tested_tiles >= *least as u64 && found.tested_tiles <= 51, "dab {index}: {found:?}");
        let (_, apart) = difference(&here, &there);
        assert!(apart <= 1, "dab {index}: {apart} steps");
    }
    assert_eq!(there.displacement().allocated_count(), 0);
    assert!(there.take_device_fault().is_none());
}

#[test]
fn dabs_of_a_device_on_triangles_are_made_at_once_and_refusals_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    for tight in [false, true] {
        let [mut here, mut there] = [object(&context, 16), object(&context, 16)];
        there.use_device(Some(&device)).unwrap();
        let settings = StrokeSettings { radius: 1.2, spacing: 0.2, ..StrokeSettings::default() };
        let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.02 };
        let stroke = stroke(&here, &[[2.0, 2.0, 0.0], [3.2, 2.4, 0.0]], action, settings);
        if tight {
            for object in [&mut here, &mut there] {
                let bytes = object.displacement().bytes();
                object.displacement_mut().set_budget(bytes + 3000);
            }
        }
        // Nothing comes between the dabs, whether blocks are there, as the second time, or not.
        for time in 0..2 {
            context.stats().take();
            let [expected, found] = apply(&context, &stroke, [&mut here, &mut there]);
            let events = context.stats().take().iter().filter(|event| event.stage == "dab.device").count();
            assert_eq!(events == 1, !tight, "{time}: {events} events");
            assert_eq!(found.report.refused, expected.report.refused);
            assert_eq!(expected.report.refused.is_empty(), !tight);
            assert_eq!(found.report.changed, expected.report.changed);
            assert_eq!(found.report.changed_texels, expected.report.changed_texels);
            let (_, apart) = difference(&here, &there);
            assert!(apart <= 2, "{apart} steps");
        }
        assert!(there.take_device_fault().is_none());
    }
}

#[test]
fn dabs_on_triangles_that_smooth_blur_and_smear_are_one_submission_with_the_bits_of_one_each() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let make = || {
        let mut object = object(&context, 16);
        let topology = object.surface().topology().clone();
        let options = TriangleOptions { segments: 16, ..Default::default() };
        object.set_paint(TriangleChannel::of_color(topology, Vec4::splat(0.5), &options).unwrap()).unwrap();
        object
    };
    let [mut here, mut there, mut apart] = [make(), make(), make()];
    let settings = |radius| StrokeSettings { radius, spacing: 0.2, strength: 0.8, ..StrokeSettings::default() };
    let way = [[1.6, 2.0, 0.0], [2.9, 2.4, 0.0]];
    let sculpt = |mode| Action::Sculpt { mode, height: 0.1 };
    let paint = |mode| Action::Paint { mode, color: [0.9, 0.1, 0.05, 1.0] };
    // Values that differ from place to place, in blocks further around than what follows reaches.
    for (action, radius) in [(sculpt(SculptMode::Draw), 2.0), (sculpt(SculptMode::Draw), 0.3)]
        .into_iter()
        .chain([(paint(PaintMode::Mix), 2.0), (paint(PaintMode::Erase), 0.3)])
    {
        let stroke = stroke(&here, &way, action, settings(radius));
        for object in [&mut here, &mut there, &mut apart] {
            stroke.apply(&context, object).unwrap();
        }
    }
    there.use_device(Some(&device)).unwrap();
    apart.use_device(Some(&device)).unwrap();
    // What the budget might refuse is made dab by dab.
    let bytes = apart.displacement().bytes();
    apart.displacement_mut().set_budget(bytes);
    let colors = apart.paint_mut().unwrap();
    let bytes = colors.bytes();
    colors.set_budget(bytes);
    for action in [sculpt(SculptMode::Smooth), paint(PaintMode::Blur), paint(PaintMode::Smear)] {
        let stroke = stroke(&here, &way, action, settings(0.9));
        let expected = stroke.apply(&context, &mut here).unwrap();
        assert!(expected.dabs > 5 && expected.report.changed_texels > 500, "{expected:?}");
        let mut events = [0, 0];
        for (events, object) in events.iter_mut().zip([&mut there, &mut apart]) {
            context.stats().take();
            let found = stroke.apply(&context, object).unwrap();
            *events = context.stats().take().iter().filter(|event| event.stage == "dab.device").count();
            assert_eq!(found.report.changed, expected.report.changed);
        }
        assert_eq!(events, [1, expected.dabs as usize], "{action:?}");
        // Of several smears the device makes the pictures between them, in single precision.
        let most = if action == paint(PaintMode::Smear) { 1.0 } else { 0.0 };
        assert_eq!(difference(&there, &apart), (0, 0), "{action:?}");
        assert!(color_difference(&there, &apart) <= most, "{action:?}");
        let (_, steps) = difference(&here, &there);
        assert!(steps <= 4 && color_difference(&here, &there) <= 1.0, "{action:?}: {steps} steps");
    }
    assert!(there.take_device_fault().is_none());
}

#[test]
fn colours_of_a_device_on_triangles_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let blank = Vec4::new(0.5, 0.4, 0.3, 1.0);
    // Colours are finer or coarser than the displacement that they lie on.
    let make = |half: bool| {
        let mut object = object(&context, 16);
        let topology = object.surface().topology().clone();
        let options = |segments| TriangleOptions { segments, ..Default::default() };
        match half {
            false => object.set_paint(TriangleChannel::of_color(topology, blank, &options(32)).unwrap()).unwrap(),
            true => object.set_half_paint(TriangleChannel::of_color(topology, blank, &options(8)).unwrap()).unwrap(),
        }
        let brush = Brush::new(
            object.transform().transform_point3(DVec3::new(2.3, 2.4, 0.1)),
            DMat3::IDENTITY,
            DVec3::splat(1.2),
            Falloff::Smooth,
        );
        let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.2 };
        object.dab(&context, &Dab { brush: brush.unwrap(), action, strength: 1.0 }).unwrap();
        object
    };
    for half in [false, true] {
        let [mut here, mut there] = [make(half), make(half)];
        there.use_device(Some(&device)).unwrap();
        for (mode, color) in PAINTING {
            let settings = StrokeSettings { radius: 0.9, spacing: 0.4, strength: 0.7, ..StrokeSettings::default() };
            let action = Action::Paint { mode, color };
            let stroke = stroke(&here, &[[1.6, 2.0, 0.0], [2.4, 2.2, 0.0]], action, settings);
            context.stats().take();
            let [expected, found] = apply(&context, &stroke, [&mut here, &mut there]);
            assert!(context.stats().take().iter().any(|event| event.stage == "dab.device"), "{mode:?}");
            assert_eq!(found.dabs, expected.dabs, "{mode:?}");
            assert!(expected.report.changed_texels > 100, "{expected:?}");
            assert_eq!(found.report.changed, expected.report.changed, "{mode:?}");
            let apart = color_difference(&here, &there);
            assert!(apart <= 1.0, "{mode:?}, half floats {half}: {apart}");
        }
        assert!(there.take_device_fault().is_none());
    }
}

#[test]
fn stamps_of_a_device_on_triangles_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut random = Random(5);
    let data: Vec<f32> = (0..13 * 9 * 4).map(|_| random.unit()).collect();
    let image = StampImage::new(13, 9, 4, &data).unwrap();
    let often = StampSettings { repeat: 2.5, mid: 0.2, angle: 0.4, ..StampSettings::default() };
    let actions = [
        (Action::Sculpt { mode: SculptMode::Draw, height: 0.1 }, StampChannel::Green),
        (Action::Sculpt { mode: SculptMode::Erase, height: 0.0 }, StampChannel::Alpha),
        (Action::Paint { mode: PaintMode::Mix, color: [0.9, 0.5, 0.1, 1.0] }, StampChannel::Red),
    ];
    let make = || {
        let mut object = object(&context, 32);
        let topology = object.surface().topology().clone();
        let paint = TriangleChannel::of_color(topology, Vec4::splat(0.5), &TriangleOptions::default()).unwrap();
        object.set_paint(paint).unwrap();
        object
    };
    let [mut here, mut there] = [make(), make()];
    there.use_device(Some(&device)).unwrap();
    for (action, channel) in actions {
        let settings = StrokeSettings { radius: 0.9, spacing: 0.5, ..StrokeSettings::default() };
        let mut stroke = stroke(&here, &[[1.2, 1.6, 0.0], [2.2, 1.6, 0.0]], action, settings);
        stroke.stamp = Some(Stamp::new(image.clone(), often, channel).unwrap());
        let [expected, found] = apply(&context, &stroke, [&mut here, &mut there]);
        let apart = (difference(&here, &there).1, color_difference(&here, &there));
        assert_stamped_alike([&expected, &found], apart, action);
    }
    assert!(there.take_device_fault().is_none());
}

#[test]
fn levels_of_a_device_on_triangles_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let make = || {
        let mut object = object(&context, 32);
        let topology = object.surface().topology().clone();
        let options = TriangleOptions { segments: 16, ..Default::default() };
        object.set_paint(TriangleChannel::of_color(topology, Vec4::splat(0.5), &options).unwrap()).unwrap();
        object
    };
    let [mut here, mut there] = [make(), make()];
    let [sculpt, clay, inflate] =
        [SculptMode::Draw, SculptMode::Clay, SculptMode::Inflate].map(|mode| Action::Sculpt { mode, height: 0.1 });
    let paint = |mode| Action::Paint { mode, color: [0.9, 0.5, 0.1, 1.0] };
    let settings = |level| StrokeSettings { radius: 0.9, spacing: 0.5, level, ..StrokeSettings::default() };
    // Detail that stays, on a part of what comes.
    let detail = [(sculpt, 0.3), (paint(PaintMode::Mix), 0.4)];
    for (action, radius) in detail {
        let settings = StrokeSettings { radius, ..settings(0) };
        let stroke = stroke(&here, &[[2.2, 2.2, 0.0], [2.9, 2.3, 0.0]], action, settings);
        apply(&context, &stroke, [&mut here, &mut there]);
    }
    there.use_device(Some(&device)).unwrap();
    let coarse = [(1, sculpt), (2, clay), (1, inflate), (2, paint(PaintMode::Mix)), (1, paint(PaintMode::Blur))];
    for (level, action) in coarse {
        let stroke = stroke(&here, &[[1.6, 2.0, 0.0], [2.6, 2.4, 0.0]], action, settings(level));
        context.stats().take();
        let [expected, found] = apply(&context, &stroke, [&mut here, &mut there]);
        assert!(context.stats().take().iter().any(|event| event.stage == "dab.device"));
        assert_eq!((found.dabs, &found.report.changed), (expected.dabs, &expected.report.changed), "{action:?}");
        assert!(expected.report.changed_texels > 100, "{expected:?}");
        let (_, apart) = difference(&here, &there);
        let colors = color_difference(&here, &there);
        assert!(apart <= 4 && colors <= 1.0, "{level} {action:?}: {apart} steps, {colors}");
    }
    assert!(there.take_device_fault().is_none());
}

#[test]
fn the_processor_takes_over_triangles_from_a_lost_device() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [object(&context, 16), object(&context, 16)];
    there.use_device(Some(&device)).unwrap();
    device.abandon();
    let settings = StrokeSettings { radius: 0.9, ..StrokeSettings::default() };
    let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.1 };
    let stroke = stroke(&here, &[[1.2, 1.6, 0.0]], action, settings);
    let [expected, found] = apply(&context, &stroke, [&mut here, &mut there]);
    assert!(expected.report.changed_texels > 0 && found == expected);
    assert_eq!(difference(&here, &there), (0, 0));
    let fault = there.take_device_fault().expect("it is told");
    assert_eq!(fault.kind, ErrorKind::Device, "{fault}");
    assert!(there.take_device_fault().is_none(), "once");
}
