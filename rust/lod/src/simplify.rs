//! Simplification of triangle meshes: fewer triangles for nearly the same surface.
//!
//! Edges are collapsed patch by patch, in the order of their costs: `patches.rs`. With attributes, and for progressive
//! meshes, whose collapses must not stand on each other more than they have to, that is done in rounds (Grund, Derzapf,
//! Guthe 2011; Derzapf, Grund, Guthe 2014, Section 3): each finds what collapses cost, and makes those of the cheapest
//! fifth that do not touch each other, at the same time. Where a vertex goes and what that costs is found from the
//! triangles as they are then (Lindstrom, Turk 1998): `placement.rs`. Results do not depend on the number of threads.

pub(crate) mod attributes;
mod beside;
pub(crate) mod decimation;
mod doubles;
mod error_bound;
mod exchange;
pub(crate) mod mesh;
mod offset;
mod open_fans;
mod outliers;
pub(crate) mod patch;
mod patches;
pub(crate) mod placement;
mod queue;
mod selection;
mod sheets;
pub(crate) mod wedges;

use std::collections::HashMap;

use glam::Vec4;
use relievo_core::{Context, Error, Progress, Result};

use crate::connectivity::NONE;
use crate::progressive::Recording;
use crate::simplify::decimation::Decimation;
use crate::simplify::doubles::Doubles;
use crate::simplify::error_bound::{Limits, Triangles};
use crate::simplify::exchange::exchange;
use crate::simplify::open_fans::OpenFans;
use crate::simplify::patch::Pieces;
use crate::simplify::patches::Reduced;
use crate::simplify::sheets::Sheets;
use crate::watched::watched;

/// When a simplification ends, at the first of these, and what it leaves alone.
#[derive(Clone, Debug)]
pub struct SimplifyOptions {
    /// Triangles to be left. There may be one less, where two go at once.
    pub target_triangles: usize,
    /// The largest estimated deviation from the mesh as it was, in its units, infinite for any. A vertex deviates by what
    /// its ends did before its collapse, and by what that adds: the root mean square distance from the planes of its
    /// triangles, over their area, or the largest distance of a vertex from the triangles around it if that is more
    /// (without attributes). The distance between the surfaces may be more.
    pub max_error: f32,
    /// The largest distance between both surfaces, either way, in units of the mesh, infinite for any. It is measured,
    /// and the mesh simplified several times. Less than 10⁻⁷ of the largest coordinate, its rounding, counts as that.
    pub bound: f32,
    /// Vertices that stay where they are.
    pub locked: Vec<u32>,
    /// Whether vertices of edges with one triangle stay where they are.
    pub is_border_locked: bool,
    /// What the costs of collapses at every vertex are multiplied by, 10⁻⁶ to 10⁶; none for 1 everywhere. Greater weights
    /// leave more triangles there. Deviations are not multiplied.
    pub vertex_weights: Vec<f32>,
}

impl Default for SimplifyOptions {
    fn default() -> Self {
        Self {
            target_triangles: 0,
            max_error: f32::INFINITY,
            bound: f32::INFINITY,
            locked: Vec::new(),
            is_border_locked: false,
            vertex_weights: Vec::new(),
        }
    }
}

impl SimplifyOptions {
    /// Checks the options for a mesh of so many points.
    ///
    /// # Errors
    /// Fails if a locked point does not exist, factors are not one a point or not from 10⁻⁶ to 10⁶, or a length is
    /// negative or no number.
    pub fn check(&self, points: usize) -> Result<()> {
        if self.locked.iter().any(|index| *index as usize >= points) {
            return Err(Error::invalid("a locked point is not there").at("locked"));
        }
        if !self.vertex_weights.is_empty() && self.vertex_weights.len() != points {
            let counts = (self.vertex_weights.len(), points);
            return Err(Error::invalid(format!("{} factors are not one for each of {} points", counts.0, counts.1))
                .at("factors"));
        }
        if let Some(factor) = self.vertex_weights.iter().find(|factor| !(1e-6..=1e6).contains(*factor)) {
            return Err(Error::invalid(format!("a factor of {factor} means nothing"))
                .at("factors")
                .advise("use 1e-6 to 1e6"));
        }
        for (name, length) in [("error", self.max_error), ("bound", self.bound)] {
            if length.is_nan() || length < 0.0 {
                return Err(Error::invalid(format!("the {name} is {length}, not a length"))
                    .at(name)
                    .advise("give 0 or more, or infinity"));
            }
        }
        Ok(())
    }

