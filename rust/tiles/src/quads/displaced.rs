//! The displaced surface `P' = S + D·N + V` and its analytic normal.
//!
//! Nießner and Loop 2013, Analytic Displacement Mapping using Hardware Tessellation, Section 4: the normal is that of
//! `P'_u = S_u + D_u·N + D·N_u` and `P'_v`, where `N_u` comes from the second derivatives of the surface. A vector
//! displacement `V = a·T + b·B + c·N` in the frame of [`crate::quads::frame`] has derivatives of the same order: with `T_u =
//! (S_uu − T (T·S_uu))/|S_u|` and `B_u = N_u × T + N × T_u`, nothing above second derivatives is needed. Points on
//! edges and vertices are evaluated at their canonical place, so that they are equal to the bit whichever tile is
//! asked, allocated or not. Units: object units; normals have length 1.
//!
//! Where the tangents of the surface vanish or are parallel (at the corner of a smooth border, say) `N` is taken a
//! little further inside the tile, and so is the displaced normal. A place that has no normal there either stays
//! undisplaced and gets the normal (0, 0, 1), as do places in holes.

use std::cell::RefCell;

use glam::Vec3;
use relievo_core::simd::{Arithmetic, Level};
use relievo_core::{Context, Error, Result, dispatch_simd};
use relievo_surface::{Grid, Order, Place, Placement, Samples, Surface};

use crate::quads::field::Field;
use crate::quads::spline::{self, Jet, Jets};
use crate::texel::Vector;

/// Points of a displaced surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    /// Positions.
    pub p: Vec<[f32; 3]>,
    /// Unit normals.
    pub normal: Vec<[f32; 3]>,
}

impl Points {
    fn reset(&mut self, count: usize) {
        for list in [&mut self.p, &mut self.normal] {
            list.clear();
            list.resize(count, [0.0; 3]);
        }
    }
}

/// A surface with its displacements.
#[derive(Clone, Copy, Debug)]
pub struct Displaced<'a> {
    surface: &'a Surface,
    field: &'a Field,
    vectors: Option<&'a Field<Vector>>,
}

/// What a tile is displaced by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Still,
    Scalar,
    Vector,
}

impl Kind {
    /// Second derivatives are only needed where there is displacement.
    fn order(self) -> Order {
        if self == Kind::Still { Order::First } else { Order::Second }
    }
}

/// Room for what is computed on the way, which threads keep, so that calls for few places do not ask for memory each.
/// It is bounded: by [`CHUNK`] places, or [`ROWS`] rows of a grid and its border.
#[derive(Default)]
struct Scratch {
    samples: Samples,
    jets: JetLists,
    points: Points,
    indices: Vec<usize>,
    chosen: Vec<Place>,
    vector: [Jets; 3],
    us: Vec<f32>,
    vs: Vec<f32>,
}

thread_local! {
    static KEPT: RefCell<Vec<Scratch>> = const { RefCell::new(Vec::new()) };
}

impl Scratch {
    /// Calls `work` with room that nothing else uses meanwhile.
    fn with<R>(work: impl FnOnce(&mut Self) -> R) -> R {
        let mut scratch = KEPT.with_borrow_mut(Vec::pop).unwrap_or_default();
        let result = work(&mut scratch);
        KEPT.with_borrow_mut(|kept| kept.push(scratch));
        result
    }
}

/// Places per item of parallel work.
const CHUNK: usize = 1024;
/// Rows of a grid computed together.
const ROWS: u32 = 16;

impl<'a> Displaced<'a> {
    /// `surface` displaced by `field`.
    ///
    /// # Errors
    /// Fails if the field belongs to a cage with other tiles.
    pub fn new(surface: &'a Surface, field: &'a Field) -> Result<Self> {
        if surface.tile_count() != field.tile_count() {
            return Err(Error::invalid(format!(
                "the surface has {} tiles, its displacement {}",
                surface.tile_count(),
                field.tile_count()
            ))
            .advise("make the displacement from the topology of this surface"));
        }
        Ok(Self { surface, field, vectors: None })
    }

