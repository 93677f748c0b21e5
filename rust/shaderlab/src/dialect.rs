//! Rewriting of GLSL to the version that front ends of Vulkan read: 4.50, with uniforms in blocks, textures apart from
//! samplers, and a location or binding for each interface. Sources are versions before 4.40, WebGL and Shadertoy.

mod arrays;
mod offsets;
mod parameters;
mod returns;
mod swizzles;

use std::collections::BTreeSet;

use crate::edit::{Edit, Part};
use crate::fault::{Checked, Fault, Span};
use crate::lexer::{Kind, Token};
use crate::outline::{Function, Outline};
use crate::source::{Language, Source, Stage};

pub(crate) use swizzles::widen;

/// How a text differs from what the front end reads.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Dialect {
    /// Edits of the user's text.
    pub edits: Vec<Edit>,
    /// The index of the edit that adds declarations before all others.
    pub prelude: usize,
    /// An entry point to append: its text up to the first statement, and from there on.
    pub wrapper: Option<[String; 2]>,
    /// Words to replace in code, with their replacements.
    words: Vec<(&'static str, &'static str)>,
}

/// Functions and variables of old versions with their present names.
const WORDS: [(&str, &str); 18] = [
    ("texture1D", "texture"),
    ("texture2D", "texture"),
    ("texture3D", "texture"),
    ("textureCube", "texture"),
    ("texture2DLod", "textureLod"),
    ("texture3DLod", "textureLod"),
    ("textureCubeLod", "textureLod"),
    ("texture2DLodEXT", "textureLod"),
    ("textureCubeLodEXT", "textureLod"),
    ("texture2DProj", "textureProj"),
    ("texture2DGrad", "textureGrad"),
    ("texture2DGradEXT", "textureGrad"),
    ("gl_FragColor", "pel_color"),
    ("gl_VertexID", "int(gl_VertexIndex)"),
    ("gl_InstanceID", "int(gl_InstanceIndex)"),
    ("texture2DRect", "texture"),
    ("textureCubeGradEXT", "textureGrad"),
    ("gl_FragDepthEXT", "gl_FragDepth"),
];

/// Words of present versions that versions before 1.30 allow as names.
const NAMES: [(&str, &str); 5] = [
    ("texture", "pel_name_texture"),
    ("sampler", "pel_name_sampler"),
    ("sample", "pel_name_sample"),
    ("buffer", "pel_name_buffer"),
    ("shared", "pel_name_shared"),
];

/// Words that change in every version: the front end's indices have no sign.
const INDICES: [(&str, &str); 3] = [
    ("gl_VertexIndex", "int(gl_VertexIndex)"),
    ("gl_InstanceIndex", "int(gl_InstanceIndex)"),
    ("gl_SampleID", "int(gl_SampleID)"),
];

/// Combined samplers with the types of their texture and their sampler.
const SAMPLERS: [(&str, &str, &str); 22] = [
    ("sampler1D", "texture1D", "sampler"),
    ("sampler1DArray", "texture1DArray", "sampler"),
    ("sampler2D", "texture2D", "sampler"),
    ("sampler2DArray", "texture2DArray", "sampler"),
    ("sampler2DMS", "texture2DMS", "sampler"),
    ("sampler2DMSArray", "texture2DMSArray", "sampler"),
    ("sampler3D", "texture3D", "sampler"),
    ("samplerCube", "textureCube", "sampler"),
    ("samplerCubeArray", "textureCubeArray", "sampler"),
    ("isampler2D", "itexture2D", "sampler"),
    ("isampler2DArray", "itexture2DArray", "sampler"),
    ("isampler2DMS", "itexture2DMS", "sampler"),
    ("isampler3D", "itexture3D", "sampler"),
    ("isamplerCube", "itextureCube", "sampler"),
    ("usampler2D", "utexture2D", "sampler"),
    ("usampler2DArray", "utexture2DArray", "sampler"),
    ("usampler2DMS", "utexture2DMS", "sampler"),
    ("usampler3D", "utexture3D", "sampler"),
    ("usamplerCube", "utextureCube", "sampler"),
    ("sampler2DShadow", "texture2D", "samplerShadow"),
    ("sampler2DArrayShadow", "texture2DArray", "samplerShadow"),
    ("samplerCubeShadow", "textureCube", "samplerShadow"),
];

