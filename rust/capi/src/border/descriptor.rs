//! Descriptors: structs that begin with their size, so that a program built with another version of the headers is
//! understood.

use std::mem::size_of;

use relievo_core::{Error, ErrorKind, Result};

/// A plain C struct that begins with its size.
///
/// # Safety
/// The type is `#[repr(C)]`, begins with a `u32`, and every bit pattern, all zeros included, is a value of it.
pub unsafe trait Descriptor: Copy {
    /// Name in C.
    const NAME: &'static str;
    /// Size in the first version of the header that had it.
    const FIRST_SIZE: usize;
}

/// Defines plain C structs; one whose first field is `struct_size` is a [`Descriptor`]. Of one that has grown,
/// `before FIELD` names the first field that its first version lacked.
macro_rules! descriptor {
    (pub struct $name:ident before $added:ident { struct_size: u32, $($field:ident: $type:ty,)* }) => {
        descriptor!(@plain $name { struct_size: u32, $($field: $type,)* });
        // SAFETY: the struct is `#[repr(C)]`, begins with a `u32` and has fields of plain numbers and pointers only.
        unsafe impl $crate::border::descriptor::Descriptor for $name {
            const NAME: &'static str = stringify!($name);
            const FIRST_SIZE: usize = std::mem::offset_of!($name, $added);
        }
    };
    (pub struct $name:ident { struct_size: u32, $($field:ident: $type:ty,)* }) => {
        descriptor!(@plain $name { struct_size: u32, $($field: $type,)* });
        // SAFETY: the struct is `#[repr(C)]`, begins with a `u32` and has fields of plain numbers and pointers only.
        unsafe impl $crate::border::descriptor::Descriptor for $name {
            const NAME: &'static str = stringify!($name);
            const FIRST_SIZE: usize = std::mem::size_of::<$name>();
        }
    };
    (pub struct $name:ident { $($field:ident: $type:ty,)* }) => {
        descriptor!(@plain $name { $($field: $type,)* });
    };
    (@plain $name:ident { $($field:ident: $type:ty,)* }) => {
        #[repr(C)]
        #[derive(Clone, Copy, Debug)]
        pub struct $name {
            $(pub $field: $type,)*
        }
    };
}

/// Defines the constants of a header and their table.
macro_rules! constants {
    ($type:ty: $($name:ident = $value:expr,)*) => {
        $(pub const $name: $type = $value;)*
        /// Name and value of every constant, for comparison with the names in scene files.
        pub const CONSTANTS: &[(&str, i64)] = &[$((stringify!($name), $name as i64),)*];
    };
}

/// The one that C calls `number`, in the order of its names in scene files.
///
/// # Errors
/// Fails with `Invalid` if there is no such number.
pub fn numbered<T: Copy>(what: &str, list: &[(T, &str)], number: u32) -> Result<T> {
    let most = list.len() - 1;
    list.get(number as usize).map(|(value, _)| *value).ok_or_else(|| {
        Error::invalid(format!("there is no {what} {number}")).at(what).advise(format!("use 0 to {most}"))
    })
}

fn declared_size<D: Descriptor>(size: usize) -> Result<usize> {
    if size < D::FIRST_SIZE || size > 1 << 16 {
        return Err(Error::invalid(format!("its struct_size is {size}"))
            .at(D::NAME)
            .advise("start from the RLV_…_INIT of the type, which sets it"));
    }
    Ok(size)
}

/// Reads the descriptor that `from` points to. Fields beyond the caller's `struct_size` keep the value in `default`;
/// fields that a newer header has and this library lacks must be zero.
///
/// # Errors
/// Fails with `Invalid` if the pointer is NULL or `struct_size` is none of the type, and with `Unsupported` if a field
/// that this library lacks is not zero.
///
/// # Safety
/// `from` is NULL or points to `struct_size` readable bytes, the first four of which are `struct_size`.
pub unsafe fn read_descriptor<D: Descriptor>(from: *const D, default: D) -> Result<D> {
    if from.is_null() {
        return Err(Error::invalid("the pointer is NULL").at(D::NAME).advise("pass a descriptor"));
    }
    // SAFETY: the caller promises the first four bytes.
    let size = declared_size::<D>(unsafe { from.cast::<u32>().read_unaligned() } as usize)?;
    let mut read = default;
    // SAFETY: `size` bytes are readable by the caller's promise, no more than the size of `D` are written, and every
    // bit pattern is a value of `D`.
    unsafe {
        std::ptr::copy_nonoverlapping(from.cast::<u8>(), (&raw mut read).cast::<u8>(), size.min(size_of::<D>()));
    }
    // SAFETY: `size` bytes are readable by the caller's promise.
    let newer = (size_of::<D>()..size).any(|at| unsafe { from.cast::<u8>().add(at).read() } != 0);
    if newer {
        return Err(Error::new(ErrorKind::Unsupported, "it uses fields that this version of the library lacks")
            .at(D::NAME)
            .advise("leave them zero, or load a newer library"));
    }
    Ok(read)
}

