//! Catmull-Clark limit surfaces as Embree evaluates them: a second source for checking other evaluators.
//!
//! Places are (face, sub-patch, u, v). A quad has one sub-patch, 0, with corner 0 at (0, 0) and corner 1 at (1, 0); a
//! face of n other corners has n of them, sub-patch k with corner k at (0, 0), the middle of the edge to the next
//! corner at (1, 0) and the centre of the face at (1, 1).

use relievo_core::{Error, Result};

use crate::abi;
use crate::device::{Device, GeometryOwner, SceneOwner};
use crate::scene::{check_points, padded};

/// Corners a face may have.
const MAX_FACE_CORNERS: u32 = 16;

/// A control cage.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cage<'a> {
    /// Positions.
    pub points: &'a [[f32; 3]],
    /// Number of corners of every face.
    pub face_sizes: &'a [u32],
    /// Point of every corner, face after face.
    pub corners: &'a [u32],
    /// The two points of sharp edges and their sharpness; infinity is allowed.
    pub edge_creases: &'a [([u32; 2], f32)],
    /// Sharp points and their sharpness; infinity is allowed.
    pub point_creases: &'a [(u32, f32)],
    /// Faces that are holes.
    pub holes: &'a [u32],
}

/// How boundaries are treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// Boundary edges are B-spline curves, also round corners of a single face.
    Edges,
    /// As `Edges`, and corners of a single face stay where they are.
    EdgesAndCorners,
}

/// A point of the limit surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// Position.
    pub p: [f32; 3],
    /// Derivative along u of the sub-patch.
    pub du: [f32; 3],
    /// Derivative along v of the sub-patch.
    pub dv: [f32; 3],
}

/// A Catmull-Clark surface.
pub struct Subdivision {
    geometry: GeometryOwner,
    face_sizes: Vec<u32>,
    _scene: SceneOwner,
}

impl Subdivision {
    /// Makes the surface of `cage`.
    ///
    /// # Errors
    /// The cage refers to what does not exist, or has faces of more than 16 corners.
    pub fn new(device: &Device, cage: &Cage, boundary: Boundary) -> Result<Self> {
        check(cage)?;
        let embree = &device.table().embree;
        let geometry = device.geometry(abi::RTC_GEOMETRY_TYPE_SUBDIVISION)?;
        let scene = device.scene(abi::RTC_SCENE_FLAG_NONE, abi::RTC_BUILD_QUALITY_LOW)?;
        geometry.fill(abi::RTC_BUFFER_TYPE_VERTEX, abi::RTC_FORMAT_FLOAT3, &padded(cage.points))?;
        geometry.fill(abi::RTC_BUFFER_TYPE_INDEX, abi::RTC_FORMAT_UINT, cage.corners)?;
        geometry.fill(abi::RTC_BUFFER_TYPE_FACE, abi::RTC_FORMAT_UINT, cage.face_sizes)?;
        let (edges, weights): (Vec<[u32; 2]>, Vec<f32>) = cage.edge_creases.iter().copied().unzip();
        geometry.fill(abi::RTC_BUFFER_TYPE_EDGE_CREASE_INDEX, abi::RTC_FORMAT_UINT2, &edges)?;
        geometry.fill(abi::RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT, abi::RTC_FORMAT_FLOAT, &weights)?;
        let (points, weights): (Vec<u32>, Vec<f32>) = cage.point_creases.iter().copied().unzip();
        geometry.fill(abi::RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX, abi::RTC_FORMAT_UINT, &points)?;
        geometry.fill(abi::RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT, abi::RTC_FORMAT_FLOAT, &weights)?;
        geometry.fill(abi::RTC_BUFFER_TYPE_HOLE, abi::RTC_FORMAT_UINT, cage.holes)?;
        let mode = match boundary {
            Boundary::Edges => abi::RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY,
            Boundary::EdgesAndCorners => abi::RTC_SUBDIVISION_MODE_PIN_CORNERS,
        };
        // SAFETY: all handles are alive and every index of the buffers has been checked.
        unsafe {
            embree.rtcSetGeometrySubdivisionMode(geometry.handle, 0, mode);
            embree.rtcCommitGeometry(geometry.handle);
            embree.rtcAttachGeometryByID(scene.handle, geometry.handle, 0);
            device.commit(scene.handle);
        }
        device.check()?;
        Ok(Self { geometry, face_sizes: cage.face_sizes.to_vec(), _scene: scene })
    }

