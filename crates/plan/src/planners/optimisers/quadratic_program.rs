use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT};

/// Convex quadratic program: least `½xᵀPx + pᵀx` with rows `a·x = b` and `a·x ≤ b`.
///
/// Solved by the interior point method of `clarabel` (Goulart & Chen 2024, "Clarabel: An interior-point solver for conic programs with
/// quadratic objectives", whole). It uses no function of the system besides roots, so that its results are the same everywhere.
#[derive(Clone, Debug, Default)]
pub(crate) struct QuadraticProgram {
    /// Entries of the upper triangle of P; entries of one place are summed.
    quadratic: Triplets,
    linear: Vec<f64>,
    equalities: Rows,
    inequalities: Rows,
}

/// Accuracy of objective and rows: a variable whose bound is just active errs by the root of it.
const ACCURACY: f64 = 1e-10;

#[derive(Clone, Debug, Default)]
struct Triplets {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

#[derive(Clone, Debug, Default)]
struct Rows {
    entries: Triplets,
    bounds: Vec<f64>,
}

/// Solution of a [`QuadraticProgram`], with its multipliers.
#[derive(Clone, Debug)]
pub(crate) struct QuadraticSolution {
    pub x: Vec<f64>,
    /// Value of the objective.
    pub value: f64,
    /// Multipliers: of the equalities, then of the inequalities.
    #[cfg_attr(not(test), expect(dead_code, reason = "the conditions of optimality are tested"))]
    pub multipliers: Vec<f64>,
}

impl Triplets {
    fn add(&mut self, row: usize, column: usize, value: f64) {
        self.rows.push(row);
        self.columns.push(column);
        self.values.push(value);
    }
}

impl Rows {
    fn add(&mut self, row: &[(usize, f64)], bound: f64) {
        for (variable, factor) in row {
            self.entries.add(self.bounds.len(), *variable, *factor);
        }
        self.bounds.push(bound);
    }
}

impl QuadraticProgram {
    /// Creates a program without rows.
    pub fn new(variables: usize) -> Self {
        Self { linear: vec![0.0; variables], ..Self::default() }
    }

    /// Adds a variable that costs `price` per unit, and returns its index.
    pub fn add_variable(&mut self, price: f64) -> usize {
        self.linear.push(price);
        self.linear.len() - 1
    }

    /// Adds `½·weight·x²` for a variable.
    pub fn add_square(&mut self, variable: usize, weight: f64) {
        self.quadratic.add(variable, variable, weight);
    }

    /// Demands `Σ factor·x = bound`.
    pub fn equal(&mut self, row: &[(usize, f64)], bound: f64) {
        self.equalities.add(row, bound);
    }

    /// Demands `Σ factor·x ≤ bound`.
    pub fn at_most(&mut self, row: &[(usize, f64)], bound: f64) {
        self.inequalities.add(row, bound);
    }

    /// Solves the program; `None` if it is infeasible, or no solution of the demanded accuracy was found.
    pub fn solve(&self) -> Option<QuadraticSolution> {
        let variables = self.linear.len();
        let Triplets { rows, columns, values } = self.quadratic.clone();
        let quadratic = CscMatrix::new_from_triplets(variables, variables, rows, columns, values);
        let equal = self.equalities.bounds.len();
        let Triplets { mut rows, mut columns, mut values } = self.equalities.entries.clone();
        rows.extend(self.inequalities.entries.rows.iter().map(|row| row + equal));
        columns.extend(&self.inequalities.entries.columns);
        values.extend(&self.inequalities.entries.values);
        let bounds = [&self.equalities.bounds[..], &self.inequalities.bounds].concat();
        let matrix = CscMatrix::new_from_triplets(bounds.len(), variables, rows, columns, values);
        let cones = [ZeroConeT(equal), NonnegativeConeT(bounds.len() - equal)];
        let settings = DefaultSettings {
            verbose: false,
            presolve_enable: false,
            tol_gap_abs: ACCURACY,
            tol_gap_rel: ACCURACY,
            tol_feas: ACCURACY,
            ..DefaultSettings::default()
        };
        let solver = DefaultSolver::new(&quadratic, &self.linear, &matrix, &bounds, &cones, settings);
        let mut solver = solver.ok()?;
        solver.solve();
        let solution = &solver.solution;
        let is_found = matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
        is_found.then(|| QuadraticSolution {
            x: solution.x.clone(),
            value: solution.obj_val,
            multipliers: solution.z.clone(),
        })
    }

