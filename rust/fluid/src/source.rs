//! Where particles come from while a fluid is simulated, and where they go: emitters and sinks.

pub(crate) mod field;
pub(crate) mod shape;
pub(crate) mod solid;

use std::collections::HashMap;

use glam::{Vec3, Vec4Swizzles};
use relievo_core::{Error, Result};

use crate::boundary::lattice::{Lattice, lattice};
use crate::boundary::sampling::{Sample, sample};
use crate::solver::Fluid;
use crate::solver::particles::Batch;
use crate::source::solid::Solid;
use crate::surface::isosurface::Channel;

/// Where there is a particle within so many spacings of a place, none is emitted.
const TAKEN: f32 = 0.6;
/// The least distance of layers, in spacings: nearer ones would be taken for what is there already.
const CLOSEST: f64 = 0.7;
/// Layers that an emitter makes in a step, at most.
const MAX: f64 = 4096.0;
/// Places of them, at most.
const MAX_PLACES: f64 = 67_108_864.0;

/// What particles are emitted from: one layer after the other, each about as far from the one before as the spacing.
pub struct Emitter {
    places: Vec<Vec3>,
    velocities: Vec<Vec3>,
    /// Seconds between layers.
    period: f64,
    spacing: f32,
    /// When it begins and ends, in seconds.
    pub time: [f64; 2],
    /// Seconds that its particles live; infinite for particles that stay.
    pub lifetime: f32,
    /// What they carry: names of channels, and 1 to 4 numbers each.
    pub channels: Vec<(String, Vec<f32>)>,
}

impl Emitter {
    /// A disc about a place, whose particles go along its normal at a speed in m/s.
    ///
    /// # Errors
    /// Fails if the radius or the speed is not positive, a number is not finite, the normal has no length, or a layer
    /// would have no particle or 10⁷ or more in its square.
    pub fn disc(middle: Vec3, normal: Vec3, radius: f32, speed: f32, spacing: f32) -> Result<Self> {
        let direction = normal.normalize_or_zero();
        let (u, v) = if direction == Vec3::ZERO { (Vec3::ZERO, Vec3::ZERO) } else { direction.any_orthonormal_pair() };
        let mut emitter = Self::rectangle(middle, [radius * u, radius * v], speed, spacing)?;
        // As many as its area has room for.
        emitter.places.retain(|place| place.distance(middle) <= radius);
        emitter.filled()
    }

    /// A rectangle about a place, by half its sides, whose particles go at right angles to both, along their cross product.
    ///
    /// # Errors
    /// Fails if a side is shorter than half a spacing, the sides are parallel, a layer would have 10⁷ particles or
    /// more, or the speed is not positive or a number not finite.
    pub fn rectangle(middle: Vec3, [u, v]: [Vec3; 2], speed: f32, spacing: f32) -> Result<Self> {
        let count = [u, v].map(|side| (2.0 * side.length() / spacing).round());
        let normal = u.cross(v).normalize_or_zero();
        if !(count[0] >= 1.0
            && count[1] >= 1.0
            && count[0] * count[1] < 1e7
            && normal != Vec3::ZERO
            && middle.is_finite())
        {
            let [long, wide] = [u, v].map(|side| 2.0 * side.length());
            let what = format!("an emitter of {long} m by {wide} m has no layer of particles {spacing} m apart");
            return Err(Error::invalid(what)
                .advise("give it sides of half a spacing to a few thousand, and not parallel, or a normal"));
        }
        let part = |number: u32, count: f32| (2.0 * number as f32 + 1.0) / count - 1.0;
        let rows = (0..count[1] as u32).flat_map(|y| (0..count[0] as u32).map(move |x| (x, y)));
        let places = rows.map(|(x, y)| middle + part(x, count[0]) * u + part(y, count[1]) * v);
        Self::new(places.collect(), vec![speed * normal], speed, spacing)
    }

    /// The surface of triangles, from which particles go along normals at a speed in m/s, half a spacing before it at first.
    ///
    /// Where all triangles face the same way the places are a lattice, and those are taken whose cell has its middle in the
    /// mesh; else they cover it up to its edges. Layers come as often as the volume is that of the area at the speed.
    ///
    /// # Errors
    /// Fails if a point is not finite or does not exist, there is no triangle, the mesh is too large for the spacing or
    /// has no room for a particle, or the speed is not positive.
    pub fn mesh(points: &[Vec3], triangles: &[[u32; 3]], speed: f32, spacing: f32) -> Result<Self> {
        Solid::new(points, triangles)?;
        let (places, normals, area) = match lattice(points, triangles, spacing)? {
            Some(Lattice { places, normal, area }) => (places, vec![normal], area),
            None => covered(points, triangles, spacing)?,
        };
        let moved = places.iter().zip(normals.iter().cycle()).map(|(place, normal)| *place + 0.5 * spacing * *normal);
        let velocities = normals.iter().map(|normal| speed * *normal).collect();
        let emitter = Self::new(moved.collect(), velocities, speed, spacing)?.filled()?;
        let share = places.len() as f64 * f64::from(spacing).powi(2) / area;
        Ok(Self { period: emitter.period * share.max(CLOSEST), ..emitter })
    }

