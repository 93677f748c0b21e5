//! The displaced surface `P' = S + D·N` and its analytic normal.
//!
//! Nießner and Loop 2013, Analytic Displacement Mapping using Hardware Tessellation, Section 4: the normal is that of
//! `P'_u = S_u + D_u·N + D·N_u` and `P'_v`, where `N_u` comes from the second derivatives of the surface. Points on
//! edges and vertices are evaluated at their canonical place, so that they are equal to the bit whichever tile is
//! asked, allocated or not. Units: object units; normals have length 1.
//!
//! Where the tangents of the surface vanish or are parallel (at the corner of a smooth border, say) `N` is taken a
//! little further inside the tile, and so is the displaced normal. A place that has no normal there either stays
//! undisplaced and gets the normal (0, 0, 1), as do places in holes.

use relievo_core::simd::Arithmetic;
use relievo_core::{Context, Error, Result, dispatch_simd};
use relievo_surface::{Grid, Order, Place, Placement, Samples, Surface};

use crate::field::Field;
use crate::spline::{self, Jets};

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
}

/// Places per item of parallel work.
const CHUNK: usize = 1024;
/// Rows of a grid computed together.
const ROWS: u32 = 16;

impl<'a> Displaced<'a> {
    /// `surface` displaced by `field`. Fails if the field belongs to a cage with other tiles.
    pub fn new(surface: &'a Surface, field: &'a Field) -> Result<Self> {
        if surface.tile_count() != field.tile_count() {
            return Err(Error::invalid(format!(
                "the surface has {} tiles, its displacement {}",
                surface.tile_count(),
                field.tile_count()
            ))
            .advise("make the displacement from the topology of this surface"));
        }
        Ok(Self { surface, field })
    }

