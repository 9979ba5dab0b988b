//! The data card in the folder of a data set.

use std::fmt::Write as _;

use cranny_scenario::write_whole_file;

use crate::DatasetError;
use crate::folder::DatasetFolder;
use crate::prepared_scene::GRASP_RESULTS;
use crate::statistics::{DatasetStatistics, Spread};

/// Columns of the demonstrations and of the scenes, in words; a test compares the names with those of the files.
const DEMONSTRATION_COLUMNS: [[&str; 2]; 21] = [
    ["row", "index in the whole set"],
    ["scene", "index of the scene"],
    ["task", "`reach`, `carry` or `place`"],
    ["outcome", "`solved` with a proven path; otherwise the outcome of the search"],
    ["seed", "seed of the search, its 64 bits as a signed number"],
    ["start", "start configuration (m, rad), in the order of `joint_names` in `dataset.json`"],
    [
        "waypoints",
        "way points (m, rad), one after another, each with one value per joint; straight lines between; empty unless solved",
    ],
    ["times_s", "times at which the way points are passed; the motion stops at each"],
    [
        "segments",
        "three numbers for each motion between those of the fingers: stage, mode, way points; the last way point of one is the first of the next",
    ],
    ["openings_m", "distance of the fingers on each segment; −1 for the open hand"],
    ["speeds", "share of the speed limits on each segment"],
    ["uneven_m", "travel of the last finger after the first touches, on each segment; −1 for an empty hand"],
    ["grasp", "index of the grasp in the set of the scene; −1 without a path"],
    ["grasp_pose", "gripper frame at the grasp in the planning frame: x, y, z, qw, qx, qy, qz"],
    ["load", "factor by which gravity may grow before a pad slips"],
    [
        "clearance_m",
        "proven lower bound of the clearance along the path, at least half of the true one less 0.01 mm",
    ],
    ["path_length", "length in the plain norm of q (m and rad alike)"],
    ["duration_s", "duration of the trajectory, which is limited in velocity, acceleration and jerk"],
    ["hold_checked", "true if the hold on the carried object was checked along the motion"],
    ["hold_factor", "factor by which loads may grow along the motion; NaN if not checked"],
    ["reason", "commonest reason for the failure of grasps in an unsolved task of several stages"],
];
const SCENE_COLUMNS: [[&str; 2]; 12] = [
    ["scene", "index of the scene"],
    ["family", "family of the scene"],
    ["robot", "robot, whose joints `dataset.json` names"],
    ["parameter_m", "difficulty parameter of the family; NaN without a sound scene"],
    ["placement", "object in the scene: x, y (m), yaw (rad)"],
    [
        "clutter",
        "eleven numbers for each object: 0 and the sides of a box, or 1, radius, length, 0 of a cylinder; pose in the scene",
    ],
    ["boxes", "ten numbers for each box of obstacles and clutter: sides; pose in the planning frame"],
    ["target_pose", "pose of the target in the planning frame: x, y, z, qw, qx, qy, qz"],
    ["start", "the robot's own start"],
    ["grasp_results", "result at each grasp, one byte each; see below"],
    ["goals", "number of goal configurations that the queries share"],
    ["rejected", "number of draws that were rejected before this scene"],
];

const PICTURE_COLUMNS: [[&str; 2]; 9] = [
    ["scene", "index of the scene"],
    ["camera", "name of the camera"],
    ["width", "width in pixels"],
    ["height", "height in pixels"],
    ["intrinsics_px", "focal lengths along x and y, principal point; pixel centres are whole numbers"],
    ["pose", "optical frame (z forward, x right, y down) in the planning frame: x, y, z, qw, qx, qy, qz"],
    [
        "depth_png",
        "PNG of 16 bits: exact depths along z in mm, 0 for none in the range of the sensor; the robot is at its own start",
    ],
    ["segments_png", "PNG of 16 bits: number of the body that each pixel shows, 0 for none"],
    ["segments", "names of the bodies, from number 1; the last is the robot"],
];

/// Meaning of each result at a grasp, in the order of [`GRASP_RESULTS`].
const RESULT_MEANINGS: [&str; 9] = [
    "a free configuration was found",
    "the object is wider there than the hand opens",
    "proven: beyond the reach of the arm",
    "the open hand touches something at the grasp and at its twin",
    "no attempt of inverse kinematics converged",
    "attempts converged, but the arm touched a body",
    "attempts converged, but the robot touched itself",
    "the grasp did not come up before there were enough goal configurations; `reasons: all` in a recipe tries all",
    "another reason",
];

/// Writes `README.md` of a data set.
pub(crate) fn write_card(folder: &DatasetFolder) -> Result<(), DatasetError> {
    let statistics = DatasetStatistics::of(folder, &mut || {})?;
    Ok(write_whole_file(&folder.path().join("README.md"), card(folder, &statistics).as_bytes())?)
}

