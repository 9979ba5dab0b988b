use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_robot::{
    HandDescription, JointKind, MountingJoint, Robot, RobotError, RobotFiles, RobotOptions, Srdf, TextSource,
    UrdfText,
};
use cranny_scenario::{MountedGripper, write_whole_folder};
use cranny_spatial::Pose;

use crate::anatomy::{Anatomy, by_name, extent_m};
use crate::choice::Choice;
use crate::hand_guess::{DEFAULT_FORCE_N, HandGuess, HandKind, marks};
use crate::robot_folder::{self, Written};
use crate::self_contacts::SelfContact;
use crate::start_choice::StartChoice;
use crate::{SetupError, limits, xacro};

/// What whoever adds a robot says of it; what is left open is chosen.
#[derive(Clone, Debug, Default)]
pub struct SetupOptions {
    /// Its SRDF. Default: the one beside the URDF, if there is one.
    pub srdf: Option<PathBuf>,
    /// Folders in which `package://` names are looked for.
    pub packages: Vec<PathBuf>,
    /// The gripper frame, a link. Default: found with the hand.
    pub tip: Option<String>,
    /// The link that carries the fingers. Default: found.
    pub palm: Option<String>,
    /// How its root moves. Default: as the URDF has it; a hand without an arm flies.
    pub base: Option<Base>,
    /// Whether an arm without a hand gets the built-in gripper. Default: it does.
    pub is_bare: bool,
}

/// How the root of a robot moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// As the URDF has it.
    Own,
    /// Drives on the floor, with a heading.
    Planar,
    /// Flies.
    Floating,
}

/// A robot that was found out about, with the files that say so.
#[derive(Clone, Debug)]
pub struct RobotSetup {
    /// Its name.
    pub name: String,
    /// The robot, as its files have it.
    pub robot: Arc<Robot>,
    /// Its files by their names.
    pub files: BTreeMap<String, Vec<u8>>,
    /// What was chosen, in the order in which it matters.
    pub choices: Vec<Choice>,
    /// Pairs of links, as they were found in drawn configurations.
    pub contacts: Vec<SelfContact>,
}

/// What a base is called that is put under a robot.
const BASE_JOINT: &str = "base";
const BASE_LINK: &str = "ground";

/// A joint's range, in metres: as far as today's scenes ask, and no lower than the floor.
const DRIVE_M: [f64; 2] = [-1.0, 1.0];
const FLY_M: [f64; 2] = [0.0, 1.5];

/// Below a body that moves over it, the floor is laid so much lower than its lowest point, in metres.
const FLOOR_GAP_M: f64 = 1e-3;

