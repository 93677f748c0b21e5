//! The imprints and strokes of a frame: colliders travel from their last place to their next in sub-steps so small that
//! no point of them goes further than a quarter of their box's smallest edge, and are pressed in after each. How far
//! they go is measured against the surface, which may move as well.
//!
//! Two deformable objects that press into each other take turns in every sub-step, the first giving way by its share
//! and the second by what is left (Schäfer et al. 2014, Real-Time Deformation of Subdivision Surfaces from Object
//! Collisions, Section 1).

use std::collections::BTreeSet;

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Error, Result};
use relievo_detail::overlap::overlap;
use relievo_detail::tool::{foremost, pressed};
use relievo_detail::{
    Collider, DecayingObject, Deformable, DisplacedObject, Grid, ImprintSettings, Imprinter, LayeredObject, Moment,
    Motion, Obb, Pose, Report, StrokeReport,
};

use crate::format::description::ToolEntry;
use crate::run::cache::{Block, Frame, Key, Layer};
use crate::run::laying;
use crate::run::refusals::Refusals;
use crate::run::riders;
use crate::run::row;
use crate::run::strokes;
use crate::run::treading;
use crate::run::way::{Pair, Way, settings_of};
use crate::state::blocks;
use crate::state::world::{Item, World};

/// Makes the imprints of frame after frame.
#[derive(Debug, Default)]
pub struct Simulator {
    imprinter: Imprinter,
}

/// What a frame changed.
#[derive(Clone, Debug, Default)]
pub struct Changes {
    /// Per object the blocks that changed, layer by layer and ascending.
    pub written: Vec<Vec<(Layer, u32)>>,
    /// Objects whose points moved.
    pub posed: Vec<usize>,
    /// What the imprints did, all together.
    pub report: Report,
    /// Tiles whose edits will not fade, because the budget has no room for their stamps.
    pub unstamped: u64,
    /// Tiles of layers that fade that made room for others.
    pub lost: u64,
    /// What the strokes did, all together.
    pub strokes: StrokeReport,
    /// Tiles that the budgets of the objects refused.
    pub refusals: Refusals,
}

/// What changed of an object in a frame.
#[derive(Clone, Debug, Default)]
pub struct Change {
    /// The tiles whose displacement or colours changed, ascending.
    pub tiles: Vec<u32>,
    /// Whether its points moved, so that all of it looks different.
    pub posed: bool,
}

/// Share of the smallest edge of a collider's box that its points may travel between imprints.
const TRAVEL: f64 = 0.25;
/// The share of the first of two deformable objects that press into each other, unless the scene says another.
const HALF: f32 = 0.5;

impl Changes {
    /// What changed of every object, as pictures want it.
    pub fn for_pictures(&self) -> Vec<Change> {
        let shown = |layer: Layer| matches!(layer, Layer::Displacement | Layer::Paint | Layer::Traces | Layer::Vectors);
        let list = self.written.iter().enumerate();
        list.map(|(object, written)| {
            let written = written.iter().filter(|(layer, _)| shown(*layer));
            let mut tiles: Vec<u32> = written.map(|(_, tile)| *tile).collect();
            tiles.sort_unstable();
            tiles.dedup();
            Change { tiles, posed: self.posed.contains(&object) }
        })
        .collect()
    }
}

impl Simulator {
    /// Presses the colliders in where they are at the beginning.
    ///
    /// # Errors
    /// Fails as [`Self::advance`].
    pub fn start(&mut self, context: &Context, world: &mut World) -> Result<Changes> {
        let path = vec![world.transforms().to_vec()];
        self.frame(context, world, 0, &path)
    }

    /// Goes on from the frame before `frame`: moves the bodies and presses the colliders in on their way.
    ///
    /// # Errors
    /// Fails with `Invalid` if an imprint, decal, stroke or brush cannot be made (a setting is out of range, a layer is
    /// hidden or does not exist, or a transform cannot be undone), as [`World::pose`] if an animated mesh cannot be
    /// posed, with `Memory` if memory does not suffice, and with `Io` if a page cannot be read back; a part of the
    /// changes is made then.
    pub fn advance(&mut self, context: &Context, world: &mut World, frame: u32) -> Result<Changes> {
        // Tools are not where they were placed but where they were pressed to, so that the bodies are asked.
        let mut path = vec![world.physics.transforms()];
        path.extend(context.stats().time("physics", || world.physics.advance()));
        self.frame(context, world, frame, &path)
    }

