//! A finite-element model: nodes, hexahedra, what they consist of, and how they are held.

use std::ops::Range;

use glam::{DVec3, Vec3};
use relievo_core::{Error, Result};

use crate::build::binding::Binding;
use crate::hexahedron::{Hexahedron, SIGNS};
use crate::material::{Material, Muscle};

/// A finite-element model of hexahedra, in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Positions of the nodes at rest.
    pub nodes: Vec<[f32; 3]>,
    /// Corners of the elements, in VTK's order.
    pub elements: Vec<[u32; 8]>,
    /// The size of all elements if they are equal boxes along the axes.
    pub cell: Option<[f32; 3]>,
    /// Materials.
    pub materials: Vec<Material>,
    /// The materials of each element with their shares, which add up to 1.
    pub mixtures: Lists<Portion>,
    /// Muscles and other families of fibres.
    pub muscles: Vec<Muscle>,
    /// The fibres of each element.
    pub fibres: Lists<Fibre>,
    /// Nodes that do not move along some axes.
    pub held: Vec<Held>,
    /// Surfaces on which nodes slide.
    pub surfaces: Vec<Shape>,
    /// Nodes that slide.
    pub sliding: Vec<Sliding>,
    /// Groups of nodes that have a name.
    pub sets: Vec<NodeSet>,
    /// Surfaces that follow the elements.
    pub bindings: Vec<Binding>,
}

/// One list for each element, stored one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Lists<T> {
    /// Where each list starts, and at the end the number of items.
    pub starts: Vec<u32>,
    /// The items.
    pub items: Vec<T>,
}

/// A share of a material in an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Portion {
    /// Index of the material.
    pub material: u32,
    /// Share, 0 to 1.
    pub share: f32,
}

/// The fibres of a muscle in an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fibre {
    /// Index of the muscle.
    pub muscle: u32,
    /// Share of the element that the muscle fills, 0 to 1.
    pub share: f32,
    /// Unit direction at rest.
    pub direction: [f32; 3],
}

/// A node that does not move along some axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held {
    /// The node.
    pub node: u32,
    /// The axes, x in bit 0; 7 holds the node altogether.
    pub axes: u32,
}

/// A triangle mesh that nodes slide on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Name.
    pub name: String,
    /// Points in metres.
    pub points: Vec<[f32; 3]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
}

/// A node that stays at a signed distance from a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliding {
    /// The node.
    pub node: u32,
    /// Index of the surface.
    pub surface: u32,
    /// Signed distance in metres, positive on the side of the normals.
    pub distance: f32,
}

/// Nodes that have a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeSet {
    /// Name.
    pub name: String,
    /// The nodes.
    pub nodes: Vec<u32>,
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Self { starts: vec![0], items: Vec::new() }
    }
}

impl<T> Lists<T> {
    /// Appends a list.
    pub fn push(&mut self, items: impl IntoIterator<Item = T>) {
        self.items.extend(items);
        self.starts.push(self.items.len() as u32);
    }

    /// Returns the number of lists.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Returns whether there is no list.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns list `index`. Panics if it does not exist.
    pub fn get(&self, index: usize) -> &[T] {
        let range: Range<usize> = self.starts[index] as usize..self.starts[index + 1] as usize;
        &self.items[range]
    }

    fn check(&self, elements: usize, what: &str) -> Result<()> {
        let is_sound = self.starts.first() == Some(&0)
            && self.starts.last().map(|last| *last as usize) == Some(self.items.len())
            && self.starts.is_sorted();
        if is_sound && self.len() == elements {
            return Ok(());
        }
        Err(Error::invalid(format!("{} lists of {what} do not fit {elements} elements", self.len()))
            .advise("give one list for each element"))
    }
}

