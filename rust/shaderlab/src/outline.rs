//! Outline of a shader: its functions and the variables that they and the shader declare, each with its place and scope.
//!
//! Front ends of the shading languages drop comments and report few places, so the outline comes from the tokens alone.
//! The types of GLSL variables stand beside their names; those of WGSL come from naga ([`crate::variable`]).

use crate::fault::Span;
use crate::lexer::{Kind, Token};
use crate::source::Language;

/// A function with a body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Function {
    pub name: String,
    /// From the `(` to the `)` of its parameters.
    pub parameters: Span,
    /// From the `{` to the `}` of its body.
    pub body: Span,
}

/// How a variable is declared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Declared {
    /// Outside of functions.
    Global,
    /// As a parameter of a function.
    Parameter,
    /// In a function.
    Local,
}

/// A declaration of a variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Declaration {
    pub name: String,
    pub declared: Declared,
    /// The bytes of the name.
    pub place: Span,
    /// The index of the first token of the declaration.
    pub token: usize,
    /// The type as it is written in GLSL.
    pub type_name: Option<String>,
    /// The index of its function.
    pub function: Option<usize>,
    /// The byte from which the variable can be used in a new statement, if there is one.
    pub usable: Option<usize>,
    /// The bytes in which the name means this variable.
    pub scope: Span,
    /// Whether the declaration gives a value.
    pub is_initialized: bool,
}

/// Functions and variables of a shader.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Outline {
    pub functions: Vec<Function>,
    pub declarations: Vec<Declaration>,
}

impl Outline {
    /// Returns the index of the function in whose body a byte lies.
    pub fn function_at(&self, at: usize) -> Option<usize> {
        self.functions.iter().position(|function| function.body.start < at && at < function.body.end)
    }
}

/// Types of GLSL whose variables are floats or vectors of floats, with their components.
pub(crate) const FLOATS: [(&str, u32); 4] = [("float", 1), ("vec2", 2), ("vec3", 3), ("vec4", 4)];

/// An open bracket.
struct Open {
    /// The first declaration whose scope ends with it.
    first: usize,
    /// The function that it is the body of.
    function: Option<usize>,
    /// The index of its token.
    token: usize,
    /// Whether it is a `(` that follows `for`, or the list of parameters of a function.
    head: Option<Head>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Head {
    For,
    Parameters,
}

struct Walk<'a> {
    text: &'a str,
    language: Language,
    /// Tokens without comments and directives, with their indices among all.
    tokens: Vec<(usize, &'a Token)>,
    open: Vec<Open>,
    outline: Outline,
}

/// Returns the outline of a shader that a front end has accepted. Any other text yields some outline.
pub(crate) fn outline(text: &str, language: Language, tokens: &[Token]) -> Outline {
    let code = tokens.iter().enumerate().filter(|(_, token)| !token.is_comment() && token.kind != Kind::Directive);
    let mut walk = Walk { text, language, tokens: code.collect(), open: Vec::new(), outline: Outline::default() };
    let mut at = 0;
    while at < walk.tokens.len() {
        at = walk.step(at);
    }
    while walk.open.pop().is_some() {}
    walk.outline
}

impl<'a> Walk<'a> {
    fn word(&self, at: usize) -> &'a str {
        self.tokens.get(at).map_or("", |(_, token)| token.text(self.text))
    }

    fn is_name(&self, at: usize) -> bool {
        self.tokens.get(at).is_some_and(|(_, token)| token.kind == Kind::Word)
    }

    fn span(&self, at: usize) -> Span {
        self.tokens.get(at).map_or(self.text.len()..self.text.len(), |(_, token)| token.span.clone())
    }

    fn function(&self) -> Option<usize> {
        self.open.iter().rev().find_map(|open| open.function)
    }

    /// Returns the index behind the bracket that closes the one at `at`.
    fn behind(&self, at: usize) -> usize {
        let mut depth = 0_usize;
        for index in at..self.tokens.len() {
            match self.word(index) {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" if depth <= 1 => return index + 1,
                ")" | "]" | "}" => depth -= 1,
                _ => {}
            }
        }
        self.tokens.len()
    }

