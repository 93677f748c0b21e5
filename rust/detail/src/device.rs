//! Edits on a graphics device: the same passes as on the processor, in kernels.
//!
//! The stages of an imprint (Schäfer et al. 2014, Sections 5 and 6) leave what the next one needs on the device, and
//! where that is a number of items, it is the argument of an indirect dispatch: a frame's pairs can be one submission.

mod batches;
mod blocks;
mod brush;
mod chain;
mod channels;
mod cull;
mod dabs;
mod events;
mod follow;
mod imprint;
mod intersect;
mod link;
mod memory;
mod meshes;
mod moved;
mod rim;
mod shared;
mod slots;
mod smear;
mod smoothing;
mod stages;
mod state;
mod still;
mod triangle_brush;
mod triangle_imprint;
mod triangle_press;
mod triangle_rim;
mod triangle_smoothing;
mod voxel;

pub(crate) use chain::DeviceChain;
pub(crate) use channels::{DeviceColor, edits_of, smudges_of};
pub(crate) use dabs::{OnDevice, on_device, reports_of};
pub(crate) use events::{DeviceValue, Edit, Returned};
pub(crate) use imprint::{Batch, Imprinted, Standing};
pub(crate) use link::{Link, MOST_LINKS};
pub(crate) use meshes::DeviceMeshes;
pub(crate) use state::DeviceObject;
pub(crate) use triangle_brush::{TriangleBrush, TriangleStage};
pub(crate) use triangle_imprint::{PressedValues, TriangleCast, TriangleChain, TriangleTarget};
pub(crate) use triangle_press::TrianglePress;
