//! Batch scripts of Slurm (<https://slurm.schedmd.com/sbatch.html>): a job for each stage, an array of jobs where chunks of
//! frames run in parallel, and dependencies between them.

use super::plan::{FRAMES, Plan, Stage};
use super::{File, SUBMIT, quoted};

/// Returns a batch script for each stage, and the script that submits them.
pub fn files(plan: &Plan) -> Vec<File> {
    let scripts = plan.stages.iter().map(|stage| File { name: file(stage), text: script(plan, stage) });
    scripts.chain([File { name: SUBMIT.into(), text: submit(plan) }]).collect()
}

fn file(stage: &Stage) -> String {
    format!("{}.sbatch", stage.name)
}

fn script(plan: &Plan, stage: &Stage) -> String {
    let Plan { name, first, last, chunk, threads, .. } = plan;
    let mut text = format!("#!/bin/bash\n#SBATCH --job-name={name}-{}\n", stage.name);
    // A task that was stopped goes on from its last frame.
    text += "#SBATCH --requeue\n";
    if *threads > 0 {
        text += &format!("#SBATCH --cpus-per-task={threads}\n");
    }
    if stage.parallel {
        // Numbers of chunks, as clusters bound the numbers of an array (MaxArraySize).
        text += &format!("#SBATCH --array=0-{}\n#SBATCH --output={}-%a.log\n", plan.chunks() - 1, stage.name);
        text += &format!("first=$(({first} + SLURM_ARRAY_TASK_ID * {chunk}))\n");
        text += &format!("last=$((first + {chunk} - 1 < {last} ? first + {chunk} - 1 : {last}))\n");
    } else {
        text += &format!("#SBATCH --output={}.log\n", stage.name);
    }
    let words = stage.command.iter().map(|word| match word == FRAMES {
        true => "\"$first..$last\"".to_owned(),
        false => quoted(word),
    });
    text + "exec " + &words.collect::<Vec<_>>().join(" ") + "\n"
}

fn submit(plan: &Plan) -> String {
    let mut text =
        "#!/bin/sh\n# Submits the stages of the job and prints their numbers.\nset -eu\ncd \"$(dirname \"$0\")\"\n"
            .to_owned();
    for stage in &plan.stages {
        let after: String = stage.after.iter().map(|name| format!(":\"${{{name}%%;*}}\"")).collect();
        let depends = match after.is_empty() {
            true => String::new(),
            // Without the second, a stage whose needs have failed would wait for ever.
            false => format!(" --dependency=afterok{after} --kill-on-invalid-dep=yes"),
        };
        let name = stage.name;
        text += &format!("{name}=$(sbatch --parsable{depends} {})\necho \"{name} ${name}\"\n", file(stage));
    }
    text
}
