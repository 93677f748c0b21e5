//! Where the vertex of a collapsed edge goes, and what that costs (Lindstrom, Turk 1998, memoryless).

use glam::Vec4;
use relievo_core::simd::Arithmetic;

/// Edges that are placed together.
pub const BATCH: usize = 16;

/// What a vertex knows of its triangles, seen from the vertex: Σ n nᵀ (xx, yy, zz, xy, xz, yz) and Σ n.
pub type Star = [f32; 9];

/// Edges, one array a number.
pub struct Batch {
    /// From start to end.
    pub edge: [[f32; BATCH]; 3],
    /// Stars of start and end.
    pub star: [[[f32; BATCH]; 9]; 2],
    /// Normals of the triangles on both sides.
    pub side: [[[f32; BATCH]; 3]; 2],
    /// 1 for edges of a boundary.
    pub open: [f32; BATCH],
    /// -1 where the start stays, 1 where the end stays, infinite where the edge must not collapse, else 0.
    pub pinned: [f32; BATCH],
    /// The vertex from the middle of the edge.
    pub place: [[f32; BATCH]; 3],
    /// What the cost is multiplied by.
    pub factor: [f32; BATCH],
    /// How far the ends deviate already.
    pub before: [f32; BATCH],
    /// What the collapse costs: the mean square of distances from the planes of its triangles, times their areas.
    pub cost: [f32; BATCH],
    /// How far the vertex deviates.
    pub deviation: [f32; BATCH],
    /// The trace of the quadric: what the cost is by the square of a distance, before it is multiplied.
    pub trace: [f32; BATCH],
    /// What is added by attributes: a quadric of places from the middle of the edge, xx, yy, zz, xy, xz, yz, then b and
    /// c, and what its trace was.
    pub added: [[f32; BATCH]; 11],
}

impl Default for Batch {
    fn default() -> Self {
        let zero = [0.0; BATCH];
        Self {
            edge: [zero; 3],
            star: [[zero; 9]; 2],
            side: [[zero; 3]; 2],
            open: zero,
            pinned: zero,
            place: [zero; 3],
            factor: zero,
            before: zero,
            cost: zero,
            deviation: zero,
            trace: zero,
            added: [zero; 11],
        }
    }
}

impl Batch {
    /// Where the vertex of an edge goes, with its deviation, from its ends.
    pub fn point(&self, lane: usize, [start, end]: [Vec4; 2]) -> Vec4 {
        let mut point = match self.pinned[lane] {
            pinned if pinned < 0.0 => start,
            pinned if pinned > 0.0 => end,
            _ => {
                let [x, y, z] = self.place;
                0.5 * (start + end) + Vec4::new(x[lane], y[lane], z[lane], 0.0)
            }
        };
        point.w = self.deviation[lane];
        point
    }
}

/// Added to the diagonal of a quadric whose trace is 1: where it leaves a place open, the middle of the edge is taken.
const MIDDLE: f32 = 1e-5;
/// Cost of an edge's length beside that of its triangles' planes, which decides where these cost nothing.
const LENGTH: f32 = 1e-8;
/// Squared distance from the middle of the edge, in edges, beyond which a place is not believed.
const REACH: f32 = 4.0;
/// Least square of the sum of normals, relative to that of normals that all agree, that tells a side to keep volume on.
const SIDE: f32 = 0.01;

