//! Bakes of triangle meshes on their texture coordinates, which are linear in every triangle: the place of a pixel is that
//! of its barycentric coordinates, and needs no search as on limit surfaces.
//!
//! A picture is made in bands of rows, each from the triangles that reach into it, in order. Where several lie on a pixel
//! the first has it; what is on the common side of two is no overlap. Tangent space is that of the interpolated normal of
//! the undisplaced mesh, with T along increasing s in the plane of the triangle.

use std::collections::BTreeSet;

use glam::{DVec2, Vec3, Vec4};
use relievo_core::{Context, Domain, Error, Mesh, Progress, Result, Values};
use relievo_tiles::Rgba8;
use relievo_tiles::trace::Trace;
use relievo_tiles::triangle::{TriangleDisplaced, TriangleField, TriangleNormals, foot_at};

use crate::map::{BakeOptions, BakeReport, MOST_PICTURES, Map, check};
use crate::quantity::{Axes, Handedness, Meaning, Space};

/// What is baked, and of what.
#[derive(Clone, Copy, Debug)]
pub struct TriangleQuantity<'a> {
    /// What the numbers are.
    pub meaning: Meaning,
    /// The displaced mesh and its normals.
    pub displaced: TriangleDisplaced<'a>,
    /// See `displaced`.
    pub normals: &'a TriangleNormals,
    /// Colours, for what is of them.
    pub colors: Option<&'a TriangleField<Rgba8>>,
    /// Traces, for what is of them.
    pub traces: Option<&'a TriangleField<Trace>>,
}

/// Rows of a band.
const ROWS: usize = 64;
/// Bands between two words on the progress.
const BANDS: usize = 8;
/// Of barycentric coordinates, what counts as on a side.
const SIDE: f64 = 1e-7;

/// A triangle in the texture coordinates of a picture, in samples, the row of the largest t first.
#[derive(Clone, Copy)]
struct Flat {
    face: u32,
    corners: [DVec2; 3],
}

