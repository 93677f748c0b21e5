//! A grid in memory, its facts, transform and metadata.

use std::ffi::CString;
use std::sync::OnceLock;

use relievo_core::{Error, Result};

use crate::abi;
use crate::call;
use crate::info::{Class, Entry, GridInfo, Kind};
use crate::module::Module;
use crate::transform::Transform;

/// A sparse grid of OpenVDB.
#[derive(Debug)]
pub struct Grid {
    pointer: *mut abi::RlvdbGrid,
    /// Kept, since all facts together take a walk through the tree.
    kind: OnceLock<Kind>,
}

// SAFETY: a grid is owned by its handle alone and has no tie to the thread that made it.
unsafe impl Send for Grid {}
// SAFETY: calls through a shared reference only read the grid, which OpenVDB allows at the same time: its leaves are read
// from files at once, never later.
unsafe impl Sync for Grid {}

/// A camera's frustum: a box in voxels becomes a pyramid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// The box in voxels, lowest and highest corner.
    pub voxels: [[f64; 3]; 2],
    /// The width of the near plane over that of the far plane.
    pub taper: f64,
    /// The depth of the pyramid over the width of its near plane.
    pub depth: f64,
}

/// Runs a call of the module that has no progress.
fn short(call: impl FnOnce(&mut abi::RlvdbError) -> i32) -> Result<()> {
    let mut error = call::record();
    let result = call(&mut error);
    call::check(result, &error)
}

/// Returns a text with a zero behind it.
pub(crate) fn zero_ended(name: &str, text: &str) -> Result<CString> {
    CString::new(text).map_err(|_| Error::invalid("the text has a zero in it").at(name))
}

impl Grid {
    /// Makes an empty grid. `background` is the value outside of all leaves; of scalars its first number counts. `voxel` is
    /// the edge of a voxel in world units.
    ///
    /// # Errors
    /// Fails with `Unsupported` if the kind is points, with `Invalid` if the size is not positive and finite, and as
    /// [`Module::open`] does.
    pub fn new(kind: Kind, background: [f64; 3], voxel: f64) -> Result<Self> {
        if kind == Kind::Points {
            return Err(
                Error::unsupported("a grid of points is not made here").advise("write particles to a .vdb file")
            );
        }
        let module = Module::open()?;
        Self::made(|out, error| {
            // SAFETY: three numbers are read, and both outputs live through the call.
            unsafe { module.table().rlvdb_grid_new(kind as i32, background.as_ptr(), voxel, out, error) }
        })
    }

    /// Takes a grid that the module hands out.
    fn made(call: impl FnOnce(*mut *mut abi::RlvdbGrid, &mut abi::RlvdbError) -> i32) -> Result<Self> {
        let mut pointer = std::ptr::null_mut();
        short(|error| call(&mut pointer, error))?;
        Self::of_pointer(pointer)
    }

    pub(crate) fn of_pointer(pointer: *mut abi::RlvdbGrid) -> Result<Self> {
        if pointer.is_null() {
            Err(Error::internal("the module returned no grid"))
        } else {
            Ok(Self { pointer, kind: OnceLock::new() })
        }
    }

    pub(crate) fn pointer(&self) -> *const abi::RlvdbGrid {
        self.pointer
    }

    pub(crate) fn pointer_mut(&mut self) -> *mut abi::RlvdbGrid {
        self.pointer
    }

    /// Copies it.
    ///
    /// # Errors
    /// Fails with `Memory` if memory runs out.
    pub fn copy(&self) -> Result<Self> {
        let module = Module::open()?;
        // SAFETY: the grid is alive, and both outputs live through the call.
        Self::made(|out, error| unsafe { module.table().rlvdb_grid_copy(self.pointer, out, error) })
    }

    /// Returns its facts.
    ///
    /// # Errors
    /// Fails with `Internal` if the module returns a kind of grids that does not exist, and with `Memory` if memory
    /// runs out.
    pub fn info(&self) -> Result<GridInfo> {
        let mut metadata = self.metadata()?;
        metadata.sort_by(|a, b| a.name.cmp(&b.name));
        GridInfo::of_abi(&self.facts()?, metadata)
    }

    fn facts(&self) -> Result<abi::RlvdbInfo> {
        let module = Module::open()?;
        let mut info = std::mem::MaybeUninit::uninit();
        // SAFETY: the grid is alive, and both outputs live through the call.
        short(|error| unsafe { module.table().rlvdb_grid_info(self.pointer, info.as_mut_ptr(), error) })?;
        // SAFETY: the call succeeded, so it wrote all of it.
        Ok(unsafe { info.assume_init() })
    }

    /// Returns the kind of its values.
    ///
    /// # Errors
    /// Fails with `Internal` if the module returns a kind of grids that does not exist.
    pub fn kind(&self) -> Result<Kind> {
        if let Some(kind) = self.kind.get() {
            return Ok(*kind);
        }
        let kind = Kind::of_number(self.facts()?.kind)?;
        Ok(*self.kind.get_or_init(|| kind))
    }

    /// Returns the value outside of all leaves; of scalars the first number counts.
    ///
    /// # Errors
    /// Fails only on an exception of OpenVDB, as for want of memory.
    pub fn background(&self) -> Result<[f64; 3]> {
        Ok(self.facts()?.background)
    }

    /// Says what its values mean.
    ///
    /// # Errors
    /// Fails with `Memory` if the module has no memory for the entry of metadata.
    pub fn set_class(&mut self, class: Class) -> Result<()> {
        let module = Module::open()?;
        // SAFETY: the grid is alive and ours alone, and the error record lives through the call.
        short(|error| unsafe { module.table().rlvdb_set_class(self.pointer, class as i32, error) })
    }

