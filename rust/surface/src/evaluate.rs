//! Evaluation at single places: position, first and second derivatives, and normal.

use relievo_core::simd::{Arithmetic, Level};
use relievo_core::{Context, Error, Parts, Result};

use crate::bezier::{cubic, cubic_first, cubic_second};
use crate::cone::GREGORY;
use crate::patch::{ORIGIN, Patch, PatchForm};
use crate::{Place, Surface};

/// What is known of the surface at a place. Derivatives are per unit of the tile's parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Position.
    pub p: [f32; 3],
    /// ∂P/∂u
    pub du: [f32; 3],
    /// ∂P/∂v
    pub dv: [f32; 3],
    /// ∂²P/∂u²
    pub duu: [f32; 3],
    /// ∂²P/∂u∂v
    pub duv: [f32; 3],
    /// ∂²P/∂v²
    pub dvv: [f32; 3],
}

impl Sample {
    /// The unit normal, du × dv. Zero where the tangents vanish or are parallel.
    pub fn normal(&self) -> [f32; 3] {
        glam::Vec3::from(self.du).cross(self.dv.into()).normalize_or_zero().to_array()
    }
}

/// Up to which derivative to evaluate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Order {
    /// Positions.
    Position,
    /// Positions and first derivatives.
    First,
    /// Positions, first and second derivatives.
    Second,
}

impl Order {
    /// How many of P, du, dv, duu, duv, dvv are evaluated.
    pub fn quantities(self) -> usize {
        match self {
            Order::Position => 1,
            Order::First => 3,
            Order::Second => 6,
        }
    }
}

/// Samples as a structure of arrays: x, y and z of every quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Positions.
    pub p: [Vec<f32>; 3],
    /// ∂P/∂u
    pub du: [Vec<f32>; 3],
    /// ∂P/∂v
    pub dv: [Vec<f32>; 3],
    /// ∂²P/∂u²
    pub duu: [Vec<f32>; 3],
    /// ∂²P/∂u∂v
    pub duv: [Vec<f32>; 3],
    /// ∂²P/∂v²
    pub dvv: [Vec<f32>; 3],
}

impl Samples {
    /// Makes room for `count` samples of the quantities that `order` asks for; others become empty.
    pub fn resize(&mut self, order: Order, count: usize) {
        let quantities = order.quantities();
        for (index, quantity) in self.quantities_mut().into_iter().enumerate() {
            for values in quantity {
                values.resize(if index < quantities { count } else { 0 }, 0.0);
            }
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.p[0].len()
    }

    /// Whether it has no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The arrays as slices to write to.
    pub fn as_slices(&mut self) -> SampleSlices<'_> {
        SampleSlices { values: self.quantities_mut().map(|quantity| quantity.each_mut().map(Vec::as_mut_slice)) }
    }

    fn quantities_mut(&mut self) -> [&mut [Vec<f32>; 3]; 6] {
        [&mut self.p, &mut self.du, &mut self.dv, &mut self.duu, &mut self.duv, &mut self.dvv]
    }
}

/// Where samples are written: x, y and z of P, du, dv, duu, duv, dvv. Quantities that are not asked for may be empty.
#[derive(Debug, Default)]
pub struct SampleSlices<'a> {
    /// The slices, by quantity and axis.
    pub values: [[&'a mut [f32]; 3]; 6],
}

impl<'a> Parts for SampleSlices<'a> {
    fn len(&self) -> usize {
        self.values[0][0].len()
    }

    fn split_at(self, count: usize) -> (SampleSlices<'a>, SampleSlices<'a>) {
        let mut tail = SampleSlices::default();
        let mut head = SampleSlices::default();
        for (quantity, values) in self.values.into_iter().enumerate() {
            for (axis, values) in values.into_iter().enumerate() {
                let (a, b) = values.split_at_mut(count.min(values.len()));
                (head.values[quantity][axis], tail.values[quantity][axis]) = (a, b);
            }
        }
        (head, tail)
    }
}

impl SampleSlices<'_> {
    fn set(&mut self, index: usize, sample: &[[f32; 3]; 6], quantities: usize) {
        for (values, quantity) in self.values.iter_mut().zip(sample).take(quantities) {
            for (values, value) in values.iter_mut().zip(quantity) {
                values[index] = *value;
            }
        }
    }
}

/// Places per item of parallel work.
const CHUNK: usize = 1024;

impl Surface {
    /// Position and derivatives at a place; zeros in a hole.
    ///
    /// # Errors
    /// Fails with `Invalid` if there is no such tile or u or v is outside 0..=1.
    pub fn sample(&self, level: Level, place: Place) -> Result<Sample> {
        self.check(&place)?;
        let [p, du, dv, duu, duv, dvv] = self.find(place.tile, place.u, place.v).map_or([[0.0; 3]; 6], |patch| {
            let mut out = [[0.0; 3]; 6];
            evaluate(level, patch, self.data_of(patch), [place.u, place.v], 6, &mut out);
            out
        });
        Ok(Sample { p, du, dv, duu, duv, dvv })
    }

