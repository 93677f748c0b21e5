//! The triangle behind a hit and the smooth surface that it stands for.
//!
//! Rays that leave it start on the surface that the normals suggest (Hanika 2021, "Hacking the Shadow Terminator").

use glam::Vec3;
use relievo_embree::Hit;

use crate::camera::Rays;
use crate::scene::{Mesh, Placed, Placement};

/// The triangle behind a hit, in the camera's space.
pub(crate) struct Facet<'a> {
    pub mesh: &'a Mesh,
    pub placement: &'a Placement,
    pub primitive: usize,
    corners: [u32; 3],
    points: [Vec3; 3],
    weights: [f32; 3],
}

/// A place on a surface to be lit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// From where rays start that go to the lit side.
    pub start: Vec3,
    /// From where rays start that go on behind the surface.
    pub behind: Vec3,
    /// Unit normal of the triangle; both normals are to the side that is seen.
    pub flat: Vec3,
    /// Unit normal of the smooth surface.
    pub smooth: Vec3,
    /// Whether the front is seen, where a ray enters a closed body.
    pub enters: bool,
}

impl<'a> Facet<'a> {
    /// The triangle that `hit` names.
    pub fn of(placed: &'a Placed<'a>, hit: &Hit) -> Option<Self> {
        let index = hit.object.0 as usize;
        let placement = placed.placements.get(index)?.as_ref()?;
        let mesh = placed.objects.get(index)?.as_ref()?.meshes.get(hit.mesh as usize)?.as_ref()?;
        let primitive = hit.primitive as usize;
        let corners = *mesh.triangles.get(primitive)?;
        let points = corners.map(|at| placement.linear * Vec3::from(mesh.points[at as usize]) + placement.translation);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        Some(Self { mesh, placement, primitive, corners, points, weights })
    }

    fn blend(&self, values: [Vec3; 3]) -> Vec3 {
        values[0] * self.weights[0] + values[1] * self.weights[1] + values[2] * self.weights[2]
    }

    /// Diffuse reflectance.
    pub fn albedo(&self) -> Vec3 {
        match self.mesh.colors.as_slice() {
            [] => Vec3::from(self.placement.material.base_color),
            colors => self.blend(self.corners.map(|at| Vec3::from(colors[at as usize]))),
        }
    }

    /// The place of the hit, seen along `direction`.
    pub fn place(&self, direction: Vec3) -> Place {
        let [a, b, c] = self.points;
        let mut flat = (b - a).cross(c - a).normalize_or(Vec3::Z);
        if self.placement.mirrored {
            flat = -flat;
        }
        let point = self.blend(self.points);
        // A few units in the last place of what the coordinates were summed from.
        let step = 4e-6 * (point.abs().max_element() + self.placement.translation.abs().max_element());
        let seen = if flat.dot(direction) > 0.0 { -1.0 } else { 1.0 };
        flat *= seen;
        let (behind, enters) = (point - flat * step, seen > 0.0);
        if self.mesh.normals.is_empty() {
            return Place { start: point + flat * step, behind, flat, smooth: flat, enters };
        }
        let normals = self.corners.map(|at| {
            (self.placement.normal * Vec3::from(self.mesh.normals[at as usize])).normalize_or(flat * seen) * seen
        });
        let smooth = self.blend(normals).normalize_or(flat);
        if normals.iter().any(|normal| normal.dot(flat) < 0.1) || smooth.dot(flat) < 0.1 {
            // The normals say little about such a triangle.
            return Place {
                start: point + flat * step,
                behind,
                flat,
                smooth: if smooth.dot(flat) > 0.0 { smooth } else { flat },
                enters,
            };
        }
        // Each corner's tangent plane lifts the point if it lies below; the smooth surface is about where they agree.
        let lifts = [0, 1, 2].map(|corner| {
            let below = (point - self.points[corner]).dot(normals[corner]);
            normals[corner] * -below.min(0.0)
        });
        Place { start: point + self.blend(lifts) + flat * step, behind, flat, smooth, enters }
    }

    /// Distances in pixels from the place that `direction` sees to the lines through the edges, edge e from corner e to
    /// the next.
    pub fn edge_distances(&self, direction: Vec3, rays: &Rays) -> [f32; 3] {
        let [a, b, c] = self.points;
        // Weight i of a direction is the volume it spans with the other two corners.
        let rows = [b.cross(c - b), c.cross(a - c), a.cross(b - a)];
        let of = |direction: Vec3| rows.map(|row| row.dot(direction));
        let (here, dx, dy) = (of(direction), of(rays.dx), of(rays.dy));
        let sum = |weights: [f32; 3]| weights[0] + weights[1] + weights[2];
        let scale = 1.0 / sum(here);
        [2, 0, 1].map(|corner| {
            let weight = here[corner] * scale;
            let slope = |change: [f32; 3]| (change[corner] - weight * sum(change)) * scale;
            let distance = weight.abs() / slope(dx).hypot(slope(dy));
            if distance.is_nan() { f32::INFINITY } else { distance }
        })
    }
}
