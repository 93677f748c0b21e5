//! A stroke: dabs at even distances along a line of points near a surface.
//!
//! Schäfer, Keinert, Nießner and Stamminger 2015, Local Painting and Deformation of Meshes on the GPU, Section 3: each
//! dab is put on the surface and oriented by its tangent plane. What counts is the surface as it was when the stroke
//! began, so that a stroke that raises it does not climb its own ridge. Pressure goes evenly from point to point.
//! Units: world units; heights of sculpting are in object units.

use glam::DVec3;
use relievo_core::{Context, Error, Result};

use crate::brush::Brush;
use crate::dab::{Action, Dab, DabReport};
use crate::falloff::Falloff;
use crate::object::DisplacedObject;

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
        /// How far a point may be from the surface, in radii. Dabs of points further away are left out.
        reach: f32 = 2.0, 0.0..=1000.0, "";
    }
}

/// A point of a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokePoint {
    /// Where, near the surface.
    pub position: DVec3,
    /// How hard, 0 to 1.
    pub pressure: f64,
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
}

/// A place along a stroke that gets a dab.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// Where, near the surface.
    pub position: DVec3,
    /// How hard, 0 to 1.
    pub pressure: f64,
    /// Where the stroke goes; zero if it does not go anywhere.
    pub direction: DVec3,
}

/// What a stroke did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrokeReport {
    /// Dabs that were made.
    pub dabs: u64,
    /// Dabs that were left out because the surface is too far away there, or has no normal.
    pub missed: u64,
    /// What the dabs did, all together.
    pub report: DabReport,
}

/// Most dabs of a stroke.
const MAX_DABS: f64 = 1e6;

impl Stroke {
    /// Fails if there are no points, a number is not finite or out of its range, or there would be over a million dabs.
    pub fn check(&self) -> Result<()> {
        self.settings.check().map_err(|error| error.at("stroke"))?;
        let fault = |what: String, remedy: &str| Err(Error::invalid(what).at("stroke").advise(remedy));
        if self.points.is_empty() {
            return fault("it has no points".into(), "give at least one");
        }
        for (index, point) in self.points.iter().enumerate() {
            if !point.position.is_finite() || point.position.abs().max_element() > 1e12 {
                return fault(format!("point {index} is nowhere"), "give finite coordinates below 1e12");
            }
            if !(0.0..=1.0).contains(&point.pressure) {
                return fault(format!("the pressure of point {index} is {}", point.pressure), "use 0 to 1");
            }
        }
        if self.length() / self.step() > MAX_DABS {
            return fault("it has over a million dabs".into(), "widen `spacing` or split the stroke");
        }
        Dab { brush: self.brush(DVec3::ZERO, DVec3::Z, DVec3::X, 1.0)?, action: self.action, strength: 1.0 }.check()
    }

    fn length(&self) -> f64 {
        self.points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum()
    }

    fn step(&self) -> f64 {
        f64::from(self.settings.radius) * f64::from(self.settings.spacing)
    }

    fn brush(&self, point: DVec3, normal: DVec3, along: DVec3, pressure: f64) -> Result<Brush> {
        let StrokeSettings { radius, depth, size_pressure, .. } = self.settings;
        let share = 1.0 - f64::from(size_pressure) * (1.0 - pressure);
        // Without pressure a brush whose size is up to it shrinks to nothing, but a box has some size.
        let radius = f64::from(radius) * share.max(1e-3);
        Brush::on_surface(point, normal, along, DVec3::new(radius, radius, radius * f64::from(depth)), self.falloff)
    }

    /// The places that get a dab: the first point, then one at every step along the line.
    ///
    /// Fails as [`Self::check`] does.
    pub fn stations(&self) -> Result<Vec<Station>> {
        self.check()?;
        let step = self.step();
        let first = self.points[0];
        let heading = self.points.windows(2).map(|pair| pair[1].position - pair[0].position);
        let direction = heading.clone().find_map(DVec3::try_normalize).unwrap_or_default();
        let mut stations = vec![Station { position: first.position, pressure: first.pressure, direction }];
        // Counted from the start and not added up, so that nothing drifts.
        let mut gone = 0.0;
        for (pair, heading) in self.points.windows(2).zip(heading) {
            let length = heading.length();
            while stations.len() as f64 * step <= gone + length && length > 0.0 {
                let share = (stations.len() as f64 * step - gone) / length;
                stations.push(Station {
                    position: pair[0].position + heading * share,
                    pressure: pair[0].pressure + (pair[1].pressure - pair[0].pressure) * share,
                    direction: heading / length,
                });
            }
            gone += length;
        }
        Ok(stations)
    }