impl RobotSetup {
    /// Finds out about the robot of a URDF, or a xacro file if Python's `xacro` is installed.
    ///
    /// 1. Its text; its joints and bodies.
    /// 2. The hand, or one for it; a base for a hand alone.
    /// 3. The gripper frame, as a link of the URDF.
    /// 4. Limits; pairs of links that touch by design; where it stands and starts.
    ///
    /// # Errors
    /// [`SetupError`], with what would help.
    pub fn of(urdf: &Path, options: &SetupOptions) -> Result<Self, SetupError> {
        // 1.
        let mut choices = Vec::new();
        let (text, file) = read(urdf, &mut choices)?;
        let folder = urdf.parent().map_or_else(|| PathBuf::from("."), Path::to_owned);
        let anatomy_of = |text: &UrdfText| Anatomy::of(text, Some(&folder), &options.packages);
        let (mut text, mut anatomy) = (text.clone(), anatomy_of(&text)?);
        check_ranges(&file, &anatomy)?;
        // 2.
        let palm = options.palm.as_ref().map(|palm| named_link(&anatomy, &file, palm)).transpose()?;
        let tip = options.tip.as_ref().map(|tip| named_link(&anatomy, &file, tip)).transpose()?;
        let mut guess = HandGuess::of(&anatomy, palm);
        let marks = guess.as_ref().map_or_else(Vec::new, |guess| marks(&anatomy, guess));
        for mark in &marks {
            let name = anatomy.link_name(*mark).to_owned();
            text = text.without_body(&name)?;
            choices.push(Choice::new(
                "left out",
                format!("the collision geometry of {name}"),
                "a speck between the pads that touches nothing is a mark, and every grasp would collide with it",
                "put it back in the URDF",
            ));
        }
        if !marks.is_empty() {
            anatomy = anatomy_of(&text)?;
            guess = HandGuess::of(&anatomy, palm);
        }
        if guess.is_none() && palm.is_some() {
            let what = format!("link {} carries no fingers", options.palm.as_deref().unwrap_or_default());
            return Err(SetupError::NotThere { file, what });
        }
        let mut mounted = None;
        if guess.is_none() && !options.is_bare {
            let flange =
                tip.map_or_else(|| flange(&anatomy), Some).filter(|flange| is_on_arm(&anatomy, *flange));
            let Some(flange) = flange else {
                let moving = anatomy.robot.joint_names().join(", ");
                return Err(SetupError::NoArm { file, joints: moving });
            };
            let gripper = MountedGripper::built_in()?;
            let name = anatomy.link_name(flange).to_owned();
            text = text.carrying(&name, &gripper.urdf, &fixed("gripper_mount"))?;
            anatomy = anatomy_of(&text)?;
            choices.push(Choice::new(
                "hand",
                format!("none found: the built-in gripper ({}) is mounted on {name}", gripper.hand.name),
                "no link carries parts that close towards each other",
                "--bare leaves the arm as it is; --palm LINK names the link that carries the fingers; --tip LINK the flange",
            ));
            mounted = Some(gripper);
        }
        let is_alone = guess
            .as_ref()
            .is_some_and(|guess| anatomy.joints_of(anatomy.body_of[guess.palm]).next().is_none());
        let base = options.base.unwrap_or(if is_alone { Base::Floating } else { Base::Own });
        // 3.
        let hand = match (&guess, &mounted) {
            (_, Some(gripper)) => Some(gripper.hand.clone()),
            (Some(guess), None) => Some(describe(&anatomy, guess, tip, &mut text, &mut choices)?),
            (None, None) => None,
        };
        if base != Base::Own {
            text = on_base(&text, base)?;
        }
        describe_base(&anatomy, base, is_alone, &mut choices);
        if anatomy.robot.ancestors(0).is_empty() && base == Base::Own && is_alone {
            let moving = anatomy.robot.joint_names().join(", ");
            return Err(SetupError::NoArm { file, joints: moving });
        }
        // 4.
        let facts = text.joints()?;
        let ranges = match base {
            Base::Own => Vec::new(),
            Base::Planar => vec![(format!("{BASE_JOINT}/x"), DRIVE_M), (format!("{BASE_JOINT}/y"), DRIVE_M)],
            Base::Floating => vec![
                (format!("{BASE_JOINT}/x"), DRIVE_M),
                (format!("{BASE_JOINT}/y"), DRIVE_M),
                (format!("{BASE_JOINT}/z"), FLY_M),
            ],
        };
        let limits_text = limits::text(&facts, &ranges);
        choices.push(limits::choice(&facts));
        let beside = urdf.with_extension("srdf");
        let own_srdf = options.srdf.clone().or_else(|| beside.is_file().then_some(beside));
        let own_srdf = own_srdf.map(|path| read_text(&path)).transpose()?;
        let stem = urdf.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut written = Written {
            stem: stem.clone(),
            limits: limits_text,
            srdf: own_srdf.clone(),
            tip: options.tip.clone().filter(|_| hand.is_none()),
            hand,
            floor_m: 0.0,
            start: BTreeMap::new(),
            notes: Vec::new(),
        };
        let load = |text: &UrdfText, written: &Written| -> Result<Arc<Robot>, RobotError> {
            let named = |name: &str, text: String| Some(TextSource::Text { name: name.to_owned(), text });
            let robot_options = RobotOptions {
                srdf: written.srdf.clone().and_then(|srdf| named(&format!("{stem}.srdf"), srdf)),
                limits: named("limits.yaml", written.limits.clone()),
                description: named("robot.yaml", written.description()),
                packages: options.packages.clone(),
                ..RobotOptions::default()
            };
            Robot::from_urdf_text(text.text(), &file, Some(&folder), &robot_options).map(Arc::new)
        };
        let robot = load(&text, &written)?;
        let contacts = SelfContact::sample(&robot);
        if own_srdf.is_none() {
            let extra = mounted.as_ref().map_or(&[][..], |gripper| &gripper.touching);
            written.srdf = Some(robot_folder::srdf_text(&robot, &contacts, extra));
        }
        choices.push(robot_folder::pairs_choice(&robot, &contacts, own_srdf.is_some(), &stem));
        written.floor_m = floor_m(&robot, base);
        let robot = load(&text, &written)?;
        let states = match &own_srdf {
            Some(srdf) => states(&robot, &Srdf::parse(srdf, &stem)?),
            None => Vec::new(),
        };
        let start = StartChoice::of(&robot, written.floor_m, &states)?;
        let Some(start) = start else {
            let worst =
                contacts.iter().filter(|c| !c.is_adjacent && !c.is_always()).max_by_key(|c| c.touching);
            let name = |link: usize| robot.links()[link].name.clone();
            let pair = worst.map_or_else(
                || "the ground".to_owned(),
                |c| format!("{} with {} ({} %)", name(c.links.0), name(c.links.1), c.touching / 10),
            );
            return Err(SetupError::NeverFree { file, pair });
        };
        written.start = by_name(&robot, &start.q);
        choices.push(Choice::new(
            "start",
            start.q.iter().map(|value| format!("{value:.3}")).collect::<Vec<_>>().join(", "),
            &start.why,
            "`start` in robot.yaml",
        ));
        let robot = load(&text, &written)?;
        let text =
            RobotFiles::of_text(text.text().to_owned(), &urdf.with_extension("urdf"), &options.packages)?;
        let mut files = text.contents;
        written.notes = choices.iter().map(Choice::line).collect();
        files.extend(written.files());
        Ok(Self { name: stem, robot, files, choices, contacts })
    }

