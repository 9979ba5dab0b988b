use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use cranny_robot::{Robot, RobotFiles, Srdf};
use cranny_scenario::write_whole_folder;
use cranny_spatial::Stream;

use crate::anatomy::{by_name, extent_m};
use crate::choice::Choice;
use crate::contact_search::PairSearch;
use crate::draft::{Draft, read_text, robot_name};
use crate::near_srdf::NearSrdf;
use crate::robot_folder::{self, Written};
use crate::self_contacts::SelfContact;
use crate::setup_options::{Base, SetupOptions};
use crate::start_choice::StartChoice;
use crate::{SetupError, limits, near_srdf};

/// Setup of a robot derived from its URDF, with the files that describe it.
#[derive(Clone, Debug)]
pub struct RobotSetup {
    /// Name of the robot.
    pub name: String,
    /// Robot built from its files.
    pub robot: Arc<Robot>,
    /// Content of its files by name.
    pub files: BTreeMap<String, Vec<u8>>,
    /// Choices that were made, in order of importance.
    pub choices: Vec<Choice>,
    /// Contacts of pairs of links in drawn configurations.
    pub contacts: Vec<SelfContact>,
}

/// Distance of the floor below the lowest point of a base that moves over it, in metres.
const FLOOR_GAP_M: f64 = 1e-3;

impl RobotSetup {
    /// Derives the setup of a robot from a URDF, MJCF or SDF, or from a xacro file if Python's `xacro` is installed.
    ///
    /// 1. Its text; its joints and rigid bodies.
    /// 2. The hand, or one mounted on it; the gripper frame, as a link of the URDF; a base for a hand alone.
    /// 3. Limits; pairs of links that touch by design.
    /// 4. The height of the ground and the start configuration.
    ///
    /// # Errors
    /// [`SetupError`], with advice in its message.
    pub fn of(urdf: &Path, options: &SetupOptions) -> Result<Self, SetupError> {
        // 1.
        let mut draft = Draft::read(urdf, options)?;
        // 2.
        let mounted = draft.find_hand()?;
        let base = draft.put_on_base()?;
        // 3.
        let facts = draft.text.joints()?;
        draft.choices.push(limits::choice(&facts));
        let stem = robot_name(urdf);
        let beside = urdf.with_file_name(format!("{stem}.srdf"));
        let own_srdf = options.srdf.clone().or_else(|| beside.is_file().then_some(beside));
        let own_srdf =
            own_srdf.map(|path| read_text(&path)).transpose()?.or_else(|| draft.model_srdf.clone());
        let near_srdf = if own_srdf.is_none() { near_srdf::find(urdf) } else { None };
        let mut written = Written {
            stem: stem.clone(),
            limits: limits::text(&facts, &base.ranges()),
            srdf: own_srdf.clone(),
            tip: options.tip.clone().filter(|_| draft.hand.is_none() && draft.tool.is_none()),
            solid_meshes: draft.solid_meshes.clone(),
            fixed: draft.fixed.clone(),
            hand: draft.hand.clone(),
            tool: draft.tool.clone(),
            floor_m: 0.0,
            start: BTreeMap::new(),
            notes: Vec::new(),
        };
        let robot = draft.robot(&written)?;
        let mut contacts = SelfContact::sample(&robot)?;
        let mut extra = mounted.as_ref().map_or_else(Vec::new, |gripper| gripper.touching.clone());
        if let Some(near) = near_srdf.as_ref().filter(|_| own_srdf.is_none()) {
            extra.extend(near.pairs(&robot));
            draft.choices.push(near.choice());
        }
        let srdf_of = |robot: &Robot, contacts: &[SelfContact]| match &own_srdf {
            Some(own) => robot_folder::with_always_pairs(own, robot, contacts),
            None => robot_folder::srdf_text(robot, contacts, &extra),
        };
        let as_given = robot.clone();
        written.srdf = Some(srdf_of(&as_given, &contacts));
        // 4.
        written.floor_m = floor_m(&robot, base);
        let robot = draft.robot(&written)?;
        let states = match &own_srdf {
            Some(srdf) => states(&robot, &Srdf::parse(srdf, &stem)?),
            None => {
                near_srdf.as_ref().and_then(NearSrdf::srdf).map_or_else(Vec::new, |srdf| states(&robot, srdf))
            }
        };
        let seldom_free: Vec<&[f64]> = contacts.iter().filter_map(|c| c.free_at.as_deref()).collect();
        let mut start = StartChoice::of(&robot, written.floor_m, &states, &seldom_free)?;
        if start.is_none() {
            // An arm may hang below the links that carry it.
            written.floor_m = below_all_m(&robot);
            start = StartChoice::of(&robot, written.floor_m, &states, &seldom_free)?;
            draft.choices.push(Choice::new(
                "ground",
                format!("at z = {:.3} m", written.floor_m),
                "nothing is free above the lowest point of the links that carry the arm",
                "`floor_m` in robot.yaml",
            ));
        }
        let start = start.ok_or_else(|| never_free(&draft.file, &robot, &contacts))?;
        // A pair that does not touch at the start does not always touch.
        for contact in contacts.iter_mut().filter(|contact| contact.is_always()) {
            if PairSearch::new(&robot, contact.links).is_free(&start.q) {
                contact.free_at = Some(start.q.clone());
            }
        }
        written.srdf = Some(srdf_of(&as_given, &contacts));
        draft.choices.push(robot_folder::pairs_choice(&as_given, &contacts, own_srdf.is_some(), &stem));
        written.start = by_name(&robot, &start.q);
        draft.choices.push(Choice::new(
            "start",
            start.q.iter().map(|value| format!("{value:.3}")).collect::<Vec<_>>().join(", "),
            &start.why,
            "`start` in robot.yaml",
        ));
        let robot = draft.robot(&written)?;
        let text = draft.text.text();
        let mut files = RobotFiles::of_text(text, &urdf.with_extension("urdf"), &options.packages)?.contents;
        written.notes = draft.choices.iter().map(Choice::line).collect();
        files.extend(written.files());
        Ok(Self { name: stem, robot, files, choices: draft.choices, contacts })
    }

