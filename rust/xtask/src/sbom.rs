//! The list of what is linked or carried (a software bill of materials), in SPDX 2.3, which `pyspdxtools` then validates.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::licences::{self, Package};
use crate::stage::{Outcome, call, output, target};
use crate::wheel;

/// The validator of the SPDX project.
const TOOLS: &str = "spdx-tools==0.8.3";
/// What Debian's licence fields, which name files and not expressions, are replaced by.
const UNKNOWN: &str = "NOASSERTION";

/// Writes the list, and fails if it is not valid.
pub fn write(path: &Path) -> Outcome {
    let mut packages = vec![own()];
    let mut relations = vec![relation("SPDXRef-DOCUMENT", "DESCRIBES", "SPDXRef-relievo")];
    for linked in licences::packages()? {
        let id = format!("SPDXRef-crate-{}-{}", plain(&linked.name), plain(&linked.version));
        relations.push(relation("SPDXRef-relievo", "DEPENDS_ON", &id));
        packages.push(of_crate(&id, &linked)?);
    }
    for name in wheel::carried() {
        let version = output(Command::new("dpkg-query").args(["--show", "--showformat=${Version}", name]))?;
        let id = format!("SPDXRef-debian-{}", plain(name));
        relations.push(relation("SPDXRef-relievo", "DEPENDS_ON", &id));
        packages.push(of_debian(&id, name, version.trim()));
    }
    let commit = output(Command::new("git").current_dir(crate::stage::root()).args(["rev-parse", "HEAD"]))?;
    let when = output(Command::new("git").current_dir(crate::stage::root()).args(["show", "-s", "--format=%ct"]))?;
    let when =
        output(Command::new("date").args(["--utc", "+%Y-%m-%dT%H:%M:%SZ", "--date"]).arg(format!("@{}", when.trim())))?;
    let version = env!("CARGO_PKG_VERSION");
    let document = json!({
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": format!("relievo-{version}"),
        "documentNamespace": format!("https://spdx.org/spdxdocs/relievo-{version}-{}", commit.trim()),
        "creationInfo": { "created": when.trim(), "creators": ["Tool: cargo-xtask-release"] },
        "packages": packages,
        "relationships": relations,
    });
    let text = serde_json::to_string_pretty(&document).map_err(|error| error.to_string())?;
    std::fs::write(path, text + "\n").map_err(|error| format!("{}: {error}", path.display()))?;
    let python = wheel::environment(&target().join("spdx"), &[TOOLS])?;
    call(Command::new(python.with_file_name("pyspdxtools")).arg("--infile").arg(path))
}

fn own() -> Value {
    json!({
        "SPDXID": "SPDXRef-relievo",
        "name": "relievo",
        "versionInfo": env!("CARGO_PKG_VERSION"),
        "downloadLocation": UNKNOWN,
        "licenseDeclared": "MIT OR Apache-2.0",
        "licenseConcluded": "MIT OR Apache-2.0",
        "copyrightText": UNKNOWN,
        "filesAnalyzed": false,
    })
}

fn of_crate(id: &str, linked: &Package) -> Result<Value, String> {
    let Package { name, version, .. } = linked;
    let licence = linked.canonical()?;
    Ok(json!({
        "SPDXID": id,
        "name": name,
        "versionInfo": version,
        "downloadLocation": format!("https://crates.io/api/v1/crates/{name}/{version}/download"),
        "licenseDeclared": licence,
        "licenseConcluded": licence,
        "copyrightText": UNKNOWN,
        "filesAnalyzed": false,
        "externalRefs": [reference(&format!("pkg:cargo/{name}@{version}"))],
    }))
}

fn of_debian(id: &str, name: &str, version: &str) -> Value {
    json!({
        "SPDXID": id,
        "name": name,
        "versionInfo": version,
        "downloadLocation": UNKNOWN,
        "licenseDeclared": UNKNOWN,
        "licenseConcluded": UNKNOWN,
        "copyrightText": UNKNOWN,
        "filesAnalyzed": false,
        "externalRefs": [reference(&format!("pkg:deb/debian/{name}@{version}?distro=bookworm"))],
    })
}

fn reference(locator: &str) -> Value {
    json!({ "referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": locator })
}

fn relation(from: &str, kind: &str, to: &str) -> Value {
    json!({ "spdxElementId": from, "relationshipType": kind, "relatedSpdxElement": to })
}

/// Returns a name with the characters that SPDX identifiers may have.
fn plain(name: &str) -> String {
    name.chars().map(|letter| if letter.is_ascii_alphanumeric() || letter == '.' { letter } else { '-' }).collect()
}
