//! Dabs and strokes against closed forms, against every texel looked at one by one, and against themselves.

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{
    Action, Brush, Dab, DisplacedObject, Falloff, PaintMode, SculptMode, Stroke, StrokePoint, StrokeSettings,
};
use relievo_surface::{Grid, Place, Placement, RingClass, Surface, SurfaceOptions};
use relievo_tiles::{Channel, ChannelOptions, ColorTexel, Displaced, Displacement, Paint, Points, Rgba8, Texel};

use crate::shapes::{cube, painted, plane};

const BLANK: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);
const RED: [f32; 4] = [0.8, 0.05, 0.02, 1.0];

fn object(context: &Context, mesh: &Mesh, size: u32, transform: DAffine3) -> DisplacedObject {
    painted(context, mesh, size, BLANK, transform)
}

fn brush(center: DVec3, half: DVec3, falloff: Falloff) -> Brush {
    Brush::new(center, DMat3::IDENTITY, half, falloff).unwrap()
}

fn paint(mode: PaintMode) -> Action {
    Action::Paint { mode, color: RED }
}

fn sculpt(mode: SculptMode, height: f32) -> Action {
    Action::Sculpt { mode, height }
}

/// Tile, texel index in the block, and displaced place in the world of every texel of a channel.
fn texels<T: Texel>(context: &Context, object: &DisplacedObject, channel: &Channel<T>) -> Vec<(u32, usize, DVec3)> {
    let displaced = Displaced::new(object.surface(), object.displacement().field()).unwrap();
    let mut list = Vec::new();
    for tile in 0..channel.field().tile_count() as u32 {
        let size = channel.field().size(tile);
        let mut points = Points::default();
        displaced.grid(context, tile, &Grid::whole(size, Placement::Centred), &mut points).unwrap();
        for (k, p) in points.p.iter().enumerate() {
            let [i, j] = [k % size as usize, k / size as usize];
            let world = object.transform().transform_point3(DVec3::from(p.map(f64::from)));
            list.push((tile, (j + 1) * (size as usize + 2) + i + 1, world));
        }
    }
    list
}

fn blocks<T: Texel>(channel: &Channel<T>) -> Vec<Option<Vec<u8>>> {
    (0..channel.field().tile_count() as u32).map(|tile| channel.read(tile).unwrap()).collect()
}

#[test]
fn a_dab_of_draw_on_a_plane_has_the_profile_and_the_volume_of_its_falloff() {
    let context = Context::serial();
    let (center, radius, height) = (DVec3::new(4.03, 3.98, 0.0), 1.7, 0.25);
    let rim = (-4.5f64).exp();
    let volumes = [4.0, 1.0 / 3.0, 0.3, 2.0 / 3.0, (2.0 / 9.0 * (1.0 - rim) - rim) / (1.0 - rim)];
    assert_eq!(volumes.len(), Falloff::NAMES.len());
    for ((falloff, name), volume) in Falloff::NAMES.into_iter().zip(volumes) {
        let mut object = object(&context, &plane(8), 64, DAffine3::IDENTITY);
        let places = texels(&context, &object, object.displacement());
        let dab = Dab {
            brush: brush(center, DVec3::splat(radius), falloff),
            action: sculpt(SculptMode::Draw, height),
            strength: 0.5,
        };
        let report = dab.apply(&context, &mut object).unwrap();
        assert!(report.refused.is_empty() && report.changed_texels > 1000);
        let field = object.displacement().field();
        let mut sum = 0.0;
        for (tile, at, p) in &places {
            let found = field.block(*tile).map_or(0.0, |block| block[*at].to_f32());
            let place = ((*p - center) / radius).as_vec3().to_array();
            let expected = 0.5 * height * falloff.share(place);
            // Next to the rim of the box rounding decides.
            let rim = falloff == Falloff::Constant && place.iter().any(|x| (x.abs() - 1.0).abs() < 1e-4);
            assert!(rim || (found - expected).abs() < 2e-4 * height, "{name} at {p}: {found} {expected}");
            sum += f64::from(found) / (64.0 * 64.0);
        }
        let area = if falloff == Falloff::Constant { 1.0 } else { std::f64::consts::PI };
        let expected = 0.5 * f64::from(height) * radius * radius * area * volume;
        assert!((sum - expected).abs() < 0.01 * expected, "{name}: {sum} {expected}");
    }
}

