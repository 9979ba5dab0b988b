//! Names in any table are names: no line break, formula, command or markup of theirs has an effect.

use cranny_bench::report::Enclosure;
use cranny_bench::{BenchError, Campaign, CampaignPlanner, OmplLog, PlannerCall};
use cranny_plan::Registry;
use cranny_task::Criterion;

use crate::synthetic::{Manner, add, empty};

const NAMES: [&str; 12] = [
    "a\nb",
    "a\r\nb",
    "a\u{2028}b\u{85}c",
    "=HYPERLINK(\"http://evil\";\"x\")",
    "+1|2",
    "-a<b>&c",
    "@sum(A1)",
    "\t=1+1",
    "[2cm] $x$ \\input{/etc/passwd} 50% #1 ~^ {",
    "*a* _b_ `c` [d](http://evil) <script>",
    "a,b;c\"d",
    "\u{202e}evil",
];

#[test]
fn a_campaign_refuses_names_that_no_table_can_show() {
    let registry = Registry::default();
    let call = PlannerCall::parse("reach", &registry).expect("a planner");
    for (name, is_refused) in [
        ("a\nb", true),
        ("a\rb", true),
        ("a\u{1b}[31m", true),
        ("\u{202e}a", true),
        ("a\u{2028}b", true),
        ("", true),
        (" ", true),
        ("=a|b<c>&d%\\", false),
        ("größer ⁺", false),
    ] {
        let planner = CampaignPlanner { name: name.to_owned(), ..CampaignPlanner::new(call.clone()) };
        let campaign = Campaign {
            scenarios: vec!["021".into()],
            planners: vec![planner],
            runs: 1,
            ..Campaign::default()
        };
        let refused = matches!(campaign.schedule(&registry), Err(BenchError::PlannerLetters { .. }));
        assert_eq!(refused, is_refused, "{name:?}");
    }
}

#[test]
fn names_of_older_results_are_escaped_in_every_format() {
    for name in NAMES {
        let (mut campaign, mut draw) = empty();
        for (planner, scenario) in [("reach", "021"), (name, "021"), ("reach", name), (name, name)] {
            let manner = Manner {
                planner,
                criterion: Criterion::Exact,
                mean_s: 1.0,
                limit_s: 10.0,
                runs: 3,
                goal: None,
            };
            add(&mut campaign, &mut draw, scenario, &manner);
        }
        campaign.runs[0].information.machine = name.to_owned();
        campaign.trials[1].record.detail = Some(name.to_owned());
        let summary = campaign.summary();

        let csv = summary.csv();
        assert_eq!(csv.lines().count(), 5, "{csv}");
        for line in csv.lines().skip(1) {
            let fields = csv_fields(line);
            assert_eq!(fields.len(), 12, "{line}");
            for field in &fields {
                assert!(!field.starts_with(['=', '+', '-', '@', '\t', '\r']), "{field}");
            }
        }

        let markdown = summary.markdown();
        let lines: Vec<&str> = markdown.lines().collect();
        assert_eq!(lines.len(), 6, "{markdown}");
        for line in &lines[..4] {
            let bars = line.replace("\\\\", "").replace("\\|", "").matches('|').count();
            assert_eq!(bars, 4, "{line}");
        }
        assert!(!markdown.replace("\\<", "").contains('<'), "{markdown}");

        let latex = summary.latex();
        assert_eq!(latex.lines().count(), 9, "{latex}");
        // The first line is a comment.
        assert!(latex.starts_with("% "), "{latex}");
        assert!(!latex.lines().skip(1).any(|line| line.contains("\\input")), "{latex}");
        for row in latex.lines().skip(3).filter(|line| line.contains(" & ")) {
            let cells = row.replace("\\&", "").matches('&').count();
            assert!(cells == 2 && !row.starts_with('[') && !row.contains(['<', '>', '|']), "{row}");
        }

        let page = summary.html(&Enclosure::default());
        assert!(page.matches("<script").count() == 2, "{name:?}");
        let log = OmplLog::of_all(&campaign.source()).expect("a log").text;
        assert!(log.lines().all(|line| line != "b" && line != "b\r"), "{log}");
    }
}

/// Splits a line of CSV at the commas outside quotes, and removes the quotes.
fn csv_fields(line: &str) -> Vec<String> {
    let (mut fields, mut is_quoted) = (vec![String::new()], false);
    for letter in line.chars() {
        match letter {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => fields.push(String::new()),
            letter => fields.last_mut().expect("a field").push(letter),
        }
    }
    fields
}
