//! Binding to OpenVDB: level sets from meshes, against which voxelisation is tested and timed, and grids in files, with which
//! those are tested that are written and read here.

mod points;

use std::ffi::{CString, c_char, c_int, c_void};
use std::path::Path;

use relievo_core::{Error, Result};

pub use self::points::{Points, read_points, write_points};

unsafe extern "C" {
    fn relievo_level_set_new(
        points: *const f32,
        point_count: usize,
        triangles: *const u32,
        triangle_count: usize,
        band: f32,
        message: *mut c_char,
        message_size: usize,
    ) -> *mut c_void;
    fn relievo_level_set_read(path: *const c_char, message: *mut c_char, message_size: usize) -> *mut c_void;
    fn relievo_level_set_facts(
        level_set: *const c_void,
        facts: *mut f64,
        message: *mut c_char,
        message_size: usize,
    ) -> c_int;
    fn relievo_level_set_values(
        level_set: *const c_void,
        voxels: *const i32,
        count: usize,
        values: *mut f32,
        message: *mut c_char,
        message_size: usize,
    ) -> c_int;
    fn relievo_level_set_write(
        level_set: *const c_void,
        path: *const c_char,
        voxel: f64,
        origin: *const f64,
        packing: u32,
        is_half: c_int,
        is_fog: c_int,
        message: *mut c_char,
        message_size: usize,
    ) -> c_int;
    fn relievo_level_set_free(level_set: *mut c_void);
}

/// What OpenVDB is told to pack values by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Packing {
    /// By zlib.
    pub zip: bool,
    /// Values of active voxels alone, where the others are one or two.
    pub active: bool,
    /// By Blosc.
    pub blosc: bool,
}

impl Packing {
    fn bits(self) -> u32 {
        u32::from(self.zip) | u32::from(self.active) << 1 | u32::from(self.blosc) << 2
    }
}

/// How a grid is written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Writing {
    /// Edge of a voxel.
    pub voxel: f64,
    /// Where voxel 0 is.
    pub origin: [f64; 3],
    /// How values are packed.
    pub packing: Packing,
    /// Values have 16 bits.
    pub is_half: bool,
    /// It is made a fog volume, 1 inside.
    pub is_fog: bool,
}

/// A narrow-band signed distance field of a triangle mesh on the integer lattice.
#[derive(Debug)]
pub struct LevelSet {
    pointer: *mut c_void,
}

// SAFETY: the grid is owned by this handle alone and has no tie to the thread that made it.
unsafe impl Send for LevelSet {}

/// What a level set is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facts {
    /// Edge of a voxel.
    pub voxel: f64,
    /// The value where nothing is said.
    pub background: f64,
    /// How many voxels are active.
    pub active: u64,
    /// Whether it is said to be a level set, of voxels that are cubes.
    pub is_level_set: bool,
}

/// Room for the message of an exception.
type Message = [u8; 256];

fn failure(message: &Message) -> Error {
    let end = message.iter().position(|byte| *byte == 0).unwrap_or(message.len());
    Error::internal(format!("OpenVDB: {}", String::from_utf8_lossy(&message[..end])))
}

fn name_of(path: &Path) -> Result<CString> {
    let name = CString::new(path.as_os_str().as_encoded_bytes());
    name.map_err(|_| Error::invalid("the name of the file has a zero in it"))
}

impl LevelSet {
    /// The level set of a mesh given in voxel coordinates, `band` voxels wide on either side.
    ///
    /// Fails if a triangle refers to a point that does not exist or OpenVDB throws.
    pub fn of_mesh(points: &[[f32; 3]], triangles: &[[u32; 3]], band: f32) -> Result<Self> {
        if let Some(index) = triangles.iter().position(|triangle| triangle.iter().any(|p| *p as usize >= points.len()))
        {
            return Err(Error::invalid("a point does not exist").at(format!("triangle {index}")));
        }
        let mut message: Message = [0; 256];
        // SAFETY: the arrays live through the call and are as long as said; every index was checked above; the message
        // buffer is as large as said. Exceptions are caught on the other side.
        let pointer = unsafe {
            relievo_level_set_new(
                points.as_ptr().cast(),
                points.len(),
                triangles.as_ptr().cast(),
                triangles.len(),
                band,
                message.as_mut_ptr().cast(),
                message.len(),
            )
        };
        if pointer.is_null() { Err(failure(&message)) } else { Ok(Self { pointer }) }
    }

