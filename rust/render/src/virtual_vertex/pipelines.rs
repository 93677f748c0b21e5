//! The pipelines of what is drawn, made when they are first needed.

use std::collections::BTreeMap;

use relievo_core::{Error, Result};
use relievo_gpu::module::{self, compose};
use relievo_gpu::wgsl::tiles_draw::TilesCall;
use relievo_gpu::wgsl::triangles_draw::TrianglesCall;
use relievo_gpu::{Device, wgpu, wgsl};
use relievo_surface::bezier::VirtualVertex;

use super::coat::DeviceCoat;
use super::patches::{Storage, UNIFORM_PATCHES};
use super::placed::{MeshVertex, PassedVertex, Shape};
use super::targets::{DEPTH, FORMATS};
use super::triangle_values::Kind;
use super::view::OBJECT_BYTES;

// Attributes lie one after another, and WGSL does not say where.
const _: () = assert!(size_of::<MeshVertex>() == 52 && size_of::<PassedVertex>() == 32);

/// What vertex and fragment stages do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Draw {
    /// Patches with control points in some storage, with weights or without.
    Patches(Storage, bool),
    /// The triangles beside their finer edges.
    Stitches(Storage, bool),
    Strips,
    /// Tiles without colours, with those of four bytes, with those of four half floats; with vectors, with traces.
    Tiles {
        colors: u8,
        vectors: bool,
        traces: bool,
    },
    /// Triangles in the pattern of their values.
    Triangles(Kind),
    Mesh,
    Indirect,
    Posed,
    Quads,
}

impl Draw {
    pub fn of(shape: &Shape<'_>) -> Self {
        match shape {
            Shape::Patches(patches) => Self::Patches(patches.storage(), patches.is_rational()),
            Shape::Strips(..) => Self::Strips,
            Shape::Tiles { coat, vectors, .. } => Self::Tiles {
                colors: coat.map_or(0, DeviceCoat::format),
                vectors: vectors.is_some(),
                traces: coat.is_some_and(DeviceCoat::has_traces),
            },
            Shape::Triangles(triangles) => Self::Triangles(triangles.kind()),
            Shape::Mesh(_) => Self::Mesh,
            Shape::Indirect(_) => Self::Indirect,
            Shape::Posed(_) => Self::Posed,
            Shape::Quads(_) => Self::Quads,
        }
    }

    /// The triangles beside finer edges of patches, which are a draw of their own.
    pub fn stitches(shape: &Shape<'_>) -> Option<Self> {
        match shape {
            Shape::Patches(patches) if patches.stitches.is_some() => {
                Some(Self::Stitches(patches.storage(), patches.is_rational()))
            }
            _ => None,
        }
    }

    fn module(self) -> &'static str {
        match self {
            Self::Patches(..) | Self::Stitches(..) | Self::Strips => "bezier_draw",
            Self::Tiles { .. } => "tiles_draw",
            Self::Triangles(_) => "triangles_draw",
            Self::Mesh => "mesh_draw",
            Self::Indirect => "indirect_draw",
            Self::Posed => "posed_draw",
            Self::Quads => "quad_draw",
        }
    }

    fn entry(self) -> &'static str {
        match self {
            Self::Patches(Storage::Uniform, _) | Self::Stitches(Storage::Uniform, _) => "vertex_uniform",
            Self::Patches(Storage::Texture, _) | Self::Stitches(Storage::Texture, _) => "vertex_texture",
            Self::Patches(Storage::Buffer, _) | Self::Stitches(Storage::Buffer, _) => "vertex_buffer",
            Self::Strips => "vertex_passed",
            Self::Tiles { .. } => "vertex_tiles",
            Self::Triangles(_) => "vertex_triangles",
            Self::Mesh => "vertex_mesh",
            Self::Indirect => "vertex_indirect",
            Self::Posed => "vertex_posed",
            Self::Quads => "vertex_quad",
        }
    }
}

/// Pipelines and the layouts of what is bound to them.
#[derive(Debug)]
pub(super) struct Pipelines {
    device: Device,
    modules: BTreeMap<&'static str, wgpu::ShaderModule>,
    /// Of group 0: to draw a picture, and a shadow map.
    scene: [wgpu::BindGroupLayout; 2],
    records: BTreeMap<Storage, [wgpu::BindGroupLayout; 1]>,
    tiles: [wgpu::BindGroupLayout; 3],
    triangles: [wgpu::BindGroupLayout; 2],
    posed: [wgpu::BindGroupLayout; 1],
    quads: [wgpu::BindGroupLayout; 1],
    made: BTreeMap<(Draw, bool), wgpu::RenderPipeline>,
}

