use serde::ser::SerializeStruct as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Outcome of perturbed physics trials of a grasp; the robust score is the share of trials in which the grasp held.
///
/// Serialized with the keys `trials`, `held` and `score`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RobustScore {
    /// Number of trials, at least 1.
    pub trials: usize,
    /// Number of trials in which the grasp held, at most `trials`.
    pub held: usize,
}

impl RobustScore {
    /// Share of the trials in which the grasp held, in [0, 1].
    pub fn score(&self) -> f64 {
        self.held as f64 / self.trials.max(1) as f64
    }

    /// Restores the counts from a share of trials: `of_share(r.score(), r.trials) = r`. `None` for a share outside [0, 1], a
    /// number of trials that is not whole, or a share that no count equals to two decimals.
    pub fn of_share(score: f64, trials: f64) -> Option<Self> {
        if !(0.0..=1.0).contains(&score) || !(1.0..=MOST_TRIALS).contains(&trials) || trials.fract() != 0.0 {
            return None;
        }
        let held = (score * trials).round();
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "both are whole, not negative and at most `MOST_TRIALS`"
        )]
        let found = Self { trials: trials as usize, held: held as usize };
        ((found.score() - score).abs() <= TWO_DECIMALS).then_some(found)
    }

    /// Returns true if the counts are consistent.
    pub(crate) fn is_sound(&self) -> bool {
        self.trials > 0 && self.held <= self.trials
    }
}

/// Maximum number of trials, so that a float represents each count exactly.
const MOST_TRIALS: f64 = 1e9;

/// Maximum error of a score that a person rounded to two decimals.
const TWO_DECIMALS: f64 = 0.005 + 1e-9;

/// Maximum difference between a written score and its counts: rounding of the last decimal.
const SCORE_ROUNDING: f64 = 1e-9;

impl Serialize for RobustScore {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("RobustScore", 3)?;
        fields.serialize_field("trials", &self.trials)?;
        fields.serialize_field("held", &self.held)?;
        fields.serialize_field("score", &self.score())?;
        fields.end()
    }
}

impl<'de> Deserialize<'de> for RobustScore {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        /// Counts, with an optional score that follows from them and must not contradict them.
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Counts {
            trials: usize,
            held: usize,
            #[serde(default)]
            score: Option<f64>,
        }
        let Counts { trials, held, score } = Counts::deserialize(deserializer)?;
        let robust = Self { trials, held };
        let fault = |problem: String| Err(serde::de::Error::custom(problem));
        match score {
            _ if !robust.is_sound() => fault(format!("{held} of {trials} trials is no robust score")),
            Some(score) if (score - robust.score()).abs() > SCORE_ROUNDING => {
                fault(format!("the robust score is {score}, but {held} of {trials} trials held"))
            }
            _ => Ok(robust),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_of_trials_is_the_score_that_it_came_from() {
        for (trials, held) in [(1, 0), (1, 1), (3, 1), (32, 31), (10_000, 3333)] {
            let score = RobustScore { trials, held };
            assert_eq!(RobustScore::of_share(score.score(), trials as f64), Some(score));
        }
        assert_eq!(RobustScore::of_share(0.97, 32.0), Some(RobustScore { trials: 32, held: 31 }));
    }

    #[test]
    fn what_contradicts_the_counts_or_is_unknown_is_refused() {
        let read = |text: &str| cranny_file::json::<RobustScore>(text.as_bytes());
        let robust = RobustScore { trials: 32, held: 8 };
        assert_eq!(read(r#"{"trials": 32, "held": 8, "score": 0.25}"#), Ok(robust));
        assert_eq!(read(r#"{"trials": 32, "held": 8}"#), Ok(robust));
        for (text, words) in [
            (r#"{"trials": 32, "held": 8, "score": 0.9}"#, "is 0.9, but 8 of 32 trials held"),
            (r#"{"trials": 32, "held": 33}"#, "33 of 32 trials"),
            (r#"{"trials": 32, "held": 8, "slipped": 3}"#, "slipped"),
        ] {
            let fault = read(text).unwrap_err().to_string();
            assert!(fault.contains(words), "{fault}");
        }
    }

    #[test]
    fn what_is_no_share_of_trials_is_none() {
        for (score, trials) in [
            (1.01, 32.0),
            (-0.1, 32.0),
            (f64::NAN, 32.0),
            (0.5, 0.0),
            (0.5, 2.5),
            (0.5, f64::INFINITY),
            (0.5, f64::NAN),
            (0.5, -2.0),
            (0.5, 3.0),
        ] {
            assert_eq!(RobustScore::of_share(score, trials), None, "{score} of {trials}");
        }
    }
}