    /// Writes its files into a folder that is made.
    ///
    /// # Errors
    /// [`ScenarioError`](cranny_scenario::ScenarioError) for one that is there already or cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), SetupError> {
        Ok(write_whole_folder(folder, |folder| robot_folder::write(folder, &self.files))?)
    }
}

fn read_text(path: &Path) -> Result<String, RobotError> {
    let unreadable = |reason| RobotError::Unreadable { path: path.to_owned(), reason };
    cranny_file::TEXT.argument().text(path).map_err(unreadable)
}

/// The text of a URDF, expanded if it is a xacro file, and what errors call it.
fn read(urdf: &Path, choices: &mut Vec<Choice>) -> Result<(UrdfText, String), SetupError> {
    let file = urdf.display().to_string();
    let is_xacro = urdf.extension().is_some_and(|ending| ending == "xacro");
    let plain = if is_xacro { None } else { Some(UrdfText::new(read_text(urdf)?, &file)) };
    match plain {
        Some(Err(RobotError::Xacro { .. })) | None => {
            let text = UrdfText::new(xacro::expand(urdf)?, &file)?;
            choices.push(Choice::new("file", "a xacro file", "expanded by Python's xacro", "give a URDF"));
            Ok((text, file))
        }
        Some(text) => Ok((text?, file)),
    }
}

fn named_link(anatomy: &Anatomy, file: &str, name: &str) -> Result<usize, SetupError> {
    let known = || anatomy.robot.links().iter().map(|link| link.name.as_str()).collect::<Vec<_>>().join(", ");
    anatomy.robot.link_index(name).ok_or_else(|| SetupError::NotThere {
        file: file.to_owned(),
        what: format!("there is no link {name}; it has {}", cranny_file::excerpt(&known())),
    })
}