    /// Returns the greatest violation of the conditions of optimality (Karush, Kuhn and Tucker) by a solution.
    #[cfg(test)]
    pub fn residual(&self, solution: &QuadraticSolution) -> f64 {
        let QuadraticSolution { x, multipliers, .. } = solution;
        let mut slopes = self.linear.clone();
        let Triplets { rows, columns, values } = &self.quadratic;
        for ((row, column), value) in rows.iter().zip(columns).zip(values) {
            slopes[*row] += value * x[*column];
            if row != column {
                slopes[*column] += value * x[*row];
            }
        }
        let equal = self.equalities.bounds.len();
        let mut worst = 0.0_f64;
        for (rows, offset) in [(&self.equalities, 0), (&self.inequalities, equal)] {
            let mut left: Vec<f64> = rows.bounds.iter().map(|bound| -bound).collect();
            let Triplets { rows: of_rows, columns, values } = &rows.entries;
            for ((row, column), value) in of_rows.iter().zip(columns).zip(values) {
                left[*row] += value * x[*column];
                slopes[*column] += value * multipliers[offset + row];
            }
            for (row, left) in left.iter().enumerate() {
                let multiplier = multipliers[offset + row];
                worst = worst.max(if offset == 0 && equal > 0 {
                    left.abs()
                } else {
                    left.max(0.0).max((-multiplier).max(0.0)).max((left * multiplier).abs())
                });
            }
        }
        slopes.iter().fold(worst, |worst, slope| worst.max(slope.abs()))
    }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Stream;
    use cranny_spatial::nalgebra::{DMatrix, DVector};

    use super::*;

    /// Solves a small program densely: for every set of active rows, the linear system of its conditions; the feasible point with
    /// multipliers of the right sign is the solution.
    fn dense(
        squares: &[f64],
        linear: &[f64],
        equal: &[(Vec<f64>, f64)],
        most: &[(Vec<f64>, f64)],
    ) -> Option<Vec<f64>> {
        let n = squares.len();
        (0..1_u32 << most.len()).find_map(|active| {
            let is_active = |row: &usize| active & (1 << row) != 0;
            let chosen: Vec<usize> = (0..most.len()).filter(is_active).collect();
            let rows: Vec<&(Vec<f64>, f64)> =
                equal.iter().chain(chosen.iter().map(|row| &most[*row])).collect();
            let size = n + rows.len();
            let (mut matrix, mut right) = (DMatrix::zeros(size, size), DVector::zeros(size));
            for (i, (square, slope)) in squares.iter().zip(linear).enumerate() {
                matrix[(i, i)] = *square;
                right[i] = -slope;
            }
            for (k, (row, bound)) in rows.iter().enumerate() {
                for (i, factor) in row.iter().enumerate() {
                    matrix[(n + k, i)] = *factor;
                    matrix[(i, n + k)] = *factor;
                }
                right[n + k] = *bound;
            }
            let solved = matrix.lu().solve(&right)?;
            let x: Vec<f64> = solved.iter().take(n).copied().collect();
            let is_feasible = most
                .iter()
                .all(|(row, bound)| row.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>() <= bound + 1e-9);
            let is_signed = solved.iter().skip(n + equal.len()).all(|multiplier| *multiplier >= -1e-9);
            (is_feasible && is_signed).then_some(x)
        })
    }

    #[test]
    fn solutions_are_those_of_a_dense_reference_and_optimal() {
        let mut random = Stream::new(11, 0);
        let mut solved = 0;
        for _ in 0..200 {
            let n = 4;
            let squares: Vec<f64> = (0..n).map(|_| random.uniform_between(0.5, 3.0)).collect();
            let linear: Vec<f64> = (0..n).map(|_| random.normal()).collect();
            let mut row = || -> (Vec<f64>, f64) {
                ((0..n).map(|_| random.normal()).collect(), random.uniform_between(-0.5, 1.0))
            };
            let equal = vec![row()];
            let most: Vec<_> = (0..6).map(|_| row()).collect();
            let mut program = QuadraticProgram::new(n);
            for (i, square) in squares.iter().enumerate() {
                program.add_square(i, *square);
            }
            program.linear.clone_from(&linear);
            let sparse = |row: &[f64]| row.iter().copied().enumerate().collect::<Vec<_>>();
            for (row, bound) in &equal {
                program.equal(&sparse(row), *bound);
            }
            for (row, bound) in &most {
                program.at_most(&sparse(row), *bound);
            }
            let (found, reference) = (program.solve(), dense(&squares, &linear, &equal, &most));
            assert_eq!(found.is_some(), reference.is_some());
            if let (Some(found), Some(reference)) = (found, reference) {
                solved += 1;
                assert!(program.residual(&found) <= 1e-6, "{}", program.residual(&found));
                for (x, reference) in found.x.iter().zip(&reference) {
                    assert!((x - reference).abs() <= 1e-5, "{x} {reference}");
                }
            }
        }
        assert!(solved > 50, "{solved}");
    }

    #[test]
    fn what_cannot_be_is_no_solution() {
        let mut program = QuadraticProgram::new(1);
        program.at_most(&[(0, 1.0)], -1.0);
        program.at_most(&[(0, -1.0)], -1.0);
        assert!(program.solve().is_none());
    }
}
