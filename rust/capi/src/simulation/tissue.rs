//! Models of soft tissue; see `include/relievo/tissue.h`.

mod build;
pub mod simulation;

use std::ffi::{c_char, c_void};
use std::path::{Path, PathBuf};
use std::sync::{Arc, RwLock};

use relievo_core::{Error, Result};
use relievo_tissue::{Binding, Held, Model, NodeSet};

pub use self::build::*;
pub use self::simulation::*;
use crate::border::array::{Input, Output, Plain, fixed, narrow, present, put, put_optional, text};
use crate::border::descriptor::{check_optional, write_descriptor, write_optional};
use crate::border::making::Making;
use crate::border::registry::{self, handle, try_read, try_write};
use crate::runtime::bytes::{self, RlvBytes};
use crate::runtime::context::{ContextObject, HostProgress, RLV_NAME_SIZE, RlvContext, RlvProgress};
use crate::surfaces::grid::{self, RlvGrid};
use crate::surfaces::mesh::RlvMesh;

handle!(RlvTissue, 28, TissueObject);

constants! {
    u32:
    RLV_TISSUE_HOLD = 0,
    RLV_TISSUE_SLIDE = 1,
    RLV_TISSUE_BIND = 2,
    RLV_TISSUE_FLOOR = 0,
    RLV_TISSUE_BALL = 1,
    RLV_TISSUE_MESH = 2,
}

descriptor! {
    pub struct RlvTissueInfo {
        struct_size: u32,
        has_cells: u32,
        node_count: usize,
        element_count: usize,
        cell: [f32; 3],
        low: [f32; 3],
        high: [f32; 3],
        material_count: u32,
        muscle_count: u32,
        set_count: u32,
        bound_count: u32,
        checksum: u32,
    }
}

descriptor! {
    pub struct RlvTissueMuscle {
        struct_size: u32,
        reserved: u32,
        stiffness: f32,
        strength: f32,
        name: [u8; RLV_NAME_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvTissueSet {
        struct_size: u32,
        reserved: u32,
        count: usize,
        name: [u8; RLV_NAME_SIZE as usize],
    }
}

/// A model and the context it belongs to.
pub struct TissueObject {
    pub context: Arc<ContextObject>,
    pub model: RwLock<Model>,
}

/// Registers a checked model.
///
/// # Errors
/// Fails with `Memory` if there are too many objects.
pub fn register(context: Arc<ContextObject>, model: Model) -> Result<RlvTissue> {
    registry::insert(TissueObject { context, model: RwLock::new(model) })
}

// SAFETY: eight integers without padding.
unsafe impl Plain for [u32; 8] {}

/// Returns an item of a list. Fails if it does not exist.
pub(crate) fn item<'a, T>(list: &'a [T], what: &str, index: u32) -> Result<&'a T> {
    list.get(index as usize).ok_or_else(|| {
        let error = Error::invalid(format!("{what} {index} does not exist")).at("index");
        error.advise(format!("there are {}, counted from 0", list.len()))
    })
}

/// Copies the numbers of nodes. Fails if one is `most` or more.
///
/// # Safety
/// `count` numbers can be read at `stride` bytes from one another.
pub(crate) unsafe fn nodes_of(nodes: *const u32, count: usize, stride: usize, most: usize) -> Result<Vec<u32>> {
    // SAFETY: promised by the caller.
    let nodes = unsafe { Input::new("nodes", nodes, count, stride) }?.to_vec("nodes", u64::MAX)?;
    match nodes.iter().find(|node| **node as usize >= most) {
        Some(node) => Err(Error::invalid(format!("node {node} does not exist"))
            .at("nodes")
            .advise(format!("the model has {most} nodes, counted from 0"))),
        None => Ok(nodes),
    }
}

/// Fails unless axes are a number of three bits.
pub(crate) fn check_axes(axes: u32) -> Result<()> {
    match axes {
        1..=7 => Ok(()),
        _ => Err(Error::invalid(format!("there are no axes {axes}"))
            .at("axes")
            .advise("use 1 for x, 2 for y, 4 for z, or sums of them")),
    }
}

