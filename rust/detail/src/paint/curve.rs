//! A pressure curve: how much the size, strength or angle of a brush is for how hard the pen presses.
//!
//! Straight between its points, level before the first and after the last. Without points it is the pressure itself.
//! All numbers are 0 to 1.

use relievo_core::{Error, Result};

/// Points (pressure, value) with ascending pressure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    points: Vec<[f64; 2]>,
}

/// Most points of a curve.
const MAX: usize = 256;

impl Curve {
    /// A curve through `points`; none make the one that returns the pressure as it is.
    ///
    /// # Errors
    /// Fails with `Invalid` if a number is not within 0 to 1, the pressure does not ascend from point to point, or
    /// there are over 256 points.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self> {
        let fault = |index: usize, what: String, remedy: &str| {
            Err(Error::invalid(what).at(format!("point {index} of a pressure curve")).advise(remedy))
        };
        if points.len() > MAX {
            return fault(MAX, format!("it has {} points", points.len()), "use at most 256");
        }
        for (index, point) in points.iter().enumerate() {
            if let Some(value) = point.iter().find(|value| !(0.0..=1.0).contains(*value)) {
                return fault(index, format!("it has the number {value}"), "use 0 to 1");
            }
            if index > 0 && point[0] <= points[index - 1][0] {
                return fault(
                    index,
                    format!("the pressure {} does not ascend", point[0]),
                    "sort the points by pressure",
                );
            }
        }
        Ok(Self { points })
    }

    /// The points.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// The value at a pressure.
    pub fn at(&self, pressure: f64) -> f64 {
        let next = self.points.partition_point(|point| point[0] <= pressure);
        match (next.checked_sub(1).and_then(|before| self.points.get(before)), self.points.get(next)) {
            (None, None) => pressure,
            (Some(only), None) | (None, Some(only)) => only[1],
            (Some(a), Some(b)) => a[1] + (b[1] - a[1]) * (pressure - a[0]) / (b[0] - a[0]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_go_through_their_points_and_are_level_beyond() {
        let curve = Curve::new(vec![[0.2, 0.5], [0.4, 1.0], [1.0, 0.0]]).unwrap();
        for (pressure, value) in [(0.0, 0.5), (0.2, 0.5), (0.3, 0.75), (0.4, 1.0), (0.7, 0.5), (1.0, 0.0)] {
            assert!((curve.at(pressure) - value).abs() < 1e-12, "{pressure}");
        }
        assert_eq!(Curve::default().at(0.3), 0.3);
        assert_eq!(Curve::new(vec![[0.5, 0.25]]).unwrap().at(0.9), 0.25);
    }

    #[test]
    fn curves_that_go_back_or_out_of_range_are_refused() {
        for points in [
            vec![[0.2, 0.0], [0.2, 1.0]],
            vec![[0.5, 0.0], [0.2, 1.0]],
            vec![[f64::NAN, 0.0]],
            vec![[0.0, 1.5]],
            vec![[-0.1, 0.5]],
            (0..257).map(|k| [f64::from(k) / 256.0, 0.0]).collect(),
        ] {
            assert!(Curve::new(points).is_err());
        }
    }
}
