//! The offscreen rasteriser of virtual vertices: colours shaded as by the ray caster, and depth, normal, reflectance and
//! number of what is at the middle of every pixel (`shaders/draw/shade.wgsl` and what imports it).
//!
//! Suns throw shadows by a map each, drawn of the same vertices; their angular size is left out. The sky's light is the
//! mean over the hemisphere, without occlusion, as the ray caster has it without rays to the sky.

use std::time::Duration;

use glam::{DMat4, Vec3};
use half::f16;
use relievo_core::{Error, Result};
use relievo_gpu::wgsl::shade::ViewBlock;
use relievo_gpu::wgsl::tiles_draw::TilesCall;
use relievo_gpu::wgsl::triangles_draw::TrianglesCall;
use relievo_gpu::{Buffer, Charge, Device, wgpu};

use super::coat::{DeviceCoat, Tint};
use super::patches::{DrawCall, Storage, UNIFORM_PATCHES, VirtualVertices};
use super::pipelines::{Draw, Pipelines};
use super::placed::{Placed, Shape};
use super::records::{Records, block_stride};
use super::targets::{PIXEL_BYTES, SHADOW_SIDE, ShadowMaps, Target, Targets};
use super::view::{Extent, OBJECT_BYTES, ObjectSlot, SUNS, object_slot, projection, shadow, view_block};
use crate::frame::{Frame, NO_OBJECT};
use crate::image::Image;
use crate::settings::View;

/// What draws: its pipelines, its targets and the view.
#[derive(Debug)]
pub struct Rasterizer {
    device: Device,
    pipelines: Pipelines,
    view: Buffer<ViewBlock>,
    objects: Option<(wgpu::Buffer, usize, Charge)>,
    nothing: Buffer<[u32; 4]>,
    sampler: wgpu::Sampler,
    targets: Option<Targets>,
    shadows: Option<ShadowMaps>,
}

/// The bind groups of what is drawn.
struct Groups {
    /// From group 1 on.
    own: Vec<wgpu::BindGroup>,
}

