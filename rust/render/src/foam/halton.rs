//! Samples in the unit ball by Halton's sequence (Halton 1964), as Akinci et al. 2013, Section 2.4.1, take them.

use glam::Vec3;

/// A place in the unit ball.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    pub place: Vec3,
    /// The contribution λ = (1 − |s|)².
    pub weight: f32,
}

/// Samples in the unit ball: those of a cube that lie within it.
#[derive(Clone, Debug)]
pub struct Ball {
    samples: Vec<Sample>,
    /// How many of the first samples of the cube lie within the ball.
    counts: Vec<u32>,
}

impl Ball {
    /// Makes those of `most` samples in the cube.
    pub fn new(most: u32) -> Self {
        let (mut samples, mut counts) = (Vec::new(), vec![0]);
        for index in 1..=most {
            let place = Vec3::from([2, 3, 5].map(|base| 2.0 * radical_inverse(index, base) - 1.0));
            let length = place.length();
            if length <= 1.0 {
                samples.push(Sample { place, weight: (1.0 - length).powi(2) });
            }
            counts.push(samples.len() as u32);
        }
        Self { samples, counts }
    }

    /// Returns all samples.
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// Returns how many of the first samples of the cube, from none to all, lie within the ball.
    pub fn counts(&self) -> &[u32] {
        &self.counts
    }

    /// Returns how many of the first `count` samples of the cube lie within the ball.
    pub fn count(&self, count: u32) -> usize {
        self.counts[(count as usize).min(self.counts.len() - 1)] as usize
    }

    /// Returns those of the first `count` samples of the cube.
    pub fn of(&self, count: u32) -> &[Sample] {
        &self.samples[..self.count(count)]
    }

    /// Returns the coordinates and the weights of all samples as columns, which are filled with zeros to a multiple of
    /// `lanes`.
    pub fn columns(&self, lanes: usize) -> [Vec<f32>; 4] {
        let length = self.samples.len().next_multiple_of(lanes);
        let column = |of: fn(&Sample) -> f32| {
            let mut column: Vec<f32> = self.samples.iter().map(of).collect();
            column.resize(length, 0.0);
            column
        };
        [column(|it| it.place.x), column(|it| it.place.y), column(|it| it.place.z), column(|it| it.weight)]
    }
}

/// Returns the digits of an index mirrored at the point, 0 to below 1.
fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= f64::from(base);
        value += digit * f64::from(index % base);
        index /= base;
    }
    value as f32
}
