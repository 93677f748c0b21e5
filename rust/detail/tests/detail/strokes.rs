//! The dynamics of strokes, stamps, and strokes over several objects, against closed forms and symmetry.

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec4};
use relievo_core::parameter::Switch;
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Brush, Curve, Dab, DisplacedObject, Falloff, OpenStroke, PaintMode, SculptMode, Stamp, StampChannel,
    StampImage, StampSettings, Stroke, StrokePoint, StrokeSettings,
};
use relievo_surface::{Grid, Placement};
use relievo_tiles::{ChannelOptions, ColorTexel, Displaced, Displacement, Points};

use crate::shapes::{centred_plane, painted};

const BLANK: Vec4 = Vec4::new(0.5, 0.5, 0.5, 1.0);

fn object(context: &Context, mesh: &Mesh, size: u32, transform: DAffine3) -> DisplacedObject {
    painted(context, mesh, size, BLANK, transform)
}

/// Tile, index in the block and undisplaced place in object space of every texel.
fn texels(context: &Context, object: &DisplacedObject) -> Vec<(u32, usize, DVec3)> {
    let field = object.displacement().field();
    let blank = Displacement::new(field.topology().clone(), &ChannelOptions::default()).unwrap();
    let flat = Displaced::new(object.surface(), blank.field()).unwrap();
    let mut list = Vec::new();
    for tile in 0..field.tile_count() as u32 {
        let size = field.size(tile);
        let mut points = Points::default();
        flat.grid(context, tile, &Grid::whole(size, Placement::Centred), &mut points).unwrap();
        for (k, p) in points.p.iter().enumerate() {
            let [i, j] = [k % size as usize, k / size as usize];
            list.push((tile, (j + 1) * (size as usize + 2) + i + 1, DVec3::from(p.map(f64::from))));
        }
    }
    list
}

fn height(object: &DisplacedObject, tile: u32, at: usize) -> f32 {
    object.displacement().field().block(tile).map_or(0.0, |block| block[at].to_f32())
}

fn color(object: &DisplacedObject, tile: u32, at: usize) -> Vec4 {
    let field = object.paint().unwrap().field();
    field.block(tile).map_or(field.blank(), |block| block[at]).color()
}

fn sculpt(mode: SculptMode, height: f32) -> Action {
    Action::Sculpt { mode, height }
}

fn line(points: &[[f64; 3]], settings: StrokeSettings, action: Action) -> Stroke {
    let points = points.iter().map(|p| StrokePoint::new((*p).into(), 1.0)).collect();
    Stroke::new(points, settings, Falloff::Smooth, action)
}

/// Red grows to the right, green downwards, alpha is 1 in the upper half.
fn image() -> Stamp {
    let n = 64;
    let at = |k: u32| (k as f32 + 0.5) / n as f32;
    let pixel = |k: u32| [at(k % n), at(k / n), 0.5, if k / n < n / 2 { 1.0 } else { 0.0 }];
    let data: Vec<f32> = (0..n * n).flat_map(pixel).collect();
    let image = StampImage::new(n, n, 4, &data).unwrap();
    Stamp::new(image, StampSettings::default(), StampChannel::Red).unwrap()
}

#[test]
fn a_stamp_paints_its_picture_and_raises_its_heights() {
    let context = Context::serial();
    let mut object = object(&context, &centred_plane(4), 64, DAffine3::IDENTITY);
    let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::new(1.5, 1.0, 1.0), Falloff::Constant).unwrap();
    let brush = brush.with_stamp(image());
    let paint = Action::Paint { mode: PaintMode::Mix, color: [1.0, 0.5, 1.0, 1.0] };
    let dab = |action| Dab { brush: brush.clone(), action, strength: 1.0 };
    let places = texels(&context, &object);
    dab(paint).apply(&context, &mut object).unwrap();
    dab(sculpt(SculptMode::Draw, 0.1)).apply(&context, &mut object).unwrap();
    let mut seen = 0;
    for (tile, at, p) in places {
        let (x, y) = (p.x as f32 / 1.5, p.y as f32);
        // Where filters reach beyond an edge of the image or of its alpha nothing is exact.
        if x.abs().min(y.abs()) < 0.05 || (x.abs() - 1.0).abs() < 0.05 || (y.abs() - 1.0).abs() < 0.05 {
            continue;
        }
        let (u, v) = (0.5 + 0.5 * x, 0.5 - 0.5 * y);
        let inside = x.abs() < 1.0 && (0.0..1.0).contains(&y);
        let expected = if inside { Vec4::new(u, 0.5 * v, 0.5, 1.0) } else { BLANK };
        let off = (color(&object, tile, at) - expected).abs().max_element();
        assert!(off < 0.02, "{p}: {} {expected}", color(&object, tile, at));
        let raised = if inside { 0.1 * 2.0 * (u - 0.5) } else { 0.0 };
        assert!((height(&object, tile, at) - raised).abs() < 1e-3, "{p}");
        seen += u32::from(inside);
    }
    assert!(seen > 1000);
}

