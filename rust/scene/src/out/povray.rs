//! Frames as scenes for POV-Ray 3.7: camera, sun, sky, and every visible object with its displacement as geometry.
//!
//! Displaced surfaces are `mesh2` with normals, texture coordinates and, where something is painted or touched, a
//! texture per colour at the vertices, between which POV-Ray interpolates. Regular patches of limit surfaces on which
//! nothing happened are `bicubic_patch` objects with the Bézier points as they are, cut into as many triangles as the
//! tiles beside them, so that both meet without cracks. POV-Ray's camera takes any three vectors, so the coordinates
//! stay right-handed. Colours are scene-linear. Units: those of the scene.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Domain, Error, Mesh, Result, Values};
use relievo_render::color::{decode_srgb, encode_srgb};
use relievo_render::{Camera, Lights, Material, Sky};
use relievo_surface::bezier::BezierSurface;
use relievo_surface::{PatchForm, Place};

use crate::format::description::ObjectEntry;
use crate::format::povray_form::PovrayForm;
use crate::out::export::shown_mesh;
use crate::out::export::{floats, point_colors, tessellated, triangle_mesh};
use crate::out::output::Folder;
use crate::out::picture::{automatic_view, camera, lights};
use crate::out::povray_fluid::PovrayFluid;
use crate::out::showing::Showing;
use crate::state::world::{Item, World};

/// Writes the frame. Returns the file.
pub(crate) fn write(context: &Context, world: &World, folder: &Folder, frame: u32) -> Result<PathBuf> {
    let _stage = context.stats().begin("export.povray");
    let scene = &world.scene;
    let mut objects = Vec::new();
    for (index, item) in world.items().iter().enumerate().filter(|(index, _)| scene.objects[*index].visible) {
        objects.push(Shown::new(context, world, index, item)?);
    }
    for object in &mut objects {
        if let Some(fluid) = &mut object.fluid {
            fluid.store(folder, &printable(object.name), frame)?;
        }
    }
    let bounds = world.start_bounds().unwrap_or((DVec3::ZERO, DVec3::ONE));
    let view = camera(world, &automatic_view(scene, world.start_bounds()), scene.time(frame))?;
    let settings = &scene.output.settings;
    let mut head = String::new();
    let size = [settings.width, settings.height];
    write_head(&mut head, &view, size, &lights(scene), scene.output.exposure.exp2(), bounds);
    let path = folder.file(&format!("scene-{frame:06}.pov"));
    relievo_core::file::store(&path, |out| {
        out.write_all(head.as_bytes())?;
        objects.iter().try_for_each(|object| object.write(out))
    })?;
    Ok(path)
}

/// How often patches of a surface by itself are halved along each side.
const HALVINGS: u32 = 7;

/// Writes Bézier patches by themselves, which POV-Ray cuts into triangles of its own.
///
/// # Errors
/// The surface is rational, which POV-Ray's patches are not, or the system refuses.
pub fn write_patches(path: &Path, surface: &BezierSurface, showing: &Showing) -> Result<()> {
    if surface.is_rational() {
        return Err(Error::unsupported("POV-Ray has no patches with weights")
            .advise("make a mesh of it by `relievo mesh tessellate`"));
    }
    let mut head = String::new();
    write_head(&mut head, &showing.camera, showing.size, &showing.lights, 1.0, showing.bounds);
    relievo_core::file::store(path, |out| {
        out.write_all(head.as_bytes())?;
        writeln!(out, "\n#declare Object_Place = transform {{ translate <0, 0, 0> }}\nunion {{")?;
        for controls in surface.all_controls() {
            let points = controls.map(|[x, y, z, _]| [x, y, z]);
            write_patch(out, &points, HALVINGS, "")?;
        }
        writeln!(out, "{}\n}}", texture(showing.material.base_color, &showing.material))
    })
}

fn write_patch(out: &mut impl Write, points: &[[f32; 3]; 16], steps: u32, texture: &str) -> std::io::Result<()> {
    writeln!(out, "bicubic_patch {{ type 1 flatness 0 u_steps {steps} v_steps {steps}")?;
    let row = |row: &[[f32; 3]]| row.iter().map(|p| vector(*p)).collect::<Vec<_>>().join(", ");
    let rows: Vec<String> = points.chunks_exact(4).map(row).collect();
    writeln!(out, "  {}\n  {texture} }}", rows.join(",\n  "))
}

