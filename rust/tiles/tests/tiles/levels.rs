//! Edits at half and a quarter of the texels, and faces of other sizes.

use std::sync::Arc;

use glam::Vec4;
use half::f16;
use relievo_core::{Context, ErrorKind, Mesh};
use relievo_surface::{Place, TileTopology};
use relievo_testing::{Random, grid};
use relievo_tiles::{Channel, ChannelOptions, ColorTexel, Displacement, Field, Rgba8, Rgba16, Sets, Texel};

const BLANK: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);

fn topology(mesh: &Mesh) -> Arc<TileTopology> {
    Arc::new(TileTopology::new(mesh).unwrap())
}

fn options(size: u32) -> ChannelOptions {
    ChannelOptions { size, ..ChannelOptions::default() }
}

/// Fills tiles with numbers from a seed.
fn scribble<T: Texel>(channel: &mut Channel<T>, tiles: &[u32], texel: impl Fn(f32) -> T + Sync) {
    let context = Context::serial();
    channel.apply(&Sets { allocate: tiles.to_vec(), ..Sets::default() }).unwrap();
    let changes = channel.edit(&context, tiles, |tile, texels| {
        let mut random = Random(u64::from(tile) + 1);
        (0..texels.size()).for_each(|j| texels.row_mut(j).fill_with(|| texel(random.unit())));
    });
    channel.settle(&context, &changes.unwrap()).unwrap();
}

/// Edits tiles at a level: `change` makes a new texel of the old one, its tile, column and row.
fn edit_at<T: Texel>(
    channel: &mut Channel<T>,
    level: u32,
    tiles: &[u32],
    change: impl Fn(T, u32, usize, usize) -> T,
) -> (Field<T>, Vec<(u32, Arc<[T]>)>) {
    let context = Context::serial();
    let coarse = channel.field().at_level(&context, level, tiles).unwrap();
    let blocks: Vec<(u32, Arc<[T]>)> = tiles
        .iter()
        .map(|tile| {
            let size = coarse.size(*tile) as usize;
            let stride = size + 2;
            let mut block = vec![coarse.blank(); stride * stride];
            if let Some(old) = coarse.block(*tile) {
                block.copy_from_slice(old);
            }
            for j in 0..size {
                for i in 0..size {
                    let at = (j + 1) * stride + i + 1;
                    block[at] = change(block[at], *tile, i, j);
                }
            }
            (*tile, block.into())
        })
        .collect();
    let applied = channel.put_at(&context, &coarse, blocks.clone()).unwrap();
    assert_eq!(channel.settle(&context, &applied.changes), Ok(applied.refused));
    (coarse, blocks)
}

fn all(channel: &Field<impl Texel>) -> Vec<u32> {
    (0..channel.tile_count() as u32).collect()
}

#[test]
fn a_coarse_edit_keeps_fine_detail_and_reads_back_as_it_was_written() {
    let context = Context::serial();
    for (level, choices) in [(1, vec![2]), (2, vec![2]), (1, vec![2, 6, 10, 14])] {
        let mesh = grid(4, true, &choices, false);
        let mut displacement = Displacement::new(topology(&mesh), &options(64)).unwrap();
        let tiles = all(displacement.field());
        scribble(&mut displacement, &tiles, |value| f16::from_f32(0.125 * value));
        let before = displacement.commit();
        // Hills that differ from tile to tile.
        let hill = |tile: u32, i: usize, j: usize| {
            let wave = (0.4 * i as f32).sin() * (0.3 * j as f32 + tile as f32).cos();
            f16::from_f32(2.0 * wave).to_f32()
        };
        let (_, blocks) =
            edit_at(&mut displacement, level, &tiles, |old, tile, i, j| f16::from_f32(old.to_f32() + hill(tile, i, j)));
        assert_eq!((displacement.field().size(5), displacement.bytes()), (64, before.bytes()));
        // Read back: exactly, but for the rounding of half floats here and there.
        let back = displacement.field().at_level(&context, level, &tiles).unwrap();
        let size = 64usize >> level;
        let mut worst = 0f32;
        for (tile, block) in &blocks {
            let found = back.block(*tile).unwrap();
            for k in 0..size * size {
                let at = (k / size + 1) * (size + 2) + k % size + 1;
                worst = worst.max((found[at].to_f32() - block[at].to_f32()).abs());
            }
        }
        assert!(worst < 0.01, "level {level}: {worst}");
        // The detail is what was there: what was added has none.
        let mut random = Random(4);
        let mut rough = 0f32;
        for _ in 0..400 {
            let place =
                Place::new(random.below(tiles.len()) as u32, 0.2 + 0.6 * random.unit(), 0.2 + 0.6 * random.unit());
            let added = |u: f32| {
                let place = Place::new(place.tile, u, place.v);
                displacement.field().point(context.level(), place).d - before.point(context.level(), place).d
            };
            let h = 1.0 / 64.0;
            rough = rough.max((added(place.u + h) - 2.0 * added(place.u) + added(place.u - h)).abs());
        }
        assert!(rough < 0.2 / (1 << level) as f32, "level {level}: {rough}");
    }
}

