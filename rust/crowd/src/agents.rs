//! Lists of agents as text, one agent a line, and point instancers of USD stages.
//!
//! A line has the place x y z, the heading in degrees about the y axis, the scale, the name or number of the clip, the
//! phase in seconds, the number of the model (0 if left out) and its speed in world units a second along its heading, the
//! model's z axis (0 if left out). What follows a `#` is a remark.

use std::fmt::Write;
use std::path::Path;

use glam::{DAffine3, DQuat, DVec3};
use relievo_core::{Context, Error, Result, file};
use relievo_meshio::PointInstancer;

use crate::crowd::{Agent, MAX_AGENTS};
use crate::hierarchy::CrowdModel;

/// An agent that walks straight on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walker {
    /// The agent at 0 seconds.
    pub agent: Agent,
    /// World units a second.
    pub velocity: DVec3,
}

impl Walker {
    /// Returns the agent where it is at `time` seconds.
    pub fn at(&self, time: f64) -> Agent {
        let transform = DAffine3::from_translation(self.velocity * time) * self.agent.transform;
        Agent { transform, ..self.agent }
    }
}

/// Reads a list of agents for some models, as they are at 0 seconds.
///
/// # Errors
/// As [`parse_walkers`].
pub fn parse_agents(text: &str, models: &[&CrowdModel]) -> Result<Vec<Agent>> {
    Ok(parse_walkers(text, models)?.into_iter().map(|walker| walker.agent).collect())
}

/// Reads a list of agents for some models, with their speeds.
///
/// # Errors
/// Names the line that has a wrong number of columns, a number that is not one, or a clip or model that does not exist.
pub fn parse_walkers(text: &str, models: &[&CrowdModel]) -> Result<Vec<Walker>> {
    let mut agents = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let columns: Vec<&str> = line.split_whitespace().collect();
        if columns.is_empty() {
            continue;
        }
        if agents.len() >= MAX_AGENTS {
            return Err(Error::unsupported(format!("a crowd has at most {MAX_AGENTS} agents")));
        }
        agents.push(agent(&columns, models).map_err(|error| error.at(format!("line {}", number + 1)))?);
    }
    Ok(agents)
}

/// Reads the agents of some models from a file: a list as text, or the point instancers of a USD stage. There the model of
/// a copy is the place of its prototype among all prototypes of the stage, the primvars `clip` and `phase` of an instancer
/// say what copies do, and velocities where they walk; lengths become metres and y becomes up.
///
/// # Errors
/// The file cannot be read, or as [`parse_walkers`].
pub fn read_walkers(context: &Context, path: &Path, models: &[&CrowdModel]) -> Result<Vec<Walker>> {
    let place = |error: Error| error.at(path.display().to_string());
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    if matches!(extension.as_deref(), Some("usd" | "usda" | "usdc")) {
        let instancers = relievo_meshio::read_point_instancers(context, path)?;
        return copied(&instancers, models).map_err(place);
    }
    let bytes = file::load(path, context.memory_limit())?;
    let text = String::from_utf8(bytes)
        .map_err(|_| place(Error::invalid("the list of agents is not text").advise("write it in UTF-8")))?;
    parse_walkers(&text, models).map_err(place)
}

/// Returns the copies of point instancers as agents.
fn copied(instancers: &[PointInstancer], models: &[&CrowdModel]) -> Result<Vec<Walker>> {
    let mut prototypes: Vec<&str> = Vec::new();
    let mut walkers = Vec::new();
    for instancer in instancers {
        let numbers: Vec<usize> = instancer
            .prototypes
            .iter()
            .map(|path| {
                prototypes.iter().position(|known| known == path).unwrap_or_else(|| {
                    prototypes.push(path);
                    prototypes.len() - 1
                })
            })
            .collect();
        for (number, copy) in instancer.copies.iter().enumerate() {
            let place = |error: Error| error.at(format!("copy {number}")).at(instancer.path.clone());
            let model = numbers[copy.prototype as usize];
            let found = models.get(model).ok_or_else(|| {
                place(
                    Error::invalid(format!("prototype {model} of the stage has no model"))
                        .advise("give a crowd model for every prototype, in their order"),
                )
            })?;
            if walkers.len() >= MAX_AGENTS {
                return Err(Error::unsupported(format!("a crowd has at most {MAX_AGENTS} agents")));
            }
            let clip = if copy.clip.is_empty() { 0 } else { clip_index(found, &copy.clip).map_err(place)? };
            let agent = Agent { model: model as u32, clip, phase: copy.phase, transform: copy.transform };
            walkers.push(Walker { agent, velocity: copy.velocity });
        }
    }
    match walkers.is_empty() {
        true => Err(Error::invalid("the stage has no point instancer with copies")
            .advise("export the crowd as a PointInstancer, or write a list of agents")),
        false => Ok(walkers),
    }
}

