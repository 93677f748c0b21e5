//! Inputs of a shader on a device: textures, samplers and uniforms in bind groups.

use std::collections::BTreeMap;
use std::sync::Arc;

use half::f16;
use relievo_core::{Error, Result, error::nearest};
use relievo_gpu::wgpu;
use relievo_gpu::{Charge, Device};
use relievo_render::Image;

use super::program::{Located, Program};
use crate::resource::{Resource, ResourceKind};
use crate::volume::Volume;

/// A texture that a shader is given.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// An image, as a 2-D texture; missing channels are 0, missing alpha is 1.
    Image(Image),
    /// A volume, as a 3-D texture whose numbers are mapped to 0 to 1.
    Volume(Volume),
}

/// What a shader is given, by the names of its resources.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Inputs {
    /// Textures.
    pub textures: BTreeMap<String, Texture>,
    /// Numbers of uniforms. What is missing is 0, but for `resolution` and `iResolution`, the size of the picture, and of the
    /// volume `NAME` `NAME_size`, its voxels, and `NAME_proportions`, its edges relative to the longest. Also the numbers of
    /// a vertex shader's inputs, vertex after vertex.
    pub numbers: BTreeMap<String, Vec<f64>>,
    /// How many vertices are drawn, three for each triangle; left out, as many as the vertex shader's inputs have, or 3.
    pub vertices: Option<u32>,
    /// How often they are drawn, with another `instance_index`; left out, once.
    pub instances: Option<u32>,
}

/// Textures of one set of inputs on one device, which several runners share, so that each is converted and sent once.
#[derive(Default)]
pub struct Textures {
    held: BTreeMap<String, Arc<Uploaded>>,
}

impl std::fmt::Debug for Textures {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_set().entries(self.held.keys()).finish()
    }
}

/// A texture on a device.
struct Uploaded {
    view: wgpu::TextureView,
    dimensions: u32,
    _charge: Charge,
}

/// Bind groups with what they hold.
pub(super) struct Bound {
    pub layouts: Vec<Option<wgpu::BindGroupLayout>>,
    pub groups: Vec<Option<wgpu::BindGroup>>,
    /// The storage texture that a compute shader writes, with its channels.
    pub target: Option<(wgpu::Texture, u32)>,
    _charges: Vec<Charge>,
    _textures: Vec<Arc<Uploaded>>,
}

/// A resource on the device.
enum Held {
    Buffer(wgpu::Buffer),
    View(wgpu::TextureView),
    Texture(Arc<Uploaded>),
    Sampler(wgpu::Sampler),
}

impl Bound {
    /// Binds the resources of a program and of its vertex shader. `instruments` has the buffers of examples and the log of each
    /// of the two that is augmented; vertex shaders see the logs if `is_vertex_marked`.
    pub fn new(
        device: &Device,
        program: &Program,
        size: [u32; 2],
        inputs: &Inputs,
        textures: &mut Textures,
        instruments: &[[&wgpu::Buffer; 2]],
        is_vertex_marked: bool,
    ) -> Result<Self> {
        let textures = &mut textures.held;
        let mut maker = Maker { device, inputs, size, textures, charges: Vec::new(), used: Vec::new(), target: None };
        let mut all = Vec::new();
        let mut buffers = instruments.iter();
        for part in program.parts() {
            let own = part.instrument.as_ref().and_then(|_| buffers.next());
            all.extend(part.resources.iter().map(|resource| (resource, own.filter(|_| part.is_instrument(resource)))));
        }
        let last = all.iter().map(|(resource, _)| resource.group).max();
        let count = last.map_or(0, |last| last as usize + 1);
        if count > device.limits().max_bind_groups as usize {
            return Err(Error::unsupported(format!("the shader uses bind group {}", count - 1))
                .advise("number the groups from 0; those of a vertex shader follow those of its fragment shader"));
        }
        let (mut layouts, mut groups) = (Vec::new(), Vec::new());
        for group in 0..count as u32 {
            let mut entries = Vec::new();
            let mut held = Vec::new();
            for (resource, own) in all.iter().filter(|(resource, _)| resource.group == group) {
                let mut visibility = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
                let (ty, made) = match (own, &resource.kind) {
                    (Some([_, log]), ResourceKind::Storage { is_written: true }) => {
                        visibility.set(wgpu::ShaderStages::VERTEX, is_vertex_marked);
                        (storage(false), Held::Buffer(wgpu::Buffer::clone(log)))
                    }
                    (Some([examples, _]), _) => (storage(true), Held::Buffer(wgpu::Buffer::clone(examples))),
                    (None, _) => maker.make(resource).map_err(|error| error.at(format!("`{}`", resource.name)))?,
                };
                visibility |= vertex(&ty);
                entries.push(wgpu::BindGroupLayoutEntry { binding: resource.binding, visibility, ty, count: None });
                held.push((resource.binding, made));
            }
            if entries.is_empty() {
                layouts.push(None);
                groups.push(None);
                continue;
            }
            let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
            let layout = device.guard(|| device.wgpu().create_bind_group_layout(&descriptor))?;
            let entries: Vec<_> = held
                .iter()
                .map(|(binding, held)| wgpu::BindGroupEntry {
                    binding: *binding,
                    resource: match held {
                        Held::Buffer(buffer) => buffer.as_entire_binding(),
                        Held::View(view) => wgpu::BindingResource::TextureView(view),
                        Held::Texture(texture) => wgpu::BindingResource::TextureView(&texture.view),
                        Held::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
                    },
                })
                .collect();
            let descriptor = wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries };
            groups.push(Some(device.guard(|| device.wgpu().create_bind_group(&descriptor))?));
            layouts.push(Some(layout));
        }
        Ok(Self { layouts, groups, target: maker.target, _charges: maker.charges, _textures: maker.used })
    }
}

