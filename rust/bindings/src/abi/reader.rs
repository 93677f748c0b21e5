//! The headers of the C ABI as bindgen and the C compiler behind it read them.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::rc::Rc;

use bindgen::callbacks::{DiscoveredItem, DiscoveredItemId, ParseCallbacks, SourceLocation, Token};
use bindgen::{EnumVariation, Formatter};

use super::types::{Signature, Type, callback, integer, plain_name};
use super::value::Value;
use super::{Abi, Enumerator, Field, Item, Kind, Noun, Structure};

/// Reads `relievo/relievo.h` of the folder `include`, and all that it includes.
///
/// # Errors
/// The C compiler refuses a header, a header is not included, or a declaration is of a kind that the ABI does not use.
pub fn read(include: &Path) -> Result<Abi, String> {
    let sources = sources(include)?;
    let seen = Rc::new(RefCell::new(Seen::default()));
    let bindings = bindgen::builder()
        .header(include.join("relievo/relievo.h").to_string_lossy())
        .clang_arg(format!("-I{}", include.display()))
        // Comments count although they do not begin with two stars.
        .clang_arg("-fparse-all-comments")
        .allowlist_item("(rlv_|Rlv|RLV_).*")
        .default_enum_style(EnumVariation::Consts)
        .prepend_enum_name(false)
        .formatter(Formatter::None)
        .parse_callbacks(Box::new(Watcher(Rc::clone(&seen))))
        .generate()
        .map_err(|error| format!("include/relievo: {error}"))?;
    let parsed = syn::parse_file(&bindings.to_string()).map_err(|error| format!("bindgen's text: {error}"))?;
    let seen = seen.borrow();
    let mut builder = Builder { seen: &seen, sources: &sources, layouts: layouts(&parsed)?, items: BTreeMap::new() };
    builder.add_enumerations(&parsed)?;
    for item in &parsed.items {
        builder.add(item)?;
    }
    builder.add_macros()?;
    Ok(builder.finish())
}

/// A header's text.
struct Source {
    noun: String,
    text: String,
}

/// The headers in the order in which a compiler reads them, each after the headers that it includes.
fn sources(include: &Path) -> Result<Vec<Source>, String> {
    fn visit(folder: &Path, name: &str, read: &mut BTreeSet<String>, sources: &mut Vec<Source>) -> Result<(), String> {
        if !read.insert(name.to_owned()) {
            return Ok(());
        }
        let path = folder.join(name);
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        for line in text.lines() {
            let inner = line.strip_prefix("#include \"relievo/").and_then(|rest| rest.split('"').next());
            inner.map_or(Ok(()), |inner| visit(folder, inner, read, sources))?;
        }
        sources.push(Source { noun: name.trim_end_matches(".h").to_owned(), text });
        Ok(())
    }
    let folder = include.join("relievo");
    let (mut read, mut sources) = (BTreeSet::new(), Vec::new());
    visit(&folder, "relievo.h", &mut read, &mut sources)?;
    let entries = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let missing: Vec<String> = names.filter(|name| name.ends_with(".h") && !read.contains(name)).collect();
    if missing.is_empty() { Ok(sources) } else { Err(format!("relievo.h does not include {}", missing.join(", "))) }
}

/// What bindgen says of the headers besides its text.
#[derive(Debug, Default)]
struct Seen {
    /// Header and line of each declaration.
    places: BTreeMap<String, (String, usize)>,
    /// The names of enumerations.
    enumerations: BTreeSet<String>,
    /// Macros of the ABI in their order: name with its parameters, and the tokens of their values.
    macros: Vec<(String, Vec<Token>)>,
}

#[derive(Debug)]
struct Watcher(Rc<RefCell<Seen>>);

impl ParseCallbacks for Watcher {
    fn new_item_found(&self, _: DiscoveredItemId, item: DiscoveredItem, place: Option<&SourceLocation>) {
        let mut seen = self.0.borrow_mut();
        let name = match item {
            DiscoveredItem::Struct { final_name, .. }
            | DiscoveredItem::Union { final_name, .. }
            | DiscoveredItem::Function { final_name }
            | DiscoveredItem::Constant { final_name }
            | DiscoveredItem::Variable { final_name } => final_name,
            DiscoveredItem::Alias { alias_name, .. } => alias_name,
            DiscoveredItem::Enum { final_name } => {
                seen.enumerations.insert(final_name.clone());
                final_name
            }
            DiscoveredItem::Method { .. } => return,
        };
        if let Some((file, line)) = place.and_then(|place| Some((place.file_name.as_deref()?, place.line))) {
            let noun = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
            seen.places.insert(name, (noun, line));
        }
    }

