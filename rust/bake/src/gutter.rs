//! The gutter: pixels around what is covered get the nearest covered pixel's numbers, so that filters and reductions
//! find no background.
//!
//! Sources are handed on from pixel to pixel, eight neighbours at a time, and a pixel takes the nearest of those it is
//! offered, of several the first in the picture. Every pixel up to the gutter's width away along rows, columns or
//! diagonals is filled. Units: pixels.

/// What the gutter of a picture copies.
#[derive(Debug)]
pub struct Gutter {
    /// Pixels of the gutter and the covered pixels they are copies of, ascending.
    pub copies: Vec<(u32, u32)>,
}

impl Gutter {
    /// Returns the gutter of `distance` pixels around the pixels of a picture that are `covered`, row by row.
    pub fn new(covered: &[bool], width: usize, distance: u32) -> Self {
        let height = covered.len() / width.max(1);
        let around = |pixel: usize| {
            let (x, y) = (pixel % width, pixel / width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            rows.flat_map(move |j| (x.saturating_sub(1)..(x + 2).min(width)).map(move |i| j * width + i))
        };
        let mut filled = covered.to_vec();
        let mut front: Vec<(u32, u32)> = Vec::new();
        if distance > 0 {
            let borders =
                (0..covered.len()).filter(|pixel| covered[*pixel] && around(*pixel).any(|other| !covered[other]));
            front.extend(borders.map(|pixel| (pixel as u32, pixel as u32)));
        }
        let mut copies = Vec::new();
        for _ in 0..distance {
            let mut offers = Vec::with_capacity(3 * front.len());
            for (pixel, source) in &front {
                for other in around(*pixel as usize).filter(|other| !filled[*other]) {
                    let apart =
                        |f: fn(usize, usize) -> usize| f(other, width).abs_diff(f(*source as usize, width)) as u64;
                    let square = apart(|p, w| p % w).pow(2) + apart(|p, w| p / w).pow(2);
                    offers.push((other as u32, square, *source));
                }
            }
            offers.sort_unstable();
            offers.dedup_by_key(|offer| offer.0);
            front = offers.into_iter().map(|(pixel, _, source)| (pixel, source)).collect();
            front.iter().for_each(|(pixel, _)| filled[*pixel as usize] = true);
            copies.extend_from_slice(&front);
            if front.is_empty() {
                break;
            }
        }
        copies.sort_unstable();
        Self { copies }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_within_the_distance_is_filled_with_the_nearest() {
        let (width, height) = (40, 30);
        let mut covered = vec![false; width * height];
        let set = [(5, 5), (6, 5), (30, 20), (31, 21), (20, 2)];
        set.iter().for_each(|(x, y)| covered[y * width + x] = true);
        let gutter = Gutter::new(&covered, width, 6);
        let mut filled = covered.clone();
        for (pixel, source) in &gutter.copies {
            assert!(covered[*source as usize] && !covered[*pixel as usize]);
            filled[*pixel as usize] = true;
            let square = |x: usize, y: usize| {
                let (i, j) = (*pixel as usize % width, *pixel as usize / width);
                i.abs_diff(x).pow(2) + j.abs_diff(y).pow(2)
            };
            let nearest = set.iter().map(|(x, y)| square(*x, *y)).min().unwrap();
            let found = square(*source as usize % width, *source as usize / width);
            assert!(found <= nearest + 2, "{found} {nearest}");
        }
        for pixel in 0..covered.len() {
            let near = |(x, y): &(usize, usize)| (pixel % width).abs_diff(*x).max((pixel / width).abs_diff(*y)) <= 6;
            assert_eq!(filled[pixel], set.iter().any(near));
        }
        assert!(Gutter::new(&covered, width, 0).copies.is_empty());
        assert!(Gutter::new(&[true; 12], 4, 5).copies.is_empty() && Gutter::new(&[], 0, 5).copies.is_empty());
    }
}
