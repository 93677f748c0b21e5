//! The reference ray caster: direct light with shadows, sky light with occlusion, and the geometry behind each pixel.
//!
//! Light is in radiance, scene-linear Rec.709. Diffuse reflection is Lambert's; the glossy part has the GGX
//! distribution (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", Section 5.2). Rays are
//! traced eight at a time, in an order that does not depend on the threads.

use glam::{Vec2, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_embree::{Hit, Ray};

use crate::camera::Rays;
use crate::facet::{Facet, Place};
use crate::image::Image;
use crate::sampling::{Shift, cone, cosine_hemisphere, in_pixel};
use crate::scene::{Material, Placed, Scene};
use crate::settings::View;
use crate::sky::{ClearSky, SkyLight, reflected_row};

/// Object number where there is none.
pub const NO_OBJECT: u32 = u32::MAX;

/// A rendered picture and what is behind its pixels. All but the colour is for the middle of each pixel.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Radiance, scene-linear Rec.709.
    pub color: Image,
    /// Distance along the direction of view, infinite where nothing is hit.
    pub depth: Image,
    /// Unit normal in world space, to the side that is seen; zero where nothing is hit.
    pub normal: Image,
    /// Diffuse reflectance, false colours and lines left out; zero where nothing is hit.
    pub albedo: Image,
    /// Number of the object, [`NO_OBJECT`] where nothing is hit.
    pub object: Vec<u32>,
}

/// Side of the square of pixels that is one item of work.
const BLOCK: u32 = 16;

/// What camera rays find, without the sky's light on surfaces.
#[derive(Clone, Copy)]
struct Found {
    color: Vec3,
    depth: f32,
    normal: Vec3,
    albedo: Vec3,
    object: u32,
}

impl Scene {
    /// Renders the scene.
    ///
    /// # Errors
    /// The view cannot be used, or the picture would not fit into the context's memory limit.
    pub fn render(&mut self, context: &Context, view: &View) -> Result<Frame> {
        view.check()?;
        let (width, height) = (view.settings.width, view.settings.height);
        let pixels = u64::from(width) * u64::from(height);
        if pixels.saturating_mul(2 * size_of::<(Found, SkyLight)>() as u64) > context.memory_limit() {
            return Err(Error::memory(format!("a picture of {width}×{height} pixels does not fit the memory limit"))
                .advise("make the picture smaller or the limit larger"));
        }
        let stats = context.stats();
        let mut stage = stats.begin("render.build");
        stage.count("triangles", self.triangle_count());
        let placed = self.placed(view.camera.eye)?;
        stage.end();
        let mut stage = stats.begin("render.trace");
        stage.count("pixels", pixels);
        let caster = Caster::new(&placed, view);
        let columns = width.div_ceil(BLOCK);
        let blocks = columns * height.div_ceil(BLOCK);
        let found = context
            .map(blocks as usize, |block| caster.block(block as u32 % columns * BLOCK, block as u32 / columns * BLOCK));
        let mut frame = Frame {
            color: Image::new(width, height, 3)?,
            depth: Image::new(width, height, 1)?,
            normal: Image::new(width, height, 3)?,
            albedo: Image::new(width, height, 3)?,
            object: vec![NO_OBJECT; pixels as usize],
        };
        let mut sky = vec![SkyLight::default(); pixels as usize];
        for (block, found) in (0..blocks).zip(found) {
            let (left, top) = (block % columns * BLOCK, block / columns * BLOCK);
            let side = BLOCK.min(width - left);
            for (index, (found, light)) in (0..).zip(found) {
                let (x, y) = (left + index % side, top + index / side);
                let at = y as usize * width as usize + x as usize;
                frame.color.set_color(x, y, found.color.to_array());
                frame.normal.set_color(x, y, found.normal.to_array());
                frame.albedo.set_color(x, y, found.albedo.to_array());
                frame.depth.data_mut()[at] = found.depth;
                frame.object[at] = found.object;
                sky[at] = light;
            }
        }
        let radius = view.settings.sky_filter;
        let rows = context.map(height as usize, |y| reflected_row(&frame, &sky, &caster.rays, radius, y as u32));
        for (color, light) in frame.color.data_mut().chunks_exact_mut(3).zip(rows.into_iter().flatten()) {
            for (value, light) in color.iter_mut().zip(light.to_array()) {
                *value += light;
            }
        }
        stage.end();
        Ok(frame)
    }
}

/// A sun, prepared.
struct SunCone {
    direction: Vec3,
    cos: f32,
    irradiance: Vec3,
}

struct Caster<'a> {
    placed: &'a Placed<'a>,
    view: &'a View,
    rays: Rays,
    suns: Vec<SunCone>,
    up: Vec3,
    clear: ClearSky,
}

/// A camera ray.
#[derive(Clone, Copy)]
struct Shot {
    pixel: [u32; 2],
    sample: u32,
    direction: Vec3,
}

