//! The buffers and kernels of a fluid on a device.

use std::sync::Arc;

use glam::Vec4;
use relievo_core::Result;
use relievo_gpu::wgsl::fluid::FluidCall;
use relievo_gpu::wgsl::fluid_forces::ForceRow;
use relievo_gpu::wgsl::fluid_press::Report;
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, GROUP, Kernel, KernelSpec, Sort, groups};

use super::obstacles::Obstacles;

/// Bits of a cell's number, as in `fluid.wgsl`.
pub const CELL_BITS: u32 = 21;

/// What a particle carries through the sort: what hosts accelerate it by, as bits, and where it was at first.
pub type Tag = [u32; 4];

/// Particles: of the fluid with pressures, of walls with masses. Velocities of the fluid have the reported pressures.
#[derive(Debug)]
pub struct Rows {
    pub places: Buffer<Vec4>,
    pub velocities: Buffer<Vec4>,
    pub tags: Buffer<Tag>,
}

impl Rows {
    fn new(device: &Device, count: usize) -> Result<Self> {
        Ok(Self {
            places: Buffer::new(device, "places of particles", count)?,
            velocities: Buffer::new(device, "velocities of particles", count)?,
            tags: Buffer::new(device, "tags of particles", count)?,
        })
    }
}

/// Particles that are put into the order of cells.
#[derive(Debug)]
struct Sorted {
    rows: Rows,
    cells: Buffer<[u32; 2]>,
    sort: Sort,
    bindings: [Bindings; 2],
    _keys: [Buffer<u32>; 2],
}

impl Sorted {
    fn new(device: &Device, kernels: &Kernels, from: &Rows) -> Result<Self> {
        let count = from.places.len();
        let keys = [Buffer::new(device, "cells of particles", count)?, Buffer::new(device, "order", count)?];
        let (rows, cells) = (Rows::new(device, count)?, Buffer::new(device, "cells", 1 << CELL_BITS)?);
        let given = [from.places.wgpu(), from.velocities.wgpu(), from.tags.wgpu()];
        let Rows { places, velocities, tags } = &rows;
        let made = [keys[0].wgpu(), keys[1].wgpu(), places.wgpu(), velocities.wgpu(), tags.wgpu(), cells.wgpu()];
        let bindings = [device.bind(&kernels.number, 0, &given)?, device.bind(&kernels.number, 1, &made)?];
        Ok(Self { sort: Sort::new(device, &keys[0], &keys[1])?, rows, cells, bindings, _keys: keys })
    }

    fn record(&self, frame: &mut Frame, kernels: &Kernels, call: &FluidCall) -> Result<()> {
        frame.clear(&self.cells);
        let mut pass = frame.pass("cells");
        let bindings = self.bindings.each_ref();
        let (count, call, size) = (call.count, bytemuck::bytes_of(call), groups(call.count.div_ceil(GROUP)));
        pass.run(&kernels.number, &bindings, call, size)?;
        self.sort.run(&mut pass, count, CELL_BITS)?;
        pass.run(&kernels.arrange, &bindings, call, size)
    }
}

#[derive(Debug)]
struct Kernels {
    number: Arc<Kernel>,
    arrange: Arc<Kernel>,
    find: Arc<Kernel>,
    begin: Arc<Kernel>,
    carry: Arc<Kernel>,
    predict: Arc<Kernel>,
    hold: Arc<Kernel>,
    correct: Arc<Kernel>,
    judge: Arc<Kernel>,
    arrive: Arc<Kernel>,
    conclude: Arc<Kernel>,
    give: Arc<Kernel>,
    give_all: Arc<Kernel>,
}

