//! The pictures of a frame, written.

use std::path::PathBuf;

use relievo_core::{Context, Result};
use relievo_render::write_png;

use crate::out::output::Folder;
use crate::out::picture::Studio;
use crate::state::world::World;

/// Renders and writes the pictures that the scene asks for. Returns the files.
pub fn write_pictures(
    context: &Context,
    world: &World,
    studio: &mut Studio,
    folder: &Folder,
    frame: u32,
) -> Result<Vec<PathBuf>> {
    let output = &world.scene.output;
    let mut written = Vec::new();
    for kind in &output.pictures {
        let mut picture = studio.render(context, world, kind, world.scene.time(frame))?;
        let _stage = context.stats().begin("export.pictures");
        for format in &output.images {
            let path = folder.file(&format!("{kind}-{frame:06}.{format}"));
            if *format == "exr" {
                picture.write_exr(&path)?;
            } else {
                picture.color.expose(output.exposure as f32);
                write_png(&path, &picture.color)?;
                picture.color.expose(-output.exposure as f32);
            }
            written.push(path);
        }
    }
    Ok(written)
}