#[test]
fn an_edit_of_one_coefficient_is_the_same_function_on_the_finer_tile() {
    let context = Context::serial();
    let mesh = grid(3, true, &[2], false);
    let mut fine = Displacement::new(topology(&mesh), &options(32)).unwrap();
    fine.apply(&Sets { allocate: all(fine.field()), ..Sets::default() }).unwrap();
    let mut coarse = Displacement::new(topology(&mesh), &options(16)).unwrap();
    coarse.apply(&Sets { allocate: all(coarse.field()), ..Sets::default() }).unwrap();
    // In the middle, at a border and at a corner.
    for (tile, i, j) in [(4, 7, 9), (4, 0, 5), (2, 15, 15)] {
        let raised = |old: f16, _: u32, x: usize, y: usize| if (x, y) == (i, j) { f16::from_f32(1.5) } else { old };
        edit_at(&mut fine, 1, &[tile], raised);
        edit_at(&mut coarse, 0, &[tile], raised);
    }
    let mut random = Random(1);
    for _ in 0..2000 {
        let place = Place::new(random.below(9) as u32, random.unit(), random.unit());
        let [a, b] = [&fine, &coarse].map(|channel| channel.field().point(context.level(), place).d);
        assert!((a - b).abs() < 2e-3, "{place:?} {a} {b}");
    }
}

#[test]
fn faces_never_edited_get_what_the_level_asks_and_grow_when_a_finer_edit_comes() {
    let context = Context::serial();
    // Quads, and faces of several tiles.
    let mesh = grid(4, true, &[2, 1, 2, 0], false);
    let mut paint: Channel<Rgba16> = Channel::of_color(topology(&mesh), BLANK, &options(64)).unwrap();
    let full = paint.full_bytes();
    let quad = (0..paint.field().tile_count() as u32).find(|tile| !paint.field().topology().is_sub(*tile)).unwrap();
    let sub = (0..paint.field().tile_count() as u32).find(|tile| paint.field().topology().is_sub(*tile)).unwrap();
    let red = Rgba16::of_color(Vec4::new(1.0, 0.0, 0.0, 1.0));
    let middle = |size: usize| (size / 4..3 * size / 4, size / 4..3 * size / 4);
    let dot = |size: usize| {
        move |old: Rgba16, _: u32, i: usize, j: usize| {
            let (columns, rows) = middle(size);
            if columns.contains(&i) && rows.contains(&j) { red } else { old }
        }
    };
    edit_at(&mut paint, 2, &[quad], dot(16));
    edit_at(&mut paint, 1, &[sub], dot(16));
    let field = paint.field();
    assert_eq!((field.size(quad), field.size(sub), field.size_at(quad, 0)), (16, 16, 64));
    // Every sub-tile of the face, so that documents know its size.
    let face = field.topology().face(sub);
    assert!(field.topology().tiles_of(face).all(|tile| field.size(tile) == 16));
    let in_use: u64 = field.allocated().map(|tile| field.tile_bytes(tile)).sum();
    assert_eq!((paint.bytes(), field.allocated().count()), (in_use, 2));
    let before = paint.commit();
    edit_at(&mut paint, 0, &[quad], |old, _, i, j| if (i, j) == (40, 40) { Rgba16::default() } else { old });
    assert_eq!(paint.field().size(quad), 64);
    for place in [(0.5, 0.5), (0.3, 0.6), (0.1, 0.1)] {
        let place = Place::new(quad, place.0, place.1);
        let [a, b] = [&*before, paint.field()].map(|field| field.color(place));
        assert!((a - b).abs().max_element() < 0.02, "{place:?} {a} {b}");
    }
    // A coarser edit then goes to the finer tile.
    edit_at(&mut paint, 2, &[quad], |_, _, _, _| red);
    assert_eq!(paint.field().size(quad), 64);
    // What is left is what was before: nothing.
    let tiles: Vec<u32> = paint.field().allocated().collect();
    let blank = paint.field().blank();
    let changes =
        paint.edit(&context, &tiles, |_, texels| (0..texels.size()).for_each(|j| texels.row_mut(j).fill(blank)));
    paint.settle(&context, &changes.unwrap()).unwrap();
    paint.reclaim(&context, &all(paint.field())).unwrap();
    assert_eq!(paint.bytes(), 0);
    let faces: Vec<(u32, u32)> = (0..paint.field().topology().face_count() as u32).map(|face| (face, 64)).collect();
    paint.resize(&context, &faces).unwrap();
    assert_eq!(paint.full_bytes(), full);
}

