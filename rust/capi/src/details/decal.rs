//! Decals; see `include/relievo/decal.h`.

mod recipe;

use std::ffi::c_void;
use std::sync::{Arc, RwLock};

use relievo_bake::Gutter;
use relievo_core::{Context, Error, Mesh, Progress, Result};
use relievo_decal::{
    Artwork, Contour, Decal, DecalSettings, Pin, Placement, Pose, Print, Printed, Sticker, TrianglePrint, nearest,
    paint_texture, strip, triangulated,
};
use relievo_detail::AnyObject;
use relievo_document::{Blend, Kind, Settings};
use relievo_render::Image;
use relievo_tiles::triangle::TriangleTessellation;
use relievo_tiles::{Tessellation, uniform_rates};

use crate::border::array::{Input, Output, Plain, present, put, put_optional};
use crate::border::descriptor::{check_optional, read_descriptor, read_optional, write_descriptor, write_optional};
use crate::border::registry::{self, handle, try_read, try_write};
use crate::details::detail::{
    DetailObject, RLV_CHANNEL_COLOR, RLV_CHANNEL_DISPLACEMENT, RLV_CHANNEL_VECTORS, RlvDetail,
};
use crate::details::layer::RLV_BLEND_NORMAL;
use crate::details::view::ViewKind;
use crate::runtime::context::{ContextObject, HostProgress, RlvProgress};
use crate::surfaces::mesh::{self, MeshObject, RlvMesh};

pub use recipe::*;

handle!(RlvDecal, 25, DecalObject);

descriptor! {
    pub struct RlvDecalPin {
        image: [f64; 2],
        position: [f64; 3],
        depth: f64,
    }
}

// SAFETY: six doubles without padding.
unsafe impl Plain for RlvDecalPin {}

impl Default for RlvDecalPin {
    fn default() -> Self {
        Self { image: [0.0; 2], position: [0.0; 3], depth: 0.0 }
    }
}

descriptor! {
    pub struct RlvDecalOptions {
        struct_size: u32,
        width: u32,
        height: u32,
        can_overlap: u32,
        outline: *const f64,
        outline_count: usize,
        outline_stride: usize,
        pose_width: f64,
        pose_up: [f64; 3],
        steps: u32,
        decrease: f32,
        triangles: u32,
        cells: u32,
    }
}

descriptor! {
    pub struct RlvDecalQuality {
        struct_size: u32,
        pin_count: u32,
        triangle_count: usize,
        flip_count: usize,
        overlap_count: usize,
        l2: f64,
        l_infinity: f64,
        worst_angle: f64,
        area_ratio: f64,
        coverage: f64,
        doubled: f64,
    }
}

descriptor! {
    pub struct RlvDecalImage {
        struct_size: u32,
        channels: u32,
        pixels: *const f32,
        pixel_count: usize,
    }
}

descriptor! {
    pub struct RlvDecalInk {
        struct_size: u32,
        channel: u32,
        blend: u32,
        opacity: f32,
        height: f32,
        reserved: u32,
    }
}

descriptor! {
    pub struct RlvDecalTexture {
        struct_size: u32,
        width: u32,
        height: u32,
        channels: u32,
        gutter: u32,
        reserved: u32,
        pixels: *mut f32,
        pixel_count: usize,
    }
}

descriptor! {
    pub struct RlvDecalReport {
        struct_size: u32,
        reserved: u32,
        changed_tiles: u64,
        texels: u64,
        refused_tiles: u64,
    }
}

/// A decal, and the detail that it lies on, if it is one.
pub struct DecalObject {
    context: Arc<ContextObject>,
    size: [u32; 2],
    detail: Option<(Arc<DetailObject>, Triangles)>,
    depths: Vec<f64>,
    pose: Option<Pose>,
    /// Cells along an edge of the cage that it lies on; 1 on triangle meshes.
    cells: u32,
    placement: RwLock<Placement>,
}

/// The triangles of a detail, with their places on its faces.
enum Triangles {
    Cage(Tessellation),
    Mesh(TriangleTessellation),
}

/// What of an image is written how.
#[derive(Clone, Copy)]
enum Writing {
    Color(Settings),
    Relief(f32, Settings),
    Vectors(f32, Settings),
}

