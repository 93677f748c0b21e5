//! Models from surfaces (Section 4): voxels, layers, muscles, restraints and bound surfaces.

pub(crate) mod bend;
pub(crate) mod binding;
pub(crate) mod labels;
pub(crate) mod nurbs;
pub(crate) mod volume;
mod voxel;

use glam::Vec3;
use relievo_core::{Context, Error, Progress, Result};

use crate::build::bend::divided;
use crate::build::binding::Binding;
use crate::build::volume::{Depth, Description, Restraint, Skin, middle};
use crate::build::voxel::{Grid, Voxel, sample};
use crate::distance::DistanceField;
use crate::hexahedron::FACES;
use crate::model::{Fibre, Held, Model, NodeSet, Portion, Sliding};

/// No element or node.
const NONE: u32 = u32::MAX;

/// What a model was made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BuildReport {
    /// Voxels of the grid along each axis.
    pub voxels: [u32; 3],
    /// Volume in m³ by the shares of all voxels.
    pub volume: f64,
}

impl Description {
    /// Makes the model. Nodes of each restraint get a set of its name, and those on the border of the grid the sets `x-`,
    /// `x+`, `y-`, `y+`, `z-` and `z+`.
    ///
    /// # Errors
    /// The description cannot be used, a surface is not closed, no voxel is an element, a place cannot be bent, or memory does
    /// not suffice.
    pub fn build(&self, context: &Context, progress: &mut dyn Progress) -> Result<(Model, BuildReport)> {
        self.check()?;
        let grid = Grid::new(self, context.memory_limit())?;
        let depth = self.skin.as_ref().map(Depth::new).transpose()?;
        let stats = context.stats();
        let stage = stats.begin("tissue.voxels");
        let voxels = sample(context, self, &grid, depth.as_ref(), progress)?;
        stage.end();
        let cell_volume = f64::from(grid.cell.x) * f64::from(grid.cell.y) * f64::from(grid.cell.z);
        let report = BuildReport {
            voxels: grid.counts.map(|count| count as u32),
            volume: cell_volume * voxels.iter().map(|voxel| f64::from(voxel.share)).sum::<f64>(),
        };
        progress.step(0.8, "elements")?;
        let mut base = Model { cell: Some(self.cell), materials: self.materials.clone(), ..Model::default() };
        let muscles: Vec<Option<u32>> = self
            .volumes
            .iter()
            .map(|volume| {
                let (muscle, _) = volume.muscle.as_ref()?;
                base.muscles.push(muscle.clone());
                Some(base.muscles.len() as u32 - 1)
            })
            .collect();
        let (mut model, at) = elements(base, &grid, &voxels, self.share, &muscles)?;
        if let (Some(skin), Some(depth)) = (&self.skin, &depth) {
            add_epidermis(context, &mut model, skin, depth, (&grid, &at))?;
        }
        progress.step(0.85, "restraints")?;
        for restraint in &self.restraints {
            restrain(context, &mut model, restraint)
                .map_err(|error| error.at(format!("surface `{}`", restraint.shape.name)))?;
        }
        progress.step(0.9, "bound surfaces")?;
        for shape in &self.bound {
            let fine = self.bend.map(|_| divided(shape, self.longest())).transpose()?;
            let shape = fine.as_ref().unwrap_or(shape);
            let binding = Binding::new(context, &model, &shape.name, &shape.points, &shape.triangles)?;
            model.bindings.push(binding);
        }
        if let Some(bend) = &self.bend {
            for surface in &mut model.surfaces {
                *surface = divided(surface, self.longest())?;
            }
            model.bend(bend)?;
        }
        model.check()?;
        Ok((model, report))
    }

    /// Returns the length of the longest edge of a surface that is bent, in metres: a voxel and a half.
    fn longest(&self) -> f32 {
        1.5 * self.cell.into_iter().fold(0.0, f32::max)
    }
}

