//! The caster that finds what is under the pointer: Embree's hierarchies over chunks of the triangles that are drawn, of
//! which those are fitted anew whose points moved.

use std::ops::Range;

use glam::DVec3;
use relievo_core::{Error, Result};
use relievo_embree::{Device, ObjectId, Ray, Scene};

/// Triangles of a chunk. Triangles that follow one another are of one tile or of neighbours.
const CHUNK: usize = 1024;

/// The triangles in chunks, each a mesh of one object.
pub(crate) struct Picker {
    scene: Scene,
    object: ObjectId,
    /// The points of each chunk, by their numbers in the whole, ascending.
    used: Vec<Vec<u32>>,
    /// Where the chunks of each point begin in `of_point`, and where the last ones end.
    starts: Vec<u32>,
    of_point: Vec<u32>,
    marked: Vec<bool>,
    room: Vec<[f32; 3]>,
}

/// Where a ray meets the triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// The place, in the world.
    pub point: DVec3,
    /// Of the triangle, of length 1, to the side of the eye.
    pub normal: DVec3,
    /// The triangle.
    pub triangle: u32,
    /// The weights of its corners.
    pub weights: [f64; 3],
}

impl Picker {
    /// Builds the hierarchies over triangles, three numbers of `points` each in `corners`.
    ///
    /// # Errors
    /// A triangle names a point that does not exist, or memory runs out.
    pub(crate) fn new(points: &[[f32; 3]], corners: &[u32]) -> Result<Self> {
        let (triangles, _) = corners.as_chunks::<3>();
        if let Some(wrong) = corners.iter().find(|corner| **corner as usize >= points.len()) {
            return Err(Error::internal(format!("a triangle names point {wrong} of {}", points.len())));
        }
        let mut scene = Scene::new(&Device::new()?)?;
        let object = scene.add_object()?;
        let mut local = vec![0_u32; points.len()];
        let mut all: Vec<Vec<u32>> = Vec::with_capacity(triangles.len().div_ceil(CHUNK));
        for (chunk, part) in (0..).zip(triangles.chunks(CHUNK)) {
            let mut used = part.as_flattened().to_vec();
            used.sort_unstable();
            used.dedup();
            used.iter().zip(0..).for_each(|(point, at)| local[*point as usize] = at);
            let places: Vec<[f32; 3]> = used.iter().map(|point| points[*point as usize]).collect();
            let triangles: Vec<[u32; 3]> = part.iter().map(|corners| corners.map(|at| local[at as usize])).collect();
            scene.set_moving_mesh(object, chunk, &places, &triangles)?;
            all.push(used);
        }
        scene.commit()?;
        let mut starts = vec![0_u32; points.len() + 1];
        all.iter().flatten().for_each(|point| starts[*point as usize + 1] += 1);
        (1..starts.len()).for_each(|at| starts[at] += starts[at - 1]);
        let mut next = starts.clone();
        let mut of_point = vec![0; all.iter().map(Vec::len).sum()];
        for (used, chunk) in all.iter().zip(0..) {
            for point in used {
                let at = &mut next[*point as usize];
                of_point[*at as usize] = chunk;
                *at += 1;
            }
        }
        let marked = vec![false; all.len()];
        Ok(Self { scene, object, used: all, starts, of_point, marked, room: Vec::new() })
    }

    /// Fits the hierarchies of the points in `ranges` to where they are now.
    ///
    /// # Errors
    /// A coordinate is not finite, or memory runs out.
    pub(crate) fn update(&mut self, points: &[[f32; 3]], ranges: &[Range<u32>]) -> Result<()> {
        for range in ranges {
            let starts = self.starts.get(range.start as usize..=range.end as usize);
            let [Some(first), Some(last)] = [starts.and_then(<[u32]>::first), starts.and_then(<[u32]>::last)] else {
                return Err(Error::internal(format!("points {range:?} are not all there")));
            };
            let chunks = &self.of_point[*first as usize..*last as usize];
            chunks.iter().for_each(|chunk| self.marked[*chunk as usize] = true);
        }
        for (chunk, used) in self.used.iter().enumerate() {
            if std::mem::take(&mut self.marked[chunk]) {
                self.room.clear();
                self.room.extend(used.iter().map(|point| points[*point as usize]));
                self.scene.move_points(self.object, chunk as u32, &self.room)?;
            }
        }
        self.scene.commit().map(drop)
    }

    /// What a ray meets first, where `way` has length 1.
    ///
    /// # Errors
    /// An update failed, so that the hierarchies are not whole.
    pub(crate) fn pick(&self, (start, way): (DVec3, DVec3)) -> Result<Option<Picked>> {
        let ray = Ray::new(start.as_vec3().to_array(), way.as_vec3().to_array());
        Ok(self.scene.tracer()?.intersect(&ray).map(|hit| {
            let normal = glam::Vec3::from(hit.normal).as_dvec3().normalize_or_zero();
            let normal = if normal.dot(way) > 0.0 { -normal } else { normal };
            let (triangle, [u, v]) = (hit.mesh * CHUNK as u32 + hit.primitive, [hit.u, hit.v].map(f64::from));
            let weights = [1.0 - u - v, u, v].map(|weight| weight.max(0.0));
            Picked { point: start + way * f64::from(hit.t), normal, triangle, weights }
        }))
    }
}
