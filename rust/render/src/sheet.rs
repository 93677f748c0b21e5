//! Contact sheets: pictures of the same scenes beside each other, and what differs, made visible.

use relievo_core::{Error, Result};

use crate::color::{Color, encode_srgb};
use crate::image::Image;
use crate::legend::{INK, draw_text};
use crate::picture::{Picture, check_sizes};

/// Pixels between pictures, and around all.
const GAP: u32 = 8;
/// Size of a letter's dots, and the height of a line of text with them.
const DOT: u32 = 2;
const LINE: u32 = 11 * DOT;
/// How much differences of display colours are amplified.
const GAIN: f32 = 20.0;
/// What is seen where nothing is, and between pictures; scene-linear.
const EMPTY: Color = [0.09; 3];
const PAPER: Color = [0.012; 3];
/// Pixels that only one picture covers, in differences.
const ALONE: Color = [0.9, 0.35, 0.0];

/// A row of a contact sheet.
#[derive(Clone, Debug)]
pub struct Row {
    /// What is seen.
    pub label: String,
    /// The pictures, of one size; the others are compared with the first.
    pub pictures: Vec<Picture>,
}

/// A sheet of `width` pixels: a column for each of the names, then one for what every picture but the first has other than
/// that, display colours amplified. Pixels that only one covers are orange.
///
/// # Errors
/// A row has no or not as many pictures as there are names, their sizes differ, or the sheet is too narrow for them.
pub fn contact_sheet(names: &[String], rows: &[Row], width: u32) -> Result<Image> {
    let columns = (2 * names.len()).saturating_sub(1) as u32;
    let room = width.saturating_sub((columns + 1) * GAP);
    if names.is_empty() || rows.is_empty() || room < columns * 16 {
        return Err(Error::invalid(format!("a sheet of {width} pixels has no room for {columns} pictures in a row"))
            .advise("make it wider"));
    }
    let cell = room / columns;
    let mut heights = Vec::with_capacity(rows.len());
    for row in rows {
        let [first, ..] = row.pictures.as_slice() else {
            return Err(Error::invalid("a row without a picture").at(row.label.clone()));
        };
        if row.pictures.len() != names.len() {
            let (found, wanted) = (row.pictures.len(), names.len());
            return Err(Error::invalid(format!("{found} pictures for {wanted} names")).at(row.label.clone()));
        }
        for other in &row.pictures {
            check_sizes(first, other).map_err(|error| error.at(row.label.clone()))?;
        }
        let height = u64::from(cell) * u64::from(first.color.height()) / u64::from(first.color.width());
        heights.push(u32::try_from(height.max(1)).unwrap_or(u32::MAX));
    }
    let total: u64 = heights.iter().map(|height| u64::from(*height) + u64::from(GAP + LINE)).sum();
    let height = u32::try_from(total + u64::from(2 * GAP + LINE)).unwrap_or(u32::MAX);
    if u64::from(width) * u64::from(height) > 1 << 28 {
        return Err(Error::unsupported(format!("a sheet of {width}×{height} pixels")).advise("make it narrower"));
    }
    let mut sheet = Image::from_data(width, height, 3, PAPER.repeat(width as usize * height as usize))?;
    let left = |column: usize| GAP + column as u32 * (cell + GAP);
    let off = |name: &String| format!("{name}: OFF X{GAIN}");
    let heads = names.iter().cloned().chain(names.iter().skip(1).map(off));
    for (column, head) in heads.enumerate() {
        draw_text(&mut sheet, [left(column), GAP], DOT, left(column) + cell, INK, &head);
    }
    let mut top = GAP + LINE;
    for (row, height) in rows.iter().zip(heights) {
        draw_text(&mut sheet, [GAP, top + DOT], DOT, width, INK, &row.label);
        top += LINE;
        let shown: Vec<Image> = row.pictures.iter().map(shown).collect();
        let differences = row
            .pictures
            .iter()
            .zip(&shown)
            .skip(1)
            .map(|(test, image)| difference(&row.pictures[0], &shown[0], test, image));
        let differences: Vec<Image> = differences.collect();
        for (column, image) in shown.iter().chain(&differences).enumerate() {
            place(&mut sheet, image, [left(column), top, cell, height]);
        }
        top += height + GAP;
    }
    Ok(sheet)
}

/// The colours of a picture over those of an empty background.
fn shown(picture: &Picture) -> Image {
    let mut image = picture.color.clone();
    for (pixel, covered) in image.data_mut().chunks_exact_mut(3).zip(picture.covered().into_iter().flatten()) {
        if !covered {
            pixel.copy_from_slice(&EMPTY);
        }
    }
    image
}

/// What a picture has other than the reference.
fn difference(reference: &Picture, ours: &Image, test: &Picture, theirs: &Image) -> Image {
    let mut image = ours.clone();
    for (pixel, value) in image.data_mut().iter_mut().zip(theirs.data()) {
        let display = |value: f32| encode_srgb(value.clamp(0.0, 1.0));
        let off = GAIN * (display(*value) - display(*pixel)).abs();
        *pixel = crate::color::decode_srgb(off.min(1.0));
    }
    let covered = reference.covered().into_iter().flatten().zip(test.covered().into_iter().flatten());
    for (pixel, _) in image.data_mut().chunks_exact_mut(3).zip(covered).filter(|(_, (ours, theirs))| ours != theirs) {
        pixel.copy_from_slice(&ALONE);
    }
    image
}

