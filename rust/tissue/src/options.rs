//! How a model is simulated.

use relievo_core::{Error, Result};

use crate::curve::Curve;

/// How a model is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulationOptions {
    /// Acceleration of all nodes in m/s².
    pub gravity: [f32; 3],
    /// Damping proportional to mass, in 1/s; 0 or more.
    pub damping: f32,
    /// Seconds of a step; `None` for the stable step times `safety`.
    pub step: Option<f32>,
    /// Share of the stable step at rest that a step takes; above 0, at most 1. Elements whose faces grow to f times their
    /// area need 1/f or less.
    pub safety: f32,
    /// Resistance to hourglass modes; 1 gives a beam of boxes its bending stiffness.
    pub hourglass: f32,
    /// Seconds of a step that heavier elements shall allow: mass is added to elements that would need a shorter one.
    pub mass_scaling: Option<f32>,
    /// How often the step may be halved, for as long as it takes, where an element turns inside out; 0 to 16. 0 stops the
    /// simulation there.
    pub halvings: u32,
    /// Coefficient of friction of the model against itself; `None` lets it pass through itself.
    pub self_friction: Option<f32>,
}

impl Default for SimulationOptions {
    fn default() -> Self {
        Self {
            gravity: [0.0, 0.0, -9.81],
            damping: 0.0,
            step: None,
            safety: 0.7,
            hourglass: 1.0,
            mass_scaling: None,
            halvings: 0,
            self_friction: None,
        }
    }
}

impl SimulationOptions {
    /// Checks the options.
    ///
    /// # Errors
    /// Fails if an option is out of its range, and names it.
    pub fn check(&self) -> Result<()> {
        let is_step = |step: Option<f32>| step.is_none_or(|step| step > 0.0 && step.is_finite());
        let refuse = |what: String, name: &str, range: &str| Err(Error::invalid(what).at(name).advise(range));
        if !self.gravity.iter().all(|part| part.is_finite()) {
            return refuse(
                format!("a gravity of {:?} cannot be", self.gravity),
                "gravity",
                "use finite numbers in m/s²",
            );
        }
        if !(self.damping >= 0.0 && self.damping.is_finite()) {
            return refuse(format!("a damping of {} cannot be", self.damping), "damping", "use 0 or more, in 1/s");
        }
        if !is_step(self.step) || !is_step(self.mass_scaling) {
            return refuse("a step is not positive".into(), "step", "use seconds above 0");
        }
        if !(self.safety > 0.0 && self.safety <= 1.0) {
            return refuse(
                format!("a share of {} of the stable step cannot be", self.safety),
                "safety",
                "use above 0 to 1",
            );
        }
        if !(0.0..=10.0).contains(&self.hourglass) {
            return refuse(
                format!("a resistance of {} cannot be", self.hourglass),
                "hourglass",
                "use 0 to 10; 1 is common",
            );
        }
        if self.halvings > 16 {
            return refuse(format!("{} halvings of the step cannot be", self.halvings), "halvings", "use 0 to 16");
        }
        if let Some(friction) = self.self_friction
            && !(friction >= 0.0 && friction.is_finite())
        {
            return refuse(format!("a friction of {friction} cannot be"), "self_friction", "use 0 or more");
        }
        Ok(())
    }
}

/// Nodes that are moved along some axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// The nodes.
    pub nodes: Vec<u32>,
    /// The axes along which they are moved, x in bit 0; along the others they are free.
    pub axes: u32,
    /// Displacement in metres over seconds.
    pub displacement: Curve<3>,
}
