//! The steps of a check and of a repair.

use relievo_core::{Attribute, Context, Domain, Error, Mesh, Progress, Result};

use crate::attributes::{self, Assembled};
use crate::corners::Corners;
use crate::edges::Edges;
use crate::orient::Components;
use crate::report::{Finding, Report};
use crate::settings::RepairSettings;
use crate::topology::{self, Topology};
use crate::{fans, holes, orient, pairs, sift, weld};

/// Stages of splits until all faces around the edges at fault are cut apart.
const MAX_SPLITS: usize = 16;

/// A repaired mesh.
#[derive(Clone, Debug, Default)]
pub struct Repaired {
    /// The mesh.
    pub mesh: Mesh,
    /// What was found and changed.
    pub report: Report,
    /// The point of the input that each point is or is a copy of; `u32::MAX` for points of fillings.
    pub point_origins: Vec<u32>,
    /// The face of the input whose attributes each face has: itself, or the one beside a filling.
    pub face_origins: Vec<u32>,
}

/// Reports what is wrong with a mesh, as a repair with the same settings would find it.
///
/// Unlike elsewhere, faces may repeat points, use points that do not exist, or have fewer than three corners, and
/// coordinates need not be finite.
///
/// # Errors
/// Face sizes, attributes or tags do not fit the mesh, a setting is out of range, the mesh takes more than the memory
/// limit of the context, or the caller cancels.
pub fn check(context: &Context, mesh: &Mesh, settings: &RepairSettings, progress: &mut dyn Progress) -> Result<Report> {
    let mut work = Work::new(context, mesh, settings, progress)?;
    work.report.after = work.report.before.clone();
    work.orient(context, settings, progress)?;
    work.report.turned_faces = 0;
    work.report.split_points = 0;
    Ok(work.report)
}

/// Repairs a mesh. What [`check`] accepts is accepted.
///
/// # Errors
/// As [`check`], and if nothing is left of the mesh.
pub fn repair(
    context: &Context,
    mesh: &Mesh,
    settings: &RepairSettings,
    progress: &mut dyn Progress,
) -> Result<Repaired> {
    let mut work = Work::new(context, mesh, settings, progress)?;
    let components = work.orient(context, settings, progress)?;
    let Work { mut corners, mut edges, mut turned, joined, mut report } = work;
    if settings.fill.is_on() {
        let parts = (&edges, &components);
        holes::fill(context, &mut corners, parts, settings, &mut report, progress, [0.5, 0.8])?;
    } else {
        report.open_holes = report.holes.clone();
    }
    if corners.face_count() == 0 {
        return Err(Error::invalid("no face is left of the mesh")
            .advise("check that its faces have three different points with finite coordinates"));
    }
    progress.step(0.8, "measuring")?;
    // Anew, and not from what the steps kept: the report then says what the mesh is.
    edges = Edges::of(context, &corners);
    let components = match settings.orient.is_on() {
        // What fillings have closed has an outside now.
        true => outward(context, &mut corners, &mut edges, &mut turned, &mut report, settings.listed),
        false => Components::of(context, &corners, &edges),
    };
    report.after = Topology::of(&corners, &edges, &components);
    drop((edges, components));
    progress.step(0.9, "carrying attributes over")?;
    report.seam_attributes = attributes::seams(mesh, &joined);
    let drop_unused = settings.unused.is_on();
    let made = attributes::assemble(mesh, corners, &joined, &report.seam_attributes, drop_unused);
    let Assembled { mesh, point_origins, face_origins } = made;
    progress.step(1.0, "repaired")?;
    Ok(Repaired { mesh, report, point_origins, face_origins })
}

/// A mesh under repair.
struct Work {
    corners: Corners,
    edges: Edges,
    /// Whether each face was turned over.
    turned: Vec<bool>,
    /// The point that each point of the input was welded to.
    joined: Vec<u32>,
    report: Report,
}

impl Work {
    /// Welds points, drops faces and finds edges.
    fn new(context: &Context, mesh: &Mesh, settings: &RepairSettings, progress: &mut dyn Progress) -> Result<Self> {
        settings.check()?;
        check_sizes(mesh)?;
        reserve(context, mesh)?;
        let listed = settings.listed;
        let mut report = Report::default();
        progress.step(0.0, "reading faces")?;
        let mut corners = Corners::of(mesh, &mut report.invalid_faces, listed)?;
        progress.step(0.05, "welding points")?;
        let mut joined = weld::weld(context, &corners, settings.tolerance);
        report.coincident_points = weld::joined_points(&joined, listed);
        if settings.weld.is_on() {
            weld::apply(context, &mut corners, &joined);
        } else {
            joined = (0..mesh.points.len() as u32).collect();
        }
        progress.step(0.15, "sifting faces")?;
        report.degenerate_faces = sift::degenerate(context, &mut corners, settings.degenerate.is_on(), listed);
        report.duplicate_faces = sift::duplicates(context, &mut corners, settings.duplicates.is_on(), listed);
        report.flat_faces = sift::flat(context, &corners, listed);
        report.unused_points = sift::unused(&corners, &joined, listed);
        progress.step(0.25, "finding edges")?;
        let edges = Edges::of(context, &corners);
        report.before = Topology::of(&corners, &edges, &Components::of(context, &corners, &edges));
        let mut work = Self { turned: vec![false; corners.face_count()], corners, edges, joined, report };
        work.find(context, listed);
        Ok(work)
    }

