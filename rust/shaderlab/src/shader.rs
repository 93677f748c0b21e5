//! A shader that was read: its annotations, its outline and its module.

use crate::annotation::{Annotation, Meaning, annotations};
use crate::dialect::{Dialect, modernize, widen};
use crate::edit::{Edit, apply};
use crate::fault::{Checked, Fault, Faults, Span};
use crate::front::{Parsed, entries, parse, wgsl};
use crate::lexer::{Kind, Token, tokens};
use crate::outline::{Outline, outline};
use crate::resource::{Resource, resources};
use crate::source::{Language, Source, Stage};
use crate::variable::{Variable, variables, with_vector};

/// What begins the names that the augmentation adds to a shader.
pub(crate) const PREFIX: &str = "pel_";

/// Swizzles of scalars that are rewritten in a shader.
const MAX_SWIZZLES: usize = 32;

/// Returns the edits that rewrite the swizzle of a scalar at which the front end failed.
fn swizzle(text: &str, tokens: &[Token], faults: &[Fault]) -> Option<[Edit; 2]> {
    let first = faults.first().filter(|fault| fault.what.starts_with("Can't lookup field"))?;
    widen(text, tokens, &first.span)
}

/// A shader that a front end has accepted.
#[derive(Debug)]
pub struct Shader {
    pub(crate) source: Source,
    pub(crate) tokens: Vec<Token>,
    pub(crate) annotations: Vec<Annotation>,
    pub(crate) outline: Outline,
    pub(crate) dialect: Dialect,
    pub(crate) parsed: Parsed,
    pub(crate) text: String,
}

/// An entry point of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Its stage.
    pub stage: Stage,
}

impl Shader {
    /// Reads a shader.
    ///
    /// # Errors
    /// Fails with the faults of its annotations, or else with the faults that the front end of its language finds.
    pub fn new(source: Source) -> Result<Self, Faults> {
        let faults = Faults::of(&source);
        Self::read(source).map_err(faults)
    }

    fn read(source: Source) -> Checked<Self> {
        let text = &*source.text;
        let tokens = tokens(text, source.language)?;
        let is_ours = |token: &&Token| token.kind == Kind::Word && token.text(text).starts_with(PREFIX);
        if let Some(token) = tokens.iter().find(is_ours) {
            let what = format!("names that begin with `{PREFIX}` belong to the augmentation");
            return Err(vec![
                Fault::new(token.span.clone(), what).advise("use another name, or the shader before it was augmented"),
            ]);
        }
        let annotations = annotations(text, source.language, &tokens)?;
        let outline = outline(text, source.language, &tokens);
        let mut dialect = modernize(&source, &tokens, &outline)?;
        for left in (0..=MAX_SWIZZLES).rev() {
            let mut edits = dialect.edits.clone();
            edits.extend(dialect.wrapper.as_ref().map(|wrapper| Edit::insert(text.len(), wrapper.concat())));
            let (plain, map) = apply(text, edits);
            match parse(&plain, source.language, source.stage, &map) {
                Ok(parsed) => return Ok(Self { tokens, annotations, outline, dialect, parsed, text: plain, source }),
                // Types are known to the front end alone: its faults show which fields are swizzles of scalars.
                Err(faults) => match swizzle(text, &tokens, &faults).filter(|_| left > 0) {
                    Some(edits) => dialect.edits.extend(edits),
                    None => return Err(faults),
                },
            }
        }
        Err(vec![Fault::new(0..0, "the shader cannot be read")])
    }

    /// Returns the source that it was read from.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Returns its text in the current version of its language: the user's own, unless that is an old dialect of GLSL.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns its entry points.
    pub fn entries(&self) -> Vec<Entry> {
        entries(&self.parsed.module).map(|(_, stage, entry)| Entry { name: entry.name.clone(), stage }).collect()
    }

    /// Returns the resources that it is bound to.
    pub fn resources(&self) -> Vec<Resource> {
        resources(&self.parsed.module)
    }

    /// Returns whether an annotation takes a vector, so that the shader can be augmented.
    pub fn is_marked(&self) -> bool {
        self.annotations.iter().any(|annotation| matches!(annotation.meaning, Meaning::Vector { .. }))
    }

    /// Returns its float variables in the order of the text.
    pub fn variables(&self) -> Vec<Variable> {
        variables(self)
    }

    /// Returns the line on which a variable is declared, counted from 1.
    pub fn line(&self, variable: &Variable) -> usize {
        self.source.place(&variable.place).0
    }

    /// Returns its text with a vector of variables, taken behind the last of them.
    ///
    /// `chosen` has indices into [`Shader::variables`], `weight` is an expression.
    ///
    /// # Errors
    /// Fails if no variable is chosen or one does not exist, if one cannot be seen from where the last is declared, or
    /// if no statement can stand there.
    pub fn with_vector(&self, chosen: &[usize], weight: &str) -> Result<String, Faults> {
        with_vector(&self.source, &self.outline, &self.variables(), chosen, weight)
    }

    /// Returns its source with spaces in place of its annotations.
    #[cfg(feature = "wgpu")]
    pub(crate) fn without_annotations(&self) -> Source {
        let mut text = self.source.text.to_string();
        for Annotation { span, .. } in &self.annotations {
            let blank: String = text[span.clone()].bytes().map(|byte| if byte == b'\n' { '\n' } else { ' ' }).collect();
            text.replace_range(span.clone(), &blank);
        }
        Source { text: text.into(), ..self.source.clone() }
    }

    /// Returns its text in WGSL, for devices.
    ///
    /// # Errors
    /// Fails if the shader uses what WGSL lacks.
    pub fn wgsl(&self) -> Result<String, Faults> {
        match self.source.language {
            Language::Wgsl => Ok(self.text.clone()),
            Language::Glsl => wgsl(&self.parsed, 0).map_err(Faults::of(&self.source)),
        }
    }

    /// Returns the text of a span.
    pub(crate) fn slice(&self, span: &Span) -> &str {
        &self.source.text[span.clone()]
    }
}