/// What begins the names of the textures and samplers of a combined sampler.
pub(crate) const TEXTURE: &str = "pel_texture_";
/// As [`TEXTURE`], for samplers.
pub(crate) const SAMPLER: &str = "pel_sampler_";

/// What some editors write before a text, and front ends refuse.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// Uniforms of Shadertoy with their types.
const SHADERTOY: [(&str, &str); 8] = [
    ("iResolution", "vec3 iResolution"),
    ("iTime", "float iTime"),
    ("iTimeDelta", "float iTimeDelta"),
    ("iFrameRate", "float iFrameRate"),
    ("iMouse", "vec4 iMouse"),
    ("iDate", "vec4 iDate"),
    ("iChannelResolution", "vec3 iChannelResolution[4]"),
    ("iFrame", "int iFrame"),
];

impl Dialect {
    /// Returns what a word of the user's code becomes, if it changes.
    fn word(&self, word: &str) -> Option<&'static str> {
        self.words.iter().find(|(old, _)| *old == word).map(|(_, new)| *new)
    }

    /// Returns the parts that copy code of the user's text, with its words replaced.
    pub fn code(&self, text: &str, code: Span) -> Vec<Part> {
        let mut parts = Vec::new();
        let mut at = code.start;
        let is_part = |it: char| it.is_alphanumeric() || it == '_';
        let mut start = code.start;
        while start < code.end {
            let rest = &text[start..code.end];
            let length = rest.find(|it| !is_part(it)).unwrap_or(rest.len());
            if let Some(new) = self.word(&rest[..length]) {
                parts.push(Part::Copy(at..start));
                parts.push(Part::New(new.to_owned()));
                at = start + length;
            }
            start += length;
            start += text[start..code.end].chars().next().map_or(0, char::len_utf8);
        }
        parts.push(Part::Copy(at..code.end));
        parts
    }
}

/// A declaration outside of functions: its tokens without comments.
struct Statement<'a> {
    tokens: Vec<&'a Token>,
}

struct Rewriter<'a> {
    text: &'a str,
    stage: Stage,
    is_old: bool,
    bindings: BTreeSet<u32>,
    locations: [u32; 2],
    dialect: Dialect,
    /// Loose uniforms that are not in a block yet, with their declarations.
    loose: Vec<(Span, Vec<Part>)>,
    blocks: u32,
    declared: BTreeSet<&'a str>,
}