    /// The surface that is displaced.
    pub fn surface(&self) -> &'a Surface {
        self.surface
    }

    /// The displacements.
    pub fn field(&self) -> &'a Field {
        self.field
    }

    /// Bounds of the displaced surface over `tile`, conservative: where hosts refit after a commit.
    ///
    /// # Panics
    /// If there is no such tile.
    pub fn tile_bounds(&self, tile: u32) -> ([f32; 3], [f32; 3]) {
        let (low, high) = self.surface.tile_bounds(tile);
        let [least, most] = self.field.range(tile);
        // Edges may be evaluated in a neighbour, whose patches and coefficients are rounded apart from these.
        let reach = 1.001 * least.abs().max(most.abs()) + 1e-6 * self.surface.extent();
        (low.map(|value| value - reach), high.map(|value| value + reach))
    }

    /// Positions and normals at many places. Fails, without touching `out`, if a tile does not exist or u or v is
    /// outside 0 to 1.
    pub fn evaluate(&self, context: &Context, places: &[Place], out: &mut Points) -> Result<()> {
        for (index, place) in places.iter().enumerate() {
            let inside = (0.0..=1.0).contains(&place.u) && (0.0..=1.0).contains(&place.v);
            if place.tile as usize >= self.field.tile_count() || !inside {
                return Err(Error::invalid(format!("{place:?} is not on the surface")).at(format!("place {index}")));
            }
        }
        let canonical: Vec<Place> = places.iter().map(|place| self.field.canonical(*place)).collect();
        self.evaluate_in_place(context, &canonical, out)
    }

    /// As [`Self::evaluate`], in the very tiles that `places` name: give it canonical ones, or want a side's own normal.
    /// Fails if a place is not on the surface.
    pub fn evaluate_in_place(&self, context: &Context, places: &[Place], out: &mut Points) -> Result<()> {
        out.reset(places.len());
        let lists = out.p.chunks_mut(CHUNK).zip(out.normal.chunks_mut(CHUNK));
        let mut chunks: Vec<_> = places.chunks(CHUNK).zip(lists).map(|chunk| (chunk, Ok(()))).collect();
        context.for_each_mut(&mut chunks, |_, ((places, (p, normal)), result)| {
            *result = self.evaluate_chunk(context, places, p, normal);
        });
        chunks.into_iter().try_for_each(|(_, result)| result)
    }

    fn evaluate_chunk(
        &self,
        context: &Context,
        places: &[Place],
        p: &mut [[f32; 3]],
        normal: &mut [[f32; 3]],
    ) -> Result<()> {
        // Second derivatives are only needed where there is displacement.
        let (displaced, still): (Vec<usize>, Vec<usize>) =
            (0..places.len()).partition(|index| self.field.is_allocated(places[*index].tile));
        let level = context.level();
        let (mut samples, mut jets, mut points) = (Samples::default(), Jets::default(), Points::default());
        for (indices, order) in [(displaced, Order::Second), (still, Order::First)] {
            let chosen: Vec<Place> = indices.iter().map(|index| places[*index]).collect();
            self.surface.evaluate(context, &chosen, order, &mut samples)?;
            jets.reset(chosen.len(), Order::First);
            if order == Order::Second {
                for (i, place) in chosen.iter().enumerate() {
                    let jet = self.field.point(level, *place);
                    (jets.d[i], jets.du[i], jets.dv[i]) = (jet.d, jet.du, jet.dv);
                }
            }
            points.reset(chosen.len());
            displace(level, &samples, &jets, &mut points.p, &mut points.normal);
            for (i, index) in indices.into_iter().enumerate() {
                (p[index], normal[index]) = (points.p[i], points.normal[i]);
                if normal[index] == [0.0; 3] {
                    (p[index], normal[index]) = self.singular(context, places[index], p[index], true)?;
                }
            }
        }
        Ok(())
    }

    /// Position and normal at a place. Fails if the tile does not exist or u or v is outside 0 to 1.
    pub fn sample(&self, context: &Context, place: Place) -> Result<([f32; 3], [f32; 3])> {
        let mut points = Points::default();
        self.evaluate(context, &[place], &mut points)?;
        Ok((points.p[0], points.normal[0]))
    }

    /// Positions and normals on a grid of `tile`: sample (i, j) has the index
    /// `(j − rows.start) · columns.len() + i − columns.start`. Points on the tile's edges are the canonical ones.
    ///
    /// Fails, without touching `out`, if the tile does not exist or the grid is larger than its size says.
    pub fn grid(&self, context: &Context, tile: u32, grid: &Grid, out: &mut Points) -> Result<()> {
        let limit = grid.size + u32::from(grid.placement == Placement::Lattice);
        if tile as usize >= self.field.tile_count() || grid.columns.end > limit || grid.rows.end > limit {
            return Err(Error::invalid(format!("{grid:?} is not a grid of a tile")).at(format!("tile {tile}")));
        }
        let level = context.level();
        let order = if self.field.is_allocated(tile) { Order::Second } else { Order::First };
        let parameters = |range: &std::ops::Range<u32>| range.clone().map(|i| grid.parameter(i)).collect::<Vec<f32>>();
        let (us, vs) = (parameters(&grid.columns), parameters(&grid.rows));
        let (mut samples, mut jets) = (Samples::default(), Jets::default());
        out.reset(grid.len());
        // A few rows at a time, so that what lies between the steps stays in the cache.
        for first in grid.rows.clone().step_by(ROWS as usize) {
            let rows = first..(first + ROWS).min(grid.rows.end);
            let part = Grid { rows: rows.clone(), ..grid.clone() };
            self.surface.grid(level, tile, &part, order, &mut samples);
            let vs = &vs[(rows.start - grid.rows.start) as usize..][..rows.len()];
            match self.field.block(tile) {
                Some(block) => {
                    spline::grid(level, block, self.field.size(tile), &us, vs, Order::First, &mut jets);
                }
                None => jets.reset(part.len(), Order::First),
            }
            let span = (rows.start - grid.rows.start) as usize * us.len()..;
            let (p, normal) = (&mut out.p[span.clone()][..part.len()], &mut out.normal[span][..part.len()]);
            displace(level, &samples, &jets, p, normal);
        }
        // Points on edges, and places without a normal.
        let is_end = |t: f32| t == 0.0 || t == 1.0;
        let (mut borders, mut indices) = (Vec::new(), Vec::new());
        for (j, v) in vs.iter().enumerate() {
            for (i, u) in us.iter().enumerate() {
                let (index, place) = (j * us.len() + i, Place::new(tile, *u, *v));
                if is_end(*u) || is_end(*v) {
                    indices.push(index);
                    borders.push(self.field.canonical(place));
                } else if out.normal[index] == [0.0; 3] {
                    // Only where the tangents fail inside a tile, which cages with collapsed edges do.
                    (out.p[index], out.normal[index]) = self.singular(context, place, out.p[index], true)?;
                }
            }
        }
        let mut points = Points::default();
        self.evaluate_in_place(context, &borders, &mut points)?;
        for (index, (p, normal)) in indices.into_iter().zip(points.p.into_iter().zip(points.normal)) {
            (out.p[index], out.normal[index]) = (p, normal);
        }
        Ok(())
    }

    /// Position and normal where the tangents at `place` give no normal, from a place nearer to the tile's centre.
    fn singular(&self, context: &Context, place: Place, p: [f32; 3], again: bool) -> Result<([f32; 3], [f32; 3])> {
        let step = if again { 1.0 / 1024.0 } else { 1.0 / 16.0 };
        let inner = Place::new(place.tile, place.u + (0.5 - place.u) * step, place.v + (0.5 - place.v) * step);
        let mut samples = Samples::default();
        self.surface.evaluate(context, &[inner], Order::Second, &mut samples)?;
        let level = context.level();
        let mut jets = Jets::default();
        jets.reset(1, Order::First);
        // The displacement is that of the place itself; where N points is all that is taken from further inside.
        let (here, there) = (self.field.point(level, place), self.field.point(level, inner));
        let (mut moved, mut base) = ([[0.0; 3]], [[0.0; 3]]);
        displace(level, &samples, &jets, &mut moved, &mut base);
        if base[0] == [0.0; 3] {
            return if again { self.singular(context, place, p, false) } else { Ok((p, [0.0, 0.0, 1.0])) };
        }
        (jets.d[0], jets.du[0], jets.dv[0]) = (there.d, there.du, there.dv);
        let mut normal = [[0.0; 3]];
        displace(level, &samples, &jets, &mut moved, &mut normal);
        Ok((std::array::from_fn(|axis| p[axis] + here.d * base[0][axis]), normal[0]))
    }
}

