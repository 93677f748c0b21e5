//! Normals of a displaced triangle mesh, in a buffer of their own that is renewed where the mesh was modified.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 6.3: the
//! normal at a vertex of the tessellation is the mean of the triangles around it by their area, those of both faces at
//! edges and of all at vertices of the mesh; and by the length of the displacement it is blended with the smooth normal
//! of the undisplaced mesh. Left at that, flat faces show where the displacement is large. So what is blended is not
//! the mean itself but the smooth normal and by how much the mean differs from that of the undisplaced triangles. The
//! buffer holds that difference; it is zero where nothing is displaced.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use relievo_core::{Context, Result};
use relievo_surface::{TriangleSurface, TriangleTopology};

use super::around::{Around, Said};
use super::displaced::{Foot, TriangleDisplaced, foot};
use super::field::{Entry, TriangleClass, TriangleField};
use super::pattern::{Node, Pattern};
use super::vectors::Offset;
use crate::store::heap::BlockId;
use crate::store::pages::CowBlocks;
use crate::store::slot::Slot as Texels;

/// The normals of all vertices of a displaced mesh's tessellation.
#[derive(Clone, Debug)]
pub struct TriangleNormals {
    turns: TriangleField<Offset>,
}

impl TriangleNormals {
    /// Those of an undisplaced mesh whose displacement has `pattern` at its finest.
    pub fn new(topology: &Arc<TriangleTopology>, pattern: Pattern) -> Self {
        Self { turns: TriangleField::new(topology.clone(), pattern, Offset::default()) }
    }

    /// Those of `displaced`, all of them.
    ///
    /// # Errors
    /// None at present: normals are found wherever the surface has a point.
    pub fn of(context: &Context, displaced: &TriangleDisplaced<'_>) -> Result<Self> {
        let field = displaced.field();
        let mut normals = Self::new(field.topology(), field.pattern());
        let faces: Vec<u32> =
            (0..field.topology().face_count() as u32).filter(|face| displaced.is_modified(*face)).collect();
        normals.update(context, displaced, &faces);
        Ok(normals)
    }

    /// Bytes of the buffer, those of vertices not counted.
    pub fn bytes(&self) -> u64 {
        let faces = self.turns.allocated().filter_map(|face| self.turns.face(face)).map(size_of_val);
        let edges = self.turns.allocated_edges().filter_map(|edge| self.turns.edge(edge)).map(size_of_val);
        faces.chain(edges).sum::<usize>() as u64
    }

    /// By how much normals differ from the smooth ones of the undisplaced mesh.
    pub fn turns(&self) -> &TriangleField<Offset> {
        &self.turns
    }

    /// The unit normal at a vertex of any pattern laid over `face`; zero where the mesh has none.
    pub fn at(&self, surface: &TriangleSurface, face: u32, pattern: Pattern, node: Node) -> Vec3 {
        let smooth = foot(surface, face, pattern, node).normal;
        self.turned(smooth, self.turns.at(face, pattern, node))
    }

    /// The unit normal at the place of `face` with barycentric coordinates `at`, where the smooth normal is `smooth`.
    pub fn value(&self, smooth: Vec3, face: u32, at: [f32; 3]) -> Vec3 {
        self.turned(smooth, self.turns.value(face, at))
    }

    fn turned(&self, smooth: Vec3, turn: DVec3) -> Vec3 {
        if turn == DVec3::ZERO {
            return smooth;
        }
        (smooth.as_dvec3() + turn).normalize_or(smooth.as_dvec3()).as_vec3()
    }