/// Returns what must change in a shader before its front end reads it.
///
/// Fails where a combined sampler is a parameter of a function that is declared without a body.
pub(crate) fn modernize(source: &Source, tokens: &[Token], outline: &Outline) -> Checked<Dialect> {
    let text = &*source.text;
    let mark = text.starts_with(BYTE_ORDER_MARK).then(|| Edit::replace(0..BYTE_ORDER_MARK.len_utf8(), ""));
    if source.language == Language::Wgsl {
        return Ok(Dialect { edits: mark.into_iter().collect(), ..Dialect::default() });
    }
    let directive = |token: &&Token, name: &str| {
        let line = token.text(text).trim_start_matches('#').trim_start();
        token.kind == Kind::Directive && line.starts_with(name)
    };
    let version = tokens.iter().find(|token| directive(token, "version"));
    let number = version.and_then(|token| {
        let digits = token.text(text).find(|it: char| it.is_ascii_digit())?;
        let line = &token.text(text)[digits..];
        line[..line.find(|it: char| !it.is_ascii_digit()).unwrap_or(line.len())].parse::<u32>().ok()
    });
    // Hosts of Shadertoy's shaders have an entry point that calls theirs. One that only another host sees is of no use here.
    let is_shadertoy = outline.functions.iter().any(|function| function.name == "mainImage");
    let conditional = conditionals(text, tokens);
    let is_main = |function: &&Function| function.name == "main";
    let (hidden, open): (Vec<_>, Vec<_>) =
        outline.functions.iter().filter(is_main).partition(|main| is_within(&conditional, main.body.start));
    let number = number.unwrap_or(if is_shadertoy { 300 } else { 100 });
    let mut words = INDICES.to_vec();
    if number < 440 {
        words.extend(WORDS);
    }
    if number < 130 {
        words.extend(NAMES);
    }
    let mut rewriter = Rewriter {
        text,
        stage: source.stage,
        is_old: number < 440,
        bindings: bindings(text, tokens),
        locations: [0; 2],
        dialect: Dialect { words, ..Dialect::default() },
        loose: Vec::new(),
        blocks: 0,
        declared: BTreeSet::new(),
    };
    let mut prelude = String::from("\n");
    // Old extensions are removed; extensions that stay come before all declarations, unless they depend on a condition.
    let leading = tokens.iter().take_while(|token| {
        token.is_comment() || directive(token, "version") || (number >= 440 && directive(token, "extension"))
    });
    let at = leading.filter(|token| !token.is_comment()).map(|token| token.span.end).max().unwrap_or(0);
    if number < 440 {
        match version {
            Some(token) => rewriter.dialect.edits.push(Edit::replace(token.span.clone(), "#version 450")),
            None => rewriter.dialect.edits.push(Edit::insert(0, "#version 450\n")),
        }
        let extensions = tokens.iter().filter(|token| directive(token, "extension"));
        rewriter.dialect.edits.extend(extensions.map(|token| Edit::replace(token.span.clone(), "")));
    }
    rewriter.globals(tokens)?;
    rewriter.dialect.edits.extend(parameters::split(text, tokens, outline));
    rewriter.dialect.edits.extend(offsets::fill(text, tokens));
    rewriter.dialect.edits.extend(arrays::size(text, tokens));
    rewriter.dialect.edits.extend(returns::complete(text, tokens, outline));
    rewriter.parameters(tokens)?;
    rewriter.rename(tokens);
    let uses = |name: &str| tokens.iter().any(|token| has_word(token, text, name));
    if is_shadertoy {
        let wrapped = open.is_empty();
        rewriter.shadertoy(&mut prelude, uses, wrapped);
        if wrapped {
            let names = hidden.iter().map(|main| text[..main.parameters.start].trim_end().len());
            rewriter.dialect.edits.extend(names.map(|end| Edit::replace(end - "main".len()..end, "pel_main")));
        }
    }
    if number < 440 && (uses("gl_FragColor") || rewriter.dialect.wrapper.is_some()) {
        prelude.push_str("layout(location = 0) out vec4 pel_color;\n");
    }
    // Of edits at one byte the version comes first, then these declarations.
    let mut dialect = rewriter.dialect;
    dialect.edits.extend(mark);
    dialect.prelude = usize::from(version.is_none());
    dialect.edits.insert(dialect.prelude, Edit::insert(at, prelude));
    Ok(dialect)
}

/// Returns whether a token is a word, or a line of the preprocessor with it.
fn has_word(token: &Token, text: &str, word: &str) -> bool {
    let is_part = |it: char| it.is_alphanumeric() || it == '_';
    match token.kind {
        Kind::Directive => token.text(text).split(|it| !is_part(it)).any(|it| it == word),
        _ => token.text(text) == word,
    }
}

/// Returns the bytes between outermost lines `#if` and `#endif`, in order.
fn conditionals(text: &str, tokens: &[Token]) -> Vec<Span> {
    let (mut found, mut starts) = (Vec::new(), Vec::new());
    for token in tokens.iter().filter(|token| token.kind == Kind::Directive) {
        let line = token.text(text).trim_start_matches('#').trim_start();
        if line.starts_with("if") {
            starts.push(token.span.start);
        } else if line.starts_with("endif")
            && let Some(start) = starts.pop()
            && starts.is_empty()
        {
            found.push(start..token.span.end);
        }
    }
    found
}

/// Returns the bindings that a text states.
fn bindings(text: &str, tokens: &[Token]) -> BTreeSet<u32> {
    let code: Vec<_> = tokens.iter().filter(|token| !token.is_comment()).map(|token| token.text(text)).collect();
    let stated = code.windows(3).filter(|it| it[0] == "binding" && it[1] == "=");
    stated.filter_map(|it| it[2].trim_end_matches(['u', 'U']).parse().ok()).collect()
}

