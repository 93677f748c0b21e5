//! The reference ray caster: direct light with shadows, sky light with occlusion, and the geometry behind each pixel.
//!
//! Light is in radiance, scene-linear Rec.709. Diffuse reflection is Lambert's; the glossy part has the GGX
//! distribution (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", Section 5.2). Shadow rays start
//! on the smooth surface that the normals suggest (Hanika 2021, "Hacking the Shadow Terminator").

use glam::{Vec2, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_embree::{Hit, Ray};

use crate::camera::Rays;
use crate::image::Image;
use crate::sampling::{Shift, cone, cosine_hemisphere, in_pixel};
use crate::scene::{Material, Mesh, Placed, Placement, Scene};
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

/// The triangle behind a hit, in the camera's space.
struct Facet<'a> {
    mesh: &'a Mesh,
    placement: &'a Placement,
    primitive: usize,
    corners: [u32; 3],
    points: [Vec3; 3],
    weights: [f32; 3],
}

/// A place on a surface to be lit.
struct Place {
    /// From where rays start that go to the lit side.
    start: Vec3,
    /// Unit normal of the triangle and of the smooth surface, both to the side that is seen.
    flat: Vec3,
    smooth: Vec3,
}

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
        let mut pixels = Vec::with_capacity((BLOCK * BLOCK) as usize);
        for y in top..bottom {
            for x in left..right {
                let (mut pixel, mut sky) = self.sample(x, y, 0);
                for sample in 1..settings.samples {
                    let (other, light) = self.sample(x, y, sample);
                    pixel.color += other.color;
                    sky.add(&light);
                }
                pixel.color /= settings.samples as f32;
                pixels.push((pixel, sky.scaled(1.0 / settings.samples as f32)));
            }
        }
        pixels
    }

    /// What one ray finds, its colour without the sky's light on surfaces, which is given apart.
    fn sample(&self, x: u32, y: u32, sample: u32) -> (Found, SkyLight) {
        let place = Vec2::new(x as f32, y as f32) + in_pixel(sample);
        let direction = self.rays.direction(place.x, place.y);
        let ray = Ray::new([0.0; 3], direction.to_array());
        let found = self.placed.tracer.intersect(&ray).and_then(|hit| Some((hit, self.facet(&hit)?)));
        let Some((hit, facet)) = found else {
            let found = Found {
                color: self.view.lights.sky.radiance(self.up, direction.normalize()),
                depth: f32::INFINITY,
                normal: Vec3::ZERO,
                albedo: Vec3::ZERO,
                object: NO_OBJECT,
            };
            return (found, SkyLight::default());
        };
        let place = facet.place(direction);
        let albedo = facet.albedo();
        let mut seen = albedo;
        if let (Some(colors), Some(tag)) = (&self.view.false_color, facet.mesh.tags.get(facet.primitive)) {
            let tint = colors.palette[*tag as usize % colors.palette.len()];
            seen = seen.lerp(Vec3::from(tint), self.view.settings.false_color);
        }
        let material = &facet.placement.material;
        let line = if self.view.settings.wireframe.is_on() { self.line(&facet, direction) } else { 0.0 };
        let lit = self.sun_light(&place, material, seen, -direction.normalize(), [x, y, sample]);
        let color = lit.lerp(Vec3::from(self.view.line_color), line);
        let sky = self.sky_light(&place, seen, 1.0 - line, Shift::new(x, y, 0), sample);
        (Found { color, depth: hit.t, normal: place.smooth, albedo, object: hit.object.0 }, sky)
    }

    fn facet(&self, hit: &Hit) -> Option<Facet<'a>> {
        let index = hit.object.0 as usize;
        let placement = self.placed.placements.get(index)?.as_ref()?;
        let mesh = self.placed.objects.get(index)?.as_ref()?.meshes.get(hit.mesh as usize)?.as_ref()?;
        let primitive = hit.primitive as usize;
        let corners = *mesh.triangles.get(primitive)?;
        let points = corners.map(|at| placement.linear * Vec3::from(mesh.points[at as usize]) + placement.translation);
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        Some(Facet { mesh, placement, primitive, corners, points, weights })
    }

    /// Radiance towards `to_eye` of what the suns throw on a place.
    fn sun_light(
        &self,
        place: &Place,
        material: &Material,
        albedo: Vec3,
        to_eye: Vec3,
        [x, y, sample]: [u32; 3],
    ) -> Vec3 {
        let settings = &self.view.settings;
        let tracer = &self.placed.tracer;
        let mut color = Vec3::ZERO;
        for (number, sun) in (1..).zip(&self.suns) {
            let toward = match sun.cos {
                1.0 => sun.direction,
                cos => cone(sun.direction, cos, Shift::new(x, y, number).sample(sample, settings.samples)).normalize(),
            };
            let cos = place.smooth.dot(toward);
            if cos <= 0.0 {
                continue;
            }
            let ray = Ray::new(place.start.to_array(), toward.to_array());
            if settings.shadows.is_on() && tracer.occluded(&ray) {
                continue;
            }
            let gloss = gloss(material.specular, material.roughness, place.smooth, toward, to_eye);
            color += sun.irradiance * cos * (albedo * std::f32::consts::FRAC_1_PI + gloss);
        }
        color
    }

    /// The sky's light on a place of which the picture shows the share `shown`.
    fn sky_light(&self, place: &Place, albedo: Vec3, shown: f32, shift: Shift, sample: u32) -> SkyLight {
        let settings = &self.view.settings;
        let (sky, rays) = (&self.view.lights.sky, settings.sky_rays);
        let directions = rays.max(1);
        let (mut open, mut all) = (Vec3::ZERO, Vec3::ZERO);
        for index in 0..directions {
            let place_in = shift.sample(sample * directions + index, settings.samples * directions);
            let mut toward = cosine_hemisphere(place.smooth, place_in);
            let below = toward.dot(place.flat);
            if below < 0.0 {
                toward -= place.flat * (2.0 * below);
            }
            let radiance = sky.radiance(self.up, toward);
            all += radiance;
            let ray = Ray::new(place.start.to_array(), toward.to_array());
            if rays == 0 || !self.placed.tracer.occluded(&ray) {
                open += radiance;
            }
        }
        let clear = self.clear.mean(place.smooth) * shown;
        SkyLight { open: open * shown, all: all * shown, clear, reflected: albedo * clear }
    }

    /// How much of the wireframe's colour covers a place.
    fn line(&self, facet: &Facet, direction: Vec3) -> f32 {
        let marked = facet.mesh.edges.get(facet.primitive).copied().unwrap_or(0b111);
        let distances = edge_distances(facet.points, direction, &self.rays);
        let nearest =
            (0..3).filter(|edge| marked >> edge & 1 == 1).map(|edge| distances[edge]).fold(f32::INFINITY, f32::min);
        (0.5 * self.view.settings.line_width + 0.5 - nearest).clamp(0.0, 1.0)
    }
}

