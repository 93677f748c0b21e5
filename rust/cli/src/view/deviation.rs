//! How far a level of a mesh is from its finest, triangle by triangle, measured in the background.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use glam::Vec3;
use relievo_core::{Context, Error, Result};
use relievo_lod::MeasuredMesh;

/// Points whose distances are found between two looks at whether to stop.
const CHUNK_LEN: usize = 1 << 14;

/// Triangles with their points.
#[derive(Debug, Default)]
pub struct Shape {
    pub points: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

/// Finds the triangle of a mesh nearest to each of some points, and its distance; `None` if it was asked to stop.
fn nearest(context: &Context, mesh: &MeasuredMesh, points: &[[f32; 3]], stops: &AtomicBool) -> Option<Vec<(u32, f64)>> {
    let mut found = Vec::with_capacity(points.len());
    for part in points.chunks(CHUNK_LEN) {
        if stops.load(Ordering::Relaxed) {
            return None;
        }
        found.extend(mesh.nearest_triangles(context, part));
    }
    Some(found)
}

/// Measures for each point of a level the largest distance between the surfaces at its triangles: of their corners and middles
/// from the finest mesh, and of points of the finest mesh from them. `None` if it was asked to stop.
fn measure<'a>(context: &Context, [finest, level]: [&'a Shape; 2], stops: &AtomicBool) -> Result<Option<Vec<f32>>> {
    if finest.triangles.is_empty() || level.triangles.is_empty() {
        return Ok(Some(vec![0.0; level.points.len()]));
    }
    let mesh = |shape: &'a Shape| MeasuredMesh::new(context, (&shape.points, &shape.triangles));
    let [fine, coarse] = [mesh(finest)?, mesh(level)?];
    let middle = |triangle: &[u32; 3]| {
        let corners = triangle.map(|point| Vec3::from(level.points[point as usize]));
        (corners.into_iter().sum::<Vec3>() / 3.0).to_array()
    };
    let middles: Vec<[f32; 3]> = level.triangles.iter().map(middle).collect();
    let Some(own) = nearest(context, &fine, &level.points, stops) else { return Ok(None) };
    let Some(inside) = nearest(context, &fine, &middles, stops) else { return Ok(None) };
    let Some(back) = nearest(context, &coarse, &finest.points, stops) else { return Ok(None) };
    let mut of_triangles: Vec<f64> = inside.iter().map(|(_, distance)| *distance).collect();
    for (triangle, distance) in back {
        // A level without area has no triangle that is near.
        if let Some(known) = of_triangles.get_mut(triangle as usize) {
            *known = known.max(distance);
        }
    }
    let mut of_points: Vec<f64> = own.iter().map(|(_, distance)| *distance).collect();
    for (triangle, distance) in level.triangles.iter().zip(of_triangles) {
        triangle.iter().for_each(|point| of_points[*point as usize] = of_points[*point as usize].max(distance));
    }
    // Nothing is near a mesh without area.
    let known = |distance: f64| if distance.is_finite() { distance as f32 } else { 0.0 };
    Ok(Some(of_points.into_iter().map(known).collect()))
}

/// A measurement on a thread of its own. Dropped, it is asked to stop and waited for.
#[derive(Debug)]
pub struct Measuring {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// What a measurement shares with its thread.
#[derive(Debug, Default)]
struct Shared {
    stops: AtomicBool,
    found: Mutex<Option<Result<Vec<f32>>>>,
}

impl Drop for Measuring {
    fn drop(&mut self) {
        self.shared.stops.store(true, Ordering::Relaxed);
        // A panic of the thread was printed when it happened.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

impl Measuring {
    /// Starts to measure a level against the finest mesh.
    ///
    /// # Errors
    /// There is no room for another thread.
    pub fn start(context: &Context, finest: &Arc<Shape>, level: Shape) -> Result<Self> {
        let shared = Arc::new(Shared::default());
        let (inside, context, finest) = (Arc::clone(&shared), context.clone(), Arc::clone(finest));
        let work = move || {
            let found = measure(&context, [&*finest, &level], &inside.stops).transpose();
            *inside.found.lock().unwrap_or_else(PoisonError::into_inner) = found;
        };
        let thread = std::thread::Builder::new().name("relievo-measure".into()).spawn(work);
        let thread = thread.map_err(|error| Error::memory(format!("there is no thread to measure with: {error}")))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// Returns the deviation at each point of the level once it is measured.
    pub fn found(&self) -> Option<Result<Vec<f32>>> {
        self.shared.found.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}
