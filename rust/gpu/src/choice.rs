//! The adapters of this machine and the choice among them, which is by name or by kind, never by chance.

use relievo_core::{Error, ErrorKind, Result};
use wgpu::{Backends, DeviceType, Features, Instance, InstanceDescriptor, InstanceFlags};

use crate::adapter::{AdapterChoice, AdapterKind, AdapterSummary};
use crate::device::ready;

/// What every kernel needs.
pub(crate) const NEEDED: Features = Features::IMMEDIATES;

fn instance() -> Instance {
    let mut descriptor = InstanceDescriptor::new_without_display_handle();
    descriptor.backends = Backends::VULKAN | Backends::METAL | Backends::DX12;
    // Neither validation layers nor the checks of indirect arguments, which cost a dispatch each: those are ours. But on
    // Direct3D it is these checks that tell kernels how many workgroups an indirect dispatch has.
    descriptor.flags = if cfg!(windows) { InstanceFlags::VALIDATION_INDIRECT_CALL } else { InstanceFlags::empty() };
    Instance::new(descriptor)
}

/// What is said of an adapter.
pub(crate) fn summary(adapter: &wgpu::Adapter) -> AdapterSummary {
    let info = adapter.get_info();
    let kind = match info.device_type {
        DeviceType::DiscreteGpu => AdapterKind::Discrete,
        DeviceType::IntegratedGpu => AdapterKind::Integrated,
        DeviceType::VirtualGpu | DeviceType::Other => AdapterKind::Virtual,
        DeviceType::Cpu => AdapterKind::Software,
    };
    let driver = format!("{} {}", info.driver, info.driver_info).trim().to_owned();
    let limits = adapter.limits();
    AdapterSummary {
        name: info.name,
        driver,
        backend: info.backend.to_str(),
        kind,
        is_usable: adapter.features().contains(NEEDED),
        buffer_limit: limits.max_buffer_size,
        binding_limit: limits.max_storage_buffer_binding_size,
    }
}

/// Adapters with their summaries, best first, those alike in the order of the system.
fn found(instance: &Instance) -> Vec<(wgpu::Adapter, AdapterSummary)> {
    let adapters = ready(instance.enumerate_adapters(Backends::all())).unwrap_or_default();
    let mut found: Vec<_> = adapters.into_iter().map(|adapter| (summary(&adapter), adapter)).collect();
    found.sort_by_key(|(summary, _)| summary.kind);
    found.into_iter().map(|(summary, adapter)| (adapter, summary)).collect()
}

/// The adapters of this machine, best first. None is no error.
pub fn adapters() -> Vec<AdapterSummary> {
    found(&instance()).into_iter().map(|(_, summary)| summary).collect()
}

/// The adapter that is chosen, and the instance that it is of.
pub(crate) fn choose(choice: &AdapterChoice) -> Result<(Instance, wgpu::Adapter, AdapterSummary)> {
    let instance = instance();
    let mut found = found(&instance);
    let wanted = |summary: &AdapterSummary| match choice {
        AdapterChoice::Best => true,
        AdapterChoice::Hardware => summary.kind != AdapterKind::Software,
        AdapterChoice::Named(name) => summary.name.to_lowercase().contains(&name.to_lowercase()),
    };
    if let Some(index) = found.iter().position(|(_, summary)| wanted(summary)) {
        let (adapter, summary) = found.swap_remove(index);
        return Ok((instance, adapter, summary));
    }
    let names: Vec<_> = found.iter().map(|(_, summary)| format!("`{}`", summary.name)).collect();
    let what = match choice {
        _ if names.is_empty() => "there is no graphics device".to_owned(),
        AdapterChoice::Named(name) => format!("no graphics device is called `{name}`"),
        _ => "there is no graphics device but the processor itself".to_owned(),
    };
    let advice = if names.is_empty() {
        "install a Vulkan driver (on Debian `mesa-vulkan-drivers`), or use the device `cpu`".to_owned()
    } else {
        format!("there are {}; name one of them, or use the device `cpu`", names.join(", "))
    };
    Err(Error::new(ErrorKind::NotFound, what).advise(advice))
}
