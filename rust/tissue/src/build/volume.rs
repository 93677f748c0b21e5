//! Volumes that a model is made from (Section 4): closed surfaces on levels, with materials, skin layers and muscles.

use glam::{DVec3, Vec3};
use relievo_core::{Error, Result};

use crate::build::bend::Bend;
use crate::build::nurbs::NurbsMuscle;
use crate::distance::DistanceField;
use crate::material::{Material, Muscle};
use crate::model::{Model, Shape};

/// Volumes at most: the bits of a mask.
pub(crate) const MAX: usize = 64;

/// What a model is made from.
#[derive(Clone, Debug, Default)]
pub struct Description {
    /// Size of the voxels in metres.
    pub cell: [f32; 3],
    /// Samples of a voxel along each axis.
    pub samples: u32,
    /// Share of its samples above which a voxel is an element.
    pub share: f32,
    /// Materials, which volumes and layers name by index.
    pub materials: Vec<Material>,
    /// Volumes.
    pub volumes: Vec<Volume>,
    /// The outer skin, with its layers.
    pub skin: Option<Skin>,
    /// Surfaces that hold nodes.
    pub restraints: Vec<Restraint>,
    /// Surfaces that follow the model.
    pub bound: Vec<Shape>,
    /// How the finished model is bent, with all its surfaces. Volumes, skin and restraints are those of the flat block.
    pub bend: Option<Bend>,
}

/// A closed surface and what is inside.
#[derive(Clone, Debug)]
pub struct Volume {
    /// Its surface, closed, counter-clockwise seen from outside.
    pub shape: Shape,
    /// Level: 0 makes elements, and each lower level overrides the one above it within that.
    pub level: u32,
    /// Index of the material.
    pub material: u32,
    /// Whether the layers of the skin are in it.
    pub has_layers: bool,
    /// The muscle that it is, and the direction of its fibres.
    pub muscle: Option<(Muscle, FibreField)>,
}

/// The direction of the fibres of a muscle.
#[derive(Clone, Debug)]
pub enum FibreField {
    /// The same everywhere.
    Uniform(DVec3),
    /// Along a NURBS volume.
    Nurbs(Box<NurbsMuscle>),
}

/// The outer skin.
#[derive(Clone, Debug)]
pub struct Skin {
    /// Its surface, which need not be closed; normals point outwards.
    pub shape: Shape,
    /// Layers by depth, which may overlap.
    pub layers: Vec<Layer>,
    /// Index of the material and thickness in metres of the outermost layer, which is thinner than voxels.
    pub epidermis: Option<(u32, f32)>,
}

/// A layer of the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Index of the material.
    pub material: u32,
    /// Depth in metres at which it starts.
    pub start: f32,
    /// Thickness in metres.
    pub thickness: f32,
}

/// A surface that holds the nodes near it.
#[derive(Clone, Debug)]
pub struct Restraint {
    /// The surface. Normals of an external one point out of the model.
    pub shape: Shape,
    /// Whether nodes slide on it; otherwise they do not move.
    pub is_sliding: bool,
    /// Whether it lies within the model; otherwise it is part of its border.
    pub is_internal: bool,
    /// The largest angle in radians between the normal of the surface and that of an outer node.
    pub angle: f32,
}

impl Description {
    /// Checks that a model can be made of it.
    ///
    /// # Errors
    /// Fails if a number is out of its range, there is no volume or none on level 0, an index does not exist, a volume
    /// has layers without a skin, or the surface of a volume is not closed.
    pub fn check(&self) -> Result<()> {
        if !self.cell.iter().all(|size| *size > 1e-7 && *size < 1e6) {
            return Err(Error::invalid(format!("voxels of {:?} m cannot be", self.cell))
                .at("voxel")
                .advise("use 1e-7 to 1e6"));
        }
        if !(1..=32).contains(&self.samples) {
            return Err(Error::invalid(format!("{} samples along an axis cannot be", self.samples))
                .at("samples")
                .advise("use 1 to 32"));
        }
        if !(0.0..1.0).contains(&self.share) {
            return Err(Error::invalid(format!("a share of {} cannot be", self.share))
                .at("share")
                .advise("use 0 to below 1"));
        }
        self.materials.iter().try_for_each(Material::check)?;
        if self.volumes.is_empty() || self.volumes.len() > MAX {
            return Err(Error::invalid(format!("{} volumes make no model", self.volumes.len()))
                .advise(format!("give 1 to {MAX}")));
        }
        if !self.volumes.iter().any(|volume| volume.level == 0) {
            return Err(
                Error::invalid("no volume is on level 0").advise("put the volume that contains the others on level 0")
            );
        }
        let is_known = |material: u32| (material as usize) < self.materials.len();
        for volume in &self.volumes {
            let named = |error: Error| error.at(format!("volume `{}`", volume.shape.name));
            if !is_known(volume.material) {
                return Err(named(Error::invalid(format!("material {} does not exist", volume.material))));
            }
            if volume.has_layers && self.skin.is_none() {
                return Err(named(
                    Error::invalid("it has layers, but there is no skin").advise("give the skin a surface and layers"),
                ));
            }
            if let Some((muscle, field)) = &volume.muscle {
                muscle.check().map_err(named)?;
                if let FibreField::Uniform(direction) = field
                    && !(direction.length() > 1e-12 && direction.is_finite())
                {
                    return Err(named(
                        Error::invalid("the fibres have no direction").advise("use a vector that is not zero"),
                    ));
                }
            }
            check_closed(&volume.shape).map_err(named)?;
        }
        if let Some(skin) = &self.skin {
            let is_sound = |layer: &Layer| is_known(layer.material) && layer.start.is_finite() && layer.thickness > 0.0;
            let is_thin =
                |(material, thickness): &(u32, f32)| is_known(*material) && *thickness > 0.0 && thickness.is_finite();
            if !skin.layers.iter().all(is_sound) || !skin.epidermis.iter().all(is_thin) {
                return Err(Error::invalid("a layer has no material, or no positive thickness").at("skin"));
            }
        }
        Ok(())
    }
}

