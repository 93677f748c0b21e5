//! How near imprints are to the colliders that made them, in voxels, and that voxels leave no terraces: on flat slopes these
//! would be many coefficients wide, with steps of a voxel between them.

use glam::{DAffine3, DQuat, DVec3, EulerRot};
use relievo_core::Context;
use relievo_core::simd::Level;
use relievo_detail::{Collider, DisplacedObject, ImprintSettings, Imprinter, Moment};
use relievo_surface::{Place, Surface, SurfaceOptions};
use relievo_testing::device;
use relievo_tiles::{Displacement, DisplacementOptions};

use super::imprint::plate;

/// Coefficients along an edge of a face, whose length is 1.
const SIZE: u32 = 128;

/// Coefficients around a voxel, about: as many as a terrace is wide on a slope of 1.
const VOXELS: u32 = 1 << 14;

/// Depth below which a coefficient may stay where it is.
const SHALLOW: f64 = 0.002;

/// How far coefficients are from the collider in voxels, and by how much slopes change from one to the next.
#[derive(Debug)]
struct Measured {
    mean: f64,
    worst: f64,
    jump: f64,
    count: usize,
}

fn flat(context: &Context, transform: DAffine3) -> DisplacedObject {
    let mesh = plate(2, 0.0);
    let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = DisplacementOptions { size: SIZE, ..DisplacementOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    DisplacedObject::new(context, surface, &mesh.points, displacement, transform).unwrap()
}

/// Presses a collider into a flat plate that lies as `transform` says, and compares coefficients with the heights over the
/// plate that `exact` gives, where it gives some.
fn measure(
    soup: (Vec<[f32; 3]>, Vec<[u32; 3]>),
    [transform, pose]: [DAffine3; 2],
    on_device: bool,
    exact: impl Fn(f64, f64) -> Option<f64>,
) -> Measured {
    let context = Context::serial();
    let mut object = flat(&context, transform);
    if on_device {
        object.use_device(device().as_ref()).unwrap();
    }
    let collider = Collider::new(&context, soup.0, soup.1, transform * pose).unwrap();
    let settings = ImprintSettings { voxels: VOXELS, ..ImprintSettings::default() };
    let report = Imprinter::new().imprint(&context, &mut object, &collider, &settings, Moment::default()).unwrap();
    assert!(object.take_device_fault().is_none());
    let voxel = report.voxel_diagonal / 3.0f64.sqrt();
    let (mut sum, mut worst, mut jump, mut jumps, mut count) = (0.0, 0.0f64, 0.0, 0, 0);
    let field = object.displacement().field();
    for tile in 0..field.tile_count() as u32 {
        let Some(block) = field.block(tile) else { continue };
        let height = |i: u32, j: u32| f64::from(block[((j + 1) * (SIZE + 2) + i + 1) as usize].to_f32());
        let centre = |k: u32| (k as f32 + 0.5) / SIZE as f32;
        let all = (0..SIZE * SIZE).map(|at| {
            let place = Place { tile, u: centre(at % SIZE), v: centre(at / SIZE) };
            let sample = object.surface().sample(Level::best(), place).unwrap();
            exact(f64::from(sample.p[0]), f64::from(sample.p[1]))
        });
        let all: Vec<Option<f64>> = all.collect();
        let wanted = |i: u32, j: u32| all[(j * SIZE + i) as usize];
        for (i, j) in (1..SIZE - 1).flat_map(|j| (1..SIZE - 1).map(move |i| (i, j))) {
            let Some(here) = wanted(i, j) else { continue };
            let off = (height(i, j) - here).abs() / voxel;
            sum += off;
            worst = worst.max(off);
            count += 1;
            for (a, b) in [((i - 1, j), (i + 1, j)), ((i, j - 1), (i, j + 1))] {
                let (Some(from), Some(to)) = (wanted(a.0, a.1), wanted(b.0, b.1)) else { continue };
                let bend = |a: f64, here: f64, b: f64| (a + b - 2.0 * here) * f64::from(SIZE);
                let found = bend(height(a.0, a.1), height(i, j), height(b.0, b.1));
                jump += (found - bend(from, here, to)).abs();
                jumps += 1;
            }
        }
    }
    Measured { mean: sum / count as f64, worst, jump: jump / jumps as f64, count }
}

/// A sphere of radius `radius(direction)`.
fn star(n: u32, radius: impl Fn(DVec3) -> f64) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let m = n / 2;
    let mut points = Vec::new();
    for (j, i) in (0..=m).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let (a, b) = (f64::from(i) / f64::from(n) * std::f64::consts::TAU, f64::from(j) / f64::from(m) - 0.5);
        let (sine, cosine) = (b * std::f64::consts::PI).sin_cos();
        let direction = DVec3::new(a.cos() * cosine, a.sin() * cosine, sine);
        points.push((direction * radius(direction)).as_vec3().to_array());
    }
    let mut triangles = Vec::new();
    for (j, i) in (0..m).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let (a, b) = (j * n + i, j * n + (i + 1) % n);
        triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
    }
    (points, triangles)
}

