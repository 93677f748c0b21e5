//! Parameters: one definition yields the struct, its default, and a table with name, type, offset, range, unit and
//! help of every field. Scene files, the command line, the C ABI and host panels all read that table.

use std::io::Write as _;

use crate::error::nearest;
use crate::{Error, Result};

/// The type of a parameter; each is four bytes in a `#[repr(C)]` struct.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterKind {
    /// `f32`
    F32,
    /// `u32`
    U32,
    /// `u32`, 0 or 1
    Bool,
}

/// One field of a parameter struct.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name of the field.
    pub name: &'static str,
    /// Its type.
    pub kind: ParameterKind,
    /// Bytes from the start of the struct.
    pub offset: usize,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// The value of the struct's `Default`.
    pub default: f64,
    /// Unit: `""` for a pure number, `rad`, `s`, `object units`, …
    pub unit: &'static str,
    /// What it does.
    pub help: &'static str,
}

/// The parameter called `name` in `table`.
///
/// # Errors
/// Fails with `Invalid` if the table has no such parameter, and suggests the nearest name.
pub fn find<'a>(table: &'a [Parameter], name: &str) -> Result<&'a Parameter> {
    table.iter().find(|parameter| parameter.name == name).ok_or_else(|| {
        let error = Error::invalid(format!("unknown parameter `{name}`"));
        match nearest(name, table.iter().map(|parameter| parameter.name)) {
            Some(near) => error.advise(format!("did you mean `{near}`?")),
            None => error,
        }
    })
}

impl Parameter {
    /// Checks that `value` is a number of this parameter's type in its range.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is not in the range, not a number, or has a fraction where the type is whole.
    pub fn check(&self, value: f64) -> Result<()> {
        let whole = self.kind == ParameterKind::F32 || value.fract() == 0.0;
        if value >= self.min && value <= self.max && whole {
            return Ok(());
        }
        let number = if self.kind == ParameterKind::F32 { "a number" } else { "a whole number" };
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        Err(Error::invalid(format!("`{}` is {value}", self.name))
            .advise(format!("use {number} from {} to {}{unit}", self.min, self.max)))
    }
}

/// Types a parameter field may have.
pub trait Field: Copy {
    /// The kind of the field.
    const KIND: ParameterKind;
    /// The value as a number.
    fn get(self) -> f64;
    /// The field for a checked number.
    fn of(value: f64) -> Self;
}

impl Field for f32 {
    const KIND: ParameterKind = ParameterKind::F32;
    fn get(self) -> f64 {
        // Through the shortest decimal, so that 0.1 reads as 0.1.
        let mut text = [0; 32];
        let mut rest = &mut text[..];
        let left = write!(rest, "{self:e}").map_or(0, |()| rest.len());
        let text = std::str::from_utf8(&text[..32 - left]).unwrap_or_default();
        text.parse().unwrap_or(f64::from(self))
    }
    fn of(value: f64) -> Self {
        value as f32
    }
}

impl Field for u32 {
    const KIND: ParameterKind = ParameterKind::U32;
    fn get(self) -> f64 {
        f64::from(self)
    }
    fn of(value: f64) -> Self {
        value as u32
    }
}

/// A switch that is four bytes wide, 0 or 1, as C sees it.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switch(pub u32);

impl Switch {
    /// Off.
    pub const OFF: Switch = Switch(0);
    /// On.
    pub const ON: Switch = Switch(1);

    /// Whether it is on.
    pub fn is_on(self) -> bool {
        self.0 != 0
    }
}

impl Field for Switch {
    const KIND: ParameterKind = ParameterKind::Bool;
    fn get(self) -> f64 {
        f64::from(self.0)
    }
    fn of(value: f64) -> Self {
        Switch(u32::from(value != 0.0))
    }
}

/// Defines a `#[repr(C)]` struct of four-byte parameters with its default and its [`Parameter`] table.
///
/// ```
/// relievo_core::parameters! {
///     /// How a dent is made.
///     pub struct Dent {
///         /// Share of the depth that is applied.
///         share: f32 = 1.0, 0.0..=1.0, "";
///         /// Most sub-steps of a frame.
///         sub_steps: u32 = 16, 1..=1024, "";
///     }
/// }
/// let mut dent = Dent::default();
/// dent.set("share", 0.5).unwrap();
/// assert_eq!(dent.get("share").unwrap(), 0.5);
/// assert!(dent.set("share", 2.0).is_err());
/// assert_eq!(Dent::PARAMETERS[1].help, "Most sub-steps of a frame.");
/// ```
#[macro_export]
macro_rules! parameters {
    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $(#[doc = $help:literal] $field:ident: $ty:ident = $default:expr, $min:literal..=$max:expr, $unit:literal;)*
        }
    ) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name {
            $(#[doc = $help] pub $field: $ty,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $name {
            /// Name, type, offset, range, default, unit and help of every field, in order.
            pub const PARAMETERS: &'static [$crate::Parameter] = &[$($crate::Parameter {
                name: stringify!($field),
                kind: <$ty as $crate::parameter::Field>::KIND,
                offset: std::mem::offset_of!($name, $field),
                min: $min as f64,
                max: $max as f64,
                default: $crate::parameters!(@number $ty $default),
                unit: $unit,
                help: $help.trim_ascii(),
            },)*];

            /// The value of the field called `name`.
            pub fn get(&self, name: &str) -> $crate::Result<f64> {
                $crate::parameter::find(Self::PARAMETERS, name)?;
                $(if name == stringify!($field) { return Ok($crate::parameter::Field::get(self.$field)); })*
                unreachable!("the table has the fields of the struct")
            }

            /// Sets the field called `name`; fails if there is none or the value is out of range.
            pub fn set(&mut self, name: &str, value: f64) -> $crate::Result<()> {
                $crate::parameter::find(Self::PARAMETERS, name)?.check(value)?;
                $(if name == stringify!($field) { self.$field = $crate::parameter::Field::of(value); })*
                Ok(())
            }

            /// Fails if any field is out of its range.
            pub fn check(&self) -> $crate::Result<()> {
                for parameter in Self::PARAMETERS {
                    parameter.check(self.get(parameter.name)?)?;
                }
                Ok(())
            }
        }
    };
    (@number Switch $value:expr) => { ($value).0 as f64 };
    (@number $ty:ident $value:expr) => { ($value) as f64 };
}
