//! The `[colliders.NAME]` tables of a scene file: objects that press, and crowds.

use glam::DVec3;
use relievo_core::error::nearest;

use crate::format::description::*;
use crate::format::diagnostic::Diagnostic;
use crate::format::names::{Names, own_object};
use crate::format::reader::{Name, Reader, Table};

/// What colliders may name.
pub(crate) struct Known<'a> {
    pub objects: &'a Names<'a>,
    pub entries: &'a [Option<ObjectEntry>],
    /// Names of the crowds, where they have one.
    pub crowds: &'a [Option<Name>],
}

/// Entries, with a gap for each that cannot be made.
type Entries<T> = Vec<Option<T>>;

/// Reads the colliders: the objects, and the crowds.
pub(crate) fn read_colliders(
    reader: &mut Reader,
    tables: &[(Name, Table)],
    known: &Known,
    settings: relievo_detail::ImprintSettings,
) -> (Entries<ColliderEntry>, Entries<CrowdColliderEntry>) {
    let (crowds, objects): (Vec<_>, Vec<_>) = tables.iter().partition(|(_, table)| table.has("crowd"));
    let objects =
        objects.into_iter().map(|(name, table)| read_collider(reader, name, *table, known, settings)).collect();
    let crowds = crowds.into_iter().map(|(name, table)| read_crowd(reader, name, *table, known, settings)).collect();
    (objects, crowds)
}

/// What objects and crowds that press have in common.
struct Press {
    into: Vec<usize>,
    from: f64,
    until: f64,
    settings: relievo_detail::ImprintSettings,
}

/// Reads what the `object` presses into, and how; `None` is a crowd.
fn read_press(
    reader: &mut Reader,
    name: &Name,
    table: Table,
    known: &Known,
    object: Option<usize>,
    mut settings: relievo_detail::ImprintSettings,
) -> Press {
    let (from, until) = (reader.number(table, "from"), reader.number(table, "until"));
    if until <= from {
        reader.fault(
            Diagnostic::new(table.span_of("until"), "the collider ends before it begins")
                .relate(table.span_of("from"), "it begins here")
                .advise("make `until` later than `from`"),
        );
    }
    let deformable =
        |index: usize| known.entries.get(index).and_then(Option::as_ref).is_none_or(|entry| entry.deformable);
    let into = match reader.texts(table, "into") {
        None => (0..known.entries.len()).filter(|index| deformable(*index) && Some(*index) != object).collect(),
        Some(names) => {
            let mut list = Vec::new();
            for into in &names {
                let Some(index) = known.objects.find(reader, into) else { continue };
                if Some(index) == object {
                    reader.fault(
                        Diagnostic::new(into.span.clone(), format!("`{}` cannot press into itself", into.text))
                            .advise("name another object"),
                    );
                } else if !deformable(index) {
                    reader.fault(
                        Diagnostic::new(into.span.clone(), format!("`{}` is not deformable", into.text))
                            .advise("give that object a `surface`, and leave out its `role`"),
                    );
                } else {
                    list.push(index);
                }
            }
            list
        }
    };
    if into.is_empty() && !table.has("into") {
        reader.fault(
            Diagnostic::new(name.span.clone(), "there is nothing deformable to press into")
                .advise("give another object a `surface`"),
        );
    }
    reader.parameters(table, |parameter, value| settings.set(parameter.name, value).is_ok());
    Press { into, from, until, settings }
}

fn read_collider(
    reader: &mut Reader,
    name: &Name,
    table: Table,
    known: &Known,
    settings: relievo_detail::ImprintSettings,
) -> Option<ColliderEntry> {
    let object = own_object(reader, name, table, known.objects);
    if table.has("triangles") {
        reader.fault(
            Diagnostic::new(table.span_of("triangles"), "`triangles` means nothing for an object")
                .advise("remove it, or press with a `crowd`"),
        );
    }
    let Press { into, from, until, settings } = read_press(reader, name, table, known, object, settings);
    let tool = if table.has("tool") { read_tool(reader, table, name) } else { None };
    if tool.is_some() {
        let surface = |entry: &ObjectEntry| matches!(entry.geometry, Geometry::Surface(_));
        if object.and_then(|object| known.entries.get(object)?.as_ref()).is_some_and(surface) {
            reader.fault(
                Diagnostic::new(table.span_of("tool"), "a tool must be rigid, and this object shows a surface")
                    .advise("give the object a `mesh`"),
            );
        }
        if into.len() > 1 {
            reader.fault(
                Diagnostic::new(table.span_of("tool"), "a tool can be pressed into one object only")
                    .advise("name one object in `into`"),
            );
        }
    }
    Some(ColliderEntry { name: name.clone(), object: object?, into, from, until, settings, tool })
}