impl TriangleQuantity<'_> {
    /// As far as the numbers may go from 0: where lengths or times are to fit into a picture.
    pub fn largest(&self) -> f32 {
        let faces = 0..self.displaced.field().topology().face_count() as u32;
        let height = || {
            let ranges = faces.clone().map(|face| self.displaced.range(face));
            ranges.map(|[low, high]| high.max(-low)).fold(0.0, f32::max)
        };
        let traces = |of: fn(&Trace) -> f32| {
            let Some(field) = self.traces else { return 0.0 };
            let blocks = field.allocated().filter_map(|face| field.face(face));
            let edges = field.allocated_edges().filter_map(|edge| field.edge(edge));
            blocks.chain(edges).chain(field.vertices()).flatten().map(of).fold(0.0, f32::max)
        };
        match self.meaning {
            Meaning::Displacement => height(),
            Meaning::Vector(..) => height() + self.displaced.vector_reach(),
            Meaning::Depth => traces(|trace| trace.depth.to_f32()),
            Meaning::Time => traces(|trace| trace.moment),
            _ => 1.0,
        }
    }

    fn check(&self) -> Result<()> {
        let missing = |what: &str| Err(Error::invalid(format!("the mesh has no {what}")));
        match self.meaning {
            Meaning::Color | Meaning::Mask if self.colors.is_none() => missing("colours"),
            Meaning::Contact | Meaning::Depth | Meaning::Time if self.traces.is_none() => missing("traces of contact"),
            _ => Ok(()),
        }
    }

    /// The numbers at a place; the rest of the four is zero.
    fn evaluate(&self, face: u32, at: [f32; 3], uvs: [DVec2; 3]) -> [f32; 4] {
        let one = |value: f32| [value, 0.0, 0.0, 0.0];
        let three = |value: Vec3| value.extend(0.0).to_array();
        let color = || self.colors.map_or(Vec4::ZERO, |colors| colors.value(face, at).as_vec4());
        let mark = || self.traces.map_or(glam::DVec4::ZERO, |traces| traces.value(face, at));
        match self.meaning {
            Meaning::Displacement => one(self.displaced.field().value(face, at) as f32),
            Meaning::Vector(space, axes) => {
                let foot = foot_at(self.displaced.surface(), face, at);
                let vector = self.displaced.offset(face, at, foot.normal);
                three(match (space, axes) {
                    (Space::Object, _) => vector,
                    (_, axes) => {
                        let [t, b, n] = self.frame(face, foot.normal, uvs);
                        let [x, y, z] = [vector.dot(t), vector.dot(b), vector.dot(n)];
                        if axes == Axes::Tbn { Vec3::new(x, y, z) } else { Vec3::new(x, z, y) }
                    }
                })
            }
            Meaning::Normal(space, handedness) => {
                let foot = foot_at(self.displaced.surface(), face, at);
                let normal = self.normals.value(foot.normal, face, at);
                three(match space {
                    Space::Object => normal,
                    Space::Tangent => {
                        let [t, b, n] = self.frame(face, foot.normal, uvs);
                        let up = if handedness == Handedness::OpenGl { 1.0 } else { -1.0 };
                        Vec3::new(normal.dot(t), up * normal.dot(b), normal.dot(n))
                    }
                })
            }
            Meaning::Color => color().to_array(),
            Meaning::Mask => one(color().w),
            Meaning::Contact => one(mark().x as f32),
            Meaning::Depth => one(mark().y as f32),
            Meaning::Time => one(if mark().x > 0.0 { (mark().z / mark().x) as f32 } else { -1.0 }),
        }
    }

    /// T, B and N where the smooth normal is `normal`.
    fn frame(&self, face: u32, normal: Vec3, [a, b, c]: [DVec2; 3]) -> [Vec3; 3] {
        let corners = self.displaced.surface().corner_points(face).map(Vec3::from);
        let (u, v) = ((b - a).as_vec2(), (c - a).as_vec2());
        let (p, q) = (corners[1] - corners[0], corners[2] - corners[0]);
        let sign = if u.perp_dot(v) < 0.0 { -1.0 } else { 1.0 };
        let across = |way: Vec3| (way - normal * normal.dot(way)).try_normalize();
        let t = across(sign * (p * v.y - q * u.y)).or_else(|| across(p)).unwrap_or(Vec3::X);
        [t, sign * normal.cross(t), normal]
    }
}

/// Bakes `quantity`, of the triangles of `mesh`, on its texture coordinates `uv`, and calls `each` for every picture, by
/// number.
///
/// Fails as [`crate::bake_watched`] does.
pub fn bake_triangles(
    context: &Context,
    (mesh, uv): (&Mesh, &str),
    quantity: &TriangleQuantity<'_>,
    options: &BakeOptions,
    progress: &mut dyn Progress,
    mut each: impl FnMut(Map) -> Result<()>,
) -> Result<BakeReport> {
    quantity.check()?;
    let channels = quantity.meaning.channels();
    check(context, channels, options)?;
    let uvs = coordinates(mesh, uv)?;
    if uvs.len() != quantity.displaced.field().topology().face_count() {
        return Err(Error::invalid("the mesh has other triangles than its detail"));
    }
    let mut found = BTreeSet::new();
    let mut report = BakeReport::default();
    for corners in &uvs {
        let [a, b, c] = *corners;
        if (b - a).perp_dot(c - a) == 0.0 {
            report.flat += 1;
            continue;
        }
        let (low, high) = (a.min(b).min(c).floor(), a.max(b).max(c));
        for l in low.y as i32..=high.y.ceil() as i32 - 1 {
            found.extend((low.x as i32..=high.x.ceil() as i32 - 1).map(|k| (l, k)));
        }
    }
    let wanted = |(l, k): &(i32, i32)| match options.udim {
        true => (0..10).contains(k) && (0..900).contains(l),
        false => (*l, *k) == (0, 0),
    };
    let pictures: Vec<(i32, i32)> = found.iter().copied().filter(|at| wanted(at)).collect();
    if pictures.len() > MOST_PICTURES {
        return Err(Error::invalid(format!("the texture coordinates lie on {} pictures", pictures.len()))
            .advise(format!("scale them to at most {MOST_PICTURES}")));
    }
    report.outside = found.len() - pictures.len();
    let part = 1.0 / pictures.len().max(1) as f32;
    for (number, (l, k)) in pictures.into_iter().enumerate() {
        let span = [number as f32 * part, (number + 1) as f32 * part];
        let (mut map, overlapping) = picture(context, &uvs, quantity, options, [k, l], (progress, span))?;
        let covered = map.covered.iter().filter(|covered| **covered).count();
        if covered == 0 {
            report.outside += 1;
            continue;
        }
        report.overlapping += overlapping;
        report.gutter += map.surround(options.gutter);
        report.covered += covered as u64;
        report.pictures.push(map.udim);
        each(map)?;
    }
    match report.pictures.is_empty() {
        true => Err(Error::invalid("no texture coordinates lie on the picture").advise("unwrap the mesh first")),
        false => Ok(report),
    }
}

