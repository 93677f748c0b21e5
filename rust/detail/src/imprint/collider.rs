//! Colliders: triangle meshes that imprint themselves on deformable objects, rigid ones moved by a transform and
//! deforming ones by new points, with their box and their hierarchy (Schäfer et al. 2014, Section 5).

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DAffine3, DVec3};
use relievo_core::{Context, Error, List, Mesh, Result};

use crate::geometry::closure::Closure;
use crate::geometry::grid::Grid;
use crate::geometry::hierarchy::{Bounds, Hierarchy, Region};
use crate::geometry::lattice::Lattice;
use crate::geometry::obb::Obb;
use crate::geometry::voxel::{Side, Solid, Voxels};
use crate::object::transform::check_transform;

/// A triangle mesh in the world.
#[derive(Clone, Debug)]
pub struct Collider {
    /// The points of the mesh, and those of its closure.
    points: Vec<[f32; 3]>,
    triangles: Arc<[[u32; 3]]>,
    hierarchy: Hierarchy,
    obb: Obb,
    /// Where the front of a sheet looks on average, in object space; zero for other meshes.
    facing: DVec3,
    closure: Closure,
    transform: DAffine3,
    /// Numbers of the mesh and of its points as they are, by which what a device keeps of them is found.
    pub(crate) identity: [u64; 2],
}

/// A number that no mesh and no points had before.
fn fresh() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// Triangles of which the bounds are found by one thread at a time.
const TOGETHER: usize = 256;

impl Collider {
    /// A collider of the faces of `mesh`, cut into triangles.
    ///
    /// # Errors
    /// Fails with `Invalid` if the mesh does not pass [`Mesh::check`] or all its faces are holes, and as [`Self::new`].
    pub fn of_mesh(context: &Context, mesh: &Mesh, transform: DAffine3) -> Result<Self> {
        mesh.check()?;
        Self::new(context, mesh.points.clone(), mesh.triangles(), transform)
    }

    /// A collider of triangles, counter-clockwise seen from outside.
    ///
    /// A mesh whose every edge is met by the same edge in the opposite direction is closed and solid inside, even where
    /// shells overlap or are turned inside out; points at the same place are one. The holes of an open mesh are
    /// covered, and it is solid inside. A sheet, an open mesh whose faces mostly point one way, is solid behind its
    /// front.
    ///
    /// # Errors
    /// Fails with `Invalid` if the transform is not finite or cannot be undone, a coordinate is not finite, there is no
    /// triangle, a point of one does not exist, or there are 2³² triangles or more with the covers of holes; and with
    /// `Unsupported` if there are 2³¹ points or more.
    pub fn new(
        context: &Context,
        mut points: Vec<[f32; 3]>,
        mut triangles: Vec<[u32; 3]>,
        transform: DAffine3,
    ) -> Result<Self> {
        check_transform(&transform)?;
        check_points(&points)?;
        if triangles.is_empty() {
            return Err(Error::invalid("the collider has no triangle").advise("give it at least one face"));
        }
        if let Some(index) = triangles.iter().position(|corners| corners.iter().any(|p| *p as usize >= points.len())) {
            return Err(Error::invalid("a point does not exist").at(format!("triangle {index}")));
        }
        if points.len() > i32::MAX as usize {
            return Err(
                Error::unsupported(format!("the collider has {} points", points.len())).advise("use a coarser mesh")
            );
        }
        let closure = context.stats().time("collider.closure", || Closure::new(&mut points, &mut triangles));
        let obb = Obb::of_points(&points)?;
        let hierarchy = context.stats().time("collider.hierarchy", || {
            Hierarchy::build(context, triangles.len(), |index| bounds(&points, &triangles[index as usize]))
        })?;
        let identity = [fresh(), fresh()];
        let facing = closure.facing(&points, &triangles);
        Ok(Self { points, triangles: triangles.into(), hierarchy, obb, facing, closure, transform, identity })
    }

    /// Returns the mesh's points in object space.
    pub fn points(&self) -> &[[f32; 3]] {
        &self.points[..self.closure.given()[0]]
    }