/// What a sticker is laid on.
enum Ground {
    Mesh(Arc<MeshObject>),
    Detail(Arc<DetailObject>),
}

/// A sticker to be laid, with all that this needs copied.
pub struct Laying {
    ground: Ground,
    size: [u32; 2],
    sticker: Sticker,
    pins: Vec<RlvDecalPin>,
    pose: Option<Pose>,
    settings: DecalSettings,
    cells: u32,
}

impl Laying {
    /// Copies what a decal on a mesh needs.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, or an option, the outline or the array of pins cannot be used,
    /// and with `Memory` if the pins exceed the context's memory limit.
    ///
    /// # Safety
    /// `options` is NULL or a descriptor that starts with its size, with an outline of its count, and `count` pins can be
    /// read at `stride` bytes from one another.
    pub unsafe fn on_mesh(
        mesh: RlvMesh,
        options: *const RlvDecalOptions,
        pins: *const RlvDecalPin,
        count: usize,
        stride: usize,
    ) -> Result<Self> {
        let ground = Ground::Mesh(registry::get(mesh)?);
        // SAFETY: promised by the caller.
        unsafe { Self::read(ground, options, pins, count, stride) }
    }

    /// Copies what a decal on a detail needs.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive, or an option, the outline or the array of pins cannot be used,
    /// and with `Memory` if the pins exceed the context's memory limit.
    ///
    /// # Safety
    /// As for [`Self::on_mesh`].
    pub unsafe fn on_detail(
        detail: RlvDetail,
        options: *const RlvDecalOptions,
        pins: *const RlvDecalPin,
        count: usize,
        stride: usize,
    ) -> Result<Self> {
        let ground = Ground::Detail(registry::get(detail)?);
        // SAFETY: promised by the caller.
        unsafe { Self::read(ground, options, pins, count, stride) }
    }

    /// # Safety
    /// As for [`Self::on_mesh`].
    unsafe fn read(
        ground: Ground,
        options: *const RlvDecalOptions,
        pins: *const RlvDecalPin,
        count: usize,
        stride: usize,
    ) -> Result<Self> {
        let default = RlvDecalOptions::default();
        let limit = ground.context().context.memory_limit();
        // SAFETY: promised by the caller.
        let (given, pins) = unsafe {
            (read_optional(options, default)?, Input::new("pins", pins, count, stride)?.to_vec("pins", limit)?)
        };
        let size = [given.width, given.height];
        // SAFETY: promised by the caller.
        let sticker = unsafe { sticker(&given, limit) }?;
        let pose = (given.pose_width != 0.0).then_some(Pose { width: given.pose_width, up: given.pose_up });
        let settings = DecalSettings {
            steps: given.steps,
            decrease: f64::from(given.decrease),
            triangles: given.triangles,
            overlap: given.can_overlap != 0,
        };
        check_cells(given.cells)?;
        Ok(Self { ground, size, sticker, pins, pose, settings, cells: given.cells })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        self.ground.context()
    }

    /// Lays the sticker and registers the decal.
    ///
    /// # Errors
    /// Fails with `Busy` if the mesh is being changed, with `Invalid` if a pin is not finite or the sticker cannot be
    /// laid so, with `Memory` if triangles exceed the memory limit, and with `Cancelled` if `progress` asks to stop.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<RlvDecal> {
        let Self { ground, size, sticker, pins, pose, settings, cells } = self;
        let mut place = |mesh: &Mesh| -> Result<Placement> {
            let mut placed = Vec::with_capacity(pins.len());
            for (index, pin) in pins.iter().enumerate() {
                let found = nearest(mesh, pin.position).map_err(|error| error.at(format!("pin {index}")))?;
                placed.push(Pin { image: pin.image, place: found.0 });
            }
            Placement::new(mesh, sticker, &placed, *pose, settings, progress)
        };
        let mut cells = *cells;
        let (detail, placement) = match ground {
            Ground::Mesh(object) => {
                let mesh = try_read(&object.mesh, "mesh")?;
                (None, place(&triangulated(&mesh))?)
            }
            Ground::Detail(object) => {
                let triangles = tessellate(&object.context.context, object, cells)?;
                if matches!(triangles, Triangles::Mesh(_)) {
                    cells = 1;
                }
                let placement = place(triangles.mesh())?;
                (Some((object.clone(), triangles)), placement)
            }
        };
        registry::insert(DecalObject {
            context: self.context().clone(),
            size: *size,
            detail,
            depths: pins.iter().map(|pin| pin.depth).collect(),
            pose: *pose,
            cells,
            placement: RwLock::new(placement),
        })
    }
}

