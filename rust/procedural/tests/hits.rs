//! Primitives hold the surface: rays find it where triangles of the same cells are, nothing slips between tiles of
//! different rates, motion is straight, and what is no ray meets nothing.

use glam::Vec3;
use half::f16;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_procedural::{BlockHit, BlockRay, MAX_SEGMENTS, Procedural, procedural_rates};
use relievo_surface::{Place, Surface, SurfaceOptions, TriangleSurface};
use relievo_testing::{Random, grid};
use relievo_tiles::triangle::{
    FaceRates, Pattern, TriangleChannel, TriangleDisplaced, TriangleNormals, TriangleOptions, TriangleSets,
    TriangleTessellation, TriangleValues, edge_foot, foot_at,
};
use relievo_tiles::{Displaced, Displacement, DisplacementOptions, Sets};

fn surface(mesh: &Mesh) -> Surface {
    Surface::new(&Context::serial(), mesh, &SurfaceOptions::default()).unwrap()
}

/// Waves of up to `depth` in some of the tiles.
fn dented(surface: &Surface, depth: f32) -> Displacement {
    let context = Context::serial();
    let options = DisplacementOptions { size: 32, ..DisplacementOptions::default() };
    let mut displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let tiles: Vec<u32> = (0..surface.tile_count() as u32).filter(|tile| tile * 7 % 5 < 2).collect();
    displacement.apply(&Sets { allocate: tiles.clone(), ..Sets::default() }).unwrap();
    let changes = displacement.edit(&context, &tiles, |_, texels| {
        let size = texels.size();
        for j in 0..size {
            for (i, c) in texels.row_mut(j).iter_mut().enumerate() {
                let (u, v) = ((i as f32 + 0.5) / size as f32, (j as f32 + 0.5) / size as f32);
                *c = f16::from_f32(depth * (9.0 * u).sin() * (7.0 * v).cos());
            }
        }
    });
    displacement.settle(&context, &changes.unwrap()).unwrap();
    displacement
}

/// The triangles of a closed tube, and heights in some of them, of 8, 16 or 32 segments a side.
fn dented_triangles(depth: f32, sizes: &[u32]) -> (Mesh, TriangleSurface, TriangleChannel) {
    let context = Context::serial();
    let quads = grid(4, true, &[2], false);
    let mesh = Mesh::from_triangles(quads.points.clone(), &quads.triangles());
    let surface = TriangleSurface::new(&context, &mesh).unwrap();
    let topology = surface.topology().clone();
    let options = TriangleOptions { segments: 32, budget: 1 << 24 };
    let mut channel = TriangleChannel::displacement(topology.clone(), &options).unwrap();
    for face in (0..topology.face_count() as u32).filter(|face| face * 7 % 5 < 2) {
        let pattern = Pattern::new(sizes[face as usize % sizes.len()]).unwrap();
        channel.apply(&context, pattern, &TriangleSets { allocate: vec![face], ..Default::default() }).unwrap();
    }
    let field = channel.field().clone();
    let wave = |p: Vec3| f16::from_f32(depth * (3.0 * p.x).sin() * (2.0 * p.y + p.z).cos());
    let inside = |face: u32| {
        let corners = surface.corner_points(face).map(Vec3::from);
        let place = |at: &[f32; 3]| wave(corners[0] * at[0] + corners[1] * at[1] + corners[2] * at[2]);
        (face, field.face_pattern(face).unwrap().places().iter().map(place).collect())
    };
    let along = |edge: u32| {
        let segments = field.edge_pattern(edge).unwrap().segments();
        (edge, (1..segments).map(|step| wave(edge_foot(&surface, edge, step, segments).point)).collect())
    };
    let (faces, edges) = (field.allocated().map(inside).collect(), field.allocated_edges().map(along).collect());
    // A vertex of which all faces have blocks moves too.
    let inner = |vertex: &u32| topology.faces_around(*vertex).all(|(face, _)| field.is_allocated(face));
    let vertices = (0..topology.vertex_count() as u32).filter(inner);
    let vertices = vertices.map(|vertex| (vertex, wave(Vec3::from(surface.points()[vertex as usize]))));
    channel.write(TriangleValues { faces, edges, vertices: vertices.collect() }).unwrap();
    (mesh, surface, channel)
}

