//! The stages of a farm job: their commands, and the stages that each waits for.

use std::path::Path;

use clap::ValueEnum;
use serde::Serialize;

/// Stands for the first and the last frame of a chunk, `A..B`, in the command of a stage.
pub const FRAMES: &str = "{frames}";

/// What is made of the frames of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Product {
    /// Meshes of the surface.
    Mesh,
    /// Spray, foam and bubbles.
    Foam,
    /// Pictures, with the foam where it is made.
    Render,
}

/// Options of the commands of a job, each a list of arguments.
#[derive(Clone, Debug, Default)]
pub struct Extra {
    pub simulate: Vec<String>,
    pub mesh: Vec<String>,
    pub foam: Vec<String>,
    pub render: Vec<String>,
}

/// A job: stages over frames.
#[derive(Debug, Serialize)]
pub struct Plan {
    pub name: String,
    pub first: u32,
    /// The last frame, included.
    pub last: u32,
    /// Frames of a task at most.
    pub chunk: u32,
    /// Threads of a task; 0 for all cores of a machine.
    pub threads: u32,
    /// In an order in which each comes after the stages that it needs.
    pub stages: Vec<Stage>,
}

/// A command over all frames, or over chunks of them in parallel.
#[derive(Debug, Serialize)]
pub struct Stage {
    pub name: &'static str,
    /// The program and its arguments; [`FRAMES`] stands for the frames of a chunk.
    pub command: Vec<String>,
    /// Whether chunks of frames are tasks of their own.
    pub parallel: bool,
    /// Stages that must have succeeded.
    pub after: Vec<&'static str>,
}

impl Plan {
    /// Returns the stages that make `products` of a description in `folder`. Paths are absolute, so that tasks run anywhere.
    pub fn stages(
        program: &str,
        [description, folder]: [&Path; 2],
        products: &[Product],
        threads: u32,
        extra: &Extra,
    ) -> Vec<Stage> {
        let path = |name: &str| folder.join(name).display().to_string();
        let (frames, foam) = (path("frames"), path("foam"));
        let has = |product| products.contains(&product);
        let command = |words: &[&str], options: &[String]| -> Vec<String> {
            let threads = ["--threads".to_owned(), threads.to_string()];
            let threads = threads.into_iter().take(if threads_are_given(options) { 0 } else { 2 });
            std::iter::once(program)
                .chain(words.iter().copied())
                .map(str::to_owned)
                .chain(threads)
                .chain(options.iter().cloned())
                .collect()
        };
        let mut stages = vec![Stage {
            name: "simulate",
            command: command(&["fluid", "sim", &description.display().to_string(), "-o", &frames], &extra.simulate),
            parallel: false,
            after: Vec::new(),
        }];
        if has(Product::Mesh) {
            stages.push(Stage {
                name: "mesh",
                command: command(&["fluid", "mesh", &frames, "-o", &path("meshes"), "--frames", FRAMES], &extra.mesh),
                parallel: true,
                after: vec!["simulate"],
            });
        }
        if has(Product::Foam) {
            stages.push(Stage {
                name: "foam",
                command: command(&["foam", "generate", &frames, "-o", &foam], &extra.foam),
                parallel: false,
                after: vec!["simulate"],
            });
        }
        if has(Product::Render) {
            let pictures = path("pictures");
            let [of_foam, of_fluid]: [&[&str]; 2] = [
                &["foam", "render", &foam, "--fluid", &frames, "-o", &pictures, "--frames", FRAMES],
                &["fluid", "render", &frames, "-o", &pictures, "--frames", FRAMES],
            ];
            let with_foam = has(Product::Foam);
            stages.push(Stage {
                name: "render",
                command: command(if with_foam { of_foam } else { of_fluid }, &extra.render),
                parallel: true,
                after: vec![if with_foam { "foam" } else { "simulate" }],
            });
        }
        stages
    }

    /// Returns how many chunks of frames there are.
    pub fn chunks(&self) -> u32 {
        (self.last - self.first) / self.chunk + 1
    }
}

/// Whether options of a command set its threads themselves.
fn threads_are_given(options: &[String]) -> bool {
    options.iter().any(|option| option == "--threads" || option.starts_with("--threads="))
}
