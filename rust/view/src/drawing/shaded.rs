//! The picture of triangles and balls on the graphics device: buffers of points and corners, of which what changed is
//! written, and the pass that draws them.

use std::ops::Range;

use glam::DMat4;
use relievo_core::Result;
use relievo_gpu::{Buffer, Device, wgpu};

use super::camera::Camera;
use crate::show::Ball;
use crate::window::Target;

/// Samples of a pixel.
const SAMPLES: u32 = 4;

/// Points between two ranges that are written with them: fewer writes take less time than a few more bytes.
const GAP: u32 = 128;

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Encoded as sRGB.
const BACKGROUND: wgpu::Color = wgpu::Color { r: 0.16, g: 0.17, b: 0.19, a: 1.0 };

/// A point as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Point {
    position: [f32; 3],
    normal: [i16; 4],
    color: [u8; 4],
}

/// The uniforms of the shader.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct View {
    projection: [f32; 16],
    axes: [[f32; 4]; 3],
    line: [f32; 4],
}

/// A ball as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct DeviceBall {
    center: [f32; 3],
    radius: f32,
    color: [u8; 4],
}

/// Triangles: points with normals of length 1 and colours, linear Rec.709, and three numbers of points each in `corners`.
#[derive(Clone, Copy, Default)]
pub(crate) struct Arrays<'a> {
    pub points: &'a [[f32; 3]],
    pub normals: &'a [[f32; 3]],
    pub colors: &'a [[f32; 3]],
    pub corners: &'a [u32],
}

/// Triangles and balls on the device.
pub(crate) struct Solid {
    device: Device,
    points: Buffer<Point>,
    corners: Buffer<u32>,
    borders: Option<Buffer<u32>>,
    balls: Buffer<DeviceBall>,
    /// The bytes of sRGB of linear values from 0 to 1.
    encoded: Vec<u8>,
    room: Vec<Point>,
}

/// What draws solids.
pub(crate) struct Shaded {
    device: Device,
    /// Once the format of the window is known.
    pipelines: Option<Pipelines>,
}

struct Pipelines {
    format: wgpu::TextureFormat,
    surface: wgpu::RenderPipeline,
    lines: wgpu::RenderPipeline,
    balls: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    group: wgpu::BindGroup,
    /// Colours and depths of all samples, of the size of the window.
    targets: Option<([u32; 2], wgpu::TextureView, wgpu::TextureView)>,
}

impl Solid {
    /// Makes room for nothing yet.
    ///
    /// # Errors
    /// The device has no memory.
    pub(crate) fn new(device: &Device) -> Result<Self> {
        Ok(Self {
            device: device.clone(),
            points: Buffer::vertices(device, "points of the view", 0)?,
            corners: Buffer::vertices(device, "corners of the view", 0)?,
            borders: None,
            balls: Buffer::vertices(device, "balls of the view", 0)?,
            encoded: (0..=4096).map(|at| relievo_render::color::srgb_byte(at as f32 / 4096.0)).collect(),
            room: Vec::new(),
        })
    }

    /// Takes other triangles.
    ///
    /// # Errors
    /// The device has no memory for them.
    pub(crate) fn replace(&mut self, arrays: Arrays<'_>) -> Result<()> {
        let count = arrays.points.len();
        if count != self.points.len() {
            self.points = Buffer::vertices(&self.device, "points of the view", count)?;
        }
        if arrays.corners.len() != self.corners.len() {
            self.corners = Buffer::vertices(&self.device, "corners of the view", arrays.corners.len())?;
        }
        self.corners.write(&self.device, 0, arrays.corners)?;
        self.borders = None;
        self.write(arrays, 0..count as u32).map(drop)
    }

    /// Takes other balls: centres, radii and colours, linear Rec.709.
    ///
    /// # Errors
    /// The device has no memory for them.
    pub(crate) fn replace_balls(&mut self, balls: &[Ball]) -> Result<()> {
        let byte = |value: f32| self.encoded[(value.clamp(0.0, 1.0) * 4096.0) as usize];
        let made: Vec<DeviceBall> = balls
            .iter()
            .map(|ball| {
                let [r, g, b] = ball.color.map(byte);
                DeviceBall { center: ball.center, radius: ball.radius, color: [r, g, b, 255] }
            })
            .collect();
        if made.len() != self.balls.len() {
            self.balls = Buffer::vertices(&self.device, "balls of the view", made.len())?;
        }
        self.balls.write(&self.device, 0, &made)
    }

