//! Progressive meshes on the graphics device, by its own clock: splits and collapses a second, and frames of a camera.

use std::sync::Arc;

use relievo_core::{Context, ErrorKind, Result};
use relievo_gpu::{AdapterKind, Device, DeviceOptions, Frame};
use relievo_lod::Progressive;
use relievo_lod::progressive::{Cut, DeviceHierarchy, DeviceLevel, Extents, View};

use crate::measure::{Sample, seconds};
use crate::progressive::of_everything;
use crate::report::{Goal, Report};

/// Runs of each figure.
const RUNS: usize = 5;
/// Millions of splits a second that a graphics card makes.
const CARD: f64 = 30.0;

/// Measures a mesh for some views.
pub fn case(
    report: &mut Report,
    context: &Context,
    name: &str,
    built: &Arc<Progressive>,
    views: &[View],
) -> Result<()> {
    let name = format!("{name}, on a device");
    let device = match Device::open(&DeviceOptions { timing: true, ..DeviceOptions::default() }) {
        Ok(device) => device,
        Err(error) => {
            report.skip(&name, &error.to_string());
            return Ok(());
        }
    };
    let made =
        rates(report, &device, &name, built).and_then(|()| frames(report, context, &device, &name, built, views));
    match made {
        // Buffers of what is around splits are larger than some devices have them.
        Err(error) if error.kind == ErrorKind::Memory => {
            report.skip(&name, &error.to_string());
            Ok(())
        }
        made => made,
    }
}

/// Seconds that the device took for what is recorded.
fn time(device: &Device, record: impl FnOnce(&mut Frame) -> Result<()>) -> Result<f64> {
    let mut frame = device.frame()?;
    record(&mut frame)?;
    let times = frame.submit()?.wait()?;
    Ok(times.iter().map(|pass| pass.length.as_secs_f64()).sum())
}

/// Splits and collapses a second, from the base to the finest mesh and back.
fn rates(report: &mut Report, device: &Device, name: &str, built: &Arc<Progressive>) -> Result<()> {
    let hierarchy = Arc::new(DeviceHierarchy::new(device, built)?);
    memory(report, &format!("{name}: in its memory"), &hierarchy, built);
    let mut level = DeviceLevel::new(&hierarchy)?;
    let splits = built.splits().count() as f64 / 1e6;
    let mut rates = [const { Vec::new() }; 2];
    for run in 0..=RUNS {
        for (rates, cut) in rates.iter_mut().zip([Cut::FINEST, Cut::BASE]) {
            let seconds = time(device, |frame| level.adapt(frame, cut))?;
            // The first finds its memory cold.
            if run > 0 {
                rates.push(splits / seconds);
            }
        }
    }
    let goal = if device.summary().kind == AdapterKind::Software { Goal::None } else { Goal::AtLeast(CARD) };
    let [made, taken] = rates.map(Sample::new);
    report.add(&format!("{name}: splits"), &made, None, "M/s", goal);
    report.add(&format!("{name}: collapses"), &taken, None, "M/s", Goal::None);
    Ok(())
}

/// Frames a second in which a mesh becomes as fine as a camera needs it, in buffers that are drawn.
fn frames(
    report: &mut Report,
    context: &Context,
    device: &Device,
    name: &str,
    built: &Arc<Progressive>,
    views: &[View],
) -> Result<()> {
    let extents = Extents::new(built);
    let hierarchy = Arc::new(DeviceHierarchy::with_surroundings(context, device, built, &extents)?);
    memory(report, &format!("{name}: in its memory, for views and edits"), &hierarchy, built);
    let mut level = DeviceLevel::new(&hierarchy)?;
    let mut frames = Vec::new();
    for view in views {
        frames.push(1.0 / time(device, |frame| level.adapt_to(frame, view))?);
    }
    let [_, triangles, _] = level.counts()?;
    let what = format!("{name}: frames of a camera around it, {triangles} triangles");
    report.add(&what, &Sample::new(frames), None, "1/s", Goal::None);
    edits(report, device, name, built, &mut level)
}

/// Collapses that are made anew by an edit of everything, and places that are put back, in millions a second, until the
/// device has drawn buffers ready.
fn edits(report: &mut Report, device: &Device, name: &str, built: &Progressive, level: &mut DeviceLevel) -> Result<()> {
    time(device, |frame| level.adapt(frame, Cut::FINEST))?;
    let splits = built.splits().count() as f64 / 1e6;
    let mut rates = [const { Vec::new() }; 2];
    for run in 0..=RUNS {
        let mut done = Ok(());
        let edited = seconds(|| {
            done = level.edit(&of_everything()).and_then(|_| device.frame()?.submit()?.wait().map(drop));
        });
        std::mem::replace(&mut done, Ok(()))?;
        let undone = seconds(|| {
            done = level.undo().and_then(|_| device.frame()?.submit()?.wait().map(drop));
        });
        done?;
        // The first makes room.
        if run > 0 {
            rates[0].push(splits / edited);
            rates[1].push(splits / undone);
        }
    }
    let [made, taken] = rates.map(Sample::new);
    report.add(&format!("{name}: collapses made anew by an edit"), &made, None, "M/s", Goal::None);
    report.add(&format!("{name}: the same taken back"), &taken, None, "M/s", Goal::None);
    Ok(())
}

fn memory(report: &mut Report, name: &str, hierarchy: &DeviceHierarchy, built: &Progressive) {
    let bytes = Sample::new(vec![hierarchy.bytes() as f64 / built.triangle_count() as f64]);
    report.add(name, &bytes, None, "bytes a triangle", Goal::None);
}