/// The nearest hit over all primitives whose bounds the ray meets, and its primitive.
fn cast(procedural: &Procedural, ray: &BlockRay) -> Option<(u32, BlockHit)> {
    let mut nearest: Option<(u32, BlockHit)> = None;
    for primitive in 0..procedural.tiles().len() as u32 {
        let (low, high) = procedural.bounds(primitive, false).unwrap();
        let (last_low, last_high) = procedural.bounds(primitive, true).unwrap();
        let blend = |a: [f32; 3], b: [f32; 3]| Vec3::from(a).lerp(Vec3::from(b), ray.time);
        let (low, high) = (blend(low, last_low), blend(high, last_high));
        let inverse = Vec3::from(ray.direction).recip();
        let (a, b) = ((low - Vec3::from(ray.origin)) * inverse, (high - Vec3::from(ray.origin)) * inverse);
        if a.min(b).max_element() > a.max(b).min_element() * 1.000001 + 1e-6 {
            assert!(procedural.intersect(primitive, ray).is_none(), "bounds hold what is in them");
            continue;
        }
        let far = nearest.map_or(ray.far, |(_, hit)| hit.distance);
        let hit = procedural.intersect(primitive, &BlockRay { far, ..*ray });
        assert_eq!(hit.is_some(), procedural.occluded(primitive, &BlockRay { far, ..*ray }));
        nearest = hit.map(|hit| (primitive, hit)).or(nearest);
    }
    nearest
}

/// Distance to the nearest triangle of `mesh`.
fn trace(mesh: &Mesh, ray: &BlockRay) -> Option<f64> {
    let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
    let triangles = mesh.corners.chunks_exact(3).map(|corners| {
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(mesh.points[corners[k] as usize]).as_dvec3());
        let (e, f, s) = (b - a, c - a, origin - a);
        let (p, q) = (direction.cross(f), s.cross(e));
        let whole = e.dot(p);
        let (u, v, t) = (s.dot(p) / whole, direction.dot(q) / whole, f.dot(q) / whole);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
    });
    triangles.flatten().min_by(f64::total_cmp)
}

fn ray(random: &mut Random, from: Vec3, spread: f32) -> BlockRay {
    let mut point = || Vec3::new(random.unit(), random.unit(), random.unit()) * 2.0 - 1.0;
    let direction = (Vec3::new(2.0, 0.0, 0.0) + spread * point() - from).to_array();
    BlockRay { origin: from.to_array(), direction, near: 0.0, far: f32::INFINITY, time: 0.0 }
}

#[test]
fn rays_meet_the_triangles_of_the_same_cells() {
    let context = Context::serial();
    let mesh = grid(4, true, &[2, 1, 0, 3], false);
    let surface = surface(&mesh);
    let displacement = dented(&surface, 0.1);
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let rates = procedural_rates(surface.topology(), |_| 32);
    let procedural = Procedural::new(&context, &displaced, None, &rates).unwrap();
    let triangles = displaced.tessellate(&context, &mesh, &rates).unwrap();
    assert_eq!(2 * procedural.cell_count(), triangles.tiles.len() as u64);
    assert!(procedural.bytes() < 12 * procedural.cell_count(), "{} bytes", procedural.bytes());
    let (mut random, mut hits, mut apart, mut off) = (Random(3), 0, 0, 0);
    for _ in 0..1500 {
        let ray = ray(&mut random, Vec3::new(9.0, 2.0, 3.0), 2.0);
        match (cast(&procedural, &ray), trace(&triangles.mesh, &ray)) {
            (Some((primitive, hit)), Some(distance)) => {
                hits += 1;
                let tile = procedural.tiles()[primitive as usize];
                let (p, normal) = displaced.sample(&context, Place::new(tile, hit.uv[0], hit.uv[1])).unwrap();
                let met = Vec3::from(ray.origin) + hit.distance * Vec3::from(ray.direction);
                // Where waves end at a tile without any, a cell is as steep as it is wide.
                let cosine = Vec3::from(normal).dot(Vec3::from(hit.normal).normalize());
                off += usize::from(met.distance(p.into()) > 0.01 || cosine < 0.8);
                apart += usize::from((f64::from(hit.distance) - distance).abs() > 1e-3);
            }
            (None, None) => {}
            _ => apart += 1,
        }
    }
    // Cells that are cut along the other diagonal differ where a ray grazes.
    assert!(hits > 350 && apart < 8 && off < hits / 20, "{hits} {apart} {off}");
}

#[test]
fn nothing_slips_between_tiles_of_different_rates() {
    let context = Context::serial();
    for seed in [1_u64, 2, 3, 5, 6, 7] {
        let mesh = grid(4, true, &[seed as u8, 1, 0, 3, 2, 0x17], false);
        let surface = surface(&mesh);
        let displacement = dented(&surface, 0.05);
        let displaced = Displaced::new(&surface, displacement.field()).unwrap();
        let mut random = Random(seed);
        let choices: Vec<u32> = (0..surface.tile_count()).map(|_| 8 << random.below(4)).collect();
        let rates = procedural_rates(surface.topology(), |tile| choices[tile as usize]);
        let procedural = Procedural::new(&context, &displaced, None, &rates).unwrap();
        for _ in 0..600 {
            // From the middle of the tube, which is narrower in the limit, to everywhere.
            let ray = ray(&mut random, Vec3::new(2.0, 0.0, 0.0), 1.0);
            assert!(cast(&procedural, &ray).is_some(), "{seed} {ray:?}");
        }
    }
}