    /// Displaced by `vectors` as well, after the scalar displacement.
    ///
    /// # Errors
    /// Fails if the vectors belong to a cage with other tiles.
    pub fn with_vectors(self, vectors: &'a Field<Vector>) -> Result<Self> {
        if self.surface.tile_count() != vectors.tile_count() {
            return Err(Error::invalid(format!(
                "the surface has {} tiles, its vector displacement {}",
                self.surface.tile_count(),
                vectors.tile_count()
            ))
            .advise("make the displacement from this surface"));
        }
        Ok(Self { vectors: Some(vectors), ..self })
    }

    /// The surface that is displaced.
    pub fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// The displacements.
    pub fn field(&self) -> &'a Field {
        self.field
    }

    /// The vector displacements, if there are any.
    pub fn vectors(&self) -> Option<&'a Field<Vector>> {
        self.vectors
    }

    /// The one place at which `place` is evaluated: the tile that is coarsest in all displacements.
    pub fn canonical(&self, place: Place) -> Place {
        let density = |tile: u32| self.field.density(tile) + self.vectors.map_or(0, |vectors| vectors.density(tile));
        self.field.topology().canonical(place, density)
    }

    fn kind(&self, tile: u32) -> Kind {
        match (self.vectors.is_some_and(|vectors| vectors.is_allocated(tile)), self.field.is_allocated(tile)) {
            (true, _) => Kind::Vector,
            (false, true) => Kind::Scalar,
            (false, false) => Kind::Still,
        }
    }

    /// Bounds of the displaced surface over `tile`, conservative: where hosts refit after a commit.
    ///
    /// # Panics
    /// If there is no such tile.
    pub fn tile_bounds(&self, tile: u32) -> ([f32; 3], [f32; 3]) {
        let (low, high) = self.surface.tile_bounds(tile);
        let [least, most] = self.field.range(tile);
        // Edges may be evaluated in a neighbour, whose patches and coefficients are rounded apart from these.
        let longest = self.vectors.map_or(0.0, |vectors| vectors.length(tile));
        let reach = 1.001 * (least.abs().max(most.abs()) + longest) + 1e-6 * self.surface.extent();
        (low.map(|value| value - reach), high.map(|value| value + reach))
    }

    /// Positions and normals at many places.
    ///
    /// # Errors
    /// Fails, without touching `out`, if a tile does not exist or u or v is outside 0 to 1.
    pub fn evaluate(&self, context: &Context, places: &[Place], out: &mut Points) -> Result<()> {
        for (index, place) in places.iter().enumerate() {
            let inside = (0.0..=1.0).contains(&place.u) && (0.0..=1.0).contains(&place.v);
            if place.tile as usize >= self.field.tile_count() || !inside {
                return Err(Error::invalid(format!("{place:?} is not on the surface")).at(format!("place {index}")));
            }
        }
        let canonical = places.iter().map(|place| self.canonical(*place));
        if places.len() > CHUNK {
            let mut chosen = context.scratch().lend::<Vec<Place>>();
            chosen.clear();
            chosen.extend(canonical);
            return self.evaluate_in_place(context, &chosen, out);
        }
        Scratch::with(|scratch| {
            scratch.chosen.clear();
            scratch.chosen.extend(canonical);
            self.evaluate_in_place(context, &scratch.chosen, out)
        })
    }

    /// As [`Self::evaluate`], in the very tiles that `places` name: give it canonical ones, or want a side's own
    /// normal.
    ///
    /// # Errors
    /// Fails if a place is not on the surface.
    pub fn evaluate_in_place(&self, context: &Context, places: &[Place], out: &mut Points) -> Result<()> {
        out.reset(places.len());
        let parts = (places, out.p.as_mut_slice(), out.normal.as_mut_slice());
        context.for_each_part(parts, CHUNK, |_, (places, p, normal)| self.evaluate_chunk(context, places, p, normal))
    }

    fn evaluate_chunk(
        &self,
        context: &Context,
        places: &[Place],
        p: &mut [[f32; 3]],
        normal: &mut [[f32; 3]],
    ) -> Result<()> {
        let level = context.level();
        Scratch::with(|scratch| {
            let Scratch { samples, jets, points, indices, chosen, .. } = scratch;
            for kind in [Kind::Still, Kind::Scalar, Kind::Vector] {
                indices.clear();
                indices.extend((0..places.len()).filter(|index| self.kind(places[*index].tile) == kind));
                chosen.clear();
                chosen.extend(indices.iter().map(|index| places[*index]));
                if chosen.is_empty() {
                    continue;
                }
                self.surface.evaluate(context, chosen, kind.order(), samples)?;
                jets.reset(chosen.len(), kind);
                for (i, place) in chosen.iter().enumerate() {
                    jets.set(i, self.jets(level, *place, kind));
                }
                points.reset(chosen.len());
                jets.displace(level, samples, &mut points.p, &mut points.normal);
                for (i, index) in indices.iter().enumerate() {
                    let index = *index;
                    (p[index], normal[index]) = (points.p[i], points.normal[i]);
                    if normal[index] == [0.0; 3] {
                        (p[index], normal[index]) = self.singular(context, places[index], p[index], true)?;
                    }
                }
            }
            Ok(())
        })
    }

    /// Along the normal, along T and along B, at a place.
    fn jets(&self, level: Level, place: Place, kind: Kind) -> [Jet; 3] {
        let scalar = if kind == Kind::Still { Jet::default() } else { self.field.point(level, place) };
        match self.vectors.filter(|_| kind == Kind::Vector) {
            Some(vectors) => {
                let [along, across, up] = vectors.vector(level, place);
                let scalar = Jet { d: scalar.d + up.d, du: scalar.du + up.du, dv: scalar.dv + up.dv, ..scalar };
                [scalar, along, across]
            }
            None => [scalar, Jet::default(), Jet::default()],
        }
    }

    /// Position and normal at a place.
    ///
    /// # Errors
    /// Fails if the tile does not exist or u or v is outside 0 to 1.
    pub fn sample(&self, context: &Context, place: Place) -> Result<([f32; 3], [f32; 3])> {
        let mut points = Points::default();
        self.evaluate(context, &[place], &mut points)?;
        Ok((points.p[0], points.normal[0]))
    }

    /// Positions and normals on a grid of `tile`: sample (i, j) has the index
    /// `(j − rows.start) · columns.len() + i − columns.start`. Points on the tile's edges are the canonical ones.
    ///
    /// # Errors
    /// Fails, without touching `out`, if the tile does not exist or the grid is larger than its size says.
    pub fn grid(&self, context: &Context, tile: u32, grid: &Grid, out: &mut Points) -> Result<()> {
        let limit = grid.size + u32::from(grid.placement == Placement::Lattice);
        if tile as usize >= self.field.tile_count() || grid.columns.end > limit || grid.rows.end > limit {
            return Err(Error::invalid(format!("{grid:?} is not a grid of a tile")).at(format!("tile {tile}")));
        }
        Scratch::with(|scratch| self.grid_with(context, tile, grid, out, scratch))
    }

    fn grid_with(
        &self,
        context: &Context,
        tile: u32,
        grid: &Grid,
        out: &mut Points,
        scratch: &mut Scratch,
    ) -> Result<()> {
        let level = context.level();
        let kind = self.kind(tile);
        let Scratch { samples, jets, points, indices, chosen, vector, us, vs } = scratch;
        for (parameters, range) in [(&mut *us, &grid.columns), (&mut *vs, &grid.rows)] {
            parameters.clear();
            parameters.extend(range.clone().map(|i| grid.parameter(i)));
        }
        out.reset(grid.len());
        // A few rows at a time, so that what lies between the steps stays in the cache.
        for first in grid.rows.clone().step_by(ROWS as usize) {
            let rows = first..(first + ROWS).min(grid.rows.end);
            let part = Grid { rows: rows.clone(), ..grid.clone() };
            self.surface.grid(level, tile, &part, kind.order(), samples);
            let vs = &vs[(rows.start - grid.rows.start) as usize..][..rows.len()];
            jets.reset(part.len(), kind);
            if let Some(block) = self.field.block(tile) {
                spline::grid(level, block, self.field.size(tile), us, vs, Order::First, &mut jets.up);
            }
            if let Some((vectors, block)) = self.vectors.and_then(|vectors| Some((vectors, vectors.block(tile)?))) {
                spline::vector_grid(level, block, vectors.size(tile), us, vs, Order::First, vector);
                jets.take(vector);
            }
            let span = (rows.start - grid.rows.start) as usize * us.len()..;
            let (p, normal) = (&mut out.p[span.clone()][..part.len()], &mut out.normal[span][..part.len()]);
            jets.displace(level, samples, p, normal);
        }
        // Points on edges, and places without a normal.
        let is_end = |t: f32| t == 0.0 || t == 1.0;
        chosen.clear();
        indices.clear();
        for (j, v) in vs.iter().enumerate() {
            for (i, u) in us.iter().enumerate() {
                let (index, place) = (j * us.len() + i, Place::new(tile, *u, *v));
                if is_end(*u) || is_end(*v) {
                    indices.push(index);
                    chosen.push(self.canonical(place));
                } else if out.normal[index] == [0.0; 3] {
                    // Only where the tangents fail inside a tile, which cages with collapsed edges do.
                    (out.p[index], out.normal[index]) = self.singular(context, place, out.p[index], true)?;
                }
            }
        }
        self.evaluate_in_place(context, chosen, points)?;
        for (index, (p, normal)) in indices.iter().zip(points.p.iter().zip(&points.normal)) {
            (out.p[*index], out.normal[*index]) = (*p, *normal);
        }
        Ok(())
    }

    /// Position and normal where the tangents at `place` give no normal, from a place nearer to the tile's centre.
    fn singular(&self, context: &Context, place: Place, p: [f32; 3], again: bool) -> Result<([f32; 3], [f32; 3])> {
        let step = if again { 1.0 / 1024.0 } else { 1.0 / 16.0 };
        let inner = Place::new(place.tile, place.u + (0.5 - place.u) * step, place.v + (0.5 - place.v) * step);
        let mut samples = Samples::default();
        self.surface.evaluate(context, &[inner], Order::Second, &mut samples)?;
        let (level, kind) = (context.level(), self.kind(place.tile));
        let mut jets = JetLists::default();
        jets.reset(1, kind);
        // The displacement is that of the place itself; where T, B and N point is all that is taken from further
        // inside.
        let (here, there) = (self.jets(level, place, kind), self.jets(level, inner, kind));
        let (mut moved, mut base) = ([[0.0; 3]], [[0.0; 3]]);
        jets.displace(level, &samples, &mut moved, &mut base);
        if base[0] == [0.0; 3] {
            return if again { self.singular(context, place, p, false) } else { Ok((p, [0.0, 0.0, 1.0])) };
        }
        jets.set(0, there);
        let mut normal = [[0.0; 3]];
        jets.displace(level, &samples, &mut moved, &mut normal);
        let n = Vec3::from(base[0]);
        let t = Vec3::from(samples.du.each_ref().map(|values| values[0])).normalize_or_zero();
        let [up, along, across] = here.map(|jet| jet.d);
        let p = match kind {
            Kind::Vector => (Vec3::from(p) + up * n + along * t + across * n.cross(t)).to_array(),
            _ => std::array::from_fn(|axis| p[axis] + up * base[0][axis]),
        };
        Ok((p, normal[0]))
    }
}