impl Rasterizer {
    /// A rasteriser on `device`.
    ///
    /// # Errors
    /// The device cannot write colours, normals, numbers and reflectances of a pixel at once, or fails.
    pub fn new(device: &Device) -> Result<Self> {
        if device.limits().max_color_attachment_bytes_per_sample < PIXEL_BYTES {
            return Err(Error::unsupported(format!("{} draws too few bytes a pixel", device.summary())));
        }
        let sampler = device.guard(|| {
            device.wgpu().create_sampler(&wgpu::SamplerDescriptor {
                label: Some("shadows"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                compare: Some(wgpu::CompareFunction::LessEqual),
                ..wgpu::SamplerDescriptor::default()
            })
        })?;
        Ok(Self {
            pipelines: Pipelines::new(device)?,
            view: Buffer::new(device, "view", 1)?,
            objects: None,
            nothing: Buffer::new(device, "no colours", 1)?,
            sampler,
            targets: None,
            shadows: None,
            device: device.clone(),
        })
    }

    /// Draws a picture of `objects` and reads it back. `view.settings.samples` colours are taken in every pixel.
    ///
    /// # Errors
    /// The view cannot be used, the picture is too large for the device, or the device fails.
    pub fn render(&mut self, objects: &[Placed<'_>], view: &View) -> Result<Frame> {
        view.check()?;
        let [width, height] = [view.settings.width, view.settings.height];
        // Colours as many times as finely; what is behind pixels at their middles.
        let fine = (1..=16u32).find(|fine| fine * fine >= view.settings.samples).unwrap_or(16);
        self.draw(objects, view, [width, height], 1.0)?;
        let geometry = self.read(Target::Geometry)?;
        let numbers = self.read(Target::Number)?;
        let albedo = self.read(Target::Albedo)?;
        if fine > 1 {
            self.draw(objects, view, [width * fine, height * fine], fine as f32)?;
        }
        let colors = self.read(Target::Color)?;
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
                    let [rg, b] = [albedo[2 * at], albedo[2 * at + 1]];
                    let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
                    frame.normal.set_color(x, y, [nx, ny, nz]);
                    frame.albedo.set_color(x, y, [half(rg), half(rg >> 16), half(b)]);
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
    pub fn time(&mut self, objects: &[Placed<'_>], view: &View, size: [u32; 2]) -> Result<Duration> {
        self.draw(objects, view, size, 1.0)
    }

    fn read(&self, target: Target) -> Result<Vec<u32>> {
        let targets = self.targets.as_ref().ok_or_else(|| Error::internal("nothing was drawn"))?;
        targets.read(&self.device, target)
    }

    /// Draws shadow maps and the picture, which is `scale` times finer than the view says.
    fn draw(&mut self, objects: &[Placed<'_>], view: &View, size: [u32; 2], scale: f32) -> Result<Duration> {
        if self.targets.as_ref().is_none_or(|targets| targets.size != size) {
            self.targets = None;
            self.targets = Some(Targets::new(&self.device, size)?);
        }
        let suns = if view.settings.shadows.is_on() { view.lights.suns.len().min(SUNS) } else { 0 };
        if self.shadows.as_ref().is_none_or(|maps| maps.suns() != suns as u32) {
            self.shadows = None;
            self.shadows = Some(ShadowMaps::new(&self.device, suns as u32)?);
        }
        let eye = view.camera.eye;
        let extent = Extent::of(objects.iter(), eye);
        let thrown = Extent::of(objects.iter().filter(|object| object.throws_shadows), eye);
        let shadows: Vec<_> =
            view.lights.suns[..suns].iter().map(|sun| shadow(sun.direction, &thrown, SHADOW_SIDE)).collect();
        self.view.write(&self.device, 0, &[view_block(view, scale, &shadows)])?;
        // The blocks of all objects as the camera sees them, then as each sun does.
        let spaces = [projection(&view.camera, size, &extent)].into_iter().chain(shadows.iter().map(|shadow| shadow.0));
        let blocks: Vec<ObjectSlot> = spaces
            .flat_map(|space: DMat4| {
                objects
                    .iter()
                    .map(move |object| object_slot(space, eye, &object.transform, &object.material, object.number))
            })
            .collect();
        let buffer = self.write_objects(&blocks)?;
        let (Some(targets), Some(maps)) = (&self.targets, &self.shadows) else {
            return Err(Error::internal("nothing to draw into"));
        };
        let groups: Vec<Groups> = objects.iter().map(|object| self.groups(&object.shape)).collect::<Result<_>>()?;
        let device = &self.device;
        let object = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &buffer,
            offset: 0,
            size: std::num::NonZeroU64::new(OBJECT_BYTES),
        });
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let shadow_group = device.guard(|| {
            device.wgpu().create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: self.pipelines.scene_layout(true),
                entries: &[entry(1, object.clone())],
            })
        })?;
        let maps_view = maps.view();
        let scene_group = device.guard(|| {
            device.wgpu().create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: self.pipelines.scene_layout(false),
                entries: &[
                    entry(0, self.view.wgpu().as_entire_binding()),
                    entry(1, object),
                    entry(2, wgpu::BindingResource::TextureView(&maps_view)),
                    entry(3, wgpu::BindingResource::Sampler(&self.sampler)),
                ],
            })
        })?;
        for object in objects {
            for draw in std::iter::once(Draw::of(&object.shape)).chain(Draw::stitches(&object.shape)) {
                self.pipelines.make(draw, false)?;
                if suns > 0 {
                    self.pipelines.make(draw, true)?;
                }
            }
        }
        let mut frame = device.frame()?;
        for sun in 0..suns {
            let layer = maps.layer(sun as u32);
            let descriptor = wgpu::RenderPassDescriptor {
                label: Some("shadows"),
                depth_stencil_attachment: Some(depth_attachment(&layer, 1.0)),
                ..wgpu::RenderPassDescriptor::default()
            };
            let mut pass = frame.draw("shadows", &descriptor);
            for (index, (object, groups)) in objects.iter().zip(&groups).enumerate() {
                pass.set_bind_group(0, &shadow_group, &[offset((1 + sun) * objects.len() + index)?]);
                if object.throws_shadows {
                    draw_shape(&mut pass, &object.shape, groups, |draw| self.pipelines.get(draw, true))?;
                }
            }
        }
        let (views, depth) = targets.views();
        let attachments = views.each_ref().map(|view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })
        });
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some("draw"),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(depth_attachment(&depth, 0.0)),
            ..wgpu::RenderPassDescriptor::default()
        };
        let mut pass = frame.draw("draw", &descriptor);
        for (index, (object, groups)) in objects.iter().zip(&groups).enumerate() {
            pass.set_bind_group(0, &scene_group, &[offset(index)?]);
            draw_shape(&mut pass, &object.shape, groups, |draw| self.pipelines.get(draw, false))?;
        }
        drop(pass);
        let times = frame.submit()?.wait()?;
        Ok(times.iter().map(|pass| pass.length).sum())
    }

    /// Writes the blocks of all objects.
    fn write_objects(&mut self, blocks: &[ObjectSlot]) -> Result<wgpu::Buffer> {
        let device = &self.device;
        if self.objects.as_ref().is_none_or(|(_, room, _)| *room < blocks.len()) {
            let room = blocks.len().max(1).next_power_of_two();
            let size = (room * size_of::<ObjectSlot>()) as u64;
            let charge = device.charge(size)?;
            let buffer = device.guard(|| {
                device.wgpu().create_buffer(&wgpu::BufferDescriptor {
                    label: Some("objects"),
                    size,
                    usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            })?;
            self.objects = Some((buffer, room, charge));
        }
        let Some((buffer, ..)) = &self.objects else { return Err(Error::internal("no room for objects")) };
        device.guard(|| device.queue().write_buffer(buffer, 0, bytemuck::cast_slice(blocks)))?;
        Ok(buffer.clone())
    }

    fn groups(&self, shape: &Shape<'_>) -> Result<Groups> {
        let draw = Draw::of(shape);
        let own = match shape {
            Shape::Patches(patches) => vec![self.record_group(patches)?],
            Shape::Strips(..) | Shape::Mesh(_) | Shape::Indirect(_) => Vec::new(),
            Shape::Posed(mesh) => vec![self.buffer_group(draw, 0, &[mesh.vertices.wgpu(), mesh.instances])?],
            Shape::Quads(mesh) => {
                let buffers = [mesh.quads.wgpu(), mesh.instances, mesh.pictures.wgpu(), mesh.texels.wgpu()];
                vec![self.buffer_group(draw, 0, &buffers)?]
            }
            Shape::Tiles { surface, tiles, vectors, coat, drawn } => {
                let nothing = self.nothing.wgpu();
                let count = drawn.rates().count();
                let channels = [tiles.field().tile_count()].into_iter();
                let channels = channels.chain(vectors.map(|vectors| vectors.field().tile_count()));
                if channels.chain(coat.iter().flat_map(|coat| coat.tile_counts())).any(|tiles| tiles != count) {
                    return Err(Error::invalid(
                        "the displacement or colours that are drawn are those of another surface",
                    ));
                }
                let vectors = vectors.map_or([nothing; 2], |vectors| vectors.buffers());
                let mut last = vec![drawn.joints.wgpu(), drawn.drawn.wgpu(), vectors[0], vectors[1]];
                last.extend(coat.map_or([nothing; 5], |coat| coat.buffers(nothing)));
                vec![
                    self.buffer_group(draw, 0, &surface.buffers())?,
                    self.buffer_group(draw, 1, &tiles.buffers())?,
                    self.buffer_group(draw, 2, &last)?,
                ]
            }
            Shape::Triangles(triangles) => vec![
                self.buffer_group(draw, 0, &triangles.mesh.buffers())?,
                self.buffer_group(draw, 1, &triangles.buffers())?,
            ],
        };
        Ok(Groups { own })
    }

    /// Storage buffers, bound from 0 on.
    fn buffer_group(&self, draw: Draw, group: usize, buffers: &[&wgpu::Buffer]) -> Result<wgpu::BindGroup> {
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let layout = &self.pipelines.layouts(draw)[group];
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
        self.device.guard(|| self.device.wgpu().create_bind_group(&descriptor))
    }

    /// The bind group of the control points.
    fn record_group(&self, patches: &VirtualVertices) -> Result<wgpu::BindGroup> {
        let layout = &self.pipelines.layouts(Draw::of(&Shape::Patches(patches)))[0];
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
}

fn depth_attachment(view: &wgpu::TextureView, far: f32) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(far), store: wgpu::StoreOp::Store }),
        stencil_ops: None,
    }
}