/// Fails if an input has a name that the shader lacks. `attributes` are the inputs of its vertex shader.
pub(super) fn check_names(program: &Program, inputs: &Inputs, attributes: &[Located]) -> Result<()> {
    let textures = || program.resources().filter(|it| matches!(it.kind, ResourceKind::Texture { .. }));
    let textures: Vec<&str> = textures().map(|resource| resource.name.as_str()).collect();
    let mut numbers: Vec<&str> = attributes.iter().map(|input| input.name.as_str()).collect();
    for resource in program.resources() {
        match &resource.kind {
            ResourceKind::Uniforms { fields, .. } => numbers.extend(fields.iter().map(|field| field.name.as_str())),
            ResourceKind::Storage { .. } => numbers.push(&resource.name),
            _ => {}
        }
    }
    let check = |name: &str, known: &[&str], what: &str| {
        if known.contains(&name) {
            return Ok(());
        }
        let advice = match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if known.is_empty() => format!("the shader has no {what}"),
            None => format!("there are {}", known.join(", ")),
        };
        Err(Error::new(relievo_core::ErrorKind::NotFound, format!("the shader has no {what} `{name}`")).advise(advice))
    };
    inputs.textures.keys().try_for_each(|name| check(name, &textures, "texture"))?;
    inputs.numbers.keys().try_for_each(|name| check(name, &numbers, "uniform"))
}

/// Returns the vertex stage for what it may be bound to: anything that is only read.
fn vertex(ty: &wgpu::BindingType) -> wgpu::ShaderStages {
    let is_written = matches!(
        ty,
        wgpu::BindingType::StorageTexture { .. }
            | wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Storage { read_only: false }, .. }
    );
    if is_written { wgpu::ShaderStages::NONE } else { wgpu::ShaderStages::VERTEX }
}

fn storage(read_only: bool) -> wgpu::BindingType {
    buffer(wgpu::BufferBindingType::Storage { read_only })
}

fn buffer(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

struct Maker<'a> {
    device: &'a Device,
    inputs: &'a Inputs,
    size: [u32; 2],
    textures: &'a mut BTreeMap<String, Arc<Uploaded>>,
    charges: Vec<Charge>,
    used: Vec<Arc<Uploaded>>,
    target: Option<(wgpu::Texture, u32)>,
}

