//! Cages under any of OpenSubdiv's schemes: its Bfr evaluates points and attributes, its Far refines uniformly.

use cxx::UniquePtr;
use relievo_core::{Error, Mesh, Result};

use crate::bridge::ffi;
use crate::table::{BoundaryRule, Cage, Options};

/// A subdivision scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheme {
    /// Catmull-Clark.
    #[default]
    CatmullClark,
    /// Loop, of triangles alone.
    Loop,
    /// Bilinear.
    Bilinear,
}

/// What a surface is at the boundary of a cage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boundary {
    /// Boundary edges are sharp, and so are boundary points of one face.
    #[default]
    EdgesAndCorners,
    /// Boundary edges are sharp, corners are rounded.
    Edges,
    /// Faces at the boundary shape their neighbours and have no surface.
    None,
}

/// Where face-varying values are interpolated linearly: OpenSubdiv's `FVAR_LINEAR_` rules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceVarying {
    /// Nowhere: seams are smooth.
    None,
    /// At corners of seams.
    #[default]
    CornersOnly,
    /// At corners, and where three or more regions meet.
    CornersPlus1,
    /// As before, and at darts and concave corners.
    CornersPlus2,
    /// Along all seams.
    Boundaries,
    /// Everywhere.
    All,
}

/// How a cage is subdivided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// The scheme.
    pub scheme: Scheme,
    /// The boundary rule.
    pub boundary: Boundary,
    /// The rule of face-varying values.
    pub face_varying: FaceVarying,
    /// Whether sharpness is averaged along creases (DeRose, Kass, Truong 1998), rather than uniform.
    pub chaikin: bool,
    /// Whether triangles of Catmull-Clark cages have weights that make them smoother.
    pub smooth_triangles: bool,
    /// Levels to which features are isolated before they are approximated, 1 to 10.
    pub isolation: u32,
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            scheme: Scheme::default(),
            boundary: Boundary::default(),
            face_varying: FaceVarying::default(),
            chaikin: false,
            smooth_triangles: false,
            isolation: 6,
        }
    }
}

/// Face-varying values of a cage: how many there are, and that of each corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channel {
    /// Number of values.
    pub count: usize,
    /// The value of each corner of the cage.
    pub corners: Vec<u32>,
}

/// Which values are interpolated, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Values of points, as smooth as the surface.
    Vertex,
    /// Values of points, bilinear over tiles.
    Varying,
    /// The values of a channel, by the rule of the subdivision.
    FaceVarying(u32),
}

impl Interpolation {
    /// Describes values of `width` numbers for C++.
    fn of(self, values: &[f32], width: u32) -> ffi::Primvar<'_> {
        let (interpolation, channel) = match self {
            Interpolation::Vertex => (0, 0),
            Interpolation::Varying => (1, 0),
            Interpolation::FaceVarying(channel) => (2, channel),
        };
        ffi::Primvar { interpolation, channel, values, width }
    }
}

/// A place: a face of the cage, which of its tiles, and parameters there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spot {
    /// Face of the cage.
    pub face: u32,
    /// Tile of an n-gon, 0 of other faces.
    pub part: u32,
    /// First parameter, 0 to 1.
    pub u: f32,
    /// Second parameter, 0 to 1; of triangles under Loop at most 1 with the first.
    pub v: f32,
}

/// A cage under a scheme, ready to be evaluated.
pub struct Subdivision {
    inner: UniquePtr<ffi::Subdivision>,
    face_count: usize,
    /// Number of values of points, then of each channel.
    counts: Vec<usize>,
}

/// The faces of a cage that was refined uniformly, those of holes left out.
pub struct Refined {
    inner: UniquePtr<ffi::Refined>,
    counts: Vec<usize>,
}

fn failed(exception: cxx::Exception) -> Error {
    Error::unsupported(exception.what()).at("subdivision").advise("use a simpler cage")
}

/// The arrays of [`Channel`]s as C++ takes them.
struct Channels {
    sizes: Vec<i32>,
    corners: Vec<i32>,
}