    /// Renews the normals of `faces`, ascending, which look different than before or whose neighbours do, and of their
    /// edges and corners.
    pub fn update(&mut self, context: &Context, displaced: &TriangleDisplaced<'_>, faces: &[u32]) {
        let field = displaced.field();
        let topology = field.topology();
        let mut edges: Vec<u32> = faces.iter().flat_map(|face| topology.edges_of(*face)).collect();
        let mut vertices: Vec<u32> = faces.iter().flat_map(|face| topology.face(*face)).collect();
        let mut around: Vec<u32> =
            vertices.iter().flat_map(|vertex| topology.faces_around(*vertex)).map(|(face, _)| face).collect();
        for list in [&mut edges, &mut vertices, &mut around] {
            list.sort_unstable();
            list.dedup();
        }
        let said = context.map(around.len(), |index| {
            let face = around[index];
            Said::by(displaced, face, faces.binary_search(&face).is_ok())
        });
        let said_of = |face: u32| around.binary_search(&face).ok().map(|index| &said[index]);
        for (face, said) in around.iter().zip(&said).filter(|(face, _)| faces.binary_search(face).is_ok()) {
            let class = said.rates.inside.map(|pattern| TriangleClass { face: true, pattern });
            set(&mut self.turns.faces, *face, class, &said.inside);
        }
        let along = context.map(edges.len(), |index| {
            let edge = edges[index];
            let pattern = displaced.edge_pattern(edge)?;
            let segments = pattern.segments();
            let mut totals = vec![Around::NOTHING; segments as usize - 1];
            for (face, side) in topology.faces_along(edge) {
                let Some(said) = said_of(face) else { continue };
                let start = said.rates.sides[..side as usize].iter().sum::<u32>() as usize + 1;
                let sums = &said.border[start..start + totals.len()];
                match topology.side(face, side).reversed {
                    false => totals.iter_mut().zip(sums).for_each(|(total, sum)| total.add(sum)),
                    true => totals.iter_mut().zip(sums.iter().rev()).for_each(|(total, sum)| total.add(sum)),
                }
            }
            let [low, high] = topology.edge(edge).map(|vertex| Foot::at_vertex(displaced.surface(), vertex));
            let turn = |(step, total): (u32, &Around)| total.turn(low.toward(&high, step, segments).normal);
            Some((TriangleClass { face: false, pattern }, (1..).zip(&totals).map(turn).collect::<Vec<Offset>>()))
        });
        for (edge, values) in edges.iter().zip(&along) {
            let (class, values) = values.as_ref().map_or((None, &[][..]), |(class, values)| (Some(*class), values));
            set(&mut self.turns.edges, *edge, class, values);
        }
        let corners = context.map(vertices.len(), |index| {
            let mut total = Around::NOTHING;
            for (face, corner) in topology.faces_around(vertices[index]) {
                let Some(said) = said_of(face) else { continue };
                total.add(&said.border[said.rates.sides[..corner as usize].iter().sum::<u32>() as usize]);
            }
            total.turn(Vec3::from(displaced.surface().normals()[vertices[index] as usize]))
        });
        for (vertex, turn) in vertices.iter().zip(corners) {
            if self.turns.vertex(*vertex) != turn {
                self.turns.set_vertex(*vertex, turn);
            }
        }
    }
}

