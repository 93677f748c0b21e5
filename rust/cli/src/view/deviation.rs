//! How far a level of a mesh is from its finest, triangle by triangle, measured in the background.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use glam::{DAffine3, DVec3, Vec3};
use relievo_core::{Context, Error, Result};
use relievo_detail::hierarchy::Target;
use relievo_detail::{Bounds, Hierarchy};
use relievo_surface::triangle::closest;

/// Points whose distances are found between two looks at whether to stop.
const CHUNK_LEN: usize = 1 << 14;

/// Triangles with their points.
#[derive(Debug, Default)]
pub struct Shape {
    pub points: Vec<[f32; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|point| Vec3::from(self.points[point as usize]).as_dvec3())
    }
}

/// A shape whose nearest triangle can be found.
struct Searched<'a> {
    shape: &'a Shape,
    hierarchy: Hierarchy,
}

impl<'a> Searched<'a> {
    fn new(context: &Context, shape: &'a Shape) -> Result<Self> {
        let corners = |triangle: u32| shape.triangles[triangle as usize].map(|point| shape.points[point as usize]);
        let bounds = |triangle: u32| Bounds::of_points(&corners(triangle));
        Ok(Self { shape, hierarchy: Hierarchy::build(context, shape.triangles.len(), bounds)? })
    }

    /// Returns the triangle nearest to a point and its distance.
    fn nearest(&self, point: DVec3) -> (usize, f64) {
        let mut near = (0, f64::INFINITY);
        let Some(target) = Target::new(&DAffine3::IDENTITY, point, 0.0) else { return near };
        let visit = |triangle: u32| {
            let corners = self.shape.corners(triangle as usize);
            let shares = closest(point, corners);
            let place: DVec3 = corners.iter().zip(shares).map(|(corner, share)| *corner * share).sum();
            let distance = place.distance(point);
            if distance < near.1 {
                near = (triangle as usize, distance);
            }
            Ok(near.1)
        };
        // No visit fails.
        let _ = self.hierarchy.approach(&target, f64::MAX.sqrt(), visit);
        near
    }

    /// Returns what is nearest to each of some points; `None` if it was asked to stop.
    fn nearest_to(&self, context: &Context, points: &[DVec3], stops: &AtomicBool) -> Option<Vec<(usize, f64)>> {
        let mut found = Vec::with_capacity(points.len());
        for part in points.chunks(CHUNK_LEN) {
            if stops.load(Ordering::Relaxed) {
                return None;
            }
            found.extend(context.map(part.len(), |at| self.nearest(part[at])));
        }
        Some(found)
    }
}

/// Measures for each point of a level the largest distance between the surfaces at its triangles: of their corners and middles
/// from the finest mesh, and of points of the finest mesh from them. `None` if it was asked to stop.
fn measure(context: &Context, [finest, level]: [&Shape; 2], stops: &AtomicBool) -> Result<Option<Vec<f32>>> {
    if finest.triangles.is_empty() || level.triangles.is_empty() {
        return Ok(Some(vec![0.0; level.points.len()]));
    }
    let [fine, coarse] = [Searched::new(context, finest)?, Searched::new(context, level)?];
    let exact = |point: &[f32; 3]| Vec3::from(*point).as_dvec3();
    let corners: Vec<DVec3> = level.points.iter().map(exact).collect();
    let middles: Vec<DVec3> =
        (0..level.triangles.len()).map(|at| level.corners(at).into_iter().sum::<DVec3>() / 3.0).collect();
    let places: Vec<DVec3> = finest.points.iter().map(exact).collect();
    let Some(own) = fine.nearest_to(context, &corners, stops) else { return Ok(None) };
    let Some(inside) = fine.nearest_to(context, &middles, stops) else { return Ok(None) };
    let Some(back) = coarse.nearest_to(context, &places, stops) else { return Ok(None) };
    let mut of_triangles: Vec<f64> = inside.iter().map(|(_, distance)| *distance).collect();
    back.iter().for_each(|(triangle, distance)| of_triangles[*triangle] = of_triangles[*triangle].max(*distance));
    let mut of_points: Vec<f64> = own.iter().map(|(_, distance)| *distance).collect();
    for (triangle, distance) in level.triangles.iter().zip(of_triangles) {
        triangle.iter().for_each(|point| of_points[*point as usize] = of_points[*point as usize].max(distance));
    }
    Ok(Some(of_points.into_iter().map(|distance| distance as f32).collect()))
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
