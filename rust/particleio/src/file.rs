//! Files of particles by what they begin with, or by their extension.

use std::fmt;
use std::io::Read as _;
use std::path::Path;

use relievo_core::{Context, Error, Result, file};

use crate::particles::Particles;
use crate::read::Read;
use crate::{bgeo, frame, ply, vdb, vtk};

/// Formats that can be read and written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Frames of our own cache.
    Cache,
    /// Houdini's classic geometry.
    Bgeo,
    /// VTK's legacy form.
    Vtk,
    /// Polygon File Format.
    Ply,
    /// OpenVDB's points.
    Vdb,
}

/// The extensions of all formats, for messages.
const EXTENSIONS: &str = ".rlvfluid, .bgeo, .vtk, .ply or .vdb";

impl Format {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Cache, Self::Bgeo, Self::Vtk, Self::Ply, Self::Vdb];

    /// The extension of its files, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Cache => frame::EXTENSION,
            Self::Bgeo => "bgeo",
            Self::Vtk => "vtk",
            Self::Ply => "ply",
            Self::Vdb => "vdb",
        }
    }

    /// The format to write to `path`, by its extension.
    ///
    /// # Errors
    /// No format has that extension.
    pub fn named(path: &Path) -> Result<Self> {
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        let found = Self::ALL.into_iter().find(|format| extension.as_deref() == Some(format.extension()));
        found.ok_or_else(|| {
            Error::unsupported("the format to write is not known")
                .at(path.display().to_string())
                .advise(format!("use the extension {EXTENSIONS}"))
        })
    }

    /// The format of a file that begins with `head`, or `None` if it may be a mesh.
    ///
    /// # Errors
    /// It is of a form that is known by name and cannot be read.
    pub fn of(head: &[u8]) -> Result<Option<Self>> {
        if let Some(error) = bgeo::refusal(head).or_else(|| vtk::refusal(head)) {
            return Err(error);
        }
        Ok(match head {
            _ if head.starts_with(&frame::MAGIC) => Some(Self::Cache),
            _ if head.starts_with(bgeo::MAGIC) || head.starts_with(bgeo::GZIP) => Some(Self::Bgeo),
            _ if head.starts_with(vtk::MAGIC) => Some(Self::Vtk),
            _ if head.starts_with(&vdb::SIGNATURE.to_le_bytes()) => Some(Self::Vdb),
            _ if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") => Some(Self::Ply),
            _ => None,
        })
    }
}

impl fmt::Display for Format {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Cache => "frame of a cache",
            Self::Bgeo => "classic .bgeo",
            Self::Vtk => "legacy VTK",
            Self::Ply => "PLY",
            Self::Vdb => "OpenVDB",
        })
    }
}

/// Reads particles: of a cache, classic `.bgeo`, legacy VTK, PLY, OpenVDB's points, or the points of any mesh that can be read. The context's
/// memory limit bounds the file and what is made of it together.
///
/// # Errors
/// The file cannot be read, is damaged, or is of a form that is refused; the error names it.
pub fn read(context: &Context, path: &Path) -> Result<Read> {
    let named = |error: Error| error.at(path.display().to_string());
    let mut head = Vec::new();
    file::open(path)?.take(256).read_to_end(&mut head).map_err(|error| Error::io(path, &error))?;
    let Some(format) = Format::of(&head).map_err(named)? else {
        // What is named as a file of particles is none of the formats that the reader of meshes would advise.
        if head.is_empty() || Format::named(path).is_ok() {
            let what =
                if head.is_empty() { "the file is empty" } else { "the file does not begin as its extension says" };
            let advice = format!("use a file of particles, {EXTENSIONS}, or a mesh");
            return Err(named(Error::invalid(what).advise(advice)));
        }
        let mesh = relievo_meshio::read(context, path)?;
        let mut read = Read::default();
        read.particles = ply::from_mesh(mesh, &mut read.notes).map_err(named)?;
        return Ok(read);
    };
    let limit = context.memory_limit();
    let bytes = file::load(path, limit)?;
    let left = limit - bytes.len() as u64;
    let read = match format {
        Format::Cache => {
            frame::read_frame(context, &bytes).map(|frame| Read { particles: frame.particles, notes: Vec::new() })
        }
        Format::Bgeo => bgeo::read_bgeo(&bytes, left),
        Format::Vtk => vtk::read_vtk(&bytes, left),
        Format::Ply => ply::read_ply(&bytes, left),
        Format::Vdb => vdb::read_vdb_points(&bytes, left),
    };
    read.map_err(named)
}

/// Writes particles in the format that the extension of `path` says; a frame of a cache has no state of a solver then.
///
/// # Errors
/// As the writer of the format.
pub fn write(context: &Context, path: &Path, particles: &Particles) -> Result<()> {
    match Format::named(path)? {
        Format::Cache => frame::write_frame(context, path, particles, None),
        Format::Bgeo => crate::write_bgeo(path, particles),
        Format::Vtk => crate::write_vtk(path, particles),
        Format::Ply => crate::write_ply(path, particles),
        Format::Vdb => crate::write_vdb_points(context, path, particles),
    }
}
