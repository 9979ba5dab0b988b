use std::str::FromStr;

use cranny_scenario::StatedSpeed;
use cranny_solve::Paces;
use cranny_task::{Mode, SpeedLimits};

use crate::RecordError;

/// A number for all motions, or `MODE=NUMBER` for those of a mode (`carry=0.2`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedOption {
    /// Mode; `None`: all.
    pub mode: Option<Mode>,
    /// Share of the limits, or speed in m/s or °/s.
    pub value: f64,
}

impl FromStr for SpeedOption {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let (mode, number) = match word.split_once('=') {
            Some((mode, number)) => (Some(Mode::of_name(mode.trim())?), number),
            None => (None, word),
        };
        let value = number.trim().parse().map_err(|_| format!("'{number}' is not a number"))?;
        Ok(Self { mode, value })
    }
}

/// Speeds in the words of users; words for a mode override those for all, and no limit is given twice.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpeedOptions {
    /// Shares of the limits of velocity.
    pub speed: Vec<SpeedOption>,
    /// Shares of the limits of acceleration.
    pub acceleration: Vec<SpeedOption>,
    /// Greatest speeds of the gripper frame, in m/s.
    pub tool_speed: Vec<SpeedOption>,
    /// Greatest angular speeds of the hand, in °/s.
    pub turn_speed: Vec<SpeedOption>,
}

/// Function that sets one limit of a pace.
type SetLimit = fn(&mut SpeedLimits, f64);

impl SpeedOptions {
    /// Returns the words of a scenario followed by these. A word for all motions also limits what the scenario states for a mode.
    pub(crate) fn after(&self, stated: &[StatedSpeed]) -> Self {
        let words = |of: fn(&StatedSpeed) -> Option<f64>, own: &[SpeedOption]| {
            let most =
                own.iter().rev().find(|word| word.mode.is_none()).map_or(f64::INFINITY, |word| word.value);
            let word =
                |speed: &StatedSpeed| Some(SpeedOption { mode: speed.mode, value: of(speed)?.min(most) });
            stated.iter().filter_map(word).chain(own.iter().copied()).collect()
        };
        Self {
            speed: words(|speed| speed.velocity, &self.speed),
            acceleration: words(|speed| speed.acceleration, &self.acceleration),
            tool_speed: words(|speed| speed.tool_m_s, &self.tool_speed),
            turn_speed: words(|speed| speed.turn_deg_s, &self.turn_speed),
        }
    }

    /// Modes that these words name, each with the field that names it.
    pub(crate) fn modes(&self) -> impl Iterator<Item = (&'static str, Mode)> {
        self.fields()
            .into_iter()
            .flat_map(|(field, words)| words.iter().filter_map(move |word| Some((field, word.mode?))))
    }

    /// Returns the field and the mode (`None`: all motions) of the first limit that these words give twice.
    pub(crate) fn twice(&self) -> Option<(&'static str, Option<Mode>)> {
        let of_field = |(field, words): (&'static str, &Vec<SpeedOption>)| {
            let is_repeated = |(index, word): (usize, &SpeedOption)| {
                words[..index].iter().any(|earlier| earlier.mode == word.mode).then_some((field, word.mode))
            };
            words.iter().enumerate().find_map(is_repeated)
        };
        self.fields().into_iter().find_map(of_field)
    }