#[test]
fn a_fine_stamp_leaves_its_mean_on_coarse_texels() {
    let context = Context::serial();
    let mut object = object(&context, &centred_plane(2), 8, DAffine3::IDENTITY);
    let n = 256;
    let data: Vec<f32> = (0..n * n).map(|k| ((k % n + k / n) % 2) as f32).collect();
    let settings = StampSettings { mid: 0.0, scale: 1.0, ..Default::default() };
    let stamp = Stamp::new(StampImage::new(n, n, 1, &data).unwrap(), settings, StampChannel::Red).unwrap();
    let brush = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(1.1), Falloff::Constant).unwrap();
    let dab = Dab { brush: brush.with_stamp(stamp), action: sculpt(SculptMode::Draw, 1.0), strength: 1.0 };
    dab.apply(&context, &mut object).unwrap();
    for (tile, at, p) in texels(&context, &object) {
        assert!((height(&object, tile, at) - 0.5).abs() < 0.01, "{p}: {}", height(&object, tile, at));
    }
}

#[test]
fn inflating_a_slope_moves_it_by_the_height_across_itself() {
    let context = Context::serial();
    let mut object = object(&context, &centred_plane(4), 64, DAffine3::IDENTITY);
    // A cone whose slope is 0.4 / 1.6 raised, then inflated.
    let brush = |half: f64, falloff| Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(half), falloff).unwrap();
    let cone = Dab { brush: brush(1.6, Falloff::Linear), action: sculpt(SculptMode::Draw, 0.8), strength: 1.0 };
    cone.apply(&context, &mut object).unwrap();
    let places = texels(&context, &object);
    let before: Vec<f32> = places.iter().map(|(tile, at, _)| height(&object, *tile, *at)).collect();
    let swell = Dab { brush: brush(9.0, Falloff::Constant), action: sculpt(SculptMode::Inflate, 0.1), strength: 1.0 };
    swell.apply(&context, &mut object).unwrap();
    let slope = 0.8f32 / 1.6;
    for ((tile, at, p), before) in places.into_iter().zip(before) {
        let r = p.truncate().length();
        let rise = height(&object, tile, at) - before;
        if (0.1..1.5).contains(&r) {
            assert!((rise - 0.1 * (1.0 + slope * slope).sqrt()).abs() < 2e-3, "{p}: {rise}");
        } else if r > 1.7 && p.abs().max_element() < 1.9 {
            assert!((rise - 0.1).abs() < 1e-3, "{p}: {rise}");
        }
    }
}

#[test]
fn symmetric_strokes_leave_symmetric_surfaces() {
    let context = Context::serial();
    let transform = DAffine3::from_translation(DVec3::new(5.0, 2.0, 1.0)) * DAffine3::from_rotation_z(0.6);
    let mut object = object(&context, &centred_plane(6), 32, transform);
    let settings = StrokeSettings {
        radius: 0.5,
        spacing: 0.5,
        angle: 0.4,
        jitter_position: 0.4,
        jitter_angle: 1.0,
        jitter_size: 0.3,
        seed: 7,
        symmetry_x: Switch::ON,
        symmetry_y: Switch::ON,
        ..Default::default()
    };
    let world = |x: f64, y: f64| transform.transform_point3(DVec3::new(x, y, 0.1)).to_array();
    for action in [sculpt(SculptMode::Draw, 0.1), Action::Paint { mode: PaintMode::Mix, color: [1.0, 0.2, 0.8, 1.0] }] {
        let mut stroke = line(&[world(0.8, 0.7), world(2.0, 1.9)], settings, action);
        stroke.stamp = Some(image());
        let done = stroke.apply(&context, &mut object).unwrap();
        assert_eq!((done.dabs, done.missed), (4 * 7, 0));
    }
    let places = texels(&context, &object);
    let (mut changed, mut off) = (0, 0);
    // Texels are row by row in faces row by row; the mirror image of one is another.
    let find = |x: f64, y: f64| {
        let (i, j) = (((x + 3.0) * 32.0) as usize, ((y + 3.0) * 32.0) as usize);
        (i / 32 + j / 32 * 6) * 1024 + i % 32 + j % 32 * 32
    };
    for (tile, at, p) in &places {
        let here = (height(&object, *tile, *at), color(&object, *tile, *at));
        changed += u32::from(here.0 != 0.0);
        for (x, y) in [(-p.x, p.y), (p.x, -p.y), (-p.x, -p.y)] {
            let (tile, at, q) = &places[find(x, y)];
            assert!(q.distance(DVec3::new(x, y, 0.0)) < 1e-5);
            let there = (height(&object, *tile, *at), color(&object, *tile, *at));
            // Next to the rims of stamps rounding decides.
            off += u32::from((here.0 - there.0).abs() > 2e-3 || (here.1 - there.1).abs().max_element() > 0.03);
        }
    }
    assert!(changed > 2000 && off < 3 * changed / 200, "{changed} {off}");
}

