//! The displaced surface: seams equal to the bit, normals those of the surface, closed forms.

use glam::Vec3;
use half::f16;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_surface::{
    Grid, Link, Order, Place, Placement, RingClass, Samples, Surface, SurfaceOptions, TriangleSurface,
};
use relievo_testing::{Random, cage, grid};
use relievo_tiles::triangle::{TriangleChannel, TriangleDisplaced, TriangleOptions, TriangleValues};
use relievo_tiles::{Change, Displaced, Displacement, DisplacementOptions, Points, Sets, Texels};

fn surface(mesh: &Mesh) -> Surface {
    Surface::new(&Context::serial(), mesh, &SurfaceOptions::default()).unwrap()
}

fn fill(texels: &mut Texels<'_>, of: impl Fn(f32, f32) -> f32) {
    let size = texels.size();
    for j in 0..size {
        for (i, c) in texels.row_mut(j).iter_mut().enumerate() {
            *c = f16::from_f32(of((i as f32 + 0.5) / size as f32, (j as f32 + 0.5) / size as f32));
        }
    }
}

/// Makes a displacement of 32 texels a side with dents of up to a 200th of the extent.
fn slightly_dented(surface: &Surface) -> Displacement {
    dented(surface, &DisplacementOptions { size: 32, ..Default::default() }, surface.extent() / 200.0)
}

/// A displacement with dents of up to `depth` in about half of the tiles.
fn dented(surface: &Surface, options: &DisplacementOptions, depth: f32) -> Displacement {
    let context = Context::serial();
    let mut displacement = Displacement::new(surface.topology().clone(), options).unwrap();
    let tiles: Vec<u32> = (0..surface.tile_count() as u32).filter(|tile| tile * 7 % 5 < 2).collect();
    displacement.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let changes = displacement.edit(&context, &tiles, |tile, texels| {
        let mut random = Random(u64::from(tile));
        let (a, b, c) = (random.unit(), random.unit(), 2.0 + 4.0 * random.unit());
        fill(texels, |u, v| -depth * (0.6 + 0.4 * ((u - a) * c).sin() * ((v - b) * c).cos()));
    });
    displacement.settle(&context, &changes.unwrap()).unwrap();
    displacement
}

/// The places across each edge that coincide with a place of it.
fn seams(surface: &Surface) -> Vec<(Place, Place)> {
    let topology = surface.topology();
    let mut pairs = Vec::new();
    for tile in 0..surface.tile_count() as u32 {
        for edge in 0..4 {
            for t in [0.0, 0.125, 0.3125, 0.5, 0.71875, 1.0] {
                let here = Place::on_edge(tile, edge, t);
                let turn = |t: f32, reversed: bool| if reversed { t } else { 1.0 - t };
                match topology.link(tile, edge) {
                    Link::Whole { side, reversed } => {
                        pairs.push((here, Place::on_edge(side.tile, side.edge, turn(t, reversed))));
                    }
                    Link::Half { side, second, reversed } => {
                        let t = turn(t, reversed) / 2.0 + if second { 0.5 } else { 0.0 };
                        pairs.push((here, Place::on_edge(side.tile, side.edge, t)));
                    }
                    _ => {}
                }
            }
        }
    }
    for ring in 0..topology.ring_count() as u32 {
        pairs.extend(topology.ring(ring).windows(2).map(|pair| (pair[0].place(), pair[1].place())));
    }
    pairs
}

fn bits(points: &[[f32; 3]]) -> Vec<[u32; 3]> {
    points.iter().map(|p| p.map(f32::to_bits)).collect()
}