    /// Returns the point indices of the mesh's triangles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles[..self.closure.given()[1]]
    }

    /// Returns the points and triangles that are voxelised: those of the mesh, and the covers of its holes.
    pub(crate) fn boundary(&self) -> (&[[f32; 3]], &[[u32; 3]]) {
        (&self.points, &self.triangles)
    }

    /// Returns whether the mesh has no open edge.
    pub fn is_closed(&self) -> bool {
        self.closure.open_edges() == 0
    }

    /// Returns the number of edges that no edge in the opposite direction meets.
    pub fn open_edges(&self) -> usize {
        self.closure.open_edges()
    }

    /// Returns whether the mesh is open and its faces mostly point one way, so that it is solid behind its front.
    pub fn is_sheet(&self) -> bool {
        self.closure.is_sheet()
    }

    /// From object space to the world.
    pub fn transform(&self) -> &DAffine3 {
        &self.transform
    }

    /// Moves the collider.
    ///
    /// # Errors
    /// Fails with `Invalid` if the transform is not finite or cannot be undone.
    pub fn set_transform(&mut self, transform: DAffine3) -> Result<()> {
        check_transform(&transform)?;
        self.transform = transform;
        Ok(())
    }

    /// Deforms the collider: as many points as before. Refits the hierarchy, or builds it anew where points that coincided
    /// come apart.
    ///
    /// # Errors
    /// Fails, and changes nothing, with `Invalid` if there are not as many points as the collider has or a coordinate
    /// is not finite.
    pub fn set_points(&mut self, context: &Context, points: &[[f32; 3]]) -> Result<()> {
        let count = self.points().len();
        if points.len() != count {
            return Err(Error::invalid(format!("the pose has {} points, the collider {count}", points.len())));
        }
        check_points(points)?;
        self.points[..count].copy_from_slice(points);
        let is_other = self.closure.follow(&mut self.points, &mut self.triangles);
        self.identity[1] = fresh();
        self.obb = Obb::of_points(&self.points)?;
        self.facing = self.closure.facing(&self.points, &self.triangles);
        let (points, triangles, hierarchy) = (&self.points, &self.triangles, &mut self.hierarchy);
        let bounds = |index: u32| bounds(points, &triangles[index as usize]);
        context.stats().time("collider.refit", || {
            if is_other {
                self.identity[0] = fresh();
                *hierarchy = Hierarchy::build(context, triangles.len(), bounds)?;
            } else {
                hierarchy.refit(context, bounds);
            }
            Ok(())
        })
    }

    /// The box in object space.
    pub fn object_obb(&self) -> &Obb {
        &self.obb
    }

    /// The box in the world.
    pub fn obb(&self) -> Obb {
        self.obb.transformed(&self.transform)
    }

    /// Returns a box in the world that holds what is solid: the collider's, for sheets as far as `behind` world units
    /// against the direction in which the front looks on average. What columns through a rim fill beside the sheet is cut
    /// off there.
    pub(crate) fn solid_obb(&self, behind: f64) -> Obb {
        let facing = (self.transform.matrix3.inverse().transpose() * self.facing).normalize_or_zero();
        // A flat sheet on the border of its box would be lost to rounding, so the box begins a little before the front.
        self.obb().swept(-behind * facing).swept(behind / 32.0 * facing)
    }

    /// The part of `obb`, along its axes, that holds everything of the collider in it; `None` if nothing is in it.
    ///
    /// It is spanned by the surface in the box. Where no surface is, the box is inside or outside as a whole: a voxel
    /// of each slab that the surface leaves tells which. Boxes around sheets are left as they are.
    ///
    /// # Errors
    /// Fails with `Unsupported` as [`Self::voxelise`] where a voxel has to tell whether a part of the box is inside;
    /// never for sheets.
    pub fn occupied(&self, context: &Context, obb: &Obb) -> Result<Option<Obb>> {
        let to_box = DAffine3::from_mat3_translation(obb.axes, obb.center).inverse() * self.transform;
        let mut found = context.scratch().list();
        self.hierarchy.query(context, &Region::new(to_box, -obb.half, obb.half), &mut found);
        if self.is_sheet() {
            return Ok((!found.is_empty()).then_some(*obb));
        }
        let mut bounds = context.scratch().list();
        context.map_into(found.len().div_ceil(TOGETHER), &mut bounds, |chunk| {
            let own = found.iter().skip(chunk * TOGETHER).take(TOGETHER);
            own.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), index| {
                let corners = self.triangles[*index as usize]
                    .map(|point| to_box.transform_point3(DVec3::from(self.points[point as usize].map(f64::from))));
                let (from, to) = clipped_bounds(corners, obb.half);
                (low.min(from), high.max(to))
            })
        });
        let (mut low, mut high) = bounds
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |sum, part| (sum.0.min(part.0), sum.1.max(part.1)));
        let part = |low: DVec3, high: DVec3| {
            let local = Obb::from_interval(glam::DMat3::IDENTITY, low, high);
            Obb { center: obb.center + obb.axes * local.center, axes: obb.axes, half: local.half }
        };
        if low.cmpgt(high).any() {
            return Ok(self.covers(context, obb)?.then_some(*obb));
        }
        let slack = 1e-9 * obb.half;
        (low, high) = ((low - slack).max(-obb.half), (high + slack).min(obb.half));
        for axis in 0..3 {
            let (mut below, mut above) = (obb.half, -obb.half);
            below[axis] = low[axis];
            above[axis] = high[axis];
            if low[axis] > -obb.half[axis] && self.covers(context, &part(-obb.half, below))? {
                low[axis] = -obb.half[axis];
            }
            if high[axis] < obb.half[axis] && self.covers(context, &part(above, obb.half))? {
                high[axis] = obb.half[axis];
            }
        }
        Ok(Some(part(low, high)))
    }

    /// Whether the middle of `obb` is inside, by a grid of one voxel.
    fn covers(&self, context: &Context, obb: &Obb) -> Result<bool> {
        let mut voxel = context.scratch().lend::<Voxels>();
        self.voxelise(context, &Grid::new(obb, 1, None), &mut voxel)?;
        Ok(voxel.count() > 0)
    }

    /// The grid of an overlap with this collider, into which rays will be cast that run along the axes of the box by as
    /// much as `facing` says, 0 to 1.
    ///
    /// Columns run along the axis that most rays follow if it is clear enough, or else along the longest edge. Those of
    /// a sheet run across it.
    pub fn grid(&self, context: &Context, obb: &Obb, budget: u64, facing: DVec3) -> Grid {
        if !self.is_sheet() {
            let along = (0..3).max_by(|a, b| facing[*a].total_cmp(&facing[*b])).filter(|axis| facing[*axis] > 0.45);
            // In very flat boxes columns would be too many for their length.
            let deep = |axis: &usize| obb.half[*axis] > 0.05 * obb.half.max_element();
            return Grid::new(obb, budget, along.filter(deep));
        }
        let mut found = context.scratch().list();
        let inverse = DAffine3::from_mat3_translation(obb.axes, obb.center).inverse() * self.transform;
        self.hierarchy.query(context, &Region::new(inverse, -obb.half, obb.half), &mut found);
        let mut area = DVec3::ZERO;
        for index in found.iter() {
            let [a, b, c] = self.triangles[*index as usize]
                .map(|point| inverse.transform_point3(DVec3::from(self.points[point as usize].map(f64::from))));
            area += (b - a).cross(c - a).abs();
        }
        // A little preference for the longest edge decides where there is nothing.
        area += obb.half * 1e-12;
        let widest = (0..3).max_by(|a, b| area[*a].total_cmp(&area[*b]));
        Grid::new(obb, budget, widest)
    }

    /// Voxelises the part of the collider in `grid`, from the side that has fewer triangles. Returns how many
    /// triangles were looked at.
    ///
    /// # Errors
    /// Fails, and leaves `voxels` as they are, with `Unsupported` if the columns of the grid, extended to that side,
    /// meet a triangle with a coordinate of 2⁴⁰ voxels or more in the grid.
    pub fn voxelise(&self, context: &Context, grid: &Grid, voxels: &mut Voxels) -> Result<usize> {
        let (side, selection) = self.side(context, grid);
        let solid = Solid {
            points: &self.points,
            triangles: &self.triangles,
            transform: self.transform,
            closed: !self.is_sheet(),
            lattice: self.lattice(grid),
        };
        voxels.fill(context, grid, &solid, Some(&selection), side)?;
        Ok(selection.len())
    }

    /// Where its points are on the lattice of `grid`; `None` where that is not a matter of integers.
    pub(crate) fn lattice(&self, grid: &Grid) -> Option<Lattice> {
        Lattice::new(grid, &self.transform, self.object_obb())
    }

    /// The side of `grid` on which its columns meet fewer triangles, and those triangles.
    pub(crate) fn side<'c>(&self, context: &'c Context, grid: &Grid) -> (Side, List<'c, u32>) {
        let map = grid.map * self.transform;
        let dims = DVec3::from(grid.dims.map(f64::from));
        // Snapping moves corners by up to 1/512 voxel.
        let (low, high) = (DVec3::splat(-0.01), dims + 0.01);
        let prism = |side: Side| {
            let (mut low, mut high) = (low, high);
            match side {
                Side::Forward => low.z = f64::NEG_INFINITY,
                Side::Backward => high.z = f64::INFINITY,
            }
            let mut found = context.scratch().list();
            self.hierarchy.query(context, &Region::new(map, low, high), &mut found);
            found
        };
        let (forward, backward) = context.join(|| prism(Side::Forward), || prism(Side::Backward));
        if backward.len() < forward.len() { (Side::Backward, backward) } else { (Side::Forward, forward) }
    }
}

