//! Budgets below one tile, or below one face of a triangle mesh with its edges: every kind of edit says which faces it
//! was refused, and changes nothing.

use glam::{DAffine3, DMat3, DVec3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Brush, Canvas, Dab, DisplacedObject, Falloff, LayeredObject, PaintMode, SculptMode, Stroke, StrokePoint,
    StrokeSettings, TriangleObject, refusal,
};
use relievo_document::Document;
use relievo_surface::{Surface, SurfaceOptions, TriangleSurface};
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};
use relievo_tiles::{ChannelOptions, Displacement, Paint, Rgba8, Rgba16, VectorDisplacement};

/// A strip of `n` unit squares along x in z = 0, or of pairs of triangles.
fn strip(n: u32, triangles: bool) -> Mesh {
    let points = (0..2 * (n + 1)).map(|k| [(k / 2) as f32, (k % 2) as f32, 0.0]).collect();
    let squares = (0..n).map(|k| [2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1]);
    if !triangles {
        return Mesh::new(points, vec![4; n as usize], squares.flatten().collect());
    }
    let halves: Vec<[u32; 3]> = squares.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh::from_triangles(points, &halves)
}

/// Every kind of edit that needs room: of colours, displacement and vectors.
const ACTIONS: [Action; 6] = [
    Action::Paint { mode: PaintMode::Mix, color: [1.0, 0.0, 0.0, 1.0] },
    Action::Paint { mode: PaintMode::Add, color: [0.1; 4] },
    Action::Sculpt { mode: SculptMode::Draw, height: 0.25 },
    Action::Sculpt { mode: SculptMode::Inflate, height: 0.25 },
    Action::Sculpt { mode: SculptMode::Pinch, height: 1.0 },
    Action::Sculpt { mode: SculptMode::Vector, height: 0.25 },
];

/// In the middle of the third square.
const MIDDLE: DVec3 = DVec3::new(2.5, 0.5, 0.0);

/// Inside the third square, and from one end of the strip to the other.
fn strokes(action: Action) -> [Stroke; 2] {
    let settings = StrokeSettings { radius: 0.3, ..StrokeSettings::default() };
    [vec![MIDDLE], vec![DVec3::new(0.5, 0.5, 0.0), DVec3::new(3.5, 0.5, 0.0)]].map(|points| {
        let points = points.into_iter().map(|point| StrokePoint::new(point, 1.0)).collect();
        Stroke::new(points, settings, Falloff::Smooth, action)
    })
}

fn bytes(context: &Context, object: &impl LayeredObject, mut document: Document) -> Vec<u8> {
    object.store(context, &mut document).unwrap();
    document.to_bytes().unwrap()
}

fn refused_and_unchanged<O: Canvas + LayeredObject>(
    context: &Context,
    object: &mut O,
    empty: &Document,
    faces: impl Fn(&O, &[u32]) -> Vec<u32>,
    expected: [&str; 2],
) {
    let before = bytes(context, object, empty.clone());
    for action in ACTIONS {
        for (stroke, expected) in strokes(action).iter().zip(expected) {
            let done = stroke.apply(context, object).unwrap();
            let report = &done.report;
            assert!(done.dabs > 0 && done.missed == 0, "{action:?}");
            assert_eq!((report.changed_texels, report.allocated, report.freed), (0, 0, 0), "{action:?}");
            assert_eq!(refusal::named(&faces(object, &report.refused)), expected, "{action:?}");
            assert!(bytes(context, object, empty.clone()) == before, "{action:?}");
        }
    }
}

#[test]
fn tiles_beyond_the_budget_are_named_and_stay() {
    let (context, mesh) = (Context::serial(), strip(4, false));
    // The smallest tile is 10 × 10 texels of two bytes.
    for (budget, halves) in [(0, false), (199, true), (18 * 18 * 2 - 1, false)] {
        let size = if budget == 199 { 8 } else { 16 };
        let options = ChannelOptions { size, budget, ..ChannelOptions::default() };
        let surface = Surface::new(&context, &mesh, &SurfaceOptions::default()).unwrap();
        let topology = surface.topology().clone();
        let displacement = Displacement::new(topology.clone(), &options).unwrap();
        let vectors = VectorDisplacement::on(&surface, &options).unwrap();
        let identity = DAffine3::IDENTITY;
        let mut object = DisplacedObject::new(&context, surface, &mesh.points, displacement, identity).unwrap();
        object.set_vectors(vectors).unwrap();
        if halves {
            object.set_half_paint(Paint::<Rgba16>::of_color(topology, Vec4::splat(0.5), &options).unwrap()).unwrap();
        } else {
            object.set_paint(Paint::<Rgba8>::of_color(topology, Vec4::splat(0.5), &options).unwrap()).unwrap();
        }
        let empty = Document::new(&mesh, "baseline").unwrap();
        let named = |object: &DisplacedObject, tiles: &[u32]| refusal::faces(object.surface().topology(), tiles);
        refused_and_unchanged(&context, &mut object, &empty, named, ["face 2", "faces 0, 1, 2, 3"]);
        // At a coarser level too.
        let brush = Brush::new(MIDDLE, DMat3::IDENTITY, DVec3::splat(0.3), Falloff::Smooth).unwrap();
        for action in ACTIONS {
            let dab = Dab { brush: brush.clone(), action, strength: 1.0 };
            if size == 16 && budget == 0 {
                let report = dab.apply_at(&context, &mut object, 1).unwrap();
                assert_eq!((report.bytes, named(&object, &report.refused)), (0, vec![2]), "{action:?}");
            }
        }
    }
}

#[test]
fn faces_of_triangle_meshes_beyond_the_budget_are_named_and_stay() {
    let (context, mesh) = (Context::serial(), strip(4, true));
    let vertices = mesh.points.len() as u64;
    // Values at the vertices are always there; a face of 16 segments has 169 and its edges 15 each.
    for (over, halves) in [(0, false), (169 * 2, true)] {
        let options = |texel: u64| TriangleOptions { segments: 16, budget: texel * vertices + over };
        let surface = TriangleSurface::new(&context, &mesh).unwrap();
        let topology = surface.topology().clone();
        let displacement = TriangleChannel::displacement(topology.clone(), &options(2)).unwrap();
        let mut object = TriangleObject::new(&context, surface, displacement, DAffine3::IDENTITY).unwrap();
        object.set_vectors(TriangleChannel::vectors(topology.clone(), &options(6)).unwrap()).unwrap();
        if halves {
            object.set_half_paint(TriangleChannel::of_color(topology, Vec4::splat(0.5), &options(8)).unwrap()).unwrap();
        } else {
            object.set_paint(TriangleChannel::of_color(topology, Vec4::splat(0.5), &options(4)).unwrap()).unwrap();
        }
        let empty = Document::of_triangles(&mesh, "baseline").unwrap();
        let named = |_: &TriangleObject, faces: &[u32]| faces.to_vec();
        let expected = ["faces 4, 5", "faces 0, 1, 2, 3, 4, 5, 6, 7"];
        refused_and_unchanged(&context, &mut object, &empty, named, expected);
    }
}
