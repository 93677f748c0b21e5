//! Bench `native`: what the bindings to C++ libraries cost and what they do, one module for each library.

mod opensubdiv;
mod openvdb;
mod repair;

use std::path::Path;

use relievo_core::Result;

use crate::peers::Peer;
use crate::report::Report;

/// Measures every case into `report`, beside the programs in a folder.
pub fn run(report: &mut Report, peers: Option<&Path>) -> Result<()> {
    let peers = peers.map_or(Ok(Vec::new()), Peer::of_folder)?;
    // Opening the module is measured once, at its first call.
    openvdb::run(report)?;
    opensubdiv::run(report)?;
    repair::run(report, &peers)
}
