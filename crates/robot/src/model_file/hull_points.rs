use crate::description::xml::Element;
use crate::{LinkForm, RobotError};

/// Maximum number of points of all hulls of a model: the URDF contains each, also those of a mesh that several shapes have.
const MOST_POINTS: usize = 1_000_000;

/// Adds the points of a shape to `count`.
///
/// # Errors
/// [`RobotError::TooMany`].
pub(crate) fn check_points(element: Element<'_>, form: &LinkForm, count: usize) -> Result<usize, RobotError> {
    let LinkForm::Hull { points } = form else { return Ok(count) };
    let (actual, most) = (count + points.len(), MOST_POINTS);
    if actual <= most {
        return Ok(actual);
    }
    Err(RobotError::TooMany { at: element.at(), what: "points of hulls in one model", most, actual })
}