#[test]
fn seams_are_equal_to_the_bit_on_real_cages() {
    for name in ["rabbit.obj", "suzanne.obj", "spot_control_mesh.obj", "bishop.obj"] {
        let Some(mesh) = cage(name) else { return };
        let surface = surface(&mesh);
        let face_sizes = (0..mesh.face_count() as u32).step_by(9).map(|face| (face, 64)).collect();
        let options = DisplacementOptions { size: 16, face_sizes, budget: 600_000 };
        let displacement = dented(&surface, &options, surface.extent() / 100.0);
        assert!(displacement.field().allocated().count() > 50);
        let displaced = Displaced::new(&surface, displacement.field()).unwrap();
        let (here, there): (Vec<Place>, Vec<Place>) = seams(&surface).into_iter().unzip();
        let (mut a, mut b) = (Points::default(), Points::default());
        let context = Context::new(&ContextOptions { threads: 2, memory_limit: 0 }).unwrap();
        displaced.evaluate(&context, &here, &mut a).unwrap();
        displaced.evaluate(&Context::serial(), &there, &mut b).unwrap();
        assert_eq!(bits(&a.p), bits(&b.p), "{name}");
        assert_eq!(bits(&a.normal), bits(&b.normal), "{name}");
        // Lattices of neighbouring tiles have the same points on their edges.
        for (here, there) in here.iter().zip(&there).step_by(97) {
            let mut points = [Points::default(), Points::default()];
            let index = |place: &Place| (place.v * 64.0) as usize * 65 + (place.u * 64.0) as usize;
            let at = [here, there].map(|place| (place.tile, index(place)));
            for (points, (tile, _)) in points.iter_mut().zip(at) {
                displaced.grid(&context, tile, &Grid::whole(64, Placement::Lattice), points).unwrap();
            }
            assert_eq!(bits(&[points[0].p[at[0].1]]), bits(&[points[1].p[at[1].1]]), "{name} {here:?} {there:?}");
        }
    }
}

#[test]
fn the_normal_is_that_of_finite_differences_and_of_unit_length() {
    let Some(mesh) = cage("spot_control_mesh.obj") else { return };
    let surface = surface(&mesh);
    let context = Context::serial();
    let displacement = slightly_dented(&surface);
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let mut random = Random(4);
    let mut worst = 0f32;
    let h = 1.0 / 512.0;
    for tile in displacement.field().allocated() {
        // Away from edges by more than h, and from extraordinary vertices, where the second derivatives are unbounded.
        let (u, v) = (0.1 + 0.8 * random.unit(), 0.1 + 0.8 * random.unit());
        let at = |u, v| {
            let (p, normal) = displaced.sample(&context, Place::new(tile, u, v)).unwrap();
            (Vec3::from(p), Vec3::from(normal))
        };
        let (_, normal) = at(u, v);
        assert!((normal.length() - 1.0).abs() < 1e-5);
        let p_u = at(u + h, v).0 - at(u - h, v).0;
        let p_v = at(u, v + h).0 - at(u, v - h).0;
        worst = worst.max(normal.angle_between(p_u.cross(p_v)));
    }
    assert!(worst < 0.02, "{worst} radians");
}

#[test]
fn normals_are_continuous_across_edges_of_equal_density() {
    let Some(mesh) = cage("spot_control_mesh.obj") else { return };
    let surface = surface(&mesh);
    let context = Context::serial();
    let displacement = slightly_dented(&surface);
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let inward = |place: &Place| Place {
        u: place.u + (0.5 - place.u).signum() * if place.u % 1.0 == 0.0 { 1e-4 } else { 0.0 },
        v: place.v + (0.5 - place.v).signum() * if place.v % 1.0 == 0.0 { 1e-4 } else { 0.0 },
        ..*place
    };
    let mut checked = 0;
    for (here, there) in seams(&surface) {
        let corner = |place: &Place| (place.u % 1.0 == 0.0) && (place.v % 1.0 == 0.0);
        if corner(&here) || corner(&there) {
            continue;
        }
        let normals = [here, there].map(|place| Vec3::from(displaced.sample(&context, inward(&place)).unwrap().1));
        let angle = normals[0].angle_between(normals[1]);
        assert!(angle < 0.02, "{here:?} {there:?} {angle}");
        checked += 1;
    }
    assert!(checked > 1000);
}

/// A flat square of 5 × 5 quads in the plane z = 0, whose middle tile's parameters are its coordinates but for a shift.
fn plane() -> Mesh {
    let mut mesh = grid(5, false, &[2], false);
    mesh.points.iter_mut().for_each(|p| p[2] = 0.0);
    mesh
}

