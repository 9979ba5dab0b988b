use cranny_spatial::Stream;

/// All points by which a way from one focus to the other is no longer than the longest: where alone a better path can be
/// (Gammell, Srinivasa & Barfoot 2014, "Informed RRT*", §III).
pub(crate) struct Spheroid {
    middle: Vec<f64>,
    /// Of unit length from focus to focus; 0 where these are one.
    axis: Vec<f64>,
    /// Half diameters along the axis and across it.
    along: f64,
    across: f64,
}

impl Spheroid {
    /// The one about two foci; a longest way that is shorter than the straight one counts as that.
    pub fn between(a: &[f64], b: &[f64], longest: f64) -> Self {
        let way: Vec<f64> = b.iter().zip(a).map(|(b, a)| b - a).collect();
        let shortest = norm(&way);
        let longest = longest.max(shortest);
        Self {
            middle: a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect(),
            axis: way.iter().map(|x| if shortest > 0.0 { x / shortest } else { 0.0 }).collect(),
            along: 0.5 * longest,
            across: 0.5 * (longest.powi(2) - shortest.powi(2)).sqrt(),
        }
    }

    /// A point of it, uniformly at random.
    pub fn draw(&self, random: &mut Stream) -> Vec<f64> {
        let mut point: Vec<f64> = self.middle.iter().map(|_| random.normal()).collect();
        let radius = random.uniform().powf(1.0 / point.len() as f64) / norm(&point).max(f64::MIN_POSITIVE);
        let on_axis: f64 = point.iter().zip(&self.axis).map(|(x, axis)| x * axis).sum();
        for ((x, middle), axis) in point.iter_mut().zip(&self.middle).zip(&self.axis) {
            let beside = *x - on_axis * axis;
            *x = middle + radius * (self.across * beside + self.along * on_axis * axis);
        }
        point
    }
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_way_by_a_point_is_longer_than_the_longest_and_some_are_nearly_so() {
        let mut random = Stream::new(0, 0);
        for (b, longest) in [([1.0, -0.5, 2.0], 2.5), ([0.0; 3], 1.0), ([3.0, 0.0, 0.0], 1.0)] {
            let spheroid = Spheroid::between(&[0.0; 3], &b, longest);
            let bound = longest.max(norm(&b));
            let ways = (0..2000).map(|_| {
                let point = spheroid.draw(&mut random);
                let rest: Vec<f64> = point.iter().zip(&b).map(|(x, b)| b - x).collect();
                norm(&point) + norm(&rest)
            });
            let farthest = ways.fold(0.0, f64::max);
            assert!(farthest <= bound * (1.0 + 1e-12) && farthest > 0.98 * bound, "{farthest} of {bound}");
        }
    }
}
