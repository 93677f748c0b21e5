//! Pictures of decals on their meshes.
//!
//! Every pixel has its own colour: the surface is rendered once in white for its light, and once with places as colours,
//! from which the reflectance behind each pixel gives the place that it shows.

use std::path::Path;

use clap::ValueEnum;
use glam::{DAffine3, DVec3};
use relievo_core::{Context, Result};
use relievo_decal::stretch;
use relievo_render::color::from_hex;
use relievo_render::{Camera, Image, Lights, Material, Mesh, Scene, Sky, Sun, View, draw_legend, write_png};
use relievo_scene::overlap::{lifted, parts_below};
use relievo_surface::Place;
use relievo_tiles::{AnyField, Tessellation};

use super::common::Laid;

/// What a picture shows of a decal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Show {
    /// Squares of the image's plane.
    Checker,
    /// The stretch of each triangle.
    Heat,
    /// The image.
    Image,
}

/// Pixels in each direction.
const SIZE: u32 = 900;
/// Rays along each side of a pixel.
const RAYS: u32 = 2;
/// The vertical field of view, radians.
const FOV: f64 = 0.5;
/// Squares of the checker along the width of the image.
const SQUARES: f64 = 16.0;
/// Places of the image from -4 to 4 become reflectances from 0 to 1.
const REACH: f64 = 4.0;
/// The reflectance of the surface beside the decal.
const GREY: [f32; 3] = [0.5; 3];
/// Stretch or compression up to a limit, with its colour (cividis, which the colour-blind can read).
const HEAT: [(f64, u32, &str); 6] = [
    (1.02, 0x00204d, "within 1.02"),
    (1.05, 0x31446b, "within 1.05"),
    (1.1, 0x666970, "within 1.1"),
    (1.25, 0x958f78, "within 1.25"),
    (1.5, 0xcbba69, "within 1.5"),
    (f64::INFINITY, 0xffea46, "beyond 1.5"),
];

/// Draws the mesh with the decal from the front of the decal. `depths` are those of the pins, or none.
pub fn draw(laid: &Laid, depths: &[f64], show: Show, file: &Path) -> Result<()> {
    let front = Front::of(laid);
    let triangles = laid.mesh.corners.as_chunks::<3>().0.to_vec();
    let ground = Mesh { points: laid.mesh.points.clone(), triangles, ..Mesh::default() };
    let color = |[u, v, heat]: [f32; 3]| {
        let place = [u, v].map(|value| (f64::from(value) - 0.5) * 2.0 * REACH);
        laid.sticker.covers(place).then(|| match show {
            Show::Heat => from_hex(HEAT[((heat * HEAT.len() as f32) as usize).min(HEAT.len() - 1)].1),
            Show::Checker => checker(place, laid.ratio()),
            Show::Image => laid.image.as_ref().map_or_else(|| checker(place, laid.ratio()), |image| over(image, place)),
        })
    };
    let meshes = coded(laid, depths, 1e-3 * front.radius)?;
    let mut picture = shot(&laid.context, &front, Some(ground), meshes, &color)?;
    if show == Show::Heat {
        let entries: Vec<_> = HEAT.iter().map(|(_, color, label)| (from_hex(*color), *label)).collect();
        draw_legend(&mut picture, &entries);
    }
    write_png(file, &picture)
}

