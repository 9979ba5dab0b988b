//! Campaign files: their content, and every mistake with its line.

use std::fs;
use std::path::Path;

use cranny_bench::{BenchError, Campaign, CampaignPlanner, Exception, PlannerCall};
use cranny_grasp::ScoreKind;
use cranny_plan::Registry;
use cranny_task::Criterion;

fn read(folder: &Path, text: &str) -> Result<Campaign, BenchError> {
    let path = folder.join("campaign.yaml");
    fs::write(&path, text).expect("written");
    Campaign::read(&path, &Registry::default())
}

const WHOLE: &str = "\
scenarios: [01x, '045', all]
planners:
  - planner: reach
  - name: ik-rrt-each
    planner: ik-rrt
    settings: {p_goal: 0.05}
    each_goal: true
    runs: 5
    time_limit_s: 5
  - exec: [sh, planner.sh, '{seed}']
criteria: [exact, paper]
runs: 20
first_seed: 100
time_limit_s: 30.5
iteration_limit: 100000
memory_limit_mb: 512
judge_both: true
exceptions:
  - {scenario: '045', planner: reach, time_limit_s: 900}
";

#[test]
fn a_campaign_file_says_everything_that_a_campaign_has() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("planner.sh"), "exit 0\n").expect("written");
    let campaign = read(folder.path(), WHOLE).expect("a campaign");
    assert_eq!(campaign.scenarios, ["01x", "045", "all"]);
    let [reach, each, exec] = &campaign.planners[..] else { panic!("{:?}", campaign.planners) };
    assert_eq!(
        *reach,
        CampaignPlanner::new(PlannerCall::parse("reach", &Registry::default()).expect("a planner"))
    );
    assert_eq!(
        (each.name.as_str(), each.each_goal, each.runs, each.time_limit_s),
        ("ik-rrt-each", true, Some(5), Some(5.0))
    );
    assert!(each.call.settings().contains("\"p_goal\":0.05"));
    assert_eq!(exec.name, "exec:planner.sh");
    assert_eq!(campaign.criteria, [Criterion::Exact, Criterion::Paper]);
    assert_eq!((campaign.runs, campaign.first_seed, campaign.iteration_limit), (20, 100, Some(100_000)));
    assert_eq!((campaign.memory_limit_bytes, campaign.judge_both), (512_000_000, true));
    let exception = Exception { scenario: "045".into(), planner: "reach".into(), time_limit_s: 900.0 };
    assert_eq!(campaign.exceptions, [exception]);
}

#[test]
fn the_score_that_counts_is_a_setting_of_a_built_in_planner() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("planner.sh"), "exit 0\n").expect("written");
    let campaign = |planner: &str| {
        read(folder.path(), &format!("scenarios: ['021']\nplanners: [{{{planner}}}]\nruns: 1\n"))
    };
    let settings = |planner: &str| campaign(planner).expect("a campaign").planners[0].call.settings();
    assert_eq!(settings("planner: reach"), settings("planner: reach, score: geometric"));
    assert!(settings("planner: reach, score: physics").contains("\"score\":\"physics\""));
    assert!(settings("planner: reach, min_score: 0.5").contains("\"min_score\":0.5"));
    for key in ["score: physics", "min_score: 0.5"] {
        let fault = campaign(&format!("exec: [sh, planner.sh], {key}")).expect_err("a fault").to_string();
        assert!(
            fault.contains("campaign.yaml:2: `score` and `min_score` apply to a built-in `planner`"),
            "{fault}"
        );
    }
    let fault = campaign("planner: reach, min_score: 1.5").expect_err("a fault").to_string();
    assert!(fault.contains("`min_score` is 1.5, but a score is from 0 to 1"), "{fault}");
    // The error precedes the first trial: the grasps of a built-in scenario have no robust scores.
    let schedule =
        campaign("planner: reach, score: physics").expect("a campaign").schedule(&Registry::default());
    let fault = schedule.expect_err("a fault").to_string();
    assert!(fault.contains("021") && fault.contains("grasp 0 has no robust score"), "{fault}");
}

