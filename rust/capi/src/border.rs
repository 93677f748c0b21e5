//! The border between C and Rust: no panic crosses it, and every failure becomes a result and the thread's last error.

mod arithmetic;
pub mod array;
#[macro_use]
pub mod descriptor;
pub mod element;
pub mod fork;
mod glibc;
pub mod host;
pub mod log;
pub mod making;
pub mod memory;
pub mod registry;
pub mod work;

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

use relievo_core::{Error, Result};

use crate::border::arithmetic::HostArithmetic;
use crate::runtime::error::{self, RLV_OK, RlvResult};

thread_local! {
    /// Where this thread panicked last; read right after the panic was caught.
    static PANIC_PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

static QUIET: Once = Once::new();

/// Runs `body` and returns its result.
///
/// # Errors
/// Returns the error of `body`, and fails with `Internal` if it panics.
pub fn caught<T>(body: impl FnOnce() -> Result<T>) -> Result<T> {
    guarded(body).unwrap_or_else(Err)
}

/// Runs `body` with the library's arithmetic; a panic in it becomes an error.
fn guarded<T>(body: impl FnOnce() -> T) -> Result<T> {
    // A library stays silent; the place of a panic goes into the error instead of the standard error stream.
    QUIET.call_once(|| {
        if !cfg!(test) {
            std::panic::set_hook(Box::new(|info| {
                let place = info.location().map(ToString::to_string).unwrap_or_default();
                // A thread that is being torn down has no place to keep it; then it is lost.
                let _ = PANIC_PLACE.try_with(|last| *last.borrow_mut() = place);
            }));
        }
    });
    let _host = HostArithmetic::replace();
    catch_unwind(AssertUnwindSafe(body)).map_err(|payload| {
        let text = payload.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("no message");
        let place = PANIC_PLACE.try_with(|last| std::mem::take(&mut *last.borrow_mut())).unwrap_or_default();
        let failure = Error::internal(format!("a fault inside Relievo: {text}"));
        let failure = if place.is_empty() { failure } else { failure.at(place) };
        failure.advise("please report it; release the objects of this call")
    })
}

/// Runs the body of the function called `name`.
pub fn enter(name: &'static str, body: impl FnOnce() -> Result<()>) -> RlvResult {
    let failed = |failure: Error| error::remember(failure.at(name));
    // Errors are large: only their number leaves the body.
    let done = guarded(|| match work::named(name, body) {
        Ok(()) => RLV_OK,
        Err(failure) => failed(failure),
    });
    done.unwrap_or_else(failed)
}

/// Defines functions of the C ABI. The body returns `Result<()>` and writes outputs as its last step.
macro_rules! entry {
    ($($(#[$meta:meta])* fn $name:ident($($argument:ident: $type:ty),* $(,)?) $body:block)*) => {$(
        $(#[$meta])*
        #[unsafe(no_mangle)]
        #[allow(clippy::too_many_arguments)]
        pub unsafe extern "C" fn $name($($argument: $type),*) -> $crate::runtime::error::RlvResult {
            $crate::border::enter(stringify!($name), || $body)
        }
    )*};
}