/// Reads three numbers.
///
/// # Safety
/// `pointer` is NULL or has three numbers.
pub(crate) unsafe fn three<T: Plain>(name: &str, pointer: *const T) -> Result<[T; 3]> {
    // SAFETY: promised by the caller.
    let input = unsafe { Input::new(name, pointer, 3, 0) }?;
    Ok(std::array::from_fn(|axis| input.get(axis)))
}

/// Returns whether a path has an extension.
fn is_named(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// Reads which model is read.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a file that
/// cannot be read or is damaged, or `Cancelled`.
///
/// # Safety
/// `path` is NULL or a NUL-terminated text.
pub unsafe fn reading(context: RlvContext, path: *const c_char) -> Result<Making<RlvTissue>> {
    let context = registry::get(context)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(context.clone(), move |progress| {
        progress.step(0.0, "read")?;
        let model = if is_named(&path, "inp") {
            let read = Model::read_inp(&context.context, &path)?;
            read.notes.iter().for_each(|note| {
                context.log(crate::runtime::context::RLV_LOG_WARNING, &format!("{}: {note}", path.display()));
            });
            read.model
        } else {
            Model::read(&context.context, &path)?
        };
        progress.step(1.0, "read")?;
        register(context, model)
    }))
}

/// Reads where a model is written to.
///
/// # Errors
/// Fails with `Invalid` if the handle is not alive or the path is no text. What the work refuses, it returns: a model that
/// is busy, a file that cannot be written, or `Cancelled`.
///
/// # Safety
/// As for [`reading`].
pub unsafe fn writing(tissue: RlvTissue, path: *const c_char) -> Result<Making<()>> {
    let object = registry::get(tissue)?;
    // SAFETY: promised by the caller.
    let path = PathBuf::from(unsafe { text("path", path) }?);
    Ok(Making::new(object.context.clone(), move |progress| {
        let model = try_read(&object.model, "tissue")?;
        progress.step(0.0, "write")?;
        if is_named(&path, "inp") {
            model.write_inp(&path)?
        } else {
            model.write(&path)?
        }
        progress.report(1.0, "write");
        Ok(())
    }))
}

