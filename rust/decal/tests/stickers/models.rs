//! Stickers on models of artists.

use crate::disks::lay_as_disk;
use relievo_core::{Context, Mesh};
use relievo_decal::{Decal, DecalSettings, Pin, Quality, Sticker, nearest};

/// A model as triangles, by its path in the folder of models.
fn model(name: &str) -> Option<Mesh> {
    let path = relievo_testing::file(name)?;
    let mesh = relievo_meshio::read(&Context::serial(), &path).unwrap_or_else(|error| panic!("{error}"));
    let triangles = mesh.triangles();
    Some(Mesh::from_triangles(mesh.points, &triangles))
}

/// Lays an image of 300 by 300 pixels; pins are points of the image, from its lower left corner, with points of space.
fn laid(mesh: &Mesh, pins: &[([f64; 2], [f64; 3])]) -> Decal {
    let sticker = Sticker::whole([300, 300]).expect("a sticker");
    let pin =
        |(image, space): &([f64; 2], [f64; 3])| Pin { image: *image, place: nearest(mesh, *space).expect("a place").0 };
    let pins: Vec<Pin> = pins.iter().map(pin).collect();
    let decal = lay_as_disk(mesh, &sticker, &pins, None, &DecalSettings::default());
    let decal = decal.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(decal.quality.flips, 0);
    assert!(decal.is_disk().expect("a manifold"));
    for (pin, vertex) in pins.iter().zip(&decal.pins) {
        let uv = decal.uv[*vertex as usize];
        assert!((0..2).all(|axis| (uv[axis] - pin.image[axis] / 300.0).abs() < 1e-6), "{pin:?} is at {uv:?}");
    }
    decal
}

#[test]
fn a_face_covers_the_head_between_large_ears() {
    let Some(mesh) = model("meshes/cheburashka.obj") else { return };
    let pins = [
        ([90.0, 110.0], [0.42, 0.69, 0.70]),
        ([210.0, 110.0], [0.58, 0.69, 0.70]),
        ([150.0, 230.0], [0.5, 0.86, 0.66]),
        ([150.0, 150.0], [0.5, 0.745, 0.70]),
        ([150.0, 70.0], [0.5, 0.635, 0.68]),
    ];
    for count in 2..=pins.len() {
        let decal = laid(&mesh, &pins[..count]);
        assert!(decal.quality.coverage > 0.98, "{count} pins: {:?}", decal.quality);
    }
}

#[test]
fn a_sticker_over_head_and_ears_shows_no_part_of_the_image_twice() {
    let Some(mesh) = model("meshes/cheburashka.obj") else { return };
    let pins = [
        ([120.0, 150.0], [0.42, 0.69, 0.70]),
        ([180.0, 150.0], [0.58, 0.69, 0.70]),
        ([150.0, 210.0], [0.5, 0.86, 0.66]),
    ];
    let Quality { coverage, doubled, .. } = laid(&mesh, &pins).quality;
    assert!(coverage > 0.9 && doubled < 0.02, "{coverage} {doubled}");
}

#[test]
fn a_sticker_lies_on_one_of_many_components() {
    let Some(mesh) = model("meshes/ogre.obj") else { return };
    let pins = [
        ([60.0, 60.0], [-2.5, 16.0, 4.0]),
        ([240.0, 60.0], [2.5, 16.0, 4.0]),
        ([60.0, 240.0], [-2.5, 20.0, 4.0]),
        ([240.0, 240.0], [2.5, 20.0, 4.0]),
    ];
    let decal = laid(&mesh, &pins);
    assert!(decal.quality.coverage > 0.98, "{:?}", decal.quality);
}

#[test]
fn a_sticker_lies_on_the_flank_of_a_cow() {
    let Some(mesh) = model("cages/spot_quadrangulated.obj") else { return };
    // Seen from the side, the image's right is -z.
    let pins = [
        ([60.0, 100.0], [0.35, -0.1, 0.45]),
        ([240.0, 100.0], [0.35, -0.1, 0.0]),
        ([60.0, 220.0], [0.3, 0.2, 0.45]),
        ([240.0, 220.0], [0.33, 0.2, 0.0]),
        ([150.0, 160.0], [0.36, 0.05, 0.22]),
    ];
    for count in [2, 3, 5] {
        let decal = laid(&mesh, &pins[..count]);
        let Quality { coverage, doubled, turned_twice, .. } = decal.quality;
        assert!(coverage > 0.98 && doubled < 0.01 && turned_twice == 0, "{count} pins: {:?}", decal.quality);
    }
}
