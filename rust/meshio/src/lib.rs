//! Readers and writers of mesh files: OBJ, PLY, glTF and USD both ways, STL and OFF in; and of Bézier patches.
//!
//! Files are hostile until read: every size is checked against the file's length and the memory limit before anything
//! is allocated, every index before it is used. Errors name the file and the line or element.
//!
//! USD needs the feature `openusd`. Without it the same functions fail and say so.

mod color;
mod corners;
mod gltf;
mod instancers;
mod merge;
mod model;
mod notes;
mod obj;
mod off;
mod patches;
mod ply;
mod pose;
mod root;
mod stage_options;
mod stl;
mod summary;
mod text;
mod transform;
#[cfg(feature = "openusd")]
mod usd;
#[cfg(not(feature = "openusd"))]
mod usd_absent;
#[cfg(feature = "openusd")]
mod usd_writer;

use std::io::Read;
use std::path::Path;

use relievo_core::{Context, Error, Mesh, Result, budget, file};

pub use gltf::glb_levels::{Joint, JointClip, Levels, write_glb_levels};
pub use gltf::glb_writer::{Instance, write_glb};
pub use gltf::{Open, read_gltf};
pub use instancers::{Copied, PointInstancer};
pub use model::{Animation, Channel, Interpolation, Model, Node, Part, Placement, Property, ShapeKeys, Skin};
pub use obj::read_obj;
pub use obj::writer::write_obj;
pub use off::read_off;
pub use off::writer::write_off;
pub use patches::{Patches, parse_patches, read_patches, write_bpt};
pub use ply::read_ply;
pub use ply::writer::{write_ply, write_points_ply};
pub use pose::{Pose, Shape};
pub use root::Root;
pub use stage_options::StageOptions;
pub use stl::read_stl;
pub use stl::writer::write_stl;
pub use summary::Summary;
pub use transform::{Kind, Operation};
#[cfg(feature = "openusd")]
pub use usd::{read_usd, read_usd_instancers};
#[cfg(not(feature = "openusd"))]
pub use usd_absent::{StageWriter, read_usd, read_usd_instancers, write_usd};
#[cfg(feature = "openusd")]
pub use usd_writer::{StageWriter, write_usd};

/// The first bytes of a binary layer of USD.
const USD_MAGIC: &[u8] = b"PXR-USDC";

/// The first bytes of a file that gzip packed.
const GZIP_MAGIC: &[u8] = b"\x1f\x8b";

/// Formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Obj,
    Ply,
    Gltf,
    Stl,
    Off,
    Usd,
    Patches,
}

impl Format {
    /// The format that the first bytes of a file show, or else its extension, in letters of any case.
    fn of(extension: &str, bytes: &[u8]) -> Result<Self> {
        if bytes.starts_with(b"glTF") {
            return Ok(Self::Gltf);
        }
        if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            return Ok(Self::Ply);
        }
        if bytes.starts_with(USD_MAGIC) || bytes.starts_with(b"#usda ") {
            return Ok(Self::Usd);
        }
        match extension.to_ascii_lowercase().as_str() {
            "obj" => Ok(Self::Obj),
            "ply" => Ok(Self::Ply),
            "glb" | "gltf" => Ok(Self::Gltf),
            "stl" => Ok(Self::Stl),
            "off" => Ok(Self::Off),
            "usd" | "usda" | "usdc" | "usdz" => Ok(Self::Usd),
            "bpt" => Ok(Self::Patches),
            _ if patches::is_patches(bytes) => Ok(Self::Patches),
            _ => Err(Error::unsupported("the format of the file is not known")
                .advise("use OBJ, PLY, GLB, glTF, USD, STL or OFF")),
        }
    }
}

/// The extension of a path, without the dot; empty if it has none.
fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Returns the extension and the bytes of a file, unpacked if gzip packed it: `.ply.gz` has the extension `ply`.
///
/// # Errors
/// The file cannot be read, is damaged, or has more than `limit` bytes packed and unpacked together.
fn load(path: &Path, limit: u64) -> Result<(String, Vec<u8>)> {
    let named = |error: Error| error.at(path.display().to_string());
    let packed = file::load(path, limit)?;
    if !packed.starts_with(GZIP_MAGIC) {
        return Ok((extension(path), packed));
    }
    let left = limit - packed.len() as u64;
    let mut bytes = Vec::new();
    let mut reader = flate2::read::MultiGzDecoder::new(packed.as_slice()).take(left.saturating_add(1));
    let mut piece = vec![0; 1 << 16];
    loop {
        let count = match reader.read(&mut piece) {
            Ok(0) => break,
            Ok(count) => count,
            Err(error) => {
                let what = format!("the file packed by gzip is damaged: {error}");
                return Err(named(Error::invalid(what).advise("pack it again")));
            }
        };
        if bytes.len() as u64 + count as u64 > left || bytes.try_reserve(count).is_err() {
            let what = format!("the file is larger than the memory limit of {limit} bytes when it is unpacked");
            return Err(named(Error::memory(what).advise("raise the memory limit, or split the file")));
        }
        bytes.extend_from_slice(&piece[..count]);
    }
    Ok((extension(&path.with_extension("")), bytes))
}

/// Whether the file at `path` holds Bézier patches, by its extension or its first lines.
///
/// # Errors
/// The file cannot be read.
pub fn holds_patches(path: &Path) -> Result<bool> {
    let mut head = Vec::new();
    let file = file::open(path)?;
    file.take(4096).read_to_end(&mut head).map_err(|error| Error::io(path, &error))?;
    Ok(!head.starts_with(GZIP_MAGIC) && matches!(Format::of(&extension(path), &head), Ok(Format::Patches)))
}

