//! Views of crowds; see `include/relievo/crowd.h`.

use glam::DVec3;
use relievo_core::{Error, Result};
use relievo_crowd::{CrowdView, PixelView};
use relievo_render::Camera;

use crate::border::descriptor::read_descriptor;

descriptor! {
    pub struct RlvCrowdView {
        struct_size: u32,
        width: u32,
        height: u32,
        tolerance: f32,
        eye: [f64; 3],
        target: [f64; 3],
        up: [f64; 3],
        fov: f64,
        time: f64,
        occlusion: u32,
        geomorph: u32,
        impostors: u32,
        reserved: u32,
    }
}

/// A view that C describes.
pub(crate) struct Seen {
    pub view: CrowdView,
    pub eye: DVec3,
    /// The same for culling by occlusion, where that is asked for.
    pub pixels: Option<PixelView>,
    pub time: f64,
}

/// Returns the view that C describes.
///
/// # Safety
/// `view` is NULL or a descriptor that starts with its size.
pub(crate) unsafe fn view_of(view: *const RlvCrowdView) -> Result<Seen> {
    // SAFETY: a descriptor of nothing but numbers.
    let default: RlvCrowdView = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(view, default) }?;
    let RlvCrowdView { width, height, tolerance, eye, target, up, fov, time, occlusion, geomorph, impostors, .. } =
        given;
    if width == 0 || height == 0 {
        return Err(Error::invalid("the picture has no pixels").at("view").advise("set width and height"));
    }
    if !time.is_finite() {
        return Err(Error::invalid("the time is not finite").at("view").advise("give seconds"));
    }
    let camera = Camera::look_at(DVec3::from(eye), DVec3::from(target), DVec3::from(up), fov)?;
    let is_on = |name: &str, value: u32| match value {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(Error::invalid(format!("{name} is {other}")).at("view").advise("set it to 0 or 1")),
    };
    let mut view = CrowdView::perspective(camera.eye, camera.axes, camera.fov, [width, height], tolerance)?;
    view.geomorph = is_on("geomorph", geomorph)?;
    view.impostors = is_on("impostors", impostors)?;
    let pixels = PixelView { eye: camera.eye, axes: camera.axes, fov: camera.fov, size: [width, height] };
    let pixels = is_on("occlusion", occlusion)?.then_some(pixels);
    Ok(Seen { view, eye: camera.eye, pixels, time })
}
