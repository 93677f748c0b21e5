//! What is left of edits that fade, evaluated on a graphics device (`shaders/brush/fade.wgsl`).
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, *Local Painting and Deformation of Meshes on the GPU*, Section 7.2. The
//! device keeps the edited texels and their stamps for as long as they fade, so that a step takes one dispatch and the way
//! back of what is left. Values are those of the processor up to one unit in the last place of a half float, colours of 8
//! bits within 1/255.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use relievo_core::{Error, Result};
use relievo_gpu::wgsl::fade::Fade;
use relievo_gpu::{Access, Buffer, Device, GROUP, Kernel, KernelSpec};

use crate::layers::decay::DecayOptions;
use crate::texel::Texel;

/// A block that fades: its number, the words of its texels and then its stamps, and how many texels those are.
#[derive(Clone, Debug)]
pub(crate) struct FadingBlock {
    pub block: u32,
    pub words: Arc<[u32]>,
    pub texels: usize,
}

/// Blocks of one channel on a device.
#[derive(Debug)]
pub(crate) struct DeviceFade {
    device: Device,
    kernel: Arc<Kernel>,
    /// What the device has, and from which word on.
    known: BTreeMap<u32, (Arc<[u32]>, u32)>,
    /// Where there is room, by words.
    free: BTreeMap<usize, Vec<u32>>,
    /// Words in use, freed ones among them.
    end: u32,
    stamped: Buffer<u32>,
}

/// Blocks of a dispatch at most.
const MAX_BLOCKS: usize = 32_768;

/// Words of texels that come back at a time.
const MAX_WORDS: usize = 1 << 24;

/// The words of texels, the last of which may be filled up, and then their stamps.
pub(crate) fn words<T: Texel>(texels: &[T], stamps: &[f32]) -> Arc<[u32]> {
    let bytes: &[u8] = bytemuck::cast_slice(texels);
    let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
    bytes.chunks(size_of::<u32>()).map(word).chain(stamps.iter().map(|stamp| stamp.to_bits())).collect()
}

