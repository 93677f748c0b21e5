//! A stroke: dabs along the way of a brush over the surfaces of one or several objects.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 3: each
//! dab is put on the surface and oriented by its tangent plane. What counts is the surface as it was when the stroke
//! began, so that a stroke that raises it does not climb its own ridge. Pressure goes evenly from point to point. What
//! is up to chance follows from the seed and the number of the station, so that a stroke is the same whenever it is
//! made. Units: world units; heights of sculpting are in object units.

use glam::{DMat3, DVec2, DVec3};
use relievo_core::parameter::Switch;
use relievo_core::{Context, Result};

use crate::object::canvas::{Canvas, Start};
use crate::object::nearest::SurfacePoint;
use crate::paint::brush::Brush;
use crate::paint::curve::Curve;
use crate::paint::dab::{Action, Dab};
use crate::paint::open::OpenStroke;
use crate::paint::path::{Pace, Station, StrokePoint};
use crate::paint::report::DabReport;
use crate::paint::stamp::Stamp;
use relievo_core::Falloff;

relievo_core::parameters! {
    /// The brush of a stroke and how it follows the points.
    pub struct StrokeSettings {
        /// Radius of the brush on the surface.
        radius: f32 = 0.1, 1e-6..=1e6, "world units";
        /// How far the brush reaches out of the surface and into it, as a share of the radius.
        depth: f32 = 1.0, 0.01..=100.0, "";
        /// Distance between dabs, as a share of the radius.
        spacing: f32 = 0.25, 0.01..=100.0, "";
        /// How much of the edit each dab makes.
        strength: f32 = 1.0, 0.0..=1.0, "";
        /// How much of the strength is up to the pressure.
        strength_pressure: f32 = 1.0, 0.0..=1.0, "";
        /// How much of the radius is up to the pressure.
        size_pressure: f32 = 0.0, 0.0..=1.0, "";
        /// By how much the brush is turned on the surface, from where the stroke goes to its left.
        angle: f32 = 0.0, -1000.0..=1000.0, "rad";
        /// By how much full pressure turns it further.
        angle_pressure: f32 = 0.0, -1000.0..=1000.0, "rad";
        /// How far a dab may be put beside its place, as a share of the radius.
        jitter_position: f32 = 0.0, 0.0..=100.0, "";
        /// How much of the radius is up to chance.
        jitter_size: f32 = 0.0, 0.0..=1.0, "";
        /// How much of the strength is up to chance.
        jitter_strength: f32 = 0.0, 0.0..=1.0, "";
        /// By how much a dab may be turned either way.
        jitter_angle: f32 = 0.0, 0.0..=1000.0, "rad";
        /// What chance begins with: the same seed is the same stroke.
        seed: u32 = 0, 0..=4294967295u32, "";
        /// Length of the string on which the brush is drawn along; 0 follows the points.
        string: f32 = 0.0, 0.0..=1e6, "world units";
        /// Dabs by time, as of an airbrush, besides those by distance; 0 makes none.
        rate: f32 = 0.0, 0.0..=10000.0, "1/s";
        /// Whether the stroke is made at x mirrored too, in the space of the object.
        symmetry_x: Switch = Switch::OFF, 0..=1, "";
        /// Whether the stroke is made at y mirrored too, in the space of the object.
        symmetry_y: Switch = Switch::OFF, 0..=1, "";
        /// Whether the stroke is made at z mirrored too, in the space of the object.
        symmetry_z: Switch = Switch::OFF, 0..=1, "";
        /// How far a point may be from the surface, in radii. Dabs of points further away are left out.
        reach: f32 = 2.0, 0.0..=1000.0, "";
        /// What it edits: 0 all texels, 1 half of them along an edge, 2 a quarter. What finer levels have more stays.
        level: u32 = 0, 0..=2, "";
    }
}

