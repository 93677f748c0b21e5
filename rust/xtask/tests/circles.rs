//! Modules of a crate that use each other in a circle can only be understood together. This prints the circles of every
//! crate and holds the size of the largest.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, Item, UseTree, Visibility};

/// Modules that may be in one circle.
const LARGEST: usize = 6;

/// Names of modules from the root of a crate.
type ModulePath = Vec<String>;

/// What a module uses and offers.
#[derive(Default)]
struct Module {
    /// Paths that it imports or names.
    uses: Vec<Vec<String>>,
    /// Its public imports: the name, and the path that it stands for.
    exports: Vec<(String, Vec<String>)>,
    /// Names of its items.
    items: BTreeSet<String>,
    /// Types that it gives methods.
    extends: BTreeSet<String>,
}

#[test]
fn circles_of_modules_stay_small() {
    let mut too_large = Vec::new();
    let mut crates = 0;
    for (name, source) in sources() {
        let modules = modules(&source);
        let circles = circles(&uses(&modules));
        let sizes: Vec<usize> = circles.iter().map(Vec::len).collect();
        println!("{name}: {} modules, circles of {sizes:?}", modules.len());
        crates += 1;
        for circle in circles.iter().filter(|circle| circle.len() > LARGEST) {
            let names: Vec<String> = circle.iter().map(|path| path.join("::")).collect();
            too_large.push(format!("{name}, {} modules where {LARGEST} may be: {}", names.len(), names.join(", ")));
        }
    }
    assert!(crates > 20, "only {crates} crates were looked at");
    assert!(too_large.is_empty(), "modules use each other in a circle:\n{}", too_large.join("\n"));
}

#[test]
fn a_circle_is_seen_and_methods_elsewhere_make_none() {
    let module = |text: &str| {
        let mut module = Module::default();
        read(&mut module, &syn::parse_file(text).expect("Rust").items);
        module
    };
    let named = |list: &[(&str, &str)]| -> BTreeMap<ModulePath, Module> {
        list.iter().map(|(name, text)| (vec![(*name).to_owned()], module(text))).collect()
    };
    let three =
        [("a", "use crate::b::B;"), ("b", "fn b(_: &crate::c::C) {} struct B;"), ("c", "use super::a; struct C;")];
    assert_eq!(circles(&uses(&named(&three))).iter().map(Vec::len).collect::<Vec<_>>(), [3]);
    let methods = [("a", "use crate::b::B; pub struct A { b: B }"), ("b", "use crate::a::A; struct B; impl A {}")];
    assert!(circles(&uses(&named(&methods))).is_empty());
    let tests = [("a", "use crate::b::B; struct A;"), ("b", "struct B; #[cfg(test)] mod tests { use crate::a::A; }")];
    assert!(circles(&uses(&named(&tests))).is_empty());
}

/// Returns the name of every crate of ours with the folder of its source.
fn sources() -> Vec<(String, PathBuf)> {
    let rust = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let inside = |folder: &Path| -> Vec<PathBuf> {
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect()
    };
    let mut crates: Vec<PathBuf> = inside(&rust).into_iter().chain(inside(&rust.join("native"))).collect();
    crates.sort();
    let named = crates.into_iter().map(|folder| {
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        (name, folder.join("src"))
    });
    named.filter(|(_, source)| source.is_dir()).collect()
}

/// Reads the modules of a crate, a file each. Stand-ins for features that are left out are not looked at.
fn modules(source: &Path) -> BTreeMap<ModulePath, Module> {
    let mut modules = BTreeMap::new();
    let mut folders = vec![(source.to_owned(), Vec::new())];
    while let Some((folder, above)) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            let stem = path.file_stem().expect("a name").to_string_lossy().into_owned();
            let mut module: ModulePath = above.clone();
            if !["lib", "main", "mod"].contains(&stem.as_str()) {
                module.push(stem.clone());
            }
            if path.is_dir() {
                folders.push((path, module));
            } else if path.extension().is_some_and(|it| it == "rs") && !stem.ends_with("_absent") {
                let text = fs::read_to_string(&path).expect("a file");
                let file = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
                read(modules.entry(module).or_default(), &file.items);
            }
        }
    }
    modules
}

