//! Dabs and strokes of a graphics device on surfaces with vector displacement, which are those of the processor.

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::parameter::Switch;
use relievo_core::{Context, ErrorKind};
use relievo_detail::{
    Action, Brush, Dab, DisplacedObject, Falloff, PaintMode, SculptMode, Stamp, StampChannel, StampImage,
    StampSettings, Stroke, StrokePoint, StrokeReport, StrokeSettings,
};
use relievo_surface::{Surface, SurfaceOptions};
use relievo_testing::{Random, device, grid};
use relievo_tiles::{ChannelOptions, Displacement, Field, Paint, Texel, VectorDisplacement};

/// A closed surface with extraordinary vertices, faces that are not quads and tiles of three sizes, bent and raised a bit.
fn object(context: &Context) -> DisplacedObject {
    let mut object = bare(context);
    let options = options();
    object.set_vectors(VectorDisplacement::on(object.surface(), &options).unwrap()).unwrap();
    for (mode, height, size) in [(SculptMode::Draw, 0.1, 1.0), (SculptMode::Vector, 0.12, 1.6)] {
        dab(&object, [3.3, 0.5, 0.5], sculpt(mode, height), size, Falloff::Gaussian)
            .apply(context, &mut object)
            .unwrap();
    }
    object
}

fn options() -> ChannelOptions {
    ChannelOptions { size: 32, face_sizes: vec![(3, 64), (8, 8)], ..Default::default() }
}

/// As [`object`], without displacement and vectors.
fn bare(context: &Context) -> DisplacedObject {
    let mesh = grid(6, true, &[2, 3, 2, 1], false);
    let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = options();
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let paint = Paint::of_color(surface.topology().clone(), Vec4::new(0.5, 0.4, 0.3, 1.0), &options).unwrap();
    let turn = DAffine3::from_scale_rotation_translation(
        DVec3::splat(1.5),
        glam::DQuat::from_rotation_y(0.4),
        DVec3::new(0.3, -1.0, 2.0),
    );
    let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, turn).unwrap();
    object.set_paint(paint).unwrap();
    object
}

fn sculpt(mode: SculptMode, height: f32) -> Action {
    Action::Sculpt { mode, height }
}

fn dab(object: &DisplacedObject, at: [f64; 3], action: Action, size: f64, falloff: Falloff) -> Dab {
    let axes = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.2, 0.1);
    let half = DVec3::new(size, 0.8 * size, 0.9 * size);
    let brush = Brush::new(object.transform().transform_point3(DVec3::from(at)), axes, half, falloff).unwrap();
    Dab { brush, action, strength: 0.8 }
}

fn stroke(object: &DisplacedObject, action: Action, settings: StrokeSettings) -> Stroke {
    let points = (0..5).map(|k| DVec3::new(3.4, 0.34 + 0.3 * f64::from(k), 0.6));
    let points = points.map(|place| StrokePoint::new(object.transform().transform_point3(place), 1.0)).collect();
    Stroke::new(points, settings, Falloff::Smooth, action)
}

/// Numbers that were compared, numbers that are more than a step of half floats apart, and by how much at most. Steps
/// are those at 2⁻⁷ below that: where an edit takes away what was there, what is left is as exact as that was.
#[derive(Debug, Default)]
pub(super) struct Apart {
    all: usize,
    more: usize,
    most: f32,
}

impl Apart {
    pub(crate) fn add<T: Texel, const N: usize>(&mut self, a: &[T], b: &[T], numbers: impl Fn(&T) -> [f32; N]) {
        for (a, b) in a.iter().zip(b).flat_map(|(a, b)| numbers(a).into_iter().zip(numbers(b))) {
            let step = f32::powi(2.0, a.abs().max(b.abs()).max(1.0 / 128.0).log2().floor() as i32 - 10);
            let far = (a - b).abs() / step;
            self.all += 1;
            self.more += usize::from(far > 1.0);
            self.most = self.most.max(far);
        }
    }

