use std::collections::{BTreeMap, HashSet};

use cranny_file::did_you_mean;
use cranny_spatial::Pose;
use cranny_task::{AfterPlacing, Move, Pick, PlaceAt, Stage};
use serde_saphyr::Spanned;

use crate::layout::own::Layout;
use crate::layout::own_file::{ScenarioFile, StepEntry, TaskEntry};
use crate::named_task::STEPS;
use crate::{NamedTask, ScenarioError, TargetPhysics};

/// Names that others refer to.
struct KnownNames<'a> {
    in_order: Vec<&'a str>,
    set: HashSet<&'a str>,
}

impl<'a> KnownNames<'a> {
    fn of(names: impl Iterator<Item = &'a String>) -> Self {
        let in_order: Vec<&str> = names.map(String::as_str).collect();
        Self { set: in_order.iter().copied().collect(), in_order }
    }
}

impl Layout<'_> {
    /// Returns the tasks of a file, among them the one that its `steps` form.
    pub fn tasks(
        &self,
        file: &ScenarioFile,
        planning_from_scene: &Pose,
    ) -> Result<Vec<NamedTask>, ScenarioError> {
        let bodies = KnownNames::of(file.obstacles.iter().chain(&file.target).map(|body| &body.name.value));
        let places = KnownNames::of(file.places.iter().map(|place| &place.value.name.value));
        let names = [bodies, places, KnownNames::of(file.regions.keys())];
        let mut tasks = Vec::new();
        let mut stages = Vec::new();
        for Spanned { value: StepEntry { pick, place, then, .. }, referenced, .. } in &file.steps {
            let of_step =
                [Stage::Pick(Pick { object: Some(pick.clone()), ..Pick::default() }), Stage::place(place)];
            for stage in &of_step {
                self.check_stage(stage, *referenced, &names)?;
            }
            stages.extend(of_step.into_iter().chain((*then == AfterPlacing::Home).then(Stage::home)));
        }
        if !stages.is_empty() {
            tasks.push(NamedTask { name: STEPS.to_owned(), stages });
        }
        let mut taken: HashSet<String> = tasks.iter().map(|task| task.name.clone()).collect();
        for TaskEntry { name, stages } in &file.tasks {
            let refuse = |problem| Err(ScenarioError::Place { at: self.at(name.referenced), problem });
            if !taken.insert(name.value.clone()) {
                return refuse(format!("there is a task '{}' already", name.value));
            }
            if stages.is_empty() {
                return refuse(format!("task '{}' has no stages", name.value));
            }
            for Spanned { value, referenced, .. } in stages {
                self.check_stage(value, *referenced, &names)?;
            }
            let stages = stages.iter().map(|stage| stage.value.in_frame(planning_from_scene)).collect();
            tasks.push(NamedTask { name: name.value.clone(), stages });
        }
        Ok(tasks)
    }

    /// Checks that the names in a stage exist.
    fn check_stage(
        &self,
        stage: &Stage,
        at: serde_saphyr::Location,
        [bodies, places, regions]: &[KnownNames<'_>; 3],
    ) -> Result<(), ScenarioError> {
        let (what, name, known) = match stage {
            Stage::Pick(Pick { object: Some(object), .. }) => ("body", object, bodies),
            Stage::Place(PlaceAt { place, .. }) => ("place", place, places),
            Stage::Move(Move::NamedRegions(names)) => {
                let is_unknown = |name: &&String| !regions.set.contains(name.as_str());
                let Some(name) = names.iter().find(is_unknown) else { return Ok(()) };
                ("region", name, regions)
            }
            Stage::Pick(_) | Stage::Move(_) => return Ok(()),
        };
        if known.set.contains(name.as_str()) {
            return Ok(());
        }
        let meant = did_you_mean(name, known.in_order.iter().copied());
        let known = known.in_order.join(", ");
        let problem = format!("unknown {what} '{name}' in this step (known: {known}){meant}");
        Err(ScenarioError::Place { at: self.at(at), problem })
    }

    /// Returns mass and friction of bodies other than the target, as the entries of obstacles and `steps` state them.
    pub fn physics_of_obstacles(
        &self,
        file: &ScenarioFile,
    ) -> Result<BTreeMap<String, TargetPhysics>, ScenarioError> {
        let mut all = BTreeMap::new();
        for body in &file.obstacles {
            all.insert(body.name.value.clone(), self.physics_of(body)?);
        }
        for Spanned { value: StepEntry { pick, mass_kg, friction, .. }, referenced, .. } in &file.steps {
            let physics = self.physics(mass_kg.as_ref(), friction.as_ref())?;
            let is_target = file.target.as_ref().is_some_and(|target| target.name.value == *pick);
            if is_target && physics != TargetPhysics::default() {
                let problem = format!("mass_kg and friction of the target '{pick}' belong under `target`");
                return Err(ScenarioError::Place { at: self.at(*referenced), problem });
            }
            let known = all.entry(pick.clone()).or_default();
            *known = physics.or(*known);
        }
        all.retain(|_, physics| *physics != TargetPhysics::default());
        Ok(all)
    }
}
