//! The splits of a progressive mesh and their numbers.
//!
//! Vertices of the fine mesh, the leaves, are numbered by walking the trees of collapses (the final vertex numbers of
//! Derzapf, Guthe 2012), so that every vertex of a coarser mesh stands for a range of leaves. It has the number of the
//! first of them. A split cuts the range in two: the vertex goes on with the first part, and a new one begins at the cut,
//! whose number is also that of the split. No leaf but those of base vertices begins ranges without such a split, so each
//! leaf has one place for a split, with two triangles. Triangles are corners of the fine mesh: whatever level a mesh is
//! of, the vertex at a corner is the one whose range has the leaf.

use std::sync::{Arc, OnceLock};

use glam::Vec3;
use relievo_core::budget::Budget;
use relievo_core::simd::prefetch;
use relievo_core::{Context, Progress, Result};

use super::cut::Cut;
use super::numbers::Numbers;
use super::recording::{Key, Operation, Recording};
use super::wedges::{WedgeTrees, Wedged, widths};
use crate::connectivity::NONE;
use crate::progressive::edit::place::Place;
use crate::progressive::files::packing::{Lattice, Normal};
use crate::simplify::decimation::Decimation;
use crate::simplify::wedges::Wedges;
use crate::simplify::{SimplifyOptions, check, reduce, unit};
use crate::watched::watched;

/// In place of a split: a leaf, with its number in the input.
pub(crate) const LEAF: u32 = 1 << 31;

/// Beside a leaf: the vertex that is split is exactly there.
pub(crate) const AT: u64 = 1 << 63;

/// What a progressive mesh is built for.
#[derive(Clone, Debug)]
pub struct BuildOptions {
    /// Triangles of the base mesh. There may be more, where no edge can collapse.
    pub faces: usize,
    /// Vertices of the input that stay where they are at all levels.
    pub locked: Vec<u32>,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self { faces: 100, locked: Vec::new() }
    }
}

/// A progressive mesh.
#[derive(Clone)]
pub struct Progressive {
    /// Places of the leaves, as they were.
    pub(crate) points: Vec<[f32; 3]>,
    pub(crate) normals: Vec<Normal>,
    /// Of the vertex that is split: on `lattice`, or [`AT`] a leaf where one has stayed.
    pub(crate) inner_points: Vec<u64>,
    pub(crate) inner_normals: Vec<Normal>,
    pub(crate) lattice: Lattice,
    pub(crate) splits: Vec<Split>,
    /// Leaves at the corners of triangles. Those of split n are 2n and 2n + 1, [`NONE`] where it makes none; those of the
    /// base are in places of base vertices and at the end.
    pub(crate) faces: Vec<[u32; 3]>,
    /// Numbers of triangles in the input.
    face_ids: Vec<u32>,
    pub(crate) base_vertices: Vec<u32>,
    pub(crate) base_faces: Vec<u32>,
    triangles: usize,
    /// Attributes, if there are any.
    pub(crate) wedges: Option<Arc<WedgeTrees>>,
    /// The finest mesh there is, where not all splits were read.
    pub(crate) floor: Cut,
    /// Found when it is first asked for.
    pub(super) triangle_sums: OnceLock<Vec<(u32, usize)>>,
}

/// A split.
#[derive(Clone, Copy)]
pub(crate) struct Split {
    /// What the vertex of lower number and that of the split's number are: the split that splits them, or a leaf. In the
    /// place of a base vertex, what that is.
    pub children: [u32; 2],
    /// The vertex that is split, as twice the number of its own split plus 1 for its second vertex; [`NONE`] in the place
    /// of a base vertex.
    pub parent: u32,
    /// Without depth in the place of a base vertex, and where it is not read yet.
    pub key: Key,
}

/// What becomes of a vertex when it is split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    /// It is split further, by this split.
    Split(u32),
    /// It is a vertex of the input, of this number.
    Leaf(u32),
}

