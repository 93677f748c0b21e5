//! Finds the code of mutants in a file, and what to write in its place so that a number chooses between both.

use std::collections::BTreeMap;
use std::ops::Range;

use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{
    Arm, BinOp, Block, Expr, ExprBinary, ExprConst, ExprRepeat, ExprStruct, ExprUnary, ImplItemConst, ImplItemFn,
    ItemConst, ItemFn, ItemStatic, Pat, PatGuard, Signature, TraitItemConst, TraitItemFn, TypeArray, TypeImplTrait,
    Variant,
};

/// The module with the check that is woven into each crate.
pub const MODULE: &str = "relievo_mutants";

const IN_CONST: &str = "it is in a constant, which a variable of the environment cannot change";
const IN_LET: &str = "it is an operator between conditions with `let`";
const OPAQUE: &str = "the function returns `impl Trait`, which is one type";
const ABSENT: &str = "no code of its kind begins at its place";

/// A mutant in a file.
#[derive(Clone, Debug)]
pub struct Site {
    /// What chooses it; from 1.
    pub number: u32,
    /// Its kind, as cargo-mutants calls it.
    pub genre: String,
    /// What is written instead.
    pub replacement: String,
    /// The byte where it begins.
    pub start: usize,
}

/// What is written in place of a range of bytes.
#[derive(Debug)]
pub struct Edit {
    pub number: u32,
    pub range: Range<usize>,
    pub pieces: Vec<Piece>,
}

/// A part of what is written.
#[derive(Debug)]
pub enum Piece {
    Text(String),
    /// Bytes of the file, with the edits in them.
    Source(Range<usize>),
    /// What only the mutant runs.
    Mutated(Vec<Piece>),
}

/// Returns the edits of a file in the order of their places, outer ones first, and the mutants that cannot be chosen while
/// the program runs, each with the reason.
pub fn find(file: &syn::File, sites: &[Site]) -> (Vec<Edit>, BTreeMap<u32, &'static str>) {
    let refused = sites.iter().map(|site| (site.number, ABSENT)).collect();
    let mut finder = Finder { sites, edits: Vec::new(), refused, is_const: false };
    finder.visit_file(file);
    let mut edits = finder.edits;
    edits
        .sort_by_key(|edit| (edit.range.start, !edit.range.is_empty(), std::cmp::Reverse(edit.range.end), edit.number));
    (edits, finder.refused)
}

struct Finder<'a> {
    sites: &'a [Site],
    edits: Vec<Edit>,
    refused: BTreeMap<u32, &'static str>,
    is_const: bool,
}

fn range(code: &impl Spanned) -> Range<usize> {
    code.span().byte_range()
}

fn text(text: impl Into<String>) -> Piece {
    Piece::Text(text.into())
}

fn check(number: u32) -> String {
    format!("crate::{MODULE}::is_on({number})")
}

impl<'a> Finder<'a> {
    /// The mutants of a kind that begin at a byte. In a constant they are refused.
    fn at(&mut self, genre: &str, start: usize) -> Vec<&'a Site> {
        let sites: Vec<&Site> = self.sites.iter().filter(|it| it.start == start && it.genre == genre).collect();
        if self.is_const {
            sites.iter().for_each(|site| self.refuse(site, IN_CONST));
            return Vec::new();
        }
        sites
    }

    fn refuse(&mut self, site: &Site, reason: &'static str) {
        self.refused.insert(site.number, reason);
    }

    fn edit(&mut self, site: &Site, range: Range<usize>, pieces: Vec<Piece>) {
        self.refused.remove(&site.number);
        self.edits.push(Edit { number: site.number, range, pieces });
    }

    /// Writes a choice in place of an expression: the mutated value where the mutant runs, else the expression as it was.
    fn choose(&mut self, site: &Site, range: Range<usize>, mutated: Vec<Piece>) {
        let pieces = vec![
            text(format!("(if {} {{ ", check(site.number))),
            Piece::Mutated(mutated),
            // Parentheses, since a block would take the start of `match x {} + 1` for a statement.
            text(" } else { ("),
            Piece::Source(range.clone()),
            text(") })"),
        ];
        self.edit(site, range, pieces);
    }

    fn function(&mut self, signature: &'a Signature, block: &'a Block) {
        let outer = std::mem::replace(&mut self.is_const, signature.constness.is_some());
        if let Some(first) = block.stmts.first() {
            let start = range(first).start;
            for site in self.at("FnValue", start) {
                if is_opaque(signature) {
                    self.refuse(site, OPAQUE);
                    continue;
                }
                let pieces = vec![
                    text(format!("if {} {{ return ", check(site.number))),
                    Piece::Mutated(vec![text(&site.replacement)]),
                    text("; } "),
                ];
                self.edit(site, start..start, pieces);
            }
        }
        self.visit_block(block);
        self.is_const = outer;
    }

    fn constant(&mut self, visit: impl FnOnce(&mut Self)) {
        let outer = std::mem::replace(&mut self.is_const, true);
        visit(self);
        self.is_const = outer;
    }
}

/// Returns whether a function names only a trait of what it returns.
fn is_opaque(signature: &Signature) -> bool {
    struct Opaque(bool);
    impl<'a> Visit<'a> for Opaque {
        fn visit_type_impl_trait(&mut self, _: &'a TypeImplTrait) {
            self.0 = true;
        }
    }
    let mut opaque = Opaque(false);
    opaque.visit_return_type(&signature.output);
    opaque.0
}

