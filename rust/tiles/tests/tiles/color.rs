//! Colour across edges and vertices, after any edits on any cage, and the memory it takes.

use std::sync::Arc;

use glam::Vec4;
use proptest::prelude::*;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_surface::{Link, Place, RingClass, Side, TileTopology};
use relievo_testing::{Random, grid};
use relievo_tiles::{Change, Channel, ChannelOptions, ColorTexel, Field, Rgba8, Rgba16, Sets};

const BLANK: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);

fn paint<T: ColorTexel>(mesh: &Mesh, options: &ChannelOptions) -> Channel<T> {
    Channel::of_color(Arc::new(TileTopology::new(mesh).unwrap()), BLANK, options).unwrap()
}

/// Random strokes: whole rows, so that borders and corners are hit often. Returns the tiles that were refused.
fn stroke<T: ColorTexel>(channel: &mut Channel<T>, context: &Context, random: &mut Random, tiles: &[u32]) -> Vec<u32> {
    let sets = Sets { allocate: tiles.to_vec(), ..Sets::default() };
    let mut refused = channel.apply(&sets).unwrap().refused;
    let tiles: Vec<u32> = tiles.iter().copied().filter(|tile| channel.field().is_allocated(*tile)).collect();
    let seed = random.below(1 << 30) as u64;
    let changes = channel.edit(context, &tiles, |tile, texels| {
        let mut random = Random(seed ^ u64::from(tile) << 20);
        let (row, start) = (random.below(texels.size()), random.below(texels.size()));
        let mut any = || T::of_color(Vec4::new(random.unit(), random.unit(), random.unit(), random.unit()));
        texels.row_mut(row)[start..].fill_with(&mut any);
        texels.row_mut(start).fill_with(&mut any);
    });
    refused.extend(channel.settle(context, &changes.unwrap()).unwrap());
    refused
}

/// Checks both sides of every edge, and every vertex, where all densities are equal.
fn check<T: ColorTexel>(field: &Field<T>) {
    let topology = field.topology();
    for tile in 0..topology.tile_count() as u32 {
        for edge in 0..4 {
            for t in [0.0f32, 0.03, 0.2, 0.46, 0.5, 0.77, 0.99, 1.0] {
                let here = Side { tile, edge };
                let turn = |reversed: bool| if reversed { t } else { 1.0 - t };
                let (other, s) = match topology.link(tile, edge) {
                    Link::Whole { side, reversed } => (side, turn(reversed)),
                    Link::Half { side, second, reversed } => {
                        (side, turn(reversed) / 2.0 + if second { 0.5 } else { 0.0 })
                    }
                    _ => continue,
                };
                let at = |side: Side, t: f32| field.color(Place::on_edge(side.tile, side.edge, t));
                let (a, b) = (at(here, t), at(other, s));
                assert!((a - b).abs().max_element() < 2e-5, "{here:?} {other:?} at {t}: {a} {b}");
                let canonical = field.color(field.canonical(Place::on_edge(tile, edge, t)));
                assert_eq!(canonical, field.color(field.canonical(Place::on_edge(other.tile, other.edge, s))));
                if field.density(tile) == 0 {
                    assert_eq!(b, field.blank().color());
                }
            }
        }
    }
    for ring in 0..topology.ring_count() as u32 {
        let colors: Vec<Vec4> = topology.ring(ring).iter().map(|entry| field.color(entry.place())).collect();
        let pinned = topology.ring_class(ring) == RingClass::Pinned;
        assert!(pinned || colors.iter().all(|color| (*color - colors[0]).abs().max_element() < 2e-5), "{colors:?}");
    }
}

fn blocks<T: ColorTexel>(field: &Field<T>) -> Vec<Option<Vec<u8>>> {
    let bytes = |tile| field.block(tile).map(|block| bytemuck::cast_slice(block).to_vec());
    (0..field.tile_count() as u32).map(bytes).collect()
}

