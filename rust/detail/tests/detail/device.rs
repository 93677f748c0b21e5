//! Dabs and strokes of a graphics device, which are those of the processor.

mod bent;
mod copies;
mod fading;
mod history;
mod imprints;
mod rims;
mod smoothing;
mod triangle_imprints;
mod triangle_vectors;
mod triangles;
mod vectors;

use glam::{DAffine3, DMat3, DVec3, Vec4};
use half::f16;
use relievo_core::parameter::Switch;
use relievo_core::{Context, ErrorKind, Mesh};
use relievo_detail::{
    Action, Brush, Dab, DabReport, DisplacedObject, Falloff, PaintMode, SculptMode, Stamp, StampChannel, StampImage,
    StampSettings, Stroke, StrokePoint, StrokeReport, StrokeSettings,
};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_testing::{Random, device, grid};
use relievo_tiles::{ChannelOptions, Displacement, DisplacementOptions, Field, Paint, Rgba16};

/// Modes of sculpting, with their heights.
const SCULPTING: [(SculptMode, f32); 8] = [
    (SculptMode::Draw, 0.2),
    (SculptMode::Smooth, 0.0),
    (SculptMode::Flatten, 0.0),
    (SculptMode::Erase, 0.0),
    (SculptMode::Clay, 0.1),
    (SculptMode::Scrape, 0.0),
    (SculptMode::Layer, -0.1),
    (SculptMode::Inflate, 0.05),
];

/// Modes of painting, with their colours.
const PAINTING: [(PaintMode, [f32; 4]); 6] = [
    (PaintMode::Mix, [0.9, 0.1, 0.05, 1.0]),
    (PaintMode::Add, [0.2, 0.3, 0.0, 1.0]),
    (PaintMode::Multiply, [0.5, 1.5, 0.9, 1.0]),
    (PaintMode::Blur, [0.0; 4]),
    (PaintMode::Erase, [0.0; 4]),
    (PaintMode::Smear, [0.0; 4]),
];

/// Turns, scales and moves an object.
fn turned() -> DAffine3 {
    let turn = glam::DQuat::from_rotation_y(0.4);
    DAffine3::from_scale_rotation_translation(DVec3::splat(1.5), turn, DVec3::new(0.3, -1.0, 2.0))
}

/// Fails unless strokes with a stamp, on the processor and on a device, changed the same, and what they left is few steps of
/// half floats and a number of colours apart.
fn assert_stamped_alike([expected, found]: [&StrokeReport; 2], (apart, colors): (i32, f32), action: Action) {
    assert!(expected.report.changed_texels > 500, "{expected:?}");
    assert_eq!((found.dabs, &found.report.changed), (expected.dabs, &expected.report.changed));
    assert!(apart <= 16 && colors <= 1.0, "{action:?}: {apart} steps, {colors}");
}

fn object(context: &Context) -> DisplacedObject {
    let mesh = grid(6, true, &[2, 3, 2, 1], false);
    let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = DisplacementOptions { size: 32, face_sizes: vec![(3, 64), (8, 8)], ..Default::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    DisplacedObject::new(context, surface, &mesh.points, displacement, turned()).unwrap()
}

/// Coefficients of two objects: how many differ, and the largest difference in steps of half floats.
fn difference(a: &DisplacedObject, b: &DisplacedObject) -> (usize, i32) {
    let (a, b) = (a.displacement().field(), b.displacement().field());
    let tiles = |field: &Field| field.allocated().collect::<Vec<_>>();
    assert_eq!(tiles(a), tiles(b), "the tiles that are allocated");
    // Half floats in order, so that neighbours are one apart.
    let order = |half: f16| {
        let bits = i32::from(half.to_bits());
        if bits & 0x8000 == 0 { bits } else { 0x8000 - bits }
    };
    let pairs = tiles(a).into_iter().flat_map(|tile| a.block(tile).unwrap().iter().zip(b.block(tile).unwrap()));
    pairs.fold((0, 0), |(count, most), (a, b)| {
        let apart = (order(*a) - order(*b)).abs();
        (count + usize::from(apart > 0), most.max(apart))
    })
}

#[test]
fn dabs_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let (mut differing, mut changed) = (0, 0);
    for (falloff, _) in Falloff::NAMES {
        for (mode, height) in SCULPTING {
            // Something to begin with, the same for both.
            let (mut here, mut there) = (object(&context), object(&context));
            let place = here.transform().transform_point3(DVec3::new(3.6, 0.4, 0.6));
            let axes = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.2, 0.1);
            let dab = |mode, height, size, falloff| Dab {
                brush: Brush::new(place, axes, DVec3::splat(size), falloff).unwrap(),
                action: Action::Sculpt { mode, height },
                strength: 0.8,
            };
            let base = dab(SculptMode::Draw, 0.15, 1.2, Falloff::Gaussian);
            for object in [&mut here, &mut there] {
                base.apply(&context, object).unwrap();
            }
            there.use_device(Some(&device)).unwrap();
            for size in [1.0, 1.7] {
                let dab = dab(mode, height, size, falloff);
                let expected = dab.apply(&context, &mut here).unwrap();
                let found = dab.apply(&context, &mut there).unwrap();
                assert_eq!(found.changed, expected.changed, "{mode:?} {falloff:?}");
                let (differ, apart) = difference(&here, &there);
                assert!(apart <= 1 || mode == SculptMode::Inflate && apart <= 8, "{mode:?} {falloff:?}: {apart} steps");
                differing += differ;
                changed += expected.changed_texels as usize;
            }
        }
    }
    println!("{differing} of {changed} coefficients differ");
    assert!(differing * 100 < changed, "{differing} of {changed} coefficients differ");
}

