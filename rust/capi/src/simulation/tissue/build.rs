//! What models of soft tissue are built from.

use std::ffi::c_char;
use std::sync::Arc;

use glam::DVec3;
use relievo_core::{Error, Progress, Result};
use relievo_tissue::{
    Bend, BuildReport, Description, FibreField, Labels, Layer, Material, Muscle, NurbsMuscle, Range, Restraint, Shape,
    Skin, Volume,
};

use super::{RLV_TISSUE_BIND, RLV_TISSUE_HOLD, RLV_TISSUE_SLIDE, RlvTissue, register};
use crate::border::array::{Input, descriptors, text};
use crate::border::descriptor::read_descriptor;
use crate::border::registry::{self, try_read};
use crate::runtime::context::{ContextObject, RlvContext};
use crate::surfaces::mesh::RlvMesh;

descriptor! {
    pub struct RlvTissueMaterial {
        struct_size: u32,
        density: f32,
        name: *const c_char,
        library: *const c_char,
        young: f32,
        poisson: f32,
    }
}

descriptor! {
    pub struct RlvTissueVolume {
        struct_size: u32,
        level: u32,
        name: *const c_char,
        mesh: RlvMesh,
        material: u32,
        has_layers: u32,
        is_muscle: u32,
        stiffness: f32,
        strength: f32,
        ring_size: u32,
        direction: [f64; 3],
        rings: *const f64,
        ring_count: usize,
    }
}

descriptor! {
    pub struct RlvTissueLayer {
        struct_size: u32,
        material: u32,
        start: f32,
        thickness: f32,
    }
}

descriptor! {
    pub struct RlvTissueSurface {
        struct_size: u32,
        purpose: u32,
        name: *const c_char,
        mesh: RlvMesh,
        is_internal: u32,
        angle: f32,
    }
}

descriptor! {
    pub struct RlvTissueDescription {
        struct_size: u32,
        samples: u32,
        cell: [f32; 3],
        share: f32,
        materials: *const RlvTissueMaterial,
        material_count: usize,
        material_stride: usize,
        volumes: *const RlvTissueVolume,
        volume_count: usize,
        volume_stride: usize,
        surfaces: *const RlvTissueSurface,
        surface_count: usize,
        surface_stride: usize,
        skin: RlvMesh,
        layers: *const RlvTissueLayer,
        layer_count: usize,
        layer_stride: usize,
        epidermis_material: u32,
        epidermis_thickness: f32,
        bend: [f64; 2],
    }
}

descriptor! {
    pub struct RlvTissueLabel {
        struct_size: u32,
        material: u32,
        low: f32,
        high: f32,
    }
}

descriptor! {
    pub struct RlvTissueLabels {
        struct_size: u32,
        block: u32,
        share: f32,
        reserved: u32,
        materials: *const RlvTissueMaterial,
        material_count: usize,
        material_stride: usize,
        labels: *const RlvTissueLabel,
        label_count: usize,
        label_stride: usize,
    }
}

descriptor! {
    pub struct RlvTissueReport {
        struct_size: u32,
        voxels: [u32; 3],
        volume: f64,
    }
}

/// Returns a descriptor of nothing but numbers, NULL pointers and null handles.
fn zeroed<T: crate::border::descriptor::Descriptor>() -> T {
    // SAFETY: all zeros are a value of every descriptor.
    unsafe { std::mem::zeroed() }
}

/// Density in kg/m³ of materials that state none and are not of the library.
const DENSITY: f32 = 1000.0;

/// Returns a material.
///
/// # Errors
/// Fails with `Invalid` if the descriptor or a text cannot be used, a number is out of range, or the library has no
/// such material.
///
/// # Safety
/// `from` is NULL or a descriptor that starts with its size, with NUL-terminated texts or NULL.
pub unsafe fn material(from: *const RlvTissueMaterial) -> Result<Material> {
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(from, zeroed()) }?;
    // SAFETY: as above.
    let name = unsafe { text("name", given.name) }?;
    let named = |error: Error| error.at(format!("material `{name}`"));
    if given.library.is_null() {
        let density = if given.density == 0.0 { DENSITY } else { given.density };
        return Material::of_young(name, given.young, given.poisson, density).map_err(named);
    }
    // SAFETY: as above.
    let found = Material::of_library(unsafe { text("library", given.library) }?).map_err(named)?;
    let density = if given.density == 0.0 { found.density } else { given.density };
    let material = Material { name: name.to_owned(), density, ..found };
    material.check()?;
    Ok(material)
}