/// Displacements of many samples: along the normal, and along T and B where there are vectors.
#[derive(Default)]
struct JetLists {
    up: Jets,
    /// Empty without vectors.
    along: Jets,
    across: Jets,
}

impl JetLists {
    /// Zeros.
    fn reset(&mut self, count: usize, kind: Kind) {
        self.up.reset(count, Order::First);
        let count = if kind == Kind::Vector { count } else { 0 };
        self.along.reset(count, Order::First);
        self.across.reset(count, Order::First);
    }

    fn set(&mut self, index: usize, jets: [Jet; 3]) {
        for (list, jet) in [&mut self.up, &mut self.along, &mut self.across].into_iter().zip(jets) {
            if let Some(d) = list.d.get_mut(index) {
                (*d, list.du[index], list.dv[index]) = (jet.d, jet.du, jet.dv);
            }
        }
    }

    /// Adds vectors to scalars, and leaves something else in their lists.
    fn take(&mut self, vector: &mut [Jets; 3]) {
        let [along, across, up] = vector;
        std::mem::swap(along, &mut self.along);
        std::mem::swap(across, &mut self.across);
        let lists = [(&mut self.up.d, &up.d), (&mut self.up.du, &up.du), (&mut self.up.dv, &up.dv)];
        for (sum, more) in lists {
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        }
    }