impl Progressive {
    /// Builds a progressive mesh of triangles.
    ///
    /// # Errors
    /// Fails as [`crate::simplify`].
    pub fn build(
        context: &Context,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
        options: &BuildOptions,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        let limits =
            SimplifyOptions { target_triangles: options.faces, locked: options.locked.clone(), ..Default::default() };
        check(context, points, triangles, &limits)?;
        let scale = unit(points);
        watched(context, progress, |progress| {
            let work = Decimation::new(context, points, triangles, 1.0 / scale)?;
            let (normals, recording) = record(context, work, (options, scale, 0), progress)?;
            Ok(Self::new(points, &normals, triangles, &recording.operations)?.0)
        })
    }

    /// As [`Self::build`], of a mesh that was checked, with what its wedges and triangles have.
    pub(super) fn build_wedged<const Q: usize>(
        context: &Context,
        (points, triangles): (&[[f32; 3]], &[[u32; 3]]),
        (wedged, wedges): (Wedged, Wedges<Q>),
        options: &BuildOptions,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        let scale = unit(points);
        watched(context, progress, |progress| {
            let [width, _] = widths(&wedged.attributes);
            let work = Decimation::with(context, points, triangles, 1.0 / scale, wedges)?;
            let (normals, recording) = record(context, work, (options, scale, width), progress)?;
            let (mut made, leaves) = Self::new(points, &normals, triangles, &recording.operations)?;
            made.wedges = Some(Arc::new(WedgeTrees::new(wedged, &recording, &leaves, &made)?));
            Ok(made)
        })
    }

    /// Of the collapses of a mesh, in their order. Also returns the leaves of the vertices of the input.
    fn new(
        points: &[[f32; 3]],
        normals: &[Normal],
        triangles: &[[u32; 3]],
        operations: &[Operation],
    ) -> Result<(Self, Vec<u32>)> {
        let numbers = Numbers::new(points.len(), operations.iter().map(|operation| [operation.kept, operation.gone]));
        let leaves = &numbers.leaves;
        let count = points.len();
        let lattice = Lattice::around(operations.iter().map(|operation| operation.point));
        let mut budget = Budget::new(u64::MAX);
        let mut made = Self::empty(count, triangles.len(), lattice, &mut budget)?;
        made.base_vertices = numbers.base.iter().map(|vertex| leaves[*vertex as usize]).collect();
        for (leaf, (point, normal)) in leaves.iter().zip(points.iter().zip(normals)) {
            made.points[*leaf as usize] = *point;
            made.normals[*leaf as usize] = *normal;
        }
        let mut gone = vec![false; triangles.len()];
        // The vertex of the input where each vertex is, if it has not moved.
        let mut stays: Vec<u32> = (0..count as u32).collect();
        for (operation, children) in operations.iter().zip(&numbers.children) {
            let split = leaves[operation.gone as usize] as usize;
            let ends = [operation.kept, operation.gone].map(|end| stays[end as usize]);
            let stayed =
                ends.into_iter().find(|end| *end != NONE && Vec3::from(points[*end as usize]) == operation.point);
            stays[operation.kept as usize] = stayed.unwrap_or(NONE);
            made.inner_points[split] = match stayed {
                Some(vertex) => AT | u64::from(leaves[vertex as usize]),
                None => lattice.pack(operation.point),
            };
            made.inner_normals[split] = operation.normal;
            made.splits[split].key = operation.key;
            for (side, (child, leaf)) in children.iter().zip([operation.kept, operation.gone]).enumerate() {
                made.splits[split].children[side] = match *child {
                    NONE => LEAF | leaf,
                    child => {
                        let child = leaves[child as usize];
                        made.splits[child as usize].parent = (2 * split + side) as u32;
                        child
                    }
                };
            }
            for (side, face) in operation.faces.into_iter().enumerate().filter(|(_, face)| *face != NONE) {
                gone[face as usize] = true;
                let leaves = triangles[face as usize].map(|vertex| leaves[vertex as usize]);
                made.set_face((2 * split + side) as u32, leaves, face);
            }
        }
        for vertex in &numbers.base {
            let leaf = leaves[*vertex as usize];
            made.splits[leaf as usize].children[0] = match numbers.last[*vertex as usize] {
                NONE => LEAF | vertex,
                child => leaves[child as usize],
            };
            if let split @ 0..LEAF = made.splits[leaf as usize].children[0] {
                made.splits[split as usize].parent = 2 * leaf;
            }
        }
        let rest: Vec<usize> = (0..triangles.len()).filter(|face| !gone[*face]).collect();
        made.base_faces = made.base_places(rest.len());
        for (index, face) in rest.into_iter().enumerate() {
            let leaves = triangles[face].map(|vertex| leaves[vertex as usize]);
            made.set_face(made.base_faces[index], leaves, face as u32);
        }
        Ok((made, numbers.leaves))
    }

