//! The reference ray caster: direct light with shadows, sky light with occlusion, and the geometry behind each pixel.
//! Rays that meet dielectric bodies go on: what is reflected and what is refracted, each with its share, up to a depth.
//!
//! Light is in radiance, scene-linear Rec.709. Diffuse reflection is Lambert's; the glossy part has the GGX
//! distribution (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", Section 5.2). Rays are
//! traced eight at a time, in an order that does not depend on the threads.

use glam::{Vec2, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_embree::Ray;

use crate::camera::Rays;
use crate::dielectric::{fresnel, refract};
use crate::facet::{Facet, Place};
use crate::frame::{Frame, NO_OBJECT};
use crate::gloss::gloss;
use crate::image::Image;
use crate::sampling::{Shift, cone, cosine_hemisphere, in_pixel};
use crate::scene::{Placed, Placement, Scene};
use crate::settings::View;
use crate::sky::{ClearSky, SkyLight, reflected_row};
use crate::tracing::{LANES, Struck, Tracing};

/// Side of the square of pixels that is one item of work.
const BLOCK: u32 = 16;

/// Surfaces of dielectric bodies that a ray is followed through one after the other, and the share of the light from
/// which on it is followed: what is left is seen as the sky's.
const DEEPEST: u32 = 12;
const MIN: f32 = 0.01;
/// The stream of samples of time; those of suns begin at 1.
const TIMES: u32 = u32::MAX;

/// What camera rays find, without the sky's light on surfaces.
#[derive(Clone, Copy)]
struct Found {
    color: Vec3,
    depth: f32,
    normal: Vec3,
    albedo: Vec3,
    object: u32,
}

impl Found {
    const NOTHING: Self =
        Self { color: Vec3::ZERO, depth: f32::INFINITY, normal: Vec3::ZERO, albedo: Vec3::ZERO, object: NO_OBJECT };
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
    /// The dielectric body that the camera is in.
    around: Option<u32>,
}

/// A camera ray.
#[derive(Clone, Copy)]
struct Shot {
    pixel: [u32; 2],
    sample: u32,
    direction: Vec3,
    time: f32,
}

/// A camera ray, or what became of it behind surfaces.
#[derive(Clone, Copy)]
struct Path {
    /// The camera ray by its number in the packet.
    of: usize,
    shot: Shot,
    origin: Vec3,
    direction: Vec3,
    /// The share of its light that arrives at the camera.
    weight: Vec3,
    /// Surfaces on the way.
    depth: u32,
    /// The dielectric body it is in.
    medium: Option<u32>,
}

/// A surface that a ray sees.
struct Seen<'a> {
    path: Path,
    t: f32,
    object: u32,
    place: Place,
    placement: &'a Placement,
    /// Diffuse reflectance, and the same under false colours.
    albedo: Vec3,
    tinted: Vec3,
    /// How much of it the wireframe covers.
    line: f32,
}

impl<'a> Caster<'a> {
    fn new(placed: &'a Placed<'a>, view: &'a View) -> Self {
        let suns = view.lights.suns.iter().map(|sun| SunCone {
            direction: Vec3::from(sun.direction).normalize(),
            cos: sun.angular_radius.cos(),
            irradiance: Vec3::from(sun.irradiance),
        });
        let up = Vec3::from(view.lights.sky.up).normalize();
        Self {
            placed,
            view,
            rays: view.camera.rays(view.settings.width, view.settings.height),
            suns: suns.collect(),
            up,
            clear: ClearSky::new(&view.lights.sky),
            around: Tracing::new(placed).around_camera(up, view.shutter[0]),
        }
    }

