//! The way of a brush: from the points of a stroke to the stations that get a dab.
//!
//! Dabs are made at even distances along the way and, for an airbrush, at even times as well. A lazy brush hangs on a
//! string and is only drawn along when that is tight, which takes the tremor out of a hand. Everything depends on the
//! points alone. Units: world units, seconds, pressure 0 to 1.

use glam::DVec3;
use relievo_core::{Error, Result};

/// A point of a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokePoint {
    /// Where, near the surface.
    pub position: DVec3,
    /// How hard, 0 to 1.
    pub pressure: f64,
    /// When, seconds from any beginning; airbrushes need it.
    pub time: Option<f64>,
}

impl StrokePoint {
    /// A point without a time.
    pub fn new(position: DVec3, pressure: f64) -> Self {
        Self { position, pressure, time: None }
    }
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
    /// Which of the stroke's stations it is.
    pub index: u32,
}

/// Most dabs of a stroke.
const MAX_DABS: f64 = 1e6;
/// Coordinates are below it.
const FAR: f64 = 1e12;

/// How a brush follows points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pace {
    /// Distance between dabs.
    pub step: f64,
    /// Dabs a second, 0 for none by time.
    pub rate: f64,
    /// Length of the string that a lazy brush hangs on.
    pub string: f64,
}

impl Pace {
    /// Fails if there are no points, a number is not finite or out of its range, times are missing or go back, or there
    /// would be over a million dabs.
    pub fn check(&self, points: &[StrokePoint]) -> Result<()> {
        let fault = |what: String, remedy: &str| Err(Error::invalid(what).at("stroke").advise(remedy));
        if points.is_empty() {
            return fault("it has no points".into(), "give at least one");
        }
        let mut before = 0.0;
        for (index, point) in points.iter().enumerate() {
            if !point.position.is_finite() || point.position.abs().max_element() > FAR {
                return fault(format!("point {index} is nowhere"), "give finite coordinates below 1e12");
            }
            if !(0.0..=1.0).contains(&point.pressure) {
                return fault(format!("the pressure of point {index} is {}", point.pressure), "use 0 to 1");
            }
            match point.time {
                Some(time) if !(0.0..=1e9).contains(&time) || time < before => {
                    let what = format!("the time of point {index} is {time}, that of the one before {before}");
                    return fault(what, "give seconds from 0 to 1e9 that do not go back");
                }
                Some(time) => before = time,
                None if self.rate > 0.0 => {
                    return fault(
                        format!("point {index} has no time"),
                        "an airbrush (`rate`) needs the time of each point",
                    );
                }
                None => {}
            }
        }
        let length: f64 = points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
        let time = before - points[0].time.unwrap_or(before);
        let trail = if self.string > 0.0 { length / self.trail_step() } else { 0.0 };
        if length / self.step + time * self.rate > MAX_DABS || trail > MAX_DABS {
            return fault(
                "it has over a million dabs".into(),
                "widen `spacing`, lower `rate`, lengthen `string` or split the stroke",
            );
        }
        Ok(())
    }

    /// The stations along checked points: the first point, one at every step along the way, and one at every tick.
    pub fn stations(&self, points: &[StrokePoint]) -> Vec<Station> {
        let mut stations = Vec::new();
        self.stations_into(points, &mut Vec::new(), &mut stations);
        stations
    }

