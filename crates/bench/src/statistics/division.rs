use cranny_spatial::Stream;

/// Maximum number of divisions that are all enumerated: 9 trials against 9 have 48 620.
const MOST_ENUMERATED: f64 = 50_000.0;

/// Number of random divisions of larger samples for a single test; [`draws_for`] makes more for several tests.
const LEAST_DRAWS: usize = 9_999;

/// Returns the number of divisions of `first + second` trials into groups of these sizes: the binomial coefficient, which
/// is exact below 2⁵³.
pub fn division_count(first: usize, second: usize) -> f64 {
    let smaller = first.min(second);
    (1..=smaller).fold(1.0, |count, i| count * (first + second - smaller + i) as f64 / i as f64)
}

/// Returns the number of random divisions that a family of `tests` needs: the least two-sided p-value, `2/(draws + 1)`,
/// stays below a quarter of the strictest level, `0.05/tests`.
pub fn draws_for(tests: usize) -> usize {
    LEAST_DRAWS.max(160 * tests)
}

/// Calls `visit` with each division of the trials `0..first + second` into two groups of the given sizes, as the indices of the
/// first group, beginning with the observed one, `0..first`. If there are too many, the others are `draws` random ones with a
/// fixed seed. As the observed division is counted, a p-value is valid as a share of the visited ones.
///
/// Source: Phipson & Smyth 2010, "Permutation p-values should never be zero", §3.
pub fn for_each_division(first: usize, second: usize, draws: usize, mut visit: impl FnMut(&[usize])) {
    let all = first + second;
    let mut members: Vec<usize> = (0..first).collect();
    if division_count(first, second) <= MOST_ENUMERATED {
        loop {
            visit(&members);
            // The next combination in lexicographic order.
            let Some(place) = (0..first).rev().find(|&place| members[place] < all - first + place) else {
                return;
            };
            members[place] += 1;
            for later in place + 1..first {
                members[later] = members[later - 1] + 1;
            }
        }
    }
    visit(&members);
    let mut random = Stream::new(0, 0);
    let mut order: Vec<usize> = (0..all).collect();
    for _ in 0..draws {
        // The first swaps of a shuffle of any order are a uniform choice (Knuth 1997, "The art of computer programming" 2,
        // §3.4.2, Algorithm P).
        for place in 0..first {
            order.swap(place, place + random.index(all - place));
        }
        visit(&order[..first]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::float_cmp, reason = "small counts are exact")]
    fn small_groups_are_divided_in_every_way_once_and_large_ones_at_random() {
        for (first, second, count) in [(1, 1, 2), (3, 3, 20), (2, 5, 21), (5, 2, 21), (4, 6, 210)] {
            assert_eq!(division_count(first, second), f64::from(count));
            let mut seen = Vec::new();
            for_each_division(first, second, 0, |members| seen.push(members.to_vec()));
            assert_eq!(seen[0], (0..first).collect::<Vec<_>>(), "the observed division comes first");
            assert!(seen.iter().all(|members| members.len() == first && members.is_sorted()));
            seen.sort();
            seen.dedup();
            assert_eq!(seen.len(), usize::try_from(count).expect("a small count"));
        }
        let (mut visited, mut of_first) = (0, 0);
        for_each_division(20, 30, 999, |members| {
            visited += 1;
            of_first += usize::from(members.contains(&0));
        });
        assert_eq!(visited, 1000);
        assert!((350..450).contains(&of_first), "two fifths of {visited}, not {of_first}");
    }
}
