//! Channels that come back from documents: to the bit, with the same memory, and as documents of the same bytes.

use std::sync::Arc;

use glam::Vec4;
use half::f16;
use proptest::prelude::*;
use relievo_core::{Context, ErrorKind, Mesh};
use relievo_document::Document;
use relievo_surface::TileTopology;
use relievo_testing::{Random, grid};
use relievo_tiles::{Channel, ChannelOptions, Displacement, Rgba8, Rgba16, Sets, StoredTexel};

const LIMIT: u64 = 256 << 20;

/// Writes `texel` here and there in some tiles.
fn scribble<T: StoredTexel>(channel: &mut Channel<T>, random: &mut Random, texel: impl Fn(f32) -> T + Sync) {
    let context = Context::serial();
    let topology = channel.field().topology().clone();
    let tiles: Vec<u32> =
        (0..topology.tile_count() as u32).filter(|tile| !topology.is_hole(*tile) && random.below(3) == 0).collect();
    channel.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let seed = random.below(1 << 30) as u64;
    let changes = channel.edit(&context, &tiles, |tile, texels| {
        let mut random = Random(seed ^ u64::from(tile) << 20);
        let row = random.below(texels.size());
        texels.row_mut(row).fill_with(|| texel(random.unit()));
    });
    channel.settle(&context, &changes.unwrap()).unwrap();
}

/// Checks that `channel` comes back from `document`.
fn check<T: StoredTexel>(channel: &Channel<T>, document: &Document, name: &str) {
    let topology = channel.field().topology();
    let stored = |budget: u64| Channel::<T>::stored(&Context::serial(), topology.clone(), document, name, budget);
    let back = stored(channel.bytes()).unwrap().unwrap();
    for tile in 0..topology.tile_count() as u32 {
        assert_eq!(back.field().size(tile), channel.field().size(tile));
        assert_eq!(back.field().block(tile), channel.field().block(tile));
    }
    assert_eq!(back.field().blank(), channel.field().blank());
    assert_eq!((back.bytes(), back.full_bytes()), (channel.bytes(), channel.full_bytes()));
    if channel.bytes() > 0 {
        let error = stored(channel.bytes() - 1).unwrap_err();
        assert!(error.kind == ErrorKind::Memory && error.remedy.contains(&channel.bytes().to_string()), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn channels_come_back_to_the_bit(choices in prop::collection::vec(any::<u8>(), 1..40), seed in any::<u64>()) {
        let mut mesh = grid(3, false, &choices, false);
        mesh.holes.push(0);
        let topology = Arc::new(TileTopology::new(&mesh).unwrap());
        let random = &mut Random(seed);
        let faces = topology.face_count() as u32;
        let sizes = (0..faces).map(|face| (face, 8 << random.below(3)));
        let options = ChannelOptions { size: 16, face_sizes: sizes.collect(), budget: LIMIT };
        let mut displacement = Displacement::new(topology.clone(), &options).unwrap();
        scribble(&mut displacement, random, f16::from_f32);
        let grey = Vec4::new(0.5, 0.5, 0.5, 1.0);
        let mut paint = Channel::<Rgba8>::of_color(topology.clone(), grey, &options).unwrap();
        scribble(&mut paint, random, |value| Rgba8([(255.0 * value) as u8, 3, 9, 255]));
        let mut light = Channel::<Rgba16>::of_color(topology.clone(), grey, &options).unwrap();
        scribble(&mut light, random, |value| Rgba16([f16::from_f32(value * 9.0); 4]));

        let context = Context::serial();
        let document = |displacement: &Displacement| {
            let mut document = Document::new(&mesh, context.level().name()).unwrap();
            displacement.field().store(&context, &mut document, "displacement").unwrap();
            paint.field().store(&context, &mut document, "paint").unwrap();
            light.field().store(&context, &mut document, "light").unwrap();
            document.to_bytes().unwrap()
        };
        let bytes = document(&displacement);
        let read = Document::parse(&bytes, LIMIT).unwrap();
        check(&displacement, &read, "displacement");
        check(&paint, &read, "paint");
        check(&light, &read, "light");
        let back = Displacement::stored(&context, topology, &read, "displacement", LIMIT).unwrap().unwrap();
        prop_assert_eq!(document(&back), bytes);
    }
}

#[test]
fn what_does_not_belong_is_refused() {
    let mesh = |size: u32| grid(size, true, &[2], false);
    let topology = |mesh: &Mesh| Arc::new(TileTopology::new(mesh).unwrap());
    let context = Context::serial();
    let displacement =
        Displacement::new(topology(&mesh(4)), &ChannelOptions { size: 8, ..Default::default() }).unwrap();
    let mut document = Document::new(&mesh(4), "baseline").unwrap();
    displacement.field().store(&context, &mut document, "a").unwrap();
    assert!(displacement.field().store(&context, &mut document, "a").is_err(), "a name twice");
    let mut other = Document::new(&mesh(5), "baseline").unwrap();
    assert!(displacement.field().store(&context, &mut other, "a").is_err(), "a document for another mesh");
    let stored = |mesh: &Mesh, name: &str| Displacement::stored(&context, topology(mesh), &document, name, LIMIT);
    assert!(stored(&mesh(4), "a").unwrap().is_some() && stored(&mesh(4), "b").unwrap().is_none());
    assert!(stored(&mesh(5), "a").unwrap_err().to_string().contains("another mesh"));
    let colour = Channel::<Rgba8>::stored(&context, topology(&mesh(4)), &document, "a", LIMIT);
    assert!(colour.unwrap_err().to_string().contains("scalar displacement, f16 and not colour, RGBA8"));
    // Displacement is zero where nothing is stored.
    let mut high = Document::new(&mesh(4), "baseline").unwrap();
    let head = ("a", relievo_document::Kind::Scalar, &[0, 0x3c][..]);
    high.pack(&context, head, vec![8; 16], &[], |_| Ok(Vec::new())).unwrap();
    let refused = Displacement::stored(&context, topology(&mesh(4)), &high, "a", LIMIT);
    assert!(refused.unwrap_err().to_string().contains("default"));
}