/// What pressure is taken as.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PressureCurves {
    /// For [`StrokeSettings::size_pressure`].
    pub size: Curve,
    /// For [`StrokeSettings::strength_pressure`].
    pub strength: Curve,
    /// For [`StrokeSettings::angle_pressure`].
    pub angle: Curve,
}

/// A line of points with a brush.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Points in order; one makes a single dab.
    pub points: Vec<StrokePoint>,
    /// The brush.
    pub settings: StrokeSettings,
    /// The brush's function.
    pub falloff: Falloff,
    /// What the brush does.
    pub action: Action,
    /// The brush's image.
    pub stamp: Option<Stamp>,
    /// What pressure is taken as.
    pub curves: PressureCurves,
}

/// What a stroke did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrokeReport {
    /// Dabs that were made.
    pub dabs: u64,
    /// Dabs that were left out because no surface is near enough there, or it has no normal.
    pub missed: u64,
    /// What the dabs did, all together.
    pub report: DabReport,
}

impl StrokeReport {
    /// Reports of nothing yet on `count` objects, with room from the context.
    pub(crate) fn list(context: &Context, count: usize) -> Vec<Self> {
        let list = || context.scratch().take_list();
        let nothing = || DabReport { changed: list(), refused: list(), ..DabReport::default() };
        let mut reports = context.scratch().take_list();
        reports.extend((0..count).map(|_| Self { report: nothing(), ..Self::default() }));
        reports
    }

    /// Gives the room of `reports` back to the context that the stroke was made with.
    pub fn give_back(context: &Context, mut reports: Vec<Self>) {
        reports.drain(..).for_each(|made| made.report.give_back(context));
        context.scratch().keep_list(reports);
    }
}

/// The objects of a stroke and what they were when it began.
#[derive(Debug)]
pub(crate) struct Among<'a, C: ?Sized> {
    pub objects: &'a [&'a mut C],
    pub starts: &'a [Start],
}

impl<C: ?Sized> Clone for Among<'_, C> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<C: ?Sized> Copy for Among<'_, C> {}

/// A dab and its mirror images, each with the object that it is put on; `None` where no surface is near enough.
#[derive(Default)]
pub(crate) struct Images {
    pub dabs: [Option<(usize, Dab)>; 8],
    pub count: usize,
}

impl Images {
    fn push(&mut self, dab: Option<(usize, Dab)>) {
        self.dabs[self.count] = dab;
        self.count += 1;
    }
}

/// Which chance a number is for.
#[derive(Clone, Copy, Debug)]
enum Chance {
    Radius,
    Direction,
    Size,
    Strength,
    Angle,
}

impl Stroke {
    /// A stroke without an image, whose pressure is taken as it is.
    pub fn new(points: Vec<StrokePoint>, settings: StrokeSettings, falloff: Falloff, action: Action) -> Self {
        Self { points, settings, falloff, action, stamp: None, curves: PressureCurves::default() }
    }

    /// Checks the brush and the points.
    ///
    /// # Errors
    /// Fails as [`Self::check_brush`], and with `Invalid` if there are no points, a coordinate is not finite or beyond
    /// 1e12, a pressure is not within 0 to 1, a time is not within 0 to 1e9 seconds, goes back, or is missing for an
    /// airbrush, or there would be over a million dabs or steps of the string.
    pub fn check(&self) -> Result<()> {
        self.check_brush()?;
        self.pace().check(&self.points)
    }

    /// Checks the brush, whatever the points are.
    ///
    /// # Errors
    /// Fails with `Invalid` if a setting, or the colour or height of the action, is out of its range.
    pub fn check_brush(&self) -> Result<()> {
        self.settings.check().map_err(|error| error.at("stroke"))?;
        let brush = Brush::on_surface(DVec3::ZERO, DVec3::Z, DVec3::X, self.half(1.0, 0.0), self.falloff)?;
        Dab { brush, action: self.action, strength: 1.0 }.check()
    }

    pub(crate) fn pace(&self) -> Pace {
        let StrokeSettings { radius, spacing, rate, string, .. } = self.settings;
        Pace { step: f64::from(radius) * f64::from(spacing), rate: f64::from(rate), string: f64::from(string) }
    }