/// Puts a picture into the rectangle [left, top, width, height]; pixels of the sheet are means of what they cover.
fn place(sheet: &mut Image, image: &Image, [left, top, width, height]: [u32; 4]) {
    let across = shares(image.width(), width);
    let down = shares(image.height(), height);
    for (y, rows) in (top..).zip(&down) {
        for (x, columns) in (left..).zip(&across) {
            let mut mean = [0.0; 3];
            for (row, high) in rows {
                for (column, wide) in columns {
                    let color = image.color(*column, *row);
                    (0..3).for_each(|k| mean[k] += color[k].clamp(0.0, 1.0) * high * wide);
                }
            }
            sheet.set_color(x, y, mean);
        }
    }
}

/// For each of `to` pixels in a row those of `from` pixels that it covers, with their shares of it.
fn shares(from: u32, to: u32) -> Vec<Vec<(u32, f32)>> {
    let step = f64::from(from) / f64::from(to);
    let covered = |at: u32| {
        let (start, end) = (f64::from(at) * step, f64::from(at + 1) * step);
        let last = (end.ceil() as u32).min(from);
        let part = move |pixel: u32| (end.min(f64::from(pixel + 1)) - start.max(f64::from(pixel))).max(0.0);
        (start as u32..last).map(move |pixel| (pixel, (part(pixel) / step) as f32)).collect()
    };
    (0..to).map(covered).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(color: Color, covered: u32) -> Picture {
        let (width, height) = (40, 30);
        let alpha = (0..width * height).map(|at| f32::from(u8::from(at % width < covered)));
        Picture {
            color: Image::from_data(width, height, 3, color.repeat(1200)).unwrap(),
            alpha: Some(Image::from_data(width, height, 1, alpha.collect()).unwrap()),
            depth: None,
            normal: None,
        }
    }

    fn names(count: usize) -> Vec<String> {
        ["A", "B", "C"].iter().take(count).map(ToString::to_string).collect()
    }

    #[test]
    fn pictures_stand_beside_their_differences() {
        let light = [0.5; 3];
        let row = Row { label: "ROW".into(), pictures: vec![picture(light, 40), picture(light, 20)] };
        let sheet = contact_sheet(&names(2), &[row], 4 * GAP + 3 * 40).unwrap();
        assert_eq!((sheet.width(), sheet.height()), (152, 30 + 3 * GAP + 2 * LINE));
        let middle = GAP + 2 * LINE + 15;
        let near = |x: u32, expected: Color| {
            let found = sheet.color(x, middle);
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-5), "{x}: {found:?} {expected:?}");
        };
        let left = |column: u32| GAP + column * (40 + GAP);
        near(left(0) + 30, light);
        near(left(1) + 10, light);
        near(left(1) + 30, EMPTY);
        near(left(2) + 10, [0.0; 3]);
        near(left(2) + 30, ALONE);
        near(left(1) - 4, PAPER);
    }

    #[test]
    fn small_differences_are_amplified_and_pictures_averaged() {
        // Two display steps of 255, which are amplified to 40.
        let (a, b) = ([crate::color::decode_srgb(0.4); 3], [crate::color::decode_srgb(0.4 + 2.0 / 255.0); 3]);
        let row = Row { label: String::new(), pictures: vec![picture(a, 40), picture(b, 40)] };
        let sheet = contact_sheet(&names(2), &[row], 4 * GAP + 3 * 16).unwrap();
        let off = sheet.color(GAP + 2 * (16 + GAP) + 8, GAP + 2 * LINE + 6)[0];
        assert!((encode_srgb(off) - 40.0 / 255.0).abs() < 1e-3, "{off}");
        for (from, to) in [(40, 16), (7, 7), (3, 5)] {
            let all = shares(from, to);
            assert!(all.iter().all(|parts| (parts.iter().map(|(_, share)| share).sum::<f32>() - 1.0).abs() < 1e-5));
            assert!(all.iter().flatten().all(|(pixel, _)| *pixel < from));
        }
    }

    #[test]
    fn rows_that_do_not_fit_are_refused() {
        let good = picture([0.1; 3], 40);
        let small = Picture { color: Image::new(4, 4, 3).unwrap(), alpha: None, depth: None, normal: None };
        let row = |pictures: Vec<Picture>| [Row { label: "R".into(), pictures }];
        assert!(contact_sheet(&names(2), &row(vec![good.clone()]), 400).is_err());
        assert!(contact_sheet(&names(2), &row(vec![good.clone(), small]), 400).is_err());
        assert!(contact_sheet(&names(2), &row(vec![good.clone(), good.clone()]), 60).is_err());
        assert!(contact_sheet(&[], &row(Vec::new()), 400).is_err());
        assert!(contact_sheet(&names(1), &[], 400).is_err());
    }
}
