//! The server's side of TLS in a build without it: there is none.

use std::path::Path;

use relievo_core::{Error, Result};
use tokio::io::{AsyncRead, AsyncWrite};

/// A connection that is encrypted.
pub type Encrypted<S> = S;

/// The certificate and key of the server, which this build cannot have.
#[derive(Clone)]
pub enum Encryption {}

impl Encryption {
    /// Fails, since this build has no TLS.
    pub fn open(_: &Path, _: &Path) -> Result<Self> {
        Err(Error::unsupported("this server was built without TLS").advise("build it with the feature `tls`"))
    }

    /// Is never called.
    pub async fn accept<S: AsyncRead + AsyncWrite + Unpin>(&self, _: S) -> std::io::Result<Encrypted<S>> {
        match *self {}
    }
}