#[test]
fn rays_meet_the_triangles_of_triangle_meshes() {
    let context = Context::serial();
    let (mesh, surface, channel) = dented_triangles(0.05, &[32]);
    let displaced = TriangleDisplaced::new(&surface, channel.field()).unwrap();
    let procedural = Procedural::of_triangles(&context, &displaced, None, MAX_SEGMENTS).unwrap();
    let normals = TriangleNormals::of(&context, &displaced).unwrap();
    let rates = |face: u32| FaceRates::of(channel.field(), face);
    let triangles = TriangleTessellation::new(&context, &displaced, &normals, &mesh, rates).unwrap();
    let (mut random, mut hits, mut apart, mut off) = (Random(3), 0, 0, 0);
    for _ in 0..1500 {
        let ray = ray(&mut random, Vec3::new(9.0, 2.0, 3.0), 2.0);
        match (cast(&procedural, &ray), trace(&triangles.mesh, &ray)) {
            (Some((primitive, hit)), Some(distance)) => {
                hits += 1;
                let face = procedural.tiles()[primitive as usize];
                let [u, v] = hit.uv;
                assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.000001, "{hit:?}");
                let at = [1.0 - u - v, u, v].map(|share| share.max(0.0));
                let foot = foot_at(&surface, face, at);
                let point = foot.point + displaced.offset(face, at, foot.normal);
                let met = Vec3::from(ray.origin) + hit.distance * Vec3::from(ray.direction);
                off += usize::from(met.distance(point) > 2e-3);
                // Faces beside those with blocks are fans of a few triangles there.
                let same = (f64::from(hit.distance) - distance).abs() < 1e-3 || !channel.field().is_allocated(face);
                apart += usize::from(!same);
            }
            (None, None) => {}
            _ => apart += 1,
        }
    }
    assert!(hits > 350 && apart < 8 && off < hits / 20, "{hits} {apart} {off}");
    // Flat triangles face outwards as the mesh does.
    let options = TriangleOptions { segments: 32, budget: 1 << 20 };
    let flat = TriangleChannel::displacement(surface.topology().clone(), &options).unwrap();
    let displaced = TriangleDisplaced::new(&surface, flat.field()).unwrap();
    let procedural = Procedural::of_triangles(&context, &displaced, None, MAX_SEGMENTS).unwrap();
    assert_eq!(procedural.tiles().len(), surface.topology().face_count());
    let mut hits = 0;
    for _ in 0..300 {
        let ray = ray(&mut random, Vec3::new(9.0, 2.0, 3.0), 2.0);
        let (found, wanted) = (cast(&procedural, &ray), trace(&mesh, &ray));
        let Some((face, hit)) = found else { continue };
        let [a, b, c] = surface.corner_points(face).map(Vec3::from);
        let flat = (b - a).cross(c - a).normalize();
        assert!(Vec3::from(hit.normal).normalize().dot(flat) > 0.999);
        let met = a + hit.uv[0] * (b - a) + hit.uv[1] * (c - a);
        assert!((Vec3::from(ray.origin) + hit.distance * Vec3::from(ray.direction)).distance(met) < 1e-4);
        hits += usize::from(wanted.is_some_and(|distance| (f64::from(hit.distance) - distance).abs() < 1e-4));
    }
    assert!(hits > 60, "{hits}");
}

#[test]
fn nothing_slips_between_triangles_of_different_rates() {
    let context = Context::serial();
    for sizes in [&[8, 32, 16][..], &[32, 8], &[16]] {
        let (_, surface, channel) = dented_triangles(0.05, sizes);
        let displaced = TriangleDisplaced::new(&surface, channel.field()).unwrap();
        for most in [8, 16, MAX_SEGMENTS] {
            let procedural = Procedural::of_triangles(&context, &displaced, None, most).unwrap();
            let mut random = Random(u64::from(most));
            for _ in 0..600 {
                let ray = ray(&mut random, Vec3::new(2.0, 0.0, 0.0), 1.0);
                assert!(cast(&procedural, &ray).is_some(), "{sizes:?} {most} {ray:?}");
            }
        }
    }
}

