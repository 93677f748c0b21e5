//! Colours of half floats as an object's own: far beyond 1 through painting, layers, undo, documents and look-up, on
//! Catmull-Clark surfaces and triangle meshes.

use std::fmt::Debug;

use glam::{DAffine3, DVec3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{
    Action, Canvas, DecayingObject, DisplacedObject, Falloff, History, LayeredObject, PaintMode, Recorded, Stroke,
    StrokePoint, StrokeSettings, TriangleObject,
};
use relievo_document::{Blend, Document, Kind, Settings};
use relievo_surface::{Place, Surface, SurfaceOptions, TriangleSurface};
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};
use relievo_tiles::{ByFormat, ChannelOptions, DecayOptions, Displacement, Paint};

const LIMIT: u64 = 1 << 30;
const BASE: Vec4 = Vec4::new(2.0, 0.25, 0.0, 1.0);
/// The brightest colour that a brush has, all of it half floats.
const LIGHT: [f32; 4] = [10_000.0, 3.0, 0.125, 1.0];

/// An object of either kind whose colours are half floats, and how it is looked at.
trait Bright: Canvas + Recorded + LayeredObject + Debug {
    fn with_halves(context: &Context, mesh: &Mesh, size: u32) -> Self;

    fn with_bytes(context: &Context, mesh: &Mesh, size: u32) -> Self;

    fn empty_document(mesh: &Mesh) -> Document;

    /// The colour seen at a place of a face that is far from its edges.
    fn seen(&self, face: u32, u: f32, v: f32) -> Vec4;

    fn has_halves(&self) -> bool;

    fn paint_bytes(&self) -> u64;
}

impl Bright for DisplacedObject {
    fn with_halves(context: &Context, mesh: &Mesh, size: u32) -> Self {
        let mut object = Self::with_bytes(context, mesh, size);
        let options = ChannelOptions { size, ..ChannelOptions::default() };
        object.set_half_paint(Paint::of_color(object.surface().topology().clone(), BASE, &options).unwrap()).unwrap();
        object
    }

    fn with_bytes(context: &Context, mesh: &Mesh, size: u32) -> Self {
        let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
        let options = ChannelOptions { size, ..ChannelOptions::default() };
        let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
        let paint = Paint::of_color(surface.topology().clone(), BASE, &options).unwrap();
        let mut object = Self::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY).unwrap();
        object.set_paint(paint).unwrap();
        object
    }

    fn empty_document(mesh: &Mesh) -> Document {
        Document::new(mesh, "baseline").unwrap()
    }

    fn seen(&self, face: u32, u: f32, v: f32) -> Vec4 {
        let place = Place::new(face, u, v);
        let found = self.colors().unwrap().color(place);
        if let Some(paint) = self.half_paint() {
            // Filtered over next to nothing it is the same.
            let filtered = paint.field().filtered(place, [[1e-4, 0.0], [0.0, 1e-4]]);
            assert!((filtered - found).abs().max_element() <= 1e-3 * found.max_element(), "{filtered} {found}");
        }
        found
    }

    fn has_halves(&self) -> bool {
        assert!(self.paint().is_none() || self.half_paint().is_none());
        matches!(self.colors(), Some(ByFormat::Rgba16(_)))
    }

    fn paint_bytes(&self) -> u64 {
        self.half_paint().map_or(0, |paint| paint.bytes())
    }
}

impl Bright for TriangleObject {
    fn with_halves(context: &Context, mesh: &Mesh, size: u32) -> Self {
        let mut object = Self::with_bytes(context, mesh, size);
        let options = TriangleOptions { segments: size, budget: LIMIT };
        let topology = object.surface().topology().clone();
        object.set_half_paint(TriangleChannel::of_color(topology, BASE, &options).unwrap()).unwrap();
        object
    }

    fn with_bytes(context: &Context, mesh: &Mesh, size: u32) -> Self {
        let surface = TriangleSurface::new(context, mesh).unwrap();
        let topology = surface.topology().clone();
        let options = TriangleOptions { segments: size, budget: LIMIT };
        let displacement = TriangleChannel::displacement(topology.clone(), &options).unwrap();
        let mut object = Self::new(context, surface, displacement, DAffine3::IDENTITY).unwrap();
        object.set_paint(TriangleChannel::of_color(topology, BASE, &options).unwrap()).unwrap();
        object
    }

    fn empty_document(mesh: &Mesh) -> Document {
        Document::of_triangles(mesh, "baseline").unwrap()
    }

