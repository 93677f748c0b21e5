//! `[[decals]]` of a scene file, read.

use glam::DVec3;

use crate::format::description::{DecalEntry, DecalPin, Geometry, ObjectEntry};
use crate::format::diagnostic::Diagnostic;
use crate::format::names::Names;
use crate::format::placement::Up;
use crate::format::reader::{Reader, Table};

pub(crate) fn read_decal(
    reader: &mut Reader,
    table: Table,
    objects: &Names,
    entries: &[Option<ObjectEntry>],
    up: Up,
) -> Option<DecalEntry> {
    let object = read_object(reader, table, objects, entries)?;
    let strip = reader.flag(table, "strip");
    let mut pins = Vec::new();
    for item in reader.list(table, "pins") {
        let image = reader.pair(item, "image");
        if !item.has("position") {
            reader.fault(Diagnostic::new(item.span(), "the pin has no place").advise("give it `position`"));
        }
        match (strip, item.has("image")) {
            (false, false) => reader.fault(
                Diagnostic::new(item.span(), "the pin has no point of the image")
                    .advise("give it `image`, or let the decal be a `strip`"),
            ),
            (true, true) => reader.fault(
                Diagnostic::new(item.span_of("image"), "pins of a strip have no point of the image")
                    .advise("remove `image`: the middle line of the image lies along the pins"),
            ),
            _ => {}
        }
        let position = DVec3::from(reader.vector(item, "position"));
        pins.push(DecalPin { image, position, depth: reader.number(item, "depth") });
    }
    let width = table.has("width").then(|| reader.number(table, "width"));
    let least = if strip { 2 } else { 1 };
    if pins.len() < least {
        reader.fault(
            Diagnostic::new(table.span(), format!("the decal has {} pins", pins.len()))
                .advise(format!("give it `pins`, at least {least}")),
        );
    } else if pins.len() == 1 && width.is_none() {
        reader.fault(
            Diagnostic::new(table.span(), "one pin gives no size").advise("give the decal its `width`, or more pins"),
        );
    }
    let contour = table.has("contour").then(|| [reader.number(table, "contour"), reader.number(table, "tolerance")]);
    let outline = reader.pairs(table, "outline");
    if contour.is_some() && table.has("outline") {
        reader.fault(
            Diagnostic::new(table.span_of("outline"), "a decal cannot have two outlines")
                .relate(table.span_of("contour"), "the other one")
                .advise("keep `outline` or `contour`"),
        );
    }
    let Some(image) = reader.text(table, "image") else {
        if !table.has("image") {
            reader.fault(Diagnostic::new(table.span(), "the decal has no image").advise("give it `image`"));
        }
        return None;
    };
    Some(DecalEntry {
        object,
        time: reader.number(table, "time"),
        image,
        outline,
        contour,
        pins,
        strip,
        width,
        up: reader.optional_vector(table, "up").map_or(up.direction(), DVec3::from),
        overlap: reader.flag(table, "overlap"),
        layer: reader.text(table, "layer"),
        opacity: reader.number(table, "opacity") as f32,
        height: table.has("height").then(|| reader.number(table, "height") as f32),
        cells: reader.whole(table, "cells") as u32,
    })
}

/// The surface that the decal names, or the only one.
fn read_object(reader: &mut Reader, table: Table, objects: &Names, entries: &[Option<ObjectEntry>]) -> Option<usize> {
    let shows_surface = |object: &usize| {
        let entry = entries.get(*object).and_then(Option::as_ref);
        entry.is_none_or(|entry| matches!(entry.geometry, Geometry::Surface(_)))
    };
    if let Some(name) = reader.text(table, "object") {
        let object = objects.find(reader, &name)?;
        if !shows_surface(&object) {
            reader.fault(
                Diagnostic::new(name.span.clone(), format!("`{}` shows no surface", name.text))
                    .advise("make a surface over its mesh and give the object that `surface`"),
            );
        }
        return Some(object);
    }
    let all: Vec<usize> = (0..entries.len()).filter(shows_surface).collect();
    if let [object] = all[..] {
        return Some(object);
    }
    if !table.has("object") {
        let what = format!("the decal names no object, and {} show a surface", all.len());
        reader.fault(Diagnostic::new(table.span(), what).advise("give it `object`"));
    }
    None
}
