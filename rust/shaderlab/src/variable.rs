//! The float variables of a shader, from which an editor lets users choose the features of a vector (Section 4.2).

use naga::proc::TypeResolution;

use crate::annotation::{Annotation, Meaning};
use crate::edit::{Edit, apply};
use crate::fault::{Fault, Faults, Span};
use crate::front::Parsed;
use crate::outline::{Declaration, Declared, FLOATS, Outline};
use crate::shader::Shader;
use crate::source::{Language, Source};

/// A float or a vector of floats that a shader declares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Its name in the shader.
    pub name: String,
    /// The name that the annotation `name` gives it.
    pub label: Option<String>,
    /// What the annotation `desc` says about it.
    pub description: Option<String>,
    /// How many floats it has, 1 to 4.
    pub components: u32,
    /// How it is declared.
    pub declared: Declared,
    /// The function that declares it.
    pub function: Option<String>,
    /// The bytes of its name where it is declared.
    pub place: Span,
    /// The bytes in which its name means this variable.
    pub scope: Span,
    /// Whether its declaration gives it a value. A vector that is taken behind one that does not holds no meaningful value.
    pub is_initialized: bool,
    /// The byte from which it can be used, if that is a place for statements.
    pub(crate) usable: Option<usize>,
    /// The index of its function.
    pub(crate) owner: Option<usize>,
}

impl Variable {
    /// Returns the expressions of its components.
    pub fn expressions(&self) -> Vec<String> {
        match self.components {
            1 => vec![self.name.clone()],
            count => "xyzw".chars().take(count as usize).map(|part| format!("{}.{part}", self.name)).collect(),
        }
    }
}

/// Returns the float variables of a shader in the order of its text.
pub(crate) fn variables(shader: &Shader) -> Vec<Variable> {
    let Shader { source, outline, parsed, annotations, tokens, .. } = shader;
    let mut found = Vec::new();
    for (index, declaration) in outline.declarations.iter().enumerate() {
        let components = match source.language {
            Language::Glsl => declaration
                .type_name
                .as_deref()
                .and_then(|name| FLOATS.iter().find(|(other, _)| *other == name).map(|(_, components)| *components)),
            Language::Wgsl => components(parsed, outline, declaration),
        };
        let Some(components) = components else { continue };
        // Annotations of a name stand between the declaration before and this one.
        let previous = index.checked_sub(1).map_or(0, |before| outline.declarations[before].token + 1);
        let between = |it: &&Annotation| (previous..declaration.token).contains(&it.token);
        let is_beside = |it: &&Annotation| tokens[it.token..declaration.token].iter().all(|token| token.is_comment());
        let notes = || annotations.iter().filter(between).filter(is_beside);
        let mut label =
            notes().filter_map(|it| if let Meaning::Name(text) = &it.meaning { Some(text.clone()) } else { None });
        let mut description = notes()
            .filter_map(|it| if let Meaning::Description(text) = &it.meaning { Some(text.clone()) } else { None });
        found.push(Variable {
            name: declaration.name.clone(),
            label: label.next_back(),
            description: description.next_back(),
            components,
            declared: declaration.declared,
            function: declaration.function.map(|it| outline.functions[it].name.clone()),
            place: declaration.place.clone(),
            scope: declaration.scope.clone(),
            is_initialized: declaration.is_initialized,
            usable: declaration.usable,
            owner: declaration.function,
        });
    }
    found
}

/// Returns the floats of a type, or `None` for one that is no float and no vector of floats.
fn floats(inner: &naga::TypeInner) -> Option<u32> {
    let is_float = |scalar: &naga::Scalar| *scalar == naga::Scalar::F32;
    match inner {
        naga::TypeInner::Scalar(scalar) if is_float(scalar) => Some(1),
        naga::TypeInner::Vector { size, scalar } if is_float(scalar) => Some(*size as u32),
        _ => None,
    }
}

