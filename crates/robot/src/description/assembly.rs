use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use cranny_shape::{ShapeError, Solid, TriangleSoup, mesh_colour};
use cranny_spatial::{Pose, Vector};

use crate::chain::coupled_limits::coupled_limits;
use crate::chain::derived::Derived;
use crate::chain::full_turn::{endless, full_turns};
use crate::chain::joint_group::{Resolved, unknown_joint};
use crate::chain::joint_reach::joint_reaches;
use crate::chain::joint_step::{Motion, Step, Value};
use crate::chain::kinematics::LinkFrames;
use crate::description::planning_limits::PlanningLimits;
use crate::description::rate_limits::parse_rate_limits;
use crate::description::robot_description::{DESCRIPTION, LIMITS};
use crate::description::text_source::{parsed, read};
use crate::description::urdf_model::{Urdf, UrdfCollision, UrdfJoint, UrdfJointKind, UrdfLink};
use crate::gripper::hand::hand_links;
use crate::link_pairs::{adjacent_pairs, declared_pairs};
use crate::tree::Tree;
use crate::{
    GroupJoint, JointGroup, JointKind, Link, LinkForm, LinkShape, LinkVisual, MeshUse, ModelText, ModelUse,
    Mover, Robot, RobotDescription, RobotError, RobotHand, RobotOptions, Srdf, TextSource,
    description::mesh_path,
};

impl Robot {
    /// Loads a robot from the URDF, MJCF or SDF file at `path`, with the SRDF, the `limits.yaml` and the `robot.yaml` beside it unless
    /// `options` gives others.
    ///
    /// # Errors
    /// Any fault of the files or the options: see [`RobotError`].
    pub fn load(path: &Path, options: &RobotOptions) -> Result<Self, RobotError> {
        UrdfFile::read(path)?.robot(options)
    }

    /// Builds a robot from the text of a URDF. `source_name` is its name in errors; mesh names are relative to `base_dir`.
    ///
    /// # Errors
    /// As [`load`](Self::load); a mesh named relative to the URDF is not found if `base_dir` is `None`.
    pub fn from_urdf_text(
        text: &str,
        source_name: &str,
        base_dir: Option<&Path>,
        options: &RobotOptions,
    ) -> Result<Self, RobotError> {
        // 1. The files are read and checked against each other.
        let mut urdf = Urdf::parse(text, source_name)?;
        let tree = Tree::of(&urdf)?;
        let srdf = parsed(options.srdf.as_ref(), Srdf::parse)?;
        let rates = parsed(options.limits.as_ref(), parse_rate_limits)?.unwrap_or_default();
        let planning = parsed(options.joint_limits.as_ref(), PlanningLimits::parse)?.unwrap_or_default();
        for (name, rate) in planning.joints.iter().chain(&rates) {
            match tree.joint(name) {
                Some(joint) => rate.narrow(&mut urdf.joints[joint])?,
                None if srdf.as_ref().is_some_and(|srdf| srdf.virtual_joint(name).is_some()) => {}
                None => return Err(unknown_joint(&urdf, rate.at().to_string(), name)),
            }
        }
        // A range can be narrowed by either file; the rates of `joint_limits.yaml` take precedence.
        for (name, rate) in &planning.joints {
            if let Some(motion) = tree.joint(name).and_then(|joint| urdf.joints[joint].motion.as_mut()) {
                rate.set_rates(&mut motion.limits);
            }
        }
        let scales = planning.scales(options.rate_scales);
        let is_own_group = options.group == JointGroup::RootToTip;
        let (options, description) = &options.with_open_hands(&urdf, &tree, srdf.as_ref())?;
        // 2. The group is resolved: the joints that move, and their motion.
        let resolved = Resolved::new(&urdf, &tree, srdf.as_ref(), options)?;
        let (movers, steps, rest) = motions(&urdf, &tree, &resolved);
        // 3. The solids of the links are built.
        let solids = SolidSource::new(base_dir, options);
        let mut links = Vec::with_capacity(tree.nodes.len());
        for node in &tree.nodes {
            let link = &urdf.links[node.link];
            let collisions = link
                .collisions
                .iter()
                .map(|collision| solids.shape(link, collision))
                .collect::<Result<_, _>>()?;
            links.push(Link {
                name: link.name.clone(),
                parent: node.above.map(|(above, _)| above),
                collisions,
                visuals: link.visuals.iter().map(|visual| solids.visual(visual)).collect(),
                inertial: link.inertial,
            });
        }
        let limits = coupled_limits(&urdf, &resolved, scales)?;
        let full_turns = full_turns(&limits, &movers);
        let on_way: Vec<usize> =
            std::iter::successors(Some(resolved.tip), |&node| tree.nodes[node].above.map(|(above, _)| above))
                .collect();
        let srdf = srdf.unwrap_or_default();
        let joints = group_joints(&urdf, &tree, &resolved.group);
        let joint_names: Vec<String> =
            resolved.group.iter().map(|&joint| urdf.joints[joint].name.clone()).collect();
        let start =
            description.as_ref().map(|own| own.start_of(&joint_names, &limits, is_own_group)).transpose()?;
        let group_states = group_states(&urdf, &tree, &srdf, &resolved.group)?;
        let pairs = declared_pairs(&urdf, &tree, &srdf, options)?;
        let values = urdf.joints.iter().map(|joint| joint.name.clone()).zip(resolved.values).collect();
        let robot = Self {
            name: urdf.name.clone(),
            notes: [&urdf.notes[..], &srdf.notes, &resolved.notes].concat(),
            links_by_name: links.iter().enumerate().map(|(index, link)| (link.name.clone(), index)).collect(),
            adjacent_pairs: adjacent_pairs(&links, &movers, &pairs.checked),
            disabled_pairs: pairs.disabled,
            values,
            virtual_joints: srdf.virtual_joints,
            passive_joints: srdf.passive_joints,
            group_states,
            joint_names,
            joint_reaches: joint_reaches(&joints, &links, &movers, &rest),
            joints,
            endless: endless(resolved.group.iter().map(|&joint| &urdf.joints[joint]), &full_turns),
            full_turns,
            limits,
            hand_links: hand_links(&links, &movers, resolved.tip),
            hand: RobotHand::of(&urdf, &tree, options, (&links, &rest, resolved.tip)),
            tool: description.as_ref().and_then(|description| description.tool.clone()),
            start: start.flatten(),
            floor_m: description.as_ref().and_then(|description| description.floor_m),
            tip: resolved.tip,
            tip_steps: steps.iter().filter(|step| on_way.contains(&step.link)).cloned().collect(),
            links,
            movers,
            steps,
            rest,
            loose: None,
            derived: Derived::default(),
        };
        robot.check_steadiness(source_name)?;
        Ok(robot)
    }
}