#[test]
fn strokes_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let modes =
        [(SculptMode::Draw, 0.1), (SculptMode::Layer, 0.1), (SculptMode::Clay, 0.05), (SculptMode::Smooth, 0.0)];
    for (mode, height) in modes {
        let [mut here, mut there] = [object(&context), object(&context)];
        // Something with edges to smooth.
        let place = here.transform().transform_point3(DVec3::new(3.4, 0.9, 0.6));
        for object in [&mut here, &mut there] {
            draw(place, DVec3::splat(1.1), SculptMode::Draw).apply(&context, object).unwrap();
        }
        there.use_device(Some(&device)).unwrap();
        // A pose that was made on the device.
        let cage: Vec<[f32; 3]> = grid(6, true, &[2, 3, 2, 1], false).points;
        let cage: Vec<_> = cage.iter().map(|p| [p[0], p[1] + 0.1 * p[0], 1.2 * p[2]]).collect();
        for object in [&mut here, &mut there] {
            object.pose(&context, &cage).unwrap();
        }
        let points = (0..5).map(|k| {
            let place = DVec3::new(3.4, 0.34 + 0.3 * f64::from(k), 0.6);
            StrokePoint::new(here.transform().transform_point3(place), 1.0)
        });
        let settings = StrokeSettings { radius: 0.9, spacing: 0.5, ..StrokeSettings::default() };
        let stroke = Stroke::new(points.collect(), settings, Falloff::Smooth, Action::Sculpt { mode, height });
        for _ in 0..2 {
            let expected = stroke.apply(&context, &mut here).unwrap();
            context.stats().take();
            let found = stroke.apply(&context, &mut there).unwrap();
            let events = context.stats().take().iter().filter(|event| event.stage == "dab.device").count();
            assert!(2 * events <= found.dabs as usize, "{mode:?}: {events} events of {} dabs", found.dabs);
            assert_eq!((found.dabs, found.missed), (expected.dabs, expected.missed));
            assert!(expected.report.changed_texels > 100, "{expected:?}");
            assert_eq!(found.report.changed, expected.report.changed);
        }
        let (differ, apart) = difference(&here, &there);
        println!("{mode:?}: {differ} coefficients of strokes differ, by {apart} steps at most");
        assert!(apart <= 4, "{mode:?}: {apart} steps");
        assert!(there.take_device_fault().is_none());
    }
}

#[test]
fn the_processor_takes_over_from_a_lost_device() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let [mut here, mut there] = [object(&context), object(&context)];
    there.use_device(Some(&device)).unwrap();
    let place = here.transform().transform_point3(DVec3::new(3.6, 0.4, 0.6));
    let dab = Dab {
        brush: Brush::new(place, DMat3::IDENTITY, DVec3::ONE, Falloff::Smooth).unwrap(),
        action: Action::Sculpt { mode: SculptMode::Draw, height: 0.1 },
        strength: 1.0,
    };
    device.abandon();
    for object in [&mut here, &mut there] {
        assert!(!dab.apply(&context, object).unwrap().changed.is_empty());
    }
    assert_eq!(difference(&here, &there), (0, 0));
    let fault = there.take_device_fault().expect("it is told");
    assert_eq!(fault.kind, ErrorKind::Device, "{fault}");
    assert!(there.take_device_fault().is_none(), "once");
}