    /// Room for a mesh.
    pub(crate) fn empty(vertices: usize, triangles: usize, lattice: Lattice, budget: &mut Budget) -> Result<Self> {
        Ok(Self {
            points: budget.filled(vertices, [0.0; 3])?,
            normals: budget.filled(vertices, Normal::default())?,
            inner_points: budget.filled(vertices, 0)?,
            inner_normals: budget.filled(vertices, Normal::default())?,
            lattice,
            splits: budget.filled(vertices, Split { children: [NONE; 2], parent: NONE, key: Key::default() })?,
            faces: budget.filled(2 * vertices, [NONE; 3])?,
            face_ids: budget.filled(2 * vertices, NONE)?,
            base_vertices: Vec::new(),
            base_faces: Vec::new(),
            triangles,
            wedges: None,
            floor: Cut::FINEST,
            triangle_sums: OnceLock::new(),
        })
    }

    /// Where the triangles of the base are: in places of base vertices, and at the end.
    pub(crate) fn base_places(&self, count: usize) -> Vec<u32> {
        let end = 2 * self.points.len() as u32;
        self.base_vertices.iter().flat_map(|leaf| [2 * leaf, 2 * leaf + 1]).chain(end..).take(count).collect()
    }

    /// Puts a triangle into its place, at the end if there is none yet.
    pub(crate) fn set_face(&mut self, place: u32, leaves: [u32; 3], id: u32) {
        let place = place as usize;
        if place == self.faces.len() {
            self.faces.push(leaves);
            self.face_ids.push(id);
        } else {
            self.faces[place] = leaves;
            self.face_ids[place] = id;
        }
    }

    /// Vertices of the finest mesh.
    pub fn vertex_count(&self) -> usize {
        self.points.len()
    }

    /// Triangles of the finest mesh.
    pub fn triangle_count(&self) -> usize {
        self.triangles
    }

    /// The vertices of the base mesh, by the leaves they begin with.
    pub fn base_vertices(&self) -> &[u32] {
        &self.base_vertices
    }

    /// The triangles of the base mesh.
    pub fn base_faces(&self) -> &[u32] {
        &self.base_faces
    }

    /// Splits, each with its key and how many triangles it makes, in no order.
    pub fn splits(&self) -> impl Iterator<Item = (u32, Key, usize)> {
        let splits = (0..).zip(&self.splits).filter(|(_, split)| split.key.depth() > 0);
        splits.map(|(number, split)| (number, split.key, self.triangles_made(number)))
    }

    /// How many triangles a split makes.
    pub(super) fn triangles_made(&self, split: u32) -> usize {
        let faces = &self.faces[2 * split as usize..2 * split as usize + 2];
        faces.iter().filter(|face| face[0] != NONE).count()
    }

    /// What a vertex is, given as [`Self::parent`] tells it.
    #[inline(always)]
    pub fn child(&self, node: u32) -> Child {
        match self.splits[node as usize / 2].children[node as usize % 2] {
            leaf if leaf & LEAF != 0 => Child::Leaf(leaf & !LEAF),
            split => Child::Split(split),
        }
    }

