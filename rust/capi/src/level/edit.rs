//! What handles and anchors of edits are; see `include/relievo/level.h`.

use relievo_core::{Falloff, Result};
use relievo_lod::progressive::{Edit, Handle, Region};

use crate::array::{Input, Plain};
use crate::descriptor::{numbered, read_descriptor};

descriptor! {
    pub struct RlvLevelRegion {
        center: [f32; 3],
        radius: f32,
        falloff: u32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvLevelHandle {
        region: RlvLevelRegion,
        translation: [f32; 3],
        axis: [f32; 3],
        angle: f32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvLevelEdit {
        struct_size: u32,
        reserved: u32,
        handles: *const RlvLevelHandle,
        handle_count: usize,
        handle_stride: usize,
        anchors: *const RlvLevelRegion,
        anchor_count: usize,
        anchor_stride: usize,
    }
}

impl Default for RlvLevelRegion {
    fn default() -> Self {
        Self { center: [0.0; 3], radius: 0.0, falloff: 0, reserved: 0 }
    }
}

impl Default for RlvLevelHandle {
    fn default() -> Self {
        let region = RlvLevelRegion::default();
        Self { region, translation: [0.0; 3], axis: [0.0; 3], angle: 0.0, reserved: 0 }
    }
}

// SAFETY: words without padding, floats and integers.
unsafe impl Plain for RlvLevelRegion {}
// SAFETY: as above.
unsafe impl Plain for RlvLevelHandle {}

/// A region of influence; `place` says whose in messages.
fn region(given: &RlvLevelRegion, place: impl Fn() -> String) -> Result<Region> {
    let falloff = numbered("falloff", &Falloff::NAMES, given.falloff).map_err(|error| error.at(place()))?;
    Ok(Region { center: given.center, radius: given.radius, falloff })
}

/// What an edit does.
///
/// # Safety
/// `edit` is NULL or a descriptor whose arrays are as the header demands.
pub unsafe fn read_edit(edit: *const RlvLevelEdit) -> Result<Edit> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default: RlvLevelEdit = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(edit, default) }?;
    // SAFETY: promised by the caller.
    let (handles, anchors) = unsafe {
        (
            Input::new("handles", given.handles, given.handle_count, given.handle_stride)?,
            Input::new("anchors", given.anchors, given.anchor_count, given.anchor_stride)?,
        )
    };
    let handle = |(index, given): (usize, RlvLevelHandle)| {
        let region = region(&given.region, || format!("handle {index}"))?;
        Ok(Handle { region, translation: given.translation, axis: given.axis, angle: given.angle })
    };
    let anchor = |(index, given): (usize, RlvLevelRegion)| region(&given, || format!("anchor {index}"));
    Ok(Edit {
        handles: handles.iter().enumerate().map(handle).collect::<Result<_>>()?,
        anchors: anchors.iter().enumerate().map(anchor).collect::<Result<_>>()?,
    })
}
