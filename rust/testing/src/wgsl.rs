//! Layouts that Rust and WGSL share, compared with what naga computes.

use relievo_gpu::module::compose;
use relievo_gpu::wgpu::naga;

/// Compares a `#[repr(C)]` type of `size` bytes, given its fields with their offsets, with the struct `name` of a module.
///
/// # Panics
/// If they differ in the names, the order or the offsets of their fields, or in their size.
pub fn assert_layout(module: &str, name: &str, size: usize, fields: &[(&str, usize)]) {
    let composed = compose(module).expect("the module");
    let parsed = naga::front::wgsl::parse_str(&composed.text).expect("valid WGSL");
    let found = parsed.types.iter().find(|(_, it)| it.name.as_deref() == Some(name));
    let (_, found) = found.unwrap_or_else(|| panic!("shaders/{module}.wgsl has no struct `{name}`"));
    let naga::TypeInner::Struct { members, span } = &found.inner else { panic!("`{name}` is no struct") };
    let members: Vec<_> =
        members.iter().map(|it| (it.name.as_deref().unwrap_or_default(), it.offset as usize)).collect();
    assert_eq!(members, fields, "the fields of `{name}` of shaders/{module}.wgsl");
    assert_eq!(*span as usize, size, "the size of `{name}` of shaders/{module}.wgsl");
}
