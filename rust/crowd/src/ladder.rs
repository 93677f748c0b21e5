//! Cuts of equal error for a whole model, from the finest to the coarsest, made once.

use crate::hierarchy::CrowdModel;

/// Ratio of the errors of neighbouring steps at least.
const RATIO: f32 = 1.05;

/// The cuts of a model by error.
#[derive(Clone, Debug, Default)]
pub struct Ladder {
    /// The error of every step, increasing from 0.
    errors: Vec<f32>,
    /// Where the clusters of each step begin, and their end.
    starts: Vec<u32>,
    clusters: Vec<u32>,
    triangles: Vec<u64>,
}

impl Ladder {
    /// Makes the cuts of a model.
    pub fn new(model: &CrowdModel) -> Self {
        let mut all: Vec<f32> = model.groups.iter().map(|group| group.error).collect();
        all.sort_unstable_by(f32::total_cmp);
        let coarsest = all.last().copied().unwrap_or_default();
        let mut errors = vec![0.0];
        for error in all {
            if error > errors.last().copied().unwrap_or_default() * RATIO {
                errors.push(error);
            }
        }
        if errors.last().is_some_and(|last| *last < coarsest) {
            errors.push(coarsest);
        }
        let mut made = Self { errors, starts: vec![0], ..Self::default() };
        for error in &made.errors {
            let cut = model.cut(*error);
            made.triangles.push(model.triangle_count(&cut));
            made.clusters.extend(cut);
            made.starts.push(made.clusters.len() as u32);
        }
        made
    }

    /// Returns the number of steps.
    pub fn len(&self) -> usize {
        self.errors.len()
    }

    /// Whether there are no steps; only of a default ladder.
    pub fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// Returns the coarsest step whose error is at most `allowed`. The search begins at `guess`, a step or not.
    pub fn step(&self, allowed: f32, guess: u32) -> u32 {
        let at = guess as usize;
        if let Some(error) = self.errors.get(at)
            && *error <= allowed
            && self.errors.get(at + 1).is_none_or(|next| *next > allowed)
        {
            return guess;
        }
        (self.errors.partition_point(|error| *error <= allowed).max(1) - 1) as u32
    }

    /// Returns the error of a step, in units of the model.
    pub fn error(&self, step: u32) -> f32 {
        self.errors.get(step as usize).copied().unwrap_or_default()
    }

    /// Returns the clusters of a step.
    pub fn clusters(&self, step: u32) -> &[u32] {
        let at = step as usize;
        match (self.starts.get(at), self.starts.get(at + 1)) {
            (Some(from), Some(to)) => &self.clusters[*from as usize..*to as usize],
            _ => &[],
        }
    }

    /// Returns the number of triangles of a step.
    pub fn triangles(&self, step: u32) -> u64 {
        self.triangles.get(step as usize).copied().unwrap_or_default()
    }
}
