//! Compute kernels: an entry point of a WGSL module with what it is bound to.

use std::fmt;
use std::sync::Arc;

use relievo_core::{Error, Result};
use wgpu::{BindGroupLayoutEntry, BindingType, BufferBindingType, ShaderStages};

use crate::device::{Device, lock, ready};
use crate::kernel_spec::{Access, KernelSpec};
use crate::module::{self, Composed, compose};

/// A compiled kernel.
pub struct Kernel {
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) immediates: u32,
    layouts: Vec<wgpu::BindGroupLayout>,
    counts: Vec<usize>,
    label: String,
}

impl fmt::Debug for Kernel {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_tuple("Kernel").field(&self.label).finish()
    }
}

/// Buffers bound to the bindings of a group. They fit every kernel with a group of the same accesses.
#[derive(Clone, Debug)]
pub struct Bindings {
    pub(crate) group: wgpu::BindGroup,
}

impl Device {
    /// The kernel that `spec` describes, compiled at the first call.
    ///
    /// # Errors
    /// Fails with `Internal` if there is no such module or entry point or it is faulty, with its file and line, and
    /// with `Memory` or `Device` if the device runs out of memory or was lost.
    pub fn kernel(&self, spec: &KernelSpec<'_>) -> Result<Arc<Kernel>> {
        let label = format!("{}.{}{:?}", spec.module, spec.entry, spec.constants);
        // An entry point may be bound with what it does not use, to share a group.
        let key = format!("{label}{:?}", spec.groups);
        if let Some(kernel) = lock(&self.inner().kernels).get(&key) {
            return Ok(Arc::clone(kernel));
        }
        let composed = compose(spec.module)?;
        let module = self.module(spec.module, &composed)?;
        let layouts: Vec<_> = spec.groups.iter().map(|group| self.bind_group_layout(group)).collect::<Result<_>>()?;
        let device = self.wgpu();
        let pipeline = self
            .guard(|| {
                let groups: Vec<_> = layouts.iter().map(Some).collect();
                let whole = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: None,
                    bind_group_layouts: &groups,
                    immediate_size: spec.immediates,
                });
                device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some(&label),
                    layout: Some(&whole),
                    module: &module,
                    entry_point: Some(spec.entry),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: spec.constants,
                        // Kernels write what they read.
                        zero_initialize_workgroup_memory: false,
                    },
                    cache: None,
                })
            })
            .map_err(|error| error.at(format!("{}, {}", module::path(spec.module), spec.entry)))?;
        let kernel = Arc::new(Kernel {
            pipeline,
            immediates: spec.immediates,
            layouts,
            counts: spec.groups.iter().map(|group| group.len()).collect(),
            label,
        });
        Ok(Arc::clone(lock(&self.inner().kernels).entry(key).or_insert(kernel)))
    }

    /// A shader module of composed text, for pipelines that draw.
    ///
    /// # Errors
    /// Fails with `Internal` if the text is faulty, with its file and line, and with `Device` if the device was lost.
    pub fn module(&self, name: &str, composed: &Composed) -> Result<wgpu::ShaderModule> {
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(composed.text.as_str().into()),
        };
        let checks = wgpu::ShaderRuntimeChecks { bounds_checks: true, ..wgpu::ShaderRuntimeChecks::unchecked() };
        let made = self.guard(|| {
            // SAFETY: the modules are ours. Their indices stay checked; what is left out is the rewriting of loops so
            // that they may be endless, and none of ours is: the iterations of each are bounded by its arguments.
            let module = unsafe { self.wgpu().create_shader_module_trusted(descriptor, checks) };
            let told = ready(module.get_compilation_info()).map(|info| info.messages).unwrap_or_default();
            (module, told)
        });
        // A faulty module is refused by its scope; the message says where.
        let (module, told) = made.map_err(|error| error.at(module::path(name)))?;
        match told.iter().find(|message| message.message_type == wgpu::CompilationMessageType::Error) {
            None => Ok(module),
            Some(message) => {
                let place = message.location.map_or(0, |location| location.line_number);
                Err(Error::internal(message.message.clone()).at(composed.place(place)))
            }
        }
    }

    fn bind_group_layout(&self, bindings: &[Access]) -> Result<wgpu::BindGroupLayout> {
        if let Some(layout) = lock(&self.inner().layouts).get(bindings) {
            return Ok(layout.clone());
        }
        let entries: Vec<_> = (0..)
            .zip(bindings)
            .map(|(binding, access)| BindGroupLayoutEntry {
                binding,
                visibility: ShaderStages::COMPUTE,
                ty: BindingType::Buffer {
                    ty: match access {
                        Access::Read => BufferBindingType::Storage { read_only: true },
                        Access::Write => BufferBindingType::Storage { read_only: false },
                        Access::Uniform => BufferBindingType::Uniform,
                    },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        let layout = self.guard(|| {
            self.wgpu().create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
        })?;
        Ok(lock(&self.inner().layouts).entry(bindings.to_vec()).or_insert(layout).clone())
    }

    /// Binds `buffers` to group `group` of `kernel`, and of every kernel with a group of the same accesses.
    ///
    /// # Errors
    /// Fails with `Internal` if there are not as many buffers as the group has bindings, there is no such group, or a
    /// buffer does not suit its binding, and with `Device` if the device was lost.
    pub fn bind(&self, kernel: &Kernel, group: usize, buffers: &[&wgpu::Buffer]) -> Result<Bindings> {
        let count = kernel.counts.get(group).copied().unwrap_or_default();
        if buffers.len() != count || count == 0 {
            let what =
                format!("{} buffers for the {count} bindings of group {group} of {}", buffers.len(), kernel.label);
            return Err(Error::internal(what));
        }
        self.bind_to(&kernel.layouts[group], buffers).map_err(|it| it.at(&*kernel.label))
    }

    /// Binds `buffers` to a group of every kernel in which it has these accesses.
    ///
    /// # Errors
    /// Fails with `Internal` if there is no buffer, not one for each access, or one that does not suit its binding, and
    /// with `Device` if the device was lost.
    pub fn bind_as(&self, accesses: &[Access], buffers: &[&wgpu::Buffer]) -> Result<Bindings> {
        if buffers.len() != accesses.len() || buffers.is_empty() {
            let what = format!("{} buffers for {} bindings", buffers.len(), accesses.len());
            return Err(Error::internal(what));
        }
        self.bind_to(&self.bind_group_layout(accesses)?, buffers)
    }

    fn bind_to(&self, layout: &wgpu::BindGroupLayout, buffers: &[&wgpu::Buffer]) -> Result<Bindings> {
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
        Ok(Bindings { group: self.guard(|| self.wgpu().create_bind_group(&descriptor))? })
    }
}
