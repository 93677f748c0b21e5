//! Articulated models: triangles whose vertices follow bones. Static models have one bone.
//!
//! All meshes that a file shows become one list of vertices and one of triangles, so that clusters may reach across
//! meshes and materials. Lengths are units of the file.

use std::collections::{HashMap, HashSet};

use glam::{DAffine3, DVec3};
use relievo_core::{Attribute, Context, Domain, Error, Mesh, Result, Values};
use relievo_meshio::{Model, Node, Part, Property};

use crate::morph::{MAX_MORPHS, MorphOffset, Morphs};

/// Bones that a character may have; they are numbered in 16 bits.
pub const MAX_BONES: usize = 1 << 16;
/// Triangles that a character may have.
pub const MAX_TRIANGLES: usize = 1 << 28;

/// The bones that move a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influence {
    /// Bones, as indices into [`Character::bones`].
    pub bones: [u16; 4],
    /// Weights of the bones. They add up to 1; unused ones are 0.
    pub weights: [f32; 4],
}

/// A bone: a node of the skeleton, and where the vertices were when they were bound to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Bone {
    /// Name of the node, empty if the file gives none.
    pub name: String,
    /// The node, as an index into [`Character::parents`].
    pub node: u32,
    /// The map from the space of the vertices to that of the node, at binding.
    pub inverse_bind: DAffine3,
}

/// An articulated model at binding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Character {
    /// Positions at binding.
    pub points: Vec<[f32; 3]>,
    /// What moves each vertex.
    pub influences: Vec<Influence>,
    /// Vertices of every triangle, counter-clockwise from its front.
    pub triangles: Vec<[u32; 3]>,
    /// Index of the material of every triangle.
    pub materials: Vec<u32>,
    /// Names of the materials.
    pub material_names: Vec<String>,
    /// Floats at the vertices: `normal`, `uv`, `color` and others.
    pub attributes: Vec<Attribute>,
    /// Bones.
    pub bones: Vec<Bone>,
    /// Parent of every node of the skeleton; it comes before its children.
    pub parents: Vec<Option<u32>>,
    /// Morph targets that clips move.
    pub morphs: Morphs,
}

/// A node of a file whose morph targets move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MorphNode {
    pub node: usize,
    /// The first of its morph targets among those of the character.
    pub first: usize,
    pub count: usize,
}

impl Character {
    /// Returns the bytes of a vertex in memory: place, influences and attributes.
    pub fn vertex_size(&self) -> usize {
        let widths: u32 = self.attributes.iter().map(|attribute| attribute.width).sum();
        12 + size_of::<Influence>() + 4 * widths as usize
    }

    /// Makes a character of all that a file shows. All morph targets keep their weights at rest.
    ///
    /// # Errors
    /// There are no triangles, or too many triangles or bones; a mesh is malformed.
    pub fn from_model(context: &Context, model: &Model) -> Result<Self> {
        Ok(Self::animated(context, model, &[])?.0)
    }

    /// As [`Self::from_model`]; morph targets that one of some animations moves become [`Self::morphs`]. Returns also the
    /// nodes that have them.
    ///
    /// # Errors
    /// As [`Self::from_model`], or there are too many morph targets.
    pub(crate) fn animated(context: &Context, model: &Model, animations: &[usize]) -> Result<(Self, Vec<MorphNode>)> {
        let moving: HashSet<usize> = animations
            .iter()
            .filter_map(|index| model.animations.get(*index))
            .flat_map(|animation| &animation.channels)
            .filter(|channel| channel.property == Property::Weights)
            .map(|channel| channel.node)
            .collect();
        let mut nodes = Vec::new();
        let mut made = Self {
            material_names: model.materials.clone(),
            parents: model.nodes.iter().map(|node| node.parent.map(|parent| parent as u32)).collect(),
            ..Self::default()
        };
        let rest = model.rest(context);
        let mut bones = HashMap::new();
        for (node, shape) in shown(model).zip(&rest.shapes) {
            let (index, node, part) = node;
            let first = made.morphs.count;
            let moved = moving.contains(&index).then_some(first);
            made.append(model, (index, node, part), moved, shape.mirrored, &mut bones)
                .map_err(|error| error.at(format!("mesh `{}`", part.name)))?;
            if moved.is_some() {
                let count = made.morphs.count - first;
                nodes.push(MorphNode { node: index, first: first as usize, count: count as usize });
            }
        }
        match made.morphs.count {
            0 => made.morphs = Morphs::default(),
            _ => made.morphs.starts.push(made.morphs.offsets.len() as u32),
        }
        made.check()?;
        Ok((made, nodes))
    }

