use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Pose};

use crate::description::xml::Element;

/// Mass and inertia of a link (`<inertial>`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertial {
    /// Mass in kilograms, above 0.
    pub mass_kg: f64,
    /// Centre of mass, in the link frame.
    pub center: Point,
    /// Inertia about the centre of mass, along the axes of the link frame, in kg m²; positive definite.
    pub inertia_kg_m2: Matrix3<f64>,
}

impl Inertial {
    /// Reads the inertial of a `<link>`; `None` if it has none or physically impossible values. Those are not an error: only
    /// dynamics uses them, and many files used for planning have zeros there.
    pub(crate) fn of(link: Element<'_>) -> Option<Self> {
        let inertial = link.first("inertial")?;
        // All values are read before any is validated, so that none counts as unread.
        let (link_from_inertial, mass, inertia) =
            (inertial.origin(), inertial.first("mass"), inertial.first("inertia"));
        let mass_kg = mass.map(|mass| mass.positive("value"));
        let moments = inertia.map(|inertia| {
            ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]
                .map(|name| inertia.number_or(name, 0.0).unwrap_or(f64::NAN))
        });
        let (link_from_inertial, mass_kg): (Pose, f64) = (link_from_inertial.ok()?, mass_kg?.ok()?);
        let [xx, xy, xz, yy, yz, zz] = moments?;
        let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let turn = link_from_inertial.rotation.to_rotation_matrix();
        let inertia_kg_m2 = turn.matrix() * own * turn.matrix().transpose();
        inertia_kg_m2.cholesky()?;
        Some(Self { mass_kg, center: link_from_inertial.translation.vector.into(), inertia_kg_m2 })
    }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Vector;

    use super::*;
    use crate::description::urdf_model::Urdf;

    fn inertial(text: &str) -> Option<Inertial> {
        let text = format!("<robot name=\"r\"><link name=\"l\">{text}</link></robot>");
        Urdf::parse(&text, "r.urdf").unwrap().links[0].inertial
    }

    #[test]
    fn what_a_link_weighs_is_told_in_its_own_frame() {
        let turned = inertial(
            r#"<inertial><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><mass value="2"/>
               <inertia ixx="1" iyy="2" izz="3" ixy="0.1" ixz="0" iyz="0"/></inertial>"#,
        )
        .unwrap();
        assert_eq!((turned.mass_kg, turned.center.coords), (2.0, Vector::new(1.0, 2.0, 3.0)));
        let expected = Matrix3::new(2.0, -0.1, 0.0, -0.1, 1.0, 0.0, 0.0, 0.0, 3.0);
        assert!((turned.inertia_kg_m2 - expected).amax() < 1e-12, "{}", turned.inertia_kg_m2);
    }

    #[test]
    fn figures_that_no_body_can_have_are_none() {
        for text in [
            "",
            "<inertial/>",
            r#"<inertial><mass value="0"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#,
            r#"<inertial><mass value="much"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#,
            r#"<inertial><mass value="1"/><inertia ixx="0" iyy="0" izz="0"/></inertial>"#,
            r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="2"/></inertial>"#,
            r#"<inertial><mass value="1"/><inertia ixx="1" iyy="nan" izz="1"/></inertial>"#,
        ] {
            assert_eq!(inertial(text), None, "{text}");
        }
    }
}