#[test]
fn words_are_paths_from_the_folder_of_the_file_unless_they_are_ids() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["021", "mine"] {
        fs::create_dir(folder.path().join(name)).expect("a folder");
    }
    let text = "scenarios: ['021', mine, ./021]\nplanners: [{planner: reach}]\n";
    let campaign = read(folder.path(), text).expect("a campaign");
    let inside = |name: &str| folder.path().join(name).display().to_string();
    assert_eq!(campaign.scenarios, ["021".to_owned(), inside("mine"), inside("./021")]);
}

#[test]
fn a_schedule_has_every_trial_once_seed_by_seed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = "scenarios: ['021', '045']\nplanners: [{planner: reach}, {planner: ik-rrt, each_goal: true, runs: 2}]\n\
                criteria: [exact, exact]\nruns: 3\ntime_limit_s: 7\nexceptions: [{scenario: 04x, planner: reach, time_limit_s: 900}, \
                {scenario: '046', planner: reach, time_limit_s: 900}]\n";
    let schedule =
        read(folder.path(), text).expect("a campaign").schedule(&Registry::default()).expect("a schedule");
    let [note] = &schedule.notes[..] else { panic!("{:?}", schedule.notes) };
    assert!(note.contains("'046' matches no scenario of the campaign"), "{note}");
    let goals: Vec<usize> = schedule.scenarios.iter().map(|s| s.goals.expect("counted")).collect();
    assert!(goals.iter().all(|goals| *goals > 0), "{goals:?}");
    let all: usize = goals.iter().sum();
    assert_eq!(schedule.questions.len(), 3 * 2 + 2 * all);
    let keys: std::collections::HashSet<String> = schedule.questions.iter().map(|q| q.trial.key()).collect();
    assert_eq!(keys.len(), schedule.questions.len());
    assert!(schedule.questions.is_sorted_by_key(|question| question.trial.seed));
    for question in &schedule.questions {
        let is_long = question.trial.scenario == "045" && question.trial.planner == "reach";
        assert_eq!(question.trial.time_limit_s.to_bits(), if is_long { 900.0_f64 } else { 7.0 }.to_bits());
        assert_eq!(question.trial.goal.is_some(), question.trial.planner == "ik-rrt");
    }
}

#[test]
fn the_paper_s_campaign_is_the_paper_s() {
    let paper = Campaign::paper().expect("a campaign");
    assert_eq!((paper.runs, paper.criteria.as_slice()), (100, &[Criterion::Paper][..]));
    let schedule = Campaign { runs: 1, ..paper }.schedule(&Registry::default()).expect("a schedule");
    let j_plus: Vec<_> = schedule.questions.iter().filter(|q| q.trial.planner == "j-plus-rrt").collect();
    assert_eq!(j_plus.len(), 20);
    for question in j_plus {
        let limit_s: f64 = if question.trial.scenario == "045" { 900.0 } else { 120.0 };
        assert_eq!(question.trial.time_limit_s.to_bits(), limit_s.to_bits());
    }
    let goals: usize = schedule.scenarios.iter().map(|scenario| scenario.goals.unwrap_or(0)).sum();
    assert_eq!(schedule.questions.len(), 20 + goals);
}

#[test]
fn mistakes_are_named_with_file_and_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let cases = [
        ("an unknown key", WHOLE.replace("runs: 20", "repeats: 20"), 12, "repeats"),
        (
            "an unknown planner",
            WHOLE.replace("planner: reach\n  - name", "planner: reech\n  - name"),
            3,
            "reech",
        ),
        ("an unknown setting", WHOLE.replace("{p_goal: 0.05}", "{p_gaol: 0.05}"), 4, "p_gaol"),
        ("a setting out of range", WHOLE.replace("{p_goal: 0.05}", "{p_goal: 5}"), 4, "[0, 1]"),
        ("no planner at all", WHOLE.replace("    planner: ik-rrt\n", ""), 4, "one of `planner`"),
        ("an unknown criterion", WHOLE.replace("[exact, paper]", "[exact, papr]"), 11, "papr"),
        ("a word for a number", WHOLE.replace("runs: 20", "runs: many"), 12, "whole number"),
        ("a truncated file", WHOLE.replace("time_limit_s: 900}", ""), 19, ""),
        ("a missing program", WHOLE.replace("[sh, planner.sh", "[./no/planner.sh, x"), 10, "no/planner.sh"),
        ("an empty file", String::new(), 1, ""),
    ];
    fs::write(folder.path().join("planner.sh"), "exit 0\n").expect("written");
    for (what, text, line, word) in cases {
        let message = read(folder.path(), &text).expect_err(what).to_string();
        assert!(message.contains(word), "{what}: {message}");
        let place = message.split("campaign.yaml:").nth(1).unwrap_or_else(|| panic!("{what}: {message}"));
        let found: i64 = place.split(':').next().expect("a line").parse().expect("a number");
        assert!((found - line).abs() <= 1, "{what} in line {line}: {message}");
    }
    assert!(matches!(
        Campaign::read(&folder.path().join("none.yaml"), &Registry::default()),
        Err(BenchError::Unreadable { .. })
    ));
}

