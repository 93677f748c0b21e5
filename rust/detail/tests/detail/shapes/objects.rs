//! Objects with displacement and colours, their values and bytes, and undoing on two of them at once.

use glam::{DAffine3, Vec4};
use relievo_core::{Context, Mesh};
use relievo_detail::{DisplacedObject, History, LayeredObject, Recorded, TriangleObject};
use relievo_document::Document;
use relievo_surface::{Surface, SurfaceOptions};
use relievo_tiles::triangle::{FaceRates, Node, Pattern, TriangleChannel};
use relievo_tiles::{ChannelOptions, Displacement, Paint, Texel};

/// Makes an object whose tiles have `size` texels a side, of displacement and of colours, which are `blank`.
pub(crate) fn painted(context: &Context, mesh: &Mesh, size: u32, blank: Vec4, transform: DAffine3) -> DisplacedObject {
    let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
    let options = ChannelOptions { size, ..ChannelOptions::default() };
    let displacement = Displacement::new(surface.topology().clone(), &options).unwrap();
    let paint = Paint::of_color(surface.topology().clone(), blank, &options).unwrap();
    let mut object = DisplacedObject::new(context, surface, &mesh.points, displacement, transform).unwrap();
    object.set_paint(paint).unwrap();
    object
}

/// Returns all vertices of the finest tessellation of a triangle mesh.
pub(crate) fn fine_values(object: &TriangleObject) -> impl Iterator<Item = (u32, Pattern, Node)> + use<> {
    let pattern = object.displacement().field().pattern();
    let rates = FaceRates { sides: [pattern.segments(); 3], inside: Some(pattern) };
    let faces = 0..object.surface().topology().face_count() as u32;
    faces.flat_map(move |face| rates.places().into_iter().map(move |(pattern, node)| (face, pattern, node)))
}

/// Returns the bytes of all values of a channel of a triangle mesh.
pub(crate) fn value_bytes<T: Texel>(channel: &TriangleChannel<T>) -> Vec<u8> {
    let field = channel.field();
    let topology = field.topology();
    let faces = (0..topology.face_count() as u32).map(|face| field.face(face).unwrap_or(&[]));
    let edges = (0..topology.edge_count() as u32).map(|edge| field.edge(edge).unwrap_or(&[]));
    faces.chain(edges).chain(field.vertices()).flat_map(bytemuck::cast_slice::<T, u8>).copied().collect()
}

/// Stores a triangle mesh and its channels in a document.
pub(crate) fn stored_triangles(context: &Context, mesh: &Mesh, object: &TriangleObject) -> Document {
    let mut document = Document::of_triangles(mesh, context.level().name()).unwrap();
    object.store(context, &mut document).unwrap();
    document
}

/// Returns the bytes of the document of a triangle mesh.
pub(crate) fn stored_bytes(context: &Context, mesh: &Mesh, object: &TriangleObject) -> Vec<u8> {
    stored_triangles(context, mesh, object).to_bytes().unwrap()
}

/// Undoes an edit of two objects, of which both histories say the same.
pub(crate) fn undo_both<O: Recorded>(context: &Context, [a, b]: [(&mut History, &mut O); 2]) {
    let [a, b] = [a.0.undo(context, a.1), b.0.undo(context, b.1)];
    assert_eq!(a.unwrap(), b.unwrap());
}

/// Makes an edit of two objects again, of which both histories say the same.
pub(crate) fn redo_both<O: Recorded>(context: &Context, [a, b]: [(&mut History, &mut O); 2]) {
    let [a, b] = [a.0.redo(context, a.1), b.0.redo(context, b.1)];
    assert_eq!(a.unwrap(), b.unwrap());
}
