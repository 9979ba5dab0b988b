use std::path::PathBuf;

use cranny_view::{Picture, PictureSettings};

use crate::arguments::Output;
use crate::failure::Failure;
use crate::pictures::render::{GLTF_RATE_HZ, RenderArguments, Rendered, flag, scene, settings};
use crate::pictures::render_format::Format;
use crate::{Answer, output_file, progress};

/// Number of pictures per row of a sheet: a row for each environment of the twenty scenarios, which come first.
const SHEET_COLUMNS: usize = 5;

/// Maximum side length of a picture on a sheet, in pixels, because the whole sheet is in memory.
const MOST_SHEET_POINTS: usize = 2048;

/// Renders all built-in scenarios, with the plans of a folder where available.
pub fn run(arguments: &RenderArguments, output: Output) -> Result<Answer, Failure> {
    let format = Format::of(&arguments.output)?;
    if let Some(kind) = format.kind() {
        output_file::check(&arguments.output, kind, output)?;
    }
    if format != Format::Png {
        return Err(flag("all", "a sheet is a picture: give -o a name that ends in .png"));
    }
    if arguments.speed.is_some() {
        return Err(flag("speed", "a film has a speed, but --all draws still pictures"));
    }
    let entries: Vec<_> = cranny_scenario::built_in().collect();
    let bar = progress::bar(entries.len() as u64, output.quiet);
    bar.set_message("scenarios");
    let [view] = arguments.views()[..] else {
        return Err(flag("view", "a sheet has one view of each scenario"));
    };
    // With --all the only free argument is the folder of plans.
    let folder = arguments.plans.first().cloned().or(arguments.id.as_ref().map(PathBuf::from));
    if let Some(folder) = folder.as_ref().filter(|folder| !folder.is_dir()) {
        let problem = format!("'{}' is not a folder of plan files", folder.display());
        return Err(Failure::Flag { flag: "all", problem });
    }
    let size = arguments.size.unwrap_or((400, 300));
    if size.0.max(size.1) > MOST_SHEET_POINTS {
        let problem = format!(
            "{} × {} pixels are too many for each picture of a sheet; each side is at most \
             {MOST_SHEET_POINTS} pixels long",
            size.0, size.1
        );
        return Err(Failure::Flag { flag: "size", problem });
    }
    let mut pictures = Vec::new();
    let mut triangles = 0;
    for entry in entries {
        let plan = folder.as_ref().map(|folder| folder.join(format!("{}.plan.json", entry.id)));
        let plan = plan.filter(|plan| plan.is_file());
        let scene = scene(entry.id, plan.as_deref(), arguments, GLTF_RATE_HZ, output)?;
        triangles += scene.triangle_count();
        // A picture on a sheet cannot be turned or zoomed, so it shows the whole scene.
        let direction_deg = arguments.camera.unwrap_or(view.direction_deg());
        let camera = scene.whole_camera_from(direction_deg, size.0 as f64 / size.1 as f64);
        let settings = PictureSettings { camera: Some(camera), ..settings(&scene, arguments, size, 3)? };
        pictures.push((entry.id.to_owned(), Picture::of(&scene, view, &settings)?));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let sheet = Picture::sheet(&pictures, SHEET_COLUMNS);
    sheet.write_png(&arguments.output)?;
    let files = vec![arguments.output.clone()];
    let (width, height) = (sheet.width(), sheet.height());
    Rendered { files, pictures: 1, width, height, triangles, seen_through: Vec::new() }.answer(output)
}
