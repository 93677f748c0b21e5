//! Brushes that move the surface sideways, pinch and vector stamps, against closed forms, on Catmull-Clark surfaces.

use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use relievo_core::parameter::Switch;
use relievo_core::simd::Level;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{
    Action, Brush, Collider, Dab, DisplacedObject, Falloff, ImprintSettings, Imprinter, Moment, OpenStroke, PaintMode,
    Recorded, SculptMode, Stamp, StampChannel, StampImage, StampSettings, Stroke, StrokePoint, StrokeSettings,
};
use relievo_surface::{Place, Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, ColorTexel, Displacement, Paint, Points, Texel, VectorDisplacement};

use crate::shapes::{centred_plane, cube};

const BLANK: Vec4 = Vec4::new(0.5, 0.5, 0.5, 1.0);

fn object(context: &Context, mesh: &Mesh, size: u32, transform: DAffine3) -> DisplacedObject {
    with_budget(context, mesh, size, transform, 1 << 30)
}

fn with_budget(context: &Context, mesh: &Mesh, size: u32, transform: DAffine3, budget: u64) -> DisplacedObject {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
    let options = ChannelOptions { size, budget, ..ChannelOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let paint = Paint::of_color(surface.topology().clone(), BLANK, &options).unwrap();
    let vectors = VectorDisplacement::on(&surface, &options).unwrap();
    let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, transform).unwrap();
    object.set_paint(paint).unwrap();
    object.set_vectors(vectors).unwrap();
    object
}

/// A texel of vectors: the undisplaced place in the world, and how far it is moved there.
struct Moved {
    tile: u32,
    at: usize,
    /// Whether it is in a corner of its tile, where it is the mean around the vertex if the valence is not 4.
    corner: bool,
    place: DVec3,
    way: DVec3,
}

fn moved(object: &DisplacedObject) -> Vec<Moved> {
    let field = object.vectors().unwrap().field();
    let mut list = Vec::new();
    for tile in 0..field.tile_count() as u32 {
        let size = field.size(tile);
        for k in 0..size * size {
            let (i, j) = (k % size, k / size);
            let [u, v] = [i, j].map(|i| (i as f32 + 0.5) / size as f32);
            let sample = object.surface().sample(Level::Baseline, Place::new(tile, u, v)).unwrap();
            let [du, dv] = [sample.du, sample.dv].map(|d| Vec3::from(d).as_dvec3());
            let (t, n) = (du.normalize(), du.cross(dv).normalize());
            let at = ((j + 1) * (size + 2) + i + 1) as usize;
            let vector = field.block(tile).map_or(DVec3::ZERO, |block| block[at].value());
            let place = object.transform().transform_point3(Vec3::from(sample.p).as_dvec3());
            let way = object.transform().transform_vector3(t * vector.x + n.cross(t) * vector.y + n * vector.z);
            let corner = [i, j].iter().all(|i| *i == 0 || *i == size - 1);
            list.push(Moved { tile, at, corner, place, way });
        }
    }
    list
}

fn sculpt(mode: SculptMode, height: f32) -> Action {
    Action::Sculpt { mode, height }
}

/// A stamp of the vectors that `at` says, at places −1 to 1 from left to right and bottom to top.
fn vectors(n: u32, settings: StampSettings, at: impl Fn(f32, f32) -> [f32; 3]) -> Stamp {
    let side = |k: u32| (k as f32 + 0.5) / n as f32 * 2.0 - 1.0;
    let data: Vec<f32> = (0..n * n).flat_map(|k| at(side(k % n), -side(k / n))).collect();
    Stamp::new(StampImage::new(n, n, 3, &data).unwrap(), settings, StampChannel::Red).unwrap()
}

/// Settings of images whose numbers are the vectors themselves.
const RAW: StampSettings =
    StampSettings { angle: 0.0, repeat: 1.0, mirror: Switch::OFF, alternate: Switch::OFF, mid: 0.0, scale: 1.0 };