impl Kernels {
    fn new(device: &Device) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = |module, entry, groups: &[&[Access]]| {
            let immediates = size_of::<FluidCall>() as u32;
            device.kernel(&KernelSpec { module, entry, groups, immediates, constants: &[] })
        };
        let cells = |entry| kernel("fluid_cells", entry, &[&[Read; 3], &[Write; 6]]);
        // What says how many workgroups there are may not be bound where it does.
        let press = |entry| kernel("fluid_press", entry, &[&[Read; 7], &[Write; 3]]);
        let steer = |entry| kernel("fluid_press", entry, &[&[Read; 7], &[Write; 3], &[Write; 2]]);
        let arrive = |entry| kernel("fluid_arrive", entry, &[&[Read; 6], &[Write; 5]]);
        let given = |entry| kernel("fluid_given", entry, &[&[Read; 10], &[Write; 2]]);
        Ok(Self {
            number: cells("number_cells")?,
            arrange: cells("arrange")?,
            find: kernel("fluid_near", "find", &[&[Read; 4], &[Write; 3]])?,
            begin: kernel("fluid_begin", "begin", &[&[Read; 8], &[Write; 2]])?,
            carry: steer("carry")?,
            predict: press("predict")?,
            hold: kernel("fluid_hold", "hold", &[&[Read; 6], &[Write; 3]])?,
            correct: press("correct")?,
            judge: steer("judge")?,
            arrive: arrive("arrive")?,
            conclude: arrive("conclude")?,
            give: given("give")?,
            give_all: given("give_all")?,
        })
    }
}

/// What follows from the room for neighbours.
#[derive(Debug)]
struct Lists {
    room: u32,
    find: [Bindings; 2],
    begin: [Bindings; 2],
    press: [Bindings; 3],
    give: [Bindings; 2],
    _lists: Buffer<u32>,
}

/// What a step works with, and what it tells.
#[derive(Debug)]
pub struct Work {
    pub report: Buffer<Report>,
    /// The squares of the greatest speed and of the greatest change of a velocity.
    pub greatest: Buffer<[f32; 2]>,
    /// The sums of what forces and walls accelerated particles by, in m/s².
    pub given: Buffer<[Vec4; 2]>,
    pub forces: Buffer<ForceRow>,
    ends: Buffer<[u32; 2]>,
    accelerations: Buffer<Vec4>,
    diagonals: Buffer<[f32; 2]>,
    predicted: Buffer<Vec4>,
    /// Velocities after colliders were met, and their changes.
    held: [Buffer<Vec4>; 2],
    sums: Buffer<Vec4>,
    given_sums: Buffer<[Vec4; 2]>,
    arguments: Buffer<u32>,
}

impl Work {
    fn new(device: &Device, [count, forces]: [usize; 2], is_held: bool) -> Result<Self> {
        let (count, groups) = (count.max(1), count.div_ceil(GROUP as usize).max(1));
        Ok(Self {
            report: Buffer::new(device, "report of a step", 1)?,
            greatest: Buffer::new(device, "greatest speed", 1)?,
            given: Buffer::new(device, "what a step gave", 1)?,
            forces: Buffer::new(device, "forces", forces.max(1))?,
            ends: Buffer::new(device, "ends of neighbours", count)?,
            accelerations: Buffer::new(device, "accelerations", count)?,
            diagonals: Buffer::new(device, "stiffnesses", count)?,
            predicted: Buffer::new(device, "predicted places", count)?,
            held: [
                Buffer::new(device, "held particles", if is_held { count } else { 1 })?,
                Buffer::new(device, "changes of held particles", if is_held { count } else { 1 })?,
            ],
            sums: Buffer::new(device, "sums of groups", groups)?,
            given_sums: Buffer::new(device, "what a step gave by groups", groups)?,
            arguments: Buffer::new(device, "arguments of corrections", 6)?,
        })
    }
}

/// The buffers and kernels of a fluid on a device.
#[derive(Debug)]
pub struct Passes {
    pub rows: Rows,
    pub walls: Rows,
    pub work: Work,
    kernels: Kernels,
    sorted: Sorted,
    sorted_walls: Sorted,
    lists: Lists,
    arrive: [Bindings; 2],
    /// Where there are colliders.
    hold: Option<[Bindings; 2]>,
}