/// A sheet of whole faces of one size, regular but for its rim.
fn sheet(context: &Context, side: u32, size: u32) -> DisplacedObject {
    laid(context, (side, size), 0.0, DAffine3::IDENTITY)
}

/// A sheet of so many faces a side whose first corner is at `from` along x and y.
fn laid(context: &Context, (side, size): (u32, u32), from: f32, transform: DAffine3) -> DisplacedObject {
    let row = side + 1;
    let along = |k: u32| from + k as f32;
    let points = (0..row * row).map(|at| [along(at % row), along(at / row), 0.1 * ((at % row) as f32).sin()]);
    let corners = (0..side * side).map(|face| face / side * row + face % side);
    let corners = corners.flat_map(|at| [at, at + 1, at + row + 1, at + row]).collect();
    let mesh = Mesh::new(points.collect(), vec![4; (side * side) as usize], corners);
    let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = DisplacementOptions { size, ..Default::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    DisplacedObject::new(context, surface, &mesh.points, displacement, transform).unwrap()
}

fn draw(place: DVec3, half: DVec3, mode: SculptMode) -> Dab {
    let brush = Brush::new(place, DMat3::IDENTITY, half, Falloff::Constant).unwrap();
    Dab { brush, action: Action::Sculpt { mode, height: 0.1 }, strength: 1.0 }
}

#[test]
fn sets_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    // Blocks of these tiles are as large as can be: the device begins with room for fewer than there are.
    let [mut here, mut there] = [sheet(&context, 7, 256), sheet(&context, 7, 256)];
    there.use_device(Some(&device)).unwrap();
    let middle = DVec3::new(3.5, 3.5, 0.0);
    let dabs = [
        // Nothing, a part of a tile, its neighbours too, what is allocated already, everything, and nothing again.
        (draw(middle + DVec3::Z * 3.0, DVec3::splat(0.5), SculptMode::Draw), 0),
        (draw(middle, DVec3::splat(0.3), SculptMode::Draw), 1),
        (draw(middle, DVec3::new(0.9, 0.3, 0.5), SculptMode::Draw), 3),
        (draw(middle, DVec3::new(0.9, 0.3, 0.5), SculptMode::Draw), 3),
        (draw(middle, DVec3::splat(9.0), SculptMode::Draw), 49),
        (draw(middle, DVec3::splat(9.0), SculptMode::Erase), 49),
    ];
    for (index, (dab, tiles)) in dabs.iter().enumerate() {
        let expected = dab.apply(&context, &mut here).unwrap();
        let found = dab.apply(&context, &mut there).unwrap();
        assert_eq!(expected.changed.len(), *tiles, "dab {index}");
        let sets = |report: &DabReport| {
            (report.changed.clone(), report.changed_texels, report.allocated, report.freed, report.bytes)
        };
        assert_eq!(sets(&found), sets(&expected), "dab {index}");
        assert!(found.tested_tiles >= *tiles as u64 && found.tested_tiles <= 49, "dab {index}: {found:?}");
        let (_, apart) = difference(&here, &there);
        assert!(apart <= 1, "dab {index}: {apart} steps");
    }
    assert_eq!(there.displacement().allocated_count(), 0);
    assert!(there.take_device_fault().is_none());
}

