//! Accumulation: how the vectors that one pixel takes become the feature vector of that pixel (Section 4.1).

use relievo_core::{Error, Result, error::nearest};

/// A way to accumulate vectors. Vectors of weight 0 do not count in any of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Accumulation {
    /// The average, weighted.
    #[default]
    Average,
    /// The sum of each feature times its weight.
    Sum,
    /// The smallest value of each feature.
    Min,
    /// The largest value of each feature.
    Max,
    /// The first vector.
    First,
    /// The last vector.
    Last,
}

impl Accumulation {
    /// Every way with its name in annotations.
    pub const ALL: [(Self, &str); 6] = [
        (Self::Average, "average"),
        (Self::Sum, "sum"),
        (Self::Min, "min"),
        (Self::Max, "max"),
        (Self::First, "first"),
        (Self::Last, "last"),
    ];

    /// Returns its name.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// Finds a way by its name; `weighted average` is `average`.
    ///
    /// # Errors
    /// Fails if there is no accumulation of the name; the error advises the nearest one.
    pub fn by_name(name: &str) -> Result<Self> {
        let name = if name == "weighted average" { "average" } else { name };
        let found = Self::ALL.iter().find(|(_, other)| *other == name);
        found.map(|(accumulation, _)| *accumulation).ok_or_else(|| {
            let advice = match nearest(name, Self::ALL.map(|(_, name)| name)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "use average, sum, min, max, first or last".to_owned(),
            };
            Error::invalid(format!("`{name}` is no accumulation")).advise(advice)
        })
    }

    /// Accumulates vectors and their weights to the vector of a pixel, as the augmented shader does on a device, in f32.
    ///
    /// `vectors` has `features` numbers a vector.
    ///
    /// # Errors
    /// Fails if no vector has a weight other than 0, the weights of an average sum to 0, or the vector is not finite.
    pub fn of(self, features: usize, weights: &[f32], vectors: &[f32]) -> Result<Vec<f32>> {
        let mut sums = vec![0.0_f32; features];
        let mut total = 0.0_f32;
        let mut taken = 0_u32;
        for (weight, vector) in weights.iter().zip(vectors.chunks_exact(features.max(1))) {
            if *weight == 0.0 {
                continue;
            }
            self.add(&mut sums, taken, *weight, vector);
            total += weight;
            taken += 1;
        }
        self.finish(taken, total, sums)
    }

    /// Adds a vector, or with weight 1 the sums of several, to the sums of `taken` vectors before it.
    pub(crate) fn add(self, sums: &mut [f32], taken: u32, weight: f32, vector: &[f32]) {
        for (sum, value) in sums.iter_mut().zip(vector) {
            *sum = match self {
                Self::Average | Self::Sum => *sum + weight * value,
                Self::Min if taken > 0 => sum.min(*value),
                Self::Max if taken > 0 => sum.max(*value),
                Self::First if taken > 0 => *sum,
                Self::Min | Self::Max | Self::First | Self::Last => *value,
            };
        }
    }

    /// Makes the vector of a pixel of the sums that a device logged. Fails as [`Accumulation::of`] does.
    pub(crate) fn finish(self, taken: u32, total: f32, mut sums: Vec<f32>) -> Result<Vec<f32>> {
        if taken == 0 {
            return Err(Error::invalid("the shader takes no vector of a weight other than 0 there")
                .advise("choose a pixel where the code of the annotation runs"));
        }
        if self == Self::Average {
            if total == 0.0 {
                return Err(Error::invalid("the weights of the vectors sum to 0 there")
                    .advise("use another accumulation, or weights that are positive"));
            }
            sums.iter_mut().for_each(|sum| *sum /= total);
        }
        match sums.iter().position(|sum| !sum.is_finite()) {
            None => Ok(sums),
            Some(index) => Err(Error::invalid(format!("feature {index} of the vector is not finite"))
                .advise("choose another pixel, or bound the expression of the annotation")),
        }
    }
}
