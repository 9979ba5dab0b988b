//! MuJoCo model of a test: elements and parameters of its XML.
//!
//! The palm is a free body of large mass, whose pose and velocity the runner sets before every step. A mocap body is
//! unsuitable: it has no velocity, so contacts with its children have none either, and friction carries nothing (MuJoCo's
//! manual, "Modeling", section "MoCap bodies"). A weld to one would add a spring between the hand and its course.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use cranny_grasp::{LEAST_ARM_M, Pads};
use cranny_spatial::{Pose, Vector};

use crate::compliant_pads::{spring_stiffness, spring_tips};
use crate::gripper::FINGER_RADIUS_M;
use crate::shell::Shell;
use crate::{GraspTest, Physics, Piece, PieceShape};

/// Number of MuJoCo steps per [`Physics::step_s`]. The engine here solves the constraints of a step in as many substeps.
pub(crate) fn mujoco_steps(physics: &Physics) -> usize {
    2 * physics.solver_iterations
}

impl GraspTest {
    /// Exports the test as MJCF, MuJoCo's XML; lengths in metres, masses in kilograms, angles in radians.
    ///
    /// Its bodies are `palm`, `finger 1`, … and `object`, each with a joint of that name: the first and the last free, the
    /// others sliding from 0 (open) to the stroke. Each finger has a position actuator of its name, whose control is the target
    /// position of the finger, in metres. A finger with a pad carries its springs as bodies `tip 1.1`, …. The hand is at the origin of the planning frame: the runner of the model moves it to
    /// the grasp, and sets pose and velocity of the palm before every step. The object is at its resting pose.
    ///
    /// The greater of two friction coefficients in contact applies, in MuJoCo as here.
    pub fn mjcf(&self) -> String {
        let mut mjcf = Mjcf::default();
        for piece in &self.surroundings {
            mjcf.geom(4, "surroundings", piece);
        }
        mjcf.hand(self);
        mjcf.object(self);
        mjcf.text(self)
    }
}

/// Sections of the document under construction.
#[derive(Default)]
struct Mjcf {
    meshes: String,
    mesh_count: usize,
    bodies: String,
    couplings: String,
    drives: String,
}

impl Mjcf {
    fn text(&self, test: &GraspTest) -> String {
        let Physics { gravity, up, step_s, rolling_m, .. } = test.physics;
        let timestep_s = step_s / mujoco_steps(&test.physics) as f64;
        let ContactReference { time_constant_s, damping_ratio, impedance } =
            ContactReference::new(&test.physics, timestep_s);
        let friction = test.object.friction.low;
        // The springs of a pad resist torsion together; other fingers need a patch at each contact.
        let (object_dimensions, torsional_friction_m) =
            if test.hand.pads.is_some() { (3, 0.0) } else { (4, friction * LEAST_ARM_M) };
        format!(
            r#"<mujoco model="grasp test">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="{timestep_s}" gravity="{down}" integrator="implicitfast" solver="Newton" cone="elliptic" impratio="{IMPEDANCE_RATIO}" iterations="100" tolerance="1e-12"/>
  <default>
    <equality solref="{time_constant_s} 1" solimp="{IMPEDANCE}"/>
    <joint solreflimit="{time_constant_s} 1" solimplimit="{IMPEDANCE}"/>
    <geom solref="{time_constant_s} {damping_ratio}" solimp="{impedance} {impedance} 0.001"/>
    <default class="palm"><geom contype="1" conaffinity="0" condim="1" friction="0 0 0"/></default>
    <default class="finger"><geom contype="2" conaffinity="0" condim="1" friction="0 0 0"/></default>
    <default class="back"><geom contype="8" conaffinity="0" condim="1" friction="0 0 0"/></default>
    <default class="tip"><geom contype="16" conaffinity="0" condim="1" friction="0 0 0" solmix="1e6" solref="{rigid_s} 1" solimp="{IMPEDANCE}"/></default>
    <default class="surroundings"><geom contype="4" conaffinity="2" condim="6" friction="0 0 {rolling_m}"/></default>
    <default class="object">
      <geom contype="0" conaffinity="{of_object}" condim="{object_dimensions}" friction="{friction} {torsional_friction_m} 0"/>
      <default class="part"><geom conaffinity="4"/></default>
      <default class="shell"><geom conaffinity="{of_shell}"/></default>
    </default>
  </default>
  <asset>
{meshes}  </asset>
  <worldbody>
{bodies}  </worldbody>
  <equality>
{couplings}  </equality>
  <actuator>
{drives}  </actuator>
</mujoco>
"#,
            // The palm, surroundings, and either the fingers or their springs with what is behind these.
            of_object = if test.hand.pads.is_some() { 1 + 4 + 8 + 16 } else { 1 + 2 + 4 },
            of_shell = 1 + 8 + 16,
            // A tip is light, and contacts yield in proportion to mass.
            rigid_s = 2.0 * timestep_s,
            // Adding zero removes the sign of a zero.
            down = numbers((up * -gravity).map(|x| x + 0.0).as_slice()),
            meshes = self.meshes,
            bodies = self.bodies,
            couplings = self.couplings,
            drives = self.drives,
        )
    }