    /// The limit surface at (u, v) in 0..=1 of sub-patch `sub` of `face`.
    ///
    /// # Errors
    /// There is no such face or sub-patch, or (u, v) is outside.
    pub fn evaluate(&self, face: u32, sub: u32, u: f32, v: f32) -> Result<Evaluation> {
        let size = self.face_sizes.get(face as usize).copied().unwrap_or(0);
        let subs = if size == 4 { 1 } else { size };
        if sub >= subs || !(0.0..=1.0).contains(&u) || !(0.0..=1.0).contains(&v) {
            return Err(Error::invalid(format!("there is no place ({u}, {v}) in sub-patch {sub} of face {face}")));
        }
        // Faces that are not quads have their sub-patches side by side in one parameter plane, four in a row, two
        // units apart, each with a margin of a half.
        let (u, v) = match size {
            4 => (u, v),
            _ => (2.0 * (sub % 4) as f32 + 0.5 + u, 2.0 * (sub / 4) as f32 + 0.5 + v),
        };
        // Results are written in whole vectors of up to sixteen floats.
        let (mut p, mut du, mut dv) = ([0.0; 16], [0.0; 16], [0.0; 16]);
        let arguments = abi::RTCInterpolateArguments {
            geometry: self.geometry.handle,
            primID: face,
            u,
            v,
            bufferType: abi::RTC_BUFFER_TYPE_VERTEX,
            bufferSlot: 0,
            P: p.as_mut_ptr(),
            dPdu: du.as_mut_ptr(),
            dPdv: dv.as_mut_ptr(),
            ddPdudu: std::ptr::null_mut(),
            ddPdvdv: std::ptr::null_mut(),
            ddPdudv: std::ptr::null_mut(),
            valueCount: 3,
        };
        // SAFETY: the geometry is alive and committed, the face and (u, v) exist, the results have room.
        unsafe { self.geometry.device.table().embree.rtcInterpolate(&arguments) };
        let first = |values: [f32; 16]| [values[0], values[1], values[2]];
        Ok(Evaluation { p: first(p), du: first(du), dv: first(dv) })
    }
}