    fn frame(&mut self, context: &Context, world: &mut World, frame: u32, path: &[Vec<DAffine3>]) -> Result<Changes> {
        let mut changes = Changes::default();
        let now = world.scene.time(frame);
        let before = world.scene.time(frame.saturating_sub(1));
        let mut last = path.last().cloned().unwrap_or_default();
        world.advance(context, now)?;
        {
            let _stage = context.stats().begin("imprint");
            let way = Way { path, before, now, frame };
            let groups = groups(world, now);
            let mut rest = &groups[..];
            while let Some((group, more)) = rest.split_first() {
                let (row, after) =
                    rest.split_at(rest.iter().take_while(|group| row::is_plain(world, group, &way)).count());
                if row.len() > 1 {
                    for (into, report) in row::sweep(context, &mut self.imprinter, world, row, &way)? {
                        changes.refusals.add(into, &report.refused);
                        changes.report.merge(report);
                    }
                    rest = after;
                    continue;
                }
                rest = more;
                let report = match group[..] {
                    [one] if matches!(world.items().get(one.by), Some(Item::Mesh(_))) => {
                        let (report, pressed) = self.sweep(context, world, one, &way)?;
                        if let (Some(place), Some(pressed)) = (last.get_mut(one.by), pressed) {
                            *place = pressed;
                        }
                        changes.refusals.add(one.into, &report.refused);
                        report
                    }
                    _ => self.surfaces(context, world, group, &way, &mut changes.refusals)?,
                };
                changes.report.merge(report);
            }
            let Changes { report, refusals, .. } = &mut changes;
            treading::press(context, &mut self.imprinter, world, &way, (report, refusals))?;
        }
        world.place(&last)?;
        changes.posed = animated(world);
        world.pose(context, now)?;
        laying::make(context, world, frame, &mut changes.refusals)?;
        strokes::make(context, world, frame, &mut changes.strokes, &mut changes.refusals)?;
        riders::make(context, world, frame, path, &mut changes.strokes, &mut changes.refusals)?;
        let _stage = context.stats().begin("commit");
        for object in 0..world.items().len() {
            if let Some(item) = world.triangles_mut(object) {
                changes.refusals.add(object, &item.object.settle(context)?);
                changes.unstamped += item.object.stamp(context)?.len() as u64;
                changes.lost += item.object.take_lost();
                // What was lost changes what is seen.
                item.object.settle(context)?;
                changes.written.push(item.commit(context)?);
                continue;
            }
            let Some(surface) = world.surface_mut(object) else {
                changes.written.push(Vec::new());
                continue;
            };
            changes.refusals.add(object, &surface.settle(context)?);
            changes.unstamped += surface.stamp(context)?.len() as u64;
            changes.lost += surface.take_lost();
            // What was lost changes what is seen.
            surface.settle(context)?;
            changes.written.push(blocks::commit(surface));
        }
        Ok(changes)
    }

    /// Moves a mesh along its way and presses it into a surface. Returns also where a tool ends that a force presses
    /// in.
    fn sweep(
        &mut self,
        context: &Context,
        world: &mut World,
        pair: Pair,
        way: &Way,
    ) -> Result<(Report, Option<DAffine3>)> {
        if matches!(world.items().get(pair.into), Some(Item::Triangles(_))) {
            return Ok((self.sweep_triangles(context, world, pair, way)?, None));
        }
        // A tool follows the surface, so its place is looked for as often as there are any.
        let parts = if pair.tool.is_some() { way.steps() } else { way.parts(&pair) };
        let mut last = None;
        if world.is_object_animated(pair.into) || way.moves(pair.into) {
            return self.sweep_moving(context, world, pair, way, parts);
        }
        let settings = settings_of(&pair, parts);
        let mut report = Report::default();
        for part in 0..parts {
            let [start, end] = [part, part + 1].map(|part| f64::from(part) / f64::from(parts));
            let [from_points, to_points] = way.points(context, world, pair.by, [start, end])?;
            let mut ends = [way.at(pair.by, start), way.at(pair.by, end)];
            if let Some(tool) = &pair.tool {
                let before = press(context, world, &pair, tool, way, start)?;
                last = press(context, world, &pair, tool, way, end)?;
                let Some(after) = last else { continue };
                ends = [before.unwrap_or(after), after];
            }
            let Some((surface, collider)) = world.surface_and_collider(pair.into, pair.by) else { continue };
            let [from, to] = ends;
            let from = Pose { transform: from, points: from_points };
            let to = Pose { transform: to, points: to_points };
            let motion = Motion::new(collider, from, to)?;
            let moment = Moment { frame: u64::from(way.frame), step: part << 16, pair: pair.number };
            report.merge(self.imprinter.sweep(context, surface, collider, &motion, &settings, moment)?);
        }
        Ok((report, last))
    }

