//! Tiles go into an atlas and come back.

use glam::Vec4;
use half::f16;
use relievo_bake::Scaling;
use relievo_bake::atlas::{table_of, write_atlas};
use relievo_bake::gather::from_atlas;
use relievo_bake::ptex::Imported;
use relievo_core::Context;
use relievo_render::read_exr;
use relievo_surface::Place;
use relievo_testing::Random;
use relievo_tiles::{Displacement, Paint, Rgba8, Rgba16};

use crate::support::{cages, options, same_tiles, scribble, surface};

#[test]
fn displacement_is_where_the_table_says_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let context = Context::serial();
    for mesh in cages() {
        let surface = surface(&mesh);
        let topology = surface.topology().clone();
        let mut made = Displacement::new(topology.clone(), &options(&mesh, true)).unwrap();
        scribble(&context, &mut made, &mut Random(5), |random| f16::from_f32(0.2 * random.unit() - 0.05));
        let path = folder.path().join("a.exr");
        let atlas = write_atlas(&context, &path, made.field(), &Scaling { scale: 0.5, mid_level: 0.25 }).unwrap();
        let layer = read_exr(&path, u64::MAX).unwrap().remove(0);
        let numbers = layer.channel("Y").unwrap().to_f32();
        for cell in &atlas.cells {
            for (i, j) in [(0, 0), (3, 5), (cell.size - 1, 2)] {
                let at = |k: u32| (k as f32 + 0.5) / cell.size as f32;
                let expected = made.field().point(context.level(), Place::new(cell.tile, at(i), at(j))).d;
                let found = numbers[((cell.y + j) * atlas.width + cell.x + i) as usize];
                assert!(((found - 0.25) * 0.5 - expected).abs() < 1e-6, "tile {}: {found} {expected}", cell.tile);
            }
        }
        for (name, near) in [("a.exr", 1e-4), ("a.png", 2e-4)] {
            let path = folder.path().join(name);
            write_atlas(&context, &path, made.field(), &Scaling { scale: 0.5, mid_level: 0.25 }).unwrap();
            let back = from_atlas(&context, &surface, &table_of(&path), 1 << 30).unwrap();
            let Imported::Displacement(back) = back else { panic!("{back:?}") };
            same_tiles(made.field(), back.field());
            for tile in made.field().allocated() {
                for (u, v) in [(0.1, 0.2), (0.5, 0.9), (0.0, 0.4), (1.0, 1.0)] {
                    let [a, b] =
                        [&made, &back].map(|made| made.field().point(context.level(), Place::new(tile, u, v)).d);
                    assert!((a - b).abs() < near, "{name}: {a} {b}");
                }
            }
        }
    }
}

#[test]
fn colours_come_back_to_the_bit_and_bad_tables_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let context = Context::serial();
    let mesh = &cages()[0];
    let surface = surface(mesh);
    let topology = surface.topology().clone();
    let mut random = Random(1);
    let blank = Vec4::new(0.5, 0.25, 1.0, 0.5);
    let mut bytes = Paint::<Rgba8>::of_color(topology.clone(), blank, &options(mesh, true)).unwrap();
    scribble(&context, &mut bytes, &mut random, |random| Rgba8([0; 4].map(|_: u8| random.below(256) as u8)));
    let png = folder.path().join("a.png");
    write_atlas(&context, &png, bytes.field(), &Scaling::PLAIN).unwrap();
    let Imported::Rgba8(back) = from_atlas(&context, &surface, &table_of(&png), 1 << 30).unwrap() else { panic!() };
    same_tiles(bytes.field(), back.field());
    assert_eq!(back.field().blank(), bytes.field().blank());
    bytes.field().allocated().for_each(|tile| assert_eq!(bytes.field().block(tile), back.field().block(tile)));

    let mut halves = Paint::<Rgba16>::of_color(topology.clone(), blank, &options(mesh, false)).unwrap();
    let number = |random: &mut Random| f16::from_f32(4.0 * random.unit() - 1.0);
    scribble(&context, &mut halves, &mut random, |random| Rgba16([0; 4].map(|_: u8| number(random))));
    let exr = folder.path().join("a.exr");
    write_atlas(&context, &exr, halves.field(), &Scaling::PLAIN).unwrap();
    let Imported::Rgba16(back) = from_atlas(&context, &surface, &table_of(&exr), 1 << 30).unwrap() else { panic!() };
    halves.field().allocated().for_each(|tile| assert_eq!(halves.field().block(tile), back.field().block(tile)));

    let good = std::fs::read_to_string(table_of(&exr)).unwrap();
    let path = folder.path().join("bad.toml");
    let refuse = |from: &str, to: &str, word: &str| {
        assert!(good.contains(from), "{from}");
        std::fs::write(&path, good.replacen(from, to, 1)).unwrap();
        let error = from_atlas(&context, &surface, &path, 1 << 30).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    };
    refuse("version = 1", "version = 2", "newer");
    refuse("version = 1", "version = [", "not the table");
    refuse("a.exr", "../a.exr", "beside the table");
    refuse("a.exr", "none.exr", "none.exr");
    refuse("\"color\"", "\"heat\"", "heat");
    refuse("face_sizes = [16, ", "face_sizes = [", "faces");
    refuse("face_sizes = [16, ", "face_sizes = [17, ", "17");
    refuse("tiles = [\n", "tiles = [\n    [4000000000, 0, 0, 1, 1, 16],\n", "no tile 4000000000");
    refuse("default = [", "default = [1.0, ", "four numbers");
    let cell = good.lines().find(|line| line.starts_with("    [")).unwrap();
    let numbers: Vec<&str> = cell.trim().trim_matches(['[', ']', ',']).split(", ").collect();
    let [tile, face, corner, _, y, size] = numbers[..] else { panic!("{cell}") };
    refuse(cell, &format!("    [{tile}, {face}, {corner}, 4294967295, {y}, {size}],"), "outside the picture");
    refuse(cell, &format!("{cell}\n{cell}"), "listed twice");
    refuse(cell, &format!("    [{tile}, {face}, {corner}, 1, 1, 64],"), "a side and not");
    assert!(from_atlas(&context, &surface, &table_of(&exr), 1000).unwrap_err().to_string().contains("allow at least"));
}
