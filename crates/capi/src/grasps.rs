//! `CrannyGrasps`: a set of grasps as arrays.

use std::mem::MaybeUninit;
use std::path::{Path, PathBuf};
use std::ptr::null;

use cranny::grasp::{
    COVERAGE_THRESHOLD, Grasp, GraspSet, SampledGrasp, SamplerSettings, covering_subset, csv_text,
    pose_of_rows, read_csv, rows_of_pose, sample_grasps,
};
use cranny::scenario::{DEFAULT_FRICTION, filter_around_object, panda_hand, read_gripper, write_whole_file};
use cranny::shape::Surface;
use cranny::task::APPROACH_M;
use serde::Deserialize;

use crate::boundary::{Indices, Numbers, Text, answered, given, guarded, put};
use crate::error::CrannyStatus;
use crate::options::{parsed, refused};
use crate::world::soup;

/// Set of grasps of an object. It never changes.
///
/// A grasp is a pose of the gripper frame: its origin lies between the finger pads, y is the axis on which the fingers close, z
/// points out of the palm; two equal pads turned by 180° about z are the same grasp. Poses are in the planning frame, those of
/// cranny_grasps_sample in the frame of the mesh.
#[derive(Debug)]
pub struct CrannyGrasps {
    pub set: GraspSet,
    poses: Vec<f64>,
    scores: Vec<f64>,
    by_score: Vec<usize>,
}

impl CrannyGrasps {
    /// Wraps a set.
    pub fn of(set: GraspSet) -> Box<Self> {
        let poses = set.grasps().iter().flat_map(|grasp| rows_of_pose(&grasp.world_from_gripper)).collect();
        let scores = set.grasps().iter().map(|grasp| grasp.score.unwrap_or(f64::NAN)).collect();
        let by_score = set.by_score();
        Box::new(Self { set, poses, scores, by_score })
    }
}

/// Makes a set of `count` grasps at `poses`, `count` × 16: homogeneous matrices, row by row, in metres. `scores`: NULL, or
/// `count` values in [0, 1]; NaN: unknown. The caller frees it with cranny_grasps_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_grasps_new(
    poses: Numbers<'_>,
    scores: Numbers<'_>,
    count: usize,
    grasps: Option<&mut MaybeUninit<Option<Box<CrannyGrasps>>>>,
) -> CrannyStatus {
    guarded(|| {
        let poses = poses.finite("poses", count, 16)?.as_chunks::<16>().0;
        let scores = if scores.is_null() { &[][..] } else { scores.values("scores", count, 1)? };
        let mut made = Vec::with_capacity(count);
        for (index, pose) in poses.iter().enumerate() {
            let score = scores.get(index).copied().filter(|score| !score.is_nan());
            made.push(Grasp { score, ..Grasp::at(pose_of_rows(pose)?) });
        }
        put(grasps, "grasps", Some(CrannyGrasps::of(GraspSet::new(made)?)))
    })
}

/// Reads a grasps.csv: 16 numbers of the pose row by row, then score, width, robust score, robust trials and load. The caller
/// frees it with cranny_grasps_free.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_grasps_load(
    path: Text<'_>,
    grasps: Option<&mut MaybeUninit<Option<Box<CrannyGrasps>>>>,
) -> CrannyStatus {
    guarded(|| put(grasps, "grasps", Some(CrannyGrasps::of(read_csv(Path::new(path.read("path")?))?))))
}

/// Options of the sampling of grasps, in the words of Python's `sample_grasps`.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Options {
    gripper: Option<PathBuf>,
    count: usize,
    candidates: Option<usize>,
    friction: f64,
    approaches: usize,
    approach_m: f64,
    bare: bool,
    seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            gripper: None,
            count: 200,
            candidates: None,
            friction: DEFAULT_FRICTION,
            approaches: 12,
            approach_m: APPROACH_M,
            bare: false,
            seed: 0,
        }
    }
}

