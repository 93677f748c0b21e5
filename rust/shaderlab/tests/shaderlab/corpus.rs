//! Every shader of this repository is read, and augmented where it has float variables.

use std::path::Path;

use relievo_gpu::module::{MODULES, compose};
use relievo_shaderlab::{Language, Shader, Source, Stage};

#[test]
fn every_kernel_is_augmented() {
    let (mut augmented, mut entered) = (0, 0);
    for module in MODULES {
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
