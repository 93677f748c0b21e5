//! How far the surfaces behind two pictures are apart: silhouettes in pixels, depths as shares of the scene's extent,
//! normals as angles.
//!
//! Depths and normals are compared inside: at pixels that both pictures cover with all their neighbours, and where the
//! reference has neither a jump of depth nor an edge. Elsewhere a hundredth of a pixel decides what is seen.

use relievo_core::Result;

use crate::picture::{Picture, angle, check_sizes};

/// A change of depth from a pixel to the next, as a share of the extent, from which there is a silhouette between them.
const JUMP: f64 = 0.01;
/// An angle between the normals of neighbouring pixels, in radians, from which there is an edge between them.
const EDGE: f64 = 20.0 / 180.0 * std::f64::consts::PI;

/// How errors are spread over pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quantiles {
    /// Half of the pixels err less.
    pub median: f64,
    /// 95 of 100 pixels err less.
    pub p95: f64,
    /// 999 of 1000 pixels err less.
    pub p999: f64,
    /// Largest.
    pub max: f64,
}

impl Quantiles {
    /// Quantiles of some errors; zeros without errors.
    fn new(mut errors: Vec<f64>) -> Self {
        errors.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| {
            let index = (share * errors.len() as f64).ceil() as usize;
            errors.get(index.saturating_sub(1)).or(errors.last()).copied().unwrap_or(0.0)
        };
        Self { median: at(0.5), p95: at(0.95), p999: at(0.999), max: at(1.0) }
    }
}

/// Differences of the surfaces behind two pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeometryDifference {
    /// Pixels that the reference covers.
    pub covered: u64,
    /// Pixels that only one of both covers.
    pub alone: u64,
    /// Pixels that are inside.
    pub inside: u64,
    /// What differences of depth are shares of, in units of the depth.
    pub extent: f64,
    /// Differences of depth inside, as shares of the extent, where both pictures have one.
    pub depth: Option<Quantiles>,
    /// Angles between normals inside in radians, where both pictures have some.
    pub normal: Option<Quantiles>,
}

impl GeometryDifference {
    /// The pixels that only one picture covers, as a share of the pixels that the reference covers.
    pub fn silhouette(&self) -> f64 {
        self.alone as f64 / self.covered.max(1) as f64
    }
}

