//! The layers of a document on another mesh: every texel of the new tiles takes what the nearest place of the old
//! surface has, without its displacement.
//!
//! Places whose surface faces away do not count, so that the two sides of a thin wall do not mix. Displacements are
//! given the coefficients whose values at the centres of texels are the old ones; vectors are turned from the old frame
//! into the new. Areas are in square object units.

mod triangles;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use glam::{Mat3, Vec3};
use half::f16;
use relievo_core::progress::Silent;
use relievo_core::simd::Level;
use relievo_core::{Context, Error, Mesh, Progress, Result};
use relievo_document::{Document, Head, Kind};
use relievo_surface::{Grid, Order, Place, Placement, Samples, Surface, SurfaceOptions};
use relievo_tiles::texel::Vector;
use relievo_tiles::{
    Blocks, Channel, ChannelOptions, ColorTexel, Displacement, Field, Paint, Rgba8, Rgba16, StoredTexel, Texel, Trace,
    Traces, VectorDisplacement,
};

use crate::nearby::{Found, Nearby, vector};
use crate::prefilter::SplineTexel;
use crate::restored;
use crate::solve::{Target, solve};

/// What a transfer did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transferred {
    /// Area of the new surface, and of it what is further from the old one than allowed: nothing is there.
    pub area: [f64; 2],
    /// Layer by layer: its name, the area of the old tiles that hold something, and of it that of tiles of which
    /// nothing came to the new surface.
    pub layers: Vec<(String, [f64; 2])>,
    /// The distance that is allowed.
    pub reach: f64,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl fmt::Display for Transferred {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [all, bare] = self.area;
        let percent = |[all, part]: [f64; 2]| if all > 0.0 { 100.0 * part / all } else { 0.0 };
        write!(
            out,
            "{bare:.6} of {all:.6} square units ({:.2} %) of the new surface are further than {:.6} from the old one and \
             uncovered",
            percent(self.area),
            self.reach
        )?;
        for (name, lost) in &self.layers {
            write!(out, "\nlayer `{name}`: {:.2} % of what was edited has no place on the new mesh", percent(*lost))?;
        }
        self.notes.iter().try_for_each(|note| write!(out, "\nnote: {note}"))
    }
}

/// The surface whose detail is taken.
struct Old<'a> {
    surface: &'a Surface,
    nearby: Nearby<'a>,
}

/// Samples along a side of a tile by which areas are measured.
const MEASURED: u32 = 8;
/// How far a place may be, as a share of the extent of the new surface, unless something else is said.
const REACH: f64 = 0.02;
/// The share of progress that finding the uncovered area is.
const COVERAGE: f32 = 0.2;
/// What is said of a document whose edits fade.
const FADE_NO_MORE: &str = "edits fade no more: when they were made belongs to the old mesh";

/// How a document is taken to another mesh.
#[derive(Clone, Copy, Debug, Default)]
pub struct TransferOptions {
    /// How far a place of the old surface may be from one of the new, in units of the meshes; `None` for 2 % of the new
    /// surface's extent.
    pub reach: Option<f64>,
    /// Levels of isolation of both surfaces; `None` for the default, or fewer where that exceeds the memory limit.
    pub isolation: Option<u32>,
}

/// Takes the layers of `document` to `mesh`. The old mesh is `from`, or the one whose points the document has.
///
/// # Errors
/// The document has no points and `from` is `None`, `from` is not its mesh, a mesh cannot be subdivided, or the memory
/// limit is too small.
pub fn transfer(
    context: &Context,
    document: &Document,
    from: Option<&Mesh>,
    mesh: &Mesh,
    options: &TransferOptions,
) -> Result<(Document, Transferred)> {
    transfer_watched(context, document, from, mesh, options, &mut Silent)
}

