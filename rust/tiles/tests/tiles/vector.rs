//! Vector displacement: closed forms, normals by finite differences, seams, rings on any cage, documents.

use glam::Vec3;
use half::f16;
use proptest::prelude::*;
use relievo_core::simd::Level;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_document::Document;
use relievo_surface::{Link, Place, Surface, SurfaceOptions};
use relievo_testing::{Random, cage, grid};
use relievo_tiles::{
    Change, ChannelOptions, Displaced, Displacement, Points, Sets, Texel, Vector, VectorDisplacement, uniform_rates,
};

fn surface(mesh: &Mesh) -> Surface {
    Surface::new(&Context::serial(), mesh, &SurfaceOptions::default()).unwrap()
}

fn options(size: u32) -> ChannelOptions {
    ChannelOptions { size, ..ChannelOptions::default() }
}

/// T, B and N.
fn frame(surface: &Surface, place: Place) -> [Vec3; 3] {
    let sample = surface.sample(Level::best(), place).unwrap();
    let (t, n) = (Vec3::from(sample.du).normalize_or_zero(), Vec3::from(sample.normal()));
    [t, n.cross(t), n]
}

/// Writes to each of `tiles` the field `of`, a vector in object space at a place.
fn write(
    channel: &mut VectorDisplacement,
    surface: &Surface,
    tiles: &[u32],
    of: impl Fn(Place) -> Vec3 + Sync,
) -> Vec<u32> {
    let context = Context::serial();
    let mut refused = channel.apply(&Sets { allocate: tiles.to_vec(), ..Sets::default() }).unwrap().refused;
    let tiles: Vec<u32> = tiles.iter().copied().filter(|tile| channel.field().is_allocated(*tile)).collect();
    let changes = channel.edit(&context, &tiles, |tile, texels| {
        let size = texels.size();
        let at = |k: usize| (k as f32 + 0.5) / size as f32;
        for j in 0..size {
            for (i, texel) in texels.row_mut(j).iter_mut().enumerate() {
                let place = Place::new(tile, at(i), at(j));
                let vector = of(place);
                *texel = Vector(frame(surface, place).map(|axis| f16::from_f32(axis.dot(vector))));
            }
        }
    });
    refused.extend(channel.settle(&context, &changes.unwrap()).unwrap());
    refused
}

fn all(surface: &Surface) -> Vec<u32> {
    (0..surface.tile_count() as u32).collect()
}

/// Places inside tiles, on edges and at corners.
fn places(surface: &Surface) -> Vec<Place> {
    let parameters = [0.0, 0.01, 0.25, 0.5, 0.8, 0.999, 1.0];
    let of = |tile: u32| parameters.iter().flat_map(move |u| parameters.map(|v| Place::new(tile, *u, v)));
    all(surface).into_iter().flat_map(of).collect()
}

/// Whether a place is away from vertices.
fn away(place: &Place) -> bool {
    let near = |t: f32| !(0.2..=0.8).contains(&t);
    !(near(place.u) && near(place.v))
}

fn evaluate(surface: &Surface, vectors: Option<&VectorDisplacement>, places: &[Place]) -> Points {
    let nothing = Displacement::new(surface.topology().clone(), &options(16)).unwrap();
    let mut displaced = Displaced::new(surface, nothing.field()).unwrap();
    if let Some(vectors) = vectors {
        displaced = displaced.with_vectors(vectors.field()).unwrap();
    }
    let mut points = Points::default();
    displaced.evaluate(&Context::serial(), places, &mut points).unwrap();
    points
}

/// The largest distance of points, and the largest angle of normals.
fn compare(a: &Points, b: &Points, shift: Vec3) -> (f32, f32) {
    let largest = |of: &dyn Fn(usize) -> f32| (0..a.p.len()).map(of).fold(0.0, f32::max);
    let distance = largest(&|i| (Vec3::from(a.p[i]) + shift - Vec3::from(b.p[i])).length());
    (distance, largest(&|i| Vec3::from(a.normal[i]).angle_between(Vec3::from(b.normal[i]))))
}

