//! The light around foam, as a map of radiance by direction, and the map of irradiance that is made of it.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use relievo_core::{Context, Error, Result};

use crate::color::Color;
use crate::image::Image;
use crate::light::Lights;

/// Rows of a map of radiance, of whatever a picture has. Maps are twice as wide.
const ROWS: u32 = 64;
/// Rows of a map of irradiance.
const IRRADIANCE_ROWS: u32 = 16;
/// The greatest radiance: that of half floats.
const BRIGHTEST: f32 = 65_504.0;

/// Light by direction: a map twice as wide as high, the top row upwards, as environment pictures have it.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    radiance: Map,
    /// Upwards, and the two directions across it of longitudes 0 and a quarter turn.
    axes: [Vec3; 3],
}

/// Values by latitude and longitude.
#[derive(Clone, Debug, PartialEq)]
struct Map {
    rows: u32,
    values: Vec<Vec3>,
}

impl Map {
    fn columns(&self) -> u32 {
        2 * self.rows
    }

    /// Returns the value between the four texels about a place, both of its coordinates 0 to 1.
    fn at(&self, place: Vec2) -> Vec3 {
        let (columns, rows) = (self.columns() as i32, self.rows as i32);
        let (x, y) = (place.x * columns as f32 - 0.5, place.y * rows as f32 - 0.5);
        let texel = |x: i32, y: i32| {
            let (x, y) = (x.rem_euclid(columns), y.clamp(0, rows - 1));
            self.values[(y * columns + x) as usize]
        };
        let (left, top) = (x.floor() as i32, y.floor() as i32);
        let (right_share, bottom_share) = (x - x.floor(), y - y.floor());
        let upper = texel(left, top).lerp(texel(left + 1, top), right_share);
        upper.lerp(texel(left, top + 1).lerp(texel(left + 1, top + 1), right_share), bottom_share)
    }
}

/// A map of light by direction as graphics devices look it up, row after row.
pub struct LightMap {
    pub rows: u32,
    pub values: Vec<Vec3>,
    /// Those of the environment.
    pub axes: [Vec3; 3],
}

/// Returns the columns and rows of the texels of a map, in order.
fn texels(rows: u32) -> impl Iterator<Item = (u32, u32)> {
    (0..rows).flat_map(move |y| (0..2 * rows).map(move |x| (x, y)))
}

/// Returns the direction to the middle of a texel, along the axes of a map.
fn direction(x: u32, y: u32, rows: u32) -> Vec3 {
    let polar = PI * (y as f32 + 0.5) / rows as f32;
    // The middle of the map is longitude 0, and longitudes grow to the left, as Blender has it.
    let around = TAU * (0.5 - (x as f32 + 0.5) / (2 * rows) as f32);
    Vec3::new(polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos())
}

/// Returns the solid angle of a texel of a row.
fn solid_angle(y: u32, rows: u32) -> f32 {
    let polar = |y: u32| PI * y as f32 / rows as f32;
    (polar(y).cos() - polar(y + 1).cos()) * TAU / (2 * rows) as f32
}

impl Environment {
    /// Makes an environment of the same radiance everywhere.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is negative or not a number.
    pub fn uniform(radiance: Color) -> Result<Self> {
        Self::of_image(&Image::from_data(2, 1, 3, [radiance, radiance].concat())?, [0.0, 0.0, 1.0])
    }

    /// Makes an environment of a picture by latitude and longitude, twice as wide as high, whose top row is `up`.
    /// Infinite radiance counts as 65,504.
    ///
    /// # Errors
    /// Fails with `Invalid` if a number is negative or not a number, the picture has another shape, or `up` has no
    /// length.
    pub fn of_image(image: &Image, up: [f32; 3]) -> Result<Self> {
        let (width, height) = (image.width(), image.height());
        if width != 2 * height || !matches!(image.channels(), 1 | 3 | 4) {
            return Err(Error::invalid(format!(
                "an environment has {width} × {height} pixels of {} channels",
                image.channels()
            ))
            .advise("use a picture by latitude and longitude, twice as wide as high, grey or in colour"));
        }
        if image.data().iter().any(|value| value.is_nan() || *value < 0.0) {
            return Err(Error::invalid("the environment has radiance that is negative or not a number")
                .advise("repair the picture"));
        }
        let axes = axes(up)?;
        let value = |x: u32, y: u32| Vec3::from(image.color(x, y)).min(Vec3::splat(BRIGHTEST));
        let mean = |x: u32, y: u32| {
            let span = |at: u32, size: u32, count: u32| {
                let [from, to] = [at, at + 1].map(|at| u64::from(at) * u64::from(size) / u64::from(count));
                from as u32..to as u32
            };
            let (mut sum, mut angles) = (Vec3::ZERO, 0.0);
            for row in span(y, height, ROWS) {
                for column in span(x, width, 2 * ROWS) {
                    sum += solid_angle(row, height) * value(column, row);
                    angles += solid_angle(row, height);
                }
            }
            sum / angles
        };
        let values = if height >= ROWS {
            texels(ROWS).map(|(x, y)| mean(x, y)).collect()
        } else {
            let coarse = Map { rows: height, values: texels(height).map(|(x, y)| value(x, y)).collect() };
            let middle = |(x, y): (u32, u32)| Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            texels(ROWS).map(|texel| coarse.at(middle(texel) / Vec2::new((2 * ROWS) as f32, ROWS as f32))).collect()
        };
        Ok(Self { radiance: Map { rows: ROWS, values }, axes })
    }