    /// Returns the points that stay where they are.
    pub(crate) fn fixed(&self, triangles: &[[u32; 3]]) -> Vec<u32> {
        let mut fixed = self.locked.clone();
        if self.is_border_locked {
            fixed.extend(border(triangles));
        }
        fixed
    }
}

/// A simplified mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Simplified {
    /// Positions.
    pub points: Vec<[f32; 3]>,
    /// Points of every triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The largest distance between both surfaces, never less than the true one, if there is a
    /// [`SimplifyOptions::bound`]; else the largest estimated deviation of a vertex.
    pub error: f32,
}

/// Triangles of a mesh at most: corners are counted in 32 bits, four a triangle.
const MAX: usize = (u32::MAX / 4) as usize;
/// Bytes of the structures for a triangle, with half a vertex.
const BYTES: u64 = 160;
/// The share of edges that are considered in a round. More would be faster and take edges out of their order.
const SHARE: f32 = 0.2;
/// Costs beyond the limit of the last round, as a factor, up to which edges are looked at; so the limit rises no faster
/// while there are enough below.
const AHEAD: f32 = 1.25;
/// Edges below the limit that are enough, as a share of the edges that are to be considered.
const FEW_SHARE: f32 = 0.25;

/// Simplifications at most of a mesh whose curves, where sheets meet, or double parts leave too many triangles.
const TRIES: usize = 5;

/// Simplifies a mesh. Vertices and triangles keep their order, but for the other sides of triangles that are there back
/// to back in a whole part, which come last. Vertices at boundaries stay there; those of edges with more than two
/// triangles, and vertices that several fans of triangles share, are not moved. Without a limit of the deviation they
/// become fewer along the curves where sheets meet, in all sheets at once, and vertices around the largest deviations
/// are moved at the end, and edges turned, to make these smaller. Of inputs of up to 4,096 triangles with a border,
/// vertices are also put back there, and others collapsed instead, unless some are locked or have factors.
///
/// # Errors
/// Fails if there is no triangle, there are 2³⁰ triangles or points or more, a coordinate is not finite, an index is
/// too large, an option is not usable ([`SimplifyOptions::check`]), memory does not suffice, or `progress` asks to
/// stop.
pub fn simplify(
    context: &Context,
    points: &[[f32; 3]],
    triangles: &[[u32; 3]],
    options: &SimplifyOptions,
    progress: &mut dyn Progress,
) -> Result<Simplified> {
    check(context, points, triangles, options)?;
    watched(context, progress, |progress| {
        let is_less = options.target_triangles < triangles.len();
        let (doubles, parted) = context.join(
            || if is_less { Doubles::find(points.len(), triangles) } else { None },
            || OpenFans::part(points, triangles, &[]),
        );
        let sides = doubles.as_ref().map_or(triangles, |doubles| &doubles.triangles);
        let locked = options.fixed(triangles);
        let scale = unit(points);
        let doubles = doubles.as_ref();
        let whole = Whole { context, points, sides, doubles, locked: &locked, factors: &options.vertex_weights, scale };
        let parted = if doubles.is_some() { OpenFans::part(points, sides, &[]) } else { parted };
        let run = |limits: &Limits, progress: &mut dyn Progress| {
            let mut faces = doubles.map_or(options.target_triangles, |doubles| doubles.faces(options.target_triangles));
            let mut made = whole.simplify(&parted, limits, faces, progress)?;
            // Of parts with two sides in a mesh with others, more or fewer may have been left than their share.
            for _ in 1..TRIES {
                let count = made.0.len();
                let is_met = count <= options.target_triangles && count + 2 >= options.target_triangles;
                if doubles.is_none() || is_met || limits.error() < f32::INFINITY {
                    break;
                }
                let by = count.abs_diff(options.target_triangles).div_ceil(2);
                faces = if count > options.target_triangles { faces.saturating_sub(by) } else { faces + by };
                let mut again = |_: f32, stage: &str| progress.report(1.0, stage);
                let other = whole.simplify(&parted, limits, faces, &mut again)?;
                if other.0.len() <= options.target_triangles || other.0.len() < count {
                    made = other;
                }
            }
            Ok(finish(context, made, points, triangles, scale))
        };
        simplified_within(context, (points, triangles), options, progress, run)
    })
}

