//! Tile topology of real cages: closed where they are, and of the right genus.

use relievo_surface::{Link, Place, RingClass, Side, TileTopology};
use relievo_testing::{Random, cage};

/// Vertices − edges + tiles.
fn euler(topology: &TileTopology) -> i64 {
    let sides = (0..topology.tile_count() as u32).flat_map(|tile| (0..4).map(move |edge| Side { tile, edge }));
    let owned = sides.filter(|side| topology.segments(*side)[0].is_some_and(|segment| segment.owner == *side));
    topology.ring_count() as i64 - owned.count() as i64 + topology.tile_count() as i64
}

#[test]
fn closed_cages_have_the_euler_number_of_their_points_edges_and_faces() {
    let expected = [
        ("bigguy.obj", 1450, 2),
        ("monsterfrog.obj", 1292, 16),
        ("quadknot.obj", 1440, 0),
        ("rabbit.obj", 176 * 3 + 496 + 6 * 16, 18),
        ("spot_control_mesh.obj", 4 * 3 + 160 + 16 * 5, 2),
        ("spot_quadrangulated.obj", 2928, 2),
    ];
    for (name, tiles, number) in expected {
        let Some(mesh) = cage(name) else { return };
        let topology = TileTopology::new(&mesh).unwrap();
        assert_eq!((topology.tile_count(), euler(&topology)), (tiles, number), "{name}");
        for tile in 0..tiles as u32 {
            let open = |link: &Link| matches!(link, Link::Boundary | Link::Pinned { .. });
            assert!(!topology.links(tile).iter().any(open), "{name}");
        }
    }
}

#[test]
fn open_and_crossing_cages_have_one_canonical_place_for_every_shared_point() {
    let names = ["armorguy.obj", "beast.obj", "bishop.obj", "car.obj", "suzanne.obj", "t-rex.obj", "target.obj"];
    for name in names {
        let Some(mesh) = cage(name) else { return };
        let topology = TileTopology::new(&mesh).unwrap();
        let density = |tile: u32| [0, 16, 64][Random(u64::from(tile)).below(3)];
        let mut borders = 0;
        for ring in 0..topology.ring_count() as u32 {
            let entries = topology.ring(ring);
            borders += usize::from(topology.ring_class(ring) == RingClass::Boundary);
            let first = topology.canonical(entries[0].place(), density);
            assert!(entries.iter().all(|entry| topology.canonical(entry.place(), density) == first), "{name} {ring}");
        }
        let closed = matches!(name, "beast.obj");
        assert_eq!(borders == 0, closed, "{name} has {borders} border vertices");
        for tile in 0..topology.tile_count() as u32 {
            let inside = Place::new(tile, 0.25, 0.75);
            assert_eq!(topology.canonical(inside, density), inside);
        }
    }
}
