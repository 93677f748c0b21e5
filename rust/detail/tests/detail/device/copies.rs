//! Displacement and vectors that a device holds after edits there: those of the object.

use glam::DAffine3;
use half::f16;
use relievo_core::Context;
use relievo_detail::{
    Action, Falloff, ImprintSettings, Imprinter, Moment, Press, SculptMode, Stroke, StrokePoint, StrokeSettings,
};
use relievo_gpu::Device;
use relievo_testing::device;
use relievo_tiles::{ChannelOptions, DeviceTiles, Field, Texel, VectorDisplacement};

use super::imprints::{ball, object, order, place};

/// Compares what the device holds with `field`: numbers that differ, by `near` at most, and all.
fn compare<T: Texel>(
    tiles: &DeviceTiles<T>,
    field: &Field<T>,
    device: &Device,
    near: impl Fn(f16, f16) -> bool,
) -> (usize, usize) {
    assert!(field.differing(tiles.field()).is_empty(), "something was not sent");
    let (mut apart, mut all) = (0, 0);
    for (tile, there) in tiles.read_back(device).unwrap() {
        let halves = |texels: &[T]| bytemuck::cast_slice::<T, f16>(texels).to_vec();
        for (a, b) in halves(field.block(tile).unwrap()).into_iter().zip(halves(&there)) {
            apart += usize::from(a != b);
            all += 1;
            assert!(near(a, b), "tile {tile}: {a} {b}");
        }
    }
    (apart, all)
}

#[test]
fn vectors_on_the_device_are_what_dabs_made_of_them() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut object = object(&context, 64, DAffine3::from_rotation_z(0.4));
    let options = ChannelOptions { size: 32, ..ChannelOptions::default() };
    object.set_vectors(VectorDisplacement::on(object.surface(), &options).unwrap()).unwrap();
    object.use_device(Some(&device)).unwrap();
    let points = [0, 1, 2].map(|step| StrokePoint::new(place(&object, step).translation, 1.0));
    let settings = StrokeSettings { radius: 0.9, spacing: 0.4, ..StrokeSettings::default() };
    // One step of a half float.
    let near = |a: f16, b: f16| (a.to_f32() - b.to_f32()).abs() <= 2e-3 * a.to_f32().abs() + 1e-6;
    for (mode, height) in [(SculptMode::Pinch, 0.6), (SculptMode::Smooth, 0.0)] {
        let action = Action::Sculpt { mode, height };
        Stroke::new(points.to_vec(), settings, Falloff::Smooth, action).apply(&context, &mut object).unwrap();
        assert!(object.take_device_fault().is_none());
        let (apart, all) = compare(object.device_vectors().unwrap(), object.vectors().unwrap().field(), &device, near);
        assert!(all > 20_000 && apart * 1000 < all, "{mode:?}: {apart} of {all}");
        compare(object.device_displacement().unwrap(), object.displacement().field(), &device, near);
    }
}

#[test]
fn displacement_on_the_device_is_what_imprints_made_of_it() {
    let Some(device) = device() else { return };
    let context = Context::serial();
    let mut objects = [0, 1].map(|_| object(&context, 64, DAffine3::from_rotation_z(0.4)));
    let settings = ImprintSettings { voxels: 1 << 16, ..ImprintSettings::default() };
    let colliders: Vec<_> = (0..6)
        .map(|step| {
            let mut collider = ball(&context, 0.8);
            collider.set_transform(place(&objects[0], step)).unwrap();
            collider
        })
        .collect();
    for object in &mut objects {
        object.use_device(Some(&device)).unwrap();
    }
    let presses: Vec<Press<'_>> = (0..6)
        .map(|pair| {
            let moment = Moment { pair: pair as u32, ..Moment::default() };
            Press { into: pair % 2, collider: &colliders[pair], settings: &settings, moment }
        })
        .collect();
    // Together, and one by one.
    let mut imprinter = Imprinter::new();
    imprinter.imprint_all(&context, &mut objects.each_mut(), &presses[..4]).unwrap();
    for press in &presses[4..] {
        imprinter.imprint(&context, &mut objects[press.into], press.collider, &settings, press.moment).unwrap();
    }
    // Means at vertices may be rounded the other way.
    let near = |a: f16, b: f16| (order(a) - order(b)).abs() <= 1;
    let (mut apart, mut all) = (0, 0);
    for object in &mut objects {
        assert!(object.take_device_fault().is_none());
        let tiles = object.device_displacement().unwrap();
        let (differing, compared) = compare(tiles, object.displacement().field(), &device, near);
        apart += differing;
        all += compared;
    }
    assert!(all > 50_000 && apart * 1000 < all, "{apart} of {all}");
}
