//! Levels and edits of progressive meshes on graphics devices.

use std::path::Path;
use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_lod::Progressive;
use relievo_lod::progressive::{ActiveMesh, Cut, DeviceHierarchy, DeviceLevel, Extents};

use super::Level;
use super::edits::Change;

/// A level that a device makes.
pub fn level(device: &Device, mesh: &Progressive, cut: Cut) -> Result<DeviceLevel> {
    let mut level = DeviceLevel::new(&Arc::new(DeviceHierarchy::new(device, mesh)?))?;
    adapt(device, &mut level, cut)?;
    Ok(level)
}

fn adapt(device: &Device, level: &mut DeviceLevel, cut: Cut) -> Result<()> {
    let mut frame = device.frame()?;
    level.adapt(&mut frame, cut)?;
    frame.submit().map(drop)
}

/// The mesh with the edits of a list, which a device makes at their levels, but for strokes. `then` gets the number of each,
/// and how many vertices it reached of how many.
pub fn edited(
    context: &Context,
    device: &Device,
    mesh: &Arc<Progressive>,
    (script, list): (&Path, Vec<(Level, Change)>),
    mut then: impl FnMut(usize, [usize; 2]) -> Result<()>,
) -> Result<ActiveMesh> {
    let whole = DeviceHierarchy::with_surroundings(context, device, mesh, &Extents::new(mesh))?;
    let mut level = DeviceLevel::new(&Arc::new(whole))?;
    for (index, (own, change)) in list.into_iter().enumerate() {
        let number = index + 1;
        let mut make = || {
            let cut = own.cut(mesh)?;
            adapt(device, &mut level, cut)?;
            let strokes = match &change {
                Change::Edit(edit) => return level.edit(edit),
                Change::Strokes(strokes) => strokes,
            };
            eprintln!("note: edit {number}: strokes are made by the processor");
            let mut active = level.to_active(context, mesh)?;
            active.adapt(context, cut);
            let mut reached = 0;
            for stroke in strokes {
                reached += active.sculpt(context, stroke)?.vertices;
            }
            level.take(context, &mut active)?;
            Ok(reached)
        };
        let reached = make().map_err(|error: Error| error.at(format!("{}: edit {number}", script.display())))?;
        then(number, [reached, level.counts()?[0]])?;
    }
    level.to_active(context, mesh)
}
