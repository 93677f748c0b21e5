//! Stickers in layers of surfaces and in textures of meshes.

use glam::{DAffine3, Vec4};
use relievo_core::progress::Silent;
use relievo_core::{Attribute, Context, ContextOptions, Domain, Mesh, Values};
use relievo_decal::{
    Artwork, Decal, DecalSettings, Pin, Sticker, TrianglePrint, charts, emboss, lay, nearest, paint, paint_texture,
};
use relievo_detail::{DisplacedObject, LayeredObject, TriangleObject};
use relievo_document::{Blend, Document, Kind, Settings};
use relievo_render::Image;
use relievo_surface::{Surface, SurfaceOptions, TriangleSurface};
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions, TriangleTessellation};
use relievo_tiles::{ChannelOptions, Displacement, Paint, Rgba8, uniform_rates};

use crate::sheets::{on_sheet, sheet};

/// An image of four colours: red and green below, magenta and white above.
fn quarters(size: u32) -> Image {
    let mut image = Image::new(size, size, 3).expect("an image");
    for y in 0..size {
        for x in 0..size {
            let is_above = f32::from(u8::from(2 * y < size));
            let is_right = f32::from(u8::from(2 * x >= size));
            image.set_color(x, y, [(1.0 - is_right).max(is_above * is_right), is_right, is_above]);
        }
    }
    image
}

/// A plane with its coordinates as texture coordinates, from `low` on and `side` large.
fn textured(low: f64, side: f64) -> Mesh {
    let mut mesh = sheet(16, |u, v| [u, v, 0.0]);
    let uv = mesh.points.iter().flat_map(|[u, v, _]| [u, v].map(|value| (low + side * f64::from(*value)) as f32));
    let values = Values::F32(uv.collect());
    mesh.attributes.push(Attribute { name: "uv".into(), domain: Domain::Point, width: 2, values, indices: None });
    mesh
}

/// Lays an image of 100 by 100 pixels of which a pixel is `scale` of the sheet, its middle on that of the sheet.
fn laid(mesh: &Mesh, sticker: &Sticker, scale: f64) -> Decal {
    let pin =
        |x: f64, y: f64| Pin { image: [x, y], place: on_sheet(16, 0.5 + scale * (x - 50.0), 0.5 + scale * (y - 50.0)) };
    let pins = [pin(40.0, 40.0), pin(60.0, 42.0), pin(50.0, 61.0)];
    lay(mesh, sticker, &pins, None, &DecalSettings::default(), &mut Silent).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_texture_has_the_image_where_the_decal_lies() {
    let mesh = textured(0.1, 0.8);
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let artwork = Artwork::new(&sticker, &quarters(100)).expect("artwork");
    let decal = laid(&mesh, &sticker, 0.005);
    let mut made = Vec::new();
    for threads in [1, 3] {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).expect("a context");
        let mut texture = Image::new(200, 200, 3).expect("an image");
        let pixels = paint_texture(&context, &mesh, &decal, &artwork, &[], 1.0, &mut texture);
        let pixels = pixels.unwrap_or_else(|error| panic!("{error}"));
        // The image covers pixels 60 to 140, the plane 20 to 180.
        assert_eq!(pixels.painted.iter().filter(|is_painted| **is_painted).count(), 80 * 80);
        assert_eq!(pixels.covered.iter().filter(|is_covered| **is_covered).count(), 160 * 160);
        for (x, y, expected) in [
            (70, 130, [1.0, 0.0, 0.0]),
            (130, 130, [0.0, 1.0, 0.0]),
            (70, 70, [1.0, 0.0, 1.0]),
            (130, 70, [1.0, 1.0, 1.0]),
            (50, 100, [0.0; 3]),
        ] {
            let color = texture.color(x, y);
            assert!(color.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-5), "{x} {y}: {color:?}");
        }
        made.push(texture);
    }
    assert_eq!(made[0], made[1]);
}

