//! Augmentation: the annotations of a shader become code that takes, logs and judges vectors (Section 4.1).

use std::collections::{BTreeSet, HashSet};

use crate::accumulation::Accumulation;
use crate::annotation::Meaning;
use crate::edit::{Edit, Part, SpanMap, apply};
use crate::fault::{Checked, Fault, Faults, Span};
use crate::front::{Parsed, entries, parse, wgsl};
use crate::instrument::{Instrument, glsl_place};
use crate::lexer::{Kind, Token};
use crate::outline::Function;
use crate::shader::Shader;
use crate::source::{Language, Source, Stage};

/// A feature of the vectors of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Feature {
    /// What users call it: the name that an annotation gives the variable, or the expression.
    pub name: String,
    /// The expression, as in the first annotation `vector`.
    pub expression: String,
    /// The description of the variable; may be empty.
    pub description: String,
}

/// A place where a shader takes a vector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Site {
    /// The bytes of the annotation.
    pub span: Span,
    /// The function around it.
    pub function: String,
}

/// An augmented shader.
#[derive(Debug)]
pub struct Augmented {
    /// The text, in the language of the shader.
    pub text: String,
    /// The features of its vectors.
    pub features: Vec<Feature>,
    /// How the vectors of a pixel are accumulated.
    pub accumulation: Accumulation,
    /// Where vectors are taken.
    pub sites: Vec<Site>,
    /// Whether the shader uses `confidence`, so that examples change its picture.
    pub uses_confidence: bool,
    /// The bind group (descriptor set) of the two buffers.
    pub group: u32,
    /// The binding of the buffer of examples; the log has the next one.
    pub binding: u32,
    /// Which bytes of the text come from which bytes of the user's text.
    pub map: SpanMap,
    /// The module of the text, where `is_whole`; otherwise functions without vectors return zero in it.
    pub(crate) parsed: Parsed,
    is_whole: bool,
}

/// Bind groups that every device has.
const GROUPS: u32 = 4;

impl Shader {
    /// Augments the shader. The result is checked by the front end again; its faults lie at the annotations.
    ///
    /// # Errors
    /// Fails with faults at the annotations if the shader takes no vector, if its vectors differ in length, if an
    /// annotation stands where no statement can, or if an expression is no float.
    pub fn augment(&self) -> Result<Augmented, Faults> {
        self.augmented().map_err(Faults::of(self.source()))
    }

