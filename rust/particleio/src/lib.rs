//! Files of particles: frames of our own cache, classic `.bgeo`, legacy VTK, PLY and OpenVDB's points, both ways; of OpenVDB,
//! level sets out and grids of floats in.
//!
//! Files are hostile until read: every size is checked against the file's length and the memory limit before anything is
//! allocated. What is read is sound ([`Particles::check`]).

mod bgeo;
mod bgeo_writer;
mod bytes;
mod file;
mod frame;
mod particles;
mod ply;
mod read;
mod sequence;
mod vdb;
mod vtk;
mod vtk_words;
mod vtk_writer;

pub use bgeo::read_bgeo;
pub use bgeo_writer::write_bgeo;
pub use file::{Format, read, write};
pub use frame::{EXTENSION, Frame, FrameStream, VERSION, encode_frame, frame_bytes, read_frame, write_frame};
pub use particles::{Channel, Particles, VELOCITY};
pub use ply::{read_ply, write_ply};
pub use read::Read;
pub use sequence::{FrameNumber, frames, path};
pub use vdb::{BLOCK, Block, Grid, LevelSet, read_grid, read_vdb_points, write_vdb, write_vdb_points};
pub use vtk::read_vtk;
pub use vtk_writer::write_vtk;
