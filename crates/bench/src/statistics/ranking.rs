/// Computes the area under the ROC curve of a score: the probability that one of the `held` (any number of scores, no unit) has
/// a higher score than one of the `lost`, where ties count half (Hanley & McNeil 1982, whole). `None` if one is empty.
pub fn area_under_curve(held: &[f64], lost: &[f64]) -> Option<f64> {
    let wins = |held: &f64| -> f64 {
        let win = |lost: &f64| match held.total_cmp(lost) {
            std::cmp::Ordering::Greater => 1.0,
            std::cmp::Ordering::Equal => 0.5,
            std::cmp::Ordering::Less => 0.0,
        };
        lost.iter().map(win).sum()
    };
    let pairs = held.len() * lost.len();
    (pairs > 0).then(|| held.iter().map(wins).sum::<f64>() / pairs as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_area_is_the_share_of_pairs_in_order() {
        assert_eq!(area_under_curve(&[2.0, 3.0], &[1.0]), Some(1.0));
        assert_eq!(area_under_curve(&[1.0, 3.0], &[1.0, 2.0]), Some(0.625));
        assert_eq!(area_under_curve(&[], &[1.0]), None);
    }
}
