use std::sync::OnceLock;

use cranny_file::did_you_mean;
use cranny_shape::TriangleSoup;
use cranny_spatial::{Point, Pose, Vector};

use crate::description::xml::Element;
use crate::mjcf::body_reader::BodyReader;
use crate::mjcf::defaults::Attributes;
use crate::model_file::body_tree::{ContactMask, Look, TreeShape};
use crate::model_file::orientation::rotation_from_z;
use crate::model_file::unread_list::not_supported;
use crate::{LinkForm, RobotError};

/// Attributes of `<geom>` that are read.
const READ: [&str; 18] = [
    "name",
    "class",
    "type",
    "contype",
    "conaffinity",
    "group",
    "size",
    "material",
    "rgba",
    "fromto",
    "pos",
    "quat",
    "axisangle",
    "xyaxes",
    "zaxis",
    "euler",
    "mesh",
    "hfield",
];

/// Attributes of `<geom>` that affect forces and inertia alone.
const IGNORED: [&str; 15] = [
    "condim",
    "priority",
    "friction",
    "mass",
    "density",
    "shellinertia",
    "solmix",
    "solref",
    "solimp",
    "margin",
    "gap",
    "fitscale",
    "fluidshape",
    "fluidcoef",
    "user",
];

/// Greatest group that `MuJoCo` draws by default; collision geometry is often in a higher one.
const LAST_DRAWN_GROUP: f64 = 2.0;

/// Divisions of the icosahedron that represents an ellipsoid: 642 points.
const ELLIPSOID_DIVISIONS: u32 = 3;

/// A geom of a body.
pub(crate) enum Geom {
    Shape(TreeShape),
    /// A plane with its pose in the body, if it collides.
    Plane(Option<Pose>),
    /// A geom that neither collides nor is drawn.
    Nothing,
}

impl<'d> BodyReader<'d, '_> {
    pub(crate) fn geom(
        &mut self,
        element: Element<'d>,
        childclass: Option<&str>,
    ) -> Result<Geom, RobotError> {
        self.unread.check_attributes(element, &READ, &IGNORED)?;
        if let Some(plugin) = self.documents.children(element).first() {
            return Err(not_supported(*plugin, "a <plugin>", "give a mesh"));
        }
        let attributes = self.classes.of(element, childclass)?;
        let mask = ContactMask {
            own: attributes.bits("contype")?,
            others: attributes.bits("conaffinity")?,
            pair: element.optional_text("name").and_then(|name| self.pair_groups.get(name).copied()),
        };
        let colour = match (attributes.numbers("rgba")?, attributes.text("material")) {
            (None, Some(material)) => self.assets.colours.get(material).copied(),
            (own, _) => own,
        };
        let [group] = attributes.numbers("group")?.unwrap_or_default();
        let is_drawn = group <= LAST_DRAWN_GROUP && colour.is_none_or(|[_, _, _, opacity]| opacity > 0.0);
        if mask.is_empty() && !is_drawn {
            return Ok(Geom::Nothing);
        }
        let kind = attributes.text("type").unwrap_or("sphere");
        if matches!(kind, "hfield" | "sdf") || kind != "mesh" && attributes.text("mesh").is_some() {
            let what = match kind {
                "hfield" => "a geom that is a height field",
                "sdf" => "a geom that is a signed distance field",
                _ => "a primitive fitted to a mesh",
            };
            if mask.is_empty() {
                self.unread.note(format!("{}: {what} is not drawn", element.at()));
                return Ok(Geom::Nothing);
            }
            return Err(not_supported(element, what, "give boxes or a mesh"));
        }
        if kind == "plane" {
            let pose = self.compiler.pose(&attributes)?;
            return Ok(Geom::Plane((!mask.is_empty()).then_some(pose)));
        }
        let (body_from_shape, form) = self.form(kind, &attributes)?;
        let look = is_drawn.then_some(Look { colour });
        Ok(Geom::Shape(TreeShape { body_from_shape, form, contacts: mask, look }))
    }

    /// Returns pose and shape of a geom (XML reference, geom: type, size, fromto).
    fn form(&self, kind: &str, attributes: &Attributes<'d>) -> Result<(Pose, LinkForm), RobotError> {
        let element = attributes.element();
        let pose = self.compiler.pose(attributes)?;
        let size = attributes.overlaid("size")?;
        if kind == "mesh" {
            let holder = attributes.text("mesh");
            let name = holder.map_or_else(|| element.text("mesh"), Ok)?;
            let mesh = self.assets.meshes.get(name).ok_or_else(|| {
                let known = self.assets.meshes.keys().map(String::as_str);
                let what = format!("the unknown mesh `{name}`{}", did_you_mean(name, known));
                not_supported(element, what, "name one of <asset>")
            })?;
            return Ok((pose * mesh.geom_from_mesh, mesh.form.clone()));
        }
        let (pose, size) = match attributes.numbers::<6>("fromto")? {
            Some(ends) if kind != "sphere" => from_to(element, kind, ends, size)?,
            _ => (pose, size),
        };
        let [x, y, z] = size;
        let form = match kind {
            "sphere" => LinkForm::Sphere { radius_m: x },
            "capsule" => LinkForm::Capsule { radius_m: x, length_m: 2.0 * y },
            "cylinder" => LinkForm::Cylinder { radius_m: x, length_m: 2.0 * y },
            "box" => LinkForm::Cuboid { size: 2.0 * Vector::new(x, y, z) },
            "ellipsoid" => ellipsoid(Vector::new(x, y, z)),
            _ => return Err(not_supported(element, format!("the geom type `{kind}`"), "give a mesh")),
        };
        let counted = if kind == "sphere" {
            1
        } else if matches!(kind, "box" | "ellipsoid") {
            3
        } else {
            2
        };
        if size[..counted].iter().any(|length| *length <= 0.0) {
            let (at, element) = (element.at(), element.title());
            let value = size[..counted].iter().copied().fold(f64::INFINITY, f64::min);
            return Err(RobotError::NotPositive { at, element, attribute: "size", value });
        }
        Ok((pose, form))
    }
}