/// As [`transfer`], telling `progress` of every layer and every few tiles.
///
/// # Errors
/// Fails as [`transfer`] does, and with `Cancelled` if `progress` asks to stop.
pub fn transfer_watched(
    context: &Context,
    document: &Document,
    from: Option<&Mesh>,
    mesh: &Mesh,
    options: &TransferOptions,
    progress: &mut dyn Progress,
) -> Result<(Document, Transferred)> {
    let topology = document.topology();
    if topology.is_of_triangles() {
        return triangles::transfer(context, document, from, mesh, options.reach, progress);
    }
    let stored;
    let mut report = Transferred::default();
    let before = match from {
        Some(from) => {
            report.notes.extend(document.fit(from)?);
            from
        }
        None => {
            stored = document.mesh().ok_or_else(without_points)?;
            if topology.sharpness() != relievo_document::topology::sharpness(&stored) {
                report.notes.push(
                    "the old mesh had creases, which the document does not hold; name that mesh with --from if they \
                     matter"
                        .into(),
                );
            }
            &stored
        }
    };
    let mut surface = |mesh: &Mesh, name: &str| {
        let (options, lowered) =
            Surface::choose_isolation(context, mesh, &SurfaceOptions::default(), options.isolation)?;
        report.notes.extend(lowered.map(|note| format!("{name}: {note}")));
        Surface::new(context, mesh, &options)
    };
    let old = surface(before, "the old mesh").map_err(|error| error.at("the old mesh"))?;
    let new = surface(mesh, "the new mesh").map_err(|error| error.at("the new mesh"))?;
    let reach = checked_reach(options.reach.unwrap_or(REACH * f64::from(new.extent())))?;
    report.reach = reach;
    let old = Old { surface: &old, nearby: Nearby::new(context, &old) };
    let areas = |surface: &Surface| -> Vec<f64> {
        context.map(surface.tile_count(), |tile| tile_area(context, surface, tile as u32))
    };
    let (old_areas, new_areas) = (areas(old.surface), areas(&new));
    report.area = [new_areas.iter().sum(), uncovered(context, &old, &new, reach as f32, progress)?];
    let mut made = Document::new(mesh, &document.level)?;
    made.time = document.time;
    let part = (1.0 - COVERAGE) / document.layers().len().max(1) as f32;
    for (number, layer) in document.layers().iter().enumerate() {
        let span = [number, number + 1].map(|at| COVERAGE + at as f32 * part);
        let head = layer.head();
        let old_sizes = head.face_sizes.clone();
        let tiles = layer.blocks().iter().map(|block| block.tile());
        let size = fitting(&old, &old_areas, &new_areas, &old_sizes, tiles);
        let carry =
            Carry { context, document, old: &old, old_areas: &old_areas, new: &new, reach: reach as f32, head, span };
        let options = ChannelOptions { size, budget: context.memory_limit(), ..ChannelOptions::default() };
        let topology = || new.topology().clone();
        let made = &mut made;
        let lost = match head.kind {
            Kind::Scalar => {
                carry.over(made, Displacement::new(topology(), &options)?, f16::sample, solved, progress)?
            }
            Kind::Vector => {
                carry.over(made, VectorDisplacement::on(&new, &options)?, Vector::sample, solved, progress)?
            }
            Kind::Rgba8 => {
                let blank = bytemuck::pod_read_unaligned::<Rgba8>(&head.blank).color();
                carry.over(
                    made,
                    Paint::<Rgba8>::of_color(topology(), blank, &options)?,
                    Rgba8::sample,
                    painted,
                    progress,
                )?
            }
            Kind::Rgba16 => {
                let blank = bytemuck::pod_read_unaligned::<Rgba16>(&head.blank).color();
                carry.over(
                    made,
                    Paint::<Rgba16>::of_color(topology(), blank, &options)?,
                    Rgba16::sample,
                    painted,
                    progress,
                )?
            }
            Kind::Trace => {
                let shape = Displacement::new(topology(), &options)?;
                carry.over(made, Traces::of(shape.field(), options.budget)?, Trace::sample, traced, progress)?
            }
            Kind::Stamps => {
                report.notes.push(FADE_NO_MORE.into());
                continue;
            }
        };
        report.layers.push((head.name.clone(), lost));
    }
    Ok((made, report))
}

