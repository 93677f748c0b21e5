//! Initial values of structures: what stands between the brackets of an `RLV_..._INIT`.

use bindgen::callbacks::{Token, TokenKind};

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `sizeof(RlvMeshInfo)`.
    SizeOf(String),
    /// `NULL`.
    Null,
    /// An integer.
    Integer(i64),
    /// A number with a point, as it is written, without the letter for `float`.
    Real(String),
    /// Values of an array or an inner structure; missing values are 0.
    List(Vec<Value>),
}

impl Value {
    /// The number, where it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            // Initial values are small integers.
            Self::Integer(value) => Some(*value as f64),
            Self::Real(text) => text.parse().ok(),
            _ => None,
        }
    }

    /// As a literal of Python, where `ctypes.sizeof` gives sizes.
    pub fn python(&self) -> String {
        match self {
            Self::SizeOf(name) => format!("ctypes.sizeof({name})"),
            Self::Null => "None".into(),
            Self::Integer(value) => value.to_string(),
            Self::Real(text) => text.clone(),
            Self::List(values) => {
                let values: Vec<String> = values.iter().map(|value| value.python() + ",").collect();
                format!("({})", values.join(" "))
            }
        }
    }

    /// The value that the tokens of a macro write. `constant` has the values of names.
    ///
    /// # Errors
    /// It is written in another way than the headers of the ABI write values.
    pub fn of(tokens: &[Token], constant: impl Fn(&str) -> Option<i64>) -> Result<Self, String> {
        let tokens = tokens.iter().filter(|token| token.kind != TokenKind::Comment);
        let words: Vec<String> = tokens.map(|token| String::from_utf8_lossy(&token.raw).into_owned()).collect();
        let mut reader = Reader { words: &words, constant };
        let value = reader.value()?;
        if reader.words.is_empty() { Ok(value) } else { Err(format!("`{}` after its end", reader.words.join(" "))) }
    }
}

struct Reader<'a, F> {
    words: &'a [String],
    constant: F,
}

impl<'a, F: Fn(&str) -> Option<i64>> Reader<'a, F> {
    fn next(&mut self) -> Result<&'a str, String> {
        let (first, rest) = self.words.split_first().ok_or("it ends too early")?;
        self.words = rest;
        Ok(first)
    }

    fn expect(&mut self, word: &str) -> Result<(), String> {
        let found = self.next()?;
        if found == word { Ok(()) } else { Err(format!("`{found}` stands where `{word}` is expected")) }
    }

    fn value(&mut self) -> Result<Value, String> {
        match self.next()? {
            "{" => self.list(),
            "NULL" => Ok(Value::Null),
            "sizeof" => {
                self.expect("(")?;
                let name = self.next()?.to_owned();
                self.expect(")")?;
                Ok(Value::SizeOf(name))
            }
            "-" => match self.value()? {
                Value::Integer(value) => Ok(Value::Integer(-value)),
                Value::Real(text) => Ok(Value::Real(format!("-{text}"))),
                _ => Err("a sign stands before something else than a number".into()),
            },
            word => number(word)
                .or_else(|| (self.constant)(word).map(Value::Integer))
                .ok_or_else(|| format!("`{word}` is no value")),
        }
    }

    fn list(&mut self) -> Result<Value, String> {
        let mut values = Vec::new();
        loop {
            values.push(self.value()?);
            match self.next()? {
                "," => {}
                "}" => return Ok(Value::List(values)),
                other => return Err(format!("`{other}` stands where a comma is expected")),
            }
        }
    }
}

/// The number that C writes as `word`.
fn number(word: &str) -> Option<Value> {
    if let Some(digits) = word.strip_prefix("0x") {
        return i64::from_str_radix(digits.trim_end_matches(['u', 'U']), 16).ok().map(Value::Integer);
    }
    if let Ok(value) = word.trim_end_matches(['u', 'U']).parse() {
        return Some(Value::Integer(value));
    }
    let text = word.trim_end_matches('f');
    (word.contains('.') && text.parse::<f64>().is_ok()).then(|| Value::Real(text.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Value, String> {
        let marks = ["{", "}", "(", ")", ",", "-"];
        let spaced = marks.iter().fold(text.to_owned(), |text, mark| text.replace(mark, &format!(" {mark} ")));
        let words = spaced.split_whitespace();
        let tokens: Vec<Token> = words.map(|word| Token::from((TokenKind::Literal, word.as_bytes()))).collect();
        Value::of(&tokens, |name| (name == "RLV_PAINT_MIX").then_some(7))
    }

    #[test]
    fn initial_values_are_read_and_written_for_python() {
        let value = of("{sizeof(RlvA), RLV_PAINT_MIX, NULL, -0.5f, 0xffu, {0}, {1.0, 2u}}").unwrap();
        assert_eq!(value.python(), "(ctypes.sizeof(RlvA), 7, None, -0.5, 255, (0,), (1.0, 2,),)");
        assert_eq!(of("-1.5f").unwrap().number(), Some(-1.5));
    }

    #[test]
    fn other_text_is_an_error() {
        for text in ["{1, }", "{1", "{rubbish}", "1 2", "{sizeof RlvA}", "-NULL", ""] {
            assert!(of(text).is_err(), "{text}");
        }
    }
}