#[test]
fn a_pinch_contracts_distances_from_its_line_by_its_falloff() {
    let context = Context::serial();
    let turned = DAffine3::from_rotation_x(0.7)
        * DAffine3::from_scale(DVec3::new(2.0, 1.0, 0.5))
        * DAffine3::from_translation(DVec3::new(0.3, 0.1, 0.2));
    for (mesh, transform) in [(centred_plane(4), DAffine3::IDENTITY), (cube(1.0), turned)] {
        for height in [0.05, -0.05] {
            let mut object = object(&context, &mesh, 32, transform);
            let near = object.nearest(&context, transform.transform_point3(DVec3::new(0.1, 0.2, 0.7)), 9.0);
            let found = near.unwrap().unwrap();
            let half = DVec3::new(0.9, 0.7, 0.8);
            for falloff in [Falloff::Linear, Falloff::Smooth] {
                let brush = Brush::on_surface(found.point, found.normal, found.tangent, half, falloff).unwrap();
                let before = moved(&object);
                let dab = Dab { brush: brush.clone(), action: sculpt(SculptMode::Pinch, height), strength: 0.75 };
                let report = dab.apply(&context, &mut object).unwrap();
                assert!(report.changed_texels > 100 && report.refused.is_empty());
                let across = |p: DVec3| p - found.point - found.normal * (p - found.point).dot(found.normal);
                for (old, new) in before.iter().zip(moved(&object)).filter(|(old, _)| !old.corner) {
                    let here = old.place + old.way;
                    let share = 0.75 * falloff.share(brush.map().transform_point3(here).as_vec3().to_array());
                    let inside = brush.map().transform_point3(here).abs().max_element() < 1.0;
                    let share = if inside { f64::from(share) } else { 0.0 };
                    let sign = if height < 0.0 { 1.0 } else { -1.0 };
                    let expected = old.way + across(here) * (sign * share);
                    let off = (new.way - expected).length();
                    // Half floats of three numbers, and the box's own border.
                    let border = (brush.map().transform_point3(here).abs().max_element() - 1.0).abs() < 1e-5;
                    assert!(border || off < 2e-3 * expected.length() + 1e-5, "{} {off} {expected}", old.place);
                }
            }
        }
    }
}

#[test]
fn dabs_of_a_pinch_at_one_place_never_cross_the_line() {
    let context = Context::serial();
    let mut object = object(&context, &centred_plane(4), 64, DAffine3::IDENTITY);
    let point = |pressure| StrokePoint { time: Some(pressure * 2.0), ..StrokePoint::new(DVec3::ZERO, 1.0) };
    let settings = StrokeSettings { radius: 1.0, rate: 4.0, strength: 0.5, ..Default::default() };
    let stroke = Stroke::new(vec![point(0.0), point(1.0)], settings, Falloff::Linear, sculpt(SculptMode::Pinch, 1.0));
    let report = stroke.apply(&context, &mut object).unwrap();
    assert_eq!(report.dabs, 9);
    for Moved { place, way, .. } in moved(&object) {
        let share = 0.5 * f64::from(Falloff::Linear.share(place.as_vec3().to_array()));
        let expected = place.length() * if place.length() < 1.0 { (1.0 - share).powi(9) } else { 1.0 };
        assert!(((place + way).length() - expected).abs() < 4e-3, "{place} {way} {expected}");
        assert!((place + way).dot(place) > 0.0);
    }
}

