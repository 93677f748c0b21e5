//! What handles and anchors of edits are; see `include/relievo/level.h`.

use relievo_core::{Falloff, Result};
use relievo_lod::progressive::{Edit, Handle, HandleKey, KeyedEdit, KeyedHandle, Region};

use crate::border::array::{Input, Plain, narrow};
use crate::border::descriptor::{numbered, read_descriptor};

descriptor! {
    pub struct RlvLevelRegion {
        center: [f64; 3],
        radius: f32,
        falloff: u32,
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

descriptor! {
    pub struct RlvLevelKey {
        time: f64,
        translation: [f32; 3],
        axis: [f32; 3],
        angle: f32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvLevelTrack {
        region: RlvLevelRegion,
        keys: *const RlvLevelKey,
        key_count: usize,
        key_stride: usize,
    }
}

descriptor! {
    pub struct RlvLevelMotion {
        struct_size: u32,
        reserved: u32,
        tracks: *const RlvLevelTrack,
        track_count: usize,
        track_stride: usize,
        anchors: *const RlvLevelRegion,
        anchor_count: usize,
        anchor_stride: usize,
    }
}

impl Default for RlvLevelKey {
    fn default() -> Self {
        Self { time: 0.0, translation: [0.0; 3], axis: [0.0; 3], angle: 0.0, reserved: 0 }
    }
}

impl Default for RlvLevelTrack {
    fn default() -> Self {
        Self { region: RlvLevelRegion::default(), keys: std::ptr::null(), key_count: 0, key_stride: 0 }
    }
}

impl Default for RlvLevelRegion {
    fn default() -> Self {
        Self { center: [0.0; 3], radius: 0.0, falloff: 0 }
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
// SAFETY: as above.
unsafe impl Plain for RlvLevelKey {}
// SAFETY: as above, and a pointer that is checked before it is followed.
unsafe impl Plain for RlvLevelTrack {}

/// A region of influence; `place` says whose in messages.
fn region(given: &RlvLevelRegion, place: impl Fn() -> String) -> Result<Region> {
    let falloff = numbered("falloff", &Falloff::NAMES, given.falloff).map_err(|error| error.at(place()))?;
    Ok(Region { center: narrow(given.center), radius: given.radius, falloff })
}

/// What an edit does.
///
/// # Errors
/// Fails with `Invalid` if the descriptor is NULL, its `struct_size` is none of the type, an array cannot be used or
/// there is no such falloff, and with `Unsupported` if a field that this library lacks is not zero.
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

/// What an edit over time does.
///
/// # Errors
/// Fails with `Invalid` if the descriptor is NULL, its `struct_size` is none of the type, an array cannot be used,
/// there is no such falloff or the keys are not in order, and with `Unsupported` if a field that this library lacks is
/// not zero.
///
/// # Safety
/// `motion` is NULL or a descriptor whose arrays are as the header demands.
pub unsafe fn read_motion(motion: *const RlvLevelMotion) -> Result<KeyedEdit> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default: RlvLevelMotion = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(motion, default) }?;
    // SAFETY: promised by the caller.
    let (tracks, anchors) = unsafe {
        (
            Input::new("tracks", given.tracks, given.track_count, given.track_stride)?,
            Input::new("anchors", given.anchors, given.anchor_count, given.anchor_stride)?,
        )
    };
    let key =
        |key: RlvLevelKey| HandleKey { time: key.time, translation: key.translation, axis: key.axis, angle: key.angle };
    let track = |(index, given): (usize, RlvLevelTrack)| {
        let region = region(&given.region, || format!("handle {index}"))?;
        // SAFETY: promised by the caller.
        let keys = unsafe { Input::new("keys", given.keys, given.key_count, given.key_stride) };
        let keys = keys.map_err(|error| error.at(format!("handle {index}")))?.iter().map(key).collect();
        Ok(KeyedHandle { region, keys })
    };
    let anchor = |(index, given): (usize, RlvLevelRegion)| region(&given, || format!("anchor {index}"));
    let made = KeyedEdit {
        handles: tracks.iter().enumerate().map(track).collect::<Result<_>>()?,
        anchors: anchors.iter().enumerate().map(anchor).collect::<Result<_>>()?,
    };
    made.check().map(|()| made)
}
