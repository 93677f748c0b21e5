//! The offscreen rasteriser of virtual vertices: colours shaded as by the ray caster, and depth, normal and number of the
//! patch at the middle of every pixel (`shaders/bezier_draw.wgsl`).
//!
//! Depth goes from 1 at the near plane to 0 at infinity, which spends the float's digits evenly. Direct light has no
//! shadows; the sky's light is the mean over the hemisphere, without occlusion.

use std::collections::BTreeMap;
use std::time::Duration;

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec4, Vec3};
use relievo_core::{Error, Result};
use relievo_gpu::module::compose;
use relievo_gpu::{Buffer, Charge, Device, wgpu};
use relievo_surface::bezier::VirtualVertex;

use super::patches::{Records, Storage, UNIFORM_PATCHES, VirtualVertices};
use crate::caster::{Frame, NO_OBJECT};
use crate::image::Image;
use crate::scene::Material;
use crate::settings::View;

/// Suns that are drawn.
const SUNS: usize = 4;
/// Pixels of a picture's side at most.
const MOST_SIDE: u32 = 16_384;
/// Distance of the near plane, as a share of that of the camera from the origin; what is nearer is cut.
const NEAR: f64 = 1e-5;

const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
const NUMBER: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// What a pixel of the three targets takes.
const PIXEL_BYTES: u32 = 36;

/// As in the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct SunBlock {
    direction: [f32; 4],
    irradiance: [f32; 4],
}

/// As in the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct ViewBlock {
    projection: [[f32; 4]; 4],
    eye: [f32; 3],
    lines: f32,
    forward: [f32; 3],
    line_width: f32,
    base_color: [f32; 3],
    specular: f32,
    line_color: [f32; 3],
    roughness: f32,
    up: [f32; 3],
    sun_count: u32,
    zenith: [f32; 4],
    horizon: [f32; 4],
    ground: [f32; 4],
    suns: [SunBlock; SUNS],
}

/// As in the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct DrawBlock {
    first: u32,
    level: u32,
}

/// A vertex whose point was computed before.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct PassedVertex {
    /// Position.
    pub p: [f32; 3],
    /// Sample of the map, as in [`VirtualVertex`].
    pub sample: u32,
    /// Unit normal.
    pub normal: [f32; 3],
    /// Unused.
    pub padding: u32,
}

/// Strips of points and normals that were computed before, drawn without evaluating anything.
#[derive(Debug)]
pub struct PassedVertices {
    buffer: Buffer<PassedVertex>,
}

impl PassedVertices {
    /// Room for `count` vertices.
    ///
    /// # Errors
    /// The device has no memory.
    pub fn new(device: &Device, count: usize) -> Result<Self> {
        Ok(Self { buffer: Buffer::vertices(device, "passed vertices", count)? })
    }

    /// Writes the vertices from index `first` on.
    ///
    /// # Errors
    /// There is no room for them, or the device fails.
    pub fn write(&self, device: &Device, first: usize, vertices: &[PassedVertex]) -> Result<()> {
        self.buffer.write(device, first, vertices)
    }

    /// How many vertices there are.
    pub fn len(&self) -> usize {
        self.buffer.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.buffer.is_empty()
    }
}

/// Textures that are drawn into.
#[derive(Debug)]
struct Targets {
    size: [u32; 2],
    color: wgpu::Texture,
    geometry: wgpu::Texture,
    number: wgpu::Texture,
    depth: wgpu::Texture,
    _charge: Charge,
}

/// What draws: its pipelines, its targets and the view.
#[derive(Debug)]
pub struct Rasterizer {
    device: Device,
    module: wgpu::ShaderModule,
    view: Buffer<ViewBlock>,
    view_layout: wgpu::BindGroupLayout,
    view_group: wgpu::BindGroup,
    pipelines: BTreeMap<(Option<Storage>, bool), wgpu::RenderPipeline>,
    record_layouts: BTreeMap<Storage, wgpu::BindGroupLayout>,
    targets: Option<Targets>,
}