/// A mesh without the other sides of its triangles, and what stays in it.
struct Whole<'a> {
    context: &'a Context,
    points: &'a [[f32; 3]],
    sides: &'a [[u32; 3]],
    doubles: Option<&'a Doubles>,
    locked: &'a [u32],
    factors: &'a [f32],
    /// What coordinates are divided by.
    scale: f32,
}

impl Whole<'_> {
    /// Simplifies the mesh, whose fans are parted, to `faces` triangles within limits. Returns the triangles that are left,
    /// whose added vertices come after those of the input; and the places of all of them.
    fn simplify(
        &self,
        parted: &OpenFans,
        limits: &Limits,
        faces: usize,
        progress: &mut dyn Progress,
    ) -> Result<(Vec<[u32; 3]>, Vec<Vec4>)> {
        let mut reduced = self.reduce(parted, &HashMap::new(), limits, faces, progress)?;
        let is_unlimited = limits.error() == f32::INFINITY;
        if is_unlimited && self.may_have_curves(parted, &reduced) {
            let sheets = Sheets::find(self.points, self.sides, 1.0 / self.scale, self.locked);
            if let Some(mut sheets) = sheets.filter(|sheets| sheets.inner() > 0) {
                // A curve has as many vertices less as others of a surface with so many triangles.
                let mut inner = (sheets.inner() as f64 * (faces as f64 / self.sides.len() as f64).sqrt()) as usize;
                for tries in 1.. {
                    sheets.thin(inner);
                    let left = sheets.left();
                    let parted = OpenFans::part(self.points, &left, &sheets.vertices());
                    let mut again = |_: f32, stage: &str| progress.report(1.0, stage);
                    reduced = self.reduce(&parted, &sheets.deviations, limits, faces, &mut again)?;
                    if reduced.triangles.len() <= faces || inner == 0 || tries == TRIES {
                        return self.finished(&parted, reduced, faces, true);
                    }
                    inner /= 2;
                }
            }
        }
        self.finished(parted, reduced, faces, is_unlimited)
    }

    /// Collapses edges of the mesh, whose fans are parted and whose vertices deviate by so much.
    fn reduce(
        &self,
        parted: &OpenFans,
        deviations: &HashMap<u32, f32>,
        limits: &Limits,
        faces: usize,
        progress: &mut dyn Progress,
    ) -> Result<Reduced> {
        let mesh = (&*parted.points, &*parted.triangles);
        let fixed = [self.locked, &parted.shared].concat();
        let factors = parted.factors(self.factors);
        let mut pieces = Pieces::new(mesh, 1.0 / self.scale, (&factors, &fixed), limits);
        for vertex in &parted.shared {
            let place = &mut pieces.points[*vertex as usize];
            place.w = place.w.max(deviations.get(&parted.origin(*vertex)).copied().unwrap_or(0.0));
        }
        patches::reduce(self.context, pieces, faces, limits.error() / self.scale, progress)
    }

    /// Whether there may be edges that are not of two triangles in opposite directions, or of one.
    fn may_have_curves(&self, parted: &OpenFans, reduced: &Reduced) -> bool {
        let mut is_known = vec![false; reduced.is_locked.len()];
        self.locked.iter().for_each(|vertex| is_known[*vertex as usize] = true);
        !parted.shared.is_empty() || reduced.is_locked.iter().zip(&is_known).any(|(is, is_known)| *is && !is_known)
    }

    /// Brings outliers nearer if there are no limits, joins fans, and gives double parts their other sides back. Returns
    /// triangles and places.
    fn finished(
        &self,
        parted: &OpenFans,
        mut reduced: Reduced,
        faces: usize,
        is_unlimited: bool,
    ) -> Result<(Vec<[u32; 3]>, Vec<Vec4>)> {
        if is_unlimited {
            let mesh = (&*parted.points, &*parted.triangles);
            let fixed = [self.locked, &parted.shared].concat();
            outliers::lessen(self.context, mesh, 1.0 / self.scale, &fixed, &mut reduced);
        }
        let mut left = reduced.triangles;
        parted.join(&mut left, &reduced.joined);
        // Vertices are exchanged where none has to stay and none counts for more.
        if is_unlimited && self.locked.is_empty() && self.factors.is_empty() {
            exchange((self.points, self.sides), faces, self.scale, &mut left, &mut reduced.points)?;
        }
        if let Some(doubles) = self.doubles {
            let is_double = |it: &&[u32; 3]| doubles.is_double(parted.origin(it[0]));
            let others: Vec<[u32; 3]> = left.iter().filter(is_double).map(|[a, b, c]| [*a, *c, *b]).collect();
            left.extend(others);
        }
        Ok((left, reduced.points))
    }
}

