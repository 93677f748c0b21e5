//! The displacement across edges and vertices, after any edits on any cage.

use std::sync::Arc;

use half::f16;
use proptest::prelude::*;
use relievo_core::simd::Level;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_surface::{Link, Place, RingClass, Side, TileTopology};
use relievo_testing::{Random, cage, grid};
use relievo_tiles::spline::Jet;
use relievo_tiles::{Applied, Change, Displacement, DisplacementOptions, Field, Sets};

/// Tiles to allocate.
fn new(tiles: &[u32]) -> Sets {
    Sets { allocate: tiles.to_vec(), ..Sets::default() }
}

/// Random dents: whole rows, so that borders and corners are hit often.
fn dent(displacement: &mut Displacement, context: &Context, random: &mut Random, tiles: &[u32]) -> Vec<u32> {
    let Applied { changes: mut made, mut refused } = displacement.apply(&new(tiles)).unwrap();
    let tiles: Vec<u32> = tiles.iter().copied().filter(|tile| displacement.field().is_allocated(*tile)).collect();
    let seed = random.below(1 << 30) as u64;
    let changes = displacement.edit(context, &tiles, |tile, texels| {
        let mut random = Random(seed ^ u64::from(tile) << 20);
        for _ in 0..3 {
            let (row, start) = (random.below(texels.size()), random.below(texels.size()));
            texels.row_mut(row)[start..].fill_with(|| f16::from_f32(random.unit() - 0.75));
            texels.row_mut(start)[..row.max(1)].fill_with(|| f16::from_f32(random.unit() - 0.75));
        }
    });
    made.extend(changes.unwrap());
    refused.extend(displacement.settle(context, &made).unwrap());
    refused
}

fn jet(field: &Field, side: Side, t: f32) -> Jet {
    field.point(Level::best(), Place::on_edge(side.tile, side.edge, t))
}

/// Derivatives along the edge and into the tile, per unit of a base edge.
fn slopes(field: &Field, side: Side, jet: &Jet) -> (f32, f32) {
    let scale = if field.topology().is_sub(side.tile) { 2.0 } else { 1.0 };
    let (along, inward) = match side.edge {
        0 => (jet.du, jet.dv),
        1 => (jet.dv, -jet.du),
        2 => (-jet.du, -jet.dv),
        _ => (-jet.dv, jet.du),
    };
    (scale * along, scale * inward)
}

/// Checks both sides of every edge, and every vertex.
fn check(field: &Field) {
    let topology = field.topology();
    for tile in (0..topology.tile_count() as u32).filter(|tile| !topology.is_hole(*tile)) {
        for edge in 0..4 {
            let here = Side { tile, edge };
            for t in [0.0f32, 0.03, 0.2, 0.46, 0.5, 0.77, 0.99, 1.0] {
                let turn = |t: f32, reversed: bool| if reversed { t } else { 1.0 - t };
                let (other, s, reversed) = match topology.link(tile, edge) {
                    Link::Whole { side, reversed } => (side, turn(t, reversed), reversed),
                    Link::Half { side, second, reversed } => {
                        (side, turn(t, reversed) / 2.0 + if second { 0.5 } else { 0.0 }, reversed)
                    }
                    Link::Pinned { .. } => {
                        assert_eq!(jet(field, here, t).d, 0.0);
                        continue;
                    }
                    Link::Boundary | Link::Halves { .. } => continue,
                };
                let (a, b) = (jet(field, here, t), jet(field, other, s));
                let (sign, direction) = if reversed { (-1.0, 1.0) } else { (1.0, -1.0) };
                let densities = [field.density(tile), field.density(other.tile)];
                assert!((a.d - sign * b.d).abs() < 2e-3, "{here:?} {other:?} at {t}: {} {}", a.d, b.d);
                let ((along_a, inward_a), (along_b, inward_b)) = (slopes(field, here, &a), slopes(field, other, &b));
                if densities.contains(&0) {
                    assert_eq!([a.d, b.d, inward_a, inward_b], [0.0; 4], "{here:?} {other:?} at {t}");
                } else if densities[0] == densities[1] {
                    let bound = 1e-4 * densities[0] as f32;
                    assert!((along_a - sign * direction * along_b).abs() < bound, "{here:?} {other:?} at {t}");
                    assert!((inward_a + sign * inward_b).abs() < bound, "{here:?} {other:?} at {t}");
                }
            }
        }
    }
    for ring in 0..topology.ring_count() as u32 {
        let entries = topology.ring(ring);
        if topology.is_hole(entries[0].tile) {
            continue;
        }
        let jets: Vec<Jet> = entries.iter().map(|entry| field.point(Level::best(), entry.place())).collect();
        let whole = entries.iter().all(|entry| field.is_allocated(entry.tile));
        let sign = |flipped: bool| if flipped { -1.0 } else { 1.0 };
        for (jet, entry) in jets.iter().zip(entries) {
            if topology.ring_class(ring) == RingClass::Pinned || !whole {
                assert_eq!(jet.d, 0.0);
            } else {
                assert!((sign(entry.flipped) * jet.d - sign(entries[0].flipped) * jets[0].d).abs() < 2e-3);
                if topology.ring_class(ring) == RingClass::Extraordinary {
                    assert!(jet.du.abs() + jet.dv.abs() < 1e-3, "{ring} {jet:?}");
                }
            }
        }
    }
}

