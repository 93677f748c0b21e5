//! Simplification of meshes whose vertices have more than places: normals, texture coordinates, colours.

use glam::Vec4;
use relievo_core::{Context, Error, Progress, Result};

use crate::connectivity::NONE;
use crate::simplify::decimation::Decimation;
use crate::simplify::error_bound::{Limits, Triangles};
use crate::simplify::wedges::{Range, Wedges};
use crate::simplify::{Bounded, SimplifyOptions, border, check, check_memory, reduce, simplified_within, unit};
use crate::watched::watched;
use crate::weld::weld;

/// Numbers that the vertices of a mesh have beside their places. Where vertices at one place have different numbers
/// there is a seam between the triangles that have them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Attributes<'a> {
    /// Those of every vertex, as many as there are weights.
    pub values: &'a [f32],
    /// Of each number, how large a part of the diagonal of the mesh's box a difference of 1 counts as, 0 or more. A number
    /// of weight 0 is kept along and has no influence beside its seams. 16 at most.
    pub weights: &'a [f32],
    /// Which numbers are the first of three that are a direction, of length 1.
    pub directions: &'a [usize],
    /// Which numbers are the first of two that are texture coordinates: no collapse turns a triangle over in them.
    pub uvs: &'a [usize],
    /// A label of every vertex, or none: vertices of different labels are on different sides of a seam, whatever their
    /// numbers are.
    pub labels: &'a [u32],
}

impl Attributes<'_> {
    /// Numbers of a vertex at most.
    pub const MAX: usize = 16;

    /// Fails unless there are numbers for so many vertices, and all can be used.
    pub(crate) fn check(&self, vertices: usize) -> Result<()> {
        let width = self.weights.len();
        if width > Self::MAX {
            return Err(Error::unsupported(format!("{width} numbers of a vertex are too many"))
                .at("attributes")
                .advise(format!("use at most {}", Self::MAX)));
        }
        if vertices.checked_mul(width) != Some(self.values.len()) {
            let count = self.values.len();
            return Err(Error::invalid(format!("{count} numbers are not {width} for each of {vertices} vertices"))
                .at("attributes"));
        }
        if !self.labels.is_empty() && self.labels.len() != vertices {
            let count = self.labels.len();
            return Err(
                Error::invalid(format!("{count} labels are not one for each of {vertices} vertices")).at("labels")
            );
        }
        if let Some(index) = self.values.iter().position(|value| !value.is_finite()) {
            return Err(Error::invalid(format!("a number of vertex {} is not finite", index / width)).at("attributes"));
        }
        if let Some(weight) = self.weights.iter().find(|weight| !(0.0..=Self::HEAVIEST).contains(*weight)) {
            return Err(Error::invalid(format!("a weight of {weight} means nothing"))
                .at("weights")
                .advise(format!("use 0 to {}", Self::HEAVIEST)));
        }
        if self.directions.iter().any(|first| first.checked_add(3).is_none_or(|end| end > width)) {
            return Err(Error::invalid("a direction goes beyond the numbers of a vertex").at("directions"));
        }
        if self.uvs.iter().any(|first| first.checked_add(2).is_none_or(|end| end > width)) {
            return Err(Error::invalid("texture coordinates go beyond the numbers of a vertex").at("uvs"));
        }
        Ok(())
    }

    /// The largest weight; squares of it times areas stay in the range of f32.
    pub const HEAVIEST: f32 = 1e6;
}

/// A mesh that was simplified with its attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimplifiedWith {
    /// Positions. Vertices at seams are there once for each side, at the same position.
    pub points: Vec<[f32; 3]>,
    /// Numbers of every vertex.
    pub values: Vec<f32>,
    /// Vertices of every triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The place of every vertex, counted from 0: vertices of one place are one on the surface.
    pub places: Vec<u32>,
    /// The triangle of the input that every triangle was.
    pub origins: Vec<u32>,
    /// The largest distance between both surfaces, never less than the true one, if there is a
    /// [`SimplifyOptions::bound`]; else the largest estimated deviation of a vertex.
    pub error: f32,
}