    /// The only grid of a file, of floats.
    ///
    /// Fails if the file has another one, or OpenVDB throws.
    pub fn read(path: &Path) -> Result<Self> {
        let name = name_of(path)?;
        let mut message: Message = [0; 256];
        // SAFETY: the name ends with a zero and lives through the call, and the message buffer is as large as said.
        // Exceptions are caught on the other side.
        let pointer = unsafe { relievo_level_set_read(name.as_ptr(), message.as_mut_ptr().cast(), message.len()) };
        if pointer.is_null() { Err(failure(&message)) } else { Ok(Self { pointer }) }
    }

    /// Writes it as the only grid of a file, called `cloud`.
    ///
    /// Fails if OpenVDB throws.
    pub fn write(&self, path: &Path, writing: &Writing) -> Result<()> {
        let name = name_of(path)?;
        let mut message: Message = [0; 256];
        let Writing { voxel, origin, packing, is_half, is_fog } = *writing;
        // SAFETY: the handle is alive, the name ends with a zero, there are three numbers of the origin, all live through the
        // call, and the message buffer is as large as said.
        let status = unsafe {
            relievo_level_set_write(
                self.pointer,
                name.as_ptr(),
                voxel,
                origin.as_ptr(),
                packing.bits(),
                is_half.into(),
                is_fog.into(),
                message.as_mut_ptr().cast(),
                message.len(),
            )
        };
        if status == 0 { Ok(()) } else { Err(failure(&message)) }
    }

    /// What it is.
    pub fn facts(&self) -> Result<Facts> {
        let mut facts = [0.0; 4];
        let mut message: Message = [0; 256];
        // SAFETY: the handle is alive, four numbers are written, and the message buffer is as large as said.
        let status = unsafe {
            relievo_level_set_facts(self.pointer, facts.as_mut_ptr(), message.as_mut_ptr().cast(), message.len())
        };
        let [voxel, background, active, is_level_set] = facts;
        match status {
            0 => Ok(Facts { voxel, background, active: active as u64, is_level_set: is_level_set == 1.0 }),
            _ => Err(failure(&message)),
        }
    }

    /// The values at lattice points; of meshes distances in voxels, negative inside, clamped to the band.
    pub fn values(&self, voxels: &[[i32; 3]]) -> Result<Vec<f32>> {
        let mut values = vec![0.0; voxels.len()];
        let mut message: Message = [0; 256];
        // SAFETY: the handle is alive, both arrays have `voxels.len()` elements, and so is the message buffer as said.
        let status = unsafe {
            relievo_level_set_values(
                self.pointer,
                voxels.as_ptr().cast(),
                voxels.len(),
                values.as_mut_ptr(),
                message.as_mut_ptr().cast(),
                message.len(),
            )
        };
        if status == 0 { Ok(values) } else { Err(failure(&message)) }
    }
}

impl Drop for LevelSet {
    fn drop(&mut self) {
        // SAFETY: the handle came from `relievo_level_set_new` and is freed once.
        unsafe { relievo_level_set_free(self.pointer) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_is_negative_inside_and_bad_indices_are_refused() {
        let points: Vec<[f32; 3]> =
            (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { 2.0 } else { 20.0 })).collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let level_set = LevelSet::of_mesh(&points, &triangles, 3.0).unwrap();
        let values = level_set.values(&[[11, 11, 11], [0, 0, 0], [3, 11, 11], [30, 30, 30]]).unwrap();
        assert!(
            values[0] == -3.0 && values[1] > 1.9 && (values[2] + 1.0).abs() < 1e-4 && values[3] == 3.0,
            "{values:?}"
        );
        assert!(LevelSet::of_mesh(&points, &[[0, 1, 8]], 3.0).is_err());
    }
}
