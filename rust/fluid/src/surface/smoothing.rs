//! Smoothing of meshes of surfaces: steps towards the mean of the neighbours, and steps back that keep the volume
//! (Taubin 1995, Section 3).

use glam::{DVec3, Vec3};
use relievo_core::{Attribute, Context, Domain, Error, Mesh, Progress, Result, Values};

/// How a mesh is smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    /// Steps forwards, at most 10,000.
    pub iterations: u32,
    /// How far a step goes towards the mean of the neighbours, 0 to 1.
    pub forwards: f32,
    /// How far the step after it goes back, 0 to 1: a little more than forwards keeps the volume, 0 is Laplace's
    /// smoothing.
    pub backwards: f32,
}

impl Default for Smoothing {
    fn default() -> Self {
        Self { iterations: 10, forwards: 0.5, backwards: 0.53 }
    }
}

/// Vertices of one task.
const CHUNK_LEN: usize = 4096;

/// Moves the points of a closed mesh of triangles, such as [`crate::mesh`] makes. Normals, if it has any, are then
/// those of the triangles around a point, by their areas; other attributes stay.
///
/// # Errors
/// Fails if a face is no triangle or a corner has no point, if a number is out of range, or where `progress` asks to
/// stop; the mesh is then as it was.
pub fn smooth(context: &Context, mesh: &mut Mesh, smoothing: Smoothing, progress: &mut dyn Progress) -> Result<()> {
    let Smoothing { iterations, forwards, backwards } = smoothing;
    if iterations > 10_000 || !(0.0..=1.0).contains(&forwards) || !(0.0..=1.0).contains(&backwards) {
        return Err(Error::invalid(format!("{iterations} steps of {forwards} and {backwards} back"))
            .advise("use at most 10,000 steps of 0 to 1"));
    }
    if let Some(face) = mesh.face_sizes.iter().position(|size| *size != 3) {
        return Err(Error::invalid("it is not a triangle").at(format!("face {face}")).advise("triangulate the mesh"));
    }
    if mesh.corners.len() != 3 * mesh.face_sizes.len() {
        return Err(Error::invalid("there are not three corners for each face"));
    }
    if let Some(corner) = mesh.corners.iter().position(|point| *point as usize >= mesh.points.len()) {
        return Err(
            Error::invalid(format!("point {} does not exist", mesh.corners[corner])).at(format!("corner {corner}"))
        );
    }
    let _stage = context.stats().begin("isosurface.smooth");
    let fans = Fans::new(mesh);
    let mut points = mesh.points.clone();
    let mut moved = points.clone();
    for step in 0..iterations {
        progress.step(step as f32 / iterations as f32, "smoothing")?;
        for share in [forwards, -backwards] {
            if share != 0.0 {
                context.for_each_part(moved.as_mut_slice(), CHUNK_LEN, |first, moved| {
                    for (at, moved) in moved.iter_mut().enumerate() {
                        *moved = fans.towards(mesh, &points, first + at, share);
                    }
                    Ok(())
                })?;
                std::mem::swap(&mut points, &mut moved);
            }
        }
    }
    mesh.points = points;
    let is_normal = |attribute: &Attribute| attribute.name == "normal" && attribute.domain == Domain::Point;
    if let Some(place) = mesh.attributes.iter().position(is_normal) {
        let normals = context.map(mesh.points.len(), |vertex| fans.normal(mesh, vertex)).into_flattened();
        let attribute = &mut mesh.attributes[place];
        attribute.width = 3;
        attribute.values = Values::F32(normals);
    }
    Ok(())
}

/// The corners at each vertex. On a closed mesh the next corner of the triangle is each neighbour once.
struct Fans {
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl Fans {
    fn new(mesh: &Mesh) -> Self {
        let mut starts = vec![0u32; mesh.points.len() + 1];
        mesh.corners.iter().for_each(|point| starts[*point as usize + 1] += 1);
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut next = starts.clone();
        let mut corners = vec![0; mesh.corners.len()];
        for (corner, point) in mesh.corners.iter().enumerate() {
            let place = &mut next[*point as usize];
            corners[*place as usize] = corner as u32;
            *place += 1;
        }
        Self { starts, corners }
    }

    fn of(&self, vertex: usize) -> &[u32] {
        &self.corners[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// A point moved by a share of the way to the mean of its neighbours.
    fn towards(&self, mesh: &Mesh, points: &[[f32; 3]], vertex: usize, share: f32) -> [f32; 3] {
        let own = Vec3::from(points[vertex]);
        let corners = self.of(vertex);
        let offset = |corner: &u32| {
            let next = corner - corner % 3 + (corner + 1) % 3;
            Vec3::from(points[mesh.corners[next as usize] as usize]) - own
        };
        let sum: Vec3 = corners.iter().map(offset).sum();
        (own + sum * (share / corners.len().max(1) as f32)).to_array()
    }

    /// The unit normal of the triangles around a vertex, by their areas.
    fn normal(&self, mesh: &Mesh, vertex: usize) -> [f32; 3] {
        let point = |corner: u32| Vec3::from(mesh.points[mesh.corners[corner as usize] as usize]).as_dvec3();
        let area = |corner: &u32| {
            let first = corner - corner % 3;
            let [a, b, c] = [first, first + 1, first + 2].map(point);
            (b - a).cross(c - a)
        };
        let sum: DVec3 = self.of(vertex).iter().map(area).sum();
        sum.normalize_or(DVec3::Z).as_vec3().to_array()
    }
}
