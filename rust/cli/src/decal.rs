//! `relievo decal`

mod apply;
mod common;
mod info;
mod kept;
mod mesh;
mod picture;
mod remove;
mod texture;
mod update;

use clap::Subcommand;

use crate::Outcome;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Lays a sticker on a mesh and writes it as a mesh of its own with texture coordinates.
    Mesh(mesh::Arguments),
    /// Lays a sticker on a mesh and reports its distortion.
    Info(info::Arguments),
    /// Lays a sticker on the limit surface of a control cage and writes it into a layer of a document.
    Apply(apply::Arguments),
    /// Changes a decal of a document and writes its layer anew.
    Update(update::Arguments),
    /// Removes a decal of a document with its layer.
    Remove(remove::Arguments),
    /// Lays a sticker on a mesh with texture coordinates and paints it into the texture.
    Texture(texture::Arguments),
}

pub fn run(arguments: &Arguments) -> Outcome {
    match &arguments.task {
        Task::Mesh(arguments) => mesh::run(arguments),
        Task::Info(arguments) => info::run(arguments),
        Task::Apply(arguments) => apply::run(arguments),
        Task::Update(arguments) => update::run(arguments),
        Task::Remove(arguments) => remove::run(arguments),
        Task::Texture(arguments) => texture::run(arguments),
    }
}
