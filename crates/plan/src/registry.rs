use crate::{Criterion, IkRrt, JPlusRrt, PlanError, Planner, Reach};

/// Every planner, with its default settings, in the order in which lists show them.
fn all() -> Vec<Box<dyn Planner>> {
    vec![Box::new(Reach::default()), Box::new(IkRrt::default()), Box::new(JPlusRrt::default())]
}

/// The planner of that name, with its default settings.
///
/// # Errors
/// [`PlanError::UnknownPlanner`], which lists the names that there are.
pub fn planner(name: &str) -> Result<Box<dyn Planner>, PlanError> {
    all()
        .into_iter()
        .find(|planner| planner.name() == name)
        .ok_or_else(|| PlanError::UnknownPlanner { name: name.to_owned(), known: planner_names().join(", ") })
}

/// The names of all planners.
pub fn planner_names() -> Vec<&'static str> {
    all().iter().map(|planner| planner.name()).collect()
}

/// The planner to take where none is named: the flagship, or under `paper`, which it does not take, the
/// better of the paper's two.
pub fn default_planner(criterion: Criterion) -> Box<dyn Planner> {
    match criterion {
        Criterion::Exact => Box::new(Reach::default()),
        Criterion::Paper => Box::new(IkRrt::default()),
    }
}
