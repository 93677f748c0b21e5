//! Rims on triangle meshes against closed forms, against the volume of the tessellated mesh, and against those of a
//! flat Catmull-Clark surface of the same shape.

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::simd::Level;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{
    Collider, DisplacedObject, ImprintSettings, Imprinter, Moment, Motion, Pose, Report, TriangleObject,
};
use relievo_surface::{Place, Surface, SurfaceOptions, TriangleSurface};
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};
use relievo_tiles::{Displacement, DisplacementOptions};

use crate::imprint::check_rims_of_two_patches;
use crate::shapes::{fine_values, octahedral_ball};

fn context(threads: usize) -> Context {
    Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap()
}

/// Quads of edge 1 from −`n`/2 to `n`/2 in z = 0.
fn plate(n: u32) -> Mesh {
    let at = |k: u32| k as f32 - 0.5 * n as f32;
    let points = (0..=n).flat_map(|y| (0..=n).map(move |x| [at(x), at(y), 0.0])).collect();
    let quad = |x: u32, y: u32| {
        let a = y * (n + 1) + x;
        [a, a + 1, a + n + 2, a + n + 1]
    };
    let corners: Vec<u32> = (0..n * n).flat_map(|k| quad(k % n, k / n)).collect();
    Mesh::new(points, vec![4; (n * n) as usize], corners)
}

fn object(context: &Context, mesh: &Mesh, segments: u32, budget: u64) -> TriangleObject {
    let surface = TriangleSurface::new(context, mesh).unwrap();
    let options = TriangleOptions { segments, budget };
    let displacement = TriangleChannel::displacement(surface.topology().clone(), &options).unwrap();
    TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY).unwrap()
}

/// Balls of radius 1 at places.
fn balls(context: &Context, places: &[DVec3]) -> Collider {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for place in places {
        let mesh = octahedral_ball(24, 1.0);
        let first = points.len() as u32;
        points.extend(mesh.points.iter().map(|p| (DVec3::from(p.map(f64::from)) + *place).as_vec3().to_array()));
        triangles.extend(mesh.triangles().iter().map(|corners| corners.map(|point| point + first)));
    }
    Collider::new(context, points, triangles, DAffine3::IDENTITY).unwrap()
}

/// Where all values are on the undisplaced mesh, and what they are.
fn heights(object: &TriangleObject) -> Vec<(Vec3, f32)> {
    let displaced = object.displaced().unwrap();
    let seen = |(face, pattern, node)| {
        let (foot, height) = displaced.at(face, pattern, node);
        (foot.point, height)
    };
    fine_values(object).map(seen).collect()
}

/// The volume that the tessellated mesh encloses.
fn volume(context: &Context, object: &mut TriangleObject) -> f64 {
    object.renew(context).unwrap();
    let mut sum = 0.0;
    for face in 0..object.surface().topology().face_count() as u32 {
        let piece = object.piece(face).unwrap().0;
        for corners in piece.triangles {
            let [a, b, c] = corners.map(|point| DVec3::from(piece.points[point as usize].map(f64::from)));
            sum += a.dot(b.cross(c)) / 6.0;
        }
    }
    sum
}

/// The volume between the plane z = 0 and the faces of the tessellated mesh that have blocks.
fn volume_over_plane(context: &Context, object: &mut TriangleObject) -> f64 {
    object.renew(context).unwrap();
    let mut sum = 0.0;
    for face in object.displacement().field().allocated() {
        let piece = object.piece(face).unwrap().0;
        for corners in piece.triangles {
            let [a, b, c] = corners.map(|point| DVec3::from(piece.points[point as usize].map(f64::from)));
            sum += 0.5 * (b - a).cross(c - a).z * (a.z + b.z + c.z) / 3.0;
        }
    }
    sum
}

fn bytes(object: &TriangleObject) -> Vec<(u32, Vec<u8>)> {
    let channel = object.displacement();
    channel.blocks().into_iter().map(|block| (block, channel.read(block).unwrap().unwrap())).collect()
}

fn settings() -> ImprintSettings {
    ImprintSettings { voxels: 1 << 20, rim: 0.5, rim_width: 0.6, repose: 1.2, ..ImprintSettings::default() }
}

fn press(context: &Context, object: &mut TriangleObject, collider: &Collider, settings: &ImprintSettings) -> Report {
    Imprinter::new().imprint(context, object, collider, settings, Moment::default()).unwrap()
}

