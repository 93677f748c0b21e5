//! Views of crowds; see `include/relievo/crowd.h`.

use glam::DVec3;
use relievo_core::{Error, Result};
use relievo_crowd::{CrowdView, PixelView, ShadowSun};
use relievo_render::Camera;

use crate::border::array::{Input, Plain};
use crate::border::descriptor::read_descriptor;

#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct RlvCrowdSun {
    pub towards: [f64; 3],
    pub angular_radius: f64,
}

// SAFETY: doubles without padding.
unsafe impl Plain for RlvCrowdSun {}

descriptor! {
    pub struct RlvCrowdView before suns {
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
        suns: *const RlvCrowdSun,
        sun_count: usize,
        around: f64,
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

/// Returns the sun that C describes.
fn sun_of(given: &RlvCrowdSun) -> Result<ShadowSun> {
    let RlvCrowdSun { towards, angular_radius } = *given;
    let direction = DVec3::from(towards).try_normalize().ok_or_else(|| {
        Error::invalid("a sun has no direction").at("suns").advise("give a direction of finite length above 0")
    })?;
    if !(angular_radius >= 0.0 && angular_radius.is_finite()) {
        return Err(Error::invalid(format!("the angular radius of a sun is {angular_radius}"))
            .at("suns")
            .advise("use 0 or more radians"));
    }
    Ok(ShadowSun { towards: direction.as_vec3().to_array(), angular_radius: angular_radius as f32 })
}

/// Returns the view that C describes.
///
/// # Safety
/// `view` is NULL or a descriptor that starts with its size and has so many suns as it says.
pub(crate) unsafe fn view_of(view: *const RlvCrowdView) -> Result<Seen> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default: RlvCrowdView = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(view, default) }?;
    let RlvCrowdView { width, height, tolerance, eye, target, up, fov, time, occlusion, geomorph, impostors, .. } =
        given;
    // SAFETY: promised by the caller.
    let suns = unsafe { Input::new("suns", given.suns, given.sun_count, 0) }?;
    let suns = suns.iter().map(|sun| sun_of(&sun)).collect::<Result<Vec<_>>>()?;
    let around = given.around;
    if !(around >= 0.0 && around.is_finite()) {
        return Err(Error::invalid(format!("around is {around}")).at("view").advise("use 0 or more"));
    }
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
    if !suns.is_empty() || around > 0.0 {
        if pixels.is_some() {
            return Err(Error::invalid("agents that others hide throw shadows too")
                .at("view")
                .advise("set occlusion to 0, or give no suns and an around of 0"));
        }
        view = view.with_shadows(&suns, around as f32);
    }
    Ok(Seen { view, eye: camera.eye, pixels, time })
}