/// That something moves.
fn check_ranges(file: &str, anatomy: &Anatomy) -> Result<(), SetupError> {
    let limits = anatomy.robot.limits().iter().zip(anatomy.robot.joint_names());
    let stuck: Vec<&str> = limits
        .clone()
        .filter(|(limits, _)| limits.upper <= limits.lower)
        .map(|(_, name)| name.as_str())
        .collect();
    if !stuck.is_empty() && 2 * stuck.len() > limits.count() {
        return Err(SetupError::NoRange { file: file.to_owned(), joints: stuck.join(", ") });
    }
    Ok(())
}

fn fixed(name: &str) -> MountingJoint {
    MountingJoint { name: name.to_owned(), kind: "fixed", mount_from_carried: Pose::identity() }
}

/// Where a tool goes: a bare link with a flange's name on the last body of the longest chain, else its last link.
fn flange(anatomy: &Anatomy) -> Option<usize> {
    let depth = |body: &usize| anatomy.joints_of(*body).count();
    let body = (0..anatomy.bodies.len()).max_by_key(depth)?;
    let links = &anatomy.bodies[body].links;
    let named = ["tool0", "flange", "tool", "tcp", "ee", "end_effector"];
    let find = |word: &&str| {
        let word: &str = word;
        links.iter().copied().find(|&link| {
            let name = anatomy.link_name(link).to_lowercase();
            name.split('_').any(|part| part == word) || name.ends_with(word)
        })
    };
    named.iter().find_map(find).or_else(|| links.last().copied())
}

/// Whether enough joints lead there to speak of an arm.
fn is_on_arm(anatomy: &Anatomy, link: usize) -> bool {
    const FEWEST: usize = 3;
    anatomy.joints_of(anatomy.body_of[link]).count() >= FEWEST
}

/// The hand that was found, its frame made a link of the URDF.
fn describe(
    anatomy: &Anatomy,
    guess: &HandGuess,
    tip: Option<usize>,
    text: &mut UrdfText,
    choices: &mut Vec<Choice>,
) -> Result<HandDescription, SetupError> {
    let palm = anatomy.link_name(guess.palm).to_owned();
    let joints: Vec<String> = guess
        .fingers
        .iter()
        .map(|(name, range)| format!("{name} {:.3} to {:.3}", range.open, range.closed))
        .collect();
    let others = guess.others.iter().map(|&link| anatomy.link_name(link)).collect::<Vec<_>>();
    let others =
        if others.is_empty() { String::new() } else { format!(" (also found: {})", others.join(", ")) };
    let (what, why) = match guess.kind {
        HandKind::Fingers => {
            (format!("on {palm}, closed by {}", joints.join(", ")), "fingers move on both sides of it")
        }
        HandKind::Jaw => (
            format!("on {palm}, closed by {}", joints.join(", ")),
            "one jaw moves towards one that is part of it",
        ),
        HandKind::Rigid => (
            format!(
                "two prongs on {palm} that do not come together: grasps can be reached, but not closed on"
            ),
            "no joint moves them towards each other",
        ),
    };
    choices.push(Choice::new("hand", what + &others, why, "--palm LINK, or `hand` in robot.yaml"));
    let name = match (tip, guess.existing) {
        (Some(tip), _) => {
            let name = anatomy.link_name(tip).to_owned();
            choices.push(Choice::new("gripper frame", name.clone(), "as told", "--tip LINK"));
            name
        }
        (None, Some(link)) => {
            let name = anatomy.link_name(link).to_owned();
            let why =
                "a bare link between the pads, y the axis on which they close, z the approach direction";
            choices.push(Choice::new(
                "gripper frame",
                name.clone(),
                why,
                "--tip LINK, or `tip` in robot.yaml",
            ));
            name
        }
        (None, None) => {
            let name = free_name(anatomy, "grasp_frame");
            *text = text.with_frame(&name, &palm, &guess.palm_from_frame)?;
            let [x, y, z] = guess.palm_from_frame.translation.vector.map(|length| length * 1000.0).into();
            choices.push(Choice::new(
                "gripper frame",
                format!("{name}, a new link at ({x:.1}, {y:.1}, {z:.1}) mm on {palm}"),
                "between the pads, y the axis on which they close, z the approach direction",
                "--tip LINK, or `tip` in robot.yaml",
            ));
            name
        }
    };
    let mut figures = format!(
        "{:.1} mm between the open pads, {:.1} mm from the frame back to the palm",
        guess.opening_m * 1000.0,
        guess.finger_depth_m * 1000.0
    );
    let force_n = guess.force_n.unwrap_or(DEFAULT_FORCE_N);
    figures += &format!(", closing with {force_n:.0} N");
    let why = if guess.force_n.is_some() {
        "measured on its collision geometry; the force is its drives'"
    } else {
        "measured on its collision geometry; the force is a default"
    };
    choices.push(Choice::new("grip", figures, why, "`hand` in robot.yaml"));
    let rounded = |length: f64| (length * 1e5).round() / 1e5;
    Ok(HandDescription {
        name: palm,
        tip: Some(name),
        fingers: guess.fingers.clone(),
        opening_m: rounded(guess.opening_m),
        finger_depth_m: rounded(guess.finger_depth_m).max(1e-5),
        closing_force_n: force_n,
    })
}

