//! Pictures of decals on their meshes.

use std::path::Path;

use clap::ValueEnum;
use glam::{DAffine3, DVec3};
use relievo_core::Result;
use relievo_decal::stretch;
use relievo_render::color::from_hex;
use relievo_render::{Camera, Lights, Material, Mesh, Scene, Sky, Sun, View, draw_legend, write_png};

use super::Laid;

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
const SIZE: [u32; 2] = [900, 900];
/// The vertical field of view, radians.
const FOV: f64 = 0.5;
/// Squares of the checker along the width of the image.
const SQUARES: f64 = 16.0;
/// Parts along each edge of a triangle that colours of the image's plane are drawn on.
const PARTS: usize = 8;
/// Stretch or compression up to a limit, with its colour (cividis, which the colour-blind can read).
const HEAT: [(f64, u32, &str); 6] = [
    (1.02, 0x00204d, "within 1.02"),
    (1.05, 0x31446b, "within 1.05"),
    (1.1, 0x666970, "within 1.1"),
    (1.25, 0x958f78, "within 1.25"),
    (1.5, 0xcbba69, "within 1.5"),
    (f64::INFINITY, 0xffea46, "beyond 1.5"),
];

/// Draws the mesh with the decal from the front of the decal.
pub fn draw(laid: &Laid, show: Show, file: &Path) -> Result<()> {
    let decal = &laid.decal;
    let points: Vec<DVec3> = decal.points.iter().map(|point| DVec3::from(*point)).collect();
    let normal: DVec3 = decal.normals.iter().map(|normal| DVec3::from(*normal)).sum();
    let normal = normal.normalize_or(DVec3::Z);
    let center = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let radius = points.iter().map(|point| point.distance(center)).fold(1e-9, f64::max);
    let up = upward(laid).reject_from(normal).normalize_or(normal.any_orthonormal_vector());
    let eye = center + normal * (1.5 * radius / (0.5 * FOV).tan());

    let mut scene = Scene::new()?;
    let grey = Material { base_color: [0.5; 3], specular: 0.0, roughness: 0.5 };
    let ground = scene.add_object(DAffine3::IDENTITY, grey)?;
    let triangles = laid.mesh.corners.as_chunks::<3>().0.to_vec();
    scene.set_mesh(ground, 0, Mesh { points: laid.mesh.points.clone(), triangles, ..Mesh::default() })?;
    let sticker = scene.add_object(DAffine3::IDENTITY, grey)?;
    scene.set_mesh(sticker, 0, colored(laid, show, 1e-3 * radius))?;

    let right = up.cross(normal);
    let sun = |direction: DVec3, irradiance: f32| Sun {
        direction: direction.normalize().as_vec3().to_array(),
        irradiance: [irradiance; 3],
        angular_radius: 0.0,
    };
    let mut view = View::new(Camera::look_at(eye, center, up, FOV)?);
    view.lights = Lights {
        suns: vec![sun(normal + 0.5 * up - 0.4 * right, 2.2), sun(normal + right, 0.9)],
        sky: Sky { up: up.as_vec3().to_array(), ..Sky::uniform([0.0; 3]) },
    };
    [view.settings.width, view.settings.height] = SIZE;
    view.settings.samples = 8;
    view.settings.sky_rays = 0;
    let mut frame = scene.render(&laid.context, &view)?;
    if show == Show::Heat {
        let entries: Vec<_> = HEAT.iter().map(|(_, color, label)| (from_hex(*color), *label)).collect();
        draw_legend(&mut frame.color, &entries);
    }
    write_png(file, &frame.color)
}

/// The direction in space in which the second texture coordinate grows, on the whole.
fn upward(laid: &Laid) -> DVec3 {
    let decal = &laid.decal;
    let middle = decal.uv.iter().map(|uv| uv[1]).sum::<f64>() / decal.uv.len().max(1) as f64;
    decal.points.iter().zip(&decal.uv).map(|(point, uv)| DVec3::from(*point) * (uv[1] - middle)).sum()
}

/// The triangles of the decal in colours, in parts where the colours vary within them, `offset` above the surface.
fn colored(laid: &Laid, show: Show, offset: f64) -> Mesh {
    let decal = &laid.decal;
    let mut mesh = Mesh::default();
    let parts = if show == Show::Heat { 1 } else { PARTS };
    for triangle in &decal.triangles {
        let corners = triangle.map(|vertex| {
            let vertex = vertex as usize;
            (DVec3::from(decal.points[vertex]) + offset * DVec3::from(decal.normals[vertex]), decal.uv[vertex])
        });
        let place = |i: usize, j: usize| {
            let (s, t) = (i as f64 / parts as f64, j as f64 / parts as f64);
            let weights = [1.0 - s - t, s, t];
            let point: DVec3 = (0..3).map(|corner| weights[corner] * corners[corner].0).sum();
            let uv: [f64; 2] =
                std::array::from_fn(|axis| (0..3).map(|corner| weights[corner] * corners[corner].1[axis]).sum());
            (point, uv)
        };
        let heat = (show == Show::Heat).then(|| heat(laid, *triangle));
        for i in 0..parts {
            for j in 0..parts - i {
                let mut add = |places: [(usize, usize); 3]| {
                    let places = places.map(|(i, j)| place(i, j));
                    let uv = std::array::from_fn(|axis| places.iter().map(|place| place.1[axis]).sum::<f64>() / 3.0);
                    if !(0.0..=1.0).contains(&uv[0]) || !(0.0..=1.0).contains(&uv[1]) {
                        return;
                    }
                    let color = heat.unwrap_or_else(|| color(laid, show, uv));
                    let first = mesh.points.len() as u32;
                    mesh.points.extend(places.map(|place| place.0.as_vec3().to_array()));
                    mesh.colors.extend([color; 3]);
                    mesh.triangles.push([first, first + 1, first + 2]);
                };
                add([(i, j), (i + 1, j), (i, j + 1)]);
                if i + j + 1 < parts {
                    add([(i + 1, j), (i + 1, j + 1), (i, j + 1)]);
                }
            }
        }
    }
    mesh
}

fn color(laid: &Laid, show: Show, [u, v]: [f64; 2]) -> [f32; 3] {
    if let (Show::Image, Some(image)) = (show, &laid.image) {
        let pixel = |share: f64, count: u32| ((share * f64::from(count)) as u32).min(count.saturating_sub(1));
        return image.color(pixel(u, image.width()), pixel(1.0 - v, image.height()));
    }
    let is_dark = ((SQUARES * u).floor() + (SQUARES * v * laid.ratio()).floor()).rem_euclid(2.0) == 1.0;
    if is_dark { [0.02, 0.08, 0.25] } else { [0.85, 0.8, 0.6] }
}

/// The colour of the stretch of a triangle, in the mean scale of the decal.
fn heat(laid: &Laid, triangle: [u32; 3]) -> [f32; 3] {
    let decal = &laid.decal;
    let plane = triangle.map(|vertex| {
        let [u, v] = decal.uv[vertex as usize];
        [u, v * laid.ratio()]
    });
    let (larger, smaller, _) = stretch(plane, triangle.map(|vertex| decal.points[vertex as usize]));
    let scale = decal.scale;
    let worst = (larger * scale).max(1.0 / (smaller * scale).max(1e-12));
    let entry = HEAT.iter().find(|(limit, ..)| worst <= *limit).unwrap_or(&HEAT[HEAT.len() - 1]);
    from_hex(entry.1)
}
