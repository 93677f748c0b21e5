//! Level sets from meshes and spheres, and meshes from grids.

use relievo_core::{Context, Error, Progress, Result};

use crate::abi;
use crate::call;
use crate::grid::Grid;
use crate::module::Module;
use crate::transform::Transform;

/// Polygons of a surface in world units, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygons {
    /// Points.
    pub points: Vec<[f32; 3]>,
    /// Triangles; none if the adaptivity was 0.
    pub triangles: Vec<[u32; 3]>,
    /// Quads.
    pub quads: Vec<[u32; 4]>,
}

/// Voxels from 0 at most, so that numbers of voxels do not overflow.
const FARTHEST: f64 = (1 << 28) as f64;
/// Voxels of a band to one side at most.
const WIDEST: f32 = 1000.0;

/// Fails unless a narrow band around `area` square voxels of surface fits the memory limit.
fn check_band(area: f64, width: f64, limit: u64) -> Result<()> {
    // Leaves reach 8 voxels beyond; while it is made, a grid has an index beside each distance.
    let bytes = area * (width + 8.0) * 8.0;
    if bytes <= limit as f64 {
        return Ok(());
    }
    let what = format!("the level set would need about {bytes:.3e} bytes, more than the memory limit of {limit}");
    Err(Error::memory(what).at("voxel").advise("take larger voxels or a narrower band, or raise the memory limit"))
}

fn check_width(name: &str, width: f32) -> Result<()> {
    if (1.0..=WIDEST).contains(&width) {
        return Ok(());
    }
    Err(Error::invalid(format!("a band of {width} voxels cannot be")).at(name).advise("use 1 to 1000; 3 is common"))
}

impl Grid {
    /// Makes a level set of a closed triangle mesh: distances in world units, negative inside, up to `exterior` voxels
    /// outside and `interior` voxels inside.
    ///
    /// # Errors
    /// Fails with `Invalid` if an index does not exist, a point is not finite or too far from 0, a width is not 1 to
    /// 1000 voxels or the transform has no inverse, with `Memory` if the estimate of its memory exceeds the limit, with
    /// `Cancelled` if `progress` asks to stop, and as [`Module::open`] does.
    pub fn of_mesh(
        context: &Context,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
        transform: &Transform,
        [exterior, interior]: [f32; 2],
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        check_width("exterior", exterior)?;
        check_width("interior", interior)?;
        transform.check()?;
        let missing = |triangle: &[u32; 3]| triangle.iter().any(|point| *point as usize >= points.len());
        if let Some(index) = triangles.iter().position(missing) {
            return Err(Error::invalid("a point does not exist").at(format!("triangle {index}")));
        }
        let voxel = transform.voxel_volume().cbrt();
        let is_near = |point: &[f32; 3]| point.iter().all(|at| (f64::from(*at) / voxel).abs() < FARTHEST);
        if let Some(index) = points.iter().position(|point| !is_near(point)) {
            let error =
                Error::invalid("the point is not finite or too many voxels from 0").at(format!("point {index}"));
            return Err(error.advise("take larger voxels, or repair the mesh"));
        }
        let area: f64 = triangles.iter().map(|triangle| area(triangle.map(|point| points[point as usize]))).sum();
        check_band(area / (voxel * voxel), f64::from(exterior + interior), context.memory_limit())?;
        let module = Module::open()?;
        let matrix = transform.numbers();
        Self::long(context, "mesh to level set", progress, |out, how, error| {
            let (places, place_count) = (points.as_flattened().as_ptr(), points.len());
            let (corners, count) = (triangles.as_flattened().as_ptr(), triangles.len());
            let (matrix, table) = (matrix.as_ptr(), module.table());
            // SAFETY: the arrays are as long as stated, every index was checked, sixteen numbers of the matrix are read,
            // and all live through the call.
            unsafe {
                table.rlvdb_from_mesh(places, place_count, corners, count, matrix, exterior, interior, how, out, error)
            }
        })
    }