#[test]
fn jitter_stays_in_its_range_and_follows_the_seed() {
    let context = Context::serial();
    let settings = StrokeSettings {
        radius: 0.2,
        spacing: 4.0,
        jitter_position: 1.0,
        jitter_size: 0.5,
        jitter_strength: 0.5,
        seed: 3,
        ..Default::default()
    };
    let run = |seed: u32| {
        let mut object = object(&context, &centred_plane(8), 32, DAffine3::IDENTITY);
        let stroke = line(
            &[[-3.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
            StrokeSettings { seed, ..settings },
            sculpt(SculptMode::Draw, 0.1),
        );
        stroke.apply(&context, &mut object).unwrap();
        let places = texels(&context, &object);
        places.into_iter().map(|(tile, at, p)| (p, height(&object, tile, at))).collect::<Vec<_>>()
    };
    let first = run(3);
    assert_eq!(first, run(3));
    assert_ne!(first, run(4));
    let mut means = Vec::new();
    for k in 0..8 {
        let center = DVec2::new(-3.0 + 0.8 * f64::from(k), 0.0);
        let near = first.iter().filter(|(p, height)| *height != 0.0 && p.truncate().distance(center) < 0.4001);
        let (sum, weight, most) = near.fold((DVec2::ZERO, 0.0, 0.0f32), |(sum, weight, most), (p, height)| {
            (sum + p.truncate() * f64::from(*height), weight + f64::from(*height), most.max(*height))
        });
        assert!(weight > 0.0 && (0.045..0.101).contains(&most), "{k}: {most}");
        means.push((sum / weight).distance(center));
    }
    // Nothing lies further off than the jitter and the radius together.
    let stray = |p: &DVec3| (0..8).all(|k| p.truncate().distance(DVec2::new(-3.0 + 0.8 * f64::from(k), 0.0)) > 0.401);
    assert!(first.iter().all(|(p, height)| *height == 0.0 || !stray(p)));
    assert!(means.iter().all(|mean| *mean < 0.21) && means.iter().any(|mean| *mean > 0.1), "{means:?}");
}

#[test]
fn pressure_goes_through_its_curves() {
    let context = Context::serial();
    let settings = StrokeSettings { radius: 0.5, size_pressure: 1.0, strength_pressure: 1.0, ..Default::default() };
    let mut object = object(&context, &centred_plane(4), 64, DAffine3::IDENTITY);
    let mut stroke = line(&[[0.0; 3]], settings, sculpt(SculptMode::Draw, 0.1));
    stroke.points[0].pressure = 0.5;
    stroke.curves.size = Curve::new(vec![[0.0, 0.0], [0.5, 0.8], [1.0, 1.0]]).unwrap();
    stroke.curves.strength = Curve::new(vec![[0.4, 0.2], [0.6, 0.4]]).unwrap();
    stroke.apply(&context, &mut object).unwrap();
    for (tile, at, p) in texels(&context, &object) {
        let expected = 0.1 * 0.3 * Falloff::Smooth.share((p / 0.4).as_vec3().to_array());
        assert!((height(&object, tile, at) - expected).abs() < 1e-4, "{p}");
    }
}

#[test]
fn a_stroke_over_two_objects_is_made_on_both_where_they_meet() {
    let context = Context::serial();
    let [left, right] = [-2.0, 2.0].map(|x| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)));
    let mut objects = [object(&context, &centred_plane(4), 32, left), object(&context, &centred_plane(4), 32, right)];
    let settings = StrokeSettings { radius: 0.5, spacing: 0.5, reach: 1.0, ..Default::default() };
    let stroke = line(&[[-3.0, 0.1, 0.0], [3.0, 0.1, 0.0]], settings, sculpt(SculptMode::Draw, 0.1));
    let [a, b] = &mut objects;
    let done = stroke.apply_all(&context, &mut [a, b]).unwrap();
    assert!(done.iter().all(|done| done.missed == 0) && done[0].dabs + done[1].dabs > 25);
    // As on one sheet of both.
    let mut whole = object(&context, &centred_plane(8), 32, DAffine3::IDENTITY);
    assert_eq!(stroke.apply(&context, &mut whole).unwrap().dabs, 25);
    let sheet: Vec<_> = texels(&context, &whole);
    let mut seen = 0;
    for object in &objects {
        for (tile, at, p) in texels(&context, object) {
            let world = object.transform().transform_point3(p);
            let (i, j) = (((world.x + 4.0) * 32.0) as usize, ((world.y + 4.0) * 32.0) as usize);
            let (other, place, q) = &sheet[(i / 32 + j / 32 * 8) * 1024 + i % 32 + j % 32 * 32];
            assert!(q.distance(world) < 1e-5);
            // Beside the seam the sheets end and their rings repeat.
            let (found, expected) = (height(object, tile, at), height(&whole, *other, *place));
            assert!((found - expected).abs() < 1e-3, "{world}: {found} {expected}");
            seen += u32::from(found != 0.0);
        }
    }
    assert!(seen > 4000);
    // Beyond reach of both.
    let far = line(&[[0.0, 0.0, 2.0]], settings, sculpt(SculptMode::Draw, 0.1));
    let [a, b] = &mut objects;
    let done = far.apply_all(&context, &mut [a, b]).unwrap();
    assert!(done.iter().all(|done| (done.dabs, done.missed) == (0, 1)));
}