    fn add_fields<T: Texel, const N: usize>(&mut self, a: &Field<T>, b: &Field<T>, numbers: impl Fn(&T) -> [f32; N]) {
        let tiles = |field: &Field<T>| field.allocated().collect::<Vec<_>>();
        assert_eq!(tiles(a), tiles(b), "the tiles that are allocated");
        tiles(a).into_iter().for_each(|tile| self.add(a.block(tile).unwrap(), b.block(tile).unwrap(), &numbers));
    }

    /// Of coefficients and vectors.
    fn between(&mut self, a: &DisplacedObject, b: &DisplacedObject) {
        self.add_fields(a.displacement().field(), b.displacement().field(), |value| [value.to_f32()]);
        let [a, b] = [a, b].map(|object| object.vectors().unwrap().field());
        self.add_fields(a, b, |vector| vector.0.map(|value| value.to_f32()));
    }

    /// That fewer than one in 10,000 are further apart than a step.
    pub(super) fn check(&self, of: &str) {
        println!("{of}: {self:?}");
        assert!(self.all > 10_000 && self.more * 10_000 < self.all, "{of}: {self:?}");
    }
}

/// Colours of two objects, by how many 255ths they differ at most.
fn colors_apart(a: &DisplacedObject, b: &DisplacedObject) -> u8 {
    let [a, b] = [a, b].map(|object| object.paint().unwrap().field());
    let pairs = a.allocated().flat_map(|tile| a.block(tile).unwrap().iter().zip(b.block(tile).unwrap()));
    pairs.flat_map(|(a, b)| (0..4).map(|k| a.0[k].abs_diff(b.0[k]))).max().unwrap_or_default()
}

/// Applies a stroke to both, of which the second is on a device. Returns what it did there, and how many submissions of
/// dabs it took.
fn apply(context: &Context, stroke: &Stroke, [here, there]: [&mut DisplacedObject; 2]) -> (StrokeReport, usize) {
    let expected = stroke.apply(context, here).unwrap();
    context.stats().take();
    let found = stroke.apply(context, there).unwrap();
    let events = context.stats().take().iter().filter(|event| event.stage == "dab.device").count();
    assert!(expected.report.changed_texels > 100, "{:?}: {expected:?}", stroke.action);
    assert_eq!((found.dabs, &found.report.changed), (expected.dabs, &expected.report.changed), "{:?}", stroke.action);
    (found, events)
}

#[test]
fn vectors_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let modes = [
        (SculptMode::Vector, 0.2),
        (SculptMode::Vector, -0.1),
        (SculptMode::Pinch, 0.1),
        (SculptMode::Pinch, -0.1),
        (SculptMode::Smooth, 0.0),
        (SculptMode::Erase, 0.0),
    ];
    for (mode, height) in modes {
        let mut apart = Apart::default();
        let [mut here, mut there] = [object(&context), object(&context)];
        there.use_device(Some(&device)).unwrap();
        for (size, falloff) in [(1.2, Falloff::Smooth), (1.8, Falloff::Linear)] {
            let dab = dab(&here, [3.3, 0.6, 0.5], sculpt(mode, height), size, falloff);
            let expected = dab.apply(&context, &mut here).unwrap();
            context.stats().take();
            let found = dab.apply(&context, &mut there).unwrap();
            assert!(context.stats().take().iter().any(|event| event.stage == "dab.device"), "{mode:?}");
            assert!(expected.changed_texels > 200, "{mode:?}: {expected:?}");
            assert_eq!(found.changed, expected.changed, "{mode:?}");
            assert_eq!((found.allocated, found.bytes), (expected.allocated, expected.bytes), "{mode:?}");
            apart.between(&here, &there);
        }
        assert!(there.take_device_fault().is_none());
        apart.check(&format!("{mode:?} {height}"));
    }
}

