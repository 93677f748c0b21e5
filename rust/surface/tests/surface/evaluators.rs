//! Evaluation against OpenSubdiv's own evaluators on the same table, and against closed forms.

use relievo_core::{Context, ContextOptions, Crease, Mesh};
use relievo_opensubdiv::{PatchKind, reference};
use relievo_surface::{Destination, Grid, Order, Place, Placement, Samples, Surface, SurfaceOptions};

fn cube() -> Mesh {
    let points = (0..8).map(|i| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32]).collect();
    let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
    Mesh::new(points, vec![4; 6], corners)
}

/// A cage of `n` × `n` quads over [0, n]², with the height of `shape`.
fn plane(n: u32, shape: impl Fn(f32, f32) -> f32) -> Mesh {
    let mut points = Vec::new();
    let mut corners = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (i as f32, j as f32);
            points.push([x, y, shape(x, y)]);
            if i < n && j < n {
                let a = j * (n + 1) + i;
                corners.extend([a, a + 1, a + n + 2, a + n + 1]);
            }
        }
    }
    Mesh::new(points, vec![4; (n * n) as usize], corners)
}

/// Cages with every kind of feature: n-gons, boundaries, creases of all kinds, sharp points, holes.
fn cages() -> Vec<(&'static str, Mesh)> {
    let mut creased = plane(6, |x, y| (x * 1.3).sin() + (y * 0.7).cos());
    for k in 0..6 {
        creased.creases.push(Crease { points: [21 + k, 22 + k], sharpness: 2.5 });
        creased.creases.push(Crease { points: [3 + 7 * k, 10 + 7 * k], sharpness: 10.0 });
    }
    creased.sharp_points.push((16, 3.0));
    creased.holes.push(20);
    let mut pentagon = Mesh::new(
        (0..5).map(|k| f32::from(k as u8) * 1.2566).map(|a| [a.cos(), a.sin(), 0.0]).chain([[0.0, 0.0, 1.0]]).collect(),
        vec![5, 3, 3, 3, 3, 3],
        vec![4, 3, 2, 1, 0, 0, 1, 5, 1, 2, 5, 2, 3, 5, 3, 4, 5, 4, 0, 5],
    );
    pentagon.creases.push(Crease { points: [0, 1], sharpness: 1.5 });
    let mut sharp_cube = cube();
    for edge in [[0, 1], [1, 3], [3, 2], [2, 0]] {
        sharp_cube.creases.push(Crease { points: edge, sharpness: 3.25 });
    }
    vec![
        ("cube", cube()),
        ("creased plane", creased),
        ("pentagonal pyramid", pentagon),
        ("cube with semi-sharp creases", sharp_cube),
    ]
}

/// Cages from the folder of real models, none if it is absent.
fn real_cages() -> Vec<(String, Mesh)> {
    let names = ["bishop", "rabbit", "suzanne", "spot_control_mesh", "monsterfrog"];
    let read = |name: &str| Some((name.to_string(), relievo_testing::cage(&format!("{name}.obj"))?));
    names.into_iter().filter_map(read).collect()
}

/// A deterministic sequence in 0..1.
fn halton(index: u32, base: u32) -> f64 {
    let (mut index, mut scale, mut value) = (index, 1.0, 0.0);
    while index > 0 {
        scale /= f64::from(base);
        value += scale * f64::from(index % base);
        index /= base;
    }
    value
}

fn places(tiles: usize, per_tile: u32) -> Vec<Place> {
    let mut places = Vec::new();
    for tile in 0..tiles as u32 {
        for k in 0..per_tile {
            let index = tile * per_tile + k + 1;
            let (mut u, mut v) = (halton(index, 2) as f32, halton(index, 3) as f32);
            match k % 5 {
                // Corners, edges, and close to a corner, where the patches are small.
                0 => (u, v) = (u.round(), v.round()),
                1 => u = u.round(),
                2 => (u, v) = (u * u * u * u * u, v * v * v * v),
                _ => {}
            }
            places.push(Place { tile, u, v });
        }
    }
    places
}

