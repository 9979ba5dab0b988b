use crate::PlanError;

/// Range checks of the settings of a planner, one after the other ([`Planner::check`](crate::Planner::check)).
///
/// ```
/// # use cranny_plan::{PlanError, Ranges};
/// # fn checked() -> Result<(), PlanError> {
/// let (p_goal, step_m, goals) = (0.1, 0.05, 40);
/// Ranges::of("my-planner").share("p_goal", p_goal)?.positive("step_m", step_m)?.count("goals", goals, usize::MAX)?;
/// # Ok(())
/// # }
/// # assert!(checked().is_ok());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Ranges {
    planner: &'static str,
}

impl Ranges {
    /// Creates checks for the planner of this name.
    pub fn of(planner: &'static str) -> Self {
        Self { planner }
    }

    /// Checks for a finite number above 0.
    ///
    /// # Errors
    /// [`PlanError::Setting`] for any other value.
    pub fn positive(self, setting: &str, value: f64) -> Result<Self, PlanError> {
        self.when(value > 0.0 && value.is_finite(), || format!("'{setting}' is {value}, but must be above 0"))
    }

    /// Checks for a probability, a score or a share: in [0, 1].
    ///
    /// # Errors
    /// [`PlanError::Setting`] for any other value.
    pub fn share(self, setting: &str, value: f64) -> Result<Self, PlanError> {
        self.when((0.0..=1.0).contains(&value), || format!("'{setting}' is {value}, but must be in [0, 1]"))
    }

    /// Checks for a count from 1 to `most`.
    ///
    /// # Errors
    /// [`PlanError::Setting`] for any other value.
    pub fn count(self, setting: &str, value: usize, most: usize) -> Result<Self, PlanError> {
        self.when((1..=most).contains(&value), || {
            let at_most = if most == usize::MAX { String::new() } else { format!(" and at most {most}") };
            format!("'{setting}' is {value}, but must be above 0{at_most}")
        })
    }

    /// Checks for a count from `least` to `most`.
    ///
    /// # Errors
    /// [`PlanError::Setting`] for any other value.
    pub fn count_between(
        self,
        setting: &str,
        value: usize,
        [least, most]: [usize; 2],
    ) -> Result<Self, PlanError> {
        self.when((least..=most).contains(&value), || {
            format!("'{setting}' is {value}, but must be from {least} to {most}")
        })
    }

    /// Checks that all way points of a path (m, rad; one value per joint) have finite values, as many as the first; there may be none.
    ///
    /// # Errors
    /// [`PlanError::Setting`] for others.
    pub fn way_points(self, setting: &str, path: &[Vec<f64>]) -> Result<Self, PlanError> {
        let dof = path.first().map_or(0, Vec::len);
        let bad = path.iter().position(|q| q.len() != dof || !q.iter().all(|value| value.is_finite()));
        self.when(bad.is_none(), || {
            let at = bad.unwrap_or(0);
            format!("way point {at} of '{setting}' must have finite values, as many as there are joints")
        })
    }

    fn when(self, is_good: bool, problem: impl FnOnce() -> String) -> Result<Self, PlanError> {
        if is_good {
            return Ok(self);
        }
        Err(PlanError::Setting { planner: self.planner.to_owned(), problem: problem() })
    }
}