entry! {
    fn rlv_tissue_build(
        context: RlvContext,
        description: *const RlvTissueDescription,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvTissueReport,
        out: *mut RlvTissue,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size, with arrays of their counts.
        let building = unsafe {
            check_optional(report)?;
            Building::read(context, description)?
        };
        let (made, about) = building.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: as above.
        unsafe {
            put(out, made);
            write_optional(report, about)
        }
    }

    fn rlv_tissue_block(
        context: RlvContext,
        low: *const f64,
        cell: *const f32,
        counts: *const u32,
        material: *const RlvTissueMaterial,
        out: *mut RlvTissue,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or three numbers each, and NULL or a descriptor that starts with its size.
        let (low, cell, counts, material) = unsafe {
            (three("low", low)?, three("cell", cell)?, three("counts", counts)?, build::material(material)?)
        };
        let elements = counts.iter().map(|count| f64::from(*count)).product::<f64>();
        if elements * 300.0 > context.context.memory_limit() as f64 {
            return Err(Error::memory(format!("{elements} elements do not fit the memory limit"))
                .at("counts")
                .advise("take fewer, or raise the memory limit of the context"));
        }
        let made = register(context, Model::block(narrow(low), cell, counts, material)?)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_tissue_scan(
        context: RlvContext,
        path: *const c_char,
        labels: *const RlvTissueLabels,
        report: *mut RlvTissueReport,
        out: *mut RlvTissue,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives a NUL-terminated text, and NULL or descriptors that start with their size, with arrays of
        // their counts.
        let (path, labels) = unsafe {
            check_optional(report)?;
            (text("path", path)?, build::labels(labels)?)
        };
        let scan = relievo_tissue::Scan::read(&context.context, Path::new(path))?;
        let (model, about) = labels.build(&context.context, &scan)?;
        let made = register(context, model)?;
        // SAFETY: as above.
        unsafe {
            put(out, made);
            write_optional(report, build::report_of(about))
        }
    }

    fn rlv_tissue_from_grid(
        grid: RlvGrid,
        labels: *const RlvTissueLabels,
        report: *mut RlvTissueReport,
        out: *mut RlvTissue,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size, with arrays of their counts.
        let labels = unsafe {
            check_optional(report)?;
            build::labels(labels)?
        };
        let (context, scan) = grid::scan(grid)?;
        let (model, about) = labels.build(&context.context, &scan)?;
        let made = register(context, model)?;
        // SAFETY: as above.
        unsafe {
            put(out, made);
            write_optional(report, build::report_of(about))
        }
    }

    fn rlv_tissue_read(context: RlvContext, path: *const c_char, out: *mut RlvTissue) {
        present("out", out)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let made = unsafe { reading(context, path) }?.now()?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_tissue_write(tissue: RlvTissue, path: *const c_char) {
        // SAFETY: the caller gives a NUL-terminated text.
        unsafe { writing(tissue, path) }?.now()
    }

    fn rlv_tissue_read_bytes(context: RlvContext, bytes: *const u8, size: usize, out: *mut RlvTissue) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller promises `size` bytes.
        let bytes = unsafe { bytes::take(bytes, size, context.context.memory_limit()) }?;
        let made = register(context, Model::decode(&bytes).map_err(|error| error.at("bytes"))?)?;
        // SAFETY: checked above.
        unsafe { put(out, made) };
        Ok(())
    }

    fn rlv_tissue_write_bytes(tissue: RlvTissue, out: *mut RlvBytes) {
        present("out", out)?;
        let object = registry::get(tissue)?;
        let made = try_read(&object.model, "tissue")?.encode();
        // SAFETY: checked above.
        unsafe { bytes::give(made, out) }
    }

    fn rlv_tissue_retain(tissue: RlvTissue) {
        registry::retain(tissue)
    }

    fn rlv_tissue_release(tissue: RlvTissue) {
        registry::release(tissue)
    }

    fn rlv_tissue_info(tissue: RlvTissue, out: *mut RlvTissueInfo) {
        let object = registry::get(tissue)?;
        let model = try_read(&object.model, "tissue")?;
        let bound = |start: f32, choose: fn(f32, f32) -> f32| {
            model.nodes.iter().fold([start; 3], |sum, node| std::array::from_fn(|axis| choose(sum[axis], node[axis])))
        };
        let info = RlvTissueInfo {
            struct_size: 0,
            has_cells: model.cell.is_some().into(),
            node_count: model.nodes.len(),
            element_count: model.elements.len(),
            cell: model.cell.unwrap_or_default(),
            low: bound(f32::INFINITY, f32::min),
            high: bound(f32::NEG_INFINITY, f32::max),
            material_count: model.materials.len() as u32,
            muscle_count: model.muscles.len() as u32,
            set_count: model.sets.len() as u32,
            bound_count: model.bindings.len() as u32,
            checksum: model.checksum(),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, info) }
    }

    fn rlv_tissue_get_nodes(tissue: RlvTissue, nodes: *mut f32, count: usize, stride: usize) {
        let object = registry::get(tissue)?;
        let model = try_read(&object.model, "tissue")?;
        // SAFETY: the caller promises room for `count` nodes.
        let out = unsafe { Output::<[f32; 3]>::new("nodes", nodes.cast(), count, stride) }?;
        out.holds("nodes", model.nodes.len())?.fill(model.nodes.iter().copied());
        Ok(())
    }

    fn rlv_tissue_get_elements(tissue: RlvTissue, nodes: *mut u32, materials: *mut u32, count: usize) {
        let object = registry::get(tissue)?;
        let model = try_read(&object.model, "tissue")?;
        // SAFETY: the caller promises room for `count` elements in each array that is not NULL.
        let (corners, main) = unsafe {
            let corners = Output::<[u32; 8]>::optional("nodes", nodes.cast(), count, 0)?;
            (corners, Output::optional("materials", materials, count, 0)?)
        };
        let needed = model.elements.len();
        let corners = corners.map(|out| out.holds("nodes", needed)).transpose()?;
        let main = main.map(|out| out.holds("materials", needed)).transpose()?;
        if let Some(out) = corners {
            out.fill(model.elements.iter().copied());
        }
        if let Some(out) = main {
            out.fill(model.main_materials());
        }
        Ok(())
    }

    fn rlv_tissue_find_muscle(tissue: RlvTissue, name: *const c_char, out: *mut u32) {
        present("out", out)?;
        let object = registry::get(tissue)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let name = unsafe { text("name", name) }?;
        let index = try_read(&object.model, "tissue")?.muscle(name)?;
        // SAFETY: checked above.
        unsafe { put(out, index as u32) };
        Ok(())
    }

    fn rlv_tissue_muscle(tissue: RlvTissue, index: u32, out: *mut RlvTissueMuscle) {
        let object = registry::get(tissue)?;
        let model = try_read(&object.model, "tissue")?;
        let muscle = item(&model.muscles, "muscle", index)?;
        let made = RlvTissueMuscle {
            struct_size: 0,
            reserved: 0,
            stiffness: muscle.stiffness,
            strength: muscle.strength,
            name: fixed(&muscle.name),
        };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, made) }
    }

    fn rlv_tissue_find_set(tissue: RlvTissue, name: *const c_char, out: *mut u32) {
        present("out", out)?;
        let object = registry::get(tissue)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let name = unsafe { text("name", name) }?;
        let model = try_read(&object.model, "tissue")?;
        model.set(name)?;
        let index = model.sets.iter().position(|set| set.name == name).unwrap_or_default();
        // SAFETY: checked above.
        unsafe { put(out, index as u32) };
        Ok(())
    }

    fn rlv_tissue_set(tissue: RlvTissue, index: u32, out: *mut RlvTissueSet) {
        let object = registry::get(tissue)?;
        let model = try_read(&object.model, "tissue")?;
        let set = item(&model.sets, "set", index)?;
        let made = RlvTissueSet { struct_size: 0, reserved: 0, count: set.nodes.len(), name: fixed(&set.name) };
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        unsafe { write_descriptor(out, made) }
    }

    fn rlv_tissue_get_set(tissue: RlvTissue, index: u32, nodes: *mut u32, count: usize) {
        let object = registry::get(tissue)?;
        let model = try_read(&object.model, "tissue")?;
        let set = item(&model.sets, "set", index)?;
        // SAFETY: the caller promises room for `count` nodes.
        let out = unsafe { Output::new("nodes", nodes, count, 0) }?.holds("nodes", set.nodes.len())?;
        out.fill(set.nodes.iter().copied());
        Ok(())
    }

    fn rlv_tissue_add_set(tissue: RlvTissue, name: *const c_char, low: *const f64, high: *const f64, out: *mut u32) {
        present("out", out)?;
        let object = registry::get(tissue)?;
        // SAFETY: the caller gives a NUL-terminated text, and NULL or three numbers each.
        let (name, low, high) = unsafe { (text("name", name)?, three("low", low)?, three("high", high)?) };
        let mut model = try_write(&object.model, "tissue")?;
        if model.sets.iter().any(|set| set.name == name) {
            return Err(Error::invalid(format!("there is a set `{name}` already")).at("name").advise("use another name"));
        }
        let nodes = model.nodes_within(narrow(low), narrow(high));
        if nodes.is_empty() {
            return Err(Error::invalid("no node is within the box").advise("take a larger box, in metres"));
        }
        model.sets.push(NodeSet { name: name.to_owned(), nodes });
        // SAFETY: checked above.
        unsafe { put(out, model.sets.len() as u32 - 1) };
        Ok(())
    }

    fn rlv_tissue_hold(tissue: RlvTissue, nodes: *const u32, count: usize, stride: usize, axes: u32) {
        let object = registry::get(tissue)?;
        check_axes(axes)?;
        let mut model = try_write(&object.model, "tissue")?;
        // SAFETY: the caller promises `count` nodes.
        let nodes = unsafe { nodes_of(nodes, count, stride, model.nodes.len()) }?;
        model.held.extend(nodes.into_iter().map(|node| Held { node, axes }));
        Ok(())
    }

    fn rlv_tissue_bind(tissue: RlvTissue, mesh: RlvMesh, name: *const c_char, out: *mut u32) {
        let object = registry::get(tissue)?;
        let mesh = registry::get(mesh)?;
        // SAFETY: the caller gives a NUL-terminated text.
        let name = unsafe { text("name", name) }?;
        let mut model = try_write(&object.model, "tissue")?;
        let binding = {
            let mesh = try_read(&mesh.mesh, "mesh")?;
            Binding::new(&object.context.context, &model, name, &mesh.points, &mesh.triangles())?
        };
        model.bindings.push(binding);
        // SAFETY: the caller promises a place, or NULL.
        unsafe { put_optional(out, model.bindings.len() as u32 - 1) };
        Ok(())
    }
}