    /// Has its numbers written with 16 bits.
    ///
    /// # Errors
    /// Fails with `Memory` if the module has no memory for the entry of metadata.
    pub fn set_half(&mut self, is_half: bool) -> Result<()> {
        let module = Module::open()?;
        // SAFETY: the grid is alive and ours alone, and the error record lives through the call.
        short(|error| unsafe { module.table().rlvdb_set_half(self.pointer, is_half.into(), error) })
    }

    /// Sets the map from voxels to the world.
    ///
    /// # Errors
    /// Fails with `Invalid` if it is a frustum, is not finite, or has no inverse.
    pub fn set_transform(&mut self, transform: &Transform) -> Result<()> {
        transform.check()?;
        if !transform.is_linear {
            return Err(Error::invalid("a frustum is set by set_frustum").at("transform"));
        }
        let module = Module::open()?;
        let numbers = transform.numbers();
        // SAFETY: the grid is alive and ours alone, sixteen numbers are read, and the record lives through the call.
        short(|error| unsafe { module.table().rlvdb_set_matrix(self.pointer, numbers.as_ptr(), error) })
    }

    /// Makes its transform a frustum, whose pyramid the affine map `after` follows.
    ///
    /// # Errors
    /// Fails with `Invalid` if the box is empty, the taper or the depth is not positive and finite, or `after` is not
    /// finite or has no inverse.
    pub fn set_frustum(&mut self, frustum: &Frustum, after: &Transform) -> Result<()> {
        after.check()?;
        let Frustum { voxels: [low, high], taper, depth } = *frustum;
        let is_box = (0..3).all(|axis| low[axis].is_finite() && high[axis].is_finite() && low[axis] < high[axis]);
        if !is_box || !(taper > 0.0 && taper.is_finite() && depth > 0.0 && depth.is_finite()) {
            return Err(Error::invalid("the frustum has no volume")
                .at("frustum")
                .advise("use a box, a taper and a depth above 0"));
        }
        let module = Module::open()?;
        let (ends, numbers) = ([low, high], after.numbers());
        let (ends, matrix) = (ends.as_flattened().as_ptr(), numbers.as_ptr());
        // SAFETY: the grid is alive and ours alone, six and sixteen numbers are read, and the record lives through the call.
        short(|error| unsafe { module.table().rlvdb_set_frustum(self.pointer, ends, taper, depth, matrix, error) })
    }

    /// Returns its metadata.
    ///
    /// # Errors
    /// Fails only on an exception of OpenVDB, as for want of memory.
    pub fn metadata(&self) -> Result<Vec<Entry>> {
        let module = Module::open()?;
        let mut count = 0;
        // SAFETY: the grid is alive, and both outputs live through the call.
        short(|error| unsafe { module.table().rlvdb_metadata_count(self.pointer, &mut count, error) })?;
        (0..count).map(|index| self.entry(module, index)).collect()
    }

    fn entry(&self, module: &Module, index: usize) -> Result<Entry> {
        let (mut name, mut kind, mut value) = (vec![0; 1024], vec![0; 64], vec![0; 1 << 16]);
        // SAFETY: the grid is alive, and the buffers are as long as stated and live through the call.
        short(|error| unsafe {
            let (name_at, name_size) = (name.as_mut_ptr(), name.len());
            let (kind_at, kind_size) = (kind.as_mut_ptr(), kind.len());
            let (value_at, value_size) = (value.as_mut_ptr(), value.len());
            let grid = self.pointer;
            let table = module.table();
            table.rlvdb_metadata_get(grid, index, name_at, name_size, kind_at, kind_size, value_at, value_size, error)
        })?;
        Ok(Entry { name: call::text(&name), kind: call::text(&kind), value: call::text(&value) })
    }

    /// Sets an entry of metadata. Its kind is `string`, `bool`, `int32`, `int64`, `float` or `double`.
    ///
    /// # Errors
    /// Fails with `Invalid` if the value is not one of its kind, the kind is another, or a text holds a zero byte.
    pub fn set_metadata(&mut self, entry: &Entry) -> Result<()> {
        let is_sound = match entry.kind.as_str() {
            "string" => true,
            "bool" => matches!(entry.value.as_str(), "true" | "false"),
            "int32" => entry.value.parse::<i32>().is_ok(),
            "int64" => entry.value.parse::<i64>().is_ok(),
            "float" | "double" => entry.value.parse::<f64>().is_ok_and(f64::is_finite),
            _ => false,
        };
        if !is_sound {
            let error = Error::invalid(format!("{:?} is not of the type {:?}", entry.value, entry.kind));
            return Err(error.at(&entry.name).advise("use string, bool, int32, int64, float or double"));
        }
        let module = Module::open()?;
        let name = zero_ended("name", &entry.name)?;
        let (kind, value) = (zero_ended("kind", &entry.kind)?, zero_ended("value", &entry.value)?);
        // SAFETY: the grid is alive and ours alone, and the texts and the record live through the call.
        short(|error| unsafe {
            let (name, kind, value) = (name.as_ptr(), kind.as_ptr(), value.as_ptr());
            module.table().rlvdb_metadata_set(self.pointer, name, kind, value, error)
        })
    }

    /// Names it.
    ///
    /// # Errors
    /// Fails with `Invalid` if the name holds a zero byte.
    pub fn set_name(&mut self, name: &str) -> Result<()> {
        self.set_metadata(&Entry { name: "name".into(), kind: "string".into(), value: name.into() })
    }
}

impl Drop for Grid {
    fn drop(&mut self) {
        // The module is open, since it made the grid.
        if let Ok(module) = Module::open() {
            // SAFETY: the grid came from the module and is freed once.
            unsafe { module.table().rlvdb_grid_free(self.pointer) }
        }
    }
}
