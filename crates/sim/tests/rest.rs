//! Tests that targets rest at their poses in scenarios.

use cranny_scenario::{OpenOptions, Scenario, built_in};
use cranny_sim::Rest;

#[test]
fn the_target_of_every_built_in_scenario_rests_where_it_stands() {
    for entry in built_in() {
        let scenario = Scenario::open(entry.id, &OpenOptions::default()).unwrap();
        let rest = Rest::of_target(&scenario).unwrap().expect("a target on something");
        assert!(rest.is_at_rest(), "{}: {rest:?}", entry.id);
    }
}
