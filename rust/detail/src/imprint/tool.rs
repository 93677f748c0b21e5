//! A tool body that is pressed into a surface by a force, as by the pressure of a pen (Schäfer et al. 2014, Section 7,
//! Sculpting Demo): how deep it sinks.
//!
//! The material resists like an elastic foundation (Winkler 1867): its pressure is its stiffness times the depth at
//! each place. The force on the tool is then the stiffness times the volume it displaces, which grows with the depth,
//! so every force has one depth; a blunt tool sinks less than a pointed one.

use glam::{DAffine3, DVec3};
use relievo_core::{Error, Result};

use crate::imprint::collider::Collider;

relievo_core::parameters! {
    /// How a tool body yields to a force.
    pub struct ToolSettings {
        /// Force that displaces one cubic world unit of material.
        stiffness: f32 = 1.0, 0.000001..=1e12, "force / world units³";
        /// Largest depth to which the tool sinks.
        max_depth: f32 = 1.0, 0.0..=1e6, "world units";
    }
}

/// The pose of `tool`, which otherwise stays as it is turned, when `force` presses it along −`normal` into a surface
/// whose tangent plane at `place` has that normal.
///
/// The tool's foremost point along −`normal` is put at `place` and sunk until the displaced volume carries the force.
///
/// # Errors
/// Fails with `Invalid` if a setting is out of range, the place, the normal or the force is not finite, the normal is
/// zero, the force is negative, or the tool is not closed.
pub fn pressed(tool: &Collider, place: DVec3, normal: DVec3, force: f64, settings: &ToolSettings) -> Result<DAffine3> {
    settings.check()?;
    let up = normal.normalize_or_zero();
    if !place.is_finite() || up == DVec3::ZERO || !(force >= 0.0 && force.is_finite()) {
        return Err(Error::invalid("the tool needs a place, a normal and a force that is not negative"));
    }
    if !tool.is_closed() {
        return Err(Error::invalid("the tool has open edges and so no volume").advise("use a closed mesh"));
    }
    let transform = *tool.transform();
    let world = |point: &[f32; 3]| transform.transform_point3(DVec3::from(point.map(f64::from)));
    let foremost = foremost(tool, -up);
    let front = foremost.dot(up);
    // Triangles that can be reached, as heights above the foremost point and areas seen along the normal.
    let deepest = f64::from(settings.max_depth);
    let mut facets = Vec::new();
    for corners in tool.triangles() {
        let corners = corners.map(|corner| world(&tool.points()[corner as usize]));
        let mut heights = corners.map(|corner| corner.dot(up) - front);
        if heights.iter().any(|height| *height < deepest) {
            let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(up);
            heights.sort_by(f64::total_cmp);
            facets.push((heights, area));
        }
    }
    // A mirrored transform turns the triangles round; the volume does not care.
    let volume = |depth: f64| facets.iter().map(|(heights, area)| area * below(heights, depth)).sum::<f64>().abs();
    let wanted = force / f64::from(settings.stiffness);
    let (mut low, mut high) = (0.0, deepest);
    if volume(high) > wanted {
        // The volume grows with the depth; 60 halvings use up the digits.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if volume(middle) > wanted { high = middle } else { low = middle }
        }
    } else {
        low = deepest;
    }
    let shift = place - foremost - up * low;
    Ok(DAffine3 { translation: transform.translation + shift, ..transform })
}

/// The point of `tool`, where it is, that comes first when it goes along `direction`.
pub fn foremost(tool: &Collider, direction: DVec3) -> DVec3 {
    let world = |point: &[f32; 3]| tool.transform().transform_point3(DVec3::from(point.map(f64::from)));
    let first = tool.points().iter().map(world).max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)));
    first.unwrap_or(tool.transform().translation)
}

/// The mean over a triangle, whose corners have the given ascending heights, of how far it is below `depth`, 0 where it
/// is above.
fn below([a, b, c]: &[f64; 3], depth: f64) -> f64 {
    // The part of the triangle below the plane, cut off at the lowest corner, less what was cut at the middle one.
    let piece = |near: f64, other: f64, far: f64| {
        let d = depth - near;
        if d <= 0.0 { 0.0 } else { d * d * d / (3.0 * (other - near) * (far - near)) }
    };
    if depth <= *a {
        0.0
    } else if depth >= *c {
        depth - (a + b + c) / 3.0
    } else if depth <= *b {
        piece(*a, *b, *c)
    } else {
        // Above the middle corner: everything less the tip around the highest one.
        let rest = c - depth;
        depth - (a + b + c) / 3.0 + rest * rest * rest / (3.0 * (c - a) * (c - b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::shapes;
    use relievo_core::Context;

    fn depth(collider: &Collider, force: f64, normal: DVec3, settings: &ToolSettings) -> f64 {
        let place = DVec3::new(3.0, -2.0, 1.0);
        let pose = pressed(collider, place, normal, force, settings).unwrap();
        let lowest = collider.points().iter().map(|p| pose.transform_point3(DVec3::from(p.map(f64::from))).dot(normal));
        place.dot(normal) - lowest.fold(f64::INFINITY, f64::min)
    }

    fn make((points, triangles): shapes::Soup, transform: DAffine3) -> Collider {
        Collider::new(&Context::serial(), points, triangles, transform).unwrap()
    }

    #[test]
    fn a_block_sinks_by_force_over_stiffness_and_area() {
        let block = make(shapes::cube(0.5), DAffine3::from_scale(DVec3::new(2.0, 3.0, -4.0)));
        let settings = ToolSettings { stiffness: 10.0, max_depth: 2.0 };
        for (force, expected) in [(0.0, 0.0), (6.0, 0.1), (60.0, 1.0), (600.0, 2.0)] {
            let found = depth(&block, force, DVec3::Z, &settings);
            assert!((found - expected).abs() < 1e-6, "{force}: {found} {expected}");
        }
        assert!((depth(&block, 8.0, DVec3::X, &settings) - 8.0 / 120.0).abs() < 1e-6);
    }

    #[test]
    fn a_ball_sinks_until_its_cap_carries_the_force() {
        let ball = make(shapes::sphere(2.0, 200, 100, 0.0), DAffine3::IDENTITY);
        let settings = ToolSettings { stiffness: 5.0, max_depth: 4.0 };
        let normal = DVec3::new(0.3, -0.5, 0.8).normalize();
        for force in [0.5, 5.0, 50.0] {
            let d = depth(&ball, force, normal, &settings);
            let cap = std::f64::consts::PI * d * d * (6.0 - d) / 3.0;
            assert!((5.0 * cap / force - 1.0).abs() < 0.02, "{force}: {d} {cap}");
        }
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let (points, mut triangles) = shapes::cube(1.0);
        let settings = ToolSettings::default();
        let closed = make((points.clone(), triangles.clone()), DAffine3::IDENTITY);
        assert!(pressed(&closed, DVec3::ZERO, DVec3::ZERO, 1.0, &settings).is_err());
        assert!(pressed(&closed, DVec3::ZERO, DVec3::Z, -1.0, &settings).is_err());
        assert!(pressed(&closed, DVec3::NAN, DVec3::Z, 1.0, &settings).is_err());
        triangles.pop();
        let open = make((points, triangles), DAffine3::IDENTITY);
        assert!(pressed(&open, DVec3::ZERO, DVec3::Z, 1.0, &settings).is_err());
    }
}
