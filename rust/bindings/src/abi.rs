//! What the headers of the C ABI declare: the one model that pages, Python's declarations and the test of
//! `rust/capi` are made from.

pub mod page;
pub mod python;
pub mod reader;
pub mod rust;
pub mod types;
pub mod value;

use types::{Signature, Type};
use value::Value;

/// The headers that declare something, each after the headers that it includes.
pub struct Abi {
    /// One for each header.
    pub nouns: Vec<Noun>,
}

/// A header.
pub struct Noun {
    /// Its file name without `.h`.
    pub name: String,
    /// The comment that it begins with.
    pub about: String,
    /// What it declares, in its order.
    pub items: Vec<Item>,
}

/// A declaration.
pub struct Item {
    /// Its name; empty for an enumeration without one.
    pub name: String,
    /// The comment before it.
    pub doc: String,
    /// The line where it begins, from 1.
    pub line: usize,
    /// What it is.
    pub kind: Kind,
}

/// What a declaration declares.
pub enum Kind {
    /// A macro with an integer as its value.
    Constant(i64),
    /// A macro with another value, as C.
    Macro(String),
    /// An enumeration.
    Enumeration(Vec<Enumerator>),
    /// Another name of a number type.
    Alias(Type),
    /// A pointer to a function of the host.
    Callback(Signature),
    /// A structure.
    Structure(Structure),
    /// An exported function.
    Function(Signature),
}

/// A value of an enumeration.
pub struct Enumerator {
    /// `RLV_DEVICE_CPU`.
    pub name: String,
    /// Its number.
    pub value: i64,
    /// The comment beside it.
    pub doc: String,
}

/// A structure and its layout.
pub struct Structure {
    /// Bytes.
    pub size: usize,
    /// Bytes to whose multiples it is aligned.
    pub align: usize,
    /// Its members in order.
    pub fields: Vec<Field>,
    /// What its `RLV_..._INIT` has, a value for each field, where there is one.
    pub initial: Option<Vec<Value>>,
}

/// A member of a structure.
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type.
    pub kind: Type,
    /// Bytes from the start of the structure.
    pub offset: usize,
    /// The comment beside it.
    pub doc: String,
}

impl Abi {
    /// Every declaration, each after the declarations that it uses.
    pub fn items(&self) -> impl Iterator<Item = &Item> {
        self.nouns.iter().flat_map(|noun| &noun.items)
    }

    /// The names of the functions, in alphabetical order.
    pub fn symbols(&self) -> Vec<&str> {
        let functions = self.items().filter(|item| matches!(item.kind, Kind::Function(_)));
        let mut names: Vec<&str> = functions.map(|item| item.name.as_str()).collect();
        names.sort_unstable();
        names
    }
}