#[test]
fn paint_mixes_adds_multiplies_and_erases_by_the_falloff() {
    let context = Context::serial();
    let center = DVec3::new(2.1, 1.9, 0.1);
    let color = Vec4::from(RED);
    for (mode, name) in PaintMode::NAMES {
        let mut object = object(&context, &plane(4), 32, DAffine3::IDENTITY);
        let fill = Dab {
            brush: brush(center, DVec3::splat(3.2), Falloff::Linear),
            action: paint(PaintMode::Mix),
            strength: 0.5,
        };
        fill.apply(&context, &mut object).unwrap();
        let before = object.paint().unwrap().field().clone();
        let dab = Dab { brush: brush(center, DVec3::splat(1.2), Falloff::Smooth), action: paint(mode), strength: 0.8 };
        dab.apply(&context, &mut object).unwrap();
        let field = object.paint().unwrap().field();
        for (tile, at, p) in texels(&context, &object, object.paint().unwrap()) {
            let block = before.block(tile).unwrap();
            let old = block[at].color();
            let mean = 0.25 * [at - 34, at - 1, at + 1, at + 34].map(|at| block[at].color()).iter().sum::<Vec4>();
            let found = field.block(tile).unwrap()[at];
            let share = 0.8 * Falloff::Smooth.share(((p - center) / 1.2).as_vec3().to_array());
            let rgb = match mode {
                PaintMode::Mix => old + (color - old) * share,
                PaintMode::Add => old + color * share,
                PaintMode::Multiply => old * (Vec4::ONE + (color - Vec4::ONE) * share),
                PaintMode::Erase => old + (BLANK - old) * share,
                PaintMode::Blur => old + (mean - old) * share,
                // A single dab carries nothing yet.
                PaintMode::Smear => old,
            };
            let alpha = if matches!(mode, PaintMode::Add | PaintMode::Multiply) { old.w } else { rgb.w };
            let expected = Rgba8::of_color(rgb.truncate().extend(alpha));
            let off = found.0.iter().zip(expected.0).map(|(a, b)| a.abs_diff(b)).max();
            // Half way between two bytes rounding decides.
            assert!(off <= Some(1), "{name} at {p}: {found:?} {expected:?}");
        }
    }
}

#[test]
fn a_dab_changes_every_texel_in_its_box_and_no_other() {
    let context = Context::serial();
    let transform = DAffine3::from_translation(DVec3::new(3.0, -1.0, 2.0))
        * DAffine3::from_rotation_y(0.7)
        * DAffine3::from_scale(DVec3::new(1.5, 1.0, 0.8));
    let mut object = object(&context, &cube(1.0), 32, transform);
    // Bumps first, so that boxes must be met by the displaced surface.
    let raise = |object: &mut DisplacedObject, aim: DVec3, height: f32| {
        let center = transform.transform_point3(aim);
        let dab = Dab {
            brush: brush(center, DVec3::splat(0.8), Falloff::Smooth),
            action: sculpt(SculptMode::Draw, height),
            strength: 1.0,
        };
        dab.apply(&context, object).unwrap()
    };
    assert!(raise(&mut object, DVec3::new(0.6, 0.1, 0.3), 0.7).changed.len() > 1);
    raise(&mut object, DVec3::new(-0.5, 0.4, -0.4), -0.2);
    for k in 0..12 {
        let t = f64::from(k);
        let axes = DMat3::from_euler(glam::EulerRot::XYZ, t, 0.3 * t, 2.0 * t);
        let aim = DVec3::new((1.3 * t).sin(), (2.1 * t).cos(), (0.7 * t).sin()).normalize() * (0.5 + 0.06 * t);
        let center = transform.transform_point3(aim);
        let brush = Brush::new(center, axes, DVec3::new(0.4, 0.25, 0.3), Falloff::Constant).unwrap();
        let mut fresh = self::object(&context, &cube(1.0), 32, transform);
        let displacement = blocks(object.displacement());
        for (tile, bytes) in (0..).zip(&displacement) {
            fresh.displacement_mut().write(tile, bytes.as_deref()).unwrap();
        }
        let dab = Dab { brush: brush.clone(), action: paint(PaintMode::Mix), strength: 1.0 };
        let report = dab.apply(&context, &mut fresh).unwrap();
        let field = fresh.paint().unwrap().field();
        let red = Rgba8([231, 63, 39, 255]);
        let (mut inside, mut count) = (0, 0);
        for (tile, at, p) in texels(&context, &fresh, fresh.paint().unwrap()) {
            let place = brush.map().transform_point3(p).abs().max_element();
            let painted = field.block(tile).is_some_and(|block| block[at] != field.blank());
            count += u64::from(painted);
            inside += u64::from(place < 1.0);
            // Corners at the cube's vertices are averaged.
            let corner = field.block(tile).is_some_and(|block| painted && block[at] != red);
            assert!((place - 1.0).abs() < 1e-4 || corner || painted == (place < 1.0), "{k}: {place} {painted}");
        }
        assert!(count > 0 && count.abs_diff(inside) < 20 && report.changed_texels > 0, "{k}: {count} {inside}");
    }
}

