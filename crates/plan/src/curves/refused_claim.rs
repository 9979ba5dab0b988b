use std::fmt;

use cranny_collision::{Cell, Contact, Motion, Scratch};
use cranny_robot::between;
use serde::{Deserialize, Serialize};

/// Fault of a path whose way points are free, but that could not be proven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RefusedClaim {
    /// Index of the first edge without a proof.
    pub edge: usize,
    /// Parameter in [0, 1] along this edge.
    pub at: f64,
    /// Names of the colliders there; `None` if a bound of the tool or a joint limit is exceeded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pair: Option<[String; 2]>,
    /// Greatest penetration depth of any pair on this edge, by samples, in metres; 0 if pairs only come too near, or may.
    pub depth_m: f64,
}

/// Number of samples along an edge that is not proven.
const SAMPLES: u32 = 32;

impl RefusedClaim {
    /// Proves every edge of a path of way points (m, rad; one value per joint); returns the first fault.
    pub(crate) fn of(cell: &Cell, path: &[Vec<f64>], scratch: &mut Scratch) -> Option<Self> {
        path.windows(2).enumerate().find_map(|(edge, ends)| {
            let ends = [&ends[0][..], &ends[1][..]];
            let motion = cell.motion_is_free(ends[0], ends[1], scratch);
            Self::of_motion(cell, (edge, ends), motion, scratch)
        })
    }

    fn of_motion(
        cell: &Cell,
        (edge, [a, b]): (usize, [&[f64]; 2]),
        motion: Motion,
        scratch: &mut Scratch,
    ) -> Option<Self> {
        let (at, contact) = match motion {
            Motion::Proven => return None,
            Motion::Contact { at, contact } | Motion::Unresolved { at, contact } => (at, Some(contact)),
            Motion::OutOfBounds { at, .. } => (at, None),
            Motion::OutOfLimits { .. } => (0.0, None),
        };
        let Some(contact) = contact else { return Some(Self { edge, at, pair: None, depth_m: 0.0 }) };
        let mut deepest: (f64, Contact) = (at, contact);
        for sample in 0..=SAMPLES {
            let share = f64::from(sample) / f64::from(SAMPLES);
            let q: Vec<f64> = between(a, b, share).collect();
            for contact in cell.contacts(&q, scratch) {
                if contact.depth_m > deepest.1.depth_m {
                    deepest = (share, contact);
                }
            }
        }
        let (at, contact) = deepest;
        Some(Self { edge, at, pair: Some(contact.names(cell)), depth_m: contact.depth_m })
    }
}

impl fmt::Display for RefusedClaim {
    /// Writes the depth and the pair: "3.1 mm deep at link5–box".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// Millimetres per metre.
        const PER_METRE: f64 = 1e3;
        match &self.pair {
            Some([first, second]) if self.depth_m > 0.0 => {
                write!(f, "{:.1} mm deep at {first}–{second}", self.depth_m * PER_METRE)
            }
            Some([first, second]) => write!(f, "too near at {first}–{second}"),
            None => write!(f, "a bound or a limit exceeded on edge {}", self.edge),
        }
    }
}