#[test]
fn dabs_of_an_event_are_made_at_once_in_buffers_that_are_kept() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let stroke = |mode, points: u32| {
        let at = |k: u32| StrokePoint::new(DVec3::new(3.0 + 0.1 * f64::from(k), 3.6, 0.0), 1.0);
        let settings = StrokeSettings { radius: 0.8, spacing: 0.125, ..StrokeSettings::default() };
        let action = Action::Sculpt { mode, height: 0.02 };
        Stroke::new((0..points).map(at).collect(), settings, Falloff::Smooth, action)
    };
    let [mut here, mut there] = [sheet(&context, 8, 32), sheet(&context, 8, 32)];
    there.use_device(Some(&device)).unwrap();
    let mut memory = Vec::new();
    // Smoothing looks at neighbours, which the device brings up to date between dabs.
    for mode in [SculptMode::Draw, SculptMode::Smooth, SculptMode::Draw, SculptMode::Draw] {
        let stroke = stroke(mode, 9);
        let expected = stroke.apply(&context, &mut here).unwrap();
        context.stats().take();
        let found = stroke.apply(&context, &mut there).unwrap();
        let made = context.stats().take().iter().filter(|event| event.stage == "dab.device").count();
        assert_eq!(made, 1, "{mode:?}");
        assert!(expected.dabs > 5, "{expected:?}");
        assert_eq!((found.dabs, &found.report.changed), (expected.dabs, &expected.report.changed));
        assert_eq!(found.report.allocated, expected.report.allocated);
        let (_, apart) = difference(&here, &there);
        assert!(apart <= 2, "{mode:?}: {apart} steps");
        memory.push(device.memory());
    }
    assert_eq!(memory[2], memory[3]);
    assert!(there.take_device_fault().is_none());
}

/// The largest difference of the colours of two objects: in bytes, or in 255ths.
fn color_difference(a: &DisplacedObject, b: &DisplacedObject) -> f32 {
    let mut most = 0.0f32;
    let mut compare = |a: [f32; 4], b: [f32; 4]| (0..4).for_each(|c| most = most.max((a[c] - b[c]).abs()));
    if let (Some(a), Some(b)) = (a.paint(), b.paint()) {
        assert_eq!(a.field().allocated().collect::<Vec<_>>(), b.field().allocated().collect::<Vec<_>>());
        for tile in a.field().allocated() {
            let blocks = [a, b].map(|paint| paint.field().block(tile).unwrap());
            blocks[0].iter().zip(blocks[1]).for_each(|(a, b)| compare(a.0.map(f32::from), b.0.map(f32::from)));
        }
    }
    if let (Some(a), Some(b)) = (a.half_paint(), b.half_paint()) {
        assert_eq!(a.field().allocated().collect::<Vec<_>>(), b.field().allocated().collect::<Vec<_>>());
        let scaled = |texel: &Rgba16| texel.0.map(|number| 255.0 * number.to_f32());
        for tile in a.field().allocated() {
            let blocks = [a, b].map(|paint| paint.field().block(tile).unwrap());
            blocks[0].iter().zip(blocks[1]).for_each(|(a, b)| compare(scaled(a), scaled(b)));
        }
    }
    most
}

#[test]
fn colours_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let blank = Vec4::new(0.5, 0.4, 0.3, 1.0);
    let make = |half: bool| {
        let mut object = object(&context);
        let options = ChannelOptions { size: 32, face_sizes: vec![(3, 16)], ..Default::default() };
        let topology = object.surface().topology().clone();
        match half {
            false => object.set_paint(Paint::of_color(topology, blank, &options).unwrap()).unwrap(),
            true => object.set_half_paint(Paint::of_color(topology, blank, &options).unwrap()).unwrap(),
        }
        // Colours lie on what is displaced.
        let place = object.transform().transform_point3(DVec3::new(3.6, 0.4, 0.6));
        draw(place, DVec3::splat(1.2), SculptMode::Draw).apply(&context, &mut object).unwrap();
        object
    };
    for half in [false, true] {
        let [mut here, mut there] = [make(half), make(half)];
        there.use_device(Some(&device)).unwrap();
        for (falloff, (mode, color)) in Falloff::NAMES.into_iter().map(|(falloff, _)| falloff).cycle().zip(PAINTING) {
            let at = |k: u32| here.transform().transform_point3(DVec3::new(3.2 + 0.2 * f64::from(k), 0.4, 0.6));
            let points = (0..4).map(|k| StrokePoint::new(at(k), 1.0)).collect();
            let settings = StrokeSettings { radius: 0.9, spacing: 0.3, strength: 0.7, ..StrokeSettings::default() };
            let stroke = Stroke::new(points, settings, falloff, Action::Paint { mode, color });
            let expected = stroke.apply(&context, &mut here).unwrap();
            context.stats().take();
            let found = stroke.apply(&context, &mut there).unwrap();
            assert!(context.stats().take().iter().any(|event| event.stage == "dab.device"), "{mode:?}");
            assert_eq!(found.dabs, expected.dabs, "{mode:?}");
            assert!(expected.report.changed_texels > 500, "{expected:?}");
            assert_eq!(found.report.changed, expected.report.changed, "{mode:?}");
            let apart = color_difference(&here, &there);
            assert!(apart <= 1.0, "{mode:?}, half floats {half}: {apart}");
        }
        assert!(there.take_device_fault().is_none());
    }
}