dispatch_simd! {
    /// Displaces samples. Where there is no normal, it is zero and the position undisplaced.
    fn displace = displace_body(
        samples: &Samples, jets: &Jets, p: &mut [[f32; 3]], normal: &mut [[f32; 3]]
    )
}

/// Samples computed together, in registers.
const LANES: usize = 16;

type Lanes = [f32; LANES];

#[inline(always)]
fn displace_body<A: Arithmetic>(samples: &Samples, jets: &Jets, p: &mut [[f32; 3]], normal: &mut [[f32; 3]]) {
    let quantities = [&samples.p, &samples.du, &samples.dv, &samples.duu, &samples.duv, &samples.dvv];
    let mut input = [[[0.0; LANES]; 3]; 6];
    let mut jet = [[0.0; LANES]; 3];
    let mut output = [[[0.0; LANES]; 3]; 2];
    for (block, (p, normal)) in p.chunks_mut(LANES).zip(normal.chunks_mut(LANES)).enumerate() {
        let (at, count) = (block * LANES, p.len());
        for (lanes, quantity) in input.iter_mut().zip(quantities) {
            // Quantities that were not evaluated stay zero.
            for (lanes, values) in lanes.iter_mut().zip(quantity).filter(|(_, values)| !values.is_empty()) {
                load(lanes, &values[at..at + count]);
            }
        }
        for (lanes, values) in jet.iter_mut().zip([&jets.d, &jets.du, &jets.dv]) {
            load(lanes, &values[at..at + count]);
        }
        displace_lanes::<A>(&input, &jet, &mut output);
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
fn displace_lanes<A: Arithmetic>(input: &[[Lanes; 3]; 6], jet: &[Lanes; 3], output: &mut [[Lanes; 3]; 2]) {
    let cross = |a: [f32; 3], b: [f32; 3]| -> [f32; 3] {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let sum = |a: [f32; 3], b: [f32; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let scale = |a: [f32; 3], s: f32| [a[0] * s, a[1] * s, a[2] * s];
    for i in 0..LANES {
        let at = |k: usize| [input[k][0][i], input[k][1][i], input[k][2][i]];
        let (p, u, v, uu, uv, vv) = (at(0), at(1), at(2), at(3), at(4), at(5));
        let (d, d_u, d_v) = (jet[0][i], jet[1][i], jet[2][i]);
        let m = cross(u, v);
        let area = dot(m, m);
        let regular = area > PARALLEL * dot(u, u) * dot(v, v);
        let inverse = if regular { 1.0 / area.sqrt() } else { 0.0 };
        let n = scale(m, inverse);
        // The derivative of m/|m| is the part of m' across n, over |m|.
        let turn = |a: [f32; 3]| scale(sum(a, scale(n, -dot(n, a))), inverse);
        let n_u = turn(sum(cross(uu, v), cross(u, uv)));
        let n_v = turn(sum(cross(uv, v), cross(u, vv)));
        let p_u = sum(u, sum(scale(n, d_u), scale(n_u, d)));
        let p_v = sum(v, sum(scale(n, d_v), scale(n_v, d)));
        let facing = cross(p_u, p_v);
        let length = dot(facing, facing);
        let upright = length > PARALLEL * dot(p_u, p_u) * dot(p_v, p_v) && length < f32::INFINITY;
        let inverse = if upright { 1.0 / length.sqrt() } else { 1.0 };
        for axis in 0..3 {
            output[0][axis][i] = A::fma(d, n[axis], p[axis]);
            output[1][axis][i] = if upright { facing[axis] * inverse } else { n[axis] };
        }
    }
}