#[test]
fn a_stamp_of_vectors_leaves_its_field() {
    let context = Context::serial();
    let field = |x: f32, y: f32| [0.3 * x * y, 0.2 - 0.1 * y, 0.5 * x + 0.25];
    for (angle, mirror, turn) in [(0.0, false, 0.0), (0.5, false, 0.3), (0.0, true, 0.0), (-0.7, true, 1.1)] {
        let mut object = object(&context, &centred_plane(4), 64, DAffine3::from_rotation_y(0.4));
        let axes = DMat3::from_rotation_y(0.4) * DMat3::from_rotation_z(turn);
        let half = DVec3::new(1.5, 1.0, 1.0);
        let brush = Brush::new(DVec3::ZERO, axes, half, Falloff::Constant).unwrap();
        let mirror = if mirror { Switch::ON } else { Switch::OFF };
        let stamp = vectors(256, StampSettings { angle, mirror, ..RAW }, field);
        let brush = brush.with_stamp(stamp);
        let dab = Dab { brush: brush.clone(), action: sculpt(SculptMode::Vector, 2.0), strength: 0.5 };
        dab.apply(&context, &mut object).unwrap();
        let mut seen = 0;
        for Moved { place, way, .. } in moved(&object) {
            let at = brush.map().transform_point3(place).as_vec3();
            let (sine, cosine) = angle.sin_cos();
            let (x, y) = (cosine * at.x + sine * at.y, cosine * at.y - sine * at.x);
            let sign = if mirror.is_on() { -1.0 } else { 1.0 };
            let inside = at.abs().max_element() < 1.0 && x.abs().max(y.abs()) < 0.98;
            if !inside {
                let outside = at.abs().max_element() > 1.0 || x.abs().max(y.abs()) > 1.02;
                assert!(!outside || way == DVec3::ZERO);
                continue;
            }
            let [right, up, out] = field(sign * x, y);
            let right = sign * right;
            let expected =
                axes * DVec3::from([cosine * right - sine * up, sine * right + cosine * up, out].map(f64::from));
            // Bilinear between pixels errs by less than half floats do.
            assert!((way - expected).length() < 6e-4, "{angle} {place}: {way} {expected}");
            seen += 1;
        }
        assert!(seen > 3000);
    }
}

#[test]
fn repeats_that_are_mirrored_meet_without_a_seam() {
    let settings = StampSettings { repeat: 3.0, alternate: Switch::ON, ..RAW };
    let context = Context::serial();
    let mut object = object(&context, &centred_plane(4), 128, DAffine3::IDENTITY);
    let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(1.5), Falloff::Constant).unwrap();
    // Upright at its border, so that its mirror image goes on from there.
    let brush =
        brush.with_stamp(vectors(128, settings, |x, y| [0.2 * (1.0 - x * x), 0.1 * (1.0 - y * y), 0.3 * x * x]));
    Dab { brush, action: sculpt(SculptMode::Vector, 1.0), strength: 1.0 }.apply(&context, &mut object).unwrap();
    for Moved { place, way, .. } in moved(&object) {
        if place.abs().max_element() > 1.45 {
            continue;
        }
        let cell = |t: f64| {
            let t = t + 0.5;
            (2.0 * t.rem_euclid(1.0) - 1.0, if t.floor() as i64 % 2 == 0 { 1.0 } else { -1.0 })
        };
        let ((x, sx), (y, sy)) = (cell(place.x), cell(place.y));
        let expected = DVec3::new(0.2 * sx * (1.0 - x * x), 0.1 * sy * (1.0 - y * y), 0.3 * x * x);
        assert!((way - expected).length() < 4e-3, "{place}: {way} {expected}");
    }
}

#[test]
fn symmetry_mirrors_pinches_and_stamps() {
    let context = Context::serial();
    let stamp = vectors(64, RAW, |x, y| [0.2 * y, 0.1 + 0.1 * x, 0.2 * (1.0 - x * x)]);
    for mode in [SculptMode::Pinch, SculptMode::Vector] {
        let mut object = object(&context, &centred_plane(4), 32, DAffine3::IDENTITY);
        let settings = StrokeSettings { radius: 0.6, symmetry_x: Switch::ON, ..Default::default() };
        let points = [[0.7, -0.5, 0.0], [0.9, 0.4, 0.0]].map(|p| StrokePoint::new(p.into(), 1.0));
        let mut stroke = Stroke::new(points.to_vec(), settings, Falloff::Smooth, sculpt(mode, 0.5));
        stroke.stamp = (mode == SculptMode::Vector).then(|| stamp.clone());
        stroke.apply(&context, &mut object).unwrap();
        let all = moved(&object);
        assert!(all.iter().any(|moved| moved.way.length() > 0.05));
        for one in &all {
            let mirrored = DVec3::new(-one.place.x, one.place.y, one.place.z);
            let other = all
                .iter()
                .min_by(|a, b| a.place.distance_squared(mirrored).total_cmp(&b.place.distance_squared(mirrored)));
            let other = other.unwrap();
            assert!(other.place.distance(mirrored) < 1e-5);
            let way = DVec3::new(-other.way.x, other.way.y, other.way.z);
            assert!((one.way - way).length() < 2e-3, "{mode:?} {}: {} {way}", one.place, one.way);
        }
    }
}

