//! What of a description begins full of fluid: meshes, boxes, spheres, and grids of OpenVDB.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3, Vec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, Error, ErrorKind, Result, file};
use relievo_fluid::{Solid, fill_where};
use relievo_openvdb::{Kind, Survey, Writing};
use relievo_particleio::{Grid, read_grid};
use serde::Deserialize;

use crate::files::Source;
use crate::shape::{Ball, Corners, MeshFile, Shape};

/// How dense fog is where it is taken for fluid.
const THRESHOLD: f32 = 0.5;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fill {
    mesh: Option<MeshFile>,
    #[serde(rename = "box")]
    corners: Option<Corners>,
    sphere: Option<Ball>,
    /// A file of OpenVDB.
    grid: Option<PathBuf>,
    /// The name of its grid; left out, the first of floats.
    grid_name: Option<String>,
    /// How dense fog is at least where fluid is.
    threshold: Option<f32>,
    #[serde(default)]
    pub velocity: [f32; 3],
    pub color: Option<[f32; 3]>,
}

impl Fill {
    /// The places of its particles; `files` finds what it names.
    pub fn places(&self, context: &Context, files: &Source, spacing: f32) -> Result<Vec<Vec3>> {
        let shape = Shape { mesh: self.mesh.as_ref(), corners: self.corners.as_ref(), sphere: self.sphere.as_ref() };
        let Some(grid) = &self.grid else {
            if self.grid_name.is_some() || self.threshold.is_some() {
                return Err(Error::invalid("it has no grid").advise("leave grid_name and threshold out"));
            }
            let (points, triangles) = shape.triangles(context, files)?;
            return Solid::new(&points, &triangles)?.fill(context, spacing);
        };
        if shape.mesh.is_some() || shape.corners.is_some() || shape.sphere.is_some() {
            return Err(
                Error::invalid("it has more than one shape").advise("give it one of mesh, box, sphere and grid")
            );
        }
        let path = files.path(grid)?;
        let named = |error: Error| error.at(path.display().to_string());
        let grid = self.load(context, &path).map_err(named)?;
        self.within(context, &grid, spacing).map_err(named)
    }

    /// Reads its grid. What our reader refuses, such as doubles, masks and streams, OpenVDB reads and makes floats.
    fn load(&self, context: &Context, path: &Path) -> Result<Grid> {
        let read = |path: &Path| {
            let bytes = file::load(path, context.memory_limit())?;
            let left = context.memory_limit() - bytes.len() as u64;
            read_grid(&bytes, self.grid_name.as_deref(), left)
        };
        let refused = match read(path) {
            Ok(grid) => return Ok(grid),
            Err(error) if matches!(error.kind, ErrorKind::NotFound | ErrorKind::Io | ErrorKind::Memory) => {
                return Err(error);
            }
            Err(error) => error,
        };
        let name = self.grid_name.as_deref();
        let listed = Survey::of_file(path, context.memory_limit()).is_ok_and(|survey| survey.find(name).is_ok());
        if !listed {
            return Err(refused);
        }
        let grid = relievo_openvdb::read(context, path, name, None, &mut Silent)?;
        let floats = grid.converted(context, Kind::Float, &mut Silent)?;
        let folder = tempfile::tempdir().map_err(|error| Error::io(&std::env::temp_dir(), &error))?;
        let plain = folder.path().join("grid.vdb");
        relievo_openvdb::write(context, &plain, &[&floats], &Writing::default(), &mut Silent)?;
        read(&plain)
    }

    /// Places where distances are negative, or fog is denser than the threshold.
    fn within(&self, context: &Context, grid: &Grid, spacing: f32) -> Result<Vec<Vec3>> {
        if grid.is_level_set && self.threshold.is_some() {
            return Err(Error::invalid("a level set has no threshold").at("threshold").advise("leave it out"));
        }
        let limit = if grid.is_level_set { 0.0 } else { self.threshold.unwrap_or(THRESHOLD) };
        let Some([low, high]) = grid.bounds(limit, grid.is_level_set) else {
            return Err(
                Error::invalid("nothing of the grid is inside, or all of space").advise("take another threshold")
            );
        };
        let [x, y, z, origin] = grid.transform.map(DVec3::from);
        let place = DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), origin);
        let voxels = place.inverse();
        if !voxels.is_finite() {
            return Err(Error::invalid("its voxels have no volume"));
        }
        let corner = |at: usize| DVec3::from([0, 1, 2].map(|axis| [low, high][at >> axis & 1][axis]));
        let corners = (0..8).map(|at| place.transform_point3(corner(at)).as_vec3());
        let ends = corners.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
        let is_inside = |at: Vec3| {
            let value = grid.sample(voxels.transform_point3(at.as_dvec3()).to_array());
            if grid.is_level_set { value < limit } else { value > limit }
        };
        fill_where(context, ends, spacing, &is_inside)
    }

    /// Returns the volume of its box or sphere in cubic metres; 0 for a mesh or a grid.
    pub fn volume(&self) -> f64 {
        let boxes = self.corners.iter().map(|it| [0, 1, 2].map(|at| f64::from(it.high[at] - it.low[at]).max(0.0)));
        boxes.map(|sides| sides.iter().product()).chain(self.sphere.iter().map(Ball::volume)).sum()
    }

    /// The mesh that it is read from.
    pub fn mesh(&self) -> Option<&MeshFile> {
        self.mesh.as_ref()
    }

    /// The grid that it is read from.
    pub fn grid(&self) -> Option<&Path> {
        self.grid.as_deref()
    }
}
