use std::fmt::Write as _;
use std::path::PathBuf;

use cranny_collision::Margins;
use cranny_record::{Demanded, Judgement};
use cranny_scenario::{Geometry, GivenGrasps};
use cranny_solve::Tilt;
use serde::Serialize;

use crate::arguments::VerifyArguments;
use crate::planning::task::Demand;
use crate::text::{at_least_mm, degrees};

/// Files that a plan names instead of the scenario's own, on the authority of the plan alone. Flags override them.
#[derive(Default, Serialize)]
pub struct Brought {
    #[serde(skip_serializing_if = "Option::is_none")]
    robot: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    grasps: Option<PathBuf>,
    #[serde(skip_serializing_if = "Option::is_none")]
    geometry: Option<&'static str>,
}

impl Brought {
    pub fn of(demand: &Demand, arguments: &VerifyArguments) -> Self {
        if !arguments.moveit.is_empty() {
            return Self::default();
        }
        let task = &arguments.task;
        let grasps = match &demand.grasps {
            GivenGrasps::File(file) if task.grasps.is_none() => Some(file.clone()),
            _ => None,
        };
        Self {
            robot: demand.robot.clone().filter(|_| task.robot.is_none()),
            grasps,
            geometry: demand.geometry.filter(|_| task.geometry.is_none()).map(Geometry::name),
        }
    }

    pub fn lines(&self) -> String {
        let file = |file: &PathBuf| file.display().to_string();
        let named = [
            ("robot", self.robot.as_ref().map(file)),
            ("grasps", self.grasps.as_ref().map(file)),
            ("geometry", self.geometry.map(str::to_owned)),
        ];
        let named = named.into_iter().filter_map(|(what, name)| Some((what, name?)));
        let mut lines = String::new();
        for (what, name) in named {
            let _ = writeln!(lines, "  {what:<12}{name}, from the plan file");
        }
        lines
    }
}

/// Formats the required margins, each with its name.
pub fn demanded_margins(margins: &Margins) -> Vec<String> {
    let Margins { margin_m, grasp_margin_m, object_margin_m, tilt_rad } = *margins;
    let margins =
        [("margin", margin_m), ("grasp margin", grasp_margin_m), ("object margin", object_margin_m)];
    let margins = margins.into_iter().filter(|(_, margin_m)| *margin_m > 0.0);
    let margins = margins.map(|(name, margin_m)| format!("{name} {}", at_least_mm(margin_m)));
    let tilt = tilt_rad.map(|tilt_rad| format!("upright within {}", degrees(tilt_rad)));
    margins.chain(tilt).collect()
}

/// Returns the lines on everything in a plan file other than its path.
pub fn statement_lines(judgement: &Judgement) -> String {
    let Judgement { demanded: Demanded { margins, task, hold }, measured, .. } = judgement;
    // An object that the scenario marks as upright may demand less tilt than the plan.
    let least = |tilt: &Tilt| margins.tilt_rad.map_or(tilt.most_rad, |most| most.min(tilt.most_rad));
    let margins = Margins { tilt_rad: measured.tilt.as_ref().map(least).or(margins.tilt_rad), ..*margins };
    let stages = task.iter().map(ToString::to_string);
    let hold = hold.map(|factor| format!("a hold by a factor of {factor}"));
    let demanded: Vec<String> = demanded_margins(&margins).into_iter().chain(stages).chain(hold).collect();
    let mut lines = String::new();
    for statement in &judgement.differs {
        let _ = writeln!(lines, "  differs     {statement}");
    }
    let as_stated = judgement.as_stated();
    for (name, values) in [
        ("demanded", demanded.join(", ")),
        ("as stated", as_stated.join(", ")),
        ("unjudged", judgement.not_compared.join(", ")),
    ] {
        if !values.is_empty() {
            let _ = writeln!(lines, "  {name:<12}{values}");
        }
    }
    lines
}
