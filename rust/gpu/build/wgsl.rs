//! What of a WGSL module its structs need: imports, constants, structs, and the types of variables that hosts fill.
//!
//! A field, a constant and a variable each have a line of their own; a struct ends with a line `}`.

/// A type in WGSL.
#[derive(Clone, Debug, PartialEq)]
pub enum Type {
    /// `f32`, `u32`, `i32`, or an atomic of one.
    Scalar(&'static str),
    /// 2 to 4 scalars.
    Vector(u32, &'static str),
    /// Columns and rows of `f32`.
    Matrix(u32, u32),
    /// Elements, and how many; `None` in an array as long as its buffer.
    Array(Box<Self>, Option<u32>),
    /// A struct.
    Struct(String),
}

/// A field of a struct.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub comment: Vec<String>,
    pub name: String,
    pub is_of: Type,
    /// The bytes that an attribute `@size` gives it.
    pub size: Option<u32>,
    /// The alignment that an attribute `@align` gives it.
    pub align: Option<u32>,
}

/// A struct as the text has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Struct {
    pub comment: Vec<String>,
    pub name: String,
    /// The line of its name, from 1.
    pub line: usize,
    /// Fields, each with its line.
    fields: Vec<(usize, Vec<String>, String)>,
}

/// What is read of a module.
#[derive(Clone, Debug, Default)]
pub struct Module {
    /// The name: that of the file without its ending.
    pub name: String,
    /// The path of the file below `shaders/`.
    pub file: String,
    pub imports: Vec<String>,
    pub structs: Vec<Struct>,
    /// Types of variables in storage, uniforms and immediate data, each with its line.
    variables: Vec<(usize, String)>,
    constants: Vec<(String, u32)>,
}

impl Module {
    /// Reads the module `name` in `file`.
    ///
    /// # Errors
    /// Names the file and line of a struct that does not end.
    pub fn read(name: &str, file: &str, text: &str) -> Result<Self, String> {
        let mut module = Self { name: name.to_owned(), file: file.to_owned(), ..Self::default() };
        let mut comment = Vec::new();
        let mut open: Option<Struct> = None;
        for (at, line) in (1..).zip(text.lines()) {
            let code = line.split("//").next().unwrap_or_default().trim();
            if code.is_empty() {
                match line.trim().strip_prefix("//") {
                    Some(text) => comment.push(text.trim_start_matches('/').trim().to_owned()),
                    None => comment.clear(),
                }
                module.imports.extend(line.strip_prefix("// import ").map(|name| name.trim().to_owned()));
                continue;
            }
            let comment = std::mem::take(&mut comment);
            if let Some(mut found) = open.take() {
                match code {
                    "}" => module.structs.push(found),
                    _ => {
                        found.fields.push((at, comment, code.to_owned()));
                        open = Some(found);
                    }
                }
            } else if let Some(rest) = code.strip_prefix("struct ") {
                let name = rest.strip_suffix('{').map(str::trim);
                let name =
                    name.ok_or_else(|| module.fault(at, "a struct has its name and `{` on one line"))?.to_owned();
                open = Some(Struct { comment, name, line: at, fields: Vec::new() });
            } else if let Some(rest) = code.strip_prefix("const ").filter(|_| line.starts_with("const")) {
                module.constants.extend(constant(rest));
            } else if let Some(of) = variable(code) {
                module.variables.push((at, of.to_owned()));
            }
        }
        match open {
            Some(found) => Err(module.fault(found.line, "a struct ends with a line `}`")),
            None => Ok(module),
        }
    }

    /// Returns the message `what` with the place of line `at`.
    pub fn fault(&self, at: usize, what: &str) -> String {
        format!("shaders/{}:{at}: {what}", self.file)
    }

    /// Returns the types of variables that hosts fill or read.
    pub fn shared(&self) -> Result<Vec<Type>, String> {
        self.variables.iter().map(|(at, of)| self.type_of(*at, of)).collect()
    }

