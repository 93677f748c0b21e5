//! Pipelines of shaders, and the commands that run them.

use relievo_core::{Error, Result};
use relievo_gpu::wgpu;
use relievo_gpu::{Buffer, Charge, Device, Frame, Readback};
use relievo_render::Image;

use super::bind::{Bound, texture};
use super::program::{Point, Program};
use crate::front::on_deep_stack;
use crate::source::Stage;

/// A compiled shader.
pub(super) enum Pipeline {
    /// A fragment shader with the picture that it draws.
    Fragment { pipeline: wgpu::RenderPipeline, channels: u32, target: Target },
    /// A compute shader with the edges of its workgroups.
    Compute { pipeline: wgpu::ComputePipeline, workgroup: [u32; 3], channels: u32 },
}

/// The picture that a fragment shader draws.
pub(super) struct Target {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    _charge: Charge,
}

impl Pipeline {
    pub fn new(device: &Device, program: &Program, entry: &Point, bound: &Bound, size: [u32; 2]) -> Result<Self> {
        // Compilers of drivers recurse as front ends do.
        let made = on_deep_stack(|| Self::compile(device, program, entry, bound, size));
        match made {
            Ok(Some(pipeline)) => pipeline,
            Ok(None) => Err(Error::internal("the compilation of the shader failed").at(entry.name.clone())),
            Err(error) => Err(Error::memory(format!("there is no memory to compile the shader: {error}"))),
        }
    }

    fn compile(device: &Device, program: &Program, entry: &Point, bound: &Bound, size: [u32; 2]) -> Result<Self> {
        let module = |text: &str| {
            let source = wgpu::ShaderSource::Wgsl(text.to_owned().into());
            device.guard(|| {
                device.wgpu().create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("shader"), source })
            })
        };
        let fragment = module(&program.text)?;
        let groups: Vec<_> = bound.layouts.iter().map(Option::as_ref).collect();
        let layout = device.guard(|| {
            device.wgpu().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &groups,
                immediate_size: 0,
            })
        })?;
        if entry.stage == Stage::Compute {
            let channels = bound.target.as_ref().map_or(0, |(_, channels)| *channels);
            let pipeline = device.guard(|| {
                device.wgpu().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: None,
                    layout: Some(&layout),
                    module: &fragment,
                    entry_point: Some(&entry.name),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    cache: None,
                })
            })?;
            return Ok(Self::Compute { pipeline, workgroup: entry.workgroup, channels });
        }
        let (format, channels) = match entry.output {
            Some(1) => (wgpu::TextureFormat::R32Float, 1),
            Some(2) => (wgpu::TextureFormat::Rg32Float, 2),
            Some(4) => (wgpu::TextureFormat::Rgba32Float, 4),
            _ => {
                return Err(Error::unsupported("the output at location 0 is no float and no vector of 2 or 4 floats")
                    .at(entry.name.clone())
                    .advise("declare it as a vector of 4 floats"));
            }
        };
        let own = program.points.iter().find(|point| point.stage == Stage::Vertex && point.inputs.is_empty());
        let covering = match own {
            Some(_) => None,
            None => Some(module(&rectangle(entry)?)?),
        };
        let (vertex, vertex_entry) = match (&covering, own) {
            (Some(module), _) => (module, "cover"),
            (None, Some(point)) => (&fragment, point.name.as_str()),
            (None, None) => (&fragment, entry.name.as_str()),
        };
        let pipeline = device.guard(|| {
            device.wgpu().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: None,
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: vertex,
                    entry_point: Some(vertex_entry),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &fragment,
                    entry_point: Some(&entry.name),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        let [width, height] = size;
        let charge = device.charge(4 * u64::from(channels) * u64::from(width) * u64::from(height))?;
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let descriptor = texture(extent, wgpu::TextureDimension::D2, format, usage);
        let made = device.guard(|| device.wgpu().create_texture(&descriptor))?;
        let view = made.create_view(&wgpu::TextureViewDescriptor::default());
        let target = Target { texture: made, view, _charge: charge };
        Ok(Self::Fragment { pipeline, channels, target })
    }

    /// Records a run for all pixels, or for one.
    pub fn record(&self, frame: &mut Frame, bound: &Bound, size: [u32; 2], pixel: Option<[u32; 2]>) -> Result<()> {
        let groups = || (0..).zip(&bound.groups).filter_map(|(index, group)| Some((index, group.as_ref()?)));
        match self {
            Self::Fragment { pipeline, target, .. } => {
                let attachment = wgpu::RenderPassColorAttachment {
                    view: &target.view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                        store: wgpu::StoreOp::Store,
                    },
                };
                let mut pass = frame.draw(
                    "shader",
                    &wgpu::RenderPassDescriptor { color_attachments: &[Some(attachment)], ..Default::default() },
                );
                pass.set_pipeline(pipeline);
                groups().for_each(|(index, group)| pass.set_bind_group(index, group, &[]));
                if let Some([x, y]) = pixel {
                    pass.set_scissor_rect(x, y, 1, 1);
                }
                pass.draw(0..3, 0..1);
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
            Self::Fragment { target, channels, .. } => (&target.texture, *channels),
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
            Self::Fragment { channels, .. } | Self::Compute { channels, .. } => *channels,
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
    for (location, floats) in &entry.inputs {
        let (ty, value) = match floats {
            Some(1) => ("f32", "place.x"),
            Some(2) => ("vec2<f32>", "place"),
            Some(3) => ("vec3<f32>", "vec3<f32>(place, 0.0)"),
            Some(4) => ("vec4<f32>", "vec4<f32>(place, 0.0, 1.0)"),
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
