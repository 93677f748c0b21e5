//! Pass 6, second part: light from the environment, by the normal of the nearest particle (Akinci et al. 2013,
//! Section 2.4.2).

use glam::Vec3;
use relievo_core::Context;

use super::depth::normal;
use super::environment::Environment;
use super::halton::Ball;
use super::layers::Shading;
use super::occlusion::samples;

/// Returns the irradiance of every pixel, black where there is no foam. A white environment gives 1: the cosines by which
/// samples are weighted are divided out, which the paper leaves to the factor of irradiance.
pub fn irradiance(context: &Context, of: &Shading<'_>, environment: &Environment) -> Vec<[f32; 3]> {
    let Shading { settings, view, projection, surfaces, intensity, .. } = *of;
    let map = settings.irradiance_map.is_on().then(|| environment.irradiance(context));
    let ball = Ball::new(settings.ao_max_samp.max(settings.ao_min_samp));
    let width = view.width as usize;
    let rows = context.map(view.height as usize, |y| {
        let of_pixel = |x: usize| {
            let at = y * width + x;
            if intensity[at] == 0.0 {
                return [0.0; 3];
            }
            let [u, v] = surfaces.disc[at];
            let normal = projection.to_world(normal(u, v)).normalize();
            let value = match &map {
                Some(map) => map.at(normal),
                None => {
                    let count = samples(settings, surfaces.search[at] * settings.ao_init_sr_fac);
                    mean(environment, &ball, count, normal)
                }
            };
            value.to_array()
        };
        (0..width).map(of_pixel).collect::<Vec<_>>()
    });
    rows.concat()
}

/// Returns the mean of the radiance over samples in the hemisphere about a normal, weighted by their cosines.
fn mean(environment: &Environment, ball: &Ball, count: u32, normal: Vec3) -> Vec3 {
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for sample in ball.of(count) {
        let Some(direction) = sample.place.try_normalize() else { continue };
        let cosine = direction.dot(normal);
        sum += cosine.abs() * environment.radiance(direction * cosine.signum());
        weights += cosine.abs();
    }
    if weights > 0.0 { sum / weights } else { Vec3::ZERO }
}
