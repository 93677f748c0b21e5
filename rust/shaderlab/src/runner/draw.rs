//! Pipelines of shaders, and the commands that run them.

use std::ops::Range;

use relievo_core::{Error, Result};
use relievo_gpu::wgpu;
use relievo_gpu::{Buffer, Charge, Device, Frame, Readback};
use relievo_render::Image;

use super::bind::{Bound, texture};
use super::geometry::Geometry;
use super::program::{Chosen, Located, Point, Program};
use crate::front::on_deep_stack;
use crate::resource::FieldKind;
use crate::source::Stage;

/// A compiled shader.
pub(super) enum Pipeline {
    /// A shader that draws.
    Draw(Box<Drawing>),
    /// A compute shader with the edges of its workgroups.
    Compute { pipeline: wgpu::ComputePipeline, workgroup: [u32; 3], channels: u32 },
}

/// A fragment shader, a vertex shader or both, with the picture that they draw.
pub(super) struct Drawing {
    triangles: wgpu::RenderPipeline,
    /// Runs the vertex shader of single vertices, where it takes vectors, and draws nothing.
    points: Option<wgpu::RenderPipeline>,
    channels: u32,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    /// The depths of what is drawn, where that is more than a rectangle.
    depth: Option<wgpu::TextureView>,
    _charges: Vec<Charge>,
}

/// What to run.
pub(super) enum Run {
    /// All pixels.
    All,
    /// One pixel.
    Pixel([u32; 2]),
    /// Vertices and instances, without any pixel.
    Vertices([Range<u32>; 2]),
}

/// The format of depths.
const DEPTHS: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The fragment shader of [`Drawing::points`].
const NOTHING: &str = "@fragment fn nothing() -> @location(0) vec4<f32> { return vec4<f32>(0.0); }\n";

impl Pipeline {
    /// Compiles the entry points that run. `geometry` is what a vertex shader of the program draws.
    pub fn new(
        device: &Device,
        program: &Program,
        chosen: &Chosen,
        geometry: Option<&Geometry>,
        bound: &Bound,
        size: [u32; 2],
    ) -> Result<Self> {
        // Compilers of drivers recurse as front ends do.
        let made = on_deep_stack(|| Self::compile(device, program, chosen, geometry, bound, size));
        match made {
            Ok(Some(pipeline)) => pipeline,
            Ok(None) => Err(Error::internal("the compilation of the shader failed")),
            Err(error) => Err(Error::memory(format!("there is no memory to compile the shader: {error}"))),
        }
    }

