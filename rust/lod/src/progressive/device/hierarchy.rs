//! What a device has of a progressive mesh, uploaded once.

use std::sync::Arc;

use glam::Vec3;
use relievo_core::{Context, Error, Result};
use relievo_gpu::wgsl::progressive::SplitBlock;
use relievo_gpu::{Buffer, Device};

use super::around::DeviceAround;
use super::directions::DeviceDirections;
use super::wedges::DeviceWedges;
use crate::connectivity::NONE;
use crate::progressive::build::hierarchy::{Child, LEAF, Progressive};
use crate::progressive::files::packing::Normal;
use crate::progressive::mesh::view::Extents;

/// Vertices at most: numbers are also given doubled, with four bits above.
const MAX: usize = 1 << 27;

/// A vertex that is drawn: its point, and its normal on an octahedron in two numbers of 16 bits (`octahedron.wgsl`).
pub type Vertex = [u32; 4];

/// What a device has of a progressive mesh. That is 42 bytes a triangle; a mesh of it may take 20 more, and what views and
/// edits need another 52. Attributes take 12 bytes a triangle and its numbers, and 4 a wedge and its numbers twice; in a
/// mesh of it the same once more, with numbers once. For edits of meshes with normals or tangents among them there are 12
/// bytes a triangle and 4 a wedge more, and in a mesh of it that is edited 31 a triangle.
#[derive(Debug)]
pub struct DeviceHierarchy {
    pub(super) device: Device,
    /// Bytes of a binding of what takes several.
    pub(super) window: u64,
    pub(super) vertices: usize,
    pub(super) triangles: usize,
    /// Numbers in the input of the leaves.
    pub(super) numbers: Vec<u32>,
    pub(super) bounds: [[f32; 3]; 2],
    /// What coordinates are multiplied by so that squares of areas stay in the range of f32.
    pub(super) scale: f32,
    pub(super) splits: Buffer<SplitBlock>,
    pub(super) inner: Buffer<Vertex>,
    pub(super) leaves: Buffer<Vertex>,
    pub(super) makers: Buffer<u32>,
    pub(super) corners: Buffer<[u32; 3]>,
    pub(super) around: Option<DeviceAround>,
    pub(super) wedges: Option<DeviceWedges>,
    pub(super) directions: Option<DeviceDirections>,
}

impl DeviceHierarchy {
    /// Sends a mesh to a device.
    ///
    /// # Errors
    /// Fails if the mesh has more than 2²⁷ vertices or its attributes more numbers than a device counts, and where the
    /// device is lost or has no memory.
    pub fn new(device: &Device, mesh: &Progressive) -> Result<Self> {
        let count = mesh.vertex_count();
        if count > MAX {
            return Err(Error::unsupported(format!("a device has progressive meshes of at most {MAX} vertices")));
        }
        let vertex = |point: Vec3, normal: Normal| {
            let [x, y, z] = point.to_array().map(f32::to_bits);
            [x, y, z, normal.0]
        };
        let inner = |split: u32| {
            // Also where a split is not read yet; elsewhere it is not used.
            let point = mesh.place(Child::Split(split), split).point;
            vertex(point, mesh.inner_normals[split as usize])
        };
        let inner: Vec<Vertex> = (0..count as u32).map(inner).collect();
        let leaves = mesh.points.iter().zip(&mesh.normals).map(|(point, normal)| vertex((*point).into(), *normal));
        let leaves: Vec<Vertex> = leaves.collect();
        let mut numbers = vec![NONE; count];
        for (slot, split) in mesh.splits.iter().enumerate() {
            for (side, child) in split.children.into_iter().enumerate().filter(|(_, child)| *child != NONE) {
                if child & LEAF != 0 {
                    let is_base = split.key.depth() == 0;
                    let leaf = if is_base { slot } else { mesh.leaf((2 * slot + side) as u32) as usize };
                    numbers[leaf] = child & !LEAF;
                }
            }
        }
        let mut makers = vec![NONE; mesh.triangle_count()];
        let mut corners = vec![[0; 3]; mesh.triangle_count()];
        // Those of the base come with any of its vertices.
        let always = mesh.base_vertices().first().copied().unwrap_or_default();
        for (place, leaves) in mesh.faces.iter().enumerate().filter(|(_, leaves)| leaves[0] != NONE) {
            let number = mesh.face_id(place as u32) as usize;
            makers[number] = if place / 2 < count { (place / 2) as u32 } else { always };
            corners[number] = *leaves;
        }
        let wedges = mesh.wedges.as_ref().map(|trees| DeviceWedges::new(device, mesh, trees));
        let points = || mesh.points.iter().map(|point| Vec3::from(*point));
        let bounds = [points().reduce(Vec3::min), points().reduce(Vec3::max)];
        Ok(Self {
            device: device.clone(),
            window: device.limits().max_storage_buffer_binding_size,
            vertices: count,
            triangles: mesh.triangle_count(),
            numbers,
            bounds: bounds.map(|corner| corner.unwrap_or_default().to_array()),
            scale: mesh.scale(),
            splits: Buffer::of(device, "splits", &blocks(mesh))?,
            inner: Buffer::of(device, "places of splits", &inner)?,
            leaves: Buffer::of(device, "places of leaves", &leaves)?,
            makers: Buffer::of(device, "makers of triangles", &makers)?,
            corners: Buffer::of(device, "corners", &corners)?,
            around: None,
            wedges: wedges.transpose()?,
            directions: None,
        })
    }