/// Samples antipodal grasps of an object, scored by the friction that they need: `vertices`, `vertex_count` × 3 in metres, and
/// `triangles`, `triangle_count` × 3 indices of vertices. The caller frees the set with cranny_grasps_free.
///
/// `options`: NULL, or a JSON object with any of "gripper" (a YAML file; otherwise the hand of the built-in robot), "count"
/// (200), "candidates" (from which they are chosen; ten times as many), "friction" (0.35), "approaches" (directions about each
/// closing axis, 12), "approach_m" (straight line that the open hand must have free, 0.05), "bare" (true: without the check
/// of the hand), "seed" (0).
#[unsafe(no_mangle)]
pub extern "C" fn cranny_grasps_sample(
    vertices: Numbers<'_>,
    vertex_count: usize,
    triangles: Indices<'_>,
    triangle_count: usize,
    options: Text<'_>,
    grasps: Option<&mut MaybeUninit<Option<Box<CrannyGrasps>>>>,
) -> CrannyStatus {
    guarded(|| {
        let mesh = soup(vertices, vertex_count, triangles, triangle_count)?;
        let asked = parsed::<Options>(options)?;
        let wished = asked.candidates.unwrap_or(asked.count.saturating_mul(10)).max(asked.count);
        for (what, value, most) in
            [("count", wished, MOST_GRASPS), ("approaches", asked.approaches, MOST_APPROACHES)]
        {
            if value > most {
                return Err(refused(format!("`{what}` is {value}, but at most {most} is allowed")));
            }
        }
        let hand = match asked.gripper.as_deref() {
            Some(path) => read_gripper(path)?,
            None => panda_hand()?,
        };
        let surface = Surface::new(&mesh)?;
        let settings = SamplerSettings {
            count: wished,
            friction: asked.friction,
            opening_m: hand.opening_m,
            closed_gap_m: hand.closed_gap_m(),
            approaches: asked.approaches,
            // Rejects early what the filter of the hand would reject anyway.
            finger_depth_m: Some(hand.finger_depth_m).filter(|depth_m| !asked.bare && *depth_m > 0.0),
            seed: asked.seed,
            ..SamplerSettings::default()
        };
        let filter = if asked.bare {
            None
        } else {
            Some(filter_around_object(&hand, &mesh, &surface, Vec::new(), asked.approach_m)?)
        };
        let accept = |sampled: &SampledGrasp| filter.as_ref().is_none_or(|f| f.is_free(&sampled.grasp));
        let found = sample_grasps(&surface, &settings, &accept, &mut |_| true)?;
        let found: Vec<Grasp> = found.grasps.iter().map(|sampled| sampled.grasp).collect();
        let chosen = covering_subset(&found, asked.count, COVERAGE_THRESHOLD);
        let chosen = GraspSet::new(chosen.into_iter().map(|index| found[index]).collect())?;
        put(grasps, "grasps", Some(CrannyGrasps::of(chosen)))
    })
}

/// Most grasps; more would be a mistake, because they are compared with each other.
const MOST_GRASPS: usize = 1_000_000;

/// Most directions about one axis; more would be a mistake.
const MOST_APPROACHES: usize = 360;

/// Frees a set of grasps. NULL is ignored.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_grasps_free(grasps: Option<Box<CrannyGrasps>>) {
    drop(grasps);
}

/// Returns the number of grasps; 0 for NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_grasps_count(grasps: Option<&CrannyGrasps>) -> usize {
    answered(0, || Ok(given(grasps, "grasps")?.set.len()))
}

/// Returns the poses, count × 16: homogeneous matrices, row by row, in metres. They are valid as long as the set.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_grasps_poses(grasps: Option<&CrannyGrasps>) -> *const f64 {
    answered(null(), || Ok(given(grasps, "grasps")?.poses.as_ptr()))
}

/// Returns the scores, count values in [0, 1]; NaN: unknown. They are valid as long as the set.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_grasps_scores(grasps: Option<&CrannyGrasps>) -> *const f64 {
    answered(null(), || Ok(given(grasps, "grasps")?.scores.as_ptr()))
}

/// Returns the indices of the grasps in the order of falling score, count values; grasps without a score come last. They are
/// valid as long as the set.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_grasps_by_score(grasps: Option<&CrannyGrasps>) -> *const usize {
    answered(null(), || Ok(given(grasps, "grasps")?.by_score.as_ptr()))
}

/// Writes a grasps.csv, whole or not at all.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_grasps_save(grasps: Option<&CrannyGrasps>, path: Text<'_>) -> CrannyStatus {
    guarded(|| {
        let (grasps, path) = (given(grasps, "grasps")?, path.read("path")?);
        Ok(write_whole_file(Path::new(path), csv_text(&grasps.set).as_bytes())?)
    })
}
