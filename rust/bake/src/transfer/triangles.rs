//! As [`super`], of documents of triangle meshes: every value of a face, an edge or a vertex takes what the nearest
//! place of the old triangles has.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};
use half::f16;
use relievo_core::{Context, Error, Mesh, Progress, Result};
use relievo_document::{Document, Head, Kind};
use relievo_surface::TriangleSurface;
use relievo_tiles::texel::Vector;
use relievo_tiles::triangle::vectors::{edge_frame, face_frame, vertex_frame};
use relievo_tiles::triangle::{
    Foot, Pattern, Slot, TriangleChannel, TriangleField, TriangleOptions, TriangleSets, TriangleValues, edge_foot, foot,
};
use relievo_tiles::{Blocks, Rgba8, Rgba16, StoredTexel, Texel, Trace};

use super::{COVERAGE, FADE_NO_MORE, REACH, Transferred};
use crate::nearby_faces::{FoundFace, NearbyFaces};

/// Faces, edges or vertices that are worked on at a time.
const RUN: usize = 256;

/// What a value belongs to.
#[derive(Clone, Copy)]
enum Owner {
    Face(u32),
    Edge(u32),
    Vertex(u32),
}

pub(super) fn transfer(
    context: &Context,
    document: &Document,
    from: Option<&Mesh>,
    mesh: &Mesh,
    reach: Option<f64>,
    progress: &mut dyn Progress,
) -> Result<(Document, Transferred)> {
    let stored;
    let before = match from {
        Some(from) => {
            document.fit_triangles(from)?;
            from
        }
        None => {
            stored = document.mesh().ok_or_else(super::without_points)?;
            &stored
        }
    };
    let old = TriangleSurface::new(context, before).map_err(|error| error.at("the old mesh"))?;
    let new = TriangleSurface::new(context, mesh).map_err(|error| error.at("the new mesh"))?;
    let points = || new.points().iter().map(|point| Vec3::from(*point));
    let extent = points().fold(Vec3::NEG_INFINITY, Vec3::max) - points().fold(Vec3::INFINITY, Vec3::min);
    let reach = super::checked_reach(reach.unwrap_or(REACH * f64::from(extent.length())))?;
    let every = |surface: &TriangleSurface| (0..surface.topology().face_count() as u32).collect::<Vec<u32>>();
    let nearby = [&old, &new].map(|surface| NearbyFaces::new(surface, every(surface)));
    let mut report = Transferred { reach, ..Transferred::default() };
    let faces = every(&new);
    progress.step(0.0, "transfer")?;
    report.area = [area(&new, &faces), area(&new, &beyond(context, &new, &faces, &nearby[0], reach))];
    let mut made = Document::of_triangles(mesh, &document.level)?;
    made.time = document.time;
    let part = (1.0 - COVERAGE) / document.layers().len().max(1) as f32;
    for (number, layer) in document.layers().iter().enumerate() {
        let span = [number, number + 1].map(|at| COVERAGE + at as f32 * part);
        let head = layer.head();
        let carry = Carry { context, document, old: &old, new: &new, nearby: &nearby, reach, head, span };
        let made = &mut made;
        let lost = match head.kind {
            Kind::Scalar => carry.plain::<f16>(made, progress)?,
            Kind::Rgba8 => carry.plain::<Rgba8>(made, progress)?,
            Kind::Rgba16 => carry.plain::<Rgba16>(made, progress)?,
            Kind::Trace => carry.plain::<Trace>(made, progress)?,
            Kind::Vector => carry.vectors(made, progress)?,
            Kind::Stamps => {
                report.notes.push(FADE_NO_MORE.into());
                continue;
            }
        };
        report.layers.push((head.name.clone(), lost));
    }
    Ok((made, report))
}

fn area(surface: &TriangleSurface, faces: &[u32]) -> f64 {
    let area = |face: &u32| {
        let [a, b, c] = surface.corner_points(*face).map(|point| DVec3::from(point.map(f64::from)));
        0.5 * (b - a).cross(c - a).length()
    };
    faces.iter().map(area).fold(0.0, |sum, area| sum + area)
}