impl Channels {
    fn new(mesh: &Mesh, channels: &[Channel]) -> Result<Self> {
        for (index, channel) in channels.iter().enumerate() {
            let fits = channel.corners.len() == mesh.corners.len()
                && i32::try_from(channel.count).is_ok()
                && channel.corners.iter().all(|value| (*value as usize) < channel.count);
            if !fits {
                return Err(Error::invalid("its corners refer to values that do not exist")
                    .at(format!("face-varying channel {index}")));
            }
        }
        let corners = channels.iter().flat_map(|channel| channel.corners.iter().map(|value| *value as i32)).collect();
        Ok(Self { sizes: channels.iter().map(|channel| channel.count as i32).collect(), corners })
    }

    fn described(&self, rules: &Rules) -> ffi::Rules<'_> {
        ffi::Rules {
            scheme: rules.scheme as u32,
            boundary: rules.boundary as u32,
            face_varying: rules.face_varying as u32,
            chaikin: rules.chaikin,
            smooth_triangles: rules.smooth_triangles,
            channel_sizes: &self.sizes,
            channel_corners: &self.corners,
        }
    }
}

/// Checks that `mesh` can be subdivided by `rules`, and describes it.
fn prepare<'m>(mesh: &'m Mesh, rules: &Rules) -> Result<(Cage<'m>, Options)> {
    if !(1..=10).contains(&rules.isolation) {
        return Err(Error::invalid(format!("isolation is {}", rules.isolation)).advise("use 1 to 10"));
    }
    if rules.scheme == Scheme::Loop
        && let Some(face) = mesh.face_sizes.iter().position(|size| *size != 3)
    {
        return Err(Error::unsupported(format!(
            "the Loop scheme takes triangles, not {} corners",
            mesh.face_sizes[face]
        ))
        .at(format!("face {face}"))
        .advise("cut faces into triangles, or use the Catmull-Clark scheme"));
    }
    let options = Options {
        boundary: BoundaryRule::default(),
        isolation: rules.isolation,
        single_crease: false,
        patch_limit: f64::INFINITY,
        memory_limit: u64::MAX,
    };
    Ok((Cage::new(mesh)?, options))
}

fn counts(mesh: &Mesh, channels: &[Channel]) -> Vec<usize> {
    std::iter::once(mesh.points.len()).chain(channels.iter().map(|channel| channel.count)).collect()
}

/// Checks that there are as many values of `width` numbers as `interpolation` takes.
fn check_values(counts: &[usize], interpolation: Interpolation, values: &[f32], width: u32) -> Result<()> {
    let index = match interpolation {
        Interpolation::FaceVarying(channel) => 1 + channel as usize,
        _ => 0,
    };
    let count = *counts.get(index).ok_or_else(|| Error::invalid("there is no such face-varying channel"))?;
    if !(1..=4).contains(&width) || count.checked_mul(width as usize) != Some(values.len()) {
        return Err(Error::invalid(format!("{count} values of 1 to 4 numbers are needed")));
    }
    Ok(())
}

/// Returns `spots` as C++ takes them. Fails if one is of a face that does not exist.
fn described(spots: &[Spot], face_count: usize) -> Result<Vec<ffi::Spot>> {
    if let Some(spot) = spots.iter().find(|spot| spot.face as usize >= face_count) {
        return Err(Error::invalid(format!("face {} does not exist", spot.face)));
    }
    let described = |spot: &Spot| ffi::Spot { face: spot.face as i32, part: spot.part as i32, u: spot.u, v: spot.v };
    Ok(spots.iter().map(described).collect())
}

/// Evaluates as [`Subdivision::evaluate`] with all derivatives, by `Osd::CpuEvaluator` on a patch table of adaptive
/// refinement, for tests.
///
/// # Errors
/// As [`Subdivision::new`] and [`Subdivision::evaluate`].
pub fn osd_evaluate(
    (mesh, rules, channels): (&Mesh, &Rules, &[Channel]),
    interpolation: Interpolation,
    (values, width): (&[f32], u32),
    spots: &[Spot],
) -> Result<Vec<f32>> {
    check_values(&counts(mesh, channels), interpolation, values, width)?;
    let (cage, options) = prepare(mesh, rules)?;
    let (arrays, spots) = (Channels::new(mesh, channels)?, described(spots, mesh.face_count())?);
    let mut out = vec![0.0; 6 * width as usize * spots.len()];
    let (cage, rules) = (cage.described(&options), arrays.described(rules));
    ffi::osd_evaluate(&cage, &rules, &interpolation.of(values, width), &spots, &mut out).map_err(failed)?;
    Ok(out)
}

