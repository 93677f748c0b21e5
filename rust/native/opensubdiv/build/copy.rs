//! A copy of OpenSubdiv's shared library whose names no other library in a process has: its namespace is renamed in the
//! dynamic symbols, so that the dynamic linker binds what it calls of itself to itself.
//!
//! The new name of the namespace is as long as the old one, so names of types within the data are renamed in place, and no
//! section moves. OpenMP goes: only evaluators that Relievo has no use for call it.

use object::build::elf::{Builder, Dynamic, SectionData, VersionId};
use object::elf;

/// The namespace in OpenSubdiv's headers, and in the copy.
pub const THEIRS: &str = "OpenSubdiv";
pub const OURS: &str = "RelievoOsd";
/// The same in mangled names.
pub const MANGLED: [&str; 2] = ["10OpenSubdiv", "10RelievoOsd"];

/// The SONAME of the copy.
const SONAME: &str = "librelievo_osd.so";
/// The library of OpenMP, and how its functions start.
const OPENMP: &str = "libgomp.so.1";
const PARALLEL: [&[u8]; 2] = [b"GOMP_", b"omp_"];

/// Makes the copy of a library.
pub fn made(original: &[u8]) -> Result<Vec<u8>, String> {
    let mut builder = Builder::read(original).map_err(|error| error.to_string())?;
    for symbol in &mut builder.dynamic_symbols {
        // Linkers for AArch64 leave symbols of sections there, which nothing looks up: in the new table of hashes they would
        // have a place.
        symbol.delete |= symbol.st_type() == elf::STT_SECTION;
        if let Some(name) = renamed(&symbol.name) {
            symbol.name = name.into();
        }
        if PARALLEL.iter().any(|start| symbol.name.starts_with(start)) {
            symbol.set_st_info(elf::STB_WEAK, symbol.st_type());
            symbol.version = VersionId::global();
        }
    }
    let entries = builder.dynamic_data_mut().ok_or("it has no dynamic section")?;
    entries
        .retain(|entry| !matches!(entry, Dynamic::String { tag: elf::DT_NEEDED, val } if **val == *OPENMP.as_bytes()));
    for entry in entries {
        if let Dynamic::String { tag: elf::DT_SONAME, val } = entry {
            *val = SONAME.as_bytes().into();
        }
    }
    builder.delete_unused_versions();
    for section in &mut builder.sections {
        if let SectionData::Data(data) = &mut section.data
            && let Some(new) = renamed(data)
        {
            *data = new.into();
        }
    }
    fit(&mut builder)?;
    let mut copy = Vec::new();
    builder.write(&mut copy).map_err(|error| error.to_string())?;
    Ok(copy)
}

/// Gives every section its new size; none may grow, because the next ones stay where they are.
fn fit(builder: &mut Builder<'_>) -> Result<(), String> {
    let sizes: Vec<u64> = builder.sections.iter().map(|section| section.sh_size).collect();
    builder.set_section_sizes();
    for (section, size) in builder.sections.iter().zip(sizes) {
        if section.sh_size > size {
            return Err(format!("the section {} would grow from {size} bytes to {}", section.name, section.sh_size));
        }
    }
    Ok(())
}

/// Bytes with the namespace renamed, if they have it.
fn renamed(bytes: &[u8]) -> Option<Vec<u8>> {
    let [from, to] = MANGLED.map(str::as_bytes);
    let mut places =
        bytes.windows(from.len()).enumerate().filter(|(_, part)| *part == from).map(|(at, _)| at).peekable();
    places.peek()?;
    let mut out = bytes.to_vec();
    for at in places {
        out[at..at + to.len()].copy_from_slice(to);
    }
    Some(out)
}
