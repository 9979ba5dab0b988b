/// Mean and standard deviation of a sample, as in the paper's tables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleMoments {
    /// The mean.
    pub mean: f64,
    /// The sample standard deviation, with divisor `n − 1`; `None` for a single value.
    pub standard_deviation: Option<f64>,
}

impl SampleMoments {
    /// Computes the moments of `values`, any number of them in one unit; `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len() as f64;
        if values.is_empty() {
            return None;
        }
        // Deviations from one of the values give exactly zero for equal values, without rounding errors.
        let about = values[0];
        let mean = about + values.iter().map(|value| value - about).sum::<f64>() / n;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let standard_deviation = (values.len() > 1).then(|| (squares / (n - 1.0)).sqrt());
        Some(Self { mean, standard_deviation })
    }
}