/// URDF, MJCF or SDF as read from a file, for building several robots from it; a pipe can be read only once.
#[derive(Clone, Debug)]
pub struct UrdfFile {
    path: PathBuf,
    text: String,
}

impl UrdfFile {
    /// Reads the file at `path`, or the URDF named in the `robot.yaml` of the folder at `path`.
    ///
    /// # Errors
    /// [`RobotError::Unreadable`], or [`RobotError::NoDescription`] for a folder without a robot.
    pub fn read(path: &Path) -> Result<Self, RobotError> {
        let path = RobotDescription::urdf_at(path)?;
        Ok(Self { text: read(cranny_file::TEXT, &path)?, path })
    }

    /// Path of the URDF.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the name of the robot.
    ///
    /// # Errors
    /// [`RobotError`] for a malformed URDF.
    pub fn robot_name(&self) -> Result<String, RobotError> {
        Ok(Urdf::parse(&self.text, &self.path.display().to_string())?.name)
    }

    /// Builds a robot from it, as [`Robot::load`] does.
    ///
    /// # Errors
    /// As [`Robot::load`].
    pub fn robot(&self, options: &RobotOptions) -> Result<Robot, RobotError> {
        let path = &self.path;
        let model = ModelText::of(self.text.clone(), path, ModelUse::Robot, &options.packages)?;
        let beside = |file: PathBuf| file.is_file().then_some(TextSource::Path(file));
        let made = |what: &str, text: &Option<String>| {
            let name = format!("{what} of {}", path.display());
            text.clone().map(|text| TextSource::Text { name, text })
        };
        let mut options = options.clone();
        options.srdf = options
            .srdf
            .or_else(|| beside(path.with_extension("srdf")))
            .or_else(|| made("contact pairs", &model.srdf));
        options.limits = options
            .limits
            .or_else(|| beside(path.with_file_name(LIMITS)))
            .or_else(|| made("speeds", &model.limits));
        options.description = options.description.or_else(|| beside(path.with_file_name(DESCRIPTION)));
        let robot = Robot::from_urdf_text(&model.urdf, &model.name_of(path), path.parent(), &options)?;
        Ok(robot.with_notes(model.notes))
    }
}