    /// Takes the lines that the wireframe shows, two points each; they stay until the triangles are replaced.
    ///
    /// # Errors
    /// The device has no memory for them.
    pub(crate) fn set_borders(&mut self, lines: impl FnOnce() -> Vec<u32>) -> Result<()> {
        if self.borders.is_none() {
            let lines = lines();
            let buffer = Buffer::vertices(&self.device, "borders of the view", lines.len())?;
            buffer.write(&self.device, 0, &lines)?;
            self.borders = Some(buffer);
        }
        Ok(())
    }

    /// Writes the points in `ranges`, ascending. Returns how many bytes were written.
    ///
    /// # Errors
    /// The device is lost.
    pub(crate) fn update(&mut self, arrays: Arrays<'_>, ranges: &[Range<u32>]) -> Result<u64> {
        let mut bytes = 0;
        let mut ranges = ranges.iter().cloned().peekable();
        while let Some(mut range) = ranges.next() {
            while let Some(next) = ranges.next_if(|next| next.start.saturating_sub(range.end) <= GAP) {
                range.end = next.end.max(range.end);
            }
            bytes += self.write(arrays, range)?;
        }
        Ok(bytes)
    }

    fn write(&mut self, arrays: Arrays<'_>, range: Range<u32>) -> Result<u64> {
        let Self { encoded, room, .. } = self;
        let at = range.start as usize..range.end as usize;
        let points = arrays.points.get(at.clone()).unwrap_or_default();
        let normals = arrays.normals.get(at.clone()).unwrap_or_default();
        let colors = arrays.colors.get(at).unwrap_or_default();
        let byte = |value: f32| encoded[(value.clamp(0.0, 1.0) * 4096.0) as usize];
        let whole = |value: f32| (value.clamp(-1.0, 1.0) * 32767.0) as i16;
        room.clear();
        room.extend(points.iter().enumerate().map(|(index, position)| {
            let [x, y, z] = normals.get(index).copied().unwrap_or_default().map(whole);
            let [r, g, b] = colors.get(index).copied().unwrap_or([0.5; 3]).map(byte);
            Point { position: *position, normal: [x, y, z, 0], color: [r, g, b, 255] }
        }));
        self.points.write(&self.device, range.start as usize, &self.room)?;
        Ok(size_of_val(self.room.as_slice()) as u64)
    }
}

impl Shaded {
    /// Makes what draws with a device.
    pub(crate) fn new(device: &Device) -> Self {
        Self { device: device.clone(), pipelines: None }
    }

    /// Records the picture of solids into the part `area` of the target, given by its upper left and its size in pixels. A
    /// solid that is marked is drawn with its borders.
    ///
    /// # Errors
    /// The device has no memory for it, or is lost.
    pub(crate) fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &Target<'_>,
        [left, top, width, height]: [u32; 4],
        camera: &Camera,
        solids: &[(&Solid, bool)],
    ) -> Result<()> {
        let device = self.device.clone();
        let pipelines = match self.pipelines.take().filter(|it| it.format == target.format) {
            Some(pipelines) => self.pipelines.insert(pipelines),
            None => self.pipelines.insert(Pipelines::new(&device, target.format)?),
        };
        let (color, depth) = pipelines.targets(&device, target.size)?;
        let aspect = f64::from(width) / f64::from(height.max(1));
        let view = uniforms(&camera.matrix(aspect), camera);
        device.guard(|| device.queue().write_buffer(&pipelines.view, 0, bytemuck::bytes_of(&view)))?;
        let load = wgpu::LoadOp::Clear(BACKGROUND);
        let attachment = wgpu::RenderPassColorAttachment {
            view: &color,
            depth_slice: None,
            resolve_target: Some(target.view),
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Discard },
        };
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view: &depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("model"),
            color_attachments: &[Some(attachment)],
            depth_stencil_attachment: Some(depth),
            ..Default::default()
        });
        let is_inside = left + width <= target.size[0] && top + height <= target.size[1];
        if width == 0 || height == 0 || !is_inside {
            return Ok(());
        }
        pass.set_viewport(left as f32, top as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(left, top, width, height);
        pass.set_bind_group(0, &pipelines.group, &[]);
        for (solid, is_wired) in solids {
            if !solid.corners.is_empty() && !solid.points.is_empty() {
                pass.set_vertex_buffer(0, solid.points.wgpu().slice(..));
                pass.set_pipeline(&pipelines.surface);
                pass.set_index_buffer(solid.corners.wgpu().slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..solid.corners.len() as u32, 0, 0..1);
                if let Some(borders) = solid.borders.as_ref().filter(|borders| *is_wired && !borders.is_empty()) {
                    pass.set_pipeline(&pipelines.lines);
                    pass.set_index_buffer(borders.wgpu().slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..borders.len() as u32, 0, 0..1);
                }
            }
            if !solid.balls.is_empty() {
                pass.set_vertex_buffer(0, solid.balls.wgpu().slice(..));
                pass.set_pipeline(&pipelines.balls);
                pass.draw(0..4, 0..solid.balls.len() as u32);
            }
        }
        Ok(())
    }
}