    /// Returns the fields of `found`, which is one of the module.
    ///
    /// # Errors
    /// Names the file and line of a field that a host cannot share, or that is not read.
    pub fn fields(&self, found: &Struct) -> Result<Vec<Field>, String> {
        let field = |(at, comment, code): &(usize, Vec<String>, String)| {
            let mut rest = code.strip_suffix(',').unwrap_or(code);
            let (mut size, mut align) = (None, None);
            while let Some(attribute) = rest.strip_prefix('@') {
                let (name, more) = attribute.split_once('(').unwrap_or((attribute, ""));
                let (value, more) = more.split_once(')').unwrap_or(("", ""));
                let value = self.number(value);
                match name {
                    "size" if value.is_some() => size = value,
                    "align" if value.is_some() => align = value,
                    _ => return Err(self.fault(*at, &format!("hosts share no fields with `@{attribute}`"))),
                }
                rest = more.trim_start();
            }
            let (name, of) = rest.split_once(':').ok_or_else(|| self.fault(*at, "a field is on a line of its own"))?;
            let is_of = self.type_of(*at, of)?;
            Ok(Field { comment: comment.clone(), name: name.trim().to_owned(), is_of, size, align })
        };
        found.fields.iter().map(field).collect()
    }

    fn type_of(&self, at: usize, text: &str) -> Result<Type, String> {
        let text = text.trim();
        let fault = |what: &str| self.fault(at, &format!("`{text}`: {what}"));
        let Some((outer, inner)) = text.split_once('<') else {
            return match scalar(text) {
                Some(scalar) => Ok(Type::Scalar(scalar)),
                None if text.starts_with(char::is_uppercase) => Ok(Type::Struct(text.to_owned())),
                None => Err(fault("hosts cannot share this type")),
            };
        };
        let inner = inner.strip_suffix('>').ok_or_else(|| fault("a type is on one line"))?;
        let counts: Vec<u32> = outer.chars().filter_map(|letter| letter.to_digit(10)).collect();
        match (outer.trim_end_matches(|letter: char| "234x".contains(letter)), &counts[..], scalar(inner)) {
            ("atomic", [], Some(scalar)) => Ok(Type::Scalar(scalar)),
            ("vec", &[count], Some(scalar)) => Ok(Type::Vector(count, scalar)),
            ("mat", &[columns, rows], Some("f32")) => Ok(Type::Matrix(columns, rows)),
            ("array", [], _) => {
                let cut = inner.rfind(',').filter(|comma| !inner[*comma..].contains('>'));
                let count = cut.map(|comma| {
                    self.number(&inner[comma + 1..])
                        .ok_or_else(|| fault("its length is a number or a constant of this file"))
                });
                let of = self.type_of(at, &inner[..cut.unwrap_or(inner.len())])?;
                Ok(Type::Array(Box::new(of), count.transpose()?))
            }
            _ => Err(fault("hosts cannot share this type")),
        }
    }

    /// Returns the value of a literal or of a constant of this module.
    fn number(&self, text: &str) -> Option<u32> {
        let text = text.trim();
        let of_name = || self.constants.iter().find(|(name, _)| name == text).map(|(_, value)| *value);
        text.trim_end_matches('u').parse().ok().or_else(of_name)
    }
}

/// Returns the name and value of `NAME[: u32] = VALUE;`, where the value is a whole number.
fn constant(text: &str) -> Option<(String, u32)> {
    let (name, value) = text.split_once('=')?;
    let name = name.split(':').next()?.trim().to_owned();
    let value = value.trim().trim_end_matches(';').trim_end_matches('u');
    Some((name, value.parse().ok()?))
}

/// Returns the type of a variable of the module that hosts fill or read.
fn variable(code: &str) -> Option<&str> {
    let (_, rest) = code.split_once("var<")?;
    let (space, rest) = rest.split_once('>')?;
    let shared = ["storage", "uniform", "immediate"].contains(&space.split(',').next()?.trim());
    let (_, of) = rest.strip_suffix(';')?.split_once(':')?;
    shared.then_some(of)
}

fn scalar(name: &str) -> Option<&'static str> {
    ["f32", "u32", "i32"].into_iter().find(|it| *it == name.trim())
}
