//! Foam in screen space; see `include/relievo/foam.h`.

use std::ffi::c_void;
use std::sync::{Arc, OnceLock, RwLock};

use glam::DVec3;
use relievo_core::{Error, ErrorKind, Result};
use relievo_render::foam::{
    Environment, Foam, FoamKind, FoamLayers, FoamParticle, FoamSettings, FoamView, Lens, Scenery,
};
use relievo_render::{Camera, Image};

use crate::border::array::{Input, Output, present, put};
use crate::border::descriptor::read_descriptor;
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::context::{ContextObject, HostProgress, RLV_LOG_WARNING, RlvContext, RlvProgress};
use crate::runtime::parameter::{RlvParameter, Table, settings, write_table};

handle!(RlvFoam, 26, FoamObject);

constants! {
    u32:
    RLV_FOAM_SPRAY = 0,
    RLV_FOAM_FLOAT = 1,
    RLV_FOAM_BUBBLE = 2,
}

settings!(RlvFoamSettings, FoamSettings);

descriptor! {
    pub struct RlvFoamView {
        struct_size: u32,
        width: u32,
        height: u32,
        reserved: u32,
        eye: [f64; 3],
        target: [f64; 3],
        up: [f64; 3],
        fov: f64,
        orthographic: f64,
        solids: *const f32,
        fluid: *const f32,
    }
}

descriptor! {
    pub struct RlvFoamParticles {
        struct_size: u32,
        reserved: u32,
        count: usize,
        positions: *const f32,
        position_stride: usize,
        ids: *const u32,
        id_stride: usize,
        kinds: *const u32,
        kind_stride: usize,
        lives: *const f32,
        life_stride: usize,
        velocities: *const f32,
        velocity_stride: usize,
    }
}

descriptor! {
    pub struct RlvFoamLight {
        struct_size: u32,
        width: u32,
        height: u32,
        up: [f32; 3],
        radiance: *const f32,
    }
}

descriptor! {
    pub struct RlvFoamLayers {
        struct_size: u32,
        reserved: u32,
        intensity: *mut f32,
        thickness: *mut f32,
        depth: *mut f32,
        normal: *mut f32,
        occlusion: *mut f32,
        irradiance: *mut f32,
    }
}

/// Particles that are copied from the host at a time.
const CHUNK: usize = 1 << 16;

/// A picture of foam.
pub struct FoamObject {
    context: Arc<ContextObject>,
    stage: RwLock<Stage>,
    pixels: usize,
}

/// How far a picture is.
enum Stage {
    /// Particles are added.
    Open(Box<Foam>),
    /// The layers are made.
    Shaded(Box<FoamLayers>),
    /// Shading was cancelled.
    Cancelled,
}

impl Stage {
    fn layers(&self) -> Result<&FoamLayers> {
        match self {
            Self::Shaded(layers) => Ok(layers),
            _ => Err(Error::invalid("the foam has no layers").advise("call rlv_foam_shade first")),
        }
    }
}

/// Returns the view and the depths about it.
///
/// # Safety
/// `view` is NULL or a descriptor whose arrays are as the header demands.
unsafe fn read_view(context: &ContextObject, view: *const RlvFoamView) -> Result<(FoamView, Scenery)> {
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default: RlvFoamView = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(view, default) }?;
    let RlvFoamView { width, height, eye, target, up, fov, orthographic, .. } = given;
    let [eye, target, up] = [eye, target, up].map(DVec3::from);
    let lens = if orthographic == 0.0 { Lens::Perspective } else { Lens::Orthographic(orthographic) };
    let view = FoamView { camera: Camera::look_at(eye, target, up, fov)?, lens, width, height };
    view.check()?;
    let limit = context.context.memory_limit();
    let depths = |name: &str, pointer: *const f32| -> Result<Option<Image>> {
        // SAFETY: the caller promises as many numbers as there are pixels.
        let list = unsafe { Input::optional(name, pointer, view.pixels(), 0) }?;
        list.map(|list| Image::from_data(width, height, 1, list.to_vec(name, limit)?)).transpose()
    };
    let scenery = Scenery { solids: depths("solids", given.solids)?, fluid: depths("fluid", given.fluid)? };
    Ok((view, scenery))
}

/// Makes a picture on the graphics device of a context, or on the processor where there is no device, or it fails or has no
/// room.
fn make(context: &ContextObject, settings: FoamSettings, view: FoamView, scenery: &Scenery) -> Result<Foam> {
    if let Some(device) = context.device() {
        match Foam::on(&context.context, Some(device), settings, view, scenery) {
            Err(error) if matches!(error.kind, ErrorKind::Device | ErrorKind::Memory) => {
                context.log(RLV_LOG_WARNING, &format!("the processor draws foam: {error}"));
            }
            made => return made,
        }
    }
    Foam::new(&context.context, settings, view, scenery)
}

