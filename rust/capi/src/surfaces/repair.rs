//! Checks and repairs of meshes; see `include/relievo/repair.h`.

use std::ffi::{c_char, c_void};
use std::path::Path;
use std::sync::{Arc, OnceLock};

use relievo_core::{Attribute, Mesh, Progress, Result};
use relievo_repair::{Element, Finding, RepairSettings, Repaired, Report, Topology, check, repair};

use crate::border::array::{present, put, text};
use crate::border::descriptor::{check_descriptor, check_optional, read_descriptor, write_descriptor, write_optional};
use crate::border::registry::{self, try_read};
use crate::runtime::context::{ContextObject, HostProgress, RlvContext, RlvProgress};
use crate::runtime::parameter::{RlvParameter, Table, settings, write_table};
use crate::surfaces::mesh::{self, MeshObject, RlvAttributeArrays, RlvMesh, RlvMeshArrays};

settings!(RlvRepairSettings, RepairSettings);

descriptor! {
    pub struct RlvRepairFinding {
        count: usize,
        first: [u32; 16],
    }
}

descriptor! {
    pub struct RlvRepairTopology {
        points: usize,
        faces: usize,
        edges: usize,
        boundary_edges: usize,
        boundary_loops: usize,
        non_manifold_edges: usize,
        components: usize,
        closed_components: usize,
        euler: i32,
        reserved: u32,
        area: f64,
        volume: f64,
    }
}

descriptor! {
    pub struct RlvRepairReport {
        struct_size: u32,
        is_solid: u32,
        invalid_faces: RlvRepairFinding,
        coincident_points: RlvRepairFinding,
        unused_points: RlvRepairFinding,
        degenerate_faces: RlvRepairFinding,
        flat_faces: RlvRepairFinding,
        duplicate_faces: RlvRepairFinding,
        non_manifold_edges: RlvRepairFinding,
        non_manifold_points: RlvRepairFinding,
        misoriented_edges: RlvRepairFinding,
        one_sided_edges: RlvRepairFinding,
        inverted_components: RlvRepairFinding,
        holes: RlvRepairFinding,
        open_holes: RlvRepairFinding,
        before: RlvRepairTopology,
        after: RlvRepairTopology,
        turned_faces: usize,
        split_points: usize,
        filled_holes: usize,
        filling_points: usize,
        filling_faces: usize,
        seam_attributes: usize,
    }
}

impl From<&Finding> for RlvRepairFinding {
    fn from(finding: &Finding) -> Self {
        let mut first = [u32::MAX; 16];
        for (pair, element) in first.as_chunks_mut::<2>().0.iter_mut().zip(&finding.first) {
            *pair = match element {
                Element::Point(number) | Element::Face(number) => [*number, u32::MAX],
                Element::Edge(points) => *points,
            };
        }
        Self { count: finding.count, first }
    }
}

impl From<&Topology> for RlvRepairTopology {
    fn from(topology: &Topology) -> Self {
        Self {
            points: topology.points,
            faces: topology.faces,
            edges: topology.edges,
            boundary_edges: topology.boundary_edges,
            boundary_loops: topology.boundary_loops,
            non_manifold_edges: topology.non_manifold_edges,
            components: topology.components,
            closed_components: topology.closed_components,
            // 2³¹ corners are the most that a mesh under repair has.
            euler: i32::try_from(topology.euler).unwrap_or(i32::MIN),
            reserved: 0,
            area: topology.area,
            volume: topology.volume,
        }
    }
}

impl From<&Report> for RlvRepairReport {
    fn from(report: &Report) -> Self {
        Self {
            struct_size: 0,
            is_solid: u32::from(report.is_solid()),
            invalid_faces: (&report.invalid_faces).into(),
            coincident_points: (&report.coincident_points).into(),
            unused_points: (&report.unused_points).into(),
            degenerate_faces: (&report.degenerate_faces).into(),
            flat_faces: (&report.flat_faces).into(),
            duplicate_faces: (&report.duplicate_faces).into(),
            non_manifold_edges: (&report.non_manifold_edges).into(),
            non_manifold_points: (&report.non_manifold_points).into(),
            misoriented_edges: (&report.misoriented_edges).into(),
            one_sided_edges: (&report.one_sided_edges).into(),
            inverted_components: (&report.inverted_components).into(),
            holes: (&report.holes).into(),
            open_holes: (&report.open_holes).into(),
            before: (&report.before).into(),
            after: (&report.after).into(),
            turned_faces: report.turned_faces,
            split_points: report.split_points,
            filled_holes: report.filled_holes,
            filling_points: report.filling_points,
            filling_faces: report.filling_faces,
            seam_attributes: report.seam_attributes.len(),
        }
    }
}

/// A mesh to be repaired, and how.
pub struct RepairJob {
    object: Arc<MeshObject>,
    settings: RepairSettings,
}

impl RepairJob {
    /// Reads the settings.
    ///
    /// # Errors
    /// Fails with `Invalid` if the handle is not alive or a setting is out of range.
    ///
    /// # Safety
    /// `settings` is NULL or a descriptor that starts with its size.
    pub unsafe fn read(mesh: RlvMesh, settings: *const RlvRepairSettings) -> Result<Self> {
        let object = registry::get(mesh)?;
        // SAFETY: promised by the caller.
        let settings = unsafe { RlvRepairSettings::read(settings) }?;
        Ok(Self { object, settings })
    }

