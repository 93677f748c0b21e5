//! What smearing brushes carry on a graphics device (`shaders/brush/brush_smear.wgsl`, `brush_spread.wgsl`): the pictures that dabs
//! leave, one of the brush and one of each of its mirror images, and the sums of what a dab picks up. Between the dabs of an
//! event the device makes the one of the other; those of a single dab come back, since other objects may add to them. Colours
//! are linear with alpha.

use std::sync::Arc;

use relievo_core::Result;
use relievo_gpu::{Access, Bindings, Buffer, Device, Frame, Kernel, KernelSpec, wgpu};

use crate::paint::smudge::{CELLS, Smudge, Sums};

/// Cells and the squares of them, see `brush_spread.wgsl`.
const ALL_CELLS: usize = CELLS + CELLS / 3;

/// Pictures at most: a brush has seven mirror images.
pub(super) const PICTURES: usize = 8;

/// Numbers of a picture in their buffer.
const PICTURE: usize = 1 + CELLS;

/// Words of a cell's sums: two of each of red, green, blue and alpha, and how many.
const WORDS: usize = 9;

/// How kernels have them.
pub(super) const ACCESS: [Access; 2] = [Access::Read, Access::Write];

/// The pictures of a brush.
#[derive(Debug)]
pub(super) struct DeviceSmear {
    /// Of every picture whether there is one, and its cells.
    carried: Buffer<[f32; 4]>,
    picked: Buffer<u32>,
    spread: Arc<Kernel>,
    spreading: Bindings,
}

impl DeviceSmear {
    /// Room for them. Fails where the device has none.
    pub fn new(device: &Device) -> Result<Self> {
        let carried = Buffer::new(device, "what brushes carry", PICTURES * PICTURE)?;
        let picked = Buffer::new(device, "what a brush picks up", WORDS * ALL_CELLS)?;
        let spread = device.kernel(&KernelSpec {
            module: "brush_spread",
            entry: "spread",
            groups: &[&[Access::Write; 2]],
            immediates: size_of::<u32>() as u32,
            constants: &[],
        })?;
        let spreading = device.bind(&spread, 0, &[carried.wgpu(), picked.wgpu()])?;
        Ok(Self { carried, picked, spread, spreading })
    }

    /// What kernels that paint have as their last bindings, see [`ACCESS`].
    pub fn tables(&self) -> [&wgpu::Buffer; 2] {
        [self.carried.wgpu(), self.picked.wgpu()]
    }

    /// Has the device leave what the first of each picture's `smudges` carries.
    pub fn take(&self, device: &Device, smudges: &[(&Smudge, usize)]) -> Result<()> {
        for picture in 0..PICTURES {
            let Some((smudge, _)) = smudges.iter().find(|it| it.1 == picture) else { return Ok(()) };
            let (first, cells) = (PICTURE * picture, smudge.carried());
            self.carried.write(device, first, &[[if cells.is_some() { 1.0 } else { 0.0 }; 4]])?;
            cells.map_or(Ok(()), |cells| self.carried.write(device, first + 1, cells))?;
        }
        Ok(())
    }

    /// Records what dab `dab` of an event, from 1, needs: the picture of what the one before it picked up, and nothing that
    /// is picked up yet.
    pub fn begin(&self, frame: &mut Frame, smudges: &[(&Smudge, usize)], dab: u32) -> Result<()> {
        if dab > 1 {
            self.spread(frame, smudges.get(dab as usize - 2))?;
        }
        frame.clear(&self.picked);
        Ok(())
    }

    fn spread(&self, frame: &mut Frame, made: Option<&(&Smudge, usize)>) -> Result<()> {
        let first = made.map_or(0, |(_, picture)| (PICTURE * picture) as u32);
        frame.pass("dab.spread").run(&self.spread, &[&self.spreading], &first.to_ne_bytes(), [1; 3])
    }

    /// Gives the last of each picture's `smudges`, whose dabs were made, what the device picked up: of several dabs the
    /// pictures that it makes, of a single one the sums.
    pub fn give(&self, device: &Device, smudges: &[(&Smudge, usize)]) -> Result<()> {
        let Some((smudge, _)) = smudges.last() else { return Ok(()) };
        let mut frame = device.frame()?;
        if smudges.len() > 1 {
            self.spread(&mut frame, smudges.last())?;
            let carried = frame.read(&self.carried, 0..self.carried.len())?;
            let _ = frame.submit()?;
            for (picture, cells) in carried.get(device)?.chunks_exact(PICTURE).enumerate() {
                let last = smudges.iter().rev().find(|it| it.1 == picture);
                if let Some((smudge, _)) = last.filter(|_| cells[0][0] > 0.0) {
                    smudge.set_picture(cells[1..].to_vec());
                }
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
