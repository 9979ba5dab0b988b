//! Bodies whose places are known to measurements in seen space.

use cranny_scenario::Scenario;

/// Returns the names of the known bodies of a scenario: none, those that support its target, or all.
///
/// # Errors
/// For another word than `none`, `support` or `all`.
pub fn known_bodies(scenario: &Scenario, word: &str) -> Result<Vec<String>, String> {
    let bodies = scenario.world.bodies();
    let indices = match (word, scenario.target) {
        ("support", Some(target)) => scenario.world.supports_of(target),
        ("all", _) => (0..bodies.len()).collect(),
        ("none" | "support", _) => Vec::new(),
        _ => return Err(format!("known are 'none', 'support' or 'all', not '{word}'")),
    };
    Ok(indices.into_iter().map(|index| bodies[index].name.clone()).collect())
}