    /// Reports what is wrong with edges and points.
    fn find(&mut self, context: &Context, listed: u32) {
        let Self { corners, edges, report, .. } = self;
        let branching = edges.branching.iter().map(|group| corners.edge(group[0]));
        report.non_manifold_edges = Finding::of(branching, listed);
        let split = fans::split_points(context, corners, edges);
        report.non_manifold_points = fans::pinched(corners, edges, &split, listed);
        let turned = (0..).zip(&edges.mates).filter(|(half, mate)| {
            *half < **mate && edges.mate(*half).is_some() && corners.from(*half) == corners.from(**mate)
        });
        report.misoriented_edges = Finding::of(turned.map(|(half, _)| corners.edge(half)), listed);
        let is_boundary = |half: &u32| {
            edges.mates[*half as usize] == crate::edges::BOUNDARY && corners.from(*half) != corners.to(*half)
        };
        let boundary: Vec<u32> = (0..edges.mates.len() as u32).filter(is_boundary).collect();
        let firsts = topology::loops(corners, &boundary);
        report.holes = Finding::of(firsts.iter().map(|half| corners.edge(*half)), listed);
    }

    /// Orients faces, splits edges and vertices, and turns closed components outwards. Returns the components.
    fn orient(
        &mut self,
        context: &Context,
        settings: &RepairSettings,
        progress: &mut dyn Progress,
    ) -> Result<Components> {
        let Self { corners, edges, turned, report, .. } = self;
        let listed = settings.listed;
        progress.step(0.35, "orienting faces")?;
        if settings.orient.is_on() {
            (*turned, report.one_sided_edges) = orient::agree(corners, edges, listed);
        }
        if settings.split.is_on() {
            progress.step(0.4, "splitting edges and points")?;
            let is_branching = !edges.branching.is_empty();
            pairs::pair(corners, edges);
            report.split_points = split(context, corners, edges);
            // Edges that were paired may still have the same two points; those are cut.
            for _ in 0..MAX_SPLITS {
                if !is_branching {
                    break;
                }
                let mut fresh = Edges::of(context, corners);
                if fresh.branching.is_empty() {
                    *edges = fresh;
                    break;
                }
                pairs::cut(&mut fresh);
                report.split_points += split(context, corners, &fresh);
                *edges = fresh;
            }
        }
        progress.step(0.45, "facing outwards")?;
        Ok(match settings.orient.is_on() {
            true => outward(context, corners, edges, turned, report, listed),
            false => Components::of(context, corners, edges),
        })
    }
}

/// Turns closed components outwards, and counts the faces of the input that are turned over in all. Returns the components.
fn outward(
    context: &Context,
    corners: &mut Corners,
    edges: &mut Edges,
    turned: &mut [bool],
    report: &mut Report,
    listed: u32,
) -> Components {
    let (outward, inverted, components) = orient::outward(context, corners, edges, turned, listed);
    report.inverted_components.count += inverted.count;
    report.inverted_components.first.extend(inverted.first);
    report.inverted_components.first.truncate(listed as usize);
    turned.iter_mut().zip(outward).for_each(|(turned, again)| *turned ^= again);
    report.turned_faces = turned.iter().filter(|turned| **turned).count();
    components
}

/// Splits the points of more than one fan. Returns the number of points that this adds.
fn split(context: &Context, corners: &mut Corners, edges: &Edges) -> usize {
    let points = fans::split_points(context, corners, edges);
    if points.is_empty() { 0 } else { fans::split(corners, edges, &points) }
}

/// Fails unless attributes and tags fit the mesh.
fn check_sizes(mesh: &Mesh) -> Result<()> {
    for Attribute { name, domain, width, values, indices } in &mesh.attributes {
        let elements = match domain {
            Domain::Point => mesh.points.len(),
            Domain::Corner => mesh.corners.len(),
            Domain::Face => mesh.face_count(),
        };
        let count = values.len() / (*width).clamp(1, 4) as usize;
        let fits = match indices {
            None => values.len() == elements * *width as usize,
            Some(indices) => {
                let is_listed = indices.iter().all(|index| (*index as usize) < count);
                *domain == Domain::Corner && indices.len() == elements && is_listed
            }
        };
        if !fits || !(1..=4).contains(width) {
            return Err(Error::invalid("it does not fit the mesh")
                .at(format!("attribute `{name}`"))
                .advise("give 1 to 4 numbers for each element of its domain"));
        }
    }
    let (points, faces) = (mesh.points.len(), mesh.face_count());
    let is_point = |point: &u32| (*point as usize) < points;
    let fits = mesh.creases.iter().all(|crease| crease.points.iter().all(is_point))
        && mesh.sharp_points.iter().all(|(point, _)| is_point(point))
        && mesh.holes.iter().all(|face| (*face as usize) < faces);
    if fits { Ok(()) } else { Err(Error::invalid("creases, sharp points or holes name elements that do not exist")) }
}

/// Fails if a repair takes more than the memory limit of the context: connectivity, and twice the attributes.
fn reserve(context: &Context, mesh: &Mesh) -> Result<()> {
    let attributes: u64 = mesh.attributes.iter().map(|attribute| 4 * attribute.values.len() as u64).sum();
    let bytes = 64 * mesh.corners.len() as u64 + 64 * mesh.points.len() as u64 + 2 * attributes;
    if bytes <= context.memory_limit() {
        return Ok(());
    }
    Err(Error::memory(format!("repairing the mesh takes about {bytes} bytes"))
        .advise(format!("raise the memory limit of {} bytes, or split the mesh", context.memory_limit())))
}
