//! Antipodal grasps of a bare object (the paper's §IV.C; Eppner et al. 2019, §III).
//!
//! 1. Draws a first contact, uniform over the surface's area.
//! 2. Casts rays from it, uniform over the solid angle of the friction cone about the inward normal.
//! 3. Takes a second contact wherever a ray leaves the object, no farther away than the gripper opens, if the ray lies inside
//!    that contact's friction cone too, and both contacts are the first that the pads meet as they close. Faces inside other
//!    components of the object, or in its sealed cavities, are no contacts.
//! 4. Spaces approach directions evenly about the closing axis, and keeps all or some of them.
//! 5. Drops grasps that the caller does not accept (a hand that collides).
//! 6. Drops grasps that equal an earlier one, or its twin.
//!
//! First contacts come in chunks of a fixed size, each with its own random stream, and are merged in the order of the
//! chunks: the result does not depend on the number of threads.

use cranny_shape::{AreaDistribution, Surface, SurfacePoint};
use cranny_spatial::{Point, Pose, Rotation, Stream, Vector, nalgebra, sin_cos};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::twins::TwinFilter;
use crate::{Contact, Grasp, GraspError, friction_needed, friction_score};

/// Settings of the grasp sampler. Directions are in the object's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct SamplerSettings {
    /// Number of grasps to find. Default 2000.
    pub count: usize,
    /// Coefficient of friction between pads and object, which bounds the cones and scales the score; positive. Default
    /// 0.24, the value of all objects in the paper's library.
    pub friction: f64,
    /// Maximum distance of two contacts, in metres: the gripper's opening. Default 0.08, a Panda's.
    pub opening_m: f64,
    /// Minimum distance of two contacts, in metres: the gap that stays between the pads of the closed hand
    /// ([`Hand::closed_gap_m`](crate::Hand::closed_gap_m)). Default 0: the pads meet.
    pub closed_gap_m: f64,
    /// Rays from each first contact. Default 1: another contact adds more than another ray from the same one.
    pub rays: usize,
    /// Approach directions about each closing axis. Default 12, every 30°, as in the released grasps.
    pub approaches: usize,
    /// Number of approach directions that each pair of contacts keeps, drawn at random. Default 1: another pair adds more
    /// than another turn about the same one.
    pub kept_approaches: usize,
    /// Direction of the first approach. Default [`FirstApproach::Level`], as in the released grasps.
    pub first_approach: FirstApproach,
    /// Upward direction. Default z.
    pub up: Vector,
    /// Maximum elevation of an approach direction, in radians from −π/2 to π/2: 0 keeps approaches from the side or from
    /// above. Default π/2: all.
    pub steepest_rise_rad: f64,
    /// Height of the ground along `up`, in metres in the object's frame. Drops grasps with an open pad, half the opening beside
    /// the origin of the gripper frame, below the ground. Default none. The released grasps follow this rule; `accept` must
    /// check that the whole hand stays above.
    pub ground_m: Option<f64>,
    /// Distance of the palm behind the gripper frame, in metres ([`Hand::finger_depth_m`](crate::Hand::finger_depth_m)). Drops
    /// grasps for which the object reaches farther back, on the line of approach through the frame, because the palm would
    /// collide. The released grasps follow this rule for a Panda's 46.6 mm. Default none: `accept` must check this.
    pub finger_depth_m: Option<f64>,
    /// Range of depths of the gripper frame, in metres along the approach direction from the middle between the contacts,
    /// drawn uniformly. Default 0 to 0, as in the released grasps.
    pub depth_m: [f64; 2],
    /// Number of first contacts after which the search gives up. Default a million: about two seconds.
    pub most_contacts: usize,
    /// Seed of all randomness. Default 0.
    pub seed: u64,
}

/// Direction of the first of several approaches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FirstApproach {
    /// Level: at a right angle to `up`. Objects that lie as given are then grasped from the side and from above at the
    /// same angles.
    #[default]
    Level,
    /// Random, drawn anew for each closing axis.
    Random,
}

