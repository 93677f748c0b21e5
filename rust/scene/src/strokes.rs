//! `[[strokes]]` of a scene file: read, and made at their time.

use glam::DVec3;
use relievo_core::{Context, Error, Result};
use relievo_detail::{Action, Falloff, PaintMode, SculptMode, Stroke, StrokePoint, StrokeReport, StrokeSettings};

use crate::description::{Geometry, ObjectEntry, StrokeEntry};
use crate::diagnostic::Diagnostic;
use crate::file::Names;
use crate::reader::{Reader, Table};
use crate::world::World;

/// The one of `list` that `word` names.
fn named<T: Copy + Default>(list: &[(T, &str)], word: Option<&str>) -> T {
    list.iter().find(|(_, name)| Some(*name) == word).map(|(value, _)| *value).unwrap_or_default()
}

pub(crate) fn read_stroke(
    reader: &mut Reader,
    table: Table,
    objects: &Names,
    entries: &[Option<ObjectEntry>],
) -> Option<StrokeEntry> {
    let falloff = named(&Falloff::NAMES, reader.choice(table, "falloff"));
    let (colour, height) = (reader.colour(table, "colour"), reader.number(table, "height") as f32);
    let time = reader.number(table, "time");
    let mut settings = StrokeSettings::default();
    reader.parameters(table, |parameter, value| settings.set(parameter.name, value).is_ok());
    let points = reader
        .list(table, "points")
        .into_iter()
        .map(|item| StrokePoint::new(DVec3::from(reader.vector(item, "position")), reader.number(item, "pressure")));
    let points: Vec<StrokePoint> = points.collect();
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
    let Some(name) = reader.text(table, "object") else {
        if !table.has("object") {
            reader.fault(Diagnostic::new(table.span(), "the stroke is on no object").advise("give it `object`"));
        }
        return None;
    };
    let object = objects.find(reader, &name)?;
    let entry = entries.get(object).and_then(Option::as_ref);
    if entry.is_some_and(|entry| matches!(entry.geometry, Geometry::Mesh(_))) {
        reader.fault(
            Diagnostic::new(name.span.clone(), "a mesh cannot be painted or sculpted")
                .advise("make a surface over the mesh and give the object that `surface`"),
        );
    }
    let stroke = Stroke::new(points, settings, falloff, action);
    // What a value of its own is wrong with has been said.
    if let Err(error) = stroke.check()
        && reader.faults.is_empty()
    {
        let place = if table.has("points") { table.span_of("points") } else { table.span() };
        reader.fault(Diagnostic::from_error(place, &error));
    }
    Some(StrokeEntry { object, time, stroke })
}

/// Makes the strokes of `frame` on the objects as they now are: those whose time is after the frame before, and at the
/// first frame those of time 0 too.
pub(crate) fn make(context: &Context, world: &mut World, frame: u32) -> Result<StrokeReport> {
    let (before, now) = (world.scene.time(frame.saturating_sub(1)), world.scene.time(frame));
    let due = |entry: &StrokeEntry| entry.time <= now && (frame == 0 || entry.time > before);
    let mut done = StrokeReport::default();
    for index in 0..world.scene.strokes.len() {
        let entry = &world.scene.strokes[index];
        if !due(entry) {
            continue;
        }
        let (object, stroke) = (entry.object, entry.stroke.clone());
        let Some(surface) = world.surface_mut(object) else { continue };
        let place = |error: Error| error.at(format!("stroke {}", index + 1));
        let report = context.stats().time("stroke", || stroke.apply(context, surface)).map_err(place)?;
        done.dabs += report.dabs;
        done.missed += report.missed;
        done.report.merge(report.report);
    }
    Ok(done)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::{FALLOFFS, PAINT_MODES, SCULPT_MODES};

    #[test]
    fn the_words_of_scene_files_are_those_of_the_brushes() {
        assert_eq!(Falloff::NAMES.map(|(_, name)| name), FALLOFFS);
        assert_eq!(PaintMode::NAMES.map(|(_, name)| name), PAINT_MODES);
        assert_eq!(SculptMode::NAMES.map(|(_, name)| name), SCULPT_MODES);
    }
}
