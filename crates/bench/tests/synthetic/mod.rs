//! Fictitious trials, drawn by a fixed rule: the same in every run of the tests.

use cranny_bench::report::{Summary, SummarySource};
use cranny_bench::{Run, RunInformation, ScenarioSource, StoredTrial, Trial, TrialOutcome, TrialRecord};
use cranny_plan::Statistics;
use cranny_task::Criterion;
use strum::VariantArray as _;

/// Results in the form that a campaign leaves.
pub struct Campaign {
    pub trials: Vec<StoredTrial>,
    pub runs: Vec<Run>,
    pub scenarios: Vec<ScenarioSource>,
}

impl Campaign {
    pub fn source(&self) -> SummarySource<'_> {
        SummarySource {
            results: "results.db",
            trials: &self.trials,
            runs: &self.runs,
            scenarios: &self.scenarios,
        }
    }

    pub fn summary(&self) -> Summary {
        Summary::of(&self.source()).expect("sound trials")
    }
}

/// Performance of a planner on a scenario.
pub struct Manner<'a> {
    pub planner: &'a str,
    pub criterion: Criterion,
    /// Mean of the exponential distribution of its times, in seconds.
    pub mean_s: f64,
    pub limit_s: f64,
    pub runs: u64,
    pub goal: Option<usize>,
}

/// Generator of numbers between 0 and 1 by splitmix64 (Steele, Lea & Flood 2014).
pub struct Draw(u64);

impl Draw {
    pub fn of_seed(seed: u64) -> Self {
        Self(seed)
    }

    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Adds the runs of a planner on a scenario.
pub fn add(campaign: &mut Campaign, draw: &mut Draw, scenario: &str, manner: &Manner) {
    for seed in 0..manner.runs {
        let time_s = -manner.mean_s * (1.0 - draw.next()).ln();
        let solved = time_s <= manner.limit_s;
        let planning_time_s = time_s.min(manner.limit_s);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count that is not negative and small"
        )]
        let iterations = 1 + (planning_time_s * 400.0 * (0.8 + 0.4 * draw.next())) as u64;
        let when_solved = |value: f64| solved.then_some(value);
        let (length, clearance_m, score) =
            (3.0 + 4.0 * draw.next(), 0.001 + 0.02 * draw.next(), 0.5 + 0.5 * draw.next());
        let record = TrialRecord {
            trial: Trial {
                scenario: scenario.to_owned(),
                scenario_hash: format!("{scenario:0>64}"),
                planner: manner.planner.to_owned(),
                settings: r#"{"goal_bias":0.1}"#.to_owned(),
                criterion: manner.criterion,
                seed,
                time_limit_s: manner.limit_s,
                iteration_limit: None,
                goal: manner.goal,
            },
            outcome: if solved { TrialOutcome::Solved } else { TrialOutcome::BudgetExhausted },
            detail: None,
            statistics: Statistics {
                iterations,
                nodes: iterations / 2 + 1,
                collision_checks: iterations * 3,
                planning_time_s,
                ..Statistics::default()
            },
            path_length: when_solved(length),
            clearance_m: when_solved(clearance_m).filter(|_| manner.criterion == Criterion::Exact),
            grasp: None,
            grasp_score: when_solved(score),
            also_solved: None,
            memory_bytes: Some(12_000_000 + 1000 * iterations),
        };
        let id = campaign.trials.len() as u64 + 1;
        campaign.trials.push(StoredTrial { id, run: 1, record });
    }
}

/// Creates results without a trial, and the generator for filling them.
pub fn empty() -> (Campaign, Draw) {
    let run = Run {
        id: 1,
        information: RunInformation {
            machine: "bench host".to_owned(),
            processor: "A processor; of some kind".to_owned(),
            cpu_features: vec!["avx2".to_owned()],
            cores: 8,
            version: "0.1.0".to_owned(),
            commit: Some("0123456789abcdef".to_owned()),
            command: "cranny bench run --preset paper -o results.db".to_owned(),
            workers: 1,
            memory_limit_bytes: Some(4 << 30),
            sandbox: None,
        },
        began: "2026-11-21T18:00:00Z".to_owned(),
        ended: None,
    };
    (Campaign { trials: Vec::new(), runs: vec![run], scenarios: Vec::new() }, Draw(2024))
}

/// Creates two environments of the paper under both criteria, a sweep, a planner that runs on single goals, and one trial
/// of each failed outcome.
pub fn campaign() -> Campaign {
    let (mut campaign, mut draw) = empty();
    let manner = |planner, criterion, mean_s, limit_s| Manner {
        planner,
        criterion,
        mean_s,
        limit_s,
        runs: 20,
        goal: None,
    };
    for (index, scenario) in ["021", "022", "023", "024", "025", "041", "042", "045"].into_iter().enumerate()
    {
        let hard = 1.0 + index as f64;
        let limit_s = if scenario == "045" { 90.0 } else { 30.0 };
        let exact = Criterion::Exact;
        add(&mut campaign, &mut draw, scenario, &manner("reach", exact, 0.004 * hard, limit_s));
        add(&mut campaign, &mut draw, scenario, &manner("j-plus-rrt", exact, 5.0 * hard * hard, limit_s));
        add(&mut campaign, &mut draw, scenario, &manner("exec:./my_planner", exact, 2.0 * hard, limit_s));
        add(&mut campaign, &mut draw, scenario, &manner("j-plus-rrt", Criterion::Paper, 3.0 * hard, limit_s));
        let goals = if scenario == "041" { 0 } else { index % 4 + 1 };
        for goal in 0..goals {
            // None of the goals of 024 can be reached.
            let mean_s = if scenario == "024" { 1e9 } else { 0.02 + 3.0 * goal as f64 };
            let manner =
                Manner { runs: 5, goal: Some(goal), ..manner("ik-rrt", Criterion::Paper, mean_s, 5.0) };
            add(&mut campaign, &mut draw, scenario, &manner);
        }
        campaign.scenarios.push(ScenarioSource {
            scenario: scenario.to_owned(),
            scenario_hash: format!("{scenario:0>64}"),
            source: scenario.to_owned(),
            goals: Some(goals),
        });
    }
    for step in 0..12_u32 {
        let gap_m = 0.64 - 0.03 * f64::from(step);
        let scenario = format!("gap-{gap_m:.4}");
        let exact = Criterion::Exact;
        add(
            &mut campaign,
            &mut draw,
            &scenario,
            &manner("reach", exact, 0.003 + 0.002 * f64::from(step), 10.0),
        );
        add(
            &mut campaign,
            &mut draw,
            &scenario,
            &manner("j-plus-rrt", exact, 1.0 + 2.0 * f64::from(step), 10.0),
        );
    }
    for (index, outcome) in
        TrialOutcome::VARIANTS.iter().copied().enumerate().filter(|(_, o)| *o != TrialOutcome::Solved)
    {
        let trial = &mut campaign.trials[40 + index];
        trial.record.outcome = outcome;
        trial.record.detail = Some(format!("what a <judge> & \"others\" say of {}", outcome.name()));
        (trial.record.path_length, trial.record.clearance_m, trial.record.grasp_score) = (None, None, None);
    }
    campaign
}