/// The surface on the edges of all tiles, and just inside of them.
fn borders(context: &Context, object: &DisplacedObject) -> Vec<(Place, [[f32; 3]; 2])> {
    let displaced = object.displaced().unwrap();
    let (mut edge, mut inner) = (Vec::new(), Vec::new());
    for tile in 0..object.surface().tile_count() as u32 {
        for side in 0..4 {
            for step in 1..16 {
                let t = step as f32 / 16.0;
                let at = |depth: f32| match side {
                    0 => Place::new(tile, t, depth),
                    1 => Place::new(tile, 1.0 - depth, t),
                    2 => Place::new(tile, t, 1.0 - depth),
                    _ => Place::new(tile, depth, t),
                };
                edge.push(at(0.0));
                inner.push(at(1e-4));
            }
        }
    }
    let (mut points, mut near) = (Points::default(), Points::default());
    displaced.evaluate(context, &edge, &mut points).unwrap();
    displaced.evaluate(context, &inner, &mut near).unwrap();
    let keys = edge.iter().map(|place| displaced.canonical(*place));
    keys.zip(points.p.into_iter().zip(near.p)).map(|(key, (p, q))| (key, [p, q])).collect()
}

#[test]
fn seams_are_equal_to_the_bit_after_pinches_and_stamps() {
    let context = Context::serial();
    let mut object = object(&context, &cube(1.0), 32, DAffine3::IDENTITY);
    let stamp = vectors(64, RAW, |x, y| [0.1 * y, 0.1 * x, 0.2 * (1.0 - x * x)]);
    for (mode, at) in [(SculptMode::Vector, [0.4, 0.5, 0.6]), (SculptMode::Pinch, [0.0, 0.45, 0.5])] {
        let points = [at, [-0.2, 0.6, 0.4]].map(|p| StrokePoint::new(DVec3::from(p), 1.0));
        let settings = StrokeSettings { radius: 0.4, strength: 0.5, reach: 9.0, ..Default::default() };
        let mut stroke = Stroke::new(points.to_vec(), settings, Falloff::Smooth, sculpt(mode, 0.3));
        stroke.stamp = (mode == SculptMode::Vector).then(|| stamp.clone());
        assert!(stroke.apply(&context, &mut object).unwrap().dabs > 1);
    }
    let mut seen: std::collections::BTreeMap<(u32, u32, u32), [f32; 3]> = Default::default();
    let mut pairs = 0;
    for (key, [edge, inner]) in borders(&context, &object) {
        let far = Vec3::from(edge).distance(Vec3::from(inner));
        // Within a texel of an edge the tangent turns a little, and vectors with it.
        assert!(far < 0.02, "{key:?}: {far}");
        if let Some(other) = seen.insert((key.tile, key.u.to_bits(), key.v.to_bits()), edge) {
            assert_eq!(other.map(f32::to_bits), edge.map(f32::to_bits), "{key:?}");
            pairs += 1;
        }
    }
    assert!(pairs > 100);
}