    fn augmented(&self) -> Checked<Augmented> {
        let (features, accumulation) = self.features()?;
        let [group, binding] = free_place(&self.parsed.module);
        let instrument = Instrument { features: features.len(), accumulation, group, binding };
        let mut edits = self.dialect.edits.clone();
        let (mut sites, mut uses_confidence, mut faults) = (Vec::new(), false, Vec::new());
        for annotation in &self.annotations {
            let span = annotation.span.clone();
            match &annotation.meaning {
                Meaning::Vector { features, weight } => match self.check_statement(annotation.token) {
                    Ok(function) => {
                        sites.push(Site { span: span.clone(), function });
                        edits.push(Edit { span, parts: self.take(features, weight) });
                    }
                    Err(fault) => faults.push(fault),
                },
                Meaning::Code { code, confidence } => {
                    if self.outline.function_at(span.start).is_none() {
                        faults.push(Fault::new(span, "the confidence is used outside of functions"));
                        continue;
                    }
                    uses_confidence = true;
                    edits.push(Edit { span, parts: self.judge(code, confidence) });
                }
                Meaning::Accumulation(_) | Meaning::Name(_) | Meaning::Description(_) => {}
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let ends = self.begin(&mut edits)?;
        let code = instrument.code(self.source.language, ends.is_some()) + ends.as_deref().unwrap_or_default();
        let text = &*self.source.text;
        match self.source.language {
            // At the end, where it moves no line of the user.
            Language::Wgsl => edits.push(Edit::insert(text.len(), code)),
            Language::Glsl => edits[self.dialect.prelude].parts.push(Part::New(code)),
        }
        // Inserted code of users can branch, and what it calls then matters to how control flows.
        let settled = if uses_confidence { Vec::new() } else { self.settled(&edits) };
        let is_whole = settled.is_empty();
        let checked = (!is_whole).then(|| apply(text, [edits.clone(), settled].concat()));
        let (text, map) = apply(text, edits);
        let (read, origin) = checked.as_ref().map_or((&text, &map), |(read, origin)| (read, origin));
        let parsed = parse(read, self.source.language, self.source.stage, origin)?;
        Ok(Augmented { text, features, accumulation, sites, uses_confidence, group, binding, map, parsed, is_whole })
    }

    /// Returns edits that leave of each function that `edits` do not change, and that calls none which they do, a body that
    /// returns zero: the front end has accepted these functions already, and only how they are called is to be checked again.
    ///
    /// Functions of GLSL can share a name and stay. So do those whose effects reach their callers beyond a value: `discard`,
    /// and what needs uniform control flow.
    fn settled(&self, edits: &[Edit]) -> Vec<Edit> {
        if self.source.language == Language::Glsl {
            return Vec::new();
        }
        let Parsed { module, info, .. } = &self.parsed;
        let is_changed = |function: &Function| edits.iter().any(|edit| function.body.contains(&edit.span.start));
        let changed: BTreeSet<&str> =
            self.outline.functions.iter().filter(|it| is_changed(it)).map(|it| it.name.as_str()).collect();
        let (mut reaching, mut settled) = (HashSet::new(), HashSet::new());
        // A module lists a function after the functions that it calls.
        for (handle, function) in module.functions.iter() {
            let name = function.name.as_deref().unwrap_or_default();
            let own = &info[handle];
            if changed.contains(name) || calls(&function.body).iter().any(|called| reaching.contains(called)) {
                reaching.insert(handle);
            } else if !own.may_kill && own.uniformity.requirements.is_empty() {
                settled.insert(name);
            }
        }
        let settle = |function: &Function| {
            let head = function.parameters.end..function.body.start;
            let first = self.tokens.partition_point(|token| token.span.start < head.start);
            let code = self.tokens[first..].iter().take_while(|token| token.span.start < head.end);
            let result: String =
                code.filter(|it| !it.is_comment()).map(|token| token.text(&self.source.text)).collect();
            let body = match result.strip_prefix("->") {
                Some(result) => format!("{{return {result}();}}"),
                None => "{}".to_owned(),
            };
            Edit::replace(function.body.clone(), body)
        };
        self.outline.functions.iter().filter(|it| settled.contains(it.name.as_str())).map(settle).collect()
    }

    /// Returns the features and the accumulation that the annotations state.
    fn features(&self) -> Checked<(Vec<Feature>, Accumulation)> {
        let mut faults = Vec::new();
        let mut first: Option<(&Vec<Span>, &Span)> = None;
        let mut accumulation: Option<(Accumulation, &Span)> = None;
        for annotation in &self.annotations {
            let span = &annotation.span;
            match &annotation.meaning {
                Meaning::Vector { features, .. } => match first {
                    None => first = Some((features, span)),
                    Some((other, place)) if other.len() != features.len() => {
                        let what = format!("this vector has {} features, another {}", features.len(), other.len());
                        let fault = Fault::new(span.clone(), what).relate(place.clone(), "the other vector");
                        faults.push(fault.advise("take the same features everywhere"));
                    }
                    Some(_) => {}
                },
                Meaning::Accumulation(way) => match accumulation {
                    None => accumulation = Some((*way, span)),
                    Some((other, place)) if other != *way => {
                        let fault = Fault::new(span.clone(), "the accumulation is stated twice");
                        faults.push(fault.relate(place.clone(), "stated here first").advise("remove one of them"));
                    }
                    Some(_) => {}
                },
                _ => {}
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let Some((list, _)) = first else {
            let fault = Fault::new(0..0, "the shader takes no vector");
            return Err(vec![fault.advise("add an annotation such as //. vector value; 1.0 behind a statement")]);
        };
        let variables = self.variables();
        let features = list.iter().map(|span| {
            let expression = self.slice(span).to_owned();
            let is_seen = |at: &Span| at.start <= span.start && span.start <= at.end;
            let named = variables.iter().rev().find(|it| it.name == expression && is_seen(&it.scope));
            Feature {
                name: named.and_then(|it| it.label.clone()).unwrap_or_else(|| expression.clone()),
                description: named.and_then(|it| it.description.clone()).unwrap_or_default(),
                expression,
            }
        });
        Ok((features.collect(), accumulation.map(|(way, _)| way).unwrap_or_default()))
    }

    /// Returns the function around an annotation, checked to stand between statements.
    fn check_statement(&self, token: usize) -> Result<String, Fault> {
        let text = &*self.source.text;
        let annotation = self.tokens[token].span.clone();
        let Some(function) = self.outline.function_at(annotation.start) else {
            let fault = Fault::new(annotation, "a vector is taken outside of functions");
            return Err(fault.advise("move the annotation into a function"));
        };
        let is_code = |token: &&crate::lexer::Token| !token.is_comment();
        let before = self.tokens[..token].iter().rev().find(is_code).map_or("", |token| token.text(text));
        let after = self.tokens[token + 1..].iter().find(is_code).map_or("", |token| token.text(text));
        if !matches!(before, ";" | "{" | "}" | ":") || matches!(after, "else" | "continuing") {
            let fault = Fault::new(annotation, "a vector is taken within a statement");
            return Err(fault.advise("move the annotation between two statements, and put branches into braces"));
        }
        Ok(self.outline.functions[function].name.clone())
    }

    /// Returns the statement that takes a vector.
    fn take(&self, features: &[Span], weight: &Span) -> Vec<Part> {
        let code = |span: &Span| self.dialect.code(&self.source.text, span.clone());
        let mut parts = vec![Part::New("{".into())];
        for (index, feature) in features.iter().enumerate() {
            parts.push(Part::New(format!(" pel_vector[{index}] = ")));
            parts.extend(code(feature));
            parts.push(Part::New(";".into()));
        }
        parts.push(Part::New(" pel_take(".into()));
        parts.extend(code(weight));
        parts.push(Part::New("); }".into()));
        parts
    }

    /// Returns code with the membership in place of the word `confidence`.
    fn judge(&self, code: &Span, confidence: &[Span]) -> Vec<Part> {
        let mut parts = vec![Part::New(" ".into())];
        let mut at = code.start;
        for word in confidence {
            parts.extend(self.dialect.code(&self.source.text, at..word.start));
            parts.push(Part::New("pel_confidence()".into()));
            at = word.end;
        }
        parts.extend(self.dialect.code(&self.source.text, at..code.end));
        parts.push(Part::New(" ".into()));
        parts
    }

    /// Adds to the entry points the call that states which pixel or vertex an invocation computes, and to those of vertices one
    /// that states where the vertex lies. Returns the functions that the latter need, if there is an entry point of vertices.
    fn begin(&self, edits: &mut Vec<Edit>) -> Checked<Option<String>> {
        let text = &*self.source.text;
        if self.source.language == Language::Glsl {
            let is_vertex = self.source.stage == Stage::Vertex;
            let begin = if is_vertex { "pel_begin_vertex" } else { "pel_begin" };
            let call = format!(" {begin}({});", glsl_place(self.source.stage));
            if let Some([head, tail]) = &self.dialect.wrapper {
                edits.push(Edit::insert(text.len(), format!("{head}{call}\n{tail}")));
                return Ok(None);
            }
            return match self.outline.functions.iter().find(|function| function.name == "main") {
                Some(main) => {
                    edits.push(Edit::insert(main.body.start + 1, call));
                    if is_vertex {
                        self.end_main(main, edits);
                    }
                    Ok(is_vertex.then(String::new))
                }
                None => Err(vec![Fault::new(0..0, "the shader has no function `main`")]),
            };
        }
        let takes = |meaning: &Meaning| matches!(meaning, Meaning::Vector { .. });
        let becomes_code = |meaning: &Meaning| takes(meaning) || matches!(meaning, Meaning::Code { .. });
        let (mut is_begun, mut ends) = (false, None);
        for (_, stage, entry) in entries(&self.parsed.module) {
            if !self.is_annotated(entry, becomes_code) {
                continue;
            }
            let Some(function) = self.outline.functions.iter().find(|function| function.name == entry.name) else {
                continue;
            };
            let (place, parameters) = wgsl_place(&self.parsed.module, stage, entry);
            if !parameters.is_empty() {
                let comma = if entry.function.arguments.is_empty() { "" } else { ", " };
                let parameters = format!("{}{comma}", parameters.join(", "));
                edits.push(Edit::insert(function.parameters.start + 1, parameters));
            }
            is_begun = true;
            let begin = if stage == Stage::Vertex { "pel_begin_vertex" } else { "pel_begin" };
            edits.push(Edit::insert(function.body.start + 1, format!(" {begin}({place});")));
            if stage == Stage::Vertex {
                let code: &mut String = ends.get_or_insert_default();
                if self.is_annotated(entry, takes) {
                    code.push_str(&self.end_entry(entry, function, edits));
                }
            }
        }
        if is_begun {
            return Ok(ends);
        }
        let fault = Fault::new(0..0, "no entry point of the shader takes a vector");
        Err(vec![fault.advise("call the annotated function from a vertex, fragment or compute entry point")])
    }

    /// Returns the bytes of each `return` in a function, from the word to its `;`.
    fn returns(&self, function: &Function) -> Vec<Span> {
        let text = &*self.source.text;
        let is_inside = |token: &&Token| function.body.contains(&token.span.start) && token.kind != Kind::Directive;
        let mut code = self.tokens.iter().filter(is_inside).filter(|token| !token.is_comment());
        let mut found = Vec::new();
        while let Some(word) = code.find(|token| token.text(text) == "return") {
            if let Some(end) = code.find(|token| token.text(text) == ";") {
                found.push(word.span.start..end.span.start);
            }
        }
        found
    }

    /// States the position of a vertex wherever the `main` of a GLSL shader ends.
    fn end_main(&self, main: &Function, edits: &mut Vec<Edit>) {
        const CALL: &str = "pel_end_vertex(gl_Position);";
        let returns = self.returns(main);
        for span in &returns {
            edits.push(Edit::insert(span.start, format!("{{ {CALL} ")));
            edits.push(Edit::insert(span.end + 1, " }"));
        }
        let text = &*self.source.text;
        let close = main.body.end - 1;
        let is_inside = |token: &&Token| main.body.contains(&token.span.start) && token.span.start < close;
        let last = self.tokens.iter().filter(is_inside).rfind(|token| !token.is_comment());
        // Front ends refuse statements behind a return of the same block.
        let is_ended = last.is_some_and(|last| returns.iter().any(|span| span.end == last.span.start));
        if !is_ended && text.get(close..).is_some_and(|rest| rest.starts_with('}')) {
            edits.push(Edit::insert(close, format!("{CALL} ")));
        }
    }

    /// States the position of a vertex wherever an entry point of WGSL returns, and returns the function that does so.
    fn end_entry(&self, entry: &naga::EntryPoint, function: &Function, edits: &mut Vec<Edit>) -> String {
        let name = &entry.name;
        let Some(result) = &entry.function.result else { return String::new() };
        let ty = &self.parsed.module.types[result.ty];
        let is_position = |binding: &Option<naga::Binding>| {
            matches!(binding, Some(naga::Binding::BuiltIn(naga::BuiltIn::Position { .. })))
        };
        let (type_name, position) = match &ty.inner {
            naga::TypeInner::Struct { members, .. } => {
                let member = members.iter().find(|member| is_position(&member.binding));
                match (&ty.name, member.and_then(|member| member.name.as_ref())) {
                    (Some(ty), Some(member)) => (ty.as_str(), format!("value.{member}")),
                    _ => return String::new(),
                }
            }
            _ => ("vec4<f32>", "value".to_owned()),
        };
        for span in self.returns(function) {
            edits.push(Edit::insert(span.start + "return".len(), format!(" pel_end_{name}(")));
            edits.push(Edit::insert(span.end, ")"));
        }
        format!(
            "\nfn pel_end_{name}(value: {type_name}) -> {type_name} {{ pel_end_vertex({position}); return value; }}\n"
        )
    }

    /// Returns whether an entry point, or a function that it calls, has an annotation of some meanings.
    fn is_annotated(&self, entry: &naga::EntryPoint, meant: impl Fn(&Meaning) -> bool) -> bool {
        let annotated = self.annotations.iter().filter(|it| meant(&it.meaning));
        let annotated: BTreeSet<&str> = annotated
            .filter_map(|it| self.outline.function_at(it.span.start))
            .map(|index| self.outline.functions[index].name.as_str())
            .collect();
        if annotated.contains(entry.name.as_str()) {
            return true;
        }
        let module = &self.parsed.module;
        let mut seen = BTreeSet::new();
        let mut left = calls(&entry.function.body);
        while let Some(function) = left.pop() {
            if seen.insert(function) {
                let called = &module.functions[function];
                if called.name.as_deref().is_some_and(|name| annotated.contains(name)) {
                    return true;
                }
                left.extend(calls(&called.body));
            }
        }
        false
    }
}

/// Returns the functions that a block calls.
fn calls(block: &naga::Block) -> Vec<naga::Handle<naga::Function>> {
    let (mut found, mut blocks) = (Vec::new(), vec![block]);
    while let Some(block) = blocks.pop() {
        for statement in block {
            match statement {
                naga::Statement::Block(inner) => blocks.push(inner),
                naga::Statement::If { accept, reject, .. } => blocks.extend([accept, reject]),
                naga::Statement::Switch { cases, .. } => blocks.extend(cases.iter().map(|case| &case.body)),
                naga::Statement::Loop { body, continuing, .. } => blocks.extend([body, continuing]),
                naga::Statement::Call { function, .. } => found.push(*function),
                _ => {}
            }
        }
    }
    found
}

/// Returns a bind group and the first of two bindings that a module leaves free: in a group of their own, or else the last.
fn free_place(module: &naga::Module) -> [u32; 2] {
    let used = || module.global_variables.iter().filter_map(|(_, variable)| variable.binding.as_ref());
    let group = used().map(|it| it.group.saturating_add(1)).max().unwrap_or(0);
    if group < GROUPS {
        return [group, 0];
    }
    let last = used().filter(|it| it.group == GROUPS - 1).map(|it| it.binding.saturating_add(1)).max();
    [GROUPS - 1, last.unwrap_or(0).min(u32::MAX - 1)]
}

/// Returns the expression of the coordinates of an invocation in WGSL, and the parameters to add for it.
fn wgsl_place(module: &naga::Module, stage: Stage, entry: &naga::EntryPoint) -> (String, Vec<&'static str>) {
    let mut added = Vec::new();
    let mut value = |name: &str, parameter: &'static str, wanted: fn(&naga::BuiltIn) -> bool| {
        built_in(module, entry, wanted).unwrap_or_else(|| {
            added.push(parameter);
            name.to_owned()
        })
    };
    let place = match stage {
        Stage::Vertex => {
            let vertex = value("pel_index", "@builtin(vertex_index) pel_index: u32", |it| {
                matches!(it, naga::BuiltIn::VertexIndex)
            });
            let instance = value("pel_instance", "@builtin(instance_index) pel_instance: u32", |it| {
                matches!(it, naga::BuiltIn::InstanceIndex)
            });
            format!("vec2<u32>({vertex}, {instance})")
        }
        Stage::Fragment => {
            let position = value("pel_position", "@builtin(position) pel_position: vec4<f32>", |it| {
                matches!(it, naga::BuiltIn::Position { .. })
            });
            format!("vec2<u32>({position}.xy)")
        }
        Stage::Compute => {
            let invocation =
                value("pel_invocation", "@builtin(global_invocation_id) pel_invocation: vec3<u32>", |it| {
                    matches!(it, naga::BuiltIn::GlobalInvocationId)
                });
            format!("{invocation}.xy")
        }
    };
    (place, added)
}

/// Returns the expression of a built-in value among the parameters of an entry point.
fn built_in(module: &naga::Module, entry: &naga::EntryPoint, wanted: fn(&naga::BuiltIn) -> bool) -> Option<String> {
    let is_bound =
        |binding: &Option<naga::Binding>| matches!(binding, Some(naga::Binding::BuiltIn(built_in)) if wanted(built_in));
    entry.function.arguments.iter().find_map(|argument| {
        let name = argument.name.as_ref()?;
        if is_bound(&argument.binding) {
            return Some(name.clone());
        }
        let naga::TypeInner::Struct { members, .. } = &module.types[argument.ty].inner else { return None };
        let member = members.iter().find(|member| is_bound(&member.binding))?;
        Some(format!("{name}.{}", member.name.as_ref()?))
    })
}

impl Augmented {
    /// Returns the text in WGSL, for devices.
    ///
    /// # Errors
    /// Fails if the shader uses what WGSL lacks.
    pub fn wgsl(&self, shader: &Shader) -> Result<String, Faults> {
        match shader.source.language {
            Language::Wgsl => Ok(self.text.clone()),
            Language::Glsl => self.numbered(shader, 0),
        }
    }

    /// Returns the text in WGSL as [`Augmented::wgsl`] does, written anew with its bind groups numbered from `first_group` on.
    pub(crate) fn numbered(&self, shader: &Shader, first_group: u32) -> Result<String, Faults> {
        let Source { language, stage, .. } = shader.source;
        let written = || match self.is_whole {
            true => wgsl(&self.parsed, first_group),
            false => wgsl(&parse(&self.text, language, stage, &self.map)?, first_group),
        };
        written().map_err(Faults::of(shader.source()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_that_take_no_vector_are_checked_once_and_stay_in_the_text() {
        let text = "@group(0) @binding(0) var<uniform> factor: f32;\n\
            fn plain(a: f32) -> vec2<f32> /* of a */ { return vec2<f32>(a, 0.625); }\n\
            fn nothing() {}\n\
            fn kills(a: f32) -> f32 { if (a > 9.0) { discard; } return 0.375; }\n\
            fn taking(a: f32) -> f32 {\n    let b = plain(a).y + kills(a);\n    //. vector b; 1.0\n    return b;\n}\n\
            fn between(a: f32) -> f32 { nothing(); return 0.875 * taking(a); }\n\
            @fragment fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {\n    \
            return vec4<f32>(between(at.x * factor));\n}\n";
        let made = |text: &str| {
            let shader = Shader::new(Source::new("test", text, Language::Wgsl, Stage::Fragment)).unwrap();
            let augmented = shader.augment().unwrap();
            (shader, augmented)
        };
        let (shader, augmented) = made(text);
        let checked = wgsl(&augmented.parsed, 0).unwrap();
        let seen = |text: &str| ["0.625", "0.375", "0.875", "pel_take("].map(|it| text.contains(it));
        assert_eq!(seen(&checked), [false, true, true, true], "{checked}");
        assert!(!augmented.is_whole);
        for whole in [augmented.wgsl(&shader).unwrap(), augmented.numbered(&shader, 0).unwrap()] {
            assert_eq!(seen(&whole), [true; 4], "{whole}");
        }
        assert!(augmented.numbered(&shader, 2).unwrap().contains("@group(2)"));
        // What is called keeps its type, and where the user inserts code all is checked.
        let fault = Shader::new(Source::new(
            "test",
            text.replace("vector b;", "vector plain(a);"),
            Language::Wgsl,
            Stage::Fragment,
        ));
        let faults = fault.unwrap().augment().unwrap_err();
        assert_eq!(faults.place(&faults.list[0].span).0, 7, "{faults}");
        assert!(made(&text.replace("return b;", "return b /*. * confidence */;")).1.is_whole);
    }
}
