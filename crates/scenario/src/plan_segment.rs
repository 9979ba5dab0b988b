use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::{PlanFile, ScenarioError};

/// A piece of a plan's path. What a version does not know is refused by name: nobody runs half a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanSegment {
    /// What joins the way points: `polyline`, straight lines.
    pub kind: String,
    /// What the robot does meanwhile: `reach`, the hand open and empty.
    #[serde(default)] // Of a kind that nobody knows the kind is told, not what it lacks.
    pub mode: String,
    /// The object that the hand carries; `None` in `reach`.
    pub attached: Option<String>,
    /// How far apart the fingers are, in metres; `None`: as far as they go.
    pub opening_m: Option<f64>,
    /// One value per joint each (m, rad).
    #[serde(default)]
    pub waypoints: Vec<Vec<f64>>,
    /// The least clearance along each edge, in metres, proven; `None` where nothing is near, empty without a proof.
    #[serde(default)]
    pub clearances_m: Vec<Option<f64>>,
}

const POLYLINE: &str = "polyline";
const REACH: &str = "reach";

impl PlanSegment {
    /// A path of straight lines with the hand open and empty.
    pub fn reach(waypoints: Vec<Vec<f64>>, clearances_m: Vec<Option<f64>>) -> Self {
        let (kind, mode) = (POLYLINE.to_owned(), REACH.to_owned());
        Self { kind, mode, attached: None, opening_m: None, waypoints, clearances_m }
    }

    /// The way points of segments that follow each other: where two meet, one.
    ///
    /// # Errors
    /// A sentence: what this version does not know of a segment, or that one is empty or does not begin where the one
    /// before ends.
    pub fn joined(segments: &[Self]) -> Result<Vec<Vec<f64>>, String> {
        let mut joined: Vec<Vec<f64>> = Vec::new();
        for (index, segment) in segments.iter().enumerate() {
            if let Some(unknown) = segment.unknown() {
                return Err(format!("segment {index} {unknown}"));
            }
            let Some(first) = segment.waypoints.first() else {
                return Err(format!("segment {index} has no way points"));
            };
            if joined.pop().is_some_and(|last| last != *first) {
                return Err(format!("segment {index} does not begin where segment {} ends", index - 1));
            }
            joined.extend_from_slice(&segment.waypoints);
        }
        Ok(joined)
    }

    /// What this version does not know of the segment.
    fn unknown(&self) -> Option<String> {
        let unknown = if self.kind != POLYLINE {
            format!("is of kind '{}'", self.kind)
        } else if self.mode != REACH {
            format!("is of mode '{}'", self.mode)
        } else if let Some(object) = &self.attached {
            format!("carries '{object}'")
        } else {
            format!("opens the hand by {} m", self.opening_m?)
        };
        Some(format!("{unknown}, which this version does not know ({POLYLINE}, {REACH})"))
    }
}

/// Whether a file is of a format that this version knows: its own, or none, as before there was any.
///
/// # Errors
/// [`ScenarioError::Content`] for another.
pub(crate) fn check_format(path: &Path, format: Option<&str>) -> Result<(), ScenarioError> {
    let Some(other) = format.filter(|format| *format != PlanFile::FORMAT) else { return Ok(()) };
    Err(fault(path, format!("its format is '{other}', but this version reads '{}'", PlanFile::FORMAT)))
}

/// Checks the segments of a plan that was read, or makes that of one written before there were any.
///
/// # Errors
/// [`ScenarioError::Content`] for a segment that this version does not know, or segments that say something else than
/// the plan's own way points.
pub(crate) fn check_segments(path: &Path, plan: &mut PlanFile) -> Result<(), ScenarioError> {
    let of_waypoints = segments_of(&plan.waypoints, &plan.clearances_per_edge_m);
    if plan.format.is_none() {
        plan.segments = of_waypoints;
        plan.format = Some(PlanFile::FORMAT.to_owned());
        return Ok(());
    }
    PlanSegment::joined(&plan.segments).map_err(|problem| fault(path, problem))?;
    if plan.segments != of_waypoints {
        return Err(fault(path, "its segments are not its way points and clearances".to_owned()));
    }
    Ok(())
}

fn fault(path: &Path, problem: String) -> ScenarioError {
    ScenarioError::Content { path: path.to_owned(), problem }
}

/// The segments of a path: one, or none where there is no path.
pub(crate) fn segments_of(waypoints: &[Vec<f64>], clearances_m: &[Option<f64>]) -> Vec<PlanSegment> {
    if waypoints.is_empty() {
        Vec::new()
    } else {
        vec![PlanSegment::reach(waypoints.to_vec(), clearances_m.to_vec())]
    }
}
