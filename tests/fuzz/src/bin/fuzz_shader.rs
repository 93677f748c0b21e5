//! Shaders: lexer, annotations, rewriting of old dialects and augmentation. Every text is augmented or refused with faults that
//! point into it.
#![no_main]

use std::sync::Once;

use libfuzzer_sys::fuzz_target;
use relievo_shaderlab::{Faults, Language, Shader, Source, Stage};

/// Bytes of a text at most: front ends need time for longer ones, not other code.
const LIMIT: usize = 4 << 10;

static HOOK: Once = Once::new();

/// Lets the library catch panics of front ends, which run on threads called `shader`; every other panic ends the process.
fn catch_front_ends() {
    let ends = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().name() != Some("shader") {
            ends(info);
        }
    }));
}

fuzz_target!(|data: &[u8]| {
    HOOK.call_once(catch_front_ends);
    let [kind, data @ ..] = data else { return };
    let data = &data[..data.len().min(LIMIT)];
    let Ok(text) = std::str::from_utf8(data) else { return };
    let language = if kind & 1 == 0 { Language::Glsl } else { Language::Wgsl };
    let stage = [Stage::Vertex, Stage::Fragment, Stage::Compute][usize::from(kind >> 1) % 3];
    let read = |text: &str| Shader::new(Source::new("fuzzed", text, language, stage));
    let shader = match read(text) {
        Ok(shader) => shader,
        Err(faults) => return sound(&faults),
    };
    let variables = shader.variables();
    for variable in &variables {
        assert_eq!(&text[variable.place.clone()], variable.name);
        assert!(variable.scope.start <= variable.scope.end && variable.scope.end <= text.len());
    }
    if let Some(last) = variables.len().checked_sub(1) {
        match shader.with_vector(&[last], "1.0") {
            Ok(marked) => check(read(&marked)),
            Err(faults) => sound(&faults),
        }
    }
    if shader.is_marked() {
        check(Ok(shader));
    }
});

/// Augments a shader. The result takes vectors, and its bytes come from bytes of the text.
fn check(shader: Result<Shader, Faults>) {
    let augmented = shader.and_then(|shader| {
        let augmented = shader.augment()?;
        let length = shader.source().text.len();
        assert!(augmented.text.contains("pel_take("));
        for at in (0..augmented.text.len()).step_by(7) {
            let from = augmented.map.source(at..at + 1);
            assert!(from.start <= from.end && from.end <= length);
        }
        Ok(())
    });
    if let Err(faults) = augmented {
        sound(&faults);
    }
}

/// Fails unless there are faults that can be printed and placed.
fn sound(faults: &Faults) {
    assert!(!faults.list.is_empty() && !faults.to_string().is_empty());
    for fault in &faults.list {
        let (line, column) = faults.place(&fault.span);
        assert!(line > 0 && column > 0);
    }
}
