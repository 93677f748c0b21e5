//! Steps on a graphics device: those of the processor, in the same order of sums but one, the sum of a node over its elements
//! in place of that over blocks. A device gives the same bits in every run.

use std::sync::Arc;

use bytemuck::Pod;
use glam::{DAffine3, DQuat};
use relievo_core::{Error, Progress, Result};
use relievo_gpu::wgsl::tissue::Step;
use relievo_gpu::{Access, Bindings, Buffer, Device, GROUP, Kernel, KernelSpec, groups};

use super::{CHUNK, Simulation};
use crate::block::{BLOCK, Row, place};
use crate::collider::Body;
use crate::element::Form;

/// A device that makes the steps of a simulation, and what it has of it, as long as that does not change.
#[derive(Debug)]
pub(super) struct OnDevice {
    device: Device,
    work: Option<Work>,
}

/// The buffers and kernels of a simulation on a device.
#[derive(Debug)]
struct Work {
    call: Step,
    /// Rows of numbers that change with time, for each step.
    stride: usize,
    press: Arc<Kernel>,
    move_nodes: Arc<Kernel>,
    press_groups: [Bindings; 2],
    move_groups: [Bindings; 2],
    displacements: Buffer<Row>,
    velocities: Buffer<Row>,
    timeline: Buffer<Row>,
    broken: Buffer<u32>,
}

impl OnDevice {
    pub fn new(device: &Device) -> Self {
        Self { device: device.clone(), work: None }
    }

    /// Forgets what was sent, since it changed.
    pub fn forget(&mut self) {
        self.work = None;
    }
}

impl Simulation {
    /// Has a graphics device take steps from now on, or the processor again. What a device does not do, the processor does:
    /// see [`Self::device_refusal`]. Forces agree within 1e-5 of the largest.
    pub fn use_device(&mut self, device: Option<&Device>) {
        self.on_device = device.map(OnDevice::new);
    }

    /// Returns whether a device takes the steps.
    pub fn has_device(&self) -> bool {
        self.on_device.is_some() && self.device_refusal().is_none()
    }

    /// Returns once why the processor took over from a device that failed.
    pub fn take_device_fault(&mut self) -> Option<Error> {
        self.device_fault.take()
    }

    /// Returns why the processor takes the steps though a device is given; `None` if the device does, or there is none.
    pub fn device_refusal(&self) -> Option<&'static str> {
        self.on_device.as_ref()?;
        let reasons = [
            (self.slides.are_crossed(), "nodes slide on several surfaces"),
            (self.self_contact.is_some(), "the model touches itself"),
            (!self.pressures.is_empty(), "pressures follow faces"),
            (self.options.halvings > 0, "steps may be halved"),
        ];
        reasons.into_iter().find(|(holds, _)| *holds).map(|(_, reason)| reason)
    }

    /// Takes `count` steps on the device. Fails when an element is inside out, or the device has no memory or is lost; the
    /// state is then that before.
    pub(super) fn advance_on_device(&mut self, count: u64, progress: &mut dyn Progress) -> Result<()> {
        let Some(mut on) = self.on_device.take() else { return Ok(()) };
        let outcome = self.advance_with(&mut on, count, progress);
        self.on_device = Some(on);
        outcome
    }

    fn advance_with(&mut self, on: &mut OnDevice, count: u64, progress: &mut dyn Progress) -> Result<()> {
        let device = &on.device;
        let work = match &mut on.work {
            Some(work) => work,
            none => none.insert(Work::new(device, self)?),
        };
        work.displacements.write(device, 0, &self.state.displacements)?;
        work.velocities.write(device, 0, &self.state.velocities)?;
        work.broken.write(device, 0, &[0])?;
        let (nodes, dt) = (self.masses.len(), self.steps.step);
        let (by_element, by_node) =
            (groups(work.call.elements.div_ceil(GROUP)), groups(work.call.nodes.div_ceil(GROUP)));
        let [forces, out] = work.press_groups.each_ref();
        let [from, to] = work.move_groups.each_ref();
        let (mut done, mut seconds) = (0, self.state.seconds);
        while done < count {
            progress.step(done as f32 / count as f32, "steps")?;
            let chunk = CHUNK.min(count - done);
            let mut rows = Vec::with_capacity(chunk as usize * work.stride);
            for _ in 0..chunk {
                let begin = seconds;
                seconds = begin + f64::from(dt);
                self.add_rows(work.stride, [begin, seconds], &mut rows);
            }
            work.timeline.write(device, 0, &rows)?;
            let mut frame = device.frame()?;
            {
                let mut pass = frame.pass("tissue");
                for step in 0..chunk as usize {
                    let call = Step { row: (step * work.stride) as u32, ..work.call };
                    let call = bytemuck::bytes_of(&call);
                    pass.run(&work.press, &[forces, out], call, by_element)?;
                    pass.run(&work.move_nodes, &[from, to], call, by_node)?;
                }
            }
            let broken = frame.read(&work.broken, 0..1)?;
            let _ = frame.submit()?.wait()?;
            if let Some(slot) = broken.get(device)?[0].checked_sub(1) {
                let element = self.elements.blocks.order[slot as usize];
                return Err(Error::invalid(format!("the element turns inside out within {seconds:.6} s"))
                    .at(format!("element {element}"))
                    .advise("take a shorter step, slower motion, less activation or stiffer material"));
            }
            done += chunk;
        }
        let mut frame = device.frame()?;
        let displacements = frame.read(&work.displacements, 0..nodes)?;
        let velocities = frame.read(&work.velocities, 0..nodes)?;
        let _ = frame.submit()?;
        self.state.displacements = displacements.get(device)?;
        self.state.velocities = velocities.get(device)?;
        self.state.steps += count;
        self.state.seconds = seconds;
        Ok(())
    }

    /// Adds the numbers of a step between two times: activations at its beginning, displacements of driven sets at its end,
    /// and poses of bodies at its end and one step earlier.
    fn add_rows(&self, stride: usize, [begin, end]: [f64; 2], rows: &mut Vec<Row>) {
        let first = rows.len();
        rows.extend(self.activations.iter().map(|curve| [curve.at(begin)[0], 0.0, 0.0, 0.0]));
        rows.extend(self.drives.iter().map(|drive| {
            let [x, y, z] = drive.displacement.at(end);
            [x, y, z, 0.0]
        }));
        for collider in &self.colliders {
            for time in [end, end - f64::from(self.steps.step)] {
                rows.extend(pose_rows(&collider.pose(time)));
            }
        }
        rows.resize(first + stride, [0.0; 4]);
    }
}