    /// As [`Self::stations`], in place of what `stations` holds; a lazy brush's own way goes to `trail`.
    pub fn stations_into(&self, points: &[StrokePoint], trail: &mut Vec<StrokePoint>, stations: &mut Vec<Station>) {
        stations.clear();
        let trail = if self.string > 0.0 {
            self.trail(points, trail);
            trail.as_slice()
        } else {
            points
        };
        let Some(first) = trail.first() else { return };
        let heading = |pair: &[StrokePoint]| pair[1].position - pair[0].position;
        // An airbrush does not wait for the hand to move.
        let ahead = if self.rate > 0.0 { None } else { trail.windows(2).map(heading).find_map(DVec3::try_normalize) };
        let mut direction = ahead.unwrap_or_default();
        let start = Station { position: first.position, pressure: first.pressure, direction, index: 0 };
        stations.push(start);
        // Counted from the start and not added up, so that nothing drifts.
        let (mut steps, mut ticks) = (1.0, 1.0);
        let (mut gone, begin) = (0.0, first.time.unwrap_or(0.0));
        for pair in trail.windows(2) {
            let length = heading(pair).length();
            direction = heading(pair).try_normalize().unwrap_or(direction);
            let (from, to) = (pair[0].time.unwrap_or(0.0) - begin, pair[1].time.unwrap_or(0.0) - begin);
            loop {
                let by_way = (length > 0.0).then(|| (steps * self.step - gone) / length).filter(|share| *share <= 1.0);
                let by_time = (self.rate > 0.0 && to > from)
                    .then(|| (ticks / self.rate - from) / (to - from))
                    .filter(|share| *share <= 1.0);
                let share = match (by_way, by_time) {
                    (Some(way), Some(time)) if way <= time => way,
                    (Some(way), None) => way,
                    (_, Some(time)) => time,
                    (None, None) => break,
                };
                if by_way == Some(share) {
                    steps += 1.0
                } else {
                    ticks += 1.0
                }
                stations.push(Station {
                    position: pair[0].position + heading(pair) * share,
                    pressure: pair[0].pressure + (pair[1].pressure - pair[0].pressure) * share,
                    direction,
                    index: stations.len() as u32,
                });
            }
            gone += length;
        }
    }

    /// Whether the first station of a stroke that begins with these points has to wait for more of them, because where
    /// it looks shows with the next place.
    pub fn waits(&self, points: &[StrokePoint]) -> bool {
        self.rate == 0.0 && self.stations(points).first().is_some_and(|first| first.direction == DVec3::ZERO)
    }

    /// Distance between the places to which a lazy brush is drawn one after the other.
    fn trail_step(&self) -> f64 {
        0.25 * self.step.min(self.string)
    }

