//! The page of a report: it agrees with the summary, is self-contained, and folds long sections.

#![allow(clippy::float_cmp, reason = "figures that are copied must be the same to the last bit")]

use cranny_bench::report::{Enclosure, Png};
use serde_json::Value;

use crate::synthetic::campaign;

/// Returns the figures of a page: path in the document, visible text, and scale.
fn figures(page: &str) -> Vec<(String, String, f64)> {
    let attribute = |tag: &str, name: &str| {
        let start = tag.find(&format!("{name}=\""))? + name.len() + 2;
        Some(tag[start..start + tag[start..].find('"')?].to_owned())
    };
    let figure = |part: &str| {
        let (tag, rest) = part.split_once('>').expect("a tag ends");
        let text = rest.split("</span>").next().expect("an element ends").to_owned();
        let scale = attribute(tag, "data-scale").map_or(1.0, |scale| scale.parse().expect("a scale"));
        (attribute(tag, "data-path").expect("a path"), text, scale)
    };
    page.split("<span data-path=").skip(1).map(|part| figure(&format!("data-path={part}"))).collect()
}

/// Returns the JSON document within a page.
fn document(page: &str) -> Value {
    let start = page.find("id=\"summary\">").expect("the page holds the document") + "id=\"summary\">".len();
    serde_json::from_str(&page[start..start + page[start..].find("</script>").unwrap()]).expect("JSON")
}

#[test]
fn the_pages_figures_are_those_of_the_json() {
    let summary = campaign().summary();
    let page = summary.html(&Enclosure::default());
    let json = serde_json::to_value(&summary).expect("a summary is JSON");
    assert_eq!(document(&page), json);
    let figures = figures(&page);
    for (path, text, scale) in &figures {
        let pointer = format!("/{}", path.replace('.', "/"));
        let expected = json.pointer(&pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"));
        if text == "&lt; 0.001" {
            assert!(expected < 1e-3, "{path}: {expected}");
            continue;
        }
        let shown: f64 = text.parse().unwrap_or_else(|_| panic!("{path} shows '{text}'"));
        let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let half = 0.5 * 10.0_f64.powi(-i32::try_from(decimals).unwrap()) * (1.0 + 1e-9);
        assert!((shown - expected * scale).abs() <= half, "{path} shows '{text}' for {expected}");
    }
    // Every row shows every figure promised by the format.
    for index in 0..summary.rows.len() {
        for key in
            ["runs", "solved", "success_rate", "success_low", "success_high", "median_s", "median_iterations"]
        {
            let path = format!("rows.{index}.{key}");
            let shown = figures.iter().any(|figure| figure.0 == path);
            assert_eq!(shown, !json.pointer(&format!("/rows/{index}/{key}")).unwrap().is_null(), "{path}");
        }
    }
}

#[test]
fn the_page_needs_nothing_from_elsewhere_and_escapes_what_it_is_told() {
    let png = Png { width: 320, height: 240, bytes: vec![1, 2, 3] };
    let enclosure = Enclosure {
        pictures: [("021".to_owned(), Ok(png)), ("022".to_owned(), Err("it <moved>".to_owned()))].into(),
        paths: [(41, "results-paths/41.html".to_owned())].into(),
    };
    let page = campaign().summary().html(&enclosure);
    assert!(
        page.contains("src=\"data:image/png;base64,AQID\"")
            && page.contains("No picture of 022: it &lt;moved&gt;.")
    );
    let page = page.replace("src=\"data:", "");
    for foreign in ["http://", "https://", "src=", "@import", "<link", "url("] {
        assert!(!page.contains(foreign), "the page holds '{foreign}'");
    }
    assert!(page.contains("what a &lt;judge&gt; &amp; &quot;others&quot; say of crashed"));
    assert!(!page.contains("<judge>"));
    assert!(page.contains("prefers-color-scheme: dark") && page.contains("@media print"));
}

#[test]
fn what_is_long_is_folded_and_every_place_that_is_named_is_there() {
    let page = campaign().summary().html(&Enclosure::default());
    let places: Vec<&str> =
        page.split("href=\"#").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert!(places.len() > 8, "{places:?}");
    for place in places {
        assert_eq!(page.matches(&format!("id=\"{place}\"")).count(), 1, "{place}");
    }
    assert_eq!(page.matches("<details").count(), page.matches("</details>").count());
    // The page has folds for eight scenarios under both criteria, and none for the twelve of the sweep.
    for place in ["exact-021", "paper-045", "exact-gap-sweep-all", "exact-comparisons", "paper-goals"] {
        assert!(page.contains(&format!("<details id=\"{place}\">")), "{place}");
    }
    assert!(!page.contains("<details id=\"exact-gap-0.3100\">"));
}

/// A phone is 360 pixels wide: only tables may be wider, within a scrolling frame.
#[test]
fn long_names_widen_no_page_and_leave_no_plot() {
    let mut campaign = campaign();
    for trial in &mut campaign.trials {
        let own = &mut trial.record.trial;
        own.planner =
            format!("exec:/opt/planners/{}/{}", "a-very-long-name-without-a-space".repeat(3), own.planner);
        own.scenario = format!("{}-of-somebody-with-a-long-folder-name", own.scenario);
    }
    let summary = campaign.summary();
    let page = summary.html(&Enclosure::default());
    let style = page.split("<style>").nth(1).and_then(|rest| rest.split("</style>").next()).expect("a style");
    for rule in style.split('}').filter(|rule| rule.contains("white-space: nowrap")) {
        let selector = rule.split('{').next().unwrap_or_default().trim();
        assert!(["nav ul", "th, td"].contains(&selector), "'{selector}' is never broken");
    }
    for plot in cranny_bench::report::plots(&summary) {
        let svg = plot.svg();
        let texts = svg.split("<text ").skip(1).map(|rest| rest.split("</text>").next().unwrap_or_default());
        for text in texts.filter(|text| !text.contains("transform")) {
            let (tag, words) = text.split_once('>').expect("a tag ends");
            let number = |name: &str| -> f64 {
                let rest = tag.split(&format!("{name}=\"")).nth(1).expect("an attribute");
                rest.split('"').next().unwrap_or_default().parse().expect("a number")
            };
            let width = words.chars().count() as f64 * number("font-size") * 0.56;
            let left = match tag {
                tag if tag.contains("\"end\"") => number("x") - width,
                tag if tag.contains("\"middle\"") => number("x") - width / 2.0,
                _ => number("x"),
            };
            assert!(left > -6.0 && left + width < 486.0, "{}: {text}", plot.name);
        }
    }
}
