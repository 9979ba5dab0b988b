use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

/// Choice of the goal during the descent of [`Omg`](crate::Omg).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum GoalChoice {
    /// Mirror descent of a distribution by five experts of different pace.
    #[default]
    Mirror,
    /// Goal of the least cost in this step.
    LeastCost,
    /// Goal of the least cost summed over all steps until this one.
    LeastSum,
    /// First goal of the start, without a change.
    Fixed,
}

/// Paces of the experts, as multiples of λ.
const PACES: [f64; 5] = [0.25, 0.5, 1.0, 4.0, 16.0];

/// Distribution over goals, learnt from their costs step by step (Wang, Xiang & Fox 2020, "Manipulation trajectory optimization with
/// online grasp synthesis and selection", §IV.C; values of `omg/online_learner.py` of the code `liruiw/OMG-Planner` 53e899c).
///
/// Mirror descent: each expert e moves its distribution by `min_p ⟨λ_e·c, p⟩ + D(p, p_e)` on the simplex, D the Bregman divergence of
/// the entropy shifted by `δ = 1/(4N + 1)`. The weight of an expert falls by `exp(−⟨c, p⟩ − ‖p − p_e‖₁)`, and the distribution is the
/// weighted mean.
#[derive(Clone, Debug)]
pub(crate) struct GoalLearner {
    choice: GoalChoice,
    rate: f64,
    shift: f64,
    experts: Vec<Vec<f64>>,
    weights: Vec<f64>,
    sums: Vec<f64>,
}

impl GoalLearner {
    /// Creates a uniform distribution over `count` goals (above 0), for `steps` steps.
    pub fn new(choice: GoalChoice, count: usize, steps: u64) -> Self {
        let uniform = vec![1.0 / count.max(1) as f64; count];
        Self {
            choice,
            rate: (libm::log(count as f64 + 1.0) / steps.max(1) as f64).sqrt(),
            shift: 1.0 / (4.0 * count as f64 + 1.0),
            experts: vec![uniform; PACES.len()],
            weights: vec![1.0; PACES.len()],
            sums: vec![0.0; count],
        }
    }

    /// Learns from the costs (no unit, at least 0; one of each goal), and returns the goal to continue with; `now` is the present one.
    pub fn next(&mut self, costs: &[f64], now: usize) -> usize {
        let total = costs.iter().fold(0.0, |sum, cost| sum + cost);
        let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
        let costs: Vec<f64> = costs.iter().map(|cost| cost * scale).collect();
        for (sum, cost) in self.sums.iter_mut().zip(&costs) {
            *sum += cost;
        }
        match self.choice {
            GoalChoice::Fixed => now,
            GoalChoice::LeastCost => least(&costs),
            GoalChoice::LeastSum => least(&self.sums),
            GoalChoice::Mirror => {
                for ((expert, weight), pace) in self.experts.iter_mut().zip(&mut self.weights).zip(PACES) {
                    let moved = projected(expert, &costs, self.rate * pace, self.shift);
                    let loss = dot(&costs, &moved)
                        + moved.iter().zip(&*expert).map(|(a, b)| (a - b).abs()).fold(0.0, |sum, x| sum + x);
                    *weight *= libm::exp(-loss);
                    *expert = moved;
                }
                let negative: Vec<f64> = self.distribution().iter().map(|p| -p).collect();
                least(&negative)
            }
        }
    }

    /// Returns the weighted mean of the experts.
    fn distribution(&self) -> Vec<f64> {
        let total = self.weights.iter().fold(0.0, |sum, weight| sum + weight).max(f64::MIN_POSITIVE);
        (0..self.sums.len())
            .map(|goal| {
                let parts =
                    self.experts.iter().zip(&self.weights).map(|(expert, weight)| weight * expert[goal]);
                parts.fold(0.0, |sum, part| sum + part) / total
            })
            .collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).fold(0.0, |sum, product| sum + product)
}

/// Returns the index of the least value, the first of equal ones.
fn least(values: &[f64]) -> usize {
    (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0)
}

/// Returns the Bregman projection: `p_i = max(0, (p_i + δ)·exp(−rate·c_i)·ν − δ)` with ν such that the sum is 1, by bisection.
fn projected(last: &[f64], costs: &[f64], rate: f64, shift: f64) -> Vec<f64> {
    const HALVINGS: usize = 100;
    let scaled: Vec<f64> =
        last.iter().zip(costs).map(|(p, cost)| (p + shift) * libm::exp(-rate * cost)).collect();
    let at = |factor: f64| -> Vec<f64> { scaled.iter().map(|p| (p * factor - shift).max(0.0)).collect() };
    let sum = |factor: f64| at(factor).iter().fold(0.0, |sum, p| sum + p);
    let (mut low, mut high) = (0.0, 1.0);
    while sum(high) < 1.0 && high < f64::MAX / 4.0 {
        high *= 2.0;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if sum(middle) < 1.0 { low = middle } else { high = middle }
    }
    at(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distribution_stays_one_and_finds_the_cheapest_goal() {
        let mut learner = GoalLearner::new(GoalChoice::Mirror, 4, 50);
        let costs = [3.0, 1.0, 0.2, 2.0];
        let mut goal = 0;
        for _ in 0..50 {
            goal = learner.next(&costs, goal);
            let sum: f64 = learner.distribution().iter().sum();
            assert!((sum - 1.0).abs() < 1e-9, "{sum}");
            assert!(learner.distribution().iter().all(|p| *p >= 0.0));
        }
        assert_eq!(goal, 2);
        assert_eq!(GoalLearner::new(GoalChoice::Fixed, 4, 50).next(&costs, 3), 3);
        assert_eq!(GoalLearner::new(GoalChoice::LeastCost, 4, 50).next(&costs, 3), 2);
    }

    #[test]
    fn the_projection_satisfies_its_conditions_of_optimality() {
        let (last, costs, rate, shift) = ([0.5, 0.3, 0.2], [0.1, 0.7, 0.2], 0.8, 1.0 / 13.0);
        let p = projected(&last, &costs, rate, shift);
        // Stationary: rate·c + ln((p + δ)/(p_old + δ)) is the same for all p above 0.
        let level = |i: usize| rate * costs[i] + ((p[i] + shift) / (last[i] + shift)).ln();
        assert!((level(0) - level(1)).abs() < 1e-9 && (level(0) - level(2)).abs() < 1e-9);
    }
}
