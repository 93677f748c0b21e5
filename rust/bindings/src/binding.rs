//! One library's declarations in Rust, made from its headers by bindgen.

use std::path::{Path, PathBuf};

use bindgen::callbacks::{EnumVariantCustomBehavior, EnumVariantValue, ParseCallbacks};
use bindgen::{EnumVariation, Formatter, RustEdition, RustTarget};
use regex::Regex;

/// What is generated from the headers of a library, and where it goes.
pub struct Binding {
    /// The Rust file that is written, relative to the folder of the workspace.
    pub output: &'static str,
    /// Lines that the file begins with: the notice of the headers, imports.
    pub head: &'static str,
    /// The headers. With several versions of them, each gives the same declarations, or it is an error.
    pub headers: &'static [Header],
    /// C that follows the headers. A macro that bindgen cannot read becomes a constant by a `static const` here.
    pub source: &'static str,
    /// Functions that are declared, as regular expressions.
    pub functions: &'static [&'static str],
    /// Types that are declared besides the types that the functions use, as regular expressions.
    pub types: &'static [&'static str],
    /// Macros, constants and enumerators that are declared, as regular expressions.
    pub constants: &'static [&'static str],
    /// Types that `head` imports, as regular expressions.
    pub imported: &'static [&'static str],
    /// The name of a struct of function pointers, for a library that is opened at run time. Its `from_library` takes an
    /// opened library and fails if that lacks a function.
    pub table: Option<&'static str>,
}

/// A header, as C includes it.
pub struct Header {
    /// `<embree3/rtcore.h>`, or a path from the folder of the workspace in quotation marks.
    pub include: &'static str,
    /// Where it is.
    pub place: Place,
}

/// Where headers are.
pub enum Place {
    /// In this repository, as `"cpp/library/header.h"`.
    Repository,
    /// In `/usr/include`, where this Debian package puts them.
    Package(&'static str),
    /// In the folder that an environment variable names; without it nothing is generated.
    Variable {
        /// The environment variable.
        name: &'static str,
        /// A header that a build of the library makes: its path below the folder, and the text that stands for it.
        configured: (&'static str, &'static str),
    },
}

impl Place {
    /// The folder to include from, or `None` where the environment variable is not set.
    fn folder(&self, root: &Path) -> Option<PathBuf> {
        match self {
            Self::Repository => Some(root.to_owned()),
            Self::Package(_) => Some("/usr/include".into()),
            Self::Variable { name, .. } => std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from),
        }
    }

    fn advice(&self) -> String {
        match self {
            Self::Repository => String::new(),
            Self::Package(name) => format!("; the headers are in Debian's {name}"),
            Self::Variable { name, .. } => format!("; the headers are looked for in the folder that {name} names"),
        }
    }
}

impl Binding {
    /// The text of the file, or `None` where none of the headers are there.
    ///
    /// # Errors
    /// The headers cannot be read, or those of two origins give different declarations.
    pub fn generate(&self, root: &Path) -> Result<Option<String>, String> {
        let mut made: Option<String> = None;
        for header in self.headers {
            let Some(folder) = header.place.folder(root) else { continue };
            let text = self.declarations(header, &folder);
            let text = text.map_err(|error| format!("{}: {error}{}", self.output, header.place.advice()))?;
            match &made {
                None => made = Some(text),
                Some(first) => self.compare(first, &text)?,
            }
        }
        Ok(made)
    }

    /// Which environment variables name the headers that are missing.
    pub fn missing(&self) -> String {
        let names = self.headers.iter().filter_map(|header| match header.place {
            Place::Variable { name, .. } => Some(name),
            _ => None,
        });
        format!("{} is not set", names.collect::<Vec<_>>().join(" and "))
    }

