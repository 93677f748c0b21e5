//! `[[strokes]]` of a scene file, read.

use glam::DVec3;
use relievo_detail::{
    Action, Curve, Falloff, PaintMode, PressureCurves, SculptMode, Stroke, StrokePoint, StrokeSettings,
};

use crate::format::description::{Geometry, ObjectEntry, StrokeEntry};
use crate::format::diagnostic::Diagnostic;
use crate::format::names::Names;
use crate::format::reader::{Name, Reader, Table};

/// The one of `list` that `word` names.
pub(crate) fn named<T: Copy + Default>(list: &[(T, &str)], word: Option<&str>) -> T {
    list.iter().find(|(_, name)| Some(*name) == word).map(|(value, _)| *value).unwrap_or_default()
}

pub(crate) fn read_stroke(
    reader: &mut Reader,
    table: Table,
    objects: &Names,
    entries: &[Option<ObjectEntry>],
    stamps: &Names,
) -> Option<StrokeEntry> {
    let time = reader.number(table, "time");
    let points = reader.list(table, "points").into_iter().map(|item| StrokePoint {
        position: DVec3::from(reader.vector(item, "position")),
        pressure: reader.number(item, "pressure"),
        time: reader.optional_number(item, "time"),
    });
    let points: Vec<StrokePoint> = points.collect();
    let (brush, stamp) = read_brush(reader, table, stamps)?;
    let objects = read_objects(reader, table, objects, entries, None)?;
    let stroke = Stroke { points, ..brush };
    // What a value of its own is wrong with has been said.
    if let Err(error) = stroke.check()
        && reader.faults.is_empty()
    {
        let place = if table.has("points") { table.span_of("points") } else { table.span() };
        reader.fault(Diagnostic::from_error(place, &error));
    }
    let layer = reader.text(table, "layer");
    if let (Some(name), Action::Sculpt { mode, .. }) = (&layer, stroke.action)
        && mode.needs_vectors()
    {
        reader.fault(Diagnostic::new(name.span.clone(), "vector displacement has no layers").advise("remove `layer`"));
    }
    Some(StrokeEntry { objects, time, stroke, layer, stamp })
}

/// The surfaces that a brush is made on, ascending: the surfaces that `object` names, else all but `without`.
pub(crate) fn read_objects(
    reader: &mut Reader,
    table: Table,
    objects: &Names,
    entries: &[Option<ObjectEntry>],
    without: Option<usize>,
) -> Option<Vec<usize>> {
    let is_mesh = |object: usize| {
        entries.get(object).and_then(Option::as_ref).is_some_and(|entry| matches!(entry.geometry, Geometry::Mesh(_)))
    };
    let Some(names) = reader.texts(table, "object") else {
        let all: Vec<usize> =
            (0..entries.len()).filter(|object| !is_mesh(*object) && Some(*object) != without).collect();
        if all.is_empty() {
            reader.fault(
                Diagnostic::new(table.span(), "no object shows a surface that it could be made on")
                    .advise("make a surface over a mesh and give an object that `surface`"),
            );
        }
        return Some(all);
    };
    let mut found = Vec::new();
    for name in &names {
        let object = objects.find(reader, name)?;
        if is_mesh(object) {
            reader.fault(
                Diagnostic::new(name.span.clone(), "a mesh cannot be painted or sculpted")
                    .advise("make a surface over the mesh and give the object that `surface`"),
            );
        }
        found.push(object);
    }
    if found.is_empty() {
        reader.fault(
            Diagnostic::new(table.span_of("object"), "it is on no object")
                .advise("name one, or remove `object` for all"),
        );
    }
    found.sort_unstable();
    found.dedup();
    Some(found)
}

/// What a brush does and how: a stroke without points, and the index of its image.
pub(crate) fn read_brush(reader: &mut Reader, table: Table, stamps: &Names) -> Option<(Stroke, Option<usize>)> {
    let falloff = named(&Falloff::NAMES, reader.choice(table, "falloff"));
    let (colour, height) = (reader.colour(table, "colour"), reader.number(table, "height") as f32);
    let mut settings = StrokeSettings::default();
    reader.parameters(table, |parameter, value| settings.set(parameter.name, value).is_ok());
    let mut curve = |key: &str| {
        let points = reader.pairs(table, key);
        Curve::new(points).unwrap_or_else(|error| {
            reader.fault(Diagnostic::from_error(table.span_of(key), &error));
            Curve::default()
        })
    };
    let curves =
        PressureCurves { size: curve("size_curve"), strength: curve("strength_curve"), angle: curve("angle_curve") };
    let stamp: Option<Name> = reader.text(table, "stamp");
    let stamp = match stamp {
        Some(name) => Some(stamps.find(reader, &name)?),
        None => None,
    };
    let action = match (table.has("paint"), table.has("sculpt")) {
        (true, false) => {
            let [r, g, b] = colour;
            Action::Paint { mode: named(&PaintMode::NAMES, reader.choice(table, "paint")), color: [r, g, b, 1.0] }
        }
        (false, true) => Action::Sculpt { mode: named(&SculptMode::NAMES, reader.choice(table, "sculpt")), height },
        (true, true) => {
            reader.fault(
                Diagnostic::new(table.span_of("sculpt"), "a stroke cannot paint and sculpt")
                    .relate(table.span_of("paint"), "it paints here")
                    .advise("make two strokes of it"),
            );
            return None;
        }
        (false, false) => {
            reader
                .fault(Diagnostic::new(table.span(), "the stroke does nothing").advise("give it `paint` or `sculpt`"));
            return None;
        }
    };
    let (unfit, other) = match action {
        Action::Paint { .. } => ("height", "colours"),
        Action::Sculpt { .. } => ("colour", "heights"),
    };
    if table.has(unfit) {
        reader.fault(
            Diagnostic::new(table.span_of(unfit), format!("`{unfit}` means nothing for a stroke that changes {other}"))
                .advise("remove it"),
        );
    }
    Some((Stroke { curves, ..Stroke::new(Vec::new(), settings, falloff, action) }, stamp))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::schema::{CHANNELS, FALLOFFS, PAINT_MODES, SCULPT_MODES};
    use relievo_detail::StampChannel;

    #[test]
    fn the_words_of_scene_files_are_those_of_the_brushes() {
        assert_eq!(Falloff::NAMES.map(|(_, name)| name), FALLOFFS);
        assert_eq!(PaintMode::NAMES.map(|(_, name)| name), PAINT_MODES);
        assert_eq!(SculptMode::NAMES.map(|(_, name)| name), SCULPT_MODES);
        assert_eq!(StampChannel::NAMES.map(|(_, name)| name), CHANNELS);
    }
}
