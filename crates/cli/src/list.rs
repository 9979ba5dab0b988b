use std::fmt::Write;

use cranny_plan::Registry;
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::text;

#[derive(Serialize)]
struct Listing {
    scenarios: Vec<Listed>,
    planners: Vec<&'static str>,
}

#[derive(Serialize)]
struct Listed {
    id: String,
    environment: String,
    summary: String,
}

pub fn run(registry: &Registry, output: Output) -> Result<Answer, Failure> {
    let scenarios: Vec<Listed> = cranny_scenario::catalogue()
        .iter()
        .map(|entry| Listed {
            id: entry.id.to_string(),
            environment: entry.environment.to_string(),
            summary: entry.description.to_string(),
        })
        .collect();
    let listing = Listing { scenarios, planners: registry.names() };
    if output.json {
        text::print_json(&listing)?;
        return Ok(Answer::Done);
    }
    let mut page = String::from("Built-in scenarios:\n");
    for Listed { id, summary, .. } in &listing.scenarios {
        let _ = writeln!(page, "  {id}  {summary}");
    }
    let _ = writeln!(page, "\nPlanners: {}", listing.planners.join(", "));
    page.push_str("\nTry: cranny plan 021\n");
    text::print(&page)?;
    Ok(Answer::Done)
}