    fn hand(&mut self, test: &GraspTest) {
        let Physics { finger_inertia_kg, drive_stiffness, drive_damping, .. } = test.physics;
        let force_n = test.hand.closing_force_n;
        self.bodies += "    <body name=\"palm\" gravcomp=\"1\">\n      <freejoint name=\"palm\"/>\n";
        self.bodies += &inertial(&Vector::zeros(), PALM_KG, [PALM_KG * PALM_RADIUS_M.powi(2); 3], [0.0; 3]);
        for piece in &test.hand.palm {
            self.geom(6, "palm", piece);
        }
        let first_m = test.hand.fingers.first().map_or(1.0, |finger| finger.stroke_m);
        for (index, finger) in test.hand.fingers.iter().enumerate() {
            let (number, stroke_m) = (index + 1, finger.stroke_m);
            // The inertia of the drive counts along the joint alone, as in the gears of a gripper.
            let armature_kg = finger_inertia_kg - FINGER_KG;
            self.line(6, format_args!("<body name=\"finger {number}\" gravcomp=\"1\">"));
            let inertia = [FINGER_KG * FINGER_RADIUS_M.powi(2); 3];
            self.bodies += &inertial(&finger.center.coords, FINGER_KG, inertia, [0.0; 3]);
            self.line(8, format_args!(
                "<joint name=\"finger {number}\" type=\"slide\" axis=\"{}\" range=\"0 {stroke_m}\" armature=\"{armature_kg}\"/>",
                numbers(finger.axis.as_slice()),
            ));
            for piece in &finger.pieces {
                self.geom(8, "finger", piece);
            }
            if let Some(pads) = &test.hand.pads {
                self.pad(test, pads, index);
            }
            self.line(6, format_args!("</body>"));
            // All fingers move by equal shares of their strokes.
            if number > 1 {
                let ratio = stroke_m / first_m;
                let _ = writeln!(
                    self.couplings,
                    "    <joint joint1=\"finger {number}\" joint2=\"finger 1\" polycoef=\"0 {ratio} 0 0 0\"/>"
                );
            }
            let _ = writeln!(
                self.drives,
                "    <position name=\"finger {number}\" joint=\"finger {number}\" kp=\"{drive_stiffness}\" \
                 kv=\"{drive_damping}\" forcerange=\"-{force_n} {force_n}\"/>"
            );
        }
        self.line(4, format_args!("</body>"));
    }

    /// The pad of a finger: springs of spherical tips, and the finger behind them.
    fn pad(&mut self, test: &GraspTest, pads: &Pads, finger: usize) {
        let face_m = pads.faces_m[finger];
        for piece in &test.hand.fingers[finger].behind_springs {
            self.geom(8, "back", piece);
        }
        let timestep_s = test.physics.step_s / mujoco_steps(&test.physics) as f64;
        let stiffness = spring_stiffness(pads);
        let armature_kg = stiffness * (timestep_s / SPRING_PHASE).powi(2);
        let damping = 2.0 * (stiffness * armature_kg).sqrt();
        for (index, tip) in spring_tips(pads, face_m).into_iter().enumerate() {
            let center = tip.coords + Vector::y() * (face_m.signum() * TIP_M);
            self.line(
                8,
                format_args!(
                    "<body name=\"tip {}.{}\" pos=\"{}\" gravcomp=\"1\">",
                    finger + 1,
                    index + 1,
                    numbers(center.as_slice())
                ),
            );
            self.bodies += &inertial(&Vector::zeros(), TIP_KG, [TIP_KG * TIP_M.powi(2); 3], [0.0; 3]);
            self.line(10, format_args!(
                "<joint type=\"slide\" axis=\"0 1 0\" stiffness=\"{stiffness}\" damping=\"{damping}\" armature=\"{armature_kg}\"/>"
            ));
            self.line(10, format_args!("<geom class=\"tip\" type=\"sphere\" size=\"{TIP_M}\"/>"));
            self.line(8, format_args!("</body>"));
        }
    }

    fn object(&mut self, test: &GraspTest) {
        let object = &test.object;
        self.line(4, format_args!("<body name=\"object\" {}>", placed(test.world_from_object())));
        self.line(6, format_args!("<freejoint name=\"object\"/>"));
        let i = &object.inertia_kg_m2;
        let (diagonal, others) = ([i.m11, i.m22, i.m33], [i.m12, i.m13, i.m23]);
        self.bodies += &inertial(&object.center.coords, object.mass_kg, diagonal, others);
        let shell = object.shell.as_ref().filter(|_| test.hand.pads.is_some()).and_then(Shell::prisms);
        for piece in &object.pieces {
            self.geom(6, if shell.is_some() { "part" } else { "object" }, piece);
        }
        for prism in shell.iter().flatten() {
            self.geom(6, "shell", prism);
        }
        self.line(4, format_args!("</body>"));
    }