    /// Checks that all indices exist, numbers are finite and lists have the length they need.
    ///
    /// # Errors
    /// Names the first element that is wrong.
    pub fn check(&self) -> Result<()> {
        if self.triangles.is_empty() {
            return Err(Error::invalid("the model has no triangles").advise("give a model with at least one triangle"));
        }
        if self.triangles.len() > MAX_TRIANGLES {
            return Err(Error::unsupported(format!("the model has more than {MAX_TRIANGLES} triangles"))
                .advise("split the model"));
        }
        let points = self.points.len();
        if self.influences.len() != points || self.materials.len() != self.triangles.len() {
            return Err(Error::invalid("the lists of vertices or triangles differ in length"));
        }
        if let Some(index) = self.points.iter().position(|point| point.iter().any(|value| !value.is_finite())) {
            return Err(Error::invalid(format!("vertex {index} is not finite")).advise("repair the model"));
        }
        let outside = |triangle: &[u32; 3]| triangle.iter().any(|vertex| *vertex as usize >= points);
        if let Some(index) = self.triangles.iter().position(outside) {
            return Err(Error::invalid(format!("triangle {index} has a vertex that does not exist")));
        }
        let wrong = |influence: &Influence| {
            let sum: f32 = influence.weights.iter().sum();
            let known = influence.bones.iter().all(|bone| usize::from(*bone) < self.bones.len());
            !known || !((sum - 1.0).abs() < 1e-3) || influence.weights.iter().any(|weight| *weight < 0.0)
        };
        if let Some(index) = self.influences.iter().position(wrong) {
            return Err(Error::invalid(format!("the weights of vertex {index} do not add up to 1"))
                .advise("normalise the weights and export the model again"));
        }
        for attribute in &self.attributes {
            let fits = attribute.domain == Domain::Point
                && attribute.indices.is_none()
                && (1..=4).contains(&attribute.width)
                && (attribute.name != "normal" || attribute.width == 3)
                && attribute.values.len() == points * attribute.width as usize
                && matches!(&attribute.values, Values::F32(values) if values.iter().all(|value| value.is_finite()));
            if !fits {
                return Err(Error::invalid(format!("the attribute `{}` does not fit the vertices", attribute.name)));
            }
        }
        if !self.morphs.fits(points) {
            return Err(Error::invalid("the morph targets do not fit the vertices"));
        }
        let nodes = self.parents.len() as u32;
        if self.bones.iter().any(|bone| bone.node >= nodes || !bone.inverse_bind.is_finite()) {
            return Err(Error::invalid("a bone has no node or is not finite"));
        }
        let late = |(node, parent): (usize, &Option<u32>)| parent.is_some_and(|parent| parent as usize >= node);
        if self.parents.iter().enumerate().any(late) {
            return Err(Error::invalid("a node comes before its parent"));
        }
        Ok(())
    }

    /// Returns the numbers of a point attribute, if the character has it.
    pub fn values(&self, name: &str) -> Option<&[f32]> {
        match &self.attributes.iter().find(|attribute| attribute.name == name)?.values {
            Values::F32(values) => Some(values),
            Values::U32(_) => None,
        }
    }