    /// Evaluates at many places. Places in holes give zeros.
    ///
    /// # Errors
    /// Fails with `Invalid`, without touching `out`, if a tile does not exist or u or v is outside 0..=1.
    pub fn evaluate(&self, context: &Context, places: &[Place], order: Order, out: &mut Samples) -> Result<()> {
        for (index, place) in places.iter().enumerate() {
            self.check(place).map_err(|error| error.at(format!("place {index}")))?;
        }
        out.resize(order, places.len());
        let (level, quantities) = (context.level(), order.quantities());
        context.for_each_part((places, out.as_slices()), CHUNK, |_, (places, mut out)| {
            for (index, place) in places.iter().enumerate() {
                let mut sample = [[0.0; 3]; 6];
                if let Some(patch) = self.find(place.tile, place.u, place.v) {
                    evaluate(level, patch, self.data_of(patch), [place.u, place.v], quantities, &mut sample);
                }
                out.set(index, &sample, quantities);
            }
            Ok(())
        })
    }

    fn check(&self, place: &Place) -> Result<()> {
        if place.tile as usize >= self.tile_count() {
            return Err(Error::invalid(format!("there is no tile {}", place.tile))
                .advise(format!("use 0 to {}", self.tile_count().saturating_sub(1))));
        }
        if !((0.0..=1.0).contains(&place.u) && (0.0..=1.0).contains(&place.v)) {
            return Err(Error::invalid(format!("({}, {}) is outside the tile", place.u, place.v))
                .advise("use u and v from 0 to 1"));
        }
        Ok(())
    }
}

relievo_core::dispatch_simd! {
    /// Evaluates the first `quantities` (1, 3 or 6) of P, du, dv, duu, duv, dvv of a patch at tile parameters `uv`.
    pub(crate) fn evaluate = evaluate_body(
        patch: &Patch, data: &[f32], uv: [f32; 2], quantities: usize, out: &mut [[f32; 3]; 6]
    )
}

#[inline(always)]
fn evaluate_body<A: Arithmetic>(
    _: A,
    patch: &Patch,
    data: &[f32],
    uv: [f32; 2],
    quantities: usize,
    out: &mut [[f32; 3]; 6],
) {
    let scale = [1.0 / patch.size[0], 1.0 / patch.size[1]];
    let [s, t] = [(uv[0] - patch.low[0]) * scale[0], (uv[1] - patch.low[1]) * scale[1]];
    let (b_s, b_t) = (cubic(s), cubic(t));
    let (d_s, d_t) = (cubic_first(s), cubic_first(t));
    let (dd_s, dd_t) = (cubic_second(s), cubic_second(t));
    let blend = gregory_blend(s, t);
    for axis in 0..3 {
        let origin = data[axis];
        let points = &data[ORIGIN..];
        let bezier: [f32; 16] = match patch.form {
            PatchForm::Bezier => {
                let points: &[f32; 16] = points[16 * axis..16 * axis + 16].try_into().unwrap_or(&[0.0; 16]);
                *points
            }
            PatchForm::Gregory => blended::<A>(&points[20 * axis..20 * axis + 20], &blend),
        };
        // Rows of the patch as curves in u, then across them in v.
        let along = |basis: &[f32; 4]| -> [f32; 4] {
            std::array::from_fn(|row| dot::<A>(basis, &bezier[4 * row..4 * row + 4]))
        };
        let curve = along(&b_s);
        out[0][axis] = origin + dot::<A>(&b_t, &curve);
        if quantities > 1 {
            let slope = along(&d_s);
            out[1][axis] = scale[0] * dot::<A>(&b_t, &slope);
            out[2][axis] = scale[1] * dot::<A>(&d_t, &curve);
            if quantities > 3 {
                out[3][axis] = scale[0] * scale[0] * dot::<A>(&b_t, &along(&dd_s));
                out[4][axis] = scale[0] * scale[1] * dot::<A>(&d_t, &slope);
                out[5][axis] = scale[1] * scale[1] * dot::<A>(&dd_t, &curve);
            }
        }
    }
}

#[inline(always)]
fn dot<A: Arithmetic>(weights: &[f32; 4], values: &[f32]) -> f32 {
    A::fma(weights[0], values[0], A::fma(weights[1], values[1], A::fma(weights[2], values[2], weights[3] * values[3])))
}

/// The share of the first of the two Gregory points of interior Bézier points 5, 6, 9 and 10.
#[inline(always)]
fn gregory_blend(s: f32, t: f32) -> [f32; 4] {
    let share = |a: f32, b: f32| {
        let sum = a + b;
        if sum > 0.0 { a / sum } else { 0.0 }
    };
    let (sc, tc) = (1.0 - s, 1.0 - t);
    [share(s, t), share(t, sc), share(tc, s), share(sc, tc)]
}

/// The Bézier points that a Gregory patch has at one place. Their derivatives stand for the patch's, as in OpenSubdiv
/// and as Loop, Schaefer, Ni and Castaño (2009) propose.
#[inline(always)]
fn blended<A: Arithmetic>(points: &[f32], blend: &[f32; 4]) -> [f32; 16] {
    let mut bezier: [f32; 16] = std::array::from_fn(|i| points[GREGORY[i][0]]);
    for (i, share) in [5, 6, 9, 10].into_iter().zip(blend) {
        let [first, second] = GREGORY[i].map(|k| points[k]);
        bezier[i] = A::fma(*share, first - second, second);
    }
    bezier
}