#[test]
fn a_stroke_that_is_drawn_bit_by_bit_is_the_whole_stroke() {
    let context = Context::serial();
    let mesh = centred_plane(4);
    let points: Vec<StrokePoint> = (0..40)
        .map(|k| {
            // At first the hand rests, later it turns.
            let t = 0.1 * f64::from((k - 4i32).max(0));
            let position = DVec3::new(t - 1.7, (2.0 * t).sin(), 0.02);
            StrokePoint { time: Some(0.05 * f64::from(k)), ..StrokePoint::new(position, 0.3 + 0.01 * f64::from(k)) }
        })
        .collect();
    let base = StrokeSettings {
        radius: 0.3,
        size_pressure: 0.5,
        jitter_position: 0.2,
        jitter_angle: 1.0,
        symmetry_y: Switch::ON,
        ..Default::default()
    };
    let cases = [
        base,
        StrokeSettings { rate: 30.0, ..base },
        StrokeSettings { string: 0.4, ..base },
        StrokeSettings { string: 0.4, rate: 30.0, ..base },
    ];
    for (case, settings) in cases.into_iter().enumerate() {
        for action in [
            Action::Paint { mode: PaintMode::Mix, color: [0.9, 0.1, 0.1, 1.0] },
            Action::Sculpt { mode: SculptMode::Draw, height: 0.1 },
            Action::Sculpt { mode: SculptMode::Smooth, height: 0.0 },
        ] {
            let stroke = Stroke::new(points.clone(), settings, Falloff::Smooth, action);
            let mut whole = object(&context, &mesh, 32, DAffine3::IDENTITY);
            let report = stroke.apply(&context, &mut whole).unwrap();
            let mut drawn = object(&context, &mesh, 32, DAffine3::IDENTITY);
            let begun = Stroke { points: Vec::new(), ..stroke };
            let mut open = OpenStroke::begin(&context, begun, &mut [&mut drawn]).unwrap();
            let mut dabs = 0;
            for part in points[..37].chunks(case + 1) {
                dabs += open.extend(&context, &mut [&mut drawn], part).unwrap()[0].dabs;
            }
            assert!(dabs > 5, "{dabs}");
            dabs += open.end(&context, &mut [&mut drawn], &points[37..]).unwrap()[0].dabs;
            assert_eq!(dabs, report.dabs);
            for tile in 0..16 {
                assert_eq!(drawn.displacement().field().block(tile), whole.displacement().field().block(tile));
                assert_eq!(drawn.paint().unwrap().field().block(tile), whole.paint().unwrap().field().block(tile));
            }
        }
    }
}