    /// The same with what views and edits need.
    ///
    /// # Errors
    /// Fails if the extents are of another mesh, a vertex has more than 4,096 neighbours or what is around splits is
    /// too much for a device, and as [`Self::new`].
    pub fn with_surroundings(
        context: &Context,
        device: &Device,
        mesh: &Arc<Progressive>,
        extents: &Extents,
    ) -> Result<Self> {
        Self::new(device, mesh)?.surrounded(context, mesh, extents)
    }

    /// With what is around splits.
    fn surrounded(self, context: &Context, mesh: &Arc<Progressive>, extents: &Extents) -> Result<Self> {
        let device = &self.device;
        let around = Some(DeviceAround::new(context, &self, mesh, extents)?);
        let directions = mesh.wedges.as_ref().map(|trees| DeviceDirections::new(device, mesh, trees));
        Ok(Self { around, directions: directions.transpose()?.flatten(), ..self })
    }

    /// What edits need. Fails if it was sent without.
    pub(super) fn for_edits(&self) -> Result<&DeviceAround> {
        let missing = || Error::invalid("the progressive mesh was sent without what edits need").at("edit");
        self.around.as_ref().ok_or_else(missing)
    }

    /// Bytes on the device, without meshes.
    pub fn bytes(&self) -> usize {
        let vertex = size_of::<SplitBlock>() + 2 * size_of::<Vertex>();
        let triangle = size_of::<[u32; 3]>() + size_of::<u32>();
        self.vertices * vertex
            + self.triangles * triangle
            + self.around.as_ref().map_or(0, DeviceAround::bytes)
            + self.wedges.as_ref().map_or(0, DeviceWedges::bytes)
            + self.directions.as_ref().map_or(0, DeviceDirections::bytes)
    }

    /// The smallest and largest coordinates of the finest mesh.
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        self.bounds
    }
}

/// Splits with their depths, the deepest first.
pub(super) fn by_depth(mesh: &Progressive) -> Vec<(u32, u32)> {
    let mut splits: Vec<_> = mesh.splits().map(|(split, key, _)| (key.depth(), split)).collect();
    splits.sort_unstable_by_key(|(depth, split)| (std::cmp::Reverse(*depth), *split));
    splits
}

/// The vertices that splits split, by their numbers, and those of the base. What a split comes from is before it.
fn split_vertices(mesh: &Progressive, splits: &[(u32, u32)]) -> Vec<u32> {
    let mut vertices: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    for (_, split) in splits {
        let from = mesh.parent(*split);
        vertices[*split as usize] = if from % 2 == 1 { from / 2 } else { vertices[from as usize / 2] };
    }
    vertices
}