/// The lowest height at which a star around `center` is met, if it is below `least` there.
fn under(center: DVec3, least: f64, radius: impl Fn(DVec3) -> f64) -> impl Fn(f64, f64) -> Option<f64> {
    move |x, y| {
        let inside = |z: f64| {
            let d = DVec3::new(x, y, z) - center;
            d.length() < radius(d.normalize())
        };
        let (mut low, mut high) = (-1.0, least);
        if !inside(high) {
            return None;
        }
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if inside(middle) { high = middle } else { low = middle }
        }
        Some(low)
    }
}

fn bumpy(direction: DVec3) -> f64 {
    1.0 + 0.015 * (11.0 * direction.x).sin() * (9.0 * direction.y).cos()
}

/// Transforms of the plate: none, and one that turns and moves it.
fn transforms() -> [DAffine3; 2] {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.7, -0.4, 0.3);
    [DAffine3::IDENTITY, DAffine3::from_rotation_translation(turn, DVec3::new(3.0, -5.0, 2.0))]
}

/// Asserts that an imprint is as near to its collider as interpolation between columns can have it, up to the border of the
/// contact.
fn check(what: &str, measured: &Measured) {
    println!("{what}: {measured:?}");
    assert!(measured.count > 3_000, "{what}: {measured:?}");
    assert!(measured.mean < 0.02 && measured.worst < 0.5 && measured.jump < 0.02, "{what}: {measured:?}");
}

fn check_all(on_device: bool) {
    for transform in transforms() {
        let center = DVec3::new(0.02, -0.03, 0.92);
        let poses = [transform, DAffine3::from_translation(center)];
        check("ball", &measure(star(400, |_| 1.0), poses, on_device, under(center, -SHALLOW, |_| 1.0)));
        check("model", &measure(star(800, bumpy), poses, on_device, under(center, -SHALLOW, bumpy)));
        // A box on its lower face, turned out of the plate's plane.
        for (x, y) in [(0.03, -0.02), (0.12, 0.07), (-0.2, 0.3)] {
            let turn = DQuat::from_euler(EulerRot::XYZ, x, y, 0.4);
            let pose = DAffine3::from_rotation_translation(turn, DVec3::new(0.0, 0.0, 0.44));
            let corner = |k: u32| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { -0.5 } else { 0.5f32 });
            let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
            let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
            let soup = ((0..8).map(corner).collect(), triangles);
            let normal = turn * DVec3::Z;
            let foot = pose.transform_point3(DVec3::new(0.0, 0.0, -0.5));
            let plane = measure(soup, [transform, pose], on_device, |x, y| {
                let z = foot.z - (normal.x * (x - foot.x) + normal.y * (y - foot.y)) / normal.z;
                let place = pose.inverse().transform_point3(DVec3::new(x, y, z));
                // Over columns beside the face there is another.
                (z < -SHALLOW && place.truncate().abs().max_element() < 0.4).then_some(z)
            });
            check("plane", &plane);
        }
    }
}

#[test]
fn imprints_follow_their_colliders_without_terraces() {
    check_all(false);
}

#[test]
fn imprints_of_a_device_follow_them_as_well() {
    if device().is_some() {
        check_all(true);
    }
}