    /// Makes the dabs of the stroke on `object`, one after the other. Parts of the stroke that are off the surface do
    /// nothing and are counted.
    ///
    /// Fails, and changes nothing, as [`Self::check`] does, or if the object has no colours and is to be painted.
    pub fn apply(&self, context: &Context, object: &mut DisplacedObject) -> Result<StrokeReport> {
        let stations = self.stations()?;
        if matches!(self.action, Action::Paint { .. }) && object.paint().is_none() {
            return Err(Error::invalid("the object has no colours to paint on").advise("give it some first"));
        }
        // Before the first dab, so that nothing has to be measured anew for each.
        object.reach();
        let placed = {
            let _stage = context.stats().begin("stroke.nearest");
            let object = &*object;
            context.map(stations.len(), |index| self.dab(context, object, &stations[index]))
        };
        let placed = placed.into_iter().collect::<Result<Vec<_>>>()?;
        let start = object.displacement().field().clone();
        let mut done =
            StrokeReport { missed: placed.iter().filter(|dab| dab.is_none()).count() as u64, ..Default::default() };
        for dab in placed.into_iter().flatten() {
            done.report.merge(dab.make(context, object, Some(&start))?);
            done.dabs += 1;
        }
        Ok(done)
    }

    /// The dab of a station on the surface as it is; `None` if the surface is too far away, or has no normal.
    pub fn dab(&self, context: &Context, object: &DisplacedObject, station: &Station) -> Result<Option<Dab>> {
        let StrokeSettings { radius, reach, strength, strength_pressure, .. } = self.settings;
        let within = f64::from(radius) * f64::from(reach);
        let found = object.nearest(context, station.position, within)?;
        let Some(found) = found.filter(|found| found.normal != DVec3::ZERO) else { return Ok(None) };
        let along = if station.direction == DVec3::ZERO { found.tangent } else { station.direction };
        let brush = self.brush(found.point, found.normal, along, station.pressure)?;
        let strength = strength * (1.0 - strength_pressure * (1.0 - station.pressure as f32));
        Ok(Some(Dab { brush, action: self.action, strength: strength.clamp(0.0, 1.0) }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mode::PaintMode;

    fn stroke(points: &[([f64; 3], f64)]) -> Stroke {
        Stroke {
            points: points
                .iter()
                .map(|(p, pressure)| StrokePoint { position: (*p).into(), pressure: *pressure })
                .collect(),
            settings: StrokeSettings { radius: 0.5, spacing: 0.5, ..Default::default() },
            falloff: Falloff::Smooth,
            action: Action::Paint { mode: PaintMode::Mix, color: [1.0; 4] },
        }
    }

    #[test]
    fn stations_are_even_round_corners_and_carry_the_pressure() {
        let line =
            stroke(&[([0.0; 3], 0.0), ([0.6, 0.0, 0.0], 0.6), ([0.6; 3].map(|_| 0.6), 0.6), ([0.6, 0.6, 0.6], 0.6)]);
        let stations = line.stations().unwrap();
        assert_eq!(stations.len(), 1 + ((0.6 + 0.72f64.sqrt()) / 0.25) as usize);
        assert!((stations[2].pressure - 0.5).abs() < 1e-12 && stations[2].direction == DVec3::X);
        assert!((stations[3].position - DVec3::new(0.6, 0.15 / 2f64.sqrt(), 0.15 / 2f64.sqrt())).length() < 1e-12);
        let dot = stroke(&[([1.0, 2.0, 3.0], 1.0)]).stations().unwrap();
        assert_eq!((dot.len(), dot[0].direction), (1, DVec3::ZERO));
    }

    #[test]
    fn strokes_that_cannot_be_are_refused() {
        let good = stroke(&[([0.0; 3], 1.0), ([1.0, 0.0, 0.0], 1.0)]);
        good.check().unwrap();
        let spoil = |spoil: &dyn Fn(&mut Stroke)| {
            let mut bad = good.clone();
            spoil(&mut bad);
            assert!(bad.check().is_err() && bad.stations().is_err(), "{bad:?}");
        };
        spoil(&|bad| bad.points.clear());
        spoil(&|bad| bad.points[0].pressure = f64::NAN);
        spoil(&|bad| bad.points[0].pressure = 1.5);
        spoil(&|bad| bad.points[1].position.x = f64::INFINITY);
        spoil(&|bad| bad.points[1].position.x = 1e11);
        spoil(&|bad| bad.settings.radius = f32::NAN);
        spoil(&|bad| bad.settings.spacing = 0.0);
        spoil(&|bad| bad.action = Action::Paint { mode: PaintMode::Mix, color: [f32::NAN; 4] });
        spoil(&|bad| bad.action = Action::Sculpt { mode: crate::SculptMode::Draw, height: f32::NAN });
    }
}
