//! A mesh of a progressive mesh on a device, in buffers that are drawn.

use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::progressive_mark::CutCall;
use relievo_gpu::wgsl::progressive_view::ViewCall;
use relievo_gpu::wgsl::progressive_write::SizesCall;
use relievo_gpu::{Access, Bindings, Buffer, Frame, Kernel, KernelSpec, Pass, Scan};

use super::around::DeviceAround;
use super::calls::blocks;
use super::directions::LevelDirections;
use super::edits::Edits;
use super::hierarchy::{DeviceHierarchy, Vertex};
use super::history::{DeviceFront, History};
use super::places::Places;
use super::wedges::LevelWedges;
use crate::progressive::build::cut::Cut;
use crate::progressive::mesh::view::View;

/// Planes of a view at most.
const PLANES: usize = 6;

/// A mesh on a device: its vertices by the first of their leaves, and its triangles in the order of the input.
#[derive(Debug)]
pub struct DeviceLevel {
    pub(super) hierarchy: Arc<DeviceHierarchy>,
    vertices: Buffer<Vertex>,
    indices: Buffer<u32>,
    arguments: Buffer<u32>,
    ranks: Scan,
    shown_ranks: Scan,
    mark: [Arc<Kernel>; 2],
    marking: [Bindings; 2],
    write: [Arc<Kernel>; 3],
    writing: [Bindings; 2],
    /// Where vertices are that were edited.
    edited: Bindings,
    /// For views.
    want: Option<(Arc<Kernel>, Bindings)>,
    /// Whether all vertices of the finest mesh are where edits have put them.
    pub(super) is_followed: bool,
    marked: Bindings,
    /// Vertices there, their ranks, triangles shown, and their ranks.
    buffers: [Buffer<u32>; 4],
    pub(super) wedges: Option<LevelWedges>,
    /// What turns normals and tangents among attributes, if there are any and it was edited.
    directions: Option<LevelDirections>,
    pub(super) edits: Option<Edits>,
    pub(super) history: History,
    pub(super) shown: Shown,
}

/// What a mesh is.
#[derive(Clone, Copy, Debug)]
pub enum Shown {
    /// Nothing yet.
    Nothing,
    /// That of a cut.
    Cut(Cut),
    /// Made for a view.
    View,
}

impl DeviceLevel {
    /// A mesh that has nothing until it is adapted, with room for all of a progressive mesh.
    ///
    /// # Errors
    /// Fails where the device is lost or has no memory.
    pub fn new(hierarchy: &Arc<DeviceHierarchy>) -> Result<Self> {
        let device = &hierarchy.device;
        let bits = |count: usize| count.div_ceil(32).max(1);
        let buffer = |label, count| Buffer::<u32>::new(device, label, count);
        let there = buffer("vertices there", bits(hierarchy.vertices))?;
        let ranks = buffer("ranks of vertices", bits(hierarchy.vertices))?;
        let shown = buffer("triangles shown", bits(hierarchy.triangles))?;
        let shown_ranks = buffer("ranks of triangles", bits(hierarchy.triangles))?;
        let vertices = Buffer::new(device, "level vertices", hierarchy.vertices.max(1))?;
        let indices = buffer("level indices", 3 * hierarchy.triangles.max(1))?;
        let arguments = buffer("level arguments", 7)?;
        let kernel = |module, entry, groups: &[&[Access]], immediates: usize, constants: &[(&str, f64)]| {
            device.kernel(&KernelSpec { module, entry, groups, immediates: immediates as u32, constants })
        };
        let nothing = Places::none(hierarchy)?;
        let constants = nothing.constants();
        let marks: &[&[Access]] = &[&[Access::Read], &[Access::Write; 2]];
        let mark = |entry| kernel("progressive_mark", entry, marks, size_of::<CutCall>(), &[]);
        let mark = [mark("mark")?, mark("count")?];
        let writes: &[&[Access]] = &[&[Access::Read; 5], &[Access::Write; 7], &[Access::Write; 2]];
        let write = |entry| kernel("progressive_write", entry, writes, size_of::<SizesCall>(), &constants);
        let write = [write("show")?, write("write_triangles")?, write("write_vertices")?];
        let whole = hierarchy.as_ref();
        let marking = [
            device.bind(&mark[0], 0, &[whole.splits.wgpu()])?,
            device.bind(&mark[0], 1, &[there.wgpu(), ranks.wgpu()])?,
        ];
        let read =
            [whole.splits.wgpu(), whole.inner.wgpu(), whole.leaves.wgpu(), whole.makers.wgpu(), whole.corners.wgpu()];
        let buffers = [there, ranks, shown, shown_ranks];
        let [there, ranks, shown, shown_ranks] = &buffers;
        let written = [
            there.wgpu(),
            ranks.wgpu(),
            shown.wgpu(),
            shown_ranks.wgpu(),
            vertices.wgpu(),
            indices.wgpu(),
            arguments.wgpu(),
        ];
        let writing = [device.bind(&write[0], 0, &read)?, device.bind(&write[0], 1, &written)?];
        let wedges = whole.wedges.as_ref();
        let wedges = wedges.map(|trees| LevelWedges::new(whole, trees, [there, shown, shown_ranks], &arguments));
        let wedges = wedges.transpose()?;
        let want = match &whole.around {
            None => None,
            Some(around) => {
                let groups: &[&[Access]] = &[&[Access::Read; 3], &[Access::Write], &[Access::Write; 2]];
                let kernel = kernel("progressive_view", "want", groups, size_of::<ViewCall>(), &constants)?;
                let buffers = [whole.splits.wgpu(), whole.inner.wgpu(), around.extents.wgpu()];
                let bindings = device.bind(&kernel, 0, &buffers)?;
                Some((kernel, bindings))
            }
        };
        Ok(Self {
            marked: device.bind_as(&[Access::Write], &[there.wgpu()])?,
            ranks: Scan::new(device, ranks, &arguments)?,
            shown_ranks: Scan::new(device, shown_ranks, &arguments)?,
            hierarchy: hierarchy.clone(),
            vertices,
            indices,
            arguments,
            mark,
            marking,
            write,
            writing,
            edited: nothing.bindings,
            want,
            is_followed: true,
            buffers,
            wedges,
            directions: None,
            edits: None,
            history: History::default(),
            shown: Shown::Nothing,
        })
    }