    fn modify_macro(&self, name: &str, tokens: &mut Vec<Token>) {
        if name.starts_with("RLV_") {
            self.0.borrow_mut().macros.push((name.to_owned(), tokens.iter().skip(1).cloned().collect()));
        }
    }

    fn func_macro(&self, name: &str, value: &[&[u8]]) {
        if name.starts_with("RLV_") {
            let tokens = value.iter().map(|raw| Token::from((bindgen::callbacks::TokenKind::Literal, *raw)));
            self.0.borrow_mut().macros.push((name.to_owned(), tokens.collect()));
        }
    }
}

/// The numbers that bindgen asserts: `Size of A`, `Alignment of A` and `Offset of field: A::b`.
fn layouts(parsed: &syn::File) -> Result<BTreeMap<String, usize>, String> {
    let mut layouts = BTreeMap::new();
    for item in &parsed.items {
        let syn::Item::Const(item) = item else { continue };
        let syn::Expr::Block(block) = &*item.expr else { continue };
        for statement in &block.block.stmts {
            let (label, number) = asserted(statement).ok_or("bindgen asserts layouts in another way")?;
            layouts.insert(label, integer(number)?);
        }
    }
    Ok(layouts)
}

/// Label and number of `["label"][expression - number];`.
fn asserted(statement: &syn::Stmt) -> Option<(String, &syn::Expr)> {
    let syn::Stmt::Expr(syn::Expr::Index(index), _) = statement else { return None };
    let (syn::Expr::Array(array), syn::Expr::Binary(difference)) = (&*index.expr, &*index.index) else { return None };
    match array.elems.first()? {
        syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(label), .. }) => Some((label.value(), &difference.right)),
        _ => None,
    }
}

struct Builder<'a> {
    seen: &'a Seen,
    sources: &'a [Source],
    layouts: BTreeMap<String, usize>,
    /// The items of each noun.
    items: BTreeMap<String, Vec<Item>>,
}

