//! The outline of an image by its alpha: a contour by marching squares (Lorensen and Cline 1987, in the plane),
//! simplified to a tolerance (Douglas and Peucker 1973). Lengths are pixels.

use relievo_core::{Error, Result};
use relievo_render::Image;

use crate::artwork::outline::MAX;
use crate::decal::Sticker;
use crate::map::energy::{Vec2, distance};

/// Halvings of the tolerance for a simplified contour that crosses itself.
const HALVINGS: usize = 8;

/// Which contour of the alpha of an image is the outline of a sticker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contour {
    /// The alpha at the contour, above 0 and below 1.
    pub level: f64,
    /// How far the outline may be from the contour, in pixels, 0 to 1,000.
    pub tolerance: f64,
}

impl Default for Contour {
    fn default() -> Self {
        Self { level: 0.5, tolerance: 0.5 }
    }
}

impl Sticker {
    /// Cuts a sticker out of an image along a contour of its alpha. Holes stay a part of the sticker, as they are
    /// transparent.
    ///
    /// # Errors
    /// The image has no alpha or none above the level; it has several parts that are larger than the tolerance; a setting is
    /// out of range; or the outline would have more than 65,536 corners.
    pub fn of_alpha(image: &Image, contour: &Contour) -> Result<Self> {
        let refuse = |what: String, remedy: String| Err(Error::invalid(what).at("image").advise(remedy));
        let Contour { level, tolerance } = *contour;
        if !(level > 0.0 && level < 1.0 && (0.0..=1000.0).contains(&tolerance)) {
            return Err(Error::invalid(format!("the level is {level} and the tolerance {tolerance}"))
                .at("contour")
                .advise("use a level above 0 and below 1, and a tolerance of 0 to 1,000 pixels"));
        }
        if !matches!(image.channels(), 2 | 4) {
            return refuse("it has no alpha".into(), "give an image with alpha, or the corners of the outline".into());
        }
        let size = [image.width(), image.height()];
        Self::whole(size)?;
        let mut loops = contours(image, level);
        // Loops around what is opaque run counter-clockwise, those around holes clockwise.
        loops.retain(|corners| area(corners) > 0.0);
        loops.sort_by(|a, b| area(b).total_cmp(&area(a)));
        let Some(largest) = loops.first() else {
            return refuse(format!("no alpha is above {level}"), "lower the level, or give the corners".into());
        };
        let least = tolerance.max(1.0).powi(2);
        let is_apart = |part: &&Vec<Vec2>| area(part) > least && !is_inside(largest, part[0]);
        let apart: Vec<_> = loops[1..].iter().filter(is_apart).collect();
        if let Some(part) = apart.first() {
            let [x, y] = part[0];
            return refuse(
                format!("its alpha has {} parts, one of them at ({x:.1}, {y:.1})", apart.len() + 1),
                "join the parts in the image, lay them as stickers of their own, or give the corners of an outline"
                    .into(),
            );
        }
        let mut tolerance = tolerance;
        for _ in 0..HALVINGS {
            let corners = simplified(largest, tolerance);
            if corners.len() > MAX {
                return refuse(
                    format!("its contour has {} corners", corners.len()),
                    format!("use a tolerance above {tolerance} pixels, or give the corners of an outline"),
                );
            }
            // A simplified contour may cross itself where the contour is near to itself.
            if let Ok(sticker) = Self::new(size, corners) {
                return Ok(sticker);
            }
            tolerance *= 0.5;
        }
        Self::new(size, largest.clone())
    }
}

/// Returns the area of a polygon, positive where it runs counter-clockwise.
fn area(corners: &[Vec2]) -> f64 {
    let edges = (0..corners.len()).map(|first| (corners[first], corners[(first + 1) % corners.len()]));
    edges.map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum()
}

/// Returns whether a point lies within a polygon.
fn is_inside(corners: &[Vec2], point: Vec2) -> bool {
    let edges = (0..corners.len()).map(|first| (corners[first], corners[(first + 1) % corners.len()]));
    edges.fold(false, |inside, (a, b)| {
        let is_crossed = (a[1] > point[1]) != (b[1] > point[1])
            && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
        inside != is_crossed
    })
}

