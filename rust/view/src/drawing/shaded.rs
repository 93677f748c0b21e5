//! The picture of triangles and balls on the graphics device: buffers of points and corners, of which what changed is
//! written, and the pass that draws them. A scene that rests is not drawn again: its last picture is copied.

use std::ops::Range;

use glam::DMat4;
use relievo_core::Result;
use relievo_gpu::{Buffer, Device, wgpu};

use super::camera::Camera;
use crate::show::Ball;
use crate::window::{Target, attachment};

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
#[derive(Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
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
    /// How often it was changed.
    changes: u64,
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
    copy: wgpu::RenderPipeline,
    view: wgpu::Buffer,
    group: wgpu::BindGroup,
    targets: Option<Targets>,
    /// What the picture in the targets is of.
    drawn: Option<Drawn>,
}

/// Targets of the size of the window.
struct Targets {
    size: [u32; 2],
    /// Colours and depths of all samples.
    color: wgpu::TextureView,
    depth: wgpu::TextureView,
    /// The picture, and what it is copied with.
    picture: wgpu::TextureView,
    copied: wgpu::BindGroup,
}

/// All that a picture depends on.
#[derive(PartialEq)]
struct Drawn {
    size: [u32; 2],
    area: [u32; 4],
    view: View,
    /// How often each solid was changed, and whether it has borders.
    solids: Vec<(u64, bool)>,
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
            changes: 0,
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
        self.changes += 1;
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
            self.changes += 1;
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
        self.changes += 1;
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
    /// solid that is marked is drawn with its borders. The solids at each place of the list are the same in every call.
    ///
    /// # Errors
    /// The device has no memory for it, or is lost.
    pub(crate) fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &Target<'_>,
        area: [u32; 4],
        camera: &Camera,
        solids: &[(&Solid, bool)],
    ) -> Result<()> {
        let device = self.device.clone();
        let pipelines = match self.pipelines.take().filter(|it| it.format == target.format) {
            Some(pipelines) => self.pipelines.insert(pipelines),
            None => self.pipelines.insert(Pipelines::new(&device, target.format)?),
        };
        pipelines.make_targets(&device, target.size)?;
        let aspect = f64::from(area[2]) / f64::from(area[3].max(1));
        let view = uniforms(&camera.matrix(aspect), camera);
        let states = solids.iter().map(|(solid, is_wired)| (solid.changes, *is_wired)).collect();
        let wanted = Drawn { size: target.size, area, view, solids: states };
        if pipelines.drawn.as_ref() != Some(&wanted) {
            device.guard(|| device.queue().write_buffer(&pipelines.view, 0, bytemuck::bytes_of(&view)))?;
            pipelines.draw(encoder, target.size, area, solids);
            pipelines.drawn = Some(wanted);
        }
        pipelines.copy(encoder, target);
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

/// Makes what copies a picture into the whole of a target.
fn copying(device: &wgpu::Device, format: wgpu::TextureFormat) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("copy.wgsl"));
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("copy of the view"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("copy_corner"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("copy_color"),
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
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
            let copy = copying(wgpu, format);
            Self { format, surface, lines, balls, copy, view, group, targets: None, drawn: None }
        })
    }

    /// Records the picture into the targets.
    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        size: [u32; 2],
        [left, top, width, height]: [u32; 4],
        solids: &[(&Solid, bool)],
    ) {
        let Some(targets) = &self.targets else { return };
        let load = wgpu::LoadOp::Clear(BACKGROUND);
        let attachment = wgpu::RenderPassColorAttachment {
            view: &targets.color,
            depth_slice: None,
            resolve_target: Some(&targets.picture),
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Discard },
        };
        let depth = wgpu::RenderPassDepthStencilAttachment {
            view: &targets.depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("model"),
            color_attachments: &[Some(attachment)],
            depth_stencil_attachment: Some(depth),
            ..Default::default()
        });
        let is_inside = left + width <= size[0] && top + height <= size[1];
        if width == 0 || height == 0 || !is_inside {
            return;
        }
        pass.set_viewport(left as f32, top as f32, width as f32, height as f32, 0.0, 1.0);
        pass.set_scissor_rect(left, top, width, height);
        pass.set_bind_group(0, &self.group, &[]);
        for (solid, is_wired) in solids {
            if !solid.corners.is_empty() && !solid.points.is_empty() {
                pass.set_vertex_buffer(0, solid.points.wgpu().slice(..));
                pass.set_pipeline(&self.surface);
                pass.set_index_buffer(solid.corners.wgpu().slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..solid.corners.len() as u32, 0, 0..1);
                if let Some(borders) = solid.borders.as_ref().filter(|borders| *is_wired && !borders.is_empty()) {
                    pass.set_pipeline(&self.lines);
                    pass.set_index_buffer(borders.wgpu().slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..borders.len() as u32, 0, 0..1);
                }
            }
            if !solid.balls.is_empty() {
                pass.set_vertex_buffer(0, solid.balls.wgpu().slice(..));
                pass.set_pipeline(&self.balls);
                pass.draw(0..4, 0..solid.balls.len() as u32);
            }
        }
    }

    /// Records a copy of the picture in the targets.
    fn copy(&self, encoder: &mut wgpu::CommandEncoder, target: &Target<'_>) {
        let Some(targets) = &self.targets else { return };
        let color_attachments = &[Some(attachment(target.view, wgpu::LoadOp::Clear(BACKGROUND)))];
        let mut pass =
            encoder.begin_render_pass(&wgpu::RenderPassDescriptor { color_attachments, ..Default::default() });
        pass.set_pipeline(&self.copy);
        pass.set_bind_group(0, &targets.copied, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Makes targets of a size if the last ones had another.
    fn make_targets(&mut self, device: &Device, size: [u32; 2]) -> Result<()> {
        if self.targets.as_ref().is_some_and(|targets| targets.size == size) {
            return Ok(());
        }
        self.drawn = None;
        let texture = |format, sample_count, usage| {
            let texture = device.wgpu().create_texture(&wgpu::TextureDescriptor {
                label: Some("picture of the view"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        self.targets = Some(device.guard(|| {
            let picture = texture(self.format, 1, wgpu::TextureUsages::TEXTURE_BINDING);
            let copied = device.wgpu().create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &self.copy.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&picture) }],
            });
            let [color, depth] =
                [self.format, DEPTH].map(|format| texture(format, SAMPLES, wgpu::TextureUsages::empty()));
            Targets { size, color, depth, picture, copied }
        })?);
        Ok(())
    }
}