/// Presses balls of radius 1 at places into a flat mesh.
fn rimmed(threads: usize, places: &[DVec3], settings: &ImprintSettings) -> (Report, TriangleObject) {
    let context = context(threads);
    let mut object = object(&context, &plate(10), 32, 1 << 30);
    let report = press(&context, &mut object, &balls(&context, places), settings);
    (report, object)
}

const MIDDLE: DVec3 = DVec3::new(0.1, 0.2, 0.8);

#[test]
fn a_rim_holds_its_share_of_what_was_pushed_away() {
    let (report, mut object) = rimmed(1, &[MIDDLE], &settings());
    // The cap of height 0.2 of the ball, over a disc of radius 0.6.
    let cap = std::f64::consts::PI * 0.04 * 2.8 / 3.0;
    assert!((report.volumes.pushed - cap).abs() < 0.05 * cap, "{:?} {cap}", report.volumes);
    assert!((report.volumes.raised / report.volumes.pushed - 0.5).abs() < 0.01, "{:?}", report.volumes);
    let measured = volume_over_plane(&Context::serial(), &mut object);
    let told = report.volumes.raised - report.volumes.pushed;
    assert!((measured - told).abs() < 2e-3 * cap, "{measured} {told}");
    // The profile's integral over the ring: 2π·w·(r/2 + 3w/20).
    let height = 0.5 * cap / (std::f64::consts::TAU * 0.6 * (0.3 + 0.09));
    let mut highest: f32 = 0.0;
    for (p, value) in heights(&object) {
        let s = (p.as_dvec3().truncate().distance(MIDDLE.truncate()) - 0.6) / 0.6;
        if s > 0.1 {
            let expected = if s < 1.0 { height * (1.0 - s).powi(2) * (1.0 + 2.0 * s) } else { 0.0 };
            assert!((f64::from(value) - expected).abs() < 0.12 * height, "{value} {expected} at {s}");
            assert!(s < 1.0 || value == 0.0, "{value} at {s}");
        }
        highest = highest.max(value);
    }
    assert!((f64::from(highest) - height).abs() < 0.1 * height, "{highest} {height}");
    for threads in [2, 3] {
        let (again, other) = rimmed(threads, &[MIDDLE], &settings());
        assert!(again == report && bytes(&other) == bytes(&object));
    }
    // Faces that nothing touched have blocks where the rim is; all others have none.
    let contact = |face: u32| {
        let corners = object.surface().corner_points(face).map(|p| DVec3::from(p.map(f64::from)));
        corners.iter().map(|p| p.truncate().distance(MIDDLE.truncate())).fold(f64::INFINITY, f64::min)
    };
    let field = object.displacement().field();
    assert!(field.allocated().any(|face| contact(face) > 0.7));
    assert!(field.allocated().all(|face| contact(face) < 1.5 + 2f64.sqrt()));
}

