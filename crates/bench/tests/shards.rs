//! Parts of a campaign: together they are the whole, and each notices when it is given another campaign.

use std::collections::BTreeSet;
use std::path::Path;

use cranny_bench::{BenchError, Campaign, CampaignPlanner, Manifest, PlannerCall, Schedule, Shard};
use cranny_plan::Registry;

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

#[test]
fn the_parts_of_a_campaign_are_the_whole_each_trial_in_one_of_them() {
    let whole = schedule(&campaign(&["01x"], 7));
    for count in [1, 2, 3, 5, 10, 14, 70, 1000] {
        let parts = (1..=count).map(|index| Shard::new(index, count).expect("a part").of(whole.clone()));
        let parts: Vec<Vec<String>> = parts.map(|part| keys(&part)).collect();
        let (fewest, most) = (parts.iter().map(Vec::len).min(), parts.iter().map(Vec::len).max());
        assert!(most.unwrap_or(0) - fewest.unwrap_or(0) <= 7, "{count}: {fewest:?} to {most:?}");
        let mut all: Vec<String> = parts.concat();
        all.sort();
        let mut wanted = keys(&whole);
        wanted.sort();
        assert_eq!(all, wanted, "{count}");
    }
    assert!(Shard::new(0, 3).is_none() && Shard::new(4, 3).is_none() && Shard::new(1, 0).is_none());
}

/// Ten cells in ten parts: without a turn each seed, a part would have nothing but the hardest scenario.
#[test]
fn a_part_has_every_scenario_and_every_planner() {
    let whole = schedule(&campaign(&["01x"], 20));
    let part = Shard::new(3, 10).expect("a part").of(whole);
    let cells: BTreeSet<(&str, &str)> =
        part.questions.iter().map(|q| (q.trial.scenario.as_str(), q.trial.planner.as_str())).collect();
    assert_eq!((part.questions.len(), cells.len()), (20, 10));
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
