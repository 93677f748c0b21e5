//! Files of models, states, scans and results.

pub(crate) mod archive;
mod grids;
mod inp;
pub(crate) mod inp_reader;
pub(crate) mod scan;
mod vtu;