/// Adds what `items` use and offer, without tests.
fn read(module: &mut Module, items: &[Item]) {
    for item in items {
        if is_for_tests(attributes(item)) {
            continue;
        }
        match item {
            Item::Use(it) => {
                let mut paths = Vec::new();
                spread(&it.tree, &mut Vec::new(), &mut paths);
                if matches!(it.vis, Visibility::Inherited) {
                    module.uses.extend(paths.into_iter().map(|(_, path)| path));
                } else {
                    module.exports.extend(paths);
                }
                continue;
            }
            Item::Impl(it) if it.trait_.is_none() => {
                if let syn::Type::Path(path) = &*it.self_ty {
                    module.extends.extend(path.path.segments.last().map(|last| last.ident.to_string()));
                }
            }
            _ => module.items.extend(name(item)),
        }
        Names(module).visit_item(item);
    }
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Mod(it) => &it.attrs,
        Item::Fn(it) => &it.attrs,
        Item::Use(it) => &it.attrs,
        Item::Impl(it) => &it.attrs,
        Item::Const(it) => &it.attrs,
        Item::Struct(it) => &it.attrs,
        _ => &[],
    }
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|it| matches!(&it.meta, syn::Meta::List(list) if list.path.is_ident("cfg") && list.tokens.to_string() == "test"))
}

fn name(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(it) => &it.ident,
        Item::Enum(it) => &it.ident,
        Item::Fn(it) => &it.sig.ident,
        Item::Static(it) => &it.ident,
        Item::Struct(it) => &it.ident,
        Item::Trait(it) => &it.ident,
        Item::Type(it) => &it.ident,
        Item::Union(it) => &it.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

/// Adds the name and the path of everything that `tree` imports.
fn spread(tree: &UseTree, above: &mut Vec<String>, paths: &mut Vec<(String, Vec<String>)>) {
    let below = |last: String, above: &[String]| above.iter().cloned().chain([last]).collect::<Vec<_>>();
    match tree {
        UseTree::Path(it) => {
            above.push(it.ident.to_string());
            spread(&it.tree, above, paths);
            above.pop();
        }
        UseTree::Name(it) if it.ident == "self" => {
            paths.push((above.last().cloned().unwrap_or_default(), above.clone()));
        }
        UseTree::Name(it) => paths.push((it.ident.to_string(), below(it.ident.to_string(), above))),
        UseTree::Rename(it) => paths.push((it.rename.to_string(), below(it.ident.to_string(), above))),
        UseTree::Glob(_) => paths.push(("*".to_owned(), above.clone())),
        UseTree::Group(it) => it.items.iter().for_each(|tree| spread(tree, above, paths)),
    }
}

/// Collects the paths that code names.
struct Names<'m>(&'m mut Module);

impl<'a> Visit<'a> for Names<'_> {
    fn visit_path(&mut self, path: &'a syn::Path) {
        // A name alone is imported, and counted there, or local.
        if path.segments.len() > 1 {
            self.0.uses.push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, it: &'a syn::Macro) {
        in_tokens(it.tokens.clone(), &mut self.0.uses);
        visit::visit_macro(self, it);
    }

    fn visit_item_use(&mut self, it: &'a syn::ItemUse) {
        let mut paths = Vec::new();
        spread(&it.tree, &mut Vec::new(), &mut paths);
        self.0.uses.extend(paths.into_iter().map(|(_, path)| path));
    }
}

/// Adds the paths in the arguments of a macro: names with `::` between them.
fn in_tokens(tokens: TokenStream, uses: &mut Vec<Vec<String>>) {
    let (mut path, mut colons): (Vec<String>, usize) = (Vec::new(), 0);
    let mut end = |path: &mut Vec<String>| {
        if path.len() > 1 {
            uses.push(std::mem::take(path));
        }
        path.clear();
    };
    let mut groups = Vec::new();
    for token in tokens {
        match token {
            TokenTree::Ident(ident) => {
                if colons != 2 {
                    end(&mut path);
                }
                path.push(ident.to_string());
                colons = 0;
            }
            TokenTree::Punct(it) if it.as_char() == ':' => colons += 1,
            TokenTree::Group(group) => groups.push(group.stream()),
            _ => colons = 0,
        }
    }
    end(&mut path);
    groups.into_iter().for_each(|group| in_tokens(group, uses));
}