#[test]
fn a_plane_is_raised_and_tilted_exactly() {
    let surface = surface(&plane());
    let context = Context::serial();
    let mut displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
    let all: Vec<u32> = (0..25).collect();
    displacement.apply(&Sets { allocate: all.clone(), ..Sets::default() }).unwrap();
    // A slope of 1/4 along x: coefficients are multiples of 1/1024 below 2, exact as half floats.
    let changes = displacement.edit(&context, &all, |tile, texels| {
        fill(texels, |u, _| 0.25 * ((tile % 5) as f32 + u) - 0.5);
    });
    displacement.settle(&context, &changes.unwrap()).unwrap();
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let slope = Vec3::new(-0.25, 0.0, 1.0).normalize();
    for tile in [6, 7, 12, 18] {
        let mut points = Points::default();
        displaced.grid(&context, tile, &Grid::whole(16, Placement::Lattice), &mut points).unwrap();
        for (p, normal) in points.p.iter().zip(&points.normal) {
            assert!((p[2] - (0.25 * p[0] - 0.5)).abs() < 1e-6, "{p:?}");
            assert!((Vec3::from(*normal) - slope).length() < 1e-5, "{normal:?}");
        }
    }
}

#[test]
fn what_is_not_displaced_is_the_surface_itself() {
    let Some(mesh) = cage("suzanne.obj") else { return };
    let surface = surface(&mesh);
    let context = Context::serial();
    let displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let places: Vec<Place> = (0..surface.tile_count() as u32).map(|tile| Place::new(tile, 0.3, 0.8)).collect();
    let (mut points, mut samples) = (Points::default(), Samples::default());
    displaced.evaluate(&context, &places, &mut points).unwrap();
    surface.evaluate(&context, &places, Order::Position, &mut samples).unwrap();
    for (index, p) in points.p.iter().enumerate() {
        assert_eq!(p.map(f32::to_bits), [0, 1, 2].map(|axis| samples.p[axis][index].to_bits()));
    }
}

#[test]
fn corners_without_a_normal_get_one_from_nearby() {
    // The border of an open cage is smooth at its corners unless told otherwise: the tangents are parallel there.
    let context = Context::serial();
    let options = SurfaceOptions { boundary: relievo_surface::BoundaryRule::Edges, ..SurfaceOptions::default() };
    let surface = Surface::new(&context, &plane(), &options).unwrap();
    let mut displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
    displacement.apply(&Sets { allocate: vec![0], ..Sets::default() }).unwrap();
    let changes = displacement.edit(&context, &[0], |_, texels| {
        (0..9).for_each(|row| texels.row_mut(row)[..9].fill(f16::from_f32(0.5)));
    });
    displacement.settle(&context, &changes.unwrap()).unwrap();
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let corner = displaced.sample(&context, Place::new(0, 0.0, 0.0)).unwrap();
    assert!((corner.0[2] - 0.5).abs() < 1e-6 && corner.1[2] > 0.9, "{corner:?}");
    let mut points = Points::default();
    displaced.grid(&context, 0, &Grid::whole(64, Placement::Lattice), &mut points).unwrap();
    assert_eq!((points.p[0], points.normal[0]), corner);
    for normal in &points.normal {
        assert!((Vec3::from(*normal).length() - 1.0).abs() < 1e-5, "{normal:?}");
    }
}

#[test]
fn at_extraordinary_vertices_the_displaced_normal_is_the_surface_normal() {
    let Some(mesh) = cage("spot_quadrangulated.obj") else { return };
    let surface = surface(&mesh);
    let context = Context::serial();
    let mut displacement = dented(&surface, &DisplacementOptions { size: 16, ..Default::default() }, 0.001);
    let all: Vec<Change> = (0..surface.tile_count() as u32).map(Change::all).collect();
    assert!(displacement.update_rings(&context, &all).unwrap().is_empty());
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let topology = surface.topology();
    let rings = (0..topology.ring_count() as u32).filter(|ring| topology.ring_class(*ring) == RingClass::Extraordinary);
    for ring in rings.take(50) {
        let place = displacement.field().canonical(topology.ring(ring)[0].place());
        let jet = displacement.field().point(context.level(), place);
        assert!(jet.du.abs() + jet.dv.abs() < 1e-4);
        let (p, _) = displaced.sample(&context, place).unwrap();
        let base = surface.sample(context.level(), place).unwrap();
        let moved = Vec3::from(base.p) + jet.d * Vec3::from(base.normal());
        assert!((Vec3::from(p) - moved).length() < 1e-5);
    }
}

