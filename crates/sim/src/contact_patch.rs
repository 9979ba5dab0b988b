//! Contact patches: the points at which the engine solves a contact, and the friction they give.
//!
//! By default the engine centres friction at the mean of all points up to 2 mm apart, whether they bear load or not, so that a
//! pad on its edge resists turning like a pad on its face. It also detects one point twice, may drop a loaded point if there
//! are more than four, and limits pull and turn separately.

use cranny_grasp::{LEAST_ARM_M, LoadedPoint, limit_factor};
use cranny_spatial::nalgebra::Vector3;
use rapier3d_f64::math::Vector;
use rapier3d_f64::parry::query;
use rapier3d_f64::prelude::{
    Collider, ContactManifold, ContactModificationContext, PairFilterContext, PhysicsHooks, RigidBodyHandle,
    RigidBodySet, SolverContact, SolverFlags,
};

use crate::bounding_ball::are_apart;

/// Minimum radius of a contact patch on a pad, in metres. A pad that yields by δ = 0.3 mm touches a ball of radius R = 33 mm on
/// a patch of radius √(R δ).
const PATCH_RADIUS_M: f64 = 0.00314;

/// Distance below which two corners are merged, in metres.
const SAME_M: f64 = 1e-5;

/// Replaces the near points of two faces by the patch on which they bear load, and drops those of two bodies that pass each
/// other.
pub(crate) struct ContactPatch {
    /// Duration of a step, in seconds.
    pub step_s: f64,
}

/// Corner of the polygon in which two faces meet, or of the patch.
#[derive(Clone, Copy)]
struct Corner {
    /// Index in the points of the manifold.
    index: u8,
    /// Anchors on the first and on the second rigid body, in the world.
    anchors: [Vector; 2],
    /// Gap between the two, in metres; negative if they overlap.
    gap_m: f64,
}

impl PhysicsHooks for ContactPatch {
    /// Skips pairs whose bounding balls are apart, because the engine examines each corner of a convex part.
    fn filter_contact_pair(&self, context: &PairFilterContext) -> Option<SolverFlags> {
        let [first, second] = [context.collider1, context.collider2].map(|handle| &context.colliders[handle]);
        (!are_apart(first, second)).then_some(SolverFlags::default())
    }

    fn modify_solver_contacts(&self, context: &mut ContactModificationContext) {
        let poses =
            [context.collider1, context.collider2].map(|collider| *context.colliders[collider].position());
        let moving =
            Moving { bodies: context.bodies, first: context.rigid_body1, second: context.rigid_body2 };
        let colliders = [context.collider1, context.collider2].map(|collider| &context.colliders[collider]);
        let Some(rigid) = context.rigid_mut() else { return };
        let mut corners: Vec<Corner> = Vec::new();
        for (index, point) in (0..).zip(&rigid.manifold.points) {
            let anchors =
                [poses[0].transform_point(point.local_p1), poses[1].transform_point(point.local_p2)];
            let corner = Corner { index, anchors, gap_m: point.dist };
            if corners.iter().all(|known| known.distance_m(&corner) > SAME_M) {
                corners.push(corner);
            }
        }
        let (Some(patch), Some(&template)) = (patch(&corners), rigid.solver_contacts.first()) else {
            // The engine predicts a contact from the speed along the normal alone: a finger that passes an edge within 2 mm
            // would push it away.
            if !moving.will_meet(&colliders, rigid.manifold, self.step_s) {
                rigid.solver_contacts.clear();
            }
            return;
        };
        *rigid.friction *= share_of_limits(&patch, rigid.manifold, *rigid.normal, &moving);
        rigid.solver_contacts.clear();
        rigid.solver_contacts.extend(patch.iter().map(|corner| corner.contact(template)));
    }
}

/// Returns the loaded corners, and for each other corner the end of the overlap on the line from its nearest loaded one, at
/// least [`PATCH_RADIUS_M`] from that one: at most four corners, `None` if none is loaded.
fn patch(corners: &[Corner]) -> Option<Vec<Corner>> {
    let mut patch: Vec<Corner> = corners.iter().copied().filter(|corner| corner.gap_m <= 0.0).collect();
    let bearing = patch.len();
    for open in corners.iter().filter(|corner| corner.gap_m > 0.0) {
        let near = |corner: &&Corner| corner.distance_m(open);
        let nearest = patch[..bearing].iter().min_by(|a, b| near(a).total_cmp(&near(b)))?;
        let end = nearest.toward_end(open);
        patch.push(end);
    }
    (bearing > 0).then(|| if patch.len() > MOST_CORNERS { widest(&patch) } else { patch })
}