    fn new(places: Vec<Vec3>, velocities: Vec<Vec3>, speed: f32, spacing: f32) -> Result<Self> {
        let period = f64::from(spacing) / f64::from(speed);
        if !(speed > 0.0 && period > 1e-9 && period.is_finite()) {
            return Err(Error::invalid(format!("an emitter cannot emit at {speed} m/s")).advise("use a positive speed"));
        }
        let (time, lifetime) = ([0.0, f64::INFINITY], f32::INFINITY);
        Ok(Self { places, velocities, period, spacing, time, lifetime, channels: Vec::new() })
    }

    fn filled(self) -> Result<Self> {
        if self.places.is_empty() {
            return Err(Error::invalid("an emitter is too small for a particle").advise("let it be a spacing or more"));
        }
        Ok(self)
    }

    /// How many particles a layer has.
    pub fn layer(&self) -> usize {
        self.places.len()
    }

    /// How many particles it makes in a second, where nothing is in their way.
    pub fn rate(&self) -> f64 {
        self.layer() as f64 / self.period
    }

    /// Adds the layers that began between a time and the fluid's own, each where it is by now, but no particle where one is
    /// already, nor a layer for which there is no room within the budget. Returns how many were added.
    fn emit(&self, fluid: &mut Fluid, since: f64, (most, overflow): (usize, Overflow)) -> Result<usize> {
        let now = fluid.seconds().min(self.time[1]);
        // Layers by their numbers, so that each is made in one step alone.
        let number = |time: f64| ((time - self.time[0]).max(0.0) / self.period).ceil();
        let (first, end) = (number(since), if now > self.time[0] { number(now) } else { 0.0 });
        if end - first > MAX || (end - first) * self.layer() as f64 > MAX_PLACES {
            return Err(Error::invalid(format!("an emitter would make {} layers in a step", end - first))
                .advise("let its particles be slower, or steps shorter"));
        }
        if first >= end {
            return Ok(0);
        }
        let before = fluid.count()?;
        let mut count = before;
        let mut layer = first;
        while layer < end {
            if count + self.layer() > most {
                match overflow {
                    Overflow::Stop => break,
                    Overflow::Refuse => {
                        return Err(Error::memory(format!("a fluid would have more than {most} particles"))
                            .advise("raise the budget, add a sink, give particles a lifetime, or let emitters stop"));
                    }
                }
            }
            let age = (fluid.seconds() - self.time[0] - layer * self.period) as f32;
            let velocities = self.velocities.iter().cycle();
            let moved = self.places.iter().zip(velocities).map(|(place, velocity)| *place + age * *velocity);
            let moved: Vec<Vec3> = moved.collect();
            let mut is_free = free(fluid, &moved, TAKEN * self.spacing);
            fluid.agree(&mut is_free)?;
            let kept = |list: &[Vec3]| -> Vec<Vec3> {
                is_free.iter().zip(list.iter().cycle()).filter(|(is_free, _)| **is_free).map(|(_, row)| *row).collect()
            };
            let channels = self.channels.iter().map(|(name, values)| Channel { name, width: values.len(), values });
            let channels: Vec<Channel> = channels.collect();
            let (places, velocities) = (kept(&moved), kept(&self.velocities));
            if !places.is_empty() {
                let batch =
                    Batch { places: &places, velocities: &velocities, lifetime: self.lifetime, channels: &channels };
                fluid.emit(&batch)?;
                count += places.len();
            }
            layer += 1.0;
        }
        Ok(count - before)
    }
}

/// Places all over a mesh, with the normals there, and its area.
fn covered(points: &[Vec3], triangles: &[[u32; 3]], spacing: f32) -> Result<(Vec<Vec3>, Vec<Vec3>, f64)> {
    let cross = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|point| points[point as usize]);
        (b - a).cross(c - a)
    };
    let samples = sample(points, triangles, spacing)?;
    let normal = |sample: &Sample| cross(&triangles[sample.triangle as usize]).normalize_or_zero();
    let pairs = samples.iter().map(|sample| (sample.of(points, triangles), normal(sample)));
    let (places, normals) = pairs.filter(|(_, normal)| *normal != Vec3::ZERO).unzip();
    Ok((places, normals, triangles.iter().map(|triangle| 0.5 * f64::from(cross(triangle).length())).sum()))
}

