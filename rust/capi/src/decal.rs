//! Decals; see `include/relievo/decal.h`.

use std::ffi::c_void;
use std::sync::{Arc, RwLock};

use relievo_core::{Context, Error, Mesh, Progress, Result};
use relievo_decal::{Artwork, Decal, DecalSettings, Pin, Placement, Pose, Printed, Sticker, emboss, nearest, paint};
use relievo_detail::DisplacedObject;
use relievo_render::Image;
use relievo_tiles::{Tessellation, uniform_rates};

use crate::array::{Input, Plain, present, put};
use crate::context::{ContextObject, HostProgress, RlvProgress};
use crate::descriptor::{check_optional, read_descriptor, read_optional, write_descriptor, write_optional};
use crate::detail::{DetailObject, RlvDetail};
use crate::mesh::{self, MeshObject, RlvMesh};
use crate::registry::{self, handle, try_read, try_write};
use crate::shape::only_cages;
use crate::view::Layers;

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
    detail: Option<(Arc<DetailObject>, Tessellation)>,
    depths: Vec<f64>,
    placement: RwLock<Placement>,
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
        let base = DecalSettings::default();
        let default = RlvDecalOptions {
            struct_size: 0,
            width: 0,
            height: 0,
            can_overlap: 0,
            outline: std::ptr::null(),
            outline_count: 0,
            outline_stride: 0,
            pose_width: 0.0,
            pose_up: [0.0, 1.0, 0.0],
            steps: base.steps,
            decrease: base.decrease as f32,
            triangles: base.triangles,
            cells: 8,
        };
        // SAFETY: promised by the caller.
        let given = unsafe { read_optional(options, default) }?;
        let limit = ground.context().context.memory_limit();
        // SAFETY: promised by the caller.
        let (outline, pins) = unsafe {
            (
                Input::optional(
                    "outline",
                    given.outline.cast::<[f64; 2]>(),
                    given.outline_count,
                    given.outline_stride,
                )?,
                Input::new("pins", pins, count, stride)?.to_vec("pins", limit)?,
            )
        };
        let size = [given.width, given.height];
        let sticker = match outline {
            Some(corners) => Sticker::new(size, corners.to_vec("outline", limit)?)?,
            None => Sticker::whole(size)?,
        };
        let pose = (given.pose_width != 0.0).then_some(Pose { width: given.pose_width, up: given.pose_up });
        let settings = DecalSettings {
            steps: given.steps,
            decrease: f64::from(given.decrease),
            triangles: given.triangles,
            overlap: given.can_overlap != 0,
        };
        if !given.cells.is_power_of_two() {
            return Err(Error::invalid(format!("there are {} cells", given.cells))
                .at("cells")
                .advise("use a power of two"));
        }
        Ok(Self { ground, size, sticker, pins, pose, settings, cells: given.cells })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        self.ground.context()
    }

    /// Lays the sticker and registers the decal.
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
        let (detail, placement) = match ground {
            Ground::Mesh(object) => {
                let mesh = try_read(&object.mesh, "mesh")?;
                let triangles = mesh.triangles();
                (None, place(&Mesh::from_triangles(mesh.points.clone(), &triangles))?)
            }
            Ground::Detail(object) => {
                let tessellation = tessellate(&object.context.context, object, *cells)?;
                let placement = place(&tessellation.mesh)?;
                (Some((object.clone(), tessellation)), placement)
            }
        };
        registry::insert(DecalObject {
            context: self.context().clone(),
            size: *size,
            detail,
            depths: pins.iter().map(|pin| pin.depth).collect(),
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

/// The displaced surface of a detail as it was committed last.
fn tessellate(context: &Context, detail: &DetailObject, cells: u32) -> Result<Tessellation> {
    let view = detail.view();
    let Layers::Tiles(tiles) = &view.layers else { return Err(only_cages("decals")) };
    let rates = uniform_rates(tiles.surface.topology(), cells);
    tiles.displaced()?.tessellate(context, &view.cage, &rates)
}

impl DecalObject {
    fn decal(&self) -> Result<Decal> {
        Ok(try_read(&self.placement, "decal")?.decal())
    }

    /// Writes the decal into its detail by `write`.
    ///
    /// # Safety
    /// `image` is NULL or a descriptor that starts with its size, with pixels of their count, and `report` NULL or a
    /// descriptor that starts with its size.
    unsafe fn write(
        &self,
        image: *const RlvDecalImage,
        report: *mut RlvDecalReport,
        write: impl FnOnce(&Context, &mut DisplacedObject, &Tessellation, &Decal, &Artwork) -> Result<Printed>,
    ) -> Result<()> {
        let default = RlvDecalImage { struct_size: 0, channels: 4, pixels: std::ptr::null(), pixel_count: 0 };
        // SAFETY: promised by the caller.
        let image = unsafe {
            check_optional(report)?;
            read_descriptor(image, default)?
        };
        let Some((detail, tessellation)) = &self.detail else {
            return Err(Error::invalid("it lies on a mesh").at("decal").advise("lay it with rlv_decal_on_detail"));
        };
        let pixels = self.size.map(|side| side as usize).iter().product::<usize>();
        if image.pixel_count != pixels || ![1, 3, 4].contains(&image.channels) {
            return Err(Error::invalid(format!("it has {} pixels of {} channels", image.pixel_count, image.channels))
                .at("image")
                .advise(format!("pass {pixels} pixels of 1, 3 or 4 channels")));
        }
        let context = &self.context.context;
        let count = pixels.saturating_mul(image.channels as usize);
        // SAFETY: promised by the caller.
        let data = unsafe { Input::new("pixels", image.pixels, count, 0) }?.to_vec("pixels", context.memory_limit())?;
        let image = Image::from_data(self.size[0], self.size[1], image.channels, data)?;
        let placement = try_read(&self.placement, "decal")?;
        let artwork = Artwork::new(placement.sticker(), &image)?;
        let decal = placement.decal();
        drop(placement);
        let mut editor = detail.edit()?;
        let done = editor.tiles("decals").and_then(|object| write(context, object, tessellation, &decal, &artwork));
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

/// Reads `N` numbers.
///
/// # Safety
/// `pointer` is NULL or has so many numbers.
unsafe fn numbers<const N: usize>(name: &str, pointer: *const f64) -> Result<[f64; N]> {
    // SAFETY: promised by the caller.
    let input = unsafe { Input::new(name, pointer, N, 0) }?;
    Ok(std::array::from_fn(|index| input.get(index)))
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
        unsafe {
            object.write(image, report, |context, detail, tessellation, decal, artwork| {
                paint(context, detail, tessellation, decal, artwork, &object.depths, opacity)
            })
        }
    }

    fn rlv_decal_emboss(decal: RlvDecal, image: *const RlvDecalImage, height: f32, report: *mut RlvDecalReport) {
        let object = registry::get(decal)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size, with pixels of their count.
        unsafe {
            object.write(image, report, |context, detail, tessellation, decal, artwork| {
                emboss(context, detail, tessellation, decal, artwork, &object.depths, height)
            })
        }
    }
}