impl Rasterizer {
    /// A rasteriser on `device`.
    ///
    /// # Errors
    /// The device cannot write colours, normals and numbers of a pixel at once, or fails.
    pub fn new(device: &Device) -> Result<Self> {
        if device.limits().max_color_attachment_bytes_per_sample < PIXEL_BYTES {
            return Err(Error::unsupported(format!("{} draws too few bytes a pixel", device.summary())));
        }
        let module = device.module("bezier_draw", &compose("bezier_draw")?)?;
        let view = Buffer::uniform(device, "view", &[ViewBlock::default()])?;
        let uniform = |dynamic: bool, bytes: u64| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: dynamic,
            min_binding_size: std::num::NonZeroU64::new(bytes),
        };
        let layout = |binding: u32, ty: wgpu::BindingType| {
            let entry = wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty,
                count: None,
            };
            device.guard(|| {
                device
                    .wgpu()
                    .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &[entry] })
            })
        };
        let view_layout = layout(0, uniform(false, size_of::<ViewBlock>() as u64))?;
        let view_group = device.guard(|| {
            device.wgpu().create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &view_layout,
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: view.wgpu().as_entire_binding() }],
            })
        })?;
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let buffer = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let record_layouts = BTreeMap::from([
            (Storage::Uniform, layout(0, uniform(true, u64::from(UNIFORM_PATCHES) * 272))?),
            (Storage::Texture, layout(1, texture)?),
            (Storage::Buffer, layout(2, buffer)?),
        ]);
        let device = device.clone();
        let pipelines = BTreeMap::new();
        Ok(Self { device, module, view, view_layout, view_group, pipelines, record_layouts, targets: None })
    }

    /// Draws a picture of `patches` and reads it back. `view.settings.samples` colours are taken in every pixel.
    ///
    /// # Errors
    /// The view cannot be used, the picture is too large for the device, or the device fails.
    pub fn render(&mut self, patches: &VirtualVertices, view: &View, material: &Material) -> Result<Frame> {
        view.check()?;
        let [width, height] = [view.settings.width, view.settings.height];
        // Colours as many times as finely; what is behind pixels at their middles.
        let fine = (1..=16u32).find(|fine| fine * fine >= view.settings.samples).unwrap_or(16);
        self.draw(patches, view, material, [width, height], 1.0)?;
        let geometry = self.read(|targets| &targets.geometry, 4)?;
        let numbers = self.read(|targets| &targets.number, 1)?;
        if fine > 1 {
            self.draw(patches, view, material, [width * fine, height * fine], fine as f32)?;
        }
        let colors = self.read(|targets| &targets.color, 4)?;
        let mut frame = Frame {
            color: Image::new(width, height, 3)?,
            depth: Image::new(width, height, 1)?,
            normal: Image::new(width, height, 3)?,
            albedo: Image::new(width, height, 3)?,
            object: vec![NO_OBJECT; width as usize * height as usize],
        };
        let rays = view.camera.rays(width * fine, height * fine);
        let up = Vec3::from(view.lights.sky.up).normalize_or(Vec3::Z);
        let share = 1.0 / (fine * fine) as f32;
        for y in 0..height {
            for x in 0..width {
                let at = y as usize * width as usize + x as usize;
                let mut sum = Vec3::ZERO;
                for part in 0..fine * fine {
                    let (px, py) = (x * fine + part % fine, y * fine + part / fine);
                    let start = 4 * (py as usize * (width * fine) as usize + px as usize);
                    let [r, g, b, alpha] = [0, 1, 2, 3].map(|k| f32::from_bits(colors[start + k]));
                    sum += if alpha > 0.0 {
                        Vec3::new(r, g, b)
                    } else {
                        let direction = rays.direction(px as f32 + 0.5, py as f32 + 0.5).normalize();
                        view.lights.sky.radiance(up, direction)
                    };
                }
                frame.color.set_color(x, y, (sum * share).to_array());
                let [nx, ny, nz, depth] = [0, 1, 2, 3].map(|k| f32::from_bits(geometry[4 * at + k]));
                let covered = numbers[at] > 0;
                frame.depth.data_mut()[at] = if covered { depth } else { f32::INFINITY };
                if covered {
                    frame.normal.set_color(x, y, [nx, ny, nz]);
                    frame.albedo.set_color(x, y, material.base_color);
                    frame.object[at] = numbers[at] - 1;
                }
            }
        }
        Ok(frame)
    }

    /// Draws a picture into the device's memory and says how long the device took, by its clock; zero if it does not
    /// time.
    ///
    /// # Errors
    /// As of [`Self::render`].
    pub fn time(
        &mut self,
        patches: &VirtualVertices,
        view: &View,
        material: &Material,
        size: [u32; 2],
    ) -> Result<Duration> {
        self.draw(patches, view, material, size, 1.0)
    }

    /// As [`Self::time`], of vertices that were computed before, in draws as of `patches`.
    ///
    /// # Errors
    /// There are fewer vertices than the draws need; as of [`Self::render`].
    pub fn time_passed(
        &mut self,
        vertices: &PassedVertices,
        patches: &VirtualVertices,
        view: &View,
        material: &Material,
        size: [u32; 2],
    ) -> Result<Duration> {
        self.begin(view, material, size, 1.0)?;
        let pipeline = self.pipeline(None, false)?;
        let mut first = 0;
        let mut ranges = Vec::with_capacity(patches.draws().len());
        for draw in patches.draws() {
            let last = draw.vertices()?.saturating_add(first);
            ranges.push(first..last);
            first = last;
        }
        if first as usize > vertices.len() {
            return Err(Error::internal(format!("{} vertices for draws of {first}", vertices.len())));
        }
        self.submit(|pass, view_group| {
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, view_group, &[]);
            pass.set_vertex_buffer(0, vertices.buffer.wgpu().slice(..));
            for range in ranges {
                pass.draw(range, 0..1);
            }
            Ok(())
        })
    }

    fn draw(
        &mut self,
        patches: &VirtualVertices,
        view: &View,
        material: &Material,
        size: [u32; 2],
        scale: f32,
    ) -> Result<Duration> {
        self.begin(view, material, size, scale)?;
        let storage = patches.storage();
        let pipeline = self.pipeline(Some(storage), patches.is_rational())?;
        let group = self.record_group(patches)?;
        self.submit(|pass, view_group| {
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, view_group, &[]);
            let mut level = 0;
            for (number, draw) in patches.draws().iter().enumerate() {
                if draw.level != level {
                    level = draw.level;
                    let map = patches.maps.get(&level).ok_or_else(|| Error::internal("a level has no map"))?;
                    pass.set_vertex_buffer(0, map.wgpu().slice(..));
                }
                if storage == Storage::Uniform {
                    let offset = u32::try_from(patches.block_stride() * u64::from(draw.block))
                        .map_err(|_| Error::unsupported("the uniform blocks are beyond 4 GiB"))?;
                    pass.set_bind_group(1, &group, &[offset]);
                } else if number == 0 {
                    pass.set_bind_group(1, &group, &[]);
                }
                pass.set_immediates(0, bytemuck::bytes_of(&DrawBlock { first: draw.first, level }));
                pass.draw(0..draw.vertices()?, 0..1);
            }
            Ok(())
        })
    }

    /// Makes targets of that size and writes the view.
    fn begin(&mut self, view: &View, material: &Material, size: [u32; 2], scale: f32) -> Result<()> {
        if self.targets.as_ref().is_none_or(|targets| targets.size != size) {
            self.targets = None;
            self.targets = Some(Targets::new(&self.device, size)?);
        }
        self.view.write(&self.device, 0, &[ViewBlock::new(view, material, size, scale)])
    }

    /// Records the draws of `work`, submits and waits.
    fn submit(&self, work: impl FnOnce(&mut wgpu::RenderPass<'_>, &wgpu::BindGroup) -> Result<()>) -> Result<Duration> {
        let targets = self.targets.as_ref().ok_or_else(|| Error::internal("nothing to draw into"))?;
        let views = [&targets.color, &targets.geometry, &targets.number, &targets.depth]
            .map(|texture| texture.create_view(&wgpu::TextureViewDescriptor::default()));
        let target = |view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let mut frame = self.device.frame()?;
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some("draw"),
            color_attachments: &[target(&views[0]), target(&views[1]), target(&views[2])],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &views[3],
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        };
        work(&mut frame.draw("draw", &descriptor), &self.view_group)?;
        let times = frame.submit()?.wait()?;
        Ok(times.first().map_or(Duration::ZERO, |pass| pass.length))
    }

    /// The bind group of the control points.
    fn record_group(&self, patches: &VirtualVertices) -> Result<wgpu::BindGroup> {
        let storage = patches.storage();
        let layout = &self.record_layouts[&storage];
        let view;
        let (binding, resource) = match &patches.records {
            Records::Uniform(buffer) => {
                let size = std::num::NonZeroU64::new(u64::from(UNIFORM_PATCHES) * 272);
                (0, wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size }))
            }
            Records::Texture(texture) => {
                view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                (1, wgpu::BindingResource::TextureView(&view))
            }
            Records::Buffer(buffer) => (2, buffer.wgpu().as_entire_binding()),
        };
        self.device.guard(|| {
            self.device.wgpu().create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout,
                entries: &[wgpu::BindGroupEntry { binding, resource }],
            })
        })
    }

    /// The pipeline of a storage, or of vertices that were computed before.
    fn pipeline(&mut self, storage: Option<Storage>, rational: bool) -> Result<wgpu::RenderPipeline> {
        if let Some(pipeline) = self.pipelines.get(&(storage, rational)) {
            return Ok(pipeline.clone());
        }
        let attribute = |offset, shader_location, format| wgpu::VertexAttribute { offset, shader_location, format };
        use wgpu::VertexFormat::{Float32x2, Float32x3, Uint32};
        let virtual_vertex = [attribute(0, 0, Float32x2), attribute(8, 1, Uint32), attribute(12, 2, Uint32)];
        let passed_vertex = [attribute(0, 0, Float32x3), attribute(12, 1, Uint32), attribute(16, 2, Float32x3)];
        let (entry, stride, attributes) = match storage {
            Some(Storage::Uniform) => ("vertex_uniform", size_of::<VirtualVertex>(), &virtual_vertex),
            Some(Storage::Texture) => ("vertex_texture", size_of::<VirtualVertex>(), &virtual_vertex),
            Some(Storage::Buffer) => ("vertex_buffer", size_of::<VirtualVertex>(), &virtual_vertex),
            None => ("vertex_passed", size_of::<PassedVertex>(), &passed_vertex),
        };
        let mut layouts = vec![Some(&self.view_layout)];
        layouts.extend(storage.map(|storage| Some(&self.record_layouts[&storage])));
        let constants = [("RATIONAL", f64::from(u8::from(rational)))];
        let options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        let device = self.device.wgpu();
        let pipeline = self.device.guard(|| {
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &layouts,
                immediate_size: if storage.is_some() { size_of::<DrawBlock>() as u32 } else { 0 },
            });
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(entry),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &self.module,
                    entry_point: Some(entry),
                    compilation_options: options.clone(),
                    buffers: &[Some(wgpu::VertexBufferLayout {
                        array_stride: stride as u64,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes,
                    })],
                },
                primitive: wgpu::PrimitiveState {
                    topology: wgpu::PrimitiveTopology::TriangleStrip,
                    ..wgpu::PrimitiveState::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &self.module,
                    entry_point: Some("fragment"),
                    compilation_options: options.clone(),
                    targets: &[Some(COLOR.into()), Some(COLOR.into()), Some(NUMBER.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        self.pipelines.insert((storage, rational), pipeline.clone());
        Ok(pipeline)
    }

    /// The words of a target, row by row.
    fn read(&self, of: impl Fn(&Targets) -> &wgpu::Texture, words: u32) -> Result<Vec<u32>> {
        let targets = self.targets.as_ref().ok_or_else(|| Error::internal("nothing was drawn"))?;
        let [width, height] = targets.size;
        let row = (width * words).next_multiple_of(64);
        let buffer = Buffer::<u32>::new(&self.device, "picture", row as usize * height as usize)?;
        let mut frame = self.device.frame()?;
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * row), rows_per_image: Some(height) };
        frame.encoder().copy_texture_to_buffer(
            of(targets).as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: buffer.wgpu(), layout },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        let read = frame.read(&buffer, 0..buffer.len())?;
        let _submitted = frame.submit()?;
        let padded = read.get(&self.device)?;
        Ok(padded.chunks_exact(row as usize).flat_map(|line| &line[..(width * words) as usize]).copied().collect())
    }
}