/// A surface that a camera ray sees.
struct Seen<'a> {
    shot: Shot,
    depth: f32,
    object: u32,
    place: Place,
    material: &'a Material,
    /// Diffuse reflectance, and the same under false colours.
    albedo: Vec3,
    tinted: Vec3,
    /// How much of it the wireframe covers.
    line: f32,
}

/// Rays that are traced together.
const LANES: usize = 8;

impl<'a> Caster<'a> {
    fn new(placed: &'a Placed<'a>, view: &'a View) -> Self {
        let suns = view.lights.suns.iter().map(|sun| SunCone {
            direction: Vec3::from(sun.direction).normalize(),
            cos: sun.angular_radius.cos(),
            irradiance: Vec3::from(sun.irradiance),
        });
        Self {
            placed,
            view,
            rays: view.camera.rays(view.settings.width, view.settings.height),
            suns: suns.collect(),
            up: Vec3::from(view.lights.sky.up).normalize(),
            clear: ClearSky::new(&view.lights.sky),
        }
    }

    /// The pixels of the block whose top left pixel is (left, top), row after row.
    fn block(&self, left: u32, top: u32) -> Vec<(Found, SkyLight)> {
        let settings = &self.view.settings;
        let (right, bottom) = ((left + BLOCK).min(settings.width), (top + BLOCK).min(settings.height));
        let shots = (top..bottom).flat_map(|y| (left..right).map(move |x| [x, y])).flat_map(|pixel| {
            (0..settings.samples).map(move |sample| {
                let place = Vec2::new(pixel[0] as f32, pixel[1] as f32) + in_pixel(sample);
                Shot { pixel, sample, direction: self.rays.direction(place.x, place.y) }
            })
        });
        let mut shots = shots.peekable();
        let mut pixels: Vec<(Found, SkyLight)> = Vec::with_capacity((BLOCK * BLOCK) as usize);
        let share = 1.0 / settings.samples as f32;
        while shots.peek().is_some() {
            let packet: [Option<Shot>; LANES] = std::array::from_fn(|_| shots.next());
            for (shot, (mut found, light)) in packet.iter().flatten().zip(self.trace(&packet)) {
                found.color *= share;
                let light = light.scaled(share);
                match pixels.last_mut() {
                    Some((pixel, sky)) if shot.sample > 0 => {
                        pixel.color += found.color;
                        sky.add(&light);
                    }
                    _ => pixels.push((found, light)),
                }
            }
        }
        pixels
    }

    /// What rays find, their colours without the sky's light on surfaces, which is given apart. The rays that exist are
    /// the first ones of the packet.
    fn trace(&self, packet: &[Option<Shot>; LANES]) -> [(Found, SkyLight); LANES] {
        let rays = packet.map(|shot| Some(Ray::new([0.0; 3], shot?.direction.to_array())));
        let hits = self.placed.tracer.intersect8(&rays);
        let seen = std::array::from_fn(|lane| self.seen(packet[lane]?, &hits[lane]?));
        let (suns, sky) = (self.sun_light(&seen), self.sky_light(&seen));
        std::array::from_fn(|lane| match (&seen[lane], packet[lane]) {
            (Some(seen), _) => {
                let color = suns[lane].lerp(Vec3::from(self.view.line_color), seen.line);
                let (depth, normal) = (seen.depth, seen.place.smooth);
                (Found { color, depth, normal, albedo: seen.albedo, object: seen.object }, sky[lane])
            }
            (None, shot) => {
                let direction = shot.map_or(self.up, |shot| shot.direction.normalize());
                let color = self.view.lights.sky.radiance(self.up, direction);
                let (normal, albedo) = (Vec3::ZERO, Vec3::ZERO);
                (Found { color, depth: f32::INFINITY, normal, albedo, object: NO_OBJECT }, SkyLight::default())
            }
        })
    }

