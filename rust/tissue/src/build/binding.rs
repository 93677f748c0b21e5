//! Surfaces that follow the elements by trilinear weights (Section 4.5, Equation 6).

use glam::{Vec3, Vec4};
use relievo_core::{Context, Error, Result};

use crate::hexahedron::{locate, trilinear};
use crate::model::Model;

/// Points of a piece of work.
const CHUNK_LEN: usize = 8192;

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
    /// Binds points in metres to the closest elements of a model.
    ///
    /// # Errors
    /// Fails if a point is not finite or a triangle names a point that does not exist.
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
        // Nodes of many points are moved once.
        let moved = |node: usize| Vec3::from(model.nodes[node]).extend(0.0) + Vec4::from(displacements[node]);
        let nodes = match self.anchors.len() > model.nodes.len() {
            true => context.map(model.nodes.len(), moved),
            false => Vec::new(),
        };
        let mut points = vec![[0.0; 3]; self.anchors.len()];
        let done = context.for_each_part(
            (self.anchors.as_slice(), points.as_mut_slice()),
            CHUNK_LEN,
            |_, (anchors, points)| {
                for (anchor, point) in anchors.iter().zip(points) {
                    let shares = trilinear(anchor.weights);
                    let mut sum = Vec4::ZERO;
                    for (node, share) in model.elements[anchor.element as usize].iter().zip(shares) {
                        let node = *node as usize;
                        sum += share * nodes.get(node).copied().unwrap_or_else(|| moved(node));
                    }
                    *point = sum.truncate().to_array();
                }
                Ok(())
            },
        );
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

/// Cells of a grid for each element at most, so that models that fill little of their box need no large grid.
const CELLS: f32 = 4.0;

/// The centres of elements in a grid of cells, cell after cell with z fastest.
struct Centres {
    /// Centres and elements.
    items: Vec<(Vec3, u32)>,
    /// Where the items of each cell begin, and at the end their number.
    starts: Vec<u32>,
    low: Vec3,
    size: Vec3,
    /// Cells along each axis, less one.
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
        let mut size = model.cell.map_or(Vec3::splat(1.25 * even), Vec3::from).max(Vec3::splat(1e-9));
        let most = CELLS * centres.len().max(1) as f32 + 64.0;
        let mut reach = cell_of(high, low, size);
        while reach.iter().map(|at| *at as f32 + 1.0).product::<f32>() > most {
            size *= 1.25;
            reach = cell_of(high, low, size);
        }
        let [_, rows, columns] = reach.map(|at| at as usize + 1);
        let number = |centre: &Vec3| {
            let [x, y, z] = cell_of(*centre, low, size).map(|at| at as usize);
            (x * rows + y) * columns + z
        };
        let mut starts = vec![0u32; (reach[0] as usize + 1) * rows * columns + 1];
        centres.iter().for_each(|centre| starts[number(centre) + 1] += 1);
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let (mut next, mut items) = (starts.clone(), vec![(Vec3::ZERO, 0); centres.len()]);
        for (element, centre) in (0u32..).zip(&centres) {
            let place = &mut next[number(centre)];
            items[*place as usize] = (*centre, element);
            *place += 1;
        }
        Self { items, starts, low, size, reach }
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
                    let row = (x * (self.reach[1] + 1) + y) * (self.reach[2] + 1);
                    if (x - home[0]).abs() == shell || (y - home[1]).abs() == shell {
                        self.look(place, row, range(2), &mut best);
                        continue;
                    }
                    for z in [home[2] - shell, home[2] + shell] {
                        if (0..=self.reach[2]).contains(&z) {
                            self.look(place, row, z..=z, &mut best);
                        }
                    }
                }
            }
        }
        best.1
    }

    /// Takes the closest element of neighbouring cells of a row if it is closer.
    fn look(&self, place: Vec3, row: i32, cells: std::ops::RangeInclusive<i32>, best: &mut (f32, u32)) {
        if cells.is_empty() {
            return;
        }
        let items = self.starts[(row + cells.start()) as usize]..self.starts[(row + cells.end() + 1) as usize];
        for (centre, element) in &self.items[items.start as usize..items.end as usize] {
            let square = centre.distance_squared(place);
            if (square, *element) < *best {
                *best = (square, *element);
            }
        }
    }
}

fn cell_of(place: Vec3, low: Vec3, size: Vec3) -> [i32; 3] {
    ((place - low) / size + 0.5).floor().to_array().map(|at| at as i32)
}