/// An object as it is written.
struct Shown<'a> {
    name: &'a str,
    material: Material,
    transform: DAffine3,
    mesh: Mesh,
    /// The triangles of the mesh by their corners; triangles of patches are left out.
    triangles: Vec<[usize; 3]>,
    /// The colours of its points, if they have some of their own.
    colors: Option<Vec<[f32; 3]>>,
    /// 16 Bézier points of each patch, row by row, and its colour.
    patches: Vec<([[f32; 3]; 16], [f32; 3])>,
    /// How often patches are halved.
    steps: u32,
    /// In place of triangles.
    fluid: Option<PovrayFluid>,
}

impl<'a> Shown<'a> {
    fn new(context: &Context, world: &'a World, index: usize, item: &Item) -> Result<Self> {
        let entry = &world.scene.objects[index];
        let material = Material {
            base_color: entry.colour.map(|value| value.min(1.0)),
            specular: entry.specular,
            roughness: entry.roughness,
        };
        let (transform, mesh, painted) = match item {
            Item::Mesh(item) if entry.fluid.is_some_and(|fluid| fluid.povray != PovrayForm::Mesh) => {
                let named = |error: Error| error.at(format!("object `{}`", entry.name.text));
                let fluid = entry.fluid.as_ref().map(|fluid| PovrayFluid::new(context, fluid, &item.mesh.points));
                let mut shown = Self::of_mesh(entry, material, item.transform, Mesh::default(), false);
                shown.fluid = fluid.transpose().map_err(named)?.flatten();
                return Ok(shown);
            }
            Item::Mesh(item) => (item.transform, shown_mesh(context, entry, &item.mesh)?, false),
            Item::Triangles(item) => {
                let painted = item.object.colors().is_some();
                (*item.object.transform(), triangle_mesh(context, world, index, item)?, painted)
            }
            Item::Surface(surface) => {
                let (tessellation, rates) = tessellated(context, world, index, surface)?;
                let displaced = surface.displaced()?;
                let topology = displaced.field().topology();
                let coat = world.coat(index);
                // Texture coordinates within a patch are no linear function of those at its corners.
                let plain = tessellation.mesh.attribute("uv").is_none();
                let regular = |tile: u32| {
                    let touched = displaced.field().is_allocated(tile)
                        || displaced.vectors().is_some_and(|vectors| vectors.is_allocated(tile))
                        || coat.as_ref().is_some_and(|coat| coat.size(tile).is_some());
                    let mut patches = surface.surface().patches(tile);
                    let patch = patches.next().filter(|_| plain && !touched && patches.len() == 0)?;
                    let rate = rates.of(tile);
                    let alike = rates.edges(topology, tile) == [rate; 4] && !topology.is_sub(tile);
                    if patch.patch.form != PatchForm::Bezier || !alike || rate != world.scene.output.rate {
                        return None;
                    }
                    let points: Vec<[f32; 3]> = patch.points().collect();
                    let color =
                        coat.as_ref().map_or(material.base_color, |coat| coat.color(Place::new(tile, 0.5, 0.5)));
                    Some((points.try_into().ok()?, color))
                };
                let patches: BTreeMap<u32, _> =
                    (0..topology.tile_count() as u32).filter_map(|tile| Some((tile, regular(tile)?))).collect();
                let painted = surface.colors().is_some();
                let mut shown = Self::of_mesh(entry, material, *surface.transform(), tessellation.mesh, painted);
                let tiles = tessellation.tiles.iter();
                let mut kept = tiles.map(|tile| !patches.contains_key(tile));
                shown.triangles.retain(|_| kept.next().unwrap_or(true));
                shown.patches = patches.into_values().collect();
                shown.steps = world.scene.output.rate.max(2).ilog2();
                return Ok(shown);
            }
        };
        Ok(Self::of_mesh(entry, material, transform, mesh, painted))
    }

    fn of_mesh(entry: &'a ObjectEntry, material: Material, transform: DAffine3, mesh: Mesh, painted: bool) -> Self {
        let colors = point_colors(entry, material.base_color, &mesh, painted);
        let triangles = fans(&mesh);
        let (name, patches) = (entry.name.text.as_str(), Vec::new());
        Self { name, material, transform, mesh, triangles, colors, patches, steps: 0, fluid: None }
    }

