use cranny_robot::between;

/// Configurations `q(t)` of a motion, for t in [0, 1]: one value per joint (m, rad).
#[derive(Clone, Copy, Debug)]
pub(crate) enum JointCurve<'a> {
    /// Straight motion from one configuration to another.
    Line([&'a [f64]; 2]),
    /// Polynomial curve, given by the control points of its Bézier form, at least two.
    Curve(&'a [Vec<f64>]),
}

/// Velocities of the joints of a motion, per unit of t (m, rad; one per joint).
#[derive(Clone, Debug, Default)]
pub(crate) struct Rates {
    /// `q'` at one configuration.
    pub now: Vec<f64>,
    /// Bounds on `|q'|` and `|q''|` along the whole of a curve; empty for a line, whose `q'` is constant.
    pub most: Vec<f64>,
    pub bend: Vec<f64>,
}

impl JointCurve<'_> {
    /// Writes `q(t)` (m, rad; one per joint).
    pub fn place(self, t: f64, q: &mut [f64]) {
        match self {
            Self::Line([a, b]) => q.iter_mut().zip(between(a, b, t)).for_each(|(q, between)| *q = between),
            Self::Curve(points) => {
                mix(q, &bernstein(points.len() - 1, t), |index| points[index].iter().copied());
            }
        }
    }

    /// Returns the first and last configuration (m, rad; one per joint).
    pub fn ends(&self) -> [&[f64]; 2] {
        match self {
            Self::Line(ends) => *ends,
            Self::Curve(points) => [&points[0], &points[points.len() - 1]],
        }
    }

    /// Writes `q'(t)` (m, rad; one per joint).
    pub fn slope(self, t: f64, slope: &mut [f64]) {
        match self {
            Self::Line([a, b]) => {
                slope.iter_mut().zip(a.iter().zip(b)).for_each(|(slope, (a, b))| *slope = b - a);
            }
            Self::Curve(points) => {
                let degree = points.len() - 1;
                let weights = bernstein(degree - 1, t).into_iter().map(|weight| degree as f64 * weight);
                let step = |index: usize| points[index + 1].iter().zip(&points[index]).map(|(b, a)| b - a);
                mix(slope, &weights.collect::<Vec<_>>(), step);
            }
        }
    }
}

impl Rates {
    /// Creates the rates of joints that do not move.
    pub fn still(dof: usize) -> Self {
        Self { now: vec![0.0; dof], ..Self::default() }
    }

    /// Computes the rates in the middle of a motion, and bounds along all of it: a derivative of a curve lies in the convex
    /// hull of its control points, which are differences of the control points of the curve.
    pub fn set(&mut self, curve: JointCurve<'_>) {
        if let JointCurve::Curve(points) = curve {
            assert!(points.iter().all(|point| point.len() == self.now.len()), "one value per joint");
        }
        curve.slope(0.5, &mut self.now);
        self.most.clear();
        self.bend.clear();
        let JointCurve::Curve(points) = curve else { return };
        let degree = (points.len() - 1) as f64;
        for joint in 0..self.now.len() {
            let greatest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
            let first = greatest(&mut points.windows(2).map(|p| p[1][joint] - p[0][joint]));
            let second =
                greatest(&mut points.windows(3).map(|p| p[2][joint] - 2.0 * p[1][joint] + p[0][joint]));
            self.most.push(degree * first);
            self.bend.push(degree * (degree - 1.0) * second);
        }
    }

    /// Returns a bound on `|q'|` of a joint.
    pub fn most_of(&self, joint: usize) -> f64 {
        self.most.get(joint).copied().unwrap_or_else(|| self.now[joint].abs())
    }

    /// Returns a bound on `|q''|` of a joint.
    pub fn bend_of(&self, joint: usize) -> f64 {
        self.bend.get(joint).copied().unwrap_or(0.0)
    }
}

fn mix<I: Iterator<Item = f64>>(sum: &mut [f64], weights: &[f64], point: impl Fn(usize) -> I) {
    sum.fill(0.0);
    for (index, weight) in weights.iter().enumerate() {
        sum.iter_mut().zip(point(index)).for_each(|(sum, value)| *sum += weight * value);
    }
}

/// Returns the values at t of the Bernstein polynomials of a degree.
fn bernstein(degree: usize, t: f64) -> Vec<f64> {
    let mut weights = vec![0.0; degree + 1];
    weights[0] = 1.0;
    for last in 1..=degree {
        for index in (1..=last).rev() {
            weights[index] = weights[index] * (1.0 - t) + weights[index - 1] * t;
        }
        weights[0] *= 1.0 - t;
    }
    weights
}