/// Of every triangle of `mesh`, fanned and without holes, the texture coordinates of its corners.
fn coordinates(mesh: &Mesh, name: &str) -> Result<Vec<[DVec2; 3]>> {
    let place = || format!("attribute `{name}`");
    let advice = "unwrap the mesh, or name its coordinates";
    let attribute = mesh.attribute(name);
    let attribute =
        attribute.ok_or_else(|| Error::invalid("there is no such attribute").at(place()).advise(advice))?;
    let (Domain::Corner, Values::F32(values), 2) = (attribute.domain, &attribute.values, attribute.width) else {
        return Err(Error::invalid("texture coordinates are two floats on corners").at(place()).advise(advice));
    };
    let at = |corner: usize| {
        let index = attribute.indices.as_ref().map_or(corner, |indices| indices[corner] as usize);
        DVec2::new(f64::from(values[2 * index]), f64::from(values[2 * index + 1]))
    };
    if values.iter().any(|value| value.abs() > LARGEST || !value.is_finite()) {
        return Err(Error::invalid(format!("texture coordinates are not within {LARGEST} of 0")).at(place()));
    }
    let mut hole = vec![false; mesh.face_count()];
    mesh.holes.iter().for_each(|face| hole[*face as usize] = true);
    let (mut first, mut all) = (0, Vec::new());
    for (size, hole) in mesh.face_sizes.iter().zip(hole) {
        let size = *size as usize;
        if !hole {
            all.extend((1..size - 1).map(|k| [at(first), at(first + k), at(first + k + 1)]));
        }
        first += size;
    }
    Ok(all)
}

/// The largest texture coordinate.
const LARGEST: f32 = 1000.0;