fn blocks(field: &Field) -> Vec<Option<Vec<u16>>> {
    let bits = |tile| field.block(tile).map(|block| block.iter().map(|c| c.to_bits()).collect());
    (0..field.tile_count() as u32).map(bits).collect()
}

fn displacement(mesh: &Mesh, options: &DisplacementOptions) -> Displacement {
    Displacement::new(Arc::new(TileTopology::new(mesh).unwrap()), options).unwrap()
}

/// Random edits with everything that may happen, checked after each.
fn exercise(mesh: &Mesh, options: &DisplacementOptions, seed: u64, context: &Context) -> Displacement {
    let mut random = Random(seed);
    let mut displacement = displacement(mesh, options);
    let usable: Vec<u32> = (0..displacement.field().tile_count() as u32)
        .filter(|tile| !displacement.field().topology().is_hole(*tile))
        .collect();
    for step in 0..6 {
        let mut tiles: Vec<u32> = (0..1 + random.below(4)).map(|_| usable[random.below(usable.len())]).collect();
        tiles.sort_unstable();
        tiles.dedup();
        let before = displacement.commit();
        let old = blocks(&before);
        if step == 3 {
            let gone = Sets { deallocate: tiles, ..Sets::default() };
            let applied = displacement.apply(&gone).unwrap();
            displacement.settle(context, &applied.changes).unwrap();
        } else if step == 4 {
            let faces: Vec<(u32, u32)> =
                tiles.iter().map(|tile| (displacement.field().topology().face(*tile), 8 << random.below(3))).collect();
            if let Err(error) = displacement.resize(context, &faces) {
                assert_eq!(error.kind, relievo_core::ErrorKind::Memory);
                assert_eq!(blocks(displacement.field()), old);
            }
        } else {
            let refused = dent(&mut displacement, context, &mut random, &tiles);
            assert!(refused.iter().all(|tile| !displacement.field().is_allocated(*tile)));
        }
        check(displacement.field());
        assert!(displacement.bytes() <= options.budget);
        let in_use: u64 = displacement.field().allocated().map(|tile| displacement.field().block_bytes(tile)).sum();
        assert_eq!(displacement.bytes(), in_use);
        // What was brought up to date step by step is what a whole update makes, and it is at rest.
        let all: Vec<Change> = usable.iter().copied().map(Change::all).collect();
        assert_eq!(displacement.update_rings(context, &all).unwrap(), Vec::<u32>::new(), "step {step}");
        // The old snapshot is as it was, and the new one lists exactly what may differ.
        assert_eq!(blocks(&before), old);
        let after = displacement.commit();
        for (tile, (old, new)) in old.iter().zip(blocks(&after)).enumerate() {
            assert!(*old == new || after.changed().contains(&(tile as u32)), "tile {tile} changed in secret");
        }
    }
    displacement
}

