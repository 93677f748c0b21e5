//! Documents on other meshes: what was where stays there, what has no place is reported.

use glam::{Vec3, Vec4};
use half::f16;
use relievo_bake::transfer::{TransferOptions, transfer};
use relievo_core::{Context, Mesh};
use relievo_document::Document;
use relievo_surface::{Grid, Order, Place, Placement, Samples, Surface, SurfaceOptions, TriangleSurface};
use relievo_tiles::texel::Vector;
use relievo_tiles::triangle::{Slot, TriangleChannel, TriangleOptions, TriangleSets, TriangleValues, foot};
use relievo_tiles::{
    Channel, ChannelOptions, ColorTexel, Displaced, Displacement, Paint, Rgba8, Sets, StoredTexel, Texel,
};

use crate::support::everywhere;

/// A rectangle from (0, 0) to `size`, of `n` × `n` faces.
fn sheet(n: u32, size: [f32; 2]) -> Mesh {
    let at = |k: u32, axis: usize| k as f32 / n as f32 * size[axis];
    let points = (0..=n).flat_map(|j| (0..=n).map(move |i| [at(i, 0), at(j, 1), 0.0])).collect();
    let corner = |i: u32, j: u32| j * (n + 1) + i;
    let corners = (0..n).flat_map(|j| {
        (0..n).flat_map(move |i| [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)])
    });
    Mesh::new(points, vec![4; (n * n) as usize], corners.collect())
}

/// A sheet of 2 by 2 with a bump and a spot of paint around (0.8, 1.1).
fn document(context: &Context, mesh: &Mesh) -> Document {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
    let options = ChannelOptions { size: 32, ..ChannelOptions::default() };
    let mut displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let mut paint = Paint::<Rgba8>::of_color(surface.topology().clone(), GREY, &options).unwrap();
    let bump = |[x, y]: [f32; 2], radius: f32| {
        let square = ((x - 0.8).powi(2) + (y - 1.1).powi(2)) / (radius * radius);
        (1.0 - square).max(0.0).powi(2)
    };
    fill(context, &surface, &mut displacement, |at| f16::from_f32(0.2 * bump(at, 0.6)));
    let red = Vec4::new(0.9, 0.1, 0.05, 1.0);
    fill(context, &surface, &mut paint, |at| Rgba8::of_color(GREY + (red - GREY) * bump(at, 0.4)));
    let mut document = Document::new(mesh, "baseline").unwrap();
    displacement.field().store(context, &mut document, "displacement").unwrap();
    paint.field().store(context, &mut document, "colour").unwrap();
    document
}

const GREY: Vec4 = Vec4::new(0.2, 0.2, 0.2, 1.0);

/// Gives the tiles where `texel` is not blank their texels.
fn fill<T: Texel>(
    context: &Context,
    surface: &Surface,
    channel: &mut Channel<T>,
    texel: impl Fn([f32; 2]) -> T + Sync,
) {
    let made = |tile: u32| -> Vec<T> {
        let mut samples = Samples::default();
        let grid = Grid::whole(channel.field().size(tile), Placement::Centred);
        surface.grid(context.level(), tile, &grid, Order::Position, &mut samples);
        samples.p[0].iter().zip(&samples.p[1]).map(|(x, y)| texel([*x, *y])).collect()
    };
    let blank = channel.field().blank();
    let tiles: Vec<(u32, Vec<T>)> = (0..surface.tile_count() as u32)
        .map(|tile| (tile, made(tile)))
        .filter(|(_, texels)| texels.iter().any(|texel| *texel != blank))
        .collect();
    let list: Vec<u32> = tiles.iter().map(|(tile, _)| *tile).collect();
    let applied = channel.apply(&Sets { allocate: list.clone(), ..Sets::default() }).unwrap();
    let mut changes = channel
        .edit(context, &list, |tile, texels| {
            let size = texels.size();
            let (_, made) = &tiles[list.binary_search(&tile).unwrap()];
            made.chunks_exact(size).enumerate().for_each(|(j, row)| texels.row_mut(j).copy_from_slice(row));
        })
        .unwrap();
    changes.extend(applied.changes);
    channel.settle(context, &changes).unwrap();
}