    fn append(
        &mut self,
        model: &Model,
        (index, node, part): (usize, &Node, &Part),
        moved: Option<u32>,
        is_mirrored: bool,
        bones: &mut HashMap<(usize, Option<usize>), u16>,
    ) -> Result<()> {
        part.mesh.check()?;
        let skin = node.skin.and_then(|skin| Some((skin, model.skins.get(skin)?)));
        let mut bone = |key: (usize, Option<usize>), node: usize, inverse_bind: DAffine3| -> Result<u16> {
            if let Some(found) = bones.get(&key) {
                return Ok(*found);
            }
            let number = u16::try_from(self.bones.len())
                .map_err(|_| Error::unsupported(format!("the model has more than {MAX_BONES} bones")))?;
            let name = model.nodes[node].name.clone();
            self.bones.push(Bone { name, node: node as u32, inverse_bind });
            bones.insert(key, number);
            Ok(number)
        };
        // The bones of the skin, or the node itself.
        let palette = match skin {
            Some((number, skin)) => {
                let joints = skin.joints.iter().zip(&skin.inverse_bind).enumerate();
                joints
                    .map(|(joint, (node, inverse))| bone((joint, Some(number)), *node, *inverse))
                    .collect::<Result<Vec<_>>>()?
            }
            None => vec![bone((index, None), index, DAffine3::IDENTITY)?],
        };
        let points = if moved.is_some() { part.mesh.points.clone() } else { morphed(node, part) };
        let influences = influences(&part.mesh, skin.is_some(), &palette);
        let split = Split::of(&part.mesh);
        let first = self.points.len();
        if first + split.points.len() > u32::MAX as usize {
            return Err(Error::unsupported("the model has 2^32 or more vertices").advise("split the model"));
        }
        self.points.extend(split.points.iter().map(|point| points[*point as usize]));
        self.influences.extend(split.points.iter().map(|point| influences[*point as usize]));
        self.add_offsets(part, &split, moved)?;
        self.unite(&part.mesh, &split, first);
        let slots = part.mesh.attribute("material").filter(|slots| slots.domain == Domain::Face);
        for (triangle, face) in &split.triangles {
            let mut triangle = triangle.map(|vertex| first as u32 + vertex);
            if is_mirrored {
                triangle.swap(1, 2);
            }
            self.triangles.push(triangle);
            self.materials.push(match slots.map(|slots| &slots.values) {
                Some(Values::U32(slots)) => slots.get(*face as usize).copied().unwrap_or_default(),
                _ => 0,
            });
        }
        Ok(())
    }

    /// Gives the last vertices the offsets of the morph targets of their mesh, which count from `moved`.
    fn add_offsets(&mut self, part: &Part, split: &Split, moved: Option<u32>) -> Result<()> {
        let targets = if moved.is_some() { part.targets.as_slice() } else { &[] };
        let first = moved.unwrap_or_default();
        if first as usize + targets.len() > MAX_MORPHS {
            return Err(Error::unsupported(format!("the clips move more than {MAX_MORPHS} morph targets"))
                .advise("build from fewer clips"));
        }
        for point in &split.points {
            self.morphs.starts.push(self.morphs.offsets.len() as u32);
            for (target, morph) in targets.iter().zip(first..) {
                let offset = target.get(*point as usize).copied().unwrap_or_default();
                if offset != [0.0; 3] {
                    self.morphs.offsets.push(MorphOffset { morph, offset });
                }
            }
        }
        if self.morphs.offsets.len() > u32::MAX as usize {
            return Err(Error::unsupported("the morph targets have 2^32 or more offsets").advise("split the model"));
        }
        self.morphs.count += targets.len() as u32;
        Ok(())
    }

    /// Gives every attribute values for the vertices from `first` on; attributes that a mesh lacks are 0, colours 1.
    fn unite(&mut self, mesh: &Mesh, split: &Split, first: usize) {
        let filler = |name: &str| if name.starts_with("color") { 1.0 } else { 0.0 };
        let known: Vec<&Attribute> = mesh
            .attributes
            .iter()
            .filter(|it| it.domain != Domain::Face && matches!(it.values, Values::F32(_)) && it.name != "weights")
            .collect();
        for source in &known {
            if !self.attributes.iter().any(|it| it.name == source.name) {
                let values = Values::F32(vec![filler(&source.name); first * source.width as usize]);
                let (name, width) = (source.name.clone(), source.width);
                self.attributes.push(Attribute { name, domain: Domain::Point, width, values, indices: None });
            }
        }
        for attribute in &mut self.attributes {
            let Values::F32(values) = &mut attribute.values else { continue };
            let width = attribute.width as usize;
            let source = known.iter().find(|it| it.name == attribute.name && it.width == attribute.width);
            match source {
                Some(source) => {
                    for (point, corner) in split.points.iter().zip(&split.corners) {
                        values.extend(element(source, *point, *corner).map(f32::from_bits));
                    }
                }
                None => values.resize(values.len() + width * split.points.len(), filler(&attribute.name)),
            }
        }
    }
}

