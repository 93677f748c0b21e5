//! The server that a command connects to, and how the status of its scenes is printed.

use std::path::{Path, PathBuf};

use relievo_client::{Activity, Address, Client, ClientOptions, Status};
use relievo_core::{Error, Result, file};
use serde_json::{Value, json};

/// The server that a command connects to.
#[derive(clap::Args)]
pub struct Connection {
    /// The server: host:port, tls://host:port or unix:/path.
    #[arg(long, value_name = "ADDRESS", default_value_t = Address::default())]
    server: Address,
    /// A file with the certificates, in PEM, of the authority that the certificate of a server at tls://host:port is
    /// checked against.
    #[arg(long, value_name = "FILE")]
    tls_authority: Option<PathBuf>,
    /// A file with your token, where the server wants one.
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
}

/// Bytes of a file with a token at most.
const LONGEST: u64 = 4096;

impl Connection {
    /// Connects to the server.
    pub fn client(&self) -> Result<Client> {
        let token = token(self.token_file.as_deref())?;
        let address = self.server.clone();
        // Somebody who types an address wants to hear soon that there is nobody.
        let patience = std::time::Duration::from_secs(5);
        let authorities = self.tls_authority.clone();
        Client::connect(ClientOptions { address, token, authorities, patience, ..ClientOptions::default() })
    }
}

/// Reads the token in a file; without one it is empty.
pub fn token(path: Option<&Path>) -> Result<String> {
    let Some(path) = path else { return Ok(String::new()) };
    let text = String::from_utf8(file::load(path, LONGEST)?);
    let unfit = |_| Error::invalid("the token is not text").at(path.display().to_string());
    Ok(text.map_err(unfit)?.trim().to_owned())
}

/// Returns the word for what a scene is doing.
fn word(state: Activity) -> &'static str {
    match state {
        Activity::Running => "running",
        Activity::Forces => "waiting for forces",
        Activity::Paused => "paused",
        Activity::Done => "done",
        Activity::Cancelled => "cancelled",
        Activity::Failed => "failed",
    }
}

/// Returns a status for programs.
pub fn value(status: &Status) -> Value {
    json!({
        "scene": status.scene,
        "state": word(status.state),
        "ready": status.ready,
        "frames": status.frames,
        "fraction": status.fraction,
        "seconds_left": status.seconds_left,
        "particles": status.particles,
        "error": status.error.as_ref().map(|error| Error::from(error.clone()).to_string()),
    })
}

/// Returns a status as a line.
pub fn line(status: &Status) -> String {
    let mut line = format!(
        "{}: {}, {} of {} frames, {} particles",
        status.scene,
        word(status.state),
        status.ready,
        status.frames,
        status.particles
    );
    if let Some(seconds) = status.seconds_left.filter(|_| status.state == Activity::Running) {
        line += &format!(", about {seconds:.0} s left");
    }
    if let Some(error) = &status.error {
        line += &format!("\n  {}", Error::from(error.clone()));
    }
    line + "\n"
}

/// Prints a status.
pub fn print(status: &Status, json: bool) -> Result<()> {
    crate::print(&if json { format!("{:#}\n", value(status)) } else { line(status) })
}
