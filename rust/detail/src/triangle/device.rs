//! Dabs of a triangle mesh that a graphics device makes, and what it keeps of the mesh.
//!
//! What comes back of an event becomes the edit that the processor would have made, by the same code, so that documents,
//! undo and the journal do not know of the device.

use std::collections::BTreeMap;

use glam::Vec4;
use half::f16;
use relievo_core::{Context, Error, Result};
use relievo_gpu::Device;
use relievo_gpu::wgsl::brush_edit::Edit;
use relievo_surface::{DeviceMesh, TriangleSurface};
use relievo_tiles::triangle::{DeviceTriangles, Offset, Pattern, TriangleChannel, TriangleField};
use relievo_tiles::{ColorPlanes, Rgba8, Rgba16, Texel, by_format};

use super::dab::write;
use super::level::refined;
use super::object::{TriangleGround, TriangleObject};
use super::site::{Element, ElementEdit, values};
use crate::channels::layered::LayeredObject;
use crate::device::{
    DeviceValue, OnDevice, Returned, TriangleBrush, TrianglePress, TriangleStage, edits_of, keep_rounded, on_device,
    reports_of, smudges_of,
};
use crate::paint::dab::{Dab, Kind, no_vectors};
use crate::paint::mode::{PaintMode, SculptMode};
use crate::paint::report::DabReport;
use crate::paint::vector::BrushMaps;
use crate::paint::weights::BrushParameters;

/// The state of a mesh on a device.
#[derive(Debug)]
pub(crate) struct TriangleDevice {
    device: Device,
    mesh: DeviceMesh,
    sculpting: Option<Tool<f16>>,
    /// The normals, once a dab needed them.
    turns: Option<DeviceTriangles<Offset>>,
    painting: Option<Tool<Rgba8>>,
    half_painting: Option<Tool<Rgba16>>,
    bending: Option<Tool<Offset>>,
    /// What imprints need, once there was one.
    pressing: Option<TrianglePress>,
}

/// What edits one kind of values, once something did.
#[derive(Debug)]
struct Tool<T: DeviceValue> {
    /// The displacement that places go by, at the vertices that have values, and the vectors, if there are some.
    ground: DeviceTriangles,
    offsets: Option<DeviceTriangles<Offset>>,
    values: DeviceTriangles<T>,
    brush: TriangleBrush,
}

/// Colours that a device has room for.
trait DeviceColor: ColorPlanes + DeviceValue {
    fn slot(object: &mut TriangleDevice) -> &mut Option<Tool<Self>>;
}

impl DeviceColor for Rgba8 {
    fn slot(object: &mut TriangleDevice) -> &mut Option<Tool<Self>> {
        &mut object.painting
    }
}

impl DeviceColor for Rgba16 {
    fn slot(object: &mut TriangleDevice) -> &mut Option<Tool<Self>> {
        &mut object.half_painting
    }
}

impl OnDevice for TriangleObject {
    type Device = TriangleDevice;

    fn device_slot(&mut self) -> &mut Option<TriangleDevice> {
        &mut self.device
    }

    fn fault_slot(&mut self) -> &mut Option<Error> {
        &mut self.device_fault
    }
}

impl TriangleObject {
    /// Has dabs and imprints made on a graphics device from now on, or on the processor again.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Memory` if the device has no room for the mesh, and with `Device` if it is
    /// lost or its driver fails.
    pub fn use_device(&mut self, device: Option<&Device>) -> Result<()> {
        self.device = device.map(|device| TriangleDevice::new(device, &self.surface)).transpose()?;
        Ok(())
    }

    /// The failure after which the processor took over, told once.
    pub fn take_device_fault(&mut self) -> Option<Error> {
        self.device_fault.take()
    }

    /// Brings the mesh on the device to its pose; where that fails the processor takes over.
    pub(super) fn pose_on_device(&mut self) {
        if let Some(mut device) = self.device.take() {
            match device.mesh.pose(&device.device, &self.surface) {
                Ok(()) => self.device = Some(device),
                Err(error) => self.device_fault = Some(error),
            }
        }
    }

