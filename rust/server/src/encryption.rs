//! TLS by rustls: the server's side.

use std::path::Path;
use std::sync::Arc;

use relievo_core::{Error, Result, file};
use rustls::ServerConfig;
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio_rustls::TlsAcceptor;

/// Bytes of a file of certificates or of a key at most.
const LONGEST: u64 = 1 << 20;

/// A connection that is encrypted.
pub type Encrypted<S> = tokio_rustls::server::TlsStream<S>;

/// The certificate and key of the server.
#[derive(Clone)]
pub struct Encryption(TlsAcceptor);

impl Encryption {
    /// Reads a chain of certificates, the server's own first, and its key, both in PEM. Fails where they cannot be read or do
    /// not fit each other.
    pub fn open(certificates: &Path, key: &Path) -> Result<Self> {
        let refused = |path: &Path, what: String| Err(Error::invalid(what).at(path.display().to_string()));
        let chain: std::result::Result<Vec<_>, _> =
            CertificateDer::pem_slice_iter(&file::load(certificates, LONGEST)?).collect();
        let chain = match chain {
            Ok(chain) if !chain.is_empty() => chain,
            _ => return refused(certificates, "it has no certificates in PEM".into()),
        };
        let Ok(private) = PrivateKeyDer::from_pem_slice(&file::load(key, LONGEST)?) else {
            return refused(key, "it has no private key in PEM".into());
        };
        let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .and_then(|config| config.with_no_client_auth().with_single_cert(chain, private));
        match config {
            Ok(config) => Ok(Self(TlsAcceptor::from(Arc::new(config)))),
            Err(error) => refused(certificates, format!("certificate and key cannot be used: {error}")),
        }
    }

    /// Agrees on keys with a client.
    pub async fn accept<S: AsyncRead + AsyncWrite + Unpin>(&self, stream: S) -> std::io::Result<Encrypted<S>> {
        self.0.accept(stream).await
    }
}
