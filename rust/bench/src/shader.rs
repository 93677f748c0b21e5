//! `shader`: what the exploration of shaders costs (Mindek et al. 2013, Section 8): frames of a volume with vectors of three
//! features and five examples beside the plain shader, the classification of a pixel, and augmentation.
//!
//! The volume has the size of the paper's, 424 × 279 × 190 voxels. Pictures have 800 × 600 pixels on a graphics card and
//! 200 × 150 where the processor itself is the device.

use std::path::Path;

use relievo_core::{Error, Result};
use relievo_gpu::module::{MODULES, compose};
use relievo_gpu::{AdapterKind, Device, DeviceOptions};
use relievo_shaderlab::{
    Class, Classes, Example, Faults, Inputs, Language, Program, Runner, Shader, Source, Stage, Texture, Volume,
};

use crate::measure::{Sample, seconds};
use crate::report::{Goal, Report};

/// Voxels of the volume.
const VOXELS: [u32; 3] = [424, 279, 190];
/// Classified pixels as shares of the picture, the first two positive.
const PIXELS: [[f32; 2]; 5] = [[0.5, 0.5], [0.45, 0.4], [0.3, 0.5], [0.65, 0.6], [0.4, 0.6]];

/// Augmentations of one shader of which the median counts: other programs delay single ones.
const SAMPLES: usize = 5;

/// Measures frames, classification and augmentation; the latter also of the shaders in a folder.
pub fn run(report: &mut Report, others: Option<&Path>) -> Result<()> {
    augmentation(report)?;
    if let Some(folder) = others {
        augmentation_of(report, folder)?;
    }
    let device = match Device::open(&DeviceOptions::default()) {
        Ok(device) => device,
        Err(error) => {
            report.skip("graphics devices", &error.to_string());
            return Ok(());
        }
    };
    let is_software = device.summary().kind == AdapterKind::Software;
    let (size, runs) = if is_software { ([200, 150], 3) } else { ([800, 600], 50) };
    let text = include_str!("../../../examples/shaders/volume.wgsl");
    let text = text.replace("vector value; magnitude; opacity", "vector value; magnitude; distance; opacity");
    let shader = Shader::new(Source::new("volume.wgsl", text, Language::Wgsl, Stage::Fragment))?;
    let augmented = shader.augment()?;
    let mut inputs = Inputs::default();
    for (name, number) in [("low", 0.1), ("high", 0.5), ("opacity", 0.05), ("steps", 300.0), ("turn", 0.4)] {
        inputs.numbers.insert(name.into(), vec![number]);
    }
    inputs.textures.insert("scan".into(), Texture::Volume(volume()));
    let plain = Runner::new(&device, &Program::plain(&shader)?, None, size, &inputs)?;
    let marked = Runner::new(&device, &Program::augmented(&shader, &augmented)?, None, size, &inputs)?;
    let none = Classes::of(&augmented);
    let mut classes = none.clone();
    let mut times = Vec::new();
    for (index, share) in PIXELS.iter().enumerate() {
        let pixel = [0, 1].map(|axis| (share[axis] * size[axis] as f32) as u32);
        let mut log = None;
        times.push(1e3 * seconds(|| log = Some(marked.classify(&none, pixel))));
        let vector = log.ok_or_else(|| Error::internal("nothing was classified"))??.vector;
        let class = if index < 2 { Class::Positive } else { Class::Negative };
        classes.examples.push(Example { pixel, class, vector });
    }
    plain.run(None)?;
    marked.run(Some(&classes))?;
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..runs {
        let mut done = Ok(());
        ours.push(1e3 * seconds(|| done = marked.run(Some(&classes))));
        done?;
        done = Ok(());
        theirs.push(1e3 * seconds(|| done = plain.run(None)));
        done?;
    }
    let case = format!("frame of a volume, {} × {}, 5 examples", size[0], size[1]);
    let goal = if is_software { Goal::None } else { Goal::RatioAtMost(2.0) };
    report.add(&case, &Sample::new(ours), Some(("plain shader", &Sample::new(theirs))), "ms", goal);
    report.add("classification of a pixel", &Sample::new(times), None, "ms", Goal::AtMost(5.0));
    vertices(report, &device)
}

/// Measures the classification of a pixel by the vertices of its triangle.
fn vertices(report: &mut Report, device: &Device) -> Result<()> {
    const VERTICES: u32 = 6 * 96 * 96;
    let source = |name, text: &str, stage| Source::new(name, text, Language::Glsl, stage);
    let vertex = include_str!("../../../examples/shaders/terrain.vert");
    let vertex = Shader::new(source("terrain.vert", vertex, Stage::Vertex))?;
    let fragment = include_str!("../../../examples/shaders/terrain.frag");
    let fragment = Shader::new(source("terrain.frag", fragment, Stage::Fragment))?;
    let augmented = vertex.augment()?;
    let program = Program::plain(&fragment)?.with_vertex(&vertex, Some(&augmented))?;
    let mut inputs = Inputs { vertices: Some(VERTICES), ..Inputs::default() };
    for (name, number) in [("turn", 0.6), ("tilt", 0.75), ("aspect", 1.7778)] {
        inputs.numbers.insert(name.into(), vec![number]);
    }
    let size = [640, 360];
    let classes = Classes::of(&augmented);
    let [mut first, mut later, mut listing, mut drawing] = [const { Vec::new() }; 4];
    for share in PIXELS {
        let pixel = [0, 1].map(|axis| (share[axis] * size[axis] as f32) as u32);
        let runner = Runner::new(device, &program, None, size, &inputs)?;
        // The first picture of a runner lists the vertices, the first pixel reads the list, and the runner retains it.
        for (pictures, pixels) in [(&mut listing, &mut first), (&mut drawing, &mut later)] {
            let mut done = Ok(());
            pictures.push(1e3 * seconds(|| done = runner.run(Some(&classes))));
            done?;
            done = Ok(());
            pixels.push(1e3 * seconds(|| done = runner.classify(&classes, pixel).map(drop)));
            done?;
        }
    }
    let case = format!("classification of a pixel of {VERTICES} vertices");
    report.add(&case, &Sample::new(later), None, "ms", Goal::AtMost(5.0));
    report.add("the first pixel after the shader changed", &Sample::new(first), None, "ms", Goal::AtMost(5.0));
    let peer = Sample::new(drawing);
    let case = "the picture before it, which lists the vertices";
    report.add(case, &Sample::new(listing), Some(("a later picture", &peer)), "ms", Goal::None);
    Ok(())
}

