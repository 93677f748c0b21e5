//! Objects that decals are written into, over either kind of surface: what they are laid on, and where recipes keep pins.
//!
//! A displaced Catmull-Clark surface is divided equally everywhere, so that recipes keep pins on the faces of that
//! tessellation. A triangle mesh is divided as finely as its layers are, which edits change: recipes keep its pins on the faces
//! of the mesh itself, by their barycentric coordinates there.

use relievo_core::{Context, Error, Mesh, Result};
use relievo_detail::{DisplacedObject, LayeredObject, TriangleObject};
use relievo_document::Settings;
use relievo_tiles::triangle::TriangleTessellation;
use relievo_tiles::{Tessellation, uniform_rates};

use crate::artwork::Artwork;
use crate::decal::Decal;
use crate::pins::Place;
use crate::print::recipe::Ink;
use crate::print::triangle_print::TrianglePrint;
use crate::print::{Print, Printed};

/// An object that decals are written into.
pub trait Printable: LayeredObject {
    /// The triangles of its displaced surface, with their places on it.
    type Triangles;

    /// Divides the displaced surface of the object into triangles. `mesh` is the cage or the triangle mesh that the object
    /// was made from; `cells` are those along an edge of a cage.
    ///
    /// # Errors
    /// The mesh is another one, or memory does not suffice.
    fn triangles(&mut self, context: &Context, mesh: &Mesh, cells: u32) -> Result<Self::Triangles>;

    /// Returns the triangles as a mesh, which a sticker is laid on.
    fn mesh(triangles: &Self::Triangles) -> &Mesh;

    /// Returns the place that a recipe keeps for a place on the triangles.
    ///
    /// # Errors
    /// There is no such triangle.
    fn kept(triangles: &Self::Triangles, place: Place) -> Result<Place>;

    /// Returns the place on the triangles that a recipe keeps.
    ///
    /// # Errors
    /// The surface has no such face.
    fn found(triangles: &Self::Triangles, place: Place) -> Result<Place>;

    /// Writes a decal on the triangles into the active layer of its kind.
    ///
    /// # Errors
    /// As [`Print::paint`] and [`Print::emboss`].
    fn print(
        &mut self,
        context: &Context,
        triangles: &Self::Triangles,
        decal: (&Decal, &Artwork, &[f64]),
        ink: Ink,
        settings: &Settings,
    ) -> Result<Printed>;
}

impl Printable for DisplacedObject {
    type Triangles = Tessellation;

    fn triangles(&mut self, context: &Context, mesh: &Mesh, cells: u32) -> Result<Tessellation> {
        let rates = uniform_rates(self.surface().topology(), cells);
        self.displaced()?.tessellate(context, mesh, &rates)
    }

    fn mesh(triangles: &Tessellation) -> &Mesh {
        &triangles.mesh
    }

    fn kept(_triangles: &Tessellation, place: Place) -> Result<Place> {
        Ok(place)
    }

    fn found(_triangles: &Tessellation, place: Place) -> Result<Place> {
        Ok(place)
    }

    fn print(
        &mut self,
        context: &Context,
        tessellation: &Tessellation,
        (decal, artwork, depths): (&Decal, &Artwork, &[f64]),
        ink: Ink,
        settings: &Settings,
    ) -> Result<Printed> {
        let print = Print { context, tessellation, decal, artwork, depths };
        match ink {
            Ink::Color => print.paint(self, settings),
            Ink::Relief(height) => print.emboss(self, height, settings),
        }
    }
}

impl Printable for TriangleObject {
    type Triangles = TriangleTessellation;

    fn triangles(&mut self, context: &Context, mesh: &Mesh, _cells: u32) -> Result<TriangleTessellation> {
        self.renew(context)?;
        TriangleTessellation::new(context, &self.displaced()?, self.normals(), mesh, |face| self.rates(face))
    }

    fn mesh(triangles: &TriangleTessellation) -> &Mesh {
        &triangles.mesh
    }

    fn kept(triangles: &TriangleTessellation, Place { face, barycentric }: Place) -> Result<Place> {
        let first = 3 * face as usize;
        let tile = triangles.tiles.get(face as usize).zip(triangles.parameters.get(first..first + 3));
        let (tile, corners) = tile.ok_or_else(|| no_face(face))?;
        let sum: f64 = barycentric.iter().sum();
        let [u, v] = [0, 1].map(|axis| {
            let weighted = corners.iter().zip(barycentric);
            weighted.map(|(corner, weight)| weight / sum * f64::from(corner[axis])).sum::<f64>()
        });
        Ok(Place { face: *tile, barycentric: [1.0 - u - v, u, v].map(|weight| weight.max(0.0)) })
    }

    fn found(triangles: &TriangleTessellation, Place { face, barycentric }: Place) -> Result<Place> {
        let sum: f64 = barycentric.iter().sum();
        let place = [barycentric[1] / sum, barycentric[2] / sum];
        let first = triangles.tiles.partition_point(|tile| *tile < face);
        let parts = triangles.tiles[first..].iter().take_while(|tile| **tile == face).count();
        let corners = triangles.parameters.as_chunks::<3>().0;
        let least = |weights: &[f64; 3]| weights.iter().fold(f64::INFINITY, |least, weight| least.min(*weight));
        let best = (first..first + parts)
            .filter_map(|part| Some((part, shares(corners.get(part)?, place)?)))
            .max_by(|a, b| least(&a.1).total_cmp(&least(&b.1)));
        let (part, shares) = best.ok_or_else(|| no_face(face))?;
        Ok(Place { face: part as u32, barycentric: shares.map(|share| share.max(0.0)) })
    }

    fn print(
        &mut self,
        context: &Context,
        ground: &TriangleTessellation,
        (decal, artwork, depths): (&Decal, &Artwork, &[f64]),
        ink: Ink,
        settings: &Settings,
    ) -> Result<Printed> {
        let print = TrianglePrint { context, ground, decal, artwork, depths };
        match ink {
            Ink::Color => print.paint(self, settings),
            Ink::Relief(height) => print.emboss(self, height, settings),
        }
    }
}

fn no_face(face: u32) -> Error {
    Error::invalid(format!("face {face} does not exist")).advise("give the mesh that the decal was laid on")
}

/// The barycentric coordinates of a place of the plane in a triangle; `None` of one without area.
fn shares(corners: &[[f32; 2]; 3], [u, v]: [f64; 2]) -> Option<[f64; 3]> {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let twice = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let (whole, at) = (twice(a, b, c), [u, v]);
    let shares = [twice(b, c, at), twice(c, a, at), twice(a, b, at)].map(|share| share / whole);
    shares.iter().all(|share| share.is_finite()).then_some(shares)
}