impl<'a> Rewriter<'a> {
    /// Returns a binding that is not used yet.
    fn binding(&mut self) -> u32 {
        let free = (0..).find(|binding| !self.bindings.contains(binding)).unwrap_or(0);
        self.bindings.insert(free);
        free
    }

    /// Rewrites the declarations outside of functions.
    fn globals(&mut self, tokens: &'a [Token]) -> Checked<()> {
        let (mut depth, mut statement) = (0_usize, Statement { tokens: Vec::new() });
        for token in tokens.iter().filter(|token| !token.is_comment()) {
            if token.kind == Kind::Directive {
                self.flush();
                continue;
            }
            let word = token.text(self.text);
            // Bodies are left out.
            if depth == 0 || (depth == 1 && word == "}") {
                statement.tokens.push(token);
            }
            match word {
                "{" => depth += 1,
                "}" => depth = depth.saturating_sub(1),
                _ => {}
            }
            let is_body = || {
                let before = statement.tokens.iter().rev().find(|token| !matches!(token.text(self.text), "{" | "}"));
                before.is_some_and(|token| token.text(self.text) == ")")
            };
            if depth == 0 && (word == ";" || (word == "}" && is_body())) {
                let whole = std::mem::replace(&mut statement, Statement { tokens: Vec::new() });
                self.global(&whole);
            }
        }
        self.flush();
        Ok(())
    }

    fn global(&mut self, statement: &Statement<'a>) {
        let text = self.text;
        let words: Vec<_> = statement.tokens.iter().map(|token| token.text(text)).collect();
        let place = |word: &str| words.iter().position(|it| *it == word);
        let brace = place("{");
        let head = brace.unwrap_or(words.len());
        let is_stated = |name: &str| words[..head].contains(&name);
        let uniform = place("uniform").filter(|at| *at < head);
        let sampler = SAMPLERS.iter().find(|(name, ..)| is_stated(name));
        // Push constants and references have no binding.
        let is_bound = ["binding", "push_constant", "buffer_reference"].into_iter().any(is_stated);
        if brace.is_some() && is_stated("gl_PerVertex") {
            self.flush();
            // The outputs of a vertex shader are declared by the front end.
            self.dialect.edits.push(Edit::replace(span(statement), ""));
            return;
        }
        match (uniform, sampler, brace) {
            (Some(at), Some(sampler), None) => self.samplers(statement, &words, at, *sampler),
            (Some(at), None, None) if !is_stated("layout") => self.loose_uniform(statement, &words, at),
            (Some(at), None, Some(_)) if !is_bound => {
                self.flush();
                self.bind(statement, &words, at);
            }
            (None, _, Some(_)) if is_stated("buffer") && !is_bound => {
                self.flush();
                self.bind(statement, &words, place("buffer").unwrap_or(0));
            }
            (None, None, None) if self.is_old => {
                self.flush();
                self.varying(statement, &words);
            }
            _ => self.flush(),
        }
    }

    /// Gives a block a binding.
    fn bind(&mut self, statement: &Statement<'a>, words: &[&str], at: usize) {
        let binding = self.binding();
        let edit = match words.iter().position(|word| *word == "layout").filter(|layout| *layout < at) {
            Some(layout) if words.get(layout + 1) == Some(&"(") => {
                Edit::insert(statement.tokens[layout + 1].span.end, format!("binding = {binding}, "))
            }
            _ => Edit::insert(statement.tokens[at].span.start, format!("layout(binding = {binding}) ")),
        };
        self.dialect.edits.push(edit);
    }