#[inline(always)]
fn body<A: Arithmetic, const WITH: bool>(batch: &mut Batch) {
    let fma = A::fma;
    for i in 0..BATCH {
        let e = [batch.edge[0][i], batch.edge[1][i], batch.edge[2][i]];
        let u: [f32; 9] = std::array::from_fn(|k| batch.star[0][k][i]);
        let v: [f32; 9] = std::array::from_fn(|k| batch.star[1][k][i]);
        let l: [f32; 3] = std::array::from_fn(|k| batch.side[0][k][i]);
        let r: [f32; 3] = std::array::from_fn(|k| batch.side[1][k][i]);
        let sum: [f32; 6] = std::array::from_fn(|k| u[k] + v[k]);
        let dif: [f32; 6] = std::array::from_fn(|k| v[k] - u[k]);
        let times = |m: &[f32; 6], x: &[f32; 3]| {
            [
                fma(m[0], x[0], fma(m[3], x[1], m[4] * x[2])),
                fma(m[3], x[0], fma(m[1], x[1], m[5] * x[2])),
                fma(m[4], x[0], fma(m[5], x[1], m[2] * x[2])),
            ]
        };
        let dot = |a: &[f32; 3], b: &[f32; 3]| fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2]));
        let ee = dot(&e, &e);
        let se = times(&sum, &e);
        let de = times(&dif, &e);
        let added: [f32; 11] = std::array::from_fn(|k| if WITH { batch.added[k][i] } else { 0.0 });
        let plus = |number: f32, added: f32| if WITH { number + added } else { number };
        let c = plus(0.25 * dot(&e, &se), added[9]);
        let b: [f32; 3] = std::array::from_fn(|k| plus(0.5 * de[k], added[6 + k]));
        let w = batch.open[i];
        let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        let a: [f32; 6] = std::array::from_fn(|k| {
            let (x, y) = pairs[k];
            let own = if k < 3 { ee } else { 0.0 };
            let shared = w * (own - e[x] * e[y]);
            fma(-l[x], l[y], fma(-r[x], r[y], sum[k])) - shared
        });
        let g: [f32; 3] = std::array::from_fn(|k| (u[6 + k] + v[6 + k]) - (l[k] + r[k]));
        let h = 0.5 * (fma(v[6] - u[6], e[0], fma(v[7] - u[7], e[1], (v[8] - u[8]) * e[2])));
        let trace = a[0] + a[1] + a[2];
        let flat = 1.0 / trace.max(1e-30);
        let scale = if WITH { 1.0 / plus(trace, added[10]).max(1e-30) } else { flat };
        let a: [f32; 6] = std::array::from_fn(|k| plus(a[k], added[k]));
        let m: [f32; 6] = std::array::from_fn(|k| fma(a[k], scale, if k < 3 { MIDDLE } else { 0.0 }));
        // L D Lᵀ of the regularised quadric.
        let low = 0.5 * MIDDLE;
        let d0 = m[0].max(low);
        let i0 = 1.0 / d0;
        let l10 = m[3] * i0;
        let l20 = m[4] * i0;
        let d1 = fma(-l10, m[3], m[1]).max(low);
        let i1 = 1.0 / d1;
        let t = fma(-l10, m[4], m[5]);
        let l21 = t * i1;
        let d2 = fma(-l21, t, fma(-l20, m[4], m[2])).max(low);
        let i2 = 1.0 / d2;
        let solve = |q: [f32; 3]| {
            let y0 = q[0];
            let y1 = fma(-l10, y0, q[1]);
            let y2 = fma(-l21, y1, fma(-l20, y0, q[2]));
            let x2 = y2 * i2;
            let x1 = fma(-l21, x2, y1 * i1);
            let x0 = fma(-l10, x1, fma(-l20, x2, y0 * i0));
            [x0, x1, x2]
        };
        let y = solve([b[0] * scale, b[1] * scale, b[2] * scale]);
        let z = solve(g);
        let gz = dot(&g, &z);
        let gg = dot(&g, &g);
        let keep = gg > SIDE * trace;
        let lambda = if keep { (h - dot(&g, &y)) / gz.max(1e-30) } else { 0.0 };
        let mut x: [f32; 3] = std::array::from_fn(|k| fma(lambda, z[k], y[k]));
        let near = dot(&x, &x) <= REACH * ee;
        let pin = 0.5 * batch.pinned[i];
        let free = pin == 0.0;
        for k in 0..3 {
            x[k] = if free { if near { x[k] } else { 0.0 } } else { pin * e[k] };
        }
        let ax = times(&a, &x);
        let cost = fma(-2.0, dot(&b, &x), dot(&x, &ax)) + c;
        let cost = cost.max(0.0);
        batch.cost[i] = if pin.abs() <= 1.0 { batch.factor[i] * fma(LENGTH * trace, ee, cost) } else { f32::INFINITY };
        batch.deviation[i] = batch.before[i] + (cost * flat).sqrt();
        batch.trace[i] = trace;
        for k in 0..3 {
            batch.place[k][i] = x[k];
        }
    }
}

#[inline(always)]
fn place_body<A: Arithmetic>(_: A, batch: &mut Batch) {
    body::<A, false>(batch);
}

#[inline(always)]
fn place_with_body<A: Arithmetic>(_: A, batch: &mut Batch) {
    body::<A, true>(batch);
}

relievo_core::dispatch_simd! {
    /// Places all edges of a batch.
    pub fn place = place_body(batch: &mut Batch)
}

relievo_core::dispatch_simd! {
    /// Places all edges of a batch, with what attributes add.
    pub fn place_with = place_with_body(batch: &mut Batch)
}
