//! Strips along a curve on the surface: labels around a neck, seams, belts.
//!
//! The middle line of the image lies on the curve, its whole width along the curve's whole length (after the texture
//! brush of Sun et al. 2013). Places of the curve are joined by geodesics. Each of them is a pin, and further
//! pins between them are at most as far from one another as the strip is wide. Lengths are units of the mesh.

use relievo_core::{Error, Mesh, Result};

use crate::decal::Sticker;
use crate::nearest::weights;
use crate::paths::geodesic::geodesic;
use crate::pins::{Pin, Place, insert, name};
use crate::surface::{Surface, Vec3, between, length, minus};

/// The most pins of a strip.
const MAX: usize = 512;

/// A strip along a curve: pins for [`lay`](crate::lay), and the length of the curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Pins from the left end of the image's middle line to its right end.
    pub pins: Vec<Pin>,
    /// The length of the curve.
    pub length: f64,
}

/// Places the middle line of a sticker's bounds along a curve through places of a mesh.
///
/// # Errors
/// The mesh or a place is unusable; there are fewer than two places or more than 512; two that follow each other are the
/// same or lie on different components.
pub fn strip(mesh: &Mesh, sticker: &Sticker, curve: &[Place]) -> Result<Strip> {
    if !(2..=MAX).contains(&curve.len()) {
        return Err(Error::invalid(format!("it has {} places", curve.len()))
            .at("curve")
            .advise(format!("give 2 to {MAX} places")));
    }
    let surface = Surface::new(mesh)?;
    let (divided, vertices) = insert(surface.clone(), curve)?;
    let Traced { points, corners } = traced(&divided, &vertices)?;
    let along = corners[corners.len() - 1];
    let (low, high) = sticker.outline.bounds();
    let scale = (high[0] - low[0]) / along;
    let most = (high[1] - low[1]) / scale;
    let mut ways = vec![0.0];
    for pair in corners.windows(2) {
        let parts = ((pair[1] - pair[0]) / most).ceil().clamp(1.0, MAX as f64);
        ways.extend((1..=parts as usize).map(|part| pair[0] + (pair[1] - pair[0]) * part as f64 / parts));
    }
    if ways.len() > MAX {
        return Err(Error::invalid(format!("it takes {} pins", ways.len()))
            .at("curve")
            .advise("shorten the curve, or make the strip wider"));
    }
    let middle = 0.5 * (low[1] + high[1]);
    let mut pins = Vec::with_capacity(ways.len());
    for way in ways {
        let next = points.partition_point(|point| point.way < way).clamp(1, points.len() - 1);
        let (from, to) = (points[next - 1], points[next]);
        let share = if to.way > from.way { (way - from.way) / (to.way - from.way) } else { 0.0 };
        let point = between(from.place, to.place, share);
        let face = divided.sources[to.triangle as usize];
        let barycentric = weights(surface.corners(face), point);
        // A pin on the outline itself would be neither inside nor outside.
        let inset = 1e-6 * (high[0] - low[0]);
        let x = (low[0] + scale * way).clamp(low[0] + inset, high[0] - inset);
        pins.push(Pin { image: [x, middle].map(|value| value * sticker.size[0]), place: Place { face, barycentric } });
    }
    Ok(Strip { pins, length: along })
}

/// A curve as points, and the lengths up to each of its places.
struct Traced {
    points: Vec<Point>,
    corners: Vec<f64>,
}

/// A point of a curve.
#[derive(Clone, Copy)]
struct Point {
    /// The length of the curve up to it.
    way: f64,
    place: Vec3,
    /// The triangle that holds the stretch of the curve before it.
    triangle: u32,
}

/// Joins vertices by geodesics.
fn traced(surface: &Surface, vertices: &[u32]) -> Result<Traced> {
    let mut points = vec![Point { way: 0.0, place: surface.points[vertices[0] as usize], triangle: 0 }];
    let mut corners = vec![0.0];
    for (index, ends) in vertices.windows(2).enumerate() {
        let path = geodesic(surface, ends[0], ends[1])?.ok_or_else(|| {
            Error::invalid("no path on the surface joins it to the place before: they are on different components")
                .at(name(index + 1))
                .advise("move it onto the component of the other, or join the components")
        })?;
        for (span, ends) in path.spans.iter().zip(path.vertices.windows(2)) {
            let mut add = |place: Vec3, triangle: u32| {
                let last = points[points.len() - 1];
                points.push(Point { way: last.way + length(minus(place, last.place)), place, triangle });
            };
            for crossing in span {
                add(crossing.point(surface), crossing.half / 3);
            }
            // The last face lies beyond the last edge that the path crosses.
            let beyond = match span.last() {
                Some(crossing) => surface.mate(crossing.half),
                None => joining(surface, ends[0], ends[1]),
            };
            let beyond = beyond.ok_or_else(|| Error::internal("a path has no face"))?;
            add(surface.points[ends[1] as usize], beyond / 3);
        }
        corners.push(points[points.len() - 1].way);
    }
    Ok(Traced { points, corners })
}

/// Returns a half-edge of the edge between two vertices.
fn joining(surface: &Surface, from: u32, to: u32) -> Option<u32> {
    let find = |from: u32, to: u32| surface.fan(from).find(|half| surface.target(*half) == to);
    find(from, to).or_else(|| find(to, from))
}
