//! Decals painted into the texture of a mesh with texture coordinates (the paper's Section 6).
//!
//! Pixels at the border of a chart, which it covers in part, get the whole colour of the decal, so that filters and the
//! gutter find no mixture with the background. Pixels are numbered row by row from the top, charts run upwards.

use relievo_core::{Attribute, Context, Domain, Error, Mesh, Result, Values};
use relievo_render::Image;
use relievo_render::color::luminance;

use crate::artwork::Artwork;
use crate::decal::Decal;
use crate::print::check_opacity;
use crate::print::texels::{Chart, SAMPLES, draw, weights};

/// Rows of pixels that are searched for charts at once.
const BAND: usize = 64;
/// How far texture coordinates may be outside of the picture.
const MARGIN: f64 = 1e-4;

/// Pixels of a texture, one for each of its pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Whether a chart of the mesh covers a part of the pixel.
    pub covered: Vec<bool>,
    /// Whether the decal changed the pixel.
    pub painted: Vec<bool>,
}

/// Returns the triangles of a mesh, fanned from the first corner of each face and without holes, with its texture coordinates
/// `uv`.
pub fn triangulated(mesh: &Mesh) -> Mesh {
    let offsets = mesh.face_offsets();
    let mut is_hole = vec![false; mesh.face_count()];
    for face in &mesh.holes {
        is_hole[*face as usize] = true;
    }
    let mut order = Vec::new();
    for ((sides, first), _) in mesh.face_sizes.iter().zip(&offsets).zip(is_hole).filter(|(_, is_hole)| !is_hole) {
        for last in 2..*sides {
            order.extend([*first, first + last - 1, first + last]);
        }
    }
    let uv =
        mesh.attributes.iter().find(|attribute| attribute.name == "uv" && attribute.domain != Domain::Face).cloned();
    let corners = order.iter().map(|corner| mesh.corners[*corner as usize]).collect();
    let mut triangles = Mesh::new(mesh.points.clone(), vec![3; order.len() / 3], corners);
    triangles.attributes.extend(uv.map(|uv| match (uv.domain, &uv.indices) {
        (Domain::Corner, Some(indices)) => {
            let indices = order.iter().map(|corner| indices[*corner as usize]).collect();
            Attribute { indices: Some(indices), ..uv }
        }
        (Domain::Corner, None) => Attribute { indices: Some(order), ..uv },
        _ => uv,
    }));
    triangles
}

/// Returns where the faces of a mesh of triangles lie in a texture of `size` columns and rows, by its attribute `uv`.
///
/// # Errors
/// The mesh is unusable, has other faces than triangles or no texture coordinates, or these lie outside of 0 to 1.
pub fn charts(mesh: &Mesh, size: [u32; 2]) -> Result<Vec<Chart>> {
    mesh.check()?;
    if let Some(face) = mesh.face_sizes.iter().position(|sides| *sides != 3) {
        return Err(Error::unsupported(format!("it has {} corners", mesh.face_sizes[face]))
            .at(format!("face {face}"))
            .advise("triangulate the mesh"));
    }
    let missing = || Error::invalid("it has no texture coordinates").at("mesh").advise("unwrap it, as attribute `uv`");
    let uv = mesh.attribute("uv").filter(|uv| uv.width == 2 && uv.domain != Domain::Face).ok_or_else(missing)?;
    let Values::F32(values) = &uv.values else { return Err(missing()) };
    let places = values.as_chunks::<2>().0;
    let mut charts = Vec::with_capacity(mesh.face_count());
    for face in 0..mesh.face_count() {
        let corners: [[f64; 2]; 3] = std::array::from_fn(|corner| {
            let corner = 3 * face + corner;
            let index = match (uv.domain, &uv.indices) {
                (_, Some(indices)) => indices[corner],
                (Domain::Point, None) => mesh.corners[corner],
                _ => corner as u32,
            };
            places[index as usize].map(f64::from)
        });
        if corners.as_flattened().iter().any(|value| !(-MARGIN..=1.0 + MARGIN).contains(value)) {
            return Err(Error::unsupported(format!("its texture coordinates are {corners:?}"))
                .at(format!("face {face}"))
                .advise("keep them within 0 to 1, or give the part of the mesh that lies in the picture"));
        }
        let corners = corners.map(|[u, v]| [u * f64::from(size[0]), v * f64::from(size[1])]);
        charts.push(Chart { target: 0, corners });
    }
    Ok(charts)
}

