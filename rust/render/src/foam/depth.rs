//! Pass 3: the smoothed depth of sprites, the search radius and the normal of the nearest one (Akinci et al. 2013,
//! Section 2.1).

use glam::{Vec2, Vec3};

use super::projection::Projection;
use super::settings::FoamSettings;
use super::thickness::Thickness;
use super::{FoamKind, FoamParticle};

/// Sizes that particles of one radius r have: r/((i mod 5) + 1).
const SIZES: u32 = 5;
/// The radius in pixels of the smallest sprite that is drawn. Smaller ones are drawn as wide and as much thinner, so that the sum
/// of their thickness stays.
const MIN_RADIUS: f32 = 0.5;
/// Pixels from the middle of the picture beyond which no sprite is.
const FARTHEST: f32 = 1e6;

/// Returns the radius of a particle: r/((i mod 5) + 1), and half of that for bubbles.
#[inline]
pub fn radius(settings: &FoamSettings, particle: &FoamParticle) -> f32 {
    let size = settings.radius / (particle.id % SIZES + 1) as f32;
    if particle.kind == FoamKind::Bubble { 0.5 * size } else { size }
}

/// Returns the radius in pixels of the circle of confusion of a depth, of a thin lens.
#[inline]
fn blur(projection: &Projection, settings: &FoamSettings, depth: f32) -> f32 {
    let FoamSettings { aperture, focus, .. } = *settings;
    0.5 * aperture * (depth - focus).abs() / depth * projection.scale(focus)
}

/// A particle in the picture.
#[derive(Clone, Copy, Debug)]
pub struct Sprite {
    pub middle: Vec2,
    /// Depth of its middle, in metres.
    pub depth: f32,
    /// Its radius in metres.
    pub radius: f32,
    /// The same in pixels, which is its search radius h.
    pub search: f32,
    /// The radius in pixels with which it is drawn: at least half a pixel, and as wide as the lens blurs it.
    pub drawn: f32,
    /// What its fragments' thickness is multiplied by.
    pub share: f32,
    pub kind: FoamKind,
    pub id: u32,
}

/// A fragment of a sprite: where it is on the disc, from −1 to 1 to the right and up, and the square of its distance from
/// the middle.
#[derive(Clone, Copy, Debug)]
pub struct Fragment {
    pub u: f32,
    pub v: f32,
    pub square: f32,
    /// Depth of the sphere there, in metres.
    pub depth: f32,
}

impl Sprite {
    /// Returns the sprite of a particle; `None` if it is behind the camera, nearer than the settings allow, or invisible.
    #[inline]
    pub fn new(
        projection: &Projection,
        settings: &FoamSettings,
        thickness: &Thickness,
        particle: &FoamParticle,
    ) -> Option<Self> {
        let mut sprite = Self::unfaded(projection, settings, particle)?;
        sprite.share *= thickness.of_life(particle.life);
        (sprite.share > 0.0).then_some(sprite)
    }

    /// Returns the sprite that a particle has at the beginning of its life; `None` if it is behind the camera or nearer than the
    /// settings allow.
    #[inline]
    pub fn unfaded(projection: &Projection, settings: &FoamSettings, particle: &FoamParticle) -> Option<Self> {
        let place = projection.to_eye(particle.position);
        let middle = projection.to_picture(place);
        // A number that is infinite or none is in no range.
        let is_seen = (settings.near_depth..f32::MAX).contains(&place.z)
            && middle.x.abs() < FARTHEST
            && middle.y.abs() < FARTHEST;
        if !is_seen {
            return None;
        }
        let radius = radius(settings, particle);
        let search = radius * projection.scale(place.z);
        let wide = if settings.aperture > 0.0 { search.hypot(blur(projection, settings, place.z)) } else { search };
        let drawn = wide.max(MIN_RADIUS);
        let share = (search / drawn).powi(2);
        Some(Self { middle, depth: place.z, radius, search, drawn, share, kind: particle.kind, id: particle.id })
    }

    /// Returns its columns or rows below `size`, by the coordinate of its middle: the first and one after the last.
    #[inline]
    pub fn span(middle: f32, drawn: f32, size: u32) -> [u32; 2] {
        // Pixels have their middles at halves; a conversion of a negative number gives 0.
        let (first, last) = (middle - drawn - 0.5, middle + drawn - 0.5);
        let below = first as u32;
        let begin = below.saturating_add(u32::from((below as f32) < first));
        let end = if last < 0.0 { 0 } else { (last as u32).saturating_add(1) };
        [begin.min(size), end.min(size)]
    }

    /// Returns the fragment at the middle of a pixel; `None` outside of the disc.
    #[inline]
    pub fn fragment(&self, x: u32, y: u32) -> Option<Fragment> {
        let inverse = self.drawn.recip();
        let u = (x as f32 + 0.5 - self.middle.x) * inverse;
        let v = (self.middle.y - y as f32 - 0.5) * inverse;
        let square = u * u + v * v;
        // The eye space z of the paper grows towards the camera; depth falls.
        (square <= 1.0).then(|| Fragment { u, v, square, depth: self.depth - (1.0 - square).sqrt() * self.radius })
    }
}

/// The nearest fragment of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    pub depth: f32,
    pub id: u32,
    pub search: f32,
    pub u: f32,
    pub v: f32,
}

impl Default for Nearest {
    fn default() -> Self {
        Self { depth: f32::INFINITY, id: u32::MAX, search: 0.0, u: 0.0, v: 0.0 }
    }
}

impl Nearest {
    /// Takes a fragment if it is nearer than what there is, or as near and of a lower number.
    #[inline]
    pub fn take(&mut self, sprite: &Sprite, fragment: &Fragment) {
        let Fragment { u, v, depth, .. } = *fragment;
        // Where particles share a number too, their places decide, so that no order of them does.
        if (depth, sprite.id, u, v) < (self.depth, self.id, self.u, self.v) {
            *self = Self { depth, id: sprite.id, search: sprite.search, u, v };
        }
    }
}

/// Returns the unit normal of a fragment, to the right, up and towards the camera.
#[inline]
pub fn normal(u: f32, v: f32) -> Vec3 {
    Vec3::new(u, v, (1.0 - u * u - v * v).max(0.0).sqrt())
}
