//! Units of the stages that are written.

/// What lengths, axes and times of a stage are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageOptions {
    /// Metres of a unit of length.
    pub meters_per_unit: f64,
    /// Whether z is up; y otherwise.
    pub z_up: bool,
    /// Time codes of a second, which is also the number of frames of a second.
    pub time_codes_per_second: f64,
}

impl Default for StageOptions {
    /// Metres, y up, 24 time codes a second: what [`crate::read_usd`] leaves as it is.
    fn default() -> Self {
        Self { meters_per_unit: 1.0, z_up: false, time_codes_per_second: 24.0 }
    }
}