#[test]
fn what_moves_goes_straight_and_does_not_depend_on_threads() {
    let context = Context::serial();
    let mesh = grid(4, true, &[2, 1, 0, 3], false);
    let shift = Vec3::new(1.0, -0.5, 0.25);
    let first = surface(&mesh);
    let moved: Vec<[f32; 3]> = mesh.points.iter().map(|point| (Vec3::from(*point) + shift).to_array()).collect();
    let second = first.posed(&context, &moved).unwrap();
    let displacement = dented(&first, 0.1);
    let begin = Displaced::new(&first, displacement.field()).unwrap();
    let end = Displaced::new(&second, displacement.field()).unwrap();
    let rates = procedural_rates(first.topology(), |_| 16);
    let still = Procedural::new(&context, &begin, None, &rates).unwrap();
    let moving = Procedural::new(&context, &begin, Some(&end), &rates).unwrap();
    let many = Context::new(&ContextOptions { threads: 3, ..ContextOptions::default() }).unwrap();
    let same = Procedural::new(&many, &begin, Some(&end), &rates).unwrap();
    assert!(moving.moves() && !still.moves());
    let (mut random, mut apart, mut hits) = (Random(8), 0, 0);
    for _ in 0..200 {
        let resting = ray(&mut random, Vec3::new(9.0, 2.0, 3.0), 2.0);
        let expected = cast(&still, &resting);
        for time in [0.0, 0.3, 1.0] {
            let origin = (Vec3::from(resting.origin) + time * shift).to_array();
            let ray = BlockRay { origin, time, ..resting };
            let found = cast(&moving, &ray);
            assert_eq!(found, cast(&same, &ray));
            match (expected, found) {
                (Some((_, a)), Some((_, b))) => {
                    hits += 1;
                    apart += usize::from((a.distance - b.distance).abs() > 1e-3);
                }
                (None, None) => {}
                _ => apart += 1,
            }
        }
    }
    assert!(hits > 150 && apart < 6, "{hits} {apart}");
}

#[test]
fn far_from_the_origin_and_of_any_size_rays_hit() {
    let context = Context::serial();
    let mesh = grid(3, true, &[2], false);
    for (scale, shift) in [(1e-4, 0.0), (1e4, 0.0), (1.0, 500.0), (1e-3, 1e-2)] {
        let place = |point: Vec3| point * scale + Vec3::new(shift, -shift, 0.5 * shift);
        let mut placed = mesh.clone();
        placed.points.iter_mut().for_each(|point| *point = place(Vec3::from(*point)).to_array());
        let surface = surface(&placed);
        let displacement = Displacement::new(surface.topology().clone(), &DisplacementOptions::default()).unwrap();
        let displaced = Displaced::new(&surface, displacement.field()).unwrap();
        let rates = procedural_rates(surface.topology(), |_| 16);
        let procedural = Procedural::new(&context, &displaced, None, &rates).unwrap();
        assert!(procedural.step() < 1e-4 * surface.extent());
        let mut random = Random(1);
        for _ in 0..300 {
            let inner = ray(&mut random, Vec3::new(2.0, 0.0, 0.0), 1.0);
            let direction = (Vec3::from(inner.direction) * scale).to_array();
            let ray = BlockRay { origin: place(Vec3::new(1.5, 0.0, 0.0)).to_array(), direction, ..inner };
            assert!(cast(&procedural, &ray).is_some(), "{scale} {shift} {ray:?}");
        }
    }
}

#[test]
fn what_is_no_ray_meets_nothing() {
    let context = Context::serial();
    let surface = surface(&grid(3, true, &[2], false));
    let displacement = dented(&surface, 0.1);
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let rates = procedural_rates(surface.topology(), |_| 16);
    let procedural = Procedural::new(&context, &displaced, None, &rates).unwrap();
    let count = procedural.tiles().len() as u32;
    let ray =
        BlockRay { origin: [9.0, 0.0, 0.0], direction: [-1.0, 0.0, 0.0], far: f32::INFINITY, ..Default::default() };
    assert!(cast(&procedural, &ray).is_some());
    assert!(procedural.intersect(count, &ray).is_none() && !procedural.occluded(u32::MAX, &ray));
    assert!(procedural.bounds(count, false).is_none());
    let nan = f32::NAN;
    for bad in [
        BlockRay { direction: [0.0; 3], ..ray },
        BlockRay { direction: [nan; 3], ..ray },
        BlockRay { origin: [nan, 0.0, 0.0], ..ray },
        BlockRay { far: nan, ..ray },
        BlockRay { far: -1.0, ..ray },
        BlockRay { near: f32::INFINITY, ..ray },
    ] {
        for primitive in 0..count {
            assert!(procedural.intersect(primitive, &bad).is_none(), "{bad:?}");
        }
    }
    let tight = Context::new(&ContextOptions { threads: 1, memory_limit: 10_000 }).unwrap();
    assert!(Procedural::new(&tight, &displaced, None, &rates).is_err());
    assert!(Procedural::new(&context, &displaced, None, &rates[1..]).is_err());
}
