//! Triangles in chunks, each with a hierarchy of its own, so that moving points costs the chunks that they are in.

use glam::Vec3;
use relievo_core::{Error, Result};
use relievo_embree::{ObjectId, Scene};

/// Triangles of a chunk: so few that fitting one to moved points takes hundredths of a millisecond, so many that the hierarchy
/// above the chunks, which is built anew each time, is small.
const CHUNK: usize = 1024;

/// The chunks of triangles in a scene, each a mesh of one object, of triangles that lie together.
pub struct Chunks {
    object: ObjectId,
    /// All triangles, chunk by chunk.
    order: Vec<u32>,
    /// The points of each chunk, by their numbers in the whole, ascending.
    points: Vec<Vec<u32>>,
    /// Where the chunks of each point begin in `of_point`, and where the last ones end.
    starts: Vec<u32>,
    of_point: Vec<u32>,
    /// Where all points are in the scene.
    places: Vec<[f32; 3]>,
    /// Whether a chunk is to be moved.
    marked: Vec<bool>,
    /// The points of the chunk that is being moved.
    room: Vec<[f32; 3]>,
}

impl Chunks {
    /// Puts the triangles of `corners`, three numbers of `points` each, into `scene`.
    ///
    /// # Errors
    /// A point does not exist, or memory runs out.
    pub fn new(scene: &mut Scene, points: &[[f32; 3]], corners: &[u32]) -> Result<Self> {
        let (triangles, _) = corners.as_chunks::<3>();
        if let Some(wrong) = corners.iter().find(|corner| **corner as usize >= points.len()) {
            return Err(Error::internal(format!("a triangle names point {wrong} of {}", points.len())));
        }
        let object = scene.add_object()?;
        let order = along_curve(points, triangles);
        let mut local = vec![u32::MAX; points.len()];
        let mut numbers: Vec<Vec<u32>> = Vec::with_capacity(triangles.len().div_ceil(CHUNK));
        for (chunk, part) in order.chunks(CHUNK).enumerate() {
            let of_chunk = || part.iter().map(|triangle| triangles[*triangle as usize]);
            let mut used: Vec<u32> = of_chunk().flatten().collect();
            used.sort_unstable();
            used.dedup();
            used.iter().enumerate().for_each(|(at, point)| local[*point as usize] = at as u32);
            let places: Vec<[f32; 3]> = used.iter().map(|point| points[*point as usize]).collect();
            let triangles: Vec<[u32; 3]> = of_chunk().map(|corners| corners.map(|at| local[at as usize])).collect();
            scene.set_moving_mesh(object, chunk as u32, &places, &triangles)?;
            numbers.push(used);
        }
        let mut starts = vec![0_u32; points.len() + 1];
        numbers.iter().flatten().for_each(|point| starts[*point as usize + 1] += 1);
        (1..starts.len()).for_each(|at| starts[at] += starts[at - 1]);
        let mut next = starts.clone();
        let mut of_point = vec![0; numbers.iter().map(Vec::len).sum()];
        for (chunk, used) in numbers.iter().enumerate() {
            for point in used {
                let at = &mut next[*point as usize];
                of_point[*at as usize] = chunk as u32;
                *at += 1;
            }
        }
        let marked = vec![false; numbers.len()];
        let places = points.to_vec();
        Ok(Self { object, order, points: numbers, starts, of_point, places, marked, room: Vec::new() })
    }

    /// The triangle that is number `primitive` of chunk `mesh`.
    pub fn triangle(&self, mesh: u32, primitive: u32) -> usize {
        self.order
            .get(mesh as usize * CHUNK + primitive as usize)
            .map_or(u32::MAX as usize, |triangle| *triangle as usize)
    }

    /// Moves the chunks of the points that moved, which are in `ranges`, pairs of a first point and how many there are.
    ///
    /// # Errors
    /// A coordinate is not finite or beyond 1e12, or memory runs out.
    pub fn update(&mut self, scene: &mut Scene, points: &[[f32; 3]], ranges: &[[u32; 2]]) -> Result<()> {
        for [first, count] in ranges {
            for point in *first as usize..(*first as usize + *count as usize).min(points.len()).min(self.places.len()) {
                if self.places[point] != points[point] {
                    self.places[point] = points[point];
                    let chunks = self.starts[point] as usize..self.starts[point + 1] as usize;
                    self.of_point[chunks].iter().for_each(|chunk| self.marked[*chunk as usize] = true);
                }
            }
        }
        for (chunk, used) in self.points.iter().enumerate() {
            if std::mem::take(&mut self.marked[chunk]) {
                self.room.clear();
                self.room.extend(used.iter().map(|point| self.places[*point as usize]));
                scene.move_points(self.object, chunk as u32, &self.room)?;
            }
        }
        Ok(())
    }
}

/// The triangles in the order of their centres along a Morton curve through the box of the points.
fn along_curve(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<u32> {
    let places = || points.iter().map(|point| Vec3::from(*point));
    let (low, high) = (places().fold(Vec3::INFINITY, Vec3::min), places().fold(Vec3::NEG_INFINITY, Vec3::max));
    let extent = (high - low).max_element();
    let scale = if extent > 0.0 { 1023.0 / extent } else { 0.0 };
    let mut keys: Vec<(u32, u32)> = triangles
        .iter()
        .enumerate()
        .map(|(triangle, corners)| {
            let centre = corners.map(|at| Vec3::from(points[at as usize])).into_iter().sum::<Vec3>() / 3.0;
            let [x, y, z] = ((centre - low) * scale).to_array().map(|at| spread(at as u32));
            (x | y << 1 | z << 2, triangle as u32)
        })
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, triangle)| triangle).collect()
}

/// The lowest ten bits of a number, each followed by two zeros.
fn spread(number: u32) -> u32 {
    let number = number.min(1023);
    let number = (number | number << 16) & 0x0300_00ff;
    let number = (number | number << 8) & 0x0300_f00f;
    let number = (number | number << 4) & 0x030c_30c3;
    (number | number << 2) & 0x0924_9249
}
