//! The camera of the view: it turns about a target, with the up direction of the scene upright.

use egui::{Key, Pos2, Rect, pos2};
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

/// Vertical field of view, radians.
const FOV: f64 = 0.6;

/// How much of the view's width or height what is fitted takes.
const FILLED: f64 = 0.9;

/// The steepest the camera looks down or up, radians.
const STEEPEST: f64 = std::f64::consts::FRAC_PI_2;

/// Distances of the target at which a camera in perspective shows what a parallel projection does.
const FAR: f64 = 200.0;

/// A direction to look from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Front,
    Back,
    Right,
    Left,
    Top,
    Bottom,
}

/// A camera that looks at a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Camera {
    target: DVec3,
    /// From the target, world units.
    distance: f64,
    /// About the up direction, radians; 0 looks from the front.
    yaw: f64,
    /// Above the horizon, radians.
    pitch: f64,
    is_parallel: bool,
    /// From axes with z up, x to the right and the front along y to those of the world.
    upright: DMat3,
    /// The least box and ball around the scene.
    bounds: [DVec3; 2],
}

impl Camera {
    /// A camera that has the box `bounds` in view from the front right above, where the axis `up`, 0 to 2, points up.
    pub(crate) fn new(bounds: [DVec3; 2], up: usize) -> Self {
        let upright = match up {
            0 => DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
            1 => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
            _ => DMat3::IDENTITY,
        };
        let (target, distance) = (DVec3::ZERO, 1.0);
        let mut camera = Self { target, distance, yaw: 0.6, pitch: 0.45, is_parallel: false, upright, bounds };
        camera.fit(1.0);
        camera
    }

    /// Takes on another box around the scene; the view stays.
    pub(crate) fn set_bounds(&mut self, bounds: [DVec3; 2]) {
        self.bounds = bounds;
    }

    /// The radius of the ball around the scene, above 0.
    fn radius(&self) -> f64 {
        let radius = 0.5 * (self.bounds[1] - self.bounds[0]).length();
        if radius > 0.0 { radius } else { 1.0 }
    }

    /// The middle of the scene.
    fn middle(&self) -> DVec3 {
        0.5 * (self.bounds[0] + self.bounds[1])
    }

    /// Columns: right, up, and against the direction of view.
    pub(crate) fn axes(&self) -> DMat3 {
        let ((sin, cos), (rise, level)) = (self.yaw.sin_cos(), self.pitch.sin_cos());
        let right = DVec3::new(cos, sin, 0.0);
        let back = DVec3::new(level * sin, -level * cos, rise);
        self.upright * DMat3::from_cols(right, back.cross(right), back)
    }

    fn eye(&self) -> DVec3 {
        self.target + self.axes().z_axis * self.distance
    }

    /// World units that a height of 1 of the view spans at the target.
    pub(crate) fn span(&self) -> f64 {
        2.0 * self.distance * (0.5 * FOV).tan()
    }

    /// Has the whole scene in view, where the view is `aspect` times as wide as high.
    pub(crate) fn fit(&mut self, aspect: f64) {
        self.target = self.middle();
        let (axes, tangent) = (self.axes(), FILLED * (0.5 * FOV).tan());
        let needed = |at: u32| {
            let pick = |axis: usize| self.bounds[(at >> axis & 1) as usize][axis];
            let corner = axes.transpose() * (DVec3::new(pick(0), pick(1), pick(2)) - self.target);
            corner.z + (corner.x.abs() / (tangent * aspect)).max(corner.y.abs() / tangent)
        };
        self.distance = (0..8).map(needed).fold(1e-3 * self.radius(), f64::max);
    }

    /// Turns by a way of the pointer, in heights of the view.
    pub(crate) fn orbit(&mut self, way: DVec2) {
        self.yaw = (self.yaw - 4.0 * way.x).rem_euclid(std::f64::consts::TAU);
        self.pitch = (self.pitch + 4.0 * way.y).clamp(-STEEPEST, STEEPEST);
    }