    /// Looks at the token `at` and returns the index of the next one to look at.
    fn step(&mut self, at: usize) -> usize {
        match self.word(at) {
            "{" => self.open_brace(at),
            "}" | ")" | "]" => self.close(at),
            "(" | "[" => self.open_bracket(at),
            "struct" => return self.structure(at),
            "var" | "let" if self.language == Language::Wgsl => return self.wgsl_variable(at),
            word if self.language == Language::Glsl && FLOATS.iter().any(|(name, _)| *name == word) => {
                return self.glsl_variables(at);
            }
            _ => {}
        }
        at + 1
    }

    /// Returns the index behind the members of a struct.
    fn structure(&self, at: usize) -> usize {
        match (at..at + 3).find(|index| self.word(*index) == "{") {
            Some(brace) => self.behind(brace),
            None => at + 1,
        }
    }

    fn push(&mut self, at: usize, function: Option<usize>, head: Option<Head>) {
        let first = self.outline.declarations.len();
        self.open.push(Open { first, function, token: at, head });
    }

    fn open_bracket(&mut self, at: usize) {
        let before = at.checked_sub(1).map_or("", |before| self.word(before));
        let is_for = self.word(at) == "(" && before == "for";
        self.push(at, None, is_for.then_some(Head::For));
        if self.word(at) != "(" || self.function().is_some() || !self.open[..self.open.len() - 1].is_empty() {
            return;
        }
        let is_function = match self.language {
            Language::Wgsl => at >= 2 && self.word(at - 2) == "fn",
            Language::Glsl => at >= 2 && self.is_name(at - 1) && self.word(self.behind(at)) == "{",
        };
        if !is_function {
            return;
        }
        if let Some(open) = self.open.last_mut() {
            open.head = Some(Head::Parameters);
        }
        let end = self.behind(at);
        let parameters = self.span(at).start..self.span(end - 1).end;
        let name = before.to_owned();
        self.outline.functions.push(Function { name, parameters, body: 0..0 });
        if self.language == Language::Wgsl {
            self.wgsl_parameters(at, end);
        }
    }

    fn open_brace(&mut self, at: usize) {
        // A function without a body yet gets this one; `for` gives its variables to the body that follows it.
        let waiting = self.outline.functions.len().checked_sub(1);
        let waiting = waiting.filter(|index| self.open.is_empty() && self.outline.functions[*index].body.is_empty());
        let function = waiting.or_else(|| self.function());
        let first = self.pending(at);
        self.push(at, function, None);
        let inside = self.span(at).end;
        if let (Some(first), Some(open)) = (first, self.open.last_mut()) {
            open.first = first;
            for declaration in &mut self.outline.declarations[first..] {
                declaration.usable = Some(inside);
                declaration.function = function;
            }
        }
        if let Some(index) = waiting {
            self.outline.functions[index].body = self.span(at).start..self.text.len();
        }
    }

    /// Returns the first of the declarations that wait for the brace at `at`: those in the head before it.
    fn pending(&self, at: usize) -> Option<usize> {
        let declarations = &self.outline.declarations;
        let count = declarations.iter().rev().take_while(|it| it.scope.end == 0).count();
        let first = declarations.len() - count;
        let is_head = count > 0 && self.span(at).start > declarations[first].place.end;
        is_head.then_some(first)
    }

    fn close(&mut self, at: usize) {
        let Some(open) = self.open.pop() else { return };
        let end = self.span(at).end;
        match open.head {
            // Scopes of declarations in a head end with the body.
            Some(Head::Parameters) => {
                for declaration in &mut self.outline.declarations[open.first..] {
                    declaration.scope.end = 0;
                }
            }
            Some(Head::For) => {
                let has_body = self.word(at + 1) == "{";
                for declaration in &mut self.outline.declarations[open.first..] {
                    declaration.scope.end = if has_body { 0 } else { end };
                    declaration.usable = None;
                }
            }
            None => {
                let ends = self.word(open.token) == "{";
                let declarations = self.outline.declarations[open.first..].iter_mut();
                for declaration in declarations.filter(|it| ends && (it.scope.end == 0 || it.scope.end > end)) {
                    declaration.scope.end = end;
                }
                if let Some(function) = open.function.filter(|_| ends && self.open.is_empty()) {
                    self.outline.functions[function].body.end = end;
                }
            }
        }
    }