    /// The half extents of the brush's box, where `chance` is 0 to 1.
    fn half(&self, pressure: f64, chance: f64) -> DVec3 {
        let StrokeSettings { radius, depth, size_pressure, jitter_size, .. } = self.settings;
        let share = 1.0 - f64::from(size_pressure) * (1.0 - self.curves.size.at(pressure));
        let share = share * (1.0 - f64::from(jitter_size) * chance);
        // Without pressure a brush whose size is up to it shrinks to nothing, but a box has some size.
        let radius = f64::from(radius) * share.max(1e-3);
        DVec3::new(radius, radius, radius * f64::from(depth))
    }

    /// 0 to 1, by the seed and the number of the station.
    fn chance(&self, station: &Station, what: Chance) -> f64 {
        // SplitMix64 (Steele, Lea and Flood 2014).
        let mut bits = (u64::from(self.settings.seed) << 32 | u64::from(station.index)) ^ (what as u64) << 61;
        for _ in 0..2 {
            bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
            bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            bits ^= bits >> 31;
        }
        (bits >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The places that get a dab: the first point, then one at every step along the way and at every tick of an
    /// airbrush.
    ///
    /// # Errors
    /// Fails as [`Self::check`].
    pub fn stations(&self) -> Result<Vec<Station>> {
        self.check()?;
        Ok(self.pace().stations(&self.points))
    }

    /// Makes the dabs of the stroke on `object`, one after the other. Parts of the stroke that are off the surface do
    /// nothing and are counted.
    ///
    /// # Errors
    /// Fails before any dab is made as [`Self::check`] and [`OpenStroke::begin`], and with `Invalid` if the active
    /// layer cannot be seen. Fails as [`OpenStroke::end`] too; dabs before stay made.
    pub fn apply<C: Canvas + ?Sized>(&self, context: &Context, object: &mut C) -> Result<StrokeReport> {
        Ok(self.apply_all(context, &mut [object])?.pop().unwrap_or_default())
    }

    /// As [`Self::apply`] over several objects: every dab is put on the nearest of their surfaces and then made on all
    /// that reach into its box. Symmetry is in the space of the object that the dab itself is put on, or of the first
    /// where it is on none. Returns what it did to each of them; a dab counts for those it was put on or changed, one
    /// that was left out counts for all.
    ///
    /// # Errors
    /// Fails as [`Self::apply`]; where one object fails, dabs on others stay made.
    #[inline(never)]
    pub fn apply_all<C: Canvas + ?Sized>(
        &self,
        context: &Context,
        objects: &mut [&mut C],
    ) -> Result<Vec<StrokeReport>> {
        self.check()?;
        let stroke = OpenStroke::begin(context, Self { points: Vec::new(), ..self.clone() }, objects)?;
        stroke.end(context, objects, &self.points)
    }

    /// As [`Self::apply_all`] with dabs at `stations`, whatever the points are: of a brush that rides on something,
    /// say.
    ///
    /// # Errors
    /// Fails as [`Self::apply_all`], where [`Self::check_brush`] takes the place of [`Self::check`].
    #[inline(never)]
    pub fn apply_stations<C: Canvas + ?Sized>(
        &self,
        context: &Context,
        objects: &mut [&mut C],
        stations: &[Station],
    ) -> Result<Vec<StrokeReport>> {
        let mut stroke = OpenStroke::begin(context, Self { points: Vec::new(), ..self.clone() }, objects)?;
        stroke.make_at(context, objects, stations)
    }

    /// The dab of a station on the nearest of the surfaces as they were before the stroke, and on which it is put, and
    /// then its mirror images; `None` where the surfaces are too far away, or have no normal.
    pub(crate) fn dabs<C: Canvas + ?Sized>(
        &self,
        context: &Context,
        objects: Among<'_, C>,
        station: &Station,
    ) -> Result<Images> {
        let first = self.find(context, objects, station.position)?;
        let space = first.map_or(0, |(index, _)| index);
        let mut images = Images::default();
        let Some(transform) = objects.objects.get(space).map(|object| object.transform()) else { return Ok(images) };
        let way = match (station.direction, first) {
            (DVec3::ZERO, Some((_, found))) => found.tangent,
            (direction, _) => direction,
        };
        for sign in self.mirrors() {
            if sign == DVec3::ONE {
                images.push(self.dab(context, objects, station, first, way, false)?);
                continue;
            }
            let mirror = *transform * glam::DAffine3::from_mat3(DMat3::from_diagonal(sign)) * transform.inverse();
            let found = self.find(context, objects, mirror.transform_point3(station.position))?;
            let over = sign.element_product() < 0.0;
            images.push(self.dab(context, objects, station, found, mirror.transform_vector3(way), over)?);
        }
        Ok(images)
    }

    /// The nearest place of the surfaces within reach, and whose it is.
    fn find<C: Canvas + ?Sized>(
        &self,
        context: &Context,
        objects: Among<'_, C>,
        point: DVec3,
    ) -> Result<Option<(usize, SurfacePoint)>> {
        let within = f64::from(self.settings.radius) * f64::from(self.settings.reach);
        let mut best: Option<(usize, SurfacePoint)> = None;
        for (index, (object, start)) in objects.objects.iter().zip(objects.starts).enumerate() {
            let within = best.map_or(within, |(_, best)| best.distance);
            if let Some(found) = object.nearest(context, start, point, within)?
                && found.normal != DVec3::ZERO
                && best.is_none_or(|(_, best)| found.distance < best.distance)
            {
                best = Some((index, found));
            }
        }
        Ok(best)
    }

    /// The dab at a found place whose first axis goes along `way`; `over` if it is a mirror image.
    fn dab<C: Canvas + ?Sized>(
        &self,
        context: &Context,
        objects: Among<'_, C>,
        station: &Station,
        found: Option<(usize, SurfacePoint)>,
        way: DVec3,
        over: bool,
    ) -> Result<Option<(usize, Dab)>> {
        let settings = &self.settings;
        let chance = |what| self.chance(station, what);
        let hand = if over { -1.0 } else { 1.0 };
        let Some((mut on, mut found)) = found else { return Ok(None) };
        let half = self.half(station.pressure, chance(Chance::Size));
        if settings.jitter_position > 0.0 {
            let axes = *Brush::on_surface(found.point, found.normal, way, half, self.falloff)?.axes();
            // Even over a disc.
            let far = f64::from(settings.radius * settings.jitter_position) * chance(Chance::Radius).sqrt();
            let beside = far * DVec2::from_angle(std::f64::consts::TAU * chance(Chance::Direction));
            let point = found.point + axes.x_axis * beside.x + axes.y_axis * (hand * beside.y);
            let Some(moved) = self.find(context, objects, point)? else { return Ok(None) };
            (on, found) = moved;
        }
        Ok(Some((on, self.dab_on(station, (found.point, found.normal), way, over)?)))
    }

    /// The signs of the axes of the stroke itself and of its mirror images.
    pub fn mirrors(&self) -> impl Iterator<Item = DVec3> {
        let StrokeSettings { symmetry_x, symmetry_y, symmetry_z, .. } = self.settings;
        let planes = [symmetry_x, symmetry_y, symmetry_z];
        let is_made = move |mirrors: &u32| (0..3).all(|axis| mirrors >> axis & 1 == 0 || planes[axis].is_on());
        let sign = |mirrors: u32| DVec3::from([0, 1, 2].map(|axis| if mirrors >> axis & 1 != 0 { -1.0 } else { 1.0 }));
        (0..8).filter(is_made).map(sign)
    }

    /// The dab of a station on a point of a surface with a normal, its first axis along `way`; `over` if it is a mirror
    /// image.
    ///
    /// # Errors
    /// Fails with `Invalid` if the normal is zero or not finite, the point is not finite, or [`Brush::new`] refuses the
    /// box.
    pub fn dab_on(&self, station: &Station, at: (DVec3, DVec3), way: DVec3, over: bool) -> Result<Dab> {
        let settings = &self.settings;
        let chance = |what| self.chance(station, what);
        let hand = if over { -1.0 } else { 1.0 };
        let half = self.half(station.pressure, chance(Chance::Size));
        let angle = f64::from(settings.angle)
            + f64::from(settings.angle_pressure) * self.curves.angle.at(station.pressure)
            + f64::from(settings.jitter_angle) * (2.0 * chance(Chance::Angle) - 1.0);
        let brush = Brush::on_surface(at.0, at.1, way, half, self.falloff)?.turned(hand * angle);
        let brush = match &self.stamp {
            Some(stamp) => brush.with_stamp(if over { stamp.turned_over() } else { stamp.clone() }),
            None => brush,
        };
        let pressure = self.curves.strength.at(station.pressure) as f32;
        let strength = settings.strength * (1.0 - settings.strength_pressure * (1.0 - pressure));
        let strength = strength * (1.0 - settings.jitter_strength * chance(Chance::Strength) as f32);
        Ok(Dab { brush, action: self.action, strength: strength.clamp(0.0, 1.0) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paint::mode::PaintMode;

    fn stroke() -> Stroke {
        let points = [DVec3::ZERO, DVec3::X].map(|position| StrokePoint::new(position, 1.0));
        let settings = StrokeSettings { radius: 0.5, spacing: 0.5, ..Default::default() };
        let action = Action::Paint { mode: PaintMode::Mix, color: [1.0; 4] };
        Stroke::new(points.to_vec(), settings, Falloff::Smooth, action)
    }

    #[test]
    fn strokes_that_cannot_be_are_refused() {
        let good = stroke();
        good.check().unwrap();
        let spoil = |spoil: &dyn Fn(&mut Stroke)| {
            let mut bad = good.clone();
            spoil(&mut bad);
            assert!(bad.check().is_err() && bad.stations().is_err(), "{bad:?}");
        };
        spoil(&|bad| bad.points.clear());
        spoil(&|bad| bad.points[0].pressure = f64::NAN);
        spoil(&|bad| bad.settings.radius = f32::NAN);
        spoil(&|bad| bad.settings.spacing = 0.0);
        spoil(&|bad| bad.settings.rate = 10.0);
        spoil(&|bad| bad.settings.jitter_size = -1.0);
        spoil(&|bad| bad.settings.string = f32::INFINITY);
        spoil(&|bad| bad.action = Action::Paint { mode: PaintMode::Mix, color: [f32::NAN; 4] });
        spoil(&|bad| bad.action = Action::Sculpt { mode: crate::SculptMode::Draw, height: f32::NAN });
    }

    #[test]
    fn chance_is_even_and_depends_on_the_seed_and_the_station_alone() {
        let mut stroke = stroke();
        let station = |index| Station { position: DVec3::ZERO, pressure: 1.0, direction: DVec3::X, index };
        let all = |stroke: &Stroke, what| -> Vec<f64> {
            (0..10_000).map(|index| stroke.chance(&station(index), what)).collect()
        };
        let first = all(&stroke, Chance::Size);
        assert_eq!(first, all(&stroke, Chance::Size));
        assert_ne!(first, all(&stroke, Chance::Angle));
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let squares: Vec<f64> = first.iter().map(|value| (value - 0.5).powi(2)).collect();
        assert!((mean(&first) - 0.5).abs() < 0.01 && (mean(&squares) - 1.0 / 12.0).abs() < 0.002);
        let products: Vec<f64> = first.windows(2).map(|pair| (pair[0] - 0.5) * (pair[1] - 0.5)).collect();
        assert!(mean(&products).abs() < 0.003);
        stroke.settings.seed = 1;
        assert_ne!(first, all(&stroke, Chance::Size));
    }
}
