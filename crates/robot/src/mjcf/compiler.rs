use cranny_spatial::{Pose, Rotation, Vector};

use crate::RobotError;
use crate::description::xml::Element;
use crate::mjcf::defaults::Attributes;
use crate::mjcf::documents::Documents;
use crate::model_file::orientation::{rotation_from_wxyz, rotation_from_z, rotation_of_axes, turn};
use crate::model_file::unread_list::{UnreadList, not_supported};

/// Attributes of `<compiler>` that affect textures, the solver and masses without a statement alone.
const IGNORED: [&str; 12] = [
    "texturedir",
    "discardvisual",
    "usethread",
    "fusestatic",
    "inertiagrouprange",
    "saveinertial",
    "alignfree",
    "convexhull",
    "exactmeshinertia",
    "conflict",
    "fitaabb",
    "name",
];

/// Attributes of `<compiler>` that are read.
const READ: [&str; 13] = [
    "angle",
    "eulerseq",
    "autolimits",
    "meshdir",
    "assetdir",
    "strippath",
    "coordinate",
    "class",
    MASSES[0].0,
    MASSES[1].0,
    MASSES[2].0,
    MASSES[3].0,
    MASSES[4].0,
];

/// Attributes of `<compiler>` that change stated masses or inertias, and their values that change none.
const MASSES: [(&str, &[&str]); 5] = [
    ("inertiafromgeom", &["false", "auto"]),
    ("settotalmass", &["-1"]),
    ("boundmass", &["0"]),
    ("boundinertia", &["0"]),
    ("balanceinertia", &["false"]),
];

/// Names of the attributes that give an orientation; at most one of them is given.
const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];

/// Masses and inertias of a model.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Masses {
    /// Those of `<inertial>`.
    Stated,
    /// Those that the compiler computes, which are not known.
    Computed,
}

/// Settings of the model compiler (XML reference, compiler). They apply to the whole model; the last value of the files counts.
pub(crate) struct Compiler {
    is_degree: bool,
    /// Axes of Euler angles, each with true if it turns with the frame.
    euler: [(Vector, bool); 3],
    pub(crate) finds_limits: bool,
    pub(crate) mesh_folder: String,
    pub(crate) strips_paths: bool,
    pub(crate) masses: Masses,
}

impl Compiler {
    pub(crate) fn read(documents: &Documents<'_>, unread: &mut UnreadList) -> Result<Self, RobotError> {
        let mut compiler = Self {
            is_degree: true,
            euler: [(Vector::x(), true), (Vector::y(), true), (Vector::z(), true)],
            finds_limits: true,
            mesh_folder: String::new(),
            strips_paths: false,
            masses: Masses::Stated,
        };
        let (mut assets, mut meshes) = (None, None);
        for element in documents.sections("compiler") {
            unread.check_attributes(element, &READ, &IGNORED)?;
            documents.children(element).into_iter().for_each(|child| unread.add(element, child));
            if let Some(angle) = element.optional_text("angle") {
                compiler.is_degree = match angle {
                    "degree" => true,
                    "radian" => false,
                    _ => {
                        return Err(not_supported(element, format!("angle=\"{angle}\""), "radian or degree"));
                    }
                };
            }
            if let Some(sequence) = element.optional_text("eulerseq") {
                compiler.euler = euler_axes(element, sequence)?;
            }
            for (attribute, harmless) in MASSES {
                let value = element.optional_text(attribute).map(str::trim);
                if let Some(value) = value.filter(|value| !harmless.contains(value)) {
                    compiler.masses = Masses::Computed;
                    let at = element.at();
                    unread.note(format!(
                        "{at}: {attribute}=\"{value}\" is not applied: all links count as without mass"
                    ));
                }
            }
            if element.optional_text("coordinate") == Some("global") {
                let hint = "MuJoCo refuses it too since version 2.3.3";
                return Err(not_supported(element, "coordinate=\"global\"", hint));
            }
            compiler.finds_limits = flag(element, "autolimits", compiler.finds_limits)?;
            compiler.strips_paths = flag(element, "strippath", compiler.strips_paths)?;
            assets = element.optional_text("assetdir").or(assets);
            meshes = element.optional_text("meshdir").or(meshes);
        }
        meshes.or(assets).unwrap_or_default().clone_into(&mut compiler.mesh_folder);
        Ok(compiler)
    }

