//! Tiles of a control cage and how they touch: the connectivity that rings, seams and evaluation share.
//!
//! A tile is a unit parameter square: one per quad face, `n` per face of `n ≠ 4` corners, in face order (the order of
//! Burley and Lacewell 2008, Ptex). Corners are 0 = (0,0), 1 = (1,0), 2 = (1,1), 3 = (0,1); edge `e` runs from corner
//! `e` to corner `e + 1`. Sub-tile `k` of a face `v0 v1 …` has corner 0 at `v_k`, corner 1 in the middle of the edge
//! `v_k v_k+1`, corner 2 at the face's centre and corner 3 in the middle of the edge `v_k−1 v_k`.
//!
//! Everything is built in time linear in the cage (up to sorting the edges of one point) and in face order, so that it
//! is the same on every run. Units: parameters in 0 to 1.

mod links;
mod rings;

use std::ops::Range;

use relievo_core::{Error, Mesh, Result};

use crate::place::{Place, snap_half};

/// One side of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Side {
    /// The tile.
    pub tile: u32,
    /// Its edge, 0 to 3.
    pub edge: u8,
}

/// What lies across an edge of a tile.
///
/// Neighbouring edges run in opposite directions (`t` meets `1 − t`) unless the faces are wound inconsistently: then
/// the link is `reversed`, `t` meets `t`, and normals and displacements change sign across it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// Nothing: the border of the surface or of a hole.
    Boundary,
    /// A non-manifold edge of three or more faces, where displacement is held at zero.
    Pinned {
        /// Number of the edge, for [`TileTopology::pinned_sides`].
        edge: u32,
    },
    /// The whole edge of one tile.
    Whole {
        /// The neighbour's side.
        side: Side,
        /// Whether both edges run in the same direction.
        reversed: bool,
    },
    /// Two sub-tiles of a face that is no quad; their common corner is in the middle of this edge.
    Halves {
        /// The side along parameters 0 to ½ of this edge.
        first: Side,
        /// The side along parameters ½ to 1 of this edge.
        second: Side,
        /// Whether the edges run in the same direction.
        reversed: bool,
        /// The ring of the vertex in the middle.
        middle: u32,
    },
    /// One half of a quad's edge; this is the sub-tile's side of [`Link::Halves`].
    Half {
        /// The quad's side.
        side: Side,
        /// Whether it is the half of the quad's edge from ½ to 1.
        second: bool,
        /// Whether the edges run in the same direction.
        reversed: bool,
    },
}

/// A part of an edge between two vertices, the same for all sides along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// The side it is named after, all of which it covers.
    pub owner: Side,
    /// Whether that side runs against the one that was asked.
    pub flipped: bool,
    /// The rings at its start and end, in the direction of the side that was asked.
    pub ends: [u32; 2],
}

/// Where a tile touches a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Incidence {
    /// The tile.
    pub tile: u32,
    /// The corner (0 to 3) at the vertex, or the edge (0 to 3) in whose middle the vertex is.
    pub corner: u8,
    /// Whether `corner` is an edge in whose middle the vertex is.
    pub middle: bool,
    /// Whether the tile is wound against the ring's first tile, so that displacements change sign.
    pub flipped: bool,
}

impl Incidence {
    /// The vertex as a place of the tile.
    pub fn place(&self) -> Place {
        Place::on_edge(self.tile, self.corner, if self.middle { 0.5 } else { 0.0 })
    }
}

/// What kind of vertex a ring goes round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RingClass {
    /// Interior, four tiles, a corner of each.
    Regular,
    /// In the middle of a quad's edge: two corners of sub-tiles, then the quad.
    Tee,
    /// Interior with any other number of tiles.
    Extraordinary,
    /// On the border: the fan of tiles from one border edge to the other. A vertex where several fans meet has a
    /// ring for each of them.
    Boundary,
    /// On a non-manifold edge: all tiles there, in tile order. Displacement is held at zero.
    Pinned,
}

#[derive(Clone, Copy, Debug)]
struct Tile {
    face: u32,
    corner: u32,
    sub: bool,
    hole: bool,
}