/// Measures the augmentation of every shader of this repository that has an entry point with a float variable.
fn augmentation(report: &mut Report) -> Result<()> {
    let mut times = Vec::new();
    for module in MODULES {
        let source = |text| Source::new(module.file, text, Language::Wgsl, Stage::Compute);
        let shader = Shader::new(source(compose(module.name)?.text))?;
        let entries: Vec<_> = shader.entries().into_iter().map(|entry| entry.name).collect();
        let is_inside = |function: &Option<String>| function.as_ref().is_some_and(|name| entries.contains(name));
        let Some(index) = shader.variables().iter().rposition(|it| is_inside(&it.function)) else { continue };
        let marked = shader.with_vector(&[index], "1.0")?;
        let once = || Shader::new(source(marked.clone())).and_then(|it| it.augment()).map(drop);
        times.push(median(once)?.1);
    }
    let slowest = times.iter().copied().fold(0.0, f64::max);
    report.add(
        &format!("augmentation of {} shaders, median", times.len()),
        &Sample::new(times),
        None,
        "ms",
        Goal::AtMost(10.0),
    );
    report.add("augmentation, the slowest, median of 5", &Sample::new(vec![slowest]), None, "ms", Goal::AtMost(10.0));
    Ok(())
}

/// Measures the augmentation of the shaders in a folder and the folders in it, each with a vector of its last variable that has
/// a value, and prints why some are refused.
fn augmentation_of(report: &mut Report, folder: &Path) -> Result<()> {
    let (mut times, mut without, mut refused) = (Vec::new(), 0, 0);
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let failed = |error: std::io::Error| Error::io(&folder, &error);
        for entry in std::fs::read_dir(&folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if Source::kind_of(&path).is_none() {
                continue;
            }
            let source = Source::read(&path)?;
            match median(|| augmented(&source)) {
                Ok((true, time)) => times.push(time),
                Ok((false, _)) => without += 1,
                Err(faults) => {
                    refused += 1;
                    eprintln!("refused: {}", Error::from(faults));
                }
            }
        }
    }
    let slowest = times.iter().copied().fold(0.0, f64::max);
    let case = format!("augmentation of {} others; {without} have no variable; {refused} refused", times.len());
    report.add(&case, &Sample::new(times), None, "ms", Goal::AtMost(10.0));
    report.add("the slowest of them, median of 5", &Sample::new(vec![slowest]), None, "ms", Goal::AtMost(10.0));
    Ok(())
}

/// Returns what `work` returns, and the median of the milliseconds that it takes.
fn median<T>(work: impl Fn() -> std::result::Result<T, Faults>) -> std::result::Result<(T, f64), Faults> {
    let mut done = Vec::new();
    let times = (0..SAMPLES).map(|_| 1e3 * seconds(|| done.push(work()))).collect();
    let mut done = done.into_iter().collect::<std::result::Result<Vec<_>, _>>()?;
    Ok((done.swap_remove(0), Sample::new(times).median()))
}

/// Augments a shader with a vector of its last variable that has a value, and writes it as WGSL. Returns whether there is one.
fn augmented(source: &Source) -> std::result::Result<bool, Faults> {
    let shader = Shader::new(source.clone())?;
    let Some(index) = shader.variables().iter().rposition(|it| it.is_initialized) else { return Ok(false) };
    let text = shader.with_vector(&[index], "1.0")?;
    let marked = Shader::new(Source { text: text.into(), ..source.clone() })?;
    marked.augment()?.wgsl(&marked)?;
    Ok(true)
}

/// Makes a volume of a ball with waves in it.
fn volume() -> Volume {
    let [width, height, depth] = VOXELS;
    let mut values = Vec::with_capacity(width as usize * height as usize * depth as usize);
    for z in 0..depth {
        for y in 0..height {
            for x in 0..width {
                let at = [x as f32 / width as f32, y as f32 / height as f32, z as f32 / depth as f32];
                let radius = at.iter().map(|it| (it - 0.5) * (it - 0.5)).sum::<f32>().sqrt();
                let wave = 0.5 + 0.5 * (30.0 * at[0]).sin() * (24.0 * at[1]).cos() * (18.0 * at[2]).sin();
                values.push((1.0 - 2.0 * radius).max(0.0) * (0.4 + 0.6 * wave));
            }
        }
    }
    Volume { size: VOXELS, spacing: [1.0; 3], values }
}
