//! The frames in which vector displacement is kept, and how those of tiles that meet are turned to each other.
//!
//! A vector has the components (along T, along B, along N), where `T = S_u/|S_u|`, `N` is the unit normal of the
//! surface and `B = N × T` (Schäfer, Keinert, Nießner and Stamminger 2015, Section 5, leaves the frame open). So `S_u`
//! of two tiles that share an edge differs by a rotation about `N`: on a side its angle to the edge says all, because
//! the edge runs the same way in space for both. Along edges 0 and 2 that angle is fixed; along 1 and 3 it is that
//! between the tangents, taken at 33 points of the side and linear between them. Across a crease this unfolds the two
//! sides. At a vertex the frames are compared directly, normals turned onto each other by the shortest way.
//!
//! Angles are those of the pose in which a channel was made, so that blocks do not depend on later poses: where a pose
//! changes the angle between two tangents, the surface just beside the edge is off by that change, and points on the
//! edge, which are evaluated in one tile, still agree to the bit. Units: none; vectors are in object units.
//!
//! `shaders/tiles/ring_turns.wgsl` does the same on a device with the sums and products of this, one by one, from
//! [`Frames::packed`]: so turns are the same to the bit.

use std::sync::OnceLock;

use glam::{DVec3, Quat, Vec3};
use relievo_core::Context;
use relievo_core::simd::Level;
use relievo_surface::{Incidence, Place, RingClass, Side, Surface, TileTopology};

/// How the frame of one tile sees a vector of another: turned about the normal by an angle, and the normal turned over
/// where faces are wound against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Whether the normals are opposite.
    pub flipped: bool,
    /// The cosine of the angle from the receiving tile's T to the other's, about the receiving tile's normal.
    pub cosine: f32,
    /// Its sine.
    pub sine: f32,
}

impl Turn {
    /// The same frame, or one that differs by the normal's sign alone.
    pub const fn plain(flipped: bool) -> Self {
        Self { flipped, cosine: 1.0, sine: 0.0 }
    }

    /// The components of a vector in the receiving frame.
    pub fn apply(self, vector: DVec3) -> DVec3 {
        let (cosine, sine) = (f64::from(self.cosine), f64::from(self.sine));
        let sign = if self.flipped { -1.0 } else { 1.0 };
        let (x, y) = (vector.x, sign * vector.y);
        DVec3::new(x * cosine - y * sine, x * sine + y * cosine, sign * vector.z)
    }

    /// From the receiving frame back.
    pub fn inverse(self) -> Self {
        // A reflection undoes itself.
        Self { sine: if self.flipped { self.sine } else { -self.sine }, ..self }
    }

    /// A turn of `angle` radians.
    fn of(flipped: bool, angle: f32) -> Self {
        let (cosine, sine) = cosine_and_sine(angle);
        Self { flipped, cosine, sine }
    }
}

/// Of an angle of a few turns at most, within 1.5e-7. Taylor's series about the nearest quarter of a turn: what platforms
/// and devices have for it differs in the last bits.
fn cosine_and_sine(angle: f32) -> (f32, f32) {
    // A quarter of a turn in three numbers, of which products of the first two with small whole numbers are exact.
    const QUARTER: [f32; 3] = [1.5703125, 4.837513e-4, 7.549_79e-8];
    let quarters = (angle * std::f32::consts::FRAC_2_PI).round_ties_even();
    let r = QUARTER.iter().fold(angle, |rest, part| rest - quarters * part);
    let square = r * r;
    let series = |terms: [f32; 5]| terms.into_iter().reduce(|sum, term| term + sum * square).unwrap_or_default();
    let sine = r + r * square * series([-2.505_210_8e-8, 2.755_731_9e-6, -1.984_127e-4, 8.333_334e-3, -1.666_666_7e-1]);
    let cosine = 1.0 + square * series([-2.755_732e-7, 2.480_158_7e-5, -1.388_888_9e-3, 4.166_666_8e-2, -0.5]);
    match quarters as i32 & 3 {
        0 => (cosine, sine),
        1 => (-sine, cosine),
        2 => (-cosine, -sine),
        _ => (sine, -cosine),
    }
}

/// Steps of a side between the points at which tangents are taken.
const STEPS: usize = 32;

/// Angles from `S_u` to `S_v` along edges 1 and 3 of a tile, in the direction of v.
type Angles = Box<[[f32; STEPS + 1]; 2]>;

/// Numbers of a tile as devices have them, see [`Frames::packed`].
pub(crate) const TURN_NUMBERS: usize = 2 * (STEPS + 1) + 4 * 6;

