//! Colliders of a description: at rest, on their way from key to key, or in the shapes of numbered files.

use std::path::Path;

use glam::{Quat, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_fluid::ColliderOptions;
use relievo_scene::sequence::Pattern;
use serde::Deserialize;

use crate::entries::contact;
use crate::files::Source;
use crate::shape::{Ball, Corners, MeshFile, Shape};

/// A mesh that fluid does not pass.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Collider {
    mesh: Option<MeshFile>,
    #[serde(rename = "box")]
    corners: Option<Corners>,
    sphere: Option<Ball>,
    /// Numbered files with the same points and triangles, one a frame.
    sequence: Option<MeshFile>,
    /// The number of the file of the first frame.
    #[serde(default)]
    first: u64,
    /// How many files there are; the last one stays.
    count: Option<u64>,
    #[serde(default)]
    container: bool,
    contact: Option<String>,
    friction: Option<f32>,
    #[serde(default)]
    pivot: [f32; 3],
    #[serde(default)]
    keys: Vec<Key>,
}

/// Where a collider is at a time.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    /// Seconds since the beginning.
    time: f64,
    /// By how many metres it has moved.
    #[serde(default = "zero", rename = "move")]
    moved: [f32; 3],
    /// By how much it has turned about its pivot: an axis as long as the angle in radians.
    #[serde(default = "zero")]
    turn: [f32; 3],
}

fn zero() -> [f32; 3] {
    [0.0; 3]
}

/// A collider on its way.
pub struct Mover {
    pub points: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub options: ColliderOptions,
    pivot: Vec3,
    keys: Vec<Key>,
    /// The files of its frames, if it changes its shape, and how many there are in a second.
    shapes: Vec<MeshFile>,
    files: Source,
    fps: f64,
}

/// Files of a sequence at most.
const MAX: u64 = 1 << 20;
/// Times nearer to a frame than this share of it are those of the frame.
const NEAR: f64 = 1e-6;

impl Collider {
    /// It on its way; `files` finds what it names, and there are so many frames in a second.
    pub fn mover(&self, context: &Context, files: &Source, fps: f64) -> Result<Mover> {
        let shapes = self.numbered()?;
        let shape = Shape { mesh: self.mesh.as_ref(), corners: self.corners.as_ref(), sphere: self.sphere.as_ref() };
        let (points, triangles) = match shapes.first() {
            Some(_) if shape.mesh.is_some() || shape.corners.is_some() || shape.sphere.is_some() => {
                return Err(Error::invalid("it has more than one shape")
                    .advise("give it one of mesh, box, sphere and sequence"));
            }
            Some(first) => first.triangles(context, files)?,
            None => shape.triangles(context, files)?,
        };
        let contact = contact(self.contact.as_deref(), self.friction)?;
        let is_sound = |key: &Key| key.time.is_finite() && key.moved.iter().chain(&key.turn).all(|at| at.is_finite());
        if !self.keys.iter().all(is_sound) || self.keys.windows(2).any(|pair| pair[0].time >= pair[1].time) {
            return Err(Error::invalid("times of keys do not increase, or a number is not finite").at("keys"));
        }
        let options = ColliderOptions { contact, is_container: self.container };
        let (pivot, keys) = (self.pivot.into(), self.keys.clone());
        let mover = Mover { points, triangles, options, pivot, keys, shapes, files: files.clone(), fps };
        // A file that does not fit is reported before anything is simulated.
        (1..mover.shapes.len()).try_for_each(|frame| mover.shape(context, frame).map(drop))?;
        Ok(mover)
    }

    /// Returns how many files its sequence has.
    pub fn count(&self) -> u64 {
        self.count.unwrap_or(0)
    }

    /// The meshes that it is read from.
    pub fn meshes(&self) -> Result<Vec<MeshFile>> {
        Ok(self.numbered()?.into_iter().chain(self.mesh.clone()).collect())
    }

    /// The files of its sequence.
    fn numbered(&self) -> Result<Vec<MeshFile>> {
        let Some(sequence) = &self.sequence else {
            if self.count.is_some() || self.first != 0 {
                return Err(Error::invalid("it has no sequence").advise("leave first and count out"));
            }
            return Ok(Vec::new());
        };
        let pattern = Pattern::new(&sequence.file).map_err(|error| error.at("sequence"))?;
        match self.count {
            Some(count @ 1..=MAX) => {
                let file = |frame: u64| sequence.with(pattern.path(self.first.saturating_add(frame)));
                Ok((0..count).map(file).collect())
            }
            _ => Err(Error::invalid("how many files the sequence has is not said, or too many")
                .at("count")
                .advise(format!("say 1 to {MAX}"))),
        }
    }
}

impl Mover {
    /// Whether it is elsewhere, or has another shape, at another time.
    pub fn is_moving(&self) -> bool {
        self.keys.len() > 1 || self.is_changing()
    }

    /// Whether it has another shape at another time.
    pub fn is_changing(&self) -> bool {
        self.shapes.len() > 1
    }

    /// Its points in a frame of the sequence. Fails where the file has others, or other triangles.
    fn shape(&self, context: &Context, frame: usize) -> Result<Vec<Vec3>> {
        let file = &self.shapes[frame];
        let (points, triangles) = file.triangles(context, &self.files)?;
        if points.len() != self.points.len() || triangles != self.triangles {
            let what = format!(
                "it has {} points and {} triangles, and the first file {} and {}, or they are joined in another way",
                points.len(),
                triangles.len(),
                self.points.len(),
                self.triangles.len()
            );
            return Err(Error::invalid(what)
                .at(self.files.path(Path::new(&file.file))?.display().to_string())
                .advise("export all frames of one mesh, whose points move and nothing else"));
        }
        Ok(points)
    }

    /// How it is turned about the origin at a time in seconds, and moved then: straight from key to key, turned by the
    /// shortest way.
    pub fn pose(&self, time: f64) -> (Quat, Vec3) {
        let after = self.keys.partition_point(|key| key.time <= time);
        let pose = |key: &Key| (Vec3::from(key.moved), Quat::from_scaled_axis(Vec3::from(key.turn)));
        let (moved, turn) = match (after.checked_sub(1).map(|at| &self.keys[at]), self.keys.get(after)) {
            (Some(last), Some(next)) => {
                let share = ((time - last.time) / (next.time - last.time)) as f32;
                let ([a, b], [from, to]) = ([pose(last).0, pose(next).0], [pose(last).1, pose(next).1]);
                (a.lerp(b, share), from.slerp(to, share))
            }
            (Some(key), None) | (None, Some(key)) => pose(key),
            (None, None) => (Vec3::ZERO, Quat::IDENTITY),
        };
        (turn, self.pivot - turn * self.pivot + moved)
    }

    /// Where its points are at a time in seconds: of a sequence, on straight lines from file to file.
    pub fn at(&self, context: &Context, time: f64) -> Result<Vec<Vec3>> {
        let (turn, moved) = self.pose(time);
        let placed = |points: &[Vec3]| points.iter().map(|point| turn * *point + moved).collect();
        if !self.is_changing() {
            return Ok(placed(&self.points));
        }
        let frame = (time * self.fps).clamp(0.0, (self.shapes.len() - 1) as f64);
        let (before, share) = ((frame + NEAR).floor(), frame - (frame + NEAR).floor());
        let mut points = self.shape(context, before as usize)?;
        if share > NEAR {
            let after = self.shape(context, before as usize + 1)?;
            points.iter_mut().zip(&after).for_each(|(point, after)| *point = point.lerp(*after, share as f32));
        }
        Ok(placed(&points))
    }
}
