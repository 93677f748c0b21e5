//! A handle on the surface of what is shown, which the pointer drags over it.

use egui::{Color32, Pos2, Rect, Stroke, Ui};
use glam::{DVec3, Vec3};
use relievo_render::Mesh;

use crate::drawing::camera::Camera;

/// Points around a handle within which a button takes hold of it.
const REACH: f32 = 16.0;

/// Radius of the ring that shows a handle, in points.
const RING: f32 = 9.0;

/// Returns whether a button at `pos` takes hold of a handle.
pub(super) fn is_at(camera: &Camera, area: Rect, place: DVec3, pos: Pos2) -> bool {
    camera.project(area, place).is_some_and(|at| at.distance(pos) <= REACH)
}

/// Draws a handle.
pub(super) fn draw(ui: &Ui, camera: &Camera, area: Rect, place: DVec3) {
    let Some(at) = camera.project(area, place) else { return };
    let painter = ui.painter_at(area);
    painter.circle_stroke(at, RING, Stroke::new(5.0, Color32::from_black_alpha(140)));
    painter.circle_stroke(at, RING, Stroke::new(3.0, Color32::from_rgb(255, 120, 20)));
}

/// Returns the nearest place at which a ray meets a mesh from either side.
pub(super) fn met(mesh: &Mesh, (start, way): (DVec3, DVec3)) -> Option<DVec3> {
    let nearest = mesh.triangles.iter().filter_map(|corners| {
        let [a, b, c] = corners.map(|point| Vec3::from(mesh.points[point as usize]).as_dvec3());
        along(start, way, [a, b, c])
    });
    nearest.min_by(f64::total_cmp).map(|far| start + far * way)
}

/// Returns how far along a ray it meets a triangle (Moeller, Trumbore 1997).
fn along(start: DVec3, way: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let across = way.cross(ac);
    let volume = ab.dot(across);
    if volume == 0.0 {
        return None;
    }
    let from = start - a;
    let second = from.dot(across) / volume;
    let turned = from.cross(ab);
    let third = way.dot(turned) / volume;
    let far = ac.dot(turned) / volume;
    (second >= 0.0 && third >= 0.0 && second + third <= 1.0 && far > 0.0).then_some(far)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_meets_the_nearest_of_two_triangles() {
        let plane = |height: f32| [[-1.0, -1.0, height], [3.0, -1.0, height], [-1.0, 3.0, height]];
        let points = [plane(0.0), plane(1.0)].concat();
        let mesh = Mesh { points, triangles: vec![[0, 1, 2], [3, 5, 4]], ..Mesh::default() };
        let down = |x: f64| met(&mesh, (DVec3::new(x, 0.0, 5.0), DVec3::NEG_Z));
        assert_eq!(down(0.5), Some(DVec3::new(0.5, 0.0, 1.0)));
        assert_eq!(down(2.5), None);
        assert_eq!(met(&mesh, (DVec3::new(0.5, 0.0, -5.0), DVec3::Z)), Some(DVec3::new(0.5, 0.0, 0.0)));
        assert_eq!(met(&mesh, (DVec3::new(0.5, 0.0, -5.0), DVec3::NEG_Z)), None);
    }
}