    /// Where a lazy brush goes: it stays until the string to the point is tight, and is then drawn straight toward it.
    fn trail(&self, points: &[StrokePoint], trail: &mut Vec<StrokePoint>) {
        trail.clear();
        trail.extend(points.first());
        let Some(mut at) = points.first().map(|point| point.position) else { return };
        for pair in points.windows(2) {
            let way = pair[1].position - pair[0].position;
            let count = (way.length() / self.trail_step()).ceil().max(1.0);
            for k in 1..=count as u64 {
                let share = k as f64 / count;
                let hand = pair[0].position + way * share;
                let string = hand - at;
                let slack = string.length() - self.string;
                if slack > 0.0 {
                    at += string * (slack / string.length());
                }
                let time = pair[0].time.zip(pair[1].time).map(|(from, to)| from + (to - from) * share);
                let pressure = pair[0].pressure + (pair[1].pressure - pair[0].pressure) * share;
                trail.push(StrokePoint { position: at, pressure, time });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: Pace = Pace { step: 0.25, rate: 0.0, string: 0.0 };

    fn points(points: &[([f64; 3], f64)]) -> Vec<StrokePoint> {
        points.iter().map(|(p, pressure)| StrokePoint::new((*p).into(), *pressure)).collect()
    }

    #[test]
    fn stations_are_even_round_corners_and_carry_the_pressure() {
        let line =
            points(&[([0.0; 3], 0.0), ([0.6, 0.0, 0.0], 0.6), ([0.6; 3].map(|_| 0.6), 0.6), ([0.6, 0.6, 0.6], 0.6)]);
        let stations = PACE.stations(&line);
        assert_eq!(stations.len(), 1 + ((0.6 + 0.72f64.sqrt()) / 0.25) as usize);
        assert!((stations[2].pressure - 0.5).abs() < 1e-12 && stations[2].direction == DVec3::X);
        assert!((stations[3].position - DVec3::new(0.6, 0.15 / 2f64.sqrt(), 0.15 / 2f64.sqrt())).length() < 1e-12);
        let dot = PACE.stations(&points(&[([1.0, 2.0, 3.0], 1.0)]));
        assert_eq!((dot.len(), dot[0].direction), (1, DVec3::ZERO));
    }

    #[test]
    fn an_airbrush_goes_on_where_the_hand_rests() {
        let mut line = points(&[([0.0; 3], 1.0), ([1.0, 0.0, 0.0], 1.0), ([1.0, 0.0, 0.0], 0.0)]);
        for (point, time) in line.iter_mut().zip([2.0, 3.0, 5.0]) {
            point.time = Some(time);
        }
        let pace = Pace { rate: 3.0, ..PACE };
        pace.check(&line).unwrap();
        let stations = pace.stations(&line);
        // Four steps and three ticks on the way, the last of both together, and six ticks at rest.
        assert_eq!(stations.len(), 1 + 4 + 3 + 6);
        assert!(stations.windows(2).all(|pair| pair[0].position.x <= pair[1].position.x));
        let rest = &stations[8..];
        assert!(rest.iter().all(|station| station.position == DVec3::X && station.direction == DVec3::X));
        assert!((rest[2].pressure - 0.5).abs() < 1e-9);
        line[1].time = None;
        assert!(pace.check(&line).is_err() && PACE.check(&line).is_ok());
        line[1].time = Some(1.0);
        assert!(PACE.check(&line).is_err());
    }

    #[test]
    fn a_lazy_brush_trails_behind_on_a_curve_of_pursuit() {
        // Drawn along a straight line at right angles to the string it goes along a tractrix (Huygens 1693): with the
        // string a, x = a (artanh cos t − cos t), y = a sin t.
        let a = 0.5;
        let line = points(&[([0.0, a, 0.0], 1.0), ([0.0; 3], 1.0), ([3.0, 0.0, 0.0], 1.0)]);
        let pace = Pace { step: 0.01, rate: 0.0, string: a };
        let mut trail = Vec::new();
        pace.trail(&line, &mut trail);
        let on_the_way = trail.iter().filter(|point| point.position.x > 0.01);
        for point in on_the_way {
            let (x, y) = (point.position.x, point.position.y);
            let cosine = (1.0 - (y / a).powi(2)).sqrt();
            let expected = a * (((1.0 + cosine) / (1.0 - cosine)).ln() * 0.5 - cosine);
            assert!((x - expected).abs() < 0.02, "{x} {expected}");
        }
        let last = trail.last().unwrap().position;
        assert!((last.distance(DVec3::new(3.0, 0.0, 0.0)) - a).abs() < 1e-9);
        // A hand that trembles less than the string leaves one dab.
        let tremor = points(&[([0.0; 3], 1.0), ([0.2, 0.1, 0.0], 1.0), ([-0.1, 0.3, 0.0], 1.0)]);
        assert_eq!(Pace { string: 0.5, ..PACE }.stations(&tremor).len(), 1);
    }

    #[test]
    fn points_that_cannot_be_are_refused() {
        let good = points(&[([0.0; 3], 1.0), ([1.0, 0.0, 0.0], 1.0)]);
        PACE.check(&good).unwrap();
        assert!(PACE.check(&[]).is_err());
        let spoil = |change: &dyn Fn(&mut StrokePoint)| {
            let mut bad = good.clone();
            change(&mut bad[1]);
            assert!(PACE.check(&bad).is_err(), "{bad:?}");
        };
        spoil(&|point| point.pressure = f64::NAN);
        spoil(&|point| point.pressure = 1.5);
        spoil(&|point| point.position.x = f64::INFINITY);
        spoil(&|point| point.position.x = 1e11);
        spoil(&|point| point.time = Some(f64::NAN));
        let mut slow = good.clone();
        (slow[0].time, slow[1].time) = (Some(0.0), Some(1e8));
        assert!(PACE.check(&slow).is_ok() && Pace { rate: 100.0, ..PACE }.check(&slow).is_err());
        assert!(Pace { string: 1e-9, ..PACE }.check(&good).is_err());
    }
}