#[test]
fn colours_meet_at_edges_and_extraordinary_points() {
    let context = Context::serial();
    let mut object = object(&context, &cube(1.0), 32, DAffine3::IDENTITY);
    for corner in cube(1.0).points {
        let center = 0.6 * DVec3::from(corner.map(f64::from));
        let brush = brush(center, DVec3::splat(0.5), Falloff::Smooth);
        Dab { brush, action: paint(PaintMode::Mix), strength: 1.0 }.apply(&context, &mut object).unwrap();
    }
    let field = object.paint().unwrap().field();
    let topology = field.topology();
    for ring in 0..topology.ring_count() as u32 {
        assert_eq!(topology.ring_class(ring), RingClass::Extraordinary);
        let colors: Vec<Vec4> = topology.ring(ring).iter().map(|entry| field.color(entry.place())).collect();
        assert!(colors.iter().all(|color| *color == colors[0]) && (colors[0].x - BLANK.x).abs() > 0.1, "{colors:?}");
    }
    for tile in 0..6 {
        for edge in 0..4 {
            for k in 0..=64 {
                let place = Place::on_edge(tile, edge, k as f32 / 64.0);
                let canonical = field.color(field.canonical(place));
                assert!((field.color(place) - canonical).abs().max_element() < 1e-5, "{place:?}");
            }
        }
    }
}

#[test]
fn erasing_all_gives_back_all_memory_and_untouched_tiles_stay() {
    let context = Context::serial();
    let mut object = object(&context, &plane(8), 16, DAffine3::IDENTITY);
    let everywhere = brush(DVec3::new(4.0, 4.0, 0.0), DVec3::splat(20.0), Falloff::Constant);
    for (draw, erase) in [
        (sculpt(SculptMode::Draw, 0.2), sculpt(SculptMode::Erase, 0.0)),
        (paint(PaintMode::Mix), paint(PaintMode::Erase)),
    ] {
        let bytes = |object: &DisplacedObject| [object.displacement().bytes(), object.paint().unwrap().bytes()];
        let all = |object: &DisplacedObject| (blocks(object.displacement()), blocks(object.paint().unwrap()));
        let start = all(&object);
        assert_eq!(bytes(&object), [0, 0]);
        let dab = |x: f64, action| Dab {
            brush: brush(DVec3::new(x, 3.0, 0.0), DVec3::splat(0.9), Falloff::Smooth),
            action,
            strength: 1.0,
        };
        let first = dab(2.0, draw).apply(&context, &mut object).unwrap();
        // Colours have mips of 8, 4 and 2 texels a side.
        let painted = matches!(draw, Action::Paint { .. });
        let tile = if painted { 4 * (18 * 18 + 10 * 10 + 6 * 6 + 4 * 4) } else { 2 * 18 * 18 };
        assert_eq!(first.allocated * tile, first.bytes);
        let before = all(&object);
        let second = dab(6.0, draw).apply(&context, &mut object).unwrap();
        let after = all(&object);
        for tile in 0..64u32 {
            let near = second.changed.iter().any(|changed| {
                let apart = |a: u32, b: u32| a.abs_diff(b) <= 1;
                apart(changed % 8, tile % 8) && apart(changed / 8, tile / 8)
            });
            let at = tile as usize;
            assert!(near || (&before.0[at], &before.1[at]) == (&after.0[at], &after.1[at]), "tile {tile}");
        }
        let report =
            Dab { brush: everywhere.clone(), action: erase, strength: 1.0 }.apply(&context, &mut object).unwrap();
        assert_eq!((report.bytes, report.freed), (0, first.allocated + second.allocated));
        assert_eq!((bytes(&object), all(&object)), ([0, 0], start));
    }
}

