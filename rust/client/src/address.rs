//! Where a server listens: `host:port`, `tls://host:port` or `unix:/path`.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use relievo_core::{Error, Result};

/// The port that a server listens on where none is given.
pub const PORT: u16 = 7350;

/// The address of a server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A host and a port over TCP.
    Tcp {
        /// A name or an IP address.
        host: String,
        /// The port.
        port: u16,
        /// Whether the connection is encrypted by TLS.
        tls: bool,
    },
    /// A Unix socket.
    Unix(PathBuf),
}

impl Default for Address {
    fn default() -> Self {
        Self::Tcp { host: "127.0.0.1".into(), port: PORT, tls: false }
    }
}

impl FromStr for Address {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let refused = |what: &str| {
            Error::invalid(format!("{what} in the address {text:?}"))
                .advise("use host:port, tls://host:port or unix:/path")
        };
        if let Some(path) = text.strip_prefix("unix:") {
            return match path {
                "" => Err(refused("there is no path")),
                path => Ok(Self::Unix(path.into())),
            };
        }
        let (tls, rest) = match text.strip_prefix("tls://") {
            Some(rest) => (true, rest),
            None => (false, text.strip_prefix("tcp://").unwrap_or(text)),
        };
        // An IPv6 address is in brackets, so that its colons are not taken for that of the port.
        let (host, port) = match rest.strip_prefix('[') {
            Some(rest) => {
                let (host, rest) = rest.split_once(']').ok_or_else(|| refused("a bracket is not closed"))?;
                (host, rest.strip_prefix(':'))
            }
            None => match rest.split_once(':') {
                Some((host, port)) => (host, Some(port)),
                None => (rest, None),
            },
        };
        let port = port.map_or(Ok(PORT), |port| port.parse().map_err(|_| refused("the port is not a number")))?;
        match host {
            "" => Err(refused("there is no host")),
            host => Ok(Self::Tcp { host: host.into(), port, tls }),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unix(path) => write!(out, "unix:{}", path.display()),
            Self::Tcp { host, port, tls } => {
                let scheme = if *tls { "tls://" } else { "" };
                match host.contains(':') {
                    true => write!(out, "{scheme}[{host}]:{port}"),
                    false => write!(out, "{scheme}{host}:{port}"),
                }
            }
        }
    }
}
