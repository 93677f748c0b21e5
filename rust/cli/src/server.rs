//! `relievo server`

mod cache;
pub mod connection;
mod control;
mod fetch;
mod log;
mod run;
mod signals;
mod status;
mod steer;
mod submit;
mod watch;

use clap::Subcommand;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Simulates for other programs and machines, until it is asked to stop.
    Run(run::Arguments),
    /// Sends a fluid to a server, which simulates it in the background.
    Submit(submit::Arguments),
    /// Says what the scenes on a server are doing.
    Status(status::Arguments),
    /// Shows the progress of a scene on a server until it is done.
    Watch(watch::Arguments),
    /// Fetches frames from a server, also while later ones are computed.
    Fetch(fetch::Arguments),
    /// Changes a scene on a server from a frame on.
    Steer(steer::Arguments),
    /// Pauses, resumes, cancels or removes a scene on a server.
    Control(control::Arguments),
    /// Lists, checks, shrinks and exports the cache of a server.
    Cache(cache::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Run(arguments) => run::run(arguments),
        Task::Submit(arguments) => submit::run(arguments),
        Task::Status(arguments) => status::run(arguments),
        Task::Watch(arguments) => watch::run(arguments),
        Task::Fetch(arguments) => fetch::run(arguments),
        Task::Steer(arguments) => steer::run(arguments),
        Task::Control(arguments) => control::run(arguments),
        Task::Cache(arguments) => cache::run(arguments),
    }
}
