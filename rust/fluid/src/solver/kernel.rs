//! Smoothing kernels of compact support in three dimensions. Their integrals are 1; what is beyond the support radius h
//! does not count.

use std::f32::consts::PI;

/// Which kernels density and pressure have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KernelSet {
    /// Wendland's C² kernel for both (Wendland 1995). Pressures then do no more work than they are given by what they hold
    /// apart, and particles do not pair (Dehnen, Aly 2012).
    #[default]
    Wendland,
    /// Those of Müller, Charypar and Gross (2003, Section 3.5): poly6 for density, the spiky one for pressure. Pressures do
    /// work of their own, so fluids need more viscosity to rest.
    Mueller,
}

/// The kernels of a support radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernels {
    /// Which density and pressure have.
    pub set: KernelSet,
    /// The support radius h, in metres.
    pub support: f32,
    /// What the kernel of density is at no distance, in 1/m³.
    pub density: f32,
    /// 45 / (π h⁶), of the spiky kernel's gradient and of viscosity's Laplacian.
    pub spiky: f32,
}

impl Kernels {
    /// Of a support radius, which is positive.
    pub fn new(set: KernelSet, support: f32) -> Self {
        let density = match set {
            KernelSet::Wendland => 21.0 / (2.0 * PI),
            KernelSet::Mueller => 315.0 / (64.0 * PI),
        };
        Self { set, support, density: density / support.powi(3), spiky: 45.0 / (PI * support.powi(6)) }
    }

    /// The kernel of densities at a distance: 21 / (2 π h³) · (1 − q)⁴ (4 q + 1) with q = r / h, or
    /// 315 / (64 π h³) · (1 − q²)³.
    pub fn density(&self, distance: f32) -> f32 {
        let q = (distance / self.support).min(1.0);
        let share = match self.set {
            KernelSet::Wendland => (1.0 - q).powi(4) * (4.0 * q + 1.0),
            KernelSet::Mueller => (1.0 - q * q).powi(3),
        };
        self.density * share
    }

    /// The gradient of [`Self::density`] at a distance, as a factor of the vector from the other particle.
    pub fn density_slope(&self, distance: f32) -> f32 {
        let q = (distance / self.support).min(1.0);
        let share = match self.set {
            KernelSet::Wendland => -20.0 * (1.0 - q).powi(3),
            KernelSet::Mueller => -6.0 * (1.0 - q * q).powi(2),
        };
        self.density * share / (self.support * self.support)
    }

    /// The gradient of the kernel of pressures at a distance, as a factor of the vector from the other particle: that of
    /// densities, or of 15 / (π h⁶) · (h − r)³, which is 0 at no distance, where there is no direction.
    pub fn pressure_slope(&self, distance: f32) -> f32 {
        let rest = (self.support - distance).max(0.0);
        match self.set {
            KernelSet::Wendland => self.density_slope(distance),
            KernelSet::Mueller if distance > 0.0 => -self.spiky * rest * rest / distance,
            KernelSet::Mueller => 0.0,
        }
    }

    /// The Laplacian of the viscosity kernel at a distance: 45 / (π h⁶) · (h − r).
    pub fn viscosity(&self, distance: f32) -> f32 {
        self.spiky * (self.support - distance).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETS: [KernelSet; 2] = [KernelSet::Wendland, KernelSet::Mueller];

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
        for (set, support) in SETS.into_iter().flat_map(|set| [0.04, 1.0, 2.5].map(|support| (set, support))) {
            let kernels = Kernels::new(set, support);
            assert!((integral(support, |r| kernels.density(r)) - 1.0).abs() < 1e-4);
            // Partial integration: the slope times r is -3 times the kernel.
            assert!((integral(support, |r| kernels.density_slope(r) * r * r) + 3.0).abs() < 1e-3);
            assert!((integral(support, |r| kernels.pressure_slope(r) * r * r) + 3.0).abs() < 1e-3);
            // The Laplacian's second moment: ∫ r² ∇²W = 6 ∫ W.
            assert!((integral(support, |r| kernels.viscosity(r) * r * r) - 6.0).abs() < 1e-3);
        }
    }

    #[test]
    fn slopes_are_those_of_the_kernels() {
        let step = 1e-3;
        for (set, r) in SETS.into_iter().flat_map(|set| [0.02, 0.1, 0.15, 0.2, 0.28].map(|r| (set, r))) {
            let kernels = Kernels::new(set, 0.3);
            let slope = (kernels.density(r + step) - kernels.density(r - step)) / (2.0 * step);
            assert!((kernels.density_slope(r) * r - slope).abs() < 0.02 * slope.abs().max(1.0), "{set:?} {r}");
        }
        for kernels in SETS.map(|set| Kernels::new(set, 0.3)) {
            assert_eq!([kernels.density(0.3), kernels.density_slope(0.5), kernels.pressure_slope(0.4)], [0.0; 3]);
            assert!(kernels.pressure_slope(0.0).is_finite());
        }
    }
}