    fn write(&self, out: &mut impl Write) -> std::io::Result<()> {
        if self.triangles.is_empty() && self.patches.is_empty() && self.fluid.is_none() {
            return Ok(());
        }
        // A union of one is warned about.
        let kind = if self.patches.is_empty() { "object" } else { "union" };
        let columns = [self.transform.matrix3.x_axis, self.transform.matrix3.y_axis, self.transform.matrix3.z_axis];
        let numbers = columns.into_iter().chain([self.transform.translation]).flat_map(|column| column.to_array());
        let numbers: Vec<String> = numbers.map(|number| number.to_string()).collect();
        writeln!(out, "\n// {}\n#declare Object_Place = transform {{", printable(self.name))?;
        writeln!(out, "  matrix <{}>\n}}", numbers.join(", "))?;
        if let Some(fluid) = &self.fluid {
            fluid.declare(out)?;
        }
        writeln!(out, "{kind} {{")?;
        if let Some(fluid) = &self.fluid {
            fluid.write(out)?;
        }
        if !self.triangles.is_empty() {
            self.write_mesh(out)?;
        }
        for (points, color) in &self.patches {
            write_patch(out, points, self.steps, &texture(*color, &self.material))?;
        }
        writeln!(out, "{}", texture(self.material.base_color, &self.material))?;
        writeln!(out, "transform {{ Object_Place }}\n}}")
    }

    fn write_mesh(&self, out: &mut impl Write) -> std::io::Result<()> {
        let mesh = &self.mesh;
        // Only what the triangles use.
        let used = Used::new(self.triangles.iter().flatten().map(|corner| mesh.corners[*corner]));
        writeln!(out, "mesh2 {{")?;
        list(out, "vertex_vectors", used.kept.iter().map(|point| vector(mesh.points[*point as usize])))?;
        if let Some(normals) = floats(mesh, "normal", Domain::Point, 3) {
            let normal = |point: &u32| [0, 1, 2].map(|axis| normals[3 * *point as usize + axis]);
            // POV-Ray refuses normals without a length.
            let normal = |point: &u32| Some(normal(point)).filter(|n| *n != [0.0; 3]).unwrap_or([0.0, 0.0, 1.0]);
            list(out, "normal_vectors", used.kept.iter().map(|point| vector(normal(point))))?;
        }
        let coordinates = Coordinates::new(mesh, &self.triangles);
        if let Some(coordinates) = &coordinates {
            list(out, "uv_vectors", coordinates.values.iter().map(|[u, v]| format!("<{u}, {v}>")))?;
        }
        let corners = |triangle: &[usize; 3]| triangle.map(|corner| used.number[&mesh.corners[corner]]);
        match &self.colors {
            Some(colors) => {
                let palette = Palette::new(used.kept.iter().map(|point| colors[*point as usize]));
                list(out, "texture_list", palette.colors.iter().map(|color| texture(*color, &self.material)))?;
                let faces = self.triangles.iter().map(|triangle| {
                    let corners = corners(triangle);
                    let [a, b, c] = corners.map(|corner| palette.indices[corner as usize]);
                    format!("{}, {a}, {b}, {c}", vector(corners))
                });
                list(out, "face_indices", faces)?;
            }
            None => list(out, "face_indices", self.triangles.iter().map(|triangle| vector(corners(triangle))))?,
        }
        if let Some(coordinates) = &coordinates {
            list(out, "uv_indices", coordinates.indices.iter().map(|indices| vector(*indices)))?;
        }
        writeln!(out, "}}")
    }
}

/// The corners of all triangles; polygons are fanned, holes left out.
fn fans(mesh: &Mesh) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    let mut first = 0;
    for (face, size) in (0..).zip(&mesh.face_sizes) {
        let size = *size as usize;
        if !mesh.holes.contains(&face) {
            triangles.extend((2..size).map(|corner| [first, first + corner - 1, first + corner]));
        }
        first += size;
    }
    triangles
}

/// Numbers that are used, counted anew in their order.
struct Used {
    kept: Vec<u32>,
    number: BTreeMap<u32, u32>,
}