#[test]
fn bad_places_and_foreign_fields_are_refused() {
    let surface = surface(&plane());
    let context = Context::serial();
    let displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    for place in [Place::new(25, 0.5, 0.5), Place::new(0, 1.5, 0.0), Place::new(0, 0.0, f32::NAN)] {
        assert!(displaced.sample(&context, place).is_err(), "{place:?}");
    }
    let rows = Grid { size: 4, placement: Placement::Centred, columns: 0..5, rows: 0..1 };
    assert!(displaced.grid(&context, 0, &rows, &mut Points::default()).is_err());
    let other = self::surface(&grid(3, false, &[2], false));
    assert!(Displaced::new(&other, displacement.field()).is_err());
}

/// A surface without borders that is round everywhere: the limit of a cube of edge 2.
fn round() -> Surface {
    let points = (0..8u8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|bit| f32::from(bit) * 2.0 - 1.0)).collect();
    let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
    surface(&Mesh { points, face_sizes: vec![4; 6], corners, ..Mesh::default() })
}

#[test]
fn folds_are_counted_where_heights_go_beyond_a_centre_of_curvature() {
    let context = Context::new(&ContextOptions { threads: 2, ..ContextOptions::default() }).unwrap();
    let surface = round();
    let options = DisplacementOptions { size: 16, ..DisplacementOptions::default() };
    let folds = |depth: f32, tiles: Vec<u32>| {
        let mut displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
        displacement.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
        let changes = displacement.edit(&context, &tiles, |_, texels| fill(texels, |_, _| -depth));
        displacement.settle(&context, &changes.unwrap()).unwrap();
        Displaced::new(&surface, displacement.field()).unwrap().folds(&context).unwrap()
    };
    // The limit of this cube reaches from 0.55 to 0.6 of its half edge, and all centres of curvature are within 1.
    for (depth, folded) in [(0.0, 0), (0.1, 0), (-3.0, 0), (3.0, 6 * 512)] {
        let found = folds(depth, (0..6).collect());
        assert_eq!((found.triangles, found.folded), (6 * 512, folded), "{depth}");
        assert_eq!(found.worst, (folded > 0).then_some(0), "{depth}");
    }
    let some = folds(3.0, vec![4]);
    assert!(some.worst == Some(4) && some.folded > 256, "{some:?}");
    assert_eq!(folds(0.0, Vec::new()), relievo_tiles::Folds::default());
}

#[test]
fn folds_of_triangle_meshes_are_counted_too() {
    let context = Context::serial();
    let quads = grid(6, true, &[2], false);
    let mesh = Mesh::from_triangles(quads.points.clone(), &quads.triangles());
    let surface = TriangleSurface::new(&context, &mesh).unwrap();
    let topology = surface.topology().clone();
    let folds = |height: f32| {
        let options = TriangleOptions { segments: 8, budget: 1 << 22 };
        let mut channel = TriangleChannel::displacement(topology.clone(), &options).unwrap();
        let vertices = (0..topology.vertex_count() as u32).map(|vertex| (vertex, f16::from_f32(height))).collect();
        channel.write(TriangleValues { faces: Vec::new(), edges: Vec::new(), vertices }).unwrap();
        TriangleDisplaced::new(&surface, channel.field()).unwrap().folds(&context)
    };
    let faces = topology.face_count() as u64;
    assert_eq!(folds(0.0), relievo_tiles::Folds::default());
    // Vertex normals of a coarse tube are not those of its faces, but little height turns nothing over.
    let little = folds(-0.01);
    assert_eq!((little.triangles, little.folded), (faces, 0));
    // Through the middle of the tube and out on the other side.
    let through = folds(-10.0);
    assert!(through.folded == faces && through.worst.is_some(), "{through:?}");
}