    /// Writes its files into a new folder.
    ///
    /// # Errors
    /// [`ScenarioError`](cranny_scenario::ScenarioError) for a folder that exists or cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), SetupError> {
        Ok(write_whole_folder(folder, |folder| robot_folder::write(folder, &self.files))?)
    }
}

/// Returns the error for a robot of which no drawn configuration is free.
fn never_free(file: &str, robot: &Robot, contacts: &[SelfContact]) -> SetupError {
    let worst = contacts.iter().filter(|c| c.unchecked.is_none() && !c.is_always() && c.touching > 0);
    let worst = worst.max_by_key(|c| c.touching);
    let name = |link: usize| robot.links()[link].name.clone();
    let pair = worst.map_or_else(
        || "the ground".to_owned(),
        |c| format!("{} with {} ({} %)", name(c.links.0), name(c.links.1), c.touching / 10),
    );
    SetupError::NeverFree { file: file.to_owned(), pair }
}

/// Height of the ground below a robot in its root frame, in metres: the lowest point of the links that carry its arm.
fn floor_m(robot: &Robot, base: Base) -> f64 {
    if base == Base::Floating {
        return 0.0;
    }
    let q: Vec<f64> = robot.limits().iter().map(|limits| limits.clamp(0.0)).collect();
    let frames = robot.frames_at(&q);
    let movers = robot.ancestors(robot.tip());
    let first_arm = movers.iter().position(|mover| {
        let above = robot.links()[mover.child_link].parent.unwrap_or(0);
        !robot.links()[above].collisions.is_empty()
    });
    let base_joints: Vec<usize> = movers[..first_arm.unwrap_or(0)].iter().map(|mover| mover.joint).collect();
    let lowest = |is_moved: bool| {
        let stands = |link: &usize| {
            let own = robot.ancestors(*link);
            own.is_empty() != is_moved && own.iter().all(|mover| base_joints.contains(&mover.joint))
        };
        let shapes = (0..robot.links().len()).filter(stands).flat_map(|link| {
            let root_from_link = *frames.link(link);
            let shapes = robot.links()[link].collisions.iter();
            shapes.map(move |shape| (root_from_link * shape.link_from_shape, shape.solid.clone()))
        });
        -extent_m(&shapes.collect::<Vec<_>>(), &-cranny_spatial::Vector::z())
    };
    let (standing, moved) = (lowest(false), lowest(true) - FLOOR_GAP_M);
    let floor = standing.min(moved);
    // The links on the ground must not touch it either.
    if floor.is_finite() { (floor * 1e4).floor() / 1e4 - 1e-4 } else { 0.0 }
}

/// Returns a height (m) of the ground in the root frame that is below the robot in all of some drawn configurations.
fn below_all_m(robot: &Robot) -> f64 {
    const DRAWS: usize = 1000;
    let mut random = Stream::new(0, 2);
    let lowest_at = |q: Vec<f64>| {
        let frames = robot.frames_at(&q);
        let shapes = robot.links().iter().enumerate().flat_map(|(link, data)| {
            let root_from_link = *frames.link(link);
            data.collisions
                .iter()
                .map(move |shape| (root_from_link * shape.link_from_shape, shape.solid.clone()))
        });
        -extent_m(&shapes.collect::<Vec<_>>(), &-cranny_spatial::Vector::z())
    };
    let lowest = (0..DRAWS).map(|_| lowest_at(robot.random_configuration(&mut random)));
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { (lowest * 10.0).floor() / 10.0 } else { 0.0 }
}

/// Returns the named states of the SRDF that set at least three joints of the group, other joints at their default.
fn states(robot: &Robot, srdf: &Srdf) -> Vec<(String, Vec<f64>)> {
    let base = robot.limits().iter().map(|limits| limits.clamp(0.0)).collect::<Vec<_>>();
    let q_of = |values: &[(String, f64)]| -> Option<Vec<f64>> {
        let mut q = base.clone();
        let mut known = 0;
        for (joint, value) in values {
            if let Some(index) = robot.joint_names().iter().position(|name| name == joint) {
                q[index] = *value;
                known += 1;
            }
        }
        (known >= 3).then_some(q)
    };
    srdf.group_states.iter().filter_map(|state| Some((state.name.clone(), q_of(&state.values)?))).collect()
}