#[test]
fn evaluation_agrees_with_opensubdiv_on_the_same_table() {
    let context = Context::serial();
    let cages = cages().into_iter().map(|(name, mesh)| (name.to_string(), mesh)).chain(real_cages());
    let mut kinds = [0; 3];
    for (name, mesh) in cages {
        let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
        let table = surface.table();
        let extent = f64::from(surface.extent());
        let all = surface.table_points(&context, &mesh.points);
        let places = places(surface.tile_count(), 20);
        let asked: Vec<_> = places.iter().map(|place| (place.tile, f64::from(place.u), f64::from(place.v))).collect();
        let expected = reference::evaluate(table, &all, &asked).unwrap();
        let mut samples = Samples::default();
        surface.evaluate(&context, &places, Order::Second, &mut samples).unwrap();
        for (index, (place, expected)) in places.iter().zip(&expected).enumerate() {
            // EvaluateBasis takes single-crease patches for infinitely sharp ones; they have a test of their own.
            let records: Vec<_> = table.patches().iter().filter(|record| record.tile == place.tile).collect();
            let record = records.iter().filter(|record| {
                let size = (-f32::from(record.depth)).exp2();
                let inside =
                    |value: f32, low: u16| value >= f32::from(low) * size && value <= f32::from(low + 1) * size;
                inside(place.u, record.u) && inside(place.v, record.v)
            });
            let touching: Vec<_> = record.collect();
            let Some(deepest) = touching.iter().map(|record| i32::from(record.depth)).max() else { continue };
            if touching.iter().any(|record| matches!(record.kind, PatchKind::SingleCrease { .. })) {
                kinds[1] += 1;
                continue;
            }
            kinds[if touching.iter().any(|record| record.kind == PatchKind::Gregory) { 2 } else { 0 }] += 1;
            let got = [&samples.p, &samples.du, &samples.dv, &samples.duu, &samples.duv, &samples.dvv];
            for (quantity, (got, expected)) in got.iter().zip(expected).enumerate() {
                let order = [0, 1, 1, 2, 2, 2][quantity];
                // Where patches meet, the two may choose different ones, which agree only up to first derivatives, and
                // at Gregory patches only in position.
                let tolerance = 1e-6 * extent * f64::from(1 << (order * deepest));
                let free = match order {
                    0 => false,
                    1 => touching.len() > 1 && touching.iter().any(|record| record.kind == PatchKind::Gregory),
                    _ => touching.len() > 1,
                };
                for axis in 0..3 {
                    let difference = (f64::from(got[axis][index]) - expected[axis]).abs();
                    assert!(
                        free || difference <= tolerance,
                        "{name}, {place:?}, quantity {quantity}, axis {axis}: {} and {} (depth {deepest})",
                        got[axis][index],
                        expected[axis]
                    );
                }
            }
        }
    }
    println!("places in regular, single-crease and Gregory patches: {kinds:?}");
    assert!(kinds.iter().all(|count| *count > 100));
}

#[test]
fn single_crease_patches_agree_with_isolation_ten() {
    let context = Context::serial();
    let crease = |mut mesh: Mesh, edges: &[[u32; 2]], sharpness: f32| {
        mesh.creases = edges.iter().map(|points| Crease { points: *points, sharpness }).collect();
        mesh
    };
    let row: Vec<[u32; 2]> = (0..6).map(|k| [21 + k, 22 + k]).collect();
    let column: Vec<[u32; 2]> = (0..6).map(|k| [3 + 7 * k, 10 + 7 * k]).collect();
    for sharpness in [0.5, 1.0, 2.5, 3.75, 6.0] {
        for edges in [&row, &column] {
            let mesh = crease(plane(6, |x, y| (x * 1.3).sin() + (y * 0.7).cos()), edges, sharpness);
            let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
            let single =
                |record: &&relievo_opensubdiv::PatchRecord| matches!(record.kind, PatchKind::SingleCrease { .. });
            assert!(surface.table().patches().iter().filter(single).count() >= 8);
            let options = relievo_opensubdiv::Options {
                boundary: Default::default(),
                isolation: 10,
                single_crease: false,
                patch_limit: 1e7,
                memory_limit: u64::MAX,
            };
            let table = relievo_opensubdiv::Table::new(&mesh, &options).unwrap();
            let fine = points(&table, &mesh);
            let places = places(surface.tile_count(), 24);
            let asked: Vec<_> = places.iter().map(|p| (p.tile, f64::from(p.u), f64::from(p.v))).collect();
            let expected = reference::evaluate(&table, &fine, &asked).unwrap();
            let mut samples = Samples::default();
            surface.evaluate(&context, &places, Order::Position, &mut samples).unwrap();
            let tolerance = 1e-5 * f64::from(surface.extent());
            for (index, expected) in expected.iter().enumerate() {
                for axis in 0..3 {
                    let difference = (f64::from(samples.p[axis][index]) - expected[0][axis]).abs();
                    assert!(difference < tolerance, "sharpness {sharpness}, {:?}: {difference}", places[index]);
                }
            }
        }
    }
}

