//! Nodes and skins of a glTF file (glTF 2.0, Sections 3.5 and 3.7.3).

use glam::{DAffine3, DMat3, DQuat, DVec3};
use gltf::json::accessor::Type;
use relievo_core::{Error, Result, Values};

use super::accessor::{Wanted, floats};
use super::container::Container;
use crate::budget::Budget;
use crate::model::{Node, Part, Placement, Skin};
use crate::notes::Notes;

/// Nodes, parents first, and skins.
pub(crate) struct Hierarchy {
    pub nodes: Vec<Node>,
    pub skins: Vec<Skin>,
    /// Where every node of the file is in `nodes`.
    pub place: Vec<usize>,
}

impl Hierarchy {
    /// Reads all nodes; those outside the scene show no mesh.
    pub fn read(file: &Container, budget: &mut Budget, notes: &mut Notes, meshes: &[Part]) -> Result<Self> {
        let sources = &file.json.nodes;
        let parents = parents(file)?;
        let order = parents_first(file, &parents)?;
        let mut place = vec![0; sources.len()];
        order.iter().enumerate().for_each(|(at, node)| place[*node] = at);
        let shown = shown(file, &parents, &order)?;
        let mut skins = Vec::new();
        for index in 0..file.json.skins.len() {
            skins.push(skin(file, budget, index, &place).map_err(|error| error.at(format!("skin {index}")))?);
        }
        let mut nodes = Vec::new();
        for index in &order {
            let named = |error: Error| error.at(format!("node {index}"));
            let source = &sources[*index];
            let mesh = source.mesh.map(|mesh| mesh.value()).filter(|_| shown[*index]);
            let part = mesh.map(|mesh| {
                meshes.get(mesh).ok_or_else(|| named(Error::invalid(format!("mesh {mesh} does not exist"))))
            });
            let part = part.transpose()?;
            let mut used = None;
            if let (Some(skin), Some(part)) = (source.skin, part) {
                let found = skins.get(skin.value());
                let found =
                    found.ok_or_else(|| named(Error::invalid(format!("skin {} does not exist", skin.value()))))?;
                used = check_skin(part, found).map_err(named)?.then_some(skin.value());
                if used.is_none() {
                    notes.add("a skin is left out because its mesh has no joints", 0);
                }
            }
            let mut weights = source.weights.clone().filter(|_| part.is_some());
            if let (Some(weights), Some(part)) = (&mut weights, part) {
                if weights.iter().any(|weight| !weight.is_finite()) {
                    return Err(named(
                        Error::invalid("a morph weight is not finite").advise("give every weight an ordinary number"),
                    ));
                }
                weights.resize(part.targets.len(), 0.0);
            }
            nodes.push(Node {
                name: source.name.clone().unwrap_or_default(),
                parent: parents[*index].map(|parent| place[parent]),
                local: placement(source).map_err(named)?,
                mesh,
                skin: used,
                weights,
            });
        }
        Ok(Self { nodes, skins, place })
    }
}

/// The parent of every node. Fails where a node has two.
fn parents(file: &Container) -> Result<Vec<Option<usize>>> {
    let nodes = &file.json.nodes;
    let mut parents = vec![None; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(|child| child.value()) {
            let place = |what: String| Error::invalid(what).at(format!("node {index}"));
            match parents.get_mut(child) {
                None => return Err(place(format!("its child {child} does not exist"))),
                Some(Some(other)) => {
                    return Err(place(format!("its child {child} is also a child of node {other}"))
                        .advise("every node has one parent; export the file again"));
                }
                Some(parent) => *parent = Some(index),
            }
        }
    }
    Ok(parents)
}

/// The nodes so that parents come before their children. Fails where nodes form a circle.
fn parents_first(file: &Container, parents: &[Option<usize>]) -> Result<Vec<usize>> {
    let mut order: Vec<usize> = (0..parents.len()).filter(|node| parents[*node].is_none()).collect();
    let mut at = 0;
    while let Some(node) = order.get(at) {
        let children = file.json.nodes[*node].children.iter().flatten().map(|child| child.value());
        order.extend(children);
        at += 1;
    }
    if order.len() < parents.len() {
        let mut reached = vec![false; parents.len()];
        order.iter().for_each(|node| reached[*node] = true);
        let lost = reached.iter().position(|reached| !reached).unwrap_or_default();
        return Err(Error::invalid("it is its own ancestor")
            .at(format!("node {lost}"))
            .advise("nodes form a tree; export the file again"));
    }
    Ok(order)
}

