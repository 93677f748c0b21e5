//! Stresses of the neo-Hookean material and of fibres: by vectors for forces, and in f64 for results.

use glam::{DMat3, DVec3};
use relievo_core::lanes::Lanes;

/// A tensor of vectors: rows by axis of the deformed body, columns by axis of the body at rest.
pub(crate) type Tensor<A> = [[<A as Lanes>::F; 3]; 3];

/// Stretch from rest at which a muscle no longer contracts.
const REACH: f32 = 0.5;

/// The polynomial in the fourth root of J that approximates its inverse cube root within 3 % for J from 0.04 to 13.
const ROOT: [f32; 5] = [8.395_719, -19.265_586, 19.052_128, -8.700_67, 1.499_665];
/// The range of J in which the stress is that of the material; beyond, its isochoric part is that of the bound.
const VOLUMES: [f32; 2] = [0.04, 12.0];

/// Returns the first Piola–Kirchhoff stress, the deformation gradient and its determinant for the gradient `h` of the
/// displacement. Moduli times volume give stress times volume.
#[inline(always)]
pub(crate) fn neo_hookean<A: Lanes>(
    v: A,
    h: &Tensor<A>,
    shear: A::F,
    bulk: A::F,
) -> (Tensor<A>, Tensor<A>, A::F) {
    let (zero, one) = (v.splat(0.0), v.splat(1.0));
    let mut f = *h;
    for axis in 0..3 {
        f[axis][axis] = v.add(f[axis][axis], one);
    }
    let mut cofactor: Tensor<A> = [[zero; 3]; 3];
    let mut squares = zero;
    for a in 0..3 {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            cofactor[a][i] = v.sub(v.mul(f[b][j], f[c][k]), v.mul(f[b][k], f[c][j]));
            squares = v.fused(f[a][i], f[a][i], squares);
        }
    }
    // J − 1 = tr H + the sum of principal minors + det H: J itself would leave little of it after rounding.
    let (mut trace, mut minors, mut determinant) = (zero, zero, zero);
    for a in 0..3 {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        trace = v.add(trace, h[a][a]);
        minors = v.add(minors, v.sub(v.mul(h[a][a], h[b][b]), v.mul(h[a][b], h[b][a])));
        let cross = v.sub(v.mul(h[1][b], h[2][c]), v.mul(h[1][c], h[2][b]));
        determinant = v.fused(h[0][a], cross, determinant);
    }
    let grown = v.add(trace, v.add(minors, determinant));
    let volume = v.add(one, grown);
    let bounded = v.min(v.max(volume, v.splat(VOLUMES[0])), v.splat(VOLUMES[1]));
    let quarter = v.sqrt(v.sqrt(bounded));
    let mut root = v.splat(ROOT[4]);
    for power in [3, 2, 1, 0] {
        root = v.fused(root, quarter, v.splat(ROOT[power]));
    }
    for _ in 0..3 {
        let cube = v.mul(v.mul(root, root), root);
        let wrong = v.sub(one, v.mul(bounded, cube));
        root = v.fused(v.mul(root, v.splat(1.0 / 3.0)), wrong, root);
    }
    let square = v.mul(root, root);
    let isochoric = v.mul(shear, square);
    // −G J^(−5/3) I₁/3 + K (J − 1)
    let spherical = v.mul(v.mul(v.mul(square, root), squares), v.splat(-1.0 / 3.0));
    let spherical = v.fused(bulk, grown, v.mul(isochoric, spherical));
    let mut p: Tensor<A> = [[zero; 3]; 3];
    for a in 0..3 {
        for i in 0..3 {
            p[a][i] = v.fused(spherical, cofactor[a][i], v.mul(isochoric, f[a][i]));
        }
    }
    (p, f, volume)
}

/// Adds the stress of fibres along the unit vector `direction` at rest, or 0, to the first Piola–Kirchhoff stress `p`.
#[inline(always)]
pub(crate) fn fibre<A: Lanes>(
    v: A,
    f: &Tensor<A>,
    direction: &[A::F; 3],
    stiffness: A::F,
    active: A::F,
    p: &mut Tensor<A>,
) {
    let (zero, one) = (v.splat(0.0), v.splat(1.0));
    let mut along = [zero; 3];
    let mut square = v.splat(1e-12);
    for axis in 0..3 {
        let sum = v.fused(f[axis][1], direction[1], v.mul(f[axis][0], direction[0]));
        along[axis] = v.fused(f[axis][2], direction[2], sum);
        square = v.fused(along[axis], along[axis], square);
    }
    let stretch = v.sqrt(square);
    let off = v.mul(v.sub(stretch, one), v.splat(1.0 / REACH));
    let share = v.max(v.sub(one, v.mul(off, off)), zero);
    let passive = v.mul(v.mul(stiffness, v.splat(2.0)), v.max(v.sub(square, one), zero));
    let tension = v.add(v.div(v.mul(active, share), stretch), passive);
    for a in 0..3 {
        let pull = v.mul(tension, along[a]);
        for i in 0..3 {
            p[a][i] = v.fused(pull, direction[i], p[a][i]);
        }
    }
}

/// A family of fibres of an element.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Family {
    pub direction: DVec3,
    /// Passive stiffness, in Pa.
    pub stiffness: f64,
    /// Isometric stress at the present activation, in Pa.
    pub active: f64,
}

/// Returns the Cauchy stress in Pa and the energy per reference volume in J/m³, without that of contraction.
pub(crate) fn cauchy(f: DMat3, shear: f64, bulk: f64, fibres: &[Family]) -> (DMat3, f64) {
    let volume = f.determinant();
    let left = f * f.transpose();
    let first = left.x_axis.x + left.y_axis.y + left.z_axis.z;
    let isochoric = volume.powf(-2.0 / 3.0);
    let deviator = (left - DMat3::from_diagonal(DVec3::splat(first / 3.0))) * (shear * isochoric / volume);
    let mut stress = deviator + DMat3::from_diagonal(DVec3::splat(bulk * (volume - 1.0)));
    let mut energy = 0.5 * shear * (isochoric * first - 3.0) + 0.5 * bulk * (volume - 1.0).powi(2);
    for fibre in fibres {
        let along = f * fibre.direction;
        let square = along.length_squared();
        let over = (square - 1.0).max(0.0);
        let off = (square.sqrt() - 1.0) / f64::from(REACH);
        let tension = fibre.active * (1.0 - off * off).max(0.0) / square.sqrt() + 2.0 * fibre.stiffness * over;
        stress += outer(along, along) * (tension / volume);
        energy += 0.5 * fibre.stiffness * over * over;
    }
    (stress, energy)
}

/// Returns the matrix a bᵀ.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
