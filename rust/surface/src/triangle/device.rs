//! A triangle mesh on a graphics device (`shaders/triangles/triangles.wgsl`): how its triangles meet, and its points with their
//! normals, which the processor makes of a pose.

use relievo_core::{Error, Result};
use relievo_gpu::{Access, Bindings, Buffer, Device, wgpu};

use super::surface::TriangleSurface;
use super::topology::TriangleTopology;

/// What kernels that import `triangles` have as their group 1.
pub const MESH_GROUP: [Access; 2] = [Access::Read; 2];

/// The triangles of a surface on a device.
#[derive(Debug)]
pub struct DeviceMesh {
    points: Buffer<[f32; 6]>,
    faces: usize,
    group: Bindings,
    words: Buffer<u32>,
}

impl DeviceMesh {
    /// Brings `surface` to a device.
    ///
    /// # Errors
    /// Fails with `Memory` if the device has no room for it, and with `Device` if it was lost.
    pub fn new(device: &Device, surface: &TriangleSurface) -> Result<Self> {
        let topology = surface.topology();
        let words = Buffer::of(device, "triangles", &words(topology))?;
        let points = Buffer::of(device, "points of triangles", &points(surface))?;
        let group = device.bind_as(&MESH_GROUP, &[points.wgpu(), words.wgpu()])?;
        Ok(Self { points, faces: topology.face_count(), group, words })
    }

    /// Takes on the pose of `surface`, which has the same triangles.
    ///
    /// # Errors
    /// Fails with `Internal` if it has another number of points, and with `Device` if the device was lost.
    pub fn pose(&mut self, device: &Device, surface: &TriangleSurface) -> Result<()> {
        let points = points(surface);
        if points.len() != self.points.len() {
            return Err(Error::internal(format!("{} points for a mesh of {}", points.len(), self.points.len())));
        }
        self.points.write(device, 0, &points)
    }

    /// What is bound as group 1 of kernels that import `triangles`.
    pub fn group(&self) -> &Bindings {
        &self.group
    }

    /// The buffers of [`Self::group`] in the order of their bindings, for pipelines that draw.
    pub fn buffers(&self) -> [&wgpu::Buffer; 2] {
        [self.points.wgpu(), self.words.wgpu()]
    }

    /// Number of triangles.
    pub fn face_count(&self) -> usize {
        self.faces
    }
}

fn points(surface: &TriangleSurface) -> Vec<[f32; 6]> {
    let both = surface.points().iter().zip(surface.normals());
    both.map(|([x, y, z], [a, b, c])| [*x, *y, *z, *a, *b, *c]).collect()
}

/// The words of `mesh_words`.
fn words(topology: &TriangleTopology) -> Vec<u32> {
    let counts = [topology.face_count(), topology.edge_count(), topology.vertex_count()].map(|count| count as u32);
    let [faces, edges, vertices] = counts;
    let mut words = vec![faces, edges, vertices, 0];
    words.extend(topology.faces().as_flattened());
    let sides = (0..faces).flat_map(|face| (0..3).map(move |side| topology.side(face, side)));
    words.extend(sides.map(|side| 2 * side.edge + u32::from(side.reversed)));
    let mut list = |lists: &mut dyn Iterator<Item = Vec<u32>>| {
        let (mut offsets, mut items) = (vec![0], Vec::new());
        for list in lists {
            items.extend(list);
            offsets.push(items.len() as u32);
        }
        words.append(&mut offsets);
        words.append(&mut items);
    };
    let item = |(face, at): (u32, u32)| 3 * face + at;
    list(&mut (0..edges).map(|edge| topology.faces_along(edge).map(item).collect()));
    list(&mut (0..vertices).map(|vertex| topology.faces_around(vertex).map(item).collect()));
    words
}
