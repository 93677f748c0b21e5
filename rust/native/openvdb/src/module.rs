//! Opens the module over OpenVDB, once per process, when it is first needed.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

use libloading::Library;
use relievo_core::{Error, ErrorKind, Result};

use crate::abi::{self, Rlvdb};
use crate::call;

/// The environment variable that names the file of the module.
pub const VARIABLE: &str = "RELIEVO_OPENVDB";
/// What to do where there is no module.
pub const ADVICE: &str =
    "install the package relievo-openvdb, or set RELIEVO_OPENVDB to the file librelievo_openvdb.so";
/// The file of the module, as CMake names modules.
const FILE: &str = if cfg!(windows) { "librelievo_openvdb.dll" } else { "librelievo_openvdb.so" };

/// The module over OpenVDB. It stays loaded until the process ends.
pub struct Module {
    table: Rlvdb,
    path: PathBuf,
}

static MODULE: OnceLock<Module> = OnceLock::new();
/// Held while the module is opened, so that it is opened once.
static OPENING: Mutex<()> = Mutex::new(());

impl Module {
    /// Returns the module, which is opened at the first call. A failure is not kept: the next call tries again.
    ///
    /// # Errors
    /// Fails with [`ErrorKind::NotFound`] if there is no module, and [`ErrorKind::Unsupported`] if it belongs to
    /// another version of Relievo.
    pub fn open() -> Result<&'static Self> {
        if let Some(module) = MODULE.get() {
            return Ok(module);
        }
        let _guard = OPENING.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(module) = MODULE.get() {
            return Ok(module);
        }
        let module = Self::find()?;
        Ok(MODULE.get_or_init(|| module))
    }

    /// Whether the module was opened before.
    pub fn is_open() -> bool {
        MODULE.get().is_some()
    }

    /// Returns the file that was opened.
    pub fn path(&self) -> &std::path::Path {
        &self.path
    }

    /// Returns major, minor and patch version of OpenVDB.
    pub fn library_version(&self) -> [u32; 3] {
        // SAFETY: the function takes nothing and only returns a number.
        let version = unsafe { self.table.rlvdb_library_version() };
        [version >> 16, version >> 8 & 0xff, version & 0xff]
    }

    pub(crate) fn table(&self) -> &Rlvdb {
        &self.table
    }

    fn find() -> Result<Self> {
        if let Some(path) = std::env::var_os(VARIABLE) {
            return Self::load(path.into());
        }
        for path in places() {
            if path.is_file() {
                return Self::load(path);
            }
        }
        // The loader's own path.
        Self::load(FILE.into())
    }

    fn load(path: PathBuf) -> Result<Self> {
        let named = |error: Error| error.at(path.display().to_string());
        let had_logging = is_loaded("liblog4cplus");
        // SAFETY: the module has no constructors of its own; those of OpenVDB and log4cplus have run in other programs'
        // plugins for years. RTLD_LOCAL keeps its names from all others, and it is never closed.
        let library = unsafe { open(&path) }.map_err(|error| {
            let cause = std::error::Error::source(&error).map_or(error.to_string(), ToString::to_string);
            named(Error::new(ErrorKind::NotFound, format!("there is no OpenVDB module: {cause}")).advise(ADVICE))
        })?;
        // SAFETY: the symbols of the module have the types of its header; which header that was is checked next, before
        // anything else is called.
        let table = unsafe { Rlvdb::from_library(library) }.map_err(|error| {
            named(Error::unsupported(format!("it is not the OpenVDB module of this version: {error}")).advise(ADVICE))
        })?;
        // SAFETY: the function takes nothing and only returns a number.
        let version = unsafe { table.rlvdb_version() };
        if version != abi::RLVDB_VERSION {
            let what = format!("the OpenVDB module has version {version}, and {} is needed", abi::RLVDB_VERSION);
            return Err(named(
                Error::unsupported(what).advise("install relievo-openvdb of the same version as Relievo"),
            ));
        }
        let mut error = call::record();
        // log4cplus starts threads when it is loaded; nobody else uses it if it was not there before.
        // SAFETY: the record lives through the call.
        let result = unsafe { table.rlvdb_initialize(i32::from(!had_logging), &mut error) };
        call::check(result, &error).map_err(named)?;
        Ok(Self { table, path })
    }
}

/// Opens a library with local symbols.
///
/// # Safety
/// Its initialisers run.
#[cfg(unix)]
unsafe fn open(path: &Path) -> std::result::Result<Library, libloading::Error> {
    use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
    // SAFETY: the caller vouches for the initialisers.
    unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map(Into::into)
}

/// Opens a library.
///
/// # Safety
/// Its initialisers run.
#[cfg(not(unix))]
unsafe fn open(path: &Path) -> std::result::Result<Library, libloading::Error> {
    // SAFETY: the caller vouches for the initialisers.
    unsafe { Library::new(path) }
}

/// Returns where the module may lie: beside the library or program that this code is in, in its `../lib`, in the
/// subfolder `relievo` of both, and in Debian's folder for it.
fn places() -> Vec<PathBuf> {
    let mut folders = Vec::new();
    for file in [own_file(), std::env::current_exe().ok()].into_iter().flatten() {
        if let Some(folder) = file.parent() {
            folders.push(folder.to_owned());
            // Test programs lie in a subfolder of the build.
            folders.push(folder.join(".."));
            folders.push(folder.join("../lib"));
            folders.push(folder.join("../lib").join(TRIPLET));
        }
    }
    folders.push(PathBuf::from("/usr/lib").join(TRIPLET));
    folders.iter().flat_map(|folder| [folder.join(FILE), folder.join("relievo").join(FILE)]).collect()
}

/// The name of Debian's folder for libraries of this architecture.
#[cfg(target_arch = "aarch64")]
const TRIPLET: &str = "aarch64-linux-gnu";
#[cfg(not(target_arch = "aarch64"))]
const TRIPLET: &str = "x86_64-linux-gnu";

/// Returns the file of the library or program that this function is in.
fn own_file() -> Option<PathBuf> {
    let address = own_file as *const () as usize;
    let (path, _) = mappings()?.into_iter().find(|(_, range)| range.contains(&address))?;
    Some(path.into())
}

/// Whether a library whose file begins like this is in the process.
fn is_loaded(name: &str) -> bool {
    let file = |path: &str| path.rsplit('/').next().is_some_and(|file| file.starts_with(name));
    mappings().is_some_and(|list| list.iter().any(|(path, _)| file(path)))
}

/// Returns the files that are mapped into the process, with their addresses.
fn mappings() -> Option<Vec<(String, std::ops::Range<usize>)>> {
    let text = std::fs::read_to_string("/proc/self/maps").ok()?;
    let line = |line: &str| {
        let (low, high) = line.split_once(' ')?.0.split_once('-')?;
        let address = |text: &str| usize::from_str_radix(text, 16).ok();
        let path = line.get(line.find('/')?..)?;
        Some((path.to_owned(), address(low)?..address(high)?))
    };
    Some(text.lines().filter_map(line).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_of_this_code_is_the_test_program() {
        assert_eq!(own_file(), std::env::current_exe().ok());
        assert!(is_loaded("libc.so") && !is_loaded("libnothing"));
    }
}
