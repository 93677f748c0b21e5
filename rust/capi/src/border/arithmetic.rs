//! Settings of floating-point arithmetic while the thread of a host is inside of the library.
//!
//! Hosts may let exceptions trap, round otherwise, or flush small numbers to zero. Kernels divide by zero on purpose in lanes
//! whose results are not used, and their results must not depend on the host.

/// Settings of arithmetic of the thread that entered, put back on drop.
pub struct HostArithmetic {
    #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
    settings: Register,
}

#[cfg(target_arch = "x86_64")]
type Register = u32;
#[cfg(target_arch = "aarch64")]
type Register = u64;

/// No exception traps, results are rounded to nearest, nothing is flushed to zero.
#[cfg(target_arch = "x86_64")]
const OURS: Register = 0x1f80;
#[cfg(target_arch = "aarch64")]
const OURS: Register = 0;
/// Bits that record exceptions and set nothing.
#[cfg(target_arch = "x86_64")]
const RECORDS: Register = 0x3f;
#[cfg(target_arch = "aarch64")]
const RECORDS: Register = 0;

impl HostArithmetic {
    /// Replaces the settings of this thread by the library's until the value is dropped.
    pub fn replace() -> Self {
        #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
        {
            let settings = read();
            if settings & !RECORDS != OURS {
                write(OURS);
            }
            Self { settings }
        }
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        Self {}
    }
}

impl Drop for HostArithmetic {
    fn drop(&mut self) {
        #[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
        if self.settings & !RECORDS != OURS {
            write(self.settings);
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn read() -> Register {
    let mut settings: Register = 0;
    // SAFETY: the instruction stores the four bytes of MXCSR where `settings` lies, and changes nothing else.
    unsafe { core::arch::asm!("stmxcsr [{}]", in(reg) &raw mut settings, options(nostack, preserves_flags)) };
    settings
}

#[cfg(target_arch = "x86_64")]
fn write(settings: Register) {
    // SAFETY: the instruction reads the four bytes of `settings`, which is `OURS` or was read from MXCSR, so that no reserved
    // bit is set. Rust code runs with `OURS` alone: the settings of the host are put back when none of it is left.
    unsafe { core::arch::asm!("ldmxcsr [{}]", in(reg) &raw const settings, options(nostack, preserves_flags)) };
}

#[cfg(target_arch = "aarch64")]
fn read() -> Register {
    let settings: Register;
    // SAFETY: the instruction reads FPCR and changes nothing else.
    unsafe { core::arch::asm!("mrs {}, fpcr", out(reg) settings, options(nomem, nostack, preserves_flags)) };
    settings
}

#[cfg(target_arch = "aarch64")]
fn write(settings: Register) {
    // SAFETY: `settings` is `OURS` or was read from FPCR. Rust code runs with `OURS` alone: the settings of the host are put
    // back when none of it is left.
    unsafe { core::arch::asm!("msr fpcr, {}", in(reg) settings, options(nomem, nostack, preserves_flags)) };
}