    fn displace(&self, level: Level, samples: &Samples, p: &mut [[f32; 3]], normal: &mut [[f32; 3]]) {
        if self.along.d.is_empty() {
            displace(level, samples, &self.up, p, normal);
        } else {
            displace_by_vector(level, samples, self, p, normal);
        }
    }
}

dispatch_simd! {
    /// Displaces samples along their normals. Where there is no normal, it is zero and the position undisplaced.
    fn displace = displace_body(
        samples: &Samples, jets: &Jets, p: &mut [[f32; 3]], normal: &mut [[f32; 3]]
    )
}

dispatch_simd! {
    /// As [`displace`], and by vectors.
    fn displace_by_vector = displace_by_vector_body(
        samples: &Samples, jets: &JetLists, p: &mut [[f32; 3]], normal: &mut [[f32; 3]]
    )
}

/// Samples computed together, in registers.
const LANES: usize = 16;

type Lanes = [f32; LANES];

#[inline(always)]
fn displace_body<A: Arithmetic>(_: A, samples: &Samples, jets: &Jets, p: &mut [[f32; 3]], normal: &mut [[f32; 3]]) {
    displace_of::<A, 1>(samples, [jets], p, normal);
}

#[inline(always)]
fn displace_by_vector_body<A: Arithmetic>(
    _: A,
    samples: &Samples,
    jets: &JetLists,
    p: &mut [[f32; 3]],
    normal: &mut [[f32; 3]],
) {
    displace_of::<A, 3>(samples, [&jets.up, &jets.along, &jets.across], p, normal);
}