impl Default for SamplerSettings {
    fn default() -> Self {
        Self {
            count: 2000,
            friction: 0.24,
            opening_m: 0.08,
            closed_gap_m: 0.0,
            rays: 1,
            approaches: 12,
            kept_approaches: 1,
            first_approach: FirstApproach::Level,
            up: Vector::z(),
            steepest_rise_rad: std::f64::consts::FRAC_PI_2,
            ground_m: None,
            finger_depth_m: None,
            depth_m: [0.0, 0.0],
            most_contacts: 1_000_000,
            seed: 0,
        }
    }
}

/// Grasp with the contacts that it was made from. Its pose is `object_from_gripper`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampledGrasp {
    /// The grasp, with its score and width.
    pub grasp: Grasp,
    /// Contacts of the pads, first at −y of the gripper, then at +y.
    pub contacts: [Contact; 2],
}

/// Result of a sampling.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampling {
    /// Grasps found, at most `count`.
    pub grasps: Vec<SampledGrasp>,
    /// Number of first contacts tried.
    pub first_contacts: usize,
    /// Number of pairs of contacts found in force closure.
    pub pairs: usize,
    /// Number of grasps that the caller did not accept.
    pub rejected: usize,
    /// Number of grasps left out because they equal an earlier one, or its twin.
    pub merged: usize,
}

/// Samples grasps on `surface`, whose triangles face outwards; it may have holes.
///
/// Several threads call `accept`, which returns true for a grasp to keep. After each wave `progress` gets the number of
/// grasps, and returns false to stop.
///
/// # Errors
/// [`GraspError::Setting`] for a setting out of its range, [`GraspError::NoArea`].
pub fn sample_grasps(
    surface: &Surface,
    settings: &SamplerSettings,
    accept: &(dyn Fn(&SampledGrasp) -> bool + Sync),
    progress: &mut dyn FnMut(usize) -> bool,
) -> Result<Sampling, GraspError> {
    resume_sampling(Sampling::default(), surface, settings, accept, progress)
}

/// Continues [`sample_grasps`] after a stop, with the same arguments; the final result is the same.
///
/// # Errors
/// As [`sample_grasps`].
pub fn resume_sampling(
    known: Sampling,
    surface: &Surface,
    settings: &SamplerSettings,
    accept: &(dyn Fn(&SampledGrasp) -> bool + Sync),
    progress: &mut dyn FnMut(usize) -> bool,
) -> Result<Sampling, GraspError> {
    let sampler = GraspSampler::new(surface, settings)?;
    let mut found = known;
    let mut twins = TwinFilter::default();
    for known in &found.grasps {
        twins.is_new(&known.grasp);
    }
    let mut chunk = (found.first_contacts / CONTACTS_PER_CHUNK) as u64;
    while found.grasps.len() < settings.count && found.first_contacts < settings.most_contacts {
        let wave: Vec<Chunk> = (chunk..chunk + CHUNKS_PER_WAVE)
            .into_par_iter()
            .map(|chunk| Chunk::sampled(chunk, &sampler, accept))
            .collect();
        chunk += CHUNKS_PER_WAVE;
        for chunk in wave {
            if found.grasps.len() >= settings.count || found.first_contacts >= settings.most_contacts {
                break;
            }
            found.first_contacts += CONTACTS_PER_CHUNK;
            found.pairs += chunk.pairs;
            found.rejected += chunk.rejected;
            for sampled in chunk.grasps {
                if !twins.is_new(&sampled.grasp) {
                    found.merged += 1;
                } else if found.grasps.len() < settings.count {
                    found.grasps.push(sampled);
                }
            }
        }
        if !progress(found.grasps.len()) {
            break;
        }
    }
    Ok(found)
}

/// First contacts that share a random stream: enough to outweigh the cost of the stream.
const CONTACTS_PER_CHUNK: usize = 16;

/// Chunks between two reports of progress; a fixed number, so that it does not affect the result.
const CHUNKS_PER_WAVE: u64 = 32;

