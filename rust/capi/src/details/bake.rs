//! Bakes; see `include/relievo/bake.h`.

use std::ffi::{c_char, c_void};
use std::path::PathBuf;

use relievo_bake::triangles::{TriangleColors, TriangleQuantity, bake_triangles};
use relievo_bake::{
    Axes, BakeOptions, BakeReport, Colors, Handedness, Map, MapFormat, Meaning, Quantity, Scaling, Space, bake_watched,
    numbered, write_map,
};
use relievo_core::{Context, Error, ErrorKind, Progress, Result};
use relievo_surface::Surface;
use relievo_tiles::by_format;

use crate::border::array::text;
use crate::border::descriptor::{check_optional, read_optional, write_optional};
use crate::border::registry;
use crate::details::detail::{RLV_CHANNEL_COLOR, RLV_CHANNEL_TRACES, RlvDetail, missing};
use crate::details::view::{TileView, TriangleView, View, ViewKind};
use crate::runtime::context::{HostProgress, RLV_PROGRESS_CONTINUE, RlvProgress};

constants! {
    u32:
    RLV_BAKE_DISPLACEMENT = 0,
    RLV_BAKE_VECTOR = 1,
    RLV_BAKE_NORMAL = 2,
    RLV_BAKE_COLOR = 3,
    RLV_BAKE_MASK = 4,
    RLV_BAKE_CONTACT = 5,
    RLV_BAKE_DEPTH = 6,
    RLV_BAKE_TIME = 7,
    RLV_BAKE_TANGENT = 0,
    RLV_BAKE_OBJECT = 1,
    RLV_BAKE_TNB = 0,
    RLV_BAKE_TBN = 1,
    RLV_BAKE_OPENGL = 0,
    RLV_BAKE_DIRECTX = 1,
}

descriptor! {
    pub struct RlvBakeOptions {
        struct_size: u32,
        quantity: u32,
        width: u32,
        height: u32,
        is_udim: u32,
        gutter: u32,
        samples: u32,
        space: u32,
        axes: u32,
        handedness: u32,
        scale: f32,
        mid_level: f32,
        uv: *const c_char,
    }
}

descriptor! {
    pub struct RlvBakePicture {
        struct_size: u32,
        udim: u32,
        width: u32,
        height: u32,
        channels: u32,
        reserved: u32,
        pixels: *const f32,
        covered: *const u8,
    }
}

descriptor! {
    pub struct RlvBakeReport {
        struct_size: u32,
        picture_count: u32,
        covered_pixels: u64,
        gutter_pixels: u64,
        overlapping_pixels: u64,
        flat_tiles: usize,
        outside_count: usize,
        scale: f32,
        mid_level: f32,
    }
}

/// `RlvBakeReceiver`: a function that gets its user pointer and a picture.
pub type RlvBakeReceiver = Option<unsafe extern "C" fn(*mut c_void, *const RlvBakePicture) -> u32>;

/// The one of `list` with a number.
fn numbered_value<T: Copy>(name: &str, list: &[T], number: u32) -> Result<T> {
    list.get(number as usize).copied().ok_or_else(|| {
        Error::invalid(format!("there is no {name} {number}")).at(name).advise(format!("use 0 to {}", list.len() - 1))
    })
}

/// What of the options is passed on.
struct Given {
    quantity: u32,
    scale: f32,
    mid_level: f32,
}

/// What is asked for.
struct Request {
    given: Given,
    options: BakeOptions,
    uv: String,
    space: Space,
    axes: Axes,
    handedness: Handedness,
}

impl Request {
    /// # Safety
    /// `options` is NULL or a descriptor that starts with its size, whose text is NULL or NUL-terminated.
    unsafe fn read(options: *const RlvBakeOptions) -> Result<Self> {
        let default = RlvBakeOptions {
            struct_size: 0,
            quantity: RLV_BAKE_DISPLACEMENT,
            width: 2048,
            height: 2048,
            is_udim: 0,
            gutter: 16,
            samples: 1,
            space: RLV_BAKE_TANGENT,
            axes: RLV_BAKE_TNB,
            handedness: RLV_BAKE_OPENGL,
            scale: 0.0,
            mid_level: 0.0,
            uv: std::ptr::null(),
        };
        // SAFETY: promised by the caller.
        let given = unsafe { read_optional(options, default) }?;
        Ok(Self {
            given: Given { quantity: given.quantity, scale: given.scale, mid_level: given.mid_level },
            options: BakeOptions {
                size: [given.width, given.height],
                udim: given.is_udim != 0,
                gutter: given.gutter,
                samples: given.samples,
            },
            // SAFETY: promised by the caller.
            uv: if given.uv.is_null() { "uv" } else { unsafe { text("uv", given.uv) }? }.to_owned(),
            space: numbered_value("space", &[Space::Tangent, Space::Object], given.space)?,
            axes: numbered_value("axes", &[Axes::Tnb, Axes::Tbn], given.axes)?,
            handedness: numbered_value("handedness", &[Handedness::OpenGl, Handedness::DirectX], given.handedness)?,
        })
    }

