//! The feature-adaptive patch table of a cage (Nießner, Loop, Meyer, DeRose 2012) as OpenSubdiv builds it: regular
//! bicubic B-spline patches, single-crease patches, and Gregory patches at extraordinary vertices, with the stencils
//! that make their points from the cage's.

use std::collections::HashSet;
use std::ops::RangeInclusive;

use cxx::UniquePtr;
use relievo_core::{Crease, Error, Mesh, Result};

use crate::bridge::ffi;
use crate::library;

/// How the surface behaves at a boundary of the cage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BoundaryRule {
    /// Boundary edges are sharp, and so are boundary points of one face: a plane of quads keeps its corners.
    #[default]
    EdgesAndCorners,
    /// Boundary edges are sharp, corners are rounded.
    Edges,
}

/// How a cage is refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The boundary rule.
    pub boundary: BoundaryRule,
    /// Levels of isolation of extraordinary features, 1 to 10.
    pub isolation: u32,
    /// Whether creases between regular faces stay single-crease patches rather than being refined.
    pub single_crease: bool,
    /// Refuse cages from which more patches are expected.
    pub patch_limit: f64,
    /// Refuse cages whose refinement is expected to need more bytes.
    pub memory_limit: u64,
}

/// Bytes while a cage is refined, for each weight of a stencil and for each corner of the cage. These and the numbers below
/// were fitted to the peaks of processes that made surfaces of cages of quads and of triangles, with and without creases:
/// estimates are 1.03 to 1.26 times what they used.
const REFINING: [f64; 2] = [55.5, 200.0];
/// Bytes while a surface is made of the table, for each weight and for each piece of a patch.
const POSING: [f64; 2] = [34.0, 870.0];
/// What the allocator does not give back at once, as a share of the rest, and up to so many bytes.
const SPARE: [f64; 2] = [0.176, 25.5e6];
/// Faces up to which estimates are counted whatever the limits: a few megabytes.
const COUNTED: f64 = 10_000.0;
/// Bytes beside these: pages of programs, and the private copy of OpenSubdiv, which the first surface of a process opens.
const FIXED: f64 = 2.8e6;

/// What a table is expected to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Patches, an upper estimate.
    pub patches: f64,
    /// Bytes at the peak while a surface is made of a cage: its refinement, or the making of its patches.
    pub bytes: f64,
}

impl Options {
    /// Checks what is expected against the limits.
    ///
    /// # Errors
    /// There are more patches than the limit, or they need more bytes than the memory limit.
    pub fn check(&self, expected: &Expected) -> Result<()> {
        let Expected { patches: expected, bytes } = *expected;
        if bytes > self.memory_limit as f64 {
            let what = format!(
                "about {expected:.0} patches are expected, which need {:.0} MB, more than the memory limit of {:.1} MB",
                (bytes / 1e6).ceil(),
                self.memory_limit as f64 / 1e6
            );
            return Err(Error::memory(what)
                .advise("raise the memory limit, or lower the isolation or the sharpness of creases"));
        }
        if expected > self.patch_limit {
            let what =
                format!("about {expected:.0} patches are expected, more than the limit of {:.0}", self.patch_limit);
            return Err(Error::unsupported(what)
                .advise("lower the isolation or the sharpness of creases, or use a coarser cage"));
        }
        Ok(())
    }
}

/// The kind of a patch, with what its evaluation needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PatchKind {
    /// 16 uniform bicubic B-spline points, row by row in v. Bit e of `boundary` says that edge e is a boundary, so that
    /// the points beyond it are phantoms to be extrapolated.
    Regular {
        /// Boundary edges.
        boundary: u8,
    },
    /// As regular, with a semi-sharp crease along one edge.
    SingleCrease {
        /// The edge: 0 v=0, 1 u=1, 2 v=1, 3 u=0.
        edge: u8,
        /// Sharpness at the patch's own level.
        sharpness: f32,
    },
    /// 20 Gregory points, five a corner: P, E+, E−, F+, F−.
    Gregory,
}

/// One patch of a table. It covers `[u, u+1]·2^-depth × [v, v+1]·2^-depth` of its tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchRecord {
    /// Tile (Ptex face).
    pub tile: u32,
    /// Column in units of the patch's size.
    pub u: u16,
    /// Row in units of the patch's size.
    pub v: u16,
    /// log2 of the tile's size over the patch's.
    pub depth: u8,
    /// The kind.
    pub kind: PatchKind,
    /// First of its point indices in [`Table::indices`].
    pub first: u32,
}

