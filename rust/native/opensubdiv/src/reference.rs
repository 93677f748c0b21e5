//! OpenSubdiv's own evaluators, which tests and benches compare with.

use std::ffi::CStr;

use relievo_core::{Error, Result};

use crate::ffi;
use crate::table::Table;

/// P, du, dv, duu, duv, dvv by `Far::PatchTable::EvaluateBasis` in f64 at `(tile, u, v)`.
///
/// `points` are all points of the table. Derivatives are per unit of the tile's own parameters. A place without a patch
/// (a hole) gives zeros. Note that `EvaluateBasis` takes single-crease patches for infinitely sharp ones.
pub fn evaluate(table: &Table, points: &[[f64; 3]], places: &[(u32, f64, f64)]) -> Result<Vec<[[f64; 3]; 6]>> {
    if points.len() != table.point_count() {
        return Err(Error::invalid("as many points as the table has are needed"));
    }
    let in_range = |(tile, u, v): &(u32, f64, f64)| {
        (*tile as usize) < table.tile_count() && (0.0..=1.0).contains(u) && (0.0..=1.0).contains(v)
    };
    if !places.iter().all(in_range) {
        return Err(Error::invalid("a place is outside its tile"));
    }
    let tiles: Vec<i32> = places.iter().map(|place| place.0 as i32).collect();
    let uv: Vec<[f64; 2]> = places.iter().map(|place| [place.1, place.2]).collect();
    let mut out = vec![[[0.0; 3]; 6]; places.len()];
    // SAFETY: every array is as long as `places`, with 2 and 18 numbers a place; points cover the table's indices.
    let found = unsafe {
        ffi::rlv_osd_evaluate(
            table.handle(),
            points.as_ptr().cast(),
            places.len() as i32,
            tiles.as_ptr(),
            uv.as_ptr().cast(),
            out.as_mut_ptr().cast(),
        )
    };
    if found < 0 { Err(Error::internal("OpenSubdiv failed to evaluate")) } else { Ok(out) }
}

/// P, du, dv by `EvaluateBasis` in f32 on a `size`² lattice of every tile, nine floats a sample, into `buffer`, from
/// its start again when it is full. Returns the number of samples.
pub fn far_grid(table: &Table, points: &[[f32; 3]], size: usize, buffer: &mut [f32]) -> Result<u64> {
    check_grid(points.len() == table.point_count(), size, buffer)?;
    // SAFETY: points cover the table's indices; the shim stays within the buffer, which holds at least one tile.
    let samples = unsafe {
        ffi::rlv_osd_far_grid(
            table.handle(),
            points.as_ptr().cast(),
            size as i32,
            buffer.as_mut_ptr(),
            buffer.len() as i64,
        )
    };
    u64::try_from(samples).map_err(|_| Error::internal("OpenSubdiv failed to evaluate"))
}

/// The Bfr evaluator of a table's refiner.
pub struct Bfr<'a> {
    handle: *mut ffi::Bfr,
    table: &'a Table,
}

impl<'a> Bfr<'a> {
    /// With `level` as the approximation level of smooth and sharp features.
    pub fn new(table: &'a Table, level: u32) -> Result<Self> {
        let mut text = [0 as std::ffi::c_char; 256];
        // SAFETY: the table is alive for 'a; the text is written within its size.
        let handle = unsafe { ffi::rlv_osd_bfr_create(table.handle(), level as i32, text.as_mut_ptr(), text.len()) };
        if handle.is_null() {
            // SAFETY: ended with a zero by the shim.
            let what = unsafe { CStr::from_ptr(text.as_ptr()) }.to_string_lossy().into_owned();
            return Err(Error::internal(what));
        }
        Ok(Self { handle, table })
    }

    /// As [`far_grid`], from the cage's points.
    pub fn grid(&mut self, points: &[[f32; 3]], size: usize, buffer: &mut [f32]) -> Result<u64> {
        check_grid(points.len() == self.table.cage_point_count(), size, buffer)?;
        // SAFETY: points are the cage's; the shim stays within the buffer, which holds at least one tile.
        let samples = unsafe {
            ffi::rlv_osd_bfr_grid(
                self.handle,
                points.as_ptr().cast(),
                size as i32,
                buffer.as_mut_ptr(),
                buffer.len() as i64,
            )
        };
        u64::try_from(samples).map_err(|_| Error::internal("OpenSubdiv failed to evaluate"))
    }
}

impl Drop for Bfr<'_> {
    fn drop(&mut self) {
        // SAFETY: made by `rlv_osd_bfr_create`, freed once.
        unsafe { ffi::rlv_osd_bfr_free(self.handle) };
    }
}

fn check_grid(points_fit: bool, size: usize, buffer: &[f32]) -> Result<()> {
    if !points_fit || !(2..=4096).contains(&size) || buffer.len() < 9 * size * size {
        return Err(Error::invalid("the points do not fit the table, or the buffer holds less than one tile"));
    }
    Ok(())
}
