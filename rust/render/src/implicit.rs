//! Surfaces that find by themselves where rays meet them, such as those of particles: an object may have one beside its
//! triangles.

/// A ray in the space of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitRay {
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it goes, of unit length.
    pub direction: [f32; 3],
    /// The distance up to which hits count; may be infinite.
    pub far: f32,
    /// The time in seconds, within the shutter of the view.
    pub time: f32,
}

/// Where a ray meets a surface, in the space of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImplicitHit {
    /// The distance from the origin.
    pub distance: f32,
    /// The unit normal, which points out of the body.
    pub normal: [f32; 3],
    /// Whether the ray enters the body here, or leaves it.
    pub enters: bool,
    /// How far from the place along the normal a ray has to start so as not to meet it again.
    pub margin: f32,
}

/// A surface of a body. It is traced from many threads.
pub trait Implicit: Send + Sync {
    /// For tracing one ray after the other.
    fn tracer(&self) -> Box<dyn ImplicitTracer + '_>;
}

/// Traces rays against an [`Implicit`] surface.
pub trait ImplicitTracer {
    /// The first place where a ray enters or leaves the body.
    fn intersect(&mut self, ray: &ImplicitRay) -> Option<ImplicitHit>;
}