impl Model {
    /// Makes a block of equal boxes of one material, from its lowest corner and the size of an element in metres.
    ///
    /// # Errors
    /// Fails if a count is 0, a size is not positive, the material is not usable, or there are 2³² nodes or more or too
    /// many for the memory.
    pub fn block(low: [f32; 3], cell: [f32; 3], counts: [u32; 3], material: Material) -> Result<Self> {
        let [x, y, z] = counts.map(|count| count as usize);
        let nodes = counts.iter().map(|count| f64::from(*count) + 1.0).product::<f64>();
        if counts.contains(&0) || nodes > f64::from(u32::MAX) {
            return Err(Error::invalid(format!("a block of {x} × {y} × {z} elements cannot be"))
                .advise("use 1 or more along each axis, and fewer than 4e9 in all"));
        }
        let mut model = Self { cell: Some(cell), materials: vec![material], ..Self::default() };
        let room = model.nodes.try_reserve_exact(nodes as usize).and(model.elements.try_reserve_exact(x * y * z));
        room.map_err(|_| Error::memory(format!("a block of {x} × {y} × {z} elements does not fit into memory")))?;
        let node = |i: usize, j: usize, k: usize| ((k * (y + 1) + j) * (x + 1) + i) as u32;
        for k in 0..=z {
            for j in 0..=y {
                let at = |i: usize| [i, j, k].map(|index| index as f32);
                model.nodes.extend((0..=x).map(|i| std::array::from_fn(|axis| low[axis] + at(i)[axis] * cell[axis])));
            }
        }
        for k in 0..z {
            for j in 0..y {
                for i in 0..x {
                    let face = |k: usize| [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)];
                    let ([a, b, c, d], [e, f, g, h]) = (face(k), face(k + 1));
                    model.elements.push([a, b, c, d, e, f, g, h]);
                    model.mixtures.push([Portion { material: 0, share: 1.0 }]);
                    model.fibres.push([]);
                }
            }
        }
        model.check()?;
        Ok(model)
    }

    /// Returns the set of nodes called `name`.
    ///
    /// # Errors
    /// Fails if there is no set of that name.
    pub fn set(&self, name: &str) -> Result<&NodeSet> {
        self.sets.iter().find(|set| set.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.sets.iter().map(|set| set.name.as_str()).collect();
            Error::invalid(format!("the model has no set of nodes `{name}`")).advise(match names.is_empty() {
                true => "the model has no sets".to_owned(),
                false => format!("use one of {}", names.join(", ")),
            })
        })
    }

    /// Returns the index of the muscle called `name`.
    ///
    /// # Errors
    /// Fails if there is no muscle of that name.
    pub fn muscle(&self, name: &str) -> Result<usize> {
        self.muscles.iter().position(|muscle| muscle.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.muscles.iter().map(|muscle| muscle.name.as_str()).collect();
            Error::invalid(format!("the model has no muscle `{name}`")).advise(match names.is_empty() {
                true => "the model has no muscles".to_owned(),
                false => format!("use one of {}", names.join(", ")),
            })
        })
    }

    /// Returns the nodes within a box, borders included.
    pub fn nodes_within(&self, low: [f32; 3], high: [f32; 3]) -> Vec<u32> {
        let is_within = |node: &[f32; 3]| (0..3).all(|axis| node[axis] >= low[axis] && node[axis] <= high[axis]);
        (0u32..).zip(&self.nodes).filter(|(_, node)| is_within(node)).map(|(number, _)| number).collect()
    }

    /// Returns the corners of an element at rest. Panics if it does not exist.
    pub(crate) fn corners(&self, element: usize) -> [DVec3; 8] {
        self.elements[element].map(|node| Vec3::from(self.nodes[node as usize]).as_dvec3())
    }

    /// Returns the shape of an element. Fails if it is inside out.
    pub(crate) fn hexahedron(&self, element: usize) -> Result<Hexahedron> {
        Hexahedron::new(&self.corners(element)).map_err(|error| error.at(format!("element {element}")))
    }

    /// Returns whether an element is a box of a size along the axes, but for rounding.
    fn is_box(&self, element: usize, cell: [f32; 3]) -> bool {
        let corners = self.elements[element].map(|node| self.nodes[node as usize]);
        corners.iter().zip(SIGNS).all(|(corner, signs)| {
            (0..3).all(|axis| {
                let expected = corners[0][axis] + if signs[axis] > 0.0 { cell[axis] } else { 0.0 };
                (corner[axis] - expected).abs() <= 1e-3 * cell[axis] + 1e-6 * expected.abs()
            })
        })
    }

    /// Returns the material of each element that has the largest share.
    pub fn main_materials(&self) -> Vec<u32> {
        let main = |element: usize| {
            let portions = self.mixtures.get(element).iter();
            portions.max_by(|a, b| a.share.total_cmp(&b.share)).map_or(0, |portion| portion.material)
        };
        (0..self.elements.len()).map(main).collect()
    }

    /// Returns the shear modulus, the bulk modulus and the density of an element.
    pub(crate) fn moduli(&self, element: usize) -> [f32; 3] {
        let mut sums = [0.0; 3];
        for portion in self.mixtures.get(element) {
            let material = &self.materials[portion.material as usize];
            sums[0] += portion.share * material.shear;
            sums[1] += portion.share * material.bulk;
            sums[2] += portion.share * material.density;
        }
        sums
    }

    /// Checks that the model can be simulated.
    ///
    /// # Errors
    /// Fails unless every index exists, every number is finite and in its range, every element has materials whose
    /// shares add up to 1, and every fibre a muscle, a share and a direction of length 1; with `cell`, unless every
    /// element is a box of that size.
    pub fn check(&self) -> Result<()> {
        let (nodes, elements) = (self.nodes.len(), self.elements.len());
        if nodes == 0 || elements == 0 {
            return Err(Error::invalid("the model has no elements")
                .advise("take smaller voxels, or a smaller share of overlap that makes a voxel an element"));
        }
        if let Some(node) = self.nodes.iter().position(|node| !node.iter().all(|at| at.is_finite())) {
            return Err(Error::invalid("a coordinate is not finite").at(format!("node {node}")));
        }
        let missing = |corners: &[u32; 8]| corners.iter().any(|node| *node as usize >= nodes);
        if let Some(element) = self.elements.iter().position(missing) {
            return Err(Error::invalid("a node does not exist").at(format!("element {element}")));
        }
        if let Some(cell) = self.cell
            && !cell.iter().all(|size| *size > 0.0 && size.is_finite())
        {
            return Err(Error::invalid(format!("elements of {cell:?} m cannot be")));
        }
        if let Some(cell) = self.cell
            && let Some(element) = (0..elements).find(|element| !self.is_box(*element, cell))
        {
            return Err(Error::invalid(format!("the element is not a box of {cell:?} m"))
                .at(format!("element {element}"))
                .advise("number its corners as VTK does, or leave out the size of the elements"));
        }
        self.materials.iter().try_for_each(Material::check)?;
        self.muscles.iter().try_for_each(Muscle::check)?;
        self.mixtures.check(elements, "materials")?;
        self.fibres.check(elements, "fibres")?;
        for element in 0..elements {
            let portions = self.mixtures.get(element);
            let is_known = |portion: &Portion| (portion.material as usize) < self.materials.len();
            let sum: f32 = portions.iter().map(|portion| portion.share).sum();
            let is_share = |portion: &Portion| (0.0..=1.001).contains(&portion.share);
            if !portions.iter().all(|portion| is_known(portion) && is_share(portion)) || (sum - 1.0).abs() > 1e-3 {
                return Err(Error::invalid(format!("the shares of its materials add up to {sum}"))
                    .at(format!("element {element}"))
                    .advise("use materials of the model with shares that add up to 1"));
            }
            let is_sound = |fibre: &Fibre| {
                (fibre.muscle as usize) < self.muscles.len()
                    && (0.0..=1.001).contains(&fibre.share)
                    && (Vec3::from(fibre.direction).length() - 1.0).abs() < 1e-3
            };
            if !self.fibres.get(element).iter().all(is_sound) {
                return Err(Error::invalid("a fibre has no muscle, no share or no unit direction")
                    .at(format!("element {element}")));
            }
        }
        let count = nodes as u32;
        let held = self.held.iter().map(|held| held.node);
        let sets = self.sets.iter().flat_map(|set| set.nodes.iter().copied());
        let named = held.chain(self.sliding.iter().map(|sliding| sliding.node)).chain(sets);
        if let Some(node) = named.into_iter().find(|node| *node >= count) {
            return Err(
                Error::invalid(format!("node {node} does not exist")).at("nodes that are held, slide or have a name")
            );
        }
        if let Some(held) = self.held.iter().find(|held| held.axes > 7) {
            return Err(Error::invalid(format!("axes {} of node {} cannot be held", held.axes, held.node)));
        }
        for sliding in &self.sliding {
            if sliding.surface as usize >= self.surfaces.len() || !sliding.distance.is_finite() {
                return Err(Error::invalid("its surface does not exist").at(format!("sliding node {}", sliding.node)));
            }
        }
        self.bindings.iter().try_for_each(|binding| binding.check(elements))
    }
}