    /// Returns an angle of the file in radians.
    pub(crate) fn radians(&self, angle: f64) -> f64 {
        if self.is_degree { angle.to_radians() } else { angle }
    }

    /// Returns the pose that `pos` and an orientation give.
    pub(crate) fn pose(&self, attributes: &Attributes<'_>) -> Result<Pose, RobotError> {
        let position = attributes.vector("pos")?.unwrap_or_default();
        Ok(Pose::from_parts(position.into(), self.rotation(attributes)?))
    }

    /// Returns the orientation of an element (XML reference, Frame orientations).
    fn rotation(&self, attributes: &Attributes<'_>) -> Result<Rotation, RobotError> {
        let Some((holder, given)) = attributes.nearest_of(&ORIENTATIONS) else {
            return Ok(Rotation::identity());
        };
        let more = ORIENTATIONS.iter().filter(|other| **other != given);
        if let Some(second) = more.copied().find(|other| holder.optional_text(other).is_some()) {
            return Err(not_supported(holder, format!("`{given}` beside `{second}`"), "give one of them"));
        }
        let rotation = match given {
            "quat" => holder.numbers("quat")?.and_then(rotation_from_wxyz),
            "axisangle" => holder.numbers("axisangle")?.and_then(|[x, y, z, angle]| {
                Some(turn(Vector::new(x, y, z).try_normalize(1e-10)?, self.radians(angle)))
            }),
            "euler" => holder.numbers("euler")?.map(|angles| self.euler(angles)),
            "xyaxes" => holder
                .numbers("xyaxes")?
                .and_then(|[a, b, c, d, e, f]| rotation_of_axes(Vector::new(a, b, c), Vector::new(d, e, f))),
            _ => holder.vector("zaxis")?.and_then(rotation_from_z),
        };
        rotation.ok_or_else(|| not_supported(holder, format!("`{given}` without a direction"), "give one"))
    }

    fn euler(&self, angles: [f64; 3]) -> Rotation {
        let mut rotation = Rotation::identity();
        for ((axis, turns_with_frame), angle) in self.euler.iter().zip(angles) {
            let step = turn(*axis, self.radians(angle));
            rotation = if *turns_with_frame { rotation * step } else { step * rotation };
        }
        rotation
    }
}

/// Returns the axes of a sequence such as `xyz`: lower case turns with the frame, upper case does not.
fn euler_axes(element: Element<'_>, sequence: &str) -> Result<[(Vector, bool); 3], RobotError> {
    let axis = |letter: char| match letter.to_ascii_lowercase() {
        'x' => Some(Vector::x()),
        'y' => Some(Vector::y()),
        'z' => Some(Vector::z()),
        _ => None,
    };
    let axes: Option<Vec<_>> =
        sequence.chars().map(|letter| Some((axis(letter)?, letter.is_ascii_lowercase()))).collect();
    axes.and_then(|axes| axes.try_into().ok()).ok_or_else(|| {
        not_supported(element, format!("eulerseq=\"{sequence}\""), "give three letters of xyz or XYZ")
    })
}

/// Returns a Boolean attribute.
pub(crate) fn flag(element: Element<'_>, name: &'static str, default: bool) -> Result<bool, RobotError> {
    match element.optional_text(name) {
        None => Ok(default),
        Some("true" | "1" | "enable") => Ok(true),
        Some("false" | "0" | "disable") => Ok(false),
        Some(other) => Err(not_supported(element, format!("{name}=\"{other}\""), "give true or false")),
    }
}