/// Those of `faces` whose middle is further than `reach` from the other surface.
fn beyond(
    context: &Context,
    surface: &TriangleSurface,
    faces: &[u32],
    other: &NearbyFaces<'_>,
    reach: f64,
) -> Vec<u32> {
    let far = context.map(faces.len(), |index| {
        let [a, b, c] = surface.corner_points(faces[index]).map(Vec3::from);
        other.find((a + b + c) / 3.0, Some((b - a).cross(c - a)), reach).is_none()
    });
    faces.iter().zip(far).filter(|(_, far)| *far).map(|(face, _)| *face).collect()
}

/// A layer on its way.
struct Carry<'a> {
    context: &'a Context,
    document: &'a Document,
    old: &'a TriangleSurface,
    new: &'a TriangleSurface,
    /// Places of the old and of the new surface.
    nearby: &'a [NearbyFaces<'a>; 2],
    reach: f64,
    head: &'a Head,
    /// The fractions of progress it goes between.
    span: [f32; 2],
}

impl Carry<'_> {
    fn stored<T: StoredTexel>(&self) -> Result<TriangleChannel<T>> {
        let topology = self.old.topology().clone();
        let limit = self.context.memory_limit();
        TriangleChannel::stored(self.context, topology, self.document, &self.head.name, limit)?
            .ok_or_else(|| Error::internal("a layer that was there is not"))
    }

    /// A layer whose values are the same wherever they are kept. Returns the area of the old faces that hold something,
    /// and of those of which nothing arrived.
    fn plain<T: StoredTexel>(&self, made: &mut Document, progress: &mut dyn Progress) -> Result<[f64; 2]> {
        let from = self.stored::<T>()?;
        let field = from.field();
        self.over(made, field, |found| field.value(found.face, found.at), |_, _, value| T::nearest(value), progress)
    }

    /// A layer of vectors, which are turned into the frames of what they come to belong to.
    fn vectors(&self, made: &mut Document, progress: &mut dyn Progress) -> Result<[f64; 2]> {
        let from = self.stored::<Vector>()?;
        let offsets = from.field().in_object_space(self.context, self.old);
        let own = |owner: Owner, foot: &Foot, value: DVec3| {
            let frame = match owner {
                Owner::Face(face) => face_frame(self.new, face, foot.normal),
                Owner::Edge(edge) => edge_frame(self.new, edge, foot.normal),
                Owner::Vertex(vertex) => vertex_frame(self.new, vertex),
            };
            Vector::nearest((frame.transpose() * value.as_vec3()).as_dvec3())
        };
        self.over(made, from.field(), |found| offsets.value(found.face, found.at), own, progress)
    }

    fn over<T: StoredTexel>(
        &self,
        made: &mut Document,
        from: &TriangleField<T>,
        sample: impl Fn(&FoundFace) -> T::Value + Sync,
        own: impl Fn(Owner, &Foot, T::Value) -> T + Sync,
        progress: &mut dyn Progress,
    ) -> Result<[f64; 2]> {
        let Self { context, old, new, nearby, reach, head, .. } = *self;
        let (topology, blank) = (new.topology(), from.blank());
        let held: Vec<u32> = (0..old.topology().face_count() as u32).filter(|face| !from.is_blank(*face)).collect();
        let segments = self.fitting(from.pattern().segments(), &held);
        let options = TriangleOptions { segments, budget: context.memory_limit() };
        let mut channel = TriangleChannel::<T>::blank(topology.clone(), blank, &options)?;
        let pattern = channel.field().pattern();
        let value = |owner: Owner, foot: Foot| match nearby[0].find(foot.point, Some(foot.normal), reach) {
            Some(found) => own(owner, &foot, sample(&found)),
            None => blank,
        };
        // What is not near a face that holds something is blank.
        let near = NearbyFaces::new(old, held.clone());
        let wanted = self.each(0..topology.face_count() as u32, |face| {
            let corners = new.corner_points(face).map(Vec3::from);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let radius = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f32::max);
            near.find(middle, None, reach + f64::from(radius)).map(|_| face)
        });
        let faces: Vec<u32> = wanted.into_iter().flatten().collect();
        let of_faces = |of: &dyn Fn(u32) -> [u32; 3]| -> Vec<u32> {
            faces.iter().flat_map(|face| of(*face)).collect::<BTreeSet<u32>>().into_iter().collect()
        };
        let edges = of_faces(&|face| topology.edges_of(face));
        let vertices = of_faces(&|face| topology.face(face));
        let vertices = self.each(vertices, |vertex| {
            let [point, normal] = [new.points(), new.normals()].map(|list| Vec3::from(list[vertex as usize]));
            (vertex, value(Owner::Vertex(vertex), Foot { point, normal }))
        });
        let edges = self.each(edges, |edge| {
            let of = |step: u32| value(Owner::Edge(edge), edge_foot(new, edge, step, segments));
            (edge, (1..segments).map(of).collect::<Vec<T>>())
        });
        let faces = context.map_watched(faces.len(), progress, ("transfer", self.span), |index| {
            let face = faces[index];
            let place = |index: u32| foot(new, face, pattern, pattern.at_slot(Slot::Inside(index)));
            let of = |index: u32| value(Owner::Face(face), place(index));
            (face, (0..pattern.face_values() as u32).map(of).collect::<Vec<T>>())
        })?;
        let bare = |values: &[T]| values.iter().all(|value| value.is_blank(blank));
        let at_vertices: BTreeSet<u32> =
            vertices.iter().filter(|(_, value)| !value.is_blank(blank)).map(|(vertex, _)| *vertex).collect();
        let on_edges: BTreeSet<u32> = edges.iter().filter(|(_, values)| !bare(values)).map(|(edge, _)| *edge).collect();
        let kept = |(face, values): &(u32, Vec<T>)| {
            !bare(values)
                || topology.edges_of(*face).iter().any(|edge| on_edges.contains(edge))
                || topology.face(*face).iter().any(|vertex| at_vertices.contains(vertex))
        };
        let faces: Vec<(u32, Vec<T>)> = faces.into_iter().filter(kept).collect();
        let allocate: Vec<u32> = faces.iter().map(|(face, _)| *face).collect();
        crate::restored::refused(&channel.apply(
            context,
            pattern,
            &TriangleSets { allocate, ..Default::default() },
        )?)?;
        let edges = edges.into_iter().filter(|(edge, _)| channel.field().edge(*edge).is_some()).collect();
        let vertices = vertices.into_iter().filter(|(vertex, _)| at_vertices.contains(vertex)).collect();
        channel.write(TriangleValues { faces, edges, vertices })?;
        let field = channel.field();
        let head = Head { blank: Blocks::blank(field).to_vec(), face_sizes: field.face_sizes(), ..head.clone() };
        let read = |block| Ok(field.bytes(block).unwrap_or_default().into_owned());
        made.pack_layer(context, head, &field.numbers(), read)?;
        Ok([area(old, &held), area(old, &beyond(context, old, &held, &nearby[1], reach))])
    }

    /// Segments an edge of the new faces, so that values are about as far apart as in the old faces that hold
    /// something.
    fn fitting(&self, segments: u32, held: &[u32]) -> u32 {
        let mean = |surface: &TriangleSurface, faces: &[u32]| area(surface, faces) / faces.len().max(1) as f64;
        let every: Vec<u32> = (0..self.new.topology().face_count() as u32).collect();
        let ratio = (mean(self.new, &every) / mean(self.old, held)).sqrt() * f64::from(segments);
        let sizes = Pattern::SIZES;
        let off = |size: &u32| (ratio / f64::from(*size)).ln().abs();
        let nearest = sizes.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.filter(|_| ratio.is_finite() && ratio > 0.0).unwrap_or(segments)
    }

    /// Works on many in parallel, in order.
    fn each<U: Send>(&self, list: impl IntoIterator<Item = u32>, of: impl Fn(u32) -> U + Sync) -> Vec<U> {
        let list: Vec<u32> = list.into_iter().collect();
        let runs: Vec<&[u32]> = list.chunks(RUN).collect();
        let done = self.context.map(runs.len(), |index| runs[index].iter().map(|item| of(*item)).collect::<Vec<U>>());
        done.into_iter().flatten().collect()
    }
}