    /// Moves a mesh along its way, as a triangle mesh sees it, and presses it in. The triangle mesh is posed as often
    /// as its place is known.
    fn sweep_triangles(&mut self, context: &Context, world: &mut World, pair: Pair, way: &Way) -> Result<Report> {
        let animated = world.is_object_animated(pair.into);
        let parts = if animated || way.moves(pair.into) { way.steps() } else { way.parts(&pair) };
        let settings = settings_of(&pair, parts);
        let mut report = Report::default();
        for part in 0..parts {
            let [start, end] = [part, part + 1].map(|part| f64::from(part) / f64::from(parts));
            let [from_points, to_points] = way.points(context, world, pair.by, [start, end])?;
            if animated {
                world.pose(context, way.time(end))?;
            }
            let [old, target] = [start, end].map(|share| way.at(pair.into, share));
            let Some((object, collider)) = world.triangles_and_collider(pair.into, pair.by) else { break };
            object.set_transform(target)?;
            let from = Pose { transform: target * old.inverse() * way.at(pair.by, start), points: from_points };
            let to = Pose { transform: way.at(pair.by, end), points: to_points };
            let motion = Motion::new(collider, from, to)?;
            let moment = Moment { frame: u64::from(way.frame), step: part << 16, pair: pair.number };
            report.merge(self.imprinter.sweep(context, object, collider, &motion, &settings, moment)?);
        }
        Ok(report)
    }

    /// As [`Self::sweep`] where the surface moves too: what counts is how the mesh moves as the surface sees it. At
    /// every sub-step both are put where they are then, the surface in its pose.
    fn sweep_moving(
        &mut self,
        context: &Context,
        world: &mut World,
        pair: Pair,
        way: &Way,
        parts: u32,
    ) -> Result<(Report, Option<DAffine3>)> {
        let settings = &pair.settings;
        let mut report = Report::default();
        let mut last = None;
        let mut before_frame = None;
        let animated = world.is_object_animated(pair.into) || world.is_object_animated(pair.by);
        for part in 0..parts {
            let [start, end] = [part, part + 1].map(|part| f64::from(part) / f64::from(parts));
            let [old_target, target] = [start, end].map(|share| way.at(pair.into, share));
            let mut ends = [way.at(pair.by, start), way.at(pair.by, end)];
            if let Some(tool) = &pair.tool {
                let before = press(context, world, &pair, tool, way, start)?;
                last = press(context, world, &pair, tool, way, end)?;
                let Some(after) = last else { continue };
                // Without a place before, the tool comes straight to where it is pressed, and moves with the surface.
                ends = [before.unwrap_or(old_target * target.inverse() * after), after];
            }
            let [from_points, to_points] = way.points(context, world, pair.by, [start, end])?;
            let travel = cage_travel(context, world, pair.into, way, [start, end])?;
            let Some((surface, collider)) = world.surface_and_collider(pair.into, pair.by) else { continue };
            let from = Pose { transform: target * old_target.inverse() * ends[0], points: from_points };
            let to = Pose { transform: ends[1], points: to_points };
            let motion = Motion::new(collider, from, to)?;
            collider.set_pose(context, &motion.at(1.0))?;
            let collider_box = collider.obb();
            if before_frame.is_none() && settings.depth_limit < ImprintSettings::default().depth_limit {
                before_frame = Some(surface.displacement().field().clone());
            }
            if animated {
                world.pose(context, way.time(end))?;
            }
            // Where the two cannot meet, nothing needs to be posed more often.
            let Some(surface) = world.surface_mut(pair.into) else { continue };
            surface.set_transform(target)?;
            let reach = bounds(surface, settings).enlarged(motion.travel() + travel);
            let wanted = if reach.overlaps(&collider_box) { motion.sub_steps_against(travel) } else { 1 };
            let steps = wanted.min(settings.sub_steps);
            report.sub_steps_wanted += u64::from(wanted);
            for step in 1..=steps {
                let within = f64::from(step) / f64::from(steps);
                let share = start + (end - start) * within;
                if animated {
                    world.pose(context, way.time(share))?;
                }
                let Some((surface, collider)) = world.surface_and_collider(pair.into, pair.by) else { break };
                let place = way.at(pair.into, share);
                let seen = motion.at(within).transform;
                let pressed = place * target.inverse() * seen;
                surface.set_transform(place)?;
                collider.set_transform(if pair.tool.is_some() { pressed } else { way.at(pair.by, share) })?;
                let moment = Moment { frame: u64::from(way.frame), step: (part << 16) + step - 1, pair: pair.number };
                let start = before_frame.as_ref();
                report.merge(self.imprinter.imprint_since(context, surface, collider, settings, moment, start)?);
            }
        }
        Ok((report, last))
    }

