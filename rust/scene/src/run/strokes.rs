//! Strokes of a scene, made at their time.

use relievo_core::{Context, Error, Result};
use relievo_detail::{Action, LayeredObject, StrokeReport};

use crate::format::description::StrokeEntry;
use crate::format::reader::Name;
use crate::run::refusals::Refusals;
use crate::state::world::{Item, World};

/// Makes the strokes of `frame` on the objects as they now are: those whose time is after the frame before, and at the
/// first frame those of time 0 too. Adds what was done and refused.
pub(crate) fn make(
    context: &Context,
    world: &mut World,
    frame: u32,
    done: &mut StrokeReport,
    refusals: &mut Refusals,
) -> Result<()> {
    let (before, now) = (world.scene.time(frame.saturating_sub(1)), world.scene.time(frame));
    make_due(context, world, |entry| entry.time <= now && (frame == 0 || entry.time > before), done, refusals)
}

/// Makes the strokes that are `due`, in the order of the file, and adds what was done and refused.
pub(crate) fn make_due(
    context: &Context,
    world: &mut World,
    mut due: impl FnMut(&StrokeEntry) -> bool,
    done: &mut StrokeReport,
    refusals: &mut Refusals,
) -> Result<()> {
    for index in 0..world.scene.strokes.len() {
        let entry = &world.scene.strokes[index];
        if !due(entry) {
            continue;
        }
        let (objects, mut stroke) = (entry.objects.clone(), entry.stroke.clone());
        stroke.stamp = entry.stamp.and_then(|stamp| world.stamp(stamp, &stroke.action).cloned());
        let layer = entry.layer.clone();
        let place = |error: Error| error.at(format!("stroke {}", index + 1));
        let active = match &layer {
            Some(name) => {
                let paints = matches!(stroke.action, Action::Paint { .. });
                choose_layer(context, world, &objects, name, paints).map_err(place)?
            }
            None => Vec::new(),
        };
        let mut surfaces = world.canvases(&objects);
        let reports = context.stats().time("stroke", || stroke.apply_all(context, &mut surfaces));
        activate(context, world, &active)?;
        let reports = reports.map_err(place)?;
        add(done, refusals, &objects, reports);
    }
    Ok(())
}

/// Adds what was done to `objects`, and refused. A dab that was left out counts once.
pub(crate) fn add(done: &mut StrokeReport, refusals: &mut Refusals, objects: &[usize], reports: Vec<StrokeReport>) {
    done.missed += reports.first().map_or(0, |report| report.missed);
    for (object, report) in objects.iter().zip(reports) {
        refusals.add(*object, &report.report.refused);
        done.dabs += report.dabs;
        done.report.merge(report.report);
    }
}

/// Makes layers the active ones of their objects.
pub(crate) fn activate(context: &Context, world: &mut World, layers: &[(usize, u32)]) -> Result<()> {
    for (object, layer) in layers {
        if let Some(surface) = world.surface_mut(*object) {
            surface.set_active_layer(context, *layer)?;
        } else if let Some(item) = world.triangles_mut(*object) {
            item.object.set_active_layer(context, *layer)?;
        }
    }
    Ok(())
}

/// Makes the layer called `name` the active one of those of `objects` that have it; it is one of colour if something
/// `paints`. Returns what was active on them.
pub(crate) fn choose_layer(
    context: &Context,
    world: &mut World,
    objects: &[usize],
    name: &Name,
    paints: bool,
) -> Result<Vec<(usize, u32)>> {
    let place = |error: Error| error.at(format!("layer `{}`", name.text));
    let (mut active, mut names) = (Vec::new(), Vec::new());
    for object in objects {
        let layers = match world.items().get(*object) {
            Some(Item::Surface(surface)) => surface.layers(),
            Some(Item::Triangles(item)) => item.object.layers(),
            _ => continue,
        };
        names.extend(layers.iter().map(|layer| layer.name.clone()));
        let Some(found) = layers.iter().find(|layer| layer.name == name.text) else { continue };
        if found.kind.is_color() != paints {
            let what = format!("it holds {} and cannot take the edit", found.kind.name());
            return Err(place(Error::invalid(what).advise("paint on colour, sculpt displacement")));
        }
        let before = layers.iter().find(|layer| layer.active && layer.kind == found.kind);
        active.extend(before.map(|before| (*object, before.id)));
        if let Some(surface) = world.surface_mut(*object) {
            surface.set_active_layer(context, found.id)?;
        } else if let Some(item) = world.triangles_mut(*object) {
            item.object.set_active_layer(context, found.id)?;
        }
    }
    if active.is_empty() {
        let error = Error::invalid("the object has no such layer");
        return Err(place(error.advise(format!("it has {}", names.join(", ")))));
    }
    Ok(active)
}
