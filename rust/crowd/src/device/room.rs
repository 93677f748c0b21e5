//! What posing writes on a device for a view.

use relievo_core::{Error, Result};
use relievo_gpu::{Buffer, Device, Frame, Readback, Scan};
use relievo_render::virtual_vertex::PosedVertex;

/// Buffers for so many agents, draws, posed vertices and corners.
#[derive(Debug)]
pub(super) struct Room {
    pub agents: usize,
    pub runs: Buffer<u32>,
    pub marks: Buffer<u32>,
    pub lists: Buffer<u32>,
    /// Of each pass.
    pub fresh: [Buffer<u32>; 2],
    pub posed_starts: [Buffer<u32>; 2],
    pub corner_starts: Buffer<u32>,
    pub posed: Buffer<PosedVertex>,
    pub corners: Buffer<[u32; 2]>,
    pub arguments: Buffer<u32>,
    pub total: Buffer<u32>,
    /// Of runs, marks and corners.
    pub scans: [Scan; 3],
    /// Of fresh runs and posed vertices, for each pass.
    pub pass_scans: [[Scan; 2]; 2],
}

impl Room {
    pub fn new(device: &Device, agents: usize, [draws, posed, corners]: [u32; 3]) -> Result<Self> {
        let by_agent = |label| Buffer::new(device, label, agents + 1);
        let by_draw = |label| Buffer::new(device, label, draws as usize + 1);
        let (runs, marks) = (by_agent("crowd runs")?, by_agent("crowd marks")?);
        let fresh = [by_agent("crowd fresh runs")?, by_agent("crowd more fresh runs")?];
        let posed_starts = [by_draw("crowd posed starts")?, by_draw("crowd more posed starts")?];
        let corner_starts = by_draw("crowd corner starts")?;
        let arguments = Buffer::new(device, "crowd arguments", 4)?;
        let scan = |items| Scan::new(device, items, &arguments);
        let of_pass = |number: usize| Ok([scan(&fresh[number])?, scan(&posed_starts[number])?]);
        Ok(Self {
            agents,
            scans: [scan(&runs)?, scan(&marks)?, scan(&corner_starts)?],
            pass_scans: [of_pass(0)?, of_pass(1)?],
            runs,
            marks,
            lists: Buffer::new(device, "crowd lists", 3 * agents)?,
            fresh,
            posed_starts,
            corner_starts,
            posed: Buffer::new(device, "crowd posed vertices", posed as usize)?,
            corners: Buffer::new(device, "crowd corners", corners as usize)?,
            arguments,
            total: Buffer::new(device, "crowd total", 1)?,
        })
    }

    /// Returns how many draws, posed vertices and corners there is room for.
    pub fn sizes(&self) -> [u32; 3] {
        [self.corner_starts.len() - 1, self.posed.len(), self.corners.len()].map(|size| size as u32)
    }

    /// Records that what a pass wrote is read back.
    pub fn read_ends(&self, number: usize, frame: &mut Frame) -> Result<Ends> {
        let draws = self.corner_starts.len() - 1;
        Ok(Ends([
            frame.read(&self.posed_starts[number], draws..draws + 1)?,
            frame.read(&self.corner_starts, draws..draws + 1)?,
            frame.read(&self.marks, self.agents..self.agents + 1)?,
            frame.read(&self.total, 0..1)?,
        ]))
    }
}

/// What a pass wrote, on its way back.
pub(super) struct Ends([Readback<u32>; 4]);

/// What a pass wrote.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ended {
    /// Vertices that it posed.
    pub vertices: u32,
    /// Corners that are drawn.
    pub corners: u32,
    /// Agents that are drawn by clusters.
    pub agents: u32,
    /// Vertices that there are of all agents of the list, drawn or not.
    pub all_vertices: u32,
}

impl Ends {
    /// Waits until the device has done it.
    ///
    /// # Errors
    /// The device is lost.
    pub fn get(self, device: &Device) -> Result<Ended> {
        let unread = || Error::internal("counts that cannot be read");
        let [vertices, corners, agents, all] = self.0.map(|end| end.get(device)?.first().copied().ok_or_else(unread));
        Ok(Ended { vertices: vertices?, corners: corners?, agents: agents?, all_vertices: all? })
    }
}
