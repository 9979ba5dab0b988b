//! Warnings of reports: sandboxes, early ends and missing shards.

use cranny_bench::TrialOutcome;
use cranny_bench::report::Enclosure;

use crate::report::{end, plain};
use crate::synthetic::Campaign;

#[test]
fn a_sandbox_and_workers_that_nobody_recorded_are_unknown() {
    let mut campaign = plain();
    campaign.trials.iter_mut().for_each(|trial| trial.record.trial.settings = r#"{"exec":["x"]}"#.to_owned());
    let says = |campaign: &Campaign, words: &str| {
        campaign.summary().warnings.iter().any(|warning| warning.contains(words))
    };
    let (open, unknown) = ("ran without namespaces", "programs whose sandbox is unknown");
    assert!(says(&campaign, open) && !says(&campaign, unknown));
    let information = &mut campaign.runs[0].information;
    (information.memory_limit_bytes, information.workers) = (None, 0);
    assert!(!says(&campaign, open) && says(&campaign, unknown));
    let page = campaign.summary().html(&Enclosure::default());
    assert!(page.contains("<td class=\"words\">unknown</td>"));
    campaign.runs[0].information.sandbox = Some("landlock, namespaces".to_owned());
    assert!(!says(&campaign, open) && !says(&campaign, unknown));
    campaign.runs.clear();
    assert!(!says(&campaign, open) && says(&campaign, unknown));
}

#[test]
fn a_program_that_ended_at_its_limit_did_not_end_before_it() {
    let mut campaign = plain();
    for trial in &mut campaign.trials {
        trial.record.trial.settings = r#"{"exec":["x"]}"#.to_owned();
        end(trial, TrialOutcome::NoReachableGrasp, 10.3);
    }
    let says = |campaign: &Campaign| {
        campaign
            .summary()
            .warnings
            .iter()
            .any(|warning| warning.contains("without a path before the time limit"))
    };
    assert!(!says(&campaign));
    end(&mut campaign.trials[0], TrialOutcome::NoReachableGrasp, 9.0);
    assert!(says(&campaign));
}

#[test]
fn a_shard_without_a_run_is_named() {
    let mut campaign = plain();
    campaign.runs[0].information.command = "cranny bench run a.yaml --shard 1/2 -o a.db".to_owned();
    let warnings = campaign.summary().warnings;
    assert!(warnings[0].starts_with("No run of shard 2/2 is among these results"), "{warnings:?}");
}
