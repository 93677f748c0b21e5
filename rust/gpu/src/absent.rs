//! The types of a build without the feature `wgpu`. No device can be opened there, so none of these types has a value,
//! and the compiler removes the code that would use one.
#![allow(missing_docs, reason = "the types of a build with `wgpu` describe them")]

use std::convert::Infallible;
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

use bytemuck::Pod;
use relievo_core::{Error, Result};

use crate::{Access, AdapterSummary, DeviceOptions, KernelSpec, PassTime};

/// Returns no adapter.
pub fn adapters() -> Vec<AdapterSummary> {
    Vec::new()
}

#[derive(Clone, Debug)]
pub struct Device(Infallible);

impl Device {
    /// Fails.
    pub fn open(_: &DeviceOptions) -> Result<Self> {
        Err(Error::unsupported("this build has no graphics devices")
            .advise("use the device `cpu`, or build with the feature `wgpu`"))
    }

    pub fn summary(&self) -> &AdapterSummary {
        match self.0 {}
    }

    pub fn limits(&self) -> &wgpu::Limits {
        match self.0 {}
    }

    pub fn is_timed(&self) -> bool {
        match self.0 {}
    }

    pub fn is_same(&self, _: &Device) -> bool {
        match self.0 {}
    }

    pub fn memory(&self) -> u64 {
        match self.0 {}
    }

    pub fn check(&self) -> Result<()> {
        match self.0 {}
    }

    pub fn abandon(&self) {
        match self.0 {}
    }

    pub fn charge(&self, _: u64) -> Result<Charge> {
        match self.0 {}
    }

    pub fn guard<T>(&self, _: impl FnOnce() -> T) -> Result<T> {
        match self.0 {}
    }

    pub fn frame(&self) -> Result<Frame> {
        match self.0 {}
    }

    pub fn kernel(&self, _: &KernelSpec<'_>) -> Result<Arc<Kernel>> {
        match self.0 {}
    }

    pub fn bind(&self, _: &Kernel, _: usize, _: &[&wgpu::Buffer]) -> Result<Bindings> {
        match self.0 {}
    }

    pub fn bind_as(&self, _: &[Access], _: &[&wgpu::Buffer]) -> Result<Bindings> {
        match self.0 {}
    }
}

#[derive(Debug)]
pub struct Charge(Infallible);

#[derive(Debug)]
pub struct Kernel(Infallible);

#[derive(Clone, Debug)]
pub struct Bindings(Infallible);

#[derive(Debug)]
pub struct Buffer<T>(Infallible, PhantomData<fn() -> T>);

impl<T: Pod> Buffer<T> {
    pub fn new(device: &Device, _: &str, _: usize) -> Result<Self> {
        match device.0 {}
    }

    pub fn of(device: &Device, _: &str, _: &[T]) -> Result<Self> {
        match device.0 {}
    }

    pub fn vertices(device: &Device, _: &str, _: usize) -> Result<Self> {
        match device.0 {}
    }

    pub fn len(&self) -> usize {
        match self.0 {}
    }

    pub fn is_empty(&self) -> bool {
        match self.0 {}
    }

    pub fn wgpu(&self) -> &wgpu::Buffer {
        match self.0 {}
    }

    pub fn write(&self, _: &Device, _: usize, _: &[T]) -> Result<()> {
        match self.0 {}
    }
}

#[derive(Debug)]
pub struct Frame(Infallible);

impl Frame {
    pub fn pass(&mut self, _: &'static str) -> Pass<'_> {
        match self.0 {}
    }

    pub fn clear<T: Pod>(&mut self, _: &Buffer<T>) {
        match self.0 {}
    }

    pub fn copy<T: Pod>(&mut self, _: &Buffer<T>, _: Range<usize>, _: &Buffer<T>, _: usize) -> Result<()> {
        match self.0 {}
    }

    pub fn read<T: Pod>(&mut self, _: &Buffer<T>, _: Range<usize>) -> Result<Readback<T>> {
        match self.0 {}
    }

    pub fn submit(self) -> Result<Submission> {
        match self.0 {}
    }
}

#[derive(Debug)]
pub struct Pass<'a>(Infallible, PhantomData<&'a mut Frame>);

impl Pass<'_> {
    pub fn run(&mut self, _: &Kernel, _: &[&Bindings], _: &[u8], _: [u32; 3]) -> Result<()> {
        match self.0 {}
    }

    pub fn run_indirect(&mut self, _: &Kernel, _: &[&Bindings], _: &[u8], _: &Buffer<u32>, _: usize) -> Result<()> {
        match self.0 {}
    }
}

#[derive(Debug)]
#[must_use]
pub struct Submission(Infallible);

impl Submission {
    pub fn wait(self) -> Result<Vec<PassTime>> {
        match self.0 {}
    }
}

#[derive(Debug)]
#[must_use]
pub struct Readback<T>(Infallible, PhantomData<fn() -> T>);

impl<T: Pod> Readback<T> {
    pub fn get(self, _: &Device) -> Result<Vec<T>> {
        match self.0 {}
    }
}

/// What callers name of the crate `wgpu`.
pub mod wgpu {
    use std::convert::Infallible;

    #[derive(Clone, Debug, PartialEq)]
    pub struct Buffer(Infallible);

    impl Buffer {
        pub fn size(&self) -> u64 {
            match self.0 {}
        }
    }

    /// What devices can do at most, for which there is no device.
    #[derive(Clone, Debug)]
    pub struct Limits {
        pub max_buffer_size: u64,
        pub max_storage_buffer_binding_size: u64,
    }
}