    /// Vertices, [`Self::counts`] says how many.
    pub fn vertices(&self) -> &Buffer<Vertex> {
        &self.vertices
    }

    /// Numbers of vertices, three a triangle.
    pub fn indices(&self) -> &Buffer<u32> {
        &self.indices
    }

    /// Of every triangle the wedges at its corners; nothing without attributes.
    pub fn wedges(&self) -> Option<&Buffer<u32>> {
        self.wedges.as_ref().map(|wedges| &wedges.corners)
    }

    /// Numbers of wedges, [`Progressive::attribute_widths`](crate::Progressive::attribute_widths) says how many of each;
    /// nothing without attributes.
    pub fn wedge_values(&self) -> Option<&Buffer<f32>> {
        self.wedges.as_ref().map(|wedges| &wedges.values)
    }

    /// Numbers of triangles; nothing without attributes.
    pub fn face_values(&self) -> Option<&Buffer<u32>> {
        self.wedges.as_ref().map(|wedges| &wedges.faces)
    }

    /// The arguments of an indirect draw of the triangles, which are five numbers, and how many vertices and wedges there
    /// are.
    pub fn arguments(&self) -> &Buffer<u32> {
        &self.arguments
    }

    /// What it is a mesh of.
    pub fn hierarchy(&self) -> &DeviceHierarchy {
        &self.hierarchy
    }

    /// Records that it becomes another mesh. The frame has to be submitted.
    ///
    /// # Errors
    /// Fails with [`ErrorKind::Internal`](relievo_core::ErrorKind) if a command does not fit its kernel or buffers;
    /// what the device refuses comes back where the frame is submitted.
    pub fn adapt(&mut self, frame: &mut Frame, cut: Cut) -> Result<()> {
        self.turn_to(frame, &DeviceFront::Cut(cut))?;
        self.write(&mut frame.pass("write"))
    }

    /// Records that it becomes the mesh of a front, which is not written yet.
    pub(super) fn turn_to(&mut self, frame: &mut Frame, front: &DeviceFront) -> Result<()> {
        let is_finer = match (self.shown, front) {
            (Shown::Nothing, _) => false,
            (Shown::Cut(before), DeviceFront::Cut(cut)) => *cut < before,
            _ => true,
        };
        let late = self.edits.as_ref().zip(self.hierarchy.around.as_ref()).filter(|_| is_finer && !self.is_followed);
        let there = &self.buffers[0];
        if let Some((edits, _)) = late {
            frame.copy(there, 0..there.len(), edits.before(), 0)?;
        }
        self.mark(frame, front, None)?;
        if let Some((edits, around)) = late {
            edits.refine(&mut frame.pass("follow"), &self.hierarchy, &around.ends)?;
            self.is_followed = matches!(front, DeviceFront::Cut(Cut::FINEST));
        }
        self.shown = match front {
            DeviceFront::Cut(cut) => Shown::Cut(*cut),
            DeviceFront::View(_) => Shown::View,
        };
        Ok(())
    }

