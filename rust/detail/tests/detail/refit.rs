//! Boxes that follow displacement: whatever was edited, and by whom, a brush finds every texel in its box and no other.

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Brush, Dab, DisplacedObject, Falloff, PaintMode, SculptMode, Stroke, StrokePoint, StrokeSettings,
};
use relievo_surface::{Grid, Placement, Surface, SurfaceOptions};
use relievo_tiles::{ChannelOptions, Displacement, Paint, Points};

/// A closed ring of `n` × `n` faces, radii 2 and 1.
fn torus(n: u32) -> Mesh {
    let point = |k: u32| {
        let [a, b] = [k % n, k / n].map(|k| std::f32::consts::TAU * k as f32 / n as f32);
        [(2.0 + b.cos()) * a.cos(), (2.0 + b.cos()) * a.sin(), b.sin()]
    };
    let corner = |i: u32, j: u32| i % n + j % n * n;
    let corners = (0..n * n).flat_map(|k| {
        let (i, j) = (k % n, k / n);
        [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]
    });
    Mesh::new((0..n * n).map(point).collect(), vec![4; (n * n) as usize], corners.collect())
}

const SIDE: u32 = 10;
const SIZE: u32 = 8;

/// Numbers from 0 to 1 that look random.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    fn brush(&mut self, most: f64) -> Brush {
        let a = self.between(0.0, std::f64::consts::TAU);
        let r = self.between(0.8, 3.6);
        let center = DVec3::new(r * a.cos(), r * a.sin(), self.between(-1.5, 1.5));
        let axes = DMat3::from_euler(glam::EulerRot::XYZ, self.between(0.0, 6.0), self.between(0.0, 6.0), 1.0);
        let half = DVec3::new(self.between(0.1, most), self.between(0.1, most), self.between(0.1, most));
        Brush::new(center, axes, half, Falloff::Constant).unwrap()
    }
}

