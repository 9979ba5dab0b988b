use std::f64::consts::TAU;

use cranny_shape::Ball;
use cranny_spatial::{Point, Stream, Vector};

use crate::{Camera, SenseError, SensedScene};

/// Request for cameras around a target.
#[derive(Clone, Debug, PartialEq)]
pub struct DefaultCameras {
    /// Number of cameras.
    pub count: usize,
    /// Width and height of their images, in pixels.
    pub size_px: [usize; 2],
    /// Horizontal field of view, in radians; 70° by default, as of common depth cameras.
    pub field_of_view_rad: f64,
    /// Number of the segment of the target.
    pub target: u16,
    /// Centre of the target, in the planning frame.
    pub aim: Point,
    /// Position of the tool at the start, in the planning frame; the space between it and the target is to be seen too.
    pub tool: Point,
    /// Balls around the links of the robot at the start, in the planning frame: the space between them and the target is to be seen
    /// too.
    pub links: Vec<Ball>,
    /// Direction against gravity in the planning frame, a unit vector.
    pub up: Vector,
}

impl DefaultCameras {
    /// Request for cameras of 320 × 240 pixels.
    pub fn new(count: usize, target: u16, [aim, tool]: [Point; 2], links: Vec<Ball>, up: Vector) -> Self {
        Self {
            count,
            size_px: [320, 240],
            field_of_view_rad: 70_f64.to_radians(),
            target,
            aim,
            tool,
            links,
            up,
        }
    }
}

/// Candidates: turns about the vertical through the target, rises above the horizontal (degrees), distances (m).
const TURNS: u32 = 16;
const RISES_DEG: [f64; 4] = [8.0, 22.0, 40.0, 65.0];
const DISTANCES_M: [f64; 5] = [0.45, 0.7, 1.0, 1.5, 2.1];

/// Width and height of the image by which a candidate is judged, in pixels.
const TRIAL_PX: [usize; 2] = [64, 48];

/// Width and height of the image in which the visible share of the target is measured, in pixels, and its field of view.
const CLOSE_UP_PX: [usize; 2] = [24, 24];

/// Least depth of anything before a camera, in metres: nearer, it is inside or against a body.
const LEAST_ROOM_M: f64 = 0.1;

/// Number of points whose visibility is counted, and radius of the ball around the target or the way to it that holds them, in
/// metres.
const POINTS: usize = 900;
const RADIUS_M: f64 = 0.35;

/// Depth up to which a point near the target is seen sharply enough for a hand beside it, in metres.
const SHARP_M: f64 = 0.4;

/// Depth up to which a point elsewhere is seen sharply enough for a link to pass, in metres.
const CLEAR_M: f64 = 1.6;

/// Space beside the links that they need, in metres.
const BESIDE_M: f64 = 0.15;

/// Weight of the visible share of the target for the first camera, which should see it sharply, relative to that of all points; for
/// further cameras it is divided by their number.
const TARGET_WEIGHT: f64 = 1.0;

/// Candidate with the points that it sees.
struct Candidate {
    camera: Camera,
    /// Sharpness with which it sees each point: 0 if it does not, 1 from near enough, and less from afar.
    sees: Vec<f64>,
    /// Share of the target that other bodies do not hide, 0 to 1.
    target_share: f64,
    /// Sharpness with which it sees the target.
    target_sharpness: f64,
}

/// Returns cameras around a target that look at it from free positions.
///
/// Candidates stand on rings around the target. The cameras are chosen one after another, each by the share of the target that it
/// sees and how sharply, and by how much more sharply than all cameras before it it sees points around the target, between it and the
/// tool, and beside the links that move towards it.
///
/// # Errors
/// [`SenseError::NoCameraPosition`] if there are fewer free candidates than cameras; [`SenseError::Camera`] for an invalid size or
/// field of view.
pub fn default_cameras(scene: &SensedScene, request: &DefaultCameras) -> Result<Vec<Camera>, SenseError> {
    let points = points_of_interest(request);
    let target_alone = scene.only(request.target);
    let mut candidates = Vec::new();
    for eye in eyes(request) {
        let Some(pose) = Camera::looking_at(&eye, &request.aim, &request.up) else { continue };
        let trial = Camera::with_field_of_view(TRIAL_PX, request.field_of_view_rad, pose)?;
        let seen = scene.render(&trial);
        if !seen.has_room(LEAST_ROOM_M) {
            continue;
        }
        let camera_from_world = pose.inverse();
        let sees =
            points.iter().map(|(point, near_m)| sees(&trial, &seen, &(camera_from_world * point), *near_m));
        let sees = sees.collect();
        let close_up = close_up(&trial, &eye, request)?;
        let count = |scene: &SensedScene| {
            scene.render(&close_up).segments.iter().filter(|segment| **segment == request.target).count()
        };
        let target_share = count(scene) as f64 / count(&target_alone).max(1) as f64;
        let target_sharpness = (SHARP_M / (eye - request.aim).norm()).min(1.0);
        let camera = Camera::with_field_of_view(request.size_px, request.field_of_view_rad, pose)?;
        candidates.push(Candidate { camera, sees, target_share, target_sharpness });
    }
    let (mut chosen, mut is_seen) = (Vec::new(), vec![0.0_f64; points.len()]);
    for number in 1..=request.count {
        // The first one looks at the target from near by, the others at what it does not see.
        let target_weight = |candidate: &Candidate| {
            TARGET_WEIGHT * if number == 1 { candidate.target_sharpness } else { 1.0 / number as f64 }
        };
        let value = |candidate: &Candidate| {
            let gains = candidate.sees.iter().zip(&is_seen).map(|(sees, seen)| (sees - seen).max(0.0));
            let new: f64 = gains.sum();
            new / points.len() as f64 + target_weight(candidate) * candidate.target_share
        };
        // The first of equal candidates.
        let best = (0..candidates.len())
            .rev()
            .max_by(|a, b| value(&candidates[*a]).total_cmp(&value(&candidates[*b])));
        let Candidate { camera, sees, .. } = candidates.remove(best.ok_or(SenseError::NoCameraPosition)?);
        for (is_seen, sees) in is_seen.iter_mut().zip(sees) {
            *is_seen = is_seen.max(sees);
        }
        chosen.push(camera);
    }
    Ok(chosen)
}

