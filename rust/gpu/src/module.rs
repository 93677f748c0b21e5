//! WGSL modules and their imports.
//!
//! A module is a file in a folder of `shaders/`, named by the file alone. A line `// import NAME` takes in the module
//! NAME, once, with what that imports, before the module itself; an import line therefore stands before everything else
//! of its file. Lines of the composed text are mapped back, so that messages name the file that a reader would open.
//!
//! A line `// needs NAME` says that the module calls a function NAME which modules that import it define. So one entry point
//! works on tiles and on triangles: WGSL does not ask in which order functions stand.

use std::collections::BTreeSet;

use relievo_core::{Error, Result};

/// A WGSL module.
#[derive(Clone, Copy, Debug)]
pub struct Module {
    /// The name: that of the file without its ending. No two files have the same.
    pub name: &'static str,
    /// The path of the file below `shaders/`.
    pub file: &'static str,
    /// The text of the file.
    pub text: &'static str,
}

impl Module {
    /// Whether it needs functions of the modules that import it, without which it cannot be composed.
    pub fn is_part(&self) -> bool {
        self.text.lines().any(|line| line.starts_with(NEEDS))
    }
}

/// The modules of all folders, by name.
pub const MODULES: &[Module] = include!(concat!(env!("OUT_DIR"), "/modules.rs"));

/// What begins a line that imports.
const IMPORT: &str = "// import ";

/// What begins a line that names a function of whoever imports the module.
const NEEDS: &str = "// needs ";

/// A module with all that it imports.
#[derive(Clone, Debug, Default)]
pub struct Composed {
    /// The WGSL text.
    pub text: String,
    /// For every line of the text the file it is from and its line there, from 1.
    lines: Vec<(&'static str, u32)>,
}

impl Composed {
    /// The file and line that line `line` (from 1) of the text is from.
    pub fn place(&self, line: u32) -> String {
        match self.lines.get((line as usize).saturating_sub(1)) {
            Some((file, line)) => format!("shaders/{file}:{line}"),
            None => format!("composed line {line}"),
        }
    }
}

fn source(name: &str) -> Result<&'static Module> {
    let found = MODULES.binary_search_by(|module| module.name.cmp(name));
    found.map(|at| &MODULES[at]).map_err(|_| Error::internal(format!("there is no WGSL module `{name}`")))
}

/// Returns the path of the file of module `name`, from the root of the repository.
pub fn path(name: &str) -> String {
    source(name).map_or_else(|_| name.to_owned(), |module| format!("shaders/{}", module.file))
}

/// The module `name` with all that it imports.
///
/// # Errors
/// Fails if the module or one that it imports does not exist, or a function that one needs is defined by none.
pub fn compose(name: &str) -> Result<Composed> {
    let mut composed = Composed::default();
    append(name, &mut BTreeSet::new(), &mut composed)?;
    let needed = (1..).zip(composed.text.lines()).filter_map(|(line, text)| Some((line, text.strip_prefix(NEEDS)?)));
    for (line, function) in needed {
        if !composed.text.contains(&format!("\nfn {function}(")) {
            return Err(Error::internal(format!("the WGSL module `{name}` does not define `{function}`"))
                .at(composed.place(line)));
        }
    }
    Ok(composed)
}

fn append(name: &str, seen: &mut BTreeSet<&'static str>, composed: &mut Composed) -> Result<()> {
    let Module { name, file, text } = *source(name)?;
    if !seen.insert(name) {
        return Ok(());
    }
    for imported in text.lines().filter_map(|line| line.strip_prefix(IMPORT)) {
        append(imported.trim(), seen, composed).map_err(|error| error.at(format!("shaders/{file}")))?;
    }
    for (line, text) in (1..).zip(text.lines()) {
        composed.text.push_str(text);
        composed.text.push('\n');
        composed.lines.push((file, line));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga;

    #[test]
    fn names_are_in_order_and_no_two_files_share_one() {
        assert!(!MODULES.is_empty());
        assert!(MODULES.is_sorted_by(|a, b| a.name < b.name));
    }

    #[test]
    fn every_module_is_valid() {
        use naga::valid::{Capabilities, ValidationFlags, Validator};
        // A module that needs functions is valid with each one that defines them.
        for Module { name, file, .. } in MODULES.iter().filter(|module| !module.is_part()) {
            let composed = compose(name).expect("its imports");
            let place = |line: Option<u32>| line.map_or((*file).to_owned(), |line| composed.place(line));
            let module = naga::front::wgsl::parse_str(&composed.text).unwrap_or_else(|error| {
                let line = error.location(&composed.text).map(|at| at.line_number);
                panic!("{}: {}", place(line), error.emit_to_string(&composed.text))
            });
            let capabilities = Capabilities::IMMEDIATES | Capabilities::SHADER_FLOAT16_IN_FLOAT32;
            let checked = Validator::new(ValidationFlags::all(), capabilities).validate(&module);
            if let Err(error) = checked {
                let line = error.location(&composed.text).map(|at| at.line_number);
                panic!("{}: {}", place(line), error.emit_to_string(&composed.text));
            }
        }
    }

    #[test]
    fn a_function_that_nobody_defines_is_named_with_its_place() {
        let error = compose("imprint_rim_list").expect_err("an error").to_string();
        assert!(error.contains("is_at_border") && error.contains("imprint_rim_list.wgsl:2"), "{error}");
        assert!(compose("imprint_rim_cells").is_ok() && compose("triangle_imprint_rim_cells").is_ok());
    }

    #[test]
    fn imports_come_once_and_lines_are_mapped_back() {
        let composed = compose("sort").expect("its imports");
        assert_eq!(composed.text.matches("fn linear_group").count(), 1);
        let line = |text: &str, start: &str| {
            let found = text.lines().position(|line| line.starts_with(start));
            found.expect("the line") as u32 + 1
        };
        for (name, start) in [("common", "fn linear_group"), ("sort", "@compute")] {
            let Module { file, text, .. } = source(name).expect("the module");
            let place = composed.place(line(&composed.text, start));
            assert_eq!(place, format!("shaders/{file}:{}", line(text, start)));
        }
        assert_eq!(composed.text.lines().count(), composed.lines.len());
    }
}