#[test]
fn a_flat_mesh_and_a_flat_surface_get_nearly_the_same_rim() {
    let context = Context::serial();
    let mesh = plate(10);
    let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = DisplacementOptions { size: 32, ..DisplacementOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let mut tiles = DisplacedObject::new(&context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
    let collider = balls(&context, &[MIDDLE]);
    let of_tiles = Imprinter::new().imprint(&context, &mut tiles, &collider, &settings(), Moment::default()).unwrap();
    let (of_triangles, triangles) = rimmed(1, &[MIDDLE], &settings());
    for (one, other) in
        [(of_tiles.volumes.pushed, of_triangles.volumes.pushed), (of_tiles.volumes.raised, of_triangles.volumes.raised)]
    {
        assert!((one - other).abs() < 0.03 * one, "{one} {other}");
    }
    // Means over rings around the contact, beside the first texels, where tiles are smooth.
    const RINGS: usize = 10;
    let ring = |p: DVec3| (p.truncate().distance(MIDDLE.truncate()) - 0.65) / (0.55 / RINGS as f64);
    let mut sums = [[(0.0, 0.0); RINGS]; 2];
    let mut add = |kind: usize, p: DVec3, value: f32| {
        let ring = ring(p);
        if (0.0..RINGS as f64).contains(&ring) {
            let (sum, count) = &mut sums[kind][ring as usize];
            (*sum, *count) = (*sum + f64::from(value), *count + 1.0);
        }
    };
    for (p, value) in heights(&triangles) {
        add(0, p.as_dvec3(), value);
    }
    let field = tiles.displacement().field();
    for tile in 0..field.tile_count() as u32 {
        let size = field.size(tile);
        for (j, i) in (0..size).flat_map(|j| (0..size).map(move |i| (j, i))) {
            let [u, v] = [i, j].map(|k| (k as f32 + 0.5) / size as f32);
            let sample = tiles.surface().sample(Level::best(), Place { tile, u, v }).unwrap();
            let value = field.block(tile).map_or(0.0, |block| block[((j + 1) * (size + 2) + i + 1) as usize].to_f32());
            add(1, DVec3::from(sample.p.map(f64::from)), value);
        }
    }
    let [one, other] = sums.map(|rings| rings.map(|(sum, count)| sum / f64::max(count, 1.0)));
    assert!(one[0] > 0.02 && one[RINGS - 1] < 0.1 * one[0], "{one:?}");
    for (one_mean, other_mean) in one.iter().zip(other) {
        assert!((one_mean - other_mean).abs() < 0.04 * one[0], "{one:?} {other:?}");
    }
}

#[test]
fn rims_are_no_steeper_than_the_angle_of_repose() {
    let settings = ImprintSettings { rim: 1.0, repose: 0.05, ..settings() };
    let (report, mut object) = rimmed(1, &[MIDDLE], &settings);
    let found = heights(&object);
    let highest = found.iter().map(|(_, value)| *value).fold(0.0, f32::max);
    assert!((highest - 0.6 * 0.05f32.tan() / 1.5).abs() < 1e-3, "{highest}");
    assert!(report.volumes.raised < 0.5 * report.volumes.pushed, "{:?}", report.volumes);
    // By distance and height, outside of the contact.
    object.renew(&Context::serial()).unwrap();
    let mut steepest = 0.0f64;
    for face in 0..object.surface().topology().face_count() as u32 {
        let piece = object.piece(face).unwrap().0;
        for corners in piece.triangles {
            let [a, b, c] = corners.map(|point| DVec3::from(piece.points[point as usize].map(f64::from)));
            let outside = [a, b, c].iter().all(|p| p.z >= 0.0 && p.truncate().distance(MIDDLE.truncate()) > 0.66);
            let normal = (b - a).cross(c - a).normalize();
            if outside {
                steepest = steepest.max(normal.truncate().length() / normal.z);
            }
        }
    }
    // Linear between vertices a slope is steeper than at them where a triangle has an obtuse angle.
    assert!(steepest < 1.25 * 0.05f64.tan() && steepest > 0.8 * 0.05f64.tan(), "{steepest}");
}

#[test]
fn a_share_of_zero_is_an_imprint_without_a_rim() {
    let none = ImprintSettings { rim: 0.0, ..settings() };
    let (report, object) = rimmed(1, &[MIDDLE], &none);
    let plain = ImprintSettings { voxels: 1 << 20, ..ImprintSettings::default() };
    let (other, same) = rimmed(1, &[MIDDLE], &plain);
    assert!(report == other && bytes(&object) == bytes(&same));
    assert!(heights(&object).iter().all(|(_, value)| *value <= 0.0));
    assert_eq!((report.volumes.pushed, report.volumes.raised), (0.0, 0.0));
    // A rim changes nothing of what was pushed.
    let (_, with) = rimmed(1, &[MIDDLE], &settings());
    for ((_, one), (_, other)) in heights(&object).iter().zip(heights(&with)) {
        assert!(*one == other || (*one == 0.0 && other > 0.0), "{one} {other}");
    }
}

#[test]
fn every_patch_of_contact_has_a_rim_of_its_own() {
    let settings = ImprintSettings { rim: 1.0, rim_width: 0.4, repose: 1.4, ..settings() };
    check_rims_of_two_patches(|places, around| {
        let found = heights(&rimmed(1, places, &settings).1);
        let near = found.iter().filter(|(p, _)| p.as_dvec3().truncate().distance(around.truncate()) < 2.0);
        near.map(|(_, value)| *value).fold(0.0, f32::max)
    });
}

#[test]
fn volumes_over_a_closed_mesh_are_those_of_the_tessellation() {
    let context = Context::serial();
    let before = volume(&context, &mut object(&context, &octahedral_ball(3, 2.0), 32, 1 << 26));
    for segments in [16, 32] {
        let mut pressed = object(&context, &octahedral_ball(3, 2.0), segments, 1 << 26);
        let place = DVec3::new(1.0, 0.7, 0.4).normalize() * 2.75;
        let settings = ImprintSettings { rim: 0.8, rim_width: 0.5, ..settings() };
        let report = press(&context, &mut pressed, &balls(&context, &[place]), &settings);
        let (told, change) = (report.volumes, volume(&context, &mut pressed) - before);
        assert!(told.pushed > 0.01 && (told.raised / told.pushed - 0.8).abs() < 0.02, "{told:?}");
        let net = told.raised - told.pushed;
        // What is pushed inwards gets narrower by the depth over the radius.
        assert!((change - net).abs() < 0.08 * told.pushed, "{change} {net} {told:?}");
    }
}

#[test]
fn what_travels_raises_a_rim_on_both_sides() {
    let mut results = Vec::new();
    for threads in [1, 3] {
        let context = context(threads);
        let mut object = object(&context, &plate(10), 16, 1 << 26);
        let mut collider = balls(&context, &[DVec3::new(0.0, 0.0, 0.85)]);
        let at = |x: f64| Pose { transform: DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)), points: None };
        let motion = Motion::new(&collider, at(-2.0), at(2.0)).unwrap();
        let settings = ImprintSettings { rim_width: 0.4, ..settings() };
        let report = Imprinter::new()
            .sweep(&context, &mut object, &mut collider, &motion, &settings, Moment::default())
            .unwrap();
        assert!(report.sub_steps >= 8, "{}", report.sub_steps);
        let net = volume_over_plane(&Context::serial(), &mut object);
        let told = report.volumes.raised - report.volumes.pushed;
        assert!((net - told).abs() < 5e-3 * report.volumes.pushed, "{net} {told}");
        // The way is as wide as the ball at the plane, 0.527 on both sides.
        let (mut left, mut right, mut track) = (0.0f32, 0.0f32, f32::NEG_INFINITY);
        for (p, value) in heights(&object).iter().filter(|(p, _)| p.x.abs() < 1.5) {
            match p.y {
                y if (0.55..0.7).contains(&y) => left = left.max(*value),
                y if (-0.7..-0.55).contains(&y) => right = right.max(*value),
                y if y.abs() < 0.25 => track = track.max(*value),
                _ => {}
            }
        }
        assert!(left > 0.02 && right > 0.02 && (left - right).abs() < 0.3 * left, "{left} {right}");
        assert!(track < -0.05, "{track}");
        results.push((bytes(&object), report));
    }
    assert!(results[0] == results[1]);
}

