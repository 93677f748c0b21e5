//! The imprints of a frame: colliders travel from their last place to their next in sub-steps so small that no point of
//! their boxes goes further than a quarter of the smallest edge, and are pressed in after each.
//!
//! Two deformable objects that press into each other take turns in every sub-step, the first giving way by its share
//! and the second by what is left (Schäfer et al. 2014, Real-Time Deformation of Subdivision Surfaces from Object
//! Collisions, Section 2).

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Error, Result};
use relievo_detail::{ImprintSettings, Imprinter, Moment, Report};

use crate::cache::{Block, Frame};
use crate::world::{Item, World};

/// Makes the imprints of frame after frame.
#[derive(Debug, Default)]
pub struct Baker {
    imprinter: Imprinter,
}

/// What a frame changed.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// Per object the tiles that changed, ascending.
    pub tiles: Vec<Vec<u32>>,
    /// Objects whose points moved.
    pub posed: Vec<usize>,
    /// What the imprints did, all together.
    pub report: Report,
}

/// A collider at work: who presses into whom.
#[derive(Clone, Copy, Debug)]
struct Pair {
    by: usize,
    into: usize,
    number: u32,
    settings: ImprintSettings,
}

/// Share of the smallest edge of a collider's box that its points may travel between imprints.
const TRAVEL: f64 = 0.25;
/// The share of the first of two deformable objects that press into each other, unless the scene says another.
const HALF: f32 = 0.5;

impl Changes {
    /// Per object the tiles that changed, or `None` where everything did, as pictures want it.
    pub fn for_pictures(&self) -> Vec<Option<&[u32]>> {
        let list = self.tiles.iter().enumerate();
        list.map(|(object, tiles)| (!self.posed.contains(&object)).then_some(tiles.as_slice())).collect()
    }
}

impl Baker {
    /// Presses the colliders in where they are at the beginning.
    pub fn start(&mut self, context: &Context, world: &mut World) -> Result<Changes> {
        let path = vec![world.transforms().to_vec()];
        self.frame(context, world, 0, &path)
    }

    /// Goes on from the frame before `frame`: moves the bodies and presses the colliders in on their way.
    pub fn advance(&mut self, context: &Context, world: &mut World, frame: u32) -> Result<Changes> {
        let mut path = vec![world.transforms().to_vec()];
        path.extend(context.stats().time("physics", || world.physics.advance()));
        self.frame(context, world, frame, &path)
    }

    fn frame(&mut self, context: &Context, world: &mut World, frame: u32, path: &[Vec<DAffine3>]) -> Result<Changes> {
        let mut changes = Changes::default();
        let now = world.scene.time(frame);
        let before = world.scene.time(frame.saturating_sub(1));
        {
            let _stage = context.stats().begin("imprint");
            for group in groups(world, now) {
                let steps = steps(context, world, &group, path, before, now)?;
                for step in 1..=steps {
                    let share = f64::from(step) / f64::from(steps);
                    let between: Vec<DAffine3> =
                        (0..world.items().len()).map(|object| along(path, object, share)).collect();
                    world.place(&between)?;
                    if world.is_animated() {
                        world.pose(context, before + (now - before) * share)?;
                    }
                    for pair in &group {
                        world.make_collider(context, pair.by)?;
                        let Some((surface, collider)) = world.pair(pair.into, pair.by) else { continue };
                        let moment = Moment { frame: u64::from(frame), step, pair: pair.number };
                        let report = self.imprinter.imprint(context, surface, collider, &pair.settings, moment)?;
                        if !report.changed.is_empty() {
                            world.forget_collider(pair.into);
                        }
                        changes.report.merge(report);
                    }
                }
            }
        }
        if let Some(last) = path.last() {
            world.place(last)?;
        }
        changes.posed = animated(world);
        world.pose(context, now)?;
        let _stage = context.stats().begin("commit");
        for object in 0..world.items().len() {
            let tiles = world.surface_mut(object).map_or_else(Vec::new, |surface| {
                // Taking it for writing also makes the object measure its reach anew, so that a frame does not depend
                // on whether the frames before were computed or opened.
                surface.displacement_mut().commit().changed().to_vec()
            });
            changes.tiles.push(tiles);
        }
        Ok(changes)
    }
}

/// The objects whose points move.
fn animated(world: &World) -> Vec<usize> {
    (0..world.items().len()).filter(|object| world.is_object_animated(*object)).collect()
}

/// The pairs at work at `time`: each alone, but two that press into each other together.
fn groups(world: &World, time: f64) -> Vec<Vec<Pair>> {
    let mut pairs: Vec<Pair> = Vec::new();
    let mut number = 0;
    for entry in &world.scene.colliders {
        for into in &entry.into {
            if entry.from <= time && time < entry.until {
                pairs.push(Pair { by: entry.object, into: *into, number, settings: entry.settings });
            }
            number += 1;
        }
    }
    let mut groups: Vec<Vec<Pair>> = Vec::new();
    for pair in pairs {
        let turned = |group: &&mut Vec<Pair>| matches!(group[..], [one] if one.by == pair.into && one.into == pair.by);
        match groups.iter_mut().find(turned) {
            Some(group) => {
                if group[0].settings.share == 1.0 {
                    group[0].settings.share = HALF;
                }
                group.push(pair);
            }
            None => groups.push(vec![pair]),
        }
    }
    groups
}

