//! Resources that a shader is bound to: textures, samplers, and the numbers of its uniforms by name.

use naga::{AddressSpace, ArraySize, Handle, ImageClass, ImageDimension, Module, ScalarKind, Type, TypeInner};

use crate::dialect::{SAMPLER, TEXTURE};

/// Numbers that a uniform may have; more are left at 0.
const MAX_NUMBERS: usize = 1 << 16;

/// A number of a uniform, or several of one name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name: of the member, with the names of the structs around it where those are nested.
    pub name: String,
    /// The byte of each number in the buffer.
    pub offsets: Vec<u32>,
    /// The kind of the numbers.
    pub kind: FieldKind,
}

/// The kind of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// Floats of 32 bits.
    Float,
    /// Integers of 32 bits with a sign.
    Signed,
    /// Integers of 32 bits without a sign.
    Unsigned,
}

impl FieldKind {
    /// Returns the kind of a scalar of naga, if it is a number of 32 bits.
    pub(crate) fn of(scalar: &naga::Scalar) -> Option<Self> {
        let kind = match scalar.kind {
            ScalarKind::Float => Self::Float,
            ScalarKind::Sint => Self::Signed,
            ScalarKind::Uint => Self::Unsigned,
            _ => return None,
        };
        (scalar.width == 4).then_some(kind)
    }

    /// Returns the bytes of a number, as devices read it.
    #[cfg(feature = "wgpu")]
    pub(crate) fn bytes(self, number: f64) -> [u8; 4] {
        match self {
            Self::Float => (number as f32).to_ne_bytes(),
            Self::Signed => (number as i32).to_ne_bytes(),
            Self::Unsigned => (number as u32).to_ne_bytes(),
        }
    }
}

/// What a binding is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ResourceKind {
    /// A buffer of uniforms.
    Uniforms {
        /// Its bytes.
        size: u32,
        /// Its numbers.
        fields: Vec<Field>,
    },
    /// A buffer of storage.
    Storage {
        /// Whether the shader writes to it.
        is_written: bool,
    },
    /// A texture of floats that is sampled or loaded.
    Texture {
        /// Its dimensions, 2 or 3.
        dimensions: u32,
    },
    /// A texture that the shader writes.
    Target {
        /// Its format in WGSL.
        format: naga::StorageFormat,
    },
    /// A sampler that filters.
    Sampler,
    /// What no input can be given for.
    Other(&'static str),
}

/// A binding of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Resource {
    /// Its name in the user's text.
    pub name: String,
    /// The bind group (descriptor set).
    pub group: u32,
    /// The binding in it.
    pub binding: u32,
    /// What it is.
    pub kind: ResourceKind,
}

/// Returns the resources of a module by group and binding.
pub(crate) fn resources(module: &Module) -> Vec<Resource> {
    let mut found: Vec<_> = module
        .global_variables
        .iter()
        .filter_map(|(_, variable)| {
            let binding = variable.binding.as_ref()?;
            let name = variable.name.clone().unwrap_or_default();
            let name =
                [TEXTURE, SAMPLER].iter().find_map(|prefix| name.strip_prefix(prefix)).unwrap_or(&name).to_owned();
            let kind = kind(module, variable);
            Some(Resource { name, group: binding.group, binding: binding.binding, kind })
        })
        .collect();
    found.sort_by_key(|resource| (resource.group, resource.binding));
    found
}

fn kind(module: &Module, variable: &naga::GlobalVariable) -> ResourceKind {
    let inner = &module.types[variable.ty].inner;
    match (variable.space, inner) {
        (AddressSpace::Uniform, _) => {
            let mut fields = Vec::new();
            let name = match inner {
                TypeInner::Struct { .. } => "",
                _ => variable.name.as_deref().unwrap_or_default(),
            };
            collect(module, variable.ty, name, 0, &mut fields);
            ResourceKind::Uniforms { size: inner.size(module.to_ctx()), fields }
        }
        (AddressSpace::Storage { access }, _) => {
            ResourceKind::Storage { is_written: access.contains(naga::StorageAccess::STORE) }
        }
        (_, TypeInner::Image { dim, arrayed: false, class }) => match (dim, class) {
            (ImageDimension::D2, ImageClass::Sampled { kind: ScalarKind::Float, multi: false }) => {
                ResourceKind::Texture { dimensions: 2 }
            }
            (ImageDimension::D3, ImageClass::Sampled { kind: ScalarKind::Float, multi: false }) => {
                ResourceKind::Texture { dimensions: 3 }
            }
            (ImageDimension::D2, ImageClass::Storage { format, .. }) => ResourceKind::Target { format: *format },
            _ => ResourceKind::Other("a texture that is neither 2-D nor 3-D, or not of floats"),
        },
        (_, TypeInner::Sampler { comparison: false }) => ResourceKind::Sampler,
        (_, TypeInner::Sampler { comparison: true }) => ResourceKind::Other("a sampler that compares"),
        _ => ResourceKind::Other("neither a buffer, a texture nor a sampler"),
    }
}

/// Adds the numbers of a type at byte `at`.
fn collect(module: &Module, ty: Handle<Type>, name: &str, at: u32, fields: &mut Vec<Field>) {
    let numbers = |scalar: &naga::Scalar, offsets: Vec<u32>| {
        FieldKind::of(scalar).map(|kind| Field { name: name.to_owned(), offsets, kind })
    };
    match &module.types[ty].inner {
        TypeInner::Scalar(scalar) => fields.extend(numbers(scalar, vec![at])),
        TypeInner::Vector { size, scalar } => {
            fields.extend(numbers(scalar, (0..*size as u32).map(|part| at + 4 * part).collect()));
        }
        TypeInner::Matrix { columns, rows, scalar } => {
            let stride = if *rows as u32 == 2 { 8 } else { 16 };
            let columns = (0..*columns as u32).map(|column| at + column * stride);
            let offsets = columns.flat_map(|start| (0..*rows as u32).map(move |row| start + 4 * row));
            fields.extend(numbers(scalar, offsets.collect()));
        }
        TypeInner::Array { base, size: ArraySize::Constant(count), stride } => {
            let mut element = Vec::new();
            collect(module, *base, name, 0, &mut element);
            for field in element {
                let count = (count.get() as usize).min(MAX_NUMBERS / field.offsets.len().max(1)) as u32;
                let offsets = (0..count).flat_map(|index| field.offsets.iter().map(move |it| (index, *it)));
                let offsets = offsets.map(|(index, offset)| at.saturating_add(index * stride).saturating_add(offset));
                fields.push(Field { offsets: offsets.collect(), ..field });
            }
        }
        TypeInner::Struct { members, .. } => {
            for member in members {
                let own = member.name.as_deref().unwrap_or_default();
                let full = if name.is_empty() { own.to_owned() } else { format!("{name}.{own}") };
                collect(module, member.ty, &full, at.saturating_add(member.offset), fields);
            }
        }
        _ => {}
    }
}