/// [`exercise`] on a mesh with holes and fins and faces of some sizes, with one thread and with several.
fn exercise_any(mut mesh: Mesh, seed: u64, sizes: &[(u32, u32)], holes: &[u32], fins: &[u32], tight: bool) {
    let faces = mesh.face_count() as u32;
    mesh.holes = if faces > 4 { holes.iter().map(|hole| hole % faces).collect() } else { vec![] };
    for fin in fins {
        let at = mesh.face_offsets()[(fin % faces) as usize] as usize;
        let new = mesh.points.len() as u32;
        mesh.points.extend([[9.0, 0.0, 1.0], [9.0, 0.0, 2.0]]);
        let face = [mesh.corners[at], mesh.corners[at + 1], new, new + 1];
        let count = if fin & 64 == 0 { 3 } else { 4 };
        mesh.face_sizes.push(count);
        mesh.corners.extend(&face[..count as usize]);
    }
    let face_sizes = sizes.iter().map(|(face, log)| (face % faces, 1 << log)).collect();
    let budget = if tight { 12_000 } else { 1 << 30 };
    let options = DisplacementOptions { size: 16, face_sizes, budget };
    let one = exercise(&mesh, &options, seed, &Context::serial());
    let context = Context::new(&ContextOptions { threads: 3, memory_limit: 0 }).unwrap();
    let many = exercise(&mesh, &options, seed, &context);
    assert_eq!(blocks(one.field()), blocks(many.field()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..Default::default() })]

    #[test]
    fn displacement_is_smooth_over_any_torus(
        size in 3u32..7, choices in prop::collection::vec(any::<u8>(), 1..40), seed: u64,
    ) {
        let options = DisplacementOptions { size: 16, ..Default::default() };
        exercise(&grid(size, true, &choices, true), &options, seed, &Context::serial());
    }

    #[test]
    fn sizes_holes_borders_fins_and_budgets_may_be_anything(
        size in 1u32..6, torus: bool, choices in prop::collection::vec(any::<u8>(), 1..40), seed: u64,
        sizes in prop::collection::vec((any::<u32>(), 3u32..7), 0..12), holes in prop::collection::vec(any::<u32>(), 0..3),
        fins in prop::collection::vec(any::<u32>(), 0..3), tight: bool,
    ) {
        let mesh = grid(if torus { size + 2 } else { size }, torus, &choices, true);
        exercise_any(mesh, seed, &sizes, &holes, &fins, tight);
    }
}

#[test]
fn a_tile_that_is_allocated_between_finer_ones_has_their_rings_brought_up_to_date() {
    let mesh = grid(3, true, &[196, 0, 18, 201, 58, 18, 170, 106, 102], true);
    let sizes = [
        (1098378601, 6),
        (1349693631, 5),
        (4094476445, 3),
        (2703002084, 5),
        (1209640730, 4),
        (602567472, 6),
        (1641520198, 5),
        (1302171263, 6),
        (2724526543, 4),
    ];
    exercise_any(mesh, 3974297728028297524, &sizes, &[], &[], true);
}

#[test]
fn cages_of_the_shared_data_are_smooth() {
    for name in ["rabbit.obj", "suzanne.obj", "spot_control_mesh.obj", "bishop.obj"] {
        let Some(mesh) = cage(name) else { return };
        let options = DisplacementOptions { size: 16, face_sizes: vec![(7, 64), (30, 8)], budget: 1 << 20 };
        exercise(&mesh, &options, 5, &Context::serial());
    }
}