impl Ground {
    fn context(&self) -> &Arc<ContextObject> {
        match self {
            Self::Mesh(mesh) => &mesh.context,
            Self::Detail(detail) => &detail.context,
        }
    }
}

/// Fails unless an edge of the cage can have so many cells.
fn check_cells(cells: u32) -> Result<()> {
    if cells.is_power_of_two() {
        return Ok(());
    }
    Err(Error::invalid(format!("there are {cells} cells")).at("cells").advise("use a power of two"))
}

impl Triangles {
    fn mesh(&self) -> &Mesh {
        match self {
            Self::Cage(made) => &made.mesh,
            Self::Mesh(made) => &made.mesh,
        }
    }
}

/// The displaced surface of a detail as it was committed last.
fn tessellate(context: &Context, detail: &DetailObject, cells: u32) -> Result<Triangles> {
    let view = detail.view();
    match &view.layers {
        ViewKind::Tiles(tiles) => {
            let rates = uniform_rates(tiles.surface.topology(), cells);
            Ok(Triangles::Cage(tiles.displaced()?.tessellate(context, &view.cage, &rates)?))
        }
        ViewKind::Triangles(mesh) => {
            let (displaced, rates) = (mesh.displaced()?, |face| mesh.rates(face));
            Ok(Triangles::Mesh(TriangleTessellation::new(context, &displaced, &mesh.normals, &view.cage, rates)?))
        }
    }
}

impl DecalObject {
    fn decal(&self) -> Result<Decal> {
        Ok(try_read(&self.placement, "decal")?.decal())
    }

    /// Reads the pixels of the sticker's image.
    ///
    /// # Safety
    /// `image` is NULL or a descriptor that starts with its size, with pixels of their count.
    unsafe fn image(&self, image: *const RlvDecalImage) -> Result<Image> {
        // SAFETY: promised by the caller.
        unsafe { pixels(image, self.size, self.context.context.memory_limit()) }
    }

    /// Writes the decal into its detail.
    ///
    /// # Safety
    /// `image` is NULL or a descriptor that starts with its size, with pixels of their count, and `report` NULL or a
    /// descriptor that starts with its size.
    unsafe fn write(&self, image: *const RlvDecalImage, report: *mut RlvDecalReport, writing: Writing) -> Result<()> {
        // SAFETY: promised by the caller.
        unsafe { check_optional(report) }?;
        let Some((detail, triangles)) = &self.detail else {
            return Err(Error::invalid("it lies on a mesh").at("decal").advise("lay it with rlv_decal_on_detail"));
        };
        // SAFETY: promised by the caller.
        let image = unsafe { self.image(image) }?;
        let placement = try_read(&self.placement, "decal")?;
        let artwork = Artwork::new(placement.sticker(), &image)?;
        let decal = placement.decal();
        drop(placement);
        let mut editor = detail.edit()?;
        let context = &self.context.context;
        let (decal, artwork, depths) = (&decal, &artwork, self.depths.as_slice());
        let done: Result<Printed> = match (&mut editor.object, triangles) {
            (AnyObject::Tiles(object), Triangles::Cage(tessellation)) => {
                let print = Print { context, tessellation, decal, artwork, depths };
                match writing {
                    Writing::Color(settings) => print.paint(object, &settings),
                    Writing::Relief(height, settings) => print.emboss(object, height, &settings),
                    Writing::Vectors(height, settings) => print.displace(object, height, &settings),
                }
            }
            (AnyObject::Triangles(object), Triangles::Mesh(ground)) => {
                let print = TrianglePrint { context, ground, decal, artwork, depths };
                match writing {
                    Writing::Color(settings) => print.paint(object, &settings),
                    Writing::Relief(height, settings) => print.emboss(object, height, &settings),
                    Writing::Vectors(height, settings) => print.displace(object, height, &settings),
                }
            }
            _ => Err(Error::internal("a decal lies on another kind of surface")),
        };
        detail.leave(editor);
        let done = done?;
        let made = RlvDecalReport {
            struct_size: 0,
            reserved: 0,
            changed_tiles: done.tiles.len() as u64,
            texels: done.texels,
            refused_tiles: done.refused.len() as u64,
        };
        // SAFETY: promised by the caller.
        unsafe { write_optional(report, made) }
    }
}