/// Draws a displaced surface with its colours from the front of the decal.
pub fn draw_painted(laid: &Laid, surface: &Tessellation, colors: Option<AnyField<'_>>, file: &Path) -> Result<()> {
    let front = Front::of(laid);
    // Tiles by their number and the number of all, so that they keep apart as reflectances.
    let count = surface.tiles.last().map_or(1, |last| last + 1);
    let mut mesh = Mesh::default();
    let normals = Mesh::of_tessellation(surface.mesh.clone()).normals;
    for (triangle, tile) in surface.tiles.iter().enumerate() {
        for corner in 3 * triangle..3 * triangle + 3 {
            let point = surface.mesh.corners[corner] as usize;
            let [u, v] = surface.parameters[corner];
            mesh.points.push(surface.mesh.points[point]);
            mesh.normals.extend(normals.get(point));
            mesh.colors.push([u, v, (*tile as f32 + 0.5) / count as f32]);
        }
        let first = 3 * triangle as u32;
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    let color = |[u, v, tile]: [f32; 3]| {
        let tile = ((tile * count as f32) as u32).min(count - 1);
        colors.map(|colors| colors.color(colors.canonical(Place::new(tile, u, v))).truncate().to_array())
    };
    write_png(file, &shot(&laid.context, &front, None, vec![mesh], &color)?)
}

/// Draws a mesh with the colours of its points from the front of the decal.
pub fn draw_colored(laid: &Laid, mesh: relievo_core::Mesh, file: &Path) -> Result<()> {
    let view = Front::of(laid).view()?;
    let mut scene = Scene::new()?;
    let material = Material { base_color: GREY, specular: 0.0, roughness: 0.5 };
    let object = scene.add_object(DAffine3::IDENTITY, material)?;
    scene.set_mesh(object, 0, Mesh::of_tessellation(mesh))?;
    let light = scene.render(&laid.context, &view)?.color;
    write_png(file, &reduced(&light, |_, color| color)?)
}

/// Where a decal is looked at from.
struct Front {
    center: DVec3,
    normal: DVec3,
    up: DVec3,
    radius: f64,
}

impl Front {
    fn of(laid: &Laid) -> Self {
        let decal = &laid.decal;
        let points: Vec<DVec3> = decal.points.iter().map(|point| DVec3::from(*point)).collect();
        let normal: DVec3 = decal.normals.iter().map(|normal| DVec3::from(*normal)).sum();
        let normal = normal.normalize_or(DVec3::Z);
        let center = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let radius = points.iter().map(|point| point.distance(center)).fold(1e-9, f64::max);
        // The direction in space in which the second texture coordinate grows, on the whole.
        let middle = decal.uv.iter().map(|uv| uv[1]).sum::<f64>() / decal.uv.len().max(1) as f64;
        let up: DVec3 = points.iter().zip(&decal.uv).map(|(point, uv)| *point * (uv[1] - middle)).sum();
        let up = up.reject_from(normal).normalize_or(normal.any_orthonormal_vector());
        Self { center, normal, up, radius }
    }

    fn view(&self) -> Result<View> {
        let Self { center, normal, up, radius } = *self;
        let right = up.cross(normal);
        let sun = |direction: DVec3, irradiance: f32| Sun {
            direction: direction.normalize().as_vec3().to_array(),
            irradiance: [irradiance; 3],
            angular_radius: 0.0,
        };
        let eye = center + normal * (1.5 * radius / (0.5 * FOV).tan());
        let mut view = View::new(Camera::look_at(eye, center, up, FOV)?);
        view.lights = Lights {
            suns: vec![sun(normal + 0.5 * up - 0.4 * right, 2.2), sun(normal + right, 0.9)],
            sky: Sky { up: up.as_vec3().to_array(), ..Sky::uniform([0.0; 3]) },
        };
        [view.settings.width, view.settings.height] = [RAYS * SIZE; 2];
        view.settings.samples = 1;
        view.settings.sky_rays = 0;
        Ok(view)
    }
}

/// Renders meshes whose colours are codes that `color` turns into reflectances, over a grey one. Where it returns none, the
/// next mesh is seen. The light is that on the first one.
fn shot(
    context: &Context,
    front: &Front,
    ground: Option<Mesh>,
    meshes: Vec<Mesh>,
    color: &dyn Fn([f32; 3]) -> Option<[f32; 3]>,
) -> Result<Image> {
    let view = front.view()?;
    let mut scene = Scene::new()?;
    let white = Material { base_color: [1.0; 3], specular: 0.0, roughness: 0.5 };
    if let Some(ground) = ground {
        let object = scene.add_object(DAffine3::IDENTITY, white)?;
        scene.set_mesh(object, 0, ground)?;
    }
    let object = scene.add_object(DAffine3::IDENTITY, white)?;
    let plain = meshes.first().map(|mesh| Mesh { colors: Vec::new(), ..mesh.clone() });
    scene.set_mesh(object, 0, plain.unwrap_or_default())?;
    let light = scene.render(context, &view)?.color;
    let mut reflectances = vec![None; light.width() as usize * light.height() as usize];
    for mesh in meshes {
        scene.set_mesh(object, 0, mesh)?;
        let places = scene.render(context, &view)?;
        for (ray, reflectance) in (0..).zip(&mut reflectances) {
            if reflectance.is_none() && places.object[ray as usize] == object.number() {
                *reflectance = color(places.albedo.color(ray % light.width(), ray / light.width()));
            }
        }
    }
    reduced(&light, |ray, light| {
        let reflectance = reflectances[ray].unwrap_or(GREY);
        std::array::from_fn(|axis| reflectance[axis] * light[axis])
    })
}

/// The means over the rays of each pixel of what `shade` makes of the number and the colour of a ray.
fn reduced(light: &Image, shade: impl Fn(usize, [f32; 3]) -> [f32; 3]) -> Result<Image> {
    let mut picture = Image::new(SIZE, SIZE, 3)?;
    for y in 0..SIZE {
        for x in 0..SIZE {
            let mut sum = [0.0; 3];
            for (row, column) in (0..RAYS * RAYS).map(|ray| (RAYS * y + ray / RAYS, RAYS * x + ray % RAYS)) {
                let color = shade((row * RAYS * SIZE + column) as usize, light.color(column, row));
                for (sum, value) in sum.iter_mut().zip(color) {
                    *sum += value / (RAYS * RAYS) as f32;
                }
            }
            picture.set_color(x, y, sum);
        }
    }
    Ok(picture)
}

/// The triangles of the decal with their places in the image and their stretch as colours, `offset` above the surface and
/// above one another: first all of them, then without the highest, until only the lowest are left, for triangles of an upper
/// part that reach beyond the outline.
fn coded(laid: &Laid, depths: &[f64], offset: f64) -> Result<Vec<Mesh>> {
    let decal = &laid.decal;
    let points = lifted(decal, depths, offset)?.points;
    let below = parts_below(decal, depths);
    let most = below.iter().copied().max().unwrap_or(0);
    let meshes = (0..=most).rev().map(|level| {
        let mut mesh = Mesh::default();
        for (triangle, _) in decal.triangles.iter().zip(&below).filter(|(_, below)| **below <= level) {
            let first = mesh.points.len() as u32;
            let heat = heat(laid, *triangle);
            for vertex in triangle.map(|vertex| vertex as usize) {
                let uv = decal.uv[vertex].map(|value| value.clamp(-REACH, REACH));
                mesh.points.push(points[vertex]);
                let [u, v] = uv.map(|value| (0.5 + 0.5 * value / REACH) as f32);
                mesh.colors.push([u, v, heat]);
            }
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        mesh
    });
    Ok(meshes.collect())
}

fn checker([u, v]: [f64; 2], ratio: f64) -> [f32; 3] {
    let is_dark = ((SQUARES * u).floor() + (SQUARES * v * ratio).floor()).rem_euclid(2.0) == 1.0;
    if is_dark { [0.02, 0.08, 0.25] } else { [0.85, 0.8, 0.6] }
}

/// The colour of an image at a place, over grey where it is transparent.
fn over(image: &Image, [u, v]: [f64; 2]) -> [f32; 3] {
    let pixel = |share: f64, count: u32| ((share * f64::from(count)) as u32).min(count.saturating_sub(1));
    let (x, y) = (pixel(u, image.width()), pixel(1.0 - v, image.height()));
    let alpha = if let [_, _, _, alpha] = *image.pixel(x, y) { alpha } else { 1.0 };
    let color = image.color(x, y);
    std::array::from_fn(|axis| GREY[axis] + alpha * (color[axis] - GREY[axis]))
}

/// The place of the stretch of a triangle among the limits, 0 to 1, in the mean scale of the decal.
fn heat(laid: &Laid, triangle: [u32; 3]) -> f32 {
    let decal = &laid.decal;
    let plane = triangle.map(|vertex| {
        let [u, v] = decal.uv[vertex as usize];
        [u, v * laid.ratio()]
    });
    let (larger, smaller, _) = stretch(plane, triangle.map(|vertex| decal.points[vertex as usize]));
    let worst = (larger * decal.scale).max(1.0 / (smaller * decal.scale).max(1e-12));
    let entry = HEAT.iter().position(|(limit, ..)| worst <= *limit).unwrap_or(HEAT.len() - 1);
    (entry as f32 + 0.5) / HEAT.len() as f32
}