impl PatchRecord {
    /// How many points it has.
    pub fn point_count(&self) -> usize {
        if self.kind == PatchKind::Gregory { 20 } else { 16 }
    }
}

/// A refined cage. Points of patches are numbered: first the cage's, then one per stencil.
pub struct Table {
    inner: UniquePtr<ffi::Table>,
    patches: Vec<PatchRecord>,
    cage_points: usize,
}

/// Largest number of corners of a face and of faces at a point in OpenSubdiv's tables.
const VALENCE_LIMIT: usize = 65_535;

/// The creases of edges that some face has. The others mean nothing, and OpenSubdiv would print a warning for each.
fn creases_on_edges(mesh: &Mesh) -> Vec<Crease> {
    if mesh.creases.is_empty() {
        return Vec::new();
    }
    let key = |a: u32, b: u32| (a.min(b), a.max(b));
    let sides = mesh.faces().flat_map(|face| face.iter().zip(face.iter().cycle().skip(1)));
    let edges: HashSet<(u32, u32)> = sides.map(|(a, b)| key(*a, *b)).collect();
    mesh.creases.iter().filter(|crease| edges.contains(&key(crease.points[0], crease.points[1]))).copied().collect()
}

/// A mesh as OpenSubdiv takes it.
pub(crate) struct Cage<'m> {
    mesh: &'m Mesh,
    face_sizes: Vec<i32>,
    corners: Vec<i32>,
    crease_points: Vec<i32>,
    crease_sharpness: Vec<f32>,
    sharp_points: Vec<i32>,
    sharp_point_sharpness: Vec<f32>,
    holes: Vec<i32>,
}

impl<'m> Cage<'m> {
    /// Describes `mesh`, which must have passed [`Mesh::check`], and opens OpenSubdiv, which all that follows calls.
    ///
    /// # Errors
    /// OpenSubdiv cannot refine `mesh`, or cannot be opened.
    pub(crate) fn new(mesh: &'m Mesh) -> Result<Self> {
        library::open()?;
        check_valence(mesh)?;
        if mesh.corners.len() > i32::MAX as usize / 2 {
            return Err(Error::unsupported("the cage has more than 2^30 corners").advise("split it"));
        }
        let signed = |values: &[u32]| values.iter().map(|value| *value as i32).collect::<Vec<_>>();
        let creases = creases_on_edges(mesh);
        Ok(Self {
            mesh,
            face_sizes: signed(&mesh.face_sizes),
            corners: signed(&mesh.corners),
            crease_points: creases.iter().flat_map(|crease| signed(&crease.points)).collect(),
            crease_sharpness: creases.iter().map(|crease| crease.sharpness.min(10.0)).collect(),
            sharp_points: mesh.sharp_points.iter().map(|(point, _)| *point as i32).collect(),
            sharp_point_sharpness: mesh.sharp_points.iter().map(|(_, value)| value.min(10.0)).collect(),
            holes: signed(&mesh.holes),
        })
    }

    /// Returns the description for C++, which borrows this cage.
    pub(crate) fn described(&self, options: &Options) -> ffi::Cage<'_> {
        ffi::Cage {
            point_count: self.mesh.points.len() as u32,
            face_sizes: &self.face_sizes,
            corners: &self.corners,
            crease_points: &self.crease_points,
            crease_sharpness: &self.crease_sharpness,
            sharp_points: &self.sharp_points,
            sharp_point_sharpness: &self.sharp_point_sharpness,
            holes: &self.holes,
            round_corners: options.boundary == BoundaryRule::Edges,
            isolation: options.isolation,
            single_crease: options.single_crease,
        }
    }

    /// Estimates the table at each isolation of `levels`, within 1 to 10.
    fn expected(&self, options: &Options, levels: RangeInclusive<u32>) -> Result<Vec<Expected>> {
        let mut sizes = vec![ffi::Sizes::default(); levels.clone().count()];
        // Half of the faces become patches, so that more of them than this are refused however many follow.
        let faces = 2.0 * options.patch_limit.min(options.memory_limit as f64 / POSING[1]);
        let faces = faces.max(COUNTED);
        ffi::expected_sizes(&self.described(options), *levels.start(), faces, &mut sizes).map_err(refused)?;
        Ok(sizes.iter().map(|size| Expected { patches: size.patches, bytes: self.bytes(size) }).collect())
    }

    /// Estimates the bytes at the peak while a surface of these sizes is made.
    fn bytes(&self, size: &ffi::Sizes) -> f64 {
        let refining = REFINING[0] * size.weights + REFINING[1] * self.corners.len() as f64;
        let posing = POSING[0] * size.weights + POSING[1] * size.pieces;
        let most = refining.max(posing);
        most + (SPARE[0] * most).min(SPARE[1]) + FIXED
    }
}