/// All points of a table in f64.
fn points(table: &relievo_opensubdiv::Table, mesh: &Mesh) -> Vec<[f64; 3]> {
    let mut all: Vec<[f64; 3]> = mesh.points.iter().map(|point| point.map(f64::from)).collect();
    let (indices, weights) = table.stencil_weights();
    let mut first = 0;
    for size in table.stencil_sizes() {
        let range = first..first + *size as usize;
        first = range.end;
        let mut sum = [0.0; 3];
        for (index, weight) in indices[range.clone()].iter().zip(&weights[range]) {
            for axis in 0..3 {
                sum[axis] += weight * f64::from(mesh.points[*index as usize][axis]);
            }
        }
        all.push(sum);
    }
    all
}

#[test]
fn level_six_is_as_close_to_isolation_ten_as_opensubdiv_is() {
    // A Gregory patch errs by a fixed share of its own size, so next to extraordinary points of high valence or in very
    // coarse cages OpenSubdiv's own level 6 is more than 1e-4 away; what we add to that stays far below.
    let context = Context::serial();
    for (name, mesh) in cages().into_iter().map(|(name, mesh)| (name.to_string(), mesh)).chain(real_cages()) {
        let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
        let places = places(surface.tile_count(), 10);
        let asked: Vec<_> = places.iter().map(|p| (p.tile, f64::from(p.u), f64::from(p.v))).collect();
        let of_level = |isolation| {
            let options = relievo_opensubdiv::Options {
                boundary: Default::default(),
                isolation,
                single_crease: false,
                patch_limit: 1e8,
                memory_limit: u64::MAX,
            };
            let table = relievo_opensubdiv::Table::new(&mesh, &options).unwrap();
            reference::evaluate(&table, &points(&table, &mesh), &asked).unwrap()
        };
        let (six, ten) = (of_level(6), of_level(10));
        let mut samples = Samples::default();
        surface.evaluate(&context, &places, Order::Position, &mut samples).unwrap();
        let extent = f64::from(surface.extent());
        let (mut worst, mut added) = (0.0_f64, 0.0_f64);
        for index in 0..places.len() {
            let distance =
                |from: [f64; 3]| (0..3).map(|axis| (from[axis] - ten[index][0][axis]).powi(2)).sum::<f64>().sqrt();
            let ours = distance([0, 1, 2].map(|axis| f64::from(samples.p[axis][index]))) / extent;
            worst = worst.max(ours);
            added = added.max(ours - distance(six[index][0]) / extent);
        }
        println!("{name}: {worst:.1e} of the extent from isolation 10, {added:.1e} of it ours");
        assert!(added < 1e-5, "{name}: {added:e}");
        assert!(worst < 1e-4 || !["cube", "monsterfrog"].contains(&name.as_str()), "{name}: {worst:e}");
    }
}

