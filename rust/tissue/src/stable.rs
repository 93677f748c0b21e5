//! The longest stable step, and mass that makes it longer.
//!
//! The highest frequency of a mesh is at most that of its stiffest element, ω² ≤ 8 M Σb²/ρ with the modulus M of
//! compression along an axis and the squares of the gradients b (Flanagan and Belytschko 1984); a step is stable up to 2/ω.

use relievo_core::{Error, Result};

use crate::model::Model;
use crate::options::SimulationOptions;

/// The step of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps {
    /// Seconds of a step.
    pub step: f32,
    /// The longest stable step in seconds, with mass that was added.
    pub stable: f32,
    /// The element that allows no longer one.
    pub element: u32,
    /// Mass that was added, as a share of the mass without it.
    pub added_mass: f32,
    /// Masses of the elements in kg.
    pub(crate) masses: Vec<f32>,
    /// The longest stable step of each element at its own mass.
    own: Vec<f32>,
    /// The mass of each element without what was added.
    true_masses: Vec<f32>,
}

impl Steps {
    /// Finds the stable step of a model. Fails if the step of the options is longer.
    pub(crate) fn new(model: &Model, options: &SimulationOptions) -> Result<Self> {
        let count = model.elements.len();
        let same = if model.cell.is_some() { Some(model.hexahedron(0)?) } else { None };
        let (mut own, mut true_masses) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for element in 0..count {
            let shape = match same {
                Some(shape) => shape,
                None => model.hexahedron(element)?,
            };
            let [shear, bulk, density] = model.moduli(element).map(f64::from);
            // Fibres add at rest 4 times their passive stiffness; 8 leaves room for stretch, and a muscle pulls by its strength.
            let fibres = model.fibres.get(element).iter().map(|fibre| {
                let muscle = &model.muscles[fibre.muscle as usize];
                f64::from(fibre.share) * f64::from(8.0 * muscle.stiffness + 2.0 * muscle.strength)
            });
            let modulus = bulk + 4.0 / 3.0 * shear + fibres.sum::<f64>();
            own.push((2.0 / (8.0 * modulus * shape.squares / density).sqrt()) as f32);
            true_masses.push((density * shape.volume) as f32);
        }
        let wanted = options.mass_scaling.unwrap_or(0.0) / options.safety;
        let scale = |own: f32| (wanted / own).powi(2).max(1.0);
        let masses: Vec<f32> = own.iter().zip(&true_masses).map(|(own, mass)| mass * scale(*own)).collect();
        let (element, stable) = (0u32..)
            .zip(own.iter().map(|own| own * scale(*own).sqrt()))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0, f32::MAX));
        let total = |masses: &[f32]| masses.iter().map(|mass| f64::from(*mass)).sum::<f64>();
        let added_mass = (total(&masses) / total(&true_masses) - 1.0) as f32;
        let step = options.step.unwrap_or(stable * options.safety);
        // What the caller computed from the stable step may be rounded.
        if step > stable * 1.0001 {
            return Err(Error::invalid(format!("a step of {step} s is longer than the stable one of {stable:.4e} s"))
                .at(format!("element {element}"))
                .advise(
                    "take a shorter step, larger elements or softer material there, or mass scaling to this step",
                ));
        }
        Ok(Self { step, stable, element, added_mass, masses, own, true_masses })
    }

    /// Returns masses of nodes at which every element is stable with a step of 1 s times `safety`.
    pub(crate) fn unit_masses(&self, model: &Model, safety: f32) -> Vec<f32> {
        let mut masses = vec![0.0; model.nodes.len()];
        for ((corners, own), mass) in model.elements.iter().zip(&self.own).zip(&self.true_masses) {
            let mass = mass / (own * safety).powi(2);
            corners.iter().for_each(|node| masses[*node as usize] += 0.125 * mass);
        }
        masses
    }
}
