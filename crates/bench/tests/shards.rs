//! Shards of a campaign: together they are the whole, and each detects a campaign that differs from the manifest.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use cranny_bench::{
    BenchError, Campaign, CampaignPlanner, Manifest, PlannerCall, Results, RunInformation, Schedule, Shard,
    Trial, TrialOutcome, TrialRecord,
};
use cranny_plan::{Registry, Statistics};

fn campaign(scenarios: &[&str], runs: u64) -> Campaign {
    let planner =
        |name: &str| CampaignPlanner::new(PlannerCall::parse(name, &Registry::default()).expect("a planner"));
    Campaign {
        scenarios: scenarios.iter().map(|id| (*id).to_owned()).collect(),
        planners: vec![planner("reach"), planner("ik-rrt")],
        runs,
        ..Campaign::default()
    }
}

fn schedule(campaign: &Campaign) -> Schedule {
    campaign.schedule(&Registry::default()).expect("a schedule")
}

fn keys(schedule: &Schedule) -> Vec<String> {
    schedule.questions.iter().map(|question| question.trial.key()).collect()
}

/// Returns the maximum difference between the numbers of trials of a kind in two shards, over all kinds.
fn spread<K: Ord>(parts: &[Schedule], kind: impl Fn(&Trial) -> K) -> usize {
    let mut counts: BTreeMap<K, Vec<usize>> = BTreeMap::new();
    for (index, part) in parts.iter().enumerate() {
        for question in &part.questions {
            counts.entry(kind(&question.trial)).or_insert_with(|| vec![0; parts.len()])[index] += 1;
        }
    }
    let spread = |counts: &Vec<usize>| counts.iter().max().unwrap_or(&0) - counts.iter().min().unwrap_or(&0);
    counts.values().map(spread).max().unwrap_or(0)
}

/// Creates a schedule of planners with different numbers of runs, without opening a scenario.
fn drawn_up(scenarios: usize, planner_runs: &[u64]) -> Schedule {
    let template = &schedule(&campaign(&["021"], 1)).questions[0];
    let mut questions = Vec::new();
    for seed in 0..planner_runs.iter().copied().max().unwrap_or(0) {
        for scenario in 0..scenarios {
            for (planner, runs) in planner_runs.iter().enumerate().filter(|(_, runs)| seed < **runs) {
                let mut question = template.clone();
                question.trial.scenario = format!("s{scenario}");
                question.trial.planner = format!("p{planner} of {runs}");
                question.trial.seed = seed;
                questions.push(question);
            }
        }
    }
    Schedule { questions, scenarios: Vec::new(), notes: Vec::new() }
}

#[test]
fn the_parts_of_a_campaign_are_the_whole_each_trial_in_one_of_them() {
    let wholes = [
        schedule(&campaign(&["01x"], 7)),
        drawn_up(1, &[8]),
        drawn_up(2, &[2]),
        drawn_up(1, &[8, 8]),
        drawn_up(3, &[4, 1, 9]),
        drawn_up(35, &[1, 1, 1]),
        drawn_up(8, &[1, 1]),
    ];
    for whole in wholes {
        for count in [1, 2, 3, 4, 5, 7, 8, 10, 14, 70, 1000] {
            let part = |index| Shard::new(index, count).expect("a part").of(whole.clone());
            let parts: Vec<Schedule> = (1..=count).map(part).collect();
            let size = whole.questions.len();
            assert!(spread(&parts, |_| ()) <= 1, "{count} parts of {size}");
            assert!(spread(&parts, |trial| trial.planner.clone()) <= 1, "{count} parts of {size}");
            let of_cell = |trial: &Trial| (trial.planner.clone(), trial.scenario.clone());
            assert!(spread(&parts, of_cell) <= 1, "{count} parts of {size}");
            assert!(spread(&parts, |trial| trial.scenario.clone()) <= 2, "{count} parts of {size}");
            assert!(parts.iter().all(|part| part.questions.is_sorted_by_key(|q| q.trial.seed)));
            let mut all: Vec<String> = parts.iter().flat_map(keys).collect();
            all.sort();
            let mut wanted = keys(&whole);
            wanted.sort();
            assert_eq!(all, wanted, "{count}");
        }
    }
    assert!(Shard::new(0, 3).is_none() && Shard::new(4, 3).is_none() && Shard::new(1, 0).is_none());
}