    pub fn context(&self) -> &Arc<ContextObject> {
        &self.object.context
    }

    /// Makes the repaired mesh.
    ///
    /// # Errors
    /// Fails with `Busy` if the mesh is being changed, with `Invalid` if nothing usable is left of it, with `Memory` if
    /// the host refuses the bytes of the mesh, and with `Cancelled` if `progress` asks to stop.
    pub fn run(&self, progress: &mut dyn Progress) -> Result<(RlvMesh, RlvRepairReport)> {
        let mesh = try_read(&self.object.mesh, "mesh")?;
        register(self.context(), &mesh, &self.settings, progress)
    }
}

/// Copies attributes whose descriptors follow each other as far apart as their sizes say.
///
/// # Safety
/// `first` is NULL or `count` descriptors that start with their size, with arrays as `mesh.h` demands.
unsafe fn read_attributes(first: *const RlvAttributeArrays, count: usize, limit: u64) -> Result<Vec<Attribute>> {
    let mut attributes = Vec::new();
    let mut at = first;
    for _ in 0..count {
        // SAFETY: promised by the caller; the first read refuses NULL.
        unsafe {
            let arrays = read_descriptor(at, std::mem::zeroed())?;
            attributes.push(mesh::copy_attribute(&arrays, limit)?);
            at = at.byte_add(at.cast::<u32>().read_unaligned() as usize);
        }
    }
    Ok(attributes)
}

/// Repairs a mesh and registers the result.
fn register(
    context: &Arc<ContextObject>,
    mesh: &Mesh,
    settings: &RepairSettings,
    progress: &mut dyn Progress,
) -> Result<(RlvMesh, RlvRepairReport)> {
    let Repaired { mesh, report, .. } = repair(&context.context, mesh, settings, progress)?;
    mesh.check()?;
    Ok((mesh::register(context.clone(), mesh)?, (&report).into()))
}

entry! {
    fn rlv_repair_params(params: *mut *const RlvParameter, count: *mut usize) {
        static TABLE: OnceLock<Table> = OnceLock::new();
        // SAFETY: the caller gives pointers to which a value may be written, or NULL.
        unsafe { write_table(&TABLE, RepairSettings::PARAMETERS, params, count) }
    }

    fn rlv_repair_check(
        mesh: RlvMesh,
        settings: *const RlvRepairSettings,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvRepairReport,
    ) {
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let job = unsafe {
            check_descriptor(report)?;
            RepairJob::read(mesh, settings)?
        };
        let mesh = try_read(&job.object.mesh, "mesh")?;
        let found = check(&job.context().context, &mesh, &job.settings, &mut HostProgress { callback: progress, user })?;
        // SAFETY: as above.
        unsafe { write_descriptor(report, (&found).into()) }
    }

    fn rlv_repair_mesh(
        mesh: RlvMesh,
        settings: *const RlvRepairSettings,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvRepairReport,
        out: *mut RlvMesh,
    ) {
        present("out", out)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size.
        let job = unsafe {
            check_optional(report)?;
            RepairJob::read(mesh, settings)?
        };
        let (made, found) = job.run(&mut HostProgress { callback: progress, user })?;
        // SAFETY: both were checked above.
        unsafe {
            put(out, made);
            write_optional(report, found)
        }
    }

    fn rlv_repair_arrays(
        context: RlvContext,
        arrays: *const RlvMeshArrays,
        attributes: *const RlvAttributeArrays,
        attribute_count: usize,
        settings: *const RlvRepairSettings,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvRepairReport,
        out: *mut RlvMesh,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        let limit = context.context.memory_limit();
        // SAFETY: the caller gives NULL or descriptors that start with their size, with arrays of their counts.
        let (mesh, settings) = unsafe {
            check_optional(report)?;
            let mut mesh = mesh::read_arrays(arrays, limit)?;
            mesh.attributes = read_attributes(attributes, attribute_count, limit)?;
            (mesh, RlvRepairSettings::read(settings)?)
        };
        let (made, found) = register(&context, &mesh, &settings, &mut HostProgress { callback: progress, user })?;
        // SAFETY: both were checked above.
        unsafe {
            put(out, made);
            write_optional(report, found)
        }
    }

    fn rlv_repair_read(
        context: RlvContext,
        path: *const c_char,
        settings: *const RlvRepairSettings,
        progress: RlvProgress,
        user: *mut c_void,
        report: *mut RlvRepairReport,
        out: *mut RlvMesh,
    ) {
        present("out", out)?;
        let context = registry::get(context)?;
        // SAFETY: the caller gives NULL or descriptors that start with their size, and NULL or a NUL-terminated text.
        let (path, settings) = unsafe {
            check_optional(report)?;
            (text("path", path)?, RlvRepairSettings::read(settings)?)
        };
        let mesh = relievo_meshio::read(&context.context, Path::new(path))?;
        let (made, found) = register(&context, &mesh, &settings, &mut HostProgress { callback: progress, user })
            .map_err(|error| error.at(path))?;
        // SAFETY: both were checked above.
        unsafe {
            put(out, made);
            write_optional(report, found)
        }
    }
}