/// Maximum number of points of a contact that the engine solves.
const MOST_CORNERS: usize = 4;

/// Returns the deepest corner, the one farthest from it, and the one farthest from their connection on each side of it.
fn widest(corners: &[Corner]) -> Vec<Corner> {
    let (Some(deepest), true) =
        (corners.iter().min_by(|a, b| a.gap_m.total_cmp(&b.gap_m)), corners.len() > MOST_CORNERS)
    else {
        return corners.to_vec();
    };
    let farthest_by = |measure: &dyn Fn(&Corner) -> f64| {
        corners.iter().max_by(|a, b| measure(a).total_cmp(&measure(b))).unwrap_or(deepest)
    };
    let farthest = farthest_by(&|corner| corner.distance_m(deepest));
    let along = (farthest.anchors[0] - deepest.anchors[0]).normalize_or_zero();
    let off_line = |corner: &Corner| {
        let offset = corner.anchors[0] - deepest.anchors[0];
        offset - along * offset.dot(along)
    };
    let third = farthest_by(&|corner| off_line(corner).length());
    let side = off_line(third);
    let fourth = farthest_by(&|corner| -off_line(corner).dot(side));
    let mut chosen = vec![*deepest, *farthest, *third];
    if off_line(fourth).dot(side) < 0.0 {
        chosen.push(*fourth);
    }
    chosen
}

impl Corner {
    fn distance_m(&self, other: &Self) -> f64 {
        (self.anchors[0] - other.anchors[0]).length()
    }

    /// Returns the end of the overlap between this corner, where the faces overlap, and `open`, where they do not.
    fn toward_end(&self, open: &Self) -> Self {
        let overlap = self.gap_m / (self.gap_m - open.gap_m);
        let share = overlap.max(PATCH_RADIUS_M / self.distance_m(open)).min(1.0);
        Self {
            index: open.index,
            anchors: [0, 1].map(|side| self.anchors[side].lerp(open.anchors[side], share)),
            gap_m: self.gap_m + share * (open.gap_m - self.gap_m),
        }
    }

    /// Returns the corner in the form of the solver; `template` is another contact of the same manifold.
    fn contact(&self, template: SolverContact) -> SolverContact {
        let mut contact = template;
        [contact.anchor1, contact.anchor2] = self.anchors;
        contact.dist = self.gap_m;
        contact.contact_id = [u64::from(self.index)];
        contact
    }
}

/// Relative motion of the two rigid bodies of a contact.
struct Moving<'a> {
    bodies: &'a RigidBodySet,
    first: Option<RigidBodyHandle>,
    second: Option<RigidBodyHandle>,
}

impl Moving<'_> {
    /// Returns true if two colliders overlap at the end of the next step. Their shapes are examined only if points of the contact
    /// approach each other that far.
    fn will_meet(&self, colliders: &[&Collider; 2], manifold: &ContactManifold, step_s: f64) -> bool {
        let next = |(body, collider): (Option<RigidBodyHandle>, &&Collider)| {
            let body = body.map(|body| &self.bodies[body]);
            let Some((body, own)) = body.zip(collider.position_wrt_parent()) else {
                return *collider.position();
            };
            let is_prescribed = body.is_kinematic();
            let place = if is_prescribed {
                *body.next_position()
            } else {
                body.predict_position_using_velocity(step_s)
            };
            place * *own
        };
        let [first, second] = [(self.first, &colliders[0]), (self.second, &colliders[1])].map(next);
        let along = first.rotation * manifold.local_n1;
        let may_meet = manifold.points.iter().any(|point| {
            let apart = second.transform_point(point.local_p2) - first.transform_point(point.local_p1);
            apart.dot(along) < 0.0
        });
        may_meet
            && query::intersection_test(&first, colliders[0].shape(), &second, colliders[1].shape())
                .is_ok_and(|meeting| meeting.intersecting)
    }

    /// Returns the speed at which the first body slides along the second at a point, in m/s, and turns on it about `normal`, in
    /// rad/s.
    fn slip(&self, at: Vector, normal: Vector) -> (f64, f64) {
        let of = |body: Option<RigidBodyHandle>| {
            let body = body.map(|body| &self.bodies[body]);
            body.map_or((Vector::ZERO, Vector::ZERO), |body| (body.velocity_at_point(at), body.angvel()))
        };
        let ((velocity, turning), (other_velocity, other_turning)) = (of(self.first), of(self.second));
        let sliding = velocity - other_velocity;
        let along = sliding - normal * sliding.dot(normal);
        (along.length(), (turning - other_turning).dot(normal).abs())
    }
}

