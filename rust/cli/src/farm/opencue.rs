//! Outlines of OpenCue (<https://docs.opencue.io/docs/developer-guide/>): a layer for each stage, whose frames Cuebot dispatches in chunks.

use super::plan::{FRAMES, Plan, Stage};
use super::{File, SUBMIT, quoted};

/// What Cuebot replaces by the first and the last frame of a chunk.
const CHUNK: &str = "#FRAME_START#..#FRAME_END#";

/// Returns the outline, and the script that launches it.
pub fn files(plan: &Plan) -> Vec<File> {
    let submit = "#!/bin/sh\n# Launches the job with PyOutline, on the Cuebot at $CUEBOT_HOSTS, in the show $SHOW and the shot $SHOT.\n\
        set -eu\nexec python3 \"$(dirname \"$0\")/job.py\"\n";
    vec![File { name: "job.py".into(), text: outline(plan) }, File { name: SUBMIT.into(), text: submit.into() }]
}

fn outline(plan: &Plan) -> String {
    let mut text = format!(
        "\"\"\"Launches the job {name} on OpenCue.\"\"\"\n\nimport os\n\nimport outline\nimport outline.cuerun\nfrom outline.modules.shell import Shell\n\n\
         job = outline.Outline({name}, show=os.environ.get(\"SHOW\", \"testing\"), shot=os.environ.get(\"SHOT\", {name}))\n",
        name = text_literal(&plan.name)
    );
    for stage in &plan.stages {
        text += &layer(plan, stage);
    }
    text + "outline.cuerun.launch(job, use_pycuerun=False)\n"
}

fn layer(plan: &Plan, stage: &Stage) -> String {
    // Cuebot joins the words by spaces and gives them to a shell.
    let words =
        stage.command.iter().map(|word| text_literal(&if word == FRAMES { CHUNK.to_owned() } else { quoted(word) }));
    let words = words.collect::<Vec<_>>().join(", ");
    let Plan { first, last, chunk, threads, .. } = plan;
    let range = match stage.parallel {
        true => format!("range=\"{first}-{last}\", chunk={chunk}"),
        false => format!("range=\"{first}-{first}\""),
    };
    let cores = if *threads > 0 { format!(", cores={threads}, overrideCores=True") } else { String::new() };
    let name = stage.name;
    let mut text = format!("\n{name} = Shell(\"{name}\", command=[{words}], {range}{cores})\n");
    for before in &stage.after {
        text += &format!("{name}.depend_all({before})\n");
    }
    text + &format!("job.add_layer({name})\n")
}

/// Returns a literal of Python for a text: JSON's are literals of Python.
fn text_literal(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