/// Returns the contours of an image's alpha, closed, with what is above the level on their left. Alpha is 0 outside of the image
/// and bilinear between the centres of pixels.
fn contours(image: &Image, level: f64) -> Vec<Vec<Vec2>> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    // Samples at the centres of pixels, with one more on each side; rows run upwards.
    let across = width + 2;
    let alpha = |column: usize, row: usize| -> f64 {
        if column == 0 || row == 0 || column > width || row > height {
            return 0.0;
        }
        let pixel = image.pixel(column as u32 - 1, (height - row) as u32);
        pixel.last().map_or(0.0, |alpha| f64::from(*alpha))
    };
    // An edge of the lattice is twice the number of its first sample, and one more if it runs upwards.
    let mut segments: Vec<(u64, u64)> = Vec::new();
    for row in 0..=height {
        for column in 0..=width {
            let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[x, y]| alpha(column + x, row + y));
            let is_above = corners.map(|alpha| alpha > level);
            let first = (row * across + column) as u64;
            let edges = [2 * first, 2 * (first + 1) + 1, 2 * (first + across as u64), 2 * first + 1];
            let is_start = |corner: usize| is_above[corner] && !is_above[(corner + 1) % 4];
            let starts: Vec<usize> = (0..4).filter(|corner| is_start(*corner)).collect();
            // Where opposite corners are above the level, they are joined if the middle is above it.
            let is_joined = corners.iter().sum::<f64>() > 4.0 * level;
            for start in starts.iter().copied() {
                let mut ends = (1..4).map(|step| (start + if is_joined { step } else { 4 - step }) % 4);
                let end = ends.find(|corner| !is_above[*corner] && is_above[(corner + 1) % 4]);
                segments.extend(end.map(|end| (edges[start], edges[end])));
            }
        }
    }
    segments.sort_unstable();
    let place = |edge: u64| -> Vec2 {
        let (sample, is_upward) = ((edge / 2) as usize, edge % 2 == 1);
        let (column, row) = (sample % across, sample / across);
        let ahead = if is_upward { [column, row + 1] } else { [column + 1, row] };
        let (from, to) = (alpha(column, row), alpha(ahead[0], ahead[1]));
        let share = ((level - from) / (to - from)).clamp(0.0, 1.0);
        let at = |from: usize, to: usize, most: usize| {
            (from as f64 - 0.5 + share * (to as f64 - from as f64)).clamp(0.0, most as f64)
        };
        [at(column, ahead[0], width), at(row, ahead[1], height)]
    };
    let mut is_seen = vec![false; segments.len()];
    let mut loops = Vec::new();
    for first in 0..segments.len() {
        let (mut corners, mut at) = (Vec::new(), first);
        while !std::mem::replace(&mut is_seen[at], true) {
            let corner = place(segments[at].0);
            if corners.last() != Some(&corner) {
                corners.push(corner);
            }
            match segments.binary_search_by_key(&segments[at].1, |segment| segment.0) {
                Ok(next) => at = next,
                Err(_) => break,
            }
        }
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        if corners.len() > 2 {
            loops.push(corners);
        }
    }
    loops
}

/// Returns the corners of a closed polygon without corners that are within a tolerance of the edges that remain.
fn simplified(corners: &[Vec2], tolerance: f64) -> Vec<Vec2> {
    let far = |from: usize| {
        let away = |corner: &usize| distance(corners[*corner], corners[from]);
        (0..corners.len()).max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or_default()
    };
    let (a, b) = (far(0), far(far(0)));
    let (first, middle) = (a.min(b), a.max(b));
    let count = corners.len();
    let mut is_kept = vec![false; count];
    is_kept[first] = true;
    is_kept[middle] = true;
    let mut spans = vec![(first, middle), (middle, first + count)];
    while let Some((from, to)) = spans.pop() {
        let ends = [corners[from % count], corners[to % count]];
        let mut farthest = (tolerance, from);
        for corner in from + 1..to {
            let off = from_segment(corners[corner % count], ends);
            if off > farthest.0 {
                farthest = (off, corner);
            }
        }
        if farthest.1 > from {
            is_kept[farthest.1 % count] = true;
            spans.extend([(from, farthest.1), (farthest.1, to)]);
        }
    }
    corners.iter().zip(is_kept).filter(|(_, is_kept)| *is_kept).map(|(corner, _)| *corner).collect()
}

