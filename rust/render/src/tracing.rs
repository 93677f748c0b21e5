//! Rays against all that a scene has: triangles, by Embree, implicit surfaces, and light through dielectric bodies.

use glam::Vec3;
use relievo_embree::{Hit, Ray};

use crate::facet::{Facet, Place};
use crate::implicit::{ImplicitRay, ImplicitTracer};
use crate::scene::{Placed, Placement};

/// Rays that are traced together.
pub(crate) const LANES: usize = 8;

/// Surfaces of dielectric bodies on the way of light at most; more let none through.
const MAX_SURFACES: usize = 64;

/// What a ray meets.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Struck {
    Triangle(Hit),
    Implicit(Met),
}

/// Where a ray meets an implicit surface, in the camera's space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    t: f32,
    object: u32,
    point: Vec3,
    /// Unit normal out of the body.
    normal: Vec3,
    enters: bool,
    margin: f32,
}

impl Struck {
    /// The distance, in multiples of the ray's direction.
    pub fn t(&self) -> f32 {
        match self {
            Self::Triangle(hit) => hit.t,
            Self::Implicit(met) => met.t,
        }
    }

    /// The number of the object.
    pub fn object(&self) -> u32 {
        match self {
            Self::Triangle(hit) => hit.object.0,
            Self::Implicit(met) => met.object,
        }
    }
}

impl Met {
    /// The place to be lit.
    pub fn place(&self) -> Place {
        let normal = if self.enters { self.normal } else { -self.normal };
        let aside = normal * self.margin;
        let (start, behind) = (self.point + aside, self.point - aside);
        Place { start, behind, flat: normal, smooth: normal, enters: self.enters }
    }
}

/// Traces rays of one thread.
pub(crate) struct Tracing<'a> {
    placed: &'a Placed<'a>,
    /// Implicit surfaces by the numbers of their objects.
    implicits: Vec<(u32, &'a Placement, Box<dyn ImplicitTracer + 'a>)>,
    /// Whether light goes through anything.
    dielectric: bool,
}

impl<'a> Tracing<'a> {
    pub fn new(placed: &'a Placed<'a>) -> Self {
        let all = (0..).zip(placed.objects.iter().zip(&placed.placements));
        let implicits = all.filter_map(|(number, (object, placement))| {
            let tracer = object.as_ref()?.implicit.as_ref()?.tracer();
            Some((number, placement.as_ref()?, tracer))
        });
        let dielectric = placed.placements.iter().flatten().any(|placement| placement.dielectric.is_some());
        Self { placed, implicits: implicits.collect(), dielectric }
    }

    /// The closest hits of up to eight rays, each at a time.
    pub fn nearest8(&mut self, rays: &[Option<Ray>; LANES], times: [f32; LANES]) -> [Option<Struck>; LANES] {
        let hits = self.placed.tracer.intersect8(rays);
        std::array::from_fn(|lane| self.nearer(rays[lane].as_ref()?, hits[lane].map(Struck::Triangle), times[lane]))
    }

    /// The closest hit of a ray.
    fn nearest(&mut self, ray: &Ray, time: f32) -> Option<Struck> {
        let hit = self.placed.tracer.intersect(ray);
        self.nearer(ray, hit.map(Struck::Triangle), time)
    }

    /// The hit of an implicit surface that is closer than `found`, or that.
    fn nearer(&mut self, ray: &Ray, mut found: Option<Struck>, time: f32) -> Option<Struck> {
        for (object, placement, tracer) in &mut self.implicits {
            let far = found.map_or(ray.far, |found| found.t());
            found = meet(*object, placement, tracer.as_mut(), ray, far, time).map(Struck::Implicit).or(found);
        }
        found
    }

