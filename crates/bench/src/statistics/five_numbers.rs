use serde::Serialize;

/// Five-number summary of a sample, as in a box plot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FiveNumbers {
    /// Number of values.
    pub count: usize,
    /// The least value.
    pub least: f64,
    /// The least value that a quarter of the values do not exceed.
    pub lower_quartile: f64,
    /// The least value that half of the values do not exceed.
    pub median: f64,
    /// The least value that three quarters of the values do not exceed.
    pub upper_quartile: f64,
    /// The greatest value.
    pub greatest: f64,
}

impl FiveNumbers {
    /// Computes the summary of `values`; `None` if there are none. Each number is one of the values, as in a Kaplan–Meier
    /// estimate ([`KaplanMeier::quantile`](crate::statistics::KaplanMeier::quantile)): Hyndman & Fan 1996, "Sample
    /// quantiles in statistical packages", definition 1; `inverted_cdf` in `NumPy`.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (&least, &greatest) = (sorted.first()?, sorted.last()?);
        Some(Self {
            count: sorted.len(),
            least,
            lower_quartile: quantile(&sorted, 0.25),
            median: quantile(&sorted, 0.5),
            upper_quartile: quantile(&sorted, 0.75),
            greatest,
        })
    }
}

/// Returns the least value that a `share` of all do not exceed; `share` is in ]0, 1], `sorted` is not empty.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count that is not negative and small"
)]
fn quantile(sorted: &[f64], share: f64) -> f64 {
    // Quarters of counts below 2^52 are exact.
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted[rank.clamp(1, sorted.len()) - 1]
}