/// Minimum distance of two contacts, in metres: no finger closes on less than the noise of an export.
const LEAST_WIDTH_M: f64 = 1e-4;

/// Distance below which layers of a surface count as one, in metres, for the pad that meets the outer one.
const LEAST_GAP_M: f64 = 1e-5;

impl SamplerSettings {
    fn check(&self) -> Result<(), GraspError> {
        let fault = |setting: &'static str, value: f64, range: &'static str| {
            Err(GraspError::Setting { setting, value, range })
        };
        let is_positive = |x: f64| x > 0.0 && x.is_finite();
        if !is_positive(self.friction) {
            return fault("friction", self.friction, "a positive number");
        }
        if !is_positive(self.opening_m) {
            return fault("opening", self.opening_m, "a positive number of metres");
        }
        if !is_positive(self.up.norm()) {
            return fault("length of the upward direction", self.up.norm(), "positive");
        }
        if let Some(ground_m) = self.ground_m.filter(|height| !height.is_finite()) {
            return fault("height of the ground", ground_m, "a finite number of metres");
        }
        if let Some(depth_m) = self.finger_depth_m.filter(|depth_m| !is_positive(*depth_m)) {
            return fault("depth of the fingers", depth_m, "a positive number of metres");
        }
        let [low, high] = self.depth_m;
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return fault("depth range", high - low, "two finite numbers, the lower first");
        }
        if self.steepest_rise_rad.is_nan() || self.steepest_rise_rad.abs() > std::f64::consts::FRAC_PI_2 {
            return fault("steepest rise", self.steepest_rise_rad, "between −π/2 and π/2 rad");
        }
        for (setting, count) in
            [("rays", self.rays), ("approaches", self.approaches), ("kept approaches", self.kept_approaches)]
        {
            if count == 0 {
                return fault(setting, 0.0, "at least 1");
            }
        }
        Ok(())
    }
}

/// Grasps from the first contacts of one random stream.
#[derive(Default)]
struct Chunk {
    grasps: Vec<SampledGrasp>,
    pairs: usize,
    rejected: usize,
}

impl Chunk {
    fn sampled(number: u64, sampler: &GraspSampler, accept: &(dyn Fn(&SampledGrasp) -> bool + Sync)) -> Self {
        let mut random = Stream::new(sampler.settings.seed, number);
        let mut chunk = Self::default();
        for _ in 0..CONTACTS_PER_CHUNK {
            chunk.pairs += sampler.draw(&mut random, &mut |sampled| {
                // 5.
                if accept(&sampled) {
                    chunk.grasps.push(sampled);
                } else {
                    chunk.rejected += 1;
                }
            });
        }
        chunk
    }
}

/// Sampler of one first contact at a time (1. to 4. of the method above), for callers that need few grasps on demand.
#[derive(Clone, Debug)]
pub struct GraspSampler<'a> {
    surface: &'a Surface,
    area: AreaDistribution<'a>,
    settings: SamplerSettings,
}

impl<'a> GraspSampler<'a> {
    /// Creates the sampler of grasps on `surface`. [`Self::draw`] ignores the seed of `settings`, and the numbers of
    /// grasps and of first contacts.
    ///
    /// # Errors
    /// As [`sample_grasps`].
    pub fn new(surface: &'a Surface, settings: &SamplerSettings) -> Result<Self, GraspError> {
        settings.check()?;
        let area = AreaDistribution::new(surface).ok_or(GraspError::NoArea)?;
        Ok(Self { surface, area, settings: settings.clone() })
    }