/// Height and red, and where, at a lattice of places of the sheet, which is a rectangle of `size`.
fn seen(context: &Context, mesh: &Mesh, document: &Document, size: [f32; 2]) -> Vec<([f32; 2], [f32; 2])> {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
    let topology = || surface.topology().clone();
    let displacement = Displacement::stored(context, topology(), document, "displacement", 1 << 30).unwrap().unwrap();
    let paint = Paint::<Rgba8>::stored(context, topology(), document, "colour", 1 << 30).unwrap().unwrap();
    let n = (mesh.face_count() as f64).sqrt() as u32;
    let displaced = Displaced::new(&surface, displacement.field()).unwrap();
    let mut list = Vec::new();
    for j in 1..24 {
        for i in 1..24 {
            let [x, y] = [i, j].map(|k| 2.0 * k as f32 / 24.0 + 0.013);
            let [s, t] = [x / size[0] * n as f32, y / size[1] * n as f32];
            let place = Place::new(t as u32 * n + s as u32, s.fract(), t.fract());
            let (p, _) = displaced.sample(context, place).unwrap();
            let red = paint.field().color(paint.field().canonical(place)).x;
            list.push(([p[2], red], [p[0], p[1]]));
        }
    }
    list
}

#[test]
fn layers_go_to_a_mesh_of_other_faces() {
    let context = Context::serial();
    let (old, size) = (sheet(4, [2.0; 2]), [2.0; 2]);
    let document = document(&context, &old);
    let before = seen(&context, &old, &document, size);
    let largest = before.iter().map(|(seen, _)| seen[0]).fold(0.0, f32::max);
    assert!(largest > 0.15);
    for n in [4, 7, 12] {
        let mesh = sheet(n, size);
        let (made, report) = transfer(&context, &document, None, &mesh, &TransferOptions::default()).unwrap();
        assert_eq!(made.layers().iter().map(|layer| layer.name()).collect::<Vec<_>>(), ["displacement", "colour"]);
        assert!((report.area[0] - 4.0).abs() < 1e-3 && report.area[1] < 1e-6, "{report}");
        assert!(report.layers.iter().all(|(_, [all, lost])| *all > 0.5 && *lost < 0.3 * all), "{report}");
        let after = seen(&context, &mesh, &made, size);
        // Compared where both have the same places, which parameters beside borders do not give.
        let same = |a: &[f32; 2], b: &[f32; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 2e-3;
        let mut compared = 0;
        for ((seen, at), (now, there)) in before.iter().zip(&after) {
            if same(at, there) {
                compared += 1;
                assert!((seen[0] - now[0]).abs() < 0.004, "{n}: height {seen:?} {now:?} at {at:?}");
                assert!((seen[1] - now[1]).abs() < 0.03, "{n}: red {seen:?} {now:?} at {at:?}");
            }
        }
        assert!(compared > 100, "{n}: {compared}");
    }
}

#[test]
fn what_has_no_place_is_told() {
    let context = Context::serial();
    let old = sheet(4, [2.0; 2]);
    let document = document(&context, &old);
    // Twice as wide: the right half is bare.
    let (_, report) = transfer(
        &context,
        &document,
        None,
        &sheet(8, [4.0, 2.0]),
        &TransferOptions { reach: Some(0.01), ..TransferOptions::default() },
    )
    .unwrap();
    assert!((report.area[0] - 8.0).abs() < 1e-2 && (report.area[1] - 4.0).abs() < 0.1, "{report}");
    // Only its lower quarter: most of what was edited is lost.
    let (made, report) = transfer(
        &context,
        &document,
        None,
        &sheet(4, [2.0, 0.5]),
        &TransferOptions { reach: Some(0.01), ..TransferOptions::default() },
    )
    .unwrap();
    assert!(report.area[1] < 1e-6, "{report}");
    let (_, [all, lost]) = &report.layers[0];
    assert!(*lost > 0.4 * all && lost < all, "{report}");
    assert!(made.fit(&sheet(3, [2.0; 2])).unwrap_err().to_string().contains("relievo doc transfer"));
    let text = report.to_string();
    assert!(text.contains("uncovered") && text.contains("layer `displacement`: "), "{text}");
    // A document of another build has no points; the mesh it was made on has.
    let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/golden/document-1.relievo")).unwrap();
    let older = Document::parse(&bytes, 1 << 24).unwrap();
    let error = transfer(&context, &older, None, &old, &TransferOptions::default()).unwrap_err().to_string();
    assert!(error.contains("--from"), "{error}");
    assert!(
        transfer(&context, &document, Some(&sheet(5, [2.0; 2])), &old, &TransferOptions::default()).is_err(),
        "another old mesh"
    );
    assert!(
        transfer(
            &context,
            &document,
            None,
            &old,
            &TransferOptions { reach: Some(f64::NAN), ..TransferOptions::default() }
        )
        .is_err()
    );
}

/// The sheet in triangles, with diagonals that lean to both sides.
fn triangles(n: u32, size: [f32; 2]) -> Mesh {
    let quads = sheet(n, size);
    let halves = |(face, corners): (usize, &[u32])| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner| corners[(corner + face % 2) % 4]);
        [a, b, c, a, c, d]
    };
    let corners: Vec<u32> = quads.corners.chunks(4).enumerate().flat_map(halves).collect();
    Mesh::new(quads.points, vec![3; corners.len() / 3], corners)
}

