//! Binding to OpenVDB: level sets from meshes.