impl Passes {
    /// For so many particles of the fluid and of walls, of which each has room for so many neighbours, and so many forces,
    /// with colliders. Fails where the device has no memory.
    pub fn new(device: &Device, [count, walls, forces]: [usize; 3], room: u32, obstacles: &Obstacles) -> Result<Self> {
        let kernels = Kernels::new(device)?;
        let (rows, walls) = (Rows::new(device, count.max(1))?, Rows::new(device, walls.max(1))?);
        let (sorted, sorted_walls) = (Sorted::new(device, &kernels, &rows)?, Sorted::new(device, &kernels, &walls)?);
        let work = Work::new(device, [count, forces], !obstacles.is_empty())?;
        let Rows { places, velocities, tags } = &sorted.rows;
        let [held, changes] = work.held.each_ref().map(Buffer::wgpu);
        let predicted = work.predicted.wgpu();
        let from = [places.wgpu(), velocities.wgpu(), tags.wgpu(), predicted, work.diagonals.wgpu(), held];
        let Obstacles { cells, list, triangles, points, paces, .. } = obstacles;
        let met = [places.wgpu(), cells.wgpu(), list.wgpu(), triangles.wgpu(), points.wgpu(), paces.wgpu()];
        let hold = match obstacles.is_empty() {
            true => None,
            false => Some([
                device.bind(&kernels.hold, 0, &met)?,
                device.bind(&kernels.hold, 1, &[predicted, held, changes])?,
            ]),
        };
        let Rows { places, velocities, tags } = &rows;
        let to = [work.sums.wgpu(), places.wgpu(), velocities.wgpu(), tags.wgpu(), work.greatest.wgpu()];
        let arrive = [device.bind(&kernels.arrive, 0, &from)?, device.bind(&kernels.arrive, 1, &to)?];
        let lists = Lists::new(device, &kernels, [&sorted, &sorted_walls], &work, room)?;
        Ok(Self { rows, walls, work, kernels, sorted, sorted_walls, lists, arrive, hold })
    }

    /// How many neighbours of a particle there is room for.
    pub fn room(&self) -> u32 {
        self.lists.room
    }

    /// Makes room for more neighbours. Fails where the device has no memory.
    pub fn widen(&mut self, device: &Device, room: u32) -> Result<()> {
        self.lists = Lists::new(device, &self.kernels, [&self.sorted, &self.sorted_walls], &self.work, room)?;
        Ok(())
    }

    /// Records that walls are put into the order of cells.
    pub fn sort_walls(&self, frame: &mut Frame, call: &FluidCall) -> Result<()> {
        self.sorted_walls.record(frame, &self.kernels, &FluidCall { count: call.walls, ..*call })
    }

    /// Records what a step begins with: the order of particles, neighbours, densities.
    pub fn look_around(&self, frame: &mut Frame, call: &FluidCall) -> Result<()> {
        self.sorted.record(frame, &self.kernels, call)?;
        frame.clear(&self.work.report);
        let (size, call) = (groups(call.count.div_ceil(GROUP)), bytemuck::bytes_of(call));
        let Lists { find, begin, .. } = &self.lists;
        frame.pass("neighbours").run(&self.kernels.find, &find.each_ref(), call, size)?;
        frame.pass("densities").run(&self.kernels.begin, &begin.each_ref(), call, size)
    }

