//! The degree to which a feature vector belongs to the positive class (Section 5, Equation 2).
//!
//! The degree is `Σ cᵢ wᵢ / Σ wᵢ` over the examples, with cᵢ 1 for positive and 0 for negative ones and `wᵢ = 1 / dᵢᵖ`. All
//! weights are computed relative to that of the nearest example, `wᵢ = (d_min / dᵢ)ᵖ`, which changes no degree and cannot
//! overflow. A vector that equals examples belongs to their class; if they contradict each other, to the share of positive
//! ones among them. Without examples every degree is 0.5.

use crate::instrument::MAX_DIFFERENCE;

/// Returns the degree, 0 to 1, to which a vector belongs to the positive class, in f32 as shaders compute it.
///
/// Each example has 1 or 0 for its class and its vector; `factors` multiply the differences of features; `exponent` is p, above
/// 0. A vector that is not finite has the degree 0.5. Shorter slices leave the features without a partner out.
pub fn membership<'a>(
    vector: &[f32],
    examples: impl IntoIterator<Item = (f32, &'a [f32])>,
    factors: &[f32],
    exponent: f32,
) -> f32 {
    if !vector.iter().all(|value| value.is_finite()) {
        return 0.5;
    }
    let halved = 0.5 * exponent;
    let mut sums: Option<[f32; 3]> = None;
    for (class, example) in examples {
        let mut distance = 0.0_f32;
        for ((value, other), factor) in vector.iter().zip(example).zip(factors) {
            let difference = ((value - other) * factor).clamp(-MAX_DIFFERENCE, MAX_DIFFERENCE);
            distance += difference * difference;
        }
        sums = Some(match sums {
            None => [class, 1.0, distance],
            Some([belongs, total, nearest]) if distance < nearest => {
                let ratio = if distance > 0.0 { (distance / nearest).powf(halved) } else { 0.0 };
                [belongs * ratio + class, total * ratio + 1.0, distance]
            }
            Some([belongs, total, nearest]) => {
                let ratio = match nearest {
                    _ if distance == nearest => 1.0,
                    0.0 => 0.0,
                    _ => (nearest / distance).powf(halved),
                };
                [belongs + ratio * class, total + ratio, nearest]
            }
        });
    }
    sums.map_or(0.5, |[belongs, total, _]| belongs / total)
}