/// Displaces by `DIRECTIONS` jets a sample: along N alone, or along N, T and B.
#[inline(always)]
fn displace_of<A: Arithmetic, const DIRECTIONS: usize>(
    samples: &Samples,
    jets: [&Jets; DIRECTIONS],
    p: &mut [[f32; 3]],
    normal: &mut [[f32; 3]],
) {
    let quantities = [&samples.p, &samples.du, &samples.dv, &samples.duu, &samples.duv, &samples.dvv];
    let mut input = [[[0.0; LANES]; 3]; 6];
    let mut jet = [[[0.0; LANES]; 3]; DIRECTIONS];
    let mut output = [[[0.0; LANES]; 3]; 2];
    for (block, (p, normal)) in p.chunks_mut(LANES).zip(normal.chunks_mut(LANES)).enumerate() {
        let (at, count) = (block * LANES, p.len());
        for (lanes, quantity) in input.iter_mut().zip(quantities) {
            // Quantities that were not evaluated stay zero.
            for (lanes, values) in lanes.iter_mut().zip(quantity).filter(|(_, values)| !values.is_empty()) {
                load(lanes, &values[at..at + count]);
            }
        }
        for (jet, jets) in jet.iter_mut().zip(jets) {
            for (lanes, values) in jet.iter_mut().zip([&jets.d, &jets.du, &jets.dv]) {
                load(lanes, &values[at..at + count]);
            }
        }
        displace_lanes::<A, DIRECTIONS>(&input, &jet, &mut output);
        for i in 0..count {
            p[i] = std::array::from_fn(|axis| output[0][axis][i]);
            normal[i] = std::array::from_fn(|axis| output[1][axis][i]);
        }
    }
}

