//! Crowds that press into surfaces: agents near a surface are posed and pressed in one after another, in parts of the frame
//! that each take them from one pose of their clip to the next.

use glam::DAffine3;
use relievo_core::{Context, Result};
use relievo_detail::{ImprintSettings, Imprinter, Moment, Obb, Report};

use crate::run::refusals::Refusals;
use crate::run::way::{Way, part_of};
use crate::state::world::{Item, World};

/// Presses all crowds that press at the end of the way. Surfaces that move are placed, and posed, at the end of each part,
/// and what they carry with them counts for no motion of the agents.
///
/// # Errors
/// Fails as an imprint does, and with `Invalid` if a pose or a place of an agent or a surface cannot be used.
pub(crate) fn press(
    context: &Context,
    imprinter: &mut Imprinter,
    world: &mut World,
    way: &Way,
    (report, refusals): (&mut Report, &mut Refusals),
) -> Result<()> {
    let mut number = world.scene.colliders.iter().map(|entry| entry.into.len() as u32).sum::<u32>();
    for entry in 0..world.scene.crowd_colliders.len() {
        let collider = &world.scene.crowd_colliders[entry];
        let is_at_work = collider.from <= way.now && way.now < collider.until;
        let (settings, objects) = (collider.settings, collider.into.clone());
        let agents = world.crowd_that_presses(entry).map_or(0, |(crowd, _)| crowd.len() as u32);
        for into in objects {
            if is_at_work {
                let one = Tread { entry, into, number, settings };
                let found = tread(context, imprinter, world, one, way)?;
                refusals.add(into, &found.refused);
                report.merge(found);
            }
            number = number.wrapping_add(agents);
        }
    }
    Ok(())
}

/// A crowd and what it presses into.
#[derive(Clone, Copy)]
struct Tread {
    entry: usize,
    into: usize,
    /// Number of the first agent among all that press.
    number: u32,
    settings: ImprintSettings,
}

fn tread(
    context: &Context,
    imprinter: &mut Imprinter,
    world: &mut World,
    Tread { entry, into, number, settings }: Tread,
    way: &Way,
) -> Result<Report> {
    let mut report = Report::default();
    let animated = world.is_object_animated(into);
    let moves = animated || way.moves(into);
    let poses = world.crowd_that_presses(entry).map_or(1, |(crowd, how)| how.parts(crowd, way.now - way.before));
    let parts = if moves { poses.max(way.steps()) } else { poses };
    let settings = part_of(&settings, parts);
    for part in 0..parts {
        let [start, end] = [part, part + 1].map(|part| f64::from(part) / f64::from(parts));
        if animated {
            world.pose(context, way.time(end))?;
        }
        let target = way.at(into, end);
        let carried = if moves { target * way.at(into, start).inverse() } else { DAffine3::IDENTITY };
        let times = [start, end].map(|share| way.time(share));
        let Some((item, crowd, how)) = world.item_and_crowd(into, entry) else { continue };
        let Some(bounds) = placed(item, target, &settings)? else { continue };
        for agent in 0..crowd.len() {
            let is_near = how.reach(crowd, agent, times, &carried).is_some_and(|reach| reach.overlaps(&bounds));
            if !is_near {
                continue;
            }
            let (mut collider, motion) = how.motion(context, (crowd, agent), times, &carried)?;
            let pair = number.wrapping_add(agent as u32);
            let moment = Moment { frame: u64::from(way.frame), step: part << 16, pair };
            report.merge(match item {
                Item::Surface(surface) => {
                    imprinter.sweep(context, &mut **surface, &mut collider, &motion, &settings, moment)?
                }
                Item::Triangles(item) => {
                    imprinter.sweep(context, &mut item.object, &mut collider, &motion, &settings, moment)?
                }
                Item::Mesh(_) => Report::default(),
            });
        }
    }
    Ok(report)
}

/// Places a surface and returns the box around it with all displacement that an imprint may leave it with.
fn placed(item: &mut Item, transform: DAffine3, settings: &ImprintSettings) -> Result<Option<Obb>> {
    let margin = |[inward, outward]: [f32; 2]| f64::from(outward.max(-inward).max(settings.max_displacement));
    Ok(match item {
        Item::Surface(surface) => {
            surface.set_transform(transform)?;
            let reach = surface.reach();
            Some(surface.obb(margin(reach)))
        }
        Item::Triangles(item) => {
            item.object.set_transform(transform)?;
            let reach = item.object.reach();
            Some(item.object.obb(margin(reach)))
        }
        Item::Mesh(_) => None,
    })
}
