//! Values of options that are numbers with commas between them.

use glam::DVec3;

/// Parses `COUNT` finite numbers with commas between them.
pub fn numbers<const COUNT: usize>(text: &str) -> Result<[f64; COUNT], String> {
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let parsed: Option<Vec<f64>> = text.split(',').map(number).collect();
    parsed
        .and_then(|parsed| parsed.try_into().ok())
        .ok_or_else(|| format!("{text:?} is not {COUNT} numbers with commas between them"))
}

/// Parses the three numbers of a vector.
pub fn vector(text: &str) -> Result<DVec3, String> {
    numbers(text).map(DVec3::from_array)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn so_many_finite_numbers_are_needed() {
        assert_eq!(vector(" 1, -2.5,3e2"), Ok(DVec3::new(1.0, -2.5, 300.0)));
        for wrong in ["", "1,2", "1,2,3,4", "1,,3", "1,2,nan", "1,2,inf", "x,2,3"] {
            assert!(vector(wrong).is_err(), "{wrong}");
        }
    }
}