#[test]
fn one_vector_all_over_a_plane_moves_it_whatever_way_its_faces_run() {
    for choices in [vec![2], vec![2, 6, 10, 14], vec![2, 0x36, 10, 14, 0x3a, 6]] {
        let mut mesh = grid(4, false, &choices, true);
        mesh.points.iter_mut().for_each(|p| p[2] = 0.0);
        let surface = surface(&mesh);
        let mut channel = VectorDisplacement::on(&surface, &options(16)).unwrap();
        let shift = Vec3::new(0.25, -0.5, 0.125);
        assert_eq!(write(&mut channel, &surface, &all(&surface), |_| shift), Vec::<u32>::new());
        let mut places = places(&surface);
        if choices.len() > 4 {
            // Where faces are wound against each other edges are sharp, and tangents turn at their ends.
            places.retain(away);
        }
        let (moved, turned) =
            compare(&evaluate(&surface, None, &places), &evaluate(&surface, Some(&channel), &places), shift);
        assert!(moved < 2e-3 && turned < 0.02, "{moved} {turned} {choices:?}");
    }
}

#[test]
fn one_vector_all_over_a_curved_cage_moves_it_also_at_extraordinary_vertices() {
    for name in ["spot_control_mesh.obj", "rabbit.obj"] {
        let Some(mesh) = cage(name) else { return };
        let surface = surface(&mesh);
        let face_sizes = (0..mesh.face_count() as u32).step_by(5).map(|face| (face, 64)).collect();
        let mut channel = VectorDisplacement::on(&surface, &ChannelOptions { face_sizes, ..options(32) }).unwrap();
        let extent = surface.extent();
        let shift = 0.05 * extent * Vec3::new(0.6, -0.64, 0.48);
        write(&mut channel, &surface, &all(&surface), |_| shift);
        let places = places(&surface);
        let (moved, _) =
            compare(&evaluate(&surface, None, &places), &evaluate(&surface, Some(&channel), &places), shift);
        // The tangent turns at any scale around an extraordinary vertex, and a texel has one frame.
        assert!(moved < 0.8 * shift.length(), "{name}: {} of the shift", moved / shift.length());
        let inner: Vec<Place> = places.into_iter().filter(away).collect();
        let distances: Vec<f32> = {
            let (a, b) = (evaluate(&surface, None, &inner), evaluate(&surface, Some(&channel), &inner));
            a.p.iter().zip(&b.p).map(|(a, b)| (Vec3::from(*a) + shift - Vec3::from(*b)).length()).collect()
        };
        let mean = distances.iter().sum::<f32>() / distances.len() as f32;
        let far = distances.iter().filter(|distance| **distance > 0.02 * shift.length()).count();
        assert!(mean < 0.01 * shift.length(), "{name}: {} of the shift", mean / shift.length());
        assert!(10 * far < distances.len(), "{name}: {far} of {}", distances.len());
    }
}

#[test]
fn along_the_normal_it_is_the_scalar_displacement() {
    let Some(mesh) = cage("suzanne.obj") else { return };
    let (surface, context) = (surface(&mesh), Context::serial());
    let mut scalar = Displacement::new(surface.topology().clone(), &options(16)).unwrap();
    let mut vector = VectorDisplacement::on(&surface, &options(16)).unwrap();
    let tiles: Vec<u32> = all(&surface).into_iter().step_by(3).collect();
    let height = |tile: u32, k: usize| {
        let mut random = Random(u64::from(tile) << 20 | k as u64);
        f16::from_f32(0.03 * (random.unit() + random.unit()))
    };
    let sets = Sets { allocate: tiles.clone(), ..Sets::default() };
    scalar.apply(&sets).unwrap();
    vector.apply(&sets).unwrap();
    let a = scalar.edit(&context, &tiles, |tile, texels| {
        for j in 0..texels.size() {
            texels.row_mut(j).iter_mut().enumerate().for_each(|(i, texel)| *texel = height(tile, 16 * j + i));
        }
    });
    let b = vector.edit(&context, &tiles, |tile, texels| {
        for j in 0..texels.size() {
            let row = texels.row_mut(j).iter_mut().enumerate();
            row.for_each(|(i, texel)| *texel = Vector([f16::ZERO, f16::ZERO, height(tile, 16 * j + i)]));
        }
    });
    scalar.settle(&context, &a.unwrap()).unwrap();
    vector.settle(&context, &b.unwrap()).unwrap();
    let places = places(&surface);
    let mut points = Points::default();
    Displaced::new(&surface, scalar.field()).unwrap().evaluate(&context, &places, &mut points).unwrap();
    let (moved, turned) = compare(&points, &evaluate(&surface, Some(&vector), &places), Vec3::ZERO);
    assert!(moved < 1e-6 * surface.extent() && turned < 1e-2, "{moved} {turned}");
}