/// Returns materials.
///
/// # Safety
/// `count` descriptors can be read, each as for [`material`].
unsafe fn materials(from: *const RlvTissueMaterial, count: usize, stride: usize) -> Result<Vec<Material>> {
    // SAFETY: promised by the caller.
    unsafe { descriptors("materials", from, count, stride)?.map(|at| material(at)).collect() }
}

/// Returns how a scan or a grid becomes a model.
///
/// # Errors
/// Fails with `Invalid` if the descriptor, an array or a material cannot be used.
///
/// # Safety
/// `from` is NULL or a descriptor that starts with its size, with arrays of their counts.
pub unsafe fn labels(from: *const RlvTissueLabels) -> Result<Labels> {
    let default = RlvTissueLabels { block: 1, share: 0.5, ..zeroed() };
    // SAFETY: promised by the caller.
    let given = unsafe { read_descriptor(from, default) }?;
    // SAFETY: as above.
    let (materials, list) = unsafe {
        let list = descriptors("labels", given.labels, given.label_count, given.label_stride)?;
        (materials(given.materials, given.material_count, given.material_stride)?, list)
    };
    let ranges = list.map(|at| {
        // SAFETY: the caller promises a descriptor there.
        let label = unsafe { read_descriptor(at, zeroed::<RlvTissueLabel>()) }?;
        Ok(Range { material: label.material, low: label.low, high: label.high })
    });
    Ok(Labels { block: given.block, share: given.share, ranges: ranges.collect::<Result<_>>()?, materials })
}

/// Describes for C what a model was made of.
pub fn report_of(report: BuildReport) -> RlvTissueReport {
    RlvTissueReport { struct_size: 0, voxels: report.voxels, volume: report.volume }
}

/// A model to be built, with all that this needs copied.
pub struct Building {
    context: Arc<ContextObject>,
    description: Description,
}

/// Copies a mesh.
fn shape(name: &str, mesh: RlvMesh) -> Result<Shape> {
    let object = registry::get(mesh)?;
    let mesh = try_read(&object.mesh, "mesh")?;
    Ok(Shape { name: name.to_owned(), points: mesh.points.clone(), triangles: mesh.triangles() })
}

/// Points around and along of the surfaces that muscles of rings are made.
const FINE: [u32; 2] = [48, 64];

