//! Messages between all ranks of OpenMPI, in bytes.
//!
//! The crate is empty without its feature `mpi`. With it, MPI is initialised by [`World::start`] and ended by dropping the
//! world. An error of MPI ends all ranks, as MPI's own handler does.

#[cfg(feature = "mpi")]
mod world;

#[cfg(feature = "mpi")]
pub use world::World;