impl Facet<'_> {
    fn blend(&self, values: [Vec3; 3]) -> Vec3 {
        values[0] * self.weights[0] + values[1] * self.weights[1] + values[2] * self.weights[2]
    }

    fn albedo(&self) -> Vec3 {
        match self.mesh.colors.as_slice() {
            [] => Vec3::from(self.placement.material.base_color),
            colors => self.blend(self.corners.map(|at| Vec3::from(colors[at as usize]))),
        }
    }

    /// The place of the hit, seen along `direction`.
    fn place(&self, direction: Vec3) -> Place {
        let [a, b, c] = self.points;
        let mut flat = (b - a).cross(c - a).normalize_or(Vec3::Z);
        if self.placement.mirrored {
            flat = -flat;
        }
        let point = self.blend(self.points);
        // A few units in the last place of what the coordinates were summed from.
        let step = 4e-6 * (point.abs().max_element() + self.placement.translation.abs().max_element());
        let seen = if flat.dot(direction) > 0.0 { -1.0 } else { 1.0 };
        flat *= seen;
        if self.mesh.normals.is_empty() {
            return Place { start: point + flat * step, flat, smooth: flat };
        }
        let normals = self.corners.map(|at| {
            (self.placement.normal * Vec3::from(self.mesh.normals[at as usize])).normalize_or(flat * seen) * seen
        });
        let smooth = self.blend(normals).normalize_or(flat);
        if normals.iter().any(|normal| normal.dot(flat) < 0.1) || smooth.dot(flat) < 0.1 {
            // The normals say little about such a triangle.
            return Place {
                start: point + flat * step,
                flat,
                smooth: if smooth.dot(flat) > 0.0 { smooth } else { flat },
            };
        }
        // Each corner's tangent plane lifts the point if it lies below; the smooth surface is about where they agree.
        let lifts = [0, 1, 2].map(|corner| {
            let below = (point - self.points[corner]).dot(normals[corner]);
            normals[corner] * -below.min(0.0)
        });
        Place { start: point + self.blend(lifts) + flat * step, flat, smooth }
    }
}

/// Distances in pixels from the place that `direction` sees to the lines through the edges of a triangle, edge e from
/// corner e to the next.
fn edge_distances(points: [Vec3; 3], direction: Vec3, rays: &Rays) -> [f32; 3] {
    let [a, b, c] = points;
    // Weight i of a direction is the volume it spans with the other two corners.
    let rows = [b.cross(c - b), c.cross(a - c), a.cross(b - a)];
    let of = |direction: Vec3| rows.map(|row| row.dot(direction));
    let (here, dx, dy) = (of(direction), of(rays.dx), of(rays.dy));
    let sum = |weights: [f32; 3]| weights[0] + weights[1] + weights[2];
    let scale = 1.0 / sum(here);
    [2, 0, 1].map(|corner| {
        let weight = here[corner] * scale;
        let slope = |change: [f32; 3]| (change[corner] - weight * sum(change)) * scale;
        let distance = weight.abs() / slope(dx).hypot(slope(dy));
        if distance.is_nan() { f32::INFINITY } else { distance }
    })
}

/// The GGX lobe with Schlick's Fresnel term and the height-correlated shadowing of Smith.
fn gloss(specular: f32, roughness: f32, normal: Vec3, toward: Vec3, to_eye: Vec3) -> Vec3 {
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