    /// The pixels of the block whose top left pixel is (left, top), row after row.
    fn block(&self, left: u32, top: u32) -> Vec<(Found, SkyLight)> {
        let settings = &self.view.settings;
        let (right, bottom) = ((left + BLOCK).min(settings.width), (top + BLOCK).min(settings.height));
        let mut tracing = Tracing::new(self.placed);
        let [open, close] = self.view.shutter;
        let shots = (top..bottom).flat_map(|y| (left..right).map(move |x| [x, y])).flat_map(|pixel| {
            (0..settings.samples).map(move |sample| {
                let place = Vec2::new(pixel[0] as f32, pixel[1] as f32) + in_pixel(sample);
                let moment = Shift::new(pixel[0], pixel[1], TIMES).sample(sample, settings.samples).x;
                let time = open + (close - open) * moment;
                Shot { pixel, sample, direction: self.rays.direction(place.x, place.y), time }
            })
        });
        let mut shots = shots.peekable();
        let mut pixels: Vec<(Found, SkyLight)> = Vec::with_capacity((BLOCK * BLOCK) as usize);
        let share = 1.0 / settings.samples as f32;
        while shots.peek().is_some() {
            let packet: [Option<Shot>; LANES] = std::array::from_fn(|_| shots.next());
            for (shot, (mut found, light)) in packet.iter().flatten().zip(self.trace(&mut tracing, &packet)) {
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
    fn trace(&self, tracing: &mut Tracing<'a>, packet: &[Option<Shot>; LANES]) -> [(Found, SkyLight); LANES] {
        let mut found = [(Found::NOTHING, SkyLight::default()); LANES];
        let of_camera = |(of, shot): (usize, &Shot)| Path {
            of,
            shot: *shot,
            origin: Vec3::ZERO,
            direction: shot.direction,
            weight: Vec3::ONE,
            depth: 0,
            medium: self.around,
        };
        let mut paths: Vec<Path> = packet.iter().flatten().enumerate().map(of_camera).collect();
        let mut next = 0;
        while next < paths.len() {
            let group: [Option<Path>; LANES] = std::array::from_fn(|lane| paths.get(next + lane).copied());
            next = (next + LANES).min(paths.len());
            let rays = group.map(|path| path.map(|path| Ray::new(path.origin.to_array(), path.direction.to_array())));
            let hits = tracing.nearest8(&rays, group.map(|path| path.map_or(0.0, |path| path.shot.time)));
            let seen = std::array::from_fn(|lane| self.seen(group[lane]?, &hits[lane]?));
            let (suns, sky) = (self.sun_light(tracing, &seen), self.sky_light(tracing, &seen));
            for lane in 0..LANES {
                let Some(path) = group[lane] else { continue };
                let (found, light) = &mut found[path.of];
                let Some(seen) = &seen[lane] else {
                    found.color += path.weight * self.background(path.direction);
                    continue;
                };
                let weight = seen.path.weight;
                found.color += weight * suns[lane].lerp(Vec3::from(self.view.line_color), seen.line);
                light.add(&sky[lane].filtered(weight));
                if path.depth == 0 {
                    (found.depth, found.normal) = (seen.t, seen.place.smooth);
                    (found.albedo, found.object) = (seen.albedo, seen.object);
                }
                for branch in self.branches(seen).into_iter().flatten() {
                    if branch.depth > DEEPEST || branch.weight.max_element() < MIN {
                        found.color += branch.weight * self.background(branch.direction);
                    } else {
                        paths.push(branch);
                    }
                }
            }
        }
        found
    }

    fn background(&self, direction: Vec3) -> Vec3 {
        self.view.lights.sky.radiance(self.up, direction.normalize())
    }

    /// How a ray goes on at a dielectric body: what is reflected, and what is refracted.
    fn branches(&self, seen: &Seen) -> [Option<Path>; 2] {
        let Some(dielectric) = &seen.placement.dielectric else { return [None; 2] };
        let (path, place) = (&seen.path, &seen.place);
        let direction = path.direction.normalize();
        let index = if place.enters { dielectric.index } else { 1.0 / dielectric.index };
        let mirrored = |normal: Vec3| direction - normal * (2.0 * direction.dot(normal));
        // Where smooth normals would send light to the wrong side, those of the triangles do not.
        let fits = |normal: Vec3| {
            let behind = refract(direction, normal, index);
            mirrored(normal).dot(place.flat) > 0.0 && behind.is_none_or(|behind| behind.dot(place.flat) < 0.0)
        };
        let normal = if fits(place.smooth) { place.smooth } else { place.flat };
        let reflected = fresnel(-direction.dot(normal), index);
        let weight = path.weight * (1.0 - seen.line);
        let branch = |share: f32, origin: Vec3, direction: Vec3, medium: Option<u32>| Path {
            origin,
            direction,
            weight: weight * share,
            depth: path.depth + 1,
            medium,
            ..*path
        };
        let [before, after] = if place.enters { [None, Some(seen.object)] } else { [Some(seen.object), None] };
        [
            Some(branch(reflected, place.start, mirrored(normal), before)),
            refract(direction, normal, index).map(|bent| branch(1.0 - reflected, place.behind, bent, after)),
        ]
    }

    fn seen(&self, mut path: Path, struck: &Struck) -> Option<Seen<'a>> {
        let (t, object) = (struck.t(), struck.object());
        let placement = self.placed.placement(object)?;
        let settings = &self.view.settings;
        let (mut albedo, mut line) = (Vec3::from(placement.material.base_color), 0.0);
        let mut tinted = albedo;
        let place = match struck {
            Struck::Implicit(met) => met.place(),
            Struck::Triangle(hit) => {
                let facet = Facet::of(self.placed, hit)?;
                albedo = facet.albedo();
                tinted = albedo;
                if let (Some(colors), Some(tag)) = (&self.view.false_color, facet.mesh.tags.get(facet.primitive)) {
                    let tint = colors.palette[*tag as usize % colors.palette.len()];
                    tinted = tinted.lerp(Vec3::from(tint), settings.false_color);
                }
                if settings.wireframe.is_on() && path.depth == 0 {
                    let marked = facet.mesh.edges.get(facet.primitive).copied().unwrap_or(0b111);
                    let distances = facet.edge_distances(path.direction, &self.rays);
                    let of_marked = (0..3).filter(|edge| marked >> edge & 1 == 1).map(|edge| distances[edge]);
                    line = (0.5 * settings.line_width + 0.5 - of_marked.fold(f32::INFINITY, f32::min)).clamp(0.0, 1.0);
                }
                facet.place(path.direction)
            }
        };
        if placement.dielectric.is_some() {
            (albedo, tinted) = (Vec3::ZERO, Vec3::ZERO);
        }
        if let Some(medium) = path.medium.and_then(|medium| self.placed.placement(medium)?.dielectric.as_ref()) {
            path.weight *= medium.left(t * path.direction.length());
        }
        Some(Seen { path, t, object, place, placement, albedo, tinted, line })
    }

    /// Radiance towards the camera of what the suns throw on surfaces.
    fn sun_light(&self, tracing: &mut Tracing, seen: &[Option<Seen>; LANES]) -> [Vec3; LANES] {
        let settings = &self.view.settings;
        let mut colors = [Vec3::ZERO; LANES];
        for (number, sun) in (1..).zip(&self.suns) {
            let towards: [Option<Vec3>; LANES] = std::array::from_fn(|lane| {
                let Seen { path: Path { shot, .. }, place, placement, .. } = seen[lane].as_ref()?;
                if placement.dielectric.is_some() && !place.enters {
                    return None;
                }
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
            let arrives =
                if settings.shadows.is_on() { tracing.light8(&rays, times(seen)) } else { [Vec3::ONE; LANES] };
            for lane in 0..LANES {
                let (Some(seen), Some(toward)) = (&seen[lane], towards[lane]) else { continue };
                let to_eye = -seen.path.direction.normalize();
                let gloss = gloss(&seen.placement.material, seen.place.smooth, toward, to_eye);
                let diffuse = seen.tinted * std::f32::consts::FRAC_1_PI;
                let light = sun.irradiance * arrives[lane];
                colors[lane] += light * seen.place.smooth.dot(toward) * (diffuse + gloss);
            }
        }
        colors
    }

    /// The sky's light on surfaces.
    fn sky_light(&self, tracing: &mut Tracing, seen: &[Option<Seen>; LANES]) -> [SkyLight; LANES] {
        let settings = &self.view.settings;
        let directions = settings.sky_rays.max(1);
        let mut lights = [SkyLight::default(); LANES];
        for index in 0..directions {
            let towards: [Option<Vec3>; LANES] = std::array::from_fn(|lane| {
                let Seen { path: Path { shot, .. }, place, placement, .. } = seen[lane].as_ref()?;
                if placement.dielectric.is_some() {
                    return None;
                }
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
                lights[lane].open += match settings.sky_rays {
                    0 => radiance,
                    _ => radiance * tracing.light(&ray, seen.path.shot.time),
                };
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

/// The times of what rays see.
fn times(seen: &[Option<Seen>; LANES]) -> [f32; LANES] {
    std::array::from_fn(|lane| seen[lane].as_ref().map_or(0.0, |seen| seen.path.shot.time))
}
