//! The graphics device of tests.

use relievo_gpu::{AdapterChoice, Device, DeviceOptions, adapters};

/// Says that tests fail where there is no graphics device, as `cargo xtask test` demands.
const REQUIRED: &str = "RELIEVO_GPU_TESTS";

/// A device that times its passes: the processor's own (lavapipe) where there is one, so that results are the same
/// everywhere, else the best; `RELIEVO_GPU_ADAPTER` names another. `None`, with a word about it, where there is none.
///
/// # Panics
/// If there is none and `RELIEVO_GPU_TESTS` is `required`, or if it cannot be opened.
pub fn device() -> Option<Device> {
    let adapters = adapters();
    let Some(last) = adapters.last() else {
        assert!(std::env::var_os(REQUIRED).is_none_or(|it| it != "required"), "there is no graphics device");
        println!("skipped: there is no graphics device");
        return None;
    };
    let name = std::env::var("RELIEVO_GPU_ADAPTER").unwrap_or_else(|_| last.name.clone());
    let options = DeviceOptions { adapter: AdapterChoice::Named(name), timing: true, ..Default::default() };
    Some(Device::open(&options).expect("the graphics device opens"))
}