/// The tiles of a control cage, their links across edges and the rings around their vertices.
#[derive(Clone, Debug)]
pub struct TileTopology {
    first_tiles: Vec<u32>,
    tiles: Vec<Tile>,
    links: Vec<[Link; 4]>,
    corner_rings: Vec<[u32; 4]>,
    ring_offsets: Vec<u32>,
    ring_entries: Vec<Incidence>,
    ring_classes: Vec<RingClass>,
    pinned_offsets: Vec<u32>,
    pinned_sides: Vec<PinnedSide>,
    pinned_middles: Vec<u32>,
}

/// A side at a non-manifold edge, and the part of that edge it covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PinnedSide {
    side: Side,
    /// Which half it covers, counted in the face's direction; `None` for all of it.
    half: Option<bool>,
    /// Whether the face runs from the larger point index to the smaller.
    backward: bool,
}

const NO_RING: u32 = u32::MAX;

impl TileTopology {
    /// The tiles of `mesh`.
    ///
    /// # Errors
    /// Fails with `Invalid` if the mesh does not pass [`Mesh::check`], or makes 2²⁹ tiles or more.
    pub fn new(mesh: &Mesh) -> Result<Self> {
        mesh.check()?;
        let mut hole = vec![false; mesh.face_count()];
        for face in &mesh.holes {
            hole[*face as usize] = true;
        }
        let mut first_tiles = Vec::with_capacity(mesh.face_count() + 1);
        let mut tiles = Vec::with_capacity(mesh.corners.len().min(mesh.face_count() * 2));
        for (face, size) in mesh.face_sizes.iter().enumerate() {
            first_tiles.push(tiles.len() as u32);
            let (count, sub) = if *size == 4 { (1, false) } else { (*size, true) };
            tiles.extend((0..count).map(|corner| Tile { face: face as u32, corner, sub, hole: hole[face] }));
        }
        // A ring per corner at most, numbered in 32 bits.
        if u32::try_from(tiles.len() * 8).is_err() {
            return Err(Error::invalid(format!("the mesh makes {} tiles", tiles.len())).advise("split it"));
        }
        first_tiles.push(tiles.len() as u32);
        let count = tiles.len();
        let mut topology = Self {
            first_tiles,
            tiles,
            links: vec![[Link::Boundary; 4]; count],
            corner_rings: vec![[NO_RING; 4]; count],
            ring_offsets: vec![0],
            ring_entries: Vec::with_capacity(4 * count),
            ring_classes: Vec::with_capacity(count),
            pinned_offsets: vec![0],
            pinned_sides: Vec::new(),
            pinned_middles: Vec::new(),
        };
        let mut pinned_points = vec![false; mesh.points.len()];
        topology.link_edges(mesh, &mut pinned_points);
        topology.link_sub_tiles();
        topology.ring_pinned(mesh, &pinned_points);
        topology.ring_fans();
        Ok(topology)
    }

    /// Number of tiles.
    pub fn tile_count(&self) -> usize {
        self.tiles.len()
    }

    /// Number of faces of the cage.
    pub fn face_count(&self) -> usize {
        self.first_tiles.len() - 1
    }

    /// The tiles of `face`.
    pub fn tiles_of(&self, face: u32) -> Range<u32> {
        self.first_tiles[face as usize]..self.first_tiles[face as usize + 1]
    }

    /// The face of `tile`.
    pub fn face(&self, tile: u32) -> u32 {
        self.tiles[tile as usize].face
    }

    /// The face corner at corner 0 of `tile`: the number of a sub-tile, 0 for a quad.
    pub fn sub_corner(&self, tile: u32) -> u32 {
        self.tiles[tile as usize].corner
    }

    /// Whether `tile` is one of several of its face, and so half as long as a quad beside it.
    pub fn is_sub(&self, tile: u32) -> bool {
        self.tiles[tile as usize].sub
    }

    /// Whether `tile` belongs to a hole: it has a number but no surface.
    pub fn is_hole(&self, tile: u32) -> bool {
        self.tiles[tile as usize].hole
    }

    /// What lies across each edge of `tile`.
    pub fn links(&self, tile: u32) -> &[Link; 4] {
        &self.links[tile as usize]
    }

    /// What lies across `edge` (0 to 3) of `tile`.
    pub fn link(&self, tile: u32, edge: u8) -> Link {
        self.links[tile as usize][usize::from(edge)]
    }

