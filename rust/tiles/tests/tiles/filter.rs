//! Mips and filtered colour: made anew or step by step alike, continuous across any edges, and means of what they
//! cover.

use std::sync::Arc;

use glam::{Vec2, Vec4};
use proptest::prelude::*;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_surface::{Link, Place, Side, TileTopology};
use relievo_testing::{Random, grid};
use relievo_tiles::{Channel, ChannelOptions, ColorTexel, Field, Rgba8, Rgba16, Sets, Texel};

const BLANK: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);

fn channel<T: ColorTexel>(mesh: &Mesh, options: &ChannelOptions) -> Channel<T> {
    Channel::of_color(Arc::new(TileTopology::new(mesh).unwrap()), BLANK, options).unwrap()
}

/// Random rectangles in some tiles.
fn stroke<T: ColorTexel>(channel: &mut Channel<T>, context: &Context, random: &mut Random) {
    let count = channel.field().tile_count();
    let mut tiles: Vec<u32> = (0..1 + random.below(4)).map(|_| random.below(count) as u32).collect();
    tiles.sort_unstable();
    tiles.dedup();
    channel.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    tiles.retain(|tile| channel.field().is_allocated(*tile));
    let seed = random.below(1 << 30) as u64;
    let changes = channel.edit(context, &tiles, |tile, texels| {
        let mut random = Random(seed ^ u64::from(tile) << 20);
        let (from, to) = (random.below(texels.size()), random.below(texels.size()));
        for j in from.min(to)..=from.max(to) {
            let any = || T::of_color(Vec4::new(random.unit(), random.unit(), random.unit(), random.unit()));
            texels.row_mut(j)[from.min(to)..].fill_with(any);
        }
    });
    channel.settle(context, &changes.unwrap()).unwrap();
}

/// All levels of all tiles.
fn levels<T: Texel>(field: &Field<T>) -> Vec<Vec<u8>> {
    let of = |tile: u32| (0..8).filter_map(move |level| Some(bytemuck::cast_slice(field.level(tile, level)?).to_vec()));
    (0..field.tile_count() as u32).flat_map(of).collect()
}

/// What lies across a side at `t`, and how much longer parameters are there.
fn across(topology: &TileTopology, tile: u32, edge: u8, t: f32) -> Option<(Place, f32)> {
    let turn = |reversed: bool| if reversed { t } else { 1.0 - t };
    let (side, s, scale): (Side, f32, f32) = match topology.link(tile, edge) {
        Link::Whole { side, reversed } => (side, turn(reversed), 1.0),
        Link::Half { side, second, reversed } => (side, turn(reversed) / 2.0 + if second { 0.5 } else { 0.0 }, 0.5),
        _ => return None,
    };
    Some((Place::on_edge(side.tile, side.edge, s), scale))
}

fn square(width: f32) -> [[f32; 2]; 2] {
    [[width, 0.0], [0.0, width]]
}

/// Compares both sides of every edge, and the tile just beside it, at several widths; and look-ups of many with single
/// ones.
fn check<T: ColorTexel>(field: &Field<T>) {
    let topology = field.topology();
    many_are_as_one_by_one(field);
    for tile in 0..topology.tile_count() as u32 {
        for edge in 0..4 {
            for t in [0.0f32, 0.03, 0.2, 0.46, 0.5, 0.77, 0.99, 1.0] {
                let Some((there, scale)) = across(topology, tile, edge, t) else { continue };
                let here = Place::on_edge(tile, edge, t);
                for width in [0.0, 0.05, 0.12, 0.3, 0.9] {
                    let a = field.filtered(here, square(width));
                    let b = field.filtered(there, square(width * scale));
                    let difference = (a - b).abs().max_element();
                    assert!(difference < 1e-4, "{here:?} {there:?} width {width}: {a} {b}");
                    let inward = |x: f32, across: bool| if across { x + (0.5 - x).signum() * 1e-5 } else { x };
                    let beside = Place::new(tile, inward(here.u, edge & 1 == 1), inward(here.v, edge & 1 == 0));
                    let c = field.filtered(beside, square(width));
                    assert!((a - c).abs().max_element() < 2e-2, "{here:?} {beside:?} width {width}: {a} {c}");
                }
            }
        }
    }
}

