use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Pose, ROUNDING_M, Rotation, Vector};

/// Binary tree of clusters of poses; the first contains all poses.
pub(crate) struct PoseClusters {
    pub clusters: Vec<Cluster>,
}

/// Poses within a radius of their middle: positions within `radius_m` metres, rotations within the chord `2 sin(angle/2)`.
pub(crate) struct Cluster {
    pub middle: Pose,
    pub radius_m: f64,
    pub chord: f64,
    pub halves: Option<[usize; 2]>,
}

impl PoseClusters {
    /// Creates the clusters of these poses, which share one frame; the middle of each cluster is in that frame too.
    pub fn new(poses: Vec<Pose>) -> Self {
        let mut clusters = Vec::with_capacity(2 * poses.len());
        if !poses.is_empty() {
            Self::add(poses, &mut clusters);
        }
        Self { clusters }
    }

    /// Adds a cluster with all clusters below it, and returns its index.
    fn add(poses: Vec<Pose>, clusters: &mut Vec<Cluster>) -> usize {
        let index = clusters.len();
        let first = &poses[0];
        let count = poses.len() as f64;
        let middle = poses.iter().map(|pose| pose.translation.vector).sum::<Vector>() / count;
        let aligned = |pose: &Pose| {
            let sign = pose.rotation.coords.dot(&first.rotation.coords).signum();
            pose.rotation.into_inner() * sign
        };
        let mean =
            poses.iter().map(aligned).fold(Quaternion::new(0.0, 0.0, 0.0, 0.0), |sum, turn| sum + turn);
        let rotation = Rotation::try_new(mean, 1e-9).unwrap_or(first.rotation);
        let middle = Pose::from_parts(middle.into(), rotation);
        let apart = |a: &Pose, b: &Pose| {
            let turn = a.rotation.inverse() * b.rotation;
            ((a.translation.vector - b.translation.vector).norm(), 2.0 * turn.imag().norm())
        };
        let (radius_m, chord) = poses.iter().map(|pose| apart(&middle, pose)).fold(
            (ROUNDING_M, ROUNDING_M),
            |(radius_m, chord), (distance_m, turn)| {
                (radius_m.max(distance_m + ROUNDING_M), chord.max(turn + ROUNDING_M))
            },
        );
        clusters.push(Cluster { middle, radius_m, chord, halves: None });
        // The split is about two poses far from each other, where a radian counts as much as an arm length.
        const ARM_M: f64 = 0.5;
        let distance = |a: &Pose, b: &Pose| {
            let (distance_m, chord) = apart(a, b);
            distance_m + ARM_M * chord
        };
        let far_from = |from: &Pose| {
            poses.iter().max_by(|a, b| distance(from, a).total_cmp(&distance(from, b))).copied()
        };
        let ends = far_from(&middle).and_then(|one| Some([one, far_from(&one)?]));
        if let Some([one, other]) = ends.filter(|[one, other]| distance(one, other) > ROUNDING_M) {
            let (near, far) =
                poses.into_iter().partition(|pose| distance(&one, pose) <= distance(&other, pose));
            let halves = [near, far].map(|half| Self::add(half, clusters));
            clusters[index].halves = Some(halves);
        }
        index
    }
}
