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

/// Returns the first Piola–Kirchhoff stress and the determinant of the deformation gradient for the gradient `h` of the
/// displacement. Moduli times volume give stress times volume.
///
/// All that vanishes at rest is computed from `h` itself, for sums that begin with 1 would lose the digits of small strains.
#[inline(always)]
pub(crate) fn neo_hookean<A: Lanes>(v: A, h: &Tensor<A>, shear: A::F, bulk: A::F) -> (Tensor<A>, A::F) {
    let (zero, one) = (v.splat(0.0), v.splat(1.0));
    let (mut trace, mut minors, mut determinant, mut squares) = (zero, zero, zero, zero);
    // The cofactors of F = I + H without those of I.
    let mut cofactor: Tensor<A> = [[zero; 3]; 3];
    for a in 0..3 {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        trace = v.add(trace, h[a][a]);
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let minor = v.sub(v.mul(h[b][j], h[c][k]), v.mul(h[b][k], h[c][j]));
            squares = v.fused(h[a][i], h[a][i], squares);
            if a == 0 {
                determinant = v.fused(h[0][i], minor, determinant);
            }
            cofactor[a][i] = if i == a {
                minors = v.add(minors, minor);
                v.add(v.add(h[b][b], h[c][c]), minor)
            } else {
                v.sub(minor, h[i][a])
            };
        }
    }
    let grown = v.add(trace, v.add(minors, determinant));
    let volume = v.add(one, grown);
    let bounded = v.min(v.max(volume, v.splat(VOLUMES[0])), v.splat(VOLUMES[1]));
    let quarter = v.sqrt(v.sqrt(bounded));
    let mut root = v.splat(ROOT[4]);
    for power in 0..4 {
        root = v.fused(root, quarter, v.splat(ROOT[3 - power]));
    }
    for _ in 0..3 {
        let cube = v.mul(v.mul(root, root), root);
        let wrong = v.sub(one, v.mul(bounded, cube));
        root = v.fused(v.mul(root, v.splat(1.0 / 3.0)), wrong, root);
    }
    let square = v.mul(root, root);
    let isochoric = v.mul(shear, square);
    // I₁/(3 J) − 1
    let excess = v.fused(v.fused(v.splat(2.0), trace, squares), v.splat(1.0 / 3.0), v.sub(zero, grown));
    let excess = v.mul(v.mul(square, root), excess);
    let spherical = v.sub(v.mul(bulk, grown), v.mul(isochoric, excess));
    let mut p: Tensor<A> = [[zero; 3]; 3];
    for a in 0..3 {
        for i in 0..3 {
            let deviator = v.mul(isochoric, v.sub(h[a][i], cofactor[a][i]));
            p[a][i] = v.fused(spherical, cofactor[a][i], deviator);
        }
        p[a][a] = v.add(p[a][a], spherical);
    }
    (p, volume)
}

/// Adds the stress of fibres along the unit vector `direction` at rest, or 0, to the first Piola–Kirchhoff stress `p`, for
/// the gradient `h` of the displacement.
#[inline(always)]
pub(crate) fn fibre<A: Lanes>(
    v: A,
    h: &Tensor<A>,
    direction: &[A::F; 3],
    stiffness: A::F,
    active: A::F,
    p: &mut Tensor<A>,
) {
    let (zero, one) = (v.splat(0.0), v.splat(1.0));
    let mut along = *direction;
    // I₄ − 1
    let mut over = zero;
    for axis in 0..3 {
        let sum = v.fused(h[axis][1], direction[1], v.mul(h[axis][0], direction[0]));
        let moved = v.fused(h[axis][2], direction[2], sum);
        over = v.fused(moved, v.fused(v.splat(2.0), direction[axis], moved), over);
        along[axis] = v.add(direction[axis], moved);
    }
    let stretch = v.sqrt(v.max(v.add(one, over), v.splat(1e-6)));
    let off = v.mul(v.sub(stretch, one), v.splat(1.0 / REACH));
    let share = v.max(v.sub(one, v.mul(off, off)), zero);
    let passive = v.mul(v.mul(stiffness, v.splat(2.0)), v.max(over, zero));
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

/// Returns the eigenvalues of a symmetric matrix, the largest first (Smith 1961).
pub(crate) fn principal(matrix: DMat3) -> [f64; 3] {
    let mean = (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z) / 3.0;
    let deviator = matrix - DMat3::from_diagonal(DVec3::splat(mean));
    let squares: f64 = deviator.to_cols_array().iter().map(|part| part * part).sum();
    let size = (squares / 6.0).sqrt();
    if size <= f64::MIN_POSITIVE {
        return [mean; 3];
    }
    let angle = (0.5 * (deviator * (1.0 / size)).determinant()).clamp(-1.0, 1.0).acos() / 3.0;
    let largest = mean + 2.0 * size * angle.cos();
    let least = mean + 2.0 * size * (angle + std::f64::consts::TAU / 3.0).cos();
    [largest, 3.0 * mean - largest - least, least]
}
