//! Which sides of tiles meet across the edges of a cage.

use relievo_core::Mesh;

use super::{Link, NO_RING, PinnedSide, Side, TileTopology};

/// One use of a cage edge by a face.
#[derive(Clone, Copy)]
struct Use {
    low: u32,
    high: u32,
    face: u32,
    corner: u32,
    backward: bool,
}

impl TileTopology {
    /// The sides along a face's edge: one for a quad, two halves in the face's direction otherwise.
    fn sides(&self, face: u32, corner: u32) -> (Side, Option<Side>) {
        let tiles = self.tiles_of(face);
        if tiles.len() == 1 {
            return (Side { tile: tiles.start, edge: corner as u8 }, None);
        }
        let next = if corner + 1 == tiles.len() as u32 { 0 } else { corner + 1 };
        (Side { tile: tiles.start + corner, edge: 0 }, Some(Side { tile: tiles.start + next, edge: 3 }))
    }

    fn set(&mut self, side: Side, link: Link) {
        self.links[side.tile as usize][usize::from(side.edge)] = link;
    }

    pub(super) fn link_edges(&mut self, mesh: &Mesh, pinned_points: &mut [bool]) {
        let uses = edge_uses(mesh);
        for group in uses.chunk_by(|a, b| (a.low, a.high) == (b.low, b.high)) {
            let hole = |edge: &Use| self.tiles[self.first_tiles[edge.face as usize] as usize].hole;
            match group {
                [a, b] if !hole(a) && !hole(b) => self.link_pair(a, b),
                [_] | [_, _] => {}
                many => {
                    for edge in many.iter().filter(|edge| !hole(edge)).copied().collect::<Vec<_>>() {
                        let (first, second) = self.sides(edge.face, edge.corner);
                        let link = Link::Pinned { edge: self.pinned_middles.len() as u32 };
                        let half = second.map(|_| false);
                        let backward = edge.backward;
                        self.pinned_sides.push(PinnedSide { side: first, half, backward });
                        self.set(first, link);
                        if let Some(second) = second {
                            self.pinned_sides.push(PinnedSide { side: second, half: Some(true), backward });
                            self.set(second, link);
                        }
                    }
                    self.pinned_middles.push(NO_RING);
                    self.pinned_offsets.push(self.pinned_sides.len() as u32);
                    pinned_points[many[0].low as usize] = true;
                    pinned_points[many[0].high as usize] = true;
                }
            }
        }
    }

    fn link_pair(&mut self, a: &Use, b: &Use) {
        let reversed = a.backward == b.backward;
        match (self.sides(a.face, a.corner), self.sides(b.face, b.corner)) {
            ((a, None), (b, None)) => {
                self.set(a, Link::Whole { side: b, reversed });
                self.set(b, Link::Whole { side: a, reversed });
            }
            ((whole, None), (one, Some(two))) | ((one, Some(two)), (whole, None)) => {
                let (first, second) = if reversed { (one, two) } else { (two, one) };
                self.set(whole, Link::Halves { first, second, reversed, middle: NO_RING });
                self.set(first, Link::Half { side: whole, second: false, reversed });
                self.set(second, Link::Half { side: whole, second: true, reversed });
            }
            ((a, Some(b)), (c, Some(d))) => {
                let pairs = if reversed { [(a, c), (b, d)] } else { [(a, d), (b, c)] };
                for (a, b) in pairs {
                    self.set(a, Link::Whole { side: b, reversed });
                    self.set(b, Link::Whole { side: a, reversed });
                }
            }
        }
    }

    /// Links the sub-tiles of every face that is no quad across its spokes: edge 1 of each with edge 2 of the next.
    pub(super) fn link_sub_tiles(&mut self) {
        for face in 0..self.face_count() as u32 {
            let tiles = self.tiles_of(face);
            if tiles.len() == 1 || self.is_hole(tiles.start) {
                continue;
            }
            for tile in tiles.clone() {
                let next = if tile + 1 == tiles.end { tiles.start } else { tile + 1 };
                let (a, b) = (Side { tile, edge: 1 }, Side { tile: next, edge: 2 });
                self.set(a, Link::Whole { side: b, reversed: false });
                self.set(b, Link::Whole { side: a, reversed: false });
            }
        }
    }
}

/// Every use of an edge by a face, grouped by edge.
fn edge_uses(mesh: &Mesh) -> Vec<Use> {
    let mut starts = vec![0u32; mesh.points.len() + 1];
    let ends = |face: &[u32], corner: usize| {
        let next = if corner + 1 == face.len() { 0 } else { corner + 1 };
        (face[corner], face[next])
    };
    for face in mesh.faces() {
        for corner in 0..face.len() {
            let (a, b) = ends(face, corner);
            starts[a.min(b) as usize + 1] += 1;
        }
    }
    for point in 0..mesh.points.len() {
        starts[point + 1] += starts[point];
    }
    let mut uses = vec![Use { low: 0, high: 0, face: 0, corner: 0, backward: false }; mesh.corners.len()];
    let mut cursors = starts.clone();
    for (index, face) in mesh.faces().enumerate() {
        for corner in 0..face.len() {
            let (a, b) = ends(face, corner);
            let (low, high) = (a.min(b), a.max(b));
            let slot = &mut cursors[low as usize];
            uses[*slot as usize] = Use { low, high, face: index as u32, corner: corner as u32, backward: a > b };
            *slot += 1;
        }
    }
    for range in starts.windows(2) {
        uses[range[0] as usize..range[1] as usize].sort_unstable_by_key(|edge| (edge.high, edge.face));
    }
    uses
}
