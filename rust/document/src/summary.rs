//! What is in a document, for people.

use std::fmt;

use crate::{Document, Lattice, Settings};

impl fmt::Display for Document {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let topology = self.topology();
        writeln!(out, "document: format version {}, by {} at {}", self.version, self.writer, self.level)?;
        write!(out, "mesh: {} faces, {} corners, ", topology.face_count(), topology.corners().len())?;
        if !topology.holes().is_empty() {
            write!(out, "{} holes, ", topology.holes().len())?;
        }
        match topology.lattice() {
            Lattice::Tiles => write!(out, "{} tiles, ", topology.tile_count())?,
            Lattice::Triangles { edges, points, .. } => write!(out, "all triangles, {edges} edges, {points} points, ")?,
        }
        write!(out, "fingerprint {:016x}", topology.fingerprint())?;
        for layer in self.layers() {
            let packed: u64 = layer.blocks().iter().map(|block| block.packed_bytes() as u64).sum();
            let unit = if topology.is_of_triangles() { "segments an edge: " } else { "tiles of " };
            write!(out, "\nlayer `{}`: {}, {unit}", layer.name(), layer.kind().name())?;
            let (low, high) = (layer.face_sizes().iter().min(), layer.face_sizes().iter().max());
            match (low, high) {
                (Some(low), Some(high)) if low != high => write!(out, "{low} to {high}")?,
                (size, _) => write!(out, "{}", size.copied().unwrap_or(0))?,
            }
            let settings = layer.settings();
            if settings != Settings::of(layer.kind()) {
                write!(out, ", {} at {:.0} %", settings.blend.name(), 100.0 * settings.opacity)?;
                write!(out, "{}", if settings.visible { "" } else { ", hidden" })?;
            }
            let (bytes, blocks) = (layer.bytes(topology), layer.blocks().len());
            write!(out, ", {blocks} of {} stored, {bytes} bytes in {packed}", topology.block_count())?;
        }
        if !self.recipes().is_empty() {
            let bytes: usize = self.recipes().iter().map(|recipe| recipe.bytes.len()).sum();
            write!(out, "\nrecipes: {}, {bytes} bytes", self.recipes().len())?;
        }
        self.notes.iter().try_for_each(|note| write!(out, "\nnote: {note}"))
    }
}