#[test]
fn poles_and_faces_of_any_number_of_corners_are_smooth() {
    // A fan of 60 quads round a point, and a face of 60 corners on its other side.
    let mut mesh = Mesh::default();
    mesh.points.push([0.0, 0.0, 1.0]);
    for k in 0..120 {
        let angle = k as f32 * std::f32::consts::TAU / 120.0;
        mesh.points.push([angle.cos(), angle.sin(), 0.0]);
    }
    for k in 0..60 {
        mesh.face_sizes.push(4);
        mesh.corners.extend([0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % 120]);
    }
    mesh.face_sizes.push(120);
    mesh.corners.extend((1..=120).rev());
    let options = DisplacementOptions { size: 16, face_sizes: vec![(3, 64), (60, 128)], ..Default::default() };
    let displacement = exercise(&mesh, &options, 3, &Context::serial());
    let topology = displacement.field().topology();
    assert_eq!(topology.ring(topology.rings(0)[0]).len(), 60);
    assert_eq!(topology.ring(topology.rings(60)[2]).len(), 120);
}

#[test]
fn a_dent_inside_a_tile_touches_no_other() {
    let context = Context::serial();
    let mut displacement = displacement(&grid(4, true, &[2], false), &DisplacementOptions::default());
    displacement.apply(&new(&[5])).unwrap();
    let write = |_: u32, texels: &mut relievo_tiles::Texels<'_>| texels.row_mut(60)[20..90].fill(f16::from_f32(-0.5));
    let changes = displacement.edit(&context, &[5], write).unwrap();
    assert_eq!(changes, [Change { tile: 5, borders: 0 }]);
    assert_eq!(displacement.settle(&context, &changes), Ok(vec![]));
    assert_eq!(displacement.field().allocated().collect::<Vec<_>>(), [5]);
    assert_eq!(displacement.bytes(), 2 * 130 * 130);
    assert_eq!(displacement.full_bytes(), 16 * 2 * 130 * 130);
    // The same edit again changes nothing.
    assert_eq!(displacement.edit(&context, &[5], write).unwrap(), []);
    assert_eq!(displacement.commit().changed(), [5]);
    assert!(displacement.commit().changed().is_empty());
}

#[test]
fn a_border_allocates_its_neighbour_and_a_corner_all_four() {
    let context = Context::serial();
    let mut displacement = displacement(&grid(4, true, &[2], false), &DisplacementOptions::default());
    displacement.apply(&new(&[5])).unwrap();
    let changes = displacement.edit(&context, &[5], |_, texels| texels.row_mut(0)[64] = f16::ONE).unwrap();
    displacement.settle(&context, &changes).unwrap();
    assert_eq!(displacement.field().allocated().collect::<Vec<_>>(), [1, 5]);
    let changes = displacement.edit(&context, &[5], |_, texels| texels.row_mut(0)[0] = f16::ONE).unwrap();
    displacement.settle(&context, &changes).unwrap();
    assert_eq!(displacement.field().allocated().collect::<Vec<_>>(), [0, 1, 4, 5]);
}

#[test]
fn a_refused_neighbour_is_reported_and_its_border_stays_at_rest() {
    let context = Context::serial();
    let options = DisplacementOptions { budget: 3 * 2 * 130 * 130, ..Default::default() };
    let mut displacement = displacement(&grid(4, true, &[2], false), &options);
    let tiles = [5, 6];
    displacement.apply(&new(&tiles)).unwrap();
    let fill = |_: u32, texels: &mut relievo_tiles::Texels<'_>| {
        (0..texels.size()).for_each(|row| texels.row_mut(row).fill(f16::from_f32(-0.25)));
    };
    let changes = displacement.edit(&context, &tiles, fill).unwrap();
    let refused = displacement.settle(&context, &changes).unwrap();
    assert_eq!(refused.len(), 9, "ten neighbours, one of which fits");
    check(displacement.field());
    let middle = Place::new(5, 0.5, 0.5);
    assert!((displacement.field().point(Level::best(), middle).d + 0.25).abs() < 1e-6, "nothing is lost inside");
}

