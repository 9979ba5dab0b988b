use std::collections::BTreeMap;
use std::path::Path;

use cranny_grasp::GraspSet;
use cranny_robot::{Robot, RobotOptions};
use cranny_scenario::{OpenOptions, Recipe, RecipeRobot, Scenario, TargetPhysics};
use cranny_spatial::Point;
use cranny_view::{Picture, PictureSettings, Scene, SceneSettings, StandardView};

use crate::failure::Failure;

/// Side length of each of the four pictures, in pixels.
const SIDE: usize = 560;

/// Drawn length of the axes of the gripper frame, in metres.
const AXES_M: f64 = 0.06;

/// Writes a sheet of four pictures: the robot at its start from two sides, its hand open and closed with the gripper frame, or
/// its tool with it.
pub fn write(what: &Path, recipe: &RecipeRobot, file: &Path) -> Result<(), Failure> {
    let mut pictures = Vec::new();
    let (open_scene, open) = scene(recipe)?;
    for (title, view) in [("at its start", StandardView::ThreeQuarter), ("from the side", StandardView::Side)]
    {
        pictures.push((title.to_owned(), Picture::of(&open_scene, view, &settings())?));
    }
    if recipe.robot.tool().is_some() {
        pictures.push(("tool".to_owned(), hand(&open_scene, &open)?));
        return Ok(Picture::sheet(&pictures, 2).write_png(file)?);
    }
    pictures.push(("hand, open".to_owned(), hand(&open_scene, &open)?));
    let fingers = recipe.robot.hand().map(|hand| &hand.description.fingers);
    let closed =
        fingers.map(|fingers| fingers.iter().map(|(name, range)| (name.clone(), range.closed)).collect());
    let options = RobotOptions { fixed: closed.unwrap_or_default(), ..RobotOptions::default() };
    let (closed_scene, closed) = scene(&RecipeRobot::load_with(what, &options)?)?;
    pictures.push(("hand, closed".to_owned(), hand(&closed_scene, &closed)?));
    Ok(Picture::sheet(&pictures, 2).write_png(file)?)
}

/// Returns a scene of the robot alone on the floor, with the axes of its gripper frame.
fn scene(recipe: &RecipeRobot) -> Result<(Scene, Scenario), Failure> {
    let recipe = Recipe {
        title: recipe.robot.name().to_owned(),
        robot: recipe.clone(),
        obstacles: Vec::new(),
        target: None,
        given_physics: TargetPhysics::default(),
        start: recipe.start(),
        grasps: GraspSet::default(),
        ik: Vec::new(),
        places: Vec::new(),
        regions: BTreeMap::new(),
        tasks: Vec::new(),
        physics: BTreeMap::new(),
        colours: BTreeMap::new(),
        tool_bounds: Vec::new(),
        joint_bounds: BTreeMap::new(),
        speeds: Vec::new(),
    };
    let scenario = recipe.scenario(recipe.robot.robot.name(), &OpenOptions::default())?;
    let frames = scenario.robot.frames_at(&scenario.start);
    let scene = Scene::of_task(&scenario, None, &SceneSettings::default())?;
    Ok((scene.with_axes(frames.link(scenario.robot.tip()), AXES_M), scenario))
}

/// Renders the hand alone, along the axis across its fingers and slightly from above.
fn hand(scene: &Scene, scenario: &Scenario) -> Result<Picture, Failure> {
    let robot: &Robot = &scenario.robot;
    let frames = robot.frames_at(&scenario.start);
    let mut points = Vec::new();
    for &link in robot.hand_links() {
        for shape in &robot.links()[link].collisions {
            let pose = frames.link(link) * shape.link_from_shape;
            let (corners, _) = shape.solid.bounding_points().unwrap_or_default();
            points.extend(corners.iter().map(|corner| pose * corner));
        }
    }
    let tip = frames.link(robot.tip());
    points.push(tip.translation.vector.into());
    // If the hand is one link with much of the arm, only points near the tip are framed.
    let near = |point: &Point| (point.coords - tip.translation.vector).norm() < 0.25;
    points.retain(near);
    let across = tip.rotation * cranny_spatial::Vector::x();
    let turn_deg = libm::atan2(across.y, across.x).to_degrees();
    let rise_deg = libm::asin(across.z.clamp(-1.0, 1.0)).to_degrees().clamp(-60.0, 60.0);
    let camera = cranny_view::Camera::framing((turn_deg + 15.0, rise_deg + 12.0), &points, 1.0);
    let settings = PictureSettings { camera: Some(camera), ..settings() };
    let hand = scene.clone().with_links(robot.hand_links());
    Ok(Picture::of(&hand, StandardView::Side, &settings)?)
}

fn settings() -> PictureSettings {
    PictureSettings { width: SIDE, height: SIDE, samples: 4, ..PictureSettings::default() }
}