/// Splits and vertices of the base by number.
fn blocks(mesh: &Progressive) -> Vec<SplitBlock> {
    let children = |number: u32| mesh.splits[number as usize].children;
    let none = SplitBlock { key: 0, vertex: 0, parent: 0, children: [LEAF; 2] };
    let mut blocks = vec![none; mesh.vertex_count()];
    for vertex in mesh.base_vertices() {
        let (key, children) = (u32::MAX, children(*vertex));
        blocks[*vertex as usize] = SplitBlock { key, vertex: *vertex, parent: 2 * vertex, children };
    }
    let splits = by_depth(mesh);
    let vertices = split_vertices(mesh, &splits);
    for (_, split) in splits {
        let (key, vertex) = (mesh.splits[split as usize].key.0, vertices[split as usize]);
        blocks[split as usize] = SplitBlock { key, vertex, parent: mesh.parent(split), children: children(split) };
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progressive::{BuildOptions, Cut, DeviceLevel, Edit, Handle, Region, View};
    use relievo_core::Falloff;
    use relievo_core::progress::Silent;

    /// A wave over a square.
    fn wave() -> Arc<Progressive> {
        let n = 24u32;
        let at = |k: u32| [(k % (n + 1)) as f32 / n as f32, (k / (n + 1)) as f32 / n as f32];
        let points: Vec<_> =
            (0..(n + 1) * (n + 1)).map(at).map(|[x, y]| [x, y, 0.1 * (9.0 * x + 4.0 * y).sin()]).collect();
        let squares = (0..n * n).map(|k| k / n * (n + 1) + k % n);
        let triangles: Vec<_> = squares.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]).collect();
        let options = BuildOptions { faces: 60, ..BuildOptions::default() };
        Arc::new(Progressive::build(&Context::serial(), &points, &triangles, &options, &mut Silent).unwrap())
    }

    #[test]
    fn meshes_do_not_depend_on_what_a_binding_holds() {
        let Some(device) = relievo_testing::device() else { return };
        let (context, mesh) = (Context::serial(), wave());
        let extents = Extents::new(&mesh);
        let region = Region { center: [0.5, 0.5, 0.0], radius: 0.4, falloff: Falloff::Smooth };
        let handle = Handle { region, translation: [0.1, 0.0, 0.2], axis: [0.0, 0.0, 1.0], angle: 0.8 };
        let edit = Edit { handles: vec![handle], anchors: Vec::new() };
        let view = View { eye: [1.8, 0.0, 0.3], pixels: 500.0, tolerance: 3.0, outline: 1.0, planes: Vec::new() };
        // Of the second all is in one binding, of the first in as many as there may be.
        let made = [1 << 14, 1 << 27].map(|window| {
            let whole = DeviceHierarchy { window, ..DeviceHierarchy::new(&device, &mesh).unwrap() };
            let mut level = DeviceLevel::new(&Arc::new(whole.surrounded(&context, &mesh, &extents).unwrap())).unwrap();
            let mut meshes = Vec::new();
            for (step, faces) in [300, usize::MAX, 0, 600].into_iter().enumerate() {
                let mut frame = device.frame().unwrap();
                level.adapt(&mut frame, Cut::of_faces(&mesh, faces)).unwrap();
                let _ = frame.submit().unwrap();
                if step != 1 {
                    level.edit(&edit).unwrap();
                }
                meshes.push(level.extract().unwrap());
            }
            assert!(level.undo().unwrap());
            let mut frame = device.frame().unwrap();
            level.adapt_to(&mut frame, &view).unwrap();
            let _ = frame.submit().unwrap();
            meshes.push(level.extract().unwrap());
            let mut active = level.to_active(&context, &mesh).unwrap();
            meshes.push(active.extract());
            active.edit(&context, &edit).unwrap();
            level.take(&context, &mut active).unwrap();
            meshes.push(level.extract().unwrap());
            meshes
        });
        assert!(made[0] == made[1]);
    }
}
