//! One touch of a brush on a triangle mesh: the passes that paint or sculpt what is in its box.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6:
//! intersect the box with faces and edges, decide by a scan which faces get blocks, with their edges, and set the
//! values of both. As on tiles the brush is evaluated before the scan. A face gets a block if something changes in it, on
//! one of its edges or at one of its corners, because without one it would follow these as far as the opposite side; where
//! the budget refuses one of the faces of an edge or a vertex, that stays. Stages report their time under
//! `dab.intersect`, `dab.evaluate` and `dab.manage`.

use glam::Vec4;
use relievo_core::{Context, Result};
use relievo_surface::TriangleTopology;
use relievo_tiles::triangle::{Pattern, TriangleChange, TriangleChannel, TriangleField, TriangleSets, TriangleValues};
use relievo_tiles::{Candidate, ColorPlanes, Sets, Texel, by_format};

use super::level;
use super::object::{TriangleGround, TriangleObject};
use super::site::{Element, ElementEdit, Pass, Run};
use crate::channels::frame::Vectors;
use crate::channels::knots::PerKnot;
use crate::channels::layered::LayeredObject;
use crate::paint::dab::Kind;
use crate::paint::dab::{Action, Dab};
use crate::paint::mode::{PaintMode, SculptMode};
use crate::paint::report::DabReport;
use crate::paint::spot::{Painting, Sculpting, everywhere};
use crate::paint::weights::BrushParameters;

impl TriangleObject {
    /// Paints or sculpts the mesh, all passes in a row.
    ///
    /// # Errors
    /// Fails, and changes nothing, as [`Dab::check`] and [`Self::renew`], and with `Invalid` if the object does not
    /// have the colours or vectors to change, or the active layer cannot be seen. Fails with the error of the page
    /// store if a block cannot be read from its page or written to one; part of the dab may be made then.
    pub fn dab(&mut self, context: &Context, dab: &Dab) -> Result<DabReport> {
        self.renew(context)?;
        let mut report = self.make_dab(context, dab, None)?;
        report.refuse(self.settle(context)?);
        Ok(report)
    }

    /// As [`Self::dab`], as one of the dabs of a stroke, which goes by the displacement `start` and the normals from
    /// when the stroke began.
    pub(crate) fn make_dab(
        &mut self,
        context: &Context,
        dab: &Dab,
        start: Option<TriangleGround<'_>>,
    ) -> Result<DabReport> {
        dab.check()?;
        if let Some(reports) = self.dab_on_device(context, std::slice::from_ref(dab), start)? {
            return Ok(reports.into_iter().next().unwrap_or_default());
        }
        match dab.action {
            Action::Paint { mode, color } => {
                let mut paint = self.take_paint()?;
                let color = Vec4::from(color);
                let done = by_format!(&mut paint, stack => {
                    self.paint_channel(context, dab, start, stack.active_mut(), mode, color)
                });
                self.put_paint(paint);
                done
            }
            Action::Sculpt { mode, height } => self.sculpt(context, dab, start, mode, height),
        }
    }

    fn paint_channel<T: ColorPlanes>(
        &mut self,
        context: &Context,
        dab: &Dab,
        start: Option<TriangleGround<'_>>,
        paint: &mut TriangleChannel<T>,
        mode: PaintMode,
        color: Vec4,
    ) -> Result<DabReport> {
        let faces = self.intersect(context, dab, start);
        let brush = BrushParameters::new(&dab.brush, dab.strength, &self.transform);
        let field = paint.field();
        let elements = Element::of_faces(field.topology(), &faces);
        let ground = start.unwrap_or(self.ground());
        let blank = field.blank().color().to_array();
        let stamp = dab.brush.stamp();
        let smudge = dab.brush.smudge();
        let painting =
            Painting { level: context.level(), mode, color: everywhere(color.to_array()), blank, stamp, smudge };
        let pattern = field.pattern().coarser(self.level());
        let places = places(ground);
        let pass = Pass { surface: &self.surface, field, pattern, brush: &brush };
        let edits = context.stats().time("dab.evaluate", || {
            pass.evaluate(context, &elements, places, |site, values| painting.edit(site, values))
        });
        let edits = level::refined(context, field, pattern, edits);
        let (report, _) = write(context, paint, pattern, &faces, edits, mode == PaintMode::Erase)?;
        Ok(report)
    }