impl DeviceFade {
    /// Nothing yet, on `device`. Fails if that is lost.
    pub fn new(device: &Device) -> Result<Self> {
        use Access::{Read, Write};
        let kernel = device.kernel(&KernelSpec {
            module: "fade",
            entry: "fade",
            groups: &[&[Read, Read, Write]],
            immediates: size_of::<Fade>() as u32,
            constants: &[],
        })?;
        let stamped = Buffer::new(device, "texels that fade", 1)?;
        let (known, free) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self { device: device.clone(), kernel, known, free, end: 0, stamped })
    }

    /// The device that it is on.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// What is left of all texels of `blocks`, by number, at `time`; all others are forgotten. `None` if the device does
    /// not know such texels.
    pub fn evaluate<T: Texel>(
        &mut self,
        blocks: &[FadingBlock],
        blank: T,
        options: DecayOptions,
        time: f64,
    ) -> Result<Option<BTreeMap<u32, Vec<T>>>> {
        let Some((format, blank)) = blank.on_device() else { return Ok(None) };
        self.take(blocks)?;
        let high = time as f32;
        let DecayOptions { delay, duration } = options;
        let rest = (time - f64::from(high)) as f32;
        let work = Fade { time: high, rest, delay, duration, blank, format, padding: [0; 3] };
        let words = |block: &FadingBlock| (block.texels * size_of::<T>()).div_ceil(4);
        let mut left = BTreeMap::new();
        let mut rest = blocks;
        while !rest.is_empty() {
            let mut sum = 0;
            let fits = |block: &&FadingBlock| {
                sum += words(block);
                sum <= MAX_WORDS
            };
            let count = rest.iter().take(MAX_BLOCKS).take_while(fits).count().max(1);
            let (now, then) = rest.split_at(count);
            rest = then;
            let mut end = 0;
            let jobs = now.iter().map(|block| {
                let first = self.known.get(&block.block).map_or(0, |(_, first)| *first);
                let out = end;
                end += words(block);
                [first, block.texels as u32, out as u32, 0]
            });
            let jobs: Vec<[u32; 4]> = jobs.collect();
            let most = now.iter().map(words).max().unwrap_or(0) as u32;
            let faded = self.run(&work, &jobs, end, most)?;
            for (block, [_, _, out, _]) in now.iter().zip(jobs) {
                let texels: &[T] = bytemuck::cast_slice(&faded[out as usize..][..words(block)]);
                left.insert(block.block, texels[..block.texels].to_vec());
            }
        }
        Ok(Some(left))
    }

    /// One dispatch over `jobs`, which leave `end` words, `most` of one block at most.
    fn run(&self, work: &Fade, jobs: &[[u32; 4]], end: usize, most: u32) -> Result<Vec<u32>> {
        let device = &self.device;
        let on_device = Buffer::of(device, "blocks that fade", jobs)?;
        let faded = Buffer::new(device, "what is left", end)?;
        let bound = device.bind(&self.kernel, 0, &[on_device.wgpu(), self.stamped.wgpu(), faded.wgpu()])?;
        let mut frame = device.frame()?;
        let size = [most.div_ceil(GROUP), jobs.len() as u32, 1];
        frame.pass("decay.fade").run(&self.kernel, &[&bound], bytemuck::bytes_of(work), size)?;
        let back = frame.read(&faded, 0..end)?;
        let _ = frame.submit()?;
        back.get(device)
    }

    /// Makes the device have `blocks` and no others.
    fn take(&mut self, blocks: &[FadingBlock]) -> Result<()> {
        let wanted: BTreeSet<u32> = blocks.iter().map(|block| block.block).collect();
        let sizes: BTreeMap<u32, usize> = blocks.iter().map(|block| (block.block, block.words.len())).collect();
        let free = &mut self.free;
        self.known.retain(|block, (words, first)| {
            let stays = wanted.contains(block) && sizes.get(block) == Some(&words.len());
            if !stays {
                free.entry(words.len()).or_default().push(*first);
            }
            stays
        });
        let mut written = Vec::new();
        for block in blocks {
            let known = self.known.get(&block.block);
            if known.is_some_and(|(words, _)| Arc::ptr_eq(words, &block.words) || **words == *block.words) {
                continue;
            }
            let length = block.words.len();
            let freed = || self.free.get_mut(&length).and_then(Vec::pop);
            let first = match known.map(|(_, first)| *first).or_else(freed) {
                Some(first) => first,
                None => {
                    let end = u32::try_from(length).ok().and_then(|length| self.end.checked_add(length));
                    let end = end.ok_or_else(|| Error::memory("what fades is too large for a graphics device"))?;
                    std::mem::replace(&mut self.end, end)
                }
            };
            self.known.insert(block.block, (block.words.clone(), first));
            written.push((first, &block.words));
        }
        self.grow()?;
        written.into_iter().try_for_each(|(first, words)| self.stamped.write(&self.device, first as usize, words))
    }

    /// Makes room for all words in use, with half as much again, and moves what is there.
    fn grow(&mut self) -> Result<()> {
        let (old, needed) = (self.stamped.len(), self.end as usize);
        if needed <= old {
            return Ok(());
        }
        let stamped = Buffer::new(&self.device, "texels that fade", needed + needed / 2)?;
        let mut frame = self.device.frame()?;
        frame.copy(&self.stamped, 0..old, &stamped, 0)?;
        let _ = frame.submit()?;
        self.stamped = stamped;
        Ok(())
    }
}

/// What evaluates a fade: a device, as long as it works.
#[derive(Debug, Default)]
pub(crate) struct Fader {
    device: Option<DeviceFade>,
    fault: Option<Error>,
}

impl Fader {
    /// Has a device evaluate from now on, or the processor again.
    pub fn use_device(&mut self, device: Option<&Device>) {
        let same = |fade: &DeviceFade| device.is_some_and(|device| device.is_same(fade.device()));
        if self.device.as_ref().is_some_and(same) {
            return;
        }
        self.device = device.and_then(|device| self.keep(DeviceFade::new(device)));
    }

    /// The failure after which the processor took over, told once.
    pub fn take_fault(&mut self) -> Option<Error> {
        self.fault.take()
    }

    /// Whether a device evaluates.
    pub fn is_on_device(&self) -> bool {
        self.device.is_some()
    }

    /// As [`DeviceFade::evaluate`]; nothing where the processor is to.
    pub fn evaluate<T: Texel>(
        &mut self,
        blocks: &[FadingBlock],
        blank: T,
        options: DecayOptions,
        time: f64,
    ) -> BTreeMap<u32, Vec<T>> {
        let Some(mut device) = self.device.take() else { return BTreeMap::new() };
        match device.evaluate(blocks, blank, options, time) {
            Ok(left) => {
                self.device = Some(device);
                left.unwrap_or_default()
            }
            Err(error) => {
                self.fault = Some(error);
                BTreeMap::new()
            }
        }
    }

    fn keep<T>(&mut self, made: Result<T>) -> Option<T> {
        made.map_err(|error| self.fault = Some(error)).ok()
    }
}