    fn seen(&self, shot: Shot, hit: &Hit) -> Option<Seen<'a>> {
        let facet = Facet::of(self.placed, hit)?;
        let settings = &self.view.settings;
        let albedo = facet.albedo();
        let mut tinted = albedo;
        if let (Some(colors), Some(tag)) = (&self.view.false_color, facet.mesh.tags.get(facet.primitive)) {
            let tint = colors.palette[*tag as usize % colors.palette.len()];
            tinted = tinted.lerp(Vec3::from(tint), settings.false_color);
        }
        let mut line = 0.0;
        if settings.wireframe.is_on() {
            let marked = facet.mesh.edges.get(facet.primitive).copied().unwrap_or(0b111);
            let distances = facet.edge_distances(shot.direction, &self.rays);
            let of_marked = (0..3).filter(|edge| marked >> edge & 1 == 1).map(|edge| distances[edge]);
            line = (0.5 * settings.line_width + 0.5 - of_marked.fold(f32::INFINITY, f32::min)).clamp(0.0, 1.0);
        }
        Some(Seen {
            shot,
            depth: hit.t,
            object: hit.object.0,
            place: facet.place(shot.direction),
            material: &facet.placement.material,
            albedo,
            tinted,
            line,
        })
    }

    /// Radiance towards the camera of what the suns throw on surfaces.
    fn sun_light(&self, seen: &[Option<Seen>; LANES]) -> [Vec3; LANES] {
        let settings = &self.view.settings;
        let mut colors = [Vec3::ZERO; LANES];
        for (number, sun) in (1..).zip(&self.suns) {
            let towards: [Option<Vec3>; LANES] = std::array::from_fn(|lane| {
                let Seen { shot, place, .. } = seen[lane].as_ref()?;
                let toward = if sun.cos == 1.0 {
                    sun.direction
                } else {
                    let [x, y] = shot.pixel;
                    let sample = Shift::new(x, y, number).sample(shot.sample, settings.samples);
                    cone(sun.direction, sun.cos, sample).normalize()
                };
                (place.smooth.dot(toward) > 0.0).then_some(toward)
            });
            let rays = std::array::from_fn(|lane| {
                Some(Ray::new(seen[lane].as_ref()?.place.start.to_array(), towards[lane]?.to_array()))
            });
            let blocked = if settings.shadows.is_on() { self.placed.tracer.occluded8(&rays) } else { [false; LANES] };
            for lane in 0..LANES {
                let (Some(seen), Some(toward), false) = (&seen[lane], towards[lane], blocked[lane]) else { continue };
                let gloss = gloss(seen.material, seen.place.smooth, toward, -seen.shot.direction.normalize());
                let diffuse = seen.tinted * std::f32::consts::FRAC_1_PI;
                colors[lane] += sun.irradiance * seen.place.smooth.dot(toward) * (diffuse + gloss);
            }
        }
        colors
    }

    /// The sky's light on surfaces.
    fn sky_light(&self, seen: &[Option<Seen>; LANES]) -> [SkyLight; LANES] {
        let settings = &self.view.settings;
        let directions = settings.sky_rays.max(1);
        let mut lights = [SkyLight::default(); LANES];
        for index in 0..directions {
            let towards: [Option<Vec3>; LANES] = std::array::from_fn(|lane| {
                let Seen { shot, place, .. } = seen[lane].as_ref()?;
                let shift = Shift::new(shot.pixel[0], shot.pixel[1], 0);
                let sample = shift.sample(shot.sample * directions + index, settings.samples * directions);
                let toward = cosine_hemisphere(place.smooth, sample);
                // What would go into the triangle is thrown back.
                Some(toward - place.flat * (2.0 * toward.dot(place.flat).min(0.0)))
            });
            for lane in 0..LANES {
                let (Some(seen), Some(toward)) = (&seen[lane], towards[lane]) else { continue };
                let radiance = self.view.lights.sky.radiance(self.up, toward);
                lights[lane].all += radiance;
                let ray = Ray::new(seen.place.start.to_array(), toward.to_array());
                // These rays go every way, so there is nothing to gain from tracing them together.
                if settings.sky_rays == 0 || !self.placed.tracer.occluded(&ray) {
                    lights[lane].open += radiance;
                }
            }
        }
        for (light, seen) in lights.iter_mut().zip(seen).filter_map(|(light, seen)| Some((light, seen.as_ref()?))) {
            light.clear = self.clear.mean(seen.place.smooth);
            light.reflected = seen.tinted * light.clear;
            *light = light.scaled(1.0 - seen.line);
        }
        lights
    }
}

/// The GGX lobe with Schlick's Fresnel term and the height-correlated shadowing of Smith.
fn gloss(material: &Material, normal: Vec3, toward: Vec3, to_eye: Vec3) -> Vec3 {
    let (specular, roughness) = (material.specular, material.roughness);
    let (light, eye) = (normal.dot(toward), normal.dot(to_eye));
    let half = (toward + to_eye).normalize_or_zero();
    if specular <= 0.0 || light <= 0.0 || eye <= 0.0 {
        return Vec3::ZERO;
    }
    let alpha2 = roughness.max(0.05).powi(4);
    let cos = normal.dot(half).clamp(0.0, 1.0);
    let spread = cos * cos * (alpha2 - 1.0) + 1.0;
    let density = alpha2 / (std::f32::consts::PI * spread * spread);
    let smith = |cos: f32, other: f32| other * (alpha2 + (1.0 - alpha2) * cos * cos).sqrt();
    let visible = 0.5 / (smith(light, eye) + smith(eye, light)).max(1e-6);
    let fresnel = specular + (1.0 - specular) * (1.0 - half.dot(to_eye).clamp(0.0, 1.0)).powi(5);
    Vec3::splat(density * visible * fresnel)
}
