//! Readers and writers of mesh files: OBJ, PLY, glTF.
