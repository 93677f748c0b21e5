//! Surfaces that follow the elements by trilinear weights (Section 4.5, Equation 6).

use std::collections::HashMap;

use glam::Vec3;
use relievo_core::{Context, Error, Result};

use crate::hexahedron::{locate, trilinear};
use crate::model::Model;

/// Points of a piece of work.
const PART: usize = 8192;

/// A surface that follows elements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Binding {
    /// Name.
    pub name: String,
    /// Triangles of its points.
    pub triangles: Vec<[u32; 3]>,
    /// Where each point is.
    pub anchors: Vec<Anchor>,
}

/// A place in an element, or beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anchor {
    /// The element.
    pub element: u32,
    /// Coordinates along the edges from its first corner: 0 to 1 inside, beyond that outside.
    pub weights: [f32; 3],
}

impl Binding {
    /// Binds points in metres to the closest elements of a model. Fails if a point is not finite or a triangle names one
    /// that does not exist.
    pub fn new(
        context: &Context,
        model: &Model,
        name: &str,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<Self> {
        if let Some(point) = points.iter().position(|point| !point.iter().all(|at| at.is_finite())) {
            return Err(Error::invalid("a coordinate is not finite").at(format!("`{name}`, point {point}")));
        }
        let missing = |corners: &[u32; 3]| corners.iter().any(|point| *point as usize >= points.len());
        if let Some(triangle) = triangles.iter().position(missing) {
            return Err(Error::invalid("a point does not exist").at(format!("`{name}`, triangle {triangle}")));
        }
        let centres = Centres::new(model);
        let anchors = context.map(points.len(), |point| {
            let place = Vec3::from(points[point]);
            let element = centres.closest(place);
            let weights = match model.cell {
                Some(cell) => {
                    let first = Vec3::from(model.nodes[model.elements[element as usize][0] as usize]);
                    ((place - first) / Vec3::from(cell)).to_array()
                }
                None => locate(&model.corners(element as usize), place.as_dvec3()).as_vec3().to_array(),
            };
            Anchor { element, weights }
        });
        Ok(Self { name: name.to_owned(), triangles: triangles.to_vec(), anchors })
    }

    /// Returns where the points are for displacements of the nodes. Panics if they are not those of the model.
    pub fn points(&self, context: &Context, model: &Model, displacements: &[[f32; 4]]) -> Vec<[f32; 3]> {
        let mut points = vec![[0.0; 3]; self.anchors.len()];
        let done =
            context.for_each_part((self.anchors.as_slice(), points.as_mut_slice()), PART, |_, (anchors, points)| {
                for (anchor, point) in anchors.iter().zip(points) {
                    let shares = trilinear(anchor.weights);
                    let mut sum = Vec3::ZERO;
                    for (node, share) in model.elements[anchor.element as usize].iter().zip(shares) {
                        let node = *node as usize;
                        sum += share * (Vec3::from(model.nodes[node]) + Vec3::from_slice(&displacements[node]));
                    }
                    *point = sum.to_array();
                }
                Ok(())
            });
        debug_assert!(done.is_ok());
        points
    }

    pub(crate) fn check(&self, elements: usize) -> Result<()> {
        let place = |what: String| format!("surface `{}`, {what}", self.name);
        let is_sound = |anchor: &Anchor| {
            (anchor.element as usize) < elements && anchor.weights.iter().all(|weight| weight.is_finite())
        };
        if let Some(point) = self.anchors.iter().position(|anchor| !is_sound(anchor)) {
            return Err(Error::invalid("its element does not exist, or a weight is not finite")
                .at(place(format!("point {point}"))));
        }
        let missing = |corners: &[u32; 3]| corners.iter().any(|point| *point as usize >= self.anchors.len());
        match self.triangles.iter().position(missing) {
            Some(triangle) => Err(Error::invalid("a point does not exist").at(place(format!("triangle {triangle}")))),
            None => Ok(()),
        }
    }
}

/// The centres of elements in a grid of cells.
struct Centres {
    centres: Vec<Vec3>,
    cells: HashMap<[i32; 3], Vec<u32>>,
    low: Vec3,
    size: Vec3,
    /// The cells from 0 in which there are centres.
    reach: [i32; 3],
}

impl Centres {
    fn new(model: &Model) -> Self {
        let centre =
            |corners: &[u32; 8]| corners.iter().map(|node| Vec3::from(model.nodes[*node as usize])).sum::<Vec3>() / 8.0;
        let centres: Vec<Vec3> = model.elements.iter().map(centre).collect();
        let low = centres.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let high = centres.iter().copied().reduce(Vec3::max).unwrap_or_default();
        // Of unequal elements there are about two in a cell.
        let even = ((high - low).max(Vec3::splat(1e-9)).element_product() / centres.len().max(1) as f32).cbrt();
        let size = model.cell.map_or(Vec3::splat(1.25 * even), Vec3::from).max(Vec3::splat(1e-9));
        let mut cells: HashMap<[i32; 3], Vec<u32>> = HashMap::with_capacity(centres.len());
        let mut reach = [0; 3];
        for (element, centre) in (0u32..).zip(&centres) {
            let cell = cell_of(*centre, low, size);
            (0..3).for_each(|axis| reach[axis] = reach[axis].max(cell[axis]));
            cells.entry(cell).or_default().push(element);
        }
        Self { centres, cells, low, size, reach }
    }

    /// Returns the element whose centre is closest, the lowest of equals.
    fn closest(&self, place: Vec3) -> u32 {
        let home = cell_of(place, self.low, self.size);
        // Shells of cells around that of the place, from the first that has any.
        let gap = (0..3).map(|axis| (-home[axis]).max(home[axis] - self.reach[axis]).max(0)).max().unwrap_or(0);
        let farthest = (0..3).map(|axis| home[axis].max(self.reach[axis] - home[axis]).max(0)).max().unwrap_or(0);
        let mut best = (f32::INFINITY, 0u32);
        let shortest = self.size.min_element();
        for shell in gap..=farthest.max(gap) {
            if ((shell - 1).max(0) as f32 * shortest).powi(2) > best.0 {
                break;
            }
            let range = |axis: usize| (home[axis] - shell).max(0)..=(home[axis] + shell).min(self.reach[axis]);
            for x in range(0) {
                for y in range(1) {
                    let is_rim = (x - home[0]).abs() == shell || (y - home[1]).abs() == shell;
                    for z in range(2) {
                        if !is_rim && (z - home[2]).abs() != shell {
                            continue;
                        }
                        for element in self.cells.get(&[x, y, z]).into_iter().flatten() {
                            let square = self.centres[*element as usize].distance_squared(place);
                            if (square, *element) < best {
                                best = (square, *element);
                            }
                        }
                    }
                }
            }
        }
        best.1
    }
}

fn cell_of(place: Vec3, low: Vec3, size: Vec3) -> [i32; 3] {
    ((place - low) / size + 0.5).floor().to_array().map(|at| at as i32)
}