    /// The share of light that comes along each of up to eight rays.
    pub fn light8(&mut self, rays: &[Option<Ray>; LANES], times: [f32; LANES]) -> [Vec3; LANES] {
        if self.dielectric {
            return std::array::from_fn(|lane| rays[lane].map_or(Vec3::ONE, |ray| self.light(&ray, times[lane])));
        }
        let blocked = self.placed.tracer.occluded8(rays);
        std::array::from_fn(|lane| match &rays[lane] {
            Some(_) if blocked[lane] => Vec3::ZERO,
            Some(ray) if self.nearer(ray, None, times[lane]).is_some() => Vec3::ZERO,
            _ => Vec3::ONE,
        })
    }

    /// The share of light that comes along a ray: dielectric bodies reflect and absorb some of it, and let the rest
    /// straight through.
    pub fn light(&mut self, ray: &Ray, time: f32) -> Vec3 {
        if !self.dielectric {
            let blocked = self.placed.tracer.occluded(ray) || self.nearer(ray, None, time).is_some();
            return if blocked { Vec3::ZERO } else { Vec3::ONE };
        }
        let (mut ray, mut light) = (*ray, Vec3::ONE);
        let direction = Vec3::from(ray.direction);
        let (length, unit) = (direction.length(), direction.normalize_or_zero());
        for _ in 0..MAX_SURFACES {
            let Some(struck) = self.nearest(&ray, time) else { return light };
            let dielectric = self.placed.placement(struck.object()).and_then(|placement| placement.dielectric.as_ref());
            let (Some(dielectric), Some(place)) = (dielectric, self.place(&struck, direction)) else {
                return Vec3::ZERO;
            };
            light *= dielectric.through(place.smooth.dot(unit));
            if !place.enters {
                light *= dielectric.left(struck.t() * length);
            }
            ray = Ray::new(place.behind.to_array(), ray.direction);
        }
        Vec3::ZERO
    }

    /// The place that a ray of a direction meets.
    fn place(&self, struck: &Struck, direction: Vec3) -> Option<Place> {
        match struck {
            Struck::Triangle(hit) => Some(Facet::of(self.placed, hit)?.place(direction)),
            Struck::Implicit(met) => Some(met.place()),
        }
    }

    /// The dielectric body that the camera is in: the last surface that a ray from it finds of one is left there and was
    /// never entered.
    pub fn around_camera(&mut self, direction: Vec3, time: f32) -> Option<u32> {
        if !self.dielectric {
            return None;
        }
        let mut ray = Ray::new([0.0; 3], direction.to_array());
        let mut entered = Vec::new();
        for _ in 0..MAX_SURFACES {
            let struck = self.nearest(&ray, time)?;
            let place = self.place(&struck, direction)?;
            let object = struck.object();
            let dielectric = self.placed.placement(object)?.dielectric.is_some();
            if dielectric && !place.enters && !entered.contains(&object) {
                return Some(object);
            }
            entered.push(object);
            ray = Ray::new(place.behind.to_array(), ray.direction);
        }
        None
    }
}

/// Where a ray in the camera's space meets an implicit surface.
fn meet(
    object: u32,
    placement: &Placement,
    tracer: &mut dyn ImplicitTracer,
    ray: &Ray,
    far: f32,
    time: f32,
) -> Option<Met> {
    let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
    let along = placement.back * direction.as_dvec3();
    let length = along.length() as f32;
    let start = placement.eye + placement.back * (origin + ray.near * direction).as_dvec3();
    let unit = along.try_normalize()?;
    let there = ImplicitRay {
        origin: start.as_vec3().to_array(),
        direction: unit.as_vec3().to_array(),
        far: (far - ray.near) * length,
        time,
    };
    let hit = tracer.intersect(&there)?;
    let t = ray.near + hit.distance / length;
    let point = origin + t * direction;
    let image = placement.normal * Vec3::from(hit.normal);
    // Along the normal a plane that is `margin` away comes to lie this far; and a few units in the last place.
    let margin = hit.margin / image.length().max(f32::MIN_POSITIVE)
        + 4e-6 * (point.abs().max_element() + placement.translation.abs().max_element());
    let normal = image.normalize_or(-direction.normalize_or_zero());
    Some(Met { t, object, point, normal, enters: hit.enters, margin })
}
