/// Adjusts the p-values (no unit) of a family of tests, so that with probability 95 % none below 0.05 occurs by chance
/// alone; returns as many, in their order.
///
/// With the p-values in rising order, `p̃₍ᵢ₎ = max over j ≤ i of min(1, (m − j + 1) p₍ⱼ₎)`, so `p ≤ p̃ ≤ min(1, m p)`, and
/// the order of the tests is kept.
///
/// # Panics
/// If one is NaN.
///
/// Source: Holm 1979, "A simple sequentially rejective multiple test procedure", §3.
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    assert!(p_values.iter().all(|p| !p.is_nan()), "a p-value is a number");
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let mut adjusted = vec![0.0; p_values.len()];
    let mut greatest = 0.0_f64;
    for (rank, &index) in order.iter().enumerate() {
        let factor = (p_values.len() - rank) as f64;
        greatest = greatest.max((factor * p_values[index]).min(1.0));
        adjusted[index] = greatest;
    }
    adjusted
}
