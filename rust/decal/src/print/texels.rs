//! The texels that a decal covers: in tiles of a surface, or in the texture of a mesh.
//!
//! A chart says where a face of the mesh lies among the texels. Triangles of the decal are drawn into the charts of their
//! faces, several samples a texel, from the deepest to the highest (the paper's Section 6, where the depths of pins
//! spread over the triangles by a Laplace equation; here they are weighted by inverse squared distances in the image,
//! Shepard 1968). Texels are numbered row by row.

use std::collections::BTreeMap;

use relievo_core::{Context, Error, Mesh, Result};

use crate::artwork::Artwork;
use crate::decal::Decal;
use crate::map::energy::Vec2;
use crate::surface::{Vec3, cross, dot, minus};

/// Samples along each side of a texel.
pub const SAMPLES: usize = 4;
/// Texels along each side of the square that is drawn at once.
const WINDOW: u32 = 64;

/// Where a face of a mesh lies among the texels of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chart {
    /// The number of the target: a tile, or a texture.
    pub target: u32,
    /// The places of the three corners, in texels.
    pub corners: [Vec2; 3],
}

/// A square of texels of a target with what a decal has there.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The number of the target.
    pub target: u32,
    /// The first column and row.
    pub first: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
    /// Colour and alpha of each texel, premultiplied, row by row.
    pub colors: Vec<[f32; 4]>,
    /// Of each texel cosine and sine of the angle from the tangent by the first coordinate of the chart to the image's
    /// direction to the right, on the surface: the mean over the samples, 0 where the decal does not lie.
    pub turns: Vec<Vec2>,
}

/// A triangle of a decal in a chart.
#[derive(Clone, Copy, Debug)]
struct Piece {
    vertices: [u32; 3],
    places: [Vec2; 3],
    uv: [Vec2; 3],
    depth: f64,
    turn: Vec2,
}

/// Draws a decal into charts, one for each face of the mesh that it lies on; `size` returns the columns and rows of a
/// target. `depths` are those of the pins, or empty: where the sticker overlaps itself, the part near pins of larger
/// depths lies on top.
///
/// # Errors
/// The mesh or the charts differ from those of the decal when it was made, or there are depths, but not one for each
/// pin.
pub fn draw(
    context: &Context,
    mesh: &Mesh,
    charts: &[Chart],
    size: &(dyn Fn(u32) -> [u32; 2] + Sync),
    decal: &Decal,
    artwork: &Artwork,
    depths: &[f64],
) -> Result<Vec<Window>> {
    let largest = decal.faces.iter().copied().max().unwrap_or(0) as usize;
    if mesh.face_count() != charts.len() || largest >= charts.len() || mesh.corners.len() != 3 * charts.len() {
        return Err(Error::invalid(format!("{} faces have {} charts", mesh.face_count(), charts.len()))
            .at("decal")
            .advise("give the mesh that the decal lies on, with a chart for each face"));
    }
    decal.check_depths(depths)?;
    let mut windows: BTreeMap<(u32, u32, u32), Vec<Piece>> = BTreeMap::new();
    for (triangle, face) in decal.triangles.iter().zip(&decal.faces) {
        let chart = &charts[*face as usize];
        let corners = &mesh.corners[3 * *face as usize..3 * *face as usize + 3];
        let corners: [Vec3; 3] = std::array::from_fn(|corner| mesh.points[corners[corner] as usize].map(f64::from));
        let uv = triangle.map(|vertex| decal.uv[vertex as usize]);
        let points = triangle.map(|vertex| decal.points[vertex as usize]);
        let Some(places) = places(chart, corners, points) else {
            continue;
        };
        let middle: Vec2 = std::array::from_fn(|axis| uv.iter().map(|uv| uv[axis]).sum::<f64>() / 3.0);
        let piece = Piece {
            vertices: *triangle,
            places,
            uv,
            depth: decal.depth(middle, depths),
            turn: turn(places, uv, points),
        };
        let [width, height] = size(chart.target);
        let span = |axis: usize, count: u32| {
            let values = places.map(|place| place[axis]);
            let least = values.into_iter().fold(f64::INFINITY, f64::min).max(0.0) as u32;
            let most = values.into_iter().fold(0.0, f64::max) as u32;
            least / WINDOW..most.min(count.saturating_sub(1)) / WINDOW + 1
        };
        for row in span(1, height) {
            for column in span(0, width) {
                windows.entry((chart.target, row, column)).or_default().push(piece);
            }
        }
    }
    let windows: Vec<_> = windows.into_iter().collect();
    let drawn = context.map(windows.len(), |index| {
        let ((target, row, column), pieces) = &windows[index];
        let first = [WINDOW * column, WINDOW * row];
        let [width, height] = size(*target);
        let size = [(width - first[0]).min(WINDOW), (height - first[1]).min(WINDOW)];
        let mut pieces = pieces.clone();
        pieces.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        let (colors, turns) = window(first, size, &pieces, artwork);
        Window { target: *target, first, size, colors, turns }
    });
    Ok(drawn.into_iter().filter(|window| window.colors.iter().any(|color| color[3] > 0.0)).collect())
}

