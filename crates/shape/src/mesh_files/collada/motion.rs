use cranny_spatial::Vector;
use cranny_spatial::nalgebra::{Matrix4, Rotation3, Unit, Vector4};
use roxmltree::Node;

use super::element::{fault, numbers};

/// Transform that an element of a node applies to the node's content; `None` for others (COLLADA 1.4.1, "Core Elements").
///
/// A node with `<lookat>` has its origin at the eye, its −z towards the point of interest and its y towards the up side,
/// as in Assimp.
///
/// # Errors
/// A message with the line: too few or too many numbers, an axis without length, a skew.
pub(super) fn motion(element: Node) -> Result<Option<Matrix4<f64>>, String> {
    Ok(Some(match element.tag_name().name() {
        "matrix" => {
            let rows: [f64; 16] = exactly(element)?;
            if rows[12..].iter().zip([0.0, 0.0, 0.0, 1.0]).any(|(x, one)| (x - one).abs() > ROUNDING) {
                return Err(fault(element, "the last row of a <matrix> must be 0 0 0 1"));
            }
            Matrix4::from_row_slice(&rows)
        }
        "translate" => Matrix4::new_translation(&Vector::from(exactly(element)?)),
        "scale" => {
            let [x, y, z] = exactly(element)?;
            Matrix4::from_diagonal(&Vector4::new(x, y, z, 1.0))
        }
        "rotate" => {
            let [x, y, z, degrees] = exactly(element)?;
            let axis = Unit::try_new(Vector::new(x, y, z), 0.0)
                .ok_or_else(|| fault(element, "the axis has no length"))?;
            Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
        }
        "lookat" => {
            let [a, b, c, d, e, f, g, h, i] = exactly(element)?;
            let (eye, interest, up) = (Vector::new(a, b, c), Vector::new(d, e, f), Vector::new(g, h, i));
            let axis = |along: Vector| {
                Unit::try_new(along, 0.0).ok_or_else(|| {
                    fault(element, "eye, point of interest and up of a <lookat> give no direction")
                })
            };
            let back = axis(eye - interest)?;
            let right = axis(up.cross(&back))?;
            let rotation = [*right, back.cross(&right), *back];
            Matrix4::new_translation(&eye) * Rotation3::from_basis_unchecked(&rotation).to_homogeneous()
        }
        "skew" => return Err(fault(element, "<skew> is not read (write it as a <matrix>)")),
        _ => return Ok(None),
    }))
}

/// Rounding of numbers near 1 that were written in single precision.
const ROUNDING: f64 = 1e-6;

fn exactly<const COUNT: usize>(element: Node) -> Result<[f64; COUNT], String> {
    let numbers = numbers(element)?;
    let actual = numbers.len();
    numbers.try_into().map_err(|_| {
        let tag = element.tag_name().name();
        fault(element, &format!("{COUNT} numbers are needed for <{tag}>, but there are {actual}"))
    })
}