impl Building {
    /// Copies what a model is built from.
    ///
    /// # Errors
    /// Fails with `Invalid` if a handle is not alive, or a descriptor, an array or the description that they make
    /// cannot be used, with `Busy` if a mesh is being changed, and with `Memory` if an array exceeds the context's
    /// memory limit.
    ///
    /// # Safety
    /// `from` is NULL or a descriptor that starts with its size, with arrays of their counts.
    pub unsafe fn read(context: RlvContext, from: *const RlvTissueDescription) -> Result<Self> {
        let context = registry::get(context)?;
        let default = RlvTissueDescription { samples: 4, share: 0.5, ..zeroed() };
        // SAFETY: promised by the caller.
        let given = unsafe { read_descriptor(from, default) }?;
        let limit = context.context.memory_limit();
        // SAFETY: as above, with arrays of their counts.
        let (materials, volumes, surfaces, layers) = unsafe {
            (
                materials(given.materials, given.material_count, given.material_stride)?,
                descriptors("volumes", given.volumes, given.volume_count, given.volume_stride)?,
                descriptors("surfaces", given.surfaces, given.surface_count, given.surface_stride)?,
                descriptors("layers", given.layers, given.layer_count, given.layer_stride)?,
            )
        };
        let mut description = Description {
            cell: given.cell,
            samples: given.samples,
            share: given.share,
            materials,
            bend: (given.bend != [0.0; 2]).then_some(Bend { radii: given.bend }),
            ..Description::default()
        };
        for at in volumes {
            // SAFETY: the caller promises a descriptor there, with an array of its count.
            let volume = unsafe { volume(read_descriptor(at, zeroed())?, limit) }?;
            description.volumes.push(volume);
        }
        for at in surfaces {
            // SAFETY: the caller promises a descriptor there, with a NUL-terminated text.
            let (surface, name) = unsafe {
                let surface = read_descriptor(at, RlvTissueSurface { angle: RIGHT, ..zeroed() })?;
                (surface, text("name", surface.name)?)
            };
            let shape = shape(name, surface.mesh).map_err(|error| error.at(format!("surface `{name}`")))?;
            match surface.purpose {
                RLV_TISSUE_HOLD | RLV_TISSUE_SLIDE => description.restraints.push(Restraint {
                    shape,
                    is_sliding: surface.purpose == RLV_TISSUE_SLIDE,
                    is_internal: surface.is_internal != 0,
                    angle: surface.angle,
                }),
                RLV_TISSUE_BIND => description.bound.push(shape),
                other => {
                    return Err(Error::invalid(format!("there is no purpose {other}"))
                        .at(format!("surface `{name}`"))
                        .advise("use a value of RlvTissuePurpose"));
                }
            }
        }
        if given.skin.id != 0 {
            let layers = layers.map(|at| {
                // SAFETY: the caller promises a descriptor there.
                let layer = unsafe { read_descriptor(at, zeroed::<RlvTissueLayer>()) }?;
                Ok(Layer { material: layer.material, start: layer.start, thickness: layer.thickness })
            });
            let epidermis = (given.epidermis_material, given.epidermis_thickness);
            description.skin = Some(Skin {
                shape: shape("skin", given.skin).map_err(|error| error.at("skin"))?,
                layers: layers.collect::<Result<_>>()?,
                epidermis: (epidermis.1 != 0.0).then_some(epidermis),
            });
        }
        description.check()?;
        Ok(Self { context, description })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.context
    }

    /// Builds the model and registers it.
    ///
    /// # Errors
    /// Fails with `Cancelled` if `progress` asks to stop, and as [`Description::build`] does: if a surface is not
    /// closed, no voxel is an element, a place cannot be bent, or memory does not suffice.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<(RlvTissue, RlvTissueReport)> {
        progress.step(0.0, "voxels")?;
        let (model, report) = self.description.build(&self.context.context, progress)?;
        Ok((register(self.context.clone(), model)?, report_of(report)))
    }
}

/// The angle of normals up to which nodes belong to a surface, in radians.
const RIGHT: f32 = 89.0 / 180.0 * std::f32::consts::PI;

/// Returns a volume.
///
/// # Safety
/// `given` has a NUL-terminated text and as many control points as it states.
unsafe fn volume(given: RlvTissueVolume, limit: u64) -> Result<Volume> {
    // SAFETY: promised by the caller.
    let name = unsafe { text("name", given.name) }?;
    let named = |error: Error| error.at(format!("volume `{name}`"));
    let mut field = FibreField::Uniform(DVec3::from(given.direction));
    let shape = if given.ring_count == 0 {
        shape(name, given.mesh).map_err(named)?
    } else {
        if given.is_muscle == 0 {
            return Err(named(Error::invalid("it has rings but is no muscle").advise("set is_muscle, or give a mesh")));
        }
        let (count, size) = (given.ring_count, given.ring_size as usize);
        let numbers = count.saturating_mul(size).saturating_mul(4);
        // SAFETY: promised by the caller.
        let numbers = unsafe { Input::new("rings", given.rings, numbers, 0) }.and_then(|it| it.to_vec("rings", limit));
        let points: Vec<[f64; 4]> = numbers.map_err(named)?.as_chunks().0.to_vec();
        let rings: Vec<Vec<[f64; 4]>> = points.chunks(size.max(1)).map(<[_]>::to_vec).collect();
        let muscle = NurbsMuscle::new(&rings).map_err(named)?;
        let (points, triangles) = muscle.mesh(FINE[0], FINE[1]);
        field = FibreField::Nurbs(Box::new(muscle));
        Shape { name: name.to_owned(), points, triangles }
    };
    let muscle = Muscle { name: name.to_owned(), stiffness: given.stiffness, strength: given.strength };
    Ok(Volume {
        shape,
        level: given.level,
        material: given.material,
        has_layers: given.has_layers != 0,
        muscle: (given.is_muscle != 0).then_some((muscle, field)),
    })
}