fn check(cage: &Cage) -> Result<()> {
    check_points(cage.points)?;
    let total: u64 = cage.face_sizes.iter().map(|size| u64::from(*size)).sum();
    let exists = |point: &u32| (*point as usize) < cage.points.len();
    let sharp = |weight: f32| weight >= 0.0;
    let sound = total == cage.corners.len() as u64
        && !cage.face_sizes.is_empty()
        && cage.corners.iter().all(exists)
        && cage.edge_creases.iter().all(|([a, b], weight)| exists(a) && exists(b) && a != b && sharp(*weight))
        && cage.point_creases.iter().all(|(point, weight)| exists(point) && sharp(*weight))
        && cage.holes.iter().all(|face| (*face as usize) < cage.face_sizes.len());
    if !sound {
        return Err(Error::invalid("the cage refers to points or faces that do not exist"));
    }
    match cage.face_sizes.iter().position(|size| !(3..=MAX_FACE_CORNERS).contains(size)) {
        None => Ok(()),
        Some(face) => Err(Error::unsupported(format!("it has {} corners", cage.face_sizes[face]))
            .at(format!("face {face}"))
            .advise(format!("use faces of 3 to {MAX_FACE_CORNERS} corners"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        (0..3).all(|axis| (a[axis] - b[axis]).abs() < 1e-5)
    }

    /// A flat grid of quads of unit size: away from the boundary its limit surface is itself.
    fn grid(size: u32) -> (Vec<[f32; 3]>, Vec<u32>, Vec<u32>) {
        let points = (0..=size).flat_map(|y| (0..=size).map(move |x| [x as f32, y as f32, 0.0])).collect();
        let corner = |x: u32, y: u32| y * (size + 1) + x;
        let corners = (0..size)
            .flat_map(|y| {
                (0..size).flat_map(move |x| [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)])
            })
            .collect();
        (points, vec![4; (size * size) as usize], corners)
    }

    #[test]
    fn a_flat_grid_is_its_own_limit_with_u_along_the_first_edge() {
        let (points, sizes, corners) = grid(5);
        let cage = Cage { points: &points, face_sizes: &sizes, corners: &corners, ..Cage::default() };
        let surface = Subdivision::new(&Device::new().unwrap(), &cage, Boundary::EdgesAndCorners).unwrap();
        let middle = surface.evaluate(12, 0, 0.25, 0.75).unwrap();
        assert!(near(middle.p, [2.25, 2.75, 0.0]), "{middle:?}");
        assert!(near(middle.du, [1.0, 0.0, 0.0]) && near(middle.dv, [0.0, 1.0, 0.0]), "{middle:?}");
        assert!(surface.evaluate(25, 0, 0.5, 0.5).is_err());
        assert!(surface.evaluate(0, 1, 0.5, 0.5).is_err());
        assert!(surface.evaluate(0, 0, 1.5, 0.5).is_err());
        assert!(surface.evaluate(0, 0, f32::NAN, 0.5).is_err());
    }

    #[test]
    fn a_cube_has_the_limit_points_of_the_valence_three_mask() {
        let points: Vec<[f32; 3]> =
            (0..8).map(|at| [0, 1, 2].map(|axis| if at >> axis & 1 == 1 { 1.0 } else { -1.0 })).collect();
        let corners = [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
        let cage = Cage { points: &points, face_sizes: &[4; 6], corners: &corners, ..Cage::default() };
        let surface = Subdivision::new(&Device::new().unwrap(), &cage, Boundary::Edges).unwrap();
        let corner = surface.evaluate(0, 0, 0.0, 0.0).unwrap();
        // (n² v + 4 Σ e + Σ f) / (n (n + 5)), with the edge neighbours e and the opposite face corners f.
        let sum = |list: &[usize], axis: usize| list.iter().map(|at| points[*at][axis]).sum::<f32>();
        let mask =
            [0, 1, 2].map(|axis| (9.0 * points[0][axis] + 4.0 * sum(&[1, 2, 4], axis) + sum(&[3, 5, 6], axis)) / 24.0);
        assert!(near(corner.p, mask), "{corner:?} {mask:?}");
    }

    #[test]
    fn sharp_edges_and_corners_are_kept() {
        let (points, sizes, corners) = grid(1);
        let creases: Vec<(u32, f32)> = (0..4).map(|point| (point, f32::INFINITY)).collect();
        let cage = Cage { points: &points, face_sizes: &sizes, corners: &corners, ..Cage::default() };
        let device = Device::new().unwrap();
        let round = Subdivision::new(&device, &cage, Boundary::Edges).unwrap();
        assert!(!near(round.evaluate(0, 0, 0.0, 0.0).unwrap().p, [0.0; 3]));
        let pinned = Subdivision::new(&device, &cage, Boundary::EdgesAndCorners).unwrap();
        assert!(near(pinned.evaluate(0, 0, 1.0, 1.0).unwrap().p, [1.0, 1.0, 0.0]));
        let cage = Cage { point_creases: &creases, ..cage };
        let tagged = Subdivision::new(&device, &cage, Boundary::Edges).unwrap();
        assert!(near(tagged.evaluate(0, 0, 1.0, 1.0).unwrap().p, [1.0, 1.0, 0.0]));
    }

    #[test]
    fn a_pentagon_has_five_sub_patches_in_corner_order() {
        let points: Vec<[f32; 3]> = (0..5)
            .map(|at| {
                let angle = std::f32::consts::TAU * at as f32 / 5.0;
                [angle.cos(), angle.sin(), 0.0]
            })
            .collect();
        let cage = Cage { points: &points, face_sizes: &[5], corners: &[0, 1, 2, 3, 4], ..Cage::default() };
        let surface = Subdivision::new(&Device::new().unwrap(), &cage, Boundary::EdgesAndCorners).unwrap();
        for sub in 0..5 {
            let at = |u, v| surface.evaluate(0, sub, u, v).unwrap().p;
            let (own, next) = (points[sub as usize], points[(sub as usize + 1) % 5]);
            assert!(near(at(0.0, 0.0), own), "corner {sub} is pinned");
            assert!(near(at(1.0, 0.0), [0, 1, 2].map(|axis| (own[axis] + next[axis]) / 2.0)), "u runs to the next");
            assert!(near(at(1.0, 1.0), [0.0; 3]), "the centre");
        }
        assert!(surface.evaluate(0, 5, 0.5, 0.5).is_err());
    }

    #[test]
    fn bad_cages_are_refused() {
        let device = Device::new().unwrap();
        let points = [[0.0; 3]; 17];
        let make = |sizes: &[u32], corners: &[u32]| {
            let cage = Cage { points: &points, face_sizes: sizes, corners, ..Cage::default() };
            Subdivision::new(&device, &cage, Boundary::Edges).map(|_| ())
        };
        assert!(make(&[4], &[0, 1, 2]).is_err());
        assert!(make(&[3], &[0, 1, 17]).is_err());
        assert!(make(&[], &[]).is_err());
        let endless = [[0.0; 3], [f32::INFINITY, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let cage = Cage { points: &endless, face_sizes: &[3], corners: &[0, 1, 2], ..Cage::default() };
        assert!(Subdivision::new(&device, &cage, Boundary::Edges).is_err());
        assert!(make(&[17], &(0..17).collect::<Vec<u32>>()).unwrap_err().to_string().contains("face 0"));
    }
}
