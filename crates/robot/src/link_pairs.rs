use std::collections::{BTreeMap, BTreeSet};

use crate::chain::joint_group::unknown_link;
use crate::description::urdf_model::Urdf;
use crate::tree::Tree;
use crate::{Link, Location, Mover, RobotError, RobotOptions, Srdf};

/// Two links with geometry are adjacent if no third one lies between them in the tree and at most one joint moves them
/// relative to each other. Two arms on a bare torso are not adjacent, nor are a gantry frame and a tool on bare carriages.
///
/// Connected bare links form a patch. The links with geometry around each patch are found first.
///
/// Pairs in `checked` are excluded.
pub(crate) fn adjacent_pairs(
    links: &[Link],
    movers: &[Vec<Mover>],
    checked: &[(usize, usize)],
) -> Vec<(usize, usize)> {
    // A patch is identified by its topmost link.
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
    let mut pairs = sorted_pairs(pairs);
    pairs.retain(|pair| checked.binary_search(pair).is_err());
    pairs
}

/// Returns the number of joints that move one link relative to another, given the movers of each.
fn joints_between(first: &[Mover], second: &[Mover]) -> usize {
    let common = first.iter().zip(second).take_while(|(a, b)| a.child_link == b.child_link).count();
    first.len() + second.len() - 2 * common
}

/// Pairs of links declared in files and options, each sorted.
pub(crate) struct DeclaredPairs {
    /// Pairs that are never tested.
    pub(crate) disabled: Vec<(usize, usize)>,
    /// Pairs that are tested even if adjacent.
    pub(crate) checked: Vec<(usize, usize)>,
}

/// Returns the pairs named in the SRDF and the options. As in `MoveIt`, `disable_collisions` takes precedence over
/// `enable_collisions`, and that over `disable_default_collisions`; the options take precedence over all of them.
pub(crate) fn declared_pairs(
    urdf: &Urdf,
    tree: &Tree,
    srdf: &Srdf,
    options: &RobotOptions,
) -> Result<DeclaredPairs, RobotError> {
    let find = |name: &String, place: &dyn Fn() -> String| {
        tree.node(name).ok_or_else(|| unknown_link(urdf, place(), name))
    };
    let of_srdf = |pairs: &[(String, String)], lines: &[Location], what: &str| {
        let pairs = pairs.iter().zip(lines).map(|((first, second), at)| {
            let place = || format!("{at}: {what}");
            Ok((find(first, &place)?, find(second, &place)?))
        });
        Ok(sorted_pairs(pairs.collect::<Result<_, RobotError>>()?))
    };
    let of_options = |pairs: &[[String; 2]], what: &str| {
        let place = || what.to_owned();
        let pairs = pairs.iter().map(|[first, second]| Ok((find(first, &place)?, find(second, &place)?)));
        Ok(sorted_pairs(pairs.collect::<Result<_, RobotError>>()?))
    };
    let places = &srdf.places;
    let named = of_srdf(&srdf.disabled_pairs, &places.disabled, "disabled pair")?;
    let mut enabled = of_srdf(&srdf.enabled_pairs, &places.enabled, "enabled pair")?;
    let mut untested = BTreeSet::new();
    for (name, at) in srdf.untested_links.iter().zip(&places.untested) {
        untested.insert(find(name, &|| format!("{at}: disable_default_collisions"))?);
    }
    let others =
        |link| (0..tree.nodes.len()).filter(move |other| *other != link).map(move |other| (link, other));
    let mut disabled = sorted_pairs(untested.into_iter().flat_map(others).collect());
    disabled.retain(|pair| enabled.binary_search(pair).is_err());
    enabled.retain(|pair| named.binary_search(pair).is_err());
    disabled.extend(named);
    disabled.extend(of_options(&options.unchecked_pairs, "unchecked_pairs")?);
    let asked = of_options(&options.checked_pairs, "checked_pairs")?;
    disabled.retain(|pair| asked.binary_search(pair).is_err());
    enabled.extend(asked);
    Ok(DeclaredPairs { disabled: sorted_pairs(disabled), checked: sorted_pairs(enabled) })
}

fn sorted_pairs(mut pairs: Vec<(usize, usize)>) -> Vec<(usize, usize)> {
    for pair in &mut pairs {
        *pair = (pair.0.min(pair.1), pair.0.max(pair.1));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