fn bump(p: Vec3) -> f32 {
    let square = ((p.x - 0.8).powi(2) + (p.y - 1.1).powi(2)) / 0.36;
    (1.0 - square).max(0.0).powi(2)
}

const LEAN: Vec3 = Vec3::new(0.3, -0.2, 0.1);

fn triangle_document(context: &Context, mesh: &Mesh) -> Document {
    let surface = TriangleSurface::new(context, mesh).unwrap();
    let options = TriangleOptions { segments: 16, budget: 1 << 26 };
    let topology = || surface.topology().clone();
    let shape = TriangleChannel::displacement(topology(), &options).unwrap();
    let shape = everywhere(context, &surface, shape, |p| f16::from_f32(0.2 * bump(p)));
    let paint = TriangleChannel::<Rgba8>::of_color(topology(), GREY, &options).unwrap();
    let red = Vec4::new(0.9, 0.1, 0.05, 1.0);
    let paint = everywhere(context, &surface, paint, |p| Rgba8::of_color(GREY + (red - GREY) * bump(p)));
    let mut document = Document::of_triangles(mesh, "baseline").unwrap();
    shape.field().store(context, &mut document, "displacement").unwrap();
    paint.field().store(context, &mut document, "colour").unwrap();
    document
}

fn channel_of<T: StoredTexel>(context: &Context, mesh: &Mesh, document: &Document, name: &str) -> TriangleChannel<T> {
    let surface = TriangleSurface::new(context, mesh).unwrap();
    TriangleChannel::stored(context, surface.topology().clone(), document, name, 1 << 26).unwrap().unwrap()
}

#[test]
fn layers_of_triangles_go_to_other_triangles() {
    let context = Context::serial();
    let old = triangles(4, [2.0; 2]);
    let document = triangle_document(&context, &old);
    for n in [4, 7, 12] {
        let mesh = triangles(n, [2.0; 2]);
        let (made, report) = transfer(&context, &document, None, &mesh, &TransferOptions::default()).unwrap();
        assert!((report.area[0] - 4.0).abs() < 1e-3 && report.area[1] == 0.0, "{report}");
        assert!(report.layers.iter().all(|(_, [all, lost])| *all > 0.5 && *lost == 0.0), "{report}");
        let surface = TriangleSurface::new(&context, &mesh).unwrap();
        let shape = channel_of::<f16>(&context, &mesh, &made, "displacement");
        let paint = channel_of::<Rgba8>(&context, &mesh, &made, "colour");
        let spacing = 2.0 / n as f32 / shape.field().pattern().segments() as f32;
        assert!(spacing > 0.6 * 2.0 / 64.0 && spacing < 1.6 * 2.0 / 64.0, "{n}: {spacing}");
        assert!(shape.allocated_count() < surface.topology().face_count(), "where nothing is there is no block");
        let mut highest = 0.0f64;
        for face in 0..surface.topology().face_count() as u32 {
            for at in [[0.2, 0.3, 0.5], [1.0, 0.0, 0.0], [0.0, 0.4, 0.6], [0.05, 0.9, 0.05]] {
                let [a, b, c] = surface.corner_points(face).map(Vec3::from);
                let expected = bump(a * at[0] + b * at[1] + c * at[2]);
                let height = shape.field().value(face, at);
                let red = paint.field().value(face, at).x;
                highest = highest.max(height);
                assert!((height - f64::from(0.2 * expected)).abs() < 2e-3, "{n}: {height} {expected}");
                assert!((red - f64::from(0.2 + 0.7 * expected)).abs() < 1.5e-2, "{n}: {red} {expected}");
            }
        }
        assert!(highest > 0.12, "{n}: {highest}");
        // Onto the triangles that it was made on nothing changes.
        if n == 4 {
            let before = channel_of::<f16>(&context, &old, &document, "displacement");
            for face in shape.field().allocated() {
                assert_eq!(shape.field().face(face), before.field().face(face), "face {face}");
            }
        }
    }
}