/// Makes elements of the voxels of which more than `share` is inside, and the sets of the grid's borders. `base` has the
/// materials and muscles, and `muscles` the muscle of each volume. Returns the element of each voxel beside the model.
pub(crate) fn elements(
    base: Model,
    grid: &Grid,
    voxels: &[Voxel],
    share: f32,
    muscles: &[Option<u32>],
) -> Result<(Model, Vec<u32>)> {
    let mut model = base;
    let corners = grid.counts.map(|count| count + 1);
    let mut nodes = numbers(corners)?;
    let mut at = numbers(grid.counts)?;
    for voxel in voxels.iter().filter(|voxel| voxel.share > share) {
        let place = voxel.at.map(|index| index as usize);
        at[Grid::index(place, grid.counts)] = model.elements.len() as u32;
        let element = crate::hexahedron::SIGNS.map(|signs| {
            let corner: [usize; 3] = std::array::from_fn(|axis| place[axis] + usize::from(signs[axis] > 0.0));
            let node = &mut nodes[Grid::index(corner, corners)];
            if *node == NONE {
                *node = model.nodes.len() as u32;
                let position = grid.low + Vec3::from(corner.map(|index| index as f32)) * grid.cell;
                model.nodes.push(position.to_array());
            }
            *node
        });
        model.elements.push(element);
        let portions = voxel.materials.iter();
        model.mixtures.push(portions.map(|(material, share)| Portion { material: *material, share: *share }));
        let fibres = voxel.muscles.iter().filter_map(|(volume, share, direction)| {
            let muscle = (*muscles.get(*volume as usize)?)?;
            Some(Fibre { muscle, share: *share, direction: direction.to_array() })
        });
        model.fibres.push(fibres);
    }
    if model.elements.is_empty() {
        return Err(Error::invalid("no voxel has enough samples inside")
            .at("share")
            .advise("take smaller voxels, or a smaller share above which a voxel is an element"));
    }
    add_borders(&mut model, grid);
    Ok((model, at))
}

/// Returns a list with `NONE` for each place of a grid. Fails if there is no memory for it.
fn numbers(counts: [usize; 3]) -> Result<Vec<u32>> {
    let count = counts.iter().product();
    let mut list = Vec::new();
    list.try_reserve_exact(count).map_err(|_| {
        Error::memory(format!("a grid of {count} voxels does not fit into memory"))
            .at("voxel")
            .advise("take larger voxels")
    })?;
    list.resize(count, NONE);
    Ok(list)
}

/// Gives the elements at the skin a share of the epidermis (Section 4.2, Figure 6): elements that the skin crosses, and
/// elements beside a voxel that it crosses and that is no element.
fn add_epidermis(
    context: &Context,
    model: &mut Model,
    skin: &Skin,
    depth: &Depth,
    (grid, at): (&Grid, &[u32]),
) -> Result<()> {
    let Some((material, thickness)) = skin.epidermis else { return Ok(()) };
    let share = (3.0 * thickness / grid.cell.element_sum()).min(1.0);
    let unchanged = &*model;
    let is_skin = context.map(model.elements.len(), |element| {
        let middle = middle(unchanged, element);
        if depth.crosses(middle, grid.cell) {
            return true;
        }
        let place = ((middle - grid.low) / grid.cell).floor();
        (0..6).any(|side| {
            let step = Vec3::AXES[side / 2] * if side % 2 == 0 { -1.0 } else { 1.0 };
            let beside = place + step;
            let is_within =
                beside.cmpge(Vec3::ZERO).all() && (0..3).all(|axis| (beside[axis] as usize) < grid.counts[axis]);
            let is_element =
                is_within && at[Grid::index(beside.to_array().map(|index| index as usize), grid.counts)] != NONE;
            !is_element && depth.crosses(middle + step * grid.cell, grid.cell)
        })
    });
    let mut mixtures = crate::model::Lists::default();
    for (element, is_skin) in is_skin.into_iter().enumerate() {
        let portions = model.mixtures.get(element);
        if is_skin {
            let others = portions.iter().map(|portion| Portion { share: portion.share * (1.0 - share), ..*portion });
            mixtures.push(others.chain([Portion { material, share }]));
        } else {
            mixtures.push(portions.iter().copied());
        }
    }
    model.mixtures = mixtures;
    Ok(())
}

/// Names the nodes on the six sides of the grid.
fn add_borders(model: &mut Model, grid: &Grid) {
    let high = grid.low + grid.cell * Vec3::from(grid.counts.map(|count| count as f32));
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for (side, border) in [("-", grid.low[axis]), ("+", high[axis])] {
            let is_there = |node: &[f32; 3]| (node[axis] - border).abs() < 1e-3 * grid.cell[axis];
            let nodes: Vec<u32> =
                (0u32..).zip(&model.nodes).filter(|(_, node)| is_there(node)).map(|(number, _)| number).collect();
            if !nodes.is_empty() {
                model.sets.push(NodeSet { name: format!("{name}{side}"), nodes });
            }
        }
    }
}