#[test]
fn flatten_smooth_and_erase_go_where_they_should() {
    let context = Context::serial();
    let raised = || {
        let mut object = object(&context, &plane(4), 32, DAffine3::IDENTITY);
        for k in 0..9 {
            let center = DVec3::new(1.5 + 0.5 * f64::from(k % 3), 1.5 + 0.5 * f64::from(k / 3), 0.0);
            let height = 0.02 * (1 + k * 7 % 5) as f32;
            let brush = brush(center, DVec3::splat(0.3), Falloff::Smooth);
            Dab { brush, action: sculpt(SculptMode::Draw, height), strength: 1.0 }
                .apply(&context, &mut object)
                .unwrap();
        }
        object
    };
    let heights = |object: &DisplacedObject| -> Vec<f32> {
        let field = object.displacement().field();
        let list = texels(&context, object, object.displacement());
        list.iter().map(|(tile, at, _)| field.block(*tile).map_or(0.0, |block| block[*at].to_f32())).collect()
    };
    let everywhere = brush(DVec3::new(2.0, 2.0, 0.05), DVec3::splat(9.0), Falloff::Constant);
    let mut object = raised();
    let dab = |mode, strength| Dab { brush: everywhere.clone(), action: sculpt(mode, 0.0), strength };
    let before = object.displacement().field().clone();
    dab(SculptMode::Smooth, 1.0).apply(&context, &mut object).unwrap();
    let after = object.displacement().field().clone();
    for (tile, at, _) in texels(&context, &object, object.displacement()) {
        let (Some(old), Some(new)) = (before.block(tile), after.block(tile)) else { continue };
        let around = [at - 34, at - 1, at + 1, at + 34].map(|at| old[at].to_f32());
        assert!((new[at].to_f32() - 0.25 * around.iter().sum::<f32>()).abs() < 1e-4, "{tile} {at}");
    }
    let smooth = heights(&object);
    dab(SculptMode::Erase, 0.5).apply(&context, &mut object).unwrap();
    assert!(heights(&object).iter().zip(smooth).all(|(half, whole)| (half - 0.5 * whole).abs() < 1e-4));
    let mut object = raised();
    dab(SculptMode::Flatten, 1.0).apply(&context, &mut object).unwrap();
    assert!(heights(&object).iter().all(|height| (height - 0.05).abs() < 1e-4));
    // Scrape takes off what is over the plane at 0.05, clay fills up to the one at 0.05 + 0.02, or down to 0.05 - 0.02.
    let before = heights(&raised());
    for (mode, height) in [(SculptMode::Scrape, 0.0), (SculptMode::Clay, 0.02), (SculptMode::Clay, -0.02)] {
        let mut object = raised();
        let dab = Dab { brush: everywhere.clone(), action: sculpt(mode, height), strength: 0.5 };
        dab.apply(&context, &mut object).unwrap();
        for (old, new) in before.iter().zip(heights(&object)) {
            let far = 0.05 + height - old;
            let far = if mode == SculptMode::Clay && height > 0.0 { far.max(0.0) } else { far.min(0.0) };
            assert!((new - (old + 0.5 * far)).abs() < 1e-4, "{mode:?} {height}: {old} {new}");
        }
    }
}