    /// Moves surfaces along their way and presses one into the other, or both into each other.
    fn surfaces(
        &mut self,
        context: &Context,
        world: &mut World,
        group: &[Pair],
        way: &Way,
        refusals: &mut Refusals,
    ) -> Result<Report> {
        let mut report = Report::default();
        let Some(first) = group.first() else { return Ok(report) };
        let travel = cage_travel(context, world, first.into, way, [0.0, 1.0])?
            + cage_travel(context, world, first.by, way, [0.0, 1.0])?;
        let wanted = group.iter().map(|pair| surface_steps(world, *pair, way, travel)).max().unwrap_or(1);
        let wanted = if near(context, world, first, way, travel)? { wanted } else { 1 };
        let steps = wanted.min(first.settings.sub_steps);
        report.sub_steps_wanted = u64::from(wanted);
        for step in 1..=steps {
            let share = f64::from(step) / f64::from(steps);
            if world.is_animated() {
                world.pose(context, way.time(share))?;
            }
            let (a, b) = (first.into, first.by);
            let (place_a, place_b) = (way.at(a, share), way.at(b, share));
            let Some([(object_a, cage_a), (object_b, cage_b)]) = world.two_surfaces(a, b) else { continue };
            object_a.set_transform(place_a)?;
            object_b.set_transform(place_b)?;
            let moment = Moment { frame: u64::from(way.frame), step: step - 1, pair: first.number };
            if let [first, second] = group {
                let mut one = Deformable { object: object_a, cage: cage_a, settings: first.settings };
                let mut other = Deformable { object: object_b, cage: cage_b, settings: second.settings };
                let [dents, other_dents] = self.imprinter.collide(context, &mut one, &mut other, moment)?;
                refusals.add(a, &dents.refused);
                refusals.add(b, &other_dents.refused);
                report.merge(dents);
                report.merge(other_dents);
            } else if let Some(collider) = tessellated(context, object_a, object_b, cage_b, &first.settings)? {
                let dents = self.imprinter.imprint(context, object_a, &collider, &first.settings, moment)?;
                refusals.add(a, &dents.refused);
                report.merge(dents);
            }
        }
        // However many imprints a step took: none where the two do not meet, two where both give way.
        report.sub_steps = u64::from(steps);
        Ok(report)
    }
}

/// Where a tool is after a `share` of the way when its force presses it into the surface it comes upon; `None` if it
/// comes upon none.
fn press(
    context: &Context,
    world: &mut World,
    pair: &Pair,
    tool: &ToolEntry,
    way: &Way,
    share: f64,
) -> Result<Option<DAffine3>> {
    let points = world.moving_points(context, pair.by, way.time(share))?;
    if world.is_object_animated(pair.into) {
        world.pose(context, way.time(share))?;
    }
    let Some((surface, collider)) = world.surface_and_collider(pair.into, pair.by) else { return Ok(None) };
    surface.set_transform(way.at(pair.into, share))?;
    collider.set_pose(context, &Pose { transform: way.at(pair.by, share), points: points.map(Into::into) })?;
    let front = foremost(collider, tool.force);
    let Some(contact) = surface.met_by_line(context, front, tool.force) else { return Ok(None) };
    pressed(collider, contact.point, contact.normal, tool.force.length(), &tool.settings).map(Some)
}