/// Paints a decal over the texture of the mesh of triangles that it lies on. `depths` are as for [`draw`]. Returns which
/// pixels it changed, and which the charts cover, for a gutter around them.
///
/// # Errors
/// As [`charts`] and [`draw`]; the opacity is not in 0 to 1. Nothing is changed then.
pub fn paint_texture(
    context: &Context,
    mesh: &Mesh,
    decal: &Decal,
    artwork: &Artwork,
    depths: &[f64],
    opacity: f32,
    image: &mut Image,
) -> Result<Pixels> {
    check_opacity(opacity)?;
    let size = [image.width(), image.height()];
    let charts = charts(mesh, size)?;
    let windows = draw(context, mesh, &charts, &|_| size, decal, artwork, depths)?;
    let (width, height) = (size[0] as usize, size[1] as usize);
    let samples = samples(context, &charts, [width, height]);
    let mut painted = vec![false; samples.len()];
    let channels = image.channels() as usize;
    let data = image.data_mut();
    for window in &windows {
        for (index, color) in window.colors.iter().enumerate() {
            let (across, up) = (index % window.size[0] as usize, index / window.size[0] as usize);
            let row = height - 1 - (window.first[1] as usize + up);
            let pixel = row * width + window.first[0] as usize + across;
            let share = samples[pixel].count_ones() as f32 / (SAMPLES * SAMPLES) as f32;
            if color[3] > 0.0 && share > 0.0 {
                let whole = opacity / share.max(color[3]);
                over(&mut data[channels * pixel..channels * (pixel + 1)], color.map(|value| value * whole));
                painted[pixel] = true;
            }
        }
    }
    Ok(Pixels { covered: samples.into_iter().map(|samples| samples != 0).collect(), painted })
}

/// Puts a premultiplied colour over a pixel of 1 to 4 channels, whose alpha is not premultiplied.
fn over(pixel: &mut [f32], [red, green, blue, alpha]: [f32; 4]) {
    let has_alpha = pixel.len().is_multiple_of(2);
    let below = (1.0 - alpha) * pixel.last().copied().filter(|_| has_alpha).unwrap_or(1.0);
    let whole = alpha + below;
    if whole <= 0.0 {
        return;
    }
    let grey = [luminance([red, green, blue])];
    let (colors, count) = if pixel.len() < 3 { (&grey[..], 1) } else { (&[red, green, blue][..], 3) };
    for (value, color) in pixel[..count].iter_mut().zip(colors) {
        *value = (color + below * *value) / whole;
    }
    if has_alpha && let Some(last) = pixel.last_mut() {
        *last = whole;
    }
}

/// Returns for each pixel which of its samples charts cover, a bit each.
fn samples(context: &Context, charts: &[Chart], [width, height]: [usize; 2]) -> Vec<u16> {
    let mut bands: Vec<Vec<u32>> = vec![Vec::new(); height.div_ceil(BAND)];
    for (index, chart) in charts.iter().enumerate() {
        let rows = chart.corners.map(|corner| corner[1]);
        let first = rows.into_iter().fold(f64::INFINITY, f64::min).max(0.0) as usize / BAND;
        let last = rows.into_iter().fold(0.0, f64::max) as usize / BAND;
        for band in first..=last.min(bands.len() - 1) {
            bands[band].push(index as u32);
        }
    }
    let drawn = context.map(bands.len(), |band| {
        let first = band * BAND;
        let rows = BAND.min(height - first);
        let mut samples = vec![0_u16; width * rows];
        for chart in &bands[band] {
            let scale = SAMPLES as f64;
            let corners =
                charts[*chart as usize].corners.map(|[x, y]| [x * scale - 0.5, (y - first as f64) * scale - 0.5]);
            let span = |axis: usize, count: usize| {
                let values = corners.map(|corner| corner[axis]);
                let least = values.into_iter().fold(f64::INFINITY, f64::min).ceil().max(0.0);
                let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max).floor().min(count as f64 - 1.0);
                if least <= most { least as usize..most as usize + 1 } else { 0..0 }
            };
            for row in span(1, rows * SAMPLES) {
                for column in span(0, width * SAMPLES) {
                    if weights([0, 1, 2], corners, [column as f64, row as f64]).is_some() {
                        let sample = row % SAMPLES * SAMPLES + column % SAMPLES;
                        samples[row / SAMPLES * width + column / SAMPLES] |= 1 << sample;
                    }
                }
            }
        }
        samples
    });
    // Bands run upwards, the rows of the picture downwards.
    let upwards = drawn.concat();
    upwards.chunks_exact(width.max(1)).rev().flatten().copied().collect()
}