fn bounds(points: &[[f32; 3]], triangle: &[u32; 3]) -> Bounds {
    Bounds::of_points(triangle.iter().map(|point| &points[*point as usize]))
}

/// The bounds of what a box around the origin leaves of a triangle. Only a triangle that reaches far out of the box is
/// cut; small ones are taken whole, which the caller clamps.
fn clipped_bounds(corners: [DVec3; 3], half: DVec3) -> (DVec3, DVec3) {
    let bounds = |corners: &[DVec3]| {
        corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
    };
    let (low, high) = bounds(&corners);
    if low.cmpgt(half).any() || high.cmplt(-half).any() {
        return (DVec3::INFINITY, DVec3::NEG_INFINITY);
    }
    if (high - half).max(-half - low).cmple(0.05 * half).all() {
        return (low, high);
    }
    // Each of six cuts adds a corner at most to a convex polygon; rounding may leave one that is not quite convex.
    let mut polygon = [DVec3::ZERO; 16];
    polygon[..3].copy_from_slice(&corners);
    let mut count = 3;
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let inside = |p: DVec3| half[axis] - sign * p[axis];
            let (from, before) = (polygon, count);
            count = 0;
            let mut add = |p: DVec3| {
                if let Some(corner) = polygon.get_mut(count) {
                    (*corner, count) = (p, count + 1);
                }
            };
            for (index, a) in from[..before].iter().enumerate() {
                let b = from[(index + 1) % before];
                let (da, db) = (inside(*a), inside(b));
                if da >= 0.0 {
                    add(*a);
                }
                if (da < 0.0) != (db < 0.0) {
                    add(a.lerp(b, da / (da - db)));
                }
            }
        }
    }
    bounds(&polygon[..count])
}