#[test]
fn a_part_has_every_scenario_and_every_planner() {
    for (scenarios, runs, count) in [("01x", 20, 10), ("01x", 2, 5), ("01x", 1, 2)] {
        let part = Shard::new(1, count).expect("a part").of(schedule(&campaign(&[scenarios], runs)));
        let of =
            |kind: fn(&Trial) -> &str| part.questions.iter().map(|q| kind(&q.trial)).collect::<BTreeSet<_>>();
        let (of_scenario, of_planner) = (of(|trial| &trial.scenario), of(|trial| &trial.planner));
        let wanted = part.questions.len().min(5);
        assert_eq!(
            (of_scenario.len() >= wanted - 1, of_planner.len()),
            (true, 2),
            "{count} parts: {of_scenario:?}"
        );
    }
}

/// Results of one shard would get trials of another, which would run twice.
#[test]
fn results_of_another_part_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = drawn_up(2, &[4, 4]);
    let shard = |index, count| Shard::new(index, count).expect("a part");
    let mut results = Results::create(&folder.path().join("part.db")).expect("results");
    let information = RunInformation::here(None, "cranny bench run", 1);
    let run = results.begin_run(&information).expect("a run");
    for question in &shard(1, 2).of(whole.clone()).questions {
        let record = TrialRecord {
            trial: question.trial.clone(),
            outcome: TrialOutcome::GaveUp,
            detail: None,
            statistics: Statistics::default(),
            path_length: None,
            clearance_m: None,
            grasp: None,
            grasp_score: None,
            also_solved: None,
            memory_bytes: None,
        };
        results.replace(run, &record, &[]).expect("stored");
    }
    assert!(shard(1, 2).check(&whole, &results).is_ok() && shard(1, 1).check(&whole, &results).is_ok());
    for (other, wanted) in [(shard(2, 2), 8), (shard(1, 3), 5)] {
        match other.check(&whole, &results) {
            Err(BenchError::OtherShard { part, trials, .. }) => {
                assert_eq!(part, other.to_string());
                assert!(trials <= wanted && trials > 0, "{trials}");
            }
            found => panic!("{other}: {found:?}"),
        }
    }
}

#[test]
fn a_part_of_another_campaign_is_refused_with_what_is_another() {
    let program = Path::new("/bin/sh");
    let handed_out = campaign(&["011", "012"], 2);
    let manifest = Manifest::of(&schedule(&handed_out), program);
    assert!(Manifest::of(&schedule(&handed_out), program).check(&manifest).is_ok());
    let other_planner = CampaignPlanner {
        name: "reach".to_owned(),
        ..CampaignPlanner::new(PlannerCall::parse("j-plus-rrt", &Registry::default()).expect("a planner"))
    };
    let [_, ik_rrt] = &handed_out.planners[..] else { panic!("two planners") };
    let cases = [
        (campaign(&["011", "013"], 2), "/bin/sh", "the scenario 012"),
        (campaign(&["011", "012"], 3), "/bin/sh", "the list of trials"),
        (Campaign { time_limit_s: 1.0, ..handed_out.clone() }, "/bin/sh", "the list of trials"),
        (
            Campaign { planners: vec![other_planner, ik_rrt.clone()], ..handed_out.clone() },
            "/bin/sh",
            "the planner reach",
        ),
        (handed_out.clone(), "/bin/ls", "the program"),
    ];
    for (other, program, what) in cases {
        let found = Manifest::of(&schedule(&other), Path::new(program)).check(&manifest);
        match found {
            Err(BenchError::OtherCampaign { what: named }) => assert!(named.contains(what), "{named}"),
            found => panic!("{what}: {found:?}"),
        }
    }
}
