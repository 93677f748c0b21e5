//! The shapes of a description: meshes of files, displaced by documents or not, boxes and spheres.

use std::fmt::{self, Formatter};
use std::path::{Path, PathBuf};

use glam::Vec3;
use relievo_core::{Context, Error, Result, file};
use relievo_fluid::{cuboid, sphere};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, Visitor};

use crate::files::Source;

/// Cells along an edge of the cage of a displaced surface, where they are not said: as `relievo doc export` has them.
const CELLS: u32 = 16;

/// A box by its corners, in metres.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Corners {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    middle: [f32; 3],
    radius: f32,
}

impl Ball {
    /// Returns its volume in cubic metres.
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * f64::from(self.radius).powi(3)
    }
}

/// Points in metres and triangles of them.
pub type Triangles = (Vec<Vec3>, Vec<[u32; 3]>);

/// A mesh file, or a surface that a document displaces: `"chair.obj"`, or `{ file = "cage.obj", document =
/// "bark.relievo", cells = 8 }`.
#[derive(Clone, Debug)]
pub struct MeshFile {
    /// The mesh; of a sequence, the pattern of its names.
    pub file: String,
    displaced: Option<Displaced>,
}

/// What displaces a mesh.
#[derive(Clone, Debug)]
struct Displaced {
    document: PathBuf,
    /// The layer to take; left out, all as they are seen together.
    layer: Option<String>,
    cells: u32,
}

/// The long form of a mesh file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    file: String,
    document: PathBuf,
    layer: Option<String>,
    cells: Option<u32>,
}

impl<'de> Deserialize<'de> for MeshFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = MeshFile;

            fn expecting(&self, out: &mut Formatter<'_>) -> fmt::Result {
                out.write_str("a file, or { file = \"…\", document = \"…\" }")
            }

            fn visit_str<E>(self, file: &str) -> std::result::Result<MeshFile, E> {
                Ok(MeshFile { file: file.to_owned(), displaced: None })
            }

            fn visit_map<M: MapAccess<'de>>(self, map: M) -> std::result::Result<MeshFile, M::Error> {
                let Table { file, document, layer, cells } = Table::deserialize(MapAccessDeserializer::new(map))?;
                let displaced = Displaced { document, layer, cells: cells.unwrap_or(CELLS) };
                Ok(MeshFile { file, displaced: Some(displaced) })
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl MeshFile {
    /// Lists the files that it is read from.
    pub fn files(&self) -> Vec<PathBuf> {
        let document = self.displaced.iter().map(|displaced| displaced.document.clone());
        std::iter::once(PathBuf::from(&self.file)).chain(document).collect()
    }

    /// The same of another mesh file.
    pub fn with(&self, file: String) -> Self {
        Self { file, displaced: self.displaced.clone() }
    }

    /// Its triangles; `files` finds what it names.
    pub fn triangles(&self, context: &Context, files: &Source) -> Result<Triangles> {
        let mut mesh = relievo_meshio::read(context, &files.path(Path::new(&self.file))?)?;
        if let Some(Displaced { document, layer, cells }) = &self.displaced {
            mesh = files.displaced(context, document, &mesh, (layer.as_deref(), *cells))?;
        }
        Ok((mesh.points.iter().map(|point| Vec3::from(*point)).collect(), mesh.triangles()))
    }

    /// What decides its shape: of the mesh a checksum of points and triangles, whichever files they come from and
    /// whatever else these have, and of the document that of its bytes.
    pub fn checksums(&self, context: &Context, files: &Source) -> Result<Vec<String>> {
        let (points, triangles) = self.with_mesh_alone().triangles(context, files)?;
        let places = points.iter().flat_map(|point| point.to_array()).flat_map(f32::to_le_bytes);
        let bytes: Vec<u8> = places.chain(triangles.into_flattened().into_iter().flat_map(u32::to_le_bytes)).collect();
        let mut lines = vec![line(&bytes, Path::new(&self.file))];
        if let Some(Displaced { document, .. }) = &self.displaced {
            lines.push(checksum(context, files, document)?);
        }
        Ok(lines)
    }

    fn with_mesh_alone(&self) -> Self {
        Self { file: self.file.clone(), displaced: None }
    }
}

/// The checksum of a file.
pub fn checksum(context: &Context, files: &Source, name: &Path) -> Result<String> {
    Ok(line(&file::load(&files.path(name)?, context.memory_limit())?, name))
}

fn line(bytes: &[u8], name: &Path) -> String {
    format!("{:08x} {} {}", crc32fast::hash(bytes), bytes.len(), name.display())
}

/// A mesh file, a box or a sphere.
pub struct Shape<'a> {
    pub mesh: Option<&'a MeshFile>,
    pub corners: Option<&'a Corners>,
    pub sphere: Option<&'a Ball>,
}

impl Shape<'_> {
    /// Its triangles; `files` finds what it names.
    pub fn triangles(&self, context: &Context, files: &Source) -> Result<Triangles> {
        match (self.mesh, self.corners, self.sphere) {
            (Some(mesh), None, None) => mesh.triangles(context, files),
            (None, Some(Corners { low, high }), None) => Ok(cuboid(Vec3::from(*low), Vec3::from(*high))),
            (None, None, Some(Ball { middle, radius })) => Ok(sphere(Vec3::from(*middle), *radius)),
            _ => Err(Error::invalid("it has no shape, or more than one").advise("give it one of mesh, box and sphere")),
        }
    }
}