/// Which of some places have no particle within a radius.
fn free(fluid: &Fluid, places: &[Vec3], radius: f32) -> Vec<bool> {
    let low = places.iter().fold(Vec3::INFINITY, |low, place| low.min(*place)) - radius;
    let high = places.iter().fold(Vec3::NEG_INFINITY, |high, place| high.max(*place)) + radius;
    // A little wider than the radius, as numbers are rounded; what is 2³¹ cells away is in the last.
    let cell = |place: Vec3| ((place - low) / (1.01 * radius)).floor().to_array().map(|at| i64::from(at as i32));
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (number, place) in places.iter().enumerate() {
        cells.entry(cell(*place)).or_default().push(number);
    }
    let mut is_free = vec![true; places.len()];
    let is_near = |place: &Vec3| place.cmpge(low).all() && place.cmple(high).all();
    for other in fluid.places().iter().map(|place| place.xyz()).filter(is_near) {
        let [x, y, z] = cell(other);
        for around in 0..27 {
            let beside = [x + around % 3 - 1, y + around / 3 % 3 - 1, z + around / 9 - 1];
            for number in cells.get(&beside).into_iter().flatten() {
                is_free[*number] &= other.distance_squared(places[*number]) >= radius * radius;
            }
        }
    }
    is_free
}

/// What takes particles away.
pub enum Sink {
    /// Those within a box, by its low and high corners in metres.
    Inside([Vec3; 2]),
    /// Particles that are not within it.
    Outside([Vec3; 2]),
    /// Those inside of a mesh.
    Mesh(Solid),
}

impl Sink {
    fn takes(&self, place: Vec3) -> bool {
        let is_in = |[low, high]: &[Vec3; 2]| place.cmpge(*low).all() && place.cmple(*high).all();
        match self {
            Self::Inside(ends) => is_in(ends),
            Self::Outside(ends) => !is_in(ends),
            Self::Mesh(solid) => solid.is_inside(place),
        }
    }
}

/// What happens where a fluid has as many particles as it may.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overflow {
    /// It is an error.
    #[default]
    Refuse,
    /// Emitters stop until sinks have made room.
    Stop,
}

/// Emitters and sinks of a fluid.
#[derive(Default)]
pub struct Sources {
    /// Where particles come from.
    pub emitters: Vec<Emitter>,
    /// Where they go.
    pub sinks: Vec<Sink>,
    /// Particles at most, beyond which emitters add none; `None` for as many as there may be.
    pub budget: Option<usize>,
    /// What happens then.
    pub overflow: Overflow,
}