impl Model {
    /// Returns the faces that belong to one element alone: the element, and the nodes counter-clockwise seen from outside.
    pub fn outer_faces(&self) -> Vec<(u32, [u32; 4])> {
        let mut faces: Vec<([u32; 4], u32, u8)> = Vec::with_capacity(6 * self.elements.len());
        for (element, corners) in (0u32..).zip(&self.elements) {
            for (face, places) in (0u8..).zip(FACES) {
                let mut key = places.map(|place| corners[place]);
                key.sort_unstable();
                faces.push((key, element, face));
            }
        }
        faces.sort_unstable();
        let alone = faces.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| (same[0].1, same[0].2));
        let mut alone: Vec<(u32, u8)> = alone.collect();
        alone.sort_unstable();
        let nodes = |(element, face): (u32, u8)| {
            (element, FACES[face as usize].map(|place| self.elements[element as usize][place]))
        };
        alone.into_iter().map(nodes).collect()
    }

    /// Returns the outer faces of which all nodes are among some, counter-clockwise seen from outside.
    pub fn outer_faces_of(&self, nodes: &[u32]) -> Vec<[u32; 4]> {
        let mut is_among = vec![false; self.nodes.len()];
        for node in nodes {
            if let Some(place) = is_among.get_mut(*node as usize) {
                *place = true;
            }
        }
        let faces = self.outer_faces().into_iter().map(|(_, face)| face);
        faces.filter(|face| face.iter().all(|node| is_among[*node as usize])).collect()
    }
}

/// Holds the nodes near a surface (Section 4.4, Figure 8).
fn restrain(context: &Context, model: &mut Model, restraint: &Restraint) -> Result<()> {
    let field = DistanceField::new(&restraint.shape.points, &restraint.shape.triangles)?;
    let cell = model.cell.map_or(Vec3::ONE, Vec3::from);
    let nodes = if restraint.is_internal {
        internal(context, model, &field, cell)
    } else {
        external(context, model, &field, cell, restraint.angle)
    };
    if nodes.is_empty() {
        return Err(
            Error::invalid("no node is near it").advise("place it within a voxel of the model, normals outwards")
        );
    }
    if restraint.is_sliding {
        let surface = model.surfaces.len() as u32;
        model.surfaces.push(restraint.shape.clone());
        let place = |node: u32| Vec3::from(model.nodes[node as usize]);
        let sliding = nodes.iter().map(|node| Sliding {
            node: *node,
            surface,
            distance: field.closest(place(*node), None).distance,
        });
        let sliding: Vec<Sliding> = sliding.collect();
        model.sliding.extend(sliding);
    } else {
        model.held.extend(nodes.iter().map(|node| Held { node: *node, axes: 7 }));
    }
    model.sets.push(NodeSet { name: restraint.shape.name.clone(), nodes });
    Ok(())
}

/// Nodes in front of a surface, of elements that it crosses.
fn internal(context: &Context, model: &Model, field: &DistanceField, cell: Vec3) -> Vec<u32> {
    let crossed = context.map(model.elements.len(), |element| {
        let middle = middle(model, element);
        let off = field.closest(middle, None).point - middle;
        off.abs().cmple(0.5001 * cell).all()
    });
    let mut nodes: Vec<u32> =
        model.elements.iter().zip(crossed).filter(|(_, crossed)| *crossed).flat_map(|(nodes, _)| *nodes).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.retain(|node| field.closest(Vec3::from(model.nodes[*node as usize]), None).distance >= 0.0);
    nodes
}

/// Outer nodes whose box of two voxels a surface crosses that points the same way.
fn external(context: &Context, model: &Model, field: &DistanceField, cell: Vec3, angle: f32) -> Vec<u32> {
    let mut normals = vec![Vec3::ZERO; model.nodes.len()];
    for (_, face) in model.outer_faces() {
        let [a, b, c, d] = face.map(|node| Vec3::from(model.nodes[node as usize]));
        let normal = (c - a).cross(d - b).normalize_or_zero();
        face.iter().for_each(|node| normals[*node as usize] += normal);
    }
    let outer: Vec<u32> = (0u32..).zip(&normals).filter(|(_, normal)| **normal != Vec3::ZERO).map(|it| it.0).collect();
    let is_near = context.map(outer.len(), |at| {
        let node = outer[at] as usize;
        let closest = field.closest(Vec3::from(model.nodes[node]), None);
        let off = closest.point - Vec3::from(model.nodes[node]);
        off.abs().cmple(cell).all() && closest.normal.angle_between(normals[node]) < angle
    });
    outer.into_iter().zip(is_near).filter(|(_, near)| *near).map(|(node, _)| node).collect()
}