    fn seen(&self, face: u32, u: f32, v: f32) -> Vec4 {
        // The first of the two triangles of a square is the one below its diagonal.
        let (u, v) = (u.max(v), u.min(v));
        let colors = self.half_paint().unwrap().field();
        colors.value(2 * face, [1.0 - u, u - v, v]).as_vec4()
    }

    fn has_halves(&self) -> bool {
        assert!(self.paint().is_none() || self.half_paint().is_none());
        matches!(self.colors(), Some(ByFormat::Rgba16(_)))
    }

    fn paint_bytes(&self) -> u64 {
        self.half_paint().map_or(0, |paint| paint.bytes())
    }
}

/// A square from 0 to 4 in z = 0, of unit faces or of pairs of triangles.
fn plane(triangles: bool) -> Mesh {
    let points = (0..25).map(|k| [(k % 5) as f32, (k / 5) as f32, 0.0]).collect();
    let corner = |x: u32, y: u32| y * 5 + x;
    let faces: Vec<[u32; 4]> = (0..16)
        .map(|k| (k % 4, k / 4))
        .map(|(x, y)| [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)])
        .collect();
    if !triangles {
        return Mesh::new(points, vec![4; 16], faces.concat());
    }
    let halves: Vec<[u32; 3]> = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Mesh::from_triangles(points, &halves)
}

/// The middle of a face of [`plane`].
fn middle(face: u32) -> DVec3 {
    DVec3::new(f64::from(face % 4) + 0.5, f64::from(face / 4) + 0.5, 0.0)
}

fn stroke(at: DVec3, mode: PaintMode, color: [f32; 4]) -> Stroke {
    let settings = StrokeSettings { radius: 0.7, spacing: 10.0, ..StrokeSettings::default() };
    Stroke::new(vec![StrokePoint::new(at, 1.0)], settings, Falloff::Constant, Action::Paint { mode, color })
}

fn document<O: Bright>(context: &Context, mesh: &Mesh, object: &O) -> Document {
    let mut document = O::empty_document(mesh);
    object.store(context, &mut document).unwrap();
    document
}

fn near(found: Vec4, expected: Vec4) {
    let far = (found - expected).abs() / (1e-3 + expected.abs());
    assert!(far.max_element() < 2e-3, "{found} is not {expected}");
}

fn light_is_painted_kept_undone_and_blended<O: Bright>(triangles: bool) {
    let (context, mesh) = (Context::serial(), plane(triangles));
    let mut object = O::with_halves(&context, &mesh, 16);
    assert!(object.has_halves());
    let (first, second) = (middle(5), middle(10));
    let bytes = |object: &O| document(&context, &mesh, object).to_bytes().unwrap();
    let (start, memory) = (bytes(&object), object.paint_bytes());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("light.relievo");
    let mut history = History::new(1000);
    history.save(&path, &document(&context, &mesh, &object)).unwrap();
    let mut made = |object: &mut O, name: &str, stroke: &Stroke| {
        history.begin(&context, object, name).unwrap();
        stroke.apply(&context, object).unwrap();
        history.end(&context, object).unwrap().unwrap();
    };
    let light = Vec4::from(LIGHT);
    made(&mut object, "mix", &stroke(first, PaintMode::Mix, LIGHT));
    near(object.seen(5, 0.5, 0.4), light);
    made(&mut object, "add", &stroke(first, PaintMode::Add, [10_000.0, 0.0, 1.0, 1.0]));
    near(object.seen(5, 0.5, 0.4), light + Vec4::new(10_000.0, 0.0, 1.0, 0.0));
    // What half floats cannot hold stays the largest that they do.
    made(&mut object, "multiply", &stroke(first, PaintMode::Multiply, [100.0, 0.5, 1.0, 1.0]));
    near(object.seen(5, 0.5, 0.4), Vec4::new(65504.0, 1.5, 1.125, 1.0));
    made(&mut object, "blur", &stroke(first, PaintMode::Blur, LIGHT));
    made(&mut object, "far", &stroke(second, PaintMode::Mix, LIGHT));
    // A layer of its own, which is added at half its strength.
    let settings = Settings { opacity: 0.5, blend: Blend::Add, visible: true };
    history.begin(&context, &mut object, "layer").unwrap();
    let (layer, _) = object.add_layer(&context, Kind::Rgba8, "glow", settings, 16).unwrap();
    history.end(&context, &mut object).unwrap().unwrap();
    history.begin(&context, &mut object, "glow").unwrap();
    stroke(second, PaintMode::Mix, [400.0, 0.0, 0.0, 1.0]).apply(&context, &mut object).unwrap();
    history.end(&context, &mut object).unwrap().unwrap();
    near(object.seen(10, 0.5, 0.4), light + Vec4::new(200.0, 0.0, 0.0, 0.0));
    let kinds: Vec<Kind> = object.layers().iter().map(|layer| layer.kind).collect();
    assert_eq!(kinds, [Kind::Scalar, Kind::Rgba16, Kind::Rgba16]);
    object.set_layer(&context, layer, Settings { visible: false, ..settings }).unwrap();
    near(object.seen(10, 0.5, 0.4), light);
    object.set_layer(&context, layer, settings).unwrap();

    let end = bytes(&object);
    let count = history.undo_count();
    assert_eq!(count, 7);
    while history.undo(&context, &mut object).unwrap().is_some() {}
    assert!(bytes(&object) == start && object.paint_bytes() == memory);
    while history.redo(&context, &mut object).unwrap().is_some() {}
    assert!(bytes(&object) == end);
    drop(history);
    // An object of 8 bits takes the document's colours.
    let (saved, mut history) = History::open(&path, LIMIT, LIMIT).unwrap();
    let mut again = O::with_bytes(&context, &mesh, 8);
    assert!(!again.has_halves());
    assert!(again.take_up(&context, &saved, LIMIT).unwrap().is_empty());
    assert!(again.has_halves() && bytes(&again) == end && history.undo_count() == count);
    near(again.seen(10, 0.5, 0.4), light + Vec4::new(200.0, 0.0, 0.0, 0.0));
    while history.undo(&context, &mut again).unwrap().is_some() {}
    assert!(bytes(&again) == start);
    while history.redo(&context, &mut again).unwrap().is_some() {}

    again.merge_layer(&context, layer).unwrap();
    near(again.seen(10, 0.5, 0.4), light + Vec4::new(200.0, 0.0, 0.0, 0.0));
    again.flatten_layers(&context).unwrap();
    for (at, face) in [(first, 5), (second, 10)] {
        let erased = stroke(at, PaintMode::Erase, LIGHT).apply(&context, &mut again).unwrap();
        assert!(erased.report.changed_texels > 0);
        near(again.seen(face, 0.5, 0.4), BASE);
    }
    assert_eq!(again.paint_bytes(), memory);
}

