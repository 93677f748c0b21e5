//! TLS by rustls: the client's side.

use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;

use relievo_core::{Error, Result, file};
use rustls::crypto::ring;
use rustls::pki_types::pem::PemObject;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};

/// Bytes of a file of certificates at most.
const LONGEST: u64 = 1 << 20;

/// Encrypts a connection to the server called `host`, whose certificate is checked against those of the authorities in a
/// file, in PEM. Fails where the file has none.
pub fn encrypt(stream: TcpStream, host: &str, authorities: &Path) -> Result<StreamOwned<ClientConnection, TcpStream>> {
    let refused = |what: String| Error::invalid(what).at(authorities.display().to_string());
    let mut roots = RootCertStore::empty();
    for certificate in CertificateDer::pem_slice_iter(&file::load(authorities, LONGEST)?) {
        let added = certificate.map_err(|error| error.to_string());
        let added = added.and_then(|certificate| roots.add(certificate).map_err(|error| error.to_string()));
        added.map_err(|error| refused(format!("a certificate cannot be used: {error}")))?;
    }
    if roots.is_empty() {
        return Err(refused("it has no certificates in PEM".into()));
    }
    let name = ServerName::try_from(host.to_owned());
    let name = name.map_err(|_| Error::invalid(format!("{host:?} is no name that a certificate could have")))?;
    let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .map_err(|error| Error::internal(error.to_string()))?
        .with_root_certificates(roots)
        .with_no_client_auth();
    let connection =
        ClientConnection::new(Arc::new(config), name).map_err(|error| Error::internal(error.to_string()))?;
    Ok(StreamOwned::new(connection, stream))
}
