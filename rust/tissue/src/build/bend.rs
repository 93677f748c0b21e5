//! Bending of a model that was made as a flat block, so that layers of elements follow a curved skin.
//!
//! Voxels approximate a curved skin by stairs, and its stiff outer layer then folds along their edges. A block whose skin is
//! the plane y = 0 has no stairs. Bent about two axes, its layers keep their depth, since normals of the skin stay straight.

use glam::{DMat3, DVec3, Vec3};
use relievo_core::{Error, Result};

use crate::distance::DistanceField;
use crate::model::{Model, Shape};

/// Triangles of a bent surface at most.
const MAX: usize = 1 << 22;

/// How a block is bent. Its outer side is the plane y = 0 and looks along −y; depths are y, and z is up.
///
/// The plane becomes a patch of a torus through the origin: lines along x become arcs about a vertical axis, lines along z
/// arcs about horizontal axes. Depths are exact, and so are lengths on the two axes of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Radii in metres of the arcs along x and along z; positive.
    pub radii: [f64; 2],
}

impl Bend {
    /// Checks the radii, and that points in metres can be bent.
    ///
    /// # Errors
    /// Fails unless radii are positive, and the points lie within half a turn across, a quarter of a turn up or down,
    /// and in front of the centres of the arcs.
    pub fn check(&self, points: &[[f32; 3]]) -> Result<()> {
        let [across, up] = self.radii;
        let refuse = |what: String, advice: &str| Err(Error::invalid(what).at("bend").advise(advice));
        if !self.radii.iter().all(|radius| *radius > 0.0 && radius.is_finite()) {
            return refuse(format!("radii of {across} m and {up} m cannot be"), "use positive radii in metres");
        }
        let (turn, quarter) = (std::f64::consts::PI, 0.5 * std::f64::consts::PI);
        let is_within = |[x, y, z]: [f64; 3]| {
            let reach = across - up + (up - y) * (z / up).cos();
            (x / across).abs() < turn && y < up && (z / up).abs() < quarter && reach > 0.0
        };
        match points.iter().find(|point| !is_within(point.map(f64::from))) {
            None => Ok(()),
            Some(point) => refuse(
                format!("{point:?} m is too far from the skin for radii of {across} m and {up} m"),
                "take larger radii, or a smaller block whose outer side is the plane y = 0",
            ),
        }
    }

    /// Returns where a place of the block goes, in metres.
    pub fn place(&self, place: DVec3) -> DVec3 {
        let [across, up] = self.radii;
        let ((sin_a, cos_a), (sin_b, cos_b)) = ((place.x / across).sin_cos(), (place.z / up).sin_cos());
        let radius = up - place.y;
        let reach = across - up + radius * cos_b;
        DVec3::new(reach * sin_a, across - reach * cos_a, radius * sin_b)
    }

    /// Returns the derivatives of [`Bend::place`], by columns.
    pub fn derivatives(&self, place: DVec3) -> DMat3 {
        let [across, up] = self.radii;
        let ((sin_a, cos_a), (sin_b, cos_b)) = ((place.x / across).sin_cos(), (place.z / up).sin_cos());
        let radius = up - place.y;
        let reach = (across - up + radius * cos_b) / across;
        let turn = radius / up;
        DMat3::from_cols(
            DVec3::new(reach * cos_a, reach * sin_a, 0.0),
            DVec3::new(-cos_b * sin_a, cos_b * cos_a, -sin_b),
            DVec3::new(-turn * sin_b * sin_a, turn * sin_b * cos_a, turn * cos_b),
        )
    }

    fn point(&self, point: [f32; 3]) -> [f32; 3] {
        self.place(Vec3::from(point).as_dvec3()).as_vec3().to_array()
    }
}