#[test]
fn pixels_at_the_border_of_a_chart_have_the_whole_colour() {
    let mesh = textured(0.1, 0.803);
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let image = Image::from_data(100, 100, 1, vec![1.0; 10_000]).expect("an image");
    let artwork = Artwork::new(&sticker, &image).expect("artwork");
    // The sticker is larger than the sheet.
    let decal = laid(&mesh, &sticker, 0.02);
    for (channels, expected) in [(1, vec![0.5]), (3, vec![0.5; 3]), (4, vec![1.0, 1.0, 1.0, 0.5])] {
        let mut texture = Image::new(100, 100, channels).expect("an image");
        let pixels = paint_texture(&Context::serial(), &mesh, &decal, &artwork, &[], 0.5, &mut texture);
        let pixels = pixels.unwrap_or_else(|error| panic!("{error}"));
        // The chart ends at 90.3 pixels, a quarter of whose samples it covers.
        let close =
            |x: u32| texture.pixel(x, 50).iter().zip(&expected).all(|(a, b): (&f32, &f32)| (a - b).abs() < 1e-5);
        assert!(close(50) && close(90), "{:?}", texture.pixel(90, 50));
        assert!(texture.pixel(91, 50).iter().all(|value| *value == 0.0));
        assert!(pixels.painted[50 * 100 + 90] && !pixels.covered[50 * 100 + 91]);
    }
}

#[test]
fn meshes_without_usable_texture_coordinates_are_refused() {
    let error = |mesh: &Mesh| charts(mesh, [64, 64]).expect_err("unusable").to_string();
    assert!(error(&sheet(2, |u, v| [u, v, 0.0])).contains("no texture coordinates"));
    assert!(error(&textured(0.5, 1.0)).contains("0 to 1"));
    let quad = Mesh::new(vec![[0.0; 3]; 4], vec![4], vec![0, 1, 2, 3]);
    assert!(error(&quad).contains("4 corners"));
}

/// A document of a wavy sheet of 16 quads with a sticker painted and embossed by a number of threads.
fn printed(threads: usize) -> Vec<u8> {
    let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).expect("a context");
    let points = (0..25).map(|index| {
        let (u, v) = ((index % 5) as f32, (index / 5) as f32);
        [u, v, 0.3 * (1.3 * u).sin() * v.cos()]
    });
    let corners = (0..16).flat_map(|face| {
        let first = face / 4 * 5 + face % 4;
        [first, first + 1, first + 6, first + 5]
    });
    let cage = Mesh::new(points.collect(), vec![4; 16], corners.collect());
    let surface = Surface::new(&context, &cage, &SurfaceOptions::default()).expect("a surface");
    let topology = surface.topology().clone();
    let options = ChannelOptions { size: 32, ..ChannelOptions::default() };
    let displacement = Displacement::new(topology.clone(), &options).expect("displacement");
    let mut object = DisplacedObject::new(&context, surface, &cage.points, displacement, DAffine3::IDENTITY)
        .unwrap_or_else(|error| panic!("{error}"));
    let grey = Paint::<Rgba8>::of_color(topology, Vec4::new(0.5, 0.5, 0.5, 1.0), &options).expect("colours");
    object.set_paint(grey).expect("colours");
    let rates = uniform_rates(object.surface().topology(), 8);
    let ground = object.displaced().expect("a surface").tessellate(&context, &cage, &rates).expect("triangles");
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let artwork = Artwork::new(&sticker, &quarters(100)).expect("artwork");
    let pin = |x: f64, y: f64| Pin {
        image: [x, y],
        place: nearest(&ground.mesh, [0.02 * x + 1.0, 0.02 * y + 1.0, 0.0]).expect("a place").0,
    };
    let pins = [pin(20.0, 20.0), pin(80.0, 20.0), pin(50.0, 80.0)];
    let decal = lay(&ground.mesh, &sticker, &pins, None, &DecalSettings::default(), &mut Silent).expect("a decal");
    let painted = paint(&context, &mut object, &ground, &decal, &artwork, &[], 0.7).expect("paint");
    assert!(painted.texels > 1000 && painted.refused.is_empty());
    emboss(&context, &mut object, &ground, &decal, &artwork, &[0.0, 1.0, 2.0], 0.1).expect("a relief");
    let mut document = Document::new(&cage, context.level().name()).expect("a document");
    object.store(&context, &mut document).expect("layers");
    document.to_bytes().expect("bytes")
}

#[test]
fn painting_does_not_depend_on_the_number_of_threads() {
    let one = printed(1);
    assert!(one.len() > 4000 && one == printed(2) && one == printed(5));
}

