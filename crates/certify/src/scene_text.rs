use std::fmt::Write as _;

use cranny_collision::ToolRegion;
use cranny_robot::{JointKind, Robot};
use cranny_spatial::Pose;

use crate::joint_curve::pose_numbers;
use crate::link_bound::LinkBound;
use crate::model::Model;
use crate::span::{Object, PlacedSolid, Shape};
use crate::word::word;

/// First line of a certificate.
pub(crate) const FORMAT: &str = "cranny-certificate/1";

/// Content of a scene beside robot and world.
pub(crate) struct Rules<'a> {
    pub name: &'a str,
    pub start: &'a [f64],
    pub goals: &'a [(String, Pose)],
}

/// Returns the lines of a scene, up to its hash.
pub(crate) fn scene_text(robot: &Robot, model: &Model, rules: &Rules<'_>) -> String {
    let mut text = format!("scene {}\n", word(rules.name));
    for (name, limits) in robot.joint_names().iter().zip(robot.limits()) {
        line(&mut text, &format!("joint {}", word(name)), &[limits.lower, limits.upper]);
    }
    for object in &model.objects {
        object_lines(&mut text, object);
    }
    line(&mut text, "margin", &[model.margin_m]);
    for ((a, b), margin_m) in &model.pairs {
        if margin_m.to_bits() != model.margin_m.to_bits() {
            line(&mut text, &format!("keep {a} {b}"), &[*margin_m]);
        }
    }
    for ((a, b), reason) in &model.skipped {
        let _ = writeln!(text, "skip {a} {b} {reason}");
    }
    model.bounds.iter().for_each(|bound| bound_line(&mut text, bound));
    line(&mut text, "start", rules.start);
    let _ = writeln!(text, "tip {}", robot.tip());
    for (name, pose) in rules.goals {
        line(&mut text, &format!("goal {}", word(name)), &pose_numbers(pose));
    }
    text
}

fn object_lines(text: &mut String, object: &Object) {
    match &object.motion {
        None => {
            let _ = writeln!(text, "body {}", object.name);
        }
        Some(motion) => {
            let parent = motion.parent.map_or("-".to_owned(), |parent| parent.to_string());
            let mut words = format!("link {} {parent}", object.name);
            numbers(&mut words, &pose_numbers(&motion.parent_from_link));
            if let Some(joint) = motion.joint {
                let kind = if joint.kind == JointKind::Revolute { "turn" } else { "slide" };
                let _ = write!(words, " {kind} {}", joint.joint);
                let axis = joint.axis_in_link;
                line(text, &words, &[joint.multiplier, joint.offset, axis.x, axis.y, axis.z]);
            } else {
                let _ = writeln!(text, "{words} fixed");
            }
        }
    }
    object.solids.iter().for_each(|solid| solid_lines(text, solid));
}

fn solid_lines(text: &mut String, PlacedSolid { pose, shape, .. }: &PlacedSolid) {
    let mut solid = |kind: &str, sizes: &[f64]| line(text, kind, &[&pose_numbers(pose)[..], sizes].concat());
    match shape {
        Shape::Cuboid(half) => solid("box", half.as_slice()),
        Shape::Capsule { half_length_m: 0.0, radius_m } => solid("ball", &[*radius_m]),
        Shape::Capsule { half_length_m, radius_m } => solid("capsule", &[*half_length_m, *radius_m]),
        Shape::Cylinder { half_length_m, radius_m } => solid("cylinder", &[*half_length_m, *radius_m]),
        Shape::HalfSpace => solid("half", &[]),
        Shape::Hull { points, radius_m } => {
            solid("hull", &[*radius_m]);
            for point in points {
                line(text, "v", point.as_slice());
            }
        }
        Shape::Mesh { points, faces } => {
            solid("mesh", &[]);
            for point in points {
                line(text, "v", point.as_slice());
            }
            for [a, b, c] in faces {
                let _ = writeln!(text, "f {a} {b} {c}");
            }
        }
    }
}

fn bound_line(text: &mut String, LinkBound { name, link, region }: &LinkBound) {
    let (kind, values) = match region {
        ToolRegion::Cone { axis_in_link, toward, most_rad } => {
            ("cone", [axis_in_link.as_slice(), toward.as_slice(), &[*most_rad]].concat())
        }
        ToolRegion::Box { point_in_link, world_from_box, half_m } => {
            let pose = pose_numbers(world_from_box);
            ("inside", [point_in_link.coords.as_slice(), &pose, half_m.as_slice()].concat())
        }
        ToolRegion::Ball { point_in_link, center, radius_m } => {
            ("near", [point_in_link.coords.as_slice(), center.coords.as_slice(), &[*radius_m]].concat())
        }
    };
    line(text, &format!("{kind} {name} {link}"), &values);
}

/// Appends a line of a word and numbers.
pub(crate) fn line(text: &mut String, word: &str, values: &[f64]) {
    text.push_str(word);
    numbers(text, values);
    text.push('\n');
}

/// Appends numbers.
fn numbers(text: &mut String, values: &[f64]) {
    for value in values {
        text.push(' ');
        text.push_str(&decimal(*value));
    }
}

/// Returns the shortest decimal that is read as this `f64`, without a zero before the point.
pub(crate) fn decimal(value: f64) -> String {
    let long = format!("{:?}", value.abs());
    let short = long.strip_suffix(".0").unwrap_or(&long);
    let short = if short.starts_with("0.") { &short[1..] } else { short };
    format!("{}{short}", if value.is_sign_negative() { "-" } else { "" })
}
