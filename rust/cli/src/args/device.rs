//! The options that choose the processor or a graphics device.

use relievo_gpu::{AdapterChoice, Device as GraphicsDevice, DeviceOptions};

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
pub enum Device {
    /// The processor.
    Cpu,
    /// The graphics device.
    Gpu,
    /// The graphics device if there is one that can be used, else the processor.
    Auto,
}

/// The option that names a graphics device.
#[derive(clap::Args, Clone, Debug)]
pub struct Adapter {
    /// A part of the name of the graphics device; left out, the best there is.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

impl Adapter {
    /// Opens the graphics device of the options; `None` for the processor, which `auto` takes, with a note, where there is no
    /// other device. Fails if `gpu` has no device of that name.
    pub fn open(&self, kind: Device, memory_limit: u64) -> relievo_core::Result<Option<GraphicsDevice>> {
        let open = |otherwise| {
            let adapter = self.adapter.clone().map_or(otherwise, AdapterChoice::Named);
            GraphicsDevice::open(&DeviceOptions { adapter, timing: true, memory_limit })
        };
        match kind {
            Device::Cpu => Ok(None),
            Device::Gpu => open(AdapterChoice::Best).map(Some),
            Device::Auto => {
                Ok(open(AdapterChoice::Hardware).inspect_err(|it| eprintln!("note: on the processor: {it}")).ok())
            }
        }
    }
}
