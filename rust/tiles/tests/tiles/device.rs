//! Displaced surfaces on a graphics device against the processor's.

use half::f16;
use relievo_core::{Context, Mesh};
use relievo_gpu::{Buffer, Device};
use relievo_surface::{DeviceSurface, Place, Surface, SurfaceOptions};
use relievo_testing::{Random, cage, device, grid};
use relievo_tiles::{DeviceTiles, Displaced, Displacement, DisplacementOptions, Points, Sets};

/// Fills tiles with waves, as an edit does.
fn dent(displacement: &mut Displacement, tiles: &[u32], depth: f32) {
    let context = Context::serial();
    displacement.apply(&Sets { allocate: tiles.to_vec(), ..Sets::default() }).unwrap();
    let changes = displacement.edit(&context, tiles, |tile, texels| {
        let mut random = Random(u64::from(tile));
        let (a, b) = (random.unit(), 1.0 + 3.0 * random.unit());
        let n = texels.size() as f32;
        for j in 0..texels.size() {
            for (i, c) in texels.row_mut(j).iter_mut().enumerate() {
                *c = f16::from_f32(-depth * (1.0 + (a + b * i as f32 / n).sin() * (b * j as f32 / n).cos()));
            }
        }
    });
    displacement.settle(&context, &changes.unwrap()).unwrap();
}

fn places(tiles: usize, count: usize) -> Vec<Place> {
    let mut random = Random(3);
    let ends = [0.0, 1.0, 0.5, 0.125];
    let mut parameter = |k: usize| if k.is_multiple_of(7) { ends[k / 7 % 4] } else { random.unit() };
    (0..count).map(|k| Place::new((k % tiles) as u32, parameter(k), parameter(k / 5))).collect()
}

fn evaluated(device: &Device, surface: &DeviceSurface, tiles: &DeviceTiles, places: &[Place]) -> Vec<f32> {
    let on_device = Buffer::of(device, "places", places).unwrap();
    let points = Buffer::new(device, "points", 6 * places.len()).unwrap();
    let evaluation = tiles.evaluation(device, &on_device, &points).unwrap();
    let mut frame = device.frame().unwrap();
    tiles.evaluate(&mut frame.pass("evaluate"), surface, &evaluation, places.len() as u32).unwrap();
    let result = frame.read(&points, 0..6 * places.len()).unwrap();
    let _ = frame.submit().unwrap();
    result.get(device).unwrap()
}

/// Compares positions, against the extent, and normals of all places.
fn compare(
    name: &str,
    device: &Device,
    surface: &Surface,
    on_device: &DeviceSurface,
    tiles: &DeviceTiles,
    now: &Displacement,
) {
    let places = places(surface.tile_count(), 30_000);
    let mut expected = Points::default();
    let displaced = Displaced::new(surface, now.field()).unwrap();
    displaced.evaluate_in_place(&Context::serial(), &places, &mut expected).unwrap();
    let ours = evaluated(device, on_device, tiles, &places);
    let (mut worst, mut turned) = (0.0_f32, 0);
    for (index, (p, normal)) in expected.p.iter().zip(&expected.normal).enumerate() {
        let [a, b] = [0, 3].map(|first| &ours[6 * index + first..][..3]);
        worst = (0..3).fold(worst, |worst, axis| worst.max((a[axis] - p[axis]).abs()));
        let cosine: f32 = (0..3).map(|axis| b[axis] * normal[axis]).sum();
        // Where tangents are nearly parallel both round; there are few such places.
        turned += usize::from(cosine < 1.0 - 1e-5);
    }
    println!("{name}: positions within {:e} of the extent, {turned} normals turned", worst / surface.extent());
    assert!(worst < 1e-6 * surface.extent(), "{name}: {worst}");
    assert!(turned * 10_000 <= places.len(), "{name}: {turned} normals");
}

fn check(name: &str, device: &Device, mesh: &Mesh) {
    let surface = Surface::new(&Context::serial(), mesh, &SurfaceOptions::default()).unwrap();
    let options = DisplacementOptions { size: 16, face_sizes: vec![(0, 64), (3, 8)], ..Default::default() };
    let mut displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let depth = 0.004 * surface.extent();
    let count = surface.tile_count() as u32;
    let some =
        |k: u32| (0..count).filter(|tile| tile % 3 == k && !surface.topology().is_hole(*tile)).collect::<Vec<_>>();
    dent(&mut displacement, &some(0), depth);
    let on_device = DeviceSurface::new(device, &surface).unwrap();
    let mut tiles = DeviceTiles::new(device, displacement.field()).unwrap();
    compare(name, device, &surface, &on_device, &tiles, &displacement);

    // More than there was room for; nothing new; and less, whose room is taken again.
    let before = displacement.field().clone();
    dent(&mut displacement, &some(1), depth);
    let changed = tiles.update(device, displacement.field()).unwrap();
    assert_eq!(changed, displacement.field().differing(&before));
    compare(name, device, &surface, &on_device, &tiles, &displacement);
    assert!(tiles.update(device, displacement.field()).unwrap().is_empty());
    let bytes = tiles.bytes();
    displacement.lose_tiles(&Context::serial(), &some(0)).unwrap();
    tiles.update(device, displacement.field()).unwrap();
    compare(name, device, &surface, &on_device, &tiles, &displacement);
    dent(&mut displacement, &some(0), 0.5 * depth);
    tiles.update(device, displacement.field()).unwrap();
    compare(name, device, &surface, &on_device, &tiles, &displacement);
    assert_eq!(tiles.bytes(), bytes, "{name}: freed room is taken again");
}

#[test]
fn displaced_surfaces_of_a_device_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    let mut mesh = grid(6, false, &[2, 3, 0, 2, 1], false);
    mesh.holes.push(5);
    check("grid", &device, &mesh);
    check("torus", &device, &grid(5, true, &[2], false));
    if let Some(mesh) = cage("monsterfrog.obj") {
        check("monsterfrog", &device, &mesh);
    }
}