/// Returns the floats of a WGSL variable by its type in the module of naga.
fn components(parsed: &Parsed, outline: &Outline, declaration: &Declaration) -> Option<u32> {
    let Parsed { module, info, .. } = parsed;
    let inner = |handle: naga::Handle<naga::Type>| &module.types[handle].inner;
    let name = declaration.name.as_str();
    let is_named = |other: &Option<String>| other.as_deref() == Some(name);
    let Some(function) = declaration.function.map(|it| &outline.functions[it]) else {
        let global = module.global_variables.iter().find(|(_, it)| is_named(&it.name))?;
        return floats(inner(global.1.ty));
    };
    let plain = module.functions.iter().find(|(_, it)| it.name.as_deref() == Some(&function.name));
    let entry = || module.entry_points.iter().position(|it| it.name == function.name);
    let (body, info) = match plain {
        Some((handle, body)) => (body, &info[handle]),
        None => {
            let index = entry()?;
            (&module.entry_points[index].function, info.get_entry_point(index))
        }
    };
    if declaration.declared == Declared::Parameter {
        return floats(inner(body.arguments.iter().find(|it| is_named(&it.name))?.ty));
    }
    // The declaration's own statement tells two variables of one name apart.
    let statement = declaration.place.start..declaration.usable.unwrap_or(declaration.place.end);
    let is_here = |span: naga::Span| {
        let at = parsed.range(span);
        at.start < statement.end && statement.start < at.end
    };
    let locals = || body.local_variables.iter().filter(|(_, it)| is_named(&it.name));
    let local = locals().find(|(handle, _)| is_here(body.local_variables.get_span(*handle)));
    if let Some((_, local)) = local {
        return floats(inner(local.ty));
    }
    let values = || body.named_expressions.iter().filter(|(_, other)| other.as_str() == name);
    let value = values().find(|(handle, _)| is_here(body.expressions.get_span(**handle))).or_else(|| values().next());
    if let Some((handle, _)) = value {
        return match &info[*handle].ty {
            TypeResolution::Handle(handle) => floats(inner(*handle)),
            TypeResolution::Value(inner) => floats(inner),
        };
    }
    locals().next().and_then(|(_, local)| floats(inner(local.ty)))
}

/// Returns the text of a shader with a vector of variables, taken with weight `weight` behind the last of them.
///
/// `chosen` has indices into `variables`, which are those of this shader. Fails if there is none, if one cannot be seen from
/// where the last is declared, or if no statement can stand there.
pub(crate) fn with_vector(
    source: &Source,
    outline: &Outline,
    variables: &[Variable],
    chosen: &[usize],
    weight: &str,
) -> Result<String, Faults> {
    let refused = |fault: Fault| Faults { source: source.clone(), list: vec![fault] };
    let mut picked = Vec::with_capacity(chosen.len());
    for index in chosen {
        let variable = variables.get(*index);
        picked.push(variable.ok_or_else(|| refused(Fault::new(0..0, format!("there is no variable {index}"))))?);
    }
    let Some(last) = picked.iter().max_by_key(|it| (it.owner.is_some(), it.place.start)) else {
        return Err(refused(Fault::new(0..0, "no variable is chosen for the vector").advise("choose at least one")));
    };
    let text = &*source.text;
    let at = match (last.declared, last.owner) {
        (Declared::Local, _) => last.usable,
        (Declared::Parameter, Some(owner)) => Some(outline.functions[owner].body.start + 1),
        // Globals have their values when the entry point begins.
        _ => {
            let main = outline.functions.iter().rev().find(|function| !function.body.is_empty());
            main.map(|function| function.body.start + 1)
        }
    };
    let Some(at) = at else {
        let what = format!("no statement can stand behind the declaration of `{}`", last.name);
        return Err(refused(Fault::new(last.place.clone(), what).advise("put its block into braces")));
    };
    if let Some(hidden) = picked.iter().find(|it| it.owner.is_some() && !(it.scope.start < at && at <= it.scope.end)) {
        let what = format!("`{}` cannot be used where `{}` is declared", hidden.name, last.name);
        let fault =
            Fault::new(hidden.place.clone(), what).relate(last.place.clone(), "the last variable of the vector");
        return Err(refused(fault.advise("choose variables of one function whose scopes overlap")));
    }
    let line = text[..at].rfind('\n').map_or(0, |at| at + 1);
    let indent: String = text[line..].chars().take_while(|it| matches!(it, ' ' | '\t')).collect();
    let deeper = if text[..at].ends_with('{') { "    " } else { "" };
    let features: Vec<_> = picked.iter().flat_map(|variable| variable.expressions()).collect();
    let note = format!("\n{indent}{deeper}//. vector {}; {weight}", features.join("; "));
    // What follows on the line must not become part of the comment.
    let rest = text[at..].split('\n').next().unwrap_or_default().trim();
    let note = if rest.is_empty() || rest.starts_with("//") { note } else { format!("{note}\n{indent}{deeper}") };
    let place = if rest.starts_with("//") { at + text[at..].find('\n').unwrap_or(text.len() - at) } else { at };
    Ok(apply(text, vec![Edit::insert(place, note)]).0)
}