#[test]
fn brushes_go_by_the_surface_that_vectors_moved() {
    let context = Context::serial();
    let mut object = object(&context, &centred_plane(6), 32, DAffine3::IDENTITY);
    // The middle goes aside by 1.5 and up by 2.
    let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(0.8), Falloff::Smooth).unwrap();
    let brush = brush.with_stamp(vectors(8, RAW, |_, _| [0.75, 0.0, 1.0]));
    Dab { brush, action: sculpt(SculptMode::Vector, 2.0), strength: 1.0 }.apply(&context, &mut object).unwrap();
    let tip = DVec3::new(1.5, 0.0, 2.0);
    let found = object.nearest(&context, tip + DVec3::Z * 0.1, 0.3).unwrap().unwrap();
    assert!(found.point.distance(tip) < 0.02, "{found:?}");
    let dab = |action| Dab {
        brush: Brush::new(tip, DMat3::IDENTITY, DVec3::splat(0.4), Falloff::Linear).unwrap(),
        action,
        strength: 1.0,
    };
    let before = moved(&object);
    let report = dab(Action::Paint { mode: PaintMode::Mix, color: [1.0, 0.0, 0.0, 1.0] });
    let report = report.apply(&context, &mut object).unwrap();
    assert!(report.changed_texels > 20);
    let painted = object.paint().unwrap().field();
    for Moved { tile, at, place, way, .. } in &before {
        let inside = ((*place + *way - tip) / 0.4).length() < 0.95;
        let outside = ((*place + *way - tip) / 0.4).length() > 1.05;
        let red = painted.block(*tile).map_or(BLANK, |block| block[*at].color()).x;
        assert!(!inside || red > 0.5, "{place} {way} {red}");
        assert!(!outside || (red - 0.5).abs() < 0.01, "{place} {way} {red}");
    }
    // What is where the middle was is not touched, and what is drawn sits on the tip.
    let report = dab(sculpt(SculptMode::Draw, 0.25)).apply(&context, &mut object).unwrap();
    assert!(report.changed_texels > 20);
    let found = object.nearest(&context, tip + DVec3::Z * 0.3, 0.3).unwrap().unwrap();
    assert!((found.point.z - 2.25).abs() < 0.02, "{found:?}");
}

#[test]
fn erasing_vectors_gives_all_memory_back_and_smoothing_evens_them() {
    let context = Context::serial();
    let mut object = object(&context, &cube(1.0), 32, DAffine3::IDENTITY);
    let bytes = object.vectors().unwrap().bytes();
    let brush = |radius: f64, falloff| {
        Brush::new(DVec3::new(0.0, 0.0, 0.5), DMat3::IDENTITY, DVec3::splat(radius), falloff).unwrap()
    };
    let dab = |brush, mode, height, strength| Dab { brush, action: sculpt(mode, height), strength };
    let rough = |x: f32, y: f32| [0.2 * (9.0 * x).sin(), 0.2 * (7.0 * y).cos(), 0.1];
    let stamped = brush(0.7, Falloff::Smooth).with_stamp(vectors(64, RAW, rough));
    dab(stamped, SculptMode::Vector, 1.0, 1.0).apply(&context, &mut object).unwrap();
    dab(brush(0.5, Falloff::Smooth), SculptMode::Draw, 0.2, 1.0).apply(&context, &mut object).unwrap();
    let roughness = |object: &DisplacedObject| {
        let field = object.vectors().unwrap().field();
        let mut sum = 0.0;
        for tile in field.allocated() {
            let (block, stride) = (field.block(tile).unwrap(), field.size(tile) as usize + 2);
            for row in block.chunks(stride) {
                sum += row.windows(2).map(|pair| (pair[1].value() - pair[0].value()).length_squared()).sum::<f64>();
            }
        }
        sum
    };
    let before = roughness(&object);
    let smooth = dab(brush(3.0, Falloff::Constant), SculptMode::Smooth, 0.0, 1.0);
    let report = smooth.apply(&context, &mut object).unwrap();
    assert_eq!(report.bytes, object.vectors().unwrap().bytes() + object.displacement().bytes());
    let after = roughness(&object);
    assert!(after < 0.9 * before, "{before} {after}");
    let report = dab(brush(3.0, Falloff::Constant), SculptMode::Erase, 0.0, 1.0).apply(&context, &mut object).unwrap();
    assert!(report.freed > 0);
    assert_eq!(object.vectors().unwrap().bytes(), bytes);
    assert_eq!(object.displacement().allocated_count() + object.vectors().unwrap().allocated_count(), 0);
}