/// How the frames of a surface's tiles are turned to each other. Made where it is asked, and kept.
#[derive(Debug)]
pub struct Frames {
    surface: Surface,
    tiles: Vec<OnceLock<Angles>>,
    rings: Vec<OnceLock<Box<[Turn]>>>,
}

impl Frames {
    /// Those of `surface` as it is posed.
    pub fn new(surface: &Surface) -> Self {
        let topology = surface.topology();
        Self {
            surface: surface.clone(),
            tiles: (0..topology.tile_count()).map(|_| OnceLock::new()).collect(),
            rings: (0..topology.ring_count()).map(|_| OnceLock::new()).collect(),
        }
    }

    /// From the frame of `other` at parameter `s` of its edge to that of `own` at parameter `t`, which is the same
    /// point.
    pub fn across(&self, (own, t): (Side, f32), (other, s): (Side, f32), reversed: bool) -> Turn {
        let (a, b) = (self.angle(own, t), self.angle(other, s));
        // Not reversed, the edges run against each other.
        Turn::of(reversed, if reversed { -b - a } else { b + std::f32::consts::PI - a })
    }

    /// From the frame of entry `from` of `ring` to that of entry `to`.
    pub fn around(&self, ring: u32, from: usize, to: usize) -> Turn {
        let turns = self.rings[ring as usize].get_or_init(|| self.turns(self.surface.topology().ring(ring)));
        let (from, to) = (turns[from], turns[to]);
        let angle = |turn: Turn| turn.sine.atan2(turn.cosine);
        let between = angle(from) - angle(to);
        Turn::of(from.flipped != to.flipped, if to.flipped { -between } else { between })
    }

    /// What a device needs of some tiles: the angles along edge 1 and along edge 3, then of every corner the cosine and sine
    /// of three turns at its vertex, to the frame of the ring's first tile, back, and from the tile whose texel the corner
    /// of a ring copies.
    pub(crate) fn packed(&self, context: &Context, tiles: &[u32]) -> Vec<[f32; TURN_NUMBERS]> {
        let topology = self.surface.topology();
        context.map(tiles.len(), |index| {
            let tile = tiles[index];
            let mut numbers = [0.0; TURN_NUMBERS];
            if topology.is_hole(tile) {
                return numbers;
            }
            let angles = self.tiles[tile as usize].get_or_init(|| self.angles(tile));
            numbers[..2 * (STEPS + 1)].copy_from_slice(angles.as_flattened());
            for (corner, turns) in (0..4).zip(numbers[2 * (STEPS + 1)..].chunks_exact_mut(6)) {
                let ring = topology.rings(tile)[usize::from(corner)];
                let own = entry_of(topology, ring, tile, Some(corner));
                let opposite = opposite(topology, ring, own).unwrap_or(own);
                for ((from, to), numbers) in
                    [(own, 0), (0, own), (opposite, own)].into_iter().zip(turns.chunks_exact_mut(2))
                {
                    let turn = self.around(ring, from, to);
                    numbers.copy_from_slice(&[turn.cosine, turn.sine]);
                }
            }
            numbers
        })
    }

    /// The angle from the direction of an edge to T, about the tile's normal.
    fn angle(&self, side: Side, t: f32) -> f32 {
        use std::f32::consts::PI;
        let between = |end: usize, v: f32| {
            let angles = &self.tiles[side.tile as usize].get_or_init(|| self.angles(side.tile))[end];
            let x = v.clamp(0.0, 1.0) * STEPS as f32;
            let step = (x as usize).min(STEPS - 1);
            angles[step] + (angles[step + 1] - angles[step]) * (x - step as f32)
        };
        match side.edge & 3 {
            0 => 0.0,
            1 => -between(0, t),
            2 => PI,
            _ => PI - between(1, 1.0 - t),
        }
    }

    fn angles(&self, tile: u32) -> Angles {
        Box::new([1.0, 0.0].map(|u| {
            std::array::from_fn(|step| {
                let (t, n, v) = tangents(&self.surface, Place::new(tile, u, step as f32 / STEPS as f32));
                n.cross(t).dot(v).atan2(t.dot(v))
            })
        }))
    }

    /// From every entry's frame to the first one's.
    fn turns(&self, entries: &[Incidence]) -> Box<[Turn]> {
        let frame = |entry: &Incidence| tangents(&self.surface, entry.place());
        let Some(first) = entries.first() else { return Box::default() };
        let (t, n, _) = frame(first);
        let turn = |entry: &Incidence| {
            let flipped = entry.flipped != first.flipped;
            let (other, normal, _) = frame(entry);
            let other = Quat::from_rotation_arc(if flipped { -normal } else { normal }, n) * other;
            Turn::of(flipped, n.cross(t).dot(other).atan2(t.dot(other)))
        };
        std::iter::once(Turn::plain(false)).chain(entries[1..].iter().map(turn)).collect()
    }
}