    /// The first leaf of the second vertex of a split, or the only one of the first, if that is a leaf.
    pub(crate) fn leaf(&self, node: u32) -> u32 {
        if node % 2 == 1 { node / 2 } else { (node / 2).saturating_sub(1) }
    }

    /// The vertex that is split, as twice the number of the split it comes from, and 1 if it is the second of that.
    #[inline(always)]
    pub fn parent(&self, split: u32) -> u32 {
        self.splits[split as usize].parent
    }

    /// The number in the input of a triangle.
    pub fn face_id(&self, face: u32) -> u32 {
        self.face_ids[face as usize]
    }

    /// Where a vertex was built. `leaf` is the first of its leaves.
    pub(crate) fn place(&self, child: Child, leaf: u32) -> Place {
        match child {
            Child::Leaf(_) => {
                Place { point: self.points[leaf as usize].into(), normal: self.normals[leaf as usize].vector() }
            }
            Child::Split(split) => {
                let split = split as usize;
                let point = match self.inner_points[split] {
                    leaf if leaf & AT != 0 => self.points[(leaf & !AT) as usize].into(),
                    packed => self.lattice.point(packed),
                };
                Place { point, normal: self.inner_normals[split].vector() }
            }
        }
    }

    /// Where a vertex was built, told by its node: as [`Self::parent`] tells it, or twice the leaf of a base vertex.
    #[inline(always)]
    pub(crate) fn node_place(&self, node: u32) -> Place {
        let split = node / 2;
        // The one leaf of a first vertex is before those of the second; a base vertex has no second.
        let is_first = node.is_multiple_of(2) && self.splits[split as usize].parent != NONE;
        self.place(self.child(node), if is_first { split.wrapping_sub(1) } else { split })
    }

    /// Asks for what [`Self::node_place`] will need of nodes.
    #[inline(always)]
    pub(crate) fn ask_ahead(&self, nodes: impl Iterator<Item = u32> + Clone) {
        nodes.clone().for_each(|node| prefetch(&self.splits, node as usize / 2));
        for node in nodes {
            match self.child(node) {
                Child::Leaf(_) => {
                    let leaf = self.leaf(node) as usize;
                    prefetch(&self.points, leaf);
                    prefetch(&self.normals, leaf);
                }
                Child::Split(split) => {
                    prefetch(&self.inner_points, split as usize);
                    prefetch(&self.inner_normals, split as usize);
                }
            }
        }
    }

    /// What coordinates are multiplied by so that squares of areas stay in the range of f32.
    pub(crate) fn scale(&self) -> f32 {
        self.lattice.scale()
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        let vertex = size_of::<[f32; 3]>() + 2 * size_of::<Normal>() + size_of::<u64>();
        let split = size_of::<Split>();
        let sums = self.triangle_sums.get().map_or(0, |sums| size_of_val(&**sums));
        let wedges = self.wedges.as_ref().map_or(0, |wedges| wedges.bytes());
        let base = size_of_val(&*self.base_vertices) + size_of_val(&*self.base_faces) + sums + wedges;
        self.points.len() * (vertex + split) + self.faces.len() * (size_of::<[u32; 3]>() + size_of::<u32>()) + base
    }
}

/// Collapses a mesh, and tells the normals it had and what was done. Wedges have `width` numbers.
fn record<const Q: usize>(
    context: &Context,
    mut work: Decimation<Q>,
    (options, scale, width): (&BuildOptions, f32, usize),
    progress: &mut dyn Progress,
) -> Result<(Vec<Normal>, Recording)> {
    work.lock(&options.locked);
    let normals: Vec<_> = work.vertex_normals(context).into_iter().map(Normal::new).collect();
    work.recording = Some(Recording::new(work.points.len(), width));
    let triangles = work.live;
    reduce(context, &mut work, triangles, options.faces, f32::INFINITY, progress)?;
    let mut recording = work.recording.take().unwrap_or_else(|| Recording::new(0, width));
    for operation in &mut recording.operations {
        operation.point *= scale;
        operation.key = operation.key.scaled(scale);
    }
    Ok((normals, recording))
}