/// Places inside and beyond tiles, with footprints of every shape and none.
fn many_are_as_one_by_one<T: ColorTexel>(field: &Field<T>) {
    let mut random = Random(7);
    let count = 203;
    let places: Vec<Place> = (0..count)
        .map(|_| {
            let tile = random.below(field.tile_count()) as u32;
            Place::new(tile, 1.2 * random.unit() - 0.1, 1.2 * random.unit() - 0.1)
        })
        .filter(|place| !field.topology().is_hole(place.tile))
        .collect();
    let footprints: Vec<[[f32; 2]; 2]> = (0..places.len())
        .map(|k| {
            let width = 0.5f32.powi(random.below(9) as i32);
            match k % 4 {
                0 => [[width, 0.3 * width * random.unit()], [0.0, width]],
                1 if k % 8 == 1 => [[f32::NAN, 0.0], [0.0, 0.0]],
                _ => square(width * random.unit()),
            }
        })
        .collect();
    let mut colors = vec![Vec4::splat(f32::NAN); places.len()];
    field.filtered_many(&places, &footprints, &mut colors);
    for ((place, footprint), color) in places.iter().zip(&footprints).zip(colors) {
        let bits = |color: Vec4| color.to_array().map(f32::to_bits);
        assert_eq!(bits(color), bits(field.filtered(*place, *footprint)), "{place:?} {footprint:?}");
    }
}

fn exercise<T: ColorTexel>(
    mesh: &Mesh,
    sizes: &[(u32, u32)],
    seed: u64,
    tight: bool,
    context: &Context,
) -> Vec<Vec<u8>> {
    let faces = mesh.face_count() as u32;
    let face_sizes: Vec<(u32, u32)> = sizes.iter().map(|(face, log)| (face % faces, 1 << log)).collect();
    let budget = if tight { 40_000 } else { 1 << 30 };
    let options = ChannelOptions { size: 16, face_sizes, budget };
    let mut one: Channel<T> = channel(mesh, &options);
    let mut random = Random(seed);
    for step in 0..4 {
        stroke(&mut one, context, &mut random);
        if step == 2 {
            let gone: Vec<u32> = one.field().allocated().step_by(3).collect();
            let applied = one.apply(&Sets { deallocate: gone, ..Sets::default() }).unwrap();
            one.settle(context, &applied.changes).unwrap();
        }
        let field = one.field();
        let in_use: u64 = field.allocated().map(|tile| field.tile_bytes(tile)).sum();
        assert_eq!((one.bytes(), one.bytes() <= budget), (in_use, true));
        let lengths: usize = levels(field).iter().map(Vec::len).sum();
        assert_eq!(lengths as u64, in_use, "the formula is what is held");
        // Made anew from the tiles alone.
        let mut two: Channel<T> = channel(mesh, &options);
        for tile in 0..field.tile_count() as u32 {
            two.write(tile, one.read(tile).unwrap().as_deref()).unwrap();
        }
        two.update_mips(context);
        assert!(levels(two.field()) == levels(one.field()), "step {step}");
        check(one.field());
    }
    levels(one.field())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..Default::default() })]

    #[test]
    fn mips_are_those_made_anew_and_colour_is_continuous_at_any_width(
        size in 2u32..5, torus: bool, choices in prop::collection::vec(any::<u8>(), 1..40), seed: u64, tight: bool,
        sizes in prop::collection::vec((any::<u32>(), 3u32..7), 0..6),
    ) {
        let mesh = grid(if torus { size + 1 } else { size }, torus, &choices, true);
        let eight = exercise::<Rgba8>(&mesh, &sizes, seed, tight, &Context::serial());
        exercise::<Rgba16>(&mesh, &sizes, seed, tight, &Context::serial());
        let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
        prop_assert_eq!(exercise::<Rgba8>(&mesh, &sizes, seed, tight, &context), eight);
    }
}

#[test]
fn a_snapshot_keeps_its_mips_while_the_channel_goes_on() {
    let (mesh, context) = (grid(4, true, &[2, 1, 0], true), Context::serial());
    let mut paint: Channel<Rgba8> = channel(&mesh, &ChannelOptions { size: 32, ..ChannelOptions::default() });
    let mut random = Random(5);
    stroke(&mut paint, &context, &mut random);
    let snapshot = paint.commit();
    let before = levels(&snapshot);
    (0..5).for_each(|_| stroke(&mut paint, &context, &mut random));
    assert!(levels(&snapshot) == before && levels(paint.field()) != before);
}

/// A torus of quads that run any way, and where a place of it is, in tiles.
fn quads(size: u32) -> (Mesh, impl Fn(Place) -> Vec2) {
    let mesh = grid(size, true, &[2, 6, 10, 14, 2, 10, 6], false);
    let corners = mesh.corners.clone();
    let position = move |place: Place| {
        let corner = |k: usize| {
            let point = corners[4 * place.tile as usize + k];
            Vec2::new((point % size) as f32, (point / size) as f32)
        };
        let wrap = |x: f32| {
            if x > 1.5 {
                x - size as f32
            } else if x < -1.5 {
                x + size as f32
            } else {
                x
            }
        };
        let near = |a: Vec2, b: Vec2| Vec2::new(wrap(b.x - a.x), wrap(b.y - a.y));
        corner(0) + near(corner(0), corner(1)) * place.u + near(corner(0), corner(3)) * place.v
    };
    (mesh, position)
}

