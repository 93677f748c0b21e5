//! What a model is made of, in TOML: surfaces with materials, layers and muscles, or a labelled scan.

use std::path::{Path, PathBuf};

use relievo_core::{Context, Error, Progress, Result};
use relievo_tissue::{
    Bend, BuildReport, Description, FibreField, Labels, Layer, Material, Model, Muscle, NurbsMuscle, Range, Restraint,
    Scan, Shape, Skin, Volume,
};
use serde::Deserialize;

use super::body::Body;
use super::{description, folder, is_named};

/// A description of a model: what it is made of, and the folder from which its files are named.
#[derive(Debug)]
pub struct Recipe {
    source: Source,
    path: PathBuf,
}

#[derive(Debug)]
enum Source {
    Surfaces(Box<SurfaceRecipe>),
    Scan(Box<ScanRecipe>),
}

impl Recipe {
    /// Reads a description.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if the file cannot be read, with `Memory` if it is longer than 4 MiB, and with
    /// `Invalid` if it is not TOML, has unknown keys, or one without a default is missing.
    pub fn read(path: &Path) -> Result<Self> {
        let source = if description::<toml::Table>(path)?.contains_key("scan") {
            Source::Scan(Box::new(description(path)?))
        } else {
            Source::Surfaces(Box::new(description(path)?))
        };
        Ok(Self { source, path: path.to_owned() })
    }

    /// Leaves out the layers of the skin and the epidermis.
    pub fn remove_layers(&mut self) {
        if let Source::Surfaces(recipe) = &mut self.source {
            recipe.skin = None;
            recipe.volume.iter_mut().for_each(|volume| volume.layers = false);
        }
    }

    /// Returns the files that it names.
    pub fn files(&self) -> Vec<PathBuf> {
        let folder = folder(&self.path);
        match &self.source {
            Source::Scan(recipe) => vec![folder.join(&recipe.scan)],
            Source::Surfaces(recipe) => recipe.bodies().filter_map(Body::file).map(|file| folder.join(file)).collect(),
        }
    }

    /// Builds the model.
    ///
    /// # Errors
    /// Fails with `NotFound` or `Io` if a surface or scan cannot be read, with `Memory` if memory does not suffice,
    /// with `Cancelled` if `progress` asks to stop, and with `Invalid` if a number is out of range, a material does not
    /// exist, a surface is not closed, or the model has no element.
    pub fn build(&self, context: &Context, progress: &mut dyn Progress) -> Result<(Model, BuildReport)> {
        let folder = folder(&self.path);
        let built = match &self.source {
            Source::Scan(recipe) => recipe.build(context, &folder),
            Source::Surfaces(recipe) => {
                recipe.description(context, &folder).and_then(|description| description.build(context, progress))
            }
        };
        built.map_err(|error| error.at(self.path.display().to_string()))
    }
}

/// What a model is made of.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceRecipe {
    voxel: Size,
    #[serde(default = "samples")]
    samples: u32,
    #[serde(default = "share")]
    share: f32,
    #[serde(default)]
    material: Vec<MaterialEntry>,
    #[serde(default)]
    volume: Vec<VolumeEntry>,
    #[serde(default)]
    muscle: Vec<MuscleEntry>,
    skin: Option<SkinEntry>,
    /// Radii to which the model is bent, across and upwards.
    bend: Option<[f64; 2]>,
    #[serde(default)]
    hold: Vec<SurfaceEntry>,
    #[serde(default)]
    slide: Vec<SurfaceEntry>,
    #[serde(default)]
    bind: Vec<BindEntry>,
}

/// A model of a labelled scan.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ScanRecipe {
    scan: PathBuf,
    /// The grid of a `.vdb` file; left out, the first.
    grid: Option<String>,
    #[serde(default = "one")]
    block: u32,
    #[serde(default = "share")]
    share: f32,
    #[serde(default)]
    material: Vec<MaterialEntry>,
    #[serde(default)]
    label: Vec<LabelEntry>,
}

