//! Transfer functions made of classes: the membership over two features, as an image and as a function of a shader.

use std::fmt::Write;

use relievo_core::{Error, Result};
use relievo_render::Image;

use crate::classes::Classes;
use crate::source::Language;

/// The membership as a function of two features; further features have the mean that they have over the examples.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    classes: Classes,
    axes: [usize; 2],
    ranges: [[f32; 2]; 2],
}

/// Share of the range of a feature by which a transfer function reaches beyond the examples on each side.
const MARGIN: f32 = 0.25;

impl Transfer {
    /// Makes a transfer function over the features `axes`.
    ///
    /// Without `ranges` it covers the examples and a quarter of their range on each side.
    ///
    /// # Errors
    /// Fails if the classes are not usable ([`Classes::check`]), if there is no example, if a feature does not exist or
    /// is named twice, or if a range is empty or not finite.
    pub fn new(classes: &Classes, axes: [usize; 2], ranges: Option<[[f32; 2]; 2]>) -> Result<Self> {
        classes.check()?;
        let count = classes.features.len();
        if axes.iter().any(|axis| *axis >= count) || (axes[0] == axes[1] && count > 1) {
            let what = format!("features {} and {} of {count} span no plane", axes[0], axes[1]);
            return Err(Error::invalid(what).advise("name two different features"));
        }
        if classes.examples.is_empty() {
            return Err(Error::invalid("there is no example").advise("classify pixels first"));
        }
        let covered = |axis: usize| {
            let values = || classes.examples.iter().map(|example| example.vector[axis]);
            let (low, high) = (values().fold(f32::INFINITY, f32::min), values().fold(f32::NEG_INFINITY, f32::max));
            let margin = if high > low { MARGIN * (high - low) } else { 0.5 };
            [low - margin, high + margin]
        };
        let ranges = ranges.unwrap_or_else(|| axes.map(covered));
        if ranges.iter().any(|[low, high]| !(low < high && (high - low).is_finite())) {
            return Err(Error::invalid("a range of the transfer function is empty or not finite")
                .advise("state a lower and a higher number"));
        }
        Ok(Self { classes: classes.clone(), axes, ranges })
    }

    /// Returns the two ranges.
    pub fn ranges(&self) -> [[f32; 2]; 2] {
        self.ranges
    }

    /// Returns a vector whose features are the means over the examples.
    fn means(&self) -> Vec<f32> {
        let count = self.classes.examples.len() as f64;
        let mean = |feature: usize| {
            let sum: f64 = self.classes.examples.iter().map(|example| f64::from(example.vector[feature])).sum();
            (sum / count) as f32
        };
        (0..self.classes.features.len()).map(mean).collect()
    }

    /// Returns an image of one channel: the first feature grows to the right, the second one upwards.
    ///
    /// # Errors
    /// Fails if the image has no pixels or more than an image can have.
    pub fn image(&self, width: u32, height: u32) -> Result<Image> {
        let mut image = Image::new(width, height, 1)?;
        let mut vector = self.means();
        let at = |axis: usize, index: u32, count: u32| {
            let [low, high] = self.ranges[axis];
            low + (high - low) * (index as f32 + 0.5) / count as f32
        };
        for (index, value) in image.data_mut().iter_mut().enumerate() {
            let (x, y) = (index as u32 % width, index as u32 / width);
            vector[self.axes[1]] = at(1, height - 1 - y, height);
            vector[self.axes[0]] = at(0, x, width);
            *value = self.classes.membership(&vector);
        }
        Ok(image)
    }

    /// Returns a function `name` of a shader that takes all features in order and returns the membership.
    ///
    /// # Errors
    /// Fails if `name` is no name of the shading languages.
    pub fn function(&self, language: Language, name: &str) -> Result<String> {
        membership_function(&self.classes, language, name)
    }
}

/// Returns a function `name` of a shader that takes all features of classes in order and returns the membership, 0 to 1.
///
/// # Errors
/// Fails if `name` is no name of the shading languages, or if the classes cannot be used.
pub fn membership_function(classes: &Classes, language: Language, name: &str) -> Result<String> {
    classes.check()?;
    let is_part = |it: char| it.is_ascii_alphanumeric() || it == '_';
    if !name.chars().all(is_part) || !name.starts_with(|it: char| it.is_ascii_alphabetic()) || name.contains("__") {
        return Err(
            Error::invalid(format!("`{name}` is no name of a function")).advise("use letters, digits and single _")
        );
    }
    let mut out = String::new();
    let count = classes.features.len();
    let number = |value: f32| format!("{value:?}");
    let _ = writeln!(out, "// The membership of these features in the positive class, 0 to 1:");
    for (index, feature) in classes.features.iter().enumerate() {
        let _ = writeln!(out, "// f{index}: {}", feature.split_whitespace().collect::<Vec<_>>().join(" "));
    }
    let is_wgsl = language == Language::Wgsl;
    let parameters: Vec<_> =
        (0..count).map(|at| if is_wgsl { format!("f{at}: f32") } else { format!("float f{at}") }).collect();
    let parameters = parameters.join(", ");
    let (float, arrow) = if is_wgsl { ("var", "fn ") } else { ("float", "float ") };
    let end = if is_wgsl { " -> f32" } else { "" };
    let _ = writeln!(out, "{arrow}{name}({parameters}){end} {{");
    if classes.examples.is_empty() {
        let _ = writeln!(out, "    return 0.5;\n}}");
        return Ok(out);
    }
    let factors = classes.factors();
    for (index, example) in classes.examples.iter().enumerate() {
        let terms: Vec<_> = (0..count)
            .map(|at| {
                let difference = format!("((f{at} - ({})) * {})", number(example.vector[at]), number(factors[at]));
                format!("{difference} * {difference}")
            })
            .collect();
        let _ = writeln!(out, "    {float} d{index} = {};", terms.join(" + "));
    }
    let _ = writeln!(out, "    {float} nearest = d0;");
    for index in 1..classes.examples.len() {
        let _ = writeln!(out, "    nearest = min(nearest, d{index});");
    }
    let _ = writeln!(out, "    {float} belongs = 0.0;\n    {float} total = 0.0;\n    {float} w = 0.0;");
    for (index, example) in classes.examples.iter().enumerate() {
        let halved = number(0.5 * classes.exponent);
        let _ = writeln!(out, "    w = 1.0;");
        let _ = writeln!(out, "    if (d{index} > nearest) {{ w = pow(nearest / d{index}, {halved}); }}");
        let _ = writeln!(out, "    total = total + w;");
        if example.class.value() > 0.0 {
            let _ = writeln!(out, "    belongs = belongs + w;");
        }
    }
    let _ = writeln!(out, "    return belongs / total;\n}}");
    Ok(out)
}