impl Default for RlvDecalOptions {
    fn default() -> Self {
        let DecalSettings { steps, decrease, triangles, .. } = DecalSettings::default();
        Self {
            struct_size: 0,
            width: 0,
            height: 0,
            can_overlap: 0,
            outline: std::ptr::null(),
            outline_count: 0,
            outline_stride: 0,
            pose_width: 0.0,
            pose_up: [0.0, 1.0, 0.0],
            steps,
            decrease: decrease as f32,
            triangles,
            cells: 8,
        }
    }
}

/// Reads the sticker of options: its image's size and its outline.
///
/// # Safety
/// The outline of `options` is NULL or has its count of corners.
unsafe fn sticker(options: &RlvDecalOptions, limit: u64) -> Result<Sticker> {
    let size = [options.width, options.height];
    let corners = options.outline.cast::<[f64; 2]>();
    // SAFETY: promised by the caller.
    let outline = unsafe { Input::optional("outline", corners, options.outline_count, options.outline_stride) }?;
    match outline {
        Some(corners) => Sticker::new(size, corners.to_vec("outline", limit)?),
        None => Sticker::whole(size),
    }
}

/// Reads the pixels of an image of `size` columns and rows.
///
/// # Safety
/// `image` is NULL or a descriptor that starts with its size, with pixels of their count.
unsafe fn pixels(image: *const RlvDecalImage, size: [u32; 2], limit: u64) -> Result<Image> {
    let default = RlvDecalImage { struct_size: 0, channels: 4, pixels: std::ptr::null(), pixel_count: 0 };
    // SAFETY: promised by the caller.
    let image = unsafe { read_descriptor(image, default) }?;
    let pixels = (size[0] as usize).saturating_mul(size[1] as usize);
    if image.pixel_count != pixels || ![1, 3, 4].contains(&image.channels) {
        return Err(Error::invalid(format!("it has {} pixels of {} channels", image.pixel_count, image.channels))
            .at("image")
            .advise(format!("pass {pixels} pixels of 1, 3 or 4 channels")));
    }
    let count = pixels.saturating_mul(image.channels as usize);
    // SAFETY: promised by the caller.
    let data = unsafe { Input::new("pixels", image.pixels, count, 0) }?.to_vec("pixels", limit)?;
    Image::from_data(size[0], size[1], image.channels, data)
}

/// Writes pins for a strip along a curve on a mesh of triangles.
///
/// # Safety
/// As for `rlv_decal_strip_on_mesh`, but for the surface; `pin_count` is not NULL.
unsafe fn write_strip(
    mesh: &Mesh,
    limit: u64,
    options: *const RlvDecalOptions,
    (curve, count, stride): (*const f64, usize, usize),
    (pins, capacity): (*mut RlvDecalPin, usize),
    pin_count: *mut usize,
    length: *mut f64,
) -> Result<()> {
    // SAFETY: promised by the caller.
    let (sticker, places, out) = unsafe {
        let options = read_optional(options, RlvDecalOptions::default())?;
        (
            sticker(&options, limit)?,
            Input::new("curve", curve.cast::<[f64; 3]>(), count, stride)?.to_vec("curve", limit)?,
            Output::optional("pins", pins, capacity, 0)?,
        )
    };
    let place = |(index, position): (usize, &[f64; 3])| -> Result<_> {
        Ok(nearest(mesh, *position).map_err(|error| error.at(format!("place {index} of the curve")))?.0)
    };
    let places = places.iter().enumerate().map(place).collect::<Result<Vec<_>>>()?;
    let made = strip(mesh, &sticker, &places)?;
    // SAFETY: promised by the caller; a length that is not NULL is room for one.
    unsafe {
        put(pin_count, made.pins.len());
        if !length.is_null() {
            put(length, made.length);
        }
    }
    if let Some(out) = out {
        let position = |pin: &Pin| -> [f64; 3] {
            let corners = &mesh.corners[3 * pin.place.face as usize..3 * pin.place.face as usize + 3];
            std::array::from_fn(|axis| {
                let weighted = corners.iter().zip(pin.place.barycentric);
                weighted.map(|(point, weight)| weight * f64::from(mesh.points[*point as usize][axis])).sum()
            })
        };
        let pin = |pin: &Pin| RlvDecalPin { image: pin.image, position: position(pin), depth: 0.0 };
        out.holds("pins", made.pins.len())?.fill(made.pins.iter().map(pin));
    }
    Ok(())
}