/// Puts the values of a block in place of what an element has; nothing where it has no class.
fn set(pages: &mut CowBlocks<Entry<Offset>>, element: u32, class: Option<TriangleClass>, values: &[Offset]) {
    if class.is_none() && pages.entry(element).is_none() {
        return;
    }
    let held = pages.entry_mut(element);
    if let (Some(Entry { texels: Texels::Here(texels), id, .. }), Some(class)) = (&mut *held, class)
        && id.class == class
        && let Some(own) = Arc::get_mut(texels)
    {
        own.copy_from_slice(values);
        return;
    }
    // The buffer has no heap: blocks come and go with those of the displacement.
    let id = |class| BlockId { class, number: 0 };
    *held = class.map(|class| Entry { texels: Texels::Here(values.into()), id: id(class), version: 0 });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texel::Vector;
    use crate::triangle::displaced::edge_foot;
    use crate::triangle::pattern::Slot;
    use crate::triangle::piece::FaceRates;
    use crate::triangle::piece::TrianglePiece;
    use crate::triangle::shapes;
    use crate::triangle::{TriangleChannel, TriangleOptions, TriangleSets, TriangleValues};
    use half::f16;
    use relievo_core::Mesh;
    use std::collections::{BTreeMap, BTreeSet};

    fn random(seed: u64) -> impl FnMut() -> f32 {
        let mut state = seed | 1;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 40) as f32 / (1u64 << 24) as f32
        }
    }

    /// A mesh of which faces of three levels have displacements of up to `height`.
    fn rough(context: &Context, mesh: &Mesh, height: f32) -> (TriangleSurface, TriangleChannel) {
        let surface = TriangleSurface::new(context, mesh).unwrap();
        let options = TriangleOptions { segments: 16, budget: 1 << 24 };
        let mut channel = TriangleChannel::displacement(surface.topology().clone(), &options).unwrap();
        for (segments, faces) in [(4, vec![2, 13]), (8, vec![3, 9]), (16, vec![4, 10])] {
            let sets = TriangleSets { allocate: faces, ..Default::default() };
            channel.apply(context, Pattern::new(segments).unwrap(), &sets).unwrap();
        }
        let mut random = random(5);
        let mut number = || f16::from_f32(height * random());
        let field = channel.field().clone();
        let mut block = |block: Option<&[f16]>| block.unwrap_or(&[]).iter().map(|_| number()).collect::<Vec<_>>();
        let faces = field.allocated().map(|face| (face, block(field.face(face)))).collect();
        let edges = field.allocated_edges().map(|edge| (edge, block(field.edge(edge)))).collect();
        let corners: BTreeSet<u32> = field.allocated().flat_map(|face| field.topology().face(face)).collect();
        let vertices = corners.into_iter().map(|vertex| (vertex, number())).collect();
        channel.write(TriangleValues { faces, edges, vertices }).unwrap();
        (surface, channel)
    }

    fn pieces(context: &Context, surface: &TriangleSurface, channel: &TriangleChannel) -> Vec<TrianglePiece> {
        let displaced = TriangleDisplaced::new(surface, channel.field()).unwrap();
        let normals = TriangleNormals::of(context, &displaced).unwrap();
        let faces = 0..surface.topology().face_count() as u32;
        faces
            .map(|face| TrianglePiece::new(&displaced, &normals, face, &FaceRates::of(channel.field(), face)))
            .collect()
    }

    #[test]
    fn displaced_meshes_have_no_cracks_whatever_the_levels_of_their_faces() {
        let context = Context::serial();
        let mesh = shapes::sail(3);
        let (surface, channel) = rough(&context, &mesh, 0.1);
        let topology = surface.topology();
        let pieces = pieces(&context, &surface, &channel);
        assert!(pieces.iter().filter(|piece| piece.triangles.len() == 1).count() > 2);
        // Every edge of the tessellation that is not on a boundary of the mesh has as many triangles as the mesh there.
        let bits = |point: [f32; 3]| point.map(|value| (value + 0.0).to_bits());
        let mut uses: BTreeMap<_, usize> = BTreeMap::new();
        let mut normals: BTreeMap<_, [u32; 3]> = BTreeMap::new();
        for piece in &pieces {
            for [a, b, c] in &piece.triangles {
                for (a, b) in [(a, b), (b, c), (c, a)] {
                    let (a, b) = (bits(piece.points[*a as usize]), bits(piece.points[*b as usize]));
                    *uses.entry((a.min(b), a.max(b))).or_default() += 1;
                }
            }
            for (point, normal) in piece.points.iter().zip(&piece.normals).take(piece.border) {
                let normal = normal.map(f32::to_bits);
                assert_eq!(*normals.entry(bits(*point)).or_insert(normal), normal);
            }
        }
        let open = uses.values().filter(|uses| **uses == 1).count();
        let segments = |edge: u32| channel.field().edge_pattern(edge).map_or(1, Pattern::segments) as usize;
        let edges = 0..topology.edge_count() as u32;
        let boundary: usize = edges.filter(|edge| topology.faces_along(*edge).len() == 1).map(segments).sum();
        assert_eq!(open, boundary);
    }

    #[test]
    fn pieces_cover_their_face_once() {
        let context = Context::serial();
        let (surface, channel) = rough(&context, &shapes::sail(3), 0.0);
        for (face, piece) in pieces(&context, &surface, &channel).iter().enumerate() {
            let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a);
            let whole = area(surface.corner_points(face as u32).map(Vec3::from));
            let parts: Vec<Vec3> = piece
                .triangles
                .iter()
                .map(|triangle| area(triangle.map(|at| Vec3::from(piece.points[at as usize]))))
                .collect();
            assert!(parts.iter().all(|part| part.dot(whole) > 0.0), "face {face}");
            assert!((parts.iter().sum::<Vec3>() - whole).length() < 1e-5 * whole.length());
        }
    }

    #[test]
    fn normals_of_what_is_not_displaced_are_the_smooth_ones_to_the_bit() {
        let context = Context::serial();
        let (surface, channel) = rough(&context, &shapes::sail(3), 0.0);
        let displaced = TriangleDisplaced::new(&surface, channel.field()).unwrap();
        for (face, piece) in (0..).zip(pieces(&context, &surface, &channel)) {
            for ((pattern, node), normal) in
                FaceRates::of(channel.field(), face).places().into_iter().zip(piece.normals)
            {
                assert_eq!(normal, displaced.at(face, pattern, node).0.normal.to_array());
            }
        }
    }

    #[test]
    fn normals_on_a_displaced_plane_are_those_of_the_height_field() {
        let context = Context::serial();
        let mut mesh = shapes::sail(3);
        mesh.points.iter_mut().for_each(|point| point[2] = 0.0);
        // Without the triangle that stands on the plane.
        mesh.face_sizes.pop();
        mesh.corners.truncate(mesh.corners.len() - 3);
        let surface = TriangleSurface::new(&context, &mesh).unwrap();
        let options = TriangleOptions { segments: 32, budget: 1 << 24 };
        let mut channel = TriangleChannel::displacement(surface.topology().clone(), &options).unwrap();
        let all: Vec<u32> = (0..surface.topology().face_count() as u32).collect();
        let pattern = channel.field().pattern();
        channel.apply(&context, pattern, &TriangleSets { allocate: all.clone(), ..Default::default() }).unwrap();
        let height = |p: Vec3| 0.1 * (6.0 * p.x).sin() * (5.0 * p.y + 1.0).cos() + 0.15;
        let topology = surface.topology().clone();
        let value = |p: Vec3| f16::from_f32(height(p));
        let faces = all.iter().map(|face| {
            let node = |index: u32| foot(&surface, *face, pattern, pattern.at_slot(Slot::Inside(index))).point;
            (*face, (0..pattern.face_values() as u32).map(|index| value(node(index))).collect())
        });
        let edges = (0..topology.edge_count() as u32).map(|edge| {
            let point = |step: u32| edge_foot(&surface, edge, step, 32).point;
            (edge, (1..32).map(|step| value(point(step))).collect())
        });
        let vertices =
            (0..topology.vertex_count() as u32 - 1).map(|v| (v, value(Vec3::from(surface.points()[v as usize]))));
        let values = TriangleValues { faces: faces.collect(), edges: edges.collect(), vertices: vertices.collect() };
        channel.write(values).unwrap();
        let mut worst = 0f32;
        for piece in pieces(&context, &surface, &channel) {
            for (point, normal) in piece.points.iter().zip(piece.normals) {
                let [x, y, _] = *point;
                // One-sided at the border of the plane, and so less exact.
                if x.min(y).min(1.0 - x).min(1.0 - y) < 0.01 {
                    continue;
                }
                let slope = |dx: f32, dy: f32| {
                    (height(Vec3::new(x + dx, y + dy, 0.0)) - height(Vec3::new(x - dx, y - dy, 0.0)))
                        / (2.0 * dx.max(dy))
                };
                let expected = Vec3::new(-slope(1e-2, 0.0), -slope(0.0, 1e-2), 1.0).normalize();
                worst = worst.max(expected.distance(Vec3::from(normal)));
            }
        }
        // Half floats near 0.2 are 1e-4 apart, over triangles of 1e-2.
        assert!(worst < 0.03, "{worst}");
    }

    #[test]
    fn normals_are_means_by_area_blended_by_the_length_of_the_displacement() {
        let context = Context::serial();
        let bits = |point: [f32; 3]| point.map(|value| (value + 0.0).to_bits());
        // At a height of hardly anything, at one that counts in part, and in full.
        for height in [1e-5, 4e-4, 0.1] {
            let (surface, channel) = rough(&context, &shapes::sail(3), height);
            let displaced = TriangleDisplaced::new(&surface, channel.field()).unwrap();
            let normals = TriangleNormals::of(&context, &displaced).unwrap();
            // All triangles of the tessellation around a place of the undisplaced mesh, from all faces.
            let mut around: BTreeMap<[u32; 3], ([DVec3; 2], f64, f64)> = BTreeMap::new();
            let mut found = Vec::new();
            let mut shares = 0;
            for face in 0..surface.topology().face_count() as u32 {
                let rates = FaceRates::of(channel.field(), face);
                let places: Vec<_> = rates.places().into_iter().collect();
                let feet: Vec<_> = places.iter().map(|(pattern, node)| displaced.at(face, *pattern, *node)).collect();
                let flat: Vec<DVec3> = feet.iter().map(|(foot, _)| foot.point.as_dvec3()).collect();
                let moved: Vec<DVec3> =
                    places.iter().map(|(pattern, node)| displaced.point(face, *pattern, *node).as_dvec3()).collect();
                for triangle in rates.triangles() {
                    let [a, b, c] = triangle.map(|at| at as usize);
                    let area = |p: &[DVec3]| (p[b] - p[a]).cross(p[c] - p[a]);
                    let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| flat[a].distance(flat[b]));
                    let height = [a, b, c].map(|at| moved[at].distance(flat[at])).into_iter().fold(0.0, f64::max);
                    let step = sides.into_iter().fold(f64::INFINITY, f64::min);
                    for at in [a, b, c] {
                        let nothing = ([DVec3::ZERO; 2], 0.0, f64::INFINITY);
                        let sum = around.entry(bits(feet[at].0.point.to_array())).or_insert(nothing);
                        sum.0 = [sum.0[0] + area(&moved), sum.0[1] + area(&flat)];
                        (sum.1, sum.2) = (sum.1.max(height), sum.2.min(step));
                    }
                }
                for ((pattern, node), (foot, _)) in places.iter().zip(feet) {
                    // The middle of a fan keeps no value: it reads as the edges around it.
                    if rates.inside.is_some() || !matches!(pattern.slot(*node), Slot::Inside(_)) {
                        found.push((foot, normals.at(&surface, face, *pattern, *node)));
                    }
                }
            }
            for (foot, normal) in found {
                let ([displaced, flat], height, step) = around[&bits(foot.point.to_array())];
                let share = (height / (step / 64.0)).min(1.0);
                shares += i32::from(share > 0.1 && share < 0.9);
                let turn = displaced.normalize() - flat.normalize();
                let expected = (foot.normal.as_dvec3() + turn * share).normalize();
                assert!(expected.distance(normal.as_dvec3()) < 1e-4, "{height}: {expected} {normal}");
            }
            assert_eq!(shares > 100, height == 4e-4, "{shares}");
        }
    }

    #[test]
    fn normals_that_are_renewed_where_something_changed_are_those_made_anew() {
        let context = Context::serial();
        let (surface, mut channel) = rough(&context, &shapes::sail(3), 0.1);
        channel.commit();
        let displaced = TriangleDisplaced::new(&surface, channel.field()).unwrap();
        let mut normals = TriangleNormals::of(&context, &displaced).unwrap();
        assert!(normals.bytes() > 0);
        let block = vec![f16::from_f32(0.3); channel.field().face(4).unwrap().len()];
        channel
            .write(TriangleValues { faces: vec![(4, block)], vertices: vec![(5, f16::ONE)], ..Default::default() })
            .unwrap();
        let gone = TriangleSets { deallocate: vec![2], ..Default::default() };
        channel.apply(&context, channel.field().pattern(), &gone).unwrap();
        let commit = channel.commit();
        let displaced = TriangleDisplaced::new(&surface, commit.field()).unwrap();
        normals.update(&context, &displaced, &commit.changed().faces_shown(commit.topology()));
        let anew = TriangleNormals::of(&context, &displaced).unwrap();
        for face in 0..surface.topology().face_count() as u32 {
            assert_eq!(normals.turns.face(face), anew.turns.face(face));
            for (pattern, node) in FaceRates::of(commit.field(), face).places() {
                let [a, b] = [&normals, &anew].map(|normals| normals.at(&surface, face, pattern, node));
                assert_eq!(a, b, "face {face} {node:?}");
            }
        }
    }

    #[test]
    fn vectors_move_along_their_frames_and_leave_no_cracks() {
        let context = Context::serial();
        let mesh = shapes::sail(3);
        let (surface, channel) = rough(&context, &mesh, 0.05);
        let options = TriangleOptions { segments: 32, budget: 1 << 24 };
        let mut vectors = TriangleChannel::vectors(surface.topology().clone(), &options).unwrap();
        let pattern = Pattern::new(16).unwrap();
        let sets = TriangleSets { allocate: vec![4, 6, 12], ..Default::default() };
        vectors.apply(&context, pattern, &sets).unwrap();
        let field = vectors.field().clone();
        let value = Vector([0.03, 0.02, 0.01].map(f16::from_f32));
        let faces = field.allocated().map(|face| (face, vec![value; pattern.face_values()])).collect();
        let edges = field.allocated_edges().map(|edge| (edge, vec![value; pattern.edge_values()])).collect();
        vectors.write(TriangleValues { faces, edges, vertices: vec![(6, value)] }).unwrap();
        let offsets = vectors.field().in_object_space(&context, &surface);
        let plain = TriangleDisplaced::new(&surface, channel.field()).unwrap();
        let displaced = plain.with_vectors(&offsets).unwrap();
        // Inside a face, T is the first side but for what of it is along the normal.
        let [a, b, _] = surface.corner_points(4).map(Vec3::from);
        for index in 0..pattern.face_values() as u32 {
            let node = pattern.at_slot(Slot::Inside(index));
            let normal = displaced.at(4, pattern, node).0.normal;
            let tangent = (b - a).reject_from_normalized(normal).normalize();
            let expected = tangent * 0.03 + normal.cross(tangent) * 0.02 + normal * 0.01;
            let moved = displaced.point(4, pattern, node) - plain.point(4, pattern, node);
            assert!((moved - expected).length() < 1e-4, "{moved} {expected}");
        }
        let normals = TriangleNormals::of(&context, &displaced).unwrap();
        let faces = 0..surface.topology().face_count() as u32;
        let pieces: Vec<TrianglePiece> =
            faces.map(|face| TrianglePiece::new(&displaced, &normals, face, &displaced.rates(face))).collect();
        let bits = |point: [f32; 3]| point.map(|value| (value + 0.0).to_bits());
        let mut uses: BTreeMap<_, usize> = BTreeMap::new();
        for piece in &pieces {
            for [a, b, c] in &piece.triangles {
                for (a, b) in [(a, b), (b, c), (c, a)] {
                    let (a, b) = (bits(piece.points[*a as usize]), bits(piece.points[*b as usize]));
                    *uses.entry((a.min(b), a.max(b))).or_default() += 1;
                }
            }
        }
        let topology = surface.topology();
        let segments = |edge: u32| displaced.edge_pattern(edge).map_or(1, Pattern::segments) as usize;
        let edges = 0..topology.edge_count() as u32;
        let boundary: usize = edges.filter(|edge| topology.faces_along(*edge).len() == 1).map(segments).sum();
        assert_eq!(uses.values().filter(|uses| **uses == 1).count(), boundary);
    }
}
