//! Finite-element models of soft tissue and their simulation.
//!
//! Surfaces such as skin, bone and muscles become a model of hexahedra, whose motion is simulated (Mark Warburton and Steve
//! Maddock, *Creating Finite Element Models of Facial Soft Tissue*, Journal of WSCG 21, 2013).
//!
//! - [`Description`] makes a [`Model`] from surfaces (Section 4).
//! - [`Labels`] makes one from a labelled [`Scan`].
//! - [`Model`] holds nodes, elements, materials, muscles and how nodes are held.
//! - [`Simulation`] moves a model by total Lagrangian explicit dynamics (Miller et al. 2007) and finds its rest.
//! - [`SavedState`] is a state on disk; models are written and read by [`Model::write`] and [`Model::read`].
//! - [`Collider`] is a body that nodes do not enter; [`Binding`] a surface that follows the elements.

mod block;
mod build;
mod collider;
mod contact;
mod curve;
mod distance;
mod element;
mod files;
mod hexahedron;
mod material;
mod model;
mod options;
mod pressure;
mod self_contact;
mod simulation;
mod slide;
mod stable;
mod stress;

pub use build::BuildReport;
pub use build::bend::Bend;
pub use build::binding::{Anchor, Binding};
pub use build::labels::{Labels, Range};
pub use build::nurbs::NurbsMuscle;
pub use build::volume::{Description, FibreField, Layer, Restraint, Skin, Volume};
pub use collider::{Body, Collider, Pose};
pub use curve::Curve;
pub use distance::{Closest, DistanceField};
pub use files::archive::SavedState;
pub use files::inp_reader::InpModel;
pub use files::scan::Scan;
pub use material::{Material, Muscle};
pub use model::{Fibre, Held, Lists, Model, NodeSet, Portion, Shape, Sliding};
pub use options::{Drive, SimulationOptions};
pub use pressure::Pressure;
pub use simulation::{ElementState, Energies, Relaxation, Simulation, State};
pub use stable::Steps;
