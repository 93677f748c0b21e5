//! Graphics devices that a context can be given; see `include/relievo/adapter.h`.

use relievo_gpu::{AdapterKind, adapters};

use crate::border::array::{Output, Plain, fixed, present, put};
use crate::runtime::context::{RLV_NAME_SIZE, RLV_TEXT_SIZE};

constants! {
    u32:
    RLV_ADAPTER_DISCRETE = 0,
    RLV_ADAPTER_INTEGRATED = 1,
    RLV_ADAPTER_VIRTUAL = 2,
    RLV_ADAPTER_SOFTWARE = 3,
}

descriptor! {
    pub struct RlvAdapterInfo {
        kind: u32,
        is_usable: u32,
        buffer_limit: u64,
        binding_limit: u64,
        backend: [u8; RLV_NAME_SIZE as usize],
        name: [u8; RLV_TEXT_SIZE as usize],
        driver: [u8; RLV_TEXT_SIZE as usize],
    }
}

impl Default for RlvAdapterInfo {
    fn default() -> Self {
        let (backend, name, driver) = (fixed(""), fixed(""), fixed(""));
        Self { kind: 0, is_usable: 0, buffer_limit: 0, binding_limit: 0, backend, name, driver }
    }
}

// SAFETY: integers, then bytes up to a multiple of eight: no padding, no invalid patterns.
unsafe impl Plain for RlvAdapterInfo {}

entry! {
    fn rlv_adapter_list(adapters: *mut RlvAdapterInfo, capacity: usize, count: *mut usize) {
        present("count", count)?;
        // SAFETY: the caller gives room for `capacity` rows, or NULL to ask for the count alone.
        let out = unsafe { Output::optional("adapters", adapters, capacity, 0) }?;
        let found = self::adapters();
        // SAFETY: checked above.
        unsafe { put(count, found.len()) };
        if let Some(out) = out {
            out.holds("adapters", found.len())?.fill(found.iter().map(|it| RlvAdapterInfo {
                kind: match it.kind {
                    AdapterKind::Discrete => RLV_ADAPTER_DISCRETE,
                    AdapterKind::Integrated => RLV_ADAPTER_INTEGRATED,
                    AdapterKind::Virtual => RLV_ADAPTER_VIRTUAL,
                    AdapterKind::Software => RLV_ADAPTER_SOFTWARE,
                },
                is_usable: u32::from(it.is_usable),
                buffer_limit: it.buffer_limit,
                binding_limit: it.binding_limit,
                backend: fixed(it.backend),
                name: fixed(&it.name),
                driver: fixed(&it.driver),
            }));
        }
        Ok(())
    }
}