impl Subdivision {
    /// Prepares `mesh`, which must have passed [`Mesh::check`].
    ///
    /// # Errors
    /// A face or point has more than 65,535 neighbours, a face is no triangle under [`Scheme::Loop`], or a channel refers
    /// to a value that does not exist.
    pub fn new(mesh: &Mesh, rules: &Rules, channels: &[Channel]) -> Result<Self> {
        let (cage, options) = prepare(mesh, rules)?;
        let arrays = Channels::new(mesh, channels)?;
        let inner = ffi::make_subdivision(&cage.described(&options), &arrays.described(rules)).map_err(failed)?;
        Ok(Self { inner, face_count: mesh.face_count(), counts: counts(mesh, channels) })
    }

    /// Evaluates values of `width` numbers at `spots`: value, du, dv, duu, duv and dvv per unit of the tile, one after the
    /// other for each spot in `out`. `derivatives` is 0, 1 or 2: what is beyond it becomes 0. A face without a limit
    /// surface has zeros.
    ///
    /// # Errors
    /// A face or channel does not exist, or an array has another length.
    pub fn evaluate(
        &self,
        interpolation: Interpolation,
        (values, width): (&[f32], u32),
        spots: &[Spot],
        derivatives: u32,
        out: &mut [f32],
    ) -> Result<()> {
        check_values(&self.counts, interpolation, values, width)?;
        if out.len() != 6 * width as usize * spots.len() {
            return Err(Error::internal("the array of results has another length"));
        }
        let described = described(spots, self.face_count)?;
        self.inner.evaluate(&interpolation.of(values, width), &described, derivatives, out).map_err(failed)
    }
}

impl Refined {
    /// Refines `mesh`, which must have passed [`Mesh::check`], `level` times, 1 to 10.
    ///
    /// # Errors
    /// As [`Subdivision::new`], and if the level is out of its range.
    pub fn new(mesh: &Mesh, rules: &Rules, channels: &[Channel], level: u32) -> Result<Self> {
        if !(1..=10).contains(&level) {
            return Err(Error::invalid(format!("level {level} is out of range")).at("level").advise("use 1 to 10"));
        }
        let (cage, options) = prepare(mesh, rules)?;
        let arrays = Channels::new(mesh, channels)?;
        let inner =
            ffi::refine_uniformly(&cage.described(&options), &arrays.described(rules), level).map_err(failed)?;
        Ok(Self { inner, counts: counts(mesh, channels) })
    }

    /// Number of corners of every face.
    pub fn face_sizes(&self) -> &[u32] {
        self.inner.face_sizes()
    }

    /// Point of every corner.
    pub fn corners(&self) -> &[u32] {
        self.inner.corners()
    }

    /// Face of the cage of every face.
    pub fn parents(&self) -> &[u32] {
        self.inner.parents()
    }

    /// The value of every corner in a face-varying channel.
    ///
    /// # Errors
    /// There is no such channel.
    pub fn channel_corners(&self, channel: u32) -> Result<Vec<u32>> {
        if channel as usize + 1 >= self.counts.len() {
            return Err(Error::invalid("there is no such face-varying channel"));
        }
        self.inner.channel_corners(channel).map_err(failed)
    }

    /// Computes the values of the refined points or channel from those of the cage; but for varying ones they lie on the
    /// limit surface.
    ///
    /// # Errors
    /// There is no such channel, or the array has another length.
    pub fn values(&self, interpolation: Interpolation, values: &[f32], width: u32) -> Result<Vec<f32>> {
        check_values(&self.counts, interpolation, values, width)?;
        self.inner.values(&interpolation.of(values, width)).map_err(failed)
    }
}