/// Returns the factor on the engine's limits of pull and turn at which the patch slips under both, as loaded in the last step.
/// It is the limit of the point loads in their locations, relative to the limits of pull and turn alone, the turn about the
/// mean of the points.
///
/// A patch that slides without turning bears its pull alone. The engine keeps the turn from the onset of sliding, so that turn
/// is scaled by the ratio of the speeds of turning and sliding.
fn share_of_limits(patch: &[Corner], manifold: &ContactManifold, normal: Vector, moving: &Moving<'_>) -> f64 {
    let count = patch.len() as f64;
    let middle = patch.iter().map(|corner| corner.anchors[0]).sum::<Vector>() / count;
    let (x, y) = normal.any_orthonormal_pair();
    let (mut pull, mut turn, mut load, mut load_by_arm) = (Vector::ZERO, 0.0, 0.0, 0.0);
    let mut points: Vec<LoadedPoint> = Vec::with_capacity(patch.len());
    for corner in patch {
        let data = &manifold.points[usize::from(corner.index)].data;
        // The engine stores both with every point, as impulses on the first body.
        pull += data.warmstart_tangent_world / count;
        turn -= data.warmstart_twist_impulse / count;
        let at = corner.anchors[0] - middle;
        let borne = data.warmstart_impulse;
        load += borne;
        load_by_arm += borne * at.length();
        if borne > 0.0 {
            points.push(([at.dot(x), at.dot(y)], borne));
        }
    }
    let (sliding, turning) = moving.slip(middle, normal);
    let turn = turn * (turning * load_by_arm / (load * sliding)).min(1.0);
    let of_engine = (load / pull.length()).min(load_by_arm / turn.abs());
    if points.is_empty() || !of_engine.is_finite() {
        return 1.0;
    }
    let of_patch =
        limit_factor(&points, Vector3::new(pull.dot(x), pull.dot(y), turn), Vector3::zeros(), LEAST_ARM_M);
    (of_patch / of_engine).min(1.0)
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Pose;
    use rapier3d_f64::prelude::RigidBodyBuilder;

    use crate::{Physics, Piece, PieceShape, engine};

    /// Speed of a box after one step, 1 mm beside which another one, 0.5 mm below its edge, moves by these lengths in metres.
    fn pushed(across_m: f64, up_m: f64) -> f64 {
        let mut world = engine::world(&Physics { gravity: 0.0, ..Physics::default() });
        let place = |half_m: f64, groups| {
            let shape = PieceShape::Cuboid([half_m; 3]);
            engine::colliders("box", &[Piece { body_from_piece: Pose::identity(), shape }], 0.0, groups)
                .expect("a box")
                .remove(0)
        };
        let object = world.insert_body(RigidBodyBuilder::dynamic().additional_mass(0.2).can_sleep(false));
        world.insert_collider(place(0.1, engine::OBJECT), Some(object));
        let [x, y] = [0.1 + 0.01 + 0.001, 0.1 + 0.01 - 0.0005];
        let from = Pose::translation(x, y, 0.0);
        let mover = world.insert_body(RigidBodyBuilder::kinematic_position_based().pose(engine::pose(&from)));
        world.insert_collider(place(0.01, engine::HAND), Some(mover));
        let to = Pose::translation(x - across_m, y + up_m, 0.0);
        world.bodies[mover].set_next_kinematic_position(engine::pose(&to));
        engine::step(&mut world, false);
        world.bodies[object].linvel().length()
    }

    #[test]
    fn a_body_that_passes_an_edge_does_not_push_it() {
        assert!(pushed(0.002, 0.002) < 1e-12, "{}", pushed(0.002, 0.002));
        assert!(pushed(0.002, 0.0) > 0.01, "{}", pushed(0.002, 0.0));
    }
}
