//! Reading of shaders by naga's front ends, with faults at the bytes of the user's text.

use std::borrow::Cow;
use std::error::Error as _;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use crate::compact::compact;
use crate::edit::SpanMap;
use crate::fault::{Checked, Fault, Span};
use crate::lexer::tokens;
use crate::source::{Language, Stage};

/// A shader that naga has read and checked.
#[derive(Debug)]
pub(crate) struct Parsed {
    pub module: naga::Module,
    pub info: ModuleInfo,
    /// Leads from what the front end read to the text that was given.
    map: SpanMap,
}

impl Parsed {
    /// Returns the bytes of a span of the module in the text that was given.
    pub fn range(&self, span: naga::Span) -> Span {
        self.map.source(range(span))
    }
}

/// Bytes of the stack on which shaders are read. Front ends recurse for each bracket, operator and branch; the lexer bounds
/// how many there are. Only pages that are used occupy memory.
const STACK: usize = 512 << 20;

/// Runs `work` on a stack that the deepest text accepted by the lexer does not exhaust. A panic of `work` becomes `None`.
///
/// # Errors
/// The system has no memory for the stack.
pub(crate) fn on_deep_stack<T: Send>(work: impl FnOnce() -> T + Send) -> std::io::Result<Option<T>> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().name("shader".into()).stack_size(STACK);
        let handle = thread.spawn_scoped(scope, || catch_unwind(AssertUnwindSafe(work)).ok())?;
        Ok(handle.join().unwrap_or_else(|panic| resume_unwind(panic)))
    })
}

/// Reads and checks a shader. `map` leads from `text` to the user's text.
pub(crate) fn parse(text: &str, language: Language, stage: Stage, map: &SpanMap) -> Checked<Parsed> {
    match on_deep_stack(|| parse_here(text, language, stage, map)) {
        Ok(Some(parsed)) => parsed,
        Ok(None) => Err(vec![
            Fault::new(0..0, "the front end of the shading language failed on this shader")
                .advise("remove code until it is accepted, and report the shader"),
        ]),
        Err(error) => Err(vec![Fault::new(0..0, format!("there is no memory to read the shader: {error}"))]),
    }
}

fn parse_here(text: &str, language: Language, stage: Stage, map: &SpanMap) -> Checked<Parsed> {
    // The preprocessor of GLSL needs its lines.
    let (text, own) = match language {
        Language::Wgsl => {
            let (text, own) = compact(text, &tokens(text, language)?);
            (Cow::Owned(text), own)
        }
        Language::Glsl => (Cow::Borrowed(text), SpanMap::whole(text)),
    };
    let origin = |span: naga::Span| map.source(own.source(range(span)));
    let module = match language {
        Language::Wgsl => naga::front::wgsl::parse_str(&text).map_err(|error| {
            let mut labels = error.labels();
            let first = labels.next();
            let span = first.as_ref().map_or(0..0, |(span, _)| origin(*span));
            let said = first.map(|(_, label)| label).filter(|label| !label.is_empty() && *label != error.message());
            let what = match said {
                Some(label) => format!("{}: {label}", error.message()),
                None => error.message().to_owned(),
            };
            let mut fault = Fault::new(span, what);
            fault.related.extend(labels.map(|(span, label)| (origin(span), label.to_owned())));
            vec![fault]
        })?,
        Language::Glsl => {
            let options = naga::front::glsl::Options::from(stage.naga());
            naga::front::glsl::Frontend::default().parse(&options, &text).map_err(|found| {
                let list: Vec<_> =
                    found.errors.iter().map(|error| Fault::new(origin(error.meta), error.kind.to_string())).collect();
                if list.is_empty() { vec![Fault::new(0..0, "the shader cannot be read")] } else { list }
            })?
        }
    };
    let checked = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module);
    match checked {
        Ok(info) => Ok(Parsed { module, info, map: own }),
        Err(error) => {
            let mut what = error.as_inner().to_string();
            let mut cause = error.as_inner().source();
            while let Some(inner) = cause {
                what = format!("{what}: {inner}");
                cause = inner.source();
            }
            let mut spans: Vec<_> = error.spans().filter(|(span, _)| span.is_defined()).collect();
            // The last span is the innermost.
            let innermost = spans.pop();
            let mut fault = Fault::new(innermost.map_or(0..0, |(span, _)| origin(*span)), what);
            fault.related.extend(spans.into_iter().map(|(span, label)| (origin(*span), label.clone())));
            Err(vec![fault])
        }
    }
}

/// Writes a shader as WGSL, the language that devices are given, with its bind groups numbered from `first_group` on.
///
/// # Errors
/// The shader uses what WGSL lacks.
pub(crate) fn wgsl(parsed: &Parsed, first_group: u32) -> Checked<String> {
    let mut module = Cow::Borrowed(&parsed.module);
    if first_group > 0 {
        for (_, variable) in module.to_mut().global_variables.iter_mut() {
            if let Some(binding) = &mut variable.binding {
                binding.group = binding.group.saturating_add(first_group);
            }
        }
    }
    let written = on_deep_stack(|| {
        let flags = naga::back::wgsl::WriterFlags::empty();
        naga::back::wgsl::write_string(&module, &parsed.info, flags).map_err(|error| error.to_string())
    });
    let refused = |why: String| vec![Fault::new(0..0, format!("the shader cannot run on WebGPU: {why}"))];
    match written {
        Ok(Some(Ok(text))) => Ok(text),
        Ok(Some(Err(why))) => Err(refused(why)),
        Ok(None) => Err(refused("its translation to WGSL failed".into())),
        Err(error) => Err(refused(error.to_string())),
    }
}

/// Returns the entry points of a shader that have a stage handled here, with their indices.
pub(crate) fn entries(module: &naga::Module) -> impl Iterator<Item = (usize, Stage, &naga::EntryPoint)> {
    module.entry_points.iter().enumerate().filter_map(|(index, entry)| {
        let stage = [Stage::Vertex, Stage::Fragment, Stage::Compute].into_iter().find(|it| it.naga() == entry.stage);
        Some((index, stage?, entry))
    })
}

/// Returns the bytes of a span of naga.
fn range(span: naga::Span) -> Span {
    span.to_range().unwrap_or_default()
}