fn card(folder: &DatasetFolder, statistics: &DatasetStatistics) -> String {
    let recipe = folder.recipe();
    let mut page = String::new();
    let _ = writeln!(page, "---\nlicense: {}\n---\n", recipe.licence.to_lowercase());
    let _ = writeln!(
        page,
        "# Proven demonstrations of grasping in confined spaces\n\nMade by Cranny {} from the recipe in `dataset.json`. \
         Every path of a row with the outcome `solved` is proven free of collision along its whole length, from its start to a \
         grasp; `cranny dataset check` proves it again.\n",
        folder.description().version
    );
    let _ = writeln!(page, "## Statistics\n");
    page.push_str(&statistics_lines(statistics));
    let _ = writeln!(page, "\n| family | task | rows | solved |\n|---|---|---|---|");
    for (family, tasks) in &statistics.kinds {
        for (task, kind) in tasks {
            let _ = writeln!(page, "| {family} | {task} | {} | {} |", kind.rows, kind.solved);
        }
    }
    let pictures = recipe.cameras.as_ref().map(|_| ("pictures/*.parquet", &PICTURE_COLUMNS[..]));
    for (title, columns) in
        [("demonstrations/*.parquet", &DEMONSTRATION_COLUMNS[..]), ("scenes/*.parquet", &SCENE_COLUMNS[..])]
            .into_iter()
            .chain(pictures)
    {
        let _ = writeln!(page, "\n## Columns of `{title}`\n\n| column | content |\n|---|---|");
        for [name, content] in columns {
            let _ = writeln!(page, "| `{name}` | {content} |");
        }
    }
    let _ = writeln!(page, "\n## Results at grasps\n\n| byte | result | meaning |\n|---|---|---|");
    for (byte, (name, meaning)) in GRASP_RESULTS.iter().zip(RESULT_MEANINGS).enumerate() {
        let _ = writeln!(page, "| {byte} | {name} | {meaning} |");
    }
    let modes: Vec<String> =
        crate::MODES.iter().enumerate().map(|(number, mode)| format!("{number} {}", mode.name)).collect();
    let _ = writeln!(
        page,
        "\nModes of segments: {}.\n\n## Use\n\n```sh\ncranny dataset check .\ncranny dataset extract . 0 -o row_0\n\
         cranny dataset export . --format lerobot -o lerobot\n```\n\n```python\nfrom cranny import dataset\nrows = dataset.load(\".\")\n```",
        modes.join(", ")
    );
    page
}

/// Returns lines with the statistics of a data set.
pub fn statistics_lines(statistics: &DatasetStatistics) -> String {
    let DatasetStatistics { scenes, rows, solved, bytes, .. } = statistics;
    let per_row = *bytes as f64 / (*rows).max(1) as f64;
    let mut page = format!("- {rows} rows in {scenes} scenes, {solved} solved; {per_row:.0} bytes a row\n");
    if statistics.picture_bytes > 0 {
        let per_scene = statistics.picture_bytes as f64 / (*scenes).max(1) as f64;
        let _ = writeln!(page, "- pictures: {per_scene:.0} bytes a scene");
    }
    let outcomes: Vec<String> =
        statistics.outcomes.iter().map(|(name, count)| format!("{name} {count}")).collect();
    let _ = writeln!(page, "- outcomes: {}", outcomes.join(", "));
    let grasps: Vec<String> =
        statistics.grasps.iter().map(|(name, count)| format!("{name} {count}")).collect();
    let _ = writeln!(page, "- grasps of the scenes: {}", grasps.join(", "));
    let mut line = |name: &str, of: &Spread, factor: f64, unit: &str| {
        let Spread { least, mean, greatest, .. } = of;
        let [least, mean, greatest] = [least, mean, greatest].map(|value| value * factor);
        let _ = writeln!(page, "- {name}: mean {mean:.2}{unit}, from {least:.2} to {greatest:.2}");
    };
    line("way points", &statistics.way_points, 1.0, "");
    line("path length", &statistics.path_length, 1.0, "");
    line("duration", &statistics.duration_s, 1.0, " s");
    line("clearance", &statistics.clearance_m, 1e3, " mm");
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parquet::reader::read_parquet;
    use crate::tables::{demonstrations_file, pictures_file, scenes_file};

    #[test]
    fn the_card_names_the_columns_of_the_files() {
        for (file, columns) in [
            (demonstrations_file(&[]), &DEMONSTRATION_COLUMNS[..]),
            (scenes_file(&[]), &SCENE_COLUMNS[..]),
            (pictures_file(&[]), &PICTURE_COLUMNS[..]),
        ] {
            let names: Vec<String> = read_parquet(&file).unwrap().into_iter().map(|(name, _)| name).collect();
            assert_eq!(names, columns.iter().map(|[name, _]| *name).collect::<Vec<_>>());
        }
    }
}
