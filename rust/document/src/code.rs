//! Numbers and texts as bytes: little-endian, and in seven bits a byte where most are small (LEB128).

use relievo_core::{Error, Result};

/// Appends to a list of bytes.
#[derive(Debug, Default)]
pub struct Encoder(pub Vec<u8>);

impl Encoder {
    /// A number of four bytes.
    pub fn u32(&mut self, value: u32) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// A number of eight bytes.
    pub fn u64(&mut self, value: u64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    /// Up to 255 bytes of text, after their number.
    pub fn text(&mut self, text: &str) {
        debug_assert!(text.len() <= usize::from(u8::MAX));
        self.0.push(text.len() as u8);
        self.0.extend_from_slice(text.as_bytes());
    }

    /// A number of one to five bytes.
    pub fn short(&mut self, mut value: u32) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }
}

/// Takes from the front of bytes that may be anything.
#[derive(Clone, Copy, Debug)]
pub struct Decoder<'a>(pub &'a [u8]);

impl<'a> Decoder<'a> {
    /// The next `count` bytes.
    ///
    /// # Errors
    /// Fails with `Invalid` if fewer are left.
    pub fn bytes(&mut self, count: usize) -> Result<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or_else(short)?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        self.bytes(N)?.try_into().map_err(|_| short())
    }

    /// A number of one byte.
    ///
    /// # Errors
    /// Fails with `Invalid` if no byte is left.
    pub fn u8(&mut self) -> Result<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    /// A number of four bytes.
    ///
    /// # Errors
    /// Fails with `Invalid` if fewer than four bytes are left.
    pub fn u32(&mut self) -> Result<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// A number of eight bytes.
    ///
    /// # Errors
    /// Fails with `Invalid` if fewer than eight bytes are left.
    pub fn u64(&mut self) -> Result<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// What [`Encoder::text`] wrote.
    ///
    /// # Errors
    /// Fails with `Invalid` if the text is longer than what is left, or not UTF-8.
    pub fn text(&mut self) -> Result<String> {
        let length = self.u8()?;
        let bytes = self.bytes(usize::from(length))?;
        String::from_utf8(bytes.to_vec()).map_err(|_| Error::invalid("the document is damaged: a text is not UTF-8"))
    }

    /// What [`Encoder::short`] wrote.
    ///
    /// # Errors
    /// Fails with `Invalid` if the bytes end before the number does, or it takes more than five bytes or 32 bits.
    pub fn short(&mut self) -> Result<u32> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = u64::from(self.u8()?);
            value |= (byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return u32::try_from(value)
                    .map_err(|_| Error::invalid("the document is damaged: a number is too large"));
            }
        }
        Err(Error::invalid("the document is damaged: a number does not end"))
    }

    /// Checks that at least `count` bytes are left: what lists of `count` items take.
    ///
    /// # Errors
    /// Fails with `Invalid` if fewer bytes are left.
    pub fn expect(&self, count: u64) -> Result<()> {
        if count > self.0.len() as u64 { Err(short()) } else { Ok(()) }
    }
}

fn short() -> Error {
    Error::invalid("the document is damaged: its index is shorter than it says")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_was_written_is_read(small: u32, number: u32, large: u64, text in "[^\u{0}]{0,40}") {
            let mut encoder = Encoder::default();
            encoder.short(small);
            encoder.u32(number);
            encoder.text(&text);
            encoder.u64(large);
            let mut decoder = Decoder(&encoder.0);
            prop_assert_eq!(decoder.short().unwrap(), small);
            prop_assert_eq!(decoder.u32().unwrap(), number);
            prop_assert_eq!(decoder.text().unwrap(), text);
            prop_assert_eq!(decoder.u64().unwrap(), large);
            prop_assert!(decoder.0.is_empty() && decoder.u8().is_err());
        }
    }

    #[test]
    fn numbers_that_do_not_fit_or_end_are_errors() {
        assert!(Decoder(&[0xff; 9]).short().is_err());
        assert!(Decoder(&[0xff, 0xff, 0xff, 0xff, 0x1f]).short().is_err());
        assert_eq!(Decoder(&[0xff, 0xff, 0xff, 0xff, 0x0f]).short().unwrap(), u32::MAX);
        assert!(Decoder(&[0x80]).short().is_err());
    }
}
