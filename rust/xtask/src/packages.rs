//! The Debian packages that are needed, and their installation.

use std::ffi::OsStr;
use std::io::{BufRead, IsTerminal, Write};
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

use crate::stage::{Outcome, call};

/// What scenes need.
pub const SCENE: &[&str] = &["g++", "libosd-dev", "libembree3-3"];

/// What the library and the `relievo` command need.
pub const BUILD: &[&str] = &["g++", "libosd-dev", "libembree3-3", "libopenmesh-dev"];

/// What tests and benches need besides: the peers, and the tools that build and check C and C++ hosts.
pub const ALL: &[&str] = &[
    "g++",
    "libosd-dev",
    "libembree3-3",
    "libopenmesh-dev",
    "libopenvdb-dev",
    "libboost-dev",
    "cmake",
    "ninja-build",
    "pkg-config",
    "valgrind",
    "python3-venv",
    "openimageio-tools",
    "libopenimageio-dev",
    "libembree-dev",
    "libclang1-14",
    "libclang-common-14-dev",
    "libtbb-dev",
    "abigail-tools",
    "python3-numpy",
    "blender",
    "dpkg-dev",
    "mmdebstrap",
    "povray",
    "libvulkan1",
    "libvulkan-dev",
    "mesa-vulkan-drivers",
    "xvfb",
    "xauth",
    // What windows load when they open.
    "libxkbcommon-x11-0",
    "libx11-xcb1",
    "libxcursor1",
    "libxi6",
    "openmpi-bin",
    "libopenmpi-dev",
    "slurmctld",
    "slurmd",
    "munge",
    "calculix-ccx",
];

/// What `cargo xtask bindings` needs: the headers of Embree, and the C parser with its own headers. `libclang-dev` has
/// these too, and 220 MB more.
pub const BINDINGS: &[&str] = &["libembree-dev", "libclang1-14", "libclang-common-14-dev"];

/// Package lists older than this are fetched again before an installation.
const STALE: Duration = Duration::from_secs(7 * 24 * 3600);

/// Installs what is missing of `packages`: as root at once, on a terminal through sudo after asking, which `yes`
/// answers. Elsewhere it fails and says what to type.
pub fn install(packages: &[&'static str], yes: bool) -> Outcome {
    if Command::new("dpkg-query").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_err() {
        return Err(format!(
            "this is not a Debian system, so packages cannot be installed for you; install what Debian 12 calls \
             {}, then use `cargo build --release` and `cargo test --release` directly",
            packages.join(" ")
        ));
    }
    let missing: Vec<_> = packages.iter().copied().filter(|name| !installed(name)).collect();
    if missing.is_empty() {
        println!("all Debian packages are there: {}", packages.join(" "));
        return Ok(());
    }
    let line = format!("apt-get install --no-install-recommends {}", missing.join(" "));
    println!("missing Debian packages; to install:\n\n    {line}\n");
    let prefix: &[&str] = match (is_root(), std::io::stdin().is_terminal()) {
        (true, _) => &[],
        (false, true) if yes || agreed()? => &["sudo"],
        (false, false) if yes => &["sudo", "--non-interactive"],
        _ => return Err(format!("packages are missing and nobody agreed to install them; run `sudo {line}`")),
    };
    let advise = |error| format!("{error}; install the packages yourself with `sudo {line}`, then come again");
    if stale()
        && let Err(error) = call(&mut apt(prefix, ["update"]))
    {
        eprintln!("warning: {error}; going on with the package lists that are there");
    }
    let arguments = ["install", "--yes", "--no-install-recommends"].into_iter().chain(missing.iter().copied());
    call(&mut apt(prefix, arguments)).map_err(advise)?;
    match missing.iter().find(|name| !installed(name)) {
        Some(name) => Err(format!("apt-get went well, but {name} is still not installed")),
        None => Ok(()),
    }
}

/// Whether all of `packages` are installed.
pub fn are_installed(packages: &[&str]) -> bool {
    packages.iter().all(|name| installed(name))
}

/// Whether this runs as root.
pub fn is_root() -> bool {
    std::fs::metadata("/proc/self").is_ok_and(|process| process.uid() == 0)
}

fn installed(package: &str) -> bool {
    let query = Command::new("dpkg-query")
        .args(["--show", "--showformat=${db:Status-Status}\n", package])
        .stderr(Stdio::null())
        .output();
    query.is_ok_and(|query| query.stdout.split(|byte| *byte == b'\n').any(|line| line == b"installed"))
}

fn agreed() -> Result<bool, String> {
    print!("Run this with sudo? [y/N] ");
    std::io::stdout().flush().map_err(|error| error.to_string())?;
    let mut answer = String::new();
    std::io::stdin().lock().read_line(&mut answer).map_err(|error| error.to_string())?;
    Ok(matches!(answer.trim(), "y" | "Y" | "yes"))
}

fn apt<S: AsRef<OsStr>>(prefix: &[&str], arguments: impl IntoIterator<Item = S>) -> Command {
    // `env` hands the variable through sudo, which clears the environment.
    let mut words = prefix.iter().copied().chain(["env", "DEBIAN_FRONTEND=noninteractive", "apt-get"]);
    let mut command = Command::new(words.next().unwrap_or("apt-get"));
    command.args(words).args(arguments);
    command
}

/// Whether the package lists are missing, as in fresh container images, or old.
fn stale() -> bool {
    let Ok(folder) = std::fs::read_dir(Path::new("/var/lib/apt/lists")) else { return true };
    let lists = folder.flatten().filter(|entry| entry.file_name().to_string_lossy().contains("_Packages"));
    let newest = lists.filter_map(|entry| entry.metadata().and_then(|data| data.modified()).ok()).max();
    let stamp = std::fs::metadata("/var/lib/apt/periodic/update-success-stamp").and_then(|data| data.modified()).ok();
    let Some(newest) = newest else { return true };
    let age = SystemTime::now().duration_since(stamp.map_or(newest, |stamp| stamp.max(newest)));
    age.is_ok_and(|age| age > STALE)
}