/// Where the block of an object is.
fn offset(index: usize) -> Result<u32> {
    u32::try_from(index * size_of::<ObjectSlot>()).map_err(|_| Error::unsupported("so many objects cannot be drawn"))
}

/// Records the draws of an object.
fn draw_shape<'a>(
    pass: &mut wgpu::RenderPass<'_>,
    shape: &Shape<'_>,
    groups: &Groups,
    pipeline: impl Fn(Draw) -> Result<&'a wgpu::RenderPipeline>,
) -> Result<()> {
    pass.set_pipeline(pipeline(Draw::of(shape))?);
    for (index, group) in (1..).zip(&groups.own) {
        if !matches!(shape, Shape::Patches(patches) if patches.storage() == Storage::Uniform) {
            pass.set_bind_group(index, group, &[]);
        }
    }
    match shape {
        Shape::Patches(patches) => {
            draw_patches(pass, patches, groups)?;
            match (Draw::stitches(shape), &patches.stitches) {
                (Some(draw), Some(vertices)) => {
                    pass.set_pipeline(pipeline(draw)?);
                    pass.set_vertex_buffer(0, vertices.wgpu().slice(..));
                    draw_stitches(pass, patches, groups)
                }
                _ => Ok(()),
            }
        }
        Shape::Strips(patches, vertices) => {
            pass.set_vertex_buffer(0, vertices.buffer.wgpu().slice(..));
            let mut first = 0u32;
            for draw in patches.draws() {
                let last = draw.vertices()?.saturating_add(first);
                if last as usize > vertices.len() {
                    return Err(Error::internal(format!("{} vertices for draws of {last}", vertices.len())));
                }
                pass.draw(first..last, 0..1);
                first = last;
            }
            Ok(())
        }
        Shape::Tiles { drawn, coat, .. } => {
            let blank = coat.map_or([0.0; 3], DeviceCoat::blank);
            let tint = coat.map_or(Tint::default(), DeviceCoat::tint).into();
            for draw in drawn.draws() {
                let Some(grid) = drawn.grids.get(&(draw.power, draw.part)) else {
                    return Err(Error::internal("a part has no triangles"));
                };
                pass.set_index_buffer(grid.wgpu().slice(..), wgpu::IndexFormat::Uint32);
                pass.set_immediates(0, bytemuck::bytes_of(&TilesCall { blank, first: draw.first, tint }));
                pass.draw_indexed(0..grid.len() as u32, 0, 0..draw.count);
            }
            Ok(())
        }
        Shape::Triangles(triangles) => {
            let tint = triangles.tint().into();
            for draw in triangles.draws() {
                let Some(indices) = triangles.indices.get(&draw.part) else {
                    return Err(Error::internal("a part has no triangles"));
                };
                pass.set_index_buffer(indices.wgpu().slice(..), wgpu::IndexFormat::Uint32);
                let call = TrianglesCall { tint, first: draw.first, padding: [0; 3] };
                pass.set_immediates(0, bytemuck::bytes_of(&call));
                pass.draw_indexed(0..indices.len() as u32, 0, 0..draw.count);
            }
            Ok(())
        }
        Shape::Mesh(mesh) => {
            let count = u32::try_from(mesh.indices.len())
                .map_err(|_| Error::unsupported("a mesh has more corners than 32 bits count"))?;
            pass.set_vertex_buffer(0, mesh.vertices.wgpu().slice(..));
            pass.set_index_buffer(mesh.indices.wgpu().slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..count, 0, 0..1);
            Ok(())
        }
        Shape::Indirect(mesh) => {
            pass.set_vertex_buffer(0, mesh.vertices.wgpu().slice(..));
            pass.set_index_buffer(mesh.indices.wgpu().slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed_indirect(mesh.arguments.wgpu(), 0);
            Ok(())
        }
        Shape::Posed(mesh) => {
            pass.set_vertex_buffer(0, mesh.corners.wgpu().slice(..));
            pass.draw_indirect(mesh.arguments.wgpu(), 0);
            Ok(())
        }
        Shape::Quads(mesh) => {
            if mesh.count > 0 {
                pass.set_immediates(0, bytemuck::bytes_of(&mesh.side));
                pass.draw(0..6, 0..mesh.count);
            }
            Ok(())
        }
    }
}

fn draw_patches(pass: &mut wgpu::RenderPass<'_>, patches: &VirtualVertices, groups: &Groups) -> Result<()> {
    let mut level = 0;
    for draw in patches.draws() {
        if draw.level != level {
            level = draw.level;
            let map = patches.maps.get(&level).ok_or_else(|| Error::internal("a level has no map"))?;
            pass.set_vertex_buffer(0, map.wgpu().slice(..));
        }
        set_patches(pass, patches, draw, groups)?;
        pass.draw(0..draw.vertices()?, 0..1);
    }
    Ok(())
}

/// The triangles beside finer edges, whose pipeline and vertices are set.
fn draw_stitches(pass: &mut wgpu::RenderPass<'_>, patches: &VirtualVertices, groups: &Groups) -> Result<()> {
    for draw in patches.draws().iter().filter(|draw| draw.stitches[1] > 0) {
        let [first, count] = draw.stitches;
        set_patches(pass, patches, draw, groups)?;
        pass.draw(first..first + count, 0..1);
    }
    Ok(())
}

/// Says which patches are drawn next.
fn set_patches(
    pass: &mut wgpu::RenderPass<'_>,
    patches: &VirtualVertices,
    draw: &DrawCall,
    groups: &Groups,
) -> Result<()> {
    if patches.storage() == Storage::Uniform {
        let offset = u32::try_from(block_stride(patches.per_draw()) * u64::from(draw.block))
            .map_err(|_| Error::unsupported("the uniform blocks are beyond 4 GiB"))?;
        pass.set_bind_group(1, &groups.own[0], &[offset]);
    }
    pass.set_immediates(0, bytemuck::bytes_of(&draw.first));
    Ok(())
}