impl FibreField {
    /// Returns the unit direction at a place. `near` holds the parameters of the place before and gets those of this one.
    pub(crate) fn direction(&self, place: Vec3, near: &mut Option<DVec3>) -> Vec3 {
        match self {
            Self::Uniform(direction) => direction.normalize().as_vec3(),
            Self::Nurbs(muscle) => {
                let (direction, at) = muscle.direction(place.as_dvec3(), *near);
                *near = Some(at);
                direction.as_vec3()
            }
        }
    }
}

/// Fails unless every edge of a surface is in two triangles that are wound the same way, and it is not inside out.
fn check_closed(shape: &Shape) -> Result<()> {
    let missing = |corners: &[u32; 3]| corners.iter().any(|point| *point as usize >= shape.points.len());
    if let Some(triangle) = shape.triangles.iter().position(missing) {
        return Err(Error::invalid("a point does not exist").at(format!("triangle {triangle}")));
    }
    if let Some(point) = shape.points.iter().position(|point| !point.iter().all(|at| at.is_finite())) {
        return Err(Error::invalid("a coordinate is not finite").at(format!("point {point}")));
    }
    let mut first = std::collections::HashMap::with_capacity(shape.points.len());
    let key = |point: &[f32; 3]| point.map(|at| (at + 0.0).to_bits());
    let joined: Vec<u32> =
        (0u32..).zip(&shape.points).map(|(number, at)| *first.entry(key(at)).or_insert(number)).collect();
    let mut edges: Vec<([u32; 2], i32)> = Vec::with_capacity(3 * shape.triangles.len());
    let mut volume = 0.0;
    let origin = Vec3::from(shape.points.first().copied().unwrap_or_default()).as_dvec3();
    for triangle in &shape.triangles {
        let ids = triangle.map(|point| joined[point as usize]);
        let [a, b, c] = triangle.map(|point| Vec3::from(shape.points[point as usize]).as_dvec3() - origin);
        volume += a.dot(b.cross(c));
        for side in 0..3 {
            let (from, to) = (ids[side], ids[(side + 1) % 3]);
            if from != to {
                edges.push(if from < to { ([from, to], 1) } else { ([to, from], -1) });
            }
        }
    }
    edges.sort_unstable_by_key(|edge| edge.0);
    let open = edges.chunk_by(|a, b| a.0 == b.0).find(|ways| ways.iter().map(|way| way.1).sum::<i32>() != 0);
    if let Some(ways) = open {
        let [a, b] = ways[0].0;
        return Err(Error::invalid("the surface is open, or its triangles are wound against each other")
            .at(format!("edge from point {a} to point {b}"))
            .advise("close it: `relievo mesh repair FILE` fills holes and turns faces"));
    }
    if volume <= 0.0 {
        return Err(Error::invalid("the surface is inside out or has no volume")
            .advise("turn its faces so that they are counter-clockwise seen from outside"));
    }
    Ok(())
}

/// The depth of places below a skin.
pub(crate) struct Depth {
    field: DistanceField,
    layers: Vec<Layer>,
    /// Depths at which a layer starts or ends.
    borders: Vec<f32>,
}

impl Depth {
    pub fn new(skin: &Skin) -> Result<Self> {
        let field = DistanceField::new(&skin.shape.points, &skin.shape.triangles).map_err(|error| error.at("skin"))?;
        let borders = skin.layers.iter().flat_map(|layer| [layer.start, layer.start + layer.thickness]).collect();
        Ok(Self { field, layers: skin.layers.clone(), borders })
    }

    /// Returns the depth of a place in metres and the triangle of the skin that is closest.
    pub fn at(&self, place: Vec3, near: Option<u32>) -> (f32, u32) {
        let closest = self.field.closest(place, near);
        (-closest.distance, closest.triangle)
    }

    /// Returns whether layers start or end within `reach` of a depth.
    pub fn is_mixed(&self, depth: f32, reach: f32) -> bool {
        self.borders.iter().any(|border| (border - depth).abs() <= reach)
    }

    /// Calls `add` with the material of each layer at a depth. Returns how many there are.
    pub fn layers(&self, depth: f32, mut add: impl FnMut(u32)) -> u32 {
        let is_in = |layer: &&Layer| depth >= layer.start && depth < layer.start + layer.thickness;
        let mut count = 0;
        for layer in self.layers.iter().filter(is_in) {
            count += 1;
            add(layer.material);
        }
        count
    }

    /// Returns whether the point of the skin closest to the middle of a box is in the box.
    pub fn crosses(&self, middle: Vec3, cell: Vec3) -> bool {
        let off = self.field.closest(middle, None).point - middle;
        off.abs().cmple(0.5001 * cell).all()
    }
}

/// Returns the middle of an element of boxes.
pub(crate) fn middle(model: &Model, element: usize) -> Vec3 {
    let [first, last] = [0, 6].map(|corner| Vec3::from(model.nodes[model.elements[element][corner] as usize]));
    0.5 * (first + last)
}