/// Where `object` is after a `share` of the way through `path`.
fn along(path: &[Vec<DAffine3>], object: usize, share: f64) -> DAffine3 {
    let place = share * (path.len() - 1) as f64;
    let before = (place.floor() as usize).min(path.len() - 1);
    let after = (before + 1).min(path.len() - 1);
    let share = place - before as f64;
    let (a, b) = (path[before][object], path[after][object]);
    if share <= 0.0 || a == b {
        return a;
    }
    let (scale_a, turn_a, at_a) = a.to_scale_rotation_translation();
    let (scale_b, turn_b, at_b) = b.to_scale_rotation_translation();
    DAffine3::from_scale_rotation_translation(
        scale_a.lerp(scale_b, share),
        turn_a.slerp(turn_b, share),
        at_a.lerp(at_b, share),
    )
}

/// How many imprints the way of a group takes.
fn steps(
    context: &Context,
    world: &mut World,
    group: &[Pair],
    path: &[Vec<DAffine3>],
    before: f64,
    now: f64,
) -> Result<u32> {
    let mut most = 1;
    for pair in group {
        let limit = pair.settings.sub_steps;
        let deformed = if world.is_object_animated(pair.by) && now > before {
            world.pose(context, now)?;
            let end = world.make_collider(context, pair.by)?.points().to_vec();
            world.pose(context, before)?;
            let start = world.make_collider(context, pair.by)?.points();
            let travel = end.iter().zip(start).map(|(a, b)| glam::Vec3::from(*a).distance((*b).into()));
            f64::from(travel.fold(0.0, f32::max))
        } else {
            0.0
        };
        let collider = world.make_collider(context, pair.by)?;
        let obb = *collider.object_obb();
        let scale = collider.transform().matrix3;
        let edge =
            (0..3).map(|axis| 2.0 * obb.half[axis] * (scale * obb.axes.col(axis)).length()).fold(f64::MAX, f64::min);
        let mut way = deformed * scale.x_axis.length().max(scale.y_axis.length()).max(scale.z_axis.length());
        for corner in 0..8 {
            let sign = DVec3::new(
                if corner & 1 == 0 { -1.0 } else { 1.0 },
                if corner & 2 == 0 { -1.0 } else { 1.0 },
                if corner & 4 == 0 { -1.0 } else { 1.0 },
            );
            let point = obb.center + obb.axes * (obb.half * sign);
            let mut travel = 0.0;
            for pose in path.windows(2) {
                // As seen from the surface, which may move itself.
                let carried = pose[1][pair.into] * pose[0][pair.into].inverse() * pose[0][pair.by];
                travel += (pose[1][pair.by].transform_point3(point) - carried.transform_point3(point)).length();
            }
            way = way.max(travel + deformed);
        }
        let wanted = (way / (edge * TRAVEL).max(1e-12)).ceil();
        most = most.max((wanted.clamp(1.0, f64::from(limit))) as u32);
    }
    Ok(most)
}

/// The blocks of the tiles in `changes`, for the cache; empty where a tile was given back.
pub fn blocks(context: &Context, world: &World, changes: &Changes) -> Result<Vec<Block>> {
    let list: Vec<(usize, u32)> = changes
        .tiles
        .iter()
        .enumerate()
        .flat_map(|(object, tiles)| tiles.iter().map(move |tile| (object, *tile)))
        .collect();
    let read = context.map(list.len(), |at| {
        let (object, tile) = list[at];
        let bytes = match world.items().get(object) {
            Some(Item::Surface(surface)) => surface.displacement().read(tile)?.unwrap_or_default(),
            _ => Vec::new(),
        };
        Ok(Block { object: object as u32, tile, bytes })
    });
    read.into_iter().collect()
}

/// Puts the world into the state of a baked `frame`, coming from the state of `since`. Fails if the frame does not fit
/// the scene.
pub fn restore(context: &Context, world: &mut World, frame: &Frame, since: Option<&Frame>) -> Result<Changes> {
    let misfit = |what: &str| {
        Error::invalid(format!("the cached frame {} does not fit the scene: {what}", frame.number))
            .advise("delete the cache and bake again")
    };
    if frame.transforms.len() != world.items().len() {
        return Err(misfit("it has other objects"));
    }
    let blocks = frame.read_since(context, since)?;
    let mut changes = Changes { tiles: vec![Vec::new(); world.items().len()], ..Changes::default() };
    for block in blocks {
        let surface = world.surface_mut(block.object as usize).ok_or_else(|| misfit("an object has no surface"))?;
        let bytes = (!block.bytes.is_empty()).then_some(block.bytes.as_slice());
        surface.displacement_mut().write(block.tile, bytes).map_err(|error| misfit(&error.to_string()))?;
        changes.tiles[block.object as usize].push(block.tile);
    }
    world.place(&frame.transforms)?;
    changes.posed = animated(world);
    world.pose(context, world.scene.time(frame.number))?;
    for object in 0..world.items().len() {
        if let Some(surface) = world.surface_mut(object) {
            surface.displacement_mut().commit();
        }
    }
    Ok(changes)
}
