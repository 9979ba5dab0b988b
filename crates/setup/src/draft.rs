use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cranny_robot::{
    HandDescription, JointKind, ModelText, ModelUse, MountingJoint, Robot, RobotError, RobotOptions,
    TextSource, ToolDescription, UrdfText,
};
use cranny_scenario::MountedGripper;
use cranny_spatial::Pose;

use crate::anatomy::Anatomy;
use crate::choice::Choice;
use crate::hand::hand_guess::{DEFAULT_FORCE_N, HandGuess, HandKind};
use crate::hand::marks::marks;
use crate::hand::palm::jaw_links;
use crate::hand::tool_guess::ToolGuess;
use crate::robot_folder::Written;
use crate::setup_options::BASE_JOINT;
use crate::{Base, SetupError, SetupOptions, xacro};

const BASE_LINK: &str = "ground";

/// Draft of a robot setup: the URDF text to be written, and the choices made.
pub(crate) struct Draft<'a> {
    /// Name in errors.
    pub file: String,
    folder: PathBuf,
    options: &'a SetupOptions,
    pub text: UrdfText,
    /// SRDF of an MJCF or SDF model, and its content that is not read.
    pub model_srdf: Option<String>,
    notes: Vec<String>,
    anatomy: Anatomy,
    pub choices: Vec<Choice>,
    pub hand: Option<HandDescription>,
    pub tool: Option<ToolDescription>,
    /// Values of joints that stand still: those of the fingers of a tool.
    pub fixed: BTreeMap<String, f64>,
    /// Links whose meshes represent the solid they enclose.
    pub solid_meshes: Vec<String>,
    /// True if it is a hand without an arm.
    is_alone: bool,
}

impl<'a> Draft<'a> {
    pub fn read(urdf: &Path, options: &'a SetupOptions) -> Result<Self, SetupError> {
        let mut choices = Vec::new();
        let Source { text, file, srdf, notes } = read(urdf, options, &mut choices)?;
        let folder = urdf.parent().map_or_else(|| PathBuf::from("."), Path::to_owned);
        if text.joints()?.iter().all(|joint| joint.motion.is_none()) {
            return Err(SetupError::NoArm {
                file,
                tip: options.tip.clone(),
                joints: "nothing moves".to_owned(),
            });
        }
        let anatomy = Anatomy::of(&text, Some(&folder), &options.packages, &[])?;
        check_ranges(&file, &anatomy)?;
        Ok(Self {
            file,
            folder,
            options,
            text,
            model_srdf: srdf,
            notes,
            anatomy,
            choices,
            hand: None,
            tool: None,
            fixed: BTreeMap::new(),
            solid_meshes: Vec::new(),
            is_alone: false,
        })
    }

    fn look_again(&mut self) -> Result<(), SetupError> {
        let packages = &self.options.packages;
        self.anatomy = Anatomy::of(&self.text, Some(&self.folder), packages, &self.solid_meshes)?;
        Ok(())
    }

    /// Finds the hand or mounts one; returns the gripper that was mounted, if any.
    pub fn find_hand(&mut self) -> Result<Option<MountedGripper>, SetupError> {
        let link = |name: &Option<String>| {
            name.as_ref().map(|name| named_link(&self.anatomy, &self.file, name)).transpose()
        };
        let (palm, tip) = (link(&self.options.palm)?, link(&self.options.tip)?);
        if let Some(tool) = link(&self.options.tool)? {
            self.take_tool(tool, tip)?;
            return Ok(None);
        }
        let mut guess = HandGuess::of(&self.anatomy, palm);
        if self.leave_out_marks(guess.as_ref())? {
            guess = HandGuess::of(&self.anatomy, palm);
        }
        if guess.is_none() && self.open_mouth(palm) {
            guess = HandGuess::of(&self.anatomy, palm);
        }
        match guess {
            Some(guess) => {
                self.is_alone = self.anatomy.joints_of(self.anatomy.body_of[guess.palm]).next().is_none();
                self.hand = Some(describe(&self.anatomy, &guess, tip, &mut self.text, &mut self.choices)?);
                Ok(None)
            }
            None if palm.is_some() => {
                let what =
                    format!("link {} carries no fingers", self.options.palm.as_deref().unwrap_or_default());
                Err(SetupError::NotThere { file: self.file.clone(), what })
            }
            None if self.options.is_bare => Ok(None),
            None => self.mount_gripper(tip).map(Some),
        }
    }