/// The places in a chart of points in the plane of its face; none of a face without area.
fn places(chart: &Chart, corners: [Vec3; 3], points: [Vec3; 3]) -> Option<[Vec2; 3]> {
    let [a, b, c] = corners;
    let normal = cross(minus(b, a), minus(c, a));
    let whole = dot(normal, normal);
    let place = |point: Vec3| -> Vec2 {
        let share = |from: Vec3, to: Vec3| dot(normal, cross(minus(to, from), minus(point, from))) / whole;
        let weights = [share(b, c), share(c, a), share(a, b)];
        std::array::from_fn(|axis| (0..3).map(|corner| weights[corner] * chart.corners[corner][axis]).sum())
    };
    let places = points.map(place);
    places.as_flattened().iter().all(|value| value.is_finite()).then_some(places)
}

/// Cosine and sine of the angle in a triangle from the direction in which the first coordinate of the places grows to that in
/// which the first one of the image does; 0 for a triangle without area.
fn turn(places: [Vec2; 3], uv: [Vec2; 3], points: [Vec3; 3]) -> Vec2 {
    let (first, second) = (minus(points[1], points[0]), minus(points[2], points[0]));
    let along = |corners: [Vec2; 3]| -> Vec3 {
        let (a, b) = (corners[1][1] - corners[0][1], corners[2][1] - corners[0][1]);
        let area = (corners[1][0] - corners[0][0]) * b - a * (corners[2][0] - corners[0][0]);
        std::array::from_fn(|axis| (first[axis] * b - second[axis] * a) / area)
    };
    let (tangent, right) = (along(places), along(uv));
    let normal = cross(first, second);
    let (cos, sin) = (dot(tangent, right), dot(cross(normal, tangent), right) / dot(normal, normal).sqrt());
    let norm = cos.hypot(sin);
    if norm > 0.0 && norm.is_finite() { [cos / norm, sin / norm] } else { [0.0; 2] }
}

/// Draws pieces over one another and returns the mean of the samples of each texel: its colour, and its turn.
fn window(first: [u32; 2], size: [u32; 2], pieces: &[Piece], artwork: &Artwork) -> (Vec<[f32; 4]>, Vec<Vec2>) {
    let (columns, rows) = (size[0] as usize * SAMPLES, size[1] as usize * SAMPLES);
    let step = 1.0 / SAMPLES as f64;
    let mut samples = vec![[0.0_f32; 4]; columns * rows];
    let mut turns = vec![[0.0; 2]; size[0] as usize * size[1] as usize];
    let pixels = artwork.sticker().size;
    for piece in pieces {
        let local = piece.places.map(|place| [0, 1].map(|axis| (place[axis] - f64::from(first[axis])) / step - 0.5));
        let [a, b, c] = local;
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 {
            continue;
        }
        // Pixels of the image for a sample, from the ratio of the areas.
        let [p, q, r] = piece.uv.map(|uv| [uv[0] * pixels[0], uv[1] * pixels[1]]);
        let image = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let footprint = (image / area).abs().sqrt();
        let span = |axis: usize, count: usize| {
            let values = local.map(|corner| corner[axis]);
            let least = values.into_iter().fold(f64::INFINITY, f64::min).ceil().max(0.0);
            let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max).floor().min(count as f64 - 1.0);
            if least <= most { least as usize..most as usize + 1 } else { 0..0 }
        };
        for row in span(1, rows) {
            for column in span(0, columns) {
                let point = [column as f64, row as f64];
                let Some(weights) = weights(piece.vertices, local, point) else {
                    continue;
                };
                let uv = std::array::from_fn(|axis| {
                    (0..3).map(|corner| weights[corner] * piece.uv[corner][axis]).sum::<f64>() / area
                });
                let over = artwork.color(uv, footprint);
                let turn = &mut turns[row / SAMPLES * size[0] as usize + column / SAMPLES];
                (0..2).for_each(|axis| turn[axis] += piece.turn[axis] * f64::from(over[3]));
                let sample = &mut samples[row * columns + column];
                for (value, over_value) in sample.iter_mut().zip(over) {
                    *value = over_value + (1.0 - over[3]) * *value;
                }
            }
        }
    }
    let mut colors = Vec::with_capacity(size[0] as usize * size[1] as usize);
    for row in 0..size[1] as usize {
        for column in 0..size[0] as usize {
            let mut sum = [0.0_f32; 4];
            for sample in 0..SAMPLES * SAMPLES {
                let at = (row * SAMPLES + sample / SAMPLES) * columns + column * SAMPLES + sample % SAMPLES;
                for (sum, value) in sum.iter_mut().zip(samples[at]) {
                    *sum += value / (SAMPLES * SAMPLES) as f32;
                }
            }
            colors.push(sum);
        }
    }
    for turn in &mut turns {
        let norm = turn[0].hypot(turn[1]);
        if norm > 0.0 {
            *turn = turn.map(|value| value / norm);
        }
    }
    (colors, turns)
}

/// Twice the signed areas of a point with the three edges, if it lies within the triangle. A point on an edge lies within
/// one of the two triangles there, as both evaluate the edge from its vertex of the smaller number.
pub fn weights(vertices: [u32; 3], places: [Vec2; 3], point: Vec2) -> Option<[f64; 3]> {
    let mut weights = [0.0; 3];
    let mut sides = [false; 3];
    for corner in 0..3 {
        let (from, to) = ((corner + 1) % 3, (corner + 2) % 3);
        let is_ordered = vertices[from] < vertices[to];
        let (a, b) = if is_ordered { (places[from], places[to]) } else { (places[to], places[from]) };
        let turn = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]);
        sides[corner] = (turn > 0.0) == is_ordered;
        weights[corner] = if is_ordered { turn } else { -turn };
    }
    (sides == [true; 3] || sides == [false; 3]).then_some(weights)
}