fn object(context: &Context, mesh: &Mesh) -> DisplacedObject {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
    let options = ChannelOptions { size: SIZE, ..ChannelOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    DisplacedObject::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap()
}

/// Paints a fresh coat in the box and compares with every texel looked at. Returns how many there are.
fn probe(context: &Context, object: &mut DisplacedObject, brush: &Brush) -> usize {
    let options = ChannelOptions { size: SIZE, ..ChannelOptions::default() };
    let mut coat =
        Paint::<relievo_tiles::Rgba8>::of_color(object.surface().topology().clone(), Vec4::ZERO, &options).unwrap();
    let action = Action::Paint { mode: PaintMode::Mix, color: [1.0; 4] };
    Dab { brush: brush.clone(), action, strength: 1.0 }.apply_to(context, object, &mut coat).unwrap();
    let (mut points, mut inside) = (Points::default(), 0);
    for tile in 0..coat.field().tile_count() as u32 {
        let displaced = object.displaced().unwrap();
        displaced.grid(context, tile, &Grid::whole(SIZE, Placement::Centred), &mut points).unwrap();
        for (k, p) in points.p.iter().enumerate() {
            let at = (k as u32 / SIZE + 1) * (SIZE + 2) + k as u32 % SIZE + 1;
            let far = brush.map().transform_point3(DVec3::from(p.map(f64::from))).abs().max_element();
            let painted = coat.field().block(tile).is_some_and(|block| block[at as usize] != coat.field().blank());
            assert!((far - 1.0).abs() < 1e-4 || painted == (far < 1.0), "tile {tile} texel {k}: {far} {painted}");
            inside += usize::from(far < 1.0);
        }
    }
    inside
}

#[test]
fn nothing_is_missed_whoever_edited() {
    let context = Context::serial();
    let mesh = torus(SIDE);
    let mut object = object(&context, &mesh);
    let mut chance = Chance(11);
    let mut found = 0;
    let mut kept = Vec::new();
    for round in 0..120 {
        let brush = chance.brush(0.8);
        let height = chance.between(-0.6, 0.9) as f32;
        let sculpt = |mode| Dab { brush: brush.clone(), action: Action::Sculpt { mode, height }, strength: 1.0 };
        match round % 10 {
            0..4 => drop(sculpt(SculptMode::Draw).apply(&context, &mut object).unwrap()),
            4 => drop(sculpt(SculptMode::Smooth).apply(&context, &mut object).unwrap()),
            5 => drop(sculpt(SculptMode::Erase).apply(&context, &mut object).unwrap()),
            6 => {
                // A stroke, whose dabs go by the surface as it was when it began.
                let points = (0..4).map(|_| StrokePoint::new(chance.brush(1.0).obb().center, 1.0)).collect();
                let settings = StrokeSettings { radius: 0.4, reach: 9.0, ..Default::default() };
                let action = Action::Sculpt { mode: SculptMode::Draw, height: 0.1 };
                Stroke::new(points, settings, Falloff::Smooth, action).apply(&context, &mut object).unwrap();
            }
            7 => {
                // Somebody else puts tiles back as they were.
                let tiles = 0..object.displacement().field().tile_count() as u32;
                let now: Vec<_> = tiles.map(|tile| object.displacement().read(tile).unwrap()).collect();
                let then = std::mem::replace(&mut kept, now);
                for (tile, bytes) in (0..).zip(&then) {
                    object.displacement_mut().write(tile, bytes.as_deref()).unwrap();
                }
            }
            8 => {
                let scale = chance.between(0.9, 1.1) as f32;
                let cage: Vec<[f32; 3]> = mesh.points.iter().map(|p| [p[0] * scale, p[1], p[2] / scale]).collect();
                object.pose(&context, &cage).unwrap();
            }
            _ => {
                let everywhere =
                    Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(9.0), Falloff::Constant).unwrap();
                let action = Action::Sculpt { mode: SculptMode::Erase, height: 0.0 };
                Dab { brush: everywhere, action, strength: 0.7 }.apply(&context, &mut object).unwrap();
            }
        }
        for _ in 0..3 {
            let brush = chance.brush(0.7);
            found += probe(&context, &mut object, &brush);
        }
    }
    assert!(found > 5000, "{found}");
}

#[test]
fn a_deep_edit_elsewhere_costs_a_dab_nothing() {
    let context = Context::serial();
    let mut object = object(&context, &torus(40));
    let at = |x: f64, half: f64| {
        Brush::new(DVec3::new(x, 0.0, 0.0), DMat3::IDENTITY, DVec3::splat(half), Falloff::Constant).unwrap()
    };
    let dab = |x: f64, mode, height| Dab { brush: at(x, 0.3), action: Action::Sculpt { mode, height }, strength: 1.0 };
    let near = |object: &DisplacedObject| object.tiles_near(&context, at(3.0, 0.3).obb()).len();
    let before = dab(3.0, SculptMode::Draw, 0.01).apply(&context, &mut object).unwrap().tested_tiles;
    let found = near(&object);
    // A spike as high as the whole ring is wide.
    dab(-3.0, SculptMode::Draw, 6.0).apply(&context, &mut object).unwrap();
    assert_eq!(near(&object), found);
    let after = dab(3.0, SculptMode::Draw, 0.01).apply(&context, &mut object).unwrap().tested_tiles;
    assert!(after <= before + 2, "{after} {before}");
    // And when it is erased nothing of it is left.
    let all = Brush::new(DVec3::ZERO, DMat3::IDENTITY, DVec3::splat(20.0), Falloff::Constant).unwrap();
    let erase = Action::Sculpt { mode: SculptMode::Erase, height: 0.0 };
    Dab { brush: all, action: erase, strength: 1.0 }.apply(&context, &mut object).unwrap();
    let beyond = at(-6.0, 1.0);
    assert!(object.tiles_near(&context, beyond.obb()).is_empty());
}