/// A smooth field of vectors, as long as `length`, in about half of the tiles, and dents beneath it.
fn waves(surface: &Surface, length: f32) -> (Displacement, VectorDisplacement) {
    let context = Context::serial();
    let face_sizes = (0..surface.topology().face_count() as u32).step_by(7).map(|face| (face, 64)).collect();
    let mut vectors = VectorDisplacement::on(surface, &ChannelOptions { face_sizes, ..options(16) }).unwrap();
    let tiles: Vec<u32> = all(surface).into_iter().filter(|tile| tile * 7 % 5 < 3).collect();
    let scale = 12.0 / surface.extent();
    write(&mut vectors, surface, &tiles, |place| {
        let p = scale * Vec3::from(surface.sample(Level::best(), place).unwrap().p);
        length * Vec3::new(p.y.sin(), (p.z + 1.0).cos(), (p.x - p.y).sin())
    });
    let mut scalar = Displacement::new(surface.topology().clone(), &options(32)).unwrap();
    let tiles: Vec<u32> = all(surface).into_iter().filter(|tile| tile % 4 < 2).collect();
    scalar.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let changes = scalar.edit(&context, &tiles, |tile, texels| {
        for j in 0..texels.size() {
            let wave = |i: usize| 0.3 * length * (0.2 * i as f32 + tile as f32).sin() * (0.15 * j as f32).cos();
            texels.row_mut(j).iter_mut().enumerate().for_each(|(i, texel)| *texel = f16::from_f32(wave(i)));
        }
    });
    scalar.settle(&context, &changes.unwrap()).unwrap();
    (scalar, vectors)
}

#[test]
fn normals_are_those_of_finite_differences() {
    let Some(mesh) = cage("spot_control_mesh.obj") else { return };
    let (surface, context) = (surface(&mesh), Context::serial());
    let (scalar, vectors) = waves(&surface, surface.extent() / 100.0);
    let displaced = Displaced::new(&surface, scalar.field()).unwrap().with_vectors(vectors.field()).unwrap();
    let (mut random, h, mut worst) = (Random(4), 1.0 / 512.0, 0f32);
    for tile in vectors.field().allocated() {
        let (u, v) = (0.1 + 0.8 * random.unit(), 0.1 + 0.8 * random.unit());
        let at = |u, v| displaced.sample(&context, Place::new(tile, u, v)).unwrap();
        let p = |u, v| Vec3::from(at(u, v).0);
        let normal = Vec3::from(at(u, v).1);
        assert!((normal.length() - 1.0).abs() < 1e-5);
        worst = worst.max(normal.angle_between((p(u + h, v) - p(u - h, v)).cross(p(u, v + h) - p(u, v - h))));
    }
    assert!(worst < 0.03, "{worst} radians");
}

