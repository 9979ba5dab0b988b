use std::path::Path;

use cranny_spatial::{Pose, Vector};

use crate::description::xml::Element;
use crate::mjcf::geoms::ellipsoid;
use crate::model_file::orientation::rotation_from_z;
use crate::model_file::unread_list::not_supported;
use crate::sdf::includes::ModelFolders;
use crate::{LinkForm, RobotError};

/// Shape of a `<collision>` or `<visual>`.
pub(crate) enum SdfShape {
    Form(LinkForm),
    /// Half-space, and the pose of its plane in the frame of the collision.
    Plane(Pose),
    Empty,
}

/// Reads the `<geometry>` of an element; `folder` is that of its file.
pub(crate) fn shape(
    owner: Element<'_>,
    folders: &ModelFolders,
    folder: &Path,
) -> Result<SdfShape, RobotError> {
    let geometry = owner.needed("geometry", &owner.title())?;
    let Some(kind) = geometry.children().next() else { return Ok(SdfShape::Empty) };
    let positive = |tag: &'static str| -> Result<f64, RobotError> {
        let value = kind.value_numbers(tag)?.map_or(1.0, |[value]| value);
        kind.check_positive(tag, value).map(|()| value)
    };
    let vector = |tag: &'static str, default: Vector| -> Result<Vector, RobotError> {
        Ok(kind.value_numbers(tag)?.map_or(default, Vector::from))
    };
    let form = match &*kind.tag() {
        "empty" => return Ok(SdfShape::Empty),
        "plane" => {
            let normal = vector("normal", Vector::z())?;
            let rotation = rotation_from_z(normal)
                .ok_or_else(|| not_supported(kind, "a normal of length 0", "give a direction"))?;
            return Ok(SdfShape::Plane(Pose::from_parts(Vector::zeros().into(), rotation)));
        }
        "box" => {
            let size = vector("size", Vector::repeat(1.0))?;
            size.iter().try_for_each(|length| kind.check_positive("size", *length))?;
            LinkForm::Cuboid { size }
        }
        "sphere" => LinkForm::Sphere { radius_m: positive("radius")? },
        "cylinder" => LinkForm::Cylinder { length_m: positive("length")?, radius_m: positive("radius")? },
        "capsule" => LinkForm::Capsule { length_m: positive("length")?, radius_m: positive("radius")? },
        "ellipsoid" => {
            let radii = vector("radii", Vector::repeat(1.0))?;
            radii.iter().try_for_each(|radius| kind.check_positive("radii", *radius))?;
            ellipsoid(radii)
        }
        "mesh" => {
            if let Some(submesh) = kind.first("submesh") {
                return Err(not_supported(submesh, "a <submesh>", "give a file with that mesh alone"));
            }
            let name = folders.mesh(kind.value("uri").unwrap_or_default(), folder);
            let scale = vector("scale", Vector::repeat(1.0))?;
            LinkForm::Mesh { name, candidates: Vec::new(), scale }
        }
        other => {
            let hint = "give boxes, cylinders or a mesh";
            return Err(not_supported(kind, format!("the geometry <{other}>"), hint));
        }
    };
    Ok(SdfShape::Form(form))
}