    fn fields(&self) -> [(&'static str, &Vec<SpeedOption>); 4] {
        [
            ("speed", &self.speed),
            ("acceleration", &self.acceleration),
            ("tool_speed", &self.tool_speed),
            ("turn_speed", &self.turn_speed),
        ]
    }

    /// Returns the requested paces; `tool_m_s` is the greatest speed of the gripper frame, in m/s, if the words state none for
    /// all motions.
    ///
    /// # Errors
    /// [`RecordError::PlanOptions`] for an invalid number.
    pub(crate) fn paces(&self, tool_m_s: Option<f64>) -> Result<Paces, RecordError> {
        let kinds: [(&'static str, &[SpeedOption], SetLimit); 4] = [
            ("speed", &self.speed, |pace, share| pace.velocity = share),
            ("acceleration", &self.acceleration, |pace, share| pace.acceleration = share),
            ("tool_speed", &self.tool_speed, |pace, speed| pace.tool_m_s = Some(speed)),
            ("turn_speed", &self.turn_speed, |pace, speed| pace.turn_rad_s = Some(speed.to_radians())),
        ];
        let mut all = SpeedLimits { tool_m_s, ..SpeedLimits::default() };
        for (field, words, set) in kinds {
            for SpeedOption { mode, value } in words {
                let mut alone = SpeedLimits::default();
                set(&mut alone, *value);
                if let Some((_, _, values)) = alone.fault() {
                    let problem = format!("'{value}' is not a valid limit: expected a number {values}");
                    return Err(RecordError::PlanOptions { field, problem });
                }
                if mode.is_none() {
                    set(&mut all, *value);
                }
            }
        }
        let mut paces = Paces::new(all);
        for (_, words, set) in kinds {
            for SpeedOption { mode, value } in words {
                if let Some(mode) = mode {
                    let mut pace = paces.of(*mode);
                    set(&mut pace, *value);
                    paces.of_modes.push((*mode, pace));
                }
            }
        }
        Ok(paces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(speed: &[&str], tool_speed: &[&str]) -> SpeedOptions {
        let parsed = |words: &[&str]| words.iter().map(|word| word.parse().unwrap()).collect();
        SpeedOptions { speed: parsed(speed), tool_speed: parsed(tool_speed), ..SpeedOptions::default() }
    }

    #[test]
    fn words_for_a_mode_go_before_those_for_all() {
        let paces = words(&["carry=0.2", "0.5"], &["0.3"]).paces(None).unwrap();
        let carry = SpeedLimits { velocity: 0.2, tool_m_s: Some(0.3), ..SpeedLimits::default() };
        assert_eq!(paces.of(Mode::CARRY), carry);
        assert_eq!(paces.of(Mode::REACH), SpeedLimits { velocity: 0.5, ..carry });
        let set_down = SpeedLimits {
            velocity: 0.5,
            tool_m_s: Some(cranny_solve::SET_DOWN_M_S),
            ..SpeedLimits::default()
        };
        assert_eq!(paces.of(Mode::SET_DOWN), set_down);
        let faster = words(&[], &["set-down=0.4"]).paces(None).unwrap();
        assert_eq!(faster.of(Mode::SET_DOWN).tool_m_s, Some(0.4));
    }

    #[test]
    fn what_is_asked_goes_before_what_a_scenario_states() {
        let stated = [(None, 0.3), (Some(Mode::CARRY), 0.1)].map(|(mode, speed)| StatedSpeed {
            mode,
            velocity: Some(speed),
            acceleration: None,
            tool_m_s: Some(2.0 * speed),
            turn_deg_s: None,
        });
        let paces = words(&["0.5"], &["carry=0.25"]).after(&stated).paces(None).unwrap();
        let reach = SpeedLimits { velocity: 0.5, tool_m_s: Some(0.6), ..SpeedLimits::default() };
        assert_eq!(paces.of(Mode::REACH), reach);
        assert_eq!(
            paces.of(Mode::CARRY),
            SpeedLimits { velocity: 0.1, tool_m_s: Some(0.25), ..SpeedLimits::default() }
        );
    }

    #[test]
    fn a_word_for_all_limits_what_a_scenario_states_for_a_mode() {
        let stated = StatedSpeed {
            mode: Some(Mode::CARRY),
            velocity: Some(0.9),
            acceleration: None,
            tool_m_s: Some(0.25),
            turn_deg_s: None,
        };
        let paces = words(&["0.1"], &["0.05"]).after(&[stated]).paces(None).unwrap();
        let slow = SpeedLimits { velocity: 0.1, tool_m_s: Some(0.05), ..SpeedLimits::default() };
        assert_eq!(paces.of(Mode::CARRY), slow);
    }

    #[test]
    fn what_is_no_limit_is_refused_by_its_word() {
        for value in ["0", "1.5", "nan", "carry=-1"] {
            let fault = words(&[value], &[]).paces(None).unwrap_err().to_string();
            assert!(fault.starts_with("speed: ") && fault.contains("above 0 and at most 1"), "{fault}");
        }
        assert!(words(&[], &["inf"]).paces(None).unwrap_err().to_string().starts_with("tool_speed: "));
        assert!("fly=1".parse::<SpeedOption>().unwrap_err().contains("reach, approach, lift-off"));
        assert!("carry=fast".parse::<SpeedOption>().unwrap_err().contains("'fast' is not a number"));
    }
}
