//! Texels of a face at another number of texels along u and v, both powers of two: the mean of what a smaller one
//! covers, and straight lines between centres where there are to be more.

/// `values` of `width` × `height` texels of `channels` numbers at `size` × `size`. All sizes are powers of two.
pub(crate) fn square(values: &[f32], width: usize, height: usize, channels: usize, size: usize) -> Vec<f32> {
    // Along u, then along v: the same with rows as texels of more channels.
    let mut out = Vec::with_capacity(size * height * channels);
    for row in values.chunks_exact(width * channels) {
        line(row, width, channels, size, &mut out);
    }
    let mut square = Vec::with_capacity(size * size * channels);
    line(&out, height, size * channels, size, &mut square);
    square
}

/// Appends `count` texels of `channels` numbers at `size` texels.
fn line(values: &[f32], count: usize, channels: usize, size: usize, out: &mut Vec<f32>) {
    let at = |k: usize, channel: usize| values[k * channels + channel];
    if size <= count {
        let ratio = count / size;
        let mean = |k: usize, channel: usize| {
            (k * ratio..(k + 1) * ratio).map(|k| f64::from(at(k, channel))).sum::<f64>() / ratio as f64
        };
        (0..size).for_each(|k| out.extend((0..channels).map(|channel| mean(k, channel) as f32)));
        return;
    }
    for k in 0..size {
        // Beyond the first and the last centre the value stays.
        let x = ((k as f32 + 0.5) * count as f32 / size as f32 - 0.5).clamp(0.0, (count - 1) as f32);
        let first = x as usize;
        let (next, share) = ((first + 1).min(count - 1), x - first as f32);
        out.extend((0..channels).map(|c| at(first, c) + (at(next, c) - at(first, c)) * share));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smaller_is_the_mean_and_larger_keeps_lines() {
        let values: Vec<f32> = (0..4 * 2 * 2).map(|i| i as f32).collect();
        // Texels (0, 0), (1, 0), (0, 1), (1, 1) of channel 0 have the means of 0 2 and 4 6, 8 10 and 12 14.
        assert_eq!(square(&values, 4, 2, 2, 2), [1.0, 2.0, 5.0, 6.0, 9.0, 10.0, 13.0, 14.0]);
        assert_eq!(square(&values, 4, 2, 2, 1), [7.0, 8.0]);
        let ramp: Vec<f32> = (0..8).map(|i| i as f32).collect();
        let wide = square(&ramp, 8, 1, 1, 16);
        for row in wide.chunks_exact(16) {
            for (k, value) in row.iter().enumerate() {
                let expected = ((k as f32 + 0.5) / 2.0 - 0.5).clamp(0.0, 7.0);
                assert!((value - expected).abs() < 1e-6);
            }
        }
        assert_eq!(square(&[3.0], 1, 1, 1, 8), [3.0; 64]);
    }
}