    /// Number of rings: vertices of the tiles, counted once per fan.
    pub fn ring_count(&self) -> usize {
        self.ring_classes.len()
    }

    /// The ring round each corner of `tile`.
    pub fn rings(&self, tile: u32) -> &[u32; 4] {
        &self.corner_rings[tile as usize]
    }

    /// What kind of vertex `ring` goes round.
    pub fn ring_class(&self, ring: u32) -> RingClass {
        self.ring_classes[ring as usize]
    }

    /// The tiles of `ring`: in counter-clockwise order, seen from the first tile.
    pub fn ring(&self, ring: u32) -> &[Incidence] {
        let ring = ring as usize;
        &self.ring_entries[self.ring_offsets[ring] as usize..self.ring_offsets[ring + 1] as usize]
    }

    /// The sides that meet at a non-manifold edge, see [`Link::Pinned`]; sides of holes are left out.
    pub fn pinned_sides(&self, edge: u32) -> impl Iterator<Item = Side> {
        self.pinned(edge).iter().map(|pinned| pinned.side)
    }

    /// The number of tiles that have a non-manifold edge, with repetition: 0 for a manifold cage.
    pub fn pinned_side_count(&self) -> usize {
        self.pinned_sides.len()
    }

    /// The one place at which `place` is evaluated, whichever of the tiles that share it was asked.
    ///
    /// Inside a tile that is `place` itself. A point on an edge or vertex belongs to the tile of the lowest density
    /// (texels along a base edge, 0 where nothing is allocated); among those to a whole tile before a sub-tile, then
    /// to the lowest tile. Parameters are converted exactly; to make that possible they are first rounded to
    /// multiples of 2⁻²⁴ (2⁻²³ on a sub-tile beside a quad) along shared edges. `place` must be in its tile.
    pub fn canonical(&self, place: Place, density: impl Fn(u32) -> u32) -> Place {
        let Some((edge, t)) = place.edge() else { return place };
        if t == 0.0 {
            return self.canonical_vertex(self.corner_rings[place.tile as usize][usize::from(edge)], density);
        }
        let key = |tile: u32| (density(tile), self.is_sub(tile), tile);
        let own = Place::on_edge(place.tile, edge, t);
        let other = match self.link(place.tile, edge) {
            Link::Boundary => return place,
            Link::Pinned { edge: pinned } => return self.canonical_pinned(own, edge, t, pinned, density),
            Link::Whole { side, reversed } => Place::on_edge(side.tile, side.edge, if reversed { t } else { 1.0 - t }),
            Link::Halves { middle, .. } if t == 0.5 => return self.canonical_vertex(middle, density),
            Link::Halves { first, second, reversed, .. } => {
                let (side, t) = if t < 0.5 { (first, 2.0 * t) } else { (second, 2.0 * t - 1.0) };
                Place::on_edge(side.tile, side.edge, if reversed { t } else { 1.0 - t })
            }
            Link::Half { side, second, reversed } => {
                let t = snap_half(t);
                if t == 0.0 || t == 1.0 {
                    let corner = if t == 0.0 { edge } else { (edge + 1) & 3 };
                    let ring = self.corner_rings[place.tile as usize][usize::from(corner)];
                    return self.canonical_vertex(ring, density);
                }
                if key(place.tile) < key(side.tile) {
                    return Place::on_edge(place.tile, edge, t);
                }
                let t = if reversed { t } else { 1.0 - t };
                return Place::on_edge(side.tile, side.edge, if second { (1.0 + t) / 2.0 } else { t / 2.0 });
            }
        };
        if key(other.tile) < key(own.tile) { other } else { own }
    }

    /// The segments of a side in order: two for a quad beside sub-tiles, else one.
    pub fn segments(&self, side: Side) -> [Option<Segment>; 2] {
        let rings = self.rings(side.tile);
        let ends = [rings[usize::from(side.edge)], rings[usize::from((side.edge + 1) & 3)]];
        let own = Segment { owner: side, flipped: false, ends };
        match self.link(side.tile, side.edge) {
            Link::Boundary | Link::Half { .. } => [Some(own), None],
            Link::Whole { side: other, reversed } => {
                let segment = if side < other { own } else { Segment { owner: other, flipped: !reversed, ends } };
                [Some(segment), None]
            }
            Link::Halves { first, second, reversed, middle } => [
                Some(Segment { owner: first, flipped: !reversed, ends: [ends[0], middle] }),
                Some(Segment { owner: second, flipped: !reversed, ends: [middle, ends[1]] }),
            ],
            Link::Pinned { edge } => self.pinned_segments(own, edge),
        }
    }

