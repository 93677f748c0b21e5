//! Pass 5: from thickness to intensity (Akinci et al. 2013, Section 2.3).

/// Returns the intensity ι(ρ, ρ_mod, ρ_exp) of a thickness ρ, from 0 to 1 (Akinci et al. 2013, Section 2.3).
pub fn intensity(thickness: f32, rho_mod: f32, rho_exp: f32) -> f32 {
    if thickness <= 0.0 {
        return 0.0;
    }
    // The same as ρᵉ/(m + ρᵉ), without an overflow.
    (1.0 + rho_mod * thickness.powf(-rho_exp)).recip()
}