/// Which nodes the scene shows: the default one, else the first, else everything.
fn shown(file: &Container, parents: &[Option<usize>], order: &[usize]) -> Result<Vec<bool>> {
    let scenes = &file.json.scenes;
    let scene = match file.json.scene {
        Some(scene) => Some(scenes.get(scene.value()).ok_or_else(|| {
            Error::invalid(format!("scene {} does not exist", scene.value())).advise("export the file again")
        })?),
        None => scenes.first(),
    };
    let Some(scene) = scene else { return Ok(vec![true; parents.len()]) };
    let mut shown = vec![false; parents.len()];
    for root in scene.nodes.iter().map(|node| node.value()) {
        *shown.get_mut(root).ok_or_else(|| Error::invalid(format!("node {root} of the scene does not exist")))? = true;
    }
    for node in order {
        if parents[*node].is_some_and(|parent| shown[parent]) {
            shown[*node] = true;
        }
    }
    Ok(shown)
}

fn placement(source: &gltf::json::Node) -> Result<Placement> {
    if let Some(matrix) = source.matrix {
        return Ok(Placement::Matrix(affine(&matrix)?));
    }
    let translation = DVec3::from(source.translation.unwrap_or_default().map(f64::from));
    let scale = DVec3::from(source.scale.unwrap_or([1.0; 3]).map(f64::from));
    let rotation = source.rotation.map_or([0.0, 0.0, 0.0, 1.0], |rotation| rotation.0);
    let rotation = DQuat::from_array(rotation.map(f64::from));
    if !(translation.is_finite() && scale.is_finite() && rotation.is_finite()) {
        return Err(Error::invalid("its placement is not finite"));
    }
    if rotation.length_squared() < 1e-12 {
        return Err(Error::invalid("its rotation is no unit quaternion").advise("use 0, 0, 0, 1 for none"));
    }
    Ok(Placement::Parts { translation, rotation: rotation.normalize(), scale })
}

/// The affine map of a matrix in column order.
fn affine(matrix: &[f32; 16]) -> Result<DAffine3> {
    let m = matrix.map(f64::from);
    let column = |at: usize| DVec3::new(m[at], m[at + 1], m[at + 2]);
    let last = [m[3], m[7], m[11], m[15] - 1.0];
    if m.iter().any(|value| !value.is_finite()) || last.iter().any(|value| value.abs() > 1e-4) {
        return Err(Error::invalid("its matrix is not affine").advise("the last row must be 0, 0, 0, 1"));
    }
    Ok(DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(4), column(8)), column(12)))
}

fn skin(file: &Container, budget: &mut Budget, index: usize, place: &[usize]) -> Result<Skin> {
    let source = &file.json.skins[index];
    let joint = |joint: usize| {
        place.get(joint).copied().ok_or_else(|| Error::invalid(format!("its joint, node {joint}, does not exist")))
    };
    let joints = source.joints.iter().map(|index| joint(index.value())).collect::<Result<Vec<_>>>()?;
    if joints.is_empty() {
        return Err(Error::invalid("it has no joints"));
    }
    let inverse_bind = match source.inverse_bind_matrices {
        None => vec![DAffine3::IDENTITY; joints.len()],
        Some(index) => {
            let wanted = Wanted { shapes: &[Type::Mat4], count: None };
            let (values, _) = floats(file, budget, index.value(), &wanted)?;
            let matrices = values.as_chunks::<16>().0;
            if matrices.len() < joints.len() {
                return Err(Error::invalid(format!("{} matrices for {} joints", matrices.len(), joints.len())));
            }
            matrices[..joints.len()].iter().map(affine).collect::<Result<Vec<_>>>()?
        }
    };
    Ok(Skin { name: source.name.clone().unwrap_or_default(), joints, inverse_bind })
}

/// Whether the mesh has joints for the skin. Fails if it refers to more than there are.
fn check_skin(part: &Part, skin: &Skin) -> Result<bool> {
    let joints = part.mesh.attribute("joints").map(|attribute| &attribute.values);
    let (Some(Values::U32(joints)), Some(_)) = (joints, part.mesh.attribute("weights")) else { return Ok(false) };
    match joints.iter().position(|joint| *joint as usize >= skin.joints.len()) {
        Some(at) => Err(Error::invalid(format!("joint {} does not exist", joints[at]))
            .at(format!("point {}", at / 4))
            .advise(format!("its skin has {} joints counted from 0", skin.joints.len()))),
        None => Ok(true),
    }
}