/// What is said of a document without the points of its mesh.
pub(crate) fn without_points() -> Error {
    Error::invalid("the document does not have the points of its mesh")
        .advise("name the mesh it was made on with --from")
}

fn checked_reach(reach: f64) -> Result<f64> {
    if reach > 0.0 && reach.is_finite() {
        return Ok(reach);
    }
    Err(Error::invalid(format!("{reach} is no reach")).advise("give a distance above 0"))
}

/// Texels along an edge of the new faces, so that they are about as large as those of the old tiles that hold
/// something.
fn fitting(old: &Old, old_areas: &[f64], new_areas: &[f64], sizes: &[u32], tiles: impl Iterator<Item = u32>) -> u32 {
    let topology = old.surface.topology();
    let (mut texels, mut area) = (0.0, 0.0);
    for tile in tiles {
        let size = f64::from(sizes.get(topology.face(tile) as usize).copied().unwrap_or(8));
        let side = if topology.is_sub(tile) { 0.5 * size } else { size };
        texels += side * side;
        area += old_areas.get(tile as usize).copied().unwrap_or(0.0);
    }
    let mean = new_areas.iter().sum::<f64>() / new_areas.len().max(1) as f64;
    if texels == 0.0 || area <= 0.0 || mean <= 0.0 {
        return sizes.iter().copied().max().unwrap_or(8);
    }
    let side = (texels / area * mean).sqrt().clamp(8.0, 256.0) as u32;
    // The nearest power of two.
    let below = 1 << side.ilog2();
    if f64::from(side) > f64::from(below) * std::f64::consts::SQRT_2 { (2 * below).min(256) } else { below }
}

/// Numbers of a texel: as many as its kind has, in front.
type Numbers = [f32; 4];

/// A place of the old surface and the frames there and at the new texel: tangent by u, across it, and normal.
struct Site {
    place: Place,
    frames: [Mat3; 2],
}

/// A texel that can be taken along.
trait Carried: StoredTexel {
    /// What an old field has at a place.
    fn sample(level: Level, field: &Field<Self>, site: &Site) -> Numbers;
}

impl Carried for f16 {
    fn sample(level: Level, field: &Field<Self>, site: &Site) -> Numbers {
        [field.point(level, field.canonical(site.place)).d, 0.0, 0.0, 0.0]
    }
}

impl Carried for Vector {
    fn sample(level: Level, field: &Field<Self>, site: &Site) -> Numbers {
        let [from, to] = site.frames;
        let there = from * Vec3::from(field.vector(level, site.place).map(|jet| jet.d));
        let [x, y, z] = (to.transpose() * there).to_array();
        [x, y, z, 0.0]
    }
}

impl Carried for Rgba8 {
    fn sample(_: Level, field: &Field<Self>, site: &Site) -> Numbers {
        field.color(field.canonical(site.place)).to_array()
    }
}

impl Carried for Rgba16 {
    fn sample(_: Level, field: &Field<Self>, site: &Site) -> Numbers {
        field.color(field.canonical(site.place)).to_array()
    }
}

impl Carried for Trace {
    /// Those of the texel that the place is in: times are not mixed.
    fn sample(_: Level, field: &Field<Self>, site: &Site) -> Numbers {
        let (place, size) = (site.place, field.size(site.place.tile));
        let at = |t: f32| ((t * size as f32) as u32).min(size - 1) as usize + 1;
        let index = at(place.v) * (size as usize + 2) + at(place.u);
        let trace = field.block(place.tile).and_then(|block| block.get(index)).copied().unwrap_or_default();
        [trace.contact.to_f32(), trace.depth.to_f32(), trace.moment, 0.0]
    }
}

/// The numbers of the tiles that hold something.
type Tiles = BTreeMap<u32, Vec<Numbers>>;

fn solved<T: SplineTexel>(context: &Context, channel: &mut Channel<T>, tiles: Tiles) -> Result<()> {
    restored::allocate(channel, &tiles.keys().copied().collect::<Vec<_>>())?;
    let numbers = |texels: Vec<Numbers>| texels.iter().flat_map(|texel| texel[..T::NUMBERS].to_vec()).collect();
    let values = tiles.into_iter().map(|(tile, texels)| (tile, numbers(texels))).collect();
    solve(context, channel, Target { values, step: 0.0 }).map(drop)
}