#[test]
fn vectors_on_triangles_follow_the_directions_of_the_image() {
    let context = Context::serial();
    let mesh = sheet(8, |u, v| [u, v, 0.0]);
    let surface = TriangleSurface::new(&context, &mesh).expect("a surface");
    let topology = surface.topology().clone();
    let options = TriangleOptions { segments: 8, budget: u64::MAX };
    let displacement = TriangleChannel::displacement(topology.clone(), &options).expect("displacement");
    let mut object = TriangleObject::new(&context, surface, displacement, DAffine3::IDENTITY).expect("an object");
    let ground = |object: &TriangleObject| {
        let displaced = object.displaced().expect("a mesh");
        TriangleTessellation::new(&context, &displaced, object.normals(), &mesh, |face| object.rates(face))
    };
    object.renew(&context).expect("normals");
    let ground = ground(&object).expect("triangles");
    // The image is half as wide as the sheet and turned.
    let (sin, cos) = 0.6_f64.sin_cos();
    let sticker = Sticker::whole([100, 100]).expect("a sticker");
    let pin = |x: f64, y: f64| {
        let [a, b] = [0.005 * (x - 50.0), 0.005 * (y - 50.0)];
        let point = [0.5 + cos * a - sin * b, 0.5 + sin * a + cos * b, 0.0];
        Pin { image: [x, y], place: nearest(&ground.mesh, point).expect("a place").0 }
    };
    let pins = [pin(20.0, 20.0), pin(80.0, 25.0), pin(45.0, 81.0)];
    let decal = lay(&ground.mesh, &sticker, &pins, None, &DecalSettings::default(), &mut Silent).expect("a decal");
    let mut image = Image::new(100, 100, 3).expect("an image");
    (0..100).for_each(|y| (0..100).for_each(|x| image.set_color(x, y, [1.0, 0.25, 0.75])));
    let artwork = Artwork::new(&sticker, &image).expect("artwork");
    let print = TrianglePrint { context: &context, ground: &ground, decal: &decal, artwork: &artwork, depths: &[] };
    let add = Settings { blend: Blend::Add, ..Settings::of(Kind::Vector) };
    let error = print.displace(&mut object, 0.2, &add).expect_err("there are no vectors").to_string();
    assert!(error.contains("no vector displacement"), "{error}");
    object.set_vectors(TriangleChannel::vectors(topology.clone(), &options).expect("vectors")).expect("they fit");
    let printed = print.displace(&mut object, 0.2, &add).expect("it is written");
    assert!(printed.refused.is_empty() && printed.texels > 1000, "{printed:?}");
    // To the right by 0.2, down by 0.1, out by 0.1.
    let expected = [0.2 * cos + 0.1 * sin, 0.2 * sin - 0.1 * cos, 0.1];
    let check = |object: &TriangleObject, expected: [f64; 3]| {
        let (offsets, _) = object.offsets().expect("vectors");
        let mut counts = [0; 2];
        for face in 0..topology.face_count() as u32 {
            let corners = topology.face(face).map(|corner| mesh.points[corner as usize].map(f64::from));
            for weights in [[0.5, 0.25, 0.25], [0.5, 0.5, 0.0], [0.0, 0.125, 0.875], [1.0, 0.0, 0.0]] {
                let at = [0, 1].map(|axis| (0..3).map(|k| f64::from(weights[k]) * corners[k][axis]).sum::<f64>() - 0.5);
                let [x, y] = [cos * at[0] + sin * at[1], cos * at[1] - sin * at[0]];
                let found = offsets.value(face, weights).to_array();
                let away = x.abs().max(y.abs());
                let (part, expected) = if away < 0.22 { (0, expected) } else { (1, [0.0; 3]) };
                if !(0.22..=0.28).contains(&away) {
                    counts[part] += 1;
                    let near = |axis: usize| (found[axis] - expected[axis]).abs() < 1e-3;
                    assert!((0..3).all(near), "face {face} {weights:?}: {found:?}, and not {expected:?}");
                }
            }
        }
        assert!(counts[0] > 50 && counts[1] > 100, "{counts:?}");
    };
    check(&object, expected);
    let half = Settings { blend: Blend::Subtract, opacity: 0.5, ..Settings::of(Kind::Vector) };
    print.displace(&mut object, 0.2, &half).expect("it is written");
    check(&object, expected.map(|value| 0.5 * value));
    let largest = Settings { blend: Blend::Max, ..add };
    let error = print.displace(&mut object, 0.2, &largest).expect_err("no mode").to_string();
    assert!(error.contains("blend"), "{error}");
}
