use std::fmt;

use cranny_file::distinct;
use cranny_shape::Surface;
use serde::{Deserialize, Serialize};

use crate::{GraspSampler, SamplerSettings};

/// Number of first contacts drawn: some ten of them hit a handle with a thousandth of the surface.
const FIRST_CONTACTS: usize = 10_000;

/// Object that no grasp fits, as sampled: two pads that hold it are farther apart than the hand opens.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TooWide {
    /// Least distance of two contacts in force closure, in metres.
    pub narrowest_m: f64,
    /// Distance between the pads of the open hand, in metres.
    pub opening_m: f64,
    /// Clearance required between the object and either pad of the open hand, in metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub clearance_m: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(clearance_m: &f64) -> bool {
    *clearance_m == 0.0
}

impl TooWide {
    /// Checks an object with a clearance (m) to either pad; `None` if it fits. `settings` are those of the grasp sampler.
    pub fn of(surface: &Surface, settings: &SamplerSettings, clearance_m: f64) -> Option<Self> {
        let opening_m = settings.opening_m;
        let most_m = opening_m - 2.0 * clearance_m;
        let narrowest_m = GraspSampler::new(surface, settings).ok()?.too_wide_m(FIRST_CONTACTS, most_m)?;
        Some(Self { narrowest_m, opening_m, clearance_m })
    }
}

impl fmt::Display for TooWide {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { narrowest_m, opening_m, clearance_m } = self;
        let left_m = (opening_m - 2.0 * clearance_m).max(0.0);
        let [narrowest, left] = distinct([narrowest_m, &left_m].map(|metres| metres * 1e3), 1);
        let hand = if is_zero(clearance_m) {
            format!("opens {left} mm")
        } else {
            let [opening_mm, clearance_mm] = [opening_m, clearance_m].map(|metres| metres * 1e3);
            format!("opens {opening_mm:.1} mm: {left} mm with {clearance_mm:.1} mm free on either side")
        };
        write!(
            formatter,
            "no grasp fits: two pads that hold it are at least {narrowest} mm apart, as sampled, and the hand {hand}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reason as in a plan file.
    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(rename_all = "kebab-case", tag = "reason")]
    enum Reason {
        TooWide(TooWide),
    }

    #[test]
    fn an_unknown_key_is_refused_by_name() {
        let read = |rest: &str| {
            let text = format!(r#"{{"reason": "too-wide", "narrowest_m": 0.2, "opening_m": 0.08{rest}}}"#);
            cranny_file::json::<Reason>(text.as_bytes())
        };
        assert_eq!(
            read(""),
            Ok(Reason::TooWide(TooWide { narrowest_m: 0.2, opening_m: 0.08, clearance_m: 0.0 }))
        );
        let fault = read(r#", "openning_m": 1"#).unwrap_err().to_string();
        assert!(fault.contains("openning_m"), "{fault}");
    }
}
