//! Descriptions of kernels: an entry point of a WGSL module and the accesses of its bindings.

/// How a kernel uses the buffer of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Access {
    /// `var<storage, read>`.
    Read,
    /// `var<storage, read_write>`.
    Write,
    /// `var<uniform>`.
    Uniform,
}

/// What a kernel is made of.
#[derive(Clone, Copy, Debug)]
pub struct KernelSpec<'a> {
    /// The WGSL module.
    pub module: &'a str,
    /// The entry point in it.
    pub entry: &'a str,
    /// The buffers of every group, in the order of their bindings. Groups are bound one by one, so that what several
    /// kernels share, such as a surface, is bound once.
    pub groups: &'a [&'a [Access]],
    /// Bytes of `var<immediate>`, a multiple of 4, at most 128.
    pub immediates: u32,
    /// Values of `override` constants.
    pub constants: &'a [(&'a str, f64)],
}
