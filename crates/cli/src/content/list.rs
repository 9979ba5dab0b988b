use std::fmt::Write;

use cranny_plan::Registry;
use cranny_scenario::{CatalogueEntry, catalogue, insertions, sequences};
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::text;

#[derive(Serialize)]
struct Listing {
    scenarios: Vec<Listed>,
    /// Scenarios whose target lies outside and is put inside.
    insertions: Vec<Listed>,
    /// Scenarios with `steps`.
    sequences: Vec<Listed>,
    planners: Vec<&'static str>,
}

#[derive(Serialize)]
struct Listed {
    id: String,
    environment: String,
    summary: String,
}

pub fn run(registry: &Registry, output: Output) -> Result<Answer, Failure> {
    let listed = |entry: &CatalogueEntry| Listed {
        id: entry.id.to_string(),
        environment: entry.environment.to_string(),
        summary: entry.description.to_string(),
    };
    let scenarios = catalogue().iter().map(listed).collect();
    let insertions = insertions().iter().map(listed).collect();
    let sequences = sequences().iter().map(listed).collect();
    let listing = Listing { scenarios, insertions, sequences, planners: registry.names() };
    if output.json {
        text::print_json(&listing)?;
        return Ok(Answer::Done);
    }
    let mut page = String::from("Built-in scenarios:\n");
    for Listed { id, summary, .. } in &listing.scenarios {
        let _ = writeln!(page, "  {id}  {summary}");
    }
    page.push_str("\nWith the target outside at first (`--place inside`):\n");
    for Listed { id, environment, summary } in &listing.insertions {
        let _ = writeln!(page, "  {id}  {environment}: {summary}");
    }
    page.push_str("\nOf several steps (`--steps`):\n");
    for Listed { id, environment, summary } in &listing.sequences {
        let _ = writeln!(page, "  {id}  {environment}: {summary}");
    }
    let _ = writeln!(page, "\nPlanners: {}", listing.planners.join(", "));
    page.push_str("\nTry: cranny plan 021\n");
    text::print(&page)?;
    Ok(Answer::Done)
}