    fn meaning(&self) -> Result<Meaning> {
        let all = [
            Meaning::Displacement,
            Meaning::Vector(self.space, self.axes),
            Meaning::Normal(self.space, self.handedness),
            Meaning::Color,
            Meaning::Mask,
            Meaning::Contact,
            Meaning::Depth,
            Meaning::Time,
        ];
        numbered_value("quantity", &all, self.given.quantity)
    }

    fn quantity<'a>(&self, view: &'a TileView) -> Result<Quantity<'a>> {
        let colors = || match &view.paint {
            Some(paint) => Ok(by_format!(paint, it => it.field() as &dyn Colors)),
            None => Err(missing(RLV_CHANNEL_COLOR)),
        };
        let traces = || view.traces.as_ref().map(|traces| traces.field()).ok_or_else(|| missing(RLV_CHANNEL_TRACES));
        Ok(match self.meaning()? {
            Meaning::Displacement => Quantity::Displacement(view.snapshot.field()),
            Meaning::Vector(space, axes) => Quantity::Vector(view.displaced()?, space, axes),
            Meaning::Normal(space, handedness) => Quantity::Normal(view.displaced()?, space, handedness),
            Meaning::Color => Quantity::Color(colors()?),
            Meaning::Mask => Quantity::Mask(colors()?),
            Meaning::Contact => Quantity::Contact(traces()?),
            Meaning::Depth => Quantity::Depth(traces()?),
            Meaning::Time => Quantity::Time(traces()?),
        })
    }

    fn of_triangles<'a>(&self, view: &'a TriangleView) -> Result<TriangleQuantity<'a>> {
        let meaning = self.meaning()?;
        let colors = view.paint.as_ref().map(|paint| by_format!(paint, it => it.field() as &dyn TriangleColors));
        let traces = view.traces.as_ref().map(|traces| traces.field());
        match meaning {
            Meaning::Color | Meaning::Mask if colors.is_none() => Err(missing(RLV_CHANNEL_COLOR)),
            Meaning::Contact | Meaning::Depth | Meaning::Time if traces.is_none() => Err(missing(RLV_CHANNEL_TRACES)),
            _ => Ok(TriangleQuantity { meaning, displaced: view.displaced()?, normals: &view.normals, colors, traces }),
        }
    }
}

/// Bakes what `request` asks for and gives `each` every picture, what its numbers are, and how files have them.
fn run(
    context: &Context,
    view: &View,
    request: &Request,
    scaling: impl FnOnce(Meaning, &dyn Fn() -> f32) -> Result<Scaling>,
    progress: &mut dyn Progress,
    mut each: impl FnMut(Map, Meaning, &Scaling) -> Result<()>,
) -> Result<RlvBakeReport> {
    let meaning = request.meaning()?;
    let (done, scaling): (BakeReport, Scaling) = match &view.layers {
        ViewKind::Tiles(tiles) => {
            let quantity = request.quantity(tiles)?;
            let scaling = scaling(meaning, &|| quantity.largest())?;
            let limit = Surface::face_varying(context, &view.cage, &request.uv, &tiles.options)?;
            let each = |map| each(map, meaning, &scaling);
            (bake_watched(context, &limit, &quantity, &request.options, progress, each)?, scaling)
        }
        ViewKind::Triangles(triangles) => {
            let quantity = request.of_triangles(triangles)?;
            let scaling = scaling(meaning, &|| quantity.largest())?;
            let each = |map| each(map, meaning, &scaling);
            let mesh = (&*view.cage, request.uv.as_str());
            (bake_triangles(context, mesh, &quantity, &request.options, progress, each)?, scaling)
        }
    };
    Ok(RlvBakeReport {
        struct_size: 0,
        picture_count: done.pictures.len() as u32,
        covered_pixels: done.covered,
        gutter_pixels: done.gutter,
        overlapping_pixels: done.overlapping,
        flat_tiles: done.flat,
        outside_count: done.outside,
        scale: scaling.scale,
        mid_level: scaling.mid_level,
    })
}