    /// Least distance of two contacts in force closure, in metres, over `first_contacts` first contacts, if the object is too
    /// wide: all pairs are farther apart than `most_m` (m), which is at most the opening. `None` for an object that is not too
    /// wide, and if there is no pair.
    pub fn too_wide_m(&self, first_contacts: usize, most_m: f64) -> Option<f64> {
        let endless_m = 4.0 * self.surface.aabb().half_extents.norm();
        let settings = SamplerSettings { opening_m: endless_m, ..self.settings.clone() };
        let mut random = Stream::new(settings.seed, 0);
        let mut narrowest_m = f64::INFINITY;
        for _ in 0..first_contacts {
            let first = self.area.point([random.uniform(), random.uniform(), random.uniform()]);
            let ray = direction_in_cone(&-first.normal, settings.friction, &mut random);
            for [one, other] in pairs_along(self.surface, &first, &ray, &settings, self.settings.opening_m) {
                narrowest_m = narrowest_m.min((one.point_in_object - other.point_in_object).norm());
            }
            if narrowest_m <= most_m {
                return None;
            }
        }
        Some(narrowest_m).filter(|distance_m| distance_m.is_finite())
    }

    /// Draws one first contact and passes the grasps that result, often none, to `found`. Returns the number of its pairs
    /// of contacts in force closure.
    pub fn draw(&self, random: &mut Stream, found: &mut dyn FnMut(SampledGrasp)) -> usize {
        let Self { surface, area, settings } = self;
        let mut pairs = 0;
        // 1.
        let first = area.point([random.uniform(), random.uniform(), random.uniform()]);
        for _ in 0..settings.rays {
            // 2.
            let ray = direction_in_cone(&-first.normal, settings.friction, random);
            // 3.
            for contacts in pairs_along(surface, &first, &ray, settings, settings.opening_m) {
                pairs += 1;
                // 4.
                let has_room = |pose: &Pose| palm_has_room(surface, pose, settings.finger_depth_m);
                for pose in gripper_poses(&contacts, settings, &has_room, random) {
                    found(scored(pose, contacts, settings.friction));
                }
            }
        }
        pairs
    }
}

/// Unit vector, uniform over the solid angle of the cone about `axis` whose half angle has the tangent `friction`.
fn direction_in_cone(axis: &Vector, friction: f64, random: &mut Stream) -> Vector {
    let least_cosine = 1.0 / (1.0 + friction * friction).sqrt();
    let cosine = random.uniform_between(least_cosine, 1.0);
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin_turn, cos_turn) = sin_cos(std::f64::consts::TAU * random.uniform());
    let [across, beside] = perpendiculars(axis);
    axis * cosine + (across * cos_turn + beside * sin_turn) * sine
}

/// Pairs of contacts in force closure along a ray that the pads meet first as they close from `opening_m` (m) apart,
/// straight towards each other. The first contact of a pair is at −y, and a pair and its twin have the same y axis.
fn pairs_along(
    surface: &Surface,
    first: &SurfacePoint,
    ray: &Vector,
    settings: &SamplerSettings,
    opening_m: f64,
) -> Vec<[Contact; 2]> {
    let contact = |point: Point, normal: Vector| Contact { point_in_object: point, normal_in_object: normal };
    let begin = contact(first.point, first.normal);
    let beyond_m = 4.0 * surface.aabb().half_extents.norm();
    let mut pairs = Vec::new();
    for hit in surface.ray_hits(&first.point, ray, settings.opening_m) {
        let end = contact(first.point + ray * hit.distance_m, hit.normal);
        let leaves = hit.normal.dot(ray) > 0.0 && hit.distance_m >= LEAST_WIDTH_M.max(settings.closed_gap_m);
        let travel_m = 0.5 * (opening_m - hit.distance_m);
        // The next surface outwards must be farther than the open pad and face the contact. The ray starts beyond the
        // surface of the contact itself, which lies within rounding.
        let is_met_first = |contact: &Contact, outwards: Vector| {
            let before = contact.point_in_object + outwards * LEAST_GAP_M;
            let met = surface.ray_hits(&before, &outwards, beyond_m);
            met.first().is_none_or(|met| met.distance_m > travel_m && met.normal.dot(&outwards) < 0.0)
        };
        if leaves
            && friction_needed(&begin, &end) <= settings.friction
            && is_met_first(&begin, -ray)
            && is_met_first(&end, *ray)
        {
            let is_turned = ray[ray.iamax()] < 0.0;
            pairs.push(if is_turned { [end, begin] } else { [begin, end] });
        }
    }
    pairs
}