#[test]
fn a_finer_face_keeps_its_displacement_and_a_coarser_one_gives_it_back() {
    let context = Context::serial();
    let mesh = grid(4, true, &[2], false);
    let mut displacement = displacement(&mesh, &DisplacementOptions { size: 32, ..Default::default() });
    displacement.apply(&new(&[5])).unwrap();
    // Dents well inside the tile, in sixteenths, so that finer coefficients are exact.
    let changes = displacement.edit(&context, &[5], |_, texels| {
        let mut random = Random(11);
        (4..28).for_each(|j| texels.row_mut(j)[4..28].fill_with(|| f16::from_f32(random.below(16) as f32 / -16.0)));
    });
    displacement.settle(&context, &changes.unwrap()).unwrap();
    let before = displacement.commit();
    assert_eq!(displacement.resize(&context, &[(5, 128)]), Ok(vec![]));
    assert_eq!((displacement.bytes(), displacement.field().size(5)), (2 * 130 * 130, 128));
    assert_eq!(displacement.full_bytes(), 2 * (130 * 130 + 15 * 34 * 34));
    let mut random = Random(2);
    for _ in 0..200 {
        let place = Place::new(5, random.unit(), random.unit());
        let [a, b] = [before.field(), displacement.field()].map(|field| field.point(Level::best(), place));
        assert!((a.d - b.d).abs() < 1e-3 && (a.du - b.du).abs() < 0.1, "{a:?} {b:?}");
    }
    displacement.resize(&context, &[(5, 32)]).unwrap();
    let values = |field: &Field| -> Vec<f32> { field.block(5).unwrap().iter().map(|c| c.to_f32()).collect() };
    let pairs = values(before.field()).into_iter().zip(values(displacement.field()));
    assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 2e-3);
    displacement.set_budget(4000);
    assert!(displacement.resize(&context, &[(5, 64)]).is_err());
    assert!(displacement.resize(&context, &[(99, 64)]).is_err() && displacement.resize(&context, &[(5, 60)]).is_err());
    assert_eq!(displacement.field().size(5), 32);
}

#[test]
fn blocks_can_be_read_and_put_back_and_bad_ones_are_refused() {
    let context = Context::serial();
    let mesh = grid(4, true, &[2, 1, 0, 3], false);
    let mut one = displacement(&mesh, &DisplacementOptions { size: 32, ..Default::default() });
    dent(&mut one, &context, &mut Random(9), &[1, 3, 4]);
    let mut two = displacement(&mesh, &DisplacementOptions { size: 32, ..Default::default() });
    for tile in 0..one.field().tile_count() as u32 {
        two.write(tile, one.read(tile).unwrap().as_deref()).unwrap();
    }
    assert_eq!(blocks(one.field()), blocks(two.field()));
    assert_eq!(one.bytes(), two.bytes());
    let tile = one.field().allocated().next().unwrap();
    let mut bytes = one.read(tile).unwrap().unwrap();
    two.write(tile, None).unwrap();
    assert!(!two.field().is_allocated(tile));
    bytes[9] = 0x7c;
    bytes[8] = 0;
    assert!(two.write(tile, Some(&bytes)).is_err(), "infinity");
    assert!(two.write(tile, Some(&bytes[2..])).is_err(), "too short");
    assert!(two.write(99999, Some(&bytes)).is_err() && two.read(99999).is_err());
    assert!(!two.field().is_allocated(tile));
    two.set_budget(0);
    assert_eq!(two.write(tile, one.read(tile).unwrap().as_deref()).unwrap_err().kind, relievo_core::ErrorKind::Memory);
    assert!(two.edit(&context, &[tile], |_, _| ()).is_err(), "not allocated");
    assert!(one.edit(&context, &[tile, tile], |_, _| ()).is_err(), "twice");
    assert!(one.edit(&context, &[tile], |_, texels| texels.row_mut(0)[0] = f16::NAN).is_err());
}
