//! The depths of posed meshes at the middles of pixels, for kernels that cull by occlusion (`shaders/draw/posed_depth.wgsl`).

use glam::{DAffine3, DMat4, DVec3, Vec3};
use relievo_core::{Error, Result};
use relievo_gpu::module::{self, compose};
use relievo_gpu::{Buffer, Charge, Device, Frame, wgpu};

use super::placed::PosedMesh;
use super::targets::DEPTH;
use super::view::{Extent, NEAR, projection};
use crate::camera::Camera;

/// What depths are drawn into.
#[derive(Debug)]
struct Target {
    size: [u32; 2],
    texture: wgpu::Texture,
    depths: Buffer<f32>,
    _charge: Charge,
}

/// Draws depths into a buffer.
#[derive(Debug)]
pub struct DepthMap {
    device: Device,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    target: Option<Target>,
}

impl DepthMap {
    /// Compiles what draws depths.
    ///
    /// # Errors
    /// The device fails.
    pub fn new(device: &Device) -> Result<Self> {
        const NAME: &str = "posed_depth";
        let compiled = device.module(NAME, &compose(NAME)?)?;
        let entry = |binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: true },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let (layout, pipeline) = device
            .guard(|| {
                let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &[entry(0), entry(1)] };
                let layout = device.wgpu().create_bind_group_layout(&descriptor);
                let whole = device.wgpu().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: None,
                    bind_group_layouts: &[Some(&layout)],
                    immediate_size: size_of::<[[f32; 4]; 4]>() as u32,
                });
                let attributes =
                    [wgpu::VertexAttribute { offset: 0, shader_location: 0, format: wgpu::VertexFormat::Uint32x2 }];
                let corner = wgpu::VertexBufferLayout {
                    array_stride: size_of::<[u32; 2]>() as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &attributes,
                };
                let pipeline = device.wgpu().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some("vertex_depth"),
                    layout: Some(&whole),
                    vertex: wgpu::VertexState {
                        module: &compiled,
                        entry_point: Some("vertex_depth"),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        buffers: &[Some(corner)],
                    },
                    primitive: wgpu::PrimitiveState::default(),
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format: DEPTH,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(wgpu::CompareFunction::Greater),
                        stencil: wgpu::StencilState::default(),
                        bias: wgpu::DepthBiasState::default(),
                    }),
                    multisample: wgpu::MultisampleState::default(),
                    fragment: None,
                    multiview_mask: None,
                    cache: None,
                });
                (layout, pipeline)
            })
            .map_err(|error| error.at(module::path(NAME)))?;
        Ok(Self { device: device.clone(), layout, pipeline, target: None })
    }

    /// Makes room for a picture of `size` pixels.
    ///
    /// # Errors
    /// The picture is too large for the device, or it has no memory.
    pub fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        if self.target.as_ref().is_some_and(|target| target.size == size) {
            return Ok(());
        }
        let ([width, height], most) = (size, self.device.limits().max_texture_dimension_2d);
        if width == 0 || height == 0 || width.max(height) > most {
            return Err(Error::unsupported(format!("depths of {width}×{height} pixels cannot be drawn"))
                .advise(format!("use up to {most} pixels a side")));
        }
        let charge = self.device.charge(4 * u64::from(width) * u64::from(height))?;
        let texture = self.device.guard(|| {
            self.device.wgpu().create_texture(&wgpu::TextureDescriptor {
                label: Some("depths"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: DEPTH,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        })?;
        let depths = Buffer::new(&self.device, "depths", stride(width) as usize * height as usize)?;
        self.target = Some(Target { size, texture, depths, _charge: charge });
        Ok(())
    }

    /// Records the depths of a mesh that lies in the world as a camera sees it, after which [`Self::depths`] has them: one over
    /// the depth of what is nearest at the middle of every pixel, times the number that this returns; 0 where nothing is.
    ///
    /// # Errors
    /// No room was made, or the device was lost.
    pub fn record(&self, frame: &mut Frame, mesh: &PosedMesh<'_>, camera: &Camera) -> Result<f32> {
        let target = self.target.as_ref().ok_or_else(|| Error::internal("depths have no room"))?;
        let mut extent = Extent::empty();
        let [low, high] = mesh.bounds.map(|corner| Vec3::from(corner).as_dvec3());
        extent.add((low, high), &DAffine3::IDENTITY, camera.eye);
        let about = DMat4::from(DAffine3::from_translation(DVec3::ZERO - camera.eye));
        let clip = (projection(camera, target.size, &extent) * about).as_mat4().to_cols_array();
        let entries = [(0, mesh.vertices.wgpu()), (1, mesh.instances)]
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() });
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout: &self.layout, entries: &entries };
        let group = self.device.guard(|| self.device.wgpu().create_bind_group(&descriptor))?;
        let view = target.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let attachment = wgpu::RenderPassDepthStencilAttachment {
            view: &view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        };
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some("depths"),
            depth_stencil_attachment: Some(attachment),
            ..wgpu::RenderPassDescriptor::default()
        };
        let mut pass = frame.draw("depths", &descriptor);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_immediates(0, bytemuck::cast_slice(&clip));
        pass.set_vertex_buffer(0, mesh.corners.wgpu().slice(..));
        pass.draw_indirect(mesh.arguments.wgpu(), 0);
        drop(pass);
        let [width, height] = target.size;
        let bytes_per_row = Some(4 * stride(width));
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: Some(height) };
        frame.encoder().copy_texture_to_buffer(
            target.texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: target.depths.wgpu(), layout },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        Ok((NEAR * extent.farthest()) as f32)
    }

    /// Returns the depths, row after row from the top, with [`Self::stride`] numbers in each; nothing before there was room.
    pub fn depths(&self) -> Option<&Buffer<f32>> {
        self.target.as_ref().map(|target| &target.depths)
    }

    /// Returns how many numbers a row of the depths has.
    pub fn stride(&self) -> u32 {
        self.target.as_ref().map_or(0, |target| stride(target.size[0]))
    }
}

/// Rows of copies begin at multiples of 256 bytes.
fn stride(width: u32) -> u32 {
    width.next_multiple_of(64)
}
