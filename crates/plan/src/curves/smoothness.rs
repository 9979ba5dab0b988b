use cranny_spatial::nalgebra::{Cholesky, DMatrix};

/// Ends of the differences in a [`Smoothness`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GoalEnd {
    /// The way point after the last free one is given.
    Fixed,
    /// The last free way point is the end of the curve.
    Free,
}

/// Smoothness of the free way points of a curve, `F = ½‖Kξ + e‖²`, with K the matrix of finite differences and `e` the
/// contribution of the fixed ends (Zucker et al. 2013, "CHOMP: Covariant Hamiltonian optimization for motion planning", §3.1), and
/// the metric `A = KᵀK` in which a step spreads along the curve.
///
/// The fixed ends count as at rest: before the first way point lies the first, after the last lies the last.
#[derive(Clone, Debug)]
pub(crate) struct Smoothness {
    /// Differences of all way points, one row for each, in columns the fixed start, the free way points and the fixed goal.
    differences: DMatrix<f64>,
    inverse: DMatrix<f64>,
    free: usize,
}

impl Smoothness {
    /// Creates the matrices for `free` way points (above 0) with `step_s` seconds between two, by differences of this order (1:
    /// velocities, 2: accelerations). `None` if A is singular.
    pub fn new(free: usize, order: u32, step_s: f64, end: GoalEnd) -> Option<Self> {
        let given = match end {
            GoalEnd::Fixed => free + 2,
            GoalEnd::Free => free + 1,
        };
        let last = given - 1;
        let column = |place: usize| place.saturating_sub(1).min(last);
        // Places are shifted by one: place 0 lies before the fixed start.
        let (weights, centres): (&[f64], std::ops::Range<usize>) = match order {
            1 => (&[-1.0, 1.0], 1..given),
            _ => (&[1.0, -2.0, 1.0], 0..given),
        };
        let mut differences = DMatrix::zeros(centres.len(), given);
        let mut scale = 1.0;
        for _ in 0..order {
            scale /= step_s;
        }
        for (row, begin) in centres.enumerate() {
            for (offset, weight) in weights.iter().enumerate() {
                differences[(row, column(begin + offset))] += weight * scale;
            }
        }
        let of_free = differences.columns(1, free);
        let metric = of_free.transpose() * of_free;
        let inverse = Cholesky::new(metric)?.inverse();
        Some(Self { differences, inverse, free })
    }

    /// Returns `F` of a curve of way points (m, rad; one value per joint), from the fixed start on.
    #[cfg(test)]
    pub fn cost(&self, path: &[Vec<f64>]) -> f64 {
        let joints = path.first().map_or(0, Vec::len);
        (0..joints).fold(0.0, |sum, joint| sum + 0.5 * self.along(path, joint).norm_squared())
    }

    /// Adds `weight · ∂F/∂ξ` at a curve of way points (m, rad; one value per joint) to the rows of the free ones.
    pub fn add_gradient(&self, path: &[Vec<f64>], weight: f64, rows: &mut [Vec<f64>]) {
        let joints = path.first().map_or(0, Vec::len);
        for joint in 0..joints {
            let slopes = self.differences.tr_mul(&self.along(path, joint));
            for (row, slope) in rows.iter_mut().zip(slopes.iter().skip(1)) {
                row[joint] += weight * slope;
            }
        }
    }

    /// Replaces the rows of the free way points (m, rad; one value per joint) by `A⁻¹` times them.
    pub fn spread(&self, rows: &mut [Vec<f64>]) {
        let joints = rows.first().map_or(0, Vec::len);
        for joint in 0..joints {
            let values = DMatrix::from_iterator(self.free, 1, rows.iter().map(|row| row[joint]));
            let spread = &self.inverse * values;
            for (row, value) in rows.iter_mut().zip(spread.iter()) {
                row[joint] = *value;
            }
        }
    }

    /// `A⁻¹`.
    pub fn inverse(&self) -> &DMatrix<f64> {
        &self.inverse
    }

    /// Number of free way points.
    pub fn free(&self) -> usize {
        self.free
    }

    /// Differences of one joint along a curve.
    fn along(&self, path: &[Vec<f64>], joint: usize) -> DMatrix<f64> {
        let given = self.differences.ncols();
        let values = path.iter().take(given).map(|q| q[joint]);
        &self.differences * DMatrix::from_iterator(given, 1, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_spatial::Stream;

    #[test]
    fn the_gradient_of_smoothness_is_that_of_finite_differences() {
        let mut random = Stream::new(4, 0);
        for (order, end, len) in
            [(1, GoalEnd::Fixed, 8), (2, GoalEnd::Fixed, 8), (1, GoalEnd::Free, 7), (2, GoalEnd::Free, 7)]
        {
            let smoothness = Smoothness::new(6, order, 0.1, end).expect("a regular metric");
            let mut path: Vec<Vec<f64>> = (0..len).map(|_| vec![random.normal(), random.normal()]).collect();
            let mut gradient = vec![vec![0.0; 2]; 6];
            smoothness.add_gradient(&path, 1.0, &mut gradient);
            for free in 0..6 {
                for joint in 0..2 {
                    const STEP: f64 = 1e-3;
                    let value = path[free + 1][joint];
                    let mut at = |value: f64| {
                        path[free + 1][joint] = value;
                        smoothness.cost(&path)
                    };
                    let slope = (at(value + STEP) - at(value - STEP)) / (2.0 * STEP);
                    at(value);
                    let scale = 1.0 + slope.abs();
                    assert!((gradient[free][joint] - slope).abs() < 1e-6 * scale, "{order} {end:?}");
                }
            }
        }
    }

    #[test]
    fn a_straight_line_is_smoothest_and_the_metric_leads_to_it_in_one_step() {
        let smoothness = Smoothness::new(9, 1, 0.1, GoalEnd::Fixed).expect("a regular metric");
        let mut random = Stream::new(5, 0);
        let mut path: Vec<Vec<f64>> = (0..11).map(|_| vec![random.normal()]).collect();
        let mut step = vec![vec![0.0]; 9];
        smoothness.add_gradient(&path, 1.0, &mut step);
        smoothness.spread(&mut step);
        for (q, step) in path[1..10].iter_mut().zip(&step) {
            q[0] -= step[0];
        }
        let straight = crate::curves::curve::straight(&path[0].clone(), &path[10].clone(), 11);
        for (q, straight) in path.iter().zip(&straight) {
            assert!((q[0] - straight[0]).abs() < 1e-9);
        }
    }
}