    /// Records that the vertices of a front are there, or that they were there before what follows.
    pub(super) fn mark(&self, frame: &mut Frame, front: &DeviceFront, before: Option<&Edits>) -> Result<()> {
        let there = before.map_or(&self.buffers[0], Edits::before);
        match front {
            DeviceFront::Cut(cut) => {
                let (key, split) = cut.parts();
                let vertices = self.hierarchy.vertices as u32;
                let call = CutCall { key, split, vertices };
                let [splits, marked] = &self.marking;
                let groups = [splits, before.map_or(marked, |edits| &edits.marking)];
                let size = blocks(self.hierarchy.vertices);
                frame.pass("mark").run(&self.mark[0], &groups, bytemuck::bytes_of(&call), size)
            }
            DeviceFront::View(bits) => frame.copy(bits, 0..bits.len(), there, 0),
        }
    }

    /// Records that it becomes as fine as a view needs it: it has what the view wants and all that this stands on. That
    /// is the mesh that the processor has after its finest one; without outlines it is so after any. A product or sum
    /// may be rounded otherwise, so splits may differ that are nearer to a limit of the view than 1e-5 of it, and than
    /// 1e-3 where the mesh was edited. The first view after an edit has the finest mesh follow that.
    ///
    /// # Errors
    /// Fails if the view is not usable or has more than six planes, and if the progressive mesh was not sent for views.
    pub fn adapt_to(&mut self, frame: &mut Frame, view: &View) -> Result<()> {
        view.check()?;
        let (Some((want, bindings)), Some(around)) = (&self.want, &self.hierarchy.around) else {
            return Err(Error::invalid("the progressive mesh was sent without what views need").at("view"));
        };
        if view.planes.len() > PLANES {
            let error = Error::unsupported(format!("{} planes; a device takes {PLANES}", view.planes.len()));
            return Err(error.at("view").advise("leave out those that cut nothing off"));
        }
        let mut planes = [[0.0; 4]; PLANES];
        planes[..view.planes.len()].copy_from_slice(&view.planes);
        let call = ViewCall {
            eye: view.eye,
            pixels: view.pixels,
            tolerance: view.tolerance,
            outline: view.outline,
            plane_count: view.planes.len() as u32,
            vertices: self.hierarchy.vertices as u32,
            planes,
        };
        let size = blocks(self.hierarchy.vertices);
        if let Some(edits) = self.edits.as_ref().filter(|_| !self.is_followed) {
            let there = &self.buffers[0];
            frame.copy(there, 0..there.len(), edits.before(), 0)?;
            self.mark(frame, &DeviceFront::Cut(Cut::FINEST), None)?;
            edits.refine(&mut frame.pass("follow"), &self.hierarchy, &around.ends)?;
        }
        let mut pass = frame.pass("adapt");
        pass.run(want, &[bindings, &self.marked, &self.edited], bytemuck::bytes_of(&call), size)?;
        around.close(&mut pass, &self.marked)?;
        self.write(&mut pass)?;
        drop(pass);
        (self.is_followed, self.shown) = (true, Shown::View);
        Ok(())
    }

    /// Which vertices there are, a bit each.
    pub(super) fn there(&self) -> &Buffer<u32> {
        &self.buffers[0]
    }

    /// Has room for edits.
    pub(super) fn prepare_edits(&mut self, around: &DeviceAround) -> Result<()> {
        let whole = &*self.hierarchy;
        let edits = Edits::new(whole, around, &self.buffers[0])?;
        let drawn = [&self.indices, &self.arguments];
        let directions = whole.directions.as_ref().zip(self.wedges.as_ref());
        let directions = directions
            .map(|(given, wedges)| LevelDirections::new(whole, given, wedges, &self.buffers, drawn, &edits.places))
            .transpose()?;
        self.edited = edits.places.bindings.clone();
        self.directions = directions;
        self.edits = Some(edits);
        Ok(())
    }

    /// Records that what is marked is written.
    pub(super) fn write(&self, pass: &mut Pass<'_>) -> Result<()> {
        let (vertices, triangles) = (self.hierarchy.vertices, self.hierarchy.triangles);
        let words = vertices.div_ceil(32);
        let call = CutCall { key: 0, split: 0, vertices: vertices as u32 };
        let [splits, there] = &self.marking;
        pass.run(&self.mark[1], &[splits, there], bytemuck::bytes_of(&call), blocks(words))?;
        self.ranks.run(pass, words as u32)?;
        let is_edited = u32::from(self.edits.is_some());
        let call = SizesCall { vertices: vertices as u32, triangles: triangles as u32, is_edited };
        let call = bytemuck::bytes_of(&call);
        let [read, written] = &self.writing;
        let bindings = [read, written, &self.edited];
        pass.run(&self.write[0], &bindings, call, blocks(triangles))?;
        self.shown_ranks.run(pass, triangles.div_ceil(32) as u32)?;
        pass.run(&self.write[1], &bindings, call, blocks(triangles))?;
        pass.run(&self.write[2], &bindings, call, blocks(vertices))?;
        self.wedges.as_ref().map_or(Ok(()), |wedges| wedges.write(pass))?;
        self.directions.as_ref().map_or(Ok(()), |directions| directions.turn(pass))
    }
}
