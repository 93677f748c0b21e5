//! Augmentation: the annotations of a shader become code that takes, logs and judges vectors (Section 4.1).

use std::collections::BTreeSet;

use crate::accumulation::Accumulation;
use crate::annotation::Meaning;
use crate::edit::{Edit, Part, SpanMap, apply};
use crate::fault::{Checked, Fault, Faults, Span};
use crate::front::{Parsed, entries, parse, wgsl};
use crate::instrument::{Instrument, glsl_place};
use crate::shader::Shader;
use crate::source::{Language, Stage};

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
    pub(crate) parsed: Parsed,
    language: Language,
}

/// Bind groups that every device has.
const GROUPS: u32 = 4;

impl Shader {
    /// Augments the shader. The result is checked by the front end again; its faults lie at the annotations.
    ///
    /// Fails if the shader takes no vector, if its vectors differ in length, if an annotation stands where no statement can,
    /// or if an expression is no float.
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
        self.begin(&mut edits)?;
        let code = instrument.code(self.source.language);
        let text = &*self.source.text;
        match self.source.language {
            // At the end, where it moves no line of the user.
            Language::Wgsl => edits.push(Edit::insert(text.len(), code)),
            Language::Glsl => edits[self.dialect.prelude].parts.push(Part::New(code)),
        }
        let (text, map) = apply(text, edits);
        let parsed = parse(&text, self.source.language, self.source.stage, &map)?;
        let language = self.source.language;
        Ok(Augmented { text, features, accumulation, sites, uses_confidence, group, binding, map, parsed, language })
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

    /// Adds to the entry points the call that states which pixel an invocation computes.
    fn begin(&self, edits: &mut Vec<Edit>) -> Checked<()> {
        let text = &*self.source.text;
        if self.source.language == Language::Glsl {
            let call = format!(" pel_begin({});", glsl_place(self.source.stage));
            if let Some([head, tail]) = &self.dialect.wrapper {
                edits.push(Edit::insert(text.len(), format!("{head}{call}\n{tail}")));
                return Ok(());
            }
            return match self.outline.functions.iter().find(|function| function.name == "main") {
                Some(main) => {
                    edits.push(Edit::insert(main.body.start + 1, call));
                    Ok(())
                }
                None => Err(vec![Fault::new(0..0, "the shader has no function `main`")]),
            };
        }
        let mut is_begun = false;
        for (_, stage, entry) in entries(&self.parsed.module) {
            if !self.is_annotated(entry) {
                continue;
            }
            let Some(function) = self.outline.functions.iter().find(|function| function.name == entry.name) else {
                continue;
            };
            let (place, parameter) = wgsl_place(&self.parsed.module, stage, entry);
            if let Some(parameter) = parameter {
                let comma = if entry.function.arguments.is_empty() { "" } else { ", " };
                edits.push(Edit::insert(function.parameters.start + 1, format!("{parameter}{comma}")));
            }
            edits.push(Edit::insert(function.body.start + 1, format!(" pel_begin({place});")));
            is_begun = true;
        }
        if is_begun {
            return Ok(());
        }
        let fault = Fault::new(0..0, "no entry point of the shader takes a vector");
        Err(vec![fault.advise("call the annotated function from a vertex, fragment or compute entry point")])
    }

    /// Returns whether an entry point, or a function that it calls, has an annotation that becomes code.
    fn is_annotated(&self, entry: &naga::EntryPoint) -> bool {
        let becomes_code = |meaning: &Meaning| matches!(meaning, Meaning::Vector { .. } | Meaning::Code { .. });
        let annotated = self.annotations.iter().filter(|it| becomes_code(&it.meaning));
        let annotated: BTreeSet<&str> = annotated
            .filter_map(|it| self.outline.function_at(it.span.start))
            .map(|index| self.outline.functions[index].name.as_str())
            .collect();
        if annotated.contains(entry.name.as_str()) {
            return true;
        }
        let module = &self.parsed.module;
        let mut seen = BTreeSet::new();
        let mut blocks = vec![&entry.function.body];
        while let Some(block) = blocks.pop() {
            for statement in block {
                match statement {
                    naga::Statement::Block(inner) => blocks.push(inner),
                    naga::Statement::If { accept, reject, .. } => blocks.extend([accept, reject]),
                    naga::Statement::Switch { cases, .. } => blocks.extend(cases.iter().map(|case| &case.body)),
                    naga::Statement::Loop { body, continuing, .. } => blocks.extend([body, continuing]),
                    naga::Statement::Call { function, .. } if seen.insert(*function) => {
                        let called = &module.functions[*function];
                        if called.name.as_deref().is_some_and(|name| annotated.contains(name)) {
                            return true;
                        }
                        blocks.push(&called.body);
                    }
                    _ => {}
                }
            }
        }
        false
    }
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

/// Returns the expression of the coordinates of an invocation in WGSL, and the parameter to add for it, if any.
fn wgsl_place(module: &naga::Module, stage: Stage, entry: &naga::EntryPoint) -> (String, Option<String>) {
    let wanted = |built_in: &naga::BuiltIn| match stage {
        Stage::Vertex => matches!(built_in, naga::BuiltIn::VertexIndex),
        Stage::Fragment => matches!(built_in, naga::BuiltIn::Position { .. }),
        Stage::Compute => matches!(built_in, naga::BuiltIn::GlobalInvocationId),
    };
    let is_bound =
        |binding: &Option<naga::Binding>| matches!(binding, Some(naga::Binding::BuiltIn(built_in)) if wanted(built_in));
    let mut found = None;
    for argument in &entry.function.arguments {
        let Some(name) = &argument.name else { continue };
        if is_bound(&argument.binding) {
            found = Some(name.clone());
        }
        if let naga::TypeInner::Struct { members, .. } = &module.types[argument.ty].inner
            && let Some(member) = members.iter().find(|member| is_bound(&member.binding))
        {
            found = member.name.as_ref().map(|member| format!("{name}.{member}"));
        }
    }
    let (parameter, attribute) = match stage {
        Stage::Vertex => ("pel_index", "@builtin(vertex_index) pel_index: u32"),
        Stage::Fragment => ("pel_position", "@builtin(position) pel_position: vec4<f32>"),
        Stage::Compute => ("pel_invocation", "@builtin(global_invocation_id) pel_invocation: vec3<u32>"),
    };
    let added = found.is_none().then(|| attribute.to_owned());
    let place = found.unwrap_or_else(|| parameter.to_owned());
    let place = match stage {
        Stage::Vertex => format!("vec2<u32>({place}, 0u)"),
        Stage::Fragment => format!("vec2<u32>({place}.xy)"),
        Stage::Compute => format!("{place}.xy"),
    };
    (place, added)
}

impl Augmented {
    /// Returns the text in WGSL, for devices.
    ///
    /// Fails if the shader uses what WGSL lacks.
    pub fn wgsl(&self, shader: &Shader) -> Result<String, Faults> {
        match self.language {
            Language::Wgsl => Ok(self.text.clone()),
            Language::Glsl => wgsl(&self.parsed).map_err(Faults::of(shader.source())),
        }
    }
}
