//! Tables of parameters; see `include/relievo/parameter.h`.

use std::ffi::{CString, c_char};
use std::mem::size_of;
use std::sync::OnceLock;

use relievo_core::parameter::ParameterKind;
use relievo_core::{Parameter, Result};

use crate::border::array::{present, put};

constants! {
    u32:
    RLV_PARAMETER_F32 = 0,
    RLV_PARAMETER_U32 = 1,
    RLV_PARAMETER_BOOL = 2,
}

descriptor! {
    pub struct RlvParameter {
        name: *const c_char,
        unit: *const c_char,
        help: *const c_char,
        kind: u32,
        offset: u32,
        min: f64,
        max: f64,
        value: f64,
    }
}

/// Defines the C struct of a settings struct: its size, then field for field what its parameter table has.
macro_rules! settings {
    ($name:ident, $settings:ty) => {
        #[repr(C)]
        #[derive(Clone, Copy, Debug)]
        pub struct $name {
            pub struct_size: u32,
            pub settings: $settings,
        }

        // SAFETY: the struct is `#[repr(C)]`, begins with a `u32` and goes on with numbers of four bytes only.
        unsafe impl $crate::border::descriptor::Descriptor for $name {
            const NAME: &'static str = stringify!($name);
            const FIRST_SIZE: usize = std::mem::size_of::<$name>();
        }

        // C has the settings as fields of the struct itself.
        impl std::ops::Deref for $name {
            type Target = $settings;
            fn deref(&self) -> &$settings {
                &self.settings
            }
        }

        impl $name {
            /// The settings that C gives, or the defaults for NULL, checked.
            ///
            /// # Errors
            /// Fails with `Invalid` if `struct_size` is none of the type or a setting is out of range, and with
            /// `Unsupported` if a field that this library lacks is not zero.
            ///
            /// # Safety
            /// `from` is NULL or a descriptor that starts with its size.
            pub unsafe fn read(from: *const $name) -> relievo_core::Result<$settings> {
                let default = $name { struct_size: 0, settings: <$settings>::default() };
                // SAFETY: promised by the caller.
                let settings = unsafe { $crate::border::descriptor::read_optional(from, default) }?.settings;
                settings.check()?;
                Ok(settings)
            }
        }
    };
}
pub(crate) use settings;

/// Bytes of the size field that settings are behind.
const START: usize = size_of::<u32>();

/// A table that C reads, and the texts it points to. It lives as long as the process.
pub struct Table {
    pub rows: Vec<RlvParameter>,
    _texts: Vec<CString>,
}

// SAFETY: the pointers are to texts that the table owns and nobody changes.
unsafe impl Send for Table {}
// SAFETY: as above.
unsafe impl Sync for Table {}

/// The table of `parameters`, made at the first call.
pub fn table(cell: &'static OnceLock<Table>, parameters: &[Parameter]) -> &'static [RlvParameter] {
    let made = cell.get_or_init(|| {
        let mut texts = Vec::new();
        let mut text = |text: &str| {
            let text = CString::new(text).unwrap_or_default();
            // The heap allocation stays where it is when the string moves.
            let pointer = text.as_ptr();
            texts.push(text);
            pointer
        };
        let row = |parameter: &Parameter| RlvParameter {
            name: text(parameter.name),
            unit: text(parameter.unit),
            help: text(parameter.help),
            kind: match parameter.kind {
                ParameterKind::F32 => RLV_PARAMETER_F32,
                ParameterKind::U32 => RLV_PARAMETER_U32,
                ParameterKind::Bool => RLV_PARAMETER_BOOL,
            },
            offset: (START + parameter.offset) as u32,
            min: parameter.min,
            max: parameter.max,
            value: parameter.default,
        };
        let rows = parameters.iter().map(row).collect();
        Table { rows, _texts: texts }
    });
    &made.rows
}

/// Writes where the table of `parameters` is, and how many rows it has.
///
/// # Errors
/// Fails with `Invalid` if a pointer is NULL.
///
/// # Safety
/// The pointers are NULL, or a value may be written to them.
pub unsafe fn write_table(
    cell: &'static OnceLock<Table>,
    parameters: &[Parameter],
    params: *mut *const RlvParameter,
    count: *mut usize,
) -> Result<()> {
    present("params", params)?;
    present("count", count)?;
    let rows = table(cell, parameters);
    // SAFETY: both were checked above.
    unsafe {
        put(params, rows.as_ptr());
        put(count, rows.len());
    }
    Ok(())
}