#[test]
fn strokes_of_a_device_on_vectors_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let paint = Action::Paint { mode: PaintMode::Mix, color: [0.9, 0.1, 0.05, 1.0] };
    // Smoothing and erasing change displacement and vectors.
    for (action, submissions) in [
        (sculpt(SculptMode::Vector, 0.05), 1),
        (sculpt(SculptMode::Pinch, 0.1), 1),
        (sculpt(SculptMode::Smooth, 0.0), 2),
        (sculpt(SculptMode::Erase, 0.0), 2),
        (sculpt(SculptMode::Draw, 0.05), 1),
        (sculpt(SculptMode::Inflate, 0.02), 1),
        (paint, 1),
    ] {
        let mut apart = Apart::default();
        let [mut here, mut there] = [object(&context), object(&context)];
        there.use_device(Some(&device)).unwrap();
        let cage: Vec<[f32; 3]> = grid(6, true, &[2, 3, 2, 1], false).points;
        let cage: Vec<_> = cage.iter().map(|p| [p[0], p[1] + 0.1 * p[0], 1.2 * p[2]]).collect();
        for object in [&mut here, &mut there] {
            object.pose(&context, &cage).unwrap();
        }
        let settings = StrokeSettings { radius: 0.9, spacing: 0.5, ..StrokeSettings::default() };
        // One stroke: the next would be put where half a step of the one before turns its brush.
        let (found, events) = apply(&context, &stroke(&here, action, settings), [&mut here, &mut there]);
        assert!(found.dabs > 2 && events == submissions, "{action:?}: {events} submissions, {found:?}");
        apart.between(&here, &there);
        assert!(colors_apart(&here, &there) <= 1, "{action:?}");
        assert!(there.take_device_fault().is_none());
        apart.check(&format!("strokes, {action:?}"));
    }
}

#[test]
fn images_and_levels_of_a_device_on_vectors_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut random = Random(5);
    let data: Vec<f32> = (0..9 * 7 * 4).map(|_| random.unit()).collect();
    let image = StampImage::new(9, 7, 4, &data).unwrap();
    let often = StampSettings {
        repeat: 2.5,
        mid: 0.4,
        angle: 0.4,
        alternate: Switch::ON,
        mirror: Switch::ON,
        ..StampSettings::default()
    };
    for (mode, height, level, stamped, symmetry) in [
        (SculptMode::Vector, 0.2, 0, true, Switch::ON),
        (SculptMode::Pinch, 0.1, 0, true, Switch::OFF),
        (SculptMode::Vector, 0.1, 1, false, Switch::OFF),
        (SculptMode::Pinch, 0.1, 1, false, Switch::OFF),
        (SculptMode::Smooth, 0.0, 2, false, Switch::OFF),
        (SculptMode::Erase, 0.0, 0, true, Switch::OFF),
    ] {
        let mut apart = Apart::default();
        let [mut here, mut there] = [object(&context), object(&context)];
        there.use_device(Some(&device)).unwrap();
        let settings =
            StrokeSettings { radius: 0.9, spacing: 0.5, level, symmetry_z: symmetry, ..StrokeSettings::default() };
        let mut stroke = stroke(&here, sculpt(mode, height), settings);
        if stamped {
            stroke.stamp = Some(Stamp::new(image.clone(), often, StampChannel::Red).unwrap());
        }
        let (_, events) = apply(&context, &stroke, [&mut here, &mut there]);
        assert!(events > 0, "{mode:?} at level {level}");
        apart.between(&here, &there);
        apart.check(&format!("{mode:?} at level {level}, with an image: {stamped}"));
        assert!(there.take_device_fault().is_none());
    }
}

#[test]
fn vectors_that_are_not_there_and_lost_devices_are_told_of() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut without = bare(&context);
    without.use_device(Some(&device)).unwrap();
    let pinch = dab(&without, [3.6, 0.4, 0.6], sculpt(SculptMode::Pinch, 0.1), 0.9, Falloff::Smooth);
    assert_eq!(pinch.apply(&context, &mut without).unwrap_err().kind, ErrorKind::Invalid);
    assert!(without.take_device_fault().is_none());
    let [mut here, mut there] = [object(&context), object(&context)];
    there.use_device(Some(&device)).unwrap();
    device.abandon();
    let expected = pinch.apply(&context, &mut here).unwrap();
    assert_eq!(pinch.apply(&context, &mut there).unwrap(), expected);
    assert_eq!(there.take_device_fault().expect("it is told").kind, ErrorKind::Device);
}
