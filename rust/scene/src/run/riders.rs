//! Brushes of a scene that ride on objects, such as feet and wheels, and leave a dab where they
//! touch a surface.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 3:
//! brushes are attached to parts of objects, and where those touch another object the edit is made. What a frame makes
//! follows from where its objects go in it and from the surface, and from nothing that was before, so that a run can go
//! on from any baked frame.

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Error, Result};
use relievo_detail::{Station, StrokeReport};

use crate::format::description::RiderEntry;
use crate::run::refusals::Refusals;
use crate::run::strokes::add;
use crate::state::world::World;

/// Makes the dabs of `frame`, in which the objects go along `path`, on the surfaces as they now are, and adds what was
/// done and refused.
pub(crate) fn make(
    context: &Context,
    world: &mut World,
    frame: u32,
    path: &[Vec<DAffine3>],
    done: &mut StrokeReport,
    refusals: &mut Refusals,
) -> Result<()> {
    let now = world.scene.time(frame);
    for index in 0..world.scene.riders.len() {
        let entry = world.scene.riders[index].clone();
        let [from, until] = entry.time;
        let way: Vec<DAffine3> = path.iter().filter_map(|pose| pose.get(entry.by)).copied().collect();
        let Some(start) = way.first().filter(|_| (from..=until).contains(&now)) else { continue };
        let mut brush = entry.brush.clone();
        brush.stamp = entry.stamp.and_then(|stamp| world.stamp(stamp, &brush.action).cloned());
        let mut surfaces = world.canvases(&entry.objects);
        let within = f64::from(brush.settings.radius) * f64::from(brush.settings.reach);
        let starts = surfaces.iter_mut().map(|surface| surface.begin(context)).collect::<Result<Vec<_>>>()?;
        let mut kept = Vec::new();
        {
            let touches = |point: DVec3| -> Result<bool> {
                surfaces.iter().zip(&starts).try_fold(false, |found, (surface, start)| {
                    Ok(found || surface.nearest(context, start, point, within)?.is_some())
                })
            };
            let mut touched = frame > 0 && touches(start.transform_point3(entry.place))?;
            for station in stations(&entry, &way, frame) {
                let touching = touches(station.position)?;
                if touching && !(entry.once && touched) {
                    kept.push(station);
                }
                touched = touching;
            }
        }
        let place = |error: Error| error.at(format!("brush {}", index + 1));
        let made = context.stats().time("stroke", || brush.apply_stations(context, &mut surfaces, &kept));
        add(done, refusals, &entry.objects, made.map_err(place)?);
    }
    Ok(())
}

/// Where the brush may touch in a frame, in which what it rides on takes the poses `way`: at the end of each part of
/// the way if it leaves one dab each time, else at even distances of at most its spacing. In the first frame, where it
/// is.
fn stations(entry: &RiderEntry, way: &[DAffine3], frame: u32) -> Vec<Station> {
    let places: Vec<DVec3> = way.iter().map(|pose| pose.transform_point3(entry.place)).collect();
    let station = |segment: usize, share: f64, index: usize| {
        let (from, to) = (places[segment], places[(segment + 1).min(places.len() - 1)]);
        let direction = match way[segment].transform_vector3(entry.along).try_normalize() {
            Some(along) => along,
            None => (to - from).normalize_or_zero(),
        };
        let index = frame.wrapping_mul(MAX as u32).wrapping_add(index as u32);
        Station { position: from + (to - from) * share, pressure: 1.0, direction, index }
    };
    if places.len() < 2 {
        return vec![station(0, 0.0, 0)];
    }
    let lengths: Vec<f64> = places.windows(2).map(|pair| pair[0].distance(pair[1])).collect();
    if entry.once {
        return (0..lengths.len()).map(|segment| station(segment, 1.0, segment)).collect();
    }
    let step = f64::from(entry.brush.settings.radius) * f64::from(entry.brush.settings.spacing);
    let length: f64 = lengths.iter().sum();
    // What rests does not touch anew.
    let count = if length > 1e-6 * step { (length / step).ceil().min(MAX as f64) as usize } else { 0 };
    let (mut segment, mut gone) = (0, 0.0);
    let at = |k: usize| {
        let wanted = length * (k + 1) as f64 / count as f64;
        while segment + 1 < lengths.len() && gone + lengths[segment] < wanted {
            gone += lengths[segment];
            segment += 1;
        }
        station(segment, ((wanted - gone) / lengths[segment].max(1e-300)).clamp(0.0, 1.0), k)
    };
    (0..count).map(at).collect()
}

/// Most dabs of a brush in a frame.
const MAX: usize = 4096;