    /// Makes the environment of lights: their sky with their suns in it.
    ///
    /// # Errors
    /// Fails as [`Lights::check`] does.
    pub fn of_lights(lights: &Lights) -> Result<Self> {
        lights.check()?;
        let axes = axes(lights.sky.up)?;
        let world = |x: u32, y: u32| to_world(&axes, direction(x, y, ROWS));
        let mut values: Vec<Vec3> = texels(ROWS).map(|(x, y)| lights.sky.radiance(axes[0], world(x, y))).collect();
        for sun in &lights.suns {
            let to_sun = Vec3::from(sun.direction).normalize_or(axes[0]);
            let facing = |(x, y): &(u32, u32)| world(*x, *y).dot(to_sun);
            let nearest = texels(ROWS).max_by(|a, b| facing(a).total_cmp(&facing(b)));
            if let Some((x, y)) = nearest {
                values[(y * 2 * ROWS + x) as usize] += Vec3::from(sun.irradiance) / solid_angle(y, ROWS);
            }
        }
        Ok(Self { radiance: Map { rows: ROWS, values }, axes })
    }

    /// Returns the radiance from a direction of unit length.
    pub(super) fn radiance(&self, direction: Vec3) -> Vec3 {
        self.radiance.at(self.place(direction))
    }

    /// Returns the map of radiance for a device.
    pub(super) fn radiance_map(&self) -> LightMap {
        LightMap { rows: self.radiance.rows, values: self.radiance.values.clone(), axes: self.axes }
    }

    /// Returns the map of irradiance for a device.
    pub(super) fn irradiance_map(&self, context: &Context) -> LightMap {
        let Map { rows, values } = self.irradiance(context).map;
        LightMap { rows, values, axes: self.axes }
    }

    /// Returns where a direction is in a map.
    fn place(&self, direction: Vec3) -> Vec2 {
        let [up, first, second] = self.axes.map(|axis| axis.dot(direction));
        let polar = up.clamp(-1.0, 1.0).acos();
        Vec2::new(0.5 - second.atan2(first) / TAU, polar / PI)
    }

    /// Returns the map of irradiance by normal.
    pub(super) fn irradiance(&self, context: &Context) -> IrradianceMap<'_> {
        let rows = IRRADIANCE_ROWS;
        let light: Vec<(Vec3, f32, Vec3)> = texels(ROWS)
            .zip(&self.radiance.values)
            .map(|((x, y), value)| (direction(x, y, ROWS), solid_angle(y, ROWS), *value))
            .collect();
        let values = context.map((2 * rows * rows) as usize, |at| {
            let normal = direction(at as u32 % (2 * rows), at as u32 / (2 * rows), rows);
            let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
            for (direction, angle, value) in &light {
                let weight = angle * direction.dot(normal).max(0.0);
                sum += weight * *value;
                weights += weight;
            }
            if weights > 0.0 { sum / weights } else { Vec3::ZERO }
        });
        IrradianceMap { environment: self, map: Map { rows, values } }
    }
}

/// Irradiance by normal, as that of a white environment of the same light: divided by π.
pub struct IrradianceMap<'a> {
    environment: &'a Environment,
    map: Map,
}

impl IrradianceMap<'_> {
    /// Returns the irradiance of a normal of unit length.
    pub fn at(&self, normal: Vec3) -> Vec3 {
        self.map.at(self.environment.place(normal))
    }
}

/// Returns upwards and two directions across it. For z upwards these are x and y, for y upwards x and −z.
fn axes(up: [f32; 3]) -> Result<[Vec3; 3]> {
    let up = Vec3::from(up).try_normalize();
    let up = up.ok_or_else(|| Error::invalid("the upward direction of the environment has no length"))?;
    let other = if up.x.abs() < 0.9 { Vec3::X } else { Vec3::Y };
    let first = (other - up * up.dot(other)).normalize();
    Ok([up, first, up.cross(first)])
}

fn to_world([up, first, second]: &[Vec3; 3], direction: Vec3) -> Vec3 {
    *first * direction.x + *second * direction.y + *up * direction.z
}