/// Returns a rotation as a quaternion, and a translation.
fn pose_rows(pose: &DAffine3) -> [Row; 2] {
    let rotation = DQuat::from_mat3(&pose.matrix3).as_quat().to_array();
    [rotation, pose.translation.as_vec3().extend(0.0).to_array()]
}

impl Work {
    fn new(device: &Device, simulation: &Simulation) -> Result<Self> {
        use Access::{Read, Write};
        let (elements, model) = (&simulation.elements, &simulation.model);
        let (blocks, count, nodes) = (&elements.blocks, model.elements.len(), model.nodes.len());
        let slots = blocks.len() * BLOCK;
        if slots > (u32::MAX / 64) as usize {
            return Err(
                Error::memory(format!("{count} elements are too many for a device")).advise("use the processor")
            );
        }
        let kernel = |module, entry, groups: &[&[Access]]| {
            let immediates = size_of::<Step>() as u32;
            device.kernel(&KernelSpec { module, entry, groups, immediates, constants: &[] })
        };
        let press = kernel("tissue_forces", "press", &[&[Read; 8], &[Write; 2]])?;
        let move_nodes = kernel("tissue_move", "move_nodes", &[&[Read; 9], &[Write; 2]])?;

        let mut corners = vec![0u32; 8 * slots];
        let mut starts = vec![0u32; nodes + 1];
        for slot in 0..count {
            for corner in 0..8 {
                let node = model.elements[blocks.order[slot] as usize][corner];
                corners[place(slot, 8, corner)] = node;
                starts[node as usize + 1] += 1;
            }
        }
        for node in 0..nodes {
            starts[node + 1] += starts[node];
        }
        let (mut next, mut list) = (starts.clone(), vec![0u32; 8 * count]);
        for slot in 0..count {
            for corner in 0..8 {
                let place = &mut next[corners[place(slot, 8, corner)] as usize];
                list[*place as usize] = (8 * slot + corner) as u32;
                *place += 1;
            }
        }
        let (scale, gradients) = match &elements.shape {
            Form::Box(scale) => (*scale, Vec::new()),
            Form::Any { gradients, patterns } => ([0.0; 3], [gradients.as_slice(), patterns].concat()),
        };
        let (mut fibres, mut muscles) = (vec![0f32; elements.fibres.len() * BLOCK * 5], Vec::new());
        for (layer, from) in elements.fibres.iter().enumerate() {
            for slot in 0..BLOCK {
                let at = |which: usize| layer * BLOCK * 5 + place(slot, 5, which);
                (0..3).for_each(|axis| fibres[at(axis)] = from.directions[place(slot, 3, axis)]);
                (0..2).for_each(|which| fibres[at(3 + which)] = from.stresses[place(slot, 2, which)]);
            }
            muscles.extend_from_slice(&from.muscles);
        }
        let mut driven = vec![[0u32; 4]; nodes];
        for (number, drive) in (1..).zip(&simulation.drives) {
            for node in &drive.nodes {
                let sets = &mut driven[*node as usize];
                (0..3).filter(|axis| drive.axes >> axis & 1 != 0).for_each(|axis| sets[axis] = number);
            }
        }
        // Bodies come first, and then the meshes that they and sliding nodes name.
        let mut shapes = vec![[0u32; 4]; simulation.colliders.len()];
        for (number, collider) in simulation.colliders.iter().enumerate() {
            let (body, friction) = collider.shape();
            let (radius, root) = match body {
                Body::Floor => (-1.0, 0),
                Body::Ball(radius) => (*radius, 0),
                Body::Mesh(field) => (0.0, field.pack(&mut shapes)?),
            };
            shapes[number] = [f32::to_bits(radius), friction.to_bits(), root, 0];
        }
        let mut rest: Vec<Row> = model.nodes.iter().map(|[x, y, z]| [*x, *y, *z, 0.0]).collect();
        let (sliding, fields) = simulation.slides.parts();
        if !sliding.is_empty() {
            let roots = fields.iter().map(|field| field.pack(&mut shapes)).collect::<Result<Vec<u32>>>()?;
            for slide in sliding {
                rest[slide.node as usize][3] = slide.distance;
                driven[slide.node as usize][3] = 1 + roots[slide.surface as usize];
            }
        }

        let stride = (simulation.activations.len() + simulation.drives.len() + 4 * simulation.colliders.len()).max(1);
        let timeline = Buffer::new(device, "what changes with time", CHUNK as usize * stride)?;
        let displacements = Buffer::new(device, "displacements", nodes)?;
        let velocities = Buffer::new(device, "velocities", nodes)?;
        let (forces, broken) =
            (Buffer::<Row>::new(device, "forces", 8 * slots)?, Buffer::new(device, "broken element", 1)?);
        let corners = sent(device, "corners", corners)?;
        let moduli = sent(device, "moduli", elements.moduli.clone())?;
        let gradients = sent(device, "gradients", gradients)?;
        let layers = sent(device, "layers of fibres", elements.layers.clone())?;
        let (fibres, muscles) = (sent(device, "fibres", fibres)?, sent(device, "muscles of fibres", muscles)?);
        let (starts, list) = (sent(device, "corners of nodes", starts)?, sent(device, "corners by node", list)?);
        let (masses, rest) = (sent(device, "masses", simulation.masses.clone())?, sent(device, "nodes", rest)?);
        let loads = sent(device, "loads", simulation.loads.clone())?;
        let (driven, shapes) = (sent(device, "driven nodes", driven)?, sent(device, "bodies and surfaces", shapes)?);

        let read = [
            displacements.wgpu(),
            corners.wgpu(),
            moduli.wgpu(),
            gradients.wgpu(),
            layers.wgpu(),
            fibres.wgpu(),
            muscles.wgpu(),
            timeline.wgpu(),
        ];
        let press_groups = [device.bind(&press, 0, &read)?, device.bind(&press, 1, &[forces.wgpu(), broken.wgpu()])?];
        let read = [
            forces.wgpu(),
            starts.wgpu(),
            list.wgpu(),
            masses.wgpu(),
            rest.wgpu(),
            loads.wgpu(),
            driven.wgpu(),
            timeline.wgpu(),
            shapes.wgpu(),
        ];
        let written = [displacements.wgpu(), velocities.wgpu()];
        let move_groups = [device.bind(&move_nodes, 0, &read)?, device.bind(&move_nodes, 1, &written)?];
        let (dt, half) = (simulation.steps.step, 0.5 * simulation.options.damping * simulation.steps.step);
        let call = Step {
            gravity: simulation.options.gravity,
            step: dt,
            kept: (1.0 - half) / (1.0 + half),
            gained: dt / (1.0 + half),
            slots: slots as u32,
            elements: count as u32,
            nodes: nodes as u32,
            muscles: simulation.activations.len() as u32,
            drives: simulation.drives.len() as u32,
            bodies: simulation.colliders.len() as u32,
            row: 0,
            loads: u32::from(!simulation.loads.is_empty()),
            boxes: u32::from(matches!(elements.shape, Form::Box(_))),
            scale_x: scale[0],
            scale_y: scale[1],
            scale_z: scale[2],
            padding: [0; 2],
        };
        Ok(Self {
            call,
            stride,
            press,
            move_nodes,
            press_groups,
            move_groups,
            displacements,
            velocities,
            timeline,
            broken,
        })
    }
}

/// Sends items. An empty list is sent as one zero, since buffers cannot be empty.
fn sent<T: Pod>(device: &Device, label: &str, mut items: Vec<T>) -> Result<Buffer<T>> {
    if items.is_empty() {
        items.push(T::zeroed());
    }
    Buffer::of(device, label, &items)
}