    /// Makes the first of `dabs`, or the first few at once, on the device. Returns what each did, what is known of several
    /// together with the last; `None` if the processor is to make the first.
    ///
    /// Fails as [`Self::dab`] does.
    pub(crate) fn dab_on_device(
        &mut self,
        context: &Context,
        dabs: &[Dab],
        start: Option<TriangleGround<'_>>,
    ) -> Result<Option<Vec<DabReport>>> {
        let Some((kind, dabs)) = Kind::first(dabs, |dab| self.kind_on_device(dab))? else { return Ok(None) };
        self.made_on_device(context, kind, dabs, start)
    }

    /// As [`Self::dab_on_device`], of dabs of one kind with the same image of the brush.
    pub(super) fn made_on_device(
        &mut self,
        context: &Context,
        kind: Kind,
        dabs: &[Dab],
        start: Option<TriangleGround<'_>>,
    ) -> Result<Option<Vec<DabReport>>> {
        match kind {
            Kind::Bend(mode) => {
                let make = |device: &mut TriangleDevice, object: &Self| device.bend(context, object, dabs, start, mode);
                let Some(event) = on_device(context, "dab.device", self, make) else { return Ok(None) };
                let Event { pattern, edits, looked, made } = event;
                let whole = self.write_bent(context, pattern, &looked, edits, mode == SculptMode::Erase)?;
                Ok(Some(told(&made, whole)))
            }
            Kind::Sculpt(mode) => {
                self.layers.displacement.check_editable()?;
                let make =
                    |device: &mut TriangleDevice, object: &Self| device.sculpt(context, object, dabs, start, mode);
                let Some(event) = on_device(context, "dab.device", self, make) else { return Ok(None) };
                let with = |sum: [f32; 2], range: [f32; 2]| [sum[0].min(range[0]), sum[1].max(range[1])];
                self.widen(
                    event.edits.iter().map(|edit| crate::object::ranges::range(&edit.values)).fold([0.0; 2], with),
                );
                let erases = mode == SculptMode::Erase;
                let (reports, shown) = event.take(context, self.layers.displacement.composite_mut(), erases)?;
                self.touch(&shown);
                Ok(Some(reports))
            }
            Kind::Paint(mode) => {
                let mut paint = self.take_paint()?;
                let done = by_format!(&mut paint, stack => {
                    let paint = stack.active_mut();
                    let make = |device: &mut TriangleDevice, object: &Self| {
                        device.paint(context, object, paint, dabs, start, mode)
                    };
                    on_device(context, "dab.device", self, make).map(|event| event.take(context, paint, mode == PaintMode::Erase)).transpose()
                });
                self.put_paint(paint);
                Ok(done?.map(|(reports, _)| reports))
            }
        }
    }

    /// What a dab does, if there is a device that does it.
    fn kind_on_device(&self, dab: &Dab) -> Option<Kind> {
        Kind::on(dab, self.vectors.is_some()).filter(|_| self.device.is_some())
    }
}

/// What came back of an event.
#[derive(Debug)]
struct Event<T> {
    pattern: Pattern,
    /// By element, ascending.
    edits: Vec<ElementEdit<T>>,
    /// The faces that were looked at, ascending.
    looked: Vec<u32>,
    made: Returned,
}

impl<T: DeviceValue> Event<T> {
    /// The edits in blocks of `room` words, of what is finer than `pattern` the following ones.
    fn new(context: &Context, field: &TriangleField<T>, pattern: Pattern, (made, room): (Returned, u32)) -> Self {
        let topology = field.topology();
        let taken = made.taken();
        let looked = taken.iter().map(|(_, state)| state.tile).collect();
        let mut new: BTreeMap<Element, &[T]> = BTreeMap::new();
        for (index, state) in taken.iter().filter(|(_, state)| state.changes > 0) {
            let words = &made.blocks[index * room as usize..][..room as usize];
            let (inside, sides, corners) = DeviceTriangles::<T>::parts(pattern, bytemuck::cast_slice(words));
            let is_changed = |part: usize| state.corners[0] >> part & 1 != 0;
            if is_changed(6) {
                new.insert(Element::Face(state.tile), inside);
            }
            // All faces of an edge or a vertex have the same values there.
            for k in (0..3).filter(|k| is_changed(*k)) {
                new.insert(Element::Edge(topology.edges_of(state.tile)[k]), sides[k]);
            }
            for k in (0..3).filter(|k| is_changed(3 + *k)) {
                new.insert(Element::Vertex(topology.face(state.tile)[k]), &corners[k..=k]);
            }
        }
        let edit = |(element, new): (Element, &[T])| {
            let old = values(field, element, pattern)?;
            let count = old.iter().zip(new).filter(|(old, new)| !old.same(**new)).count() as u64;
            Some(ElementEdit { element, pattern, values: new.to_vec(), count })
        };
        let edits = new.into_iter().filter_map(edit).collect();
        let edits = if pattern == field.pattern() { edits } else { refined(context, field, pattern, edits) };
        Self { pattern, edits, looked, made }
    }