/// Returns true if the object ends before the palm, on the line of approach.
fn palm_has_room(surface: &Surface, pose: &Pose, finger_depth_m: Option<f64>) -> bool {
    finger_depth_m.is_none_or(|depth_m| {
        let back = pose.rotation * -Vector::z();
        let palm = Point::from(pose.translation.vector + back * depth_m);
        // The ray reaches from the palm beyond the far side of the object.
        surface.ray_hits(&palm, &back, 4.0 * surface.aabb().half_extents.norm()).is_empty()
    })
}

/// Poses of the gripper frame about one pair of contacts that `has_room` accepts.
fn gripper_poses(
    contacts: &[Contact; 2],
    settings: &SamplerSettings,
    has_room: &dyn Fn(&Pose) -> bool,
    random: &mut Stream,
) -> Vec<Pose> {
    let [begin, end] = contacts.map(|contact| contact.point_in_object);
    let y = (end - begin).normalize();
    let middle = begin + (end - begin) * 0.5;
    let up = settings.up.normalize();
    let level = y.cross(&up);
    // An upright closing axis has only level approaches, and any may be the first.
    let first = level.try_normalize(UPRIGHT).unwrap_or_else(|| perpendiculars(&y)[0]);
    let beside = first.cross(&y);
    let step = std::f64::consts::TAU / settings.approaches as f64;
    let begin_at = match settings.first_approach {
        FirstApproach::Level => 0.0,
        FirstApproach::Random => step * random.uniform(),
    };
    let greatest_rise = sin_cos(settings.steepest_rise_rad).0 + LEVEL;
    let mut poses = Vec::new();
    for index in 0..settings.approaches {
        let (sine, cosine) = sin_cos(begin_at + step * index as f64);
        let depth_m = random.uniform_between(settings.depth_m[0], settings.depth_m[1]);
        let z = first * cosine + beside * sine;
        if z.dot(&up) > greatest_rise {
            continue;
        }
        let axes = nalgebra::Matrix3::from_columns(&[y.cross(&z), y, z]);
        let rotation = nalgebra::Rotation3::from_matrix_unchecked(axes);
        let origin = middle + z * depth_m;
        let lower_pad_m = origin.coords.dot(&up) - 0.5 * settings.opening_m * y.dot(&up).abs();
        if settings.ground_m.is_some_and(|ground_m| lower_pad_m < ground_m) {
            continue;
        }
        let pose = Pose::from_parts(origin.coords.into(), Rotation::from_rotation_matrix(&rotation));
        poses.push(pose);
    }
    if settings.finger_depth_m.is_none() {
        while poses.len() > settings.kept_approaches {
            poses.swap_remove(random.index(poses.len()));
        }
        return poses;
    }
    // In random order, so that few poses are checked.
    let mut kept = Vec::new();
    while kept.len() < settings.kept_approaches && !poses.is_empty() {
        let pose = poses.swap_remove(random.index(poses.len()));
        if has_room(&pose) {
            kept.push(pose);
        }
    }
    kept
}

/// Sine of the angle to `up` below which a closing axis counts as upright.
const UPRIGHT: f64 = 1e-6;

/// Tolerance for the rounding of a level approach, as the sine of its rise.
const LEVEL: f64 = 1e-9;

fn scored(object_from_gripper: Pose, contacts: [Contact; 2], friction: f64) -> SampledGrasp {
    let [a, b] = &contacts;
    let grasp = Grasp {
        world_from_gripper: object_from_gripper,
        score: Some(friction_score(friction_needed(a, b), friction)),
        width_m: Some((b.point_in_object - a.point_in_object).norm()),
        robust: None,
        load: None,
        has_no_twin: false,
    };
    SampledGrasp { grasp, contacts }
}

/// Two unit vectors at right angles to `axis` and to each other.
fn perpendiculars(axis: &Vector) -> [Vector; 2] {
    let mut helper = Vector::zeros();
    helper[axis.iamin()] = 1.0;
    let across = axis.cross(&helper).normalize();
    [across, axis.cross(&across)]
}