impl Used {
    fn new(numbers: impl Iterator<Item = u32>) -> Self {
        let mut kept: Vec<u32> = numbers.collect();
        kept.sort_unstable();
        kept.dedup();
        let number = kept.iter().copied().zip(0..).collect();
        Self { kept, number }
    }
}

/// Texture coordinates of corners.
struct Coordinates {
    values: Vec<[f32; 2]>,
    /// Of every triangle.
    indices: Vec<[u32; 3]>,
}

impl Coordinates {
    fn new(mesh: &Mesh, triangles: &[[usize; 3]]) -> Option<Self> {
        let attribute = mesh.attribute("uv").filter(|uv| uv.width == 2 && uv.domain != Domain::Face)?;
        let Values::F32(values) = &attribute.values else { return None };
        let place = |corner: usize| match (attribute.domain, &attribute.indices) {
            (Domain::Corner, Some(indices)) => indices[corner],
            (Domain::Corner, None) => corner as u32,
            _ => mesh.corners[corner],
        };
        let used = Used::new(triangles.iter().flatten().map(|corner| place(*corner)));
        let value = |at: &u32| [values[2 * *at as usize], values[2 * *at as usize + 1]];
        Some(Self {
            values: used.kept.iter().map(value).collect(),
            indices: triangles.iter().map(|triangle| triangle.map(|corner| used.number[&place(corner)])).collect(),
        })
    }
}

/// Textures that POV-Ray may have to hold for one mesh.
const MAX_TEXTURES: usize = 1 << 16;