/// As [`read_descriptor`], where NULL means `default`.
///
/// # Errors
/// Fails with `Invalid` if `struct_size` is none of the type, and with `Unsupported` if a field that this library lacks
/// is not zero.
///
/// # Safety
/// As for [`read_descriptor`].
pub unsafe fn read_optional<D: Descriptor>(from: *const D, default: D) -> Result<D> {
    if from.is_null() {
        return Ok(default);
    }
    // SAFETY: promised by the caller.
    unsafe { read_descriptor(from, default) }
}

/// Writes `value` through `to`, no further than the caller's `struct_size`, which is left as it is.
///
/// # Errors
/// Fails with `Invalid` if the pointer is NULL or `struct_size` is none of the type.
///
/// # Safety
/// `to` is NULL or points to `struct_size` writable bytes, the first four of which are `struct_size`.
pub unsafe fn write_descriptor<D: Descriptor>(to: *mut D, value: D) -> Result<()> {
    if to.is_null() {
        return Err(Error::invalid("the output pointer is NULL").at(D::NAME).advise("pass a place for the result"));
    }
    // SAFETY: the caller promises the first four bytes.
    let size = declared_size::<D>(unsafe { to.cast::<u32>().read_unaligned() } as usize)?;
    let count = size.min(size_of::<D>()) - size_of::<u32>();
    // SAFETY: both sides have `count` bytes after their size field.
    unsafe {
        let from = (&raw const value).cast::<u8>().add(size_of::<u32>());
        std::ptr::copy_nonoverlapping(from, to.cast::<u8>().add(size_of::<u32>()), count);
    }
    Ok(())
}

/// As [`write_descriptor`], where NULL says that no result is wanted.
///
/// # Errors
/// Fails with `Invalid` if `struct_size` is none of the type.
///
/// # Safety
/// As for [`write_descriptor`].
pub unsafe fn write_optional<D: Descriptor>(to: *mut D, value: D) -> Result<()> {
    // SAFETY: promised by the caller.
    if to.is_null() { Ok(()) } else { unsafe { write_descriptor(to, value) } }
}

/// As [`write_descriptor`], field by field and then text by text, which saves copies of long ones. Bytes of the caller's
/// behind the end of a text stay as they are.
macro_rules! write_fields {
    ($to:ident: $name:ident { $($field:ident: $value:expr,)* } texts { $($array:ident: $text:expr,)* }) => {{
        use std::mem::offset_of;
        let size = check_descriptor::<$name>($to)?;
        $(
            let value = $value;
            if offset_of!($name, $field) + size_of_val(&value) <= size {
                (&raw mut (*$to).$field).write_unaligned(value);
            }
        )*
        $(
            let array = &raw mut (*$to).$array;
            if offset_of!($name, $array) + (*array).len() <= size {
                $crate::border::array::write_text(array, $text);
            }
        )*
        Ok(())
    }};
}

/// The size of the descriptor at `to`; called before the work whose result goes there.
///
/// # Errors
/// Fails with `Invalid` if the pointer is NULL or `struct_size` is none of the type.
///
/// # Safety
/// As for [`write_descriptor`].
pub unsafe fn check_descriptor<D: Descriptor>(to: *mut D) -> Result<usize> {
    if to.is_null() {
        return Err(Error::invalid("the output pointer is NULL").at(D::NAME).advise("pass a place for the result"));
    }
    // SAFETY: the caller promises the first four bytes.
    declared_size::<D>(unsafe { to.cast::<u32>().read_unaligned() } as usize)
}

/// As [`check_descriptor`], where NULL says that no result is wanted.
///
/// # Errors
/// Fails with `Invalid` if `struct_size` is none of the type.
///
/// # Safety
/// As for [`write_descriptor`].
pub unsafe fn check_optional<D: Descriptor>(to: *mut D) -> Result<()> {
    // SAFETY: promised by the caller.
    if to.is_null() { Ok(()) } else { unsafe { check_descriptor(to) }.map(|_| ()) }
}
