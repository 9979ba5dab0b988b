use std::collections::BTreeMap;

use crate::joint_group::unknown_link;
use crate::tree::Tree;
use crate::urdf_model::Urdf;
use crate::{Link, Mover, RobotError, Srdf};

/// Two links with geometry are adjacent if the way between them through the tree meets no third one, and at most one joint
/// moves them against each other. Two arms on a bare torso are not, nor a gantry's frame and its tool beyond bare carriages.
///
/// Bare links that hang together form a patch; which links with geometry are around one is found first.
pub(crate) fn adjacent_pairs(links: &[Link], movers: &[Vec<Mover>]) -> Vec<(usize, usize)> {
    // A patch is known by its topmost link.
    let mut patch_of: Vec<usize> = (0..links.len()).collect();
    let mut around: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut pairs = Vec::new();
    for (index, link) in links.iter().enumerate() {
        let Some(parent) = link.parent else { continue };
        match (links[parent].collisions.is_empty(), link.collisions.is_empty()) {
            (false, false) => pairs.push((parent, index)),
            (false, true) => around.entry(index).or_default().push(parent),
            (true, false) => around.entry(patch_of[parent]).or_default().push(index),
            (true, true) => patch_of[index] = patch_of[parent],
        }
    }
    for neighbours in around.values() {
        for (position, &first) in neighbours.iter().enumerate() {
            pairs.extend(neighbours[position + 1..].iter().map(|&second| (first, second)));
        }
    }
    pairs.retain(|&(first, second)| joints_between(&movers[first], &movers[second]) <= 1);
    sorted_pairs(pairs)
}

/// How many joints move one link against another, by those that move each.
fn joints_between(first: &[Mover], second: &[Mover]) -> usize {
    let common = first.iter().zip(second).take_while(|(a, b)| a.child_link == b.child_link).count();
    first.len() + second.len() - 2 * common
}

/// The pairs that the SRDF, or whoever loads the robot, says not to test.
pub(crate) fn disabled_pairs(
    urdf: &Urdf,
    tree: &Tree,
    srdf: &Srdf,
    unchecked_pairs: &[[String; 2]],
) -> Result<Vec<(usize, usize)>, RobotError> {
    let find = |name: &String, place: &dyn Fn() -> String| {
        tree.node(name).ok_or_else(|| unknown_link(urdf, place(), name))
    };
    let mut pairs = Vec::with_capacity(srdf.disabled_pairs.len() + unchecked_pairs.len());
    for ((first, second), at) in srdf.disabled_pairs.iter().zip(&srdf.disabled_at) {
        let place = || format!("{at}: disabled pair");
        pairs.push((find(first, &place)?, find(second, &place)?));
    }
    for [first, second] in unchecked_pairs {
        let place = || "unchecked_pairs".to_owned();
        pairs.push((find(first, &place)?, find(second, &place)?));
    }
    Ok(sorted_pairs(pairs))
}

fn sorted_pairs(mut pairs: Vec<(usize, usize)>) -> Vec<(usize, usize)> {
    for pair in &mut pairs {
        *pair = (pair.0.min(pair.1), pair.0.max(pair.1));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