    /// Splits combined samplers into textures and samplers.
    fn samplers(
        &mut self,
        statement: &Statement<'a>,
        words: &[&'a str],
        uniform: usize,
        (kind, texture, sampler): (&str, &str, &str),
    ) {
        let number = |name: &str| {
            let stated = words.windows(3).find(|it| it[0] == name && it[1] == "=");
            stated.and_then(|it| it[2].parse::<u32>().ok())
        };
        let set = number("set").unwrap_or(0);
        let mut stated = number("binding");
        let names = words[uniform + 1..].iter().zip(&statement.tokens[uniform + 1..]);
        let names = names.filter(|(word, token)| {
            token.kind == Kind::Word && **word != kind && !matches!(**word, "lowp" | "mediump" | "highp")
        });
        let mut out = String::new();
        for (name, _) in names {
            let first = stated.take().unwrap_or_else(|| self.binding());
            let second = self.binding();
            let name = self.dialect.word(name).unwrap_or(name);
            self.declared.insert(name);
            out.push_str(&format!(
                "layout(set = {set}, binding = {first}) uniform {texture} {TEXTURE}{name};\n\
                 layout(set = {set}, binding = {second}) uniform {sampler} {SAMPLER}{name};\n\
                 #define {name} {kind}({TEXTURE}{name}, {SAMPLER}{name})\n"
            ));
        }
        self.dialect.edits.push(Edit::replace(span(statement), format!("\n{out}")));
    }

    /// Puts a uniform aside for the next block.
    fn loose_uniform(&mut self, statement: &Statement<'a>, words: &[&'a str], uniform: usize) {
        let mut parts = Vec::new();
        let (mut depth, mut is_value) = (0_usize, false);
        for (word, token) in words.iter().zip(&statement.tokens).skip(uniform + 1) {
            match *word {
                "=" => is_value = true,
                "," | ";" if depth == 0 => is_value = false,
                "(" | "[" => depth += 1,
                ")" | "]" => depth = depth.saturating_sub(1),
                _ => {}
            }
            if !is_value && !matches!(*word, "lowp" | "mediump" | "highp") {
                parts.push(Part::Copy(token.span.clone()));
                parts.push(Part::New(" ".into()));
            }
            if token.kind == Kind::Word {
                self.declared.insert(word);
            }
        }
        self.loose.push((span(statement), parts));
    }

    /// Declares a block of the uniforms put aside, in place of the last of them.
    fn flush(&mut self) {
        let loose = std::mem::take(&mut self.loose);
        let Some((last, _)) = loose.last() else { return };
        let binding = self.binding();
        let mut parts = vec![Part::New(format!("layout(binding = {binding}) uniform pel_Uniforms{} {{ ", self.blocks))];
        self.blocks += 1;
        let last = last.clone();
        for (span, members) in loose {
            if span != last {
                self.dialect.edits.push(Edit::replace(span, ""));
            }
            parts.extend(members);
        }
        parts.push(Part::New("};".into()));
        self.dialect.edits.push(Edit { span: last, parts });
    }

    /// Gives an input or output of a stage a location.
    fn varying(&mut self, statement: &Statement<'a>, words: &[&str]) {
        let qualifier = words.iter().position(|word| matches!(*word, "in" | "out" | "varying" | "attribute"));
        let Some(at) = qualifier.filter(|at| !words[..*at].contains(&"(")) else { return };
        let is_input = match words[at] {
            "in" | "attribute" => true,
            "varying" => self.stage == Stage::Fragment,
            _ => false,
        };
        let counter = &mut self.locations[usize::from(is_input)];
        let location = *counter;
        *counter += 1;
        let token = statement.tokens[at].span.clone();
        let direction = if is_input { "in" } else { "out" };
        if words.contains(&"layout") {
            return;
        }
        self.dialect.edits.push(Edit::insert(span(statement).start, format!("layout(location = {location}) ")));
        self.dialect.edits.push(Edit::replace(token, direction));
    }

    /// Returns the bytes that edits replace so far, in order.
    fn edited(&self) -> Vec<Span> {
        let mut edited: Vec<_> = self.dialect.edits.iter().map(|edit| edit.span.clone()).collect();
        edited.retain(|span| !span.is_empty());
        edited.sort_by_key(|span| span.start);
        edited
    }

