//! Every shader of this repository is read, and augmented where it has float variables.

use std::path::{Path, PathBuf};
use std::time::Instant;

use relievo_gpu::module::{MODULES, compose};
use relievo_shaderlab::{Faults, Language, Shader, Source, Stage};

#[test]
fn every_kernel_is_augmented() {
    let (mut augmented, mut entered) = (0, 0);
    // What a module needs of its importers comes with them.
    for module in MODULES.iter().filter(|module| !module.is_part()) {
        let text = compose(module.name).unwrap().text;
        let source = Source::new(module.file, text, Language::Wgsl, Stage::Compute);
        let shader = Shader::new(source).unwrap_or_else(|faults| panic!("{faults}"));
        let entries: Vec<_> = shader.entries().into_iter().map(|entry| entry.name).collect();
        if entries.is_empty() {
            continue;
        }
        entered += 1;
        let variables = shader.variables();
        // The last variable of an entry point.
        let chosen = variables.iter().rposition(|it| it.function.as_ref().is_some_and(|name| entries.contains(name)));
        let Some(chosen) = chosen else { continue };
        let marked = shader.with_vector(&[chosen], "1.0").unwrap_or_else(|faults| panic!("{faults}"));
        let source = Source::new(module.file, marked, Language::Wgsl, Stage::Compute);
        let marked = Shader::new(source).unwrap_or_else(|faults| panic!("{faults}"));
        let result = marked.augment().unwrap_or_else(|faults| panic!("{faults}"));
        assert_eq!(result.features.len(), variables[chosen].components as usize);
        // The augmentation checks what it changed; here the whole text is checked.
        let module = naga::front::wgsl::parse_str(&result.text).unwrap_or_else(|error| panic!("{error}"));
        let flags = naga::valid::ValidationFlags::all();
        let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::all());
        validator.validate(&module).unwrap_or_else(|error| panic!("{error}"));
        augmented += 1;
    }
    assert!(entered > 60 && augmented > 20, "{augmented} of {entered}");
}

#[test]
fn every_example_is_augmented() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/shaders");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if Source::kind_of(&path).is_none() {
            continue;
        }
        let shader = Shader::new(Source::read(&path).unwrap()).unwrap_or_else(|faults| panic!("{faults}"));
        let marked = match shader.is_marked() {
            true => shader,
            false => {
                let last = shader.variables().len() - 1;
                let text = shader.with_vector(&[last], "1.0").unwrap_or_else(|faults| panic!("{faults}"));
                let Source { name, language, stage, .. } = shader.source().clone();
                Shader::new(Source::new(name, text, language, stage)).unwrap_or_else(|faults| panic!("{faults}"))
            }
        };
        let augmented = marked.augment().unwrap_or_else(|faults| panic!("{faults}"));
        augmented.wgsl(&marked).unwrap_or_else(|faults| panic!("{faults}"));
        count += 1;
    }
    assert!(count >= 4, "{count}");
}

/// Returns the shaders in a folder and those below it, in order.
fn shaders(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => shaders(&path, found),
            false => found.extend(Source::kind_of(&path).is_some().then_some(path)),
        }
    }
    found.sort();
}

/// Reads a shader, marks its last variable in an entry point, or else its last one, and augments it.
fn explore(path: &Path) -> Result<bool, Faults> {
    let source = Source::read(path).unwrap_or_else(|error| panic!("{error}"));
    let shader = Shader::new(source.clone())?;
    let mut entries: Vec<_> = shader.entries().into_iter().map(|entry| entry.name).collect();
    entries.push("mainImage".to_owned());
    let variables = shader.variables();
    let in_entry = variables.iter().rposition(|it| it.function.as_ref().is_some_and(|name| entries.contains(name)));
    let Some(chosen) = in_entry.or_else(|| variables.iter().rposition(|it| it.function.is_none())) else {
        return Ok(false);
    };
    let marked = shader.with_vector(&[chosen], "1.0")?;
    let shader = Shader::new(Source::new(source.name, marked, source.language, source.stage))?;
    shader.augment().map(|_| true)
}

/// Shaders of others, in the folder that the environment variable `RELIEVO_SHADERS` names: at most one in forty is refused, and
/// with its place.
#[test]
fn public_shaders_are_augmented() {
    let Some(folder) = std::env::var_os("RELIEVO_SHADERS") else {
        eprintln!("skipped: RELIEVO_SHADERS names no folder");
        return;
    };
    let mut paths = Vec::new();
    shaders(Path::new(&folder), &mut paths);
    let (mut refused, mut plain, mut times) = (0, 0, Vec::new());
    for path in &paths {
        let start = Instant::now();
        let outcome = explore(path);
        times.push(1e3 * start.elapsed().as_secs_f64());
        match outcome {
            Ok(true) => {}
            Ok(false) => plain += 1,
            Err(faults) => {
                refused += 1;
                assert!(faults.list[0].span.end <= faults.source.text.len());
                let (line, column) = faults.place(&faults.list[0].span);
                eprintln!("{}:{line}:{column}: {}", path.display(), faults.list[0].what);
            }
        }
    }
    times.sort_by(f64::total_cmp);
    let (median, slowest) = (times[times.len() / 2], times[times.len() - 1]);
    eprintln!(
        "{} shaders, {plain} without a float variable, {refused} refused; reading twice and augmenting: median {median:.2} ms, \
         slowest {slowest:.2} ms",
        paths.len()
    );
    assert!(40 * refused <= paths.len());
}