/// The colours of a mesh, rounded so that vertices share them.
struct Palette {
    colors: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl Palette {
    /// In steps of 1/255 of the encoded value, twice as large until there are few enough.
    fn new(colors: impl Iterator<Item = [f32; 3]> + Clone) -> Self {
        let mut steps = 255.0;
        loop {
            if let Some(palette) = Self::in_steps(steps, colors.clone()) {
                return palette;
            }
            steps *= 0.5;
        }
    }

    /// `None` if there are too many.
    fn in_steps(steps: f32, colors: impl Iterator<Item = [f32; 3]>) -> Option<Self> {
        let mut numbers: BTreeMap<[u32; 3], u32> = BTreeMap::new();
        let mut palette = Self { colors: Vec::new(), indices: Vec::new() };
        for color in colors {
            // Brighter than 1 is not clipped.
            let key = color.map(|value| (encode_srgb(value.max(0.0)) * steps).round() as u32);
            let count = numbers.len() as u32;
            let index = *numbers.entry(key).or_insert(count);
            if index == count {
                palette.colors.push(key.map(|step| decode_srgb(step as f32 / steps)));
            }
            if palette.colors.len() > MAX_TEXTURES {
                return None;
            }
            palette.indices.push(index);
        }
        Some(palette)
    }
}

/// Textures of surfaces: Lambert's reflection with a highlight. A file that includes the scene may have other ones, by a
/// macro of this name of its own, to which `Object_Place` says where the object is.
const TEXTURES: &str = "\
#ifndef (Surface_Texture)
#macro Surface_Texture(Color, Specular, Roughness)
  texture { pigment { rgb Color } finish { ambient 0 diffuse 1 specular Specular roughness Roughness } }
#end
#end
";

/// The call of the macro of textures. POV-Ray's lights bring π times less than ours, which are irradiances; its
/// highlight is Blinn's, here as wide and, seen straight on, as bright as the GGX lobe of the ray caster.
fn texture([r, g, b]: [f32; 3], material: &Material) -> String {
    let alpha = material.roughness.max(0.05).powi(2);
    let exponent = (2.0 / (alpha * alpha) - 2.0).max(1.0);
    let specular = material.specular * (exponent + 2.0) / 8.0;
    format!("Surface_Texture(<{r}, {g}, {b}>, {specular}, {})", 1.0 / exponent)
}

fn write_head(
    out: &mut String,
    view: &Camera,
    [width, height]: [u32; 2],
    lights: &Lights,
    exposure: f64,
    (low, high): (DVec3, DVec3),
) {
    let exposed = |color: [f32; 3]| color.map(|value| f64::from(value) * exposure);
    let dark = is_dark(&lights.sky);
    let _ = writeln!(
        out,
        "// Written by Relievo. Render with: povray +W{width} +H{height} +A +I<this file>\n#version 3.7;\n\
         global_settings {{ assumed_gamma 1"
    );
    if !dark {
        // The light of the sky.
        out.push_str("  radiosity { pretrace_start 0.08 pretrace_end 0.01 count 200 nearest_count 8 error_bound 0.5\n");
        out.push_str("    recursion_limit 2 low_error_factor 0.5 gray_threshold 0 brightness 1 }\n");
    }
    out.push_str("}\n");
    out.push_str(TEXTURES);
    let half = (0.5 * view.fov).tan();
    let [right, up, back] = [view.axes.x_axis, view.axes.y_axis, view.axes.z_axis];
    let right = right * (2.0 * half * f64::from(width) / f64::from(height));
    let _ = writeln!(
        out,
        "#declare Camera_Place = {};\n#declare Camera_Direction = {};\n\
         camera {{ perspective\n  location Camera_Place\n  direction Camera_Direction\n  right {}\n  up {}\n}}",
        vector(view.eye.to_array()),
        vector((-back).to_array()),
        vector(right.to_array()),
        vector((up * (2.0 * half)).to_array())
    );
    let middle = 0.5 * (low + high);
    let far = 100.0 * (high - low).length().max(1e-6);
    for sun in &lights.suns {
        let direction = DVec3::from(sun.direction.map(f64::from)).normalize_or(DVec3::Z);
        let place = middle + direction * far;
        let color = exposed(sun.irradiance).map(|value| value * std::f64::consts::FRAC_1_PI);
        let _ = write!(out, "light_source {{ {} color rgb {}", vector(place.to_array()), vector(color));
        if sun.angular_radius > 0.0 {
            let side = direction.any_orthonormal_vector();
            let size = 2.0 * far * f64::from(sun.angular_radius).tan();
            let [one, other] = [side * size, direction.cross(side) * size].map(|axis| vector(axis.to_array()));
            let _ = write!(out, "\n  area_light {one}, {other}, 9, 9 adaptive 2 circular");
        }
        let _ = writeln!(out, "\n  parallel point_at {} }}", vector(middle.to_array()));
    }
    if !dark {
        write_sky(out, &lights.sky, exposure);
    }
}

fn write_sky(out: &mut String, sky: &Sky, exposure: f64) {
    let up = vector(DVec3::from(sky.up.map(f64::from)).normalize_or(DVec3::Z).to_array());
    let _ = writeln!(out, "sky_sphere {{ pigment {{ gradient {up} color_map {{");
    for (height, color) in sky_stops(sky) {
        let color = vector(color.map(|value| value * exposure));
        let _ = writeln!(out, "  [{} color rgb {color}]", 0.5 + 0.5 * height);
    }
    let _ = writeln!(out, "}} scale 2 translate -{up} }} }}");
}

/// Whether the sky brings no light.
pub(crate) fn is_dark(sky: &Sky) -> bool {
    [sky.zenith, sky.horizon, sky.ground].iter().flatten().all(|value| *value == 0.0)
}

/// Steps of the sky's colours above the horizon.
const STEPS: i32 = 16;

/// The sky as colours at sines of elevations, ascending from −1, linear in between: it goes from the horizon to the zenith
/// with the root of the sine, and to the ground within an eighth of it.
pub(crate) fn sky_stops(sky: &Sky) -> Vec<(f64, [f64; 3])> {
    let [zenith, horizon, ground] = [sky.zenith, sky.horizon, sky.ground].map(|color| color.map(f64::from));
    let above = (0..=STEPS).map(|step| {
        let share = f64::from(step) / f64::from(STEPS);
        (share * share, [0, 1, 2].map(|k| horizon[k] + (zenith[k] - horizon[k]) * share))
    });
    [(-1.0, ground), (-0.125, ground)].into_iter().chain(above).collect()
}

fn vector<T: std::fmt::Display>(values: [T; 3]) -> String {
    let [x, y, z] = values;
    format!("<{x}, {y}, {z}>")
}

/// `name { count, item, item }`
fn list(out: &mut impl Write, name: &str, items: impl ExactSizeIterator<Item = String>) -> std::io::Result<()> {
    write!(out, "{name} {{ {}", items.len())?;
    for item in items {
        write!(out, ",\n  {item}")?;
    }
    writeln!(out, " }}")
}

/// A name within a comment.
fn printable(name: &str) -> String {
    name.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect()
}
