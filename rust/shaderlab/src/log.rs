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

impl Log {
    /// Reads the words of a log whose vectors have `features` numbers.
    ///
    /// Fails if there are fewer words than the accumulated features need, if the pixel took no vector of a weight other than
    /// 0, if the weights of an average sum to 0, or if the vector is not finite.
    pub fn of(words: &[u32], features: usize, accumulation: Accumulation) -> Result<Self> {
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
        let vector = accumulation.finish(head[0], f32::from_bits(head[2]), sums)?;
        Ok(Self { vector, taken, weights, vectors })
    }
}
