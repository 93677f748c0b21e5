//! Exploration of shaders by feature vectors: which variables of a shader tell what is sought in a picture from what is not
//! (Mindek et al. 2013).
//!
//! An author marks expressions of a shader in comments, `//. vector density; gradient; alpha`, and the shader stays valid for
//! its host ([`annotation`]). [`Shader::augment`] turns the marks into code that takes the vectors, logs those of one pixel
//! and computes `confidence`, the degree to which the vector taken last resembles pixels that a user called positive and not
//! those called negative ([`membership`], Equation 2). A host binds two buffers ([`instrument`]); a `Runner` does so on a
//! graphics device. [`Classes`] hold the classified pixels, [`Diagnosis`] says whether the features separate them, and
//! [`Transfer`] makes a transfer function of them.
//!
//! GLSL of any version is read, old ones by rewriting, and WGSL.

pub mod accumulation;
pub mod annotation;
mod augment;
mod classes;
mod compact;
mod diagnosis;
mod dialect;
mod edit;
mod fault;
mod front;
pub mod instrument;
mod lexer;
mod log;
mod membership;
mod outline;
mod project;
mod resource;
#[cfg(feature = "wgpu")]
mod runner;
mod shader;
mod source;
mod transfer;
#[cfg(feature = "wgpu")]
mod values;
mod variable;
mod volume;

pub use accumulation::Accumulation;
pub use augment::{Augmented, Feature, Site};
pub use classes::{Class, Classes, EXPONENT, Example, MAX_EXAMPLES, Mode};
pub use diagnosis::{Correlation, Diagnosis, Explanation, Neighbour};
pub use edit::SpanMap;
pub use fault::{Fault, Faults, Span};
pub use log::Log;
pub use membership::membership;
pub use outline::Declared;
pub use project::{Classified, Input, Project};
pub use resource::{Field, FieldKind, Resource, ResourceKind};
#[cfg(feature = "wgpu")]
pub use runner::{Inputs, MAX_VECTORS, MAX_VERTICES, Program, Runner, Texture, Textures};
pub use shader::{Entry, Shader};
pub use source::{Language, MAX_BYTES, Source, Stage};
pub use transfer::{Transfer, membership_function};
#[cfg(feature = "wgpu")]
pub use values::{Setting, Value};
pub use variable::Variable;
pub use volume::Volume;