    /// Makes the event the channel's: memory and values. Returns what each of its dabs did, and the faces that look
    /// different.
    fn take(
        self,
        context: &Context,
        channel: &mut TriangleChannel<T>,
        erases: bool,
    ) -> Result<(Vec<DabReport>, Vec<u32>)> {
        let (whole, shown) = write(context, channel, self.pattern, &self.looked, self.edits, erases)?;
        Ok((told(&self.made, whole), shown))
    }
}

/// What each dab of an event did, of which the processor knows what they did together.
fn told(made: &Returned, mut whole: DabReport) -> Vec<DabReport> {
    let changed = whole.changed_texels;
    if made.tested.len() > 1 {
        // A value that several dabs changed counts for each.
        whole.changed_texels = made.tested.iter().map(|it| u64::from(it.changed)).sum();
    }
    let mut reports = reports_of(&made.tested, &whole);
    if let [report] = &mut reports[..] {
        report.changed_texels = changed;
    }
    reports
}

impl TriangleDevice {
    fn new(device: &Device, surface: &TriangleSurface) -> Result<Self> {
        let mesh = DeviceMesh::new(device, surface)?;
        let (device, painting, half_painting) = (device.clone(), None, None);
        let (sculpting, turns, bending, pressing) = (None, None, None, None);
        Ok(Self { device, mesh, sculpting, turns, painting, half_painting, bending, pressing })
    }

    /// The device that it is on.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// What imprints need, and the mesh.
    pub fn pressing(&mut self) -> (&mut Option<TrianglePress>, &DeviceMesh) {
        (&mut self.pressing, &self.mesh)
    }

    fn sculpt(
        &mut self,
        context: &Context,
        object: &TriangleObject,
        dabs: &[Dab],
        start: Option<TriangleGround<'_>>,
        mode: SculptMode,
    ) -> Result<Option<Event<f16>>> {
        let (channel, ground) = (object.displacement(), start.unwrap_or(object.ground()));
        let edits = edits_of(&object.transform, dabs, Vec4::ZERO);
        // A dab that is by itself goes by its own displacement.
        let (together, looks_beside) = (start.is_some(), mode.needs_mean());
        let mut tool = self.sculpting.take();
        let tools = self.tool(&mut tool, channel.field(), (ground, object.level()))?;
        if mode.needs_facing() {
            let (device, normals, pattern) = (&self.device, object.normals.turns(), tools.values.pattern());
            let turns = match self.turns.take().filter(|turns| turns.pattern() == pattern) {
                Some(mut turns) => {
                    turns.update(device, normals)?;
                    self.turns.insert(turns)
                }
                None => self.turns.insert(DeviceTriangles::new(device, normals, pattern)?),
            };
            tools.brush.take_turns(device, turns)?;
        }
        let field = (channel.field(), left(channel));
        let made = self.event(context, tools, field, ground, (edits, dabs, &[]), (together, looks_beside));
        self.sculpting = tool;
        made
    }

    fn bend(
        &mut self,
        context: &Context,
        object: &TriangleObject,
        dabs: &[Dab],
        start: Option<TriangleGround<'_>>,
        mode: SculptMode,
    ) -> Result<Option<Event<Offset>>> {
        let (offsets, _) = object.offsets.as_ref().ok_or_else(no_vectors)?;
        let ground = start.unwrap_or(object.ground());
        let edits = edits_of(&object.transform, dabs, Vec4::ZERO);
        let maps: Vec<_> = dabs.iter().map(|dab| BrushMaps::new(&dab.brush, &object.transform)).collect();
        let mut tool = self.bending.take();
        let tools = self.tool(&mut tool, offsets, (ground, object.level()))?;
        let (together, looks_beside) = (start.is_some(), mode.needs_mean());
        let field = (offsets, object.vectors.as_ref().map_or(0, left));
        let made = self.event(context, tools, field, ground, (edits, dabs, &maps), (together, looks_beside));
        self.bending = tool;
        made
    }