    /// Moves with a way of the pointer, in heights of the view.
    pub(crate) fn pan(&mut self, way: DVec2) {
        let (axes, span) = (self.axes(), self.span());
        self.target += span * (axes.y_axis * way.y - axes.x_axis * way.x);
    }

    /// Comes nearer by notches of the wheel.
    pub(crate) fn zoom(&mut self, notches: f64) {
        let radius = self.radius();
        self.distance = (self.distance * 0.85_f64.powf(notches)).clamp(1e-4 * radius, 1e3 * radius);
    }

    /// Looks from a side, in parallel projection.
    pub(crate) fn look_from(&mut self, side: Side) {
        use std::f64::consts::{FRAC_PI_2, PI};
        (self.yaw, self.pitch) = match side {
            Side::Front => (0.0, 0.0),
            Side::Back => (PI, 0.0),
            Side::Right => (FRAC_PI_2, 0.0),
            Side::Left => (-FRAC_PI_2, 0.0),
            Side::Top => (0.0, FRAC_PI_2),
            Side::Bottom => (0.0, -FRAC_PI_2),
        };
        self.is_parallel = true;
    }

    /// Looks from a side or changes the projection if `key` stands for that; the opposite side with `is_opposite`.
    pub(crate) fn press(&mut self, key: Key, is_opposite: bool) {
        let [front, right, top] = match is_opposite {
            true => [Side::Back, Side::Left, Side::Bottom],
            false => [Side::Front, Side::Right, Side::Top],
        };
        match key {
            Key::Num1 => self.look_from(front),
            Key::Num3 => self.look_from(right),
            Key::Num7 => self.look_from(top),
            Key::Num5 => self.toggle_projection(),
            _ => {}
        }
    }

    /// Changes between perspective and parallel projection.
    pub(crate) fn toggle_projection(&mut self) {
        self.is_parallel = !self.is_parallel;
    }

    /// Whether the projection is parallel.
    pub(crate) fn is_parallel(&self) -> bool {
        self.is_parallel
    }

    /// The place and the vertical field of view, radians, of a camera in perspective that shows the same: a far one stands
    /// for parallel projection.
    pub(crate) fn perspective(&self) -> (DVec3, f64) {
        if !self.is_parallel {
            return (self.eye(), FOV);
        }
        let distance = FAR * self.distance.max(self.radius());
        (self.target + self.axes().z_axis * distance, 2.0 * (0.5 * self.span() / distance).atan())
    }

    /// From the world to clip space, with depths from 0 to 1.
    pub(crate) fn matrix(&self, aspect: f64) -> DMat4 {
        let (eye, axes) = (self.eye(), self.axes());
        let radius = self.radius();
        let middle = axes.z_axis.dot(eye - self.middle());
        let far = (middle + 1.1 * radius).max(0.1 * radius);
        let to_camera = DMat4::from_mat3(axes.transpose()) * DMat4::from_translation(-eye);
        if self.is_parallel {
            let half = 0.5 * self.span();
            let near = middle - 1.1 * radius;
            let depth = far - near;
            let [x, y, z] = [DVec4::X / (half * aspect), DVec4::Y / half, -DVec4::Z / depth];
            return DMat4::from_cols(x, y, z, DVec4::new(0.0, 0.0, -near / depth, 1.0)) * to_camera;
        }
        let near = (middle - 1.1 * radius).max(2e-4 * far);
        let (focus, depth) = ((0.5 * FOV).tan().recip(), far / (near - far));
        let [x, y] = [DVec4::X * (focus / aspect), DVec4::Y * focus];
        DMat4::from_cols(x, y, DVec4::new(0.0, 0.0, depth, -1.0), DVec4::Z * (near * depth)) * to_camera
    }

    /// Returns where a point of the world is in the window, in its points, where `area` of it shows the view; `None` for a point
    /// that is not in front.
    pub(crate) fn project(&self, area: Rect, point: DVec3) -> Option<Pos2> {
        let placed = self.matrix(aspect(area)) * point.extend(1.0);
        let (x, y) = (placed.x / placed.w, placed.y / placed.w);
        let is_seen = placed.w > 0.0 || self.is_parallel;
        (is_seen && x.is_finite() && y.is_finite()).then(|| {
            pos2(
                area.left() + (0.5 + 0.5 * x as f32) * area.width(),
                area.top() + (0.5 - 0.5 * y as f32) * area.height(),
            )
        })
    }