#[test]
fn seams_are_equal_to_the_bit_and_surfaces_meet_there() {
    for name in ["rabbit.obj", "suzanne.obj", "bishop.obj"] {
        let Some(mesh) = cage(name) else { return };
        let surface = surface(&mesh);
        let length = surface.extent() / 100.0;
        let (scalar, vectors) = waves(&surface, length);
        assert!(vectors.field().allocated().count() > 50);
        let displaced = Displaced::new(&surface, scalar.field()).unwrap().with_vectors(vectors.field()).unwrap();
        let topology = surface.topology();
        let turn = |t: f32, reversed: bool| if reversed { t } else { 1.0 - t };
        let (mut here, mut there, mut beside) = (Vec::new(), Vec::new(), Vec::new());
        for tile in all(&surface) {
            for edge in 0..4 {
                for t in [0.0, 0.125, 0.3125, 0.5, 0.71875] {
                    let (side, s) = match topology.link(tile, edge) {
                        Link::Whole { side, reversed } => (side, turn(t, reversed)),
                        Link::Half { side, second, reversed } => {
                            (side, turn(t, reversed) / 2.0 + if second { 0.5 } else { 0.0 })
                        }
                        _ => continue,
                    };
                    let place = Place::on_edge(tile, edge, t);
                    here.push(place);
                    there.push(Place::on_edge(side.tile, side.edge, s));
                    let inward = |x: f32, across: bool| if across { x + (0.5 - x).signum() * 1e-4 } else { x };
                    beside.push(Place::new(tile, inward(place.u, edge & 1 == 1), inward(place.v, edge & 1 == 0)));
                }
            }
        }
        let bits = |points: &Points| -> Vec<[u32; 3]> { points.p.iter().map(|p| p.map(f32::to_bits)).collect() };
        let (mut a, mut b, mut c) = (Points::default(), Points::default(), Points::default());
        let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
        displaced.evaluate(&context, &here, &mut a).unwrap();
        displaced.evaluate(&Context::serial(), &there, &mut b).unwrap();
        displaced.evaluate(&context, &beside, &mut c).unwrap();
        assert_eq!(bits(&a), bits(&b), "{name}");
        // Beside the edge the surface is where it is on the edge, but for what it moves in 10⁻⁴ of a tile and for how
        // much frames turn within a texel.
        let steps: Vec<f32> = a.p.iter().zip(&c.p).map(|(a, b)| (Vec3::from(*a) - Vec3::from(*b)).length()).collect();
        let away = here.iter().zip(&steps).filter(|(place, _)| away(place));
        let worst = away.map(|(_, step)| *step).fold(0.0, f32::max);
        let mean = steps.iter().sum::<f32>() / steps.len() as f32;
        assert!(worst < 0.1 * length && mean < 6e-3 * length, "{name}: {} {}", worst / length, mean / length);
        // A mesh of it is closed where the cage is.
        let tessellation = displaced.tessellate(&context, &mesh, &uniform_rates(topology, 8)).unwrap();
        tessellation.mesh.check().unwrap();
        for tile in all(&surface) {
            let (low, high) = displaced.tile_bounds(tile);
            for (corner, point) in tessellation.mesh.corners.iter().enumerate().step_by(7) {
                if tessellation.tiles[corner / 3] == tile {
                    let p = tessellation.mesh.points[*point as usize];
                    assert!((0..3).all(|axis| low[axis] <= p[axis] && p[axis] <= high[axis]));
                }
            }
        }
    }
}

fn blocks(channel: &VectorDisplacement) -> Vec<Option<Vec<u8>>> {
    (0..channel.field().tile_count() as u32).map(|tile| channel.read(tile).unwrap()).collect()
}