    fn compile(
        device: &Device,
        program: &Program,
        chosen: &Chosen,
        geometry: Option<&Geometry>,
        bound: &Bound,
        size: [u32; 2],
    ) -> Result<Self> {
        let module = |text: &str| {
            let source = wgpu::ShaderSource::Wgsl(text.to_owned().into());
            device.guard(|| {
                device.wgpu().create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("shader"), source })
            })
        };
        let own = module(&program.text)?;
        let groups: Vec<_> = bound.layouts.iter().map(Option::as_ref).collect();
        let layout = device.guard(|| {
            device.wgpu().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &groups,
                immediate_size: 0,
            })
        })?;
        if let Some(entry) = chosen.pixels.as_ref().filter(|entry| entry.stage == Stage::Compute) {
            let channels = bound.target.as_ref().map_or(0, |(_, channels)| *channels);
            let pipeline = device.guard(|| {
                device.wgpu().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: None,
                    layout: Some(&layout),
                    module: &own,
                    entry_point: Some(&entry.name),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    cache: None,
                })
            })?;
            return Ok(Self::Compute { pipeline, workgroup: entry.workgroup, channels });
        }
        let (vertex, vertex_entry) = match (&chosen.vertices, &program.vertex, &chosen.pixels) {
            // The only vertex entry point of its text, whose name changes where it is written anew.
            (Some(_), Some(other), _) => (module(&other.text)?, None),
            (Some(point), None, _) => (own.clone(), Some(point.name.as_str())),
            (None, _, Some(pixels)) => (module(&rectangle(pixels)?)?, Some("cover")),
            (None, _, None) => return Err(Error::internal("no entry point was chosen")),
        };
        let (fragment, fragment_entry, channels) = match (&chosen.pixels, &chosen.vertices) {
            (Some(pixels), _) => (own, pixels.name.as_str(), pixels.output()),
            (None, Some(vertices)) => (module(&paint(vertices))?, "paint", Some(4)),
            (None, None) => return Err(Error::internal("no entry point was chosen")),
        };
        let format = match channels {
            Some(1) => wgpu::TextureFormat::R32Float,
            Some(2) => wgpu::TextureFormat::Rg32Float,
            Some(4) => wgpu::TextureFormat::Rgba32Float,
            _ => {
                return Err(Error::unsupported("the output at location 0 is no float and no vector of 2 or 4 floats")
                    .at(fragment_entry.to_owned())
                    .advise("declare it as a vector of 4 floats"));
            }
        };
        let attributes: Vec<_> = geometry.iter().flat_map(|geometry| &geometry.attributes).collect();
        let described: Vec<_> = attributes
            .iter()
            .map(|(location, format, ..)| {
                [wgpu::VertexAttribute { format: *format, offset: 0, shader_location: *location }]
            })
            .collect();
        let buffers: Vec<_> = attributes
            .iter()
            .zip(&described)
            .map(|((.., stride, _), attributes)| {
                let step_mode = wgpu::VertexStepMode::Vertex;
                Some(wgpu::VertexBufferLayout { array_stride: *stride, step_mode, attributes })
            })
            .collect();
        let pipeline = |topology, fragment: &wgpu::ShaderModule, entry: &str, writes: wgpu::ColorWrites| {
            let target = wgpu::ColorTargetState { format, blend: None, write_mask: writes };
            device.guard(|| {
                device.wgpu().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: None,
                    layout: Some(&layout),
                    vertex: wgpu::VertexState {
                        module: &vertex,
                        entry_point: vertex_entry,
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        buffers: &buffers,
                    },
                    primitive: wgpu::PrimitiveState { topology, ..Default::default() },
                    depth_stencil: geometry.map(|_| wgpu::DepthStencilState {
                        format: DEPTHS,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(wgpu::CompareFunction::LessEqual),
                        stencil: wgpu::StencilState::default(),
                        bias: wgpu::DepthBiasState::default(),
                    }),
                    multisample: wgpu::MultisampleState::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: fragment,
                        entry_point: Some(entry),
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        targets: &[Some(target)],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            })
        };
        let list = wgpu::PrimitiveTopology::TriangleList;
        let triangles = pipeline(list, &fragment, fragment_entry, wgpu::ColorWrites::ALL)?;
        let points = match chosen.vertices.as_ref().is_some_and(|point| point.is_marked) {
            true => {
                let list = wgpu::PrimitiveTopology::PointList;
                Some(pipeline(list, &module(NOTHING)?, "nothing", wgpu::ColorWrites::empty())?)
            }
            false => None,
        };
        let channels = channels.unwrap_or(4);
        let mut charges = Vec::new();
        let mut target = |format, texels: u64, usage| {
            charges.push(device.charge(texels * u64::from(size[0]) * u64::from(size[1]))?);
            let extent = wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 };
            let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | usage;
            let descriptor = texture(extent, wgpu::TextureDimension::D2, format, usage);
            device.guard(|| device.wgpu().create_texture(&descriptor))
        };
        let made = target(format, 4 * u64::from(channels), wgpu::TextureUsages::COPY_SRC)?;
        let depth = geometry.map(|_| target(DEPTHS, 4, wgpu::TextureUsages::empty())).transpose()?;
        Ok(Self::Draw(Box::new(Drawing {
            triangles,
            points,
            channels,
            view: made.create_view(&wgpu::TextureViewDescriptor::default()),
            texture: made,
            depth: depth.map(|depth| depth.create_view(&wgpu::TextureViewDescriptor::default())),
            _charges: charges,
        })))
    }

    /// Records a run. `geometry` is what a vertex shader of the program draws.
    pub fn record(
        &self,
        frame: &mut Frame,
        bound: &Bound,
        geometry: Option<&Geometry>,
        size: [u32; 2],
        run: Run,
    ) -> Result<()> {
        let groups = || (0..).zip(&bound.groups).filter_map(|(index, group)| Some((index, group.as_ref()?)));
        match self {
            Self::Draw(drawing) => {
                // Runs of vertices leave the picture alone: clearing it would take longer than they do.
                let draws = !matches!(run, Run::Vertices(_));
                let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
                let attachment = wgpu::RenderPassColorAttachment {
                    view: &drawing.view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: if draws { clear } else { wgpu::LoadOp::Load },
                        store: wgpu::StoreOp::Store,
                    },
                };
                let load = if draws { wgpu::LoadOp::Clear(1.0) } else { wgpu::LoadOp::Load };
                let depth = drawing.depth.as_ref().map(|view| wgpu::RenderPassDepthStencilAttachment {
                    view,
                    depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                });
                let descriptor = wgpu::RenderPassDescriptor {
                    color_attachments: &[Some(attachment)],
                    depth_stencil_attachment: depth,
                    ..Default::default()
                };
                let mut pass = frame.draw("shader", &descriptor);
                let [count, instances] = geometry.map_or([3, 1], |geometry| geometry.count);
                let (pipeline, [vertices, instances]) = match (&run, &drawing.points) {
                    (Run::Vertices(ranges), Some(points)) => (points, ranges.clone()),
                    (Run::Vertices(_), None) => return Err(Error::internal("the vertex shader takes no vectors")),
                    (Run::All | Run::Pixel(_), _) => (&drawing.triangles, [0..count, 0..instances]),
                };
                pass.set_pipeline(pipeline);
                groups().for_each(|(index, group)| pass.set_bind_group(index, group, &[]));
                let attributes = geometry.iter().flat_map(|geometry| &geometry.attributes);
                for (slot, (.., buffer)) in (0..).zip(attributes) {
                    pass.set_vertex_buffer(slot, buffer.wgpu().slice(..));
                }
                if let Run::Pixel([x, y]) = run {
                    pass.set_scissor_rect(x, y, 1, 1);
                }
                pass.draw(vertices, instances);
            }
            Self::Compute { pipeline, workgroup, .. } => {
                let descriptor = wgpu::ComputePassDescriptor::default();
                let mut pass = frame.encoder().begin_compute_pass(&descriptor);
                pass.set_pipeline(pipeline);
                groups().for_each(|(index, group)| pass.set_bind_group(index, group, &[]));
                let [columns, rows, _] = *workgroup;
                pass.dispatch_workgroups(size[0].div_ceil(columns.max(1)), size[1].div_ceil(rows.max(1)), 1);
            }
        }
        Ok(())
    }

    /// Records the copy of the picture to the host.
    pub fn read(&self, device: &Device, frame: &mut Frame, bound: &Bound, size: [u32; 2]) -> Result<Readback<f32>> {
        let (texture, channels) = match self {
            Self::Draw(drawing) => (&drawing.texture, drawing.channels),
            Self::Compute { .. } => match &bound.target {
                Some((texture, channels)) => (texture, *channels),
                None => {
                    return Err(Error::unsupported("the compute shader writes no picture")
                        .advise("let it write a 2-D storage texture of the format rgba32float"));
                }
            },
        };
        let [width, height] = size;
        let row = (width * channels).next_multiple_of(64);
        let buffer = Buffer::<f32>::new(device, "picture", row as usize * height as usize)?;
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * row), rows_per_image: Some(height) };
        frame.encoder().copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: buffer.wgpu(), layout },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        frame.read(&buffer, 0..buffer.len())
    }

    /// Makes an image of what was read.
    pub fn image(&self, padded: &[f32], size: [u32; 2]) -> Result<Image> {
        let channels = match self {
            Self::Draw(drawing) => drawing.channels,
            Self::Compute { channels, .. } => *channels,
        };
        let [width, height] = size;
        let row = (width * channels).next_multiple_of(64) as usize;
        let rows = padded.chunks_exact(row).flat_map(|line| &line[..(width * channels) as usize]);
        Image::from_data(width, height, channels, rows.copied().collect())
    }
}