    /// Takes a link as a tool, and adds its gripper frame as a link of the URDF.
    fn take_tool(&mut self, link: usize, tip: Option<usize>) -> Result<(), SetupError> {
        let name = self.anatomy.link_name(link).to_owned();
        let guess = ToolGuess::of(&self.anatomy, link).ok_or_else(|| SetupError::NotThere {
            file: self.file.clone(),
            what: format!("link {name} has no geometry that shows where a tool points"),
        })?;
        self.is_alone = self.anatomy.joints_of(self.anatomy.body_of[link]).next().is_none();
        let tip = guess.gripper_frame((&self.anatomy, link), tip, &mut self.text, &mut self.choices)?;
        self.tool = Some(ToolDescription { name, tip: Some(tip) });
        self.fixed = guess.open;
        Ok(())
    }

    /// Returns true if a jaw is found once the meshes of the jaw, and of the palm that is rigid with the other jaw, represent
    /// the solids they enclose: their hulls may fill the mouth between them.
    fn open_mouth(&mut self, palm: Option<usize>) -> bool {
        let Some(links) = jaw_links(&self.anatomy, palm) else { return false };
        let (folder, packages) = (Some(self.folder.as_path()), &self.options.packages);
        // Meshes that enclose no solid remain hulls.
        let Ok(anatomy) = Anatomy::of(&self.text, folder, packages, &links) else { return false };
        if HandGuess::of(&anatomy, palm).is_none_or(|guess| guess.kind != HandKind::Jaw) {
            return false;
        }
        self.choices.push(Choice::new(
            "solid meshes",
            links.join(", "),
            "the convex hulls of their meshes would fill the gap between the jaws",
            "`solid_meshes` in robot.yaml",
        ));
        (self.anatomy, self.solid_meshes) = (anatomy, links);
        true
    }

    /// Removes the geometry of links that are marks; returns true if there was any.
    fn leave_out_marks(&mut self, guess: Option<&HandGuess>) -> Result<bool, SetupError> {
        let marks = guess.map_or_else(Vec::new, |guess| marks(&self.anatomy, guess));
        for mark in &marks {
            let name = self.anatomy.link_name(*mark);
            self.text = self.text.without_body(name)?;
            self.choices.push(Choice::new(
                "left out",
                format!("the collision geometry of {name}"),
                "a tiny body between the pads that touches no other link is a marker, and every grasp would \
                 collide with it",
                "put it back in the URDF",
            ));
        }
        if !marks.is_empty() {
            self.look_again()?;
        }
        Ok(!marks.is_empty())
    }

    fn mount_gripper(&mut self, tip: Option<usize>) -> Result<MountedGripper, SetupError> {
        let flange = tip.or_else(|| flange(&self.anatomy)).filter(|flange| is_on_arm(&self.anatomy, *flange));
        let flange = flange.ok_or_else(|| self.no_arm())?;
        let gripper = MountedGripper::built_in()?;
        let name = self.anatomy.link_name(flange).to_owned();
        self.text = self.text.carrying(&name, &gripper.urdf, &fixed("gripper_mount"))?;
        self.look_again()?;
        self.hand = Some(gripper.hand.clone());
        self.choices.push(Choice::new(
            "hand",
            format!("none found: the built-in gripper ({}) is mounted on {name}", gripper.hand.name),
            "no link carries fingers that close towards each other",
            "--bare leaves the arm as it is; --tool LINK names a suction cup or the like; --palm LINK the link that carries \
             the fingers; --tip LINK the flange",
        ));
        Ok(gripper)
    }

    fn no_arm(&self) -> SetupError {
        let joints = self.anatomy.robot.joint_names().join(", ");
        SetupError::NoArm { file: self.file.clone(), tip: self.options.tip.clone(), joints }
    }

    /// Puts the robot on the requested base; a hand alone gets a floating one by default.
    pub fn put_on_base(&mut self) -> Result<Base, SetupError> {
        let base = self.options.base.unwrap_or(if self.is_alone { Base::Floating } else { Base::Own });
        if base == Base::Own && self.is_alone {
            return Err(self.no_arm());
        }
        if base != Base::Own {
            self.text = on_base(&self.text, base)?;
        }
        describe_base(&self.anatomy, base, self.is_alone, &mut self.choices);
        Ok(base)
    }

    /// Builds the robot as described by its future files.
    pub fn robot(&self, written: &Written) -> Result<Arc<Robot>, RobotError> {
        let named = |name: &str, text: String| Some(TextSource::Text { name: name.to_owned(), text });
        let options = RobotOptions {
            srdf: written.srdf.clone().and_then(|srdf| named(&format!("{}.srdf", written.stem), srdf)),
            limits: named("limits.yaml", written.limits.clone()),
            description: named("robot.yaml", written.description()),
            packages: self.options.packages.clone(),
            ..RobotOptions::default()
        };
        let robot = Robot::from_urdf_text(self.text.text(), &self.file, Some(&self.folder), &options)?;
        Ok(Arc::new(robot.with_notes(self.notes.clone())))
    }
}