    fn pinned_segments(&self, own: Segment, edge: u32) -> [Option<Segment>; 2] {
        let sides = self.pinned(edge);
        let Some(asked) = sides.iter().find(|other| other.side == own.owner) else { return [Some(own), None] };
        let flipped = |other: &PinnedSide| other.backward != asked.backward;
        // The half of the edge that a side covers, counted in the direction of the side that was asked.
        let half = |other: &PinnedSide| other.half.map(|second| second != flipped(other));
        let named = |wanted: Option<bool>, ends: [u32; 2]| {
            let owner = sides.iter().find(|other| half(other) == wanted)?;
            Some(Segment { owner: owner.side, flipped: flipped(owner), ends })
        };
        let middle = self.pinned_middles[edge as usize];
        match asked.half {
            None if middle == NO_RING => [named(None, own.ends), None],
            None => [named(Some(false), [own.ends[0], middle]), named(Some(true), [middle, own.ends[1]])],
            Some(second) => [named(Some(second), own.ends), None],
        }
    }

    fn canonical_vertex(&self, ring: u32, density: impl Fn(u32) -> u32) -> Place {
        let key = |entry: &&Incidence| (density(entry.tile), self.is_sub(entry.tile), entry.tile);
        // A ring has at least the tile that was asked.
        self.ring(ring).iter().min_by_key(key).map(Incidence::place).unwrap_or_default()
    }

    /// As [`Self::canonical`] for the point at `t` along a non-manifold edge.
    fn canonical_pinned(&self, own: Place, edge: u8, t: f32, pinned: u32, density: impl Fn(u32) -> u32) -> Place {
        let sides = self.pinned(pinned);
        let Some(asked) = sides.iter().find(|other| other.side == Side { tile: own.tile, edge }) else { return own };
        let mut along = match asked.half {
            None => t,
            Some(second) => (if second { 1.0 + snap_half(t) } else { snap_half(t) }) / 2.0,
        };
        if asked.backward {
            along = 1.0 - along;
        }
        let end = |corner: u8| self.corner_rings[own.tile as usize][usize::from(corner & 3)];
        let middle = self.pinned_middles[pinned as usize];
        if along == 0.5 && middle != NO_RING {
            return self.canonical_vertex(middle, density);
        }
        if along == 0.0 || along == 1.0 {
            return self.canonical_vertex(end(if t < 0.5 { edge } else { edge + 1 }), density);
        }
        let places = sides.iter().filter_map(|other| {
            let along = if other.backward { 1.0 - along } else { along };
            let t = match other.half {
                None => along,
                Some(second) if second == (along > 0.5) => 2.0 * along - if second { 1.0 } else { 0.0 },
                Some(_) => return None,
            };
            Some(Place::on_edge(other.side.tile, other.side.edge, t))
        });
        places.min_by_key(|place| (density(place.tile), self.is_sub(place.tile), place.tile)).unwrap_or(own)
    }

