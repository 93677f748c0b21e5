//! Dabs that change the vector displacement of a triangle mesh.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6. Each
//! vector is in the frame of the face, edge or vertex it belongs to, so values are read, changed and interpolated in
//! object space, and only what changed goes back to its frame. What gets a block without being changed is written too,
//! because a mean of vectors in several frames means nothing. Units: object units.

use glam::Mat3;
use relievo_core::{Context, Result};
use relievo_surface::TriangleSurface;
use relievo_tiles::triangle::vectors::{edge_frame, face_frame, vertex_frame};
use relievo_tiles::triangle::{Offset, Pattern, TriangleField, edge_foot, foot};
use relievo_tiles::{Texel, Vector};

use super::dab::{faces_of, places, write};
use super::level;
use super::object::{TriangleGround, TriangleObject, field_length};
use super::site::{Element, ElementEdit, Pass, values};
use crate::paint::dab::Kind;
use crate::paint::dab::{Dab, no_vectors};
use crate::paint::mode::SculptMode;
use crate::paint::report::DabReport;
use crate::paint::vector::Bending;
use crate::paint::weights::BrushParameters;

impl TriangleObject {
    /// Changes the vector displacement.
    pub(super) fn bend(
        &mut self,
        context: &Context,
        dab: &Dab,
        start: Option<TriangleGround<'_>>,
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        if self.offsets.is_none() {
            return Err(no_vectors());
        }
        let (kind, dabs) = (Kind::Bend(mode), std::slice::from_ref(dab));
        if let Some(reports) = self.made_on_device(context, kind, dabs, start)? {
            return Ok(reports.into_iter().next().unwrap_or_default());
        }
        let faces = self.intersect(context, dab, start);
        let Some((offsets, _)) = &self.offsets else { return Err(no_vectors()) };
        let brush = BrushParameters::new(&dab.brush, dab.strength, &self.transform);
        let elements = Element::of_faces(offsets.topology(), &faces);
        let pattern = offsets.pattern().coarser(self.level());
        let places = places(start.unwrap_or(self.ground()));
        let bending = Bending::new(context.level(), mode, height, &dab.brush, &self.transform);
        let surface = &self.surface;
        let edits = context.stats().time("dab.evaluate", || {
            let pass = Pass { surface, field: offsets, pattern, brush: &brush };
            let edits = pass.evaluate(context, &elements, places, |site, values| bending.edit(site, values));
            level::refined(context, offsets, pattern, edits)
        });
        self.write_bent(context, pattern, &faces, edits, mode == SculptMode::Erase)
    }

    /// The third and fourth pass, of edits in object space among `faces`.
    pub(super) fn write_bent(
        &mut self,
        context: &Context,
        pattern: Pattern,
        faces: &[u32],
        edits: Vec<ElementEdit<Offset>>,
        erases: bool,
    ) -> Result<DabReport> {
        let (Some(vectors), Some((offsets, _))) = (&self.vectors, &self.offsets) else { return Err(no_vectors()) };
        let edits = framed(context, &self.surface, vectors.field(), offsets, pattern, edits);
        let (Some(vectors), Some((offsets, reach))) = (&mut self.vectors, &mut self.offsets) else {
            return Err(no_vectors());
        };
        let (report, shown) = write(context, vectors, pattern, faces, edits, erases)?;
        vectors.field().renew_in_object_space(context, &self.surface, &shown, offsets);
        *reach = shown.iter().map(|face| field_length(offsets, *face)).fold(*reach, f32::max);
        self.touch(&shown);
        Ok(report)
    }
}

/// Edits of vectors in their frames made of edits in object space, and of what will get a block beside them.
fn framed(
    context: &Context,
    surface: &TriangleSurface,
    vectors: &TriangleField<Vector>,
    offsets: &TriangleField<Offset>,
    pattern: Pattern,
    edits: Vec<ElementEdit<Offset>>,
) -> Vec<ElementEdit<Vector>> {
    let topology = surface.topology();
    let made = context.map(edits.len(), |index| {
        let edit = &edits[index];
        let before = values(offsets, edit.element, edit.pattern)?;
        let kept = own(vectors, edit.element, edit.pattern);
        let frames = frames(surface, edit.element, edit.pattern);
        let (mut values, mut count) = (Vec::with_capacity(edit.values.len()), 0);
        for (k, (new, old)) in edit.values.iter().zip(&before).enumerate() {
            let into = |offset: &Offset| Vector::nearest(frames[k].transpose().as_dmat3() * offset.value());
            // What the edit does not reach keeps its bits.
            let old_vector = kept.get(k).copied().unwrap_or_else(|| into(old));
            let new_vector = if new.same(*old) { old_vector } else { into(new) };
            count += u64::from(!new_vector.same(old_vector));
            values.push(new_vector);
        }
        (count > 0).then_some(ElementEdit { element: edit.element, pattern: edit.pattern, values, count })
    });
    let mut edits: Vec<ElementEdit<Vector>> = made.into_iter().flatten().collect();
    let mut around = faces_of(topology, &edits);
    around.retain(|face| vectors.face_pattern(*face).is_none_or(|own| own < pattern) && !offsets.is_blank(*face));
    let mut others = Element::of_faces(topology, &around);
    others.retain(|element| {
        !matches!(element, Element::Vertex(_))
            && element.pattern(vectors).is_none_or(|own| own < pattern)
            && edits.binary_search_by_key(element, |edit| edit.element).is_err()
    });
    let made = context.map(others.len(), |index| {
        let element = others[index];
        let offsets = values(offsets, element, pattern)?;
        let frames = frames(surface, element, pattern);
        let turned = offsets.iter().zip(&frames);
        let values = turned.map(|(offset, frame)| Vector::nearest(frame.transpose().as_dmat3() * offset.value()));
        Some(ElementEdit { element, pattern, values: values.collect(), count: 0 })
    });
    edits.extend(made.into_iter().flatten());
    edits.sort_by_key(|edit| edit.element);
    edits
}

/// What an element holds in `pattern`; nothing if it has none.
fn own(vectors: &TriangleField<Vector>, element: Element, pattern: Pattern) -> Vec<Vector> {
    let block = match element {
        Element::Face(face) => vectors.face(face),
        Element::Edge(edge) => vectors.edge(edge),
        Element::Vertex(vertex) => return vec![vectors.vertex(vertex)],
    };
    block.filter(|_| element.pattern(vectors) == Some(pattern)).unwrap_or(&[]).to_vec()
}

/// The frames of an element's values.
fn frames(surface: &TriangleSurface, element: Element, pattern: Pattern) -> Vec<Mat3> {
    match element {
        Element::Face(face) => {
            let knots = element.knots(surface.topology(), pattern).into_iter();
            knots.map(|(_, _, node)| face_frame(surface, face, foot(surface, face, pattern, node).normal)).collect()
        }
        Element::Edge(edge) => {
            let segments = pattern.segments();
            let normal = |step: u32| edge_foot(surface, edge, step, segments).normal;
            (1..segments).map(|step| edge_frame(surface, edge, normal(step))).collect()
        }
        Element::Vertex(vertex) => vec![vertex_frame(surface, vertex)],
    }
}