    /// Makes a level set of the union of balls, with a band of `band` voxels on either side.
    ///
    /// # Errors
    /// Fails with `Invalid` if there are not as many radii as points, a number is not finite or too far from 0, a
    /// radius is not positive or the band is not 1 to 1000 voxels, with `Memory` if the estimate of its memory exceeds
    /// the limit, with `Cancelled` if `progress` asks to stop, and as [`Module::open`] does.
    pub fn of_spheres(
        context: &Context,
        points: &[[f32; 3]],
        radii: &[f32],
        voxel: f64,
        band: f32,
        progress: &mut dyn Progress,
    ) -> Result<Self> {
        check_width("band", band)?;
        Transform::uniform(voxel).check()?;
        if points.len() != radii.len() {
            let what = format!("there are {} radii for {} points", radii.len(), points.len());
            return Err(Error::invalid(what).at("radii").advise("give one for each point"));
        }
        let is_near = |at: f32| (f64::from(at) / voxel).abs() < FARTHEST;
        let is_sound = |(point, radius): (&[f32; 3], &f32)| {
            point.iter().all(|at| is_near(*at)) && *radius > 0.0 && is_near(*radius)
        };
        if let Some(index) = points.iter().zip(radii).position(|it| !is_sound(it)) {
            let error = Error::invalid("the ball is not finite, has no radius, or is too many voxels from 0");
            return Err(error.at(format!("point {index}")).advise("take larger voxels, or leave the point out"));
        }
        let area: f64 = radii.iter().map(|radius| (f64::from(*radius) / voxel + f64::from(band)).powi(2) * 12.6).sum();
        check_band(area, 2.0 * f64::from(band), context.memory_limit())?;
        let module = Module::open()?;
        Self::long(context, "spheres to level set", progress, |out, how, error| {
            let (places, sizes, count) = (points.as_flattened().as_ptr(), radii.as_ptr(), points.len());
            // SAFETY: both arrays are as long as stated and live through the call.
            unsafe { module.table().rlvdb_from_spheres(places, sizes, count, voxel, band, how, out, error) }
        })
    }

    /// Takes a grid that a long call of the module hands out.
    pub(crate) fn long(
        context: &Context,
        stage: &'static str,
        progress: &mut dyn Progress,
        call: impl FnOnce(*mut *mut abi::RlvdbGrid, &abi::RlvdbCall, &mut abi::RlvdbError) -> i32,
    ) -> Result<Self> {
        let mut pointer = std::ptr::null_mut();
        call::run(context, stage, progress, |how, error| call(&mut pointer, how, error))?;
        Self::of_pointer(pointer)
    }

    /// Meshes the surface at which a scalar grid has a value: 0 of a level set, in world units. `adaptivity` is 0 for quads
    /// of one size, up to 1 for the fewest polygons that keep to the surface.
    ///
    /// # Errors
    /// Fails with `Invalid` if the grid has bools, masks or vectors, the value is not finite or the adaptivity is not 0
    /// to 1, with `Cancelled` if `progress` asks to stop, and as [`Module::open`] does.
    pub fn polygons(
        &self,
        context: &Context,
        value: f64,
        adaptivity: f64,
        progress: &mut dyn Progress,
    ) -> Result<Polygons> {
        if !value.is_finite() || !(0.0..=1.0).contains(&adaptivity) {
            let error = Error::invalid(format!("a value of {value} with an adaptivity of {adaptivity} cannot be"));
            return Err(error.at("adaptivity").advise("use a finite value, and 0 to 1"));
        }
        let module = Module::open()?;
        let mut mesh = std::ptr::null_mut();
        call::run(context, "level set to mesh", progress, |how, error| {
            // SAFETY: the grid is alive, and both outputs live through the call.
            unsafe { module.table().rlvdb_to_mesh(self.pointer(), value, adaptivity, how, &mut mesh, error) }
        })?;
        if mesh.is_null() {
            return Err(Error::internal("the module returned no mesh"));
        }
        let mut view = std::mem::MaybeUninit::uninit();
        // SAFETY: the mesh is alive, and the view is written whole.
        let view = unsafe {
            module.table().rlvdb_mesh_view(mesh, view.as_mut_ptr());
            view.assume_init()
        };
        // SAFETY: the arrays of the view are as long as it states, and live until the mesh is freed.
        let polygons = unsafe {
            Polygons {
                points: copied(view.points.cast(), view.point_count),
                triangles: copied(view.triangles.cast(), view.triangle_count),
                quads: copied(view.quads.cast(), view.quad_count),
            }
        };
        // SAFETY: the mesh came from the module and is freed once.
        unsafe { module.table().rlvdb_mesh_free(mesh) };
        Ok(polygons)
    }
}

/// Copies an array of the module.
///
/// # Safety
/// There are `count` elements at `start`, unless there is none.
unsafe fn copied<T: Copy>(start: *const T, count: usize) -> Vec<T> {
    if count == 0 {
        return Vec::new();
    }
    // SAFETY: promised by the caller.
    unsafe { std::slice::from_raw_parts(start, count) }.to_vec()
}

fn area([a, b, c]: [[f32; 3]; 3]) -> f64 {
    let edge = |to: [f32; 3]| [0, 1, 2].map(|axis| f64::from(to[axis]) - f64::from(a[axis]));
    let (u, v) = (edge(b), edge(c));
    let cross = [0, 1, 2].map(|axis| u[(axis + 1) % 3] * v[(axis + 2) % 3] - u[(axis + 2) % 3] * v[(axis + 1) % 3]);
    0.5 * cross.iter().map(|part| part * part).sum::<f64>().sqrt()
}
