//! Bakes of triangle meshes on their texture coordinates, which are linear in every triangle: the place of a pixel is
//! that of its barycentric coordinates, and needs no search as on limit surfaces.
//!
//! A picture is made in bands of rows, each from the triangles that reach into it, in order. Where several lie on a
//! pixel the first has it; what is on the common side of two is no overlap. Tangent space is that of the interpolated
//! normal of the undisplaced mesh, with T along increasing s in the plane of the triangle.

use glam::{DVec2, Vec3, Vec4};
use relievo_core::{Context, Domain, Error, Mesh, Progress, Result, Values};
use relievo_tiles::ColorTexel;
use relievo_tiles::trace::Trace;
use relievo_tiles::triangle::{TriangleDisplaced, TriangleField, TriangleNormals, foot_at};

use crate::layout::{MAX_COVERED, covered_too_often};
use crate::map::{BakeOptions, BakeReport, Map, check, chosen};
use crate::quantity::{Axes, Handedness, Meaning, Space};

/// Colours of a triangle mesh, of any format.
pub trait TriangleColors: Sync + std::fmt::Debug {
    /// The linear colour and alpha at the place of `face` with barycentric coordinates `at`.
    fn color(&self, face: u32, at: [f32; 3]) -> Vec4;
}

impl<T: ColorTexel> TriangleColors for TriangleField<T> {
    fn color(&self, face: u32, at: [f32; 3]) -> Vec4 {
        self.value(face, at).as_vec4()
    }
}

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
    pub colors: Option<&'a dyn TriangleColors>,
    /// Traces, for what is of them.
    pub traces: Option<&'a TriangleField<Trace>>,
}

/// Rows of a band, columns of a window.
const ROWS: usize = 64;
const COLUMNS: usize = 256;
/// Bands between two words on the progress.
const BANDS: usize = 8;
/// How often triangles may cover a picture of any size.
const MIN_COVER: f64 = 100.0;
/// Of barycentric coordinates, what counts as on a side.
const SIDE: f64 = 1e-7;

/// A triangle in the texture coordinates of a picture, in samples, the row of the largest t first.
#[derive(Clone, Copy)]
struct Flat {
    face: u32,
    corners: [DVec2; 3],
}

impl Flat {
    /// Whether its box meets that from `low` to `high`.
    fn meets(&self, low: DVec2, high: DVec2) -> bool {
        let [a, b, c] = self.corners;
        a.min(b).min(c).cmple(high).all() && a.max(b).max(c).cmpge(low).all()
    }
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

    /// The mean of the samples of a pixel that hit a triangle, and whether several triangles lie on one of them; `None`
    /// where none hits.
    fn mean<'s>(&self, samples: impl Iterator<Item = &'s Sampled>, uvs: &[[DVec2; 3]]) -> Option<([f32; 4], bool)> {
        let (mut sum, mut hits, mut several) = (Vec4::ZERO, 0, false);
        for (hit, overlaps) in samples {
            several |= overlaps;
            let Some((face, at)) = hit else { continue };
            sum += Vec4::from(self.evaluate(*face, *at, uvs[*face as usize]));
            hits += 1;
        }
        if hits == 0 {
            return None;
        }
        let mut mean = sum / hits as f32;
        if let (Meaning::Normal(..), 2..) = (self.meaning, hits) {
            mean = mean.truncate().normalize_or_zero().extend(0.0);
        }
        Some((mean.to_array(), several))
    }

    /// The numbers at a place; the rest of the four is zero.
    fn evaluate(&self, face: u32, at: [f32; 3], uvs: [DVec2; 3]) -> [f32; 4] {
        let one = |value: f32| [value, 0.0, 0.0, 0.0];
        let three = |value: Vec3| value.extend(0.0).to_array();
        let color = || self.colors.map_or(Vec4::ZERO, |colors| colors.color(face, at));
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

/// Bakes `quantity`, of the triangles of `mesh`, on its texture coordinates `uv`, and calls `each` for every picture,
/// by number.
///
/// # Errors
/// Fails as [`crate::bake_watched`] does, and with `Invalid` if the mesh has no such texture coordinates or other
/// triangles than its detail, or what is to be baked is missing.
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
    let found = squares(&uvs);
    let pictures = chosen(&found, options)?;
    check_cover(&uvs, &pictures, options)?;
    let flat = uvs.iter().filter(|corners| area(corners) == 0.0).count();
    let mut report = BakeReport { flat, outside: found.len() - pictures.len(), ..BakeReport::default() };
    let part = 1.0 / pictures.len().max(1) as f32;
    for (number, at) in pictures.into_iter().enumerate() {
        let span = [number as f32 * part, (number + 1) as f32 * part];
        let (mut map, overlapping) = picture(context, &uvs, quantity, options, at, (progress, span))?;
        let covered = map.covered.iter().filter(|covered| **covered).count();
        if covered == 0 {
            continue;
        }
        report.overlapping += overlapping;
        report.gutter += map.surround(options.gutter);
        report.covered += covered as u64;
        report.pictures.push(map.udim);
        each(map)?;
    }
    report.found_some(options)
}