impl Bounded for SimplifiedWith {
    fn shape(&self) -> Triangles<'_> {
        (&self.points, &self.triangles)
    }

    fn set_error(&mut self, error: f32) {
        self.error = error;
    }
}

/// Simplifies a mesh as [`crate::simplify`] does, with the attributes of its vertices: their differences, with their
/// weights, count as distances too. Vertices at the same place are taken as one, with a seam where their attributes
/// differ. A seam collapses along itself only, and its ends, and places where several meet, stay. Values stay within
/// the range of the input's.
///
/// # Errors
/// Fails as [`crate::simplify`], if a vertex has more than 16 numbers, or values, labels or weights do not fit the
/// vertices or are not usable.
pub fn simplify_with(
    context: &Context,
    points: &[[f32; 3]],
    triangles: &[[u32; 3]],
    attributes: &Attributes,
    options: &SimplifyOptions,
    progress: &mut dyn Progress,
) -> Result<SimplifiedWith> {
    check(context, points, triangles, options)?;
    attributes.check(points.len())?;
    match attributes.weights.len() {
        ..=4 => run::<1>(context, points, triangles, attributes, options, progress),
        5..=8 => run::<2>(context, points, triangles, attributes, options, progress),
        _ => run::<4>(context, points, triangles, attributes, options, progress),
    }
}

fn run<const Q: usize>(
    context: &Context,
    points: &[[f32; 3]],
    triangles: &[[u32; 3]],
    attributes: &Attributes,
    options: &SimplifyOptions,
    progress: &mut dyn Progress,
) -> Result<SimplifiedWith> {
    check_memory(context, triangles.len().max(points.len()), Wedges::<Q>::BYTES)?;
    let scale = unit(points);
    watched(context, progress, |progress| {
        let welded = weld(points, triangles);
        let sides = sides(&welded.numbers, attributes.labels, attributes.values, attributes.weights.len());
        let number = |vertex: &u32| sides[*vertex as usize];
        let wedges: Vec<[u32; 3]> = triangles.iter().map(|triangle| triangle.each_ref().map(number)).collect();
        let values: Vec<[Vec4; Q]> = (0..points.len()).map(|vertex| quads(attributes, vertex)).collect();
        let range = range(points, &values, attributes, scale);
        let mut fixed: Vec<u32> = options.locked.iter().map(|vertex| welded.numbers[*vertex as usize]).collect();
        if options.is_border_locked {
            fixed.extend(border(&welded.triangles));
        }
        let run = |limits: &Limits, progress: &mut dyn Progress| {
            let wedges = Wedges::<Q>::new(context, welded.points.len(), &wedges, values.clone(), range.clone());
            let mut work = Decimation::with(context, &welded.points, &welded.triangles, 1.0 / scale, wedges)?;
            work.spend(|vertex| limits.spent(vertex) / scale);
            work.lock(&fixed);
            work.weigh(&options.vertex_weights, |point| welded.numbers[point] as usize);
            reduce(context, &mut work, triangles.len(), options.target_triangles, limits.error() / scale, progress)?;
            Ok(finish(&work, (points, triangles), &sides, attributes.weights.len(), scale))
        };
        simplified_within(context, (&welded.points, &welded.triangles), options, progress, run)
    })
}

/// For every vertex the first at its place that has the same label, if there are any, and the same numbers.
pub fn sides(places: &[u32], labels: &[u32], values: &[f32], width: usize) -> Vec<u32> {
    let known = |vertex: u32| (places[vertex as usize], labels.get(vertex as usize));
    let numbers = |vertex: u32| {
        let start = vertex as usize * width;
        // 0 and -0 are one number.
        values[start..start + width].iter().map(|value| (value + 0.0).to_bits())
    };
    let same = |a: u32, b: u32| known(a).cmp(&known(b)).then_with(|| numbers(a).cmp(numbers(b)));
    let mut order: Vec<u32> = (0..places.len() as u32).collect();
    order.sort_unstable_by(|a, b| same(*a, *b).then(a.cmp(b)));
    let mut first = vec![0; places.len()];
    for group in order.chunk_by(|a, b| same(*a, *b).is_eq()) {
        group.iter().for_each(|vertex| first[*vertex as usize] = group[0]);
    }
    first
}

