//! What a file holds: meshes, the nodes that place them, skins and animations.
//!
//! Static formats give one mesh on one node. Lengths are in the file's units; glTF files and USD stages are in metres with y up.

use glam::{DAffine3, DQuat, DVec3};
use relievo_core::Mesh;

use crate::transform::Operation;

/// The contents of a file. Every index in it exists; see [`Model::merged_mesh`] for one mesh of everything.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Meshes, each in its own space.
    pub meshes: Vec<Part>,
    /// Nodes; a parent comes before its children.
    pub nodes: Vec<Node>,
    /// Skins.
    pub skins: Vec<Skin>,
    /// Animations.
    pub animations: Vec<Animation>,
    /// Names of the slots that the face attribute `material` refers to.
    pub materials: Vec<String>,
    /// Names of the slots that the face attribute `group` refers to.
    pub groups: Vec<String>,
    /// Whether the file says its unit and which axis is up, so that it was brought to metres with y up: others want it
    /// in theirs. What glTF is in by definition is left as it is.
    pub is_converted: bool,
    /// What was left out or repaired while reading, for the user to know.
    pub notes: Vec<String>,
}

/// A mesh and what deforms it before it is placed.
///
/// Its indices exist and its numbers are finite; faces of fewer than three corners or with a repeated point are kept
/// as the file has them, and [`Mesh::check`] refuses them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Name, empty if the file gives none.
    pub name: String,
    /// The undeformed mesh. A skinned one has the point attributes `joints` (indices into [`Skin::joints`]) and
    /// `weights` (which add up to one).
    pub mesh: Mesh,
    /// Morph targets: what each adds to every point at weight one.
    pub targets: Vec<Vec<[f32; 3]>>,
    /// Weights of the morph targets at rest, one per target.
    pub weights: Vec<f32>,
}

/// A node of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name, empty if the file gives none.
    pub name: String,
    /// The node whose space this one is placed in; its index is lower than this node's.
    pub parent: Option<usize>,
    /// Placement at rest.
    pub local: Placement,
    /// The mesh that is shown here.
    pub mesh: Option<usize>,
    /// The skin that deforms the mesh.
    pub skin: Option<usize>,
    /// Morph weights at rest that replace those of the mesh.
    pub weights: Option<Vec<f32>>,
}

/// Where a node is in its parent's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    /// First scaled, then rotated, then moved.
    Parts {
        /// Movement.
        translation: DVec3,
        /// Rotation, a unit quaternion.
        rotation: DQuat,
        /// Scale along the axes.
        scale: DVec3,
    },
    /// Any affine map.
    Matrix(DAffine3),
}

impl Placement {
    /// The identity.
    pub const IDENTITY: Self = Self::Matrix(DAffine3::IDENTITY);

    /// The map from the node's space to its parent's.
    pub fn matrix(&self) -> DAffine3 {
        match *self {
            Self::Parts { translation, rotation, scale } => {
                DAffine3::from_scale_rotation_translation(scale, rotation, translation)
            }
            Self::Matrix(matrix) => matrix,
        }
    }
}

/// The joints that deform a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Name, empty if the file gives none.
    pub name: String,
    /// The node of every joint.
    pub joints: Vec<usize>,
    /// The map from the mesh's space to every joint's, at binding.
    pub inverse_bind: Vec<DAffine3>,
}

/// Curves over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// Name, empty if the file gives none.
    pub name: String,
    /// The curves.
    pub channels: Vec<Channel>,
    /// Points of meshes over time, instead of morph targets.
    pub shapes: Vec<ShapeKeys>,
    /// Placements of nodes over time: operations of which the first is applied last.
    pub transforms: Vec<(usize, Vec<Operation>)>,
}

impl Animation {
    /// First and last time of any key, in seconds; zeros without keys.
    pub fn range(&self) -> (f64, f64) {
        let channels = self.channels.iter().flat_map(|channel| [channel.times.first(), channel.times.last()]);
        let mut times: Vec<f64> = channels.flatten().copied().map(f64::from).collect();
        let ends = |times: &[f64]| [times.first().copied(), times.last().copied()];
        times.extend(self.shapes.iter().flat_map(|keys| ends(&keys.times)).flatten());
        let operations = self.transforms.iter().flat_map(|(_, operations)| operations);
        times.extend(operations.flat_map(|operation| ends(&operation.times)).flatten());
        let low = times.iter().copied().reduce(f64::min).unwrap_or(0.0);
        let high = times.iter().copied().reduce(f64::max).unwrap_or(0.0);
        (low, high)
    }
}

/// The points of the mesh of a node over time. Between keys they move evenly.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeKeys {
    /// The node.
    pub node: usize,
    /// Times of the keys in seconds, increasing.
    pub times: Vec<f64>,
    /// The points at every key, as many as the mesh has.
    pub points: Vec<Vec<[f32; 3]>>,
}

/// A curve that drives one property of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The node.
    pub node: usize,
    /// The property.
    pub property: Property,
    /// How values between keys are found.
    pub interpolation: Interpolation,
    /// Times of the keys in seconds, increasing.
    pub times: Vec<f32>,
    /// Numbers of every key: 3 for translation and scale, 4 (x, y, z, w) for rotation, one per morph target for
    /// weights; for [`Interpolation::Cubic`] three times as many: in-tangent, value, out-tangent.
    pub values: Vec<f32>,
}

/// What a channel drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Property {
    /// Movement.
    Translation,
    /// Rotation.
    Rotation,
    /// Scale.
    Scale,
    /// Weights of morph targets.
    Weights,
}

/// How a channel is interpolated; before the first and behind the last key their values hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The key before.
    Step,
    /// Straight, and along the great arc for rotations.
    Linear,
    /// Cubic Hermite with the tangents of the keys.
    Cubic,
}

impl Model {
    /// A model of one mesh without a placement.
    pub fn from_mesh(mesh: Mesh) -> Self {
        let node = Node {
            name: String::new(),
            parent: None,
            local: Placement::IDENTITY,
            mesh: Some(0),
            skin: None,
            weights: None,
        };
        Self { meshes: vec![Part { mesh, ..Part::default() }], nodes: vec![node], ..Self::default() }
    }

    /// Places everything by `map` as well, after it is placed in the model's space.
    pub fn place(&mut self, map: DAffine3) {
        for node in self.nodes.iter_mut().filter(|node| node.parent.is_none()) {
            node.local = Placement::Matrix(map * node.local.matrix());
        }
    }

    /// The nodes that show a mesh, in order: the instances. Poses and the merged mesh follow this order.
    pub fn instances(&self) -> impl Iterator<Item = &Node> {
        self.nodes.iter().filter(|node| node.mesh.is_some())
    }
}