/// Refuses pictures that triangles cover so often that no layout was meant: they would take hours.
fn check_cover(uvs: &[[DVec2; 3]], pictures: &[[i32; 2]], options: &BakeOptions) -> Result<()> {
    let samples = options.size.map(|size| size * options.samples);
    let most = (MAX_COVERED / samples.map(f64::from).iter().product::<f64>()).max(MIN_COVER);
    // Half of a triangle's box, whose samples are tried.
    let cover = |low: DVec2, high: DVec2| -> f64 {
        let some = uvs.iter().filter(|corners| area(corners) != 0.0);
        let boxes = some.map(|[a, b, c]| a.max(*b).max(*c).min(high) - a.min(*b).min(*c).max(low));
        boxes.map(|size| size.max(DVec2::ZERO).element_product() / 2.0).sum()
    };
    if cover(DVec2::MIN, DVec2::MAX) <= most {
        return Ok(());
    }
    for [k, l] in pictures {
        let low = DVec2::new(f64::from(*k), f64::from(*l));
        let times = cover(low, low + 1.0);
        if times > most {
            return Err(covered_too_often(times, samples));
        }
    }
    Ok(())
}

/// Twice the area in texture coordinates, negative where they are mirrored.
fn area([a, b, c]: &[DVec2; 3]) -> f64 {
    (*b - *a).perp_dot(*c - *a)
}

/// The squares of texture coordinates that the boxes of triangles with an area reach into, as (row, column), ascending.
/// Their number is bounded by that of the coordinates' whole box, and so is the time.
fn squares(uvs: &[[DVec2; 3]]) -> Vec<(i32, i32)> {
    let boxes = uvs.iter().filter(|corners| area(corners) != 0.0).map(|[a, b, c]| {
        let (low, high) = (a.min(*b).min(*c).floor(), a.max(*b).max(*c).ceil());
        [low.as_ivec2(), high.as_ivec2()]
    });
    let Some([low, high]) = boxes.clone().reduce(|[low, high], [l, h]| [low.min(l), high.max(h)]) else {
        return Vec::new();
    };
    let size = (high - low + 1).as_usizevec2();
    // How many boxes begin or end at a square; its sums over rows and columns are how many cover it.
    let mut grid = vec![0i64; size.x * size.y];
    for [from, to] in boxes {
        let [from, to] = [from, to].map(|at| (at - low).as_usizevec2());
        for (y, sign) in [(from.y, 1), (to.y, -1)] {
            grid[y * size.x + from.x] += sign;
            grid[y * size.x + to.x] -= sign;
        }
    }
    let mut found = Vec::new();
    let mut above = vec![0i64; size.x];
    for (y, row) in (low.y..).zip(grid.chunks(size.x)) {
        let mut sum = 0;
        for ((x, begins), above) in (low.x..).zip(row).zip(&mut above) {
            *above += begins;
            sum += *above;
            if sum > 0 {
                found.push((y, x));
            }
        }
    }
    found
}

/// Of every triangle of `mesh`, fanned and without holes, the texture coordinates of its corners.
fn coordinates(mesh: &Mesh, name: &str) -> Result<Vec<[DVec2; 3]>> {
    let place = || format!("attribute `{name}`");
    let advice = "unwrap the mesh, or name its coordinates";
    let attribute = mesh.attribute(name);
    let attribute = attribute.ok_or_else(|| Error::invalid("there is no such attribute").at(place()).advise(advice))?;
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
    let mut triangles = Vec::new();
    for (face, corners) in (0..).zip(uvs) {
        // Rows run against t.
        let corners = corners.map(|uv| {
            let at = (uv - DVec2::new(f64::from(k), f64::from(l))) * scale;
            DVec2::new(at.x, scale.y - at.y)
        });
        let flat = Flat { face, corners };
        if area(&corners) != 0.0 && flat.meets(DVec2::ZERO, scale) {
            triangles.push(flat);
        }
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
            let rows = covered.len() / width;
            let top = (first + index) * ROWS * times;
            let (low, high) = (DVec2::new(0.0, top as f64), DVec2::new(scale.x, (top + rows * times) as f64));
            let own: Vec<Flat> = triangles.iter().filter(|flat| flat.meets(low, high)).copied().collect();
            for left in (0..width).step_by(COLUMNS) {
                let columns = COLUMNS.min(width - left);
                let samples = samples(&own, [left * times, top], [columns * times, rows * times]);
                for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                    let pixel = &samples[(y * columns * times + x) * times..];
                    let hits = (0..times).flat_map(|row| &pixel[row * columns * times..][..times]);
                    let Some((value, overlaps)) = quantity.mean(hits, uvs) else { continue };
                    let pixel = y * width + left + x;
                    *overlapping += u64::from(overlaps);
                    data[pixel * channels..(pixel + 1) * channels].copy_from_slice(&value[..channels]);
                    covered[pixel] = true;
                }
            }
        });
    }
    let overlapping = bands.iter().map(|(.., overlapping)| overlapping).sum();
    Ok((map, overlapping))
}

/// The face and place of a sample, and whether several triangles lie on it.
type Sampled = (Option<(u32, [f32; 3])>, bool);

/// Those of a window of samples whose first has the column `left` and the row `top`.
fn samples(triangles: &[Flat], [left, top]: [usize; 2], [width, rows]: [usize; 2]) -> Vec<Sampled> {
    let mut out = vec![(None, false); width * rows];
    let mut inner = vec![false; width * rows];
    let origin = DVec2::new(left as f64, top as f64);
    for Flat { face, corners } in triangles {
        let [a, b, c] = corners.map(|corner| corner - origin);
        let area = area(corners);
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f64, high: f64, count: usize| {
            let clamp = |value: f64| value.clamp(0.0, count as f64) as usize;
            clamp((low - 0.5).floor())..clamp((high + 0.5).ceil())
        };
        for y in range(low.y, high.y, rows) {
            for x in range(low.x, high.x, width) {
                let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let shares = [(c - b).perp_dot(at - b), (a - c).perp_dot(at - c), (b - a).perp_dot(at - a)];
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