    fn sculpt(
        &mut self,
        context: &Context,
        dab: &Dab,
        start: Option<TriangleGround<'_>>,
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        if mode.needs_vectors() {
            return self.bend(context, dab, start, mode, height);
        }
        if !(mode.changes_vectors() && self.vectors.is_some()) {
            return self.raise(context, dab, start, mode, height);
        }
        // Both see the mesh as it was before.
        let kept = match start {
            Some(_) => None,
            None => {
                Some((self.displacement().field().clone(), self.offsets.as_ref().map(|(offsets, _)| offsets.clone())))
            }
        };
        let kept = kept.as_ref().map(|(heights, vectors)| TriangleGround { heights, vectors: vectors.as_ref() });
        let mut report = self.raise(context, dab, start.or(kept), mode, height)?;
        let bytes = report.bytes;
        report.merge(self.bend(context, dab, start.or(kept), mode, height)?);
        report.bytes += bytes;
        Ok(report)
    }

    /// Changes the displacement along the normals.
    fn raise(
        &mut self,
        context: &Context,
        dab: &Dab,
        start: Option<TriangleGround<'_>>,
        mode: SculptMode,
        height: f32,
    ) -> Result<DabReport> {
        self.layers.displacement.check_editable()?;
        let (kind, dabs) = (Kind::Sculpt(mode), std::slice::from_ref(dab));
        if let Some(reports) = self.made_on_device(context, kind, dabs, start)? {
            return Ok(reports.into_iter().next().unwrap_or_default());
        }
        let faces = self.intersect(context, dab, start);
        let brush = BrushParameters::new(&dab.brush, dab.strength, &self.transform);
        let field = self.displacement().field();
        let elements = Element::of_faces(field.topology(), &faces);
        let stamp = dab.brush.stamp();
        let sculpting = Sculpting { level: context.level(), mode, height, stamp, since: start.is_some() };
        let pattern = field.pattern().coarser(self.level());
        let ground = start.unwrap_or(self.ground());
        let places = places(ground);
        let pass = Pass { surface: &self.surface, field, pattern, brush: &brush };
        let edits = context.stats().time("dab.evaluate", || {
            pass.evaluate(context, &elements, places, |site, values| {
                sculpting.edit(site, |site, cosines| site.facing(&self.normals, cosines), values);
            })
        });
        let edits = level::refined(context, field, pattern, edits);
        let with = |sum: [f32; 2], range: [f32; 2]| [sum[0].min(range[0]), sum[1].max(range[1])];
        self.widen(edits.iter().map(|edit| crate::object::ranges::range(&edit.values)).fold([0.0; 2], with));
        let (report, shown) = write(
            context,
            self.layers.displacement.composite_mut(),
            pattern,
            &faces,
            edits,
            mode == SculptMode::Erase,
        )?;
        self.touch(&shown);
        Ok(report)
    }

    /// The first pass: faces that may be in the box.
    pub(crate) fn intersect(&self, context: &Context, dab: &Dab, start: Option<TriangleGround<'_>>) -> Vec<u32> {
        let mut stage = context.stats().begin("dab.intersect");
        let faces = self.faces_near(context, dab.brush.obb(), start);
        stage.count("faces", faces.len() as u64);
        faces
    }
}

/// Where the vertices of a run are with displacements.
pub(super) fn places<'a>(ground: TriangleGround<'a>) -> impl Fn(&Run, &mut PerKnot, &mut Vectors) -> bool + Sync + 'a {
    move |run, heights, vectors| {
        run.heights(ground.heights, heights);
        if let Some(field) = ground.vectors {
            run.vectors(field, vectors);
        }
        ground.vectors.is_some()
    }
}