/// Returns the distance of a point from a segment.
fn from_segment(point: Vec2, [a, b]: [Vec2; 2]) -> f64 {
    let (edge, way) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let square = edge[0] * edge[0] + edge[1] * edge[1];
    let share = if square > 0.0 { ((way[0] * edge[0] + way[1] * edge[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (way[0] - share * edge[0]).hypot(way[1] - share * edge[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image whose alpha is that of a shape: 1 inside, 0 outside, linear across a pixel at its border.
    fn image(size: u32, inside: impl Fn(f64, f64) -> f64) -> Image {
        let mut data = Vec::new();
        for row in 0..size {
            for column in 0..size {
                let depth = inside(f64::from(column) + 0.5, f64::from(size - 1 - row) + 0.5);
                data.extend([1.0, 1.0, 1.0, (depth + 0.5).clamp(0.0, 1.0) as f32]);
            }
        }
        Image::from_data(size, size, 4, data).expect("an image")
    }

    #[test]
    fn a_disk_has_an_outline_within_the_tolerance() {
        let disk = image(200, |x, y| 70.0 - (x - 90.0).hypot(y - 110.0));
        let mut counts = Vec::new();
        for tolerance in [0.0, 0.25, 1.0, 4.0] {
            let sticker = Sticker::of_alpha(&disk, &Contour { tolerance, ..Contour::default() }).expect("an outline");
            let corners = sticker.outline.corners();
            counts.push(corners.len());
            for index in 0..corners.len() {
                let (a, b) = (corners[index], corners[(index + 1) % corners.len()]);
                for step in 0..8 {
                    let at: Vec2 =
                        std::array::from_fn(|axis| 200.0 * (a[axis] + f64::from(step) / 8.0 * (b[axis] - a[axis])));
                    let off = ((at[0] - 90.0).hypot(at[1] - 110.0) - 70.0).abs();
                    // Alpha that is clamped bends the contour by less than a tenth of a pixel.
                    assert!(off <= tolerance + 0.1, "{tolerance}: {off}");
                }
            }
        }
        assert!(counts.is_sorted_by(|a, b| a > b) && counts[3] < 30, "{counts:?}");
    }

    #[test]
    fn an_opaque_image_is_its_own_outline_and_holes_stay_inside() {
        let whole = Sticker::of_alpha(&image(20, |_, _| 9.0), &Contour::default()).expect("an outline");
        let area = whole.outline.area();
        // Half a pixel of tolerance along four sides of 20 pixels.
        assert!((area - 1.0).abs() <= 0.1 && whole.outline.corners().len() <= 8, "{area}");
        let ring = image(100, |x, y| 10.0 - ((x - 50.0).hypot(y - 50.0) - 30.0).abs());
        let ring = Sticker::of_alpha(&ring, &Contour::default()).expect("an outline");
        assert!((ring.outline.area() - std::f64::consts::PI * 0.16).abs() < 0.01);
        assert!(ring.covers([0.5, 0.5]));
    }

    #[test]
    fn images_without_one_contour_are_refused() {
        let two = image(100, |x, y| 15.0 - (x - 25.0).hypot(y - 50.0).min((x - 75.0).hypot(y - 50.0)));
        let grey = Image::new(8, 8, 3).expect("an image");
        let cases = [
            (&two, Contour::default(), "2 parts"),
            (&grey, Contour::default(), "no alpha"),
            (&image(8, |_, _| -9.0), Contour::default(), "no alpha is above"),
            (&two, Contour { level: 1.0, tolerance: 1.0 }, "the level is 1"),
            (&two, Contour { level: 0.5, tolerance: f64::NAN }, "tolerance NaN"),
        ];
        for (image, contour, expected) in cases {
            let error = Sticker::of_alpha(image, &contour).expect_err("unusable").to_string();
            assert!(error.contains(expected), "{error} should contain {expected}");
        }
    }
}