impl Maker<'_> {
    fn make(&mut self, resource: &Resource) -> Result<(wgpu::BindingType, Held)> {
        match &resource.kind {
            ResourceKind::Uniforms { size, .. } => {
                let bytes = self.uniforms(resource, *size)?;
                let held = self.buffer(&bytes, wgpu::BufferUsages::UNIFORM)?;
                Ok((buffer(wgpu::BufferBindingType::Uniform), held))
            }
            ResourceKind::Storage { is_written } => {
                let numbers = self.inputs.numbers.get(&resource.name).ok_or_else(|| {
                    Error::invalid("the storage buffer has no input").advise("give it numbers, as for a uniform")
                })?;
                let bytes: Vec<u8> = numbers.iter().flat_map(|number| (*number as f32).to_ne_bytes()).collect();
                Ok((storage(!is_written), self.buffer(&bytes, wgpu::BufferUsages::STORAGE)?))
            }
            ResourceKind::Texture { dimensions } => {
                let view_dimension = match dimensions {
                    3 => wgpu::TextureViewDimension::D3,
                    _ => wgpu::TextureViewDimension::D2,
                };
                let sample_type = wgpu::TextureSampleType::Float { filterable: true };
                let ty = wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false };
                Ok((ty, Held::Texture(self.texture(resource, *dimensions)?)))
            }
            ResourceKind::Sampler => {
                let descriptor = wgpu::SamplerDescriptor {
                    mag_filter: wgpu::FilterMode::Linear,
                    min_filter: wgpu::FilterMode::Linear,
                    ..Default::default()
                };
                let sampler = self.device.guard(|| self.device.wgpu().create_sampler(&descriptor))?;
                Ok((wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering), Held::Sampler(sampler)))
            }
            ResourceKind::Target { format } => self.written(*format),
            ResourceKind::Other(what) => {
                Err(Error::unsupported(format!("it is {what}")).advise("remove it from the shader"))
            }
        }
    }

    /// Returns the bytes of a buffer of uniforms.
    fn uniforms(&self, resource: &Resource, size: u32) -> Result<Vec<u8>> {
        let ResourceKind::Uniforms { fields, .. } = &resource.kind else { return Ok(Vec::new()) };
        if u64::from(size) > self.device.limits().max_uniform_buffer_binding_size {
            return Err(Error::unsupported(format!("the uniforms have {size} bytes")).advise("use a storage buffer"));
        }
        let mut bytes = vec![0; (size as usize).next_multiple_of(16).max(16)];
        for field in fields {
            let given = self.inputs.numbers.get(&field.name);
            let standard = self.standard(&field.name);
            if let Some(given) = given
                && given.len() != field.offsets.len()
            {
                let what = format!("`{}` has {} numbers, not {}", field.name, field.offsets.len(), given.len());
                return Err(Error::invalid(what).advise("give as many"));
            }
            let Some(numbers) = given.or(standard.as_ref()) else { continue };
            for (offset, number) in field.offsets.iter().zip(numbers) {
                let at = *offset as usize;
                if let Some(place) = bytes.get_mut(at..at + 4) {
                    place.copy_from_slice(&field.kind.bytes(*number));
                }
            }
        }
        Ok(bytes)
    }

    /// Returns the numbers of a uniform that need not be given: the size of the picture, and the edges of volumes.
    fn standard(&self, name: &str) -> Option<Vec<f64>> {
        if matches!(name, "resolution" | "iResolution") {
            return Some(vec![f64::from(self.size[0]), f64::from(self.size[1]), 1.0]);
        }
        let (texture, property) = name.rsplit_once('_')?;
        let Texture::Volume(volume) = self.inputs.textures.get(texture)? else { return None };
        match property {
            "proportions" => Some(volume.proportions().map(f64::from).to_vec()),
            "size" => Some(volume.size.map(f64::from).to_vec()),
            _ => None,
        }
    }

    fn buffer(&mut self, bytes: &[u8], usage: wgpu::BufferUsages) -> Result<Held> {
        let device = self.device;
        let size = bytes.len() as u64;
        self.charges.push(device.charge(size)?);
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let made = device.guard(|| device.wgpu().create_buffer(&descriptor))?;
        device.guard(|| device.queue().write_buffer(&made, 0, bytes))?;
        Ok(Held::Buffer(made))
    }

    /// Returns a texture, made unless a runner made it before.
    fn texture(&mut self, resource: &Resource, dimensions: u32) -> Result<Arc<Uploaded>> {
        let made = match self.textures.get(&resource.name).filter(|held| held.dimensions == dimensions) {
            Some(held) => Arc::clone(held),
            None => {
                let made = Arc::new(self.upload(resource, dimensions)?);
                self.textures.insert(resource.name.clone(), Arc::clone(&made));
                made
            }
        };
        self.used.push(Arc::clone(&made));
        Ok(made)
    }

    fn upload(&self, resource: &Resource, dimensions: u32) -> Result<Uploaded> {
        let given = self.inputs.textures.get(&resource.name).ok_or_else(|| {
            Error::invalid("the texture has no input").advise(match dimensions {
                3 => "give it a volume: NIfTI or OpenVDB",
                _ => "give it an image: PNG or EXR",
            })
        })?;
        let (size, values, channels) = match (given, dimensions) {
            (Texture::Image(image), 2) => ([image.width(), image.height(), 1], four(image), 4),
            (Texture::Volume(volume), 3) => (volume.size, volume.normalized(), 1),
            (Texture::Image(_), _) => return Err(Error::invalid("the texture is 3-D").advise("give it a volume")),
            (Texture::Volume(_), _) => return Err(Error::invalid("the texture is 2-D").advise("give it an image")),
        };
        let device = self.device;
        let limits = device.limits();
        let most = if dimensions == 3 { limits.max_texture_dimension_3d } else { limits.max_texture_dimension_2d };
        if size.iter().any(|edge| *edge > most) {
            return Err(Error::unsupported(format!("the device has textures of at most {most} texels along an edge"))
                .advise("reduce the file"));
        }
        // 32-bit floats cannot be filtered on every device.
        let is_full = device.wgpu().features().contains(wgpu::Features::FLOAT32_FILTERABLE);
        let (format, bytes): (_, Vec<u8>) = match (is_full, channels) {
            (true, 4) => (wgpu::TextureFormat::Rgba32Float, bytemuck::cast_slice(&values).to_vec()),
            (true, _) => (wgpu::TextureFormat::R32Float, bytemuck::cast_slice(&values).to_vec()),
            (false, 4) => (wgpu::TextureFormat::Rgba16Float, halves(&values)),
            (false, _) => (wgpu::TextureFormat::R16Float, halves(&values)),
        };
        let charge = device.charge(bytes.len() as u64)?;
        let extent = wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: size[2] };
        let dimension = if dimensions == 3 { wgpu::TextureDimension::D3 } else { wgpu::TextureDimension::D2 };
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = device.guard(|| device.wgpu().create_texture(&texture(extent, dimension, format, usage)))?;
        let row = bytes.len() / (size[1] as usize * size[2] as usize);
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row as u32), rows_per_image: Some(size[1]) };
        device.guard(|| device.queue().write_texture(texture.as_image_copy(), &bytes, layout, extent))?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Uploaded { view, dimensions, _charge: charge })
    }

    /// Makes the texture that a compute shader writes.
    fn written(&mut self, format: naga::StorageFormat) -> Result<(wgpu::BindingType, Held)> {
        let (format, channels) = match format {
            naga::StorageFormat::Rgba32Float => (wgpu::TextureFormat::Rgba32Float, 4),
            naga::StorageFormat::R32Float => (wgpu::TextureFormat::R32Float, 1),
            _ => {
                return Err(Error::unsupported("the storage texture has another format than rgba32float and r32float")
                    .advise("declare it as rgba32float"));
            }
        };
        if self.target.is_some() {
            return Err(Error::unsupported("the shader writes more than one texture").advise("leave one of them"));
        }
        let device = self.device;
        let [width, height] = self.size;
        self.charges.push(device.charge(4 * u64::from(channels) * u64::from(width) * u64::from(height))?);
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let usage = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let descriptor = texture(extent, wgpu::TextureDimension::D2, format, usage);
        let made = device.guard(|| device.wgpu().create_texture(&descriptor))?;
        let view = made.create_view(&wgpu::TextureViewDescriptor::default());
        self.target = Some((made, channels));
        let ty = wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format,
            view_dimension: wgpu::TextureViewDimension::D2,
        };
        Ok((ty, Held::View(view)))
    }
}

/// Returns the description of a texture.
pub(super) fn texture(
    size: wgpu::Extent3d,
    dimension: wgpu::TextureDimension,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension,
        format,
        usage,
        view_formats: &[],
    }
}

/// Returns the numbers of an image as red, green, blue and alpha; grey fills all three colours.
fn four(image: &Image) -> Vec<f32> {
    let channels = image.channels() as usize;
    let pixels = image.data().chunks_exact(channels);
    let wide = |pixel: &[f32]| match *pixel {
        [grey] => [grey, grey, grey, 1.0],
        [grey, alpha] => [grey, grey, grey, alpha],
        [red, green, blue] => [red, green, blue, 1.0],
        [red, green, blue, alpha, ..] => [red, green, blue, alpha],
        [] => [0.0, 0.0, 0.0, 1.0],
    };
    pixels.flat_map(wide).collect()
}

fn halves(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| f16::from_f32(*value).to_ne_bytes()).collect()
}
