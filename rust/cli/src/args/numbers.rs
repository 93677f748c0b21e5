//! Values of options that are several numbers: vectors, pixels, frames.

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

/// Parses the pixels of a picture: WIDTHxHEIGHT, or one number for both.
pub fn pixels(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once('x').unwrap_or((text, text));
    let number = |text: &str| text.trim().parse().map_err(|_| format!("{text:?} is not a number of pixels"));
    Ok([number(width)?, number(height)?])
}

/// Parses the first and the last frame, both included: `A..B`, `A..=B` or `A`.
pub fn frames(text: &str) -> Result<(u32, u32), String> {
    let number = |text: &str| text.trim().parse::<u32>().map_err(|_| format!("{text:?} is no frame number"));
    let (from, to) = match text.split_once("..") {
        Some((from, to)) => (number(from)?, number(to.trim_start_matches('='))?),
        None => (number(text)?, number(text)?),
    };
    if from > to { Err(format!("frame {from} comes after frame {to}")) } else { Ok((from, to)) }
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

    #[test]
    fn pixels_are_one_number_or_two() {
        assert_eq!(pixels("512"), Ok([512, 512]));
        assert_eq!(pixels("64x32"), Ok([64, 32]));
        assert!(pixels("64x").is_err() && pixels("-1").is_err());
    }

    #[test]
    fn frames_are_inclusive_ranges() {
        assert_eq!(frames("3..7"), Ok((3, 7)));
        assert_eq!(frames("3..=7"), Ok((3, 7)));
        assert_eq!(frames("4"), Ok((4, 4)));
        assert!(frames("7..3").is_err() && frames("a..b").is_err() && frames("-1..2").is_err());
    }
}
