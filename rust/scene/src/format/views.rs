//! The tables of a scene file that decide how it is seen and what is written: camera, sun, sky, output.

use glam::DVec3;

use crate::format::bodies::read_time;
use crate::format::description::*;
use crate::format::diagnostic::{Diagnostic, Span};
use crate::format::names::Names;
use crate::format::placement::Up;
use crate::format::reader::{Reader, Table};

pub(crate) fn read_camera(reader: &mut Reader, table: Table, objects: &Names) -> CameraEntry {
    let mut view = View {
        time: 0.0,
        position: reader.optional_vector(table, "position").map(DVec3::from),
        target: reader.optional_vector(table, "target").map(DVec3::from),
        fov: reader.number(table, "fov").to_radians(),
    };
    let follow = reader.text(table, "follow").and_then(|name| objects.find(reader, &name));
    let mut views: Vec<View> = Vec::new();
    let mut spans: Vec<Span> = Vec::new();
    let check = |reader: &mut Reader, table: Table, view: &View| {
        if view.position.is_some() && view.position == view.target {
            reader.fault(
                Diagnostic::new(table.span_of("target"), "the camera looks at the place where it is")
                    .advise("move `position` or `target`"),
            );
        }
    };
    check(reader, table, &view);
    for item in reader.list(table, "keyframes") {
        let Some(time) = read_time(reader, item, views.last().map(|view| view.time), spans.last()) else { continue };
        view = View {
            time,
            position: reader.optional_vector(item, "position").map(DVec3::from).or(view.position),
            target: reader.optional_vector(item, "target").map(DVec3::from).or(view.target),
            fov: reader.optional_number(item, "fov").map_or(view.fov, f64::to_radians),
        };
        check(reader, item, &view);
        views.push(view);
        spans.push(item.span_of("time"));
    }
    if views.is_empty() {
        views.push(view);
    }
    CameraEntry { views, follow }
}

pub(crate) fn read_sun(reader: &mut Reader, table: Table, up: Up) -> SunEntry {
    let elevation = reader.number(table, "elevation").to_radians();
    let azimuth = reader.number(table, "azimuth").to_radians();
    let strength = reader.number(table, "strength") as f32;
    let flat = [elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin()];
    let direction = up.from_z_up(flat.map(|value| value as f32)).map(f64::from);
    SunEntry {
        direction: DVec3::from(direction).normalize_or(up.direction()),
        radiance: reader.colour(table, "colour").map(|value| value * strength),
        angle: reader.number(table, "angle").to_radians(),
    }
}

pub(crate) fn read_output(reader: &mut Reader, table: Table) -> OutputEntry {
    let mut when = |key: &str| match reader.choice(table, key) {
        Some("last") => When::Last,
        Some("every") => When::Every,
        _ => When::Never,
    };
    let (picture_frames, mesh, tiles) = (when("picture_frames"), when("mesh"), when("tiles"));
    let (documents, povray, blender) = (when("documents"), when("povray"), when("blender"));
    let mut settings = relievo_render::Settings::default();
    reader.parameters(table, |parameter, value| {
        // The reader has checked the value.
        settings.set(parameter.name, value).is_ok()
    });
    OutputEntry {
        frames: reader.whole(table, "frames") as u32,
        images: reader.choices(table, "images"),
        pictures: reader.choices(table, "pictures"),
        picture_frames,
        mesh,
        mesh_formats: reader.choices(table, "mesh_formats"),
        rate: reader.whole(table, "rate") as u32,
        mesh_rate: reader.whole(table, "mesh_rate") as u32,
        settings,
        tiles,
        documents,
        povray,
        blender,
        exposure: reader.number(table, "exposure"),
    }
}

pub(crate) fn read_sky(reader: &mut Reader, table: Table) -> SkyEntry {
    let strength = reader.number(table, "strength") as f32;
    let mut radiance = |key: &str| reader.colour(table, key).map(|value| value * strength);
    SkyEntry { zenith: radiance("zenith"), horizon: radiance("horizon"), ground: radiance("ground") }
}