fn read_crowd(
    reader: &mut Reader,
    name: &Name,
    table: Table,
    known: &Known,
    settings: relievo_detail::ImprintSettings,
) -> Option<CrowdColliderEntry> {
    let written = reader.text(table, "crowd");
    let crowd = written.and_then(|written| {
        let found = known.crowds.iter().position(|name| name.as_ref().is_some_and(|name| name.text == written.text));
        if found.is_none() {
            let fault = Diagnostic::new(written.span.clone(), format!("there is no `{}` in [[crowds]]", written.text));
            let near = nearest(&written.text, known.crowds.iter().flatten().map(|name| name.text.as_str()));
            reader.fault(match near {
                Some(near) => fault.advise(format!("did you mean `{near}`?")),
                None => fault.advise(format!("give the crowd `name = \"{}\"`", written.text)),
            });
        }
        found
    });
    for (key, what, remedy) in [
        ("object", "either an object or a crowd presses", "remove `object` or `crowd`"),
        ("tool", "a force cannot press a crowd", "remove `tool`: agents press where they walk"),
    ] {
        if table.has(key) {
            reader.fault(Diagnostic::new(table.span_of(key), what).advise(remedy));
        }
    }
    let triangles = reader.whole(table, "triangles");
    let Press { into, from, until, settings } = read_press(reader, name, table, known, None, settings);
    Some(CrowdColliderEntry { name: name.clone(), crowd: crowd?, triangles, into, from, until, settings })
}

fn read_tool(reader: &mut Reader, table: Table, name: &Name) -> Option<ToolEntry> {
    let span = table.span_of("tool");
    let tool = reader.sub_table(table, "tool");
    let mut settings = relievo_detail::tool::ToolSettings::default();
    reader.parameters(tool, |parameter, value| settings.set(parameter.name, value).is_ok());
    match reader.optional_vector(tool, "force").map(DVec3::from) {
        Some(force) if force != DVec3::ZERO => Some(ToolEntry { force, settings }),
        Some(_) => {
            reader.fault(
                Diagnostic::new(tool.span_of("force"), "a force of zero has no direction")
                    .advise("let the collider act at other times with `from` and `until`"),
            );
            None
        }
        None => {
            reader.fault(
                Diagnostic::new(span, format!("the tool `{}` has no force", name.text))
                    .advise("give `force = [0, 0, -30]`, in newtons"),
            );
            None
        }
    }
}

/// What a collider presses, into what, and from when until when.
struct Claim<'a> {
    presses: usize,
    name: &'a Name,
    into: &'a [usize],
    when: [f64; 2],
}

/// Notes colliders that press the same into the same at the same time.
fn check_claims(reader: &mut Reader, claims: &[Claim], what: &str) {
    for (at, claim) in claims.iter().enumerate() {
        let same = |other: &&Claim| {
            let overlap = other.when[0] < claim.when[1] && claim.when[0] < other.when[1];
            other.presses == claim.presses && overlap && other.into.iter().any(|into| claim.into.contains(into))
        };
        if let Some(other) = claims[..at].iter().find(same) {
            reader.fault(
                Diagnostic::new(claim.name.span.clone(), what)
                    .relate(other.name.span.clone(), "the other one")
                    .advise("remove one, or let them act at different times with `from` and `until`"),
            );
        }
    }
}

/// Notes colliders that contradict each other or bodies.
pub(crate) fn check_colliders(
    reader: &mut Reader,
    colliders: &[Option<ColliderEntry>],
    crowds: &[Option<CrowdColliderEntry>],
    bodies: &[Option<BodyEntry>],
) {
    let crowds = crowds.iter().flatten().map(|it| {
        let CrowdColliderEntry { crowd: presses, name, into, from, until, .. } = it;
        Claim { presses: *presses, name, into, when: [*from, *until] }
    });
    let objects = colliders.iter().flatten().map(|it| {
        let ColliderEntry { object: presses, name, into, from, until, .. } = it;
        Claim { presses: *presses, name, into, when: [*from, *until] }
    });
    let (crowds, objects): (Vec<Claim>, Vec<Claim>) = (crowds.collect(), objects.collect());
    check_claims(reader, &crowds, "two colliders press the same crowd into the same object");
    check_claims(reader, &objects, "two colliders press the same object into the same other");
    for collider in colliders.iter().flatten().filter(|collider| collider.tool.is_some()) {
        let own = |body: &&BodyEntry| body.object == collider.object && body.motion == Motion::Dynamic;
        if let Some(body) = bodies.iter().flatten().find(own) {
            reader.fault(
                Diagnostic::new(
                    collider.name.span.clone(),
                    "physics and the force of `tool` would move the same object",
                )
                .relate(body.name.span.clone(), "the body")
                .advise("give the body keyframes, remove it, or remove `tool`"),
            );
        }
        let also = |other: &&ColliderEntry| {
            let overlap = other.from < collider.until && collider.from < other.until;
            other.object == collider.object && other.name != collider.name && overlap
        };
        if let Some(other) = colliders.iter().flatten().find(also) {
            reader.fault(
                Diagnostic::new(collider.name.span.clone(), "a tool can be pressed into one object at a time only")
                    .relate(other.name.span.clone(), "the same object presses here as well")
                    .advise("remove one, or let them act at different times with `from` and `until`"),
            );
        }
    }
}
