//! What a surface is: a Catmull-Clark limit surface, whose tiles are squares, or a triangle mesh, whose tiles are its
//! faces with u and v the barycentric coordinates of their second and third corner.

use std::ops::Range;
use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_surface::{Surface, TriangleSurface};

/// A surface in one pose.
#[derive(Clone)]
pub enum Shape {
    /// The limit surface of a cage.
    Tiles(Surface),
    /// A triangle mesh.
    Triangles(Arc<TriangleSurface>),
}

/// What triangle meshes do not have.
pub fn only_cages(what: &str) -> Error {
    Error::unsupported(format!("triangle meshes have no {what}")).advise("use a surface of RLV_SURFACE_CATMULL_CLARK")
}

impl Shape {
    pub fn tile_count(&self) -> usize {
        match self {
            Self::Tiles(surface) => surface.tile_count(),
            Self::Triangles(surface) => surface.topology().face_count(),
        }
    }

    /// Checks that `tile` exists.
    ///
    /// # Errors
    /// Fails with `Invalid` if it does not.
    pub fn check_tile(&self, tile: u32) -> Result<()> {
        if (tile as usize) < self.tile_count() {
            return Ok(());
        }
        Err(Error::invalid(format!("tile {tile} does not exist"))
            .at("tile")
            .advise(format!("the surface has {} tiles", self.tile_count())))
    }

    /// Checks that the place exists.
    ///
    /// # Errors
    /// Fails with `Invalid` if the tile does not exist, or u and v are outside of it.
    pub fn check_place(&self, tile: u32, [u, v]: [f32; 2]) -> Result<()> {
        self.check_tile(tile)?;
        let inside = (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v);
        let (fits, remedy) = match self {
            Self::Tiles(_) => (inside, "use u and v from 0 to 1"),
            Self::Triangles(_) => {
                (inside && u + v <= 1.0 + SLACK, "use u and v from 0 to 1 that make at most 1 together")
            }
        };
        if fits { Ok(()) } else { Err(Error::invalid(format!("({u}, {v}) is outside the tile")).advise(remedy)) }
    }

    /// The face of the mesh that a tile is on, or a part of.
    pub fn face(&self, tile: u32) -> u32 {
        match self {
            Self::Tiles(surface) => surface.topology().face(tile),
            Self::Triangles(surface) => surface.topology().polygon(tile),
        }
    }

    /// The tiles of a face of the mesh, which exists; faces that are holes of a triangle mesh have none.
    pub fn tiles_of(&self, face: u32) -> Range<u32> {
        match self {
            Self::Tiles(surface) => surface.topology().tiles_of(face),
            Self::Triangles(surface) => {
                let topology = surface.topology();
                let count = topology.face_count() as u32;
                // Triangles are in the order of the polygons they are of.
                let first = |wanted: u32| {
                    let (mut low, mut high) = (0, count);
                    while low < high {
                        let middle = low + (high - low) / 2;
                        if topology.polygon(middle) < wanted { low = middle + 1 } else { high = middle }
                    }
                    low
                };
                first(face)..first(face.saturating_add(1))
            }
        }
    }

    /// Points of the mesh it was made from.
    pub fn point_count(&self) -> usize {
        match self {
            Self::Tiles(surface) => surface.table().cage_point_count(),
            Self::Triangles(surface) => surface.topology().vertex_count(),
        }
    }

    /// Conservative bounds of a tile without displacement.
    pub fn tile_bounds(&self, tile: u32) -> ([f32; 3], [f32; 3]) {
        match self {
            Self::Tiles(surface) => surface.tile_bounds(tile),
            Self::Triangles(surface) => bounds(&surface.corner_points(tile)),
        }
    }

    /// Conservative bounds without displacement.
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        match self {
            Self::Tiles(surface) => surface.bounds(),
            Self::Triangles(surface) => bounds(surface.points()),
        }
    }

    /// The limit surface.
    ///
    /// # Errors
    /// Fails with `Unsupported`, naming `what` it is wanted for, if it is a triangle mesh.
    pub fn tiles(&self, what: &str) -> Result<&Surface> {
        match self {
            Self::Tiles(surface) => Ok(surface),
            Self::Triangles(_) => Err(only_cages(what)),
        }
    }

    /// The same in another pose.
    ///
    /// # Errors
    /// Fails with `Invalid` if there are not as many points or one is not finite.
    pub fn posed(&self, context: &Context, points: &[[f32; 3]]) -> Result<Self> {
        Ok(match self {
            Self::Tiles(surface) => Self::Tiles(surface.posed(context, points)?),
            Self::Triangles(surface) => Self::Triangles(Arc::new(surface.posed(context, points)?)),
        })
    }
}

/// What rounding may leave of a sum that is to be 1.
pub const SLACK: f32 = 1e-6;

/// The barycentric coordinates of a place of a face. What is on a side is so exactly.
pub fn barycentric(u: f32, v: f32) -> [f32; 3] {
    let rest = 1.0 - u - v;
    [if rest < SLACK { 0.0 } else { rest }, u, v]
}

fn bounds(points: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let both = points.iter().map(|point| (*point, *point));
    both.reduce(union).unwrap_or_default()
}

/// The bounds of both.
pub fn union(a: ([f32; 3], [f32; 3]), b: ([f32; 3], [f32; 3])) -> ([f32; 3], [f32; 3]) {
    (std::array::from_fn(|axis| a.0[axis].min(b.0[axis])), std::array::from_fn(|axis| a.1[axis].max(b.1[axis])))
}