fn check_points(points: &[[f32; 3]]) -> Result<()> {
    match points.iter().position(|point| !point.iter().all(|value| value.is_finite())) {
        Some(index) => Err(Error::invalid("a coordinate is not a finite number").at(format!("point {index}"))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::shapes;
    use glam::DMat3;

    #[test]
    fn closed_and_open_meshes_are_told_apart() {
        let context = Context::serial();
        let make =
            |(points, triangles): shapes::Soup| Collider::new(&context, points, triangles, DAffine3::IDENTITY).unwrap();
        assert!(make(shapes::sphere(1.0, 12, 8, 0.1)).is_closed());
        assert!(make(shapes::inverted(shapes::torus(1.0, 0.3, 9, 7))).is_closed());
        let (points, mut triangles) = shapes::cube(1.0);
        triangles.pop();
        let open = make((points, triangles));
        assert!(!open.is_closed() && open.open_edges() == 3 && !open.is_sheet());
        // The cover of the hole is for voxels alone.
        assert_eq!([open.points().len(), open.triangles().len()], [8, 11]);
    }

    #[test]
    fn bad_colliders_are_refused() {
        let context = Context::serial();
        let (points, triangles) = shapes::cube(1.0);
        let new = |points: &[[f32; 3]], triangles: &[[u32; 3]], transform| {
            Collider::new(&context, points.to_vec(), triangles.to_vec(), transform)
        };
        assert!(new(&points, &[], DAffine3::IDENTITY).is_err());
        assert!(new(&points, &[[0, 1, 8]], DAffine3::IDENTITY).is_err());
        assert!(new(&[[f32::INFINITY; 3]; 8], &triangles, DAffine3::IDENTITY).is_err());
        assert!(new(&points, &triangles, DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_err());
        let mut good = new(&points, &triangles, DAffine3::IDENTITY).unwrap();
        assert!(good.set_points(&context, &points[..7]).is_err());
        assert!(good.set_transform(DAffine3::from_translation(DVec3::NAN)).is_err());
    }

    #[test]
    fn a_box_is_cut_down_to_what_the_collider_fills_of_it() {
        let context = Context::serial();
        let (points, triangles) = shapes::sphere(1.0, 60, 40, 0.0);
        let ball = Collider::new(&context, points, triangles, DAffine3::IDENTITY).unwrap();
        let slab = |center: [f64; 3], half: [f64; 3]| {
            let obb = Obb { center: DVec3::from(center), axes: DMat3::from_rotation_z(0.3), half: DVec3::from(half) };
            ball.occupied(&context, &obb).unwrap()
        };
        // A cap of height 0.2 has the radius 0.6.
        let cap = slab([0.0, 0.0, -0.9], [3.0, 3.0, 0.1]).unwrap();
        assert!(cap.half.x > 0.58 && cap.half.x < 0.65 && cap.half.y < 0.65 && cap.half.z > 0.099, "{cap:?}");
        // The flank: solid to one side, so that side stays although no surface is near.
        let flank = slab([0.5, 0.0, 0.0], [0.9, 0.05, 0.05]).unwrap();
        let low = flank.center.dot(flank.axes.x_axis) - flank.half.x;
        assert!(low < 0.5 * 0.3f64.cos() - 0.9 + 1e-6, "{flank:?}");
        assert!(flank.half.x < 0.9);
        let inside = slab([0.0; 3], [0.2; 3]).unwrap();
        assert_eq!(inside.half, DVec3::splat(0.2));
        assert_eq!(slab([3.0, 0.0, 0.0], [0.5; 3]), None);
        // Close by, where boxes of triangles are met but the ball is not.
        assert_eq!(slab([0.9, 0.9, 0.9], [0.05; 3]), None);
    }

    #[test]
    fn an_open_sheet_is_voxelised_across_its_columns() {
        let context = Context::serial();
        let points = vec![[-9.0, -9.0, 0.1], [9.0, -9.0, 0.1], [9.0, 9.0, 0.1], [-9.0, 9.0, 0.1]];
        let sheet = Collider::new(&context, points, vec![[0, 1, 2], [0, 2, 3]], DAffine3::IDENTITY).unwrap();
        let obb = Obb { center: DVec3::ZERO, axes: DMat3::from_rotation_x(0.05), half: DVec3::new(3.0, 3.0, 0.5) };
        let grid = sheet.grid(&context, &obb, 1 << 15, DVec3::ZERO);
        let mut voxels = Voxels::default();
        sheet.voxelise(&context, &grid, &mut voxels).unwrap();
        for index in 0..4096u32 {
            let voxel = [index % 16, index / 16 % 16, index / 256].map(|v| v * 2);
            if (0..3).all(|axis| voxel[axis] < grid.dims[axis]) {
                let height = grid.center(voxel).z - 0.1;
                assert!(height.abs() < 1e-3 || voxels.get(voxel) == (height < 0.0), "{voxel:?} {height}");
            }
        }
    }
}
