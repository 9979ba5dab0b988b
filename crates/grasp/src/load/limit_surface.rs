//! Friction limit of a patch that is pulled and turned at once.

use cranny_spatial::nalgebra::{Matrix3, Vector3};

/// Point of a patch: position in the plane of contact, in metres from the patch's middle, and load in newtons.
pub type LoadedPoint = ([f64; 2], f64);

/// Factor by which a wrench in the plane of contact, two components of force and the moment about the middle (N, N m),
/// can grow before the patch slips: with friction 1, an additional torsional arm `arm_m` (m) of each point, and a constant
/// wrench `push` of its own, which friction must bear alone.
///
/// Slip is a velocity ξ in the plane. Friction then takes a power of Σ Nₖ √(|v(pₖ)|² + `arm_m`² ω²), the wrench to be borne
/// gives w·ξ, and the push takes p·ξ: the factor is the least power taken at w·ξ = 1 (the limit surface: Goyal, Ruina &
/// Papadopoulos 1991, §2). Weighted least squares find it, with weights of Nₖ by the last velocity of the point; each
/// iteration descends.
pub fn limit_factor(points: &[LoadedPoint], wrench: Vector3<f64>, push: Vector3<f64>, arm_m: f64) -> f64 {
    let speed = |p: &[f64; 2], slip: &Vector3<f64>| {
        let (x, y) = (slip.x - slip.z * p[1], slip.y + slip.z * p[0]);
        (x * x + y * y + (arm_m * slip.z).powi(2)).sqrt()
    };
    let mut weights: Vec<f64> = points.iter().map(|(_, load)| *load).collect();
    let mut factor = f64::INFINITY;
    for _ in 0..STEPS {
        let mut power = Matrix3::zeros();
        for (([x, y], _), weight) in points.iter().zip(&weights) {
            let along_x = Vector3::new(1.0, 0.0, -y);
            let along_y = Vector3::new(0.0, 1.0, *x);
            let turning = Vector3::new(0.0, 0.0, arm_m);
            for row in [along_x, along_y, turning] {
                power += row * row.transpose() * *weight;
            }
        }
        let Some(inverse) = power.try_inverse() else { break };
        let [along, pushed] = [wrench, push].map(|force| inverse * force);
        let slip = along * ((1.0 + pushed.dot(&wrench)) / along.dot(&wrench)) - pushed;
        factor = push.dot(&slip) + points.iter().map(|(p, load)| load * speed(p, &slip)).sum::<f64>();
        for ((p, load), weight) in points.iter().zip(&mut weights) {
            *weight = load / speed(p, &slip).max(f64::MIN_POSITIVE);
        }
    }
    factor.max(0.0)
}

/// Number of iterations; the factor is then known to within 1 % (see the test).
const STEPS: usize = 8;

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]
mod tests {
    use super::*;

    /// Least ratio over a fine grid of slips.
    fn by_search(points: &[LoadedPoint], [fx, fy, moment]: [f64; 3], push: &Vector3<f64>, arm_m: f64) -> f64 {
        let mut least = f64::INFINITY;
        for i in 0..400 {
            let turn = std::f64::consts::PI * f64::from(i) / 400.0;
            for j in 0..400 {
                let share = std::f64::consts::PI * f64::from(j) / 400.0;
                let (vx, vy, w) = (share.sin() * turn.cos(), share.sin() * turn.sin(), share.cos() / 0.01);
                let given = fx * vx + fy * vy + moment * w;
                let (vx, vy, w) = if given < 0.0 { (-vx, -vy, -w) } else { (vx, vy, w) };
                let taken: f64 = points
                    .iter()
                    .map(|([x, y], load)| {
                        load * ((vx - w * y).powi(2) + (vy + w * x).powi(2) + (arm_m * w).powi(2)).sqrt()
                    })
                    .sum();
                let taken: f64 = taken + push.dot(&Vector3::new(vx, vy, w));
                if given.abs() > 0.0 {
                    least = least.min(taken / given.abs());
                }
            }
        }
        least
    }

    #[test]
    fn the_load_factor_is_the_least_ratio_of_the_powers() {
        let edge = [([-0.007, 0.0], 30.0), ([0.007, 0.0], 40.0)];
        let face =
            [([-0.01, -0.01], 1.0), ([0.01, -0.01], 20.0), ([0.01, 0.01], 30.0), ([-0.01, 0.01], 20.0)];
        let point = [([0.001, 0.0], 10.0)];
        for points in [&edge[..], &face[..], &point[..]] {
            for wrench in
                [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.01], [1.0, 0.5, 0.01], [0.3, -1.0, 0.03]]
            {
                for push in [Vector3::zeros(), Vector3::new(3.0, 1.0, 0.0), Vector3::new(0.0, -2.0, 0.01)] {
                    let found = limit_factor(points, wrench.into(), push, 0.002);
                    let expected = by_search(points, wrench, &push, 0.002);
                    assert!(
                        (found / expected - 1.0).abs() < 0.02,
                        "{points:?} {wrench:?} {push:?}: {found}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn an_edge_turns_at_the_load_of_its_ends_times_their_arms() {
        let edge = [([-0.007, 0.0], 35.0), ([0.007, 0.0], 35.0)];
        assert!((limit_factor(&edge, Vector3::z(), Vector3::zeros(), 0.0) - 70.0 * 0.007).abs() < 1e-3);
        // A pull across the edge adds to the turn at one end: F/2 + M/L = N/2.
        let pull = 20.0;
        let moment = (35.0 - 0.5 * pull) * 0.014;
        assert!(
            (limit_factor(&edge, Vector3::new(0.0, pull, moment), Vector3::zeros(), 0.0) - 1.0).abs() < 0.01
        );
    }
}
