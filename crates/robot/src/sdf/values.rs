use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Pose, Rotation, Vector};

use crate::RobotError;
use crate::description::xml::{Element, rotation_of};
use crate::model_file::unread_list::not_supported;

/// Values of elements: SDF writes most of them as text, not as attributes.
impl<'a> Element<'a> {
    /// Returns the text of the first child element `tag`.
    pub(crate) fn value(self, tag: &'static str) -> Option<&'a str> {
        self.first(tag)?.own_text()
    }

    /// Returns the finite numbers of the text of the first child element `tag`.
    pub(crate) fn value_numbers<const N: usize>(
        self,
        tag: &'static str,
    ) -> Result<Option<[f64; N]>, RobotError> {
        let Some(child) = self.first(tag) else { return Ok(None) };
        let numbers = child.text_numbers()?;
        let count = numbers.len();
        numbers.try_into().map(Some).map_err(|_| {
            not_supported(child, format!("<{tag}> of {count} numbers"), "give as many as the specification")
        })
    }

    /// Returns the number in the first child element `tag`, which may be infinite.
    pub(crate) fn value_number(self, tag: &'static str) -> Result<Option<f64>, RobotError> {
        let Some(child) = self.first(tag) else { return Ok(None) };
        let text = child.own_text().unwrap_or_default();
        let number = text.parse().ok().filter(|number: &f64| !number.is_nan());
        number.map(Some).ok_or_else(|| not_supported(child, format!("the number `{text}`"), "give a number"))
    }

    fn text_numbers(self) -> Result<Vec<f64>, RobotError> {
        let text = self.own_text().unwrap_or_default();
        let number = |word: &str| word.parse().ok().filter(|number: &f64| number.is_finite());
        text.split_whitespace()
            .map(|word| {
                let what = || format!("`{}` in <{}>", cranny_file::excerpt(word), self.tag());
                number(word).ok_or_else(|| not_supported(self, what(), "give finite numbers"))
            })
            .collect()
    }

    /// Returns the truth value in the first child element `tag`.
    pub(crate) fn value_flag(self, tag: &'static str) -> bool {
        matches!(self.value(tag), Some("true" | "1"))
    }

    /// Returns the `<pose>` of an element and the name of the frame that it is relative to; the identity if there is none.
    pub(crate) fn sdf_pose(self) -> Result<(Pose, Option<&'a str>), RobotError> {
        let Some(pose) = self.first("pose") else { return Ok((Pose::identity(), None)) };
        if pose.optional_text("frame").is_some_and(|frame| !frame.is_empty()) {
            let hint = "use `relative_to`, as since version 1.7";
            return Err(not_supported(pose, "the attribute `frame`", hint));
        }
        let relative_to = pose.optional_text("relative_to").filter(|frame| !frame.is_empty());
        let numbers = pose.text_numbers()?;
        let is_degree = matches!(pose.optional_text("degrees"), Some("true" | "1"));
        let in_radians = |angle: f64| if is_degree { angle.to_radians() } else { angle };
        let is_quaternion = pose.optional_text("rotation_format") == Some("quat_xyzw");
        let (position, rotation) = match numbers[..] {
            [] => (Vector::zeros(), Rotation::identity()),
            [x, y, z, i, j, k, w] if is_quaternion => {
                let quaternion = Quaternion::new(w, i, j, k);
                if quaternion.norm() < 1e-9 {
                    return Err(not_supported(pose, "a quaternion of length 0", "give a rotation"));
                }
                (Vector::new(x, y, z), Rotation::new_normalize(quaternion))
            }
            [x, y, z, roll, pitch, yaw] if !is_quaternion => {
                (Vector::new(x, y, z), rotation_of([roll, pitch, yaw].map(in_radians)))
            }
            _ => {
                let what = format!("a <pose> of {} numbers", numbers.len());
                return Err(not_supported(pose, what, "give x y z roll pitch yaw"));
            }
        };
        Ok((Pose::from_parts(position.into(), rotation), relative_to))
    }
}