    fn geom(&mut self, indent: usize, class: &str, piece: &Piece) {
        let (kind, sizes): (&str, &[f64]) = match &piece.shape {
            PieceShape::Cuboid(half_extents) => ("box", half_extents),
            PieceShape::Ball(radius_m) => ("sphere", &[*radius_m]),
            PieceShape::Capsule(half_m, radius_m) => ("capsule", &[*radius_m, *half_m]),
            PieceShape::Cylinder(half_m, radius_m) => ("cylinder", &[*radius_m, *half_m]),
            // The plane is infinite; the third number is the spacing of a drawn grid.
            PieceShape::HalfSpace => ("plane", &[0.0, 0.0, 1.0]),
            PieceShape::Hull(hull) => {
                self.mesh_count += 1;
                let corners: Vec<f64> =
                    hull.vertices.iter().flat_map(|p| p.coords.into_iter().copied()).collect();
                let _ = writeln!(
                    self.meshes,
                    "    <mesh name=\"mesh {}\" vertex=\"{}\"/>",
                    self.mesh_count,
                    numbers(&corners)
                );
                ("mesh", &[])
            }
        };
        let shape = match &piece.shape {
            PieceShape::Hull(_) => format!("mesh=\"mesh {}\"", self.mesh_count),
            _ => format!("size=\"{}\"", numbers(sizes)),
        };
        let place = placed(&piece.body_from_piece);
        self.line(indent, format_args!("<geom class=\"{class}\" type=\"{kind}\" {shape} {place}/>"));
    }

    fn line(&mut self, indent: usize, line: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.bodies, "{:indent$}{line}", "");
    }
}

/// MuJoCo parameters of the spring and damper of a contact.
struct ContactReference {
    /// Time constant T, in seconds, and damping ratio ζ of `solref`.
    time_constant_s: f64,
    damping_ratio: f64,
    /// Impedance d of `solimp`, at any depth.
    impedance: f64,
}

impl ContactReference {
    /// Converts the spring and the damper of [`Physics`]: for a mass m they are m ω² and 2 m ζ' ω.
    ///
    /// MuJoCo's are m d/(1 − d) times k = 1/(d T² ζ²) and b = 2/(d T) (manual, "Computation", section "Parameters"). T cannot
    /// be less than two steps. With that, 1 − d = 1/(T ζ' ω) and ζ² = ζ'/(T ω) make both equal.
    fn new(physics: &Physics, timestep_s: f64) -> Self {
        let time_constant_s = 2.0 * timestep_s;
        let angular_frequency = TAU * physics.contact_frequency_hz;
        let softness = 1.0 / (time_constant_s * physics.contact_damping_ratio * angular_frequency);
        Self {
            time_constant_s,
            damping_ratio: (physics.contact_damping_ratio / (time_constant_s * angular_frequency)).sqrt(),
            impedance: (1.0 - softness).clamp(LEAST_IMPEDANCE, GREATEST_IMPEDANCE),
        }
    }
}

/// Range of impedances that MuJoCo accepts.
const LEAST_IMPEDANCE: f64 = 0.0001;
const GREATEST_IMPEDANCE: f64 = 0.9999;

fn inertial(center: &Vector, mass_kg: f64, diagonal: [f64; 3], others: [f64; 3]) -> String {
    let inertia = diagonal.into_iter().chain(others).collect::<Vec<_>>();
    format!(
        "      <inertial pos=\"{}\" mass=\"{mass_kg}\" fullinertia=\"{}\"/>\n",
        numbers(center.as_slice()),
        numbers(&inertia)
    )
}

fn placed(pose: &Pose) -> String {
    let q = pose.rotation.coords;
    format!(
        "pos=\"{}\" quat=\"{}\"",
        numbers(pose.translation.vector.as_slice()),
        numbers(&[q.w, q.x, q.y, q.z])
    )
}

fn numbers(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

/// Radius of the tip of a spring, in metres.
const TIP_M: f64 = 1.5e-3;
/// Mass of a tip, in kilograms: MuJoCo requires one.
const TIP_KG: f64 = 1e-5;
/// Angle by which a spring swings within a step, in radians: the integrator is explicit in it.
const SPRING_PHASE: f64 = 0.25;

/// Impedance of stroke limits and couplings (`solimp`): the share of a violating acceleration that their force removes.
const IMPEDANCE: &str = "0.99 0.999 0.0001";

/// Ratio of the impedances of friction and normal force. At 1, a gripped object creeps visibly below the limit of friction;
/// with this value it creeps by some micrometres per second.
const IMPEDANCE_RATIO: f64 = 1000.0;

/// Mass of a palm that nothing pushes away, in kilograms: finger forces move it by less than 1 µm in a step.
const PALM_KG: f64 = 1e4;

/// Radius of gyration of the palm, in metres.
const PALM_RADIUS_M: f64 = 0.3;

/// Mass of a finger, in kilograms: MuJoCo requires one, but a finger has only the inertia of its drive.
const FINGER_KG: f64 = 1e-3;