fn refused(exception: cxx::Exception) -> Error {
    Error::unsupported(exception.what()).at("subdivision").advise("use a coarser or a simpler cage")
}

fn check_isolation(isolation: u32) -> Result<()> {
    if (1..=10).contains(&isolation) {
        return Ok(());
    }
    Err(Error::invalid(format!("isolation is {isolation}")).advise("use 1 to 10"))
}

impl Table {
    /// Estimates the tables of `mesh`, which must have passed [`Mesh::check`], at each isolation from 1 to that of
    /// `options`.
    ///
    /// # Errors
    /// A face or point has more than 65,535 neighbours.
    pub fn expected(mesh: &Mesh, options: &Options) -> Result<Vec<Expected>> {
        check_isolation(options.isolation)?;
        Cage::new(mesh)?.expected(options, 1..=options.isolation)
    }

    /// Refines `mesh`, which must have passed [`Mesh::check`].
    ///
    /// # Errors
    /// Fails with `Invalid` if the isolation is not 1 to 10, with `Unsupported` if a face or point has more than 65,535
    /// neighbours or more patches are expected than their limit, with `Memory` if they are expected to exceed the
    /// memory limit, and with `NotFound` if OpenSubdiv cannot be opened.
    pub fn new(mesh: &Mesh, options: &Options) -> Result<Self> {
        check_isolation(options.isolation)?;
        let cage = Cage::new(mesh)?;
        let expected = cage.expected(options, options.isolation..=options.isolation)?;
        for expected in &expected {
            options.check(expected).map_err(|error| error.at("subdivision"))?;
        }
        let inner = ffi::refine(&cage.described(options)).map_err(refused)?;
        let patches = inner.patches().iter().map(record).collect();
        Ok(Self { inner, patches, cage_points: mesh.points.len() })
    }

    /// Number of tiles, in the order of OpenSubdiv's `Far::PtexIndices`.
    pub fn tile_count(&self) -> usize {
        self.inner.tile_count() as usize
    }

    /// The patches, in no particular order.
    pub fn patches(&self) -> &[PatchRecord] {
        &self.patches
    }

    /// Point indices of the patches.
    pub fn indices(&self) -> &[i32] {
        self.inner.indices()
    }

    /// Number of points: the cage's and one per stencil.
    pub fn point_count(&self) -> usize {
        self.cage_points + self.inner.stencil_sizes().len()
    }

    /// Number of points of the cage.
    pub fn cage_point_count(&self) -> usize {
        self.cage_points
    }

    /// Size of every stencil.
    pub fn stencil_sizes(&self) -> &[i32] {
        self.inner.stencil_sizes()
    }

    /// Cage points and weights of all stencils, one after the other.
    pub fn stencil_weights(&self) -> (&[i32], &[f64]) {
        (self.inner.stencil_indices(), self.inner.stencil_weights())
    }

    pub(crate) fn inner(&self) -> &ffi::Table {
        &self.inner
    }
}

fn record(patch: &ffi::Patch) -> PatchRecord {
    let kind = match (patch.is_gregory, patch.crease) {
        (true, _) => PatchKind::Gregory,
        (false, 0) => PatchKind::Regular { boundary: patch.boundary },
        (false, crease) => PatchKind::SingleCrease { edge: crease - 1, sharpness: patch.sharpness },
    };
    PatchRecord { tile: patch.tile, u: patch.u, v: patch.v, depth: patch.depth, kind, first: patch.first }
}

fn check_valence(mesh: &Mesh) -> Result<()> {
    if let Some(face) = mesh.face_sizes.iter().position(|size| *size as usize > VALENCE_LIMIT) {
        return Err(Error::unsupported(format!("it has {} corners", mesh.face_sizes[face]))
            .at(format!("face {face}"))
            .advise(format!("split faces of more than {VALENCE_LIMIT} corners")));
    }
    let mut valence = vec![0_usize; mesh.points.len()];
    for corner in &mesh.corners {
        valence[*corner as usize] += 1;
    }
    if let Some(point) = valence.iter().position(|count| *count > VALENCE_LIMIT) {
        return Err(Error::unsupported(format!("{} faces meet there", valence[point]))
            .at(format!("point {point}"))
            .advise(format!("at most {VALENCE_LIMIT} faces may meet at a point")));
    }
    Ok(())
}
