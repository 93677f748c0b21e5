//! Imprints of a ball on plates and cubes: how deep, where, at which orientation, and that nothing else changes.

use glam::{DAffine3, DQuat, DVec3, EulerRot};
use relievo_core::simd::Level;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{Collider, Deformable, DisplacedObject, ImprintSettings, Imprinter, Moment, Motion, Pose, Report};
use relievo_surface::{Place, Surface, SurfaceOptions};
use relievo_tiles::{Displacement, DisplacementOptions};

use crate::shapes::cube;

fn context(threads: usize) -> Context {
    Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap()
}

/// A plate of n × n quads of edge 1 around the origin, facing +z; `bump` shakes it.
pub(crate) fn plate(n: u32, bump: f32) -> Mesh {
    let mut points = Vec::new();
    let mut corners = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (i as f32 - n as f32 / 2.0, j as f32 - n as f32 / 2.0);
            points.push([x, y, bump * (1.3 * x).sin() * (0.9 * y).cos()]);
            if i < n && j < n {
                let a = j * (n + 1) + i;
                corners.extend([a, a + 1, a + n + 2, a + n + 1]);
            }
        }
    }
    Mesh::new(points, vec![4; (n * n) as usize], corners)
}

fn object(context: &Context, mesh: &Mesh, size: u32, transform: DAffine3) -> DisplacedObject {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
    let options = DisplacementOptions { size, ..DisplacementOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    DisplacedObject::new(context, surface, &mesh.points, displacement, transform).unwrap()
}

fn ball(context: &Context, radius: f32, transform: DAffine3) -> Collider {
    let (n, m) = (64u32, 32u32);
    let mut points = vec![[0.0, 0.0, -radius], [0.0, 0.0, radius]];
    let at = |i: u32, j: u32| match j {
        0 => 0,
        j if j == m => 1,
        j => 2 + (j - 1) * n + i % n,
    };
    let mut triangles = Vec::new();
    for j in 0..m {
        for i in 0..n {
            if j > 0 {
                let (a, b) = (i as f32 / n as f32, j as f32 / m as f32 / 2.0 - 0.25);
                let (a, b) = (std::f32::consts::TAU * a, std::f32::consts::TAU * b);
                points.push([radius * b.cos() * a.cos(), radius * b.cos() * a.sin(), radius * b.sin()]);
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            }
            if j + 1 < m {
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    Collider::new(context, points, triangles, transform).unwrap()
}

/// All coefficients with their points in the world: tile, point, value.
fn coefficients(object: &DisplacedObject) -> Vec<(u32, DVec3, f32)> {
    let field = object.displacement().field();
    let mut all = Vec::new();
    for tile in 0..field.tile_count() as u32 {
        let size = field.size(tile);
        for index in 0..size * size {
            let (i, j) = (index % size, index / size);
            let centre = |k: u32| (k as f32 + 0.5) / size as f32;
            let sample = object.surface().sample(Level::best(), Place { tile, u: centre(i), v: centre(j) }).unwrap();
            let value = field.block(tile).map_or(0.0, |block| block[((j + 1) * (size + 2) + i + 1) as usize].to_f32());
            let (p, n) = (DVec3::from(sample.p.map(f64::from)), DVec3::from(sample.normal().map(f64::from)));
            all.push((tile, object.transform().transform_point3(p + n * f64::from(value)), value));
        }
    }
    all
}

fn blocks(object: &DisplacedObject) -> Vec<Option<Vec<u16>>> {
    let field = object.displacement().field();
    (0..field.tile_count() as u32)
        .map(|tile| field.block(tile).map(|b| b.iter().map(|c| c.to_bits()).collect()))
        .collect()
}

fn settings() -> ImprintSettings {
    ImprintSettings { voxels: 1 << 20, max_displacement: 1.0, ..ImprintSettings::default() }
}

fn press(context: &Context, object: &mut DisplacedObject, collider: &Collider, frames: u64) -> Report {
    let mut imprinter = Imprinter::new();
    let mut report = Report::default();
    for frame in 0..frames {
        let moment = Moment { frame, ..Moment::default() };
        report.merge(imprinter.imprint(context, object, collider, &settings(), moment).unwrap());
    }
    report
}

#[test]
fn no_point_ends_deeper_than_a_voxel_diagonal_at_any_orientation_and_scale() {
    let turns = [(0.0, 0.0), (1.5, 0.3), (3.1, 0.0), (2.2, -1.0), (-0.9, 2.0)];
    let scales = [DVec3::ONE, DVec3::splat(3.0), DVec3::new(1.0, 1.5, 0.6), DVec3::new(-1.0, 1.0, 1.0)];
    for (case, (x, y)) in turns.into_iter().enumerate() {
        let scale = scales[case % scales.len()];
        let turn = DQuat::from_euler(EulerRot::XYZ, x, y, 0.4);
        let transform = DAffine3::from_scale_rotation_translation(scale, turn, DVec3::new(10.0, -20.0, 5.0));
        let context = context(1);
        let mut plate = object(&context, &plate(8, 0.1), 32, transform);
        let untouched = plate.displacement().bytes();
        assert_eq!(untouched, 0);
        // The ball's middle is 0.6 of its radius above the plate.
        let radius = 1.1 * scale.abs().min_element();
        let normal = transform.matrix3.inverse().transpose() * DVec3::Z;
        let middle = transform.translation + normal.normalize() * 0.6 * radius;
        let ball = ball(&context, radius as f32, DAffine3::from_translation(middle));
        let report = press(&context, &mut plate, &ball, 2);
        assert!(report.changed_coefficients > 500 && report.clamped == 0, "case {case}: {report:?}");
        let mut deepest: f64 = 0.0;
        for (_, point, value) in coefficients(&plate) {
            deepest = deepest.max(radius - (point - middle).length());
            assert!(value <= 0.0);
        }
        assert!(deepest <= report.voxel_diagonal, "case {case}: {deepest} of {}", report.voxel_diagonal);
        assert_eq!(plate.displacement().bytes(), report.bytes);
    }
}

#[test]
fn only_what_the_ball_touches_changes_and_threads_do_not_matter() {
    let run = |threads| {
        let context = context(threads);
        let mut plate = object(&context, &plate(10, 0.2), 64, DAffine3::IDENTITY);
        let first = ball(&context, 1.0, DAffine3::from_translation(DVec3::new(-2.0, -2.0, 0.6)));
        let a = press(&context, &mut plate, &first, 1);
        let before = blocks(&plate);
        let second = ball(&context, 1.0, DAffine3::from_translation(DVec3::new(2.6, 2.3, 0.7)));
        let b = press(&context, &mut plate, &second, 3);
        (before, blocks(&plate), a, b, plate)
    };
    let (before, after, first, second, plate) = run(1);
    assert!(!first.changed.is_empty() && !second.changed.is_empty());
    let reach = |tile: u32| {
        let (low, high) = plate.surface().tile_bounds(tile);
        (0..2).all(|axis| low[axis] < [2.6, 2.3][axis] + 1.1 && high[axis] > [2.6, 2.3][axis] - 1.1)
    };
    for (tile, (before, after)) in before.iter().zip(&after).enumerate() {
        assert!(before == after || reach(tile as u32), "tile {tile}");
    }
    assert!(second.allocated > 0 && after.iter().flatten().count() < 40);
    let (_, two, _, report, _) = run(2);
    assert!(two == after);
    assert_eq!(report, second);
}

#[test]
fn dents_go_over_the_corners_of_a_cube() {
    // Extraordinary vertices of valence 3, and tiles whose sides run either way.
    let context = context(1);
    let mut cube = object(&context, &cube(2.0), 64, DAffine3::IDENTITY);
    let corner = cube.surface().sample(Level::best(), Place::corner(0, 0)).unwrap();
    let middle = DVec3::from(corner.p.map(f64::from)) * 1.15;
    let ball = ball(&context, 0.7, DAffine3::from_translation(middle));
    let report = press(&context, &mut cube, &ball, 1);
    assert_eq!(report.changed.len(), 3);
    let mut touched = 0;
    for (_, point, value) in coefficients(&cube) {
        // At the corner itself coefficients of all tiles are averaged.
        let near = (point - DVec3::from(corner.p.map(f64::from))).length() < 0.1;
        let depth = 0.7 - (point - middle).length();
        assert!(near || depth <= report.voxel_diagonal, "{depth} {}", report.voxel_diagonal);
        touched += u32::from(value < 0.0);
    }
    assert!(touched > 200);
}

#[test]
fn share_and_depth_limit_hold_back() {
    let context = context(1);
    let deepest = |change: fn(&mut ImprintSettings), frames: u64| {
        let mut plate = object(&context, &plate(6, 0.0), 32, DAffine3::IDENTITY);
        let ball = ball(&context, 1.0, DAffine3::from_translation(DVec3::new(0.1, 0.2, 0.5)));
        let mut settings = settings();
        change(&mut settings);
        let mut imprinter = Imprinter::new();
        for frame in 0..frames {
            let moment = Moment { frame, ..Moment::default() };
            imprinter.imprint(&context, &mut plate, &ball, &settings, moment).unwrap();
        }
        coefficients(&plate).into_iter().map(|(_, _, value)| value).fold(0.0, f32::min)
    };
    let near = |found: f32, expected: f32| assert!((found - expected).abs() < 0.03, "{found} {expected}");
    near(deepest(|_| {}, 1), -0.5);
    near(deepest(|settings| settings.share = 0.5, 1), -0.25);
    near(deepest(|settings| settings.share = 0.5, 2), -0.375);
    near(deepest(|settings| settings.depth_limit = 0.125, 1), -0.125);
    near(deepest(|settings| settings.depth_limit = 0.125, 3), -0.375);
    near(deepest(|settings| settings.max_displacement = 0.25, 3), -0.25);
    near(deepest(|settings| settings.share = 0.0, 1), 0.0);
    near(deepest(|settings| settings.culling = 0, 1), -0.5);
    near(deepest(|settings| settings.compaction = 0, 1), -0.5);
    let smooth = deepest(
        |settings| {
            settings.smoothing = 1.0;
            settings.smoothing_passes = 20;
        },
        1,
    );
    assert!(smooth > -0.5 && smooth < -0.3, "{smooth}");
}

#[test]
fn culling_loses_no_coefficient() {
    for mesh in [plate(8, 0.3), cube(2.0)] {
        let run = |culling| {
            let context = context(1);
            let mut object = object(&context, &mesh, 32, DAffine3::from_rotation_y(0.5));
            let mut imprinter = Imprinter::new();
            for frame in 0..6u32 {
                let at = DVec3::new(1.7 - 0.6 * f64::from(frame), 0.3 * f64::from(frame), 1.6 - 0.2 * f64::from(frame));
                let ball = ball(&context, 1.0, DAffine3::from_translation(at));
                let settings = ImprintSettings { culling, ..settings() };
                let moment = Moment { frame: frame.into(), ..Moment::default() };
                imprinter.imprint(&context, &mut object, &ball, &settings, moment).unwrap();
            }
            blocks(&object)
        };
        let culled = run(1);
        assert!(culled.iter().flatten().count() > 2);
        assert!(culled == run(0));
    }
}

#[test]
fn a_full_budget_is_reported_and_the_rest_still_dented() {
    let context = context(1);
    let mut plate = object(&context, &plate(6, 0.0), 32, DAffine3::IDENTITY);
    let block = 2 * 34 * 34;
    plate.displacement_mut().set_budget(3 * block);
    let ball = ball(&context, 1.5, DAffine3::from_translation(DVec3::new(0.0, 0.0, 1.2)));
    let report = press(&context, &mut plate, &ball, 1);
    assert_eq!(report.bytes, 3 * block);
    assert!(!report.refused.is_empty() && !report.changed.is_empty());
}

#[test]
fn a_fast_ball_leaves_a_track_and_not_dots() {
    let context = context(2);
    let (from, to) = (DVec3::new(-4.0, 0.1, 0.3), DVec3::new(4.0, 0.1, 0.3));
    let roll =
        |at: DVec3, angle: f64| Pose::rigid(DAffine3::from_rotation_translation(DQuat::from_rotation_y(angle), at));
    let run = |settings: ImprintSettings| {
        let mut plate = object(&context, &plate(12, 0.0), 64, DAffine3::IDENTITY);
        let mut ball = ball(&context, 0.5, DAffine3::IDENTITY);
        let motion = Motion::new(&ball, roll(from, 0.0), roll(to, 2.0)).unwrap();
        let report =
            Imprinter::new().sweep(&context, &mut plate, &mut ball, &motion, &settings, Moment::default()).unwrap();
        assert_eq!(ball.transform().translation, to);
        // The shallowest and the deepest place along the middle of the track.
        let depths = coefficients(&plate).into_iter().filter(|(_, p, _)| (p.y - 0.1).abs() < 0.02 && p.x.abs() < 3.9);
        let depths = depths.fold((0.0f32, -1.0f32), |(deep, shallow), (_, _, v)| (deep.min(v), shallow.max(v)));
        (report, depths)
    };
    let (report, (deep, shallow)) = run(settings());
    assert!(report.sub_steps > 30 && report.sub_steps == report.sub_steps_wanted, "{report:?}");
    assert!(shallow < -0.17 && deep > -0.25, "{shallow} {deep}");
    let (report, (deep, _)) = run(ImprintSettings { depth_limit: 0.0625, ..settings() });
    assert_eq!(deep, -0.0625);
    assert!(report.changed.len() > 8);
    let (report, (_, shallow)) = run(ImprintSettings { sub_steps: 3, ..settings() });
    assert!(report.sub_steps == 3 && report.sub_steps_wanted > 30 && shallow == 0.0);
}

#[test]
fn two_deformable_objects_share_the_penetration() {
    let context = context(2);
    let (ground, body) = (plate(8, 0.0), cube(2.0));
    let mut below = object(&context, &ground, 32, DAffine3::IDENTITY);
    let mut above = object(&context, &body, 32, DAffine3::IDENTITY);
    // The lowest point of the limit surface of the cube, in the middle of the face it looks down with.
    let lowest = coefficients(&above).into_iter().map(|(_, p, _)| p.z).fold(f64::INFINITY, f64::min);
    let overlap = 0.3;
    above.set_transform(DAffine3::from_translation(DVec3::new(0.1, 0.2, -lowest - overlap))).unwrap();
    let settings = ImprintSettings { voxels: 1 << 18, ..settings() };
    let mut first =
        Deformable { object: &mut below, cage: &ground, settings: ImprintSettings { share: 0.5, ..settings } };
    let mut second = Deformable { object: &mut above, cage: &body, settings };
    let reports = Imprinter::new().collide(&context, &mut first, &mut second, Moment::default()).unwrap();
    assert!(reports.iter().all(|report| report.changed_coefficients > 100), "{reports:?}");
    let slack = reports[0].voxel_diagonal.max(reports[1].voxel_diagonal);
    let deepest = |object: &DisplacedObject| coefficients(object).into_iter().map(|(_, _, v)| v).fold(0.0, f32::min);
    let (a, b) = (f64::from(-deepest(&below)), f64::from(-deepest(&above)));
    assert!((a - 0.5 * overlap).abs() < slack && (a + b - overlap).abs() < 2.0 * slack, "{a} {b} {slack}");
    // Nothing of the body is left below the ground around it.
    let ground: Vec<DVec3> = coefficients(&below).into_iter().map(|(_, p, _)| p).collect();
    for (_, point, _) in coefficients(&above).into_iter().filter(|(_, p, _)| p.z < 0.0) {
        let near = ground.iter().min_by(|a, b| {
            let far = |p: &DVec3| (p.truncate() - point.truncate()).length();
            far(a).total_cmp(&far(b))
        });
        assert!(point.z > near.unwrap().z - 2.0 * slack, "{point} {near:?}");
    }
}

/// `valence` quads around the origin, facing +z, with a border: corners on a circle of radius 2.
fn fan(valence: u32) -> Mesh {
    let mut points = vec![[0.0; 3]];
    for k in 0..2 * valence {
        let angle = std::f32::consts::TAU * k as f32 / (2 * valence) as f32;
        points.push([2.0 * angle.cos(), 2.0 * angle.sin(), 0.0]);
    }
    let corner = |k: u32| 1 + k % (2 * valence);
    let corners = (0..valence).flat_map(|k| [0, corner(2 * k), corner(2 * k + 1), corner(2 * k + 2)]).collect();
    Mesh::new(points, vec![4; valence as usize], corners)
}

#[test]
fn any_valence_borders_and_mixed_sizes_are_dented() {
    for valence in [2, 3, 5, 14] {
        let context = context(2);
        let mesh = fan(valence);
        let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
        // Every second face is coarser, one is finer.
        let mut face_sizes: Vec<(u32, u32)> = (0..valence).step_by(2).map(|face| (face, 16)).collect();
        face_sizes.push((1, 64));
        let options = DisplacementOptions { size: 32, face_sizes, ..DisplacementOptions::default() };
        let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
        let mut object =
            DisplacedObject::new(&context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
        // Once over the middle, once over the border.
        for x in [0.0, 1.6] {
            let middle = DVec3::new(x, 0.05, 0.45);
            let ball = ball(&context, 0.7, DAffine3::from_translation(middle));
            let report = press(&context, &mut object, &ball, 2);
            assert!(report.changed_coefficients > 20 && report.refused.is_empty(), "valence {valence}: {report:?}");
            if x == 0.0 {
                // Tiles that the middle of the dent touches.
                assert_eq!(report.changed.len(), valence as usize);
            }
            let mut dented = 0;
            for (_, point, value) in coefficients(&object) {
                // Around the vertex in the middle coefficients are averaged.
                let depth = 0.7 - (point - middle).length();
                assert!(
                    point.length() < 0.4 || depth <= report.voxel_diagonal,
                    "valence {valence}: {depth} at {point}"
                );
                dented += u32::from(value < 0.0);
            }
            assert!(dented > 100, "valence {valence}: {dented}");
        }
    }
}

/// A flat sheet of one quad with the given half edges, facing −z.
fn sheet(context: &Context, [x, y]: [f32; 2], transform: DAffine3) -> Collider {
    let points = vec![[-x, -y, 0.0], [-x, y, 0.0], [x, y, 0.0], [x, -y, 0.0]];
    Collider::new(context, points, vec![[0, 1, 2], [0, 2, 3]], transform).unwrap()
}

#[test]
fn a_flat_sheet_without_depth_presses_with_all_that_is_behind_it() {
    for (case, turn) in [(0.0, 0.0), (0.0, 0.3), (1.1, 0.2), (3.1, -0.4)].into_iter().enumerate() {
        for (jitter, slope) in [(0.0, 0.0), (0.1, 0.0), (0.0, 0.15), (0.1, 0.15)] {
            for half in [[1.3, 0.9], [9.0, 9.0]] {
                let context = context(1);
                let world = DAffine3::from_rotation_translation(
                    DQuat::from_euler(EulerRot::XYZ, turn.0, turn.1, 0.0),
                    DVec3::new(3.0, 1.0, -2.0),
                );
                let mut plate = object(&context, &plate(6, 0.0), 32, world);
                let place =
                    DAffine3::from_rotation_translation(DQuat::from_rotation_y(slope), DVec3::new(0.1, 0.2, -0.25));
                let sheet = sheet(&context, half, world * place);
                let settings = ImprintSettings { jitter, ..settings() };
                let mut imprinter = Imprinter::new();
                let report = imprinter.imprint(&context, &mut plate, &sheet, &settings, Moment::default()).unwrap();
                let named = || format!("case {case}, jitter {jitter}, slope {slope}, half {half:?}");
                assert!(report.changed_coefficients > 500, "{}: {report:?}", named());
                let mut inside = 0;
                for (_, point, value) in coefficients(&plate) {
                    // Straight below its place on the plate, as the sheet sees it.
                    let local = (world * place).inverse().transform_point3(point);
                    let flat = world.inverse().transform_point3(point);
                    let under = |slack: f64| {
                        local.x.abs() < f64::from(half[0]) - slack && local.y.abs() < f64::from(half[1]) - slack
                    };
                    if flat.x.abs().max(flat.y.abs()) < 2.5 && under(0.2) {
                        let sheet_height = -0.25 - (flat.x - 0.1) * slope.tan();
                        let expected = sheet_height.min(0.0);
                        let slack = report.voxel_diagonal;
                        assert!(
                            (f64::from(value) - expected).abs() < slack,
                            "{}: {value} instead of {expected} at {flat}, voxel {slack}",
                            named()
                        );
                        inside += 1;
                    } else if !under(-0.2) {
                        assert_eq!(value, 0.0, "{}: {flat}", named());
                    }
                }
                assert!(inside > 300, "{}: {inside}", named());
            }
        }
    }
}

/// Presses balls of radius 1 at places into a flat plate, with a rim, and returns the report and all coefficients.
fn rimmed(threads: usize, places: &[DVec3], settings: &ImprintSettings) -> (Report, Vec<(u32, DVec3, f32)>) {
    let context = context(threads);
    let mut plate = object(&context, &plate(10, 0.0), 32, DAffine3::IDENTITY);
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for place in places {
        let ball = ball(&context, 1.0, DAffine3::IDENTITY);
        let first = points.len() as u32;
        points.extend(ball.points().iter().map(|p| (DVec3::from(p.map(f64::from)) + *place).as_vec3().to_array()));
        triangles.extend(ball.triangles().iter().map(|corners| corners.map(|point| point + first)));
    }
    let balls = Collider::new(&context, points, triangles, DAffine3::IDENTITY).unwrap();
    let report = Imprinter::new().imprint(&context, &mut plate, &balls, settings, Moment::default()).unwrap();
    (report, coefficients(&plate))
}

#[test]
fn a_rim_holds_its_share_of_what_was_pushed_away() {
    let settings = ImprintSettings { rim: 0.5, rim_width: 0.6, repose: 1.2, ..settings() };
    let middle = DVec3::new(0.1, 0.2, 0.8);
    let (report, found) = rimmed(1, &[middle], &settings);
    // The cap of height 0.2 of the ball, over a disc of radius 0.6.
    let cap = std::f64::consts::PI * 0.04 * 2.8 / 3.0;
    assert!((report.volumes.pushed - cap).abs() < 0.05 * cap, "{:?} {cap}", report.volumes);
    assert!((report.volumes.raised / report.volumes.pushed - 0.5).abs() < 0.01, "{:?}", report.volumes);
    // The profile's integral over the ring: 2π·w·(r/2 + 3w/20).
    let height = 0.5 * cap / (std::f64::consts::TAU * 0.6 * (0.3 + 0.09));
    let mut highest: f32 = 0.0;
    for (_, p, value) in &found {
        let s = (p.truncate().distance(middle.truncate()) - 0.6) / 0.6;
        if s > 0.1 {
            let expected = if s < 1.0 { height * (1.0 - s).powi(2) * (1.0 + 2.0 * s) } else { 0.0 };
            assert!((f64::from(*value) - expected).abs() < 0.12 * height, "{value} {expected} at {s}");
        }
        highest = highest.max(*value);
    }
    assert!((f64::from(highest) - height).abs() < 0.1 * height, "{highest} {height}");
    assert!(rimmed(2, &[middle], &settings) == (report, found));
}

#[test]
fn rims_are_no_steeper_than_the_angle_of_repose() {
    let settings = ImprintSettings { rim: 1.0, rim_width: 0.6, repose: 0.05, ..settings() };
    let (report, found) = rimmed(1, &[DVec3::new(0.1, 0.2, 0.8)], &settings);
    let highest = found.iter().map(|(_, _, value)| *value).fold(0.0, f32::max);
    assert!((highest - 0.6 * 0.05f32.tan() / 1.5).abs() < 1e-3, "{highest}");
    assert!(report.volumes.raised < 0.5 * report.volumes.pushed, "{:?}", report.volumes);
}

#[test]
fn a_rim_too_wide_for_memory_is_refused() {
    let (context, narrow) = (context(1), ContextOptions { threads: 1, memory_limit: 100_000 });
    let narrow = Context::new(&narrow).unwrap();
    let mut plate = object(&context, &plate(10, 0.0), 32, DAffine3::IDENTITY);
    let ball = ball(&context, 1.0, DAffine3::from_translation(DVec3::new(0.1, 0.2, 0.8)));
    let settings = ImprintSettings { rim: 1.0, rim_width: 50000.0, ..settings() };
    let error = Imprinter::new().imprint(&narrow, &mut plate, &ball, &settings, Moment::default()).unwrap_err();
    assert!(error.to_string().contains("rim_width"), "{error}");
    assert_eq!(plate.displacement().bytes(), 0);
}

/// Checks that a shallow and a deep patch of contact raise rims of their own, of which `highest` returns the height around
/// a place where balls are at some places.
pub(crate) fn check_rims_of_two_patches(highest: impl Fn(&[DVec3], DVec3) -> f32) {
    let (shallow, deep) = (DVec3::new(-2.5, 0.1, 0.9), DVec3::new(2.5, 0.1, 0.7));
    let both = [shallow, deep];
    let (low, high) = (highest(&both, shallow), highest(&both, deep));
    assert!(high > 2.0 * low && low > 0.0, "{low} {high}");
    for (place, together) in [(shallow, low), (deep, high)] {
        let alone = highest(&[place], place);
        assert!((alone - together).abs() < 0.1 * alone, "{alone} {together}");
    }
}

#[test]
fn every_patch_of_contact_has_a_rim_of_its_own() {
    let settings = ImprintSettings { rim: 1.0, rim_width: 0.4, repose: 1.4, ..settings() };
    check_rims_of_two_patches(|places, around| {
        let (_, found) = rimmed(1, places, &settings);
        let near = found.iter().filter(|(_, p, _)| p.truncate().distance(around.truncate()) < 2.0);
        near.map(|(_, _, value)| *value).fold(0.0, f32::max)
    });
}

#[test]
fn an_imprint_is_the_same_on_an_object_that_was_opened_as_it_is() {
    let context = context(1);
    let mesh = plate(6, 0.1);
    let mut object = object(&context, &mesh, 32, DAffine3::IDENTITY);
    let plain = ImprintSettings { max_displacement: 0.4, ..settings() };
    let rimmed = ImprintSettings { rim: 0.8, rim_width: 0.4, ..plain };
    let at = |x: f64, z: f64| DAffine3::from_translation(DVec3::new(x, 0.0, z));
    let highest = |object: &DisplacedObject| coefficients(object).iter().fold(0.0, |most: f32, it| most.max(it.2));
    // A rim rises, and another ball presses it flat.
    let small = ball(&context, 0.8, at(0.0, 0.6));
    let large = ball(&context, 20.0, at(0.0, 19.98));
    let press = |object: &mut DisplacedObject, collider: &Collider, settings: &ImprintSettings| {
        let report = Imprinter::new().imprint(&context, object, collider, settings, Moment::default()).unwrap();
        assert!(!report.changed.is_empty());
    };
    press(&mut object, &small, &rimmed);
    let risen = highest(&object);
    press(&mut object, &large, &plain);
    assert!(risen > 0.05 && highest(&object) < 0.8 * risen, "{risen} {}", highest(&object));
    let mut opened = self::object(&context, &mesh, 32, DAffine3::IDENTITY);
    for tile in 0..mesh.face_count() as u32 {
        let bytes = object.displacement().read(tile).unwrap();
        opened.displacement_mut().write(tile, bytes.as_deref()).unwrap();
    }
    let other = ball(&context, 0.7, at(1.8, 0.5));
    [&mut object, &mut opened].into_iter().for_each(|object| press(object, &other, &rimmed));
    assert!(blocks(&object) == blocks(&opened));
}