fn group_joints(urdf: &Urdf, tree: &Tree, group: &[usize]) -> Vec<GroupJoint> {
    let describe = |&joint: &usize| {
        let described = &urdf.joints[joint];
        let motion = described.motion.as_ref()?;
        Some(GroupJoint {
            name: described.name.clone(),
            kind: motion.kind.into(),
            child_link: tree.node_of_joint[joint],
            axis_in_child: motion.axis_in_child,
            effort: motion.limits.effort,
        })
    };
    group.iter().filter_map(describe).collect()
}

impl From<UrdfJointKind> for JointKind {
    fn from(kind: UrdfJointKind) -> Self {
        match kind {
            UrdfJointKind::Revolute | UrdfJointKind::Continuous => Self::Revolute,
            UrdfJointKind::Prismatic => Self::Prismatic,
        }
    }
}

/// Returns the movers of each link, the forward kinematics of each moving link, and all poses at `q = 0`.
pub(crate) fn motions(
    urdf: &Urdf,
    tree: &Tree,
    resolved: &Resolved,
) -> (Vec<Vec<Mover>>, Vec<Step>, Vec<Pose>) {
    let mut movers: Vec<Vec<Mover>> = vec![Vec::new()];
    let mut rest = LinkFrames { root_from_link: vec![Pose::identity(); tree.nodes.len()], loose: Vec::new() };
    let mut steps = Vec::new();
    let at_zero = vec![0.0; resolved.group.len()];
    for (link, node) in tree.nodes.iter().enumerate() {
        let Some((parent, joint)) = node.above else { continue };
        let described = &urdf.joints[joint];
        let mut above = movers[parent].clone();
        let motion = joint_motion(described, resolved, joint, link, &mut above);
        let step = Step { link, parent, motion };
        rest.root_from_link[link] = step.root_from_link(&rest.root_from_link[parent], &[], &at_zero);
        // Links that no joint of the group moves keep their pose at `q = 0`.
        if !above.is_empty() {
            steps.push(step);
        }
        movers.push(above);
    }
    (movers, steps, rest.root_from_link)
}

/// Returns the motion by which `joint` moves `link`; adds to `movers` if it depends on a joint of the group.
fn joint_motion(
    described: &UrdfJoint,
    resolved: &Resolved,
    joint: usize,
    link: usize,
    movers: &mut Vec<Mover>,
) -> Motion {
    let parent_from_joint = described.parent_from_joint;
    let Some(motion) = &described.motion else {
        return Motion::Rigid { parent_from_link: parent_from_joint };
    };
    let value = resolved.values[joint];
    let kind: JointKind = motion.kind.into();
    let build = |value: Value| match kind {
        JointKind::Revolute => Motion::turn(value, &parent_from_joint, &motion.axis_in_child),
        JointKind::Prismatic => Motion::slide(value, &parent_from_joint, &motion.axis_in_child),
    };
    if let Some((joint, multiplier)) = value.follows {
        let axis_in_child = motion.axis_in_child;
        movers.push(Mover { joint, multiplier, kind, child_link: link, axis_in_child });
        return build(Value { joint, multiplier, offset: value.offset });
    }
    let held = build(Value { joint: 0, multiplier: 0.0, offset: value.offset });
    let step = Step { link, parent: 0, motion: held };
    Motion::Rigid { parent_from_link: step.root_from_link(&Pose::identity(), &[], &[0.0]) }
}

/// Context for reading the solids of links.
pub(crate) struct SolidSource<'a> {
    pub(crate) base_dir: Option<&'a Path>,
    pub(crate) options: &'a RobotOptions,
    /// Solids of mesh files that were read, with their triangles, by path, bits of the scale, and true for a solid instead of
    /// a hull: links that name the same file share them.
    known: RefCell<HashMap<MeshKey, (Solid, TriangleSoup)>>,
}

type MeshKey = (PathBuf, [u64; 3], bool);

impl<'a> SolidSource<'a> {
    pub(crate) fn new(base_dir: Option<&'a Path>, options: &'a RobotOptions) -> Self {
        Self { base_dir, options, known: RefCell::default() }
    }
}

