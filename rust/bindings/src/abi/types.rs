//! Types of C as the headers of the ABI use them, and how C, Rust and Python write them.

use std::fmt::{Display, Write as _};

use syn::{GenericArgument, PathArguments, PointerMutability, ReturnType};

/// A type.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Type {
    /// `void`, behind a pointer or as a result.
    Void,
    /// `char`: a byte of a text.
    Char,
    /// A number.
    Number(Number),
    /// A type that the headers declare.
    Named(String),
    /// A pointer, and whether what it points to is `const`.
    Pointer(Box<Type>, bool),
    /// An array in a structure.
    Array(Box<Type>, usize),
}

/// A type of numbers: its names in C, Rust and `ctypes`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Number {
    /// `uint32_t`.
    pub c: &'static str,
    /// `u32`.
    pub rust: &'static str,
    /// `c_uint32`.
    pub python: &'static str,
}

/// The numbers that the ABI may use.
pub const NUMBERS: [Number; 9] = [
    Number { c: "float", rust: "f32", python: "c_float" },
    Number { c: "double", rust: "f64", python: "c_double" },
    Number { c: "uint8_t", rust: "u8", python: "c_uint8" },
    Number { c: "uint16_t", rust: "u16", python: "c_uint16" },
    Number { c: "uint32_t", rust: "u32", python: "c_uint32" },
    Number { c: "uint64_t", rust: "u64", python: "c_uint64" },
    Number { c: "int32_t", rust: "i32", python: "c_int32" },
    Number { c: "int64_t", rust: "i64", python: "c_int64" },
    Number { c: "size_t", rust: "usize", python: "c_size_t" },
];

/// What a function takes and returns.
pub struct Signature {
    /// Names and types.
    pub arguments: Vec<(String, Type)>,
    /// The result, or [`Type::Void`].
    pub result: Type,
}

impl Type {
    /// The type that bindgen writes as `from`.
    ///
    /// # Errors
    /// The ABI does not use such types.
    pub fn of(from: &syn::Type) -> Result<Self, String> {
        match from {
            syn::Type::Ptr(pointer) => {
                let constant = matches!(pointer.mutability, PointerMutability::Const(_));
                Ok(Self::Pointer(Box::new(Self::of(&pointer.elem)?), constant))
            }
            syn::Type::Array(array) => Ok(Self::Array(Box::new(Self::of(&array.elem)?), integer(&array.len)?)),
            syn::Type::Path(path) => {
                let name = path.path.segments.last().map(|last| last.ident.to_string()).unwrap_or_default();
                let number = NUMBERS.into_iter().find(|number| number.rust == name);
                match name.as_str() {
                    "c_void" => Ok(Self::Void),
                    "c_char" => Ok(Self::Char),
                    _ if name.starts_with("Rlv") => Ok(Self::Named(name)),
                    _ => number.map(Self::Number).ok_or_else(|| format!("the ABI does not use {name}")),
                }
            }
            _ => Err("the ABI uses only numbers, structures, pointers and arrays".into()),
        }
    }

    /// As C declares `name` with this type.
    pub fn c(&self, name: &str) -> String {
        match self {
            Self::Array(of, count) => of.c(&format!("{name}[{count}]")),
            Self::Pointer(to, constant) => {
                let stars = format!("*{name}");
                match (&**to, constant) {
                    // `const T **` has the qualifier of the innermost type in front.
                    (Self::Pointer(..), _) | (_, false) => to.c(&stars),
                    (_, true) => format!("const {}", to.c(&stars)),
                }
            }
            Self::Void => spaced("void", name),
            Self::Char => spaced("char", name),
            Self::Number(number) => spaced(number.c, name),
            Self::Named(own) => spaced(own, name),
        }
    }

    /// As Rust writes the type. Texts in structures are bytes there.
    pub fn rust(&self) -> String {
        match self {
            Self::Void => "c_void".into(),
            Self::Char => "c_char".into(),
            Self::Number(number) => number.rust.into(),
            Self::Named(name) => name.clone(),
            Self::Pointer(to, true) => format!("*const {}", to.rust()),
            Self::Pointer(to, false) => format!("*mut {}", to.rust()),
            Self::Array(of, count) if **of == Self::Char => format!("[u8; {count}]"),
            Self::Array(of, count) => format!("[{}; {count}]", of.rust()),
        }
    }

