//! Chromaticities: which colours red, green, blue and white of a picture are, as CIE 1931 x and y, and the matrix that
//! takes its colours to Rec.709.
//!
//! Primaries and white give the matrix to XYZ (SMPTE RP 177:1993, Section 3.3). Between different whites, colours are
//! adapted by the Bradford transform (Lam 1985; ICC.1:2010, Annex E), so that what is neutral stays so.

use glam::{DMat3, DVec2, DVec3};
use relievo_core::{Error, Result};

/// Where the primaries and white are, CIE 1931 x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chromaticities {
    /// Red.
    pub red: [f32; 2],
    /// Green.
    pub green: [f32; 2],
    /// Blue.
    pub blue: [f32; 2],
    /// White.
    pub white: [f32; 2],
}

/// Those of Rec. ITU-R BT.709, whose white is D65.
pub const REC_709: Chromaticities =
    Chromaticities { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: [0.3127, 0.3290] };

/// Chromaticities that differ by less are the same; files round theirs.
const SAME: f64 = 1e-5;

/// From XYZ to the responses of cones by which the Bradford transform adapts.
const BRADFORD: DMat3 = DMat3::from_cols_array(&[
    0.8951, -0.7502, 0.0389, //
    0.2664, 1.7135, -0.0685, //
    -0.1614, 0.0367, 1.0296,
]);

/// The colour of luminance 1 at x and y, as XYZ.
fn xyz([x, y]: [f32; 2]) -> DVec3 {
    let (x, y) = (f64::from(x), f64::from(y));
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

impl Chromaticities {
    /// The matrix from linear colours of these primaries to linear Rec.709, `None` if they are Rec.709's.
    ///
    /// # Errors
    /// No matrix exists: a number is not finite, a luminance is zero, or the primaries are on one line.
    pub fn to_rec_709(self) -> Result<Option<DMat3>> {
        let pairs = |of: Self| [of.red, of.green, of.blue, of.white];
        let distance = |(a, b): ([f32; 2], [f32; 2])| DVec2::from(a.map(f64::from)).distance(b.map(f64::from).into());
        if pairs(self).into_iter().zip(pairs(REC_709)).map(distance).all(|distance| distance < SAME) {
            return Ok(None);
        }
        let cones = |white| BRADFORD * xyz(white);
        let adaptation = BRADFORD.inverse() * DMat3::from_diagonal(cones(REC_709.white) / cones(self.white)) * BRADFORD;
        let matrix = REC_709.to_xyz().inverse() * adaptation * self.to_xyz();
        // No real space comes near these; numbers beyond would only make infinities.
        if !(matrix.is_finite() && matrix.determinant().abs() > 1e-6 && matrix.abs_diff_eq(DMat3::ZERO, 1e3)) {
            return Err(Error::invalid("its chromaticities are not those of a colour space")
                .advise("write it with the right ones, or as linear Rec.709"));
        }
        Ok(Some(matrix))
    }

    /// The matrix from linear colours to XYZ; white has luminance 1.
    fn to_xyz(self) -> DMat3 {
        let primaries = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        primaries * DMat3::from_diagonal(primaries.inverse() * xyz(self.white))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(from: Chromaticities, rows: [[f64; 3]; 3], tolerance: f64) {
        let found = from.to_rec_709().unwrap().unwrap();
        let expected = DMat3::from_cols_array_2d(&rows).transpose();
        assert!(found.abs_diff_eq(expected, tolerance), "{found} {expected}");
        assert!((found * DVec3::ONE).abs_diff_eq(DVec3::ONE, 1e-6), "white stays white");
    }

    #[test]
    fn rec_2020_is_converted_as_bt_2087_says() {
        let rec_2020 = Chromaticities { red: [0.708, 0.292], green: [0.170, 0.797], blue: [0.131, 0.046], ..REC_709 };
        let rows = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
        check(rec_2020, rows, 6e-5);
    }

    #[test]
    fn aces_is_converted_as_its_configurations_do() {
        // The matrix of the ACES configuration of OpenColorIO, from AP0 with its white to sRGB's primaries with D65.
        let ap0 = Chromaticities {
            red: [0.7347, 0.2653],
            green: [0.0, 1.0],
            blue: [0.0001, -0.0770],
            white: [0.32168, 0.33767],
        };
        let rows = [[2.52169, -1.13413, -0.38756], [-0.27648, 1.37272, -0.09624], [-0.01538, -0.15298, 1.16835]];
        check(ap0, rows, 2e-5);
    }

    #[test]
    fn rec_709_needs_nothing_and_nonsense_is_refused() {
        assert_eq!(REC_709.to_rec_709().unwrap(), None);
        for spoiled in [
            Chromaticities { white: [0.3, 0.0], ..REC_709 },
            Chromaticities { red: [f32::NAN, 0.3], ..REC_709 },
            Chromaticities { green: [0.64, 0.33], ..REC_709 },
            Chromaticities { blue: [0.15, 0.0], ..REC_709 },
        ] {
            assert!(spoiled.to_rec_709().is_err(), "{spoiled:?}");
        }
    }
}