impl Sources {
    /// Takes away what sinks reach and adds what was emitted since a time, in seconds; called after each step with the
    /// time at which that began, it does the same in a run that goes on from a state. Of a fluid in domains, all ranks
    /// call it alike. Returns how many particles were added, on all ranks, and removed, on this one.
    ///
    /// # Errors
    /// Fails if there are more particles than the budget and [`Overflow::Refuse`] holds, an emitter would make too many
    /// layers in a step, a channel of an emitter does not fit, or another rank has ended.
    pub fn renew(&self, fluid: &mut Fluid, since: f64) -> Result<[usize; 2]> {
        let gone: Vec<bool> = if self.sinks.is_empty() {
            Vec::new()
        } else {
            fluid.places().iter().map(|place| self.sinks.iter().any(|sink| sink.takes(place.xyz()))).collect()
        };
        let removed = fluid.remove(|particle| gone.get(particle).is_some_and(|gone| *gone));
        let mut added = 0;
        for (number, emitter) in self.emitters.iter().enumerate() {
            let room = (self.budget.unwrap_or(usize::MAX), self.overflow);
            added += emitter.emit(fluid, since, room).map_err(|error| error.at(format!("emitter {number}")))?;
        }
        if added > 0 || !self.sinks.is_empty() {
            fluid.find_fastest()?;
        }
        Ok([added, removed])
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use relievo_core::Context;

    use super::*;
    use crate::{FluidOptions, State};

    fn weightless(spacing: f32) -> Fluid {
        Fluid::new(FluidOptions { spacing, gravity: Vec3::ZERO, ..FluidOptions::default() }).unwrap()
    }

    fn run(fluid: &mut Fluid, sources: &Sources, seconds: f32) -> Result<()> {
        let mut since = fluid.seconds();
        fluid.advance(&Context::serial(), seconds, |fluid, _| {
            sources.renew(fluid, since)?;
            since = fluid.seconds();
            Ok(())
        })
    }

    #[test]
    fn layers_join_to_a_jet_that_has_the_density_at_rest() {
        let mut fluid = weightless(0.05);
        let mut emitter = Emitter::disc(Vec3::ZERO, Vec3::X, 0.2, 2.0, 0.05).unwrap();
        emitter.channels.push(("color".into(), vec![0.2, 0.4, 0.8]));
        let layer = emitter.layer();
        let sources = Sources { emitters: vec![emitter], ..Sources::default() };
        run(&mut fluid, &sources, 0.4975).unwrap();
        // 0.995 m of it, a layer each 0.05 m.
        assert_eq!(fluid.len(), 20 * layer);
        assert!(fluid.velocities().iter().all(|velocity| velocity.xyz().distance(Vec3::X * 2.0) < 0.1));
        let mut along: Vec<f32> = fluid.places().iter().map(|place| place.x).collect();
        along.sort_unstable_by(f32::total_cmp);
        for layers in along.chunks(layer).collect::<Vec<_>>().windows(2) {
            assert!((layers[1][0] - layers[0][0] - 0.05).abs() < 0.005, "{:?} {:?}", layers[0], layers[1]);
        }
        let color = &fluid.channels()[0];
        assert!(color.name == "color" && color.values.chunks(3).all(|color| color == [0.2, 0.4, 0.8]));
    }

    #[test]
    fn what_is_emitted_lives_as_long_as_it_should_and_goes_where_sinks_are() {
        let mut fluid = weightless(0.05);
        let rectangle = || Emitter::rectangle(Vec3::ZERO, [Vec3::Y * 0.1, Vec3::Z * 0.1], 1.0, 0.05).unwrap();
        let short = Emitter { lifetime: 0.2, time: [0.0, 0.31], ..rectangle() };
        let sources = Sources { emitters: vec![short], ..Sources::default() };
        run(&mut fluid, &sources, 0.3).unwrap();
        assert!((0.15..0.3).contains(&fluid.places().iter().map(|place| place.x).fold(0.0, f32::max)));
        run(&mut fluid, &sources, 0.3).unwrap();
        assert!(fluid.is_empty());
        let sinks = vec![Sink::Inside([Vec3::new(0.3, -1.0, -1.0), Vec3::ONE]), Sink::Outside([-Vec3::ONE, Vec3::ONE])];
        let later = Emitter { time: [0.73, f64::INFINITY], ..rectangle() };
        let sources = Sources { emitters: vec![later], sinks, ..Sources::default() };
        run(&mut fluid, &sources, 0.1).unwrap();
        assert!(fluid.is_empty());
        fluid.add(&[Vec3::splat(3.0)], Vec3::ZERO).unwrap();
        run(&mut fluid, &sources, 0.6).unwrap();
        assert_eq!(fluid.len(), 6 * 16);
        // It goes on from a state to the bit.
        let mut other = weightless(0.05);
        other.set_state(State::clone(&fluid.state())).unwrap();
        for fluid in [&mut fluid, &mut other] {
            run(fluid, &sources, 0.1).unwrap();
        }
        assert_eq!(fluid.state(), other.state());
    }

    /// A disc or, of four corners, a square, in a plane that is turned, of triangles about its middle.
    fn polygon(corners: u32, radius: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let turn = glam::Quat::from_scaled_axis(Vec3::new(0.3, -0.8, 0.5));
        let at = |corner: u32| glam::Vec2::from_angle(TAU * corner as f32 / corners as f32).extend(0.0);
        let rim = (0..corners).map(|corner| Vec3::splat(0.7) + turn * (radius * at(corner)));
        let points = std::iter::once(Vec3::splat(0.7)).chain(rim).collect();
        (points, (0..corners).map(|corner| [0, 1 + corner, 1 + (corner + 1) % corners]).collect())
    }

    #[test]
    fn flat_meshes_emit_their_area_times_their_speed() {
        let (spacing, speed) = (0.05, 2.0);
        for size in [3.0, 3.4, 4.0, 5.5, 7.25, 10.0, 20.0f32] {
            for corners in [4, 60] {
                let radius = if corners == 4 { size * spacing * 0.5f32.sqrt() } else { 0.5 * size * spacing };
                let (points, mut triangles) = polygon(corners, radius);
                let area = 0.5 * corners as f32 * radius * radius * (TAU / corners as f32).sin();
                let emitter = Emitter::mesh(&points, &triangles, speed, spacing).unwrap();
                let flow = emitter.rate() * f64::from(spacing).powi(3);
                let due = f64::from(area * speed);
                assert!((flow / due - 1.0).abs() < 1e-4, "{corners} {size}: {flow} {due}");
                // What is whole is as a lattice of it, and layers are as far apart as particles.
                let share = emitter.period * f64::from(speed / spacing);
                assert!((0.85..1.2).contains(&share), "{corners} {size}: {share}");
                if corners == 4 && size.fract() == 0.0 {
                    assert_eq!(emitter.layer(), (size * size) as usize);
                }
                let within =
                    emitter.places.iter().all(|place| place.distance(Vec3::splat(0.7)) < radius + 0.5 * spacing);
                let apart = (0..emitter.layer())
                    .all(|a| (0..a).all(|b| emitter.places[a].distance(emitter.places[b]) > 0.999 * spacing));
                assert!(within && apart);
                // Lying on itself, it is the same.
                triangles.extend(triangles.clone());
                let twice = Emitter::mesh(&points, &triangles, speed, spacing).unwrap();
                assert_eq!(twice.layer(), emitter.layer());
                assert!((twice.period / emitter.period - 1.0).abs() < 0.08, "{} {}", twice.period, emitter.period);
            }
        }
        // A surface that is not flat too.
        let (points, triangles) = crate::sphere(Vec3::ZERO, 0.2);
        let emitter = Emitter::mesh(&points, &triangles, speed, spacing).unwrap();
        let flow = emitter.rate() * f64::from(spacing).powi(3);
        assert!((flow / (f64::from(speed) * 2.0 * f64::from(TAU) * 0.04) - 1.0).abs() < 0.01, "{flow}");
    }

    #[test]
    fn a_jet_of_a_square_mesh_has_the_volume_that_is_due() {
        let mut fluid = weightless(0.05);
        let (points, triangles) = polygon(4, 0.17 * 0.5f32.sqrt());
        let sources =
            Sources { emitters: vec![Emitter::mesh(&points, &triangles, 2.0, 0.05).unwrap()], ..Sources::default() };
        run(&mut fluid, &sources, 1.0).unwrap();
        let volume = fluid.len() as f32 * 0.05f32.powi(3);
        assert!((volume / (0.17 * 0.17 * 2.0) - 1.0).abs() < 0.03, "{volume}");
    }

    #[test]
    fn emitters_in_a_fluid_add_nothing_where_it_is_and_keep_within_a_budget() {
        let mut fluid = weightless(0.05);
        let (points, triangles) = crate::cuboid(Vec3::ZERO, Vec3::splat(0.3));
        let mesh = || Emitter::mesh(&points, &triangles, 0.5, 0.05).unwrap();
        let full =
            Sources { emitters: vec![mesh()], budget: Some(500), overflow: Overflow::Stop, ..Sources::default() };
        run(&mut fluid, &full, 0.5).unwrap();
        assert!((200..=500).contains(&fluid.len()), "{}", fluid.len());
        let least = |fluid: &Fluid| {
            let places = fluid.places();
            let pairs = (0..places.len()).flat_map(|a| (0..a).map(move |b| places[a].xyz().distance(places[b].xyz())));
            pairs.fold(1.0, f32::min)
        };
        assert!(least(&fluid) > 0.02, "{}", least(&fluid));
        let refused = Sources { emitters: vec![mesh()], budget: Some(500), ..Sources::default() };
        assert!(run(&mut fluid, &refused, 0.5).unwrap_err().to_string().contains("emitter 0"));
        // Layers that begin in the same step are counted one by one.
        for more in [0, 1] {
            let mut fluid = weightless(0.05);
            let fast = Emitter::disc(Vec3::ZERO, Vec3::X, 0.2, 100.0, 0.05).unwrap();
            let (layer, most) = (fast.layer(), Some(2 * fast.layer() + more));
            let swift = Sources { emitters: vec![fast], budget: most, overflow: Overflow::Stop, ..Sources::default() };
            run(&mut fluid, &swift, 0.02).unwrap();
            assert_eq!(fluid.len(), 2 * layer);
        }
        assert!(Emitter::disc(Vec3::ZERO, Vec3::ZERO, 0.2, 1.0, 0.05).is_err());
        assert!(Emitter::disc(Vec3::ZERO, Vec3::X, 0.2, 0.0, 0.05).is_err());
        assert!(Emitter::disc(Vec3::ZERO, Vec3::X, f32::NAN, 1.0, 0.05).is_err());
        assert!(Emitter::mesh(&points, &[], 1.0, 0.05).is_err());
    }
}