fn layout(device: &Device, entries: &[(u32, wgpu::ShaderStages, wgpu::BindingType)]) -> Result<wgpu::BindGroupLayout> {
    let entries: Vec<_> = entries
        .iter()
        .map(|(binding, visibility, ty)| wgpu::BindGroupLayoutEntry {
            binding: *binding,
            visibility: *visibility,
            ty: *ty,
            count: None,
        })
        .collect();
    let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
    device.guard(|| device.wgpu().create_bind_group_layout(&descriptor))
}

impl Pipelines {
    pub fn new(device: &Device) -> Result<Self> {
        let uniform = |dynamic: bool, bytes: u64| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: dynamic,
            min_binding_size: std::num::NonZeroU64::new(bytes),
        };
        let texture = |sample_type, view_dimension| wgpu::BindingType::Texture {
            sample_type,
            view_dimension,
            multisampled: false,
        };
        let buffer = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        const BOTH: wgpu::ShaderStages = wgpu::ShaderStages::VERTEX_FRAGMENT;
        // Stages have few storage buffers on some devices: each sees what it reads.
        let buffers = |vertex: u32, fragment: u32| {
            let stage = |at: u32| if at < vertex { wgpu::ShaderStages::VERTEX } else { wgpu::ShaderStages::FRAGMENT };
            layout(device, &(0..vertex + fragment).map(|at| (at, stage(at), buffer)).collect::<Vec<_>>())
        };
        let object = uniform(true, OBJECT_BYTES);
        let points = texture(wgpu::TextureSampleType::Float { filterable: false }, wgpu::TextureViewDimension::D2);
        let scene = [
            (0, BOTH, buffer),
            (1, BOTH, object),
            (2, BOTH, texture(wgpu::TextureSampleType::Depth, wgpu::TextureViewDimension::D2Array)),
            (3, BOTH, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
        ];
        let records = BTreeMap::from([
            (Storage::Uniform, [layout(device, &[(0, BOTH, uniform(true, u64::from(UNIFORM_PATCHES) * 272))])?]),
            (Storage::Texture, [layout(device, &[(1, BOTH, points)])?]),
            (Storage::Buffer, [layout(device, &[(2, BOTH, buffer)])?]),
        ]);
        Ok(Self {
            scene: [layout(device, &scene)?, layout(device, &[(1, BOTH, object)])?],
            records,
            tiles: [buffers(4, 0)?, buffers(2, 0)?, buffers(4, 5)?],
            triangles: [buffers(2, 0)?, buffers(3, 0)?],
            posed: [buffers(2, 0)?],
            quads: [layout(device, &[0, 1, 2, 3].map(|at| (at, BOTH, buffer)))?],
            modules: BTreeMap::new(),
            made: BTreeMap::new(),
            device: device.clone(),
        })
    }

    /// The layout of group 0.
    pub fn scene_layout(&self, shadow: bool) -> &wgpu::BindGroupLayout {
        &self.scene[usize::from(shadow)]
    }

    /// The layouts of the groups from 1 on.
    pub fn layouts(&self, draw: Draw) -> &[wgpu::BindGroupLayout] {
        match draw {
            Draw::Patches(storage, _) | Draw::Stitches(storage, _) => &self.records[&storage],
            Draw::Tiles { .. } => &self.tiles,
            Draw::Triangles(_) => &self.triangles,
            Draw::Posed => &self.posed,
            Draw::Quads => &self.quads,
            Draw::Strips | Draw::Mesh | Draw::Indirect => &[],
        }
    }

    /// The pipeline of a draw that was made before.
    pub fn get(&self, draw: Draw, shadow: bool) -> Result<&wgpu::RenderPipeline> {
        self.made.get(&(draw, shadow)).ok_or_else(|| Error::internal("a pipeline was not made"))
    }