#[test]
fn smears_over_objects_and_with_mirror_images_are_as_few_submissions_as_their_order_allows() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let make = |x: f64| {
        let mut object = laid(&context, (4, 32), -2.0, DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)));
        let options = ChannelOptions { size: 32, ..Default::default() };
        let paint = Paint::of_color(object.surface().topology().clone(), Vec4::splat(0.5), &options).unwrap();
        object.set_paint(paint).unwrap();
        // Something to smear on both sides of the mirror.
        for (at, color) in [([-1.0, 0.7], [0.9, 0.1, 0.05, 1.0]), ([0.6, -0.5], [0.1, 0.2, 0.9, 1.0])] {
            let place = DVec3::new(x + at[0], at[1], 0.0);
            let brush = Brush::new(place, DMat3::IDENTITY, DVec3::splat(0.7), Falloff::Smooth).unwrap();
            let action = Action::Paint { mode: PaintMode::Mix, color };
            Dab { brush, action, strength: 1.0 }.apply(&context, &mut object).unwrap();
        }
        object
    };
    let smear = Action::Paint { mode: PaintMode::Smear, color: [0.0; 4] };
    // Of the 11 dabs 4 reach both sheets where these meet, and others one. None reaches the third.
    for (count, symmetry, dabs, submissions) in
        [(1, Switch::ON, 22, 1), (3, Switch::OFF, 11, 2 + 2 * 4), (2, Switch::ON, 22, 2 + 2 * 8)]
    {
        let [mut here, mut there] = [0, 1].map(|_| [make(0.0), make(4.0), make(8.0)]);
        for object in &mut there {
            object.use_device(Some(&device)).unwrap();
        }
        let ends = if count == 1 { [-1.3, 1.2] } else { [0.75, 3.25] };
        // Mirror images reach what the brush has left, and it what they have.
        let points = ends.map(|x| StrokePoint::new(DVec3::new(x, 0.3, 0.0), 1.0)).to_vec();
        let settings = StrokeSettings { radius: 0.5, spacing: 0.5, symmetry_y: symmetry, ..StrokeSettings::default() };
        let stroke = Stroke::new(points, settings, Falloff::Smooth, smear);
        let all =
            |objects: &mut [DisplacedObject; 3]| stroke.apply_all(&context, &mut objects.each_mut()[..count]).unwrap();
        let expected = all(&mut here);
        context.stats().take();
        let found = all(&mut there);
        let made = context.stats().take().iter().filter(|event| event.stage == "dab.device").count();
        for (index, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!(expected.report.changed_texels > 100 || index == 2, "{expected:?}");
            assert_eq!((found.dabs, &found.report.changed), (expected.dabs, &expected.report.changed));
            assert_eq!(found.report.bytes, there[index].paint().unwrap().bytes());
            let apart = color_difference(&here[index], &there[index]);
            assert!(apart <= 1.0, "{count} objects, {symmetry:?}: {apart}");
            assert!(there[index].take_device_fault().is_none());
        }
        let most = expected.iter().map(|done| done.dabs).max();
        println!("{count} objects, {symmetry:?}: {made} submissions, {most:?} dabs");
        assert!(most.is_some_and(|most| most <= dabs));
        assert_eq!(made, submissions, "{count} objects, {symmetry:?}");
    }
}