/// The particles of the host.
struct Particles {
    positions: Input<[f32; 3]>,
    ids: Option<Input<u32>>,
    kinds: Option<Input<u32>>,
    lives: Option<Input<f32>>,
    velocities: Option<Input<[f32; 3]>>,
}

impl Particles {
    /// # Safety
    /// `particles` is NULL or a descriptor whose arrays are as the header demands.
    unsafe fn new(particles: *const RlvFoamParticles) -> Result<Self> {
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvFoamParticles = unsafe { std::mem::zeroed() };
        // SAFETY: promised by the caller.
        let given = unsafe { read_descriptor(particles, default) }?;
        let count = given.count;
        // SAFETY: the caller promises `count` elements of each.
        unsafe {
            Ok(Self {
                positions: Input::new("positions", given.positions.cast(), count, given.position_stride)?,
                ids: Input::optional("ids", given.ids, count, given.id_stride)?,
                kinds: Input::optional("kinds", given.kinds, count, given.kind_stride)?,
                lives: Input::optional("lives", given.lives, count, given.life_stride)?,
                velocities: Input::optional("velocities", given.velocities.cast(), count, given.velocity_stride)?,
            })
        }
    }

    /// Returns a particle. Fails if its kind is unknown or a number is not finite.
    fn get(&self, at: usize) -> Result<FoamParticle> {
        let kind = match self.kinds.as_ref().map_or(RLV_FOAM_FLOAT, |kinds| kinds.get(at)) {
            RLV_FOAM_SPRAY => FoamKind::Spray,
            RLV_FOAM_FLOAT => FoamKind::Foam,
            RLV_FOAM_BUBBLE => FoamKind::Bubble,
            other => {
                let error = Error::invalid(format!("particle {at} has the kind {other}")).at("kinds");
                return Err(error.advise("use a value of RlvFoamKind"));
            }
        };
        let (position, life) = (self.positions.get(at), self.lives.as_ref().map_or(0.0, |lives| lives.get(at)));
        if !position.iter().chain([&life]).all(|value| value.is_finite()) {
            return Err(Error::invalid(format!("particle {at} is not finite")).at("positions"));
        }
        if let Some(velocities) = &self.velocities
            && !velocities.get(at).iter().all(|value| value.is_finite())
        {
            return Err(Error::invalid(format!("the velocity of particle {at} is not finite")).at("velocities"));
        }
        Ok(FoamParticle { position, life, id: self.ids.as_ref().map_or(at as u32, |ids| ids.get(at)), kind })
    }
}

/// Returns the environment of a light; white for NULL.
///
/// # Safety
/// `light` is NULL or a descriptor whose array is as the header demands.
unsafe fn read_light(context: &ContextObject, light: *const RlvFoamLight) -> Result<Environment> {
    if light.is_null() {
        return Environment::uniform([1.0; 3]);
    }
    // SAFETY: a descriptor of nothing but numbers and NULL pointers.
    let default: RlvFoamLight = unsafe { std::mem::zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(light, default) }?;
    let texels = given.width as usize * given.height as usize;
    // SAFETY: the caller promises three numbers of each texel.
    let radiance = unsafe { Input::<[f32; 3]>::new("radiance", given.radiance.cast(), texels, 0) }?;
    let radiance = radiance.to_vec("radiance", context.context.memory_limit())?.into_flattened();
    Environment::of_image(&Image::from_data(given.width, given.height, 3, radiance)?, given.up)
}