/// A result of simplification with an error of its own.
pub trait Bounded {
    /// Returns the points and triangles.
    fn shape(&self) -> Triangles<'_>;

    /// Sets the largest deviation.
    fn set_error(&mut self, error: f32);
}

impl Bounded for Simplified {
    fn shape(&self) -> Triangles<'_> {
        (&self.points, &self.triangles)
    }

    fn set_error(&mut self, error: f32) {
        self.error = error;
    }
}

/// Calls `run` once, or as often as it takes to hold the bound of the distance if there is one.
pub fn simplified_within<T: Bounded>(
    context: &Context,
    input: Triangles,
    options: &SimplifyOptions,
    progress: &mut dyn Progress,
    mut run: impl FnMut(&Limits, &mut dyn Progress) -> Result<T>,
) -> Result<T> {
    if options.bound == f32::INFINITY {
        return run(&Limits::of(options.max_error), progress);
    }
    let limit = [options.bound, options.max_error];
    let (mut made, error) = error_bound::within(context, input, limit, progress, run, T::shape)?;
    made.set_error(error);
    Ok(made)
}

/// Returns the vertices of edges that have one triangle, some of them twice.
pub fn border(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for [a, b, c] in triangles {
        edges.extend([[a, b], [b, c], [c, a]].map(|[from, to]| [*from.min(to), *from.max(to)]));
    }
    edges.sort_unstable();
    edges.chunk_by(|one, other| one == other).filter(|edge| edge.len() == 1).flat_map(|edge| edge[0]).collect()
}

/// The power of two that coordinates are divided by: squares of areas then stay in the range of f32, and no digit changes.
pub fn unit(points: &[[f32; 3]]) -> f32 {
    // Bits of numbers without their signs are in the order of the numbers.
    let extent = points.iter().flatten().fold(0, |most, value| most.max(value.abs().to_bits() as i32));
    let extent = f32::from_bits(extent as u32);
    let exponent = if extent > 0.0 { extent.log2().ceil().clamp(-120.0, 120.0) } else { 0.0 };
    exponent.exp2()
}

/// Fails if a mesh, or what is asked of it, is not what [`simplify`] takes.
pub fn check(context: &Context, points: &[[f32; 3]], triangles: &[[u32; 3]], options: &SimplifyOptions) -> Result<()> {
    if triangles.is_empty() {
        return Err(Error::invalid("a mesh without triangles cannot be simplified").at("triangles"));
    }
    if triangles.len() > MAX || points.len() > MAX {
        return Err(Error::unsupported(format!("{} triangles are too many", triangles.len()))
            .at("triangles")
            .advise(format!("split the mesh into parts of at most {MAX}")));
    }
    check_memory(context, triangles.len().max(points.len()), 0)?;
    if let Some(index) = points.iter().position(|point| point.iter().any(|value| !value.is_finite())) {
        return Err(Error::invalid(format!("point {index} is not finite")).at("points"));
    }
    let outside = |index: &u32| *index as usize >= points.len();
    if let Some(index) = triangles.iter().position(|triangle| triangle.iter().any(outside)) {
        return Err(Error::invalid(format!("triangle {index} has a point that is not there")).at("triangles"));
    }
    options.check(points.len())
}

