//! Edits that fade: linearly, the latest one from its own time, and until nothing is left of them.

use std::sync::Arc;

use half::f16;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_surface::TileTopology;
use relievo_tiles::decay::PERMANENT;
use relievo_tiles::{
    Channel, ChannelOptions, ColorTexel, Decay, DecayOptions, Displacement, Field, Rgba8, Rgba16, Sets, StoredTexel,
};

const OPTIONS: DecayOptions = DecayOptions { delay: 2.0, duration: 8.0 };
const SIZE: u32 = 16;

/// 4 × 4 quads.
fn topology() -> Arc<TileTopology> {
    let points = (0..25).map(|k| [(k % 5) as f32, (k / 5) as f32, 0.0]).collect();
    let corners = (0..16u32).map(|k| 5 * (k / 4) + k % 4).flat_map(|a| [a, a + 1, a + 6, a + 5]);
    let mesh = Mesh::new(points, vec![4; 16], corners.collect());
    Arc::new(TileTopology::new(&mesh).unwrap())
}

fn options() -> ChannelOptions {
    ChannelOptions { size: SIZE, ..ChannelOptions::default() }
}

/// Sets the texels of rows `rows` of `tile` to `texel`.
fn fill<T: StoredTexel>(
    context: &Context,
    channel: &mut Channel<T>,
    tile: u32,
    rows: std::ops::Range<usize>,
    texel: T,
) {
    let mut changes = channel.apply(&Sets { allocate: vec![tile], ..Sets::default() }).unwrap().changes;
    let edit = channel.edit(context, &[tile], |_, texels| rows.clone().for_each(|row| texels.row_mut(row).fill(texel)));
    changes.extend(edit.unwrap());
    channel.settle(context, &changes).unwrap();
}

fn texel<T: StoredTexel>(field: &Field<T>, tile: u32, column: u32, row: u32) -> T {
    field.block(tile).map_or(field.blank(), |block| block[((row + 1) * (SIZE + 2) + column + 1) as usize])
}

#[test]
fn displacement_fades_linearly_and_the_latest_edit_wins() {
    for threads in [1, 3] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut channel = Displacement::new(topology(), &options()).unwrap();
        let mut decay = Decay::new(channel.field().tile_count(), OPTIONS, 1 << 20).unwrap();
        // What was there before has no stamp and stays.
        fill(&context, &mut channel, 5, 12..14, f16::from_f32(-0.25));
        for (time, rows, height) in [(1.0, 4..8, 1.0), (5.0, 6..10, 2.0)] {
            decay.fade(&context, &mut channel, time).unwrap();
            let before = channel.field().clone();
            fill(&context, &mut channel, 5, rows, f16::from_f32(height));
            assert!(decay.stamp(&context, &before, &channel, time).is_empty());
        }
        // One tile of texels of 2 bytes and stamps of 4.
        assert_eq!(decay.bytes(), 6 * 18 * 18);
        let left = |stamp: f64, time: f64| 1.0 - ((time - stamp - 2.0) / 8.0).clamp(0.0, 1.0);
        for step in 0..=60 {
            // In whatever steps.
            let time = 5.0 + 0.25 * f64::from(step + step % 3 / 2);
            decay.fade(&context, &mut channel, time).unwrap();
            let field = channel.field();
            let value = |row: u32| f64::from(texel(field, 5, 3, row).to_f32());
            assert!((value(4) - left(1.0, time)).abs() < 1e-3, "{time}: {}", value(4));
            for row in 6..10 {
                assert!((value(row) - 2.0 * left(5.0, time)).abs() < 2e-3, "{time}: {}", value(row));
            }
            assert_eq!((value(12), value(15)), (-0.25, 0.0));
        }
        // The tile stays for what does not fade, with the neighbours that reaches; its stamps have gone.
        assert_eq!((decay.bytes(), channel.allocated_count()), (0, 3));
    }
}