impl Builder<'_> {
    fn put(&mut self, name: &str, doc: String, kind: Kind) -> Result<(), String> {
        let place = self.seen.places.get(name).ok_or_else(|| format!("bindgen says no place of {name}"))?;
        let shown = if name.starts_with("_bindgen") { "" } else { name };
        let item = Item { name: shown.to_owned(), doc, line: place.1, kind };
        self.items.entry(place.0.clone()).or_default().push(item);
        Ok(())
    }

    /// Adds the enumerations with the constants of their types, which bindgen writes beside them.
    fn add_enumerations(&mut self, parsed: &syn::File) -> Result<(), String> {
        let mut values: BTreeMap<String, Vec<Enumerator>> = BTreeMap::new();
        for item in &parsed.items {
            let syn::Item::Const(item) = item else { continue };
            let syn::Type::Path(kind) = &*item.ty else { continue };
            let kind = kind.path.segments.last().map(|last| last.ident.to_string()).unwrap_or_default();
            if self.seen.enumerations.contains(&kind) {
                let enumerator =
                    Enumerator { name: item.ident.to_string(), value: integer(&item.expr)?, doc: doc(&item.attrs) };
                values.entry(kind).or_default().push(enumerator);
            }
        }
        for item in &parsed.items {
            let syn::Item::Type(item) = item else { continue };
            if let Some(values) = values.remove(&item.ident.to_string()) {
                self.put(&item.ident.to_string(), doc(&item.attrs), Kind::Enumeration(values))?;
            }
        }
        match values.into_keys().next() {
            None => Ok(()),
            Some(name) => Err(format!("bindgen declares no type {name}")),
        }
    }

    fn add(&mut self, item: &syn::Item) -> Result<(), String> {
        let within = |name: &syn::Ident| {
            let name = name.to_string();
            move |error: String| format!("{name}: {error}")
        };
        match item {
            syn::Item::Struct(item) => {
                let structure = self.structure(item).map_err(within(&item.ident))?;
                self.put(&item.ident.to_string(), doc(&item.attrs), Kind::Structure(structure))
            }
            syn::Item::Type(item) if self.seen.enumerations.contains(&item.ident.to_string()) => Ok(()),
            syn::Item::Type(item) => {
                let kind = match callback(&item.ty) {
                    Some(function) => Signature::of_pointer(function).map(Kind::Callback),
                    None => Type::of(&item.ty).map(Kind::Alias),
                };
                self.put(&item.ident.to_string(), doc(&item.attrs), kind.map_err(within(&item.ident))?)
            }
            syn::Item::ForeignMod(block) => block.items.iter().try_for_each(|item| match item {
                syn::ForeignItem::Fn(item) => {
                    let name = &item.sig.ident;
                    let signature = Signature::of_function(&item.sig).map_err(within(name))?;
                    self.put(&name.to_string(), doc(&item.attrs), Kind::Function(signature))
                }
                _ => Err("a variable is no part of the ABI".into()),
            }),
            syn::Item::Union(item) => Err(format!("{}: a union is no part of the ABI", item.ident)),
            // Enumerators and layouts are read elsewhere, and macros from their tokens.
            _ => Ok(()),
        }
    }

    fn structure(&self, item: &syn::ItemStruct) -> Result<Structure, String> {
        let name = item.ident.to_string();
        let layout = |label: String| {
            self.layouts.get(&label).copied().ok_or_else(|| format!("bindgen does not assert the {label}"))
        };
        let fields = item.fields.iter().map(|field| {
            let own = field.ident.as_ref().map(ToString::to_string).unwrap_or_default();
            Ok::<_, String>(Field {
                kind: Type::of(&field.ty).map_err(|error| format!("{own}: {error}"))?,
                offset: layout(format!("Offset of field: {name}::{own}"))?,
                doc: doc(&field.attrs),
                name: plain_name(&own),
            })
        });
        Ok(Structure {
            size: layout(format!("Size of {name}"))?,
            align: layout(format!("Alignment of {name}"))?,
            fields: fields.collect::<Result<_, _>>()?,
            initial: None,
        })
    }

    /// Adds the macros: integers as constants, initial values to their structures, others as they are.
    fn add_macros(&mut self) -> Result<(), String> {
        let mut constants: BTreeMap<&str, i64> = BTreeMap::new();
        for (name, tokens) in &self.seen.macros {
            if let Ok(Value::Integer(value)) = Value::of(tokens, |_| None) {
                constants.insert(name, value);
            }
        }
        let enumerators = self.items.values().flatten().filter_map(|item| match &item.kind {
            Kind::Enumeration(values) => Some(values.iter().map(|value| (value.name.clone(), value.value))),
            _ => None,
        });
        let enumerators: BTreeMap<String, i64> = enumerators.flatten().collect();
        for (name, tokens) in &self.seen.macros {
            let (noun, line, doc) = self.definition(name)?;
            if name.ends_with("_INIT") {
                let known = |name: &str| enumerators.get(name).or_else(|| constants.get(name)).copied();
                let value = Value::of(tokens, known).map_err(|error| format!("{name}: {error}"))?;
                self.set_initial(name, value)?;
                continue;
            }
            let kind = match constants.get(name.as_str()) {
                Some(value) => Kind::Constant(*value),
                None => Kind::Macro(joined(tokens)),
            };
            self.items.entry(noun).or_default().push(Item { name: name.clone(), doc, line, kind });
        }
        Ok(())
    }

    /// Header and line of a macro's definition, and the comment above it.
    fn definition(&self, name: &str) -> Result<(String, usize, String), String> {
        let start = format!("#define {}", name.split('(').next().unwrap_or_default());
        let is_it = |line: &str| line.strip_prefix(&start).is_some_and(|rest| !rest.starts_with(is_word));
        for source in self.sources {
            if let Some(index) = source.text.lines().position(is_it) {
                let before: Vec<&str> = source.text.lines().take(index).collect();
                return Ok((source.noun.clone(), index + 1, comment_above(&before)));
            }
        }
        Err(format!("no header has a line that begins with `{start}`"))
    }

    fn set_initial(&mut self, name: &str, value: Value) -> Result<(), String> {
        let Value::List(values) = value else { return Err(format!("{name} has no brackets")) };
        let plain = |text: &str| text.replace('_', "").to_lowercase();
        let wanted = plain(name.trim_start_matches("RLV_").trim_end_matches("_INIT"));
        let mut items = self.items.values_mut().flatten();
        let of = items.find_map(|item| match &mut item.kind {
            Kind::Structure(structure) if plain(item.name.trim_start_matches("Rlv")) == wanted => {
                Some((&item.name, structure))
            }
            _ => None,
        });
        let (of, structure) = of.ok_or_else(|| format!("{name} is of no structure"))?;
        if let Some(Value::SizeOf(other)) = values.first().filter(|first| **first != Value::SizeOf(of.clone())) {
            return Err(format!("{name} has the size of {other}"));
        }
        if values.len() != structure.fields.len() {
            return Err(format!("{name} has {} values for {} fields", values.len(), structure.fields.len()));
        }
        structure.initial = Some(values);
        Ok(())
    }

    fn finish(mut self) -> Abi {
        let nouns = self.sources.iter().filter_map(|source| {
            let mut items = self.items.remove(&source.noun)?;
            items.sort_by_key(|item| item.line);
            Some(Noun { name: source.noun.clone(), about: comment_at_start(&source.text), items })
        });
        Abi { nouns: nouns.collect() }
    }
}