/// Fails if the structures of so many triangles, with `more` bytes for each than usual, do not fit.
pub fn check_memory(context: &Context, triangles: usize, more: u64) -> Result<()> {
    let bytes = (BYTES + more) * triangles as u64;
    if bytes > context.memory_limit() {
        return Err(Error::memory(format!("simplification needs {bytes} bytes, more than the memory limit"))
            .advise("raise the memory limit, or split the mesh"));
    }
    Ok(())
}

/// Collapses edges in rounds until a mesh has `faces` triangles, or none is left that deviates by at most `error`.
pub fn reduce<const Q: usize>(
    context: &Context,
    work: &mut Decimation<Q>,
    before: usize,
    faces: usize,
    error: f32,
    progress: &mut dyn Progress,
) -> Result<()> {
    work.parts = work.mesh.parts(context);
    let mut plan = Plan { share: SHARE, known: 0.0, ahead: f32::INFINITY };
    while work.live > faces && !work.recording.as_ref().is_some_and(Recording::is_full) {
        let done = (before - work.live) as f32 / (before - faces) as f32;
        progress.step(done, "simplify")?;
        if !plan.round(context, work, faces, error)? {
            break;
        }
    }
    progress.step(1.0, "simplify")
}

/// What the next round looks at.
struct Plan {
    /// The share of edges that are considered.
    share: f32,
    /// Costs below this are right.
    known: f32,
    /// Edges below this are looked at.
    ahead: f32,
}

impl Plan {
    /// Makes a round. Returns whether another may find something to collapse.
    fn round<const Q: usize>(
        &mut self,
        context: &Context,
        work: &mut Decimation<Q>,
        faces: usize,
        error: f32,
    ) -> Result<bool> {
        work.compact(context)?;
        let is_all = self.ahead == f32::INFINITY;
        let (edges, costs) = work.renew_costs(context, [self.known, self.ahead], error)?;
        let Some(wanted) = costs.below(self.share) else { return Ok(false) };
        let limit = wanted.min(self.ahead);
        let few = costs.share_below(limit) < FEW_SHARE * self.share;
        self.known = self.ahead.min(limit * AHEAD).min(f32::MAX);
        self.ahead = if few { wanted } else { limit } * AHEAD;
        let edges = if is_all { work.edges_below(context, limit) } else { edges };
        let collapses = work.select(context, edges, limit);
        if !work.apply(context, collapses, work.live - faces, self.known) && limit >= wanted {
            if self.share >= 1.0 {
                return Ok(false);
            }
            (self.share, self.ahead) = ((2.0 * self.share).min(1.0), f32::INFINITY);
        }
        Ok(true)
    }
}

/// The triangles that are left, and their points, in the order of the input, with points that no triangle had before.
fn finish(
    context: &Context,
    (left, points): (Vec<[u32; 3]>, Vec<Vec4>),
    before: &[[f32; 3]],
    triangles: &[[u32; 3]],
    scale: f32,
) -> Simplified {
    let lonely = || {
        let mut lonely = vec![true; before.len()];
        triangles.as_flattened().iter().for_each(|vertex| lonely[*vertex as usize] = false);
        before.iter().zip(lonely).filter(|(_, lonely)| *lonely).map(|(point, _)| *point).collect::<Vec<_>>()
    };
    let rest = || {
        let mut numbers = vec![NONE; points.len()];
        left.as_flattened().iter().for_each(|vertex| numbers[*vertex as usize] = 0);
        let mut made = Simplified { points: Vec::with_capacity(left.len()), triangles: left, error: 0.0 };
        for (number, point) in numbers.iter_mut().zip(&points).filter(|(number, _)| **number == 0) {
            *number = made.points.len() as u32;
            made.points.push((point.truncate() * scale).to_array());
            made.error = made.error.max(point.w * scale);
        }
        made.triangles.as_flattened_mut().iter_mut().for_each(|vertex| *vertex = numbers[*vertex as usize]);
        made
    };
    let (mut made, lonely) = context.join(rest, lonely);
    made.points.extend(lonely);
    made
}
