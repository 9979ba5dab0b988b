use std::str::FromStr as _;

use cranny_solve::{Mode, Segment};
use serde::{Deserialize, Serialize};

/// A piece of a plan's path. What a version does not know is refused by name: nobody runs half a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanSegment {
    /// What joins the way points: `polyline`, straight lines.
    pub kind: String,
    /// What the robot does meanwhile: `reach`, the hand open and empty; `lift-off`, the object in the closed hand, off what
    /// it rests on; `carry`, from
    /// there on; `set-down`, down to where it is put; `retreat`, the hand open again, off the object; `return`, home.
    #[serde(default)] // Of a kind that nobody knows the kind is told, not what it lacks.
    pub mode: String,
    /// The object that the hand carries; `None` while it is open.
    pub attached: Option<String>,
    /// How far apart the fingers are, in metres; `None`: as far as they go.
    pub opening_m: Option<f64>,
    /// How much farther the finger that meets the object last would have to go than the first, in metres: so far the
    /// object is pushed, or the hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uneven_m: Option<f64>,
    /// One value per joint each (m, rad).
    #[serde(default)]
    pub waypoints: Vec<Vec<f64>>,
    /// The least clearance along each edge, in metres, proven; `None` where nothing is near, empty without a proof.
    #[serde(default)]
    pub clearances_m: Vec<Option<f64>>,
}

const POLYLINE: &str = "polyline";

impl PlanSegment {
    /// What a file says of a segment of an answer.
    pub fn of(segment: &Segment) -> Self {
        let (kind, mode) = (POLYLINE.to_owned(), segment.mode.name().to_owned());
        let Segment { attached, opening_m, uneven_m, waypoints, clearances_m, .. } = segment.clone();
        Self { kind, mode, attached, opening_m, uneven_m, waypoints, clearances_m }
    }

    /// The segment that it stands for.
    ///
    /// # Errors
    /// A sentence: what this version does not know of it.
    pub fn segment(&self) -> Result<Segment, String> {
        let known = Mode::from_str(&self.mode).ok().filter(|_| self.kind == POLYLINE);
        let unknown = match (known, &self.attached, self.opening_m) {
            (None, _, _) if self.kind != POLYLINE => format!("is of kind '{}'", self.kind),
            (None, _, _) => format!("is of mode '{}'", self.mode),
            (Some(Mode::Reach), Some(object), _) => format!("carries '{object}' before anything is grasped"),
            (Some(Mode::Reach), _, Some(opening_m)) => {
                format!("opens the hand by {opening_m} m on its way to the grasp")
            }
            (Some(mode), Some(object), _) if !mode.holds() => format!("carries '{object}' that was put down"),
            (Some(mode), _, Some(opening_m)) if !mode.holds() => {
                format!("opens the hand by {opening_m} m where it is open")
            }
            (Some(mode), attached, opening_m) => {
                let (attached, uneven_m) = (attached.clone(), self.uneven_m);
                let (waypoints, clearances_m) = (self.waypoints.clone(), self.clearances_m.clone());
                return Ok(Segment { mode, attached, opening_m, uneven_m, waypoints, clearances_m });
            }
        };
        Err(format!(
            "{unknown}, which this version does not know ({POLYLINE}; reach, lift-off, carry, set-down, retreat, return)"
        ))
    }

    /// The way points of segments that follow each other: where two meet, one.
    ///
    /// # Errors
    /// A sentence: what this version does not know of a segment, or that one is empty, does not begin where the one before
    /// ends, or follows one that it cannot follow.
    pub fn joined(segments: &[Self]) -> Result<Vec<Vec<f64>>, String> {
        let mut joined: Vec<Vec<f64>> = Vec::new();
        let mut modes = Vec::new();
        for (index, segment) in segments.iter().enumerate() {
            modes.push(segment.segment().map_err(|unknown| format!("segment {index} {unknown}"))?.mode);
            let Some(first) = segment.waypoints.first() else {
                return Err(format!("segment {index} has no way points"));
            };
            if joined.pop().is_some_and(|last| last != *first) {
                return Err(format!("segment {index} does not begin where segment {} ends", index - 1));
            }
            joined.extend_from_slice(&segment.waypoints);
        }
        let is_task = match &modes[..] {
            [Mode::Reach, Mode::LiftOff, Mode::Carry, put_down @ ..] => {
                matches!(
                    put_down,
                    [] | [Mode::SetDown, Mode::Retreat] | [Mode::SetDown, Mode::Retreat, Mode::Return]
                )
            }
            _ => false,
        };
        if !is_task && modes.iter().any(|mode| *mode != Mode::Reach) {
            return Err(
                "its segments are neither a reach nor a reach, a lift-off and a carry, which a set-down, a \
                        retreat and a return may follow"
                    .to_owned(),
            );
        }
        Ok(joined)
    }
}

/// The segments of a path to a grasp: one, or none where there is no path.
pub(crate) fn segments_of(waypoints: &[Vec<f64>], clearances_m: &[Option<f64>]) -> Vec<PlanSegment> {
    let reach = || PlanSegment::of(&Segment::reach(waypoints.to_vec(), clearances_m.to_vec()));
    (!waypoints.is_empty()).then(reach).into_iter().collect()
}