#[test]
fn strokes_that_are_drawn_are_checked_as_they_come() {
    let context = Context::serial();
    let mesh = centred_plane(2);
    let mut plate = object(&context, &mesh, 16, DAffine3::IDENTITY);
    let mut other = object(&context, &mesh, 16, DAffine3::IDENTITY);
    let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.1 };
    let stroke = Stroke::new(Vec::new(), StrokeSettings::default(), Falloff::Smooth, action);
    let bad = Stroke { settings: StrokeSettings { radius: f32::NAN, ..Default::default() }, ..stroke.clone() };
    assert!(OpenStroke::begin(&context, bad, &mut [&mut plate]).is_err());
    let mut open = OpenStroke::begin(&context, stroke, &mut [&mut plate]).unwrap();
    let nowhere = StrokePoint::new(DVec3::splat(f64::NAN), 1.0);
    assert!(open.extend(&context, &mut [&mut plate], &[nowhere]).is_err());
    assert!(open.extend(&context, &mut [&mut plate, &mut other], &[StrokePoint::new(DVec3::ZERO, 1.0)]).is_err());
    assert!(open.stroke().points.is_empty());
    assert!(open.clone().end(&context, &mut [&mut plate], &[]).is_err());
    // One point makes one dab, at the end.
    open.extend(&context, &mut [&mut plate], &[StrokePoint::new(DVec3::ZERO, 1.0)]).unwrap();
    assert_eq!(plate.displacement().bytes(), 0);
    assert_eq!(open.end(&context, &mut [&mut plate], &[]).unwrap()[0].dabs, 1);
    assert!(plate.displacement().bytes() > 0);
}

#[test]
fn smearing_carries_an_edge_along_and_changes_nothing_that_is_even() {
    let context = Context::serial();
    let smear = Action::Paint { mode: PaintMode::Smear, color: [0.0; 4] };
    let settings = StrokeSettings { radius: 0.4, spacing: 0.25, ..Default::default() };
    let stroke = line(&[[-1.5, 0.05, 0.0], [1.5, 0.05, 0.0]], settings, smear);
    // Nothing painted: nothing changes and nothing is allocated.
    let mut even = object(&context, &centred_plane(4), 32, DAffine3::IDENTITY);
    let done = stroke.apply(&context, &mut even).unwrap();
    assert_eq!((done.report.changed_texels, even.paint().unwrap().bytes()), (0, 0));
    // The left half red: red is drawn over into the right one, less and less, and stays beside the stroke.
    let runs = [1, 2].map(|threads| {
        let context = Context::new(&relievo_core::ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut object = object(&context, &centred_plane(4), 32, DAffine3::IDENTITY);
        let half = Brush::new(DVec3::new(-2.0, 0.0, 0.0), DMat3::IDENTITY, DVec3::splat(2.0), Falloff::Constant);
        let red = Action::Paint { mode: PaintMode::Mix, color: [1.0, 0.0, 0.0, 1.0] };
        Dab { brush: half.unwrap(), action: red, strength: 1.0 }.apply(&context, &mut object).unwrap();
        stroke.apply(&context, &mut object).unwrap();
        let places = texels(&context, &object);
        places.into_iter().map(|(tile, at, p)| (p, color(&object, tile, at))).collect::<Vec<_>>()
    });
    assert_eq!(runs[0], runs[1]);
    let redness = |x: f64, y: f64| {
        let near = runs[0].iter().min_by(|a, b| {
            let far = |p: &DVec3| p.truncate().distance(DVec2::new(x, y));
            far(&a.0).total_cmp(&far(&b.0))
        });
        near.unwrap().1.x - near.unwrap().1.y
    };
    assert!(redness(-1.0, 0.05) > 0.95 && redness(0.1, 0.05) > 0.5);
    let along: Vec<f32> = (1..8).map(|k| redness(0.1 * f64::from(k), 0.05)).collect();
    assert!(along.windows(2).all(|pair| pair[1] <= pair[0] + 0.02), "{along:?}");
    assert!(redness(0.2, 0.6) < 1e-3 && redness(1.8, 0.05) < 0.2);
}