    /// Records the first corrections of a step, where `is_first`, or more of them, and the step's end if they are enough.
    pub fn press(&self, frame: &mut Frame, call: &FluidCall, corrections: u32, is_first: bool) -> Result<()> {
        let (size, bytes) = (groups(call.count.div_ceil(GROUP)), bytemuck::bytes_of(call));
        let [read, write, steer] = &self.lists.press;
        let mut pass = frame.pass("pressures");
        if is_first {
            pass.run(&self.kernels.carry, &[read, write, steer], bytes, size)?;
        }
        for _ in 0..corrections {
            pass.run_indirect(&self.kernels.predict, &[read, write], bytes, &self.work.arguments, 0)?;
            if let Some([from, to]) = &self.hold {
                pass.run_indirect(&self.kernels.hold, &[from, to], bytes, &self.work.arguments, 0)?;
            }
            pass.run_indirect(&self.kernels.correct, &[read, write], bytes, &self.work.arguments, 0)?;
            pass.run(&self.kernels.judge, &[read, write, steer], bytes, [1, 1, 1])?;
        }
        let [from, to] = &self.arrive;
        pass.run_indirect(&self.kernels.arrive, &[from, to], bytes, &self.work.arguments, 3)?;
        pass.run(&self.kernels.conclude, &[from, to], bytes, [1, 1, 1])?;
        let [from, to] = &self.lists.give;
        pass.run_indirect(&self.kernels.give, &[from, to], bytes, &self.work.arguments, 3)?;
        pass.run(&self.kernels.give_all, &[from, to], bytes, [1, 1, 1])
    }

    /// Records that a step ends though corrections were not enough.
    pub fn end(&self, frame: &mut Frame, call: &FluidCall) -> Result<()> {
        let (size, bytes) = (groups(call.count.div_ceil(GROUP)), bytemuck::bytes_of(call));
        let [from, to] = &self.arrive;
        let mut pass = frame.pass("end");
        pass.run(&self.kernels.arrive, &[from, to], bytes, size)?;
        pass.run(&self.kernels.conclude, &[from, to], bytes, [1, 1, 1])?;
        let [from, to] = &self.lists.give;
        pass.run(&self.kernels.give, &[from, to], bytes, size)?;
        pass.run(&self.kernels.give_all, &[from, to], bytes, [1, 1, 1])
    }
}

impl Lists {
    fn new(device: &Device, kernels: &Kernels, [sorted, walls]: [&Sorted; 2], work: &Work, room: u32) -> Result<Self> {
        let count = sorted.rows.places.len();
        let lists = Buffer::new(device, "neighbours", count.saturating_mul(room as usize))?;
        let [places, wall_places] = [&sorted.rows.places, &walls.rows.places].map(Buffer::wgpu);
        let [velocities, wall_velocities] = [&sorted.rows.velocities, &walls.rows.velocities].map(Buffer::wgpu);
        let (tags, near, far) = (sorted.rows.tags.wgpu(), lists.wgpu(), work.ends.wgpu());
        let [accelerations, predicted, sums] = [&work.accelerations, &work.predicted, &work.sums].map(Buffer::wgpu);
        let (diagonals, forces, report) = (work.diagonals.wgpu(), work.forces.wgpu(), work.report.wgpu());
        let [held, changes] = work.held.each_ref().map(Buffer::wgpu);
        let Kernels { find, begin, carry, give, .. } = kernels;
        let moving = [accelerations, velocities, wall_places, wall_velocities, near, far, diagonals];
        let giving = [places, velocities, wall_places, wall_velocities, near, far, predicted, forces, held, changes];
        Ok(Self {
            room,
            find: [
                device.bind(find, 0, &[places, sorted.cells.wgpu(), wall_places, walls.cells.wgpu()])?,
                device.bind(find, 1, &[near, far, report])?,
            ],
            begin: [
                device.bind(begin, 0, &[places, velocities, tags, wall_places, wall_velocities, near, far, forces])?,
                device.bind(begin, 1, &[accelerations, diagonals])?,
            ],
            press: [
                device.bind(carry, 0, &moving)?,
                device.bind(carry, 1, &[sums, places, predicted])?,
                device.bind(carry, 2, &[report, work.arguments.wgpu()])?,
            ],
            give: [device.bind(give, 0, &giving)?, device.bind(give, 1, &[work.given_sums.wgpu(), work.given.wgpu()])?],
            _lists: lists,
        })
    }
}