#[test]
fn light_stays_light_on_catmull_clark_surfaces() {
    light_is_painted_kept_undone_and_blended::<DisplacedObject>(false);
}

#[test]
fn light_stays_light_on_triangle_meshes() {
    light_is_painted_kept_undone_and_blended::<TriangleObject>(true);
}

#[test]
fn weak_dabs_arrive_where_those_on_bytes_stop() {
    let (context, mesh) = (Context::serial(), plane(false));
    let weak = Stroke {
        settings: StrokeSettings { strength: 0.002, ..stroke(DVec3::ZERO, PaintMode::Mix, LIGHT).settings },
        ..stroke(middle(5), PaintMode::Mix, [0.5, 0.5, 0.5, 1.0])
    };
    let mut halves = DisplacedObject::with_halves(&context, &mesh, 8);
    let mut bytes = DisplacedObject::with_bytes(&context, &mesh, 8);
    for _ in 0..200 {
        weak.apply(&context, &mut halves).unwrap();
        weak.apply(&context, &mut bytes).unwrap();
    }
    // 1 − 0.998²⁰⁰ of the way from 0 to ½.
    let expected = 0.5 * (1.0 - 0.998f32.powi(200));
    let [half, byte] = [&halves, &bytes].map(|object| object.seen(5, 0.5, 0.5).z);
    assert!((half - expected).abs() < 0.02 && (byte - expected).abs() > 0.05, "{half} {byte} {expected}");
}

#[test]
fn light_fades_to_what_was_there_without_it() {
    let (context, mesh) = (Context::serial(), plane(false));
    let mut object = DisplacedObject::with_halves(&context, &mesh, 8);
    object.set_decay(DecayOptions { delay: 1.0, duration: 2.0 }, LIMIT).unwrap();
    stroke(middle(5), PaintMode::Mix, LIGHT).apply(&context, &mut object).unwrap();
    let (light, layer) = (Vec4::from(LIGHT), object.layers()[1].id);
    assert_eq!(object.decay(layer).unwrap().duration, 2.0);
    for (time, share) in [(1.0, 1.0), (2.0, 0.5), (3.0, 0.0)] {
        object.advance(&context, time).unwrap();
        near(object.seen(5, 0.5, 0.4), BASE + share * (light - BASE));
    }
    assert_eq!(object.paint_bytes(), 0);
}