    fn pinned(&self, edge: u32) -> &[PinnedSide] {
        let edge = edge as usize;
        &self.pinned_sides[self.pinned_offsets[edge] as usize..self.pinned_offsets[edge + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use relievo_testing::grid;

    /// Where the bilinear cage is at a place: corners, middles of edges and centres decide.
    fn position(mesh: &Mesh, topology: &TileTopology, place: Place) -> [f64; 3] {
        let first = mesh.face_offsets()[topology.face(place.tile) as usize] as usize;
        let size = mesh.face_sizes[topology.face(place.tile) as usize] as usize;
        let point = |corner: usize| mesh.points[mesh.corners[first + corner % size] as usize].map(f64::from);
        let mean = |points: &[[f64; 3]]| {
            std::array::from_fn(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64)
        };
        let k = topology.sub_corner(place.tile) as usize;
        let corners: [[f64; 3]; 4] = if topology.is_sub(place.tile) {
            let all: Vec<_> = (0..size).map(point).collect();
            [point(k), mean(&[point(k), point(k + 1)]), mean(&all), mean(&[point(k), point(k + size - 1)])]
        } else {
            std::array::from_fn(point)
        };
        let (u, v) = (f64::from(place.u), f64::from(place.v));
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v];
        std::array::from_fn(|axis| (0..4).map(|c| weights[c] * corners[c][axis]).sum())
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|axis| (a[axis] - b[axis]).abs()).fold(0.0, f64::max)
    }

    /// The places that coincide with the point at `t` of every side of `edge` of `tile`.
    fn across(topology: &TileTopology, tile: u32, edge: u8, t: f32) -> Vec<Place> {
        let turn = |t: f32, reversed: bool| if reversed { t } else { 1.0 - t };
        match topology.link(tile, edge) {
            Link::Boundary | Link::Pinned { .. } => vec![],
            Link::Whole { side, reversed } => vec![Place::on_edge(side.tile, side.edge, turn(t, reversed))],
            Link::Half { side, second, reversed } => {
                let t = turn(t, reversed) / 2.0;
                vec![Place::on_edge(side.tile, side.edge, if second { 0.5 + t } else { t })]
            }
            Link::Halves { first, second, reversed, .. } => {
                let mut places = vec![];
                if t <= 0.5 {
                    places.push(Place::on_edge(first.tile, first.edge, turn(2.0 * t, reversed)));
                }
                if t >= 0.5 {
                    places.push(Place::on_edge(second.tile, second.edge, turn(2.0 * t - 1.0, reversed)));
                }
                places
            }
        }
    }

    /// Checks everything that holds for any cage.
    fn check(mesh: &Mesh, topology: &TileTopology, seed: u32) {
        let density = |tile: u32| [0, 64, 128, 256][((tile ^ seed).wrapping_mul(0x9e37_79b9) >> 30) as usize];
        let expected: u32 = mesh.face_sizes.iter().map(|size| if *size == 4 { 1 } else { *size }).sum();
        assert_eq!(topology.tile_count() as u32, expected);
        let mut corners = 0;
        for ring in 0..topology.ring_count() as u32 {
            let entries = topology.ring(ring);
            let first = position(mesh, topology, entries[0].place());
            let canonical = topology.canonical(entries[0].place(), density);
            for entry in entries {
                assert!(distance(position(mesh, topology, entry.place()), first) < 1e-6);
                if topology.is_hole(entry.tile) {
                    continue;
                }
                assert_eq!(topology.canonical(entry.place(), density), canonical);
                assert!(density(canonical.tile) <= density(entry.tile));
                if !entry.middle {
                    corners += 1;
                    assert_eq!(topology.rings(entry.tile)[usize::from(entry.corner)], ring);
                }
            }
        }
        for tile in (0..topology.tile_count() as u32).filter(|tile| !topology.is_hole(*tile)) {
            corners -= 4;
            for edge in 0..4 {
                // Each segment lies along its part of the edge, from ring to ring.
                let segments = topology.segments(Side { tile, edge });
                let count = segments.iter().flatten().count() as f32;
                for (index, segment) in segments.iter().flatten().enumerate() {
                    let ends = segment.ends.map(|ring| position(mesh, topology, topology.ring(ring)[0].place()));
                    for (end, t) in ends.into_iter().zip([0.0, 1.0]) {
                        let here = Place::on_edge(tile, edge, (index as f32 + t) / count);
                        let s = if segment.flipped { 1.0 - t } else { t };
                        let there = Place::on_edge(segment.owner.tile, segment.owner.edge, s);
                        assert!(distance(position(mesh, topology, here), end) < 1e-6);
                        assert!(distance(position(mesh, topology, there), end) < 1e-6);
                    }
                    let [Some(own), None] = topology.segments(segment.owner) else {
                        panic!("an owner has one segment")
                    };
                    assert_eq!((own.owner, own.flipped), (segment.owner, false));
                }
                for t in [0.0, 1e-9, 0.125, 0.3, 0.4999999, 0.5, 0.6, 0.875, 0.9999999, 1.0] {
                    let place = Place::on_edge(tile, edge, t);
                    let canonical = topology.canonical(place, density);
                    assert_eq!(topology.canonical(canonical, density), canonical);
                    let here = position(mesh, topology, place);
                    assert!(distance(here, position(mesh, topology, canonical)) < 1e-5);
                    for other in across(topology, tile, edge, t) {
                        assert!(distance(here, position(mesh, topology, other)) < 1e-5);
                        if t * 1024.0 % 1.0 == 0.0 {
                            assert_eq!(topology.canonical(other, density), canonical);
                        }
                        // Links are symmetric: the way back leads here.
                        let (side, s) = other.edge().unwrap();
                        if t > 0.0 && t < 1.0 && t != 0.5 && s > 0.0 {
                            let back = across(topology, other.tile, side, s);
                            assert!(back.iter().any(|back| back.tile == tile));
                        }
                    }
                }
            }
        }
        assert_eq!(corners, 0, "every corner is in exactly one ring");
    }

    /// Vertices − edges + faces of the tiles.
    fn euler(topology: &TileTopology) -> i64 {
        let mut halves_of_edges = 0;
        for tile in 0..topology.tile_count() as u32 {
            for link in topology.links(tile) {
                halves_of_edges += match link {
                    Link::Boundary | Link::Half { .. } => 2,
                    Link::Whole { .. } => 1,
                    Link::Halves { .. } | Link::Pinned { .. } => 0,
                };
            }
        }
        topology.ring_count() as i64 - halves_of_edges / 2 + topology.tile_count() as i64
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn any_torus_has_symmetric_links_closed_rings_and_one_canonical_place(
            size in 3u32..8, choices in prop::collection::vec(any::<u8>(), 1..40), seed: u32,
        ) {
            let mesh = grid(size, true, &choices, true);
            let topology = TileTopology::new(&mesh).unwrap();
            check(&mesh, &topology, seed);
            prop_assert_eq!(euler(&topology), 0);
            for ring in 0..topology.ring_count() as u32 {
                prop_assert!(!matches!(topology.ring_class(ring), RingClass::Boundary | RingClass::Pinned));
            }
        }

        #[test]
        fn any_disc_with_holes_and_fins_is_consistent(
            size in 1u32..7, choices in prop::collection::vec(any::<u8>(), 1..40), seed: u32,
            holes in prop::collection::vec(any::<u32>(), 0..4), fins in prop::collection::vec(any::<u32>(), 0..4),
        ) {
            let mut mesh = grid(size, false, &choices, true);
            prop_assert_eq!(euler(&TileTopology::new(&mesh).unwrap()), 1);
            let faces = mesh.face_count() as u32;
            mesh.holes = holes.iter().map(|hole| hole % faces).collect();
            for fin in fins {
                // Another face on some edge: a triangle or a quad.
                let at = mesh.face_offsets()[(fin % faces) as usize] as usize;
                let (a, b) = (mesh.corners[at], mesh.corners[at + 1]);
                let new = mesh.points.len() as u32;
                mesh.points.extend([[9.0, fin as f32 * 1e-9, 1.0], [9.0, 0.0, 2.0]]);
                let face = if fin & 64 == 0 { vec![a, b, new] } else { vec![b, a, new, new + 1] };
                mesh.face_sizes.push(face.len() as u32);
                mesh.corners.extend(face);
            }
            let topology = TileTopology::new(&mesh).unwrap();
            check(&mesh, &topology, seed);
        }
    }

    fn polygons(points: usize, faces: &[&[u32]]) -> (Mesh, TileTopology) {
        let points = (0..points).map(|i| [(i as f32).sin(), (i as f32 * 1.7).cos(), i as f32]).collect();
        let sizes = faces.iter().map(|face| face.len() as u32).collect();
        let mesh = Mesh::new(points, sizes, faces.concat());
        let topology = TileTopology::new(&mesh).unwrap();
        check(&mesh, &topology, 7);
        (mesh, topology)
    }

    #[test]
    fn a_triangle_beside_a_quad_makes_a_tee() {
        let (_, topology) = polygons(5, &[&[0, 1, 2, 3], &[2, 1, 4]]);
        assert_eq!(topology.tile_count(), 4);
        let Link::Halves { first, second, reversed: false, middle } = topology.link(0, 1) else {
            panic!("{:?}", topology.link(0, 1))
        };
        // The quad runs 1 → 2, the triangle 2 → 1: its sub-tile 1 is at point 1, sub-tile 0 at point 2.
        assert_eq!((first, second), (Side { tile: 2, edge: 3 }, Side { tile: 1, edge: 0 }));
        assert_eq!(topology.ring_class(middle), RingClass::Tee);
        assert!(topology.ring(middle).iter().any(|entry| entry.middle && entry.tile == 0));
        assert_eq!(topology.canonical(Place::new(2, 0.0, 0.75), |_| 128), Place::new(0, 1.0, 0.375));
        assert_eq!(
            topology.canonical(Place::new(0, 1.0, 0.375), |t| if t == 0 { 9 } else { 1 }),
            Place::new(2, 0.0, 0.75)
        );
        let centre = topology.rings(1)[2];
        assert_eq!((topology.ring(centre).len(), topology.ring_class(centre)), (3, RingClass::Extraordinary));
    }

    #[test]
    fn two_quads_that_share_two_edges_have_a_ring_of_two() {
        let (_, topology) = polygons(5, &[&[0, 1, 2, 3], &[1, 0, 3, 4]]);
        let ring = topology.rings(0)[0];
        assert_eq!((topology.ring(ring).len(), topology.ring_class(ring)), (2, RingClass::Extraordinary));
    }

    #[test]
    fn fans_that_share_only_a_point_have_a_ring_each() {
        let (_, topology) = polygons(7, &[&[0, 1, 2, 3], &[0, 4, 5, 6]]);
        assert_ne!(topology.rings(0)[0], topology.rings(1)[0]);
        assert_eq!(topology.ring_count(), 8);
    }

    #[test]
    fn an_edge_of_three_faces_is_pinned_and_has_one_canonical_place() {
        let (_, topology) = polygons(8, &[&[0, 1, 2, 3], &[1, 0, 4, 5], &[0, 1, 6], &[0, 1, 7, 6]]);
        assert!(matches!(topology.link(0, 0), Link::Pinned { .. }));
        assert_eq!(topology.ring_class(topology.rings(0)[0]), RingClass::Pinned);
        for t in [0.0, 0.125, 0.25, 0.5, 0.75, 1.0] {
            let expected = topology.canonical(Place::on_edge(0, 0, t), |_| 0);
            assert_eq!(expected.tile, 0);
            assert_eq!(topology.canonical(Place::on_edge(1, 0, 1.0 - t), |_| 0), expected);
            assert_eq!(topology.canonical(Place::on_edge(5, 0, t), |_| 0), expected);
            let half = if t <= 0.5 { Place::on_edge(2, 0, 2.0 * t) } else { Place::on_edge(3, 3, 2.0 * t - 1.0) };
            assert_eq!(topology.canonical(half, |_| 0), expected);
        }
    }

    #[test]
    fn a_hole_is_a_border_and_a_pole_has_any_valence() {
        let faces: Vec<Vec<u32>> = (0..40).map(|i| vec![0, 1 + 2 * i, 2 + 2 * i, 1 + (2 * i + 2) % 80]).collect();
        let (mut mesh, topology) = polygons(81, &faces.iter().map(Vec::as_slice).collect::<Vec<_>>());
        let ring = topology.rings(0)[0];
        assert_eq!((topology.ring(ring).len(), topology.ring_class(ring)), (40, RingClass::Extraordinary));
        mesh.holes = vec![3];
        let topology = TileTopology::new(&mesh).unwrap();
        check(&mesh, &topology, 1);
        let ring = topology.rings(0)[0];
        assert_eq!((topology.ring(ring).len(), topology.ring_class(ring)), (39, RingClass::Boundary));
        assert!(topology.is_hole(3) && topology.links(3).iter().all(|link| *link == Link::Boundary));
    }

    #[test]
    fn an_unusable_mesh_is_refused() {
        assert!(TileTopology::new(&Mesh::new(vec![[0.0; 3]; 3], vec![3], vec![0, 1, 1])).is_err());
    }
}