    fn paint<T: DeviceColor>(
        &mut self,
        context: &Context,
        object: &TriangleObject,
        channel: &TriangleChannel<T>,
        dabs: &[Dab],
        start: Option<TriangleGround<'_>>,
        mode: PaintMode,
    ) -> Result<Option<Event<T>>> {
        let ground = start.unwrap_or(object.ground());
        let edits = edits_of(&object.transform, dabs, channel.field().blank().color());
        let mut tool = T::slot(self).take();
        let tools = self.tool(&mut tool, channel.field(), (ground, object.level()))?;
        let field = (channel.field(), left(channel));
        let made = self.event(context, tools, field, ground, (edits, dabs, &[]), (true, mode.needs_mean()));
        *T::slot(self) = tool;
        made
    }

    /// What edits `field` at `level`, with the displacement `ground` to go by, up to date.
    fn tool<'a, T: DeviceValue>(
        &self,
        tool: &'a mut Option<Tool<T>>,
        field: &TriangleField<T>,
        (TriangleGround { heights, vectors }, level): (TriangleGround<'_>, u32),
    ) -> Result<&'a mut Tool<T>> {
        let device = &self.device;
        let pattern = field.pattern().coarser(level);
        let fits = |tool: &Tool<T>| tool.values.pattern() == pattern && tool.offsets.is_some() == vectors.is_some();
        Ok(match tool.take().filter(fits) {
            Some(mut known) => {
                known.ground.update(device, heights)?;
                if let Some((known, vectors)) = known.offsets.as_mut().zip(vectors) {
                    known.update(device, vectors)?;
                }
                known.values.update(device, field)?;
                tool.insert(known)
            }
            None => tool.insert(Tool {
                ground: DeviceTriangles::new(device, heights, pattern)?,
                offsets: vectors.map(|vectors| DeviceTriangles::new(device, vectors, pattern)).transpose()?,
                values: DeviceTriangles::new(device, field, pattern)?,
                brush: TriangleBrush::new::<T>(device, &self.mesh, pattern, vectors.is_some())?,
            }),
        })
    }

    /// Makes the first of some edits of a field, whose new blocks may take `left` bytes, or the first few at once where they
    /// may be made `together`. `None` if they reach more triangles than the device can have blocks for.
    fn event<T: DeviceValue>(
        &self,
        context: &Context,
        tool: &mut Tool<T>,
        (field, left): (&TriangleField<T>, u64),
        ground: TriangleGround<'_>,
        (mut edits, dabs, maps): (Vec<(BrushParameters, Edit)>, &[Dab], &[BrushMaps]),
        (together, looks_beside): (bool, bool),
    ) -> Result<Option<Event<T>>> {
        let (device, mesh) = (&self.device, &self.mesh);
        let pattern = tool.values.pattern();
        let stamp = dabs.first().and_then(|dab| dab.brush.stamp());
        let (smudges, chained) = smudges_of(dabs, &mut edits);
        let ground = (&tool.ground, tool.offsets.as_ref(), ground);
        let (values, smudges) = (&tool.values, &smudges[..]);
        let stage = TriangleStage { device, mesh, ground, values, field, left, looks_beside, smudges, maps };
        // Finer values follow the edit of a coarser level dab by dab.
        let together = together && pattern == field.pattern() && chained;
        for (_, edit) in &mut edits {
            edit.segments = pattern.segments();
            if together {
                keep_rounded(edit);
            }
        }
        let made = tool.brush.event(stage, (&edits, stamp), together)?;
        Ok(made.map(|made| Event::new(context, field, pattern, made)))
    }
}

/// Bytes that new blocks of a channel may take.
fn left<T: Texel>(channel: &TriangleChannel<T>) -> u64 {
    channel.budget().saturating_sub(channel.bytes())
}
