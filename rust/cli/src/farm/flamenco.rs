//! Jobs of Flamenco 3 (<https://flamenco.blender.org/usage/job-types/>): a job type that the Manager compiles to tasks, and a
//! job of it as its API takes it (`SubmittedJob` of flamenco-openapi.yaml).

use relievo_core::{Error, Result};
use serde_json::json;

use super::plan::Plan;
use super::{File, SUBMIT};

/// The job type, which is named after its file.
const JOB_TYPE: &str = include_str!("relievo.js");

/// This platform as Flamenco, in Go, calls it.
const PLATFORM: &str = if cfg!(target_os = "macos") { "darwin" } else { std::env::consts::OS };

const SUBMIT_TEXT: &str = "\
#!/bin/sh
# Submits the job to the Flamenco Manager at $FLAMENCO_MANAGER. Its folder `scripts` needs relievo.js, which lies beside this.
set -eu
exec curl --fail --silent --show-error --header 'Content-Type: application/json' \\
    --data-binary \"@$(dirname \"$0\")/job.json\" \"${FLAMENCO_MANAGER:-http://localhost:8080}/api/v3/jobs\"
";

/// Returns the job type, the job, and the script that submits it.
pub fn files(plan: &Plan) -> Result<Vec<File>> {
    let failed = |error: serde_json::Error| Error::internal(error.to_string());
    let job = json!({
        "name": plan.name,
        "type": "relievo",
        "priority": 50,
        "submitter_platform": PLATFORM,
        // Settings are numbers and texts, so the stages are a text.
        "settings": { "plan": serde_json::to_string(plan).map_err(failed)? },
        "metadata": { "project": plan.name },
    });
    let file = |name: &str, text: String| File { name: name.into(), text };
    Ok(vec![
        file("relievo.js", JOB_TYPE.into()),
        file("job.json", format!("{job:#}\n")),
        file(SUBMIT, SUBMIT_TEXT.into()),
    ])
}