#[test]
fn a_stroke_of_layer_is_the_height_by_the_largest_share_of_its_dabs() {
    let context = Context::serial();
    let mut object = object(&context, &plane(4), 64, DAffine3::IDENTITY);
    let places = texels(&context, &object, object.displacement());
    for (round, height) in [0.2f32, -0.1].into_iter().enumerate() {
        let before = object.displacement().field().clone();
        let stroke = Stroke::new(
            [1.0, 3.0].map(|x| StrokePoint::new(DVec3::new(x, 2.0, 0.1 * round as f64), 1.0)).to_vec(),
            StrokeSettings { radius: 0.5, spacing: 0.2, ..Default::default() },
            Falloff::Constant,
            sculpt(SculptMode::Layer, height),
        );
        assert!(stroke.apply(&context, &mut object).unwrap().dabs >= 20);
        let field = object.displacement().field();
        let mut covered = 0;
        for (tile, at, p) in &places {
            let [old, new] = [&before, field].map(|field| field.block(*tile).map_or(0.0, |block| block[*at].to_f32()));
            let inside = (p.y - 2.0).abs() < 0.49 && (0.52..3.35).contains(&p.x);
            let outside = (p.y - 2.0).abs() > 0.51 || !(0.45..3.55).contains(&p.x);
            covered += u32::from(inside);
            assert!(!inside || (new - old - height).abs() < 2e-4, "{p}: {old} {new}");
            assert!(!outside || new == old, "{p}: {old} {new}");
        }
        assert!(covered > 1000);
    }
}

#[test]
fn the_nearest_place_is_no_further_than_any_sample() {
    let context = Context::serial();
    let transform = DAffine3::from_rotation_z(0.4) * DAffine3::from_scale(DVec3::new(2.0, 1.0, 1.3));
    let mut object = object(&context, &cube(1.0), 32, transform);
    let raise = Dab {
        brush: brush(DVec3::new(1.0, 0.4, 0.3), DVec3::splat(0.7), Falloff::Smooth),
        action: sculpt(SculptMode::Draw, 0.2),
        strength: 1.0,
    };
    raise.apply(&context, &mut object).unwrap();
    let samples = texels(&context, &object, object.displacement());
    for k in 0..100 {
        let t = f64::from(k);
        let point = DVec3::new(2.0 * (1.7 * t).sin(), 1.2 * (0.9 * t).cos(), 1.1 * (2.3 * t).sin());
        let least = samples.iter().map(|(.., p)| p.distance(point)).fold(f64::INFINITY, f64::min);
        let found = object.nearest(&context, point, 10.0).unwrap().unwrap();
        assert!(found.distance < least + 1e-6, "{k}: {} {least}", found.distance);
        assert!((found.point.distance(point) - found.distance).abs() < 1e-12);
        // Where there is an outside, the way to the point is along the normal.
        let way = (point - found.point).normalize();
        let inner = [found.place.u, found.place.v].iter().all(|t| (0.01..0.99).contains(t));
        assert!(!inner || found.distance < 0.02 || way.dot(found.normal).abs() > 0.99, "{k}: {found:?}");
        assert!(object.nearest(&context, point, 0.5 * found.distance).unwrap().is_none());
    }
    assert!(object.nearest(&context, DVec3::splat(f64::NAN), 1.0).unwrap().is_none());
    assert!(object.nearest(&context, DVec3::ZERO, f64::INFINITY).unwrap().is_none());
}

fn spiral(action: Action) -> Stroke {
    let points = (0..60).map(|k| {
        let (a, z) = (0.35 * f64::from(k), f64::from(k) / 30.0 - 1.0);
        let r = (1.0 - z * z).max(0.0).sqrt();
        StrokePoint::new(DVec3::new(r * a.cos(), r * a.sin(), z), 0.3 + 0.01 * f64::from(k))
    });
    let settings = StrokeSettings { radius: 0.2, spacing: 0.4, size_pressure: 0.5, ..Default::default() };
    Stroke::new(points.collect(), settings, Falloff::Sphere, action)
}

#[test]
fn strokes_do_not_depend_on_the_number_of_threads() {
    let all = |threads: usize| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut object = object(&context, &cube(1.0), 32, DAffine3::IDENTITY);
        let reports = [sculpt(SculptMode::Draw, 0.05), paint(PaintMode::Mix), sculpt(SculptMode::Smooth, 0.0)]
            .map(|action| spiral(action).apply(&context, &mut object).unwrap());
        assert!(reports.iter().all(|report| report.dabs > 100 && report.missed == 0));
        (blocks(object.displacement()), blocks(object.paint().unwrap()), reports)
    };
    assert!(all(1) == all(2));
}