fn is_word(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// The comment that bindgen hands on as `#[doc]`.
fn doc(attributes: &[syn::Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        syn::Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    });
    unmarked(&lines.collect::<Vec<_>>().join("\n"))
}

/// The comment that a header begins with.
fn comment_at_start(text: &str) -> String {
    let inside = text.trim_start().strip_prefix("/*").and_then(|rest| rest.split("*/").next());
    unmarked(inside.unwrap_or_default())
}

/// The comment that ends with the last of `lines`.
fn comment_above(lines: &[&str]) -> String {
    if !lines.last().is_some_and(|line| line.trim_end().ends_with("*/")) {
        return String::new();
    }
    let start = lines.iter().rposition(|line| line.starts_with("/*")).unwrap_or(lines.len());
    let text = lines[start..].join("\n");
    unmarked(text.trim_start_matches("/*").trim_end().trim_end_matches("*/"))
}

/// A comment without the stars and spaces that its lines begin with.
fn unmarked(comment: &str) -> String {
    let lines = comment.lines().map(|line| line.trim().trim_start_matches('*').trim());
    lines.collect::<Vec<_>>().join("\n").trim().to_owned()
}

/// Tokens as C.
fn joined(tokens: &[Token]) -> String {
    let mut text = String::new();
    for token in tokens {
        let word = String::from_utf8_lossy(&token.raw);
        let tight = text.ends_with(['(', '{']) || word.starts_with([')', '}', ',', ';']);
        let called = word == "(" && text.ends_with(is_word);
        if !text.is_empty() && !tight && !called {
            text.push(' ');
        }
        text.push_str(&word);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads the header `ball.h` with this text.
    fn ball(text: &str) -> Result<Abi, String> {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("relievo");
        std::fs::create_dir(&inside).unwrap();
        let all = "#include <stddef.h>\n#include <stdint.h>\n#include \"relievo/ball.h\"\n";
        std::fs::write(inside.join("relievo.h"), all).unwrap();
        std::fs::write(inside.join("ball.h"), text).unwrap();
        read(folder.path())
    }

    const BALL: &str = "/* Relievo: balls.\n *\n * They roll. */\n\n/* How many. */\n#define RLV_BALLS 7u\n\
        #define RLV_TWICE(a) ((a) + (a))\n\
        /* How it lies. */\ntypedef enum RlvSide { RLV_SIDE_UP = 0, /* up */ RLV_SIDE_DOWN = 4 /* down */ } RlvSide;\n\
        enum { RLV_OK = 0 };\n\
        typedef int32_t RlvResult;\n\
        /* A ball. */\ntypedef struct RlvBall {\n    uint32_t struct_size;\n    float radius; /* metres,\n above 0 */\n\
        char type[RLV_BALLS];\n double centre[3];\n} RlvBall;\n\
        #define RLV_BALL_INIT \\\n    {sizeof(RlvBall), 1.5f, {RLV_SIDE_DOWN}, {0}}\n\
        /* Sees. */\ntypedef void (*RlvSeen)(void *user, const RlvBall *ball);\n\
        /* Rolls it.\n * Fails uphill. */\nRlvResult rlv_ball_roll(const RlvBall *ball, RlvSeen seen, void *user);\n";

    #[test]
    fn a_header_is_read_with_its_comments_values_and_layout() {
        let abi = ball(BALL).unwrap();
        assert_eq!(abi.nouns.len(), 1);
        assert_eq!(
            (abi.nouns[0].name.as_str(), abi.nouns[0].about.as_str()),
            ("ball", "Relievo: balls.\n\nThey roll.")
        );
        let names: Vec<&str> = abi.items().map(|item| item.name.as_str()).collect();
        assert_eq!(
            names,
            ["RLV_BALLS", "RLV_TWICE(a)", "RlvSide", "", "RlvResult", "RlvBall", "RlvSeen", "rlv_ball_roll"]
        );
        let item = |name: &str| abi.items().find(|item| item.name == name).unwrap();
        assert_eq!(item("RLV_BALLS").doc, "How many.");
        assert!(matches!(item("RLV_BALLS").kind, Kind::Constant(7)));
        let Kind::Macro(text) = &item("RLV_TWICE(a)").kind else { panic!() };
        assert_eq!(text, "((a) + (a))");
        let Kind::Enumeration(values) = &item("RlvSide").kind else { panic!() };
        assert_eq!((item("RlvSide").doc.as_str(), values.len()), ("How it lies.", 2));
        assert_eq!((values[1].name.as_str(), values[1].value, values[1].doc.as_str()), ("RLV_SIDE_DOWN", 4, "down"));
        let Kind::Structure(structure) = &item("RlvBall").kind else { panic!() };
        assert_eq!((structure.size, structure.align, item("RlvBall").doc.as_str()), (40, 8, "A ball."));
        let fields = structure
            .fields
            .iter()
            .map(|field| (field.name.as_str(), field.offset, field.kind.c(""), field.doc.as_str()));
        assert_eq!(
            fields.collect::<Vec<_>>(),
            [
                ("struct_size", 0, "uint32_t".to_owned(), ""),
                ("radius", 4, "float".to_owned(), "metres,\nabove 0"),
                ("type", 8, "char [7]".to_owned(), ""),
                ("centre", 16, "double [3]".to_owned(), ""),
            ]
        );
        let initial = Value::List(structure.initial.clone().unwrap()).python();
        assert_eq!(initial, "(ctypes.sizeof(RlvBall), 1.5, (4,), (0,),)");
        let Kind::Callback(signature) = &item("RlvSeen").kind else { panic!() };
        assert_eq!(signature.c("RlvSeen"), "void RlvSeen(void *user, const RlvBall *ball)");
        let Kind::Function(signature) = &item("rlv_ball_roll").kind else { panic!() };
        assert_eq!(signature.c("f"), "RlvResult f(const RlvBall *ball, RlvSeen seen, void *user)");
        assert_eq!(item("rlv_ball_roll").doc, "Rolls it.\nFails uphill.");
        assert_eq!(abi.symbols(), ["rlv_ball_roll"]);
    }

    #[test]
    fn declarations_that_the_abi_does_not_use_are_errors() {
        for (text, said) in [
            ("typedef union RlvU { int32_t a; float b; } RlvU;", "RlvU"),
            ("int32_t rlv_long(long a);", "rlv_long"),
            ("typedef struct RlvA { float (*f)(void); } RlvA;", "RlvA"),
            (
                "typedef struct RlvA { float f; } RlvA;\n#define RLV_A_INIT {0, 0}",
                "RLV_A_INIT has 2 values for 1 fields",
            ),
            ("#define RLV_NOBODY_INIT {0}", "RLV_NOBODY_INIT"),
            ("typedef struct RlvA { rubbish f; } RlvA;", "rubbish"),
        ] {
            let error = ball(text).err().unwrap_or_else(|| panic!("{text} was read"));
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
