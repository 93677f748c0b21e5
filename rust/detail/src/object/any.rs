//! An object over either kind of surface, for hosts that learn the kind when they open a mesh or a document.

use relievo_core::{Context, Error, Mesh, Result};
use relievo_document::Document;

use crate::channels::layered::LayeredObject;
use crate::object::DisplacedObject;
use crate::object::canvas::Canvas;
use crate::triangle::TriangleObject;

/// An object over a Catmull-Clark surface or over a triangle mesh.
#[derive(Debug)]
pub enum AnyObject {
    /// Over the limit surface of a cage.
    Tiles(Box<DisplacedObject>),
    /// Over the triangles of a mesh.
    Triangles(Box<TriangleObject>),
}

/// Evaluates an expression with the object inside an [`AnyObject`], whichever its kind is.
#[macro_export]
macro_rules! with_object {
    ($object:expr, $name:ident => $body:expr) => {
        match $object {
            $crate::AnyObject::Tiles($name) => $body,
            $crate::AnyObject::Triangles($name) => $body,
        }
    };
}

impl AnyObject {
    /// Returns what strokes are made on.
    pub fn canvas(&mut self) -> &mut dyn Canvas {
        with_object!(self, object => &mut **object)
    }

    /// Returns the error that made the processor take over from the graphics device, once.
    pub fn take_device_fault(&mut self) -> Option<Error> {
        with_object!(self, object => object.take_device_fault())
    }

    /// Brings layers and normals up to date after edits. Returns the tiles or faces that budgets refused.
    ///
    /// # Errors
    /// Fails as [`LayeredObject::settle`].
    pub fn settle(&mut self, context: &Context) -> Result<Vec<u32>> {
        let refused = with_object!(self, object => LayeredObject::settle(&mut **object, context))?;
        match self {
            Self::Tiles(_) => {}
            Self::Triangles(object) => object.renew(context)?,
        }
        Ok(refused)
    }

    /// Checks that a document was made on `mesh`, as an object of this kind. Returns what the user should know.
    ///
    /// # Errors
    /// Fails with `Invalid` if the document is of the other kind or of another mesh.
    pub fn fit(&self, document: &Document, mesh: &Mesh) -> Result<Option<String>> {
        match self {
            Self::Tiles(_) => document.fit(mesh),
            Self::Triangles(_) => document.fit_triangles(mesh).map(|()| None),
        }
    }

    /// Makes a document of its layers; [`LayeredObject::settle`] is to be done before.
    ///
    /// # Errors
    /// Fails with `Invalid` if the mesh is not the one it was made of, and as [`LayeredObject::store`].
    pub fn document(&self, context: &Context, mesh: &Mesh) -> Result<Document> {
        let level = context.level().name();
        let mut document = match self {
            Self::Tiles(_) => Document::new(mesh, level)?,
            Self::Triangles(_) => Document::of_triangles(mesh, level)?,
        };
        with_object!(self, object => object.store(context, &mut document))?;
        Ok(document)
    }
}
