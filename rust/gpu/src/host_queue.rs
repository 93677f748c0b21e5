//! Queues of the host, which are used under its lock.
//!
//! wgpu submits in several places and waits for the queue as it lets a device go. A lock around our own calls would miss some
//! and hold others too long, so the two functions of Vulkan that use a queue are replaced where wgpu looks them up. They
//! get a `VkQueue` and nothing else, hence the table by queue.

use std::collections::BTreeMap;
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex};

use ash::vk::{self, Handle};
use relievo_core::{Error, Result};

use crate::device::lock;
use crate::host_device::{HostDevice, HostFunction};

/// Turns on a queue.
struct Gate {
    /// For contexts that share a queue of a host without a lock. Taken after the host's lock, which the host may hold already.
    turn: Mutex<()>,
    submit: vk::PFN_vkQueueSubmit,
    wait_idle: vk::PFN_vkQueueWaitIdle,
    lock: Option<HostFunction>,
    unlock: Option<HostFunction>,
    user: *mut c_void,
}

// SAFETY: the pointer is only handed back to its owner's functions, which the header says run on any thread.
unsafe impl Send for Gate {}
// SAFETY: as above.
unsafe impl Sync for Gate {}

impl Gate {
    fn pass(&self, work: impl FnOnce(&Self) -> vk::Result) -> vk::Result {
        let call = |function: Option<HostFunction>| {
            if let Some(function) = function {
                // SAFETY: the host gave this function for this pointer.
                unsafe { function(self.user) };
            }
        };
        call(self.lock);
        let turn = lock(&self.turn);
        let result = work(self);
        drop(turn);
        call(self.unlock);
        result
    }
}

/// Gates by queue, with the number of devices that use each.
static GATES: Mutex<BTreeMap<u64, (Arc<Gate>, usize)>> = Mutex::new(BTreeMap::new());

fn through(queue: vk::Queue, work: impl FnOnce(&Gate) -> vk::Result) -> vk::Result {
    let gate = lock(&GATES).get(&queue.as_raw()).map(|(gate, _)| Arc::clone(gate));
    gate.map_or(vk::Result::ERROR_DEVICE_LOST, |gate| gate.pass(work))
}

unsafe extern "system" fn submit(
    queue: vk::Queue,
    count: u32,
    submits: *const vk::SubmitInfo<'_>,
    fence: vk::Fence,
) -> vk::Result {
    // SAFETY: wgpu's call, passed on.
    through(queue, |gate| unsafe { (gate.submit)(queue, count, submits, fence) })
}

unsafe extern "system" fn wait_idle(queue: vk::Queue) -> vk::Result {
    // SAFETY: wgpu's call, passed on.
    through(queue, |gate| unsafe { (gate.wait_idle)(queue) })
}

/// What stands in for a function of a device, if anything does.
pub(crate) fn replacement(name: &CStr) -> Option<*const c_void> {
    match name.to_bytes() {
        b"vkQueueSubmit" => Some(submit as *const c_void),
        b"vkQueueWaitIdle" => Some(wait_idle as *const c_void),
        _ => None,
    }
}

/// A queue whose gate is in the table until this is dropped.
pub(crate) struct HostQueue(u64);

impl HostQueue {
    /// Puts the gate of a queue into the table. Fails if another context works on the queue under another lock.
    pub(crate) fn new(queue: vk::Queue, device: &ash::Device, host: &HostDevice) -> Result<Self> {
        let functions = device.fp_v1_0();
        let mut gates = lock(&GATES);
        let (gate, users) = gates.entry(queue.as_raw()).or_insert_with(|| {
            let gate = Gate {
                turn: Mutex::new(()),
                submit: functions.queue_submit,
                wait_idle: functions.queue_wait_idle,
                lock: host.lock,
                unlock: host.unlock,
                user: host.user,
            };
            (Arc::new(gate), 0)
        });
        let address = |function: Option<HostFunction>| function.map(|it| it as usize);
        let same = address(gate.lock) == address(host.lock)
            && address(gate.unlock) == address(host.unlock)
            && (gate.lock.is_none() || gate.user == host.user);
        if !same {
            return Err(Error::invalid("another context works on this queue under another lock")
                .at("lock")
                .advise("give all contexts of a queue the same lock, unlock and user"));
        }
        *users += 1;
        Ok(Self(queue.as_raw()))
    }
}

impl Drop for HostQueue {
    fn drop(&mut self) {
        let mut gates = lock(&GATES);
        if let Some((_, users)) = gates.get_mut(&self.0) {
            *users -= 1;
            if *users == 0 {
                gates.remove(&self.0);
            }
        }
    }
}