fn painted<T: ColorTexel>(context: &Context, channel: &mut Channel<T>, tiles: Tiles) -> Result<()> {
    filled(context, channel, tiles, |numbers| T::of_color(numbers.into()))
}

fn traced(context: &Context, channel: &mut Traces, tiles: Tiles) -> Result<()> {
    filled(context, channel, tiles, |[contact, depth, moment, _]| Trace {
        contact: f16::from_f32(contact),
        depth: f16::from_f32(depth),
        moment,
    })
}

fn filled<T: Texel>(
    context: &Context,
    channel: &mut Channel<T>,
    tiles: Tiles,
    texel: impl Fn(Numbers) -> T,
) -> Result<()> {
    let list: Vec<u32> = tiles.keys().copied().collect();
    let texels: Vec<Vec<T>> = tiles.into_values().map(|numbers| numbers.into_iter().map(&texel).collect()).collect();
    restored::allocate(channel, &list)?;
    restored::fill(context, channel, &list, &texels)?;
    restored::settle(context, channel, &list)
}

/// The numbers of a new tile, and the old tiles that they come from.
type Arrived = (Vec<Numbers>, BTreeSet<u32>);

/// A layer on its way.
struct Carry<'a> {
    context: &'a Context,
    document: &'a Document,
    old: &'a Old<'a>,
    old_areas: &'a [f64],
    new: &'a Surface,
    reach: f32,
    head: &'a Head,
    /// The fractions of progress it goes between.
    span: [f32; 2],
}

impl Carry<'_> {
    /// Fills `channel` and adds it to `made`. Returns the area of the old tiles that hold something, and of those of
    /// which nothing arrived.
    fn over<T: Carried>(
        &self,
        made: &mut Document,
        mut channel: Channel<T>,
        sample: fn(Level, &Field<T>, &Site) -> Numbers,
        fill: fn(&Context, &mut Channel<T>, Tiles) -> Result<()>,
        progress: &mut dyn Progress,
    ) -> Result<[f64; 2]> {
        let Self { context, document, old, new, head, .. } = *self;
        let topology = old.surface.topology().clone();
        let from = Channel::<T>::stored(context, topology, document, &head.name, context.memory_limit())?;
        let Some(from) = from else { return Ok([0.0; 2]) };
        let (from, level) = (from.field(), context.level());
        // Where every old tile holds something, what is out of reach reads as zero.
        let blank = blank_numbers(from, sample, level).unwrap_or_default();
        let field = channel.field();
        let live: Vec<u32> = (0..new.tile_count() as u32).filter(|tile| !new.topology().is_hole(*tile)).collect();
        let serial = Context::serial();
        let stage = ("transfer", self.span);
        let tiles = context.map_watched(live.len(), progress, stage, |index| -> Result<Option<Arrived>> {
            let (samples, points) = points(level, new, live[index], field.size(live[index]));
            let found = old.nearby.find(&serial, &points)?;
            let near =
                |found: &Option<Found>| found.filter(|found| found.distance <= self.reach).map(|found| found.place);
            let places: Vec<Option<Place>> = found.iter().map(near).collect();
            let there = |place: &Place| from.is_allocated(from.canonical(*place).tile) || from.is_allocated(place.tile);
            let reached: BTreeSet<u32> =
                places.iter().flatten().filter(|place| there(place)).map(|place| place.tile).collect();
            if reached.is_empty() {
                return Ok(None);
            }
            let list: Vec<Place> = places.iter().flatten().copied().collect();
            let mut before = Samples::default();
            old.surface.evaluate(&serial, &list, Order::First, &mut before)?;
            let mut next = 0..;
            let numbers = places.iter().enumerate().map(|(at, place)| match (place, place.and_then(|_| next.next())) {
                (Some(place), Some(index)) => {
                    let frames = [frame(&before, index), frame(&samples, at)];
                    sample(level, from, &Site { place: *place, frames })
                }
                _ => blank,
            });
            Ok(Some((numbers.collect(), reached)))
        })?;
        let (mut kept, mut reached) = (Tiles::new(), BTreeSet::new());
        for (tile, made) in live.into_iter().zip(tiles) {
            let Some((numbers, places)) = made? else { continue };
            reached.extend(places);
            if numbers.iter().any(|numbers| *numbers != blank) {
                kept.insert(tile, numbers);
            }
        }
        fill(context, &mut channel, kept)?;
        let field = channel.field();
        let own = Head {
            blank: Blocks::blank(field).to_vec(),
            face_sizes: field.face_sizes(),
            given_sizes: Vec::new(),
            ..head.clone()
        };
        let read = |tile| Ok(field.bytes(tile).unwrap_or_default().into_owned());
        made.pack_layer(context, own, &field.numbers(), read)?;
        let area = |tile: &u32| self.old_areas.get(*tile as usize).copied().unwrap_or(0.0);
        let held: Vec<u32> = from.allocated().collect();
        let lost = held.iter().filter(|tile| !reached.contains(tile)).map(area).sum();
        Ok([held.iter().map(area).sum(), lost])
    }
}