/// Reads `N` numbers.
///
/// # Safety
/// `pointer` is NULL or has so many numbers.
unsafe fn numbers<const N: usize>(name: &str, pointer: *const f64) -> Result<[f64; N]> {
    // SAFETY: promised by the caller.
    let input = unsafe { Input::new(name, pointer, N, 0) }?;
    Ok(std::array::from_fn(|index| input.get(index)))
}

/// Reads what a decal puts on a channel, NULL for its initial values, and how that is seen.
///
/// # Safety
/// `ink` is NULL or a descriptor that starts with its size.
unsafe fn read_ink(ink: *const RlvDecalInk) -> Result<(RlvDecalInk, Settings)> {
    let default = RlvDecalInk {
        struct_size: 0,
        channel: RLV_CHANNEL_COLOR,
        blend: RLV_BLEND_NORMAL,
        opacity: 1.0,
        height: 0.0,
        reserved: 0,
    };
    // SAFETY: promised by the caller.
    let ink = unsafe { read_optional(ink, default) }?;
    let (blend, _) = Blend::NAMES.get(ink.blend as usize).ok_or_else(|| {
        Error::invalid(format!("there is no blend mode {}", ink.blend)).at("ink").advise("use an RLV_BLEND_ value")
    })?;
    let settings = Settings { opacity: ink.opacity, blend: *blend, visible: true };
    Ok((ink, settings))
}