pub(crate) fn read_text(path: &Path) -> Result<String, RobotError> {
    let unreadable = |reason| RobotError::Unreadable { path: path.to_owned(), reason };
    cranny_file::TEXT.text(path).map_err(unreadable)
}

/// Returns the robot name from a file name: `arm` for `arm.urdf` and `arm.urdf.xacro`.
pub fn robot_name(urdf: &Path) -> String {
    let name = urdf.file_name().unwrap_or_default().to_string_lossy();
    let plain = name.strip_suffix(".xacro").unwrap_or(&name);
    Path::new(plain).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// URDF of a robot, with its name in errors, and what an MJCF or SDF model has beyond it.
struct Source {
    text: UrdfText,
    file: String,
    srdf: Option<String>,
    notes: Vec<String>,
}

/// Reads the text of a URDF, expanded if it is a xacro file, or converted if it is an MJCF or SDF model.
fn read(urdf: &Path, options: &SetupOptions, choices: &mut Vec<Choice>) -> Result<Source, SetupError> {
    let file = urdf.display().to_string();
    let bare = |text, file| Source { text, file, srdf: None, notes: Vec::new() };
    let is_xacro = urdf.extension().is_some_and(|ending| ending == "xacro");
    let model = if is_xacro {
        None
    } else {
        Some(ModelText::of(read_text(urdf)?, urdf, ModelUse::Robot, &options.packages)?)
    };
    let plain = model.as_ref().map(|model| UrdfText::new(model.urdf.clone(), &model.name_of(urdf)));
    match plain {
        Some(Err(RobotError::Xacro { .. })) | None => {
            let (text, warnings) = xacro::expand(urdf, options)?;
            let text = UrdfText::new(text, &file)?;
            let why = match &*warnings {
                "" => "expanded by Python's xacro".to_owned(),
                warnings => format!("expanded by Python's xacro, which warns: {warnings}"),
            };
            choices.push(Choice::new("file", "a xacro file", &why, "give a URDF"));
            Ok(bare(text, file))
        }
        Some(_) if !options.xacro.is_empty() => Err(SetupError::NotThere {
            file,
            what: "arguments for xacro are given, but this is not a xacro file".to_owned(),
        }),
        Some(text) => {
            let (text, Some(model)) = (text?, model) else { return Err(RobotError::Empty { file }.into()) };
            if model.srdf.is_some() {
                let why = "its outermost element is that of MJCF or SDF; a link stands for each body";
                choices.push(Choice::new("file", "a model, converted to URDF", why, "give a URDF"));
            }
            let file = model.name_of(urdf);
            Ok(Source { text, file, srdf: model.srdf, notes: model.notes })
        }
    }
}

fn named_link(anatomy: &Anatomy, file: &str, name: &str) -> Result<usize, SetupError> {
    let known = || anatomy.robot.links().iter().map(|link| link.name.as_str()).collect::<Vec<_>>().join(", ");
    anatomy.robot.link_index(name).ok_or_else(|| SetupError::NotThere {
        file: file.to_owned(),
        what: format!("unknown link '{name}' (known: {})", cranny_file::excerpt(&known())),
    })
}

/// Checks that most joints have a range.
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

/// Returns the mounting link of a tool: a flange, by its name, at the end of the longest chain, else the last link there.
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

/// Returns true if enough joints move the link for its chain to be an arm.
fn is_on_arm(anatomy: &Anatomy, link: usize) -> bool {
    const FEWEST: usize = 3;
    anatomy.joints_of(anatomy.body_of[link]).count() >= FEWEST
}

/// Describes the hand that was found, and adds its frame as a link of the URDF.
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
            "one jaw moves towards a fixed jaw on that link",
        ),
        HandKind::Rigid => (
            format!("two rigid prongs on {palm}: grasps can be reached, but not closed"),
            "no joint moves them towards each other",
        ),
    };
    choices.push(Choice::new("hand", what + &others, why, "--palm LINK, or `hand` in robot.yaml"));
    let name = match (tip, guess.existing) {
        (Some(tip), _) => {
            let name = anatomy.link_name(tip).to_owned();
            choices.push(Choice::new("gripper frame", name.clone(), "as requested", "--tip LINK"));
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
            let name = anatomy.free_name("grasp_frame");
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
    let _ = write!(figures, ", closing with {force_n:.0} N");
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
        pads: None,
    })
}

/// Returns the robot on a mobile base.
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
            if is_alone { "a hand without an arm" } else { "as requested" },
            "give the URDF of the whole robot",
        ),
        Base::Planar => {
            ("drives: planar joint under its root (x, y, theta)".to_owned(), "as requested", "--base own")
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
                    ("its own joints move its base".to_owned(), "they are its first joints", "limits.yaml")
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