    /// Makes the pipeline of a draw into a picture, or into a shadow map, which has depths alone.
    pub fn make(&mut self, draw: Draw, shadow: bool) -> Result<()> {
        if self.made.contains_key(&(draw, shadow)) {
            return Ok(());
        }
        let name = draw.module();
        if !self.modules.contains_key(name) {
            let module = self.device.module(name, &compose(name)?)?;
            self.modules.insert(name, module);
        }
        let module = &self.modules[name];
        use wgpu::VertexFormat::{Float32x2, Float32x3, Uint32, Uint32x2};
        let attribute = |offset, shader_location, format| wgpu::VertexAttribute { offset, shader_location, format };
        let virtual_vertex = [attribute(0, 0, Float32x2), attribute(8, 1, Uint32), attribute(12, 2, Uint32)];
        let passed_vertex = [attribute(0, 0, Float32x3), attribute(12, 1, Uint32), attribute(16, 2, Float32x3)];
        let indirect_vertex = [attribute(0, 0, Float32x3), attribute(12, 1, Uint32)];
        let posed_corner = [attribute(0, 0, Uint32x2)];
        let mesh_vertex = [
            attribute(0, 0, Float32x3),
            attribute(12, 1, Float32x3),
            attribute(24, 2, Float32x3),
            attribute(36, 3, Float32x3),
            attribute(48, 4, Uint32),
        ];
        let (stride, attributes, immediates): (usize, &[_], u32) = match draw {
            Draw::Patches(..) | Draw::Stitches(..) => {
                (size_of::<VirtualVertex>(), &virtual_vertex, size_of::<wgsl::bezier_draw::Draw>() as u32)
            }
            Draw::Strips => (size_of::<PassedVertex>(), &passed_vertex, 0),
            Draw::Tiles { .. } => (0, &[], size_of::<TilesCall>() as u32),
            Draw::Triangles(_) => (0, &[], size_of::<TrianglesCall>() as u32),
            Draw::Mesh => (size_of::<MeshVertex>(), &mesh_vertex, 0),
            Draw::Indirect => (size_of::<[u32; 4]>(), &indirect_vertex, 0),
            Draw::Posed => (size_of::<[u32; 2]>(), &posed_corner, 0),
            Draw::Quads => (0, &[], size_of::<wgsl::quad_draw::Call>() as u32),
        };
        let buffers = [Some(wgpu::VertexBufferLayout {
            array_stride: stride as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes,
        })];
        let number = |on: bool| f64::from(u8::from(on));
        let constants = match draw {
            Draw::Patches(_, rational) | Draw::Stitches(_, rational) => vec![("RATIONAL", number(rational))],
            Draw::Tiles { colors, vectors, traces } => {
                vec![("COLORS", f64::from(colors)), ("VECTORS", number(vectors)), ("TRACES", number(traces))]
            }
            Draw::Triangles(Kind { colors, vectors, traces }) => {
                vec![("COLORS", number(colors)), ("VECTORS", number(vectors)), ("TRACES", number(traces))]
            }
            Draw::Strips | Draw::Mesh | Draw::Indirect | Draw::Posed | Draw::Quads => Vec::new(),
        };
        let options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        let mut layouts = vec![Some(self.scene_layout(shadow))];
        layouts.extend(self.layouts(draw).iter().map(Some));
        let targets = FORMATS.map(|format| Some(format.into()));
        let strips = matches!(draw, Draw::Patches(..) | Draw::Strips);
        // Of a picture on a quad some texels are empty.
        let fragment = if shadow { (draw == Draw::Quads).then_some("fragment_depth") } else { Some("fragment") };
        let device = self.device.wgpu();
        let pipeline = self
            .device
            .guard(|| {
                let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: None,
                    bind_group_layouts: &layouts,
                    immediate_size: immediates,
                });
                device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(draw.entry()),
                    layout: Some(&layout),
                    vertex: wgpu::VertexState {
                        module,
                        entry_point: Some(draw.entry()),
                        compilation_options: options.clone(),
                        buffers: if stride > 0 { &buffers } else { &[] },
                    },
                    primitive: wgpu::PrimitiveState {
                        topology: if strips {
                            wgpu::PrimitiveTopology::TriangleStrip
                        } else {
                            wgpu::PrimitiveTopology::TriangleList
                        },
                        ..wgpu::PrimitiveState::default()
                    },
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format: DEPTH,
                        depth_write_enabled: Some(true),
                        // Pictures have 1 at the near plane, shadow maps 0.
                        depth_compare: Some(if shadow {
                            wgpu::CompareFunction::Less
                        } else {
                            wgpu::CompareFunction::Greater
                        }),
                        stencil: wgpu::StencilState::default(),
                        bias: wgpu::DepthBiasState::default(),
                    }),
                    multisample: wgpu::MultisampleState::default(),
                    fragment: fragment.map(|entry| wgpu::FragmentState {
                        module,
                        entry_point: Some(entry),
                        compilation_options: options.clone(),
                        targets: if shadow { &[] } else { &targets },
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            })
            .map_err(|error| error.at(module::path(name)))?;
        self.made.insert((draw, shadow), pipeline);
        Ok(())
    }
}