/// How far the points of an object's mesh or cage go in a part of the way, in world units, its transform aside. No
/// point of the limit surface goes further.
fn cage_travel(context: &Context, world: &mut World, object: usize, way: &Way, shares: [f64; 2]) -> Result<f64> {
    let [Some(before), Some(after)] = way.points(context, world, object, shares)? else { return Ok(0.0) };
    let scale = shares.map(|share| {
        let map = way.at(object, share).matrix3;
        map.to_cols_array().iter().map(|value| value * value).sum::<f64>().sqrt()
    });
    let ways = before.iter().zip(&*after).map(|(a, b)| {
        let way: [f64; 3] = std::array::from_fn(|axis| f64::from(b[axis]) - f64::from(a[axis]));
        DVec3::from(way).length()
    });
    Ok(ways.fold(0.0, f64::max) * scale[0].max(scale[1]))
}

/// The box of a surface with all displacement that an imprint may leave it with.
fn bounds(surface: &mut DisplacedObject, settings: &ImprintSettings) -> Obb {
    let [inward, outward] = surface.reach();
    surface.obb(f64::from(outward.max(-inward).max(settings.max_displacement)))
}

/// Whether two surfaces, whose points go up to `travel` besides, may meet on their way.
fn near(context: &Context, world: &mut World, pair: &Pair, way: &Way, travel: f64) -> Result<bool> {
    if world.is_animated() {
        world.pose(context, way.now)?;
    }
    let Some([(into, _), (by, _)]) = world.two_surfaces(pair.into, pair.by) else { return Ok(false) };
    into.set_transform(way.at(pair.into, 1.0))?;
    by.set_transform(way.at(pair.by, 1.0))?;
    let (into, by) = (bounds(into, &pair.settings), bounds(by, &pair.settings));
    let corners = by.corners();
    // As the first surface sees the second, in its place at the end.
    let end = [pair.into, pair.by].map(|object| way.at(object, 1.0));
    let back = end[1].inverse();
    let farthest = corners.into_iter().map(|corner| {
        let point = back.transform_point3(corner);
        let seen = way.path.iter().map(|pose| end[0] * pose[pair.into].inverse() * pose[pair.by]);
        seen.map(|place| (place.transform_point3(point) - corner).length()).fold(0.0, f64::max)
    });
    Ok(into.enlarged(farthest.fold(0.0, f64::max) + travel).overlaps(&by))
}

/// How many imprints the way of a surface takes, by the corners of its box, where points of the two surfaces move by
/// `travel` besides.
fn surface_steps(world: &World, pair: Pair, way: &Way, travel: f64) -> u32 {
    let Some(Item::Surface(surface)) = world.items().get(pair.by) else { return 1 };
    let obb = surface.obb(0.0);
    let to_object = surface.transform().inverse();
    let edge = 2.0 * obb.half.min_element().max(0.05 * obb.half.max_element());
    let farthest = obb
        .corners()
        .into_iter()
        .map(|corner: DVec3| {
            let point = to_object.transform_point3(corner);
            let travel = |pose: &[Vec<DAffine3>]| {
                // As seen from the other surface, which may move itself.
                let carried = pose[1][pair.into] * pose[0][pair.into].inverse() * pose[0][pair.by];
                (pose[1][pair.by].transform_point3(point) - carried.transform_point3(point)).length()
            };
            way.path.windows(2).map(travel).sum()
        })
        .fold(0.0, f64::max);
    ((farthest + travel) / (edge * TRAVEL).max(1e-12)).ceil().clamp(1.0, 65536.0) as u32
}