entry! {
    fn rlv_decal_on_mesh(
        mesh: RlvMesh,
        options: *const RlvDecalOptions,
        pins: *const RlvDecalPin,
        count: usize,
        stride: usize,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvDecal,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, and `count` pins.
        let laying = unsafe { Laying::on_mesh(mesh, options, pins, count, stride) }?;
        let made = laying.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_decal_on_detail(
        detail: RlvDetail,
        options: *const RlvDecalOptions,
        pins: *const RlvDecalPin,
        count: usize,
        stride: usize,
        progress: RlvProgress,
        user: *mut c_void,
        out: *mut RlvDecal,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, and `count` pins.
        let laying = unsafe { Laying::on_detail(detail, options, pins, count, stride) }?;
        let made = laying.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_decal_retain(decal: RlvDecal) {
        registry::retain(decal)
    }

    fn rlv_decal_release(decal: RlvDecal) {
        registry::release(decal)
    }

    fn rlv_decal_quality(decal: RlvDecal, out: *mut RlvDecalQuality) {
        let object = registry::get(decal)?;
        let quality = object.decal()?.quality;
        let made = RlvDecalQuality {
            struct_size: 0,
            pin_count: object.depths.len() as u32,
            triangle_count: quality.triangles,
            flip_count: quality.flips,
            overlap_count: quality.overlaps,
            l2: quality.l2,
            l_infinity: quality.l_infinity,
            worst_angle: quality.worst_angle,
            area_ratio: quality.area_ratio,
            coverage: quality.coverage,
            doubled: quality.doubled,
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, made) }
    }

    fn rlv_decal_mesh(decal: RlvDecal, offset: f64, out: *mut RlvMesh) {
        present("out", out)?;
        if !offset.is_finite() {
            return Err(Error::invalid("it is not finite").at("offset").advise("pass a length"));
        }
        let object = registry::get(decal)?;
        let mesh = object.decal()?.mesh(offset);
        mesh.check()?;
        let made = mesh::register(object.context.clone(), mesh)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_decal_drag_pin(decal: RlvDecal, pin: usize, position: *const f64) {
        let object = registry::get(decal)?;
        // SAFETY: the caller gives NULL or three numbers.
        let position = unsafe { numbers::<3>("position", position) }?;
        let mut placement = try_write(&object.placement, "decal")?;
        let (place, _) = nearest(placement.mesh(), position)?;
        placement.drag(pin, place)
    }

    fn rlv_decal_move_image(decal: RlvDecal, pin: usize, image: *const f64, progress: RlvProgress, user: *mut c_void) {
        let object = registry::get(decal)?;
        // SAFETY: the caller gives NULL or two numbers.
        let image = unsafe { numbers::<2>("image", image) }?;
        try_write(&object.placement, "decal")?.move_image(pin, image, &mut HostProgress { callback: progress, user })
    }

    fn rlv_decal_pose(
        decal: RlvDecal,
        points: *const f32,
        count: usize,
        stride: usize,
        progress: RlvProgress,
        user: *mut c_void,
    ) {
        let object = registry::get(decal)?;
        if object.detail.is_some() {
            return Err(Error::invalid("it lies on a detail").at("decal").advise("pose the detail, and lay it anew"));
        }
        let limit = object.context.context.memory_limit();
        // SAFETY: the caller promises `count` points.
        let points = unsafe { Input::new("points", points.cast::<[f32; 3]>(), count, stride) }?.to_vec("points", limit)?;
        try_write(&object.placement, "decal")?.pose(&points, &mut HostProgress { callback: progress, user })
    }

    fn rlv_decal_settle(decal: RlvDecal, progress: RlvProgress, user: *mut c_void) {
        let object = registry::get(decal)?;
        try_write(&object.placement, "decal")?.settle(&mut HostProgress { callback: progress, user })
    }

    fn rlv_decal_paint(decal: RlvDecal, image: *const RlvDecalImage, opacity: f32, report: *mut RlvDecalReport) {
        let object = registry::get(decal)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size, with pixels of their count.
        unsafe { object.write(image, report, Writing::Color(Settings { opacity, ..Settings::of(Kind::Rgba8) })) }
    }

    fn rlv_decal_emboss(decal: RlvDecal, image: *const RlvDecalImage, height: f32, report: *mut RlvDecalReport) {
        let object = registry::get(decal)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size, with pixels of their count.
        unsafe { object.write(image, report, Writing::Relief(height, Settings::of(Kind::Scalar))) }
    }

    fn rlv_decal_write(
        decal: RlvDecal,
        image: *const RlvDecalImage,
        ink: *const RlvDecalInk,
        report: *mut RlvDecalReport,
    ) {
        let object = registry::get(decal)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let (ink, settings) = unsafe { read_ink(ink) }?;
        let writing = match ink.channel {
            RLV_CHANNEL_COLOR => Writing::Color(settings),
            RLV_CHANNEL_DISPLACEMENT => Writing::Relief(ink.height, settings),
            RLV_CHANNEL_VECTORS => Writing::Vectors(ink.height, settings),
            other => {
                return Err(Error::invalid(format!("decals are not written into channel {other}"))
                    .at("ink")
                    .advise("use colour, displacement or vectors"));
            }
        };
        // SAFETY: the caller gives NULL or descriptors that start with their size, with pixels of their count.
        unsafe { object.write(image, report, writing) }
    }

    fn rlv_decal_paint_texture(
        decal: RlvDecal,
        image: *const RlvDecalImage,
        opacity: f32,
        texture: *const RlvDecalTexture,
        painted: *mut usize,
    ) {
        let object = registry::get(decal)?;
        let default = RlvDecalTexture {
            struct_size: 0,
            width: 0,
            height: 0,
            channels: 3,
            gutter: 8,
            reserved: 0,
            pixels: std::ptr::null_mut(),
            pixel_count: 0,
        };
        let context = &object.context.context;
        // SAFETY: the caller gives NULL or descriptors that start with their size, with pixels of their count.
        let (image, texture) = unsafe { (object.image(image)?, read_descriptor(texture, default)?) };
        let RlvDecalTexture { width, height, channels, .. } = texture;
        let pixels = (width as usize).saturating_mul(height as usize);
        if pixels == 0 || texture.pixel_count != pixels || !(1..=4).contains(&channels) || texture.gutter > 256 {
            return Err(Error::invalid(format!(
                "{width} x {height} pixels of {channels} channels and a gutter of {} were given in {} pixels",
                texture.gutter, texture.pixel_count
            ))
            .at("texture")
            .advise("pass width times height pixels of 1 to 4 channels, and a gutter of at most 256"));
        }
        let count = pixels.saturating_mul(channels as usize);
        // SAFETY: the caller gives so many pixels, to be read and written.
        let (data, out) = unsafe {
            let read = Input::new("pixels", texture.pixels.cast_const(), count, 0)?;
            (read.to_vec("pixels", context.memory_limit())?, Output::new("pixels", texture.pixels, count, 0)?)
        };
        let mut canvas = Image::from_data(width, height, channels, data)?;
        let placement = try_read(&object.placement, "decal")?;
        let artwork = Artwork::new(placement.sticker(), &image)?;
        let (mesh, made) = (placement.mesh(), placement.decal());
        let done = paint_texture(context, mesh, &made, &artwork, &object.depths, opacity, &mut canvas)?;
        let (gutter, size) = (Gutter::new(&done.covered, width as usize, texture.gutter), channels as usize);
        for (to, from) in gutter.copies {
            let (to, from) = (to as usize, from as usize);
            if done.painted[from] {
                canvas.data_mut().copy_within(size * from..size * (from + 1), size * to);
            }
        }
        out.fill(canvas.data().iter().copied());
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(painted, done.painted.iter().filter(|is_painted| **is_painted).count()) };
        Ok(())
    }

    fn rlv_decal_contour(
        image: *const RlvDecalImage,
        width: u32,
        height: u32,
        level: f64,
        tolerance: f64,
        corners: *mut f64,
        capacity: usize,
        count: *mut usize,
    ) {
        present("count", count)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, with pixels of their count, and room for
        // `capacity` corners, or NULL to ask for the count alone.
        let (image, out) = unsafe {
            let out = Output::optional("corners", corners.cast::<[f64; 2]>(), capacity, 0)?;
            (pixels(image, [width, height], u64::MAX)?, out)
        };
        let found = Sticker::of_alpha(&image, &Contour { level, tolerance })?.corners();
        // SAFETY: checked above.
        unsafe { put(count, found.len()) };
        if let Some(out) = out {
            out.holds("corners", found.len())?.fill(found.iter().copied());
        }
        Ok(())
    }

    fn rlv_decal_strip_on_mesh(
        mesh: RlvMesh,
        options: *const RlvDecalOptions,
        curve: *const f64,
        count: usize,
        stride: usize,
        pins: *mut RlvDecalPin,
        capacity: usize,
        pin_count: *mut usize,
        length: *mut f64,
    ) {
        present("pin_count", pin_count)?;
        let object = registry::get(mesh)?;
        let limit = object.context.context.memory_limit();
        let triangles = triangulated(&*try_read(&object.mesh, "mesh")?);
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, `count` places, room for `capacity` pins
        // or NULL, and for a length or NULL.
        unsafe {
            write_strip(&triangles, limit, options, (curve, count, stride), (pins, capacity), pin_count, length)
        }
    }

    fn rlv_decal_strip_on_detail(
        detail: RlvDetail,
        options: *const RlvDecalOptions,
        curve: *const f64,
        count: usize,
        stride: usize,
        pins: *mut RlvDecalPin,
        capacity: usize,
        pin_count: *mut usize,
        length: *mut f64,
    ) {
        present("pin_count", pin_count)?;
        let object = registry::get(detail)?;
        let context = &object.context.context;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_optional(options, RlvDecalOptions::default()) }?;
        check_cells(given.cells)?;
        let ground = tessellate(context, &object, given.cells)?;
        let limit = context.memory_limit();
        // SAFETY: the caller gives NULL or a descriptor that starts with its size, `count` places, room for `capacity` pins
        // or NULL, and for a length or NULL.
        unsafe {
            write_strip(ground.mesh(), limit, options, (curve, count, stride), (pins, capacity), pin_count, length)
        }
    }
}