#[test]
fn grids_agree_with_single_places_at_every_size_and_rectangle() {
    let context = Context::serial();
    for (name, mesh) in cages() {
        let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
        for tile in 0..surface.tile_count() as u32 {
            for size in [1, 7, 8, 128] {
                for placement in [Placement::Centred, Placement::Lattice] {
                    let mut grid = Grid::whole(size, placement);
                    if size == 128 {
                        grid = Grid { columns: 37..113, rows: 120..128, ..grid };
                    }
                    let mut samples = Samples::default();
                    surface.grid(context.level(), tile, &grid, Order::Second, &mut samples);
                    assert_eq!(samples.len(), grid.len());
                    let mut streamed = Samples::default();
                    streamed.resize(Order::Second, grid.len());
                    let target = &mut streamed.as_slices();
                    surface.grid_into(context.level(), tile, &grid, Order::Second, Destination::Memory, target);
                    assert!(streamed == samples, "{name}, tile {tile}");
                    for (index, j) in grid.rows.clone().enumerate() {
                        for (column, i) in grid.columns.clone().enumerate() {
                            let place = Place { tile, u: grid.parameter(i), v: grid.parameter(j) };
                            let one = surface.sample(context.level(), place).unwrap();
                            let k = index * grid.columns.len() + column;
                            let quantities = [
                                (&samples.p, one.p, 1e-6),
                                (&samples.du, one.du, 1e-5),
                                (&samples.dv, one.dv, 1e-5),
                                (&samples.duu, one.duu, 1e-3),
                                (&samples.duv, one.duv, 1e-3),
                                (&samples.dvv, one.dvv, 1e-3),
                            ];
                            for (got, expected, tolerance) in quantities {
                                for axis in 0..3 {
                                    let difference = (got[axis][k] - expected[axis]).abs();
                                    let scale = surface.extent().max(expected[axis].abs());
                                    assert!(difference <= tolerance * scale, "{name}, {place:?}: {difference}");
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_flat_cage_gives_a_flat_surface_with_unit_derivatives() {
    let context = Context::serial();
    let surface = Surface::new(&context, &plane(4, |_, _| 0.0), &SurfaceOptions::default()).unwrap();
    for place in places(surface.tile_count(), 10) {
        let sample = surface.sample(context.level(), place).unwrap();
        assert_eq!(sample.p[2], 0.0);
        assert_eq!(sample.normal(), [0.0, 0.0, 1.0]);
    }
    // Corners of the boundary keep their places.
    let corner = surface.sample(context.level(), Place { tile: 0, u: 0.0, v: 0.0 }).unwrap();
    assert_eq!(corner.p, [0.0, 0.0, 0.0]);
}

#[test]
fn bounds_and_cones_contain_what_they_bound() {
    let context = Context::serial();
    for (name, mesh) in cages() {
        let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
        let slack = 1e-6 * surface.extent();
        for tile in 0..surface.tile_count() as u32 {
            let (low, high) = surface.tile_bounds(tile);
            for patch in surface.patches(tile) {
                let cone = patch.normals();
                for k in 1..30 {
                    let (a, b) = (halton(k, 2) as f32, halton(k, 3) as f32);
                    let [u, v] = [0, 1].map(|i| patch.patch.low[i] + [a, b][i] * patch.patch.size[i]);
                    let sample = surface.sample(context.level(), Place { tile, u, v }).unwrap();
                    for axis in 0..3 {
                        let inside = low[axis] - slack <= sample.p[axis] && sample.p[axis] <= high[axis] + slack;
                        assert!(inside, "{name}, tile {tile}");
                    }
                    let cosine: f32 = (0..3).map(|axis| sample.normal()[axis] * cone.axis[axis]).sum();
                    assert!(cosine >= cone.cosine - 1e-4, "{name}, tile {tile}: {cosine} and {}", cone.cosine);
                }
            }
        }
    }
}

#[test]
fn poses_share_topology_and_follow_the_points() {
    let context = Context::serial();
    let mesh = plane(4, |x, y| x * y * 0.1);
    let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
    let moved: Vec<[f32; 3]> = mesh.points.iter().map(|p| [2.0 * p[0] + 1.0, p[1], p[2] - 3.0]).collect();
    let posed = surface.posed(&context, &moved).unwrap();
    let fresh = Surface::new(&context, &Mesh { points: moved.clone(), ..mesh }, &SurfaceOptions::default()).unwrap();
    for place in places(surface.tile_count(), 8) {
        assert_eq!(posed.sample(context.level(), place).unwrap(), fresh.sample(context.level(), place).unwrap());
    }
    assert!(surface.posed(&context, &moved[1..]).is_err());
}

#[test]
fn bad_places_and_exploding_cages_are_errors() {
    let context = Context::serial();
    let surface = Surface::new(&context, &cube(), &SurfaceOptions::default()).unwrap();
    for place in [Place::new(6, 0.5, 0.5), Place::new(0, f32::NAN, 0.5), Place::new(0, 0.5, 1.5)] {
        assert!(surface.sample(context.level(), place).is_err());
        assert!(surface.evaluate(&context, &[place], Order::First, &mut Samples::default()).is_err());
    }
    // Crossing creases cannot be single-crease patches, so a sharpness of nine refines along all of them.
    let mut mesh = plane(12, |_, _| 0.0);
    for j in 0..=12 {
        for i in 0..12 {
            mesh.creases.push(Crease { points: [13 * j + i, 13 * j + i + 1], sharpness: 9.0 });
            mesh.creases.push(Crease { points: [13 * i + j, 13 * (i + 1) + j], sharpness: 8.5 });
        }
    }
    let options = SurfaceOptions { patch_limit: 20_000, ..Default::default() };
    let error = Surface::new(&context, &mesh, &options).unwrap_err();
    assert!(error.to_string().contains("patches are expected, more than the limit of 20000"), "{error}");
    let little = ContextOptions { threads: 1, memory_limit: 100_000 };
    let error = Surface::new(&Context::new(&little).unwrap(), &mesh, &SurfaceOptions::default()).unwrap_err();
    assert_eq!(error.kind, relievo_core::ErrorKind::Memory);
    assert!(error.what.contains("memory limit of 0.1 MB") && !error.remedy.contains("patch limit"), "{error}");
    let limited = Context::new(&ContextOptions { threads: 1, memory_limit: 8 << 20 }).unwrap();
    assert!(Surface::new(&limited, &mesh, &SurfaceOptions::default()).is_err());
}
