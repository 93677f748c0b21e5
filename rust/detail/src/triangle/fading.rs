//! Layers of a triangle mesh whose edits fade. See [`crate::channels::fading`] and [`relievo_tiles::triangle::decay`].

use std::sync::Arc;

use relievo_core::{Context, Error, Result};
use relievo_document::{Document, Stamps};
use relievo_gpu::Device;
use relievo_tiles::triangle::{TriangleChannel, TriangleDecay, TriangleField};
use relievo_tiles::{Blocks, DecayOptions};

use crate::channels::fading::LayerDecay;
use crate::channels::layer_channel::Absorb;

impl<T: Absorb> LayerDecay<TriangleChannel<T>> for TriangleDecay<T> {
    fn new(field: &TriangleField<T>, options: DecayOptions, budget: u64) -> Result<Self> {
        TriangleDecay::new(field, options, budget)
    }

    fn options(&self) -> DecayOptions {
        TriangleDecay::options(self)
    }

    fn set_options(&mut self, options: DecayOptions) -> Result<()> {
        TriangleDecay::set_options(self, options)
    }

    fn bytes(&self) -> u64 {
        TriangleDecay::bytes(self)
    }

    fn use_device(&mut self, device: Option<&Device>) {
        TriangleDecay::use_device(self, device);
    }

    fn take_device_fault(&mut self) -> Option<Error> {
        TriangleDecay::take_device_fault(self)
    }

    fn newest(&self) -> Option<f32> {
        TriangleDecay::newest(self)
    }

    fn oldest(&self) -> Vec<(u64, u32)> {
        TriangleDecay::oldest(self)
    }

    #[inline(never)]
    fn stamp(
        &mut self,
        context: &Context,
        before: &TriangleField<T>,
        channel: &TriangleChannel<T>,
        time: f64,
    ) -> Result<Vec<u32>> {
        TriangleDecay::stamp(self, context, before, channel, time)
    }

    fn fade(&mut self, context: &Context, channel: &mut TriangleChannel<T>, time: f64) -> Result<Vec<u32>> {
        Ok(TriangleDecay::fade(self, context, channel, time)?.changed)
    }

    #[inline(never)]
    fn bring(
        &mut self,
        context: &Context,
        channel: &mut TriangleChannel<T>,
        time: f64,
        restored: &[u32],
    ) -> Result<Vec<u32>> {
        TriangleDecay::bring(self, context, channel, time, restored)
    }

    fn stamped(&self) -> Vec<u32> {
        TriangleDecay::stamped(self)
    }

    fn take_changed(&mut self) -> Vec<u32> {
        TriangleDecay::take_changed(self)
    }

    fn read(&self, block: u32) -> Option<Vec<u8>> {
        TriangleDecay::read(self, block)
    }

    fn write(&mut self, _: &TriangleField<T>, block: u32, bytes: Option<&[u8]>) -> Result<()> {
        TriangleDecay::write(self, block, bytes)
    }

    fn restore(&mut self, _: &TriangleField<T>, block: u32, bytes: Option<&[u8]>) -> Result<()> {
        TriangleDecay::restore(self, block, bytes)
    }

    fn head(&self, layer: u32) -> Stamps {
        TriangleDecay::head(self, layer)
    }

    fn blocks(&self, _: &TriangleField<T>) -> Arc<dyn Blocks> {
        Arc::new(TriangleDecay::blocks(self))
    }

    #[inline(never)]
    fn stored(
        context: &Context,
        document: &Document,
        name: &str,
        field: &TriangleField<T>,
        budget: u64,
    ) -> Result<Self> {
        TriangleDecay::stored(context, document, name, field, budget)
    }
}
