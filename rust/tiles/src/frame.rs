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

use std::sync::OnceLock;

use glam::{DVec3, Quat, Vec3};
use relievo_core::simd::Level;
use relievo_surface::{Incidence, Place, Side, Surface, TileTopology};

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
        Self { flipped, cosine: angle.cos(), sine: angle.sin() }
    }
}

/// Steps of a side between the points at which tangents are taken.
const STEPS: usize = 32;

/// Angles from `S_u` to `S_v` along edges 1 and 3 of a tile, in the direction of v.
type Angles = Box<[[f32; STEPS + 1]; 2]>;

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
        // As parallel as [`crate::displaced`] takes them.
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

#[cfg(test)]
mod tests {
    use super::*;

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