/// The surface `by` as a collider for `into`, finer than a voxel where they meet; `None` if they do not.
fn tessellated(
    context: &Context,
    into: &mut DisplacedObject,
    by: &mut DisplacedObject,
    cage: &relievo_core::Mesh,
    settings: &ImprintSettings,
) -> Result<Option<Collider>> {
    let [least, most] = into.reach().map(f64::from);
    let least = least.min(f64::from(-settings.max_displacement));
    let [inward, outward] = by.reach().map(f64::from);
    let boxes = (into.obb(most.max(-least)), by.obb(outward.max(-inward)));
    let Some(both) = overlap(&boxes.0, &boxes.1) else { return Ok(None) };
    let Some(both) = into.occupied(context, &both, least, most) else { return Ok(None) };
    let edge = Grid::new(&both, u64::from(settings.voxels), None).size.min_element();
    context.stats().time("imprint.tessellate", || Collider::of_object(context, by, cage, &both, edge)).map(Some)
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
                let (by, into) = (entry.object, *into);
                pairs.push(Pair { by, into, number, settings: entry.settings, tool: entry.tool });
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

/// The blocks of the tiles in `changes`, for the cache; empty where a tile was given back.
///
/// # Errors
/// Fails with `Invalid` if a block of `changes` does not exist, and with `Io`, `Invalid` or `Memory` if it is on a page
/// that cannot be read back.
pub fn blocks(context: &Context, world: &World, changes: &Changes) -> Result<Vec<Block>> {
    let list: Vec<(usize, Layer, u32)> = (0..)
        .zip(&changes.written)
        .flat_map(|(object, written)| written.iter().map(move |(layer, tile)| (object, *layer, *tile)))
        .collect();
    let read = context.map(list.len(), |at| {
        let (object, layer, tile) = list[at];
        let bytes = match world.items().get(object) {
            Some(Item::Surface(surface)) => blocks::read(surface, layer, tile)?,
            Some(Item::Triangles(item)) => item.read(layer, tile)?,
            _ => None,
        };
        Ok(Block { object: object as u32, layer, tile, bytes: bytes.unwrap_or_default() })
    });
    read.into_iter().collect()
}

/// All blocks there are.
fn allocated(world: &World) -> Vec<Key> {
    let lists = (0..).zip(world.items()).filter_map(|(object, item)| match item {
        Item::Surface(surface) => Some((object, blocks::allocated(surface))),
        Item::Triangles(item) => Some((object, item.allocated())),
        Item::Mesh(_) => None,
    });
    lists.flat_map(|(object, list)| list.into_iter().map(move |(layer, tile)| (object, layer, tile))).collect()
}

/// Puts the world into the state of a baked `frame`, coming from the state of `since`.
///
/// # Errors
/// Fails with `Invalid` if the frame does not fit the scene, as [`Frame::read_since`] if it cannot be read, and as
/// [`World::pose`] if an animated mesh cannot be posed; a part of the frame may be put back then.
pub fn restore(context: &Context, world: &mut World, frame: &Frame, since: Option<&Frame>) -> Result<Changes> {
    let misfit = |what: &str| {
        Error::invalid(format!("the cached frame {} does not fit the scene: {what}", frame.number))
            .advise("delete the cache and bake again")
    };
    if frame.transforms.len() != world.items().len() {
        return Err(misfit("it has other objects"));
    }
    let mut blocks = frame.read_since(context, since)?;
    if since.is_none() {
        // What documents brought and the frame no longer has.
        let there: BTreeSet<_> = frame.blocks().collect();
        let brought = allocated(world).into_iter().filter(|key| !there.contains(key));
        blocks.extend(brought.map(|(object, layer, tile)| Block { object, layer, tile, bytes: Vec::new() }));
    }
    // Tiles that are given back make room in the budget for others, and sizes come before what has them.
    let sizes_first = |block: &Block| (!block.bytes.is_empty(), block.object, block.layer != Layer::Sizes);
    blocks.sort_by_key(|block| (sizes_first(block), block.layer, block.tile));
    let mut changes = Changes { written: vec![Vec::new(); world.items().len()], ..Changes::default() };
    for block in blocks {
        let object = block.object as usize;
        let bytes = (!block.bytes.is_empty()).then_some(block.bytes.as_slice());
        let done = if let Some(item) = world.triangles_mut(object) {
            item.write(block.layer, block.tile, bytes)
        } else {
            let surface = world.surface_mut(object).ok_or_else(|| misfit("an object has no surface"))?;
            blocks::write(surface, block.layer, block.tile, bytes)
        };
        done.map_err(|error| misfit(&error.to_string()))?;
        changes.written[object].push((block.layer, block.tile));
    }
    changes.written.iter_mut().for_each(|written| written.sort_unstable());
    world.place(&frame.transforms)?;
    let now = world.scene.time(frame.number);
    changes.posed = animated(world);
    world.pose(context, now)?;
    world.set_time(now)?;
    for surface in world.surfaces_mut() {
        surface.settle(context)?;
        surface.take_as_stamped();
        blocks::commit(surface);
    }
    for object in 0..world.items().len() {
        if let Some(item) = world.triangles_mut(object) {
            item.object.settle(context)?;
            item.object.take_as_stamped();
            item.commit(context)?;
        }
    }
    Ok(changes)
}