    fn declarations(&self, header: &Header, folder: &Path) -> Result<String, String> {
        let kept = Regex::new(&format!("^(?:{})$", self.constants.join("|"))).map_err(|error| error.to_string())?;
        let target = RustTarget::stable(85, 0).map_err(|error| error.to_string())?;
        let mut builder = bindgen::builder()
            .header_contents("binding.h", &format!("#include {}\n{}", header.include, self.source))
            .clang_arg(format!("-I{}", folder.display()))
            .rust_target(target)
            .rust_edition(RustEdition::Edition2024)
            .default_enum_style(EnumVariation::Consts)
            .prepend_enum_name(false)
            .wrap_unsafe_ops(true)
            .ctypes_prefix("::std::ffi")
            .disable_header_comment()
            .raw_line(self.head)
            .formatter(Formatter::Prettyplease)
            .parse_callbacks(Box::new(Enumerators(kept)));
        if let Place::Variable { configured: (path, text), .. } = header.place {
            builder = builder.header_contents(&folder.join(path).to_string_lossy(), text);
        }
        if let Some(name) = self.table {
            builder = builder.dynamic_library_name(name).dynamic_link_require_all(true);
        }
        builder = self.functions.iter().fold(builder, |builder, name| builder.allowlist_function(name));
        builder = self.types.iter().fold(builder, |builder, name| builder.allowlist_type(name));
        builder = self.constants.iter().fold(builder, |builder, name| builder.allowlist_var(name));
        builder = self.imported.iter().fold(builder, |builder, name| builder.blocklist_type(name));
        Ok(builder.generate().map_err(|error| error.to_string())?.to_string())
    }

    /// Fails unless two texts have the same declarations, in any order: versions order their headers differently.
    fn compare(&self, first: &str, second: &str) -> Result<(), String> {
        let sorted = |text: &str| {
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            lines.sort_unstable();
            lines
        };
        let (first, second) = (sorted(first), sorted(second));
        if first == second {
            return Ok(());
        }
        let only = |one: &[String], other: &[String]| one.iter().find(|line| !other.contains(line)).cloned();
        let line = only(&first, &second).or_else(|| only(&second, &first)).unwrap_or_default();
        Err(format!("{}: two versions of the headers declare different things: {}", self.output, line.trim()))
    }
}

/// Leaves out the enumerators that are not asked for, so that a version that has more of them gives the same text.
#[derive(Debug)]
struct Enumerators(Regex);

impl ParseCallbacks for Enumerators {
    fn enum_variant_behavior(
        &self,
        _: Option<&str>,
        variant: &str,
        _: EnumVariantValue,
    ) -> Option<EnumVariantCustomBehavior> {
        (!self.0.is_match(variant)).then_some(EnumVariantCustomBehavior::Hide)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALL: Binding = Binding {
        output: "ball.rs",
        head: "// The head.",
        headers: &[Header { include: "<stddef.h>", place: Place::Repository }],
        source: "typedef enum Kind { KIND_A = 1, KIND_B = 2 } Kind;\n\
                 typedef struct Ball { float radius[3]; Kind kind; } Ball;\n\
                 #define CAST ((unsigned int)-1)\n\
                 static const unsigned int NOTHING = CAST;\n\
                 int ball_roll(const Ball *ball, void (*seen)(void *user));\n\
                 int ball_other(void);\n",
        functions: &["ball_roll"],
        types: &[],
        constants: &["KIND_B", "NOTHING"],
        imported: &[],
        table: Some("Table"),
    };

    #[test]
    fn only_what_is_asked_for_is_declared() {
        let text = BALL.generate(Path::new("/")).unwrap().unwrap();
        for part in [
            "// The head.",
            "pub const KIND_B: Kind = 2;",
            "NOTHING: ::std::ffi::c_uint = 4294967295",
            "offset_of!(Ball, kind)",
        ] {
            assert!(text.contains(part), "no {part} in\n{text}");
        }
        assert!(text.contains("pub struct Table") && text.contains("ball: *const Ball"), "{text}");
        assert!(!text.contains("KIND_A") && !text.contains("ball_other"), "{text}");
    }

    #[test]
    fn versions_may_differ_in_the_order_of_declarations_alone() {
        assert_eq!(BALL.compare("a\nb\n", "b\na\n"), Ok(()));
        assert!(BALL.compare("a\nb\n", "a\nb: u8\n").unwrap_err().ends_with("different things: b"));
    }

    #[test]
    fn headers_that_are_absent_or_wrong_are_named() {
        const ABSENT: Place = Place::Variable { name: "RELIEVO_NO_SUCH_HEADERS", configured: ("a.h", "") };
        let absent = Binding { headers: &[Header { include: "<a.h>", place: ABSENT }], ..BALL };
        assert_eq!(absent.generate(Path::new("/")).unwrap(), None);
        assert_eq!(absent.missing(), "RELIEVO_NO_SUCH_HEADERS is not set");
        const WRONG: Place = Place::Package("ball-dev");
        let wrong = Binding { headers: &[Header { include: "<ball/that_is_not_there.h>", place: WRONG }], ..BALL };
        let error = wrong.generate(Path::new("/")).unwrap_err();
        assert!(error.contains("ball.rs") && error.contains("ball-dev"), "{error}");
    }
}
