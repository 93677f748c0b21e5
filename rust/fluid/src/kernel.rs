//! Smoothing kernels of compact support in three dimensions. Their integrals are 1; what is beyond the support radius h
//! does not count.
//!
//! Density, pressure and viscosity have kernels of their own (Müller, Charypar, Gross 2003, Section 3.5). The cubic
//! spline (Monaghan 1992) is for solvers whose density and pressure must have the same one.

use std::f32::consts::PI;

/// The kernels of a support radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernels {
    /// The support radius h, in metres.
    pub support: f32,
    /// 315 / (64 π h⁹)
    pub poly6: f32,
    /// 45 / (π h⁶)
    pub spiky: f32,
    /// 8 / (π h³)
    pub spline: f32,
}

impl Kernels {
    /// Of a support radius, which is positive.
    pub fn new(support: f32) -> Self {
        Self {
            support,
            poly6: 315.0 / (64.0 * PI * support.powi(9)),
            spiky: 45.0 / (PI * support.powi(6)),
            spline: 8.0 / (PI * support.powi(3)),
        }
    }

    /// The kernel of densities at the square of a distance: 315 / (64 π h⁹) · (h² − r²)³.
    #[inline(always)]
    pub fn density(&self, square: f32) -> f32 {
        let rest = (self.support * self.support - square).max(0.0);
        self.poly6 * rest * rest * rest
    }

    /// The gradient of [`Self::density`] where it is evaluated, as a factor of the vector from the other particle.
    #[inline(always)]
    pub fn density_slope(&self, square: f32) -> f32 {
        let rest = (self.support * self.support - square).max(0.0);
        -6.0 * self.poly6 * rest * rest
    }

    /// The gradient of the spiky kernel 15 / (π h⁶) · (h − r)³ at a distance, as a factor of the vector from the other
    /// particle; 0 at no distance, where there is no direction.
    #[inline(always)]
    pub fn pressure_slope(&self, distance: f32) -> f32 {
        let rest = (self.support - distance).max(0.0);
        if distance > 0.0 { -self.spiky * rest * rest / distance } else { 0.0 }
    }

    /// The Laplacian of the viscosity kernel at a distance: 45 / (π h⁶) · (h − r).
    #[inline(always)]
    pub fn viscosity(&self, distance: f32) -> f32 {
        self.spiky * (self.support - distance).max(0.0)
    }

    /// The cubic spline at a distance.
    #[inline(always)]
    pub fn spline(&self, distance: f32) -> f32 {
        let q = distance / self.support;
        let rest = (1.0 - q).max(0.0);
        let near = 6.0 * q * q * (q - 1.0) + 1.0;
        self.spline * if q <= 0.5 { near } else { 2.0 * rest * rest * rest }
    }

    /// The gradient of the cubic spline at a distance, as a factor of the vector from the other particle.
    #[inline(always)]
    pub fn spline_slope(&self, distance: f32) -> f32 {
        let q = distance / self.support;
        let rest = (1.0 - q).max(0.0);
        let over_q = if q <= 0.5 { 18.0 * q - 12.0 } else { -6.0 * rest * rest / q };
        self.spline * over_q / (self.support * self.support)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integral over all distances of 4 π r² f(r).
    fn integral(support: f32, f: impl Fn(f32) -> f32) -> f32 {
        let steps = 4000;
        let sum: f64 = (0..steps)
            .map(|step| {
                let r = (step as f32 + 0.5) / steps as f32 * support;
                f64::from(4.0 * PI * r * r * f(r))
            })
            .sum();
        (sum * f64::from(support) / f64::from(steps)) as f32
    }

    #[test]
    fn integrals_are_one() {
        for support in [0.04, 1.0, 2.5] {
            let kernels = Kernels::new(support);
            assert!((integral(support, |r| kernels.density(r * r)) - 1.0).abs() < 1e-4);
            assert!((integral(support, |r| kernels.spline(r)) - 1.0).abs() < 1e-4);
            // Partial integration: the slope times r is -3 times the kernel.
            for slope in [
                &(|r: f32| kernels.density_slope(r * r)) as &dyn Fn(f32) -> f32,
                &|r| kernels.pressure_slope(r),
                &|r| kernels.spline_slope(r),
            ] {
                assert!((integral(support, |r| slope(r) * r * r) + 3.0).abs() < 1e-3);
            }
            // The Laplacian's second moment: ∫ r² ∇²W = 6 ∫ W.
            assert!((integral(support, |r| kernels.viscosity(r) * r * r) - 6.0).abs() < 1e-3);
        }
    }

    #[test]
    fn slopes_are_those_of_the_kernels() {
        let kernels = Kernels::new(0.3);
        let step = 1e-3;
        for r in [0.02, 0.1, 0.149, 0.151, 0.2, 0.28] {
            let density =
                (kernels.density((r + step) * (r + step)) - kernels.density((r - step) * (r - step))) / (2.0 * step);
            assert!((kernels.density_slope(r * r) * r - density).abs() < 0.02 * density.abs().max(1.0), "{r}");
            let spline = (kernels.spline(r + step) - kernels.spline(r - step)) / (2.0 * step);
            assert!((kernels.spline_slope(r) * r - spline).abs() < 0.02 * spline.abs().max(1.0), "{r}");
        }
        assert_eq!(kernels.pressure_slope(0.0), 0.0);
        assert_eq!(kernels.density(0.09), 0.0);
    }
}
