//! The outside of a glTF file: the chunks of a GLB, the JSON, and the buffers, which are the binary chunk, written in
//! the file in base 64, or files beside it.

use std::borrow::Cow;

use gltf::json::Root as Json;
use gltf::json::validation::Checked;
use relievo_core::{Error, Result};

use crate::budget::Budget;
use crate::root::scheme;
use crate::text::BYTE_ORDER_MARK;

/// Opens a file that a glTF file names; it gets the name and the most bytes it may return.
pub type Open<'a> = dyn Fn(&str, u64) -> Result<Vec<u8>> + 'a;

/// A glTF file with all its bytes.
pub(crate) struct Container<'a> {
    pub json: Json,
    buffers: Vec<Cow<'a, [u8]>>,
}

/// Extensions that a file may require: the first is done here, the others only change how it looks.
const EXTENSIONS: &[&str] = &[
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "KHR_texture_transform",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "MSFT_texture_dds",
];

impl<'a> Container<'a> {
    /// Opens a `.glb` or `.gltf` file.
    pub fn open(bytes: &'a [u8], budget: &mut Budget, open: &Open) -> Result<Self> {
        let (text, chunk) = if bytes.starts_with(b"glTF") { chunks(bytes)? } else { (bytes, None) };
        let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        charge_json(text, budget)?;
        let json: Json = gltf::json::deserialize::from_slice(text).map_err(|error| {
            Error::invalid(format!("the JSON cannot be read: {error}")).advise("check that it is a glTF 2.0 file")
        })?;
        if !json.asset.version.starts_with("2.") {
            return Err(Error::unsupported(format!("it is glTF {}", json.asset.version)).advise("export glTF 2.0"));
        }
        for extension in &json.extensions_required {
            if !EXTENSIONS.contains(&extension.as_str()) && !extension.starts_with("KHR_materials_") {
                return Err(Error::unsupported(format!("it requires the extension {extension}"))
                    .advise("export it without that extension, for compressed meshes without compression"));
            }
        }
        let mut buffers = Vec::new();
        for (index, buffer) in json.buffers.iter().enumerate() {
            let place = |error: Error| error.at(format!("buffer {index}"));
            let content = match &buffer.uri {
                None => Cow::Borrowed(chunk.filter(|_| index == 0).ok_or_else(|| {
                    place(Error::invalid("it has neither bytes nor a name").advise("export the file as GLB"))
                })?),
                Some(uri) => Cow::Owned(load(uri, budget, open).map_err(place)?),
            };
            let length = buffer.byte_length.0;
            if length > content.len() as u64 {
                let what = format!("it has {} bytes instead of {length}", content.len());
                return Err(place(Error::invalid(what)).advise("the file is cut off; export it again"));
            }
            buffers.push(content);
        }
        Ok(Self { json, buffers })
    }

    /// The bytes of a view and its stride.
    pub fn view(&self, index: usize) -> Result<(&[u8], Option<usize>)> {
        let place = |error: Error| error.at(format!("buffer view {index}"));
        let missing = || Error::invalid(format!("buffer view {index} does not exist"));
        let view = self.json.buffer_views.get(index).ok_or_else(missing)?;
        let buffer = self
            .buffers
            .get(view.buffer.value())
            .ok_or_else(|| place(Error::invalid(format!("buffer {} does not exist", view.buffer.value()))))?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.checked_add(view.byte_length.0).and_then(|end| usize::try_from(end).ok());
        let bytes = end
            .and_then(|end| buffer.get(start as usize..end))
            .ok_or_else(|| place(Error::invalid(format!("it leaves the {} bytes of its buffer", buffer.len()))))?;
        Ok((bytes, view.byte_stride.map(|stride| stride.0)))
    }
}

/// The value that was understood, or an error.
pub(crate) fn understood<T: Copy>(value: &Checked<T>, what: &str) -> Result<T> {
    match value {
        Checked::Valid(value) => Ok(*value),
        Checked::Invalid => Err(Error::invalid(format!("its {what} is not known")).advise("use those of glTF 2.0")),
    }
}