/// A name that no link has.
fn free_name(anatomy: &Anatomy, name: &str) -> String {
    let numbered = (2..).map(|number: u32| format!("{name}_{number}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    names.find(|name| anatomy.robot.link_index(name).is_none()).unwrap_or_default()
}

/// The same on a base that moves.
fn on_base(text: &UrdfText, base: Base) -> Result<UrdfText, SetupError> {
    let name = text.robot_name()?.replace(['<', '&', '"'], "_");
    let ground = format!("<robot name=\"{name}\">\n  <link name=\"{BASE_LINK}\"/>\n</robot>\n");
    let kind = if base == Base::Planar { "planar" } else { "floating" };
    let joint = MountingJoint { kind, ..fixed(BASE_JOINT) };
    Ok(UrdfText::new(ground, text.file())?.carrying(BASE_LINK, text, &joint)?)
}

fn describe_base(anatomy: &Anatomy, base: Base, is_alone: bool, choices: &mut Vec<Choice>) {
    let (what, why, otherwise) = match base {
        Base::Floating => (
            "flies: floating joint under its root (x, y, z, yaw, pitch, roll)".to_owned(),
            if is_alone { "a hand without an arm" } else { "as told" },
            "give the URDF of the whole robot",
        ),
        Base::Planar => {
            ("drives: planar joint under its root (x, y, theta)".to_owned(), "as told", "--base own")
        }
        Base::Own => {
            let slides = anatomy.robot.joints().iter().filter(|joint| joint.kind == JointKind::Prismatic);
            let first = slides.take_while(|joint| anatomy.body_of[joint.child_link] > 0).next();
            let drives = first.is_some_and(|joint| {
                let links = anatomy.robot.links();
                let above = links[joint.child_link].parent.unwrap_or(0);
                anatomy.robot.ancestors(above).is_empty() && links[above].collisions.is_empty()
            });
            match (drives, anatomy.wheels()) {
                (true, _) => {
                    ("its own joints move its base".to_owned(), "they come first in it", "limits.yaml")
                }
                (false, 0) => ("fixed".to_owned(), "no joint moves its root", "--base planar lets it drive"),
                (false, wheels) => (
                    format!("fixed, though it has {wheels} wheels"),
                    "no joint of the URDF moves its root",
                    "--base planar lets it drive, as x, y and heading",
                ),
            }
        }
    };
    choices.push(Choice::new("base", what, why, otherwise));
}

/// Where the ground is on which a robot stands: at the lowest point of what carries its arm.
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
    // What stands on it does not touch it either.
    if floor.is_finite() { (floor * 1e4).floor() / 1e4 - 1e-4 } else { 0.0 }
}

/// Its named states that say where all joints of the group stand.
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