/// T, N and the direction of `S_v` at a place, from further inside where the tangents there make no frame.
fn tangents(surface: &Surface, place: Place) -> (Vec3, Vec3, Vec3) {
    let inner = |step: f32| Place::new(place.tile, place.u + (0.5 - place.u) * step, place.v + (0.5 - place.v) * step);
    let frame = |place: Place| {
        let sample = surface.sample(Level::Baseline, place).ok()?;
        let (u, v) = (Vec3::from(sample.du).try_normalize()?, Vec3::from(sample.dv).try_normalize()?);
        // As parallel as [`crate::quads::displaced`] takes them.
        let across = u.cross(v);
        (across.length() > 1e-6).then(|| (u, across.normalize(), v))
    };
    [0.0, 1.0 / 1024.0, 1.0 / 16.0].into_iter().find_map(|step| frame(inner(step))).unwrap_or((
        Vec3::X,
        Vec3::Z,
        Vec3::Y,
    ))
}

/// Which entry of a ring a tile is, at `corner` if it is there more than once.
pub(crate) fn entry_of(topology: &TileTopology, ring: u32, tile: u32, corner: Option<u8>) -> usize {
    let entries = topology.ring(ring);
    let at =
        |corner: u8| entries.iter().position(|entry| !entry.middle && (entry.tile, entry.corner) == (tile, corner));
    let found = corner.and_then(at).or_else(|| entries.iter().position(|entry| entry.tile == tile));
    found.unwrap_or_default()
}

/// Which entry of a ring whose texels are copied is opposite to `own`; none where there is no such.
pub(crate) fn opposite(topology: &TileTopology, ring: u32, own: usize) -> Option<usize> {
    let entries = topology.ring(ring);
    match topology.ring_class(ring) {
        // The other sub-tile in the middle of a quad's edge.
        RingClass::Tee => entries.iter().enumerate().find(|(i, entry)| *i != own && !entry.middle).map(|it| it.0),
        _ => Some((own + entries.len() / 2) % entries.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use relievo_core::Mesh;
    use relievo_surface::SurfaceOptions;

    #[test]
    fn cosines_and_sines_are_within_their_bound() {
        for step in -40_000..=40_000 {
            let angle = step as f32 / 3_000.0;
            let (cosine, sine) = cosine_and_sine(angle);
            let exact = f64::from(angle);
            let far = (f64::from(cosine) - exact.cos()).abs().max((f64::from(sine) - exact.sin()).abs());
            assert!(far < 1.5e-7, "{angle}: {far}");
        }
        assert_eq!(cosine_and_sine(0.0), (1.0, 0.0));
    }

    #[test]
    fn ways_around_a_vertex_agree_where_faces_are_wound_against_each_other() {
        // Of four squares around a point one is wound the other way.
        let points = (0..9).map(|k| [(k % 3) as f32, (k / 3) as f32, 0.1 * (k * k % 5) as f32]).collect();
        let cage = Mesh::new(points, vec![4; 4], vec![0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 7, 8, 5]);
        let surface = Surface::new(&Context::serial(), &cage, &SurfaceOptions::default()).unwrap();
        let (topology, frames) = (surface.topology(), Frames::new(&surface));
        let vector = DVec3::new(0.3, -1.5, 0.7);
        let mut flipped = 0;
        for ring in 0..topology.ring_count() as u32 {
            let entries = topology.ring(ring);
            for (from, to) in (0..entries.len()).flat_map(|from| (0..entries.len()).map(move |to| (from, to))) {
                let over = frames.around(ring, to, 0).apply(frames.around(ring, from, to).apply(vector));
                assert!((over - frames.around(ring, from, 0).apply(vector)).length() < 1e-5, "{ring} {from} {to}");
                flipped += usize::from(entries[to].flipped != entries[0].flipped);
            }
        }
        assert!(flipped > 0);
    }

    #[test]
    fn a_turn_and_its_inverse_keep_a_vector() {
        for flipped in [false, true] {
            for angle in [0.0, 0.3, 2.0, -2.5] {
                let turn = Turn::of(flipped, angle);
                let vector = DVec3::new(0.3, -1.5, 0.7);
                let there = turn.apply(vector);
                assert!((there.length() - vector.length()).abs() < 1e-6);
                assert!((turn.inverse().apply(there) - vector).length() < 1e-6);
            }
        }
        let turned = Turn::of(false, std::f32::consts::FRAC_PI_2).apply(DVec3::X);
        assert!((turned - DVec3::Y).length() < 1e-6);
    }
}