#[test]
fn a_campaign_that_asks_nothing_or_nonsense_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let fault = |text: &str| {
        read(folder.path(), text)
            .and_then(|campaign| campaign.schedule(&Registry::default()))
            .expect_err("a fault")
            .to_string()
    };
    let planners = "planners: [{planner: reach}]\n";
    assert!(fault("scenarios: ['021']\nplanners: []\n").contains("no planners"));
    assert!(fault(&format!("scenarios: []\n{planners}")).contains("no scenarios"));
    assert!(fault(&format!("scenarios: ['05x']\n{planners}")).contains("'05x'"));
    assert!(fault(&format!("scenarios: ['021']\n{planners}runs: 0\n")).contains("number of runs"));
    assert!(fault(&format!("scenarios: ['021']\n{planners}time_limit_s: 0\n")).contains("time limit"));
    let message = fault(&format!("scenarios: ['021']\n{planners}time_limit_s: .nan\n"));
    assert!(message.contains("campaign.yaml:3: a time limit is NaN"), "{message}");
    let message = fault(&format!("scenarios: ['021']\n{planners}margin_m: -0.001\n"));
    assert!(message.contains("campaign.yaml:3: a margin is -0.001"), "{message}");
    let message = fault(&format!("scenarios: ['021']\n{planners}robust_rad: 4\n"));
    assert!(message.contains("campaign.yaml:3: a turn is 4"), "{message}");
    assert!(
        fault(&format!("scenarios: ['021']\n{planners}first_seed: 9223372036854775807\n")).contains("seed")
    );
    // These values caused an overflow to a limit of zero, or filled the memory before the first trial.
    let limits = [
        ("memory_limit_mb: 0", "at least 1 and at most 16777216 MB"),
        ("memory_limit_mb: 17592186044416", "at least 1 and at most 16777216 MB"),
        ("memory_limit_mb: 18446744073709551615", "at least 1 and at most 16777216 MB"),
        ("time_limit_s: 1.0e+300", "at most 10000000 s"),
        ("time_limit_s: .inf", "at most 10000000 s"),
        ("iteration_limit: 9223372036854775808", "below 2^63"),
        ("runs: 100000000", "100000000 trials, but at most 1000000"),
        ("runs: 9223372036854775808", "2^63"),
    ];
    for (limit, range) in limits {
        let message = fault(&format!("scenarios: ['021']\n{planners}{limit}\n"));
        assert!(message.contains(range), "{limit}: {message}");
    }
    let twice = "scenarios: ['021']\nplanners: [{planner: reach}, {planner: reach, settings: {looks: 8}}]\n";
    assert!(fault(twice).contains("two planners of the campaign are called 'reach'"));
}

#[test]
fn a_trial_is_known_by_all_settings_whether_or_not_its_call_was_checked() {
    let bare = PlannerCall::BuiltIn {
        planner: "reach".into(),
        settings: serde_json::Map::new(),
        score: ScoreKind::default(),
        min_score: None,
    };
    let checked = PlannerCall::parse("reach", &Registry::default()).expect("a planner");
    let trials = |call: PlannerCall| {
        let campaign = Campaign {
            scenarios: vec!["021".into()],
            planners: vec![CampaignPlanner::new(call)],
            runs: 1,
            ..Campaign::default()
        };
        let questions = campaign.schedule(&Registry::default()).expect("a schedule").questions;
        questions.into_iter().map(|question| question.trial).collect::<Vec<_>>()
    };
    assert_eq!(trials(bare), trials(checked));
}