impl Targets {
    fn new(device: &Device, size: [u32; 2]) -> Result<Self> {
        let [width, height] = size;
        let most = device.limits().max_texture_dimension_2d.min(MOST_SIDE);
        if width == 0 || height == 0 || width.max(height) > most {
            return Err(Error::unsupported(format!("a picture of {width}×{height} pixels cannot be drawn"))
                .advise(format!("use up to {most} pixels a side, or fewer samples a pixel")));
        }
        let charge = device.charge(u64::from(width) * u64::from(height) * u64::from(PIXEL_BYTES + 4))?;
        let texture = |label, format| {
            device.guard(|| {
                device.wgpu().create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                    view_formats: &[],
                })
            })
        };
        Ok(Self {
            size,
            color: texture("colours", COLOR)?,
            geometry: texture("normals and depths", COLOR)?,
            number: texture("numbers", NUMBER)?,
            depth: texture("depth", DEPTH)?,
            _charge: charge,
        })
    }
}

impl ViewBlock {
    /// `scale` is by how much the picture is finer than the settings say.
    fn new(view: &View, material: &Material, [width, height]: [u32; 2], scale: f32) -> Self {
        let camera = &view.camera;
        let half = (0.5 * camera.fov).tan();
        let aspect = f64::from(width) / f64::from(height);
        let [right, up, back] = [camera.axes.x_axis, camera.axes.y_axis, camera.axes.z_axis];
        let row = |axis: glam::DVec3, factor: f64| (axis * factor).extend(-axis.dot(camera.eye) * factor);
        let near = NEAR * camera.eye.length().max(1e-3);
        let rows =
            [row(right, 1.0 / (half * aspect)), row(up, 1.0 / half), DVec4::new(0.0, 0.0, 0.0, near), row(back, -1.0)];
        let projection = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
        let sky = &view.lights.sky;
        let mut block = Self {
            projection: projection.as_mat4().to_cols_array_2d(),
            eye: camera.eye.as_vec3().to_array(),
            lines: if view.settings.wireframe.is_on() { 1.0 } else { 0.0 },
            forward: (-back).as_vec3().to_array(),
            line_width: view.settings.line_width * scale,
            base_color: material.base_color,
            specular: material.specular,
            line_color: view.line_color,
            roughness: material.roughness,
            up: Vec3::from(sky.up).normalize_or(Vec3::Z).to_array(),
            sun_count: view.lights.suns.len().min(SUNS) as u32,
            zenith: Vec3::from(sky.zenith).extend(0.0).to_array(),
            horizon: Vec3::from(sky.horizon).extend(0.0).to_array(),
            ground: Vec3::from(sky.ground).extend(0.0).to_array(),
            suns: [SunBlock::default(); SUNS],
        };
        for (into, sun) in block.suns.iter_mut().zip(&view.lights.suns) {
            into.direction = Vec3::from(sun.direction).normalize_or(Vec3::Z).extend(0.0).to_array();
            into.irradiance = Vec3::from(sun.irradiance).extend(0.0).to_array();
        }
        block
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_as_long_as_in_the_shader() {
        assert_eq!((size_of::<ViewBlock>(), size_of::<SunBlock>(), size_of::<PassedVertex>()), (320, 32, 32));
        assert_eq!(std::mem::offset_of!(ViewBlock, sun_count), 140);
        assert_eq!(std::mem::offset_of!(ViewBlock, suns), 192);
    }
}
