/// Returns for each pixel of an image the value that `pick` chooses among those at most `reach` away along both axes and within the
/// image.
pub(crate) fn window(
    image: &[f32],
    [width, height]: [usize; 2],
    reach: usize,
    pick: impl Fn(f32, f32) -> f32 + Copy,
) -> Vec<f32> {
    let choose = |target: &mut [f32], values: &[f32]| {
        for (chosen, value) in target.iter_mut().zip(values) {
            *chosen = pick(*chosen, *value);
        }
    };
    let mut across = image.to_vec();
    for shift in 1..=reach.min(width - 1) {
        for (target, row) in across.chunks_exact_mut(width).zip(image.chunks_exact(width)) {
            choose(&mut target[shift..], row);
            choose(target, &row[shift..]);
        }
    }
    let mut both = across.clone();
    for shift in 1..=reach.min(height - 1) {
        choose(&mut both[shift * width..], &across);
        choose(&mut both, &across[shift * width..]);
    }
    both
}

/// Returns the lesser of two numbers that are not NaN, in one instruction.
#[inline(always)]
pub(crate) fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Returns the greater of two numbers that are not NaN, in one instruction.
#[inline(always)]
pub(crate) fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Stream;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_window_chooses_among_its_pixels(seed in any::<u64>(), width in 1_usize..12, height in 1_usize..12, reach in 0_usize..4) {
            let mut random = Stream::new(seed, 0);
            #[allow(clippy::cast_possible_truncation, reason = "pixels")]
            let image: Vec<f32> = (0..width * height).map(|_| random.uniform() as f32).collect();
            let found = window(&image, [width, height], reach, lesser);
            for v in 0..height {
                for u in 0..width {
                    let rows = v.saturating_sub(reach)..=(v + reach).min(height - 1);
                    let columns = u.saturating_sub(reach)..=(u + reach).min(width - 1);
                    let all = rows.flat_map(|row| columns.clone().map(move |column| row * width + column));
                    let least = all.map(|place| image[place]).fold(f32::INFINITY, f32::min);
                    prop_assert!((found[v * width + u] - least).abs() <= 0.0);
                }
            }
        }
    }
}
