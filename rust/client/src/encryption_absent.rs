//! The client's side of TLS in a build without it: there is none.

use std::net::TcpStream;
use std::path::Path;

use relievo_core::{Error, Result};

/// Fails, since this build has no TLS.
pub fn encrypt(_: TcpStream, _: &str, _: &Path) -> Result<TcpStream> {
    Err(Error::unsupported("this client was built without TLS").advise("build it with the feature `tls`"))
}
