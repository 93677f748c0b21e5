//! The falloff of particles (Akinci et al. 2013, Equation 1), and a table of it.

/// Returns the falloff f(x, b, n, m) = (1 − (x/b)ⁿ)ᵐ, which is 0 beyond `b` and 1 at 0 (Akinci et al. 2013, Equation 1).
pub fn falloff(x: f32, b: f32, n: f32, m: f32) -> f32 {
    let share = x / b;
    if share > 1.0 || share.is_nan() {
        return 0.0;
    }
    let share = share.max(0.0);
    // The exponent of lifetimes is 2 unless it is set, and this is done for every particle.
    let powered = if n == 2.0 { share * share } else { share.powf(n) };
    (1.0 - powered).max(0.0).powf(m)
}

/// Cells of a table. Between its entries the falloffs of particles are off by less than 1e-5.
const CELLS: usize = 1024;

/// A falloff over 0 to 1, looked up for every fragment.
#[derive(Clone, Debug)]
pub struct Table(Vec<f32>);

impl Table {
    /// Makes the table of f(x, 1, n, m), or of 1 less that.
    pub fn new(n: f32, m: f32, is_inverted: bool) -> Self {
        let value = |at: usize| {
            let value = falloff(at as f32 / CELLS as f32, 1.0, n, m);
            if is_inverted { 1.0 - value } else { value }
        };
        Self((0..=CELLS).map(value).collect())
    }

    /// Returns the falloffs at all multiples of 1/1024 from 0 to 1.
    pub fn entries(&self) -> &[f32] {
        &self.0
    }

    /// Returns the falloff at `x`, 0 to 1.
    #[inline]
    pub fn at(&self, x: f32) -> f32 {
        let place = x * CELLS as f32;
        let cell = (place as usize).min(CELLS - 1);
        let (low, high) = (self.0[cell], self.0[cell + 1]);
        low + (place - cell as f32) * (high - low)
    }
}