/// The numbers of a vertex, four by four.
fn quads<const Q: usize>(attributes: &Attributes, vertex: usize) -> [Vec4; Q] {
    let width = attributes.weights.len();
    fours(&attributes.values[vertex * width..(vertex + 1) * width])
}

/// Numbers, four by four.
pub fn fours<const Q: usize>(numbers: &[f32]) -> [Vec4; Q] {
    let number = |index: usize| numbers.get(index).copied().unwrap_or(0.0);
    std::array::from_fn(|quad| Vec4::from_array(std::array::from_fn(|lane| number(4 * quad + lane))))
}

/// What bounds the numbers, with lengths divided by `scale`.
pub fn range<const Q: usize>(
    points: &[[f32; 3]],
    values: &[[Vec4; Q]],
    attributes: &Attributes,
    scale: f32,
) -> Range<Q> {
    let bounds = points.iter().fold((Vec4::MAX, Vec4::MIN), |(low, high), [x, y, z]| {
        let point = Vec4::new(*x, *y, *z, 0.0) / scale;
        (low.min(point), high.max(point))
    });
    let diagonal = bounds.1.distance(bounds.0);
    let squares: Vec<f32> = attributes.weights.iter().map(|weight| (weight * diagonal).powi(2)).collect();
    let mut range = Range {
        squares: fours(&squares),
        low: [Vec4::MAX; Q],
        high: [Vec4::MIN; Q],
        directions: attributes.directions.to_vec(),
        uvs: attributes.uvs.to_vec(),
    };
    for values in values {
        for (quad, value) in values.iter().enumerate() {
            range.low[quad] = range.low[quad].min(*value);
            range.high[quad] = range.high[quad].max(*value);
        }
    }
    range
}

/// The triangles that are left, and their vertices, in the order of the input, with vertices that no triangle had
/// before.
fn finish<const Q: usize>(
    work: &Decimation<Q>,
    (points, triangles): (&[[f32; 3]], &[[u32; 3]]),
    sides: &[u32],
    width: usize,
    scale: f32,
) -> SimplifiedWith {
    let mut found = vec![None; points.len()];
    let mut is_used = vec![false; points.len()];
    triangles.as_flattened().iter().for_each(|vertex| is_used[sides[*vertex as usize] as usize] = true);
    for vertex in (0..points.len()).filter(|vertex| !is_used[*vertex] && sides[*vertex] as usize == *vertex) {
        found[vertex] = Some((points[vertex], NONE));
    }
    let mut made = SimplifiedWith::default();
    for index in 0..work.mesh.triangles() {
        let vertices = work.mesh.triangle(index);
        if vertices[0] != NONE {
            let (wedges, origin) = work.wedges.triangle(index);
            for (vertex, wedge) in vertices.into_iter().zip(wedges) {
                let point = work.points[vertex as usize];
                found[wedge as usize] = Some(((point.truncate() * scale).to_array(), vertex));
                made.error = made.error.max(point.w * scale);
            }
            made.triangles.push(wedges);
            made.origins.push(origin);
        }
    }
    let (mut numbers, mut places, mut count) = (vec![0; points.len()], vec![NONE; work.points.len()], 0);
    for (wedge, found) in (0..).zip(found) {
        let Some((point, vertex)) = found else { continue };
        // A vertex without triangles is at a place of its own.
        let place = match places.get_mut(vertex as usize) {
            Some(place) if *place != NONE => *place,
            known => {
                count += 1;
                known.map_or(count - 1, |place| {
                    *place = count - 1;
                    *place
                })
            }
        };
        made.places.push(place);
        numbers[wedge as usize] = made.points.len() as u32;
        made.points.push(point);
        let values = work.wedges.values(wedge).iter().flat_map(|quad| quad.to_array());
        made.values.extend(values.take(width));
    }
    made.triangles.as_flattened_mut().iter_mut().for_each(|vertex| *vertex = numbers[*vertex as usize]);
    made
}