fn colours_fade_and_give_their_memory_back<T: ColorTexel + StoredTexel>(tolerance: f32) {
    let context = Context::serial();
    let blank = glam::Vec4::new(0.2, 0.3, 0.4, 1.0);
    let mut channel: Channel<T> = Channel::of_color(topology(), blank, &options()).unwrap();
    let mut decay = Decay::new(channel.field().tile_count(), OPTIONS, 1 << 20).unwrap();
    let before = channel.field().clone();
    let red = glam::Vec4::new(0.9, 0.1, 0.0, 1.0);
    // To the border, so that a neighbour is allocated with it.
    fill(&context, &mut channel, 5, 0..4, T::of_color(red));
    assert!(channel.allocated_count() > 1);
    decay.stamp(&context, &before, &channel, 0.0);
    let frames = 24 * 10;
    for frame in 0..=frames {
        let time = f64::from(frame) / 24.0;
        decay.fade(&context, &mut channel, time).unwrap();
        let share = 1.0 - ((time as f32 - 2.0) / 8.0).clamp(0.0, 1.0);
        let found = texel(channel.field(), 5, 7, 1).color();
        let wanted = blank.lerp(red, share);
        assert!((found - wanted).abs().max_element() < tolerance, "{time}: {found} {wanted}");
    }
    assert_eq!((channel.bytes(), decay.bytes(), decay.stamped_count()), (0, 0, 0));
}

#[test]
fn bytes_of_colour_fade_without_sticking() {
    // A step of the coarsest bytes, in linear light: half for the edit, half for what is left of it.
    colours_fade_and_give_their_memory_back::<Rgba8>(9e-3);
    colours_fade_and_give_their_memory_back::<Rgba16>(1e-3);
}

#[test]
fn stamps_survive_reading_and_bad_ones_are_refused() {
    let context = Context::serial();
    let mut channel = Displacement::new(topology(), &options()).unwrap();
    let count = channel.field().tile_count();
    let mut decay = Decay::new(count, OPTIONS, 1 << 20).unwrap();
    let before = channel.field().clone();
    fill(&context, &mut channel, 5, 4..8, f16::ONE);
    decay.stamp(&context, &before, &channel, 3.5);
    assert_eq!(decay.take_changed(), [5]);
    let bytes = decay.read(5).unwrap();
    let mut other = Decay::new(count, OPTIONS, 1 << 20).unwrap();
    other.write(channel.field(), 5, Some(&bytes)).unwrap();
    assert_eq!(other.block(5), decay.block(5));
    let stamps = other.block(5).unwrap().stamps;
    assert_eq!(stamps.iter().filter(|stamp| **stamp == 3.5).count(), 4 * 16);
    assert!(stamps.iter().all(|stamp| [3.5, PERMANENT].contains(stamp)));
    other.write(channel.field(), 5, None).unwrap();
    assert_eq!(other.bytes(), 0);

    assert!(other.write(channel.field(), 99, Some(&bytes)).is_err());
    assert!(other.write(channel.field(), 5, Some(&bytes[1..])).is_err());
    let mut bad = bytes.clone();
    bad.iter_mut().rev().take(4).for_each(|byte| *byte = 0xff);
    assert!(other.write(channel.field(), 5, Some(&bad)).is_err());
    let mut small: Decay<f16> = Decay::new(count, OPTIONS, 6 * 18 * 18 - 1).unwrap();
    assert!(small.write(channel.field(), 5, Some(&bytes)).is_err());
    assert_eq!(small.stamp(&context, &before, &channel, 0.0), [5]);
    assert_eq!(small.bytes(), 0);
    for (delay, duration) in [(-1.0, 1.0), (0.0, 0.0), (f32::NAN, 1.0), (0.0, f32::INFINITY)] {
        assert!(Decay::<f16>::new(count, DecayOptions { delay, duration }, 0).is_err());
    }
}