    /// As `ctypes` writes the type. Pointers to numbers are types of their own, which take addresses, as NumPy gives
    /// them, and remember what they point to.
    ///
    /// # Errors
    /// Python's declarations have no such type.
    pub fn python(&self) -> Result<String, String> {
        match self {
            Self::Void => Ok("None".into()),
            Self::Char => Ok("c_char".into()),
            Self::Number(number) => Ok(number.python.into()),
            Self::Named(name) => Ok(name.clone()),
            Self::Array(of, count) => Ok(format!("{} * {count}", of.python()?)),
            Self::Pointer(to, _) => match &**to {
                Self::Void => Ok("c_void_p".into()),
                Self::Char => Ok("c_char_p".into()),
                Self::Number(number) => Ok(format!("{}_p", number.python)),
                Self::Named(name) => Ok(format!("POINTER({name})")),
                Self::Pointer(inner, _) if matches!(**inner, Self::Named(_) | Self::Number(_)) => {
                    Ok(format!("POINTER({})", to.python()?))
                }
                _ => Err(format!("Python has no declaration of {}", self.c(""))),
            },
        }
    }
}

impl Signature {
    /// The signature of the function type `from`.
    ///
    /// # Errors
    /// The ABI does not use one of the types, or an argument has no name.
    pub fn of_pointer(from: &syn::TypeFnPtr) -> Result<Self, String> {
        let arguments = from.inputs.iter().map(|argument| {
            let name = argument.name.as_ref().map(|(name, _)| name.to_string()).ok_or("an argument has no name")?;
            Ok::<_, String>((plain_name(&name), Type::of(&argument.ty)?))
        });
        Ok(Self { arguments: arguments.collect::<Result<_, _>>()?, result: result(&from.output)? })
    }

    /// The signature of the declaration `from`.
    ///
    /// # Errors
    /// As [`Self::of_pointer`].
    pub fn of_function(from: &syn::Signature) -> Result<Self, String> {
        let arguments = from.inputs.iter().map(|argument| match argument {
            syn::FnArg::Typed(argument) => match &*argument.pat {
                syn::Pat::Ident(name) => Ok((plain_name(&name.ident.to_string()), Type::of(&argument.ty)?)),
                _ => Err("an argument has no name".to_owned()),
            },
            syn::FnArg::Receiver(_) => Err("C has no methods".to_owned()),
        });
        Ok(Self { arguments: arguments.collect::<Result<_, _>>()?, result: result(&from.output)? })
    }

    /// As C declares a function with this name.
    pub fn c(&self, name: &str) -> String {
        let arguments: Vec<String> = self.arguments.iter().map(|(name, kind)| kind.c(name)).collect();
        let arguments = if arguments.is_empty() { "void".to_owned() } else { arguments.join(", ") };
        self.result.c(&format!("{name}({arguments})"))
    }

    /// As Rust writes the type of a pointer to such a function.
    pub fn rust(&self) -> String {
        let arguments: Vec<String> = self.arguments.iter().map(|(_, kind)| kind.rust()).collect();
        let mut text = format!("unsafe extern \"C\" fn({})", arguments.join(", "));
        if self.result != Type::Void {
            let _ = write!(text, " -> {}", self.result.rust());
        }
        text
    }
}

/// The function type in `Option<unsafe extern "C" fn(...)>`, as bindgen writes pointers to functions.
pub fn callback(from: &syn::Type) -> Option<&syn::TypeFnPtr> {
    let syn::Type::Path(path) = from else { return None };
    let last = path.path.segments.last().filter(|last| last.ident == "Option")?;
    let PathArguments::AngleBracketed(list) = &last.arguments else { return None };
    match list.args.first()? {
        GenericArgument::Type(syn::Type::FnPtr(function)) => Some(function),
        _ => None,
    }
}