    /// Returns the ray through a place of the window, in its points, where `area` of it shows the view; see [`Self::ray`].
    pub(crate) fn ray_at(&self, area: Rect, at: Pos2) -> (DVec3, DVec3) {
        let share = |at: f32, low: f32, length: f32| 2.0 * f64::from((at - low) / length.max(1.0)) - 1.0;
        let place = DVec2::new(share(at.x, area.left(), area.width()), -share(at.y, area.top(), area.height()));
        self.ray(place, aspect(area))
    }

    /// The ray through a place of the view, −1 to 1 to the right and upwards: where it starts and its direction of length 1.
    pub(crate) fn ray(&self, at: DVec2, aspect: f64) -> (DVec3, DVec3) {
        let (eye, axes) = (self.eye(), self.axes());
        let half = (0.5 * FOV).tan();
        let across = axes.x_axis * (at.x * half * aspect) + axes.y_axis * (at.y * half);
        if self.is_parallel {
            // From before the scene.
            let start = self.target + across * self.distance;
            let back = (self.middle() - start).dot(axes.z_axis) + 1.1 * self.radius();
            return (start + axes.z_axis * back, -axes.z_axis);
        }
        (eye, (across - axes.z_axis).normalize())
    }
}

/// Returns the width of an area of the window as a share of its height.
pub(crate) fn aspect(area: Rect) -> f64 {
    f64::from(area.width()) / f64::from(area.height().max(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(up: usize) -> Camera {
        Camera::new([DVec3::new(-1.0, -2.0, -0.5), DVec3::new(3.0, 2.0, 0.5)], up)
    }

    #[test]
    fn rays_go_through_what_the_matrix_projects_there() {
        for up in 0..3 {
            for side in [None, Some(Side::Top), Some(Side::Left), Some(Side::Back)] {
                let mut camera = camera(up);
                camera.fit(1.6);
                side.into_iter().for_each(|side| camera.look_from(side));
                camera.pan(DVec2::new(0.1, -0.05));
                for at in [DVec2::ZERO, DVec2::new(0.7, -0.4), DVec2::new(-0.9, 0.8)] {
                    let (start, way) = camera.ray(at, 1.6);
                    assert!((way.length() - 1.0).abs() < 1e-12);
                    let placed = camera.matrix(1.6) * (start + way * 6.0).extend(1.0);
                    assert!((placed.truncate().truncate() / placed.w - at).length() < 1e-9, "{up} {side:?} {placed}");
                }
            }
        }
    }

    #[test]
    fn what_is_fitted_is_in_view_and_sides_show_their_axes() {
        for up in 0..3 {
            let mut camera = camera(up);
            for aspect in [0.5, 1.0, 2.5] {
                camera.fit(aspect);
                let matrix = camera.matrix(aspect);
                let mut most = 0.0_f64;
                for corner in 0..8 {
                    let pick = |axis: usize| camera.bounds[(corner >> axis & 1) as usize][axis];
                    let placed = matrix * DVec3::new(pick(0), pick(1), pick(2)).extend(1.0);
                    let placed = placed.truncate() / placed.w;
                    assert!((0.0..=1.0).contains(&placed.z), "{placed}");
                    most = most.max(placed.x.abs()).max(placed.y.abs());
                }
                assert!((most - FILLED).abs() < 1e-9, "{most}");
            }
            let upwards = [DVec3::X, DVec3::Y, DVec3::Z][up];
            camera.look_from(Side::Front);
            assert!((camera.axes().y_axis - upwards).length() < 1e-12);
            camera.look_from(Side::Top);
            assert!((camera.axes().z_axis - upwards).length() < 1e-12);
            assert!((camera.axes().determinant() - 1.0).abs() < 1e-12);
        }
    }
}