fn uniforms(matrix: &DMat4, camera: &Camera) -> View {
    let axes = camera.axes();
    let axis = |axis: glam::DVec3| axis.as_vec3().extend(0.0).to_array();
    View {
        projection: matrix.as_mat4().to_cols_array(),
        axes: [axis(axes.x_axis), axis(axes.y_axis), axis(axes.z_axis)],
        line: [0.09, 0.1, 0.12, 2e-4],
    }
}

impl Pipelines {
    fn new(device: &Device, format: wgpu::TextureFormat) -> Result<Self> {
        device.guard(|| {
            let wgpu = device.wgpu();
            let module = wgpu.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("surface of the view"),
                source: wgpu::ShaderSource::Wgsl(include_str!("surface.wgsl").into()),
            });
            let layout = wgpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &[wgpu::BindGroupLayoutEntry {
                    binding: 0,
                    visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                    ty: wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Uniform,
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    count: None,
                }],
            });
            let view = wgpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("camera of the view"),
                size: size_of::<View>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let group = wgpu.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &layout,
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: view.as_entire_binding() }],
            });
            let layout = wgpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&layout)],
                ..Default::default()
            });
            let point = wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x4, 2 => Unorm8x4];
            let ball = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Unorm8x4];
            let points = wgpu::VertexBufferLayout {
                array_stride: size_of::<Point>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &point,
            };
            let balls = wgpu::VertexBufferLayout {
                array_stride: size_of::<DeviceBall>() as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &ball,
            };
            let pipeline = |names: [&str; 2], topology, buffer: &wgpu::VertexBufferLayout<'_>| {
                wgpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(names[1]),
                    layout: Some(&layout),
                    vertex: wgpu::VertexState {
                        module: &module,
                        entry_point: Some(names[0]),
                        compilation_options: Default::default(),
                        buffers: &[Some(buffer.clone())],
                    },
                    primitive: wgpu::PrimitiveState { topology, ..Default::default() },
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format: DEPTH,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(wgpu::CompareFunction::LessEqual),
                        stencil: Default::default(),
                        bias: Default::default(),
                    }),
                    multisample: wgpu::MultisampleState { count: SAMPLES, ..Default::default() },
                    fragment: Some(wgpu::FragmentState {
                        module: &module,
                        entry_point: Some(names[1]),
                        compilation_options: Default::default(),
                        targets: &[Some(format.into())],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            };
            let surface = pipeline(["surface_point", "surface_color"], wgpu::PrimitiveTopology::TriangleList, &points);
            let lines = pipeline(["line_point", "line_color"], wgpu::PrimitiveTopology::LineList, &points);
            let balls = pipeline(["ball_corner", "ball_color"], wgpu::PrimitiveTopology::TriangleStrip, &balls);
            Self { format, surface, lines, balls, view, group, targets: None }
        })
    }

    /// The targets of colour and depth of a size, made anew where it is another one.
    fn targets(&mut self, device: &Device, size: [u32; 2]) -> Result<(wgpu::TextureView, wgpu::TextureView)> {
        if let Some((_, color, depth)) = self.targets.as_ref().filter(|(made, ..)| *made == size) {
            return Ok((color.clone(), depth.clone()));
        }
        let texture = |format| {
            let texture = device.wgpu().create_texture(&wgpu::TextureDescriptor {
                label: Some("samples of the view"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: SAMPLES,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let (color, depth) = device.guard(|| (texture(self.format), texture(DEPTH)))?;
        self.targets = Some((size, color.clone(), depth.clone()));
        Ok((color, depth))
    }
}