/// Random strokes, checked after each; at the end everything is wiped. Returns what it looked like before.
fn exercise<T: ColorTexel>(mesh: &Mesh, seed: u64, budget: u64, context: &Context) -> Vec<Option<Vec<u8>>> {
    let mut random = Random(seed);
    let mut channel: Channel<T> = paint(mesh, &ChannelOptions { size: 16, budget, ..ChannelOptions::default() });
    let all: Vec<u32> = (0..channel.field().tile_count() as u32).collect();
    for _ in 0..5 {
        let mut tiles: Vec<u32> = (0..1 + random.below(4)).map(|_| random.below(all.len()) as u32).collect();
        tiles.sort_unstable();
        tiles.dedup();
        let refused = stroke(&mut channel, context, &mut random, &tiles);
        assert!(refused.iter().all(|tile| !channel.field().is_allocated(*tile)));
        check(channel.field());
        let field = channel.field();
        let in_use: u64 = field.allocated().map(|tile| field.tile_bytes(tile)).sum();
        assert_eq!((channel.bytes(), channel.bytes() <= budget), (in_use, true));
        let changes: Vec<Change> = all.iter().copied().map(Change::all).collect();
        assert_eq!(channel.update_rings(context, &changes).unwrap(), Vec::<u32>::new());
        // What is given back was blank and not wanted, so that nothing changes.
        let before = channel.commit();
        channel.reclaim(context, &all).unwrap();
        for tile in &all {
            for place in [(0.0, 0.0), (0.3, 0.01), (0.5, 0.5), (0.99, 0.2), (1.0, 1.0)] {
                let place = Place::new(*tile, place.0, place.1);
                assert_eq!(channel.field().color(place), before.color(place));
            }
        }
        check(channel.field());
    }
    let kept = blocks(channel.field());
    let tiles: Vec<u32> = channel.field().allocated().collect();
    let blank = channel.field().blank();
    let changes =
        channel.edit(context, &tiles, |_, texels| (0..texels.size()).for_each(|j| texels.row_mut(j).fill(blank)));
    channel.settle(context, &changes.unwrap()).unwrap();
    channel.reclaim(context, &all).unwrap();
    assert_eq!((channel.bytes(), channel.allocated_count()), (0, 0));
    kept
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 30, failure_persistence: None, ..Default::default() })]

    #[test]
    fn colour_is_continuous_over_any_grid_and_given_back_to_the_byte(
        size in 2u32..6, torus: bool, choices in prop::collection::vec(any::<u8>(), 1..40), seed: u64, tight: bool,
    ) {
        prop_assume!(!torus || size > 2);
        let mesh = grid(size, torus, &choices, true);
        let budget = if tight { 40_000 } else { 1 << 30 };
        let eight = exercise::<Rgba8>(&mesh, seed, budget, &Context::serial());
        exercise::<Rgba16>(&mesh, seed, budget, &Context::serial());
        let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
        prop_assert_eq!(exercise::<Rgba8>(&mesh, seed, budget, &context), eight);
    }
}

#[test]
fn a_place_between_texels_is_between_their_colours() {
    let mesh = grid(2, false, &[2], false);
    let context = Context::serial();
    let mut channel: Channel<Rgba16> = paint(&mesh, &ChannelOptions { size: 8, ..ChannelOptions::default() });
    assert_eq!(channel.field().color(Place::new(0, 0.4, 0.7)), BLANK);
    channel.apply(&Sets { allocate: vec![0, 1, 2, 3], ..Sets::default() }).unwrap();
    // A ramp over the face, which bilinear look-up keeps exactly away from the border.
    let ramp = |i: usize, j: usize| Vec4::new(i as f32 / 8.0, j as f32 / 8.0, 0.0, 1.0);
    let changes = channel.edit(&context, &[0], |_, texels| {
        for j in 0..8 {
            texels.row_mut(j).iter_mut().enumerate().for_each(|(i, texel)| *texel = Rgba16::of_color(ramp(i, j)));
        }
    });
    channel.settle(&context, &changes.unwrap()).unwrap();
    let found = channel.field().color(Place::new(0, 0.40, 0.70));
    assert!((found - Vec4::new(0.40 - 1.0 / 16.0, 0.70 - 1.0 / 16.0, 0.0, 1.0)).abs().max_element() < 1e-6, "{found}");
}

#[test]
fn hostile_blocks_are_refused() {
    let mesh = grid(2, false, &[2], false);
    let mut channel: Channel<Rgba16> = paint(&mesh, &ChannelOptions { size: 8, ..ChannelOptions::default() });
    assert!(channel.write(0, Some(&[0; 7])).is_err() && channel.write(4, None).is_err());
    let mut bytes = vec![0u8; 10 * 10 * 8];
    bytes[1] = 0x7e;
    assert!(channel.write(0, Some(&bytes)).is_err());
    assert_eq!(channel.bytes(), 0);
    bytes[1] = 0;
    channel.write(0, Some(&bytes)).unwrap();
    assert_eq!((channel.read(0).unwrap().unwrap(), channel.bytes()), (bytes, 8 * (10 * 10 + 6 * 6 + 4 * 4)));
    assert!(channel.reclaim(&Context::serial(), &[9]).is_err());
}