/// What is read where nothing is.
fn blank_numbers<T: Carried>(
    field: &Field<T>,
    sample: fn(Level, &Field<T>, &Site) -> Numbers,
    level: Level,
) -> Option<Numbers> {
    let bare = (0..field.tile_count() as u32).find(|tile| !field.is_allocated(*tile))?;
    Some(sample(level, field, &Site { place: Place::new(bare, 0.5, 0.5), frames: [Mat3::IDENTITY; 2] }))
}

/// The centres of the texels of a tile, and the normals there.
fn points(level: Level, surface: &Surface, tile: u32, size: u32) -> (Samples, Vec<(Vec3, Vec3)>) {
    let mut samples = Samples::default();
    surface.grid(level, tile, &Grid::whole(size, Placement::Centred), Order::First, &mut samples);
    let point = |at: usize| (vector(&samples.p, at), frame(&samples, at).z_axis);
    let points = (0..samples.len()).map(point).collect();
    (samples, points)
}

/// The unit tangent by u, the direction across it, and the normal.
fn frame(samples: &Samples, at: usize) -> Mat3 {
    let (du, dv) = (vector(&samples.du, at), vector(&samples.dv, at));
    let normal = du.cross(dv).normalize_or_zero();
    let tangent = du.normalize_or_zero();
    Mat3::from_cols(tangent, normal.cross(tangent), normal)
}

/// Areas of the parts of a tile around its samples.
fn parts(samples: &Samples) -> Vec<f64> {
    let share = 1.0 / samples.len().max(1) as f64;
    let part = |at: usize| share * f64::from(vector(&samples.du, at).cross(vector(&samples.dv, at)).length());
    (0..samples.len()).map(part).collect()
}

fn tile_area(context: &Context, surface: &Surface, tile: u32) -> f64 {
    if surface.topology().is_hole(tile) {
        return 0.0;
    }
    parts(&points(context.level(), surface, tile, MEASURED).0).iter().sum()
}

/// The area of `new` that is further from the old surface than `reach`.
fn uncovered(context: &Context, old: &Old, new: &Surface, reach: f32, progress: &mut dyn Progress) -> Result<f64> {
    let serial = Context::serial();
    let areas =
        context.map_watched(new.tile_count(), progress, ("coverage", [0.0, COVERAGE]), |tile| -> Result<f64> {
            if new.topology().is_hole(tile as u32) {
                return Ok(0.0);
            }
            let (samples, points) = points(context.level(), new, tile as u32, MEASURED);
            let found = old.nearby.find(&serial, &points)?;
            let bare = |found: &Option<Found>| found.is_none_or(|found| found.distance > reach);
            Ok(parts(&samples).iter().zip(&found).filter(|(_, found)| bare(found)).map(|(area, _)| area).sum())
        })?;
    areas.into_iter().sum()
}