impl Model {
    /// Bends a model: nodes, fibres, surfaces on which nodes slide, and with their elements the bound surfaces. Elements are
    /// then no longer equal boxes. Fails if a place is out of range of the bend.
    pub(crate) fn bend(&mut self, bend: &Bend) -> Result<()> {
        bend.check(&self.nodes)?;
        self.surfaces.iter().try_for_each(|surface| bend.check(&surface.points))?;
        for element in 0..self.elements.len() {
            let middle = self.corners(element).iter().sum::<DVec3>() / 8.0;
            let derivatives = bend.derivatives(middle);
            let range = self.fibres.starts[element] as usize..self.fibres.starts[element + 1] as usize;
            for fibre in &mut self.fibres.items[range] {
                let direction = derivatives * Vec3::from(fibre.direction).as_dvec3();
                fibre.direction = direction.as_vec3().normalize_or(Vec3::from(fibre.direction)).to_array();
            }
        }
        self.nodes.iter_mut().for_each(|node| *node = bend.point(*node));
        for surface in &mut self.surfaces {
            surface.points.iter_mut().for_each(|point| *point = bend.point(*point));
        }
        let fields = self.surfaces.iter().map(|surface| DistanceField::new(&surface.points, &surface.triangles));
        let fields = fields.collect::<Result<Vec<_>>>()?;
        for sliding in &mut self.sliding {
            let place = Vec3::from(self.nodes[sliding.node as usize]);
            sliding.distance = fields[sliding.surface as usize].closest(place, None).distance;
        }
        self.cell = None;
        Ok(())
    }
}

/// Returns a surface of which no edge is longer than `longest` metres, by halving edges of the triangles that are. Triangles
/// that share an edge halve it in the same place. Fails if there would be too many.
pub(crate) fn divided(shape: &Shape, longest: f32) -> Result<Shape> {
    let mut shape = shape.clone();
    loop {
        let is_long = |a: u32, b: u32| {
            Vec3::from(shape.points[a as usize]).distance(Vec3::from(shape.points[b as usize])) > longest
        };
        let mut middles = std::collections::BTreeMap::new();
        let first = shape.points.len() as u32;
        let edges = shape.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        for [a, b] in edges.filter(|[a, b]| is_long(*a, *b)) {
            let next = first + middles.len() as u32;
            middles.entry([a.min(b), a.max(b)]).or_insert(next);
        }
        if middles.is_empty() {
            return Ok(shape);
        }
        if shape.triangles.len() > MAX / 4 {
            return Err(Error::memory(format!("a bent surface would have more than {MAX} triangles"))
                .at(format!("surface `{}`", shape.name))
                .advise("take larger voxels, or a smaller surface"));
        }
        let mut order: Vec<([u32; 2], u32)> = middles.iter().map(|(edge, point)| (*edge, *point)).collect();
        order.sort_unstable_by_key(|(_, point)| *point);
        for ([a, b], _) in order {
            let [a, b] = [a, b].map(|point| Vec3::from(shape.points[point as usize]));
            shape.points.push((0.5 * (a + b)).to_array());
        }
        let mut triangles = Vec::with_capacity(2 * shape.triangles.len());
        for [a, b, c] in &shape.triangles {
            let (a, b, c) = (*a, *b, *c);
            let middle = |from: u32, to: u32| middles.get(&[from.min(to), from.max(to)]).copied();
            match [middle(a, b), middle(b, c), middle(c, a)] {
                [None, None, None] => triangles.push([a, b, c]),
                [Some(m), None, None] => triangles.extend([[a, m, c], [m, b, c]]),
                [None, Some(m), None] => triangles.extend([[b, m, a], [m, c, a]]),
                [None, None, Some(m)] => triangles.extend([[c, m, b], [m, a, b]]),
                [Some(m), Some(n), None] => triangles.extend([[m, b, n], [a, m, n], [a, n, c]]),
                [None, Some(m), Some(n)] => triangles.extend([[m, c, n], [b, m, n], [b, n, a]]),
                [Some(n), None, Some(m)] => triangles.extend([[m, a, n], [c, m, n], [c, n, b]]),
                [Some(m), Some(n), Some(o)] => triangles.extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]),
            }
        }
        shape.triangles = triangles;
    }
}