/// Waves that close over a torus of `size` tiles, the finest of them finer than most footprints.
fn waves(size: u32, at: Vec2) -> Vec4 {
    let phase = at * std::f32::consts::TAU / size as f32;
    let of = |x: f32, y: f32| 0.5 + 0.25 * ((phase.x * x).sin() + (phase.y * y).cos());
    Vec4::new(of(1.0, 2.0), of(8.0, 9.0), of(40.0, 33.0), 1.0)
}

#[test]
fn filtered_colours_are_means_over_their_footprint_across_tiles() {
    let size = 4;
    let (mesh, position) = quads(size);
    let context = Context::serial();
    // Half of the faces twice as fine.
    let face_sizes = (0..mesh.face_count() as u32).step_by(2).map(|face| (face, 128)).collect();
    let mut paint: Channel<Rgba16> =
        channel(&mesh, &ChannelOptions { size: 64, face_sizes, ..ChannelOptions::default() });
    let tiles: Vec<u32> = (0..mesh.face_count() as u32).collect();
    paint.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let changes = paint.edit(&context, &tiles, |tile, texels| {
        let count = texels.size();
        let at = |k: usize| (k as f32 + 0.5) / count as f32;
        for j in 0..count {
            let color = |i: usize| waves(size, position(Place::new(tile, at(i), at(j))));
            texels.row_mut(j).iter_mut().enumerate().for_each(|(i, texel)| *texel = Rgba16::of_color(color(i)));
        }
    });
    paint.settle(&context, &changes.unwrap()).unwrap();
    let field = paint.field();
    let mut random = Random(3);
    let mut squares = [0f32; 2];
    for _ in 0..400 {
        let place = Place::new(random.below(tiles.len()) as u32, random.unit(), random.unit());
        // Up to a tile long, up to ten times as long as wide, in any direction.
        let turn = Vec2::from_angle(std::f32::consts::TAU * random.unit());
        let long = 0.05 + 0.7 * random.unit();
        let wide = long * (0.1 + 0.9 * random.unit());
        let footprint = [turn * long, turn.perp() * wide];
        let found = field.filtered(place, footprint.map(|axis| axis.to_array()));
        let step = |x: f32, y: f32| position(Place::new(place.tile, place.u + x, place.v + y)) - position(place);
        let (x, y) = (step(0.25, 0.0) * 4.0, step(0.0, 0.25) * 4.0);
        let mut mean = Vec4::ZERO;
        for i in 0..48 {
            for j in 0..48 {
                let part = |k: i32| (k as f32 + 0.5) / 48.0 - 0.5;
                let at = footprint[0] * part(i) + footprint[1] * part(j);
                mean += waves(size, position(place) + x * at.x + y * at.y) / (48.0 * 48.0);
            }
        }
        squares[0] += (found - mean).length_squared();
        squares[1] += (field.color(place) - mean).length_squared();
    }
    // Root mean squares; what is left is that levels are powers of two and their texels lie where they do.
    let [filtered, point] = squares.map(|sum| (sum / 400.0).sqrt());
    assert!(filtered < 0.06 && point > 0.2, "filtered {filtered}, not filtered {point}");
}

#[test]
fn one_colour_stays_itself_whatever_the_footprint() {
    let mesh = grid(3, true, &[0, 1, 2, 5, 9, 3], true);
    let context = Context::serial();
    let mut paint: Channel<Rgba8> =
        channel(&mesh, &ChannelOptions { size: 16, face_sizes: vec![(1, 64), (2, 8)], ..ChannelOptions::default() });
    let tiles: Vec<u32> = (0..paint.field().tile_count() as u32).collect();
    paint.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let red = Rgba8([200, 30, 90, 255]);
    let changes =
        paint.edit(&context, &tiles, |_, texels| (0..texels.size()).for_each(|j| texels.row_mut(j).fill(red)));
    paint.settle(&context, &changes.unwrap()).unwrap();
    let mut random = Random(8);
    for _ in 0..2000 {
        let place = Place::new(random.below(tiles.len()) as u32, random.unit(), random.unit());
        let mut number = || (8.0 * random.unit()).exp2() / 64.0 - 0.5;
        let footprint = [[number(), number()], [number(), number()]];
        let found = paint.field().filtered(place, footprint);
        assert!((found - red.color()).abs().max_element() < 1e-5, "{place:?} {footprint:?} {found}");
    }
    for odd in [f32::NAN, f32::INFINITY, 1e30, 0.0] {
        assert!(paint.field().filtered(Place::new(3, odd, 0.5), [[odd, 1.0], [0.0, odd]]).is_finite());
    }
}
