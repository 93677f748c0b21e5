//! The code that the augmentation adds to a shader: taking of vectors, their log, and the membership of the vector taken
//! last (Sections 4.1 and 5, Equation 2).
//!
//! Two storage buffers carry what host and shader exchange, in words of 32 bits:
//!
//! | words | examples, read by the shader | | words | log, written by the shader |
//! |---|---|---|---|---|
//! | 0 | the mode: 0 to render, 1 to classify a pixel, 2 to make a mask, 3 to classify a vertex, 4 to list vertices | | 0 | vectors with a weight other than 0 |
//! | 1, 2 | x and y of the pixel, vertex and instance, or how many there are of each | | 1 | all vectors |
//! | 3 | number of examples | | 2 | sum of weights, f32 |
//! | 4 | exponent of the membership, f32 | | 3 | accumulated features, f32 |
//! | 5 | a factor for each feature, f32 | | 3 + n | for each vector its weight and its n features, f32 |
//! | 5 + n | for each example 1 or 0 for its class, and its n features, f32 | | | |
//!
//! Only the invocation of the classified pixel or vertex writes, so plain stores suffice. Of a mask each invocation writes the
//! membership of its pixel, the number at its row and column in place of the accumulated features. Of a list of vertices each
//! invocation writes a record in their place: its position (4 numbers), how many vectors of a weight other than 0 it took, the
//! sum of their weights, and its accumulated features. Every index is checked against the length of its buffer. Pixels are
//! the coordinates of fragments and of compute invocations. Vertex shaders act on the modes 3 and 4 alone, other shaders on 1
//! and 2 alone, so that a pipeline of both can have one buffer.

use crate::accumulation::Accumulation;
use crate::source::{Language, Stage};

/// Words of the buffer of examples before the factors.
pub const EXAMPLES_HEAD: usize = 5;
/// Words of the log before the accumulated features.
pub const LOG_HEAD: usize = 3;
/// Numbers of the record of a vertex before its accumulated features.
pub const VERTEX_HEAD: usize = 6;

/// Largest difference of a feature between two vectors, so that squares of distances are finite.
pub(crate) const MAX_DIFFERENCE: f32 = 1e18;

/// What the added code depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Instrument {
    pub features: usize,
    pub accumulation: Accumulation,
    pub group: u32,
    pub binding: u32,
}

impl Instrument {
    /// Returns the statement that accumulates feature `i` of the vector to `sum`, where `taken` vectors came before.
    fn accumulate(&self, sum: &str, taken: &str) -> String {
        let value = "pel_vector[i]";
        match self.accumulation {
            Accumulation::Average | Accumulation::Sum => format!("{sum} = {sum} + weight * {value};"),
            Accumulation::Min => format!("if ({taken} == 0u || {value} < {sum}) {{ {sum} = {value}; }}"),
            Accumulation::Max => format!("if ({taken} == 0u || {value} > {sum}) {{ {sum} = {value}; }}"),
            Accumulation::First => format!("if ({taken} == 0u) {{ {sum} = {value}; }}"),
            Accumulation::Last => format!("{sum} = {value};"),
        }
    }

    /// Returns the declarations and functions to add, with those of vertex shaders if `has_vertices`.
    pub fn code(&self, language: Language, has_vertices: bool) -> String {
        let [template, of_vertices] = match language {
            Language::Wgsl => [include_str!("instrument.wgsl"), include_str!("instrument_vertex.wgsl")],
            Language::Glsl => [include_str!("instrument.glsl"), include_str!("instrument_vertex.glsl")],
        };
        let template = format!("{template}{}", if has_vertices { of_vertices } else { "" });
        // The front end of GLSL cannot read members of an unsized block by the name of an instance.
        let logged = match language {
            Language::Wgsl => "pel_log.values[i]",
            Language::Glsl => "pel_log_values[i]",
        };
        let pixel = match self.accumulation {
            Accumulation::Average => "pel_sums[i] / pel_total",
            _ => "pel_sums[i]",
        };
        template
            .replace("GROUP", &self.group.to_string())
            .replace("EXAMPLES_BINDING", &self.binding.to_string())
            .replace("LOG_BINDING", &(self.binding + 1).to_string())
            .replace("FEATURES", &self.features.to_string())
            .replace("MAX_DIFFERENCE", "1e18")
            .replace("LOG_VECTOR;", &self.accumulate(logged, "taken"))
            .replace("ADD_VECTOR;", &self.accumulate("pel_sums[i]", "pel_added"))
            .replace("PIXEL_FEATURE", pixel)
    }
}

/// Returns the expression of the coordinates of an invocation in GLSL.
pub(crate) fn glsl_place(stage: Stage) -> &'static str {
    match stage {
        Stage::Vertex => "uvec2(gl_VertexIndex, gl_InstanceIndex)",
        Stage::Fragment => "uvec2(gl_FragCoord.xy)",
        Stage::Compute => "gl_GlobalInvocationID.xy",
    }
}