    fn declare(&mut self, token: usize, name: usize, type_name: Option<&str>, usable: usize, is_initialized: bool) {
        let declared = match self.open.last() {
            None => Declared::Global,
            Some(open) if open.head == Some(Head::Parameters) => Declared::Parameter,
            Some(_) => Declared::Local,
        };
        let place = self.span(name);
        let function = match declared {
            Declared::Parameter => self.outline.functions.len().checked_sub(1),
            _ => self.function(),
        };
        self.outline.declarations.push(Declaration {
            name: self.word(name).to_owned(),
            declared,
            scope: place.start..self.text.len(),
            place,
            token: self.tokens.get(token).map_or(0, |(index, _)| *index),
            type_name: type_name.map(str::to_owned),
            function,
            usable: Some(usable),
            is_initialized: is_initialized || declared != Declared::Local,
        });
    }

    /// Declares the variable of `var` or `let` and returns the index to go on from.
    fn wgsl_variable(&mut self, at: usize) -> usize {
        let mut name = at + 1;
        if self.word(name) == "<" {
            while name < self.tokens.len() && self.word(name) != ">" {
                name += 1;
            }
            name += 1;
        }
        if !self.is_name(name) {
            return at + 1;
        }
        let end = self.statement_end(name);
        let is_initialized = (name..end).any(|index| self.word(index) == "=");
        let usable = self.span(end).end;
        self.declare(at, name, None, usable, is_initialized);
        name + 1
    }

    /// Returns the index of the `;` that ends a statement, or of the bracket around it.
    fn statement_end(&self, mut at: usize) -> usize {
        while at < self.tokens.len() {
            match self.word(at) {
                ";" | ")" | "}" | "]" => return at,
                "(" | "[" | "{" => at = self.behind(at),
                _ => at += 1,
            }
        }
        at
    }

    /// Declares the parameters of a WGSL function between the brackets `at` and `end - 1`.
    fn wgsl_parameters(&mut self, at: usize, end: usize) {
        let mut index = at + 1;
        while index + 1 < end {
            match self.word(index) {
                "@" => index += if self.word(index + 2) == "(" { self.behind(index + 2) - index } else { 2 },
                "(" | "[" => index = self.behind(index),
                _ if self.is_name(index) && self.word(index + 1) == ":" => {
                    let usable = self.span(end - 1).end;
                    self.declare(index, index, None, usable, true);
                    index += 2;
                }
                _ => index += 1,
            }
        }
    }

    /// Declares the variables that follow a type of GLSL and returns the index to go on from.
    fn glsl_variables(&mut self, at: usize) -> usize {
        let type_name = self.word(at);
        let is_place = match self.open.last() {
            None => true,
            Some(open) => open.head.is_some() || (self.word(open.token) == "{" && self.function().is_some()),
        };
        if !is_place {
            return at + 1;
        }
        let is_constant = at > 0 && (self.word(at - 1) == "const" || (at > 1 && self.word(at - 2) == "const"));
        let is_list = self.open.last().is_none_or(|open| open.head != Some(Head::Parameters));
        let mut name = at + 1;
        // Expressions between the variables hold no declarations, but brackets to skip.
        loop {
            let after = self.word(name + 1);
            let is_variable = matches!(after, "=" | ";" | "," | ")");
            if !self.is_name(name) || is_constant || !(is_variable || after == "[") {
                return name.max(at + 1);
            }
            let mut index = name + 1;
            while !matches!(self.word(index), "," | ";" | ")" | "}" | "") {
                index = if matches!(self.word(index), "(" | "[" | "{") { self.behind(index) } else { index + 1 };
            }
            if is_variable {
                let end = self.statement_end(name);
                let usable = self.span(end).end;
                self.declare(at, name, Some(type_name), usable, after == "=");
            }
            if self.word(index) != "," || !is_list {
                return index;
            }
            name = index + 1;
        }
    }
}