entry! {
    fn rlv_foam_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        // SAFETY: the caller gives pointers to which a value may be written, or NULL.
        unsafe { write_table(&TABLE, FoamSettings::PARAMETERS, params, count) }
    }

    fn rlv_foam_create(
        context: RlvContext,
        view: *const RlvFoamView,
        settings: *const RlvFoamSettings,
        out: *mut RlvFoam,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let settings = unsafe { RlvFoamSettings::read(settings) }?;
        // SAFETY: as above, with arrays as the header demands.
        let (view, scenery) = unsafe { read_view(&context, view) }?;
        let foam = Box::new(make(&context, settings, view, &scenery)?);
        let object = FoamObject { context, stage: RwLock::new(Stage::Open(foam)), pixels: view.pixels() };
        let handle = registry::insert(object)?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_foam_retain(foam: RlvFoam) {
        registry::retain(foam)
    }

    fn rlv_foam_release(foam: RlvFoam) {
        registry::release(foam)
    }

    fn rlv_foam_add(foam: RlvFoam, particles: *const RlvFoamParticles) {
        let object = registry::get(foam)?;
        // SAFETY: the caller's arrays are as the header demands.
        let particles = unsafe { Particles::new(particles) }?;
        let mut stage = try_write(&object.stage, "foam")?;
        let Stage::Open(picture) = &mut *stage else {
            return Err(Error::invalid("the foam is shaded already").advise("make another one"));
        };
        let count = particles.positions.len();
        // All are checked before one is added.
        (0..count).try_for_each(|at| particles.get(at).map(drop))?;
        for first in (0..count).step_by(CHUNK) {
            let chunk = (first..count.min(first + CHUNK)).map(|at| particles.get(at)).collect::<Result<Vec<_>>>()?;
            let context = &object.context.context;
            match &particles.velocities {
                Some(velocities) => {
                    let moving: Vec<_> = (first..first + chunk.len()).map(|at| velocities.get(at)).collect();
                    picture.add_moving(context, &chunk, &moving)?;
                }
                None => picture.add(context, &chunk)?,
            }
        }
        Ok(())
    }

    fn rlv_foam_shade(foam: RlvFoam, light: *const RlvFoamLight, progress: RlvProgress, user: *mut c_void) {
        let object = registry::get(foam)?;
        // SAFETY: the caller gives NULL or a descriptor with an array as the header demands.
        let environment = unsafe { read_light(&object.context, light) }?;
        let mut stage = try_write(&object.stage, "foam")?;
        let Stage::Open(_) = &*stage else {
            return Err(Error::invalid("the foam is shaded already").advise("make another one"));
        };
        let Stage::Open(picture) = std::mem::replace(&mut *stage, Stage::Cancelled) else { return Ok(()) };
        let mut progress = HostProgress { callback: progress, user };
        let layers = picture.finish(&object.context.context, &environment, &mut progress)?;
        *stage = Stage::Shaded(Box::new(layers));
        Ok(())
    }

    fn rlv_foam_get(foam: RlvFoam, layers: *const RlvFoamLayers) {
        let object = registry::get(foam)?;
        // SAFETY: a descriptor of nothing but numbers and NULL pointers.
        let default: RlvFoamLayers = unsafe { std::mem::zeroed() };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let given = unsafe { read_descriptor(layers, default) }?;
        let stage = try_read(&object.stage, "foam")?;
        let found = stage.layers()?;
        let pixels = object.pixels;
        let scalars = [
            ("intensity", given.intensity, found.intensity()),
            ("thickness", given.thickness, found.thickness()),
            ("depth", given.depth, found.depth()),
            ("occlusion", given.occlusion, found.occlusion()),
        ];
        for (name, pointer, values) in scalars {
            // SAFETY: the caller promises room for as many numbers as there are pixels.
            if let Some(out) = unsafe { Output::optional(name, pointer, pixels, 0) }? {
                out.fill(values.iter().copied());
            }
        }
        // SAFETY: the caller promises room for three numbers of each pixel.
        let [normal, irradiance] = unsafe {
            [
                Output::<[f32; 3]>::optional("normal", given.normal.cast(), pixels, 0)?,
                Output::<[f32; 3]>::optional("irradiance", given.irradiance.cast(), pixels, 0)?,
            ]
        };
        if let Some(out) = normal {
            out.fill((0..pixels).map(|pixel| found.normal(pixel)));
        }
        if let Some(out) = irradiance {
            out.fill(found.irradiance().iter().copied());
        }
        Ok(())
    }

    fn rlv_foam_composite(foam: RlvFoam, background: *const f32, channels: u32, picture: *mut f32) {
        let object = registry::get(foam)?;
        let stage = try_read(&object.stage, "foam")?;
        let layers = stage.layers()?;
        if !matches!(channels, 3 | 4) {
            return Err(Error::invalid(format!("a picture has {channels} channels")).at("channels").advise("use 3 or 4"));
        }
        let count = object.pixels * channels as usize;
        let limit = object.context.context.memory_limit();
        // SAFETY: the caller promises as many numbers as pixels have channels, to be read and to be written.
        let (from, to) = unsafe {
            (Input::new("background", background, count, 0)?, Output::new("picture", picture, count, 0)?)
        };
        let [width, height] = layers.size();
        let image = Image::from_data(width, height, channels, from.to_vec("background", limit)?)?;
        let composited = layers.composite(&object.context.context, &image)?;
        to.fill(composited.data().iter().copied());
        Ok(())
    }
}
