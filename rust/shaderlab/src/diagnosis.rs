//! Diagnosis of classes: whether the features separate them, which features say the same, which one to leave out, and why a
//! pixel has its degree of membership.

use crate::classes::{Class, Classes};

/// Correlation from which on two features count as saying the same.
const CORRELATED: f64 = 0.95;

/// A pair of features that say nearly the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correlation {
    /// The indices of the features.
    pub features: [usize; 2],
    /// Pearson's coefficient over the vectors, -1 to 1.
    pub coefficient: f64,
}

/// What a set of features is worth for classes.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// The share of examples that the other examples put into the wrong class, 0 to 1; half an example for a degree of exactly
    /// 0.5. `None` unless both classes have two examples, since an example left out needs another one of its class.
    pub error: Option<f64>,
    /// The same share with each feature left out; empty for one feature, and without an error.
    pub errors_without: Vec<f64>,
    /// Pairs of features whose coefficient is 0.95 or more in size.
    pub correlations: Vec<Correlation>,
    /// The feature that can be left out: one without which the error is not larger, first of the features that
    /// correlate with another.
    pub redundant: Option<usize>,
}

impl Diagnosis {
    /// Diagnoses classes. Correlations are taken over the vectors of the examples and `context`, vectors of other pixels.
    pub fn of(classes: &Classes, context: &[Vec<f32>]) -> Self {
        let count = classes.features.len();
        let has_two = |class| classes.examples.iter().filter(|example| example.class == class).count() >= 2;
        let error = (has_two(Class::Positive) && has_two(Class::Negative)).then(|| leave_one_out(classes));
        let errors_without: Vec<_> = match (error, count) {
            (None, _) | (_, 0 | 1) => Vec::new(),
            _ => (0..count).map(|feature| leave_one_out(&without(classes, feature))).collect(),
        };
        let vectors: Vec<&[f32]> = classes
            .examples
            .iter()
            .map(|example| example.vector.as_slice())
            .chain(context.iter().map(Vec::as_slice))
            .filter(|vector| vector.len() == count)
            .collect();
        let mut correlations = Vec::new();
        for first in 0..count {
            for second in first + 1..count {
                if let Some(coefficient) = correlation(&vectors, first, second).filter(|it| it.abs() >= CORRELATED) {
                    correlations.push(Correlation { features: [first, second], coefficient });
                }
            }
        }
        let is_correlated = |feature: usize| correlations.iter().any(|pair| pair.features.contains(&feature));
        let candidates =
            (0..errors_without.len()).filter(|feature| error.is_some_and(|error| errors_without[*feature] <= error));
        // Later features are left out first: authors name the important ones first.
        let redundant = candidates.min_by(|a, b| {
            let rank = |feature: usize| (!is_correlated(feature), errors_without[feature]);
            let ((a_apart, a_error), (b_apart, b_error)) = (rank(*a), rank(*b));
            a_apart.cmp(&b_apart).then(a_error.total_cmp(&b_error)).then(b.cmp(a))
        });
        Self { error, errors_without, correlations, redundant }
    }
}

/// Returns the share of examples that the other examples put into the wrong class.
fn leave_one_out(classes: &Classes) -> f64 {
    let wrong = classes.examples.iter().enumerate().map(|(index, example)| {
        let degree = classes.membership_without(&example.vector, |other| other == index);
        match (example.class, degree) {
            (_, 0.5) => 0.5,
            (Class::Positive, degree) => f64::from(u8::from(degree < 0.5)),
            (Class::Negative, degree) => f64::from(u8::from(degree > 0.5)),
        }
    });
    wrong.sum::<f64>() / classes.examples.len().max(1) as f64
}

/// Returns classes without one of their features.
fn without(classes: &Classes, feature: usize) -> Classes {
    let mut fewer = classes.clone();
    fewer.features.remove(feature);
    for example in &mut fewer.examples {
        if feature < example.vector.len() {
            example.vector.remove(feature);
        }
    }
    fewer
}

/// Returns Pearson's coefficient of two features, or `None` where one of them does not vary.
fn correlation(vectors: &[&[f32]], first: usize, second: usize) -> Option<f64> {
    let count = vectors.len() as f64;
    let mean = |feature: usize| vectors.iter().map(|vector| f64::from(vector[feature])).sum::<f64>() / count;
    let means = [mean(first), mean(second)];
    let mut sums = [0.0_f64; 3];
    for vector in vectors {
        let [x, y] = [f64::from(vector[first]) - means[0], f64::from(vector[second]) - means[1]];
        sums = [sums[0] + x * x, sums[1] + y * y, sums[2] + x * y];
    }
    let coefficient = sums[2] / (sums[0].sqrt() * sums[1].sqrt());
    (vectors.len() > 2 && coefficient.is_finite()).then_some(coefficient)
}

/// An example that decides about a vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighbour {
    /// The index of the example.
    pub example: usize,
    /// The distance, with the factors of the features.
    pub distance: f64,
    /// Its share of all weights, 0 to 1.
    pub share: f64,
}

/// Why a vector has its degree of membership.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// The degree, 0 to 1.
    pub membership: f32,
    /// All examples, the nearest first.
    pub neighbours: Vec<Neighbour>,
    /// The feature in which the vector is nearer to the nearest example than to the nearest one of the other class, by the
    /// largest difference of squares; `None` with one class alone.
    pub deciding: Option<usize>,
}

impl Explanation {
    /// Explains the degree of a vector. A vector without examples has no neighbours.
    pub fn of(classes: &Classes, vector: &[f32]) -> Self {
        let factors = classes.factors();
        let square = |example: usize, feature: usize| {
            let other = classes.examples[example].vector.get(feature).copied().unwrap_or_default();
            let factor = factors.get(feature).copied().unwrap_or(1.0);
            ((f64::from(vector[feature]) - f64::from(other)) * f64::from(factor)).powi(2)
        };
        let distance = |example: usize| (0..vector.len()).map(|feature| square(example, feature)).sum::<f64>().sqrt();
        let mut neighbours: Vec<_> = (0..classes.examples.len())
            .map(|example| Neighbour { example, distance: distance(example), share: 0.0 })
            .collect();
        neighbours.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let nearest = neighbours.first().map_or(0.0, |neighbour| neighbour.distance);
        let mut total = 0.0;
        for neighbour in &mut neighbours {
            let ratio = if neighbour.distance == nearest { 1.0 } else { nearest / neighbour.distance };
            neighbour.share = ratio.powf(f64::from(classes.exponent));
            total += neighbour.share;
        }
        neighbours.iter_mut().for_each(|neighbour| neighbour.share /= total);
        let class = |neighbour: &Neighbour| classes.examples[neighbour.example].class;
        let first = neighbours.first();
        let rival = first.and_then(|first| neighbours.iter().find(|other| class(other) != class(first)));
        let deciding = first.zip(rival).and_then(|(first, rival)| {
            let gain = |feature: usize| square(rival.example, feature) - square(first.example, feature);
            (0..vector.len()).max_by(|a, b| gain(*a).total_cmp(&gain(*b)))
        });
        Self { membership: classes.membership(vector), neighbours, deciding }
    }
}
