//! What is drawn, and where: patches, displaced surfaces, and triangles whose points were computed before.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};
use relievo_core::{Error, Result};
pub use relievo_gpu::wgsl::posed_draw::PosedVertex;
pub use relievo_gpu::wgsl::quad_draw::QuadPicture;
use relievo_gpu::{Buffer, Device, wgpu};
use relievo_surface::DeviceSurface;
use relievo_tiles::{DeviceTiles, Vector};

use super::coat::DeviceCoat;
use super::patches::VirtualVertices;
use super::tiles::VirtualTiles;
use super::triangles::VirtualTriangles;
use crate::scene::{Material, Mesh};

/// The form of something that is drawn.
#[derive(Clone, Copy, Debug)]
pub enum Shape<'a> {
    /// Bézier patches.
    Patches(&'a VirtualVertices),
    /// The strips of patches with points that were computed before.
    Strips(&'a VirtualVertices, &'a PassedVertices),
    /// A displaced Catmull-Clark surface, straight from what the device has of it.
    Tiles {
        /// The surface.
        surface: &'a DeviceSurface,
        /// Its displacement.
        tiles: &'a DeviceTiles,
        /// Its vector displacement, if it has some.
        vectors: Option<&'a DeviceTiles<Vector>>,
        /// Its colours and traces, if it has some.
        coat: Option<&'a DeviceCoat>,
        /// How it is divided.
        drawn: &'a VirtualTiles,
    },
    /// A displaced triangle mesh, straight from what the device has of it.
    Triangles(&'a VirtualTriangles),
    /// Triangles.
    Mesh(&'a DeviceMesh),
    /// Triangles that kernels of the device have written, as many as they say.
    Indirect(IndirectMesh<'a>),
    /// Posed clusters of a crowd, each at the places of its instances.
    Posed(PosedMesh<'a>),
    /// Quads with pictures of models.
    Quads(PicturedQuads<'a>),
}

/// Something that is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// Its form.
    pub shape: Shape<'a>,
    /// From its space to the world.
    pub transform: DAffine3,
    /// What it is made of.
    pub material: Material,
    /// Its number in pictures; if it has none, they have the numbers of its patches or tiles.
    pub number: Option<u32>,
    /// Whether it throws shadows. Shadow maps have the extent of what does, so a ground that reaches far would make them coarse.
    pub throws_shadows: bool,
}

impl<'a> Placed<'a> {
    /// Where it is, with the numbers of its parts.
    pub fn new(shape: Shape<'a>, material: Material) -> Self {
        Self { shape, transform: DAffine3::IDENTITY, material, number: None, throws_shadows: true }
    }

    /// Smallest and largest coordinates in its own space.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        match self.shape {
            Shape::Patches(patches) | Shape::Strips(patches, _) => patches.bounds(),
            Shape::Tiles { drawn, .. } => drawn.bounds(),
            Shape::Triangles(triangles) => triangles.bounds(),
            Shape::Mesh(mesh) => mesh.bounds,
            Shape::Indirect(IndirectMesh { bounds, .. })
            | Shape::Posed(PosedMesh { bounds, .. })
            | Shape::Quads(PicturedQuads { bounds, .. }) => {
                let [low, high] = bounds.map(|corner| Vec3::from(corner).as_dvec3());
                (low, high)
            }
        }
    }
}

/// A vertex of a strip whose point was computed before.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct PassedVertex {
    /// Position.
    pub p: [f32; 3],
    /// Sample of the map, as in [`VirtualVertex`](relievo_surface::bezier::VirtualVertex).
    pub sample: u32,
    /// Unit normal.
    pub normal: [f32; 3],
    /// Unused.
    pub padding: u32,
}

/// Strips of points and normals that were computed before, drawn without evaluating anything.
#[derive(Debug)]
pub struct PassedVertices {
    pub(super) buffer: Buffer<PassedVertex>,
}

impl PassedVertices {
    /// Room for `count` vertices.
    ///
    /// # Errors
    /// The device has no memory.
    pub fn new(device: &Device, count: usize) -> Result<Self> {
        Ok(Self { buffer: Buffer::vertices(device, "passed vertices", count)? })
    }

    /// Writes the vertices from index `first` on.
    ///
    /// # Errors
    /// There is no room for them, or the device fails.
    pub fn write(&self, device: &Device, first: usize, vertices: &[PassedVertex]) -> Result<()> {
        self.buffer.write(device, first, vertices)
    }

    /// How many vertices there are.
    pub fn len(&self) -> usize {
        self.buffer.len()
    }

    /// Whether it has no vertex.
    pub fn is_empty(&self) -> bool {
        self.buffer.is_empty()
    }
}

/// A vertex of a mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MeshVertex {
    /// Position.
    pub p: [f32; 3],
    /// Normal of any length; zero for that of the triangle.
    pub normal: [f32; 3],
    /// Diffuse reflectance, linear Rec.709.
    pub color: [f32; 3],
    /// Lines of wireframes go where one of these, interpolated, is a whole number.
    pub grid: [f32; 3],
    /// Which of the false colours.
    pub tag: u32,
}

/// What no false colour covers.
pub const NO_TAG: u32 = u32::MAX;

/// Triangles on a device.
#[derive(Debug)]
pub struct DeviceMesh {
    pub(super) vertices: Buffer<MeshVertex>,
    pub(super) indices: Buffer<u32>,
    bounds: (DVec3, DVec3),
}

