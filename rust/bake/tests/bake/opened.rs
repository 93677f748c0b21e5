//! Layers of documents, alone and together.

use glam::Vec4;
use half::f16;
use relievo_bake::Opened;
use relievo_bake::opened::ColorLayer;
use relievo_core::Context;
use relievo_document::{Blend, Document, Head, Kind, Settings};
use relievo_surface::Place;
use relievo_testing::Random;
use relievo_tiles::{Displacement, Paint, Rgba8};

use crate::support::{cages, options, scribble, surface};

#[test]
fn layers_are_taken_alone_or_as_they_are_seen_together() {
    let context = Context::serial();
    let mesh = &cages()[1];
    let topology = surface(mesh).topology().clone();
    let mut document = Document::new(mesh, context.level().name()).unwrap();
    let mut random = Random(9);
    let mut layers = Vec::new();
    for name in ["base", "bumps"] {
        let mut made = Displacement::new(topology.clone(), &options(mesh, false)).unwrap();
        scribble(&context, &mut made, &mut random, |random| f16::from_f32(random.unit()));
        if name == "base" {
            made.field().store(&context, &mut document, name).unwrap();
        } else {
            // Half of it is taken away.
            let settings = Settings { opacity: 0.5, blend: Blend::Subtract, visible: true };
            let face_sizes = vec![16; mesh.face_count()];
            let head = Head::new(document.free_id(), name, Kind::Scalar, &[0; 2], face_sizes);
            let head = Head { settings, ..head };
            let tiles: Vec<u32> = made.field().allocated().collect();
            document.pack_layer(&context, head, &tiles, |tile| Ok(made.read(tile)?.unwrap())).unwrap();
        }
        layers.push(made);
    }
    let paint = Paint::<Rgba8>::of_color(topology, Vec4::new(0.0, 1.0, 0.0, 1.0), &options(mesh, false)).unwrap();
    paint.field().store(&context, &mut document, "green").unwrap();
    let opened = Opened::new(&context, &document, mesh, None).unwrap();
    let level = context.level();
    let alone = opened.displacement(&context, Some("bumps")).unwrap().unwrap();
    let together = opened.displacement(&context, None).unwrap().unwrap();
    // The name of a layer of another kind leaves displacement as it is.
    let beside = opened.displacement(&context, Some("green")).unwrap().unwrap();
    for tile in 0..alone.field().tile_count() as u32 {
        // Far from borders, whose rules are those of what is composed.
        let d = |made: &Displacement| made.field().point(level, Place::new(tile, 0.45, 0.55)).d;
        assert_eq!(d(&alone), d(&layers[1]));
        assert!((d(&together) - d(&layers[0]) + 0.5 * d(&layers[1])).abs() < 1e-3);
        assert_eq!(d(&together), d(&beside));
    }
    assert!(matches!(opened.colors(&context, None).unwrap(), Some(ColorLayer::Rgba8(_))));
    assert!(opened.vectors(&context, None).unwrap().is_none() && opened.traces(&context, None).unwrap().is_none());
    let error = opened.displacement(&context, Some("bump")).unwrap_err().to_string();
    assert!(error.contains("perhaps `bumps`") && error.contains("base, bumps, green"), "{error}");
}
