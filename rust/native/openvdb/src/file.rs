//! Grids from and to files.

use std::path::Path;

use relievo_core::{Context, Error, ErrorKind, Progress, Result};

use crate::abi;
use crate::call;
use crate::grid::{Grid, zero_ended};
use crate::info::Entry;
use crate::module::Module;
use crate::survey::Survey;

/// A box in world units, lowest and highest corner.
pub type Box3 = [[f64; 3]; 2];

/// How values are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packing {
    /// By zlib.
    pub zip: bool,
    /// Values of active voxels alone, where a node has at most two others.
    pub active: bool,
    /// By Blosc.
    pub blosc: bool,
}

impl Default for Packing {
    /// As OpenVDB packs by default.
    fn default() -> Self {
        Self { zip: false, active: true, blosc: true }
    }
}

impl Packing {
    pub(crate) fn bits(self) -> u32 {
        let Self { zip, active, blosc } = self;
        let flags = [(zip, abi::RLVDB_ZIP), (active, abi::RLVDB_ACTIVE), (blosc, abi::RLVDB_BLOSC)];
        flags.iter().filter(|(is_on, _)| *is_on).map(|(_, flag)| flag).sum()
    }
}

/// How a file is written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Writing {
    /// How values are packed.
    pub packing: Packing,
    /// Leaves out places of grids, as `openvdb::io::Stream` does.
    pub is_stream: bool,
    /// Metadata of the file.
    pub metadata: Vec<Entry>,
}

/// Reads a grid of a file: the one of a name, or the first that can be read. With `bounds` leaves that do not touch the box are
/// skipped; voxels outside of it are background.
///
/// The file is checked first.
///
/// # Errors
/// Fails with `NotFound` if the file or the grid does not exist, with `Io` if the file cannot be read, with `Invalid`
/// if it is damaged or `bounds` are empty or not finite, with `Unsupported` for a grid of another kind or a name used
/// twice, with `Memory` above the context's memory limit, with `Cancelled` if `progress` asks to stop, and as
/// [`Module::open`] does.
pub fn read(
    context: &Context,
    path: &Path,
    name: Option<&str>,
    bounds: Option<Box3>,
    progress: &mut dyn Progress,
) -> Result<Grid> {
    let named = |error: Error| error.at(path.display().to_string());
    let limit = context.memory_limit();
    let survey = Survey::of_file(path, limit)?;
    let index = survey.find(name).map_err(named)?;
    let unique = survey.check(path, index, limit).map_err(named)?;
    if let Some([low, high]) = bounds
        && !(0..3).all(|axis| low[axis] <= high[axis] && low[axis].is_finite() && high[axis].is_finite())
    {
        return Err(Error::invalid("the box is empty or not finite").at("bounds"));
    }
    let module = Module::open()?;
    let (file, unique) = (path_text(path)?, zero_ended("name", unique)?);
    let ends = bounds.map(|bounds| bounds.as_flattened().to_vec());
    let ends = ends.as_ref().map_or(std::ptr::null(), Vec::as_ptr);
    let read = Grid::long(context, "read grid", progress, |out, how, error| {
        // SAFETY: the texts end with zeros, the box is NULL or six numbers, and all live through the call. The file was
        // checked.
        unsafe { module.table().rlvdb_read(file.as_ptr(), unique.as_ptr(), ends, how, out, error) }
    });
    read.map_err(|error| match error.kind {
        // What OpenVDB finds wrong is the file's fault.
        ErrorKind::Internal => named(Error { kind: ErrorKind::Invalid, ..error }),
        _ => named(error),
    })
}

/// Writes grids to a file, which appears whole or not at all.
///
/// # Errors
/// Fails with `Invalid` if there is no grid or a text holds a zero byte, with `Io` or `NotFound` if the folder takes no
/// file, with `Internal` if OpenVDB cannot write it, with `Cancelled` if `progress` asks to stop, and as
/// [`Module::open`] does.
pub fn write(
    context: &Context,
    path: &Path,
    grids: &[&Grid],
    writing: &Writing,
    progress: &mut dyn Progress,
) -> Result<()> {
    if grids.is_empty() {
        return Err(Error::invalid("there is no grid to write").at(path.display().to_string()));
    }
    let module = Module::open()?;
    let failed = |error: std::io::Error| Error::io(path, &error).advise("check the folder, its rights and its space");
    let texts = writing.metadata.iter().flat_map(|Entry { name, kind, value }| [name, kind, value]);
    let texts = texts.map(|text| zero_ended("metadata", text)).collect::<Result<Vec<_>>>()?;
    let texts: Vec<_> = texts.iter().map(|text| text.as_ptr()).collect();
    let pointers: Vec<_> = grids.iter().map(|grid| grid.pointer()).collect();
    let temporary = temporary(path).map_err(failed)?;
    let file = path_text(&temporary)?;
    let packing = writing.packing.bits() | if writing.is_stream { abi::RLVDB_STREAM } else { 0 };
    call::run(context, "write grids", progress, |how, error| {
        let (grids, count, entries) = (pointers.as_ptr(), pointers.len(), writing.metadata.len());
        // SAFETY: the path ends with a zero, the grids are alive, there are three texts of each entry, and all live through
        // the call.
        unsafe {
            let table = module.table();
            table.rlvdb_write(file.as_ptr(), grids, count, packing, texts.as_ptr(), entries, how, error)
        }
    })
    .map_err(|error| error.at(path.display().to_string()))?;
    temporary.persist(path).map_err(|error| failed(error.error))
}

/// Makes a file of another name in the same folder, which is gone if it is not given its name.
pub(crate) fn temporary(path: &Path) -> std::io::Result<tempfile::TempPath> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".relievo-").suffix(".vdb");
    #[cfg(unix)]
    {
        // As any new file, not only for its owner; the process's mask still applies.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    Ok(builder.tempfile_in(folder)?.into_temp_path())
}

/// Returns a path as text with a zero behind it.
pub(crate) fn path_text(path: &Path) -> Result<std::ffi::CString> {
    std::ffi::CString::new(path.as_os_str().as_encoded_bytes())
        .map_err(|_| Error::invalid("the name of the file has a zero in it"))
}
