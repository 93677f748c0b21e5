//! Encrypted connections. The certificates in `tests/tls` are for tests alone.

use std::path::{Path, PathBuf};

use relievo_client::{Address, Client, ClientOptions};
use relievo_server::{FluidKind, Server, ServerOptions};

use super::{DAM, client_options, options, scene, start};

/// An authority, and a certificate of it for `localhost` with its key, until 2126.
const AUTHORITY: &str = include_str!("../../../../tests/tls/authority.pem");
const CERTIFICATE: &str = include_str!("../../../../tests/tls/server.pem");
const KEY: &str = include_str!("../../../../tests/tls/server.key");

fn files(folder: &Path) -> [PathBuf; 3] {
    [("authority", AUTHORITY), ("certificate", CERTIFICATE), ("key", KEY)].map(|(name, text)| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    })
}

#[test]
fn clients_check_the_certificate_of_the_server() {
    let folder = tempfile::tempdir().unwrap();
    let [authority, certificate, key] = files(folder.path());
    let encryption = Some([certificate.clone(), key.clone()]);
    let server = start(ServerOptions { encryption, ..options(&folder.path().join("cache")) });
    let Address::Tcp { port, tls: true, .. } = *server.address() else { panic!("an encrypted server") };
    let connect = |host: &str, tls: bool, authorities: Option<&PathBuf>| {
        let address = Address::Tcp { host: host.into(), port, tls };
        let patience = std::time::Duration::from_millis(10);
        let options = ClientOptions { authorities: authorities.cloned(), patience, ..client_options(&address) };
        Client::connect(options)
    };
    let mut client = connect("localhost", true, Some(&authority)).unwrap();
    client.submit(&scene("dam", DAM)).unwrap();
    client.wait("dam", 6, &mut relievo_core::progress::Silent).unwrap();
    assert!(super::fetched(&mut client, "dam", 6) == super::local_frames(DAM)[6]);
    assert!(connect("localhost", true, None).is_err(), "nothing to check the certificate against");
    assert!(connect("localhost", true, Some(&certificate)).is_err(), "another authority");
    assert!(connect("127.0.0.1", true, Some(&authority)).is_err(), "a certificate of another name");
    assert!(connect("localhost", false, None).is_err(), "a client that does not encrypt");

    let wrong = [[key.clone(), key.clone()], [certificate.clone(), certificate.clone()], [authority, key]];
    for encryption in wrong {
        let options = ServerOptions { encryption: Some(encryption), ..options(&folder.path().join("other")) };
        assert!(Server::start(options, vec![Box::new(FluidKind::default())]).is_err());
    }
    // With tokens and encryption, others may connect.
    let tokens = folder.path().join("tokens");
    std::fs::write(&tokens, "anna a-token-of-anna-0001").unwrap();
    let listen = Address::Tcp { host: "0.0.0.0".into(), port: 0, tls: true };
    let encryption = Some([certificate, folder.path().join("key")]);
    let open = |tokens: Option<PathBuf>, encryption: Option<[PathBuf; 2]>| {
        let options =
            ServerOptions { listen: listen.clone(), tokens, encryption, ..options(&folder.path().join("open")) };
        Server::start(options, vec![Box::new(FluidKind::default())])
    };
    assert!(open(None, encryption.clone()).is_err() && open(Some(tokens.clone()), None).is_err());
    assert!(open(Some(tokens), encryption).is_ok());
}