/// One picture, and the pixels on which triangles overlap.
fn picture(
    context: &Context,
    uvs: &[[DVec2; 3]],
    quantity: &TriangleQuantity<'_>,
    options: &BakeOptions,
    [k, l]: [i32; 2],
    (progress, [from, to]): (&mut dyn Progress, [f32; 2]),
) -> Result<(Map, u64)> {
    let [width, height] = options.size.map(|size| size as usize);
    let (channels, times) = (quantity.meaning.channels(), options.samples as usize);
    let scale = DVec2::new((width * times) as f64, (height * times) as f64);
    let mut bins: Vec<Vec<Flat>> = vec![Vec::new(); height.div_ceil(ROWS)];
    let rows = ROWS * times;
    for (face, corners) in (0..).zip(uvs) {
        // Rows run against t.
        let corners = corners.map(|uv| {
            let at = (uv - DVec2::new(f64::from(k), f64::from(l))) * scale;
            DVec2::new(at.x, scale.y - at.y)
        });
        let (low, high) =
            (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        if high.x < 0.0 || high.y < 0.0 || low.x > scale.x || low.y > scale.y {
            continue;
        }
        let first = low.y.max(0.0) as usize / rows;
        let last = (high.y.min(scale.y - 1.0).max(0.0) as usize / rows).min(bins.len() - 1);
        bins[first.min(last)..=last].iter_mut().for_each(|bin| bin.push(Flat { face, corners }));
    }
    let mut map = Map {
        udim: (1001 + k + 10 * l) as u32,
        width: width as u32,
        height: height as u32,
        channels,
        data: quantity.meaning.background().repeat(width * height),
        covered: vec![false; width * height],
    };
    let data = map.data.chunks_mut(ROWS * width * channels);
    let covered = map.covered.chunks_mut(ROWS * width);
    let mut bands: Vec<_> = data.zip(covered).map(|(data, covered)| (data, covered, 0u64)).collect();
    let count = bands.len();
    for (index, some) in bands.chunks_mut(BANDS).enumerate() {
        let first = index * BANDS;
        progress.step(from + (to - from) * first as f32 / count as f32, "bake")?;
        context.for_each_mut(some, |index, (data, covered, overlapping)| {
            let band = first + index;
            let size = [width * times, covered.len() / width * times];
            let samples = samples(&bins[band], band * rows, size);
            for pixel in 0..covered.len() {
                let (x, y) = (pixel % width * times, pixel / width * times);
                let own = (0..times * times).map(|at| &samples[(y + at / times) * size[0] + x + at % times]);
                let (mut sum, mut hits, mut several) = ([0.0f32; 4], 0, false);
                for (hit, overlaps) in own {
                    several |= overlaps;
                    let Some((face, at)) = hit else { continue };
                    let value = quantity.evaluate(*face, *at, uvs[*face as usize]);
                    (0..channels).for_each(|channel| sum[channel] += value[channel]);
                    hits += 1;
                }
                if hits == 0 {
                    continue;
                }
                *overlapping += u64::from(several);
                let mut mean = sum.map(|sum| sum / hits as f32);
                if let (Meaning::Normal(..), 2..) = (quantity.meaning, hits) {
                    let unit = Vec4::from(mean).truncate().normalize_or_zero();
                    mean = unit.extend(0.0).to_array();
                }
                data[pixel * channels..(pixel + 1) * channels].copy_from_slice(&mean[..channels]);
                covered[pixel] = true;
            }
        });
    }
    let overlapping = bands.iter().map(|(.., overlapping)| overlapping).sum();
    Ok((map, overlapping))
}

/// The face and place of a sample, and whether several triangles lie on it.
type Sampled = (Option<(u32, [f32; 3])>, bool);

/// Those of a band of samples, which begins at row `first`.
fn samples(triangles: &[Flat], first: usize, [width, rows]: [usize; 2]) -> Vec<Sampled> {
    let mut out = vec![(None, false); width * rows];
    let mut inner = vec![false; width * rows];
    for Flat { face, corners: [a, b, c] } in triangles {
        let area = (*b - *a).perp_dot(*c - *a);
        if area == 0.0 {
            continue;
        }
        let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
        let top = first as f64;
        let range = |low: f64, high: f64, count: usize| {
            let clamp = |value: f64| value.clamp(0.0, count as f64) as usize;
            clamp((low - 0.5).floor())..clamp((high + 0.5).ceil())
        };
        for y in range(low.y - top, high.y - top, rows) {
            for x in range(low.x, high.x, width) {
                let at = DVec2::new(x as f64 + 0.5, top + y as f64 + 0.5);
                let shares = [(*c - *b).perp_dot(at - *b), (*a - *c).perp_dot(at - *c), (*b - *a).perp_dot(at - *a)];
                let shares = shares.map(|share| share / area);
                let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
                if least < -SIDE {
                    continue;
                }
                let (found, overlaps) = &mut out[y * width + x];
                let inside = &mut inner[y * width + x];
                if found.is_none() {
                    let shares = shares.map(|share| if share < SIDE { 0.0 } else { share as f32 });
                    *found = Some((*face, shares));
                } else {
                    *overlaps |= *inside && least > SIDE;
                }
                *inside |= least > SIDE;
            }
        }
    }
    out
}
