//! Files of shaders and what is read beside them by several tasks of `relievo shader`.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use relievo_core::Result;
use relievo_shaderlab::{Faults, Shader, Source};

use crate::Outcome;

/// Prints the faults of a shader with their lines and ends the command.
pub fn refused(faults: &Faults) -> Outcome {
    let _ = write!(std::io::stderr(), "{faults}");
    Ok(ExitCode::FAILURE)
}

/// Evaluates to the value of a result with faults, or ends the command after they are printed.
macro_rules! sound {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(faults) => return $crate::shader::source::refused(&faults),
        }
    };
}
pub(super) use sound;

/// Reads a shader file.
pub fn read(path: &Path) -> Result<std::result::Result<Shader, Faults>> {
    Ok(Shader::new(Source::read(path)?))
}

/// Writes a text to a file, which appears whole or not at all.
pub fn store(path: &Path, text: &str) -> Result<()> {
    relievo_core::file::store(path, |file| file.write_all(text.as_bytes()))
}

/// Reads a column and a row.
pub fn pixel(text: &str) -> std::result::Result<[u32; 2], String> {
    let numbers: Vec<_> = text.split(',').map(|part| part.trim().parse::<u32>()).collect();
    match numbers.as_slice() {
        [Ok(x), Ok(y)] => Ok([*x, *y]),
        _ => Err(format!("{text:?} is not a column and a row, such as 120,80")),
    }
}
