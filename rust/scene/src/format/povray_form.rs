//! The form in which scenes for POV-Ray have a fluid.

/// What scenes for POV-Ray have of a fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PovrayForm {
    /// A mesh.
    Mesh,
    /// A blob for each particle.
    Blobs,
    /// A grid of values.
    Grid,
}