impl SolidSource<'_> {
    pub(crate) fn shape(&self, link: &UrdfLink, collision: &UrdfCollision) -> Result<LinkShape, RobotError> {
        let mut soup = None;
        let solid = match &collision.form {
            LinkForm::Cuboid { size } => Solid::cuboid(size * 0.5),
            LinkForm::Sphere { radius_m } => Solid::sphere(*radius_m),
            LinkForm::Cylinder { length_m, radius_m } => Solid::cylinder(0.5 * length_m, *radius_m),
            LinkForm::Capsule { length_m, radius_m } => Solid::capsule(0.5 * length_m, *radius_m),
            LinkForm::Hull { points } => Solid::hull(points),
            LinkForm::Mesh { name, scale, .. } => {
                let path = self.find(link, collision, name)?;
                let is_solid =
                    self.options.meshes == MeshUse::Solid || self.options.solid_meshes.contains(&link.name);
                self.mesh(path, scale, is_solid).map(|(solid, triangles)| {
                    soup = Some(triangles);
                    solid
                })
            }
        };
        let solid = solid.map_err(|reason| RobotError::Shape {
            at: collision.at.clone(),
            link: link.name.clone(),
            reason: Box::new(reason),
        })?;
        Ok(LinkShape { link_from_shape: collision.link_from_shape, solid, soup })
    }

    fn mesh(
        &self,
        path: PathBuf,
        scale: &Vector,
        is_solid: bool,
    ) -> Result<(Solid, TriangleSoup), ShapeError> {
        let key = (path, [scale.x, scale.y, scale.z].map(f64::to_bits), is_solid);
        if let Some(known) = self.known.borrow().get(&key) {
            return Ok(known.clone());
        }
        let triangles = TriangleSoup::load(&key.0, *scale)?;
        let solid = if is_solid { Solid::mesh(&triangles) } else { Solid::hull(&triangles.vertices) };
        let read = (solid?, triangles);
        self.known.borrow_mut().insert(key, read.clone());
        Ok(read)
    }

    /// Returns the colour of a solid: that of the visual of the same shape and pose, else of the first visual with a colour, else of
    /// its mesh file.
    pub(crate) fn colour(&self, link: &UrdfLink, collision: &UrdfCollision) -> Option<[f64; 3]> {
        let is_same = |visual: &&LinkVisual| {
            visual.link_from_visual == collision.link_from_shape && visual.form == collision.form
        };
        let same = link.visuals.iter().find(is_same).and_then(|visual| visual.colour);
        let given = same.or_else(|| link.visuals.iter().find_map(|visual| visual.colour));
        if let Some([red, green, blue, _]) = given {
            return Some([red, green, blue].map(|channel| channel.clamp(0.0, 1.0)));
        }
        let LinkForm::Mesh { name, .. } = &collision.form else { return None };
        mesh_colour(&self.find(link, collision, name).ok()?)
    }

    fn visual(&self, visual: &LinkVisual) -> LinkVisual {
        let mut visual = visual.clone();
        if let LinkForm::Mesh { name, candidates, .. } = &mut visual.form {
            *candidates = mesh_path::candidates(name, self.base_dir, &self.options.packages);
        }
        visual
    }

    fn find(&self, link: &UrdfLink, collision: &UrdfCollision, mesh: &str) -> Result<PathBuf, RobotError> {
        let tried = mesh_path::candidates(mesh, self.base_dir, &self.options.packages);
        match tried.iter().find(|path| mesh_path::is_file_like(path)) {
            Some(path) => Ok(path.clone()),
            None => Err(RobotError::MeshNotFound {
                at: collision.at.clone(),
                link: link.name.clone(),
                mesh: mesh.to_owned(),
                tried,
            }),
        }
    }
}

/// Returns the states that name every joint of the group.
fn group_states(
    urdf: &Urdf,
    tree: &Tree,
    srdf: &Srdf,
    group: &[usize],
) -> Result<Vec<(String, Vec<f64>)>, RobotError> {
    let mut states = Vec::new();
    for state in &srdf.group_states {
        let mut values = HashMap::new();
        for (name, value) in &state.values {
            let place = || format!("{}: state `{}`", state.at, state.name);
            match tree.joint(name) {
                Some(joint) => drop(values.insert(joint, *value)),
                None if srdf.virtual_joint(name).is_some() => {}
                None => return Err(unknown_joint(urdf, place(), name)),
            }
        }
        let q: Option<Vec<f64>> = group.iter().map(|joint| values.get(joint).copied()).collect();
        states.extend(q.map(|q| (state.name.clone(), q)));
    }
    Ok(states)
}