/// Returns a vertex shader that covers the picture and gives a fragment shader its inputs: 0 to 1 from the upper left corner,
/// in the first two floats of each; further floats are 0 and 1.
fn rectangle(entry: &Point) -> Result<String> {
    let mut members = String::new();
    let mut values = String::new();
    for Located { location, numbers, .. } in &entry.inputs {
        let (ty, value) = match numbers {
            Some((FieldKind::Float, 1)) => ("f32", "place.x"),
            Some((FieldKind::Float, 2)) => ("vec2<f32>", "place"),
            Some((FieldKind::Float, 3)) => ("vec3<f32>", "vec3<f32>(place, 0.0)"),
            Some((FieldKind::Float, 4)) => ("vec4<f32>", "vec4<f32>(place, 0.0, 1.0)"),
            _ => {
                return Err(Error::unsupported(format!(
                    "the input at location {location} is no float or vector of floats"
                ))
                .at(entry.name.clone())
                .advise("compute it in the fragment shader"));
            }
        };
        members.push_str(&format!("    @location({location}) input_{location}_: {ty},\n"));
        values.push_str(&format!("    out.input_{location}_ = {value};\n"));
    }
    Ok(format!(
        "struct Out {{\n    @builtin(position) position: vec4<f32>,\n{members}}}\n\
         @vertex fn cover(@builtin(vertex_index) index: u32) -> Out {{\n    \
             let place = vec2<f32>(vec2<u32>(index << 1u, index) & vec2<u32>(2u));\n    \
             var out: Out;\n    \
             out.position = vec4<f32>(place * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0), 0.0, 1.0);\n{values}    \
             return out;\n}}\n"
    ))
}

/// Returns a fragment shader for a vertex shader that runs alone: it shows the floats of the output at location 0, and
/// white where it has no such output.
fn paint(vertex: &Point) -> String {
    let first = vertex.outputs.iter().find(|output| output.location == 0 && output.is_smooth);
    let (ty, value) = match first.and_then(|output| output.numbers) {
        Some((FieldKind::Float, 1)) => ("f32", "vec4<f32>(vec3<f32>(value), 1.0)"),
        Some((FieldKind::Float, 2)) => ("vec2<f32>", "vec4<f32>(value, 0.0, 1.0)"),
        Some((FieldKind::Float, 3)) => ("vec3<f32>", "vec4<f32>(value, 1.0)"),
        Some((FieldKind::Float, 4)) => ("vec4<f32>", "value"),
        _ => return "@fragment fn paint() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }\n".to_owned(),
    };
    format!("@fragment fn paint(@location(0) value: {ty}) -> @location(0) vec4<f32> {{ return {value}; }}\n")
}
