//! A layer: what one file says about paths. Text or binary, or an archive that begins with one of them.

use std::borrow::Cow;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

use openusd::sdf::{Data, Path, Value};
use relievo_core::{Error, Result};

use super::binary::Binary;
use super::{archive, old_names, text};
use crate::USD_MAGIC;
use crate::budget::Budget;

/// What a file says.
pub(crate) enum Layer {
    Text(Data),
    Binary(Box<Binary>),
}

impl Layer {
    /// Reads a file. Fails if it is neither text nor binary, is damaged, or needs more than the budget has.
    pub fn open(mut bytes: Vec<u8>, budget: &mut Budget) -> Result<Self> {
        if bytes.starts_with(archive::MAGIC) {
            bytes = archive::root_layer(bytes)?;
        }
        if bytes.starts_with(USD_MAGIC) {
            return Ok(Self::Binary(Box::new(Binary::open(bytes, budget)?)));
        }
        if !bytes.starts_with(b"#usda ") {
            return Err(Error::invalid("the file is not USD").advise("use .usda or .usdc, or .usd with either in it"));
        }
        let text = String::from_utf8(bytes).map_err(|error| {
            Error::invalid("the text is not UTF-8").at(format!("byte {}", error.utf8_error().valid_up_to()))
        })?;
        text::bound(&text, budget)?;
        let text = old_names::replaced(&text);
        if let Cow::Owned(renamed) = &text {
            budget.charge(renamed.len() as u64)?;
        }
        Ok(Self::Text(fenced(|| openusd::usda::parse(&text))?))
    }

    /// Whether it says something about what is at the path.
    pub fn has(&self, path: &Path) -> bool {
        match self {
            Self::Text(data) => data.spec(path).is_some(),
            Self::Binary(file) => file.has(path.as_str()),
        }
    }

    /// A field of what is at the path. Decoding it takes at most `left` bytes.
    pub fn field(&self, path: &Path, name: &str, left: u64) -> Result<Option<Cow<'_, Value>>> {
        let at = |error: Error| error.at(format!("`{}` of {}", name, path.as_str()));
        match self {
            Self::Text(data) => {
                let found = data.spec(path).and_then(|spec| spec.fields.iter().find(|(key, _)| key == name));
                Ok(found.map(|(_, value)| Cow::Borrowed(value)))
            }
            Self::Binary(file) => Ok(file.field(path.as_str(), name, left).map_err(at)?.map(Cow::Owned)),
        }
    }
}

/// What the parser returns, or an error.
///
/// It takes indices and counts of damaged files for good, and panics at some. Its state is dropped with the layer, so
/// nothing that it left half done is seen again.
pub(crate) fn fenced<T, E: Display>(work: impl FnOnce() -> std::result::Result<T, E>) -> Result<T> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(error)) => Err(Error::invalid(format!("the layer cannot be read: {error:#}"))),
        Err(_) => Err(Error::invalid("the layer is damaged").advise("export the file again")),
    }
}