/// The JSON and binary chunks of a GLB. Other chunks are stepped over.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>)> {
    let word = |at: usize| {
        let bytes = bytes.get(at..at + 4).and_then(|bytes| <[u8; 4]>::try_from(bytes).ok());
        bytes.map(u32::from_le_bytes)
    };
    let bad = |what: &str| Error::invalid(what).advise("the file is cut off or no GLB; export it again");
    if word(4) != Some(2) {
        return Err(Error::unsupported("the GLB is not of version 2").advise("export glTF 2.0"));
    }
    let length = word(8).ok_or_else(|| bad("the header ends early"))? as usize;
    if length > bytes.len() {
        return Err(bad(&format!("the file has {} bytes instead of {length}", bytes.len())));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at + 8 <= length {
        let size = word(at).unwrap_or_default() as usize;
        let kind = &bytes[at + 4..at + 8];
        let start = at + 8;
        let end = start.checked_add(size).filter(|end| *end <= length);
        let end = end.ok_or_else(|| bad(&format!("the chunk at byte {at} is longer than the file")))?;
        match kind {
            b"JSON" if json.is_none() => json = Some(&bytes[start..end]),
            b"BIN\0" if binary.is_none() => binary = Some(&bytes[start..end]),
            _ => {}
        }
        at = end;
    }
    json.map(|json| (json, binary)).ok_or_else(|| bad("there is no JSON chunk"))
}

/// Counts what the JSON may become in memory: every brace a structure, every comma a number or text.
fn charge_json(text: &[u8], budget: &mut Budget) -> Result<()> {
    let count = |mark: u8| text.iter().filter(|byte| **byte == mark).count() as u64;
    budget.charge(count(b'{') * 512 + count(b',') * 32 + text.len() as u64)
}

/// The bytes that a buffer's address means.
fn load(uri: &str, budget: &mut Budget, open: &Open) -> Result<Vec<u8>> {
    if scheme(uri).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data")) {
        let data = uri.split_once(',').filter(|(head, _)| head.ends_with(";base64"));
        let (_, data) =
            data.ok_or_else(|| Error::unsupported("its data are not in base 64").advise("export as GLB"))?;
        return base64(data.as_bytes(), budget);
    }
    let name = unescape(uri).ok_or_else(|| Error::invalid(format!("its address {uri:?} cannot be read")))?;
    let bytes = open(&name, budget.left())?;
    budget.charge(bytes.len() as u64)?;
    Ok(bytes)
}

/// The name with `%20` and the like replaced.
fn unescape(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((first, tail)) = rest.split_first() {
        rest = tail;
        if *first == b'%' {
            let (digits, tail) = tail.split_first_chunk::<2>()?;
            let digit = |digit: u8| char::from(digit).to_digit(16);
            bytes.push((digit(digits[0])? * 16 + digit(digits[1])?) as u8);
            rest = tail;
        } else {
            bytes.push(*first);
        }
    }
    String::from_utf8(bytes).ok()
}

/// Decodes base 64 (RFC 4648, Section 4), with or without padding.
fn base64(text: &[u8], budget: &mut Budget) -> Result<Vec<u8>> {
    let text = text.trim_ascii_end();
    let padding = text.iter().rev().take_while(|byte| **byte == b'=').count();
    let text = &text[..text.len() - padding.min(2)];
    let mut bytes = Vec::new();
    budget.reserve(&mut bytes, text.len() / 4 * 3 + 2)?;
    let (mut word, mut bits) = (0u32, 0);
    for letter in text {
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return Err(Error::invalid("its base 64 has a wrong letter").advise("export the file again")),
        };
        word = word << 6 | u32::from(value);
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            bytes.push((word >> bits) as u8);
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_agrees_with_the_vectors_of_its_standard() {
        let cases =
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg", "foob"), ("Zm9vYmFy", "foobar")];
        for (text, expected) in cases {
            assert_eq!(base64(text.as_bytes(), &mut Budget::new(100)).unwrap(), expected.as_bytes());
        }
        assert!(base64(b"Zm9*", &mut Budget::new(100)).is_err());
    }

    #[test]
    fn escapes_are_read() {
        assert_eq!(unescape("a%20b.bin").as_deref(), Some("a b.bin"));
        assert_eq!(unescape("a%2"), None);
        assert_eq!(unescape("%ff"), None);
    }
}