fn colours_keep_detail<T: ColorTexel>(bound: f32) {
    let context = Context::serial();
    let mesh = grid(4, true, &[2, 6, 10], false);
    let mut paint: Channel<T> = Channel::of_color(topology(&mesh), BLANK, &options(32)).unwrap();
    let tiles = all(paint.field());
    scribble(&mut paint, &tiles, |value| T::of_color(Vec4::new(0.3 + 0.1 * value, 0.4 - 0.1 * value, 0.35, 1.0)));
    let before = paint.commit();
    let tint = Vec4::new(0.125, 0.125, 0.0, 0.0);
    let (_, blocks) = edit_at(&mut paint, 1, &tiles, |old, _, _, _| T::of_color(old.color() + tint));
    let back = paint.field().at_level(&context, 1, &tiles).unwrap();
    for (tile, block) in &blocks {
        for k in 0..16 * 16 {
            let at = (k / 16 + 1) * 18 + k % 16 + 1;
            let (found, written) = (back.block(*tile).unwrap()[at].color(), block[at].color());
            assert!((found - written).abs().max_element() < 2.0 * bound, "{tile} {k}: {found} {written}");
        }
        let (old, new) = (before.block(*tile).unwrap(), paint.field().block(*tile).unwrap());
        for (old, new) in old.iter().zip(new) {
            assert!((new.color() - old.color() - tint).abs().max_element() < bound, "{old:?} {new:?}");
        }
    }
}

#[test]
fn a_coarse_tint_keeps_what_is_drawn_beneath() {
    colours_keep_detail::<Rgba16>(2e-3);
    colours_keep_detail::<Rgba8>(1.5e-2);
}

#[test]
fn painted_faces_take_other_sizes() {
    let context = Context::serial();
    let mesh = grid(4, true, &[2, 1], false);
    let mut paint: Channel<Rgba16> = Channel::of_color(topology(&mesh), BLANK, &options(32)).unwrap();
    let tiles = all(paint.field());
    scribble(&mut paint, &tiles, |value| Rgba16::of_color(Vec4::new(value, 1.0 - value, 0.5, 1.0)));
    let before = paint.commit();
    let faces: Vec<(u32, u32)> = (0..mesh.face_count() as u32).step_by(2).map(|face| (face, 64)).collect();
    assert_eq!(paint.resize(&context, &faces), Ok(vec![]));
    let in_use: u64 = paint.field().allocated().map(|tile| paint.field().tile_bytes(tile)).sum();
    assert_eq!((paint.bytes(), paint.bytes() > before.bytes()), (in_use, true));
    // Texel centres of the coarser tile are between those of the finer one.
    let face = paint.field().topology().face(tiles[0]);
    let place = Place::new(paint.field().topology().tiles_of(face).start, 10.0 / 32.0, 17.0 / 32.0);
    let [a, b] = [&*before, paint.field()].map(|field| field.color(place));
    assert!((a - b).abs().max_element() < 2e-3, "{a} {b}");
    // Coarser: means.
    let tile = tiles.iter().copied().find(|tile| paint.field().size(*tile) == 32).unwrap();
    let mean = paint.field().level(tile, 1).unwrap()[18 * 5 + 6];
    let face = paint.field().topology().face(tile);
    let size = if paint.field().topology().is_sub(tile) { 32 } else { 16 };
    paint.resize(&context, &[(face, size)]).unwrap();
    assert_eq!(paint.field().block(tile).unwrap()[18 * 5 + 6], mean);
}

#[test]
fn what_cannot_be_put_is_refused_and_changes_nothing() {
    let context = Context::serial();
    let mesh = grid(3, true, &[2], false);
    let mut channel = Displacement::new(topology(&mesh), &ChannelOptions { budget: 800, ..options(32) }).unwrap();
    let coarse = channel.field().at_level(&context, 2, &[0, 1]).unwrap();
    let block = |length: usize, value: f32| -> Arc<[f16]> { vec![f16::from_f32(value); length].into() };
    assert!(channel.put_at(&context, &coarse, vec![(0, block(99, 1.0))]).is_err());
    assert!(channel.put_at(&context, &coarse, vec![(0, block(100, f32::NAN))]).is_err());
    assert!(channel.put_at(&context, &coarse, vec![(77, block(100, 1.0))]).is_err());
    assert!(
        channel.field().at_level(&context, 3, &[]).is_err() && channel.field().at_level(&context, 1, &[9]).is_err()
    );
    assert_eq!((channel.bytes(), channel.field().size(0)), (0, 32));
    // A quarter of the size fits four times, its neighbours not.
    let mut dot = vec![f16::ZERO; 100];
    dot[55] = f16::ONE;
    let blocks = (0..5).map(|tile| (tile, dot.clone().into())).collect();
    let applied = channel.put_at(&context, &coarse, blocks).unwrap();
    assert_eq!((applied.refused, channel.bytes()), (vec![4], 800));
    let fine = channel.field().at_level(&context, 0, &[0]).unwrap();
    let blocks = vec![(0, block(34 * 34, 1.0))];
    assert_eq!(channel.put_at(&context, &fine, blocks).unwrap_err().kind, ErrorKind::Memory);
    assert_eq!((channel.bytes(), channel.field().size(0)), (800, 8));
}
