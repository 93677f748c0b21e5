//! Layouts of structs by the rules of WGSL (W3C, WebGPU Shading Language, section "Memory Layout").

use super::wgsl::{Module, Struct, Type};

/// A field with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedField {
    pub comment: Vec<String>,
    pub name: String,
    /// The type in Rust, whose alignment is that of a word.
    pub rust: String,
    /// Bytes from the beginning of the struct.
    pub offset: u32,
    /// Bytes in Rust.
    pub size: u32,
}

/// A struct with the places of its fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    pub fields: Vec<PlacedField>,
    /// Bytes, a multiple of the alignment.
    pub size: u32,
    pub align: u32,
}

/// Bytes, alignment and the type in Rust, which may be shorter.
struct Measure {
    size: u32,
    align: u32,
    rust: String,
    rust_size: u32,
}

/// All modules.
pub struct Modules(pub Vec<Module>);

impl Modules {
    /// Returns the module and struct that `name` is in module `from`: one of its own, or of what it imports.
    pub fn find<'m>(&'m self, from: &'m Module, name: &str) -> Option<(&'m Module, &'m Struct)> {
        let mut modules = vec![from];
        let mut at = 0;
        while let Some(module) = modules.get(at).copied() {
            if let Some(found) = module.structs.iter().find(|it| it.name == name) {
                return Some((module, found));
            }
            for imported in module.imports.iter().filter_map(|name| self.0.iter().find(|it| it.name == *name)) {
                if modules.iter().all(|it| it.name != imported.name) {
                    modules.push(imported);
                }
            }
            at += 1;
        }
        None
    }

    /// Returns the structs of which host and shader share values, with their modules, in the order of both: structs that
    /// variables of modules hold, and structs in these, except where one ends with an array as long as its buffer.
    ///
    /// # Errors
    /// Names the file and line of a type that is not known or cannot be shared.
    pub fn shared(&self) -> Result<Vec<(&Module, &Struct)>, String> {
        let mut found = Vec::new();
        for module in &self.0 {
            for of in module.shared()? {
                self.gather(module, &of, &mut found)?;
            }
        }
        found.sort_by_key(|(module, found)| (&module.name, found.line));
        Ok(found)
    }

    fn gather<'m>(
        &'m self,
        module: &'m Module,
        of: &Type,
        found: &mut Vec<(&'m Module, &'m Struct)>,
    ) -> Result<(), String> {
        match of {
            Type::Array(of, _) => self.gather(module, of, found),
            Type::Struct(name) => {
                let (module, wanted) = self.named(module, name)?;
                if found.iter().any(|(other, it)| other.name == module.name && it.name == *name) {
                    return Ok(());
                }
                let fields = module.fields(wanted)?;
                if !matches!(fields.last().map(|field| &field.is_of), Some(Type::Array(_, None))) {
                    found.push((module, wanted));
                }
                fields.iter().try_for_each(|field| self.gather(module, &field.is_of, found))
            }
            _ => Ok(()),
        }
    }

    fn named<'m>(&'m self, module: &'m Module, name: &str) -> Result<(&'m Module, &'m Struct), String> {
        let unknown = || format!("shaders/{}: no struct `{name}` in this module and its imports", module.file);
        self.find(module, name).ok_or_else(unknown)
    }

    /// Returns where the fields of `found`, a struct of `module`, are.
    ///
    /// # Errors
    /// Names the file and line of a field that hosts cannot share.
    pub fn layout(&self, module: &Module, found: &Struct) -> Result<Layout, String> {
        let mut layout = Layout { fields: Vec::new(), size: 0, align: 1 };
        for field in module.fields(found)? {
            let measure = self.measure(module, &field.is_of)?;
            let align = measure.align.max(field.align.unwrap_or(1));
            let offset = layout.size.next_multiple_of(align);
            layout.size = offset + field.size.unwrap_or(measure.size);
            layout.align = layout.align.max(align);
            let (rust, size) = (measure.rust, measure.rust_size);
            layout.fields.push(PlacedField { comment: field.comment, name: field.name, rust, offset, size });
        }
        layout.size = layout.size.next_multiple_of(layout.align);
        Ok(layout)
    }

    fn measure(&self, module: &Module, of: &Type) -> Result<Measure, String> {
        Ok(match of {
            Type::Scalar(scalar) => Measure { size: 4, align: 4, rust: (*scalar).to_owned(), rust_size: 4 },
            Type::Vector(count, scalar) => {
                let rust = format!("[{scalar}; {count}]");
                Measure { size: 4 * count, align: 4 * count.next_power_of_two(), rust, rust_size: 4 * count }
            }
            Type::Matrix(columns, rows) => {
                let column = rows.next_power_of_two();
                let size = 4 * column * columns;
                Measure { size, align: 4 * column, rust: format!("[[f32; {column}]; {columns}]"), rust_size: size }
            }
            Type::Array(of, count) => {
                let count = count.ok_or_else(|| format!("shaders/{}: an array has no length", module.file))?;
                let mut element = self.measure(module, of)?;
                let stride = element.size.next_multiple_of(element.align);
                if let Type::Vector(3, scalar) = **of {
                    (element.rust, element.rust_size) = (format!("[{scalar}; 4]"), stride);
                }
                Measure {
                    size: stride * count,
                    align: element.align,
                    rust: format!("[{}; {count}]", element.rust),
                    rust_size: element.rust_size * count,
                }
            }
            Type::Struct(name) => {
                let (other, found) = self.named(module, name)?;
                let Layout { size, align, .. } = self.layout(other, found)?;
                let rust =
                    if other.name == module.name { name.clone() } else { format!("super::{}::{name}", other.name) };
                Measure { size, align, rust, rust_size: size }
            }
        })
    }
}