fn stroke(mode: SculptMode) -> Stroke {
    let points = [[-1.5, 0.1, 0.0], [0.2, -0.7, 0.0], [1.3, 1.1, 0.0]];
    let points = points.map(|p| StrokePoint::new(p.into(), 0.8)).to_vec();
    let settings = StrokeSettings { radius: 0.5, strength: 0.4, jitter_angle: 1.0, ..Default::default() };
    let mut stroke = Stroke::new(points, settings, Falloff::Smooth, sculpt(mode, 0.3));
    stroke.stamp =
        (mode == SculptMode::Vector).then(|| vectors(32, RAW, |x, y| [0.3 * y, -0.3 * x, 0.5 * (1.0 - x * x)]));
    stroke
}

#[test]
fn strokes_are_the_same_however_they_come_and_on_any_number_of_threads() {
    for mode in [SculptMode::Pinch, SculptMode::Vector, SculptMode::Smooth, SculptMode::Erase] {
        let made = |threads, open: bool| {
            let context = Context::new(&ContextOptions { threads, ..Default::default() }).unwrap();
            let mut object = object(&context, &centred_plane(4), 32, DAffine3::IDENTITY);
            stroke(SculptMode::Vector).apply(&context, &mut object).unwrap();
            let stroke = stroke(mode);
            if open {
                let mut objects = [&mut object];
                let begun = Stroke { points: Vec::new(), ..stroke.clone() };
                let mut begun = OpenStroke::begin(&context, begun, &mut objects).unwrap();
                for point in &stroke.points {
                    begun.extend(&context, &mut objects, std::slice::from_ref(point)).unwrap();
                }
                begun.end(&context, &mut objects, &[]).unwrap();
            } else {
                stroke.apply(&context, &mut object).unwrap();
            }
            let states = object.states(&context).unwrap();
            let blocks = states.iter().flat_map(|state| {
                state.blocks.numbers().into_iter().map(|tile| state.blocks.bytes(tile).unwrap_or_default().into_owned())
            });
            blocks.collect::<Vec<_>>()
        };
        let one = made(1, false);
        assert!(!one.is_empty());
        assert_eq!(one, made(3, false), "{mode:?}");
        assert_eq!(one, made(1, true), "{mode:?}");
    }
}

#[test]
fn a_coarser_level_bends_over_fine_vectors() {
    let context = Context::serial();
    let mut object = object(&context, &centred_plane(4), 64, DAffine3::IDENTITY);
    let fine = vectors(128, RAW, |x, y| [0.0, 0.0, 0.05 * (20.0 * x).sin() * (20.0 * y).sin()]);
    let brush = |radius| Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(radius), Falloff::Smooth).unwrap();
    let dab = Dab { brush: brush(1.5).with_stamp(fine), action: sculpt(SculptMode::Vector, 1.0), strength: 1.0 };
    dab.apply(&context, &mut object).unwrap();
    let before = moved(&object);
    let aside = vectors(8, RAW, |_, _| [0.5, 0.0, 0.0]);
    let dab = Dab { brush: brush(1.2).with_stamp(aside), action: sculpt(SculptMode::Vector, 1.0), strength: 1.0 };
    dab.apply_at(&context, &mut object, 2).unwrap();
    for (old, new) in before.iter().zip(moved(&object)) {
        let share = f64::from(Falloff::Smooth.share((old.place / 1.2).as_vec3().to_array()));
        let inside = (old.place / 1.2).length() < 1.0;
        let expected = old.way + DVec3::X * if inside { 0.5 * share } else { 0.0 };
        // Between texels of a quarter the falloff is a spline, and shares go by the fine surface.
        assert!((new.way - expected).length() < 0.02, "{}: {} {expected}", old.place, new.way);
        assert!((new.way.z - old.way.z).abs() < 1e-4);
    }
}