fn agent(columns: &[&str], models: &[&CrowdModel]) -> Result<Walker> {
    if !(7..=9).contains(&columns.len()) {
        return Err(Error::invalid(format!("an agent has 7 to 9 columns, not {}", columns.len()))
            .advise("write x y z heading scale clip phase [model [speed]]"));
    }
    let number = |at: usize| {
        let value = columns[at].parse::<f64>().ok().filter(|value| value.is_finite());
        value.ok_or_else(|| Error::invalid(format!("`{}` is not a number", columns[at])))
    };
    let model = match columns.get(7) {
        None => 0,
        Some(text) => text.parse().map_err(|_| Error::invalid(format!("`{text}` is not the number of a model")))?,
    };
    let found: &CrowdModel = models
        .get(model as usize)
        .ok_or_else(|| Error::invalid(format!("there is no model {model}")).advise("models count from 0"))?;
    let clip = clip_index(found, columns[5])?;
    let place = DVec3::new(number(0)?, number(1)?, number(2)?);
    let turn = DQuat::from_rotation_y(number(3)?.to_radians());
    let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(number(4)?), turn, place);
    let speed = if columns.len() > 8 { number(8)? } else { 0.0 };
    Ok(Walker { agent: Agent { model, clip, phase: number(6)?, transform }, velocity: turn * DVec3::Z * speed })
}

/// Returns the clip of a model with a name, or with a number counted from 0.
///
/// # Errors
/// There is no such clip; names the nearest.
pub fn clip_index(model: &CrowdModel, name: &str) -> Result<u32> {
    let named = model.clips.iter().position(|clip| clip.name == name);
    let numbered = || name.parse().ok().filter(|index| *index < model.clips.len());
    named.or_else(numbered).map(|index| index as u32).ok_or_else(|| {
        let error = Error::invalid(format!("there is no clip `{name}`"));
        match relievo_core::error::nearest(name, model.clips.iter().map(|clip| clip.name.as_str())) {
            Some(near) => error.advise(format!("did you mean `{near}`?")),
            None => error.advise("`relievo crowd info` lists the clips"),
        }
    })
}

/// Returns a list of agents as text: `count` of them on a square of the ground, `spacing` apart, each with its own
/// heading and phase, in the clips of a model in turn.
pub fn square(model: &CrowdModel, count: usize, spacing: f64) -> String {
    let side = (count as f64).sqrt().ceil().max(1.0) as usize;
    let mut text = String::from("# x y z heading scale clip phase\n");
    // A sequence that is spread evenly, by the golden ratio.
    let spread = |index: usize, factor: f64| (index as f64 * factor).fract();
    for index in 0..count {
        let place = |at: usize| (at as f64 - 0.5 * (side - 1) as f64) * spacing;
        let jitter = |factor: f64| 0.5 * spacing * (spread(index, factor) - 0.5);
        let (x, z) = (place(index % side) + jitter(0.754_877_666), place(index / side) + jitter(0.569_840_291));
        let heading = 360.0 * spread(index, 0.618_033_989);
        let scale = 0.9 + 0.2 * spread(index, 0.324_717_957);
        let clip = index % model.clips.len().max(1);
        let seconds = model.clips.get(clip).map_or(0.0, |clip| clip.poses.len() as f64 / f64::from(clip.rate));
        let phase = seconds * spread(index, 0.819_172_513);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{x:.3} 0 {z:.3} {heading:.1} {scale:.3} {clip} {phase:.3}");
    }
    text
}
