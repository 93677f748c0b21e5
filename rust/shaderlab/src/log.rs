//! The log of a classified pixel: the vectors that it took, read from the words that an augmented shader wrote
//! (see [`crate::instrument`]).

use relievo_core::{Error, Result};

use crate::accumulation::Accumulation;
use crate::instrument::LOG_HEAD;

/// What a pixel logged.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// The feature vector of the pixel.
    pub vector: Vec<f32>,
    /// How many vectors the pixel took.
    pub taken: u32,
    /// The weights of the vectors that fitted into the log.
    pub weights: Vec<f32>,
    /// These vectors, one after the other.
    pub vectors: Vec<f32>,
}

/// What one invocation logged.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Part {
    /// Vectors with a weight other than 0.
    pub weighted: u32,
    /// All vectors.
    pub taken: u32,
    /// The sum of weights.
    pub total: f32,
    /// The accumulated features.
    pub sums: Vec<f32>,
    /// Weights of the vectors that fitted.
    pub weights: Vec<f32>,
    /// These vectors.
    pub vectors: Vec<f32>,
}

impl Part {
    /// Reads the words of a log. Fails if there are fewer than the accumulated features need.
    pub fn of(words: &[u32], features: usize) -> Result<Self> {
        let first = LOG_HEAD + features;
        let Some((head, records)) = words.split_at_checked(first) else {
            return Err(Error::invalid(format!("the log has {} words", words.len()))
                .advise(format!("read {first} words at least")));
        };
        let sums = head[LOG_HEAD..].iter().map(|word| f32::from_bits(*word)).collect();
        let taken = head[1];
        let (mut weights, mut vectors) = (Vec::new(), Vec::new());
        for record in records.chunks_exact(features + 1).take(taken as usize) {
            weights.push(f32::from_bits(record[0]));
            vectors.extend(record[1..].iter().map(|word| f32::from_bits(*word)));
        }
        Ok(Self { weighted: head[0], taken, total: f32::from_bits(head[2]), sums, weights, vectors })
    }
}

impl Log {
    /// Reads the words of a log whose vectors have `features` numbers.
    ///
    /// # Errors
    /// Fails if there are fewer words than the accumulated features need, if the pixel took no vector of a weight other
    /// than 0, if the weights of an average sum to 0, or if the vector is not finite.
    pub fn of(words: &[u32], features: usize, accumulation: Accumulation) -> Result<Self> {
        Self::join(vec![(Part::of(words, features)?, 1.0)], features, accumulation)
    }

    /// Joins what several invocations logged, in their order. The share of each multiplies its weights. Fails as
    /// [`Log::of`] does.
    pub(crate) fn join(parts: Vec<(Part, f32)>, features: usize, accumulation: Accumulation) -> Result<Self> {
        let mut whole = Part { sums: vec![0.0; features], ..Part::default() };
        for (part, share) in parts {
            whole.taken = whole.taken.saturating_add(part.taken);
            whole.weights.extend(part.weights.iter().map(|weight| share * weight));
            whole.vectors.extend(part.vectors);
            if part.weighted > 0 && share > 0.0 {
                accumulation.add(&mut whole.sums, whole.weighted, share, &part.sums);
                whole.total += share * part.total;
                whole.weighted = whole.weighted.saturating_add(part.weighted);
            }
        }
        let vector = accumulation.finish(whole.weighted, whole.total, whole.sums)?;
        Ok(Self { vector, taken: whole.taken, weights: whole.weights, vectors: whole.vectors })
    }
}