#[test]
fn a_budget_smaller_than_a_tile_refuses_and_changes_nothing() {
    let context = Context::serial();
    for budget in [0, 100, 4000] {
        let mut object = with_budget(&context, &centred_plane(4), 64, DAffine3::IDENTITY, budget);
        let colour = Action::Paint { mode: PaintMode::Mix, color: [1.0, 0.0, 0.0, 1.0] };
        for action in [colour, sculpt(SculptMode::Draw, 0.2), sculpt(SculptMode::Pinch, 0.2)] {
            let made = Stroke { action, ..stroke(SculptMode::Pinch) };
            let report = made.apply(&context, &mut object).unwrap();
            assert!(report.dabs > 1 && !report.report.refused.is_empty(), "{action:?}");
            assert!(report.report.changed.is_empty() && report.report.changed_texels == 0);
        }
        let report = stroke(SculptMode::Vector).apply(&context, &mut object).unwrap();
        assert!(!report.report.refused.is_empty() && report.report.changed.is_empty());
        assert!(object.states(&context).unwrap().iter().all(|state| state.blocks.numbers().is_empty()));
        assert_eq!(object.vectors().unwrap().bytes() + object.displacement().bytes(), 0);
        // Nothing is there to smooth or erase, and nothing is refused for it.
        for mode in [SculptMode::Smooth, SculptMode::Erase] {
            let report = stroke(mode).apply(&context, &mut object).unwrap();
            assert!(report.report.changed.is_empty() && report.report.refused.is_empty());
        }
    }
}

#[test]
fn objects_without_vectors_say_so() {
    let context = Context::serial();
    let surface = Surface::new(&context, &centred_plane(2), &SurfaceOptions::default()).unwrap();
    let none = Displacement::new(surface.topology().clone(), &ChannelOptions::default()).unwrap();
    let mut object =
        DisplacedObject::new(&context, surface, &centred_plane(2).points, none, DAffine3::IDENTITY).unwrap();
    for mode in [SculptMode::Pinch, SculptMode::Vector] {
        let error = stroke(mode).apply(&context, &mut object).unwrap_err().to_string();
        assert!(error.contains("no vector displacement"), "{error}");
        let dab = Dab {
            brush: Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::ONE, Falloff::Smooth).unwrap(),
            action: sculpt(mode, 1.0),
            strength: 1.0,
        };
        assert!(dab.apply(&context, &mut object).is_err() && dab.apply_at(&context, &mut object, 1).is_err());
    }
    assert!(stroke(SculptMode::Erase).apply(&context, &mut object).is_ok());
}

#[test]
fn imprints_go_by_the_surface_that_vectors_moved() {
    let context = Context::serial();
    let mut object = object(&context, &centred_plane(6), 32, DAffine3::IDENTITY);
    // The middle goes aside by 1.5 and up by 2; a box stands into it there from above, down to 1.8.
    let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(0.8), Falloff::Smooth).unwrap();
    let brush = brush.with_stamp(vectors(8, RAW, |_, _| [0.75, 0.0, 1.0]));
    Dab { brush, action: sculpt(SculptMode::Vector, 2.0), strength: 1.0 }.apply(&context, &mut object).unwrap();
    let corner = |i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { -0.4f32 } else { 0.4 });
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let block = Mesh::new((0..8).map(corner).collect(), vec![4; 6], faces.concat());
    let press = |object: &mut DisplacedObject, at: DVec3| {
        let collider = Collider::of_mesh(&context, &block, DAffine3::from_translation(at)).unwrap();
        let settings = ImprintSettings { voxels: 1 << 18, ..Default::default() };
        Imprinter::default().imprint(&context, object, &collider, &settings, Moment::default()).unwrap()
    };
    // Over where the middle was there is nothing.
    let report = press(&mut object, DVec3::new(0.0, 0.0, 1.6));
    assert_eq!(report.changed_coefficients, 0);
    let report = press(&mut object, DVec3::new(1.5, 0.0, 2.2));
    assert!(report.changed_coefficients > 10);
    let displaced = object.displaced().unwrap();
    let mut points = Points::default();
    let mut pressed = 0;
    for tile in 0..object.surface().tile_count() as u32 {
        displaced
            .grid(&context, tile, &relievo_surface::Grid::whole(32, relievo_surface::Placement::Centred), &mut points)
            .unwrap();
        for p in &points.p {
            let inside = (p[0] - 1.5).abs() < 0.35 && p[1].abs() < 0.35;
            assert!(!inside || p[2] < 1.82, "{p:?}");
            pressed += u32::from(inside && p[2] > 1.7);
        }
    }
    assert!(pressed > 10);
}
