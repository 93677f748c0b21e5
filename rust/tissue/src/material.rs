//! Materials and muscles, and the table of soft tissues of the paper (Table 1).

use relievo_core::{Error, Result};

/// A nearly incompressible neo-Hookean material with the energy `G/2 (J^(-2/3) I₁ − 3) + K/2 (J − 1)²` per reference
/// volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, unique within a model.
    pub name: String,
    /// Density in kg/m³; positive.
    pub density: f32,
    /// Shear modulus G in Pa; positive.
    pub shear: f32,
    /// Bulk modulus K in Pa; positive.
    pub bulk: f32,
}

/// A family of fibres that may contract.
///
/// The passive part has the energy `stiffness/2 (I₄ − 1)²` per reference volume where I₄, the squared stretch, exceeds 1.
/// The active part is Hill's contractile element without its force–velocity curve: a tension along the fibre of
/// `strength · activation · f(stretch)` per reference area, where f is a parabola that is 1 at rest length and 0 at
/// stretches of 0.5 and 1.5 (Zajac 1989).
#[derive(Clone, Debug, PartialEq)]
pub struct Muscle {
    /// Name, unique within a model.
    pub name: String,
    /// Passive stiffness of the fibres in Pa; 0 or more.
    pub stiffness: f32,
    /// Isometric stress at full activation in Pa; 0 or more. Skeletal muscle has about 3e5.
    pub strength: f32,
}

/// Names, Young's moduli in Pa and Poisson's ratios of soft tissues (Table 1 of the paper).
const TISSUES: [(&str, f32, f32); 5] = [
    ("stratum corneum", 48e6, 0.49),
    ("dermis", 81.4e3, 0.49),
    ("hypodermis", 34e3, 0.49),
    ("muscle", 0.5e6, 0.49),
    ("tendon", 24e6, 0.49),
];

/// Density of soft tissues in kg/m³ (Duck 1990); the paper states none.
const DENSITY: f32 = 1060.0;

impl Material {
    /// Makes a material of Young's modulus in Pa and Poisson's ratio.
    ///
    /// # Errors
    /// Fails if the ratio is outside −0.99 to 0.4999, or a number is not in the range of [`Self::check`].
    pub fn of_young(name: &str, young: f32, poisson: f32, density: f32) -> Result<Self> {
        if !(-0.99..=0.4999).contains(&poisson) {
            return Err(Error::invalid(format!("Poisson's ratio of `{name}` is {poisson}"))
                .advise("use -0.99 to 0.4999; incompressible tissue has 0.49 to 0.499"));
        }
        let material = Self {
            name: name.to_owned(),
            density,
            shear: young / (2.0 * (1.0 + poisson)),
            bulk: young / (3.0 * (1.0 - 2.0 * poisson)),
        };
        material.check()?;
        Ok(material)
    }

    /// Returns the soft tissue called `name` from the built-in library.
    ///
    /// # Errors
    /// Fails if the library has none of that name.
    pub fn of_library(name: &str) -> Result<Self> {
        match TISSUES.iter().find(|tissue| tissue.0 == name) {
            Some((name, young, poisson)) => Self::of_young(name, *young, *poisson, DENSITY),
            None => {
                let names = TISSUES.map(|tissue| tissue.0).join(", ");
                Err(Error::invalid(format!("the library has no material `{name}`"))
                    .advise(format!("use one of {names}")))
            }
        }
    }

    /// Returns Young's modulus in Pa.
    pub fn young(&self) -> f32 {
        young(self.shear, self.bulk)
    }

    /// Checks the density in kg/m³ and the moduli in Pa.
    ///
    /// # Errors
    /// Fails if one is not between 10⁻⁶ and 10¹⁵.
    pub fn check(&self) -> Result<()> {
        let numbers = [("density", self.density), ("shear modulus", self.shear), ("bulk modulus", self.bulk)];
        match numbers.into_iter().find(|(_, value)| !(*value > 1e-6 && *value < 1e15)) {
            None => Ok(()),
            Some((what, value)) => Err(Error::invalid(format!("the {what} is {value}"))
                .at(format!("material `{}`", self.name))
                .advise("use 1e-6 to 1e15, in kg/m³ and Pa")),
        }
    }
}

impl Muscle {
    /// Checks the stiffness and the strength in Pa.
    ///
    /// # Errors
    /// Fails if one is negative or not below 10¹⁵.
    pub fn check(&self) -> Result<()> {
        let numbers = [("stiffness", self.stiffness), ("strength", self.strength)];
        match numbers.into_iter().find(|(_, value)| !(*value >= 0.0 && *value < 1e15)) {
            None => Ok(()),
            Some((what, value)) => Err(Error::invalid(format!("the {what} is {value}"))
                .at(format!("muscle `{}`", self.name))
                .advise("use 0 to 1e15 Pa")),
        }
    }
}

/// Returns Young's modulus for a shear and a bulk modulus, in their unit.
pub(crate) fn young(shear: f32, bulk: f32) -> f32 {
    9.0 * bulk * shear / (3.0 * bulk + shear)
}