/// The third and fourth pass: the sets of the edit, their memory, and the values. Returns what was done and the faces
/// that look different.
pub(super) fn write<T: Texel>(
    context: &Context,
    channel: &mut TriangleChannel<T>,
    pattern: Pattern,
    tested: &[u32],
    edits: Vec<ElementEdit<T>>,
    reclaim: bool,
) -> Result<(DabReport, Vec<u32>)> {
    let mut stage = context.stats().begin("dab.manage");
    let topology = channel.field().topology().clone();
    let wanted = faces_of(&topology, &edits);
    let candidates: Vec<Candidate> =
        wanted.iter().map(|face| Candidate { tile: *face, decision: Candidate::MODIFY }).collect();
    let field = channel.field();
    let sets = Sets::scan(context, &candidates, |face| field.face_pattern(face).is_some_and(|own| own >= pattern));
    let new = sets.allocate.iter().filter(|face| !field.is_allocated(**face)).count();
    let allocated = TriangleSets { allocate: sets.allocate, modify: sets.modify, ..Default::default() };
    let refused = channel.apply(context, pattern, &allocated)?;
    let kept = |edit: &ElementEdit<T>| {
        // What is only written into a new block stays what it was, whoever is refused.
        let refused = if edit.count > 0 { &refused[..] } else { &[] };
        is_kept(channel.field(), refused, edit.element, edit.pattern)
    };
    let edits: Vec<ElementEdit<T>> = edits.into_iter().filter(kept).collect();
    let elements = Element::of_faces(&topology, tested);
    let texels = |element: &Element| element.count(element.pattern(channel.field()).unwrap_or(pattern)) as u64;
    let mut report = DabReport {
        tested_tiles: tested.len() as u64,
        tested_texels: elements.iter().map(texels).sum(),
        changed_texels: edits.iter().map(|edit| edit.count).sum(),
        allocated: (new as u64).saturating_sub(refused.len() as u64),
        ..DabReport::default()
    };
    let mut change = TriangleChange { faces: allocated.allocate, ..Default::default() };
    let mut values = TriangleValues::default();
    for edit in edits {
        match edit.element {
            Element::Face(face) => {
                change.faces.push(face);
                values.faces.push((face, edit.values));
            }
            Element::Edge(edge) => {
                change.edges.push(edge);
                values.edges.push((edge, edit.values));
            }
            Element::Vertex(vertex) => {
                change.vertices.push(vertex);
                values.vertices.extend(edit.values.first().map(|value| (vertex, *value)));
            }
        }
    }
    // New blocks divide the edges of their neighbours too.
    change.edges.extend(change.faces.iter().flat_map(|face| topology.edges_of(*face)));
    channel.write(values)?;
    if reclaim {
        let around = TriangleChange {
            vertices: tested.iter().flat_map(|face| topology.face(*face)).collect(),
            ..Default::default()
        };
        let freed = channel.reclaim(context, &around.faces_shown(&topology))?;
        report.freed = freed.len() as u64;
        change.edges.extend(freed.iter().flat_map(|face| topology.edges_of(*face)));
    }
    let shown = change.faces_shown(&topology);
    report.changed = shown.clone();
    report.refused = refused;
    report.bytes = channel.bytes();
    stage.count("allocated", report.allocated);
    stage.count("freed", report.freed);
    Ok((report, shown))
}

/// Whether an edit of `element` in `pattern` was written, where the budget refused some faces, ascending.
pub(super) fn is_kept<T: Texel>(field: &TriangleField<T>, refused: &[u32], element: Element, pattern: Pattern) -> bool {
    // What changes on an edge or at a vertex without all its faces would drag those along.
    let is_granted = |(face, _): (u32, u32)| refused.binary_search(&face).is_err();
    match element {
        Element::Face(face) => field.face_pattern(face) == Some(pattern),
        Element::Edge(edge) => {
            field.edge_pattern(edge) == Some(pattern) && field.topology().faces_along(edge).all(is_granted)
        }
        Element::Vertex(vertex) => field.topology().faces_around(vertex).all(is_granted),
    }
}

/// The faces that need a block for `edits`, ascending.
pub(super) fn faces_of<T>(topology: &TriangleTopology, edits: &[ElementEdit<T>]) -> Vec<u32> {
    let mut faces: Vec<u32> = Vec::new();
    for edit in edits {
        match edit.element {
            Element::Face(face) => faces.push(face),
            Element::Edge(edge) if edit.count > 0 => {
                faces.extend(topology.faces_along(edge).map(|(face, _)| face));
            }
            Element::Edge(_) => {}
            Element::Vertex(vertex) => faces.extend(topology.faces_around(vertex).map(|(face, _)| face)),
        }
    }
    faces.sort_unstable();
    faces.dedup();
    faces
}
