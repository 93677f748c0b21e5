// How the influence of brushes and handles falls, as `Falloff` of rust/core.

/// The bell at r = 1, before it is lowered.
const RIM: f32 = 0.011108997;

/// The share at a place whose r² is `square`, of a formula by its number.
fn falloff_share(formula: u32, square: f32) -> f32 {
    if formula == 0u {
        return 1.0;
    }
    if square >= 1.0 {
        return 0.0;
    }
    let r = sqrt(square);
    switch formula {
        case 1u: {
            return 1.0 - r;
        }
        case 2u: {
            return (1.0 - r) * (1.0 - r) * (1.0 + 2.0 * r);
        }
        case 3u: {
            return sqrt(1.0 - square);
        }
        default: {
            return (exp(-4.5 * square) - RIM) / (1.0 - RIM);
        }
    }
}