#[test]
fn what_the_budget_refuses_is_not_counted() {
    let context = Context::serial();
    let (whole, full) = rimmed(1, &[MIDDLE], &settings());
    let budget = full.displacement().bytes() * 2 / 3;
    let mut object = object(&context, &plate(10), 32, budget);
    let report = press(&context, &mut object, &balls(&context, &[MIDDLE]), &settings());
    assert!(!report.refused.is_empty() && object.displacement().bytes() <= budget);
    let (told, measured) = (report.volumes, volume_over_plane(&context, &mut object));
    assert!(told.raised > 0.0 && told.pushed > 0.0 && told.raised < whole.volumes.raised, "{told:?}");
    let net = told.raised - told.pushed;
    assert!((measured - net).abs() < 0.05 * told.pushed, "{measured} {net}");
}

#[test]
fn a_rim_too_wide_for_memory_is_refused() {
    let context = context(1);
    let narrow = Context::new(&ContextOptions { threads: 1, memory_limit: 100_000 }).unwrap();
    let mut object = object(&context, &plate(10), 32, 1 << 30);
    let before = bytes(&object);
    let settings = ImprintSettings { rim: 1.0, rim_width: 50000.0, ..settings() };
    let collider = balls(&context, &[MIDDLE]);
    let mut imprinter = Imprinter::new();
    let done = imprinter.imprint(&narrow, &mut object, &collider, &settings, Moment::default());
    let error = done.unwrap_err();
    assert!(error.to_string().contains("rim_width"), "{error}");
    assert_eq!(bytes(&object), before);
}
