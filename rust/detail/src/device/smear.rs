//! What a smearing brush carries on a graphics device (`shaders/brush_smear.wgsl`, `brush_spread.wgsl`): the picture that a
//! dab leaves, and the sums of what it picks up. Between the dabs of an event the device makes the one of the other; those
//! of a single dab come back, since other objects may add to them. Colours are linear with alpha.

use std::sync::Arc;

use relievo_core::Result;
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, Kernel, KernelSpec, wgpu};

use crate::smudge::{CELLS, Smudge, Sums};

/// Cells and the squares of them, see `brush_spread.wgsl`.
const ALL_CELLS: usize = CELLS + CELLS / 3;

/// Words of a cell's sums: two of each of red, green, blue and alpha, and how many.
const WORDS: usize = 9;

/// How kernels have them.
pub(super) const ACCESS: [Access; 2] = [Access::Read, Access::Write];

/// The pictures of a brush.
#[derive(Debug)]
pub(super) struct DeviceSmear {
    /// Whether there is one, and its cells.
    carried: Buffer<[f32; 4]>,
    picked: Buffer<u32>,
    spread: Arc<Kernel>,
    spreading: Bindings,
}

impl DeviceSmear {
    /// Room for them. Fails where the device has none.
    pub fn new(device: &Device) -> Result<Self> {
        let carried = Buffer::new(device, "what a brush carries", 1 + CELLS)?;
        let picked = Buffer::new(device, "what a brush picks up", WORDS * ALL_CELLS)?;
        let spread = device.kernel(&KernelSpec {
            module: "brush_spread",
            entry: "spread",
            groups: &[&[Access::Write; 2]],
            immediates: 0,
            constants: &[],
        })?;
        let spreading = device.bind(&spread, 0, &[carried.wgpu(), picked.wgpu()])?;
        Ok(Self { carried, picked, spread, spreading })
    }

    /// What kernels that paint have as their last bindings, see [`ACCESS`].
    pub fn tables(&self) -> [&wgpu::Buffer; 2] {
        [self.carried.wgpu(), self.picked.wgpu()]
    }

    /// Has the device leave what the first of `smudges` carries, if there are such brushes.
    pub fn take(&self, device: &Device, smudges: &[&Smudge]) -> Result<()> {
        let Some(smudge) = smudges.first() else { return Ok(()) };
        let cells = smudge.carried();
        self.carried.write(device, 0, &[[if cells.is_some() { 1.0 } else { 0.0 }; 4]])?;
        cells.map_or(Ok(()), |cells| self.carried.write(device, 1, cells))
    }

    /// Records that dab `dab` of an event, from 1, leaves what the one before it picked up, and has picked up nothing yet.
    pub fn begin(&self, frame: &mut Frame, dab: u32) -> Result<()> {
        if dab > 1 {
            self.spread(frame)?;
        }
        frame.clear(&self.picked);
        Ok(())
    }

    fn spread(&self, frame: &mut Frame) -> Result<()> {
        frame.pass("dab.spread").run(&self.spread, &[&self.spreading], &[], [1; 3])
    }

    /// Gives the last of `smudges`, whose dabs were made, what the device picked up: of several the picture that it makes,
    /// of a single one the sums.
    pub fn give(&self, device: &Device, smudges: &[&Smudge]) -> Result<()> {
        let Some(smudge) = smudges.last() else { return Ok(()) };
        let mut frame = device.frame()?;
        if smudges.len() > 1 {
            self.spread(&mut frame)?;
            let carried = frame.read(&self.carried, 0..1 + CELLS)?;
            let _ = frame.submit()?;
            let mut cells = carried.get(device)?;
            if cells.remove(0)[0] > 0.0 {
                smudge.set_picture(cells);
            }
            return Ok(());
        }
        let picked = frame.read(&self.picked, 0..WORDS * CELLS)?;
        let _ = frame.submit()?;
        let sums = |words: &[u32]| -> Sums {
            std::array::from_fn(|n| match n {
                4 => i64::from(words[8]),
                _ => (u64::from(words[2 * n]) | u64::from(words[2 * n + 1]) << 32).cast_signed(),
            })
        };
        smudge.add(picked.get(device)?.chunks_exact(WORDS).map(sums));
        Ok(())
    }
}
