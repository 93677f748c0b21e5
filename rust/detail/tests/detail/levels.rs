//! Dabs at coarser levels: what they add is the same over detail as over nothing, and detail stays.

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{Action, Brush, Dab, DisplacedObject, Falloff, PaintMode, SculptMode};
use relievo_surface::{Place, Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displacement, Paint};

fn object(context: &Context) -> DisplacedObject {
    let points = (0..25).map(|i| [(i % 5) as f32, (i / 5) as f32, 0.0]).collect();
    let face = |i: u32| [i, i + 1, i + 6, i + 5];
    let corners = (0..4).flat_map(|y| (0..4).flat_map(move |x| face(5 * y + x))).collect();
    let mesh = Mesh::new(points, vec![4; 16], corners);
    let surface = Surface::new(context, &mesh, &SurfaceOptions::default()).unwrap();
    let options = ChannelOptions { size: 32, ..ChannelOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let paint = Paint::of_color(surface.topology().clone(), Vec4::new(0.2, 0.2, 0.2, 1.0), &options).unwrap();
    let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
    object.set_paint(paint).unwrap();
    object
}

fn dab(center: DVec3, half: f64, falloff: Falloff, action: Action) -> Dab {
    let brush = Brush::new(center, DMat3::IDENTITY, DVec3::new(half, half, 3.0), falloff).unwrap();
    Dab { brush, action, strength: 1.0 }
}

#[test]
fn a_coarse_dab_adds_the_same_over_detail_as_over_nothing() {
    let context = Context::serial();
    let detail = |object: &mut DisplacedObject| {
        for k in 0..8 {
            let at = DVec3::new(1.2 + 0.2 * f64::from(k), 1.6 + 0.1 * f64::from(k), 0.0);
            let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.05 };
            dab(at, 0.08, Falloff::Smooth, action).apply(&context, object).unwrap();
        }
    };
    let hill =
        dab(DVec3::new(2.1, 1.9, 0.0), 1.3, Falloff::Smooth, Action::Sculpt { mode: SculptMode::Draw, height: 0.5 });
    for level in [1, 2] {
        let [mut both, mut fine, mut coarse] = [(); 3].map(|()| object(&context));
        detail(&mut both);
        detail(&mut fine);
        let report = hill.apply_at(&context, &mut both, level).unwrap();
        hill.apply_at(&context, &mut coarse, level).unwrap();
        assert!(report.changed.len() >= 9 && report.refused.is_empty());
        assert_eq!(coarse.displacement().field().size(5), 32 >> level, "what was not edited gets what the level asks");
        assert_eq!(both.displacement().field().size(5), 32);
        let mut sharpest = 0f32;
        for k in 0..4000u32 {
            let part = |factor: u32| k.wrapping_mul(factor) as f32 / u32::MAX as f32;
            let place = Place::new(k % 16, part(3_242_174_889), part(2_447_445_413));
            let [a, b, c] = [&both, &fine, &coarse].map(|object| {
                let field = object.displacement().field();
                field.point(context.level(), field.canonical(place))
            });
            // Shares depend on where the surface is, which detail moves a little.
            assert!((a.d - b.d - c.d).abs() < 0.02, "level {level} {place:?}: {} {} {}", a.d, b.d, c.d);
            sharpest = sharpest.max((a.duu - c.duu).abs());
        }
        assert!(sharpest > 5.0, "the detail is there: {sharpest}");
    }
}

#[test]
fn a_coarse_tint_lies_over_what_was_painted_and_levels_end() {
    let context = Context::serial();
    let mut object = object(&context);
    let paint = |color: [f32; 4], mode: PaintMode| Action::Paint { mode, color };
    let dot = dab(DVec3::new(2.5, 2.5, 0.0), 0.05, Falloff::Constant, paint([0.9, 0.0, 0.0, 1.0], PaintMode::Mix));
    dot.apply(&context, &mut object).unwrap();
    let tint = dab(DVec3::new(2.5, 2.5, 0.0), 1.0, Falloff::Constant, paint([0.0, 0.25, 0.0, 0.0], PaintMode::Add));
    tint.apply_at(&context, &mut object, 2).unwrap();
    let color = |u: f32| object.paint().unwrap().field().color(Place::new(10, u, 0.5));
    let (inside, outside) = (color(0.5), color(0.8));
    assert!((inside - outside).x > 0.4 && (outside - Vec4::new(0.2, 0.45, 0.2, 1.0)).abs().max_element() < 0.02);
    assert!((inside.y - 0.25).abs() < 0.05, "{inside}");
    assert!(tint.apply_at(&context, &mut object, 3).is_err());
}
