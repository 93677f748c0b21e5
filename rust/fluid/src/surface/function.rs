//! Functions of particles whose zero is the surface of a fluid: what they are, and the numbers they take.

use relievo_core::{Error, Result};

use crate::surface::profile::Profile;

/// A function of space whose zero is the surface. It is positive inside. Distances are in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfaceFunction {
    /// Σ w − w(radius) of Gaussians w(r) = exp(−sharpness · r² / support²), cut and lowered to 0 at the support radius
    /// (Blinn 1982). A particle alone is a sphere of the radius; the sharper, the less do neighbours melt together.
    Blobs {
        /// The support radius.
        support: f32,
        /// The radius of a particle alone.
        radius: f32,
        /// How fast weights fall off, below 64.
        sharpness: f32,
    },
    /// radius − |x − mean of the particles near x|, where weights of the mean are (1 − r² / support²)³ (Zhu, Bridson
    /// 2005, Section 5, with one radius for all). A particle alone is a sphere of the radius. Where no particle is near
    /// it is radius − support.
    ZhuBridson {
        /// The support radius.
        support: f32,
        /// The radius of a particle alone.
        radius: f32,
    },
    /// Σ V W − iso with the cubic spline W, where V = 1 / Σ W at the particle is its volume: the share of the density
    /// at rest. A particle alone is 1 in its middle.
    Density {
        /// The support radius.
        support: f32,
        /// The share at the surface, between 0 and 1.
        iso: f32,
    },
    /// As [`Self::Density`], with kernels that are flat along the surface and centres moved to the mean of the
    /// neighbours by the share `centring` (Yu, Turk 2013, Section 4).
    Anisotropic {
        /// The support radius.
        support: f32,
        /// The share at the surface, between 0 and 1.
        iso: f32,
        /// How far centres are moved, 0 to 1.
        centring: f32,
    },
}

impl SurfaceFunction {
    /// Blobs of particles of a radius that lie two radii apart: support of 4 radii, sharpness 8.
    pub fn blobs(radius: f32) -> Self {
        Self::Blobs { support: 4.0 * radius, radius, sharpness: 8.0 }
    }

    /// Zhu's and Bridson's function of particles of a radius that lie two radii apart: support of 4 radii.
    pub fn zhu_bridson(radius: f32) -> Self {
        Self::ZhuBridson { support: 4.0 * radius, radius }
    }

    /// The density of particles of a radius that lie two radii apart: support of 4 radii, iso value 0.6.
    pub fn density(radius: f32) -> Self {
        Self::Density { support: 4.0 * radius, iso: 0.6 }
    }

    /// Anisotropic kernels of particles of a radius that lie two radii apart: support of 4 radii, iso value 0.6,
    /// centres moved by 0.9.
    pub fn anisotropic(radius: f32) -> Self {
        Self::Anisotropic { support: 4.0 * radius, iso: 0.6, centring: 0.9 }
    }

    /// The support radius: what is farther from a particle does not see it, but for anisotropic kernels, which reach
    /// farther along the surface.
    pub fn support(&self) -> f32 {
        match *self {
            Self::Blobs { support, .. }
            | Self::ZhuBridson { support, .. }
            | Self::Density { support, .. }
            | Self::Anisotropic { support, .. } => support,
        }
    }

    /// How far the volumes, shapes and centres of kernels see, in metres: other particles change a kernel from this far.
    pub(crate) fn sight(&self) -> f32 {
        match *self {
            Self::Blobs { .. } | Self::ZhuBridson { .. } => 0.0,
            Self::Density { support, .. } => support,
            Self::Anisotropic { support, centring, .. } => support * (1.0 + centring),
        }
    }

    /// Checks the parameters of the function.
    ///
    /// # Errors
    /// Fails unless the support radius is between 10⁻¹⁵ and 10¹⁵, the radius positive and below it, the iso value
    /// between 0 and 1, the sharpness between 0 and 64 and the share from 0 to 1.
    pub fn check(&self) -> Result<()> {
        let support = self.support();
        if !(support > 1e-15 && support < 1e15) {
            return Err(Error::invalid(format!("the support radius is {support}")).advise("use 1e-15 to 1e15"));
        }
        let within = |name: &str, value: f32, low: f32, high: f32| {
            if value > low && value < high {
                Ok(())
            } else {
                Err(Error::invalid(format!("the {name} is {value}"))
                    .advise(format!("use more than {low} and less than {high}")))
            }
        };
        match *self {
            Self::Blobs { radius, sharpness, .. } => {
                within("radius", radius, 0.0, support)?;
                within("sharpness", sharpness, 0.0, 64.0)
            }
            Self::ZhuBridson { radius, .. } => within("radius", radius, 0.0, support),
            Self::Density { iso, .. } => within("iso value", iso, 0.0, 1.0),
            Self::Anisotropic { iso, centring, .. } => {
                within("iso value", iso, 0.0, 1.0)?;
                if (0.0..=1.0).contains(&centring) {
                    return Ok(());
                }
                Err(Error::invalid(format!("centres are moved by {centring}")).advise("use 0 to 1"))
            }
        }
    }

    /// How weights fall off.
    pub(crate) fn profile(&self) -> Profile {
        match *self {
            Self::Blobs { sharpness, .. } => Profile::Gaussian(sharpness),
            Self::ZhuBridson { .. } => Profile::Cubic,
            Self::Density { .. } | Self::Anisotropic { .. } => Profile::Spline,
        }
    }

    /// How a value comes from the sums over particles.
    pub(crate) fn combination(&self) -> Combination {
        match *self {
            Self::Blobs { support, radius, .. } => {
                let share = radius / support;
                Combination::Sum { iso: self.profile().at(share * share) }
            }
            Self::ZhuBridson { support, radius } => Combination::Mean { radius, outside: radius - support },
            Self::Density { iso, .. } | Self::Anisotropic { iso, .. } => Combination::Sum { iso },
        }
    }
}

/// How the value of a function comes from sums over particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Combination {
    /// The sum of weights less this.
    Sum { iso: f32 },
    /// The radius less the distance to the weighted mean; `outside` where no particle has weight.
    Mean { radius: f32, outside: f32 },
}

impl Combination {
    /// The value of a sum of weights and of weights times vectors to the particles.
    #[inline(always)]
    pub fn value(self, weight: f32, [x, y, z]: [f32; 3]) -> f32 {
        match self {
            Self::Sum { iso } => weight - iso,
            Self::Mean { radius, outside } => {
                let distance = (x * x + y * y + z * z).sqrt() / weight;
                if weight > 0.0 { radius - distance } else { outside }
            }
        }
    }
}