/// Returns whether a condition has a `let` that is not within parentheses.
fn has_let(condition: &Expr) -> bool {
    match condition {
        Expr::Let(_) => true,
        Expr::Binary(ExprBinary { left, op: BinOp::And(_), right, .. }) => has_let(left) || has_let(right),
        _ => false,
    }
}

impl<'a> Visit<'a> for Finder<'a> {
    fn visit_item_fn(&mut self, item: &'a ItemFn) {
        self.function(&item.sig, &item.block);
    }

    fn visit_impl_item_fn(&mut self, item: &'a ImplItemFn) {
        self.function(&item.sig, &item.block);
    }

    fn visit_trait_item_fn(&mut self, item: &'a TraitItemFn) {
        if let Some(block) = &item.default {
            self.function(&item.sig, block);
        }
    }

    fn visit_expr_binary(&mut self, expr: &'a ExprBinary) {
        for site in self.at("BinaryOperator", range(&expr.op).start) {
            if has_let(&expr.left) || has_let(&expr.right) {
                self.refuse(site, IN_LET);
                continue;
            }
            // Operands keep their operators, whichever binds more strongly than the new one.
            let mutated = vec![
                text("("),
                Piece::Source(range(&expr.left)),
                text(format!(") {} (", site.replacement)),
                Piece::Source(range(&expr.right)),
                text(")"),
            ];
            self.choose(site, range(expr), mutated);
        }
        visit::visit_expr_binary(self, expr);
    }

    fn visit_expr_unary(&mut self, expr: &'a ExprUnary) {
        for site in self.at("UnaryOperator", range(&expr.op).start) {
            let mutated = vec![text(format!("{}(", site.replacement)), Piece::Source(range(&expr.expr)), text(")")];
            self.choose(site, range(expr), mutated);
        }
        visit::visit_expr_unary(self, expr);
    }

    fn visit_arm(&mut self, arm: &'a Arm) {
        for site in self.at("MatchArm", range(arm).start) {
            match &arm.pat {
                Pat::Guard(PatGuard { guard, .. }) if has_let(guard) => self.refuse(site, IN_LET),
                Pat::Guard(PatGuard { guard, .. }) => {
                    let guard = range(guard);
                    let check = text(format!("!{} && (", check(site.number)));
                    self.edit(site, guard.clone(), vec![check, Piece::Source(guard), text(")")]);
                }
                pattern => {
                    let end = range(pattern).end;
                    self.edit(site, end..end, vec![text(format!(" if !{}", check(site.number)))]);
                }
            }
        }
        if let Pat::Guard(PatGuard { guard, .. }) = &arm.pat {
            for site in self.at("MatchArmGuard", range(guard).start) {
                if has_let(guard) {
                    self.refuse(site, IN_LET);
                } else {
                    self.choose(site, range(guard), vec![text(&site.replacement)]);
                }
            }
        }
        visit::visit_arm(self, arm);
    }

    fn visit_expr_struct(&mut self, expr: &'a ExprStruct) {
        for field in &expr.fields {
            for site in self.at("StructField", range(field).start) {
                let Some(rest) = &expr.rest else { continue };
                let member = &field.member;
                let name = |pieces: &mut Vec<Piece>| pieces.push(Piece::Source(range(member)));
                let mut mutated = vec![text("{ let whole: "), Piece::Source(range(&expr.path)), text(" = ")];
                mutated.extend([Piece::Source(range(rest)), text("; whole.")]);
                name(&mut mutated);
                mutated.push(text(" }"));
                let mut pieces = Vec::new();
                name(&mut pieces);
                pieces.push(text(format!(": (if {} {{ ", check(site.number))));
                pieces.push(Piece::Mutated(mutated));
                pieces.extend([text(" } else { ("), Piece::Source(range(&field.expr)), text(") })")]);
                self.edit(site, range(field), pieces);
            }
        }
        visit::visit_expr_struct(self, expr);
    }

    fn visit_pat(&mut self, pattern: &'a Pat) {
        match pattern {
            Pat::Guard(PatGuard { pat, guard, .. }) => {
                self.visit_pat(pat);
                self.visit_expr(guard);
            }
            _ => self.constant(|finder| visit::visit_pat(finder, pattern)),
        }
    }

    fn visit_item_const(&mut self, item: &'a ItemConst) {
        self.constant(|finder| visit::visit_item_const(finder, item));
    }

    fn visit_item_static(&mut self, item: &'a ItemStatic) {
        self.constant(|finder| visit::visit_item_static(finder, item));
    }

    fn visit_impl_item_const(&mut self, item: &'a ImplItemConst) {
        self.constant(|finder| visit::visit_impl_item_const(finder, item));
    }

    fn visit_trait_item_const(&mut self, item: &'a TraitItemConst) {
        self.constant(|finder| visit::visit_trait_item_const(finder, item));
    }

    fn visit_variant(&mut self, item: &'a Variant) {
        self.constant(|finder| visit::visit_variant(finder, item));
    }

    fn visit_type_array(&mut self, array: &'a TypeArray) {
        self.constant(|finder| visit::visit_type_array(finder, array));
    }

    fn visit_expr_const(&mut self, block: &'a ExprConst) {
        self.constant(|finder| visit::visit_expr_const(finder, block));
    }

    fn visit_expr_repeat(&mut self, array: &'a ExprRepeat) {
        self.visit_expr(&array.expr);
        self.constant(|finder| finder.visit_expr(&array.len));
    }

    fn visit_generic_argument(&mut self, argument: &'a syn::GenericArgument) {
        match argument {
            syn::GenericArgument::Const(value) => self.constant(|finder| finder.visit_expr(value)),
            _ => visit::visit_generic_argument(self, argument),
        }
    }
}