/// Returns the modules that each module uses. A module that adds methods to a type of another one does not use that one
/// by naming the type.
fn uses(modules: &BTreeMap<ModulePath, Module>) -> BTreeMap<ModulePath, BTreeSet<ModulePath>> {
    let edges = modules.iter().map(|(own, module)| {
        let used = module.uses.iter().filter_map(|path| {
            let (target, rest) = resolve(modules, absolute(modules, own, path)?, 0)?;
            let extended = rest.first().is_some_and(|name| module.extends.contains(name));
            (target != *own && !target.is_empty() && !extended).then_some(target)
        });
        (own.clone(), used.collect())
    });
    edges.collect()
}

/// Returns the path from the root of the crate, if `path` in `module` leads into the crate.
fn absolute(modules: &BTreeMap<ModulePath, Module>, module: &ModulePath, path: &[String]) -> Option<Vec<String>> {
    let mut base = module.clone();
    match path.first()?.as_str() {
        "crate" => return Some(path[1..].to_vec()),
        "self" => return Some(base.into_iter().chain(path[1..].iter().cloned()).collect()),
        "super" => {
            let up = path.iter().take_while(|name| *name == "super").count();
            base.truncate(base.len().saturating_sub(up));
            return Some(base.into_iter().chain(path[up..].iter().cloned()).collect());
        }
        child => base.push(child.to_owned()),
    }
    modules.contains_key(&base).then(|| base.into_iter().chain(path[1..].iter().cloned()).collect())
}

/// Returns the module that a path of the crate leads to, through public imports, and the rest of the path.
fn resolve(modules: &BTreeMap<ModulePath, Module>, path: Vec<String>, steps: u32) -> Option<(ModulePath, Vec<String>)> {
    let length = (0..=path.len()).rev().find(|length| modules.contains_key(&path[..*length]))?;
    let (target, rest) = (path[..length].to_vec(), path[length..].to_vec());
    let (Some(name), true) = (rest.first(), steps < 8) else { return Some((target, rest)) };
    let module = &modules[&target];
    if module.items.contains(name) {
        return Some((target, rest));
    }
    for (export, from) in &module.exports {
        let Some(from) = absolute(modules, &target, from) else { continue };
        if export == name {
            return resolve(modules, from.into_iter().chain(rest[1..].iter().cloned()).collect(), steps + 1);
        }
        if export == "*" && modules.get(&from).is_some_and(|module| module.items.contains(name)) {
            return Some((from, rest));
        }
    }
    Some((target, rest))
}

/// Returns the strongly connected components of more than one module, the largest first (Tarjan 1972).
fn circles(uses: &BTreeMap<ModulePath, BTreeSet<ModulePath>>) -> Vec<Vec<ModulePath>> {
    let mut search = Search { uses, numbers: BTreeMap::new(), open: Vec::new(), found: Vec::new() };
    for module in uses.keys() {
        search.visit(module);
    }
    search.found.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
    search.found
}

struct Search<'a> {
    uses: &'a BTreeMap<ModulePath, BTreeSet<ModulePath>>,
    /// The order in which modules were met.
    numbers: BTreeMap<&'a ModulePath, usize>,
    open: Vec<&'a ModulePath>,
    found: Vec<Vec<ModulePath>>,
}

impl<'a> Search<'a> {
    /// Returns the smallest number that `module` leads to among open modules.
    fn visit(&mut self, module: &'a ModulePath) -> usize {
        if let Some(number) = self.numbers.get(module) {
            return if self.open.contains(&module) { *number } else { usize::MAX };
        }
        let number = self.numbers.len();
        self.numbers.insert(module, number);
        self.open.push(module);
        let uses = self.uses;
        let used = uses.get(module).into_iter().flatten().filter_map(|used| uses.get_key_value(used));
        let lowest = used.map(|(used, _)| self.visit(used)).min().unwrap_or(number).min(number);
        if lowest == number {
            let from = self.open.iter().position(|it| *it == module).expect("it is open");
            let circle: Vec<ModulePath> = self.open.drain(from..).cloned().collect();
            if circle.len() > 1 {
                self.found.push(circle);
            }
        }
        lowest
    }
}
