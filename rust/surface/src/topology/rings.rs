//! The tiles round every vertex of a cage, found by walking from tile to tile across their edges.

use relievo_core::Mesh;

use super::{Incidence, Link, NO_RING, RingClass, Side, TileTopology};

/// Where a walk round a vertex arrives when it crosses an edge.
enum Step {
    Corner { tile: u32, corner: u8, entered: u8, reversed: bool },
    Middle { side: Side, reversed: bool },
}
impl TileTopology {
    /// Makes the rings of vertices on non-manifold edges: every tile there, whatever its fan.
    pub(super) fn ring_pinned(&mut self, mesh: &Mesh, pinned_points: &[bool]) {
        if self.pinned_sides.is_empty() {
            return;
        }
        for edge in 0..self.pinned_middles.len() {
            let sides = self.pinned(edge as u32).to_vec();
            if sides.iter().all(|pinned| pinned.half.is_none()) {
                continue;
            }
            self.pinned_middles[edge] = self.ring_classes.len() as u32;
            let ring = sides.iter().map(|pinned| {
                // The middle of a face's edge is corner 1 of the sub-tile before it and corner 3 of the one after.
                let corner = pinned.half.map_or(pinned.side.edge, |second| if second { 3 } else { 1 });
                Incidence { tile: pinned.side.tile, corner, middle: pinned.half.is_none(), flipped: false }
            });
            self.push_ring(ring.collect(), RingClass::Pinned);
        }
        let mut incidences = Vec::new();
        let offsets = mesh.face_offsets();
        for tile in (0..self.tiles.len() as u32).filter(|tile| !self.is_hole(*tile)) {
            let first = (offsets[self.face(tile) as usize] + self.sub_corner(tile)) as usize;
            for corner in 0..if self.is_sub(tile) { 1 } else { 4 } {
                let point = mesh.corners[first + usize::from(corner)];
                if pinned_points[point as usize] {
                    incidences.push((point, Incidence { tile, corner, middle: false, flipped: false }));
                }
            }
        }
        incidences.sort_by_key(|(point, _)| *point);
        for group in incidences.chunk_by(|a, b| a.0 == b.0) {
            self.push_ring(group.iter().map(|(_, entry)| *entry).collect(), RingClass::Pinned);
        }
    }

    /// Makes the rings of all other vertices, by walking round each of them.
    pub(super) fn ring_fans(&mut self) {
        for tile in 0..self.tiles.len() as u32 {
            for corner in 0..4 {
                if self.corner_rings[tile as usize][usize::from(corner)] == NO_RING {
                    let (ring, class) = self.fan(tile, corner);
                    self.push_ring(ring, class);
                }
            }
        }
    }

    fn push_ring(&mut self, ring: Vec<Incidence>, class: RingClass) {
        let id = self.ring_classes.len() as u32;
        for entry in &ring {
            if !entry.middle {
                self.corner_rings[entry.tile as usize][usize::from(entry.corner)] = id;
            } else if let Link::Halves { middle, .. } = &mut self.links[entry.tile as usize][usize::from(entry.corner)]
            {
                *middle = id;
            }
        }
        self.ring_entries.extend(ring);
        self.ring_offsets.push(self.ring_entries.len() as u32);
        self.ring_classes.push(class);
    }

    /// The fan of tiles round a corner, counter-clockwise seen from `tile`.
    fn fan(&self, tile: u32, corner: u8) -> (Vec<Incidence>, RingClass) {
        let first = Incidence { tile, corner, middle: false, flipped: false };
        let mut ring = vec![first];
        let mut middle = None;
        let mut walk = |edge: u8, ring: &mut Vec<Incidence>| {
            let (mut at, mut edge) = (first, edge);
            while let Some(step) = self.cross(at.tile, at.corner, edge) {
                match step {
                    Step::Corner { tile, corner, .. } if (tile, corner) == (first.tile, first.corner) => return true,
                    Step::Corner { tile, corner, entered, reversed } => {
                        at = Incidence { tile, corner, middle: false, flipped: at.flipped != reversed };
                        ring.push(at);
                        edge = if entered == corner { (corner + 3) & 3 } else { corner };
                    }
                    Step::Middle { side, reversed } => {
                        let flipped = at.flipped != reversed;
                        middle = Some(Incidence { tile: side.tile, corner: side.edge, middle: true, flipped });
                        break;
                    }
                }
            }
            false
        };
        if walk((corner + 3) & 3, &mut ring) {
            let class = if ring.len() == 4 { RingClass::Regular } else { RingClass::Extraordinary };
            return (ring, class);
        }
        let mut before = Vec::new();
        walk(corner, &mut before);
        before.reverse();
        before.append(&mut ring);
        match middle {
            Some(middle) => {
                before.push(middle);
                (before, RingClass::Tee)
            }
            None => (before, RingClass::Boundary),
        }
    }

    /// Crosses `edge`, one of the two at `corner` of `tile`, staying at the same vertex.
    fn cross(&self, tile: u32, corner: u8, edge: u8) -> Option<Step> {
        let at_end = edge != corner;
        Some(match self.link(tile, edge) {
            Link::Boundary | Link::Pinned { .. } => return None,
            Link::Whole { side, reversed } => {
                let corner = if at_end == reversed { (side.edge + 1) & 3 } else { side.edge };
                Step::Corner { tile: side.tile, corner, entered: side.edge, reversed }
            }
            Link::Halves { first, second, reversed, .. } => {
                let side = if at_end { second } else { first };
                Step::Corner { tile: side.tile, corner: 0, entered: side.edge, reversed }
            }
            // Corner 0 of a sub-tile is the point of the cage, its other corner on the edge is the middle.
            Link::Half { side, reversed, .. } if corner != 0 => Step::Middle { side, reversed },
            Link::Half { side, second, reversed } => {
                let corner = if second { (side.edge + 1) & 3 } else { side.edge };
                Step::Corner { tile: side.tile, corner, entered: side.edge, reversed }
            }
        })
    }
}
