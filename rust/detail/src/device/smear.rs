//! What a smearing brush carries on a graphics device (`shaders/brush_smear.wgsl`): the picture that a dab leaves, and the
//! sums of what it picks up, which come back and are the processor's again. Colours are linear with alpha.

use relievo_core::Result;
use relievo_gpu::{Access, Buffer, Device, Frame, wgpu};

use crate::smudge::{CELLS, Smudge, Sums};

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
}

impl DeviceSmear {
    /// Room for them. Fails where the device has none.
    pub fn new(device: &Device) -> Result<Self> {
        let carried = Buffer::new(device, "what a brush carries", 1 + CELLS)?;
        Ok(Self { carried, picked: Buffer::new(device, "what a brush picks up", WORDS * CELLS)? })
    }

    /// What kernels that paint have as their last bindings, see [`ACCESS`].
    pub fn tables(&self) -> [&wgpu::Buffer; 2] {
        [self.carried.wgpu(), self.picked.wgpu()]
    }

    /// Has the device leave what `smudge` carries, if there is such a brush.
    pub fn take(&self, device: &Device, smudge: Option<&Smudge>) -> Result<()> {
        let Some(smudge) = smudge else { return Ok(()) };
        let cells = smudge.carried();
        self.carried.write(device, 0, &[[if cells.is_some() { 1.0 } else { 0.0 }; 4]])?;
        cells.map_or(Ok(()), |cells| self.carried.write(device, 1, cells))
    }

    /// Records that nothing is picked up so far.
    pub fn clear(&self, frame: &mut Frame) {
        frame.clear(&self.picked);
    }

    /// Adds what the device picked up to what `smudge` has, if there is such a brush.
    pub fn give(&self, device: &Device, smudge: Option<&Smudge>) -> Result<()> {
        let Some(smudge) = smudge else { return Ok(()) };
        let mut frame = device.frame()?;
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