/// Random strokes of whole rows, checked after each.
fn exercise(surface: &Surface, reversed: bool, seed: u64, budget: u64, context: &Context) -> VectorDisplacement {
    let mut random = Random(seed);
    let sizes = [(random.below(4) as u32, 8), (random.below(4) as u32, 64)];
    let face_sizes = sizes.into_iter().filter(|(face, _)| (*face as usize) < surface.topology().face_count()).collect();
    let mut channel = VectorDisplacement::on(surface, &ChannelOptions { size: 16, face_sizes, budget }).unwrap();
    let tiles = all(surface);
    for _ in 0..4 {
        let mut chosen: Vec<u32> = (0..1 + random.below(4)).map(|_| tiles[random.below(tiles.len())]).collect();
        chosen.sort_unstable();
        chosen.dedup();
        channel.apply(&Sets { allocate: chosen.clone(), ..Sets::default() }).unwrap();
        chosen.retain(|tile| channel.field().is_allocated(*tile));
        let seed = random.below(1 << 30) as u64;
        let changes = channel.edit(context, &chosen, |tile, texels| {
            let mut random = Random(seed ^ u64::from(tile) << 20);
            let (row, start) = (random.below(texels.size()), random.below(texels.size()));
            let mut any = || Vector([(); 3].map(|()| f16::from_f32(2.0 * random.unit() - 1.0)));
            texels.row_mut(row)[start..].fill_with(&mut any);
            texels.row_mut(start).fill_with(&mut any);
        });
        channel.settle(context, &changes.unwrap()).unwrap();
        // What was brought up to date step by step is what a whole update makes, and it is at rest.
        let everything: Vec<Change> = tiles.iter().copied().map(Change::all).collect();
        assert_eq!(channel.update_rings(context, &everything).unwrap(), Vec::<u32>::new());
        assert!(channel.bytes() <= budget);
        // At a vertex all tiles have one vector, but for how frames turn within a texel where texels are copied. Not so
        // on creases, which edges between faces wound against each other are: vectors turn with the normals there.
        let topology = surface.topology();
        for ring in 0..topology.ring_count() as u32 {
            let entries = topology.ring(ring);
            if topology.ring_class(ring) == relievo_surface::RingClass::Pinned {
                continue;
            }
            let world = |entry: &relievo_surface::Incidence| {
                let [a, b, c] = channel.field().vector(Level::best(), entry.place()).map(|jet| jet.d);
                let [t, across, n] = frame(surface, entry.place());
                a * t + b * across + c * n
            };
            // Not where tangents vanish or faces fold, which random cages have.
            let frames: Vec<[Vec3; 3]> = entries.iter().map(|entry| frame(surface, entry.place())).collect();
            if frames.iter().any(|[t, _, n]| t.length() < 0.9 || n.dot(frames[0][2]) < 0.9) {
                continue;
            }
            let copied = entries.len() == 4 || topology.ring_class(ring) == relievo_surface::RingClass::Tee;
            let (first, bound) = (world(&entries[0]), if copied { 0.2 } else { 0.01 });
            for entry in entries.iter().filter(|_| !reversed) {
                assert!((world(entry) - first).length() < bound, "ring {ring}: {first} {}", world(entry));
            }
        }
    }
    channel
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..Default::default() })]

    #[test]
    fn rings_are_at_rest_and_vertices_agree_on_any_torus(
        size in 3u32..6, choices in prop::collection::vec(any::<u8>(), 1..40), seed: u64, tight: bool,
        reversed: bool,
    ) {
        let surface = surface(&grid(size, true, &choices, reversed));
        let budget = if tight { 60_000 } else { 1 << 30 };
        let one = exercise(&surface, reversed, seed, budget, &Context::serial());
        let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
        prop_assert_eq!(blocks(&one), blocks(&exercise(&surface, reversed, seed, budget, &context)));
    }
}

#[test]
fn a_document_gives_it_back_to_the_bit_and_it_goes_on_from_there() {
    let (mesh, context) = (grid(4, true, &[2, 1, 0, 3, 6], true), Context::serial());
    let surface = surface(&mesh);
    let channel = exercise(&surface, true, 5, 1 << 30, &context);
    let mut document = Document::new(&mesh, "baseline").unwrap();
    channel.field().store(&context, &mut document, "push").unwrap();
    let document = Document::parse(&document.to_bytes().unwrap(), u64::MAX).unwrap();
    let mut again =
        VectorDisplacement::stored_on(&context, &surface, &document, "push", 1 << 30, None).unwrap().unwrap();
    assert_eq!((blocks(&again), again.bytes()), (blocks(&channel), channel.bytes()));
    let everything: Vec<Change> = all(&surface).into_iter().map(Change::all).collect();
    assert_eq!(again.update_rings(&context, &everything).unwrap(), Vec::<u32>::new());
    assert!(Displacement::stored(&context, surface.topology().clone(), &document, "push", 1 << 30).is_err());
}

#[test]
fn a_turned_over_neighbour_sees_the_other_normal() {
    let vector = Vector([0.5, -0.25, 2.0].map(f16::from_f32));
    assert_eq!(vector.flipped(), Vector([0.5, 0.25, -2.0].map(f16::from_f32)));
    assert_eq!(vector.flipped().flipped(), vector);
    assert!(!Vector::all_finite(&[Vector([f16::ZERO, f16::NAN, f16::ZERO])]));
}
