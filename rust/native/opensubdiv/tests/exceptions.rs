//! Every C++ exception becomes an error, whatever its type. The allocator of C++ in this program is ours: it throws
//! where a test asks for it, so that the library needs no entry that only tests call.
#![cfg(target_os = "linux")]

use std::cell::Cell;
use std::ffi::{c_int, c_void};

use relievo_core::Mesh;
use relievo_opensubdiv::reference::{Bfr, evaluate};
use relievo_opensubdiv::{BoundaryRule, Options, Table};

unsafe extern "C" {
    fn malloc(size: usize) -> *mut c_void;
    fn __cxa_allocate_exception(size: usize) -> *mut c_void;
    /// `typeid(int)`.
    static _ZTIi: u8;
}

unsafe extern "C-unwind" {
    fn __cxa_throw(exception: *mut c_void, kind: *const u8, destructor: *const c_void) -> !;
}

thread_local! {
    /// Allocations of this thread that succeed before one throws.
    static ALLOWED: Cell<usize> = const { Cell::new(usize::MAX) };
}

/// Replaces `operator new(std::size_t)`: throws an `int` once when the allowed allocations are used up.
///
/// # Safety
/// Only C++ calls it, whose frames can be unwound.
#[unsafe(export_name = "_Znwm")]
unsafe extern "C-unwind" fn operator_new(size: usize) -> *mut c_void {
    match ALLOWED.get() {
        usize::MAX => {}
        0 => {
            ALLOWED.set(usize::MAX);
            // SAFETY: the exception is an int, which needs no destructor, of the type that is named.
            unsafe {
                let exception = __cxa_allocate_exception(size_of::<c_int>());
                exception.cast::<c_int>().write(7);
                __cxa_throw(exception, &raw const _ZTIi, std::ptr::null());
            }
        }
        allowed => ALLOWED.set(allowed - 1),
    }
    // SAFETY: `operator delete` of libstdc++ gives to `free` what this returns.
    unsafe { malloc(size.max(1)) }
}

const OPTIONS: Options = Options {
    boundary: BoundaryRule::EdgesAndCorners,
    isolation: 3,
    single_crease: true,
    patch_limit: 1e6,
    memory_limit: u64::MAX,
};

fn cube() -> Mesh {
    let points = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(|bit| bit as f32)).collect();
    let corners = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
    Mesh::new(points, vec![4; 6], corners)
}

/// Runs `call` with one more allowed allocation each time until none throws. Returns how many runs failed.
fn failures<T>(mut call: impl FnMut() -> relievo_core::Result<T>) -> usize {
    for allowed in 0.. {
        ALLOWED.set(allowed);
        let result = call();
        let threw = ALLOWED.replace(usize::MAX) == usize::MAX;
        match result {
            Ok(_) if !threw => return allowed,
            Ok(_) => {}
            Err(error) => {
                assert!(threw, "allocation {allowed}: {error}");
                assert!(error.to_string().contains("an exception of an unknown type"), "{error}");
            }
        }
    }
    unreachable!("the numbers of a range do not end")
}

#[test]
fn an_exception_that_is_no_std_exception_is_an_error_wherever_it_is_thrown() {
    let cube = cube();
    let allocations = failures(|| Table::expected(&cube, &OPTIONS));
    assert!(allocations > 10, "only {allocations} allocations");
    let allocations = failures(|| Table::new(&cube, &OPTIONS));
    assert!(allocations > 100, "only {allocations} allocations");

    let table = Table::new(&cube, &OPTIONS).unwrap();
    let points = vec![[0.0; 3]; table.point_count()];
    assert!(failures(|| evaluate(&table, &points, &[(0, 0.5, 0.5)])) > 0);
    assert!(failures(|| Bfr::new(&table, 3)) > 0);
    let mut buffer = vec![0.0; 9 * 4];
    assert!(failures(|| Bfr::new(&table, 3)?.grid(&cube.points, 2, &mut buffer)) > 0);
}
