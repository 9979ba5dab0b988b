//! Viewer pages beside a report: the path of each of its worst trials that has one.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cranny_bench::report::Summary;
use cranny_bench::{PathDemand, Results, StoredTrial, source_of};
use cranny_record::write_waypoints_csv;
use cranny_scenario::Temporary;
use rayon::prelude::*;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file::{self, NamedFile};
use crate::pictures::page_task::{PageRequest, PageTask};
use crate::{progress, text};

/// Trial with a path, and the name that opens its scenario.
struct Shown {
    trial: StoredTrial,
    path: Vec<Vec<f64>>,
    source: String,
}

/// Writes the pages to a folder beside the report at `page` and returns their addresses relative to it, by trial.
pub fn write(
    summary: &Summary,
    results: &Results,
    page: &Path,
    output: Output,
) -> Result<BTreeMap<u64, String>, Failure> {
    let mut shown = Vec::new();
    for worst in &summary.worst {
        let trial = results.trial(worst.trial)?;
        let path = results.path_of(worst.trial)?;
        if path.is_empty() {
            continue;
        }
        let (own, said) = (&trial.record.trial, !output.quiet);
        let demand = PathDemand::of_settings(&own.settings);
        if demand.carry.is_some() || demand.task.is_some() {
            // The path continues with the object in the hand, which bare way points do not record.
            let note = || {
                text::note(&format!(
                    "trial {}: no page, because its path continues with the target in the hand",
                    trial.id
                ))
            };
            said.then(note).transpose()?;
            continue;
        }
        match source_of(results, &own.scenario, &own.scenario_hash, None) {
            Ok(source) => shown.push(Shown { trial, path, source }),
            Err(fault) if said => text::note(&format!("trial {}: {fault}", trial.id))?,
            Err(_) => {}
        }
    }
    let bar = progress::bar(shown.len() as u64, output.quiet);
    bar.set_message("paths");
    let file = |shown: &Shown| {
        let content = content(shown, output)?.into_bytes();
        bar.inc(1);
        Ok(NamedFile { name: format!("{}.html", shown.trial.id), kind: FileKind::ViewerPage, content })
    };
    let files = shown.par_iter().map(file).collect::<Result<Vec<_>, Failure>>()?;
    bar.finish_and_clear();
    let folder = folder_of(page);
    output_file::write_all(&folder, &files, output)?;
    let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let address = |shown: &Shown| (shown.trial.id, format!("{}/{}.html", address_of(&name), shown.trial.id));
    Ok(shown.iter().map(address).collect())
}

/// Folder of the pages: `report.html` → `report-paths`, beside it.
pub fn folder_of(page: &Path) -> PathBuf {
    let stem = page.file_stem().unwrap_or_default().to_string_lossy();
    page.with_file_name(format!("{stem}-paths"))
}

/// Percent-encodes a name for an address.
fn address_of(name: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    name.bytes()
        .map(|byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") })
        .collect()
}

fn content(shown: &Shown, output: Output) -> Result<String, Failure> {
    let trial = &shown.trial.record.trial;
    let folder = Temporary::folder()?;
    // The page names a path by its file.
    let letter = |c: char| if c.is_alphanumeric() || "-._ ".contains(c) { c } else { '-' };
    let planner: String = trial.planner.chars().map(letter).take(60).collect();
    let file = folder.path().join(format!("trial {} {planner}.csv", shown.trial.id));
    write_waypoints_csv(&file, &shown.path)?;
    let request = PageRequest {
        id: &shown.source,
        plans: &[file],
        robot: None,
        geometry: None,
        criterion: Some(trial.criterion),
        grasps: PathDemand::of_settings(&trial.settings).given_grasps(),
        search_trees: None,
    };
    let task = PageTask::open(&request, Output { quiet: true, ..output })?;
    Ok(task.page.html()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_lie_beside_the_report_and_are_found_from_it() {
        assert_eq!(folder_of(Path::new("out/my report.html")), Path::new("out/my report-paths"));
        assert_eq!(address_of("my report-paths"), "my%20report-paths");
        assert_eq!(address_of("50%#?"), "50%25%23%3F");
    }
}