/// Positions of the candidates.
fn eyes(request: &DefaultCameras) -> impl Iterator<Item = Point> {
    // Horizontal directions: towards the tool, and to its left.
    let up = request.up;
    let away = request.tool - request.aim;
    let level = away - up * away.dot(&up);
    let others = [level, Vector::x(), Vector::y()];
    let ahead =
        others.iter().find_map(|way| (way - up * way.dot(&up)).try_normalize(1e-6)).unwrap_or_else(Vector::x);
    let left = up.cross(&ahead);
    let aim = request.aim;
    DISTANCES_M.into_iter().flat_map(move |distance_m| {
        RISES_DEG.into_iter().flat_map(move |rise_deg| {
            (0..TURNS).map(move |turn| {
                let (sin_turn, cos_turn) = cranny_spatial::sin_cos(TAU * f64::from(turn) / f64::from(TURNS));
                let (sin_rise, cos_rise) = cranny_spatial::sin_cos(rise_deg.to_radians());
                aim + (ahead * (cos_turn * cos_rise) + left * (sin_turn * cos_rise) + up * sin_rise)
                    * distance_m
            })
        })
    })
}

/// Points near the target, between it and the tool, and where links come along if they move towards it, each with the depth (m) up to
/// which it is seen sharply enough.
fn points_of_interest(request: &DefaultCameras) -> Vec<(Point, f64)> {
    let mut random = Stream::new(0, 0);
    let way = request.tool - request.aim;
    let level = request.up * way.dot(&request.up) - way;
    let within = |radius_m: f64, random: &mut Stream| loop {
        let drawn = Vector::from_fn(|_, _| random.uniform_between(-1.0, 1.0));
        if drawn.norm() <= 1.0 {
            break drawn * radius_m;
        }
    };
    (0..POINTS)
        .map(|index| {
            let share = random.uniform();
            match index % 3 {
                0 => (request.aim + within(RADIUS_M, &mut random), SHARP_M),
                1 if !request.links.is_empty() => {
                    let Ball { center, radius_m } = request.links[random.index(request.links.len())];
                    (center + level * share + within(radius_m + BESIDE_M, &mut random), CLEAR_M)
                }
                _ => (request.aim + way * share + within(RADIUS_M, &mut random), CLEAR_M),
            }
        })
        .collect()
}

fn sees(camera: &Camera, seen: &crate::Render, point_in_camera: &Point, near_m: f64) -> f64 {
    let Some([u, v]) = camera.project(point_in_camera) else { return 0.0 };
    let (u, v) = (u.round(), v.round());
    let is_inside = u >= 0.0 && v >= 0.0 && u < camera.width_px as f64 && v < camera.height_px as f64;
    if !is_inside {
        return 0.0;
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a pixel of the image")]
    let depth_m = seen.depth.depth_m(u as usize, v as usize);
    let is_seen = depth_m.is_some_and(|depth_m| f64::from(depth_m) > point_in_camera.z);
    if is_seen { (near_m / point_in_camera.z).min(1.0) } else { 0.0 }
}

/// Camera at the same position whose image the target fills.
fn close_up(camera: &Camera, eye: &Point, request: &DefaultCameras) -> Result<Camera, SenseError> {
    /// Radius around the centre of the target that is shown, in metres.
    const SHOWN_M: f64 = 0.15;
    let field_rad = 2.0 * libm::atan(SHOWN_M / (eye - request.aim).norm());
    Camera::with_field_of_view(CLOSE_UP_PX, field_rad, camera.world_from_camera)
}
