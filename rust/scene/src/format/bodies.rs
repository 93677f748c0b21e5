//! The `[bodies.NAME]` tables of a scene file: rigid bodies, their forces and their keyframes.

use glam::DVec3;

use crate::format::description::*;
use crate::format::diagnostic::{Diagnostic, Span};
use crate::format::names::{Names, own_object};
use crate::format::placement::Placement;
use crate::format::placement::{AT_ORIGIN, read_placement};
use crate::format::reader::{Name, Reader, Table};
use crate::format::schema;

pub(crate) fn read_body(
    reader: &mut Reader,
    name: &Name,
    table: Table,
    objects: &Names,
    entries: &[Option<ObjectEntry>],
    metres: f64,
) -> Option<BodyEntry> {
    let object = own_object(reader, name, table, objects);
    let start = object.and_then(|object| entries.get(object)?.as_ref()).map_or(AT_ORIGIN, |object| object.placement);
    let keyframes = read_keyframes(reader, table, start);
    let motion = match reader.choice(table, "motion").filter(|_| table.has("motion")) {
        Some("fixed") => Motion::Fixed,
        Some("keyframed") => Motion::Keyframed,
        Some(_) => Motion::Dynamic,
        None if table.has("keyframes") => Motion::Keyframed,
        None => Motion::Dynamic,
    };
    match motion {
        Motion::Keyframed if keyframes.is_empty() => reader.fault(
            Diagnostic::new(table.span_of("motion"), format!("body `{}` is keyframed but has no keyframes", name.text))
                .advise("give it `keyframes = [{ time = 0, translation = [0, 0, 0] }, …]`"),
        ),
        Motion::Fixed | Motion::Dynamic if !keyframes.is_empty() => reader.fault(
            Diagnostic::new(table.span_of("keyframes"), "keyframes contradict `motion`")
                .relate(table.span_of("motion"), "says how it moves")
                .advise("remove one of them"),
        ),
        _ => {}
    }
    const FORCES: &[&str] = &[
        "mass",
        "density",
        "velocity",
        "angular_velocity",
        "force",
        "torque",
        "motor_axis",
        "motor_speed",
        "motor_torque",
        "damping",
        "angular_damping",
        "locked",
    ];
    if motion != Motion::Dynamic {
        for key in FORCES.iter().filter(|key| table.has(key)) {
            reader.fault(
                Diagnostic::new(
                    table.span_of(key),
                    format!("`{key}` means nothing for a body that forces do not move"),
                )
                .advise(format!("remove it, or make body `{}` dynamic", name.text)),
            );
        }
    }
    if table.has("mass") && table.has("density") {
        reader.fault(
            Diagnostic::new(table.span_of("density"), "a body has either a mass or a density")
                .relate(table.span_of("mass"), "the mass")
                .advise("remove one of them"),
        );
    }
    let mass = match (reader.optional_number(table, "mass"), reader.optional_number(table, "density")) {
        (Some(mass), _) => Mass::Total(mass),
        (None, density) => Mass::Density(density.unwrap_or(1000.0 * metres.powi(3))),
    };
    let stand_in = match reader.choice(table, "shape") {
        Some("none") => StandIn::None,
        Some("trimesh") => StandIn::TriMesh,
        Some("heightfield") => StandIn::HeightField,
        Some("ball") => StandIn::Ball,
        Some("cylinder") => StandIn::Cylinder,
        Some("box") => StandIn::Box,
        _ => StandIn::Convex,
    };
    if motion == Motion::Dynamic && matches!(stand_in, StandIn::TriMesh | StandIn::HeightField) {
        reader.fault(
            Diagnostic::new(table.span_of("shape"), "a dynamic body must be convex, since a surface has no inside")
                .advise("use `convex`, `ball`, `cylinder` or `box`"),
        );
    }
    if table.has("radius") && !matches!(stand_in, StandIn::Ball | StandIn::Cylinder) {
        reader.fault(
            Diagnostic::new(table.span_of("radius"), "only a ball or a cylinder has a radius")
                .advise("remove it, or set `shape`"),
        );
    }
    let motor = read_motor(reader, table);
    let locked = reader.choices(table, "locked");
    Some(BodyEntry {
        name: name.clone(),
        object: object?,
        motion,
        stand_in,
        inset: reader.number(table, "inset"),
        radius: reader.optional_number(table, "radius"),
        mass,
        friction: reader.number(table, "friction"),
        restitution: reader.number(table, "restitution"),
        velocity: reader.vector(table, "velocity").into(),
        angular_velocity: DVec3::from(reader.vector(table, "angular_velocity").map(f64::to_radians)),
        force: reader.vector(table, "force").into(),
        torque: reader.vector(table, "torque").into(),
        motor,
        damping: reader.number(table, "damping"),
        angular_damping: reader.number(table, "angular_damping"),
        locked: std::array::from_fn(|index| locked.contains(&schema::LOCKS[index])),
        keyframes,
    })
}

fn read_motor(reader: &mut Reader, table: Table) -> Option<Motor> {
    let axis = reader.optional_vector(table, "motor_axis").map(DVec3::from);
    let speed = reader.number(table, "motor_speed").to_radians();
    let torque = reader.number(table, "motor_torque");
    match axis.map(DVec3::try_normalize) {
        Some(Some(axis)) => Some(Motor { axis, speed, torque }),
        Some(None) => {
            reader.fault(Diagnostic::new(table.span_of("motor_axis"), "the motor's axis has no direction"));
            None
        }
        None => {
            if let Some(key) = table.first_of(&["motor_speed", "motor_torque"]) {
                reader.fault(
                    Diagnostic::new(table.span_of(key), "the motor has no axis")
                        .advise("give `motor_axis = [0, 1, 0]`"),
                );
            }
            None
        }
    }
}

fn read_keyframes(reader: &mut Reader, table: Table, start: Placement) -> Vec<Keyframe> {
    let mut list: Vec<Keyframe> = Vec::new();
    let mut spans: Vec<Span> = Vec::new();
    for item in reader.list(table, "keyframes") {
        let Some(time) = read_time(reader, item, list.last().map(|key| key.time), spans.last()) else { continue };
        let before = list.last().map_or(start, |key| key.placement);
        list.push(Keyframe { time, placement: read_placement(reader, item, before) });
        spans.push(item.span_of("time"));
    }
    list
}

/// The time of a keyframe, which must come after the one before.
pub(crate) fn read_time(reader: &mut Reader, item: Table, before: Option<f64>, span: Option<&Span>) -> Option<f64> {
    if !item.has("time") {
        reader.fault(Diagnostic::new(item.span(), "a keyframe needs a time").advise("give `time` in seconds"));
        return None;
    }
    let time = reader.number(item, "time");
    if let (Some(before), Some(span)) = (before, span)
        && time <= before
    {
        reader.fault(
            Diagnostic::new(item.span_of("time"), "this keyframe is not later than the one before")
                .relate(span.clone(), "the one before")
                .advise("sort keyframes by time"),
        );
        return None;
    }
    Some(time)
}