/// Compares what is behind two pictures of the same size. `extent` is the extent of the scene; left out, it is how much
/// the reference's depths differ among themselves, which is less. `None` unless both pictures say which pixels are
/// covered.
///
/// # Errors
/// The sizes differ.
pub fn compare_geometry(
    reference: &Picture,
    test: &Picture,
    extent: Option<f64>,
) -> Result<Option<GeometryDifference>> {
    let [width, height] = check_sizes(reference, test)?.map(|side| side as usize);
    let (Some(ours), Some(theirs)) = (reference.covered(), test.covered()) else { return Ok(None) };
    let covered = ours.iter().filter(|covered| **covered).count() as u64;
    let alone = ours.iter().zip(&theirs).filter(|(ours, theirs)| ours != theirs).count() as u64;
    let depths = reference.depth.as_ref().map(|image| image.data());
    let normals = reference.normal.as_ref().map(|image| image.data());
    let extent = extent.unwrap_or_else(|| {
        let finite = depths.unwrap_or_default().iter().filter(|depth| depth.is_finite());
        let (low, high) = finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), z| (low.min(*z), high.max(*z)));
        f64::from((high - low).max(0.0))
    });
    let normal = |normals: &[f32], at: usize| [normals[3 * at], normals[3 * at + 1], normals[3 * at + 2]];
    let is_inside = |x: usize, y: usize| {
        if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
            return false;
        }
        let here = y * width + x;
        (y - 1..=y + 1).flat_map(|row| (x - 1..=x + 1).map(move |column| row * width + column)).all(|at| {
            let level = depths.is_none_or(|depths| f64::from((depths[at] - depths[here]).abs()) <= JUMP * extent);
            let smooth = || {
                normals.is_none_or(|normals| {
                    angle(&normal(normals, at), &normal(normals, here)).is_none_or(|angle| angle <= EDGE)
                })
            };
            ours[at] && theirs[at] && level && smooth()
        })
    };
    let inside: Vec<usize> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .filter(|(x, y)| is_inside(*x, *y))
        .map(|(x, y)| y * width + x)
        .collect();
    let depth = depths.zip(test.depth.as_ref()).filter(|_| extent > 0.0).map(|(ours, theirs)| {
        let off = |at: &usize| (f64::from(theirs.data()[*at]) - f64::from(ours[*at])).abs() / extent;
        Quantiles::new(inside.iter().map(off).collect())
    });
    let normal = normals.zip(test.normal.as_ref()).map(|(ours, theirs)| {
        // A normal that is missing in the test is as wrong as one can be.
        let off = |at: &usize| angle(&normal(ours, *at), &normal(theirs.data(), *at)).unwrap_or(std::f64::consts::PI);
        Quantiles::new(inside.iter().map(off).collect())
    });
    let inside = inside.len() as u64;
    Ok(Some(GeometryDifference { covered, alone, inside, extent, depth, normal }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    const SIDE: u32 = 256;

    /// A sphere of radius 1 seen along −z from a distance of `distance`, in parallel rays over a square of 2.5, with its
    /// normals turned about x by `turn` radians.
    fn sphere(distance: f32, middle: f32, turn: f32) -> Picture {
        let mut depth = Image::new(SIDE, SIDE, 1).unwrap();
        let mut normal = Image::new(SIDE, SIDE, 3).unwrap();
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            let place = |at: u32| ((at as f32 + 0.5) / SIDE as f32 - 0.5) * 2.5;
            let (a, b) = (place(x) - middle, -place(y));
            let squared = 1.0 - a * a - b * b;
            let at = (y * SIDE + x) as usize;
            if squared < 0.0 {
                depth.data_mut()[at] = f32::INFINITY;
                continue;
            }
            let c = squared.sqrt();
            depth.data_mut()[at] = distance - c;
            let (sin, cos) = turn.sin_cos();
            normal.set_color(x, y, [a, b * cos - c * sin, b * sin + c * cos]);
        }
        let color = Image::new(SIDE, SIDE, 3).unwrap();
        Picture { color, alpha: None, depth: Some(depth), normal: Some(normal) }
    }

    #[test]
    fn equal_surfaces_have_no_difference() {
        let picture = sphere(5.0, 0.0, 0.0);
        let found = compare_geometry(&picture, &picture, None).unwrap().unwrap();
        assert_eq!((found.alone, found.silhouette()), (0, 0.0));
        assert_eq!((found.depth, found.normal), (Some(Quantiles::default()), Some(Quantiles::default())));
        // π/6.25 of the picture, of which the steep half is not inside.
        let expected = std::f64::consts::PI / 6.25 * f64::from(SIDE * SIDE);
        assert!((found.covered as f64 / expected - 1.0).abs() < 0.01, "{found:?}");
        assert!(found.inside < found.covered && found.inside > found.covered / 4, "{found:?}");
        assert!((found.extent - 0.95).abs() < 0.05, "{found:?}");
    }

    #[test]
    fn differences_are_those_that_were_made() {
        let reference = sphere(5.0, 0.0, 0.0);
        let found = compare_geometry(&reference, &sphere(5.01, 0.0, 0.02), Some(2.0)).unwrap().unwrap();
        let (depth, normal) = (found.depth.unwrap(), found.normal.unwrap());
        assert_eq!((found.alone, found.extent), (0, 2.0));
        for value in [depth.median, depth.p95, depth.p999, depth.max] {
            assert!((value - 0.005).abs() < 1e-5, "{depth:?}");
        }
        // The turn is all of the angle where the normal is across the axis.
        assert!((normal.max - 0.02).abs() < 1e-4 && normal.median > 0.015 && normal.p95 <= normal.p999, "{normal:?}");
    }

    #[test]
    fn a_shift_shows_at_the_silhouette_and_not_inside() {
        let reference = sphere(5.0, 0.0, 0.0);
        let pixel = 2.5 / SIDE as f32;
        let moved = sphere(5.0, pixel, 0.0);
        let found = compare_geometry(&reference, &moved, None).unwrap().unwrap();
        // A disc that moves by a pixel loses and wins one in each row that it has.
        let covered = reference.covered().unwrap();
        let rows = covered.chunks(SIDE as usize).filter(|row| row.contains(&true)).count() as u64;
        assert_eq!(found.alone, 2 * rows, "{found:?}");
        let alpha = reference.depth.as_ref().unwrap().data().iter().map(|z| f32::from(u8::from(z.is_finite())));
        let alpha = Image::from_data(SIDE, SIDE, 1, alpha.collect()).unwrap();
        let flat = Picture { alpha: Some(alpha), depth: None, normal: None, ..reference.clone() };
        let found = compare_geometry(&flat, &moved, None).unwrap().unwrap();
        assert_eq!((found.alone, found.depth, found.normal), (2 * rows, None, None));
        let unknown = Picture { alpha: None, ..flat };
        assert_eq!(compare_geometry(&unknown, &moved, None).unwrap(), None);
    }

    #[test]
    fn steps_of_depth_and_edges_are_not_inside() {
        let plane = |step: f32, bend: bool| {
            let at = |x: u32| if x < SIDE / 2 { 1.0 } else { 1.0 + step };
            let side = |x: u32| if bend && x < SIDE / 2 { [0.6, 0.0, 0.8] } else { [0.0, 0.0, 1.0] };
            let columns = || (0..SIDE).flat_map(|_| 0..SIDE);
            let depth = Image::from_data(SIDE, SIDE, 1, columns().map(at).collect()).unwrap();
            let normal = Image::from_data(SIDE, SIDE, 3, columns().flat_map(side).collect()).unwrap();
            let color = Image::new(SIDE, SIDE, 3).unwrap();
            Picture { color, alpha: None, depth: Some(depth), normal: Some(normal) }
        };
        let inside = |picture: &Picture| compare_geometry(picture, picture, Some(1.0)).unwrap().unwrap().inside;
        let side = u64::from(SIDE - 2);
        let (all, without) = (side * side, side * (side - 2));
        assert_eq!(inside(&plane(0.0, false)), all);
        assert_eq!(inside(&plane(0.009, false)), all);
        assert_eq!(inside(&plane(0.02, false)), without);
        assert_eq!(inside(&plane(0.0, true)), without);
    }
}