/// The name in C of what bindgen calls `name`: it adds an underscore to words of Rust.
pub fn plain_name(name: &str) -> String {
    match name.strip_suffix('_') {
        Some(short) if syn::parse_str::<syn::Ident>(short).is_err() => short.to_owned(),
        _ => name.to_owned(),
    }
}

/// The name in Rust of what C calls `name`.
pub fn rust_name(name: &str) -> String {
    if syn::parse_str::<syn::Ident>(name).is_err() { format!("{name}_") } else { name.to_owned() }
}

/// The integer that is written as `from`.
///
/// # Errors
/// It is something else.
pub fn integer<T>(from: &syn::Expr) -> Result<T, String>
where
    T: std::str::FromStr<Err: Display>,
{
    let (sign, from) = match from {
        syn::Expr::Unary(syn::ExprUnary { op: syn::UnOp::Neg(_), expr, .. }) => ("-", &**expr),
        _ => ("", from),
    };
    match from {
        syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Int(number), .. }) => {
            format!("{sign}{}", number.base10_digits()).parse().map_err(|error: T::Err| error.to_string())
        }
        _ => Err("an integer is expected".into()),
    }
}

fn result(from: &ReturnType) -> Result<Type, String> {
    match from {
        ReturnType::Default => Ok(Type::Void),
        ReturnType::Type(_, kind) => Type::of(kind),
    }
}

fn spaced(kind: &str, name: &str) -> String {
    if name.is_empty() { kind.to_owned() } else { format!("{kind} {name}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Type, String> {
        Type::of(&syn::parse_str(text).unwrap())
    }

    #[test]
    fn each_language_has_its_way_to_write_a_type() {
        for (rust, c, python) in [
            ("*const f32", "const float *it", "c_float_p"),
            ("*mut usize", "size_t *it", "c_size_t_p"),
            ("*const ::std::ffi::c_char", "const char *it", "c_char_p"),
            ("*mut ::std::ffi::c_void", "void *it", "c_void_p"),
            ("*mut *const RlvParameter", "const RlvParameter **it", "POINTER(POINTER(RlvParameter))"),
            ("*mut *const u8", "const uint8_t **it", "POINTER(c_uint8_p)"),
            ("[f64; 12usize]", "double it[12]", "c_double * 12"),
            ("RlvMesh", "RlvMesh it", "RlvMesh"),
        ] {
            let kind = of(rust).unwrap();
            assert_eq!((kind.c("it").as_str(), kind.python().unwrap().as_str()), (c, python), "{rust}");
        }
        assert_eq!(of("[::std::ffi::c_char; 48usize]").unwrap().rust(), "[u8; 48]");
        assert!(of("::std::ffi::c_long").unwrap_err().contains("c_long"));
        assert!(of("*mut *mut *mut f32").unwrap().python().is_err());
    }

    #[test]
    fn words_of_rust_keep_their_names_in_c() {
        assert_eq!((plain_name("type_").as_str(), plain_name("end_").as_str()), ("type", "end_"));
        assert_eq!((rust_name("type").as_str(), rust_name("kind").as_str()), ("type_", "kind"));
    }

    #[test]
    fn signatures_are_written_for_c_and_rust() {
        let function: syn::ForeignItemFn =
            syn::parse_str("pub fn rlv_a(type_: u32, list: *const f32, out: *mut RlvMesh) -> RlvResult;").unwrap();
        let signature = Signature::of_function(&function.sig).unwrap();
        assert_eq!(signature.c("rlv_a"), "RlvResult rlv_a(uint32_t type, const float *list, RlvMesh *out)");
        assert_eq!(signature.rust(), "unsafe extern \"C\" fn(u32, *const f32, *mut RlvMesh) -> RlvResult");
        let kind: syn::Type =
            syn::parse_str("::std::option::Option<unsafe extern \"C\" fn(user: *mut ::std::ffi::c_void)>").unwrap();
        let signature = Signature::of_pointer(callback(&kind).unwrap()).unwrap();
        assert_eq!(signature.c("(*RlvSeen)"), "void (*RlvSeen)(void *user)");
    }
}
