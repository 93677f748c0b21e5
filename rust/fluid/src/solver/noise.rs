//! Smooth noise without sources.

use glam::Vec3;

/// What makes the curl as long as 1 in the mean square.
const LENGTH: f32 = 0.61;

/// A number in −1..1 for a corner of a lattice in space and time.
fn value([x, y, z, t]: [i32; 4], seed: u32) -> f32 {
    let mut mixed = seed.wrapping_mul(0x9e37_79b1) ^ 0x85eb_ca6b;
    for at in [x, y, z, t] {
        mixed = (mixed ^ at as u32).wrapping_mul(0xcc9e_2d51);
        mixed = (mixed ^ mixed >> 15).wrapping_mul(0x1b87_3593);
        mixed ^= mixed >> 13;
    }
    (mixed >> 8) as f32 / (1 << 23) as f32 - 1.0
}

/// A weight that goes from 0 to 1 with no slope or bend at its ends (Perlin 2002), and its slope.
fn fade(at: f32) -> [f32; 2] {
    let bend = at * (at - 1.0);
    [at * at * at * (at * (6.0 * at - 15.0) + 10.0), 30.0 * bend * bend]
}

/// The slice of noise that a time has passed last, and the weight of the next one.
pub fn slice(time: f64) -> (i32, f32) {
    // Times come again after 2³¹, as places do.
    let slice = time.floor();
    let [later, _] = fade((time - slice) as f32);
    (slice.rem_euclid(2_147_483_648.0) as i32, later)
}

/// The slope of noise on a lattice of a unit, interpolated in space and time.
fn slope(place: Vec3, time: f64, seed: u32) -> Vec3 {
    let cell = place.floor();
    let [ix, iy, iz] = cell.as_ivec3().to_array();
    let within = place - cell;
    let [[x, dx], [y, dy], [z, dz]] = within.to_array().map(fade);
    let (slice, later) = slice(time);
    let mut sum = Vec3::ZERO;
    for corner in 0..8 {
        let [a, b, c] = [corner & 1, corner >> 1 & 1, corner >> 2];
        let at = |slice: i32| value([ix.wrapping_add(a), iy.wrapping_add(b), iz.wrapping_add(c), slice], seed);
        let now = at(slice);
        let height = now + later * (at(slice.wrapping_add(1)) - now);
        let weight = |side: i32, to: f32, slope: f32| if side == 1 { [to, slope] } else { [1.0 - to, -slope] };
        let [[wx, sx], [wy, sy], [wz, sz]] = [weight(a, x, dx), weight(b, y, dy), weight(c, z, dz)];
        sum += height * Vec3::new(sx * wy * wz, wx * sy * wz, wx * wy * sz);
    }
    sum
}

/// The curl of three such noises, of about the length 1 in the mean.
pub fn curl(place: Vec3, time: f64, seed: u32) -> Vec3 {
    let [x, y, z] = [0, 1, 2].map(|axis| slope(place, time, seed.wrapping_mul(3).wrapping_add(axis)));
    LENGTH * Vec3::new(z.y - y.z, x.z - z.x, y.x - x.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eddies_have_no_sources_and_a_length_of_one() {
        let (mut square, step) = (0.0, 1e-2);
        for number in 0..500 {
            let place = Vec3::from([0.37, 0.61, 0.83].map(|share| number as f32 * share - 90.0));
            let time = f64::from(number) * 0.13;
            let along = |axis: usize| {
                let ends = [0.5 * step, -0.5 * step].map(|off| curl(place + off * Vec3::AXES[axis], time, 7)[axis]);
                (ends[0] - ends[1]) / step
            };
            assert!((along(0) + along(1) + along(2)).abs() < 0.02, "{place}");
            square += curl(place, time, 7).length_squared() / 500.0;
        }
        assert!((0.8..1.25).contains(&square.sqrt()), "{}", square.sqrt());
        assert!(curl(Vec3::ONE * 0.3, 0.0, 1) != curl(Vec3::ONE * 0.3, 0.0, 2));
        assert!(curl(Vec3::ONE * 1e30, 1e30, 1).is_finite());
    }
}
