//! Users and their tokens.

use std::path::Path;

use relievo_client::Hash;
use relievo_core::{Error, Result, file};
use subtle::ConstantTimeEq;

/// Bytes of a file of tokens at most.
const LONGEST: u64 = 1 << 20;
/// Bytes of a token at least: shorter ones can be guessed.
const SHORTEST: usize = 16;
/// The user of a server without tokens.
const LOCAL: &str = "local";

/// The users of a server, with the hashes of their tokens.
#[derive(Default)]
pub struct Users(Vec<(String, Hash)>);

impl Users {
    /// Reads a file of tokens: on each line a name, a space and a token. Empty lines and lines that begin with `#` are
    /// left out. Fails if a line has no token, a token is shorter than 16 bytes, or a name or token is there twice.
    pub fn read(path: &Path) -> Result<Self> {
        let named = |error: Error| error.at(path.display().to_string());
        let bytes = file::load(path, LONGEST)?;
        let text = String::from_utf8(bytes).map_err(|_| named(Error::invalid("it is not UTF-8 text")))?;
        let mut users: Vec<(String, Hash)> = Vec::new();
        for (number, line) in
            text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'))
        {
            // The line itself is a secret.
            let refused = |what: &str| Err(named(Error::invalid(what).at(format!("line {}", number + 1))));
            let Some((name, token)) = line.trim().split_once(char::is_whitespace) else {
                return refused("it is not a name, a space and a token");
            };
            let token = token.trim();
            if token.len() < SHORTEST {
                return refused("the token is shorter than 16 bytes");
            }
            let hash = Hash::of(token.as_bytes());
            if users.iter().any(|(other, theirs)| other == name || *theirs == hash) {
                return refused("the name or the token is there twice");
            }
            users.push((name.to_owned(), hash));
        }
        match users.is_empty() {
            true => {
                Err(named(Error::invalid("there is no user").advise("add a line with a name, a space and a token")))
            }
            false => Ok(Self(users)),
        }
    }

    /// Returns whether users need tokens.
    pub fn are_known(&self) -> bool {
        !self.0.is_empty()
    }

    /// Returns the user of a token. The time that it takes depends neither on the token nor on whether it is right: hashes
    /// of all users are compared, each in constant time. Fails for a wrong token, without saying more.
    pub fn user(&self, token: &str) -> Result<String> {
        if !self.are_known() {
            return Ok(LOCAL.into());
        }
        let hash = Hash::of(token.as_bytes());
        let mut found = None;
        for (name, theirs) in &self.0 {
            if bool::from(theirs.0.ct_eq(&hash.0)) {
                found = Some(name);
            }
        }
        found.cloned().ok_or_else(|| {
            Error::invalid("the server does not take this token").advise("ask whoever runs the server for one")
        })
    }
}