#[test]
fn stamps_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut random = Random(5);
    let data: Vec<f32> = (0..13 * 9 * 4).map(|_| random.unit()).collect();
    let image = StampImage::new(13, 9, 4, &data).unwrap();
    let on = Switch::ON;
    let once = StampSettings { angle: 0.4, mirror: on, ..StampSettings::default() };
    let often = StampSettings { repeat: 2.5, alternate: on, mid: 0.2, ..StampSettings::default() };
    let actions = [
        (Action::Sculpt { mode: SculptMode::Draw, height: 0.1 }, often, StampChannel::Green),
        (Action::Sculpt { mode: SculptMode::Erase, height: 0.0 }, once, StampChannel::Alpha),
        (Action::Paint { mode: PaintMode::Mix, color: [0.9, 0.5, 0.1, 1.0] }, once, StampChannel::Red),
        (Action::Paint { mode: PaintMode::Multiply, color: [0.5, 0.5, 1.5, 1.0] }, often, StampChannel::Red),
    ];
    let make = || {
        let mut object = sheet(&context, 4, 32);
        let options = ChannelOptions { size: 64, ..Default::default() };
        let topology = object.surface().topology().clone();
        object.set_paint(Paint::of_color(topology, Vec4::splat(0.5), &options).unwrap()).unwrap();
        object
    };
    let [mut here, mut there] = [make(), make()];
    there.use_device(Some(&device)).unwrap();
    for (action, settings, channel) in actions {
        let points = [1.2, 1.7, 2.2].map(|x| StrokePoint::new(DVec3::new(x, 1.6, 0.0), 1.0)).to_vec();
        // Mirror images see the other side.
        let settings_of = StrokeSettings { radius: 0.8, spacing: 0.5, symmetry_y: on, ..StrokeSettings::default() };
        let mut stroke = Stroke::new(points, settings_of, Falloff::Smooth, action);
        stroke.stamp = Some(Stamp::new(image.clone(), settings, channel).unwrap());
        let expected = stroke.apply(&context, &mut here).unwrap();
        let found = stroke.apply(&context, &mut there).unwrap();
        let apart = (difference(&here, &there).1, color_difference(&here, &there));
        assert_stamped_alike([&expected, &found], apart, action);
    }
    assert!(there.take_device_fault().is_none());
}

#[test]
fn levels_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let make = || {
        let mut object = object(&context);
        let options = ChannelOptions { size: 32, face_sizes: vec![(3, 16)], ..Default::default() };
        let topology = object.surface().topology().clone();
        object.set_paint(Paint::of_color(topology, Vec4::splat(0.5), &options).unwrap()).unwrap();
        object
    };
    let [mut here, mut there] = [make(), make()];
    let stroke = |action, radius, level| {
        let at = |k: u32| here.transform().transform_point3(DVec3::new(3.2 + 0.2 * f64::from(k), 0.4, 0.6));
        let points = (0..4).map(|k| StrokePoint::new(at(k), 1.0)).collect();
        let settings = StrokeSettings { radius, spacing: 0.5, level, ..StrokeSettings::default() };
        Stroke::new(points, settings, Falloff::Smooth, action)
    };
    let sculpt = |mode| Action::Sculpt { mode, height: 0.1 };
    let paint = |mode| Action::Paint { mode, color: [0.9, 0.5, 0.1, 1.0] };
    // Detail that stays, on a part of what comes.
    let detail = [sculpt(SculptMode::Draw), paint(PaintMode::Mix)].map(|action| stroke(action, 0.4, 0));
    let coarse = [
        (1, sculpt(SculptMode::Draw)),
        (2, sculpt(SculptMode::Clay)),
        (1, sculpt(SculptMode::Smooth)),
        (2, sculpt(SculptMode::Erase)),
        (2, paint(PaintMode::Mix)),
        (1, paint(PaintMode::Blur)),
    ];
    let coarse = coarse.map(|(level, action)| (level, action, stroke(action, 0.9, level)));
    for stroke in &detail {
        stroke.apply(&context, &mut here).unwrap();
        stroke.apply(&context, &mut there).unwrap();
    }
    there.use_device(Some(&device)).unwrap();
    for (level, action, stroke) in &coarse {
        let expected = stroke.apply(&context, &mut here).unwrap();
        context.stats().take();
        let found = stroke.apply(&context, &mut there).unwrap();
        let made = context.stats().take().iter().filter(|event| event.stage == "dab.device").count();
        assert_eq!(made, found.dabs as usize, "{level} {action:?}");
        assert!(expected.report.changed_texels > 20, "{expected:?}");
        assert_eq!((found.dabs, &found.report.changed), (expected.dabs, &expected.report.changed), "{action:?}");
        let (_, apart) = difference(&here, &there);
        let colors = color_difference(&here, &there);
        println!("{level} {action:?}: {apart} steps, colours {colors}");
        assert!(apart <= 4 && colors <= 1.0, "{level} {action:?}: {apart} steps, {colors}");
    }
    assert!(there.take_device_fault().is_none());
}
