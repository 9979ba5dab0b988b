use cranny_grasp::{Grasp, GraspSet};
use cranny_spatial::{EXACT_TRANSLATION_M, Pose, PoseDifference, Vector, nalgebra::Quaternion};

/// Measures grippers against all grasps of a set by the released metric `d = ½·mm + ½·deg`; stores the nearest node of each.
#[derive(Clone, Debug)]
pub(crate) struct GoalMeter {
    positions: Vec<Vector>,
    rotations: Vec<Quaternion<f64>>,
    twins: Vec<Quaternion<f64>>,
    nearest: Vec<(f64, usize)>,
    /// Squared distance below which a gripper may be the nearest to each grasp, or may have arrived (m²).
    reach_squared_m2: Vec<f64>,
}

impl GoalMeter {
    pub fn new(set: &GraspSet) -> Self {
        let pose = |grasp: &Grasp| grasp.world_from_gripper;
        let quaternion = |pose: Pose| *pose.rotation.quaternion();
        Self {
            positions: set.grasps().iter().map(|g| pose(g).translation.vector).collect(),
            rotations: set.grasps().iter().map(|g| quaternion(pose(g))).collect(),
            twins: set.grasps().iter().map(|g| quaternion(pose(&g.twin()))).collect(),
            nearest: vec![(f64::INFINITY, 0); set.len()],
            reach_squared_m2: vec![f64::INFINITY; set.len()],
        }
    }

    /// Returns the node nearest to `grasp`.
    pub fn nearest_node(&self, grasp: usize) -> usize {
        self.nearest[grasp].1
    }

    /// Measures the gripper of a new node against every grasp. Returns the first grasp at which it has arrived.
    ///
    /// The translation alone is a lower bound of `d`. The rotation is evaluated only if the node may be the nearest, or may
    /// have arrived by the `exact` criterion. (Under `paper` the first node to arrive is the nearest.)
    pub fn measure(
        &mut self,
        node: usize,
        world_from_gripper: &Pose,
        is_arrival: impl Fn(&PoseDifference) -> bool,
    ) -> Option<usize> {
        let mut arrived = None;
        let position = world_from_gripper.translation.vector;
        let rotation = world_from_gripper.rotation.quaternion();
        for (grasp, (goal, reach_squared_m2)) in
            self.positions.iter().zip(&mut self.reach_squared_m2).enumerate()
        {
            let distance_squared_m2 = (goal - position).norm_squared();
            if distance_squared_m2 > *reach_squared_m2 {
                continue;
            }
            let direct = self.rotations[grasp].dot(rotation).abs();
            let turned = self.twins[grasp].dot(rotation).abs();
            let difference = PoseDifference {
                translation_m: distance_squared_m2.sqrt(),
                rotation_rad: 2.0 * libm::acos(direct.max(turned).min(1.0)),
            };
            let d = difference.paper_metric();
            if d < self.nearest[grasp].0 {
                self.nearest[grasp] = (d, node);
                let reach_m = (d / HALF_MILLIMETRES_PER_METRE).max(EXACT_TRANSLATION_M);
                *reach_squared_m2 = reach_m * reach_m;
            }
            if arrived.is_none() && is_arrival(&difference) {
                arrived = Some(grasp);
            }
        }
        arrived
    }
}

/// Value of `d` for one metre of translation.
const HALF_MILLIMETRES_PER_METRE: f64 = 500.0;

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_spatial::Stream;

    #[test]
    fn the_meter_agrees_with_the_plain_measure() {
        let mut random = Stream::new(5, 0);
        let mut pose = || {
            let translation = Vector::new(random.uniform(), random.uniform(), random.uniform());
            Pose::from_parts(translation.into(), random.rotation())
        };
        let grasps: Vec<Grasp> = (0..50).map(|_| Grasp::at(pose())).collect();
        let set = GraspSet::new(grasps).unwrap();
        let mut meter = GoalMeter::new(&set);
        let grippers: Vec<Pose> = (0..500).map(|_| pose()).collect();
        for (node, gripper) in grippers.iter().enumerate() {
            meter.measure(node, gripper, |_| false);
        }
        for (index, grasp) in set.grasps().iter().enumerate() {
            let d = |node: &usize| grasp.difference(&grippers[*node]).paper_metric();
            let nearest = (0..grippers.len()).min_by(|a, b| d(a).total_cmp(&d(b))).unwrap();
            assert_eq!(meter.nearest_node(index), nearest);
            assert!((meter.nearest[index].0 - d(&nearest)).abs() < 1e-6);
        }
    }
}
