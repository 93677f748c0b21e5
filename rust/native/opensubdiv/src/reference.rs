//! OpenSubdiv's own evaluators, which tests and benches compare with.

use cxx::UniquePtr;
use relievo_core::{Error, Mesh, Result};

use crate::bridge::ffi;
use crate::table::{Cage, Options, Table};

/// P, du, dv, duu, duv, dvv by `Far::PatchTable::EvaluateBasis` in f64 at `(tile, u, v)`.
///
/// `points` are all points of the table. Derivatives are per unit of the tile's own parameters. A place without a patch
/// (a hole) gives zeros. Note that `EvaluateBasis` takes single-crease patches for infinitely sharp ones.
///
/// # Errors
/// Fails with `Invalid` if there are not as many points as the table has or a place is outside its tile, and with
/// `Internal` if OpenSubdiv fails to evaluate.
pub fn evaluate(table: &Table, points: &[[f64; 3]], places: &[(u32, f64, f64)]) -> Result<Vec<[[f64; 3]; 6]>> {
    if points.len() != table.point_count() {
        return Err(Error::invalid("as many points as the table has are needed"));
    }
    let (tiles, uv) = split(places, table.tile_count())?;
    let mut out = vec![[[0.0; 3]; 6]; places.len()];
    let numbers = out.as_flattened_mut().as_flattened_mut();
    table.inner().evaluate(points.as_flattened(), &tiles, uv.as_flattened(), numbers).map_err(failed)?;
    Ok(out)
}

/// Returns the tiles and parameters of `places`. Fails if one is outside its tile.
fn split(places: &[(u32, f64, f64)], tile_count: usize) -> Result<(Vec<i32>, Vec<[f64; 2]>)> {
    let in_range = |(tile, u, v): &(u32, f64, f64)| {
        (*tile as usize) < tile_count && (0.0..=1.0).contains(u) && (0.0..=1.0).contains(v)
    };
    if !places.iter().all(in_range) {
        return Err(Error::invalid("a place is outside its tile"));
    }
    Ok(places.iter().map(|(tile, u, v)| (*tile as i32, [*u, *v])).unzip())
}

/// A cage and places on it as C++ takes them, so that [`Self::run`] is a single call.
pub struct Evaluation<'m> {
    cage: Cage<'m>,
    options: Options,
    cage_points: Vec<[f64; 3]>,
    tiles: Vec<i32>,
    uv: Vec<[f64; 2]>,
}

impl<'m> Evaluation<'m> {
    /// Prepares `mesh`, which must have passed [`Mesh::check`], and `(tile, u, v)` on its tiles.
    ///
    /// # Errors
    /// Fails with `Invalid` if a place is outside its tile, with `NotFound` if OpenSubdiv cannot be opened, and with
    /// `Unsupported` if a face or point has more than 65,535 neighbours.
    pub fn new(mesh: &'m Mesh, options: &Options, places: &[(u32, f64, f64)]) -> Result<Self> {
        let tile_count = mesh.face_sizes.iter().map(|size| if *size == 4 { 1 } else { *size as usize }).sum();
        let (tiles, uv) = split(places, tile_count)?;
        let cage_points = mesh.points.iter().map(|point| point.map(f64::from)).collect();
        Ok(Self { cage: Cage::new(mesh)?, options: *options, cage_points, tiles, uv })
    }

    /// Refines the cage and evaluates it, as [`Table::new`] and [`evaluate`] do together, within C++ alone.
    ///
    /// # Errors
    /// Fails with `Internal` if OpenSubdiv cannot refine the cage or evaluate it.
    pub fn run(&self) -> Result<Vec<[[f64; 3]; 6]>> {
        let mut out = vec![[[0.0; 3]; 6]; self.tiles.len()];
        let numbers = out.as_flattened_mut().as_flattened_mut();
        let (cage, points) = (self.cage.described(&self.options), self.cage_points.as_flattened());
        ffi::refine_and_evaluate(&cage, points, &self.tiles, self.uv.as_flattened(), numbers).map_err(failed)?;
        Ok(out)
    }
}

/// P, du, dv by `EvaluateBasis` in f32 on a `size`² lattice of every tile, nine floats a sample, into `buffer`, from
/// its start again when it is full. Returns the number of samples.
///
/// # Errors
/// Fails with `Invalid` if there are not as many points as the table has, `size` is not 2 to 4096, or `buffer` holds
/// less than one tile, and with `Internal` if OpenSubdiv fails.
pub fn far_grid(table: &Table, points: &[[f32; 3]], size: usize, buffer: &mut [f32]) -> Result<u64> {
    check_grid(points.len() == table.point_count(), size, buffer)?;
    table.inner().far_grid(points.as_flattened(), size as u32, buffer).map_err(failed)
}

/// The Bfr evaluator of a table's refiner.
pub struct Bfr<'a> {
    inner: UniquePtr<ffi::BfrEvaluator<'a>>,
    table: &'a Table,
}

impl<'a> Bfr<'a> {
    /// With `level` as the approximation level of smooth and sharp features.
    ///
    /// # Errors
    /// Fails with `Internal` on an exception of OpenSubdiv.
    pub fn new(table: &'a Table, level: u32) -> Result<Self> {
        Ok(Self { inner: ffi::make_bfr(table.inner(), level).map_err(failed)?, table })
    }

    /// As [`far_grid`], from the cage's points.
    ///
    /// # Errors
    /// Fails with `Invalid` if there are not as many points as the cage has, `size` is not 2 to 4096, or `buffer` holds
    /// less than one tile, and with `Internal` if OpenSubdiv fails.
    pub fn grid(&mut self, points: &[[f32; 3]], size: usize, buffer: &mut [f32]) -> Result<u64> {
        check_grid(points.len() == self.table.cage_point_count(), size, buffer)?;
        self.inner.pin_mut().grid(points.as_flattened(), size as u32, buffer).map_err(failed)
    }
}

fn failed(exception: cxx::Exception) -> Error {
    Error::internal(format!("OpenSubdiv failed to evaluate: {exception}"))
}

fn check_grid(points_fit: bool, size: usize, buffer: &[f32]) -> Result<()> {
    if !points_fit || !(2..=4096).contains(&size) || buffer.len() < 9 * size * size {
        return Err(Error::invalid("the points do not fit the table, or the buffer holds less than one tile"));
    }
    Ok(())
}