/// Copies up to [`LANES`] values; the usual full block is one move of known size.
#[inline(always)]
fn load(lanes: &mut Lanes, values: &[f32]) {
    match values.try_into() {
        Ok(full) => *lanes = full,
        Err(_) => lanes[..values.len()].copy_from_slice(values),
    }
}

/// The sine of the angle between the tangents at and below which they count as parallel, squared.
const PARALLEL: f32 = 1e-12;

// No fused arithmetic in cross products: those of parallel vectors must vanish.
#[inline(always)]
fn displace_lanes<A: Arithmetic, const DIRECTIONS: usize>(
    input: &[[Lanes; 3]; 6],
    jet: &[[Lanes; 3]; DIRECTIONS],
    output: &mut [[Lanes; 3]; 2],
) {
    let cross = |a: [f32; 3], b: [f32; 3]| -> [f32; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let sum = |a: [f32; 3], b: [f32; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let scale = |a: [f32; 3], s: f32| [a[0] * s, a[1] * s, a[2] * s];
    for i in 0..LANES {
        let at = |k: usize| [input[k][0][i], input[k][1][i], input[k][2][i]];
        let (p, u, v, uu, uv, vv) = (at(0), at(1), at(2), at(3), at(4), at(5));
        let (d, d_u, d_v) = (jet[0][0][i], jet[0][1][i], jet[0][2][i]);
        let m = cross(u, v);
        let area = dot(m, m);
        let regular = area > PARALLEL * dot(u, u) * dot(v, v);
        let inverse = if regular { 1.0 / area.sqrt() } else { 0.0 };
        let n = scale(m, inverse);
        // The derivative of m/|m| is the part of m' across n, over |m|.
        let turn = |a: [f32; 3]| scale(sum(a, scale(n, -dot(n, a))), inverse);
        let n_u = turn(sum(cross(uu, v), cross(u, uv)));
        let n_v = turn(sum(cross(uv, v), cross(u, vv)));
        let mut p_u = sum(u, sum(scale(n, d_u), scale(n_u, d)));
        let mut p_v = sum(v, sum(scale(n, d_v), scale(n_v, d)));
        let mut moved: [f32; 3] = std::array::from_fn(|axis| A::fma(d, n[axis], p[axis]));
        if DIRECTIONS == 3 {
            let [(a, a_u, a_v), (b, b_u, b_v)] = [1, 2].map(|k| (jet[k][0][i], jet[k][1][i], jet[k][2][i]));
            let inverse = if regular { 1.0 / dot(u, u).sqrt() } else { 0.0 };
            let t = scale(u, inverse);
            let turn = |a: [f32; 3]| scale(sum(a, scale(t, -dot(t, a))), inverse);
            let (t_u, t_v) = (turn(uu), turn(uv));
            let across = cross(n, t);
            let across_u = sum(cross(n_u, t), cross(n, t_u));
            let across_v = sum(cross(n_v, t), cross(n, t_v));
            let tangential = |a: f32, t: [f32; 3], b: f32, across: [f32; 3]| sum(scale(t, a), scale(across, b));
            p_u = sum(p_u, sum(tangential(a_u, t, b_u, across), tangential(a, t_u, b, across_u)));
            p_v = sum(p_v, sum(tangential(a_v, t, b_v, across), tangential(a, t_v, b, across_v)));
            moved = sum(moved, tangential(a, t, b, across));
        }
        let facing = cross(p_u, p_v);
        let length = dot(facing, facing);
        let upright = length > PARALLEL * dot(p_u, p_u) * dot(p_v, p_v) && length < f32::INFINITY;
        let inverse = if upright { 1.0 / length.sqrt() } else { 1.0 };
        for axis in 0..3 {
            output[0][axis][i] = moved[axis];
            output[1][axis][i] = if upright { facing[axis] * inverse } else { n[axis] };
        }
    }
}