/// Reads a file as one mesh, at rest if it is animated. See [`read_model`].
///
/// # Errors
/// Fails as [`read_model`] and [`Model::merged_mesh`] do.
pub fn read(context: &Context, path: &Path) -> Result<Mesh> {
    let model = read_model(context, path)?;
    model.into_merged_mesh(context).map_err(|error| error.at(path.display().to_string()))
}

/// Reads everything a file holds, unpacked if gzip packed it (`.ply.gz`). Files that it names are opened only below its own folder.
///
/// The context's memory limit bounds the file and what is made of it together. Indices are in range and numbers
/// finite in what is returned; whether the faces can be used says [`Mesh::check`].
///
/// # Errors
/// Fails with `NotFound` or `Io` if the file does not exist or cannot be read, with `Invalid` if it is damaged, with
/// `Unsupported` if its format or a part of it is not known, and with `Memory` above the memory limit.
pub fn read_model(context: &Context, path: &Path) -> Result<Model> {
    let folder = path.parent().unwrap_or(Path::new(""));
    read_model_within(context, path, &Root::below(folder)?)
}

/// Reads the point instancers of a USD stage; files that it names are opened only below its own folder.
///
/// # Errors
/// The file is no USD stage, or as [`read_usd_instancers`].
pub fn read_point_instancers(context: &Context, path: &Path) -> Result<Vec<PointInstancer>> {
    let named = |error: Error| error.at(path.display().to_string());
    let limit = context.memory_limit();
    let (extension, bytes) = load(path, limit)?;
    if Format::of(&extension, &bytes).map_err(named)? != Format::Usd {
        return Err(named(Error::unsupported("the file is no USD stage").advise("give .usda, .usdc or .usd")));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let left = limit - bytes.len() as u64;
    read_usd_instancers(bytes, left, folder, &Root::below(folder)?).map_err(named)
}

/// As [`read_model`]; files that it names are opened only where `root` allows.
///
/// # Errors
/// Fails as [`read_model`] does, and with `Invalid` if the file needs one that `root` does not allow.
pub fn read_model_within(context: &Context, path: &Path, root: &Root) -> Result<Model> {
    let named = |error: Error| error.at(path.display().to_string());
    let limit = context.memory_limit();
    let (extension, bytes) = load(path, limit)?;
    let left = limit - bytes.len() as u64;
    let folder = path.parent().unwrap_or(Path::new(""));
    decode(&extension, bytes, left, (folder, root)).map_err(named)
}

/// Reads the bytes of a file as one mesh, at rest if it is animated. `extension` is that of the file, without the dot, for
/// formats that do not begin with a sign of their own.
///
/// # Errors
/// As [`read`], with the memory limit for what is made of the bytes; or the file needs another one.
pub fn parse(context: &Context, extension: &str, bytes: Vec<u8>) -> Result<Mesh> {
    let model = decode(extension, bytes, context.memory_limit(), (Path::new(""), &Root::none()))?;
    model.into_merged_mesh(context)
}

/// Reads everything that bytes hold; files that they name from a folder are opened where a root allows.
fn decode(extension: &str, bytes: Vec<u8>, left: u64, (folder, root): (&Path, &Root)) -> Result<Model> {
    let open = |name: &str, most: u64| file::load(&root.resolve(folder, name)?, most);
    match Format::of(extension, &bytes)? {
        Format::Patches => Err(Error::unsupported("the file holds Bézier patches and no mesh")
            .advise("make a mesh of it by `relievo mesh tessellate`")),
        Format::Obj => read_obj(&bytes, left),
        Format::Ply => read_ply(&bytes, left),
        Format::Gltf => read_gltf(&bytes, left, &open),
        Format::Stl => read_stl(&bytes, left),
        Format::Off => read_off(&bytes, left),
        Format::Usd => read_usd(bytes, left, folder, root),
    }
}

/// Writes a mesh as OBJ, PLY, GLB, USD, STL or OFF, as the extension of the path says. See [`write_obj`], [`write_ply`],
/// [`write_glb`], [`write_usd`], [`write_stl`] and [`write_off`].
///
/// # Errors
/// Fails with `Unsupported` if the extension is another, and as the function of the format does.
pub fn write(path: &Path, mesh: &Mesh) -> Result<()> {
    match extension(path).to_ascii_lowercase().as_str() {
        "obj" => write_obj(path, mesh, &[]),
        "ply" => write_ply(path, mesh),
        "glb" => write_glb(path, &[Instance::new("mesh", mesh)]),
        "usd" | "usda" => write_usd(path, &[Instance::new("mesh", mesh)], &StageOptions::default()),
        "stl" => write_stl(path, mesh),
        "off" => write_off(path, mesh),
        _ => Err(Error::unsupported("the format to write is not known")
            .at(path.display().to_string())
            .advise("use the extension .obj, .ply, .glb, .usda, .stl or .off")),
    }
}

/// The bytes of the file that [`write`] would write with the extension `obj`, `ply` or `glb`, in letters of any case.
///
/// # Errors
/// As [`write`], or the extension is another.
pub fn to_bytes(extension: &str, mesh: &Mesh) -> Result<Vec<u8>> {
    match extension.to_ascii_lowercase().as_str() {
        "obj" => obj::writer::obj_bytes(mesh),
        "ply" => ply::writer::ply_bytes(mesh),
        "glb" => gltf::glb_writer::glb_bytes(&[Instance::new("mesh", mesh)]),
        other => Err(Error::unsupported(format!("bytes of the format {other:?} are not written"))
            .at("format")
            .advise("use obj, ply or glb")),
    }
}
