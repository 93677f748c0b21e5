//! The pairs of a frame whose meshes keep their points and whose surfaces stay as and where they are: on a graphics device
//! consecutive pairs are submitted together, on surfaces and on triangle meshes.

use std::collections::BTreeSet;

use relievo_core::{Context, Result};
use relievo_detail::{Collider, ImprintSettings, Imprinter, Moment, Motion, Pose, Report, Sweep};

use crate::run::way::{Pair, Way, settings_of};
use crate::state::world::{Item, World};

/// Whether it is a mesh that keeps its points, on a way of its own, and a surface that stays as and where it is.
pub(crate) fn is_plain(world: &World, group: &[Pair], way: &Way) -> bool {
    let [pair] = group else { return false };
    let [by, into] = [pair.by, pair.into].map(|object| world.items().get(object));
    let kinds = matches!((by, into), (Some(Item::Mesh(_)), Some(Item::Surface(_) | Item::Triangles(_))));
    let animated = [pair.by, pair.into].into_iter().any(|object| world.is_object_animated(object));
    kinds && pair.tool.is_none() && !animated && !way.moves(pair.into)
}

/// A part of a mesh's way through a frame.
struct Part {
    pair: Pair,
    /// Which part of the pair's it is, and which of all.
    part: u32,
    number: usize,
    /// Which of the colliders it is.
    collider: usize,
    motion: Motion,
    settings: ImprintSettings,
}

/// Moves meshes along their ways, one after another, and presses them into surfaces that stay where they are. Returns which
/// was pressed into and what was done, in the order of the pairs.
pub(crate) fn sweep(
    context: &Context,
    imprinter: &mut Imprinter,
    world: &mut World,
    groups: &[Vec<Pair>],
    way: &Way,
) -> Result<Vec<(usize, Report)>> {
    let pairs: Vec<Pair> = groups.iter().flatten().copied().collect();
    let by: BTreeSet<usize> = pairs.iter().map(|pair| pair.by).collect();
    let into: BTreeSet<usize> = pairs.iter().map(|pair| pair.into).collect();
    // No pair depends on those of other objects.
    let is_triangles = |object: &usize| matches!(world.items().get(*object), Some(Item::Triangles(_)));
    let (meshes, tiled): (BTreeSet<usize>, BTreeSet<usize>) = into.into_iter().partition(is_triangles);
    let (mut objects, mut colliders) = world.surfaces_and_colliders(&tiled, &by);
    let on_tiled = parts(&pairs, &tiled, &by, &colliders, way)?;
    let motions = sweeps(&on_tiled, &tiled, way);
    let made = imprinter.sweep_all(context, &mut objects, &mut colliders, &motions)?;
    let (mut objects, mut colliders) = world.triangles_and_colliders(&meshes, &by);
    let on_meshes = parts(&pairs, &meshes, &by, &colliders, way)?;
    let motions = sweeps(&on_meshes, &meshes, way);
    let made = made.into_iter().chain(imprinter.sweep_all(context, &mut objects, &mut colliders, &motions)?);
    let of = on_tiled.iter().chain(&on_meshes).map(|part| (part.number, part.pair.into));
    let mut all: Vec<((usize, usize), Report)> = of.zip(made).collect();
    all.sort_by_key(|((number, _), _)| *number);
    Ok(all.into_iter().map(|((_, into), report)| (into, report)).collect())
}

/// Where an object is among some.
fn place(set: &BTreeSet<usize>, object: usize) -> usize {
    set.range(..object).count()
}

/// The parts of the ways of those `pairs` that press into one of the objects `into`, by one of `by`, the `colliders`.
fn parts(
    pairs: &[Pair],
    into: &BTreeSet<usize>,
    by: &BTreeSet<usize>,
    colliders: &[&mut Collider],
    way: &Way,
) -> Result<Vec<Part>> {
    let mut all = Vec::new();
    for (number, pair) in pairs.iter().enumerate().filter(|(_, pair)| into.contains(&pair.into)) {
        let parts = way.parts(pair);
        let collider = place(by, pair.by);
        for part in 0..parts {
            let [from, to] = [part, part + 1].map(|part| f64::from(part) / f64::from(parts));
            let [from, to] = [from, to].map(|share| Pose::rigid(way.at(pair.by, share)));
            let motion = Motion::new(&*colliders[collider], from, to)?;
            all.push(Part { pair: *pair, part, number, collider, motion, settings: settings_of(pair, parts) });
        }
    }
    Ok(all)
}

/// The motions of parts of ways, where the objects are `into`.
fn sweeps<'a>(parts: &'a [Part], into: &BTreeSet<usize>, way: &Way) -> Vec<Sweep<'a>> {
    let sweep = |part: &'a Part| Sweep {
        into: place(into, part.pair.into),
        by: part.collider,
        motion: &part.motion,
        settings: &part.settings,
        moment: Moment { frame: u64::from(way.frame), step: part.part << 16, pair: part.pair.number },
    };
    parts.iter().map(sweep).collect()
}
