//! Classified pixels with their feature vectors, and their file: JSON.

use std::io::Write;
use std::path::Path;

use relievo_core::{Error, Result};
use serde::{Deserialize, Serialize};

use crate::augment::Augmented;
use crate::instrument::EXAMPLES_HEAD;
use crate::membership::membership;

/// Examples that a shader may have. Each pixel compares its vectors with all of them.
pub const MAX_EXAMPLES: usize = 4096;

/// Bytes that a file of classes may have.
const MAX_BYTES: u64 = 64 << 20;

/// The exponent of the membership where none is chosen.
pub const EXPONENT: f32 = 2.0;

/// The class of an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// What is sought.
    Positive,
    /// What is not.
    Negative,
}

impl Class {
    /// Returns 1 for the positive class and 0 for the negative one (Equation 1).
    pub fn value(self) -> f32 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => 0.0,
        }
    }
}

/// What an augmented shader does (Section 4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// It makes its picture.
    Render,
    /// It also logs the vectors of the pixel at a column and row.
    Classify([u32; 2]),
    /// It also writes the membership of each pixel of a picture of these columns and rows.
    Mask([u32; 2]),
    /// A vertex shader logs the vectors of a vertex of an instance.
    ClassifyVertex([u32; 2]),
    /// A vertex shader lists position and accumulated vector of so many vertices of so many instances.
    Vertices([u32; 2]),
}

/// A classified pixel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Example {
    /// Column and row, from the upper left corner.
    pub pixel: [u32; 2],
    /// Its class.
    pub class: Class,
    /// Its feature vector.
    pub vector: Vec<f32>,
}

/// Examples and how vectors are compared with them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Classes {
    /// The version of the file, 1.
    version: u32,
    /// The features of all vectors.
    pub features: Vec<String>,
    /// The exponent p of Equation 2: the larger, the harder the border between the classes.
    pub exponent: f32,
    /// Whether features are divided by the range that they have over the examples.
    pub is_scaled: bool,
    /// The examples.
    pub examples: Vec<Example>,
}

impl Classes {
    /// Makes classes without examples for vectors of these features.
    pub fn new(features: Vec<String>) -> Self {
        Self { version: 1, features, exponent: EXPONENT, is_scaled: false, examples: Vec::new() }
    }

    /// Makes classes without examples for the vectors of an augmented shader.
    pub fn of(augmented: &Augmented) -> Self {
        Self::new(augmented.features.iter().map(|feature| feature.expression.clone()).collect())
    }

    /// Checks the classes.
    ///
    /// # Errors
    /// Fails if the version is another one, a vector has another length than the features or a number that is not
    /// finite, the exponent is not in 0.01 to 64, or there are more than [`MAX_EXAMPLES`] examples.
    pub fn check(&self) -> Result<()> {
        if self.version != 1 {
            return Err(Error::unsupported(format!("the classes have version {}", self.version))
                .advise("read them with a newer Relievo"));
        }
        if !(0.01..=64.0).contains(&self.exponent) {
            return Err(
                Error::invalid(format!("the exponent {} is out of range", self.exponent)).advise("use 0.01 to 64")
            );
        }
        if self.examples.len() > MAX_EXAMPLES {
            return Err(Error::invalid(format!("there are {} examples", self.examples.len()))
                .advise(format!("use at most {MAX_EXAMPLES}")));
        }
        for (index, Example { vector, .. }) in self.examples.iter().enumerate() {
            let place = || format!("example {index}");
            if vector.len() != self.features.len() {
                let what = format!("the vector has {} features, not {}", vector.len(), self.features.len());
                return Err(Error::invalid(what).at(place()).advise("classify its pixel again"));
            }
            if !vector.iter().all(|value| value.is_finite()) {
                return Err(Error::invalid("the vector is not finite").at(place()).advise("classify another pixel"));
            }
        }
        Ok(())
    }

    /// Returns what differences of each feature are multiplied by: 1, or with scaling the inverse of the range that the feature
    /// has over the examples, where that is not 0.
    pub fn factors(&self) -> Vec<f32> {
        let factor = |feature: usize| {
            let values = || self.examples.iter().filter_map(|example| example.vector.get(feature)).copied();
            let range = values().fold(f32::NEG_INFINITY, f32::max) - values().fold(f32::INFINITY, f32::min);
            let inverse = 1.0 / range;
            if self.is_scaled && range > 0.0 && inverse.is_finite() { inverse } else { 1.0 }
        };
        (0..self.features.len()).map(factor).collect()
    }

    /// Returns the degree to which a vector belongs to the positive class, without the examples that `leave` names.
    pub fn membership_without(&self, vector: &[f32], leave: impl Fn(usize) -> bool) -> f32 {
        let examples = self.examples.iter().enumerate().filter(|(index, _)| !leave(*index));
        let examples = examples.map(|(_, example)| (example.class.value(), example.vector.as_slice()));
        membership(vector, examples, &self.factors(), self.exponent)
    }

    /// Returns the degree to which a vector belongs to the positive class.
    pub fn membership(&self, vector: &[f32]) -> f32 {
        self.membership_without(vector, |_| false)
    }

    /// Returns the words of the buffer of examples (see [`crate::instrument`]) for a mode.
    pub fn words(&self, mode: Mode) -> Vec<u32> {
        let (number, [x, y]) = match mode {
            Mode::Render => (0, [0, 0]),
            Mode::Classify(pixel) => (1, pixel),
            Mode::Mask(size) => (2, size),
            Mode::ClassifyVertex(vertex) => (3, vertex),
            Mode::Vertices(count) => (4, count),
        };
        let count = self.examples.len() as u32;
        let mut words = Vec::with_capacity(EXAMPLES_HEAD + (self.features.len() + 1) * (self.examples.len() + 1));
        words.extend([number, x, y, count, self.exponent.to_bits()]);
        words.extend(self.factors().into_iter().map(f32::to_bits));
        for example in &self.examples {
            words.push(example.class.value().to_bits());
            words.extend(example.vector.iter().map(|value| value.to_bits()));
        }
        words
    }

    /// Returns the text of their file.
    ///
    /// # Errors
    /// Fails as [`Classes::check`] does.
    pub fn to_json(&self) -> Result<String> {
        self.check()?;
        serde_json::to_string_pretty(self).map_err(|error| Error::internal(error.to_string()))
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// Fails if the text is no classes, or as [`Classes::check`] does.
    pub fn from_json(text: &str) -> Result<Self> {
        let classes: Self = serde_json::from_str(text).map_err(|error| {
            Error::invalid(format!("the classes cannot be read: {error}"))
                .advise("write them by `relievo shader classify`")
        })?;
        classes.check()?;
        Ok(classes)
    }

    /// Writes the file, which appears whole or not at all.
    ///
    /// # Errors
    /// Fails as [`Classes::check`] does, and if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = self.to_json()?;
        relievo_core::file::store(path, |file| writeln!(file, "{text}"))
    }

    /// Reads a file.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is larger than 64 MiB or no UTF-8, or as [`Classes::from_json`] does.
    pub fn read(path: &Path) -> Result<Self> {
        let place = path.display().to_string();
        let bytes = relievo_core::file::load(path, MAX_BYTES)?;
        let text = String::from_utf8(bytes).map_err(|_| Error::invalid("the file is no UTF-8").at(&*place))?;
        Self::from_json(&text).map_err(|error| error.at(place))
    }
}
