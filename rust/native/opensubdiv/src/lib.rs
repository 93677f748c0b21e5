//! Binding to OpenSubdiv: topology refinement, patch tables, stencils and reference evaluators.