/// A bake to files.
pub struct Order {
    request: Request,
    path: PathBuf,
    format: MapFormat,
}

impl Order {
    /// Copies what was asked for.
    ///
    /// # Errors
    /// Fails with `Invalid` if an option is out of range or the path is no text, and with `Unsupported` if its
    /// extension is neither .exr nor .png.
    ///
    /// # Safety
    /// `options` is NULL or a descriptor that starts with its size, `path` a NUL-terminated text.
    pub unsafe fn read(options: *const RlvBakeOptions, path: *const c_char) -> Result<Self> {
        // SAFETY: promised by the caller.
        let (request, path) = unsafe { (Request::read(options)?, PathBuf::from(text("path", path)?)) };
        let format = MapFormat::of(&path)?;
        Ok(Self { request, path, format })
    }

    /// Bakes and writes every picture.
    ///
    /// # Errors
    /// Fails with `Invalid` if the detail does not have what is to be baked, or its texture coordinates cannot be used;
    /// with `Memory` if a picture does not fit the context's memory limit; with `NotFound` or `Io` if a file cannot be
    /// written; and with `Cancelled` if `progress` asks to stop.
    pub fn write(&self, context: &Context, view: &View, progress: &mut dyn Progress) -> Result<RlvBakeReport> {
        let Self { request, path, format } = self;
        let Given { scale, mid_level, .. } = request.given;
        let scaling = |meaning: Meaning, largest: &dyn Fn() -> f32| {
            let scaling = match scale {
                0.0 => Scaling::fitting(*format, meaning, largest()),
                _ => Scaling { scale, mid_level },
            };
            scaling.check().map(|()| scaling)
        };
        run(context, view, request, scaling, progress, |map, meaning, scaling| {
            let udim = request.options.udim.then(|| numbered(path, "<UDIM>", map.udim));
            write_map(context, udim.as_deref().unwrap_or(path), &map, meaning, scaling)
        })
    }
}

entry! {
    fn rlv_bake_run(
        detail: RlvDetail,
        options: *const RlvBakeOptions,
        receive: RlvBakeReceiver,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvBakeReport,
    ) {
        let receive = receive.ok_or_else(|| {
            Error::invalid("there is nobody to receive pictures").at("receive").advise("pass a function")
        })?;
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let request = unsafe {
            check_optional(report)?;
            Request::read(options)?
        };
        let detail = registry::get(detail)?;
        let progress = &mut HostProgress { callback: progress, user };
        let plain = |_: Meaning, _: &dyn Fn() -> f32| Ok(Scaling::PLAIN);
        let done = run(&detail.context.context, &detail.view(), &request, plain, progress, |map, _, _| {
            let picture = RlvBakePicture {
                struct_size: size_of::<RlvBakePicture>() as u32,
                udim: map.udim,
                width: map.width,
                height: map.height,
                channels: map.channels as u32,
                reserved: 0,
                pixels: map.data.as_ptr(),
                // A bool is a byte, 0 or 1.
                covered: map.covered.as_ptr().cast(),
            };
            // SAFETY: the host gave this function for this pointer, and the picture lives through the call.
            match unsafe { receive(user, &picture) } {
                RLV_PROGRESS_CONTINUE => Ok(()),
                _ => Err(Error::new(ErrorKind::Cancelled, "the caller cancelled the operation").at("receive")),
            }
        })?;
        // SAFETY: as above.
        unsafe { write_optional(report, done) }
    }

    fn rlv_bake_write(
        detail: RlvDetail,
        options: *const RlvBakeOptions,
        path: *const c_char,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvBakeReport,
    ) {
        // SAFETY: the caller gives a NUL-terminated text, and NULL or descriptors that start with their size.
        let order = unsafe {
            check_optional(report)?;
            Order::read(options, path)?
        };
        let detail = registry::get(detail)?;
        let done = order.write(&detail.context.context, &detail.view(), &mut HostProgress { callback: progress, user })?;
        // SAFETY: as above.
        unsafe { write_optional(report, done) }
    }
}
