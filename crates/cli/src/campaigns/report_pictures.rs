//! Pictures of the scenarios of a report: a small one of each scenario that is unchanged.

use std::collections::BTreeMap;

use cranny_bench::report::{Png, Row, Summary};
use cranny_bench::{Results, source_of};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_view::{Picture, PictureSettings, Scene, SceneSettings, StandardView};
use rayon::prelude::*;

use crate::failure::Failure;

const WIDTH: usize = 320;
const HEIGHT: usize = 240;

/// Maximum number of scenarios drawn, in the order of their names; drawing more would dominate the time of a report.
const MOST: usize = 40;

/// Returns a picture of each scenario by its name, or the reason why there is none.
pub fn pictures(summary: &Summary, results: &Results) -> BTreeMap<String, Result<Png, String>> {
    let mut scenarios: BTreeMap<&str, &Row> = BTreeMap::new();
    for row in &summary.rows {
        scenarios.entry(&row.scenario_name).or_insert(row);
    }
    let source = |row: &Row| {
        source_of(results, &row.scenario, &row.scenario_hash, None).map_err(|fault| fault.to_string())
    };
    let sources: Vec<(&str, Result<String, String>)> = scenarios
        .into_iter()
        .enumerate()
        .map(|(index, (name, row))| {
            let too_many = || Err(format!("only {MOST} scenarios are drawn"));
            (name, if index < MOST { source(row) } else { too_many() })
        })
        .collect();
    let draw_one = |(name, source): &(&str, Result<String, String>)| {
        let drawn = source.clone().and_then(|source| picture(&source).map_err(|fault| fault.to_string()));
        ((*name).to_owned(), drawn)
    };
    sources.par_iter().map(draw_one).collect()
}

/// Draws the whole scene with the robot at its start.
fn picture(source: &str) -> Result<Png, Failure> {
    let scenario = Scenario::open(source, &OpenOptions::default())?;
    let scene = Scene::of_task(&scenario, None, &SceneSettings::default())?;
    let view = StandardView::ThreeQuarter;
    let camera = scene.whole_camera_from(view.direction_deg(), WIDTH as f64 / HEIGHT as f64);
    let settings =
        PictureSettings { width: WIDTH, height: HEIGHT, camera: Some(camera), ..PictureSettings::default() };
    let picture = Picture::of(&scene, view, &settings)?.in_few_shades();
    let bytes = picture.png(source.as_ref())?;
    Ok(Png { width: WIDTH, height: HEIGHT, bytes })
}