#[test]
fn strokes_off_the_mesh_do_nothing_and_hostile_ones_are_refused() {
    let context = Context::serial();
    let mut object = object(&context, &cube(1.0), 32, DAffine3::IDENTITY);
    let mut stroke = spiral(paint(PaintMode::Mix));
    stroke.points.iter_mut().for_each(|point| point.position.x += 50.0);
    let done = stroke.apply(&context, &mut object).unwrap();
    assert_eq!((done.dabs, done.report.bytes, object.paint().unwrap().bytes()), (0, 0, 0));
    assert!(done.missed > 100);
    stroke.points[7].pressure = f64::NAN;
    assert!(stroke.apply(&context, &mut object).is_err());
    for strength in [f32::NAN, -0.1, 1.1] {
        let brush = brush(DVec3::ZERO, DVec3::ONE, Falloff::Smooth);
        assert!(Dab { brush, action: paint(PaintMode::Mix), strength }.apply(&context, &mut object).is_err());
    }
    // A surface without colours cannot be painted, and colours of another surface are refused.
    let mesh = plane(2);
    let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
    let displacement = Displacement::new(surface.topology().clone(), &ChannelOptions::default()).unwrap();
    let foreign = Paint::of_color(object.surface().topology().clone(), BLANK, &ChannelOptions::default()).unwrap();
    let mut bare = DisplacedObject::new(&context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
    assert!(bare.set_paint(foreign).is_err());
    assert!(spiral(paint(PaintMode::Mix)).apply(&context, &mut bare).is_err());
    assert!(spiral(sculpt(SculptMode::Draw, 0.1)).apply(&context, &mut bare).is_ok());
}

#[test]
fn a_budget_refuses_tiles_and_says_which() {
    let context = Context::serial();
    let mesh = plane(4);
    let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = ChannelOptions { size: 16, budget: 18 * 18 * 2 * 3, ..ChannelOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let mut object = DisplacedObject::new(&context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
    let everywhere = brush(DVec3::new(2.0, 2.0, 0.0), DVec3::splat(9.0), Falloff::Constant);
    let dab = Dab { brush: everywhere.clone(), action: sculpt(SculptMode::Draw, 0.5), strength: 1.0 };
    let report = dab.apply(&context, &mut object).unwrap();
    assert_eq!((report.changed.len(), report.refused.len(), report.bytes), (3, 13, options.budget));
}

#[test]
fn a_stroke_of_draw_is_an_even_ridge_and_the_sum_of_its_dabs() {
    let context = Context::serial();
    let mut object = object(&context, &plane(4), 64, DAffine3::IDENTITY);
    let ends = [DVec3::new(1.0, 2.0, 0.0), DVec3::new(3.0, 2.0, 0.0)];
    let stroke = Stroke::new(
        ends.map(|position| StrokePoint::new(position, 1.0)).to_vec(),
        StrokeSettings { radius: 0.3, spacing: 0.2, ..Default::default() },
        Falloff::Smooth,
        sculpt(SculptMode::Draw, 0.2),
    );
    let done = stroke.apply(&context, &mut object).unwrap();
    assert_eq!((done.dabs, done.missed), (34, 0));
    let field = object.displacement().field();
    let mut highest = 0.0f64;
    for (tile, at, p) in
        texels(&context, &self::object(&context, &plane(4), 64, DAffine3::IDENTITY), object.displacement())
    {
        let found = field.block(tile).map_or(0.0, |block| f64::from(block[at].to_f32()));
        let shares = stroke
            .stations()
            .unwrap()
            .into_iter()
            .map(|station| f64::from(Falloff::Smooth.share(((p - station.position) / 0.3).as_vec3().to_array())));
        let expected = 0.2 * shares.sum::<f64>();
        // Each dab is rounded to half floats.
        assert!((found - expected).abs() < 4e-3, "{p}: {found} {expected}");
        highest = highest.max(found);
    }
    // Higher than the brush is deep, which would have stopped it if it had looked at what it raised.
    assert!(highest > 0.9, "{highest}");
}