    /// Refuses combined samplers as parameters.
    fn parameters(&self, tokens: &[Token]) -> Checked<()> {
        let edited = self.edited();
        let mut depth = 0_usize;
        let mut faults = Vec::new();
        for token in tokens.iter().filter(|token| !token.is_comment() && token.kind != Kind::Directive) {
            match token.text(self.text) {
                "(" => depth += 1,
                ")" => depth = depth.saturating_sub(1),
                word if depth > 0 && SAMPLERS.iter().any(|(name, ..)| *name == word) => {
                    // `sampler2D(texture, sampler)` makes a combined sampler of its two parts.
                    let is_constructor = self.text[token.span.end..].trim_start().starts_with('(');
                    if !is_within(&edited, token.span.start) && !is_constructor {
                        let fault = Fault::new(
                            token.span.clone(),
                            "a combined sampler is a parameter of a function without a body",
                        );
                        faults.push(fault.advise("define the function where it is declared"));
                    }
                }
                _ => {}
            }
        }
        if faults.is_empty() { Ok(()) } else { Err(faults) }
    }

    /// Replaces words in code that other edits leave alone.
    fn rename(&mut self, tokens: &[Token]) {
        let edited = self.edited();
        for token in tokens.iter().filter(|token| token.kind == Kind::Word) {
            let new = self.dialect.word(token.text(self.text));
            if let Some(new) = new.filter(|_| !is_within(&edited, token.span.start)) {
                self.dialect.edits.push(Edit::replace(token.span.clone(), new));
            }
        }
        // The front end refuses the qualifier of parameters that are not written, which changes nothing else.
        let code: Vec<_> = tokens.iter().filter(|token| !token.is_comment()).collect();
        for pair in code.windows(2) {
            if pair[0].text(self.text) == "const" && pair[1].text(self.text) == "in" {
                self.dialect.edits.push(Edit::replace(pair[0].span.clone(), ""));
            }
        }
        for token in tokens.iter().filter(|token| token.kind == Kind::Directive) {
            if !token.text(self.text).trim_start_matches('#').trim_start().starts_with("define") {
                continue;
            }
            let parts = self.dialect.code(self.text, token.span.clone());
            if parts.len() > 1 {
                self.dialect.edits.push(Edit { span: token.span.clone(), parts });
            }
        }
    }

    /// Declares what Shadertoy gives its shaders and, if it is `wrapped`, appends an entry point that calls theirs.
    fn shadertoy(&mut self, prelude: &mut String, uses: impl Fn(&str) -> bool, wrapped: bool) {
        let members = SHADERTOY.iter().filter(|(name, _)| !self.declared.contains(name) && (wrapped || uses(name)));
        let members: Vec<_> = members.map(|(_, member)| format!("{member};")).collect();
        if !members.is_empty() {
            let (binding, members) = (self.binding(), members.join(" "));
            prelude.push_str(&format!("layout(binding = {binding}) uniform pel_Shadertoy {{ {members} }};\n"));
        }
        for name in ["iChannel0", "iChannel1", "iChannel2", "iChannel3"] {
            if uses(name) && !self.declared.contains(name) {
                let (first, second) = (self.binding(), self.binding());
                prelude.push_str(&format!(
                    "layout(binding = {first}) uniform texture2D {TEXTURE}{name};\n\
                     layout(binding = {second}) uniform sampler {SAMPLER}{name};\n\
                     #define {name} sampler2D({TEXTURE}{name}, {SAMPLER}{name})\n"
                ));
            }
        }
        if !wrapped {
            return;
        }
        // Rows count from the bottom there.
        self.dialect.wrapper = Some([
            "\nvoid main() {\n".into(),
            "    vec4 pel_result = vec4(0.0);\n    \
                 mainImage(pel_result, vec2(gl_FragCoord.x, iResolution.y - gl_FragCoord.y));\n    \
                 pel_color = vec4(pel_result.rgb, 1.0);\n}\n"
                .into(),
        ]);
    }
}

/// Returns whether a byte lies in one of some spans that are in order and do not overlap.
fn is_within(spans: &[Span], at: usize) -> bool {
    let index = spans.partition_point(|span| span.start <= at);
    index.checked_sub(1).is_some_and(|index| spans[index].contains(&at))
}

/// Returns the bytes of a statement.
fn span(statement: &Statement<'_>) -> Span {
    match (statement.tokens.first(), statement.tokens.last()) {
        (Some(first), Some(last)) => first.span.start..last.span.end,
        _ => 0..0,
    }
}