/// Returns pose and size of a geom between two points; z leads from the second to the first, as in `MuJoCo` 3.17 (its reference
/// states the opposite). Only a box shows the difference.
fn from_to(
    element: Element<'_>,
    kind: &str,
    [a, b, c, d, e, f]: [f64; 6],
    [width, ..]: [f64; 3],
) -> Result<(Pose, [f64; 3]), RobotError> {
    let (from, to) = (Vector::new(a, b, c), Vector::new(d, e, f));
    let rotation = rotation_from_z(from - to)
        .ok_or_else(|| not_supported(element, "a `fromto` of length 0", "give two points"))?;
    let half_length = 0.5 * (to - from).norm();
    let size = match kind {
        "box" | "ellipsoid" => [width, width, half_length],
        _ => [width, half_length, 0.0],
    };
    Ok((Pose::from_parts((0.5 * (from + to)).into(), rotation), size))
}

/// Returns the hull of points around an ellipsoid: it contains the ellipsoid, and exceeds it by at most 0.5 % of its radii.
pub(crate) fn ellipsoid(radii: Vector) -> LinkForm {
    static POINTS: OnceLock<Vec<Point>> = OnceLock::new();
    let points = POINTS.get_or_init(|| {
        let sphere = TriangleSoup::geodesic_sphere(1.0, ELLIPSOID_DIVISIONS);
        let distance = |triangle: usize| {
            let [a, b, c] = sphere.corners(triangle);
            (b - a).cross(&(c - a)).normalize().dot(&a.coords).abs()
        };
        let inner = (0..sphere.triangles.len()).map(distance).fold(1.0, f64::min);
        sphere.vertices.iter().map(|vertex| (vertex.coords / inner).into()).collect()
    });
    let scaled = |point: &Point| Point::from(point.coords.component_mul(&radii));
    LinkForm::Hull { points: points.iter().map(scaled).collect() }
}