impl DeviceMesh {
    /// Triangles of vertices that they may share, three indices each, counter-clockwise from their front.
    ///
    /// # Errors
    /// An index names no vertex, or the device has no memory.
    pub fn indexed(device: &Device, vertices: &[MeshVertex], indices: &[u32]) -> Result<Self> {
        if !indices.len().is_multiple_of(3) || indices.iter().any(|index| *index as usize >= vertices.len()) {
            return Err(Error::invalid("triangles name vertices that do not exist, or one has no third"));
        }
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for vertex in vertices {
            low = low.min(vertex.p.into());
            high = high.max(vertex.p.into());
        }
        let made = Buffer::vertices(device, "mesh", vertices.len())?;
        made.write(device, 0, vertices)?;
        let corners = Buffer::vertices(device, "triangles", indices.len())?;
        corners.write(device, 0, indices)?;
        Ok(Self { vertices: made, indices: corners, bounds: (low.as_dvec3(), high.as_dvec3()) })
    }

    /// A mesh as the ray caster draws it, with the colour of `material` where it has none of its own.
    ///
    /// # Errors
    /// As of [`Self::indexed`].
    pub fn new(device: &Device, mesh: &Mesh, material: &Material) -> Result<Self> {
        let mut vertices = Vec::with_capacity(3 * mesh.triangles.len());
        let at = |list: &[[f32; 3]], index: u32, or: [f32; 3]| list.get(index as usize).copied().unwrap_or(or);
        for (triangle, corners) in mesh.triangles.iter().enumerate() {
            if corners.iter().any(|corner| *corner as usize >= mesh.points.len()) {
                return Err(Error::invalid("a triangle names a point that does not exist"));
            }
            let marked = mesh.edges.get(triangle).copied().unwrap_or(0b111);
            for (number, corner) in corners.iter().enumerate() {
                // The line of edge e goes where the coordinate that is 1/2 at the corner before it is 0.
                let line = |edge: usize| if marked >> edge & 1 == 1 && number != (edge + 2) % 3 { 0.0 } else { 0.5 };
                vertices.push(MeshVertex {
                    p: mesh.points[*corner as usize],
                    normal: at(&mesh.normals, *corner, [0.0; 3]),
                    color: at(&mesh.colors, *corner, material.base_color),
                    grid: [line(0), line(1), line(2)],
                    tag: mesh.tags.get(triangle).copied().unwrap_or(NO_TAG),
                });
            }
        }
        let indices: Vec<u32> = (0..vertices.len() as u32).collect();
        Self::indexed(device, &vertices, &indices)
    }

    /// How many triangles there are.
    pub fn triangles(&self) -> usize {
        self.indices.len() / 3
    }
}

/// Triangles that kernels of the device have written, drawn without being read back, in the colour of their material and
/// without lines.
#[derive(Clone, Copy, Debug)]
pub struct IndirectMesh<'a> {
    /// The bits of the three coordinates of each point, and the normal on an octahedron that is unfolded to a square, in two
    /// numbers of 16 bits (`shaders/common/octahedron.wgsl`), or 0 for that of the triangle.
    pub vertices: &'a Buffer<[u32; 4]>,
    /// Numbers of vertices, three a triangle, counter-clockwise from its front.
    pub indices: &'a Buffer<u32>,
    /// First the number of indices, then 1, 0, 0, 0.
    pub arguments: &'a Buffer<u32>,
    /// Smallest and largest coordinates; they may be those of more than is drawn.
    pub bounds: [[f32; 3]; 2],
}

/// The false colour that is that of the number of the instance.
pub const INSTANCE_TAG: u32 = u32::MAX - 1;

/// Triangles of vertices that kernels of the device have posed, each vertex once for all instances in its pose, drawn without
/// being read back in the colour of their material. Pictures have the numbers of instances.
#[derive(Clone, Copy, Debug)]
pub struct PosedMesh<'a> {
    /// A vertex and an instance for each corner, three a triangle, counter-clockwise from its front in the world.
    pub corners: &'a Buffer<[u32; 2]>,
    /// The vertices.
    pub vertices: &'a Buffer<PosedVertex>,
    /// 16 words each: the number of the instance, three words that are not read, and three rows of four numbers that map its
    /// model to the object's space.
    pub instances: &'a wgpu::Buffer,
    /// First the number of corners, then 1, 0, 0.
    pub arguments: &'a Buffer<u32>,
    /// Smallest and largest coordinates; they may be those of more than is drawn.
    pub bounds: [[f32; 3]; 2],
}

/// Quads with pictures of models that are seen from a few pixels' distance, drawn in the colour of their material or false
/// colours, and without lines. Pictures have the numbers of instances.
#[derive(Clone, Copy, Debug)]
pub struct PicturedQuads<'a> {
    /// The picture and the instance of each quad.
    pub quads: &'a Buffer<[u32; 2]>,
    /// How many quads are drawn.
    pub count: u32,
    /// As [`PosedMesh::instances`].
    pub instances: &'a wgpu::Buffer,
    /// Where the pictures lie.
    pub pictures: &'a Buffer<QuadPicture>,
    /// For each texel of a picture, row after row from the lowest, the normal in the space of the model, zero where there is
    /// nothing, and the bits of the false colour or [`INSTANCE_TAG`].
    pub texels: &'a Buffer<[f32; 4]>,
    /// Texels along a side of a picture.
    pub side: u32,
    /// Smallest and largest coordinates; they may be those of more than is drawn.
    pub bounds: [[f32; 3]; 2],
}
