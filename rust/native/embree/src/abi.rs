//! The C interface of Embree 3.13 and 4, made from its headers by `cargo xtask bindings`.
//!
//! [`common`] has what both versions declare alike, and a table of those functions; [`embree3`] and [`embree4`] have
//! the functions that trace rays, whose signatures differ, and their structures. Records of hits are those of 4.4
//! everywhere: 3.x writes the same fields at the same places and leaves the last one alone.

// Generated names are those of C, and a table has members that only a debugger looks at.
#[rustfmt::skip]
#[allow(dead_code, non_camel_case_types, non_snake_case, non_upper_case_globals)]
#[allow(clippy::all, clippy::undocumented_unsafe_blocks)]
pub mod common;
#[rustfmt::skip]
#[allow(dead_code, non_camel_case_types, non_snake_case, non_upper_case_globals)]
#[allow(clippy::all, clippy::undocumented_unsafe_blocks)]
pub mod embree3;
#[rustfmt::skip]
#[allow(dead_code, non_camel_case_types, non_snake_case, non_upper_case_globals)]
#[allow(clippy::all, clippy::undocumented_unsafe_blocks)]
pub mod embree4;

pub use common::*;
pub use embree4::{RTCHit, RTCHit8, RTCRayHit, RTCRayHit8};

/// Which rays of a packet are traced: −1 for yes, 0 for no. Embree reads it with aligned loads.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub struct Valid8(pub [i32; 8]);

/// Fails to compile unless a record of 4.4 can be handed to 3.x: at least as large, with the same fields in the same
/// places.
macro_rules! extends {
    ($name:ident: $($field:ident),*) => {
        const _: () = assert!(size_of::<embree4::$name>() >= size_of::<embree3::$name>());
        const _: () = assert!(align_of::<embree4::$name>() == align_of::<embree3::$name>());
        $(const _: () = assert!(
            std::mem::offset_of!(embree4::$name, $field) == std::mem::offset_of!(embree3::$name, $field)
        );)*
    };
}

extends!(RTCHit: Ng_x, Ng_y, Ng_z, u, v, primID, geomID, instID);
extends!(RTCHit8: Ng_x, Ng_y, Ng_z, u, v, primID, geomID, instID);
extends!(RTCRayHit: ray, hit);
extends!(RTCRayHit8: ray, hit);