/// Values of the scan that are a material.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LabelEntry {
    material: String,
    low: f32,
    high: f32,
}

fn samples() -> u32 {
    4
}

fn share() -> f32 {
    0.5
}

/// One size for all axes, or one for each.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Size {
    Cube(f32),
    Box([f32; 3]),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialEntry {
    name: String,
    library: Option<String>,
    young: Option<f32>,
    poisson: Option<f32>,
    shear: Option<f32>,
    bulk: Option<f32>,
    density: Option<f32>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct VolumeEntry {
    name: String,
    body: Body,
    #[serde(default)]
    level: u32,
    material: String,
    #[serde(default)]
    layers: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MuscleEntry {
    name: String,
    #[serde(default = "one")]
    level: u32,
    material: String,
    /// Rings of control points, along the muscle.
    rings: Option<Vec<Vec<[f64; 3]>>>,
    /// A closed surface in place of rings, and the direction of its fibres.
    body: Option<Body>,
    direction: Option<[f64; 3]>,
    #[serde(default)]
    stiffness: f32,
    strength: f32,
}

fn one() -> u32 {
    1
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SkinEntry {
    body: Body,
    #[serde(default)]
    layer: Vec<LayerEntry>,
    epidermis: Option<EpidermisEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerEntry {
    material: String,
    #[serde(default)]
    start: f32,
    thickness: f32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct EpidermisEntry {
    material: String,
    thickness: f32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceEntry {
    name: String,
    body: Body,
    #[serde(default)]
    internal: bool,
    /// Degrees between its normals and those of outer nodes.
    #[serde(default = "angle")]
    angle: f32,
}

fn angle() -> f32 {
    89.0
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BindEntry {
    name: String,
    body: Body,
}

/// Returns the index of the material called `name`. Fails if there is none.
fn index(materials: &[MaterialEntry], name: &str) -> Result<u32> {
    let found = materials.iter().position(|material| material.name == name);
    found.map(|at| at as u32).ok_or_else(|| {
        let names: Vec<&str> = materials.iter().map(|material| material.name.as_str()).collect();
        Error::invalid(format!("there is no material `{name}`")).advise(format!("use one of {}", names.join(", ")))
    })
}

impl ScanRecipe {
    fn build(&self, context: &Context, folder: &Path) -> Result<(Model, BuildReport)> {
        let ranges = self.label.iter().map(|label| {
            Ok(Range { material: index(&self.material, &label.material)?, low: label.low, high: label.high })
        });
        let labels = Labels {
            block: self.block,
            share: self.share,
            materials: self.material.iter().map(MaterialEntry::material).collect::<Result<_>>()?,
            ranges: ranges.collect::<Result<_>>()?,
        };
        let path = folder.join(&self.scan);
        let scan = match (is_named(&path, "vdb"), &self.grid) {
            (true, name) => Scan::read_grid(context, &path, name.as_deref())?,
            (false, None) => Scan::read(context, &path)?,
            (false, Some(_)) => {
                return Err(Error::invalid("a scan has no grids")
                    .at("grid")
                    .advise("remove `grid`, or name a .vdb file"));
            }
        };
        labels.build(context, &scan)
    }
}

impl SurfaceRecipe {
    /// Returns all surfaces.
    fn bodies(&self) -> impl Iterator<Item = &Body> {
        let volumes = self.volume.iter().map(|entry| &entry.body);
        let muscles = self.muscle.iter().filter_map(|entry| entry.body.as_ref());
        let skin = self.skin.iter().map(|entry| &entry.body);
        let surfaces = self.hold.iter().chain(&self.slide).map(|entry| &entry.body);
        volumes.chain(muscles).chain(skin).chain(surfaces).chain(self.bind.iter().map(|entry| &entry.body))
    }

    fn description(&self, context: &Context, folder: &Path) -> Result<Description> {
        let mut description = Description {
            cell: match self.voxel {
                Size::Cube(size) => [size; 3],
                Size::Box(size) => size,
            },
            samples: self.samples,
            share: self.share,
            materials: self.material.iter().map(MaterialEntry::material).collect::<Result<_>>()?,
            bend: self.bend.map(|radii| Bend { radii }),
            ..Description::default()
        };
        let material = |name: &str| index(&self.material, name);
        for volume in &self.volume {
            description.volumes.push(Volume {
                shape: volume.body.shape(context, folder, &volume.name)?,
                level: volume.level,
                material: material(&volume.material)?,
                has_layers: volume.layers,
                muscle: None,
            });
        }
        for muscle in &self.muscle {
            description.volumes.push(muscle.volume(context, folder, material(&muscle.material)?)?);
        }
        if let Some(skin) = &self.skin {
            let layers = skin.layer.iter().map(|layer| {
                Ok(Layer { material: material(&layer.material)?, start: layer.start, thickness: layer.thickness })
            });
            let epidermis = skin.epidermis.as_ref().map(|it| material(&it.material).map(|found| (found, it.thickness)));
            description.skin = Some(Skin {
                shape: skin.body.shape(context, folder, "skin")?,
                layers: layers.collect::<Result<_>>()?,
                epidermis: epidermis.transpose()?,
            });
        }
        for (entries, is_sliding) in [(&self.hold, false), (&self.slide, true)] {
            for entry in entries {
                description.restraints.push(Restraint {
                    shape: entry.body.shape(context, folder, &entry.name)?,
                    is_sliding,
                    is_internal: entry.internal,
                    angle: entry.angle.to_radians(),
                });
            }
        }
        for entry in &self.bind {
            description.bound.push(entry.body.shape(context, folder, &entry.name)?);
        }
        Ok(description)
    }
}

impl MaterialEntry {
    fn material(&self) -> Result<Material> {
        let named = |error: Error| error.at(format!("material `{}`", self.name));
        let density = self.density.unwrap_or(1000.0);
        let material = match (&self.library, self.young, self.poisson, self.shear, self.bulk) {
            (Some(library), None, None, None, None) => {
                let found = Material::of_library(library).map_err(named)?;
                Material { density: self.density.unwrap_or(found.density), ..found }
            }
            (None, Some(young), Some(poisson), None, None) => {
                Material::of_young(&self.name, young, poisson, density).map_err(named)?
            }
            (None, None, None, Some(shear), Some(bulk)) => Material { name: String::new(), density, shear, bulk },
            _ => {
                return Err(named(
                    Error::invalid("its moduli are missing, or given twice")
                        .advise("give `library`, or `young` and `poisson`, or `shear` and `bulk`"),
                ));
            }
        };
        Ok(Material { name: self.name.clone(), ..material })
    }
}

impl MuscleEntry {
    fn volume(&self, context: &Context, folder: &Path, material: u32) -> Result<Volume> {
        let named = |error: Error| error.at(format!("muscle `{}`", self.name));
        let (shape, field) = match (&self.rings, &self.body, self.direction) {
            (Some(rings), None, None) => {
                let rings: Vec<Vec<[f64; 4]>> =
                    rings.iter().map(|ring| ring.iter().map(|[x, y, z]| [*x, *y, *z, 1.0]).collect()).collect();
                let muscle = NurbsMuscle::new(&rings).map_err(named)?;
                let (points, triangles) = muscle.mesh(48, 64);
                let shape = Shape { name: self.name.clone(), points, triangles };
                (shape, FibreField::Nurbs(Box::new(muscle)))
            }
            (None, Some(body), Some(direction)) => {
                (body.shape(context, folder, &self.name)?, FibreField::Uniform(direction.into()))
            }
            _ => {
                return Err(named(
                    Error::invalid("its shape is missing, or given twice")
                        .advise("give `rings` of control points, or `body` and `direction`"),
                ));
            }
        };
        let muscle = Muscle { name: self.name.clone(), stiffness: self.stiffness, strength: self.strength };
        Ok(Volume { shape, level: self.level, material, has_layers: false, muscle: Some((muscle, field)) })
    }
}