/// Returns the nodes that show a mesh, with their numbers.
fn shown(model: &Model) -> impl Iterator<Item = (usize, &Node, &Part)> {
    let nodes = model.nodes.iter().enumerate();
    nodes.filter_map(|(index, node)| Some((index, node, model.meshes.get(node.mesh?)?)))
}

/// Returns the points of a mesh with its morph targets at their weights at rest.
fn morphed(node: &Node, part: &Part) -> Vec<[f32; 3]> {
    let weights = node.weights.as_ref().unwrap_or(&part.weights);
    let mut points = part.mesh.points.clone();
    for (target, weight) in part.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        for (point, offset) in points.iter_mut().zip(target) {
            let moved = DVec3::from(point.map(f64::from)) + DVec3::from(offset.map(f64::from)) * f64::from(*weight);
            *point = moved.as_vec3().to_array();
        }
    }
    points
}

/// Returns what moves the points of a mesh; `palette` has the bones of its skin, or its one bone.
fn influences(mesh: &Mesh, is_skinned: bool, palette: &[u16]) -> Vec<Influence> {
    let values = |name: &str| mesh.attribute(name).map(|attribute| &attribute.values);
    let rigid = Influence { bones: [palette[0]; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    match (values("joints"), values("weights")) {
        (Some(Values::U32(joints)), Some(Values::F32(weights))) if is_skinned => {
            let pairs = joints.as_chunks::<4>().0.iter().zip(weights.as_chunks::<4>().0);
            pairs
                .map(|(joints, weights)| {
                    let bones = joints.map(|joint| palette.get(joint as usize).copied().unwrap_or(palette[0]));
                    Influence { bones, weights: *weights }
                })
                .collect()
        }
        _ => vec![rigid; mesh.points.len()],
    }
}

/// Vertices of a mesh: its points, several where corners of one point differ in attributes.
struct Split {
    /// The point of every vertex.
    points: Vec<u32>,
    /// A corner of every vertex.
    corners: Vec<u32>,
    /// Triangles of vertices, and the face of each.
    triangles: Vec<([u32; 3], u32)>,
}

impl Split {
    fn of(mesh: &Mesh) -> Self {
        let at_corners: Vec<&Attribute> = mesh.attributes.iter().filter(|it| it.domain == Domain::Corner).collect();
        let mut made = Self { points: Vec::new(), corners: Vec::new(), triangles: Vec::new() };
        if at_corners.is_empty() {
            made.points = (0..mesh.points.len() as u32).collect();
            made.corners = vec![0; mesh.points.len()];
        }
        let mut known: HashMap<Vec<u32>, u32> = HashMap::new();
        let mut first = 0;
        for (face, size) in mesh.face_sizes.iter().enumerate() {
            let corners: Vec<u32> = (first..first + size).collect();
            first += size;
            if mesh.holes.contains(&(face as u32)) {
                continue;
            }
            let vertices: Vec<u32> = corners
                .iter()
                .map(|corner| {
                    let point = mesh.corners[*corner as usize];
                    if at_corners.is_empty() {
                        return point;
                    }
                    let mut key = vec![point];
                    at_corners.iter().for_each(|it| key.extend(element(it, point, *corner)));
                    *known.entry(key).or_insert_with(|| {
                        made.points.push(point);
                        made.corners.push(*corner);
                        made.points.len() as u32 - 1
                    })
                })
                .collect();
            let fan = (2..vertices.len()).map(|last| [vertices[0], vertices[last - 1], vertices[last]]);
            made.triangles.extend(fan.map(|triangle| (triangle, face as u32)));
        }
        made
    }
}

/// Returns the bits of an attribute at a point or one of its corners.
fn element(attribute: &Attribute, point: u32, corner: u32) -> impl Iterator<Item = u32> {
    let index = match (attribute.domain, &attribute.indices) {
        (Domain::Corner, Some(indices)) => indices[corner as usize],
        (Domain::Corner, None) => corner,
        _ => point,
    };
    let width = attribute.width as usize;
    let range = index as usize * width..(index as usize + 1) * width;
    range.map(move |at| match &attribute.values {
        Values::F32(values) => values[at].to_bits(),
        Values::U32(values) => values[at],
    })
}