#[test]
fn vectors_of_triangles_keep_their_direction_and_what_has_no_place_is_told() {
    let context = Context::serial();
    let old = triangles(4, [2.0; 2]);
    let surface = TriangleSurface::new(&context, &old).unwrap();
    let options = TriangleOptions { segments: 16, budget: 1 << 26 };
    // Kept in the frames of their owners, so the frames give what is to be written.
    let mut vectors = TriangleChannel::<Vector>::vectors(surface.topology().clone(), &options).unwrap();
    let pattern = vectors.field().pattern();
    let allocate = (0..surface.topology().face_count() as u32).collect();
    vectors.apply(&context, pattern, &TriangleSets { allocate, ..Default::default() }).unwrap();
    let face = |face: u32| {
        let value = |index: u32| {
            let foot = foot(&surface, face, pattern, pattern.at_slot(Slot::Inside(index)));
            let frame = relievo_tiles::triangle::vectors::face_frame(&surface, face, foot.normal);
            Vector::nearest((frame.transpose() * (LEAN * bump(foot.point))).as_dvec3())
        };
        (face, (0..pattern.face_values() as u32).map(value).collect())
    };
    let faces = (0..surface.topology().face_count() as u32).map(face).collect();
    vectors.write(TriangleValues { faces, ..Default::default() }).unwrap();
    let mut document = Document::of_triangles(&old, "baseline").unwrap();
    vectors.field().store(&context, &mut document, "vectors").unwrap();
    let mesh = triangles(9, [2.0, 2.0]);
    let (made, _) = transfer(&context, &document, None, &mesh, &TransferOptions::default()).unwrap();
    let new = TriangleSurface::new(&context, &mesh).unwrap();
    let there = channel_of::<Vector>(&context, &mesh, &made, "vectors").field().in_object_space(&context, &new);
    let before = vectors.field().in_object_space(&context, &surface);
    let mut compared = 0;
    for face in there.allocated().collect::<Vec<u32>>() {
        let [a, b, c] = new.corner_points(face).map(Vec3::from);
        let middle = (a + b + c) / 3.0;
        // The old face that the middle is in, by its barycentric coordinates.
        let found = (0..surface.topology().face_count() as u32).find_map(|old| {
            let [a, b, c] = surface.corner_points(old).map(Vec3::from);
            let whole = (b - a).cross(c - a).z;
            let at =
                [(b - middle).cross(c - middle).z, (c - middle).cross(a - middle).z, (a - middle).cross(b - middle).z];
            at.iter().all(|part| *part > 0.05 * whole).then(|| before.value(old, at.map(|part| part / whole)))
        });
        let Some(expected) = found else { continue };
        compared += 1;
        let is = there.value(face, [1.0 / 3.0; 3]);
        assert!((is - expected).length() < 2e-3, "{is} {expected}");
    }
    assert!(compared > 20, "{compared}");
    // Twice as wide: the right half is bare; a quarter of it: most of what was edited is lost.
    let (_, report) = transfer(
        &context,
        &document,
        None,
        &triangles(8, [4.0, 2.0]),
        &TransferOptions { reach: Some(0.01), ..TransferOptions::default() },
    )
    .unwrap();
    assert!((report.area[0] - 8.0).abs() < 1e-3 && (report.area[1] - 4.0).abs() < 0.3, "{report}");
    let (_, report) = transfer(
        &context,
        &document,
        None,
        &triangles(4, [2.0, 1.0]),
        &TransferOptions { reach: Some(0.01), ..TransferOptions::default() },
    )
    .unwrap();
    let (_, [all, lost]) = &report.layers[0];
    assert!(report.area[1] == 0.0 && *lost > 0.4 * all && lost < all, "{report}");
    // Another old mesh, and one that is no number.
    assert!(transfer(&context, &document, Some(&triangles(5, [2.0; 2])), &old, &TransferOptions::default()).is_err());
    assert!(
        transfer(&context, &document, None, &old, &TransferOptions { reach: Some(-1.0), ..TransferOptions::default() })
            .is_err()
    );
}
