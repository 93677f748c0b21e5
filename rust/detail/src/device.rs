//! Edits on a graphics device: the same passes as on the processor, in kernels.
//!
//! The stages of an imprint (Schäfer et al. 2014, Sections 5 and 6) leave what the next one needs on the device, and
//! where that is a number of items, it is the argument of an indirect dispatch: a frame's pairs can be one submission.

mod imprint;
mod paint;
mod state;

pub(crate) use imprint::chain::DeviceChain;
pub(crate) use imprint::job::{ImprintJob, MAX_JOBS};
pub(crate) use imprint::meshes::DeviceMeshes;
pub(crate) use imprint::triangle_imprint::{PressedValues, TriangleCast, TriangleChain, TriangleTarget};
pub(crate) use imprint::triangle_press::TrianglePress;
pub(crate) use imprint::{Batch, DeviceRow, Standing};
pub(crate) use paint::channels::{DeviceColor, edits_of, smudges_of};
pub(crate) use paint::dabs::{OnDevice, on_device, reports_of};
pub(crate) use paint::events::{DeviceValue, Returned, keep_rounded};
pub(crate) use paint::triangle_brush::{TriangleBrush, TriangleStage};
pub(crate) use state::DeviceObject;
